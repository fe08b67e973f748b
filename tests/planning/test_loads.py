"""Plans and paths of robots with gravity, heavy bars and friction, through Type 2."""

import io
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

import fivebar as fb

from ..helpers.physics_cases import CASES, robot_of_case

IRI = robot_of_case(CASES[0])
LAB = fb.FiveBar(gravity=(0.0, -9.81))
HEAVY = fb.FiveBar.from_links(
    0.09,
    0.09,
    0.09,
    0.09,
    0.118,
    {name: 0.1 for name in ("11", "12", "21", "22")},
    payload=0.3,
    gravity=(0.0, -9.81),
    rotor=(0.001, 0.001),
)
RUBS = fb.FiveBar(fs1=0.005, fs2=0.005, fv1=0.002)
HOME, ACROSS = (0.09, 0.06796322), (0.05, 0.0)


def crossing(robot, plan):
    """The time at which det A passes 0."""
    t = np.linspace(0, plan.duration, 401)
    det_A = plan.accelerations(t).rates.pose.det_A
    k = int(np.flatnonzero(det_A[1:] * det_A[:-1] < 0)[0])
    return brentq(lambda s: float(plan.accelerations(s).rates.pose.det_A), t[k], t[k + 1])


@cache
def plan_across(robot):
    return fb.plan(robot, HOME, ACROSS, 2.0, collocation=fb.Collocation(max_time=120.0))


@pytest.mark.deep
@pytest.mark.parametrize("robot", [LAB, HEAVY, RUBS])
def test_a_plan_crosses_type_2_and_the_plant_follows_it(robot):
    plan = plan_across(robot)
    found = fb.check_path(robot, plan)
    assert found.type == fb.Singularity.PARALLEL and found.criterion_holds
    run = fb.simulate(
        robot, fb.FeedForward(robot, 5.0, 0.3, ahead=0.0005), plan, control_period=0.001
    )
    assert np.abs(run.error).max() < 2e-4
    assert any(event.type == fb.Singularity.PARALLEL for event in run.events)
    file = io.StringIO()
    plan.to_csv(file)
    file.seek(0)
    back = fb.Plan.from_csv(file)
    assert back.robot == robot and back.error == plan.error


@pytest.mark.deep
def test_the_criterion_under_gravity_is_not_the_inertial_one():
    """On the plan the inertial force has a part along t_s, that of the weight: exactly what gravity balances."""
    plan = plan_across(LAB)
    t = crossing(LAB, plan)
    acc = plan.accelerations(t)
    ux, uy = acc.rates.pose.u2[0]
    along = np.array([-uy, ux])
    inertial, weight = (LAB.m * along @ each for each in (acc.xi_ddot, np.array([0.0, -9.81])))
    assert abs(weight) > 0.1 and inertial == pytest.approx(weight, rel=5e-3)


@pytest.mark.parametrize("robot", [LAB, HEAVY])
def test_a_polynomial_made_to_cross_has_a_finite_torque_under_gravity_and_one_that_forgets_it_has_not(
    robot,
):
    line, lab = fb.line(HOME, ACROSS, 0.3), fb.FiveBar()
    found = fb.check_path(robot, line)
    xi, velocity, times = tuple(found.pose.xi), tuple(line(found.time)[1]), (0.0, found.time, 0.3)
    for own, finite in ((robot, True), (lab, False)):
        path = fb.crossing_polynomial(own, HOME, ACROSS, xi, velocity, times)
        torques = []
        for before in (1e-4, 1e-6):
            motion = path(found.time - before)
            acc = fb.ikm2(fb.ikm(fb.igm(robot, motion[0]), motion[1]), motion[2])
            torques.append(np.abs(fb.inverse_dynamics(acc)).max())
        assert (torques[1] < 1.5 * torques[0]) == finite


def test_smoothing_of_dry_friction_in_a_plan_is_measured():
    plan = fb.plan(RUBS, HOME, (0.0, 0.1), 0.5)
    assert 0 < plan.friction_error <= RUBS.fs1 * (1 + 1e-12)
    t = np.linspace(0.1, 0.4, 50)
    acc = plan.accelerations(t)
    fast = (np.abs(acc.rates.q_dot) > 0.5).all(axis=1)
    exact = fb.inverse_dynamics(
        fb.ikm2(fb.ikm(fb.igm(RUBS, acc.rates.pose.xi), acc.rates.xi_dot), acc.xi_ddot)
    )
    assert fast.any()
    np.testing.assert_allclose(
        plan.torques(t)[fast], exact[fast], atol=0.005 * 0.5 * (0.05 / 0.5) ** 2 + 1e-5
    )
    assert fb.plan(replace(RUBS, fs1=0, fs2=0), HOME, (0.06, 0.1), 1.0).friction_error == 0


@pytest.mark.deep
def test_between_poses_under_gravity():
    start, goal = fb.igm(LAB, HOME), fb.igm(LAB, (0.0, 0.12), (-1, 1))
    plan = fb.plan(LAB, start, goal, 1.5, collocation=fb.Collocation(max_time=120.0))
    np.testing.assert_allclose(
        plan.accelerations(plan.duration).rates.pose.xi, (0.0, 0.12), atol=1e-6
    )
    run = fb.simulate(LAB, fb.FeedForward(LAB, 5.0, 0.3, ahead=0.0005), plan, control_period=0.001)
    assert np.abs(run.error).max() < 1e-3


@pytest.mark.deep
def test_between_poses_with_dry_friction():
    """Both motors reverse, and the mesh gets accurate there too."""
    robot = fb.FiveBar(
        0.08, 0.11, 0.1, 0.095, 0.12, zz1=0.001, zz2=0.002, m=0.4, mx11=0.01, mx21=0.02,
        fs1=0.0087, fs2=0.0087, gravity=(1.0, -9.0),
    )  # fmt: skip
    start = fb.igm(robot, (-0.0656, -0.1399), (-1, -1))
    goal = fb.igm(robot, (-0.0382, -0.1206), (1, -1))
    plan = fb.plan(robot, start, goal, 0.59)
    rates = plan.joints(np.linspace(0, 0.59, 100)[1:-1])[1]
    assert (rates.min(axis=0) < -0.1).all() and (rates.max(axis=0) > 0.1).all()
    assert plan.error <= 1e-3
    run = fb.simulate(robot, fb.FeedForward(robot, 5.0, 0.3), plan, control_period=0.001)
    assert np.abs(run.error).max() < 1e-3


@pytest.mark.deep
def test_a_vertical_robot_of_cad_numbers_is_planned_through_type_2():
    plan = fb.plan(IRI, (0.1, 0.2), (0.0, -0.25), 0.8, collocation=fb.Collocation(max_time=120.0))
    assert fb.check_path(IRI, plan).type == fb.Singularity.PARALLEL
    run = fb.simulate(IRI, fb.FeedForward(IRI, 60.0, 4.0, ahead=0.0005), plan, control_period=0.001)
    assert np.abs(run.error).max() < 1e-3
