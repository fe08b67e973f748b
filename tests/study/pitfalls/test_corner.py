"""Motions into the corner of the workspace, where both legs are straight, against redundant coordinates."""

import itertools

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.redundant import closure
from tests.study.pitfalls.reference import redundant_reference

ROBOT = fb.FiveBar()
CORNER = np.array([0.0, np.sqrt(0.18**2 - 0.059**2)])
STEP = 5e-4
STARTS = [(0.0, 0.12), (0.02, 0.11), (-0.03, 0.13), (0.0, 0.165)]
MODES = [(1, -1), (-1, 1), (-1, -1), (1, 1)]


def motion(start, angle, speed, working):
    """Rates towards the corner, turned by `angle`, and the time for the way there and back in whole steps."""
    to_corner = CORNER - start
    distance = np.linalg.norm(to_corner)
    c, s = np.cos(angle), np.sin(angle)
    velocity = speed / distance * np.array([[c, -s], [s, c]]) @ to_corner
    steps = np.ceil(2 * distance / speed / STEP)
    return fb.ikm(fb.igm(ROBOT, start, working), velocity), steps * STEP


def check(rates, duration, chart):
    run = fb.simulate(
        ROBOT, duration=duration, start=rates, step=STEP, integrator=fb.Integrator(chart=chart)
    )
    reference = redundant_reference(ROBOT, rates, duration)
    assert np.abs(run.energy / run.energy[0] - 1).max() <= 1e-6
    assert closure(ROBOT, run.q, run.xi).max() < 5e-16
    assert np.linalg.norm(run.xi[-1] - reference.xi[-1]) < 1e-8
    # Energy from the joint rates and, by differences of positions of order 6, the end-effector's velocity.
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * STEP)
    xi_dot = sum(w * run.xi[k : len(run.xi) - 6 + k] for k, w in enumerate(weights))
    energy = 0.5 * (ROBOT.zz1 * run.q_dot[3:-3] ** 2).sum(axis=1) + 0.5 * ROBOT.m * (xi_dot**2).sum(
        axis=1
    )
    assert energy == pytest.approx(run.energy[0], rel=1e-6)


CASES = list(itertools.product(STARTS, (0.0, 1e-4, -1e-3), (0.1, 0.3), MODES))


@pytest.mark.every(3)
@pytest.mark.parametrize("start, angle, speed, working", CASES[::3])
def test_charts_pass_the_corner(start, angle, speed, working):
    check(*motion(start, angle, speed, working), chart="auto")


@pytest.mark.parametrize("start", STARTS[::2])
def test_task_coordinates_do_not(start):
    with pytest.raises(fb.SingularityError, match="jumps the singularity of the task chart"):
        check(*motion(start, 0.0, 0.3, (-1, -1)), chart="task")
