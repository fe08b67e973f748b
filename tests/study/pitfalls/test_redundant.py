"""Redundant coordinates pass every singularity but drift off their constraints; what is closed by geometry cannot."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.joint_space import FREE_END, free_start
from fivebar.study.pitfalls.redundant import closure, redundant_motion
from tests.study.pitfalls.reference import redundant_reference

ROBOT = fb.FiveBar()
STEP, DURATION = 1e-3, 10.0


def stays_closed(gap):
    """To rounding of the coordinates."""
    return bool(np.isfinite(gap).all() and gap.max() < 5e-16)


@pytest.fixture(scope="module")
def drifting():
    return redundant_motion(ROBOT, free_start(ROBOT), DURATION, STEP)


def test_ours_stays_closed():
    run = fb.simulate(ROBOT, duration=DURATION, start=free_start(ROBOT), step=STEP)
    assert stays_closed(closure(ROBOT, run.q, run.xi))


@pytest.mark.deep
def test_without_stabilisation(drifting):
    assert not stays_closed(drifting.closure)
    assert drifting.closure[-1] > 1e-9
    assert drifting.closure[-1] > 10 * drifting.closure[len(drifting.t) // 5]  # and on it goes


@pytest.mark.deep
def test_with_baumgarte(drifting):
    for rate in (10.0, 100.0):
        held = redundant_motion(ROBOT, free_start(ROBOT), DURATION, STEP, rate)
        assert not stays_closed(held.closure)
        assert held.closure[-1] < 0.1 * drifting.closure[-1]  # it does help
    with np.errstate(all="ignore"):
        stiff = redundant_motion(ROBOT, free_start(ROBOT), 0.5, STEP, 4000.0)
    assert not stays_closed(stiff.closure)
    assert (
        not stiff.closure[-1] < 1e-3
    )  # with a rate beyond what the step bears it makes the error grow


def test_independent_integration_of_the_free_motion():
    reference = redundant_reference(ROBOT, free_start(ROBOT), 2.0)
    energy = reference.states[:, 4:] ** 2 @ [ROBOT.m, ROBOT.m, ROBOT.zz1, ROBOT.zz2]
    assert np.abs(energy / energy[0] - 1).max() < 1e-11 and reference.closure.max() < 1e-11
    run = fb.simulate(ROBOT, duration=2.0, start=free_start(ROBOT), step=1e-4)
    assert np.linalg.norm(run.xi[-1] - reference.xi[-1]) < 1e-11
    assert np.linalg.norm(run.xi[-1] - FREE_END) < 1e-11
    assert np.linalg.norm(reference.xi[-1] - FREE_END) < 1e-11
    assert run.xi[::200] == pytest.approx(reference.xi, abs=1e-11)
