"""Joint coordinates do not cross Type 2: nan, a bounce, or "success" with garbage. In the four bars the motion does."""

from collections import Counter

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.integrators import march, rk4
from fivebar.study.pitfalls.joint_space import (
    FREE_END,
    FreeRun,
    free_motion_by,
    free_motion_by_steps,
    free_motion_of_ours,
    free_motion_of_ours_by_steps,
    free_start,
    joint_model,
    joint_slope,
    whole_steps,
)

ROBOT = fb.FiveBar()
STEPS = whole_steps()


def survives(motion):
    """The motion was finished, it is where it should be, and it has its energy."""
    return bool(
        motion.success
        and np.isfinite(motion.xi).all()
        and np.linalg.norm(motion.xi[-1] - FREE_END) < 1e-6
        and motion.energy_error < 1e-6
    )


@pytest.mark.parametrize("step", [4e-4, 1e-3, 2e-3, 4e-3])
def test_ours_survives(step):
    assert survives(free_motion_of_ours(ROBOT, step))


@pytest.mark.every(8)
@pytest.mark.parametrize(
    "method, rtol, success",
    [
        ("RK45", 1e-3, False),
        ("RK45", 1e-9, False),
        ("DOP853", 1e-9, False),
        ("Radau", 1e-6, False),
        ("DOP853", 1e-3, True),
        ("Radau", 1e-3, True),
        ("LSODA", 1e-3, True),
        ("LSODA", 1e-9, True),
    ],
)
def test_scipy_does_not(method, rtol, success):
    motion = free_motion_by(ROBOT, method, rtol)
    assert not survives(motion)
    assert motion.success == success  # by its own word
    if method == "LSODA":
        assert not np.isfinite(motion.xi[-1]).any()
    elif success:
        assert np.isfinite(motion.xi).all() and motion.energy_error > 0.1


def test_the_joint_model_is_right_where_it_is_regular():
    """It is the method that fails, not its equations."""
    rates = free_start(ROBOT)
    state = np.concatenate([rates.pose.q, rates.q_dot])
    xi, xi_dot, q_ddot, energy = joint_model(ROBOT, state, int(rates.pose.assembly))
    assert xi == pytest.approx(rates.pose.xi, abs=1e-14)
    assert xi_dot == pytest.approx(rates.xi_dot, abs=1e-12)
    assert q_ddot == pytest.approx(fb.forward_dynamics(rates, (0.0, 0.0)).q_ddot, rel=1e-11)
    assert energy == pytest.approx(fb.energy(rates), rel=1e-12)


def free_motion_by_rk4(step):
    """The free motion by RK4 with fixed step, s, on the joint-space model."""
    start = free_start(ROBOT)
    assembly = int(start.pose.assembly)
    with np.errstate(all="ignore"):
        state = np.concatenate([start.pose.q, start.q_dot])
        t, states = march(rk4, joint_slope(ROBOT, assembly), state, 2.0, step)
        xi, _, _, energy = joint_model(ROBOT, states.T, assembly)
    return FreeRun("RK4", t, xi.T, energy)


def outcomes(steps, near=1e-4):
    """How many steps gave nan, ended within `near` (m) of the true end, or elsewhere without a word."""
    distance = np.linalg.norm(steps.end - FREE_END, axis=1)
    kinds = np.where(distance <= near, "right", "silently wrong")
    return Counter(np.where(np.isfinite(distance), kinds, "nan").tolist())


def all_survive(steps):
    return outcomes(steps, near=1e-6)["right"] == len(steps.step) and bool(
        (np.abs(steps.energy_error) < 1e-7).all()
    )


@pytest.mark.deep
def test_every_fixed_step():
    naive = free_motion_by_steps(ROBOT, STEPS)
    assert all_survive(free_motion_of_ours_by_steps(ROBOT, STEPS[::20]))
    assert not all_survive(naive)
    found = outcomes(naive)
    assert found["right"] == 0 and found["nan"] > 200 and found["silently wrong"] > 5
    silent = float(naive.step[np.isfinite(naive.energy_error)][0])
    motion = free_motion_by_rk4(silent)
    assert motion.success and np.isfinite(motion.xi).all() and not survives(motion)


def test_our_joint_chart_alone_refuses():
    for step in STEPS[::40]:
        with pytest.raises(fb.SingularityError, match="jumps the singularity of the joint chart"):
            fb.simulate(
                ROBOT,
                duration=2.0,
                start=free_start(ROBOT),
                step=float(step),
                integrator=fb.Integrator(chart="joint"),
            )
