"""Controllers of robots with gravity, heavy bars and friction."""

from dataclasses import replace

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.control.matched import matched

from ..helpers.physics_cases import CASES, robot_of_case

IRI = robot_of_case(CASES[0])
LAB = fb.FiveBar(gravity=(0.0, -9.81))
CIRCLE = fb.circle((0.0, 0.13), 0.02, 2.0)


def last_error(run):
    return np.abs(run.error[-1]).max()


def test_pd_with_gravity_stands_where_pd_sags():
    still = fb.line((0.09, 0.068), (0.0900001, 0.068), 1.5)
    sags, stands = (
        fb.simulate(LAB, fb.PD(LAB, 8.0, 0.6, gravity=gravity), still, control_period=0.002)
        for gravity in (False, True)
    )
    assert last_error(sags) > 2e-3 and last_error(stands) < 1e-6
    # The sag is what the springs give under the weight, kp (q_ref - q) = g(q).
    pose = fb.dgm(LAB, sags.q[-1])
    away = fb.igm(LAB, (0.0900001, 0.068)).q - pose.q
    np.testing.assert_allclose(8.0 * away, fb.gravity_torques(pose), rtol=1e-3)


def test_pd_with_gravity_of_symbols_is_that_of_numbers():
    law, q, q_dot = (
        fb.PD(IRI, 20.0, 1.0, gravity=True),
        casadi.SX.sym("q", 2),
        casadi.SX.sym("v", 2),
    )
    call = casadi.Function(
        "law", [q, q_dot], [law.law(q, q_dot, (0.3, 0.6), (0.0, 0.0), (0.0, 0.0))]
    )
    numbers = law.law(
        np.array((0.2, 0.8)), np.array((0.1, -0.2)), np.array((0.3, 0.6)), np.zeros(2), np.zeros(2)
    )
    np.testing.assert_allclose(call((0.2, 0.8), (0.1, -0.2)).full().ravel(), numbers, rtol=1e-12)
    runs = fb.simulate_many(
        LAB, [fb.PD(LAB, kp, 0.6, gravity=True) for kp in (4.0, 8.0)], CIRCLE, step=0.002
    )
    alone = fb.simulate(
        LAB,
        fb.PD(LAB, 8.0, 0.6, gravity=True),
        CIRCLE,
        step=0.002,
        integrator=fb.Integrator(method="rk4"),
    )
    np.testing.assert_allclose(runs[1].q, alone.q, atol=1e-10)


@pytest.mark.every(3)
@pytest.mark.parametrize("robot", [LAB, IRI, replace(LAB, fs1=0.01, fs2=0.02, fv1=0.003)])
def test_computed_torque_that_knows_the_robot_follows_and_without_gravity_does_not(robot):
    xi = (0.02, 0.12) if robot is not IRI else (0.02, 0.25)
    path = fb.line(xi, (xi[0] + 0.03, xi[1] - 0.02), 1.0)
    blind = replace(robot, gravity=(0.0, 0.0))
    knows, not_ = (
        fb.simulate(robot, fb.ComputedTorque(each, 400.0, 40.0), path, control_period=0.002)
        for each in (robot, blind)
    )
    assert np.abs(knows.error).max() < 3e-4 < 3e-3 < np.abs(not_.error).max()


def test_dry_friction_is_given_by_the_reference_not_by_the_sign_of_a_rate_near_0():
    robot = fb.FiveBar(fs1=0.02, fs2=0.03)
    law = fb.ComputedTorque(robot, 100.0, 20.0)
    still, moving = np.zeros(2), np.array([0.5, -0.5])
    q = np.array((0.2, 0.4))
    for rate in (1e-9, -1e-9):
        np.testing.assert_allclose(law.law(q, np.full(2, rate), q, still, still), 0, atol=1e-6)
    lab = fb.ComputedTorque(fb.FiveBar(), 100.0, 20.0)
    more = law.law(q, moving, q, moving, still) - lab.law(q, moving, q, moving, still)
    np.testing.assert_allclose(more, (0.02, -0.03), rtol=1e-12)


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "more", [{}, {"fs1": 0.01, "fs2": 0.01, "fv1": 0.002}, {"zz12": -1e-4, "my22": 2e-4}]
)
def test_the_tracker_knows_gravity_friction_and_heavy_bars(more):
    robot = replace(LAB, **more)
    run, blind = (
        fb.simulate(robot, fb.Tracker(each), CIRCLE, duration=2.0) for each in (robot, fb.FiveBar())
    )
    settled = run.t > 0.5
    best, other = (np.hypot(*each.error[settled].T).max() for each in (run, blind))
    assert best < 3e-4 and best < other
    assert (run.log.status == 0).mean() > 0.95


@pytest.mark.parametrize(
    "robot, acceleration", [(LAB, (0.0, 0.0)), (fb.FiveBar(), (0.4, 0.3)), (LAB, (0.4, 0.3))]
)
def test_the_tracker_s_first_torque_is_that_with_which_the_motion_begins(robot, acceleration):
    """Where a change from 0 is charged, a seventh of it is missing, and the robot sags."""
    start = np.array((0.09, 0.068))
    moved = start + 0.02 * np.array(acceleration)
    ends = [(0.0, {0: start, 1: (0, 0), 2: acceleration}), (0.4, {0: moved, 1: (0, 0), 2: (0, 0)})]
    reference = fb.polynomial(ends)
    at_rest = fb.ikm(fb.igm(robot, start), (0.0, 0.0))
    needed = fb.inverse_dynamics(fb.ikm2(at_rest, acceleration))
    constraints = fb.Constraints()
    for tracker in (fb.Tracker(robot), matched(robot, 0.5, 0.01, constraints, assembly=-1)):
        run = fb.simulate(robot, tracker, reference, start=at_rest)
        assert np.abs(run.tau[0] - needed).max() < 0.03 * np.abs(needed).max()
        assert np.hypot(*run.error[run.t < 0.1].T).max() < 1.5e-5


def test_gravity_is_a_flag():
    with pytest.raises(ValueError, match="gravity must be one of True, False"):
        fb.PD(LAB, 1.0, 0.1, gravity=(0, -9.81))
