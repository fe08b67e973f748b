"""The robot oscillates for a minute, or until Ctrl-C; then the mean error of every model is printed.

fivebar run evaluation.py [five_bar | biglide [your_models.py]]
"""

import sys
from time import time

from chosen_models import chosen_models
from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import np

ASSEMBLY, WORKING = -1, (-1, -1)
GOOD = 1e-3


def compare(robot, model):
    """Yields (quantity, the robot's values, the model's) for the present state."""
    left, right, end = robot.active_left_joint, robot.active_right_joint, robot.end_effector
    passive_left, passive_right = robot.passive_left_joint, robot.passive_right_joint
    q = left.position, right.position
    q_dot = left.velocity, right.velocity
    q_ddot = left.acceleration, right.acceleration
    xy = end.position_x, end.position_y
    xy_dot = end.velocity_x, end.velocity_y
    xy_ddot = end.acceleration_x, end.acceleration_y
    passive = passive_left.position, passive_right.position
    passive_dot = passive_left.velocity, passive_right.velocity
    passive_ddot = passive_left.acceleration, passive_right.acceleration
    joints = q[0], passive[0], q[1], passive[1]
    motion = *joints, q_dot[0], passive_dot[0], q_dot[1], passive_dot[1]

    yield "dgm", xy, model.dgm(*q, ASSEMBLY)
    yield "dgm_passive", passive, model.dgm_passive(*q, ASSEMBLY)
    yield "dkm", xy_dot, model.dkm(*joints, *q_dot)
    yield "dkm_passive", passive_dot, model.dkm_passive(*joints, *q_dot, *xy_dot)
    yield "dkm2", xy_ddot, model.dkm2(*motion, *q_ddot)
    yield "dkm2_passive", passive_ddot, model.dkm2_passive(*motion, *q_ddot, *xy_ddot)
    yield "igm", q, model.igm(*xy, *WORKING)
    yield "ikm", q_dot, model.ikm(*joints, *xy_dot)
    yield "ikm2", q_ddot, model.ikm2(*motion, *xy_ddot)
    M, c = model.dynamic_model(*motion)
    yield "dynamic_model", (left.effort, right.effort), np.dot(M, q_ddot) + np.ravel(c)


def main(args=None):
    rclpy.init(args=args)
    name, model = chosen_models(args)
    robot = Robot(name)
    start_robot(robot)
    errors = {}
    start = time()
    robot.start_oscillate()
    while time() < start + 60:
        try:
            if robot.data_updated():
                for quantity, measured, computed in compare(robot, model):
                    errors.setdefault(quantity, []).append(
                        np.abs(np.subtract(measured, np.ravel(computed)))
                    )
                robot.continue_oscillations()
        except KeyboardInterrupt:
            break
    for quantity, error in errors.items():
        first, second = np.mean(error, axis=0)
        verdict = "OK" if max(first, second) < GOOD else "error in model"
        print(f"{quantity:<14} mean errors {first:.3e}, {second:.3e}: {verdict}")
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv)
