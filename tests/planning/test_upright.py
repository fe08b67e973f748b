"""Plans of robots that stand upright: their weight, larger than the forces of the motion, may swing them."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.four_joints import bars_pose, closed, loop_gap
from fivebar.planning.coordinates import bars

DOWN = (0.0, -9.81)
HEAVY = fb.FiveBar.from_links(
    0.09,
    0.1,
    0.08,
    0.09,
    0.12,
    {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08},
    payload=0.2,
    gravity=DOWN,
    rotor=(1e-4, 2e-4),
)
LARGE = fb.FiveBar.from_links(
    0.3,
    0.4,
    0.3,
    0.4,
    0.25,
    {"11": 1.0, "12": 0.8, "21": 1.0, "22": 0.8},
    payload=1.0,
    gravity=DOWN,
    rotor=(5e-3, 5e-3),
)
LAB = fb.FiveBar(gravity=DOWN)
EQUAL = fb.FiveBar.from_links(
    0.1,
    0.1,
    0.1,
    0.1,
    0.08,
    dict.fromkeys(("11", "12", "21", "22"), 0.05),
    payload=0.2,
    gravity=DOWN,
)
# Robot, active joints and assembly mode at both ends, duration.
PAIRS = [
    (HEAVY, ((0.0733, 2.7929), -1), ((-0.4754, 2.0318), -1), 2.1),
    (LAB, ((0.5, 2.2), -1), ((1.2, 2.9), -1), 1.5),
    (LARGE, ((0.9, 2.0), -1), ((2.4, 1.1), 1), 2.0),
]


def balance(plan):
    """The largest difference of the energy's change and the torques' work, over the largest energy."""
    t = np.linspace(0, plan.duration, 20001)
    rates = plan.accelerations(t).rates
    energy = fb.energy(rates) + fb.potential(rates.pose)
    power = (plan.torques(t) * rates.q_dot).sum(axis=1)
    work = np.append(0.0, np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(t)))
    return np.abs(energy - energy[0] - work).max() / np.ptp(energy)


@pytest.mark.deep
@pytest.mark.parametrize("robot, start, goal, duration", PAIRS)
def test_between_poses_of_upright_robots(robot, start, goal, duration):
    poses = [fb.dgm(robot, *each) for each in (start, goal)]
    plan = fb.plan(robot, *poses, duration)
    assert plan.error < 1e-3
    assert plan.status == "Solve_Succeeded"
    np.testing.assert_allclose(plan(np.array([duration]))[0][0], poses[1].xi, atol=1e-6)
    t = np.linspace(0, duration, 20001)
    effort = np.trapezoid((plan.torques(t) ** 2).sum(axis=1), t)
    assert plan.objective == pytest.approx(effort, rel=1e-3)
    assert np.hypot(*loop_gap(bars_pose(robot, tuple(plan.motion(t)[:, :4].T)))).max() < 1e-5
    assert balance(plan) < 2e-3


@pytest.mark.deep
def test_more_time_makes_no_worse_plan():
    robot, start, goal, duration = PAIRS[0]
    poses = [fb.dgm(robot, *each) for each in (start, goal)]
    quick, slow = (
        fb.plan(robot, *poses, duration, collocation=fb.Collocation(max_time=max_time))
        for max_time in (30.0, 60.0)
    )
    assert slow.objective <= quick.objective * 1.001


@pytest.mark.deep
def test_ways_whose_first_motions_take_many_iterations():
    """IPOPT ends before it has converged on any way; near where it ended, it soon does."""
    robot = fb.FiveBar(
        0.0981445390937392,
        0.0781646816256492,
        0.0759117010666356,
        0.09087456852972432,
        0.07083033174835218,
        0.0017025819880472175,
        0.0008271729707202872,
        0.4666591579876006,
        mx11=0.016640922639248275,
        mx21=0.010140634227101705,
        zz12=-0.00013280251485127734,
        zz22=-0.00016237726277091295,
        gravity=DOWN,
    )
    start = fb.dgm(robot, (1.191887, 0.021339), -1)
    goal = fb.dgm(robot, (0.162541, 2.037665), 1)
    plan = fb.plan(robot, start, goal, 2.9945, collocation=fb.Collocation(max_time=120.0))
    assert plan.error < 1e-3 and plan.objective < 0.9


def test_an_interval_ends_on_the_closed_loop():
    pose = fb.igm(HEAVY, (0.01, 0.13), (-1, -1))
    open_bars = bars(pose) + (1e-3, -2e-3, 1.5e-3, 1e-3)
    rates = np.array([0.1, -0.2, 0.3, 0.2])
    closed_bars, closed_rates = (
        np.array(each) for each in closed(HEAVY, tuple(open_bars), tuple(rates))[:2]
    )
    assert np.hypot(*loop_gap(bars_pose(HEAVY, tuple(closed_bars)))) < 1e-6
    assert np.abs(closed_bars - open_bars).max() < 3e-3 and np.abs(closed_rates - rates).max() < 0.5


@pytest.mark.deep
@pytest.mark.parametrize(
    "robot, start, goal, most",
    [(LAB, (0.0, 0.1), (0.03, 0.11), 0.0479), (EQUAL, (0.0, 0.12), (0.03, 0.15), 0.0149)],
)
def test_swings_that_lead_to_no_plan_leave_time_for_the_ways(robot, start, goal, most):
    """In 3 s bars fall many times, and meshes of their swings would take all of the time."""
    plan = fb.plan(robot, fb.igm(robot, start), fb.igm(robot, goal), 3.0)
    assert plan.objective < most and plan.error <= 1e-3


@pytest.mark.deep
def test_least_time_between_poses_is_no_longer_than_in_their_modes():
    links = {"11": 1.0, "12": 0.5, "21": 1.0, "22": 0.5}
    robot = fb.FiveBar.from_links(0.22, 0.31, 0.25, 0.26924, 0.15, links, payload=2.0, gravity=DOWN)
    limits = fb.Constraints(torque=8.0)
    ends = (0.1, 0.3), (-0.1, 0.35)
    kept = fb.plan(robot, *ends, objective="time", constraints=limits)
    poses = [fb.igm(robot, point, (-1, -1)) for point in ends]
    free = fb.plan(robot, *poses, objective="time", constraints=limits)
    assert free.duration <= 1.001 * kept.duration < 0.465


def test_a_plan_says_how_far_smoothed_friction_is_off_where_torques_are_limited():
    robot = fb.FiveBar(fs1=0.05, fs2=0.02)
    plan = fb.plan(robot, (0.05, 0.12), (-0.03, 0.1), 1.0, constraints=fb.Constraints(torque=1.0))
    assert any("is up to 0.05 N m off" in note for note in plan.notes)
    free = fb.plan(robot, (0.05, 0.12), (-0.03, 0.1), 1.0)
    assert not any("friction" in note for note in free.notes)
