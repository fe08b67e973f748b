"""The nonlinear program of a plan: its scaled guess, its cost, and its limits, against SI values."""

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.collocation import LIMITS, Scheme
from fivebar.planning.guess import first_guess
from fivebar.planning.problem import OBJECTIVES, Problem, checked_stops
from fivebar.planning.program import NonlinearProgram, knots_of, solve

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
    return NonlinearProgram(problem, MESH, durations, elastic), guess, durations


def parts_of(program, values):
    """The values of the variables, a matrix each with the points in its rows."""
    parts = []
    for variable in program.variables:
        count = variable.numel()
        parts.append(values[:count].reshape(variable.shape[::-1]))
        values = values[count:]
    assert not len(values)
    return parts


@pytest.mark.parametrize("elastic", [False, True])
def test_a_guess_is_scaled_by_lengths_times_and_forces(elastic):
    program, guess, durations = program_of(problem_of({"effort": 1.0}), elastic)
    parts = parts_of(program, program.values(durations, guess))
    knots = knots_of(MESH, durations)
    first, second = durations
    assert knots == pytest.approx(
        [0.0, 0.3 * first, first, first + 0.5 * second, first + 0.8 * second, first + second]
    )
    nodes = np.concatenate([a + (b - a) * Scheme(3).c for a, b in zip(knots, knots[1:])])
    length, time = (0.1 + 0.11) / 2, durations.sum()
    for part, t, order in (
        (0, knots, 0),
        (1, knots, 1),
        (2, nodes, 0),
        (3, nodes, 1),
        (4, nodes, 2),
    ):
        own = guess(t)[:, 2 * order : 2 * order + 2]
        assert parts[part] * length / time**order == pytest.approx(own, abs=1e-12)
    assert parts[-2].ravel() * time == pytest.approx(durations)
    assert parts[-1].ravel() == pytest.approx(np.full(len(LIMITS), float(elastic)))
    distance = ca.Function("d", program.variables, [program.distance(durations, guess)])
    moved = [ca.DM(part.T) for part in parts]
    assert float(distance(*moved)) == pytest.approx(0.0, abs=1e-20)
    moved[2] = moved[2] + 0.1
    assert float(distance(*moved)) == pytest.approx(2 * 0.01)


def test_bounds_hold_the_stops_and_the_slack():
    program, guess, durations = program_of(problem_of({"effort": 1.0}))
    low, high = (parts_of(program, side) for side in program.bounds())
    length = (0.1 + 0.11) / 2
    for k, point in ((0, START), (2, (0.01, 0.13)), (5, GOAL)):
        assert low[0][k] * length == pytest.approx(point)
        assert high[0][k] * length == pytest.approx(point)
    assert not low[1][0].any() and not high[1][0].any()
    time = durations.sum()
    assert low[1][5] * length / time == pytest.approx((0.02, -0.01))
    assert high[1][5] * length / time == pytest.approx((0.02, -0.01))
    assert np.isinf(low[1][2]).all() and np.isinf(low[0][[1, 3, 4]]).all()
    assert (low[-2] == 1e-6).all() and np.isinf(high[-2]).all()
    assert not low[-1].any() and not high[-1].any()
    program = NonlinearProgram(program.problem, MESH, durations, True)
    low, high = (parts_of(program, side) for side in program.bounds())
    assert not low[-1].any() and np.isinf(np.delete(high[-1].ravel(), LIMITS.index("sin"))).all()


@pytest.mark.parametrize(
    "weights",
    [{"effort": 2.0}, {"time": 3.0}, {"jerk": 0.5}, {"effort": 2.0, "time": 3.0, "jerk": 0.5}],
)
def test_a_cost_is_the_integral_of_its_polynomials(weights):
    """Torques and accelerations are polynomials in each interval, so that their squares are exact."""
    program, guess, durations = program_of(problem_of(weights))
    cost = program.cost()
    rng = np.random.default_rng(1)
    values = parts_of(program, program.values(durations, guess))
    outputs = [rng.normal(size=each.shape) for each in program.outputs]
    function = ca.Function("cost", [*program.variables, *program.outputs], [cost])
    found = float(function(*(ca.DM(each.T) for each in values), *map(ca.DM, outputs)))
    tau = outputs[1] * program.torque
    xi_ddot = outputs[4] * program.length / program.time**2
    knots = knots_of(MESH, durations)
    total = 0.0
    for k, (a, b) in enumerate(zip(knots, knots[1:])):
        own = slice(3 * k, 3 * k + 3)
        for torque, acceleration in zip(tau[:, own], xi_ddot[:, own]):
            square = np.polynomial.Polynomial.fit(
                Scheme(3).c, torque, 2, domain=[0, 1], window=[0, 1]
            )
            bend = np.polynomial.Polynomial.fit(
                Scheme(3).c, acceleration, 2, domain=[0, 1], window=[0, 1]
            )
            whole = (square**2).integ()
            total += weights.get("effort", 0.0) * (b - a) * (whole(1.0) - whole(0.0))
            whole = (bend.deriv() ** 2).integ()
            total += weights.get("jerk", 0.0) * (whole(1.0) - whole(0.0)) / (b - a)
    total += weights.get("time", 0.0) * durations.sum()
    assert found * program.cost_unit == pytest.approx(total, rel=1e-9)
    force = program.problem.mass * program.length / program.time**2
    assert program.torque == pytest.approx(force * program.length)


def test_limits_are_shares_of_their_bounds():
    """Of motors the line through stall torque and largest speed; of torques Bezier points."""
    limits = dict(torque=(0.1, 0.2), joint_speed=(2.0, 3.0), acceleration=0.7, sin=0.05, det_A=0.2)
    program, guess, durations = program_of(problem_of({"effort": 1.0}, **limits))
    program.keep_limits()
    values = [ca.DM(each.T) for each in parts_of(program, program.values(durations, guess))]
    rng = np.random.default_rng(2)
    outputs = [rng.normal(size=each.shape) for each in program.outputs]
    function = ca.Function("g", [*program.variables, *program.outputs], program.constraints)
    sin, det_A, torque, speed, acceleration = (
        each.full().ravel() for each in function(*values, *map(ca.DM, outputs))
    )
    assert sin == pytest.approx(outputs[2][:2].T.ravel())
    assert det_A == pytest.approx(outputs[2][2])
    tau = outputs[1] * program.torque
    to_bezier = Scheme(3).to_bezier
    points = np.concatenate([tau[:, 3 * k : 3 * k + 3] @ to_bezier.T for k in range(5)], axis=1)
    assert torque == pytest.approx((points / [[0.1], [0.2]]).T.ravel())
    q_dot = outputs[3] / program.time
    assert speed == pytest.approx((q_dot / [[2.0], [3.0]]).T.ravel())
    xi_ddot = outputs[4] * program.length / program.time**2
    points = np.concatenate([xi_ddot[:, 3 * k : 3 * k + 3] @ to_bezier.T for k in range(5)], axis=1)
    assert acceleration == pytest.approx(((points / 0.7) ** 2).sum(axis=0) - 1)
    for bound, low, high in zip(
        range(5), (0.05, 0.2, -1.0, -1.0, -np.inf), (np.inf, np.inf, 1.0, 1.0, 0.0)
    ):
        assert (program.lower[bound] == low).all() and (program.upper[bound] == high).all()
    program, *_ = program_of(problem_of({"effort": 1.0}, motors=fb.Motor(0.4, 5.0)))
    program.keep_limits()
    function = ca.Function("g", [*program.variables, *program.outputs], program.constraints)
    _, share, line = (each.full().ravel() for each in function(*values, *map(ca.DM, outputs)))
    assert line == pytest.approx((tau / 0.4 + q_dot / 5.0).T.ravel())
    assert np.abs(share).max() <= np.abs(tau / 0.4).max() * 10


def test_an_elastic_limit_is_exceeded_by_its_slack():
    program, guess, durations = program_of(problem_of({"effort": 1.0}, joint_speed=2.0), True)
    program.keep_limits()
    parts = parts_of(program, program.values(durations, guess))
    parts[-1][:, LIMITS.index("joint_speed")] = 0.25
    outputs = [np.full(each.shape, 0.5) for each in program.outputs]
    function = ca.Function("g", [*program.variables, *program.outputs], program.constraints)
    *_, above, below = (
        each.full() for each in function(*(ca.DM(each.T) for each in parts), *map(ca.DM, outputs))
    )
    share = 0.5 / program.time / 2.0
    assert above == pytest.approx(share - 0.25) and below == pytest.approx(share + 0.25)
    assert (program.upper[-2] == 1.0).all() and np.isinf(program.lower[-2]).all()
    assert (program.lower[-1] == -1.0).all() and np.isinf(program.upper[-1]).all()


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
    found = solve(problem, mesh, durations, guess, 30.0, elastic=True)
    assert found.solved
    slack = dict(zip(LIMITS, found.slack.ravel()))
    assert 0.95 < slack.pop("joint_speed") < 1.25
    assert max(slack.values()) < 1e-5
