"""First guesses of plans: where they pass, when, how fast, and how long their ways are."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.collocation import Scheme
from fivebar.planning.guess import _blocked, _path, first_guess
from fivebar.planning.problem import OBJECTIVES, Problem, checked_stops

from ..conftest import UNEQUAL

ROBOT = fb.FiveBar()
START, GOAL = (0.05, 0.12), (-0.03, 0.1)


def problem_of(stops, robot=ROBOT, working=(-1, -1), weights=None, **limits):
    weights = dict.fromkeys(OBJECTIVES, 0.0) | (weights or {"effort": 1.0})
    constraints = fb.Constraints(sin=0.05, **limits)
    return Problem(robot, stops, working, weights, constraints, Scheme(3))


def length_of(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def test_a_guess_passes_its_stops_at_their_times_and_rests_there():
    """Between stops with a time, the others get theirs by the lengths of the ways."""
    via = [(0.5, (0.03, 0.15)), (None, (0.0, 0.15)), (2.0, (0.0, 0.11))]
    problem = problem_of(checked_stops(START, GOAL, 3.0, via))
    guess, durations = first_guess(problem)
    assert durations[0] == pytest.approx(0.5) and durations.sum() == pytest.approx(3.0)
    assert durations[1:3] == pytest.approx(1.5 * np.array([0.03, 0.04]) / 0.07)
    times = np.append(0.0, np.cumsum(durations))
    points = np.array([stop[0][0] for stop in problem.stops])
    found = guess(times)
    assert found[:, :2] == pytest.approx(points, abs=1e-12)
    # At the turning points the velocity is that between the last two of 201 places.
    assert np.abs(found[:, 2:4]).max() < 1e-3
    t = np.linspace(0.0, 3.0, 60001)
    xi, xi_dot, xi_ddot, controls = np.split(guess(t), (2, 4, 6), axis=1)
    assert not controls.any()
    for value, slope in ((xi, xi_dot), (xi_dot, xi_ddot)):
        change = np.cumsum((slope[1:] + slope[:-1]) / 2, axis=0) * 3.0 / 60000
        assert np.abs(change - (value[1:] - value[0])).max() < 2e-3 * np.abs(value).max()


def test_the_middle_of_a_guess_is_the_quintic():
    guess, durations = first_guess(problem_of(checked_stops(START, GOAL, 2.0, [])))
    t = np.linspace(0.0, 2.0, 41)
    line = fb.line(START, GOAL, 2.0)
    assert durations == pytest.approx([2.0])
    for value, exact in zip(np.split(guess(t), (2, 4, 6), axis=1), line(t)):
        assert np.abs(value - exact)[1:-1].max() < 5e-4 * np.abs(exact).max() + 1e-9


def test_a_way_in_even_steps_is_passed_step_by_step():
    """However far its points are apart, as the steps of a way of the bars are even by their energy."""
    share = np.linspace(0.0, 1.0, 11)[:, None]
    path = START + share**2 * np.subtract(GOAL, START)
    problem = problem_of(checked_stops(START, GOAL, 2.0, []))
    guess, _ = first_guess(problem, [path])
    sigma = np.linspace(0.0, 1.0, 201)
    blend = sigma**3 * (10 - 15 * sigma + 6 * sigma**2)
    expected = START + blend[:, None] ** 2 * np.subtract(GOAL, START)
    # Between the points, straight.
    assert guess(2.0 * sigma)[:, :2] == pytest.approx(expected, abs=0.0026 * 0.09)


@pytest.mark.parametrize("weights", [{"effort": 1e4, "time": 1.0}, {"jerk": 1e-3, "time": 2.0}])
def test_a_free_duration_of_a_guess_costs_least(weights):
    """Among motions along the same way in the same rhythm."""
    problem = problem_of(checked_stops(START, GOAL, None, []), weights=weights)
    _, (duration,) = first_guess(problem)

    def cost(duration):
        motion = fb.line(START, GOAL, duration)
        t = np.linspace(0.0, duration, 2001)
        xi, xi_dot, xi_ddot = motion(t)
        acc = fb.ikm2(fb.ikm(fb.igm(ROBOT, xi), xi_dot), xi_ddot)
        jerk = np.gradient(xi_ddot, t, axis=0)
        squares = {"effort": fb.inverse_dynamics(acc), "jerk": jerk}
        total = weights["time"] * duration
        for name, value in squares.items():
            total += weights.get(name, 0.0) * np.trapezoid((value**2).sum(axis=1), t)
        return total

    assert cost(duration) < min(cost(0.97 * duration), cost(1.03 * duration))


@pytest.mark.parametrize("limit", ["acceleration", "joint_speed", "torque", "motors"])
def test_a_guess_in_least_time_is_as_fast_as_a_limit_allows(limit):
    """The largest acceleration is the limit; of the others 95 % of the values are below it."""
    given = {
        "acceleration": {"acceleration": 0.7},
        "joint_speed": {"joint_speed": (1.5, 3.0)},
        "torque": {"torque": (0.02, 0.05)},
        "motors": {"motors": fb.Motor(10.0, 2.0)},
    }[limit]
    problem = problem_of(checked_stops(START, GOAL, None, []), weights={"time": 1.0}, **given)
    guess, (duration,) = first_guess(problem)
    acc = problem.accelerations(guess(np.linspace(0.0, duration, 201)))
    if limit == "acceleration":
        largest = np.linalg.norm(acc.xi_ddot, axis=1).max()
        assert largest == pytest.approx(0.7, rel=2e-3)
        return
    if limit == "torque":
        used = np.abs(fb.inverse_dynamics(acc)) / given["torque"]
    elif limit == "motors":
        used = np.abs(acc.rates.q_dot) / 2.0
    else:
        used = np.abs(acc.rates.q_dot) / given["joint_speed"]
    assert np.quantile(used, 0.95) == pytest.approx(1.0, rel=2e-3)


def test_a_way_round_a_hole_is_about_the_shortest():
    """Round the circle that the left leg cannot come into: two tangents and an arc."""
    robot = fb.FiveBar(0.06, 0.16, 0.09, 0.15, 0.02)
    a, b = np.array([0.01, 0.15]), np.array([-0.02, -0.15])
    problem = problem_of(checked_stops(tuple(a), tuple(b), 2.0, []), robot)
    path = _path(problem, a, b)
    assert len(path) == 101
    assert path[[0, -1]] == pytest.approx(np.array([a, b]), abs=1e-12)
    assert _blocked(problem, path).max() <= 1e-3
    centre = np.array([-robot.d / 2, 0.0])
    square = robot.l11**2 + robot.l12**2 - 2 * robot.l11 * robot.l12 * np.sqrt(1 - 0.05**2)
    radius = np.sqrt(square)
    ends = [np.linalg.norm(each - centre) for each in (a, b)]
    angle = np.arccos((a - centre) @ (b - centre) / np.prod(ends))
    arc = angle - sum(np.arccos(radius / end) for end in ends)
    shortest = radius * arc + sum(np.sqrt(end**2 - square) for end in ends)
    assert 0.99 < length_of(path) / shortest < 1.03
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.max() < 2 * np.median(steps)


def test_a_way_in_a_region_with_a_corner_leads_about_the_corner():
    corner = np.array([0.0, 0.1])
    region = [(-0.08, 0.08), (0.08, 0.08), (0.08, 0.1), (0.0, 0.1), (0.0, 0.16), (-0.08, 0.16)]
    a, b = np.array([0.07, 0.095]), np.array([-0.005, 0.15])
    problem = problem_of(checked_stops(tuple(a), tuple(b), 2.0, []), region=region)
    path = _path(problem, a, b)
    shortest = np.linalg.norm(a - corner) + np.linalg.norm(b - corner)
    assert length_of(path) < 1.04 * shortest
    assert _blocked(problem, path).max() <= 0.02
    straight = _path(problem, a, np.array([-0.06, 0.095]))
    assert length_of(straight) == pytest.approx(0.13, rel=1e-12)


def test_what_blocks_a_point_is_its_worst_limit():
    """In units of the limits; beyond the reach by 1 m, ten times that over a bar's length more."""
    region = [(-0.1, 0.05), (0.1, 0.05), (0.1, 0.13), (-0.1, 0.13)]
    problem = problem_of((({0: START}, 0.0), ({0: GOAL}, 1.0)), UNEQUAL, region=region, det_A=0.4)
    xi = np.random.default_rng(4).uniform((-0.12, 0.02), (0.12, 0.2), (200, 2))
    pose = fb.igm(UNEQUAL, xi, unreachable="nan")
    bar = (UNEQUAL.l12 + UNEQUAL.l22) / 2
    side = np.sign(fb.igm(UNEQUAL, START).det_A)
    inside = np.min([xi[:, 0] + 0.1, 0.1 - xi[:, 0], xi[:, 1] - 0.05, 0.13 - xi[:, 1]], axis=0)
    sines = np.array(pose.sines)
    worst = np.max([0.05 - sines[0], 0.05 - sines[1], 0.4 - side * pose.det_A], axis=0)
    closes = np.isfinite(worst)
    near = closes & (inside > 0)
    assert near.sum() > 50
    expected = np.maximum(worst, -inside / bar)[near]
    assert _blocked(problem, xi)[near] == pytest.approx(expected, abs=1e-12)
    outer = [UNEQUAL.l11 + UNEQUAL.l12, UNEQUAL.l21 + UNEQUAL.l22]
    far = np.array([[0.4, 0.1], [-0.35, 0.2]])
    bases = np.array([[-UNEQUAL.d / 2, 0.0], [UNEQUAL.d / 2, 0.0]])
    gaps = np.linalg.norm(far[:, None] - bases[None], axis=2) - outer
    expected = 2 + 10 * gaps.max(axis=1) / bar
    assert _blocked(problem, far) == pytest.approx(expected, rel=1e-9)
