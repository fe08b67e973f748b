"""The robot oscillates; the direct models are drawn over what the robot does.

fivebar run direct_models.py [five_bar | biglide [your_models.py]]
"""

import sys

from chosen_models import chosen_models
from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *

ASSEMBLY = -1


def main(args=None):
    rclpy.init(args=args)
    name, model = chosen_models(args)
    robot = Robot(name)
    start_robot(robot)
    QtGui.QApplication([])
    size = 0.1 if name == "five_bar" else 0.05
    position = {title: Scope(f"Position {title}", 0, size) for title in ("x", "y", "q12", "q22")}
    velocity = {
        title: Scope(f"Velocity {title}", -size, size) for title in ("x", "y", "q12", "q22")
    }
    acceleration = {
        title: Scope(f"Acceleration {title}", -size, size) for title in ("x", "y", "q12", "q22")
    }
    left, right, end = robot.active_left_joint, robot.active_right_joint, robot.end_effector
    passive_left, passive_right = robot.passive_left_joint, robot.passive_right_joint

    def show(scopes, measured, computed):
        for scope, robots, models in zip(scopes.values(), measured, computed):
            scope.update(robot.get_time(), robots, models)

    robot.start_oscillate()
    try:
        while True:
            if robot.data_updated():
                q11, q21 = left.position, right.position
                xy = model.dgm(q11, q21, ASSEMBLY)
                q12, q22 = model.dgm_passive(q11, q21, ASSEMBLY)
                measured = (
                    end.position_x,
                    end.position_y,
                    passive_left.position,
                    passive_right.position,
                )
                show(position, measured, (*xy, q12, q22))

                q11D, q21D = left.velocity, right.velocity
                xD, yD = model.dkm(q11, q12, q21, q22, q11D, q21D)
                q12D, q22D = model.dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD)
                measured = (
                    end.velocity_x,
                    end.velocity_y,
                    passive_left.velocity,
                    passive_right.velocity,
                )
                show(velocity, measured, (xD, yD, q12D, q22D))

                motion = q11, q12, q21, q22, q11D, q12D, q21D, q22D
                q11DD, q21DD = left.acceleration, right.acceleration
                xDD, yDD = model.dkm2(*motion, q11DD, q21DD)
                passive = model.dkm2_passive(*motion, q11DD, q21DD, xDD, yDD)
                measured = (
                    end.acceleration_x,
                    end.acceleration_y,
                    passive_left.acceleration,
                    passive_right.acceleration,
                )
                show(acceleration, measured, (xDD, yDD, *passive))

                robot.continue_oscillations()
    except KeyboardInterrupt:
        pass
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv)
