"""Control task 1: computed torque along a straight line, on a quintic law of time.

fivebar run control.py [five_bar | biglide [your_models.py]]
"""

import sys

from chosen_models import chosen_models
from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *

ASSEMBLY, WORKING = -1, (-1, -1)
KP, KD = 100.0, 20.0
DURATION, PERIOD = 2.0, 0.01
LINES = {"five_bar": ((0.09, 0.06796322), (0.0, 0.1)), "biglide": ((0.0, 0.2), (0.06, 0.25))}


def line(start, goal):
    """Position, velocity and acceleration, each (n, 2), at every period."""
    s = np.arange(round(DURATION / PERIOD) + 1) * PERIOD / DURATION
    laws = (
        10 * s**3 - 15 * s**4 + 6 * s**5,
        (30 * s**2 - 60 * s**3 + 30 * s**4) / DURATION,
        (60 * s - 180 * s**2 + 120 * s**3) / DURATION**2,
    )
    start, way = np.array(start), np.subtract(goal, start)
    return start + np.outer(laws[0], way), np.outer(laws[1], way), np.outer(laws[2], way)


def in_joint_space(model, trajectory):
    """The same of the active joints, point by point through the inverse models."""
    rows = []
    for xy, xy_dot, xy_ddot in zip(*trajectory):
        q11, q21 = model.igm(*xy, *WORKING)
        q12, q22 = model.dgm_passive(q11, q21, ASSEMBLY)
        joints = q11, q12, q21, q22
        q11D, q21D = model.ikm(*joints, *xy_dot)
        q12D, q22D = model.dkm_passive(*joints, q11D, q21D, *xy_dot)
        q_ddot = model.ikm2(*joints, q11D, q12D, q21D, q22D, *xy_ddot)
        rows.append(np.reshape([(q11, q21), (q11D, q21D), q_ddot], (3, 2)).astype(float))
    return np.array(rows)


def main(args=None):
    rclpy.init(args=args)
    name, model = chosen_models(args)
    robot = Robot(name)
    start_robot(robot)
    QtGui.QApplication([])
    scopes = Scope("Left joint", -0.5, 0.5), Scope("Right joint", -0.5, 1.5)
    trajectory = in_joint_space(model, line(*LINES[name]))
    left, right = robot.active_left_joint, robot.active_right_joint
    index, errors = 0, []
    try:
        robot.apply_efforts(0.0, 0.0)  # the lab's simulation begins with the first step
        while True:
            if robot.data_updated():
                q, q_dot = (
                    np.array([left.position, right.position]),
                    np.array([left.velocity, right.velocity]),
                )
                target, target_dot, target_ddot = trajectory[index]
                errors.append(target - q)
                for scope, wanted, measured in zip(scopes, target, q):
                    scope.update(robot.get_time(), wanted, measured)

                q12, q22 = model.dgm_passive(*q, ASSEMBLY)
                joints = q[0], q12, q[1], q22
                q12D, q22D = model.dkm_passive(*joints, *q_dot, *model.dkm(*joints, *q_dot))
                M, c = model.dynamic_model(*joints, q_dot[0], q12D, q_dot[1], q22D)
                tau = np.dot(
                    M, target_ddot + KD * (target_dot - q_dot) + KP * (target - q)
                ) + np.ravel(c)
                robot.apply_efforts(tau[0], tau[1])
                index = min(index + 1, len(trajectory) - 1)
    except KeyboardInterrupt:
        size = np.abs(errors)
        print(
            f"largest errors of the joints {size.max(axis=0)}, root mean square {np.sqrt(np.mean(size**2, axis=0))}"
        )
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv)
