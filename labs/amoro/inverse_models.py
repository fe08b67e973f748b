"""The robot oscillates; the inverse models and the dynamic model are drawn over what the robot does.

fivebar run inverse_models.py [five_bar | biglide [your_models.py]]
"""

import sys

from chosen_models import chosen_models
from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *

WORKING = -1, -1


def main(args=None):
    rclpy.init(args=args)
    name, model = chosen_models(args)
    robot = Robot(name)
    start_robot(robot)
    QtGui.QApplication([])
    effort = 0.001 if name == "five_bar" else 0.02
    titles = ("Position", 0.1), ("Velocity", 0.1), ("Acceleration", 0.1), ("Effort", effort)
    scopes = [
        [Scope(f"{title} {joint}", -y, y) for joint in ("left", "right")] for title, y in titles
    ]
    left, right, end = robot.active_left_joint, robot.active_right_joint, robot.end_effector
    passive_left, passive_right = robot.passive_left_joint, robot.passive_right_joint

    def show(pair, measured, computed):
        for scope, robots, models in zip(pair, measured, computed):
            scope.update(robot.get_time(), robots, models)

    robot.start_oscillate()
    try:
        while True:
            if robot.data_updated():
                joints = (
                    left.position,
                    passive_left.position,
                    right.position,
                    passive_right.position,
                )
                q = model.igm(end.position_x, end.position_y, *WORKING)
                show(scopes[0], (left.position, right.position), q)

                q_dot = model.ikm(*joints, end.velocity_x, end.velocity_y)
                show(scopes[1], (left.velocity, right.velocity), q_dot)

                motion = (
                    *joints,
                    left.velocity,
                    passive_left.velocity,
                    right.velocity,
                    passive_right.velocity,
                )
                q_ddot = model.ikm2(*motion, end.acceleration_x, end.acceleration_y)
                measured = left.acceleration, right.acceleration
                show(scopes[2], measured, q_ddot)

                M, c = model.dynamic_model(*motion)
                efforts = np.dot(M, measured) + np.ravel(c)
                show(scopes[3], (left.effort, right.effort), efforts)

                robot.continue_oscillations()
    except KeyboardInterrupt:
        pass
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv)
