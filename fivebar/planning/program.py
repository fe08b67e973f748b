"""One plan's problem on one mesh as a nonlinear program in CasADi, solved by IPOPT."""

from __future__ import annotations

import math
import threading
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import block_array, coo_array, eye_array, hstack, kron, vstack

from ..constraints.constraints import at_joints
from ..models.compiled import minimized
from .collocation import LIMITS, Pieces
from .derivatives import differentiated, program_of
from .functions import MotionPoint, refuse_not_finite

if TYPE_CHECKING:
    from .guess import Guess

MOST_ITERATIONS = 100
# Of the coordinates' units, about a stop: its conditions hold in other poses too, far away.
NEAR_STOP = 0.1
REGULARIZING = 1e-6  # weight of the objective where the violation of limits is minimized
# Of the time: the weight of torques at their limits, where many take least time. Motions take up to
# 0.2 % longer by it; a twentieth of it, plans need three times as long or are not found.
CHOOSING = 2e-2


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
    interval: Interval, mesh: list[np.ndarray], durations: np.ndarray, guess: Guess, max_time: float
) -> PlanSolution:
    """Solve a problem on one mesh.

    mesh: per phase the knots from 0 to 1.
    durations: s, of the phases in the guess.
    guess: times (n,) -> (n, 3 size + 2) coordinates, their rates and accelerations, controls.
    max_time: s of the processor.
    """
    program = NonlinearProgram(interval, mesh, durations)
    nlp, derivatives, limits = program.whole()
    options = derivatives | {
        "show_eval_warnings": False,
        "ipopt.max_iter": MOST_ITERATIONS,
        # IPOPT's processor time is that of all threads.
        "ipopt.max_cpu_time": max(max_time, 1e-3) * threading.active_count(),
        "ipopt.acceptable_iter": 0,
        # With smaller pivots, rounding makes minima look like saddles, and IPOPT leaves them.
        "ipopt.mumps_pivtol": 1e-2,
        "ipopt.mu_strategy": "adaptive",
        # Half the iterations of the default, and none of the monotone mode that whips never leave.
        "ipopt.adaptive_mu_globalization": "never-monotone-mode",
    }
    start = {"x0": program.values(guess)} | program.bounds() | limits
    result, stats = minimized("plan", nlp, options, **start)
    pieces, durations, controls, slack = program.in_si(result["x"].full().ravel())
    cost = float(result["f"])
    if interval.elastic:
        cost = (cost - slack.sum()) / REGULARIZING
    objective = cost * interval.cost_unit - interval.choosing * pieces.effort
    status = stats["return_status"]
    iterations = int(stats["iter_count"])
    return PlanSolution(pieces, durations, controls, slack, objective, status, iterations)


class Interval:
    """One interval of the program of a problem, scaled to be near 1. All are alike.

    z: symbols of what it is made of: c, c' at its begin, c'' and controls at its points, slack, its
    width and the time at its begin. kept: what is between `low` and `high`; cost: its objective.

    mesh, durations, guess: the first ones, as of `solve`. elastic: instead of the objective, it is
    minimized by what parts the limits are exceeded.
    """

    def __init__(self, problem, mesh, durations, guess, elastic=False):
        self.problem = problem
        self.elastic = elastic
        self.rule = rule = problem.scheme
        self.coordinates = problem.coordinates
        self.length = problem.length
        # Of the whole motion, or of falling by half of a bar where this is shorter: bars that swing
        # freely are so fast.
        self.time = 1 / math.hypot(1 / np.sum(durations), problem.fall_rate)
        self.force = problem.mass * (self.length / self.time**2 + problem.fall)
        self.torque = self.force * problem.lever
        size = self.coordinates.size
        c, c_dot = ca.SX.sym("c", size), ca.SX.sym("c_dot", size)
        c_ddot = ca.SX.sym("c_ddot", size, len(rule.c))
        controls = ca.SX.sym("controls", 2, len(rule.c))
        self.slack = ca.SX.sym("slack", len(LIMITS))
        self.h = ca.SX.sym("h")
        begin = ca.SX.sym("begin")
        self.z = ca.vertcat(c, c_dot, ca.vec(c_ddot), ca.vec(controls), self.slack, self.h, begin)
        self.point, sizes = _point(self)
        self.nodes = []
        points = []
        for k, sigma in enumerate([*rule.c, 1.0]):
            _, once, twice = map(ca.DM, rule.powers(sigma))
            rate = c_dot + self.h * (c_ddot @ once)
            place = c + self.h * (sigma * c_dot + self.h * (c_ddot @ twice))
            if sigma < 1.0:
                at = ca.vertcat(place, rate, c_ddot[:, k], controls[:, k], begin + self.h * sigma)
                self.nodes.append((self.point, at))
                points.append([ca.SX.sym("y", each) for each in sizes])
        self.nodes.append((_knot(self), ca.vertcat(place, rate)))
        self.end = ca.SX.sym("end", 2 * size)
        self.outputs = [*(ca.vertcat(*each) for each in points), self.end]
        # A column for each point.
        dynamics, self.tau, self.sines, self.q_dot, self.xi_ddot, self.clearances, self.own = (
            ca.horzcat(*each) for each in zip(*points)
        )
        self.choosing = self._choosing()
        own_mean = self._own_mean(rule.nodes(knots_of(mesh, durations)), guess)
        self.cost, self.cost_unit = self._cost(own_mean)
        self.kept = []
        self.low = []
        self.high = []
        self.keep(dynamics)
        self.keep_limits()
        self.functions = self._functions()

    def to(self, stops):
        """Return the interval of the same problem with other stops."""
        other = copy(self)
        other.problem = replace(self.problem, stops=stops)
        return other

    def keep(self, expression, low=0.0, high=0.0, limit=None):
        """Add low <= expression <= high, numbers or one per row.

        The slack of `limit` softens it if the program is elastic.
        """
        if limit is not None and self.elastic:
            slack = self.slack[LIMITS.index(limit)]
            self.keep(expression - slack, -np.inf, high)
            self.keep(expression + slack, low, np.inf)
            return
        self.kept.append(ca.vec(expression))
        self.low.append(np.full(expression.numel(), low))
        self.high.append(np.full(expression.numel(), high))

    def keep_limits(self):
        """Add the limits: of polynomials by their Bezier points, so between nodes too."""
        limits = self.problem.constraints
        to_bezier = ca.DM(self.rule.to_bezier.T)
        if limits.sin:
            self.keep(self.sines[:2, :], limits.sin, np.inf, "sin")
        if limits.det_A:
            self.keep(self.sines[2, :], limits.det_A, np.inf, "det_A")
        if limits.torque is not None:
            unit = ca.diag(self.torque / ca.DM(limits.torque))
            self.keep(unit @ self.tau @ to_bezier, -1.0, 1.0, "torque")
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
            part = self.xi_ddot @ to_bezier * unit
            limit = 1 + self.slack[LIMITS.index("acceleration")]
            self.keep(ca.sum1(part * part) - limit**2, -np.inf)
        self.keep(self.clearances, 0.0, np.inf, "poses")
        self.keep(self.own[1:, :], 0.0, np.inf, "functions")

    def _choosing(self):
        """Return a weight of effort that does not count in the objective.

        Where one motor is as fast as it may be, many torques of the other take as little time, and
        those that are found would leap from point to point.
        """
        limits = self.problem.constraints
        weights = self.problem.weights
        most = limits.torque
        if limits.motors is not None:
            most, _ = at_joints(limits.motors)
        if limits.joint_speed is None or most is None or weights["effort"]:
            return 0.0
        return CHOOSING * weights["time"] / float(np.mean(np.square(most)))

    def _cost(self, own_mean):
        """Return the weighted objective over its unit, and this; integrals of squares are exact."""
        rule = self.rule
        quadrature = rule.powers(1.0)[1]
        weights = self.problem.weights | {"own": float(self.problem.has_own_cost)}
        weights["effort"] += self.choosing
        terms = {
            "effort": self.h * ca.sumsqr(self.tau @ (rule.square @ rule.to_power).T),
            "time": self.h,
            "jerk": ca.sumsqr(self.xi_ddot @ (rule.square_slope @ rule.to_power).T) / self.h,
            "own": self.h * (self.own[:1, :] @ quadrature) / own_mean,
        }
        units = {
            "effort": self.torque**2 * self.time,
            "time": self.time,
            "jerk": self.length**2 / self.time**5,
            "own": self.time * own_mean,
        }
        unit = sum(weights[name] * each for name, each in units.items())
        cost = sum(weights[name] * units[name] * terms[name] for name in terms if weights[name])
        return cost / unit, unit

    def _own_mean(self, nodes, guess):
        """Return the mean size of the user's own cost on the guess; ValueError where not finite."""
        own = self.problem.own
        if own is None:
            return 1.0
        at = np.hstack(self.scaled(nodes, guess)).T
        z = ca.SX.sym("z", len(at))
        functions = self.point(z)[-1 - len(own.constraints) :]
        slope = ca.Function("slope", [z], [functions, ca.jacobian(functions, z)])
        values, slopes = (each.full() for each in slope(at))
        refuse_not_finite(own, values, slopes, nodes)
        return float(np.abs(values[0]).mean()) or 1.0

    def scaled(self, t, guess):
        """Return c, c', c'', controls and time of a guess at times t (n,), (n, ...) each."""
        own = self.coordinates.units(self.problem)
        control = np.full(2, self.coordinates.control(self))
        units = np.concatenate([own, own / self.time, own / self.time**2, control])
        size = self.coordinates.size
        parts = np.split(guess(t) / units, [size, 2 * size, 3 * size], axis=1)
        return [*parts, t[:, None] / self.time]

    def _functions(self):
        """Return functions of the results: end, what is kept, accelerations at both ends, cost."""
        edges = self.xi_ddot @ ca.DM(self.rule.powers((0.0, 1.0))[0].T)
        cost = REGULARIZING * self.cost if self.elastic else self.cost
        result = ca.vertcat(self.end, *self.kept, ca.vec(edges), cost)
        return differentiated(self.z, self.nodes, self.outputs, result)

    @cached_property
    def torques(self):
        """Function z -> torques at the points, SI."""
        values = ca.vertcat(*(function(place) for function, place in self.nodes))
        tau = ca.substitute(self.tau, ca.vertcat(*self.outputs), values)
        return ca.Function("torques", [self.z], [self.torque * tau])


class NonlinearProgram:
    """Variables and constraints on one mesh.

    The variables are c, c' at the knots; c'' and controls at the points of each interval; the
    phases' durations; slack.
    """

    def __init__(self, interval, mesh, durations):
        self.interval = interval
        self.problem = interval.problem
        self.mesh = mesh
        self.durations = durations
        self.first = np.cumsum([0, *(len(knots) - 1 for knots in mesh)])  # interval of each phase
        self.count = int(self.first[-1])
        self.size = interval.coordinates.size
        self.units = interval.coordinates.units(self.problem)
        points = (self.size + 2) * len(interval.rule.c)
        knots = 2 * self.size * (self.count + 1)
        self.lengths = [knots, points * self.count, len(mesh), len(LIMITS)]

    def whole(self):
        """Return program, options with its derivatives, bounds of the constraints, for `nlpsol`."""
        interval = self.interval
        width = interval.functions[0].numel_out(0)
        parts = np.split(np.eye(width), [2 * self.size, width - 5, width - 3, width - 1])
        end, kept, begins, ends, cost = (kron(eye_array(self.count), part, "csr") for part in parts)
        variables = sum(self.lengths)
        slack = np.zeros((1, variables))
        slack[:, -len(LIMITS) :] = interval.elastic
        after = eye_array(len(end.indptr) - 1, variables, k=2 * self.size)
        # Rows by the intervals' results and by the variables, and the value of their sum.
        equal = [(-end, after, np.zeros(end.shape[0])), *self._stops(begins, ends)]
        values = np.concatenate([value for *_, value in equal])
        low, high = (
            np.append(values, np.tile(np.concatenate(each), self.count))
            for each in (interval.low, interval.high)
        )
        rows = [[cost.sum(axis=0)[None], slack], *(row[:2] for row in equal), [kept, None]]
        nlp = program_of(interval.functions, self.inputs(), block_array(rows, format="csr"))
        return *nlp, {"lbg": low, "ubg": high}

    def _stops(self, begins, ends):
        """Return rows, as in `whole`, for times, positions and accelerations of stops.

        With a weight on jerk, no acceleration jumps. Other positions are among the bounds.
        """
        found = []

        def add(value, first, columns):
            linear = np.zeros((len(value), sum(self.lengths)))
            linear[:, first : first + columns.shape[1]] = columns
            found.append((None, linear, value))

        for k, order, rows, value in self._conditions():
            if rows is not None:
                add(rows @ (self.units * value), (2 * k + order) * self.size, rows * self.units)
            if order == 2:
                if k < self.count:
                    found.append((begins[2 * k : 2 * k + 2], None, value))
                if k > 0:
                    found.append((ends[2 * k - 2 : 2 * k], None, value))
        for i, j, lasts in self._given_times():
            # One phase alone is among the bounds: a row without variables would be singular.
            if j > i + 1:
                add(np.array([lasts]), sum(self.lengths[:2]) + i, np.ones((1, j - i)))
        if self.problem.weights["jerk"]:
            jumps = ends[:-2] - begins[2:]
            found.append((jumps, None, np.zeros(jumps.shape[0])))
        return found

    def _conditions(self):
        """Yield (knot, order, rows, scaled value) of all stops, as of `coordinates.at`."""
        time = self.interval.time
        for k, (conditions, _) in zip(self.first.tolist(), self.problem.stops):
            for order, rows, value in self.interval.coordinates.at(self.problem, conditions):
                yield k, order, rows, value * time**order / self.units
            if 2 in conditions:
                yield k, 2, None, np.array(conditions[2]) * time**2 / self.interval.length

    def _given_times(self):
        """Yield (first phase, phase after the last one, scaled duration) where it is given."""
        timed = self.problem.timed
        for (i, before), (j, after) in zip(timed, timed[1:]):
            yield i, j, (after - before) / self.interval.time

    def inputs(self):
        """Return the matrix of all intervals' inputs by the variables."""
        ends = np.cumsum(self.lengths)
        count = self.count
        # Widths of the intervals, and times at their begins, by the durations of the phases.
        widths = block_diag(*(np.diff(knots)[:, None] for knots in self.mesh))
        times = np.stack([widths, np.cumsum(widths, axis=0) - widths], axis=1)
        slack = eye_array(len(LIMITS), ends[-1], k=ends[2])
        before, after = (coo_array((2 * count, n)) for n in (ends[1], len(LIMITS)))
        parts = [
            eye_array(2 * self.size * count, ends[-1]),
            eye_array(self.lengths[1], ends[-1], k=ends[0]),
            kron(np.ones((count, 1)), slack),
            hstack([before, times.reshape(2 * count, -1), after]),
        ]
        first = np.cumsum([0, *(part.shape[0] for part in parts)])
        rows = [np.arange(*each).reshape(count, -1) for each in zip(first, first[1:])]
        return vstack(parts, "csr")[np.hstack(rows).ravel()]

    def values(self, guess):
        """Return a guess as the variables."""
        interval = self.interval
        knots = knots_of(self.mesh, self.durations)
        at_knots = interval.scaled(knots, guess)[:2]
        at_points = interval.scaled(interval.rule.nodes(knots), guess)[2:4]
        inner = np.hstack([each.reshape(self.count, -1) for each in at_points])
        slack = np.full(len(LIMITS), float(interval.elastic))
        parts = np.hstack(at_knots), inner, self.durations / interval.time, slack
        return np.concatenate([*map(np.ravel, parts)])

    def bounds(self):
        """Return the bounds of the variables, for `nlpsol`."""
        sides = {}
        for name, sign in (("lbx", -np.inf), ("ubx", np.inf)):
            knots, points, phases, slack = (np.full(n, sign) for n in self.lengths)
            knots = knots.reshape(-1, 2, self.size)
            for k, order, rows, value in self._conditions():
                if order < 2:
                    width = 0.0 if rows is None else (NEAR_STOP, np.inf)[order]
                    knots[k, order] = value + np.sign(sign) * width
            phases[:] = np.maximum(phases, 1e-6)
            for i, j, lasts in self._given_times():
                if j == i + 1:
                    phases[i] = lasts
            if sign < 0 or not self.interval.elastic:
                slack[:] = 0.0
            else:
                # So B stays regular.
                slack[LIMITS.index("sin")] = 0.9 * self.problem.constraints.sin
            sides[name] = np.concatenate([knots.ravel(), points, phases, slack])
        return sides

    def in_si(self, x):
        """Return pieces, durations of the phases, controls and slack of a solution."""
        interval = self.interval
        knots, points, phases, slack = np.split(x, np.cumsum(self.lengths)[:-1])
        c, c_dot = knots.reshape(-1, 2, self.size)[:-1].swapaxes(0, 1)
        places = self.size * len(interval.rule.c)
        c_ddot, controls = np.split(points.reshape(self.count, -1), [places], axis=1)
        durations = interval.time * phases
        z = (self.inputs() @ x).reshape(self.count, -1).T
        tau = interval.torques.map(self.count)(z).full().T
        pieces = Pieces(
            interval.rule,
            knots_of(self.mesh, durations),
            self.units * c,
            self.units / interval.time * c_dot,
            self.units / interval.time**2 * c_ddot.reshape(self.count, -1, self.size),
            tau.reshape(self.count, -1, 2),
        )
        controls = interval.coordinates.control(interval) * controls.reshape(-1, 2)
        return pieces, durations, controls, slack


def knots_of(mesh, durations):
    """Return the times of all knots, s."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    times = []
    for start, duration, knots in zip(starts, durations, mesh):
        times.append(start + duration * knots[:-1])
    return np.concatenate([*times, starts[-1:]])


def _knot(interval):
    """Return c, c' at the end of an interval -> c, c' at the begin of the next one, scaled."""
    size = interval.coordinates.size
    c = ca.SX.sym("c", 2 * size)
    after = interval.coordinates.at_knot(interval, c[:size], c[size:])
    return ca.Function("knot", [c], [ca.vertcat(*after)])


def _point(interval):
    """Return (c, c', c'', controls, time -> outputs; their sizes), scaled.

    They are residual, tau, sines, q', xi'', clearances; the user's own cost and constraints, SI.
    """
    problem = interval.problem
    coordinates = interval.coordinates
    length = interval.length
    time = interval.time
    units = ca.DM(coordinates.units(problem))
    c = [ca.SX.sym(name, coordinates.size) for name in ("c", "c_dot", "c_ddot")]
    controls = ca.SX.sym("controls", 2)
    t = ca.SX.sym("t")
    in_si = [units / time**k * symbol for k, symbol in enumerate(c)]
    residual, tau, acc = coordinates.point(interval, in_si, controls)
    pose = acc.rates.pose
    outputs = [
        residual,
        tau / interval.torque,
        ca.vertcat(*problem.signed_sines(pose)),
        time * acc.rates.q_dot,
        acc.xi_ddot * (time**2 / length),
        ca.vertcat(*problem.constraints.smooth(pose, length)),
        ca.SX(0),
    ]
    if problem.own is not None:
        point = MotionPoint.of(time * t, acc, tau, problem.bar_forces(acc, tau))
        outputs[-1] = ca.vertcat(*problem.own.function(*point))
    function = ca.Function("point", [ca.vertcat(*c, controls, t)], [ca.vertcat(*outputs)])
    return function, [each.numel() for each in outputs]
