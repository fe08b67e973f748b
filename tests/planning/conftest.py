"""The lab's tasks, and two plans that many tests look at."""

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
HOME, TASK_1, TASK_2 = (0.09, 0.06796322), (0.0, 0.1), (0.05, 0.0)
METHODS = dict(method="legendre-gauss"), dict(method="hermite-simpson")


@pytest.fixture(scope="session")
def crossing():
    return fb.plan(ROBOT, HOME, TASK_2, 4.0)


@pytest.fixture(scope="session")
def fastest():
    return fb.plan(ROBOT, HOME, TASK_1, objective="time", torque_limit=0.02)


def fine(motion):
    return np.linspace(0, motion.duration, 4001)
