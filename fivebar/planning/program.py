"""One plan's problem on one mesh as a nonlinear program in CasADi, solved by IPOPT."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ..constraints.constraints import at_joints
from ..models.compiled import minimized
from .collocation import LIMITS, Pieces
from .derivatives import Derivatives
from .functions import MotionPoint, refuse_not_finite

if TYPE_CHECKING:
    from .guess import Guess
    from .problem import Problem

MOST_ITERATIONS = 200
# Of the coordinates' units, about a stop: its conditions hold in other poses too, far away.
NEAR_STOP = 0.1
REGULARIZING = 1e-6  # weight of the objective where the violation of limits is minimized


@dataclass(frozen=True, eq=False)
class PlanSolution:
    """A result of IPOPT, solved or not.

    durations: s, of each phase (p,). controls: at all points (n, 2). slack: by what part of its
    unit each of LIMITS was exceeded, where that was allowed.
    """

    pieces: Pieces
    durations: np.ndarray
    controls: np.ndarray
    slack: np.ndarray
    objective: float
    status: str
    iterations: int

    @property
    def solved(self) -> bool:
        return self.status == "Solve_Succeeded"


def solve(
    problem: Problem,
    mesh: list[np.ndarray],
    durations: np.ndarray,
    guess: Guess,
    max_time: float,
    elastic: bool = False,
    iterations: int | None = None,
    near: float = 0.0,
) -> PlanSolution:
    """Solve a problem on one mesh.

    mesh: per phase the knots from 0 to 1.
    durations: s, of the phases in the guess.
    guess: times (n,) -> (n, 3 size + 2) coordinates, their rates and accelerations, controls.
    max_time: s of the processor.
    elastic: instead of the objective, minimize by what parts the limits are exceeded.
    iterations: of IPOPT at most, if not MOST_ITERATIONS.
    near: weight, beside the objective, of the mean square distance from the guess.
    """
    program = NonlinearProgram(problem, mesh, durations, elastic)
    program.keep_motion()
    program.keep_limits()
    program.keep_stops()
    program.keep_functions(durations, guess)
    cost = program.cost()
    if near:
        cost = cost + near * program.distance(durations, guess)
    variables = ca.vertcat(*map(ca.vec, program.variables))
    low, high = program.bounds()
    derivatives = Derivatives(
        program.point,
        program.variables,
        program.at_points,
        program.outputs,
        ca.sum1(program.slack) + REGULARIZING * cost if elastic else cost,
        ca.vertcat(*program.constraints),
    )
    nlp = {"x": variables, "f": derivatives.objective, "g": derivatives.constraints}
    options = derivatives.options | {
        "show_eval_warnings": False,
        "ipopt.max_iter": iterations or MOST_ITERATIONS,
        # IPOPT's processor time is that of all threads.
        "ipopt.max_cpu_time": max(max_time, 1e-3) * threading.active_count(),
        "ipopt.acceptable_iter": 0,
        "ipopt.mu_strategy": "adaptive",
        "ipopt.adaptive_mu_globalization": "kkt-error",  # half the iterations
    }
    result, stats = minimized(
        "plan",
        nlp,
        options,
        x0=program.values(durations, guess),
        lbx=low,
        ubx=high,
        lbg=np.concatenate(program.lower),
        ubg=np.concatenate(program.upper),
    )
    unpack = ca.Function(
        "unpack",
        [variables],
        [*program.variables, derivatives.outputs[1], program.distance(durations, guess)],
    )
    *solution, distance = [matrix.full().T for matrix in unpack(result["x"])]
    objective = (float(result["f"]) - near * distance.item()) * program.cost_unit
    status = stats["return_status"]
    iterations = int(stats["iter_count"])
    pieces, durations, controls, slack = program.in_si(solution)
    return PlanSolution(pieces, durations, controls, slack, objective, status, iterations)


class NonlinearProgram:
    """Variables and constraints on one mesh, scaled to be near 1; vectors of points are columns."""

    def __init__(self, problem, mesh, durations, elastic):
        self.problem = problem
        self.mesh = mesh
        self.elastic = elastic
        self.rule = problem.scheme
        sizes = [len(knots) - 1 for knots in mesh]
        self.first = np.cumsum([0, *sizes])  # interval in which each phase begins
        self.count = count = int(self.first[-1])
        self.length = problem.length
        self.time = float(np.sum(durations))
        self.force = problem.mass * (self.length / self.time**2 + problem.fall)
        self.torque = self.force * problem.lever
        points = count * len(self.rule.c)
        self.coordinates = problem.coordinates
        size = self.coordinates.size
        self.at_knots = [ca.MX.sym(name, size, count + 1) for name in ("c", "c_dot")]
        self.at_points = [ca.MX.sym(name, size, points) for name in ("c_c", "c_dot_c", "c_ddot_c")]
        self.at_points.append(ca.MX.sym("controls", 2, points))
        if problem.own is not None:
            self.at_points.append(ca.MX.sym("t", 1, points))
        self.phases = ca.MX.sym("phases", len(mesh))
        self.slack = ca.MX.sym("slack", len(LIMITS))
        self.variables = [*self.at_knots, *self.at_points, self.phases, self.slack]
        # Durations that are all given are constants: the constraints on the motion are then linear.
        if len(problem.timed) == len(problem.stops):
            phases = ca.MX(ca.DM(np.asarray(durations) / self.time))
        else:
            phases = self.phases
        self.total = ca.sum1(phases)
        widths = ca.MX(ca.DM(np.concatenate([np.diff(knots) for knots in mesh])))
        phase_of = np.repeat(np.arange(len(mesh)), sizes).tolist()
        self.h = (widths * phases[phase_of, 0]).T
        self.point = _point(self)
        self.outputs = [
            ca.MX.sym(f"y{k}", self.point.size1_out(k), points) for k in range(self.point.n_out())
        ]
        (self.dynamics, self.tau, self.sines, self.q_dot, self.xi_ddot, self.kept, *self.own) = (
            self.outputs
        )
        self.constraints = []
        self.lower = []
        self.upper = []

    def keep(self, expression, low=0.0, high=0.0, limit=None):
        """Add low <= expression <= high, numbers or one per row.

        The slack of `limit` softens it if the program is elastic.
        """
        if limit is not None and self.elastic:
            slack = self.slack[LIMITS.index(limit)]
            self.keep(expression - slack, -np.inf, high)
            self.keep(expression + slack, low, np.inf)
            return
        self.constraints.append(ca.vec(expression))
        self.lower.append(np.full(expression.numel(), low))
        self.upper.append(np.full(expression.numel(), high))

    def keep_motion(self):
        """Add continuity between intervals, their polynomials at the points, and the dynamics."""
        xi, xi_dot = self.at_knots
        xi_c, xi_dot_c, xi_ddot_c, *_ = self.at_points
        interval = _interval(self).map(self.count)
        on_xi, on_xi_dot, end, end_dot = interval(xi[:, :-1], xi_dot[:, :-1], self.h, xi_ddot_c)
        self.keep(xi[:, 1:] - end)
        self.keep(xi_dot[:, 1:] - end_dot)
        self.keep(xi_c - on_xi)
        self.keep(xi_dot_c - on_xi_dot)
        self.keep(self.dynamics)

    def keep_functions(self, durations, guess):
        """Add the user's own constraints, and the time at each point; the unit of the own cost."""
        if not self.own:
            return
        # A column for each interval, a row for each of its points.
        starts = ca.cumsum(self.h, 1) - self.h
        places = ca.DM(self.rule.c)
        times = ca.repmat(starts, len(self.rule.c)) + places @ self.h
        self.keep(self.at_points[-1].T - ca.vec(times))
        _, kept = self.own
        if kept.numel():
            self.keep(kept, 0.0, np.inf, "functions")
        nodes = self.rule.nodes(knots_of(self.mesh, durations))
        given = [ca.DM(each.T) for each in self.points_of(nodes, guess)]
        sizes = map(self.point.size_in, range(self.point.n_in()))
        symbols = [ca.SX.sym("z", *size) for size in sizes]
        functions = ca.vertcat(*self.point(*symbols)[-2:])
        slope = ca.Function("slope", symbols, [ca.jacobian(functions, ca.vertcat(*symbols))])
        values = self.point(*given)[-2:]
        refuse_not_finite(self.problem.own, values, slope(*given).full(), nodes)
        mean = float(np.abs(values[0].full()).mean())
        self.own_unit = self.time * (mean or 1.0)

    def keep_limits(self):
        """Add the limits: of polynomials by their Bezier points, so between nodes too."""
        limits = self.problem.constraints
        rule = self.rule
        if limits.sin:
            self.keep(self.sines[:2, :], limits.sin, np.inf, "sin")
        if limits.det_A:
            self.keep(self.sines[2, :], limits.det_A, np.inf, "det_A")
        if limits.torque is not None:
            unit = ca.diag(self.torque / ca.DM(limits.torque))
            share = unit @ self.rows(rule.to_bezier, self.tau)
            self.keep(share, -1.0, 1.0, "torque")
        if limits.motors is not None:
            stall, speed = at_joints(limits.motors)
            unit = ca.diag(self.torque / ca.DM(stall))
            per_speed = ca.diag(1 / (self.time * ca.DM(speed)))
            self.keep(unit @ self.tau + per_speed @ self.q_dot, -1.0, 1.0, "torque")
        if limits.joint_speed is not None:
            unit = ca.diag(1 / (self.time * ca.DM(limits.joint_speed)))
            self.keep(unit @ self.q_dot, -1.0, 1.0, "joint_speed")
        if limits.acceleration is not None:
            unit = self.length / self.time**2 / limits.acceleration
            part = self.rows(rule.to_bezier, self.xi_ddot) * unit
            limit = 1 + self.slack[LIMITS.index("acceleration")]
            self.keep(ca.sum1(part * part) - limit**2, -np.inf)
        if self.kept.numel():
            self.keep(self.kept, 0.0, np.inf, "poses")

    def keep_stops(self):
        """Add accelerations and times of stops; with a weight on jerk, no acceleration jumps.

        Positions and velocities are among the bounds.
        """
        at_start, at_end = self.rule.powers((0.0, 1.0))[0]
        starts = self.rows(at_start[None], self.xi_ddot)
        ends = self.rows(at_end[None], self.xi_ddot)
        units = self.coordinates.units(self.problem)
        for k, (conditions, _) in zip(self.first.tolist(), self.problem.stops):
            for order, rows, value in self.coordinates.at(self.problem, conditions):
                if rows is not None:
                    scaled = ca.DM(value * self.time**order / units)
                    error = self.at_knots[order][:, k] - scaled
                    self.keep(ca.DM(rows * units) @ error)
            if 2 in conditions:
                value = ca.DM(conditions[2]) * self.time**2 / self.length
                if k < self.count:
                    self.keep(starts[:, k] - value)
                if k > 0:
                    self.keep(ends[:, k - 1] - value)
        timed = self.problem.timed
        for (i, before), (j, after) in zip(timed, timed[1:]):
            lasts = ca.sum1(self.phases[i:j])
            self.keep(lasts - (after - before) / self.time)
        if self.problem.weights["jerk"]:
            self.keep(ends[:, :-1] - starts[:, 1:])

    def rows(self, matrix, values):
        """Return matrix (r, s) times the values at the points of each interval, 2 x r count."""
        one = ca.sparsify(ca.DM(matrix.T))
        all_intervals = ca.kron(ca.DM.eye(self.count), one)
        return values @ all_intervals

    def cost(self):
        """Return the weighted objective over its unit; the integrals of squares are exact."""

        def integral(factor, values, h):
            squares = ca.sum1(self.rows(factor @ self.rule.to_power, values) ** 2)
            return ca.dot(squares, ca.reshape(ca.repmat(h, len(factor)), 1, -1))

        terms = {
            "effort": integral(self.rule.square, self.tau, self.h),
            "time": self.total,
            "jerk": integral(self.rule.square_slope, self.xi_ddot, 1 / self.h),
        }
        weights = self.problem.weights
        units = {
            "effort": self.torque**2 * self.time,
            "time": self.time,
            "jerk": self.length**2 / self.time**5,
        }
        self.cost_unit = sum(weights[name] * unit for name, unit in units.items())
        cost = 0.0
        for name, term in terms.items():
            if weights[name]:
                cost += weights[name] * units[name] * term
        if self.own and self.problem.own.costs:
            self.cost_unit += self.own_unit
            quadrature = self.rule.powers(1.0)[1][None]
            cost += self.time * ca.dot(self.rows(quadrature, self.own[0]), self.h)
        return cost / self.cost_unit

    def distance(self, durations, guess):
        """Return the mean square distance of the points from those of a guess, scaled."""
        units = self.coordinates.units(self.problem)
        nodes = self.rule.nodes(knots_of(self.mesh, durations))
        points = guess(nodes)[:, : len(units)]
        difference = self.at_points[0] - ca.DM((points / units).T)
        return ca.sumsqr(difference) / len(points)

    def values(self, durations, guess):
        """Return the guess as one column; n columns of a matrix are n rows here."""
        knots = knots_of(self.mesh, durations)
        at_knots = self.points_of(knots, guess)[:2]
        at_points = self.points_of(self.rule.nodes(knots), guess)
        slack = np.full(len(LIMITS), float(self.elastic))
        parts = *at_knots, *at_points
        return np.concatenate([*map(np.ravel, parts), durations / self.time, slack])

    def points_of(self, t, guess):
        """Return the guess at times t (n,) as the inputs of `point`, (n, ...) each, scaled."""
        own = self.coordinates.units(self.problem)
        control = np.full(2, self.coordinates.control(self))
        units = np.concatenate([own, own / self.time, own / self.time**2, control])
        size = self.coordinates.size
        ends = size, 2 * size, 3 * size
        parts = np.split(guess(t) / units, ends, axis=1)
        return [*parts, t[:, None] / self.time] if self.own else parts

    def bounds(self):
        sides = []
        for sign in (-1, 1):
            shapes = [variable.shape[::-1] for variable in self.variables]
            parts = [np.full(shape, sign * np.inf) for shape in shapes]
            for k, (conditions, _) in zip(self.first, self.problem.stops):
                for order, rows, value in self.coordinates.at(self.problem, conditions):
                    scaled = value * self.time**order / self.coordinates.units(self.problem)
                    width = 0.0
                    if rows is not None:
                        width = NEAR_STOP if order == 0 else np.inf
                    parts[order][k] = scaled + sign * width
            if sign < 0:
                parts[-2][:], parts[-1][:] = 1e-6, 0.0
            elif not self.elastic:
                parts[-1][:] = 0.0
            else:
                # So B stays regular.
                parts[-1][:, LIMITS.index("sin")] = 0.9 * self.problem.constraints.sin
            sides.append(np.concatenate([part.ravel() for part in parts]))
        return sides

    def in_si(self, solution):
        """Return pieces, durations of the phases, controls and slack of a solution."""
        c, c_dot, _, _, c_ddot, controls, *_, phases, slack, tau = solution
        units = self.coordinates.units(self.problem)
        durations = self.time * phases.ravel()
        pieces = Pieces(
            self.rule,
            knots_of(self.mesh, durations),
            units * c[:-1],
            units / self.time * c_dot[:-1],
            (units / self.time**2 * c_ddot).reshape(self.count, -1, len(units)),
            (self.torque * tau).reshape(self.count, -1, 2),
        )
        return (pieces, durations, self.coordinates.control(self) * controls, slack.ravel())


def knots_of(mesh, durations):
    """Return the times of all knots, s."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    times = []
    for start, duration, knots in zip(starts, durations, mesh):
        times.append(start + duration * knots[:-1])
    return np.concatenate([*times, starts[-1:]])


def _interval(program):
    """Return (c, c', h, c'' at the points) -> (c, c' at the points, both at the end), scaled."""
    rule = program.rule
    size = program.coordinates.size
    x = ca.SX.sym("x", size)
    v = ca.SX.sym("v", size)
    h = ca.SX.sym("h")
    a = ca.SX.sym("a", size, len(rule.c))
    places = [*rule.c, 1.0]
    _, single, double = rule.powers(places)
    xs, vs = [], []
    for sigma, once, twice in zip(places, single, double):
        vs.append(v + h * (a @ ca.DM(once)))
        bend = h * (a @ ca.DM(twice))
        xs.append(x + h * (sigma * v + bend))
    end = xs.pop()
    end, end_dot = program.coordinates.at_knot(program, end, vs[-1])
    outputs = [ca.horzcat(*xs), ca.horzcat(*vs[:-1]), end, end_dot]
    return ca.Function("interval", [x, v, h, a], outputs)


def _point(program):
    """Return (c, c', c'', controls) -> residual, tau, sines, q', xi'', clearances, scaled.

    With functions of the user's own also time -> their cost and constraints, SI.
    """
    problem = program.problem
    own = program.coordinates
    length = program.length
    time = program.time
    units = ca.DM(own.units(problem))
    c = [ca.SX.sym(name, own.size) for name in ("c", "c_dot", "c_ddot")]
    controls = ca.SX.sym("controls", 2)
    in_si = [units / time**k * symbol for k, symbol in enumerate(c)]
    residual, tau, acc = own.point(program, in_si, controls)
    pose = acc.rates.pose
    outputs = [
        residual,
        tau / program.torque,
        ca.vertcat(*problem.signed_sines(pose)),
        time * acc.rates.q_dot,
        acc.xi_ddot * (time**2 / length),
        ca.vertcat(*problem.constraints.smooth(pose, length)),
    ]
    inputs = [*c, controls]
    if problem.own is not None:
        t = ca.SX.sym("t")
        inputs.append(t)
        point = MotionPoint.of(time * t, acc, tau, problem.bar_forces(acc, tau))
        outputs += problem.own.function(*point)
    return ca.Function("point", inputs, ca.cse(outputs))
