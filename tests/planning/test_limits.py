"""Limits of plans: by how much they are exceeded, in words and numbers, and stops that break them."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.collocation import Scheme
from fivebar.planning.problem import (
    OBJECTIVES,
    PlanError,
    Problem,
    checked_stops,
    checked_weights,
    refuse_broken,
    refuse_stops,
    stop_names,
    timed,
    working_modes,
)

from ..conftest import UNEQUAL

ROBOT = fb.FiveBar()
START, GOAL = (0.05, 0.12), (-0.03, 0.1)
STOPS = checked_stops(START, GOAL, 1.0, [])


def problem_of(robot=ROBOT, stops=STOPS, working=(-1, -1), **limits):
    weights = dict.fromkeys(OBJECTIVES, 0.0) | {"effort": 1.0}
    return Problem(robot, stops, working, weights, fb.Constraints(**limits), Scheme(3))


def test_violations_are_the_largest_excesses():
    problem = problem_of(
        torque=(0.1, 0.2), joint_speed=(1.0, 3.0), acceleration=0.5, sin=0.1, det_A=0.3
    )
    q_dot = np.array([[0.5, -3.5], [-1.25, 1.0], [0.5, 0.5]])
    xi_ddot = np.array([[0.3, -0.4], [0.6, 0.8], [0.0, 0.0]])
    tau = np.array([[0.15, -0.1], [0.05, -0.5], [0.0, 0.2]])
    sines = np.array([0.5, 0.05, 0.2]), np.array([0.02, 0.3, 0.4]), np.array([0.1, 0.9, 0.3])
    found = problem.violations(q_dot, xi_ddot, tau, sines)
    expected = {
        "torque": [0.05, 0.3, 0.0],
        "joint_speed": [0.5, 0.25, -0.5],
        "acceleration": [0.0, 0.5, -0.5],
        "sin": [0.08, 0.05, -0.1],
        "det_A": [0.2, -0.6, 0.0],
    }
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        assert found[name] == pytest.approx(values, abs=1e-12), name
    assert problem_of().violations(q_dot, xi_ddot, tau, sines) == {}
    assert problem.violations() == {}


def test_a_motor_that_turns_fast_has_less_torque():
    """At half of its largest speed half of the stall torque is left, when it drives."""
    problem = problem_of(motors=fb.Motor(0.4, 6.0))
    tau = np.array([[0.3, 0.1], [0.3, 0.1], [-0.3, 0.0]])
    q_dot = np.array([[3.0, 0.0], [-3.0, 0.0], [-3.0, 0.0]])
    found = problem.violations(q_dot, tau=tau)["torque"]
    assert found == pytest.approx([0.1, -0.1, 0.1], abs=1e-12)


def test_units_of_limits():
    """Of a limit its largest value; of places a mean distal bar; of sines and det A 1."""
    problem = problem_of(UNEQUAL, torque=(0.1, 0.2), joint_speed=3.0, acceleration=0.5, sin=0.1)
    assert [problem.unit(name) for name in ("torque", "joint_speed", "acceleration")] == [
        0.2,
        3.0,
        0.5,
    ]
    assert problem.unit("region") == problem.unit("reach") == pytest.approx(0.13)
    assert problem.unit("sin") == problem.unit("det_A") == 1.0
    assert problem.lever == problem.length == pytest.approx(0.13)
    assert problem.mass == pytest.approx(0.7 + (0.003 + 0.0015) / 0.13**2)
    slides = problem_of(fb.Biglide())
    assert slides.lever == 1.0
    assert slides.mass == pytest.approx(fb.Biglide().m + sum(fb.Biglide().inertias))
    assert problem.fall == 0.0
    assert problem_of(fb.FiveBar(gravity=(3.0, -4.0))).fall == pytest.approx(5.0)


def test_violated_limits_in_words():
    problem = problem_of(torque=(0.1, 0.2), joint_speed=3.0, acceleration=0.5, sin=0.1)
    violations = {
        "torque": 0.0512345,
        "joint_speed": 0.25,
        "acceleration": 0.125,
        "sin": 0.01,
        "reach": 0.002,
    }
    assert problem.listed(violations) == (
        "; violated: torque by 0.05123 N m (limit 0.2), joint_speed by 0.25 rad/s (limit 3),"
        " acceleration by 0.125 m/s² (limit 0.5), sin by 0.01 (limit 0.1), reach by 0.002 m"
    )
    assert problem.listed({"torque": 1e-7, "sin": 1e-6}) == ""
    slides = problem_of(fb.Biglide(), torque=2.0, joint_speed=0.5)
    assert slides.listed({"torque": 1.0, "joint_speed": 0.1}) == (
        "; violated: force by 1 N (limit 2), joint_speed by 0.1 m/s (limit 0.5)"
    )


@pytest.mark.parametrize("robot", [ROBOT, UNEQUAL, fb.Biglide()])
def test_margins_count_from_the_start(robot):
    """Positive there, in whatever modes; det A alone where all modes are free."""
    start = (0.02, 0.2) if isinstance(robot, fb.Biglide) else START
    for working in ((-1, -1), (1, -1), (-1, 1)):
        pose = fb.igm(robot, start, working)
        problem = problem_of(robot, checked_stops(start, GOAL, 1.0, []), working)
        expected = [*np.abs(pose.sines), abs(pose.det_A)]
        assert problem.signed_sines(pose) == pytest.approx(expected, abs=1e-12)
        assert problem.side == np.sign(pose.det_A)


def test_a_stop_that_breaks_a_limit_by_its_own_speed_or_acceleration():
    fast = {0: GOAL, 1: (0.3, 0.0)}
    q_dot = fb.ikm(fb.igm(ROBOT, GOAL), (0.3, 0.0)).q_dot
    excess = np.abs(q_dot).max() - 2.0
    stops = checked_stops(START, fast, 1.0, [])
    with pytest.raises(
        PlanError, match="goal itself breaks limits; violated: joint_speed"
    ) as error:
        refuse_stops(problem_of(stops=stops, joint_speed=2.0))
    assert error.value.violations == {"joint_speed": pytest.approx(excess)}
    hard = {0: GOAL, 2: (0.3, 0.4)}
    stops = checked_stops(START, (0.0, 0.12), 1.0, [(0.5, hard)])
    with pytest.raises(PlanError, match=r"via\[0\] itself breaks limits") as error:
        refuse_stops(problem_of(stops=stops, acceleration=0.3))
    assert error.value.violations == {"acceleration": pytest.approx(0.2)}
    refuse_stops(problem_of(stops=stops, acceleration=0.5))
    refuse_stops(problem_of(stops=checked_stops(START, fast, 1.0, []), acceleration=0.1))


def test_the_other_side_of_type_2_is_named_with_its_signs():
    below = (0.05, 0.0)
    there, here = fb.igm(ROBOT, below).det_A, fb.igm(ROBOT, START).det_A
    assert here * there < 0
    word = "positive" if here > 0 else "negative"
    problem = problem_of(stops=checked_stops(START, below, 1.0, []), det_A=0.1)
    words = rf"goal is on the other side .*det A = {there:.3g} there, and it is {word} at the start"
    with pytest.raises(PlanError, match=words) as error:
        refuse_stops(problem)
    assert error.value.violations == {"det_A": pytest.approx(0.1 + abs(there))}
    back = problem_of(stops=checked_stops(below, START, 1.0, []), det_A=0.1)
    other = "negative" if here > 0 else "positive"
    with pytest.raises(PlanError, match=f"and it is {other} at the start"):
        refuse_stops(back)


def test_a_plan_that_leaves_a_region_between_its_stops_is_refused_with_the_time():
    """Of a region that has a corner inwards, which the program does not know."""
    plan = fb.plan(ROBOT, START, GOAL, 1.0)
    lowest = float(plan(np.linspace(0.0, 1.0, 401))[0][:, 1].min())
    problem = replace(
        plan.problem, constraints=fb.Constraints(half_planes=[(0.0, 1.0, lowest + 0.01)])
    )
    broken = replace(plan, problem=problem)
    with pytest.raises(PlanError, match=r"does not keep .* \(t = .* s\): by 0.01") as error:
        refuse_broken(broken, 1e-3)
    (value,) = error.value.violations.values()
    assert value == pytest.approx(0.01, abs=1e-6)
    assert error.value.plan is broken
    # The tolerance is a share of a bar's length.
    assert refuse_broken(broken, 0.0101 / problem.length) is broken
    with pytest.raises(PlanError):
        refuse_broken(broken, 0.0099 / problem.length)
    q = plan.joints(np.linspace(0.0, 1.0, 401))[0][:, 0]
    joints = fb.Constraints(joints=((-3.0, q.max() - 0.01), None))
    turned = replace(plan, problem=replace(plan.problem, constraints=joints))
    assert refuse_broken(turned, 0.0101) is turned
    with pytest.raises(PlanError, match="joint"):
        refuse_broken(turned, 0.0099)


def test_stops_in_order():
    assert stop_names(4) == ["start", "via[0]", "via[1]", "goal"]
    assert stop_names(2) == ["start", "goal"]
    found = timed("a", "d", 3.0, [(1.0, "b"), (None, "c")])
    assert found == [
        ("start", 0.0, "a"),
        ("via[0]", 1.0, "b"),
        ("via[1]", None, "c"),
        ("goal", 3.0, "d"),
    ]
    assert timed("a", "b", None, [])[-1] == ("goal", None, "b")
    stops = checked_stops(START, {0: GOAL, 2: (0, 0)}, 3.0, [(1.0, (0.0, 0.1))])
    assert stops == (
        ({0: START, 1: (0.0, 0.0)}, 0.0),
        ({0: (0.0, 0.1)}, 1.0),
        ({0: GOAL, 2: (0.0, 0.0)}, 3.0),
    )
    with pytest.raises(ValueError, match="free duration would be 0"):
        checked_stops(START, START, None, [])
    assert len(checked_stops(START, START, None, [(None, GOAL)])) == 3
    assert len(checked_stops(START, START, 1.0, [])) == 2


def test_weights_of_an_objective():
    assert checked_weights("time") == {"effort": 0.0, "time": 1.0, "jerk": 0.0}
    assert checked_weights({"jerk": 2, "effort": 3.0}) == {"effort": 3.0, "time": 0.0, "jerk": 2.0}
    assert checked_weights({"own": abs, "time": 0.5}) == {"effort": 0.0, "time": 0.5, "jerk": 0.0}
    assert not any(checked_weights(abs).values())
    assert not any(checked_weights({"own": abs, "time": 0.0}).values())
    for bad in ({"time": 1.0, "own": 3.0}, {"time": 0.0, "effort": 0.0}, {}, "own", None):
        with pytest.raises(ValueError, match="plan: "):
            checked_weights(bad)


def test_working_modes_are_those_of_the_poses():
    one, other = fb.igm(ROBOT, START, (1, -1)), fb.igm(ROBOT, GOAL, (-1, -1))
    assert working_modes(one, GOAL) == (1, -1) == working_modes(one, one)
    assert working_modes(START, other) == (-1, -1)
    with pytest.raises(ValueError, match=r"modes \(1, -1\), goal in \(-1, -1\)"):
        working_modes(one, other)


def test_a_plan_keeps_to_the_line_of_its_motors():
    """The free motion is faster than they can drive; the plan with them costs a little more."""
    coarse = fb.Collocation(intervals=10)
    t = np.linspace(0.0, 1.0, 1001)
    free = fb.plan(ROBOT, START, GOAL, 1.0, collocation=coarse)
    tau, (_, q_dot) = free.torques(t), free.joints(t)
    fastest = np.abs(q_dot).max()
    stall = np.abs(tau).max() * 1.2
    motors = fb.Constraints(motors=fb.Motor(stall, fastest))
    assert motors.torque_share(tau, q_dot).max() > 1.05
    plan = fb.plan(ROBOT, START, GOAL, 1.0, constraints=motors, collocation=coarse)
    share = np.abs(plan.torques(t) / stall + plan.joints(t)[1] / fastest).max(axis=1)
    assert 0.999 < share.max() < 1.002
    assert 1.001 * free.objective < plan.objective < 1.5 * free.objective
    assert plan.saturated == pytest.approx(np.mean(share >= 0.999), abs=0.02)


def test_least_time_where_many_torques_take_as_little():
    """One motor is as fast as it may be: the torques of the other must not leap from node to node."""
    robot = fb.FiveBar(0.08, 0.1, 0.08, 0.1, 0.06, zz1=9e-4, zz2=9e-4, m=0.15)
    limits = fb.Constraints(torque=0.9, joint_speed=6.3)
    start, goal = (fb.igm(robot, xi, (-1, -1)) for xi in ((0.03, 0.1), (-0.03, 0.12)))
    plan = fb.plan(robot, start, goal, objective="time", constraints=limits)
    assert plan.error <= 1e-3 and plan.objective == pytest.approx(plan.duration, rel=1e-12)
    turned = np.abs(goal.q - start.q).max()
    assert turned / 6.3 < plan.duration < 1.1 * turned / 6.3
    t = np.linspace(0, plan.duration, 2001)
    q, q_dot = plan.joints(t)
    assert np.abs(q_dot).max() < 6.3 * (1 + 1e-3) and np.abs(plan.torques(t)).max() < 0.9 * (
        1 + 1e-3
    )
