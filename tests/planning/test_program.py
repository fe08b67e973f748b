"""The nonlinear program of a plan: its scaled guess, its cost, and its limits, against SI values."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.collocation import LIMITS, Scheme
from fivebar.planning.coordinates import bars
from fivebar.planning.guess import first_guess
from fivebar.planning.problem import OBJECTIVES, Problem, checked_stops
from fivebar.planning.program import Interval, NonlinearProgram, knots_of, solve

ROBOT = fb.FiveBar(0.09, 0.1, 0.08, 0.11, 0.12)
START, GOAL = (0.05, 0.12), (-0.03, 0.1)
MESH = [np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.5, 0.8, 1.0])]


def problem_of(weights, **limits):
    goal = {0: GOAL, 1: (0.02, -0.01)}
    stops = checked_stops(START, goal, 3.0, [(None, (0.01, 0.13))])
    weights = dict.fromkeys(OBJECTIVES, 0.0) | weights
    constraints = fb.Constraints(**({"sin": 0.05} | limits))
    return Problem(ROBOT, stops, (-1, -1), weights, constraints, Scheme(3))


def program_of(problem, elastic=False):
    guess, durations = first_guess(problem)
    interval = Interval(problem, MESH, durations, guess, elastic)
    return NonlinearProgram(interval, MESH, durations), guess, durations


def parts_of(program, values):
    """Return the variables: c, c' at knots (n, 2, 2); c'' and controls (n, 3, 2); phases; slack."""
    knots, points, phases, slack = np.split(values, np.cumsum(program.lengths)[:-1])
    inner = points.reshape(program.count, 2, 3, 2)
    return knots.reshape(-1, 2, 2), inner[:, 0], inner[:, 1], phases, slack


def at_outputs(interval, expressions, outputs, *given):
    """Return values of expressions of an interval, at random outputs of its points."""
    symbols = ca.vertcat(*interval.outputs)
    function = ca.Function("f", [symbols, interval.h, interval.slack], expressions)
    return [each.full() for each in function.call([outputs, *given])]


def random_outputs(interval, seed):
    """Return outputs of the points of an interval, and torques, sines, rates, accelerations."""
    outputs = np.random.default_rng(seed).normal(size=sum(map(ca.SX.numel, interval.outputs)))
    seen = [interval.tau, interval.sines, interval.q_dot, interval.xi_ddot]
    return outputs, at_outputs(interval, seen, outputs, 1.0, np.zeros(len(LIMITS)))


@pytest.mark.parametrize("elastic", [False, True])
def test_a_guess_is_scaled_by_lengths_times_and_forces(elastic):
    program, guess, durations = program_of(problem_of({"effort": 1.0}), elastic)
    at_knots, bends, _, phases, slack = parts_of(program, program.values(guess))
    knots = knots_of(MESH, durations)
    first, second = durations
    assert knots == pytest.approx(
        [0.0, 0.3 * first, first, first + 0.5 * second, first + 0.8 * second, first + second]
    )
    nodes = np.concatenate([a + (b - a) * Scheme(3).c for a, b in zip(knots, knots[1:])])
    length, time = (0.1 + 0.11) / 2, durations.sum()
    assert at_knots[:, 0] * length == pytest.approx(guess(knots)[:, :2], abs=1e-12)
    assert at_knots[:, 1] * length / time == pytest.approx(guess(knots)[:, 2:4], abs=1e-12)
    own = guess(nodes)[:, 4:6]
    assert bends.reshape(-1, 2) * length / time**2 == pytest.approx(own, abs=1e-12)
    assert phases * time == pytest.approx(durations)
    assert slack == pytest.approx(np.full(len(LIMITS), float(elastic)))
    # What the intervals are made of: begins, and times at them.
    z = (program.inputs() @ program.values(guess)).reshape(program.count, -1)
    assert z[:, :4] == pytest.approx(at_knots[:-1].reshape(-1, 4))
    assert z[:, -2] * time == pytest.approx(np.diff(knots))
    assert z[:, -1] * time == pytest.approx(knots[:-1])


def test_bounds_hold_the_stops_and_the_slack():
    program, guess, durations = program_of(problem_of({"effort": 1.0}))
    low, high = (parts_of(program, side) for side in program.bounds().values())
    length = (0.1 + 0.11) / 2
    for k, point in ((0, START), (2, (0.01, 0.13)), (5, GOAL)):
        assert low[0][k, 0] * length == pytest.approx(point)
        assert high[0][k, 0] * length == pytest.approx(point)
    assert not low[0][0, 1].any() and not high[0][0, 1].any()
    time = durations.sum()
    assert low[0][5, 1] * length / time == pytest.approx((0.02, -0.01))
    assert high[0][5, 1] * length / time == pytest.approx((0.02, -0.01))
    assert np.isinf(low[0][2, 1]).all() and np.isinf(low[0][[1, 3, 4], 0]).all()
    assert (low[-2] == 1e-6).all() and np.isinf(high[-2]).all()
    assert not low[-1].any() and not high[-1].any()
    program, *_ = program_of(program.problem, True)
    low, high = (parts_of(program, side) for side in program.bounds().values())
    assert not low[-1].any() and np.isinf(np.delete(high[-1], LIMITS.index("sin"))).all()


@pytest.mark.parametrize(
    "weights",
    [{"effort": 2.0}, {"time": 3.0}, {"jerk": 0.5}, {"effort": 2.0, "time": 3.0, "jerk": 0.5}],
)
def test_a_cost_is_the_integral_of_its_polynomials(weights):
    """Torques and accelerations are polynomials in each interval, so that their squares are exact."""
    program, *_ = program_of(problem_of(weights))
    interval = program.interval
    outputs, (tau, _, _, xi_ddot) = random_outputs(interval, 1)
    width = 0.3
    given = width / interval.time, np.zeros(len(LIMITS))
    found = float(at_outputs(interval, [interval.cost], outputs, *given)[0].item())
    total = weights.get("time", 0.0) * width
    for torque, acceleration in zip(
        tau * interval.torque, xi_ddot * interval.length / interval.time**2
    ):
        own = dict(domain=[0, 1], window=[0, 1])
        square = np.polynomial.Polynomial.fit(Scheme(3).c, torque, 2, **own)
        bend = np.polynomial.Polynomial.fit(Scheme(3).c, acceleration, 2, **own)
        whole = (square**2).integ()
        total += weights.get("effort", 0.0) * width * (whole(1.0) - whole(0.0))
        whole = (bend.deriv() ** 2).integ()
        total += weights.get("jerk", 0.0) * (whole(1.0) - whole(0.0)) / width
    assert found * interval.cost_unit == pytest.approx(total, rel=1e-9)
    force = program.problem.mass * interval.length / interval.time**2
    assert interval.torque == pytest.approx(force * interval.length)


def test_limits_are_shares_of_their_bounds():
    """Of motors the line through stall torque and largest speed; of torques Bezier points."""
    limits = dict(torque=(0.1, 0.2), joint_speed=(2.0, 3.0), acceleration=0.7, sin=0.05, det_A=0.2)
    interval = program_of(problem_of({"effort": 1.0}, **limits))[0].interval
    outputs, (tau, sines, q_dot, xi_ddot) = random_outputs(interval, 2)
    rest = 1.0, np.zeros(len(LIMITS))
    _, sin, det_A, torque, speed, acceleration, *_ = (
        each.ravel() for each in at_outputs(interval, interval.kept, outputs, *rest)
    )
    assert sin == pytest.approx(sines[:2].T.ravel())
    assert det_A == pytest.approx(sines[2])
    tau = tau * interval.torque
    to_bezier = Scheme(3).to_bezier.T
    assert torque == pytest.approx((tau @ to_bezier / [[0.1], [0.2]]).T.ravel())
    q_dot = q_dot / interval.time
    assert speed == pytest.approx((q_dot / [[2.0], [3.0]]).T.ravel())
    points = xi_ddot * interval.length / interval.time**2 @ to_bezier
    assert acceleration == pytest.approx(((points / 0.7) ** 2).sum(axis=0) - 1)
    for bound, low, high in zip(
        range(1, 6), (0.05, 0.2, -1.0, -1.0, -np.inf), (np.inf, np.inf, 1.0, 1.0, 0.0)
    ):
        assert (interval.low[bound] == low).all() and (interval.high[bound] == high).all()
    motor = problem_of({"effort": 1.0}, motors=fb.Motor(0.4, 5.0))
    interval = program_of(motor)[0].interval
    _, _, share, line, *_ = (
        each.ravel() for each in at_outputs(interval, interval.kept, outputs, *rest)
    )
    assert line == pytest.approx((tau / 0.4 + q_dot / 5.0).T.ravel())
    assert np.abs(share).max() <= np.abs(tau / 0.4).max() * 10


def test_an_elastic_limit_is_exceeded_by_its_slack():
    program, *_ = program_of(problem_of({"effort": 1.0}, joint_speed=2.0), True)
    interval = program.interval
    outputs, (_, _, q_dot, _) = random_outputs(interval, 3)
    slack = np.zeros(len(LIMITS))
    slack[LIMITS.index("joint_speed")] = 0.25
    found = at_outputs(interval, interval.kept, outputs, 1.0, slack)
    above, below, *_ = found[-6:]  # before those of poses and functions
    share = (q_dot / interval.time / 2.0).T.ravel()
    assert above.ravel() == pytest.approx(share - 0.25)
    assert below.ravel() == pytest.approx(share + 0.25)
    assert (interval.high[-6] == 1.0).all() and np.isinf(interval.low[-6]).all()
    assert (interval.low[-5] == -1.0).all() and np.isinf(interval.high[-5]).all()


@pytest.mark.parametrize("elastic", [False, True])
@pytest.mark.parametrize("in_bars", [False, True])
def test_derivatives_are_those_of_casadi(in_bars, elastic):
    """With stops whose accelerations are given, free durations, and all limits."""
    limits = dict(torque=(0.1, 0.2), joint_speed=(2.0, 3.0), acceleration=0.7, det_A=0.2)
    problem = problem_of({"effort": 2.0, "time": 3.0, "jerk": 0.5}, **limits)
    robot = fb.FiveBar(0.09, 0.1, 0.08, 0.11, 0.12, gravity=(0.0, -9.81))
    paths = None
    if in_bars:
        ends = [bars(fb.igm(robot, point, (-1, -1))) for point in (START, GOAL)]
        path = ends[0] + np.linspace(0, 1, 31)[:, None] * (ends[1] - ends[0])
        stops = tuple(({0: end, 1: np.zeros(4)}, t) for end, t in zip(ends, (0.0, None)))
        limits = replace(problem.constraints, sin=None)
        problem = replace(problem, robot=robot, stops=stops, working=None, constraints=limits)
        paths = [path]
    else:
        end = {0: GOAL, 1: (0.0, 0.0), 2: (0.1, 0.2)}
        problem = replace(problem, stops=(*problem.stops[:-1], (end, 3.0)))
    guess, durations = first_guess(problem, paths)
    mesh = MESH[-len(durations) :]
    program = NonlinearProgram(Interval(problem, mesh, durations, guess, elastic), mesh, durations)
    nlp, options, bounds = program.whole()
    x = nlp["x"]
    g = nlp["g"]
    rng = np.random.default_rng(4)
    at = program.values(guess)
    at = at + 0.01 * rng.normal(size=at.shape)
    weights = ca.MX.sym("f"), ca.MX.sym("g", g.numel())
    gamma = weights[0] * nlp["f"] + ca.dot(weights[1], g)
    wanted = [ca.gradient(nlp["f"], x), ca.jacobian(g, x), ca.triu(ca.hessian(gamma, x)[0])]
    values = rng.normal(), rng.normal(size=g.numel())
    wanted = ca.Function("wanted", [x, *weights], wanted)(at, *values)
    found = options["grad_f"](at, [])[1], options["jac_g"](at, [])[1]
    for one, other in zip((*found, options["hess_lag"](at, [], *values)), wanted, strict=True):
        one, other = one.full().reshape(other.shape), other.full()
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-11 * np.abs(other).max())
    assert len(bounds["lbg"]) == len(bounds["ubg"]) == g.numel()


def test_an_elastic_program_exceeds_its_limits_as_little_as_can_be():
    """Of half the mean speed nothing but the mean is asked at the nodes; the cost does not count."""
    duration = 1.0
    q = [fb.igm(ROBOT, point, (-1, -1)).q for point in (START, GOAL)]
    mean = np.abs(q[1] - q[0]) / duration
    weights = dict.fromkeys(OBJECTIVES, 0.0) | {"effort": 1.0}
    limits = fb.Constraints(sin=0.05, joint_speed=mean.max() / 2)
    stops = checked_stops(START, GOAL, duration, [])
    problem = Problem(ROBOT, stops, (-1, -1), weights, limits, Scheme(3))
    guess, durations = first_guess(problem)
    mesh = [np.linspace(0.0, 1.0, 7)]
    interval = Interval(problem, mesh, durations, guess, elastic=True)
    found = solve(interval, mesh, durations, guess, 30.0)
    assert found.solved
    slack = dict(zip(LIMITS, found.slack.ravel()))
    assert 0.95 < slack.pop("joint_speed") < 1.25
    assert max(slack.values()) < 1e-5
