"""The lab's tasks, and two plans that many tests look at."""

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
HOME, TASK_1, TASK_2 = (0.09, 0.06796322), (0.0, 0.1), (0.05, 0.0)
DEGREES = [dict(collocation=fb.Collocation(degree=degree)) for degree in (3, 5)]
IN_MODES = fb.Constraints(sin=0.05)  # so that a motion between Poses keeps their working modes


def poses(robot, ends, working):
    """Return the ends as Poses in these working modes."""
    return [fb.igm(robot, xi, working) for xi in ends]


@pytest.fixture(scope="session")
def crossing():
    return fb.plan(ROBOT, HOME, TASK_2, 4.0)


@pytest.fixture(scope="session")
def fastest():
    return fb.plan(ROBOT, HOME, TASK_1, objective="time", constraints=fb.Constraints(torque=0.02))


def fine(motion):
    return np.linspace(0, motion.duration, 4001)
