"""Many coarse motions of the four bars at a time, by multiple shooting.

Each is a chain of intervals with constant torques. Gauss and Newton's steps close the gaps between
the intervals and lower the cost, which limits that are broken raise. On the loop's surface the
state has four directions, so that a step of all motions takes milliseconds.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ..models.charts import BarAngles
from ..models.dynamics import forward_dynamics
from ..models.four_joints import bars_pose, bars_rates, closed, closure_columns, gap_rate
from .coordinates import bar_accelerations
from .functions import MotionPoint
from .problem import Problem

STOP = 1e5  # weight of the distance from a stop
BROKEN = 1e2  # weight of the square of a limit's excess, over the cost
FARTHEST = 1.0  # rad or bars that a step may move a node
FAST = 0.35  # rad or bars of an interval, beyond which a motion is too fast for it
# After a step that is taken, damping is divided by EASIER; after one that is not, it is multiplied
# by HARDER. The share of a step that is made changes by HARDER in both cases.
EASIER, HARDER = 1.5, 4.0
RIDGE = 1e-12  # of the diagonal of a matrix that is singular
GAUSS = np.array([0.5 - math.sqrt(3) / 6, 0.5 + math.sqrt(3) / 6])


class Shooting:
    """The functions of a problem, built once for all motions, and its units.

    step: (x, torques, h) -> x at the end, x at both of Gauss's points. slope: (x, torques) -> the
    accelerations' derivatives (4, 10). loop: x -> closure's derivatives by the bars, those of its
    rate. stage: (x, torques, t, h) -> cost, excess of limits, gradient, Hessian.
    """

    def __init__(self, problem: Problem, duration: float) -> None:
        self.problem = problem
        robot = problem.model
        acceleration = 10 * problem.length / duration**2 + problem.fall
        self.torque = problem.mass * acceleration * problem.lever
        time = math.sqrt(problem.length / acceleration)
        units = problem.coordinates.units(problem)
        self.units = np.concatenate([units, units / time])
        x = ca.SX.sym("x", 8)
        torques = ca.SX.sym("torques", 2)
        h = ca.SX.sym("h")
        t = ca.SX.sym("t")
        bars, rates = tuple(ca.vertsplit(x[:4])), tuple(ca.vertsplit(x[4:]))
        motion = forward_dynamics(bars_rates(robot, bars, rates), torques)
        bends = ca.vertcat(*BarAngles().accelerations(motion))
        both = ca.vertcat(x, torques)
        self.slope = _function([x, torques], [ca.densify(ca.jacobian(bends, both))])
        at = _function([x, torques], [ca.vertcat(x[4:], bends)])
        # Runge and Kutta's method of order 4, and its continuous solution of order 3.
        one = at(x, torques)
        two = at(x + h / 2 * one, torques)
        three = at(x + h / 2 * two, torques)
        four = at(x + h * three, torques)
        ends = []
        for s in (1.0, *GAUSS):
            first = s - 3 * s**2 / 2 + 2 * s**3 / 3
            middle = s**2 - 2 * s**3 / 3
            last = 2 * s**3 / 3 - s**2 / 2
            ends.append(x + h * (first * one + middle * (two + three) + last * four))
        self.step = _function([x, torques, h], [_closed(robot, ends[0]), *ends[1:]])
        self.close = _function([x], [_closed(robot, _closed(robot, x))])
        columns = closure_columns(bars_pose(robot, bars))
        rate = ca.vertcat(*gap_rate(columns, rates))
        by_bars = ca.horzcat(*(ca.vertcat(*column) for column in columns))
        self.loop = _function([x], [by_bars, ca.densify(ca.jacobian(rate, x[:4]))])
        self.stage = self._stage(x, torques, t, h, bends, duration)

    def _own_unit(self):
        """Return the mean size of the user's own cost at the first stop, under a unit of torque."""
        problem = self.problem
        count = 8
        bars = np.tile(problem.stops[0][0][0], (count, 1))
        random = np.random.default_rng(0).normal(size=(count, 10))
        motion = np.concatenate(
            [bars, random[:, :4] * self.units[4:], np.zeros((count, 4))], axis=1
        )
        tau = random[:, 8:] * self.torque
        acc = problem.accelerations(motion, problem.model)
        point = MotionPoint.of(np.zeros(count), acc, tau, problem.bar_forces(acc, tau))
        columns = [np.asarray(each).T for each in point[1:]]
        costs = np.abs(problem.own.function(point.t[None], *columns)[0].full())
        return float(np.nanmean(costs)) or 1.0

    def _stage(self, x, torques, t, h, bends, duration):
        """Return the function of an interval's cost in a unit of time, as of the class."""
        problem = self.problem
        acc = bar_accelerations(problem.model, *map(ca.vertsplit, (x[:4], x[4:], bends)))
        weights = problem.weights
        own = problem.own
        residuals = [math.sqrt(weights["effort"]) * torques]
        # For coarse motions, whose accelerations jump, the jerk of a motion that swings once.
        once = math.sqrt(weights["jerk"]) * 2 * math.pi / duration
        residuals.append(once * acc.xi_ddot)
        smooth = ca.SX(0)
        kept = list(problem.margins(acc, torques).values())
        if own is not None:
            point = MotionPoint.of(t, acc, torques, problem.bar_forces(acc, torques))
            smooth, functions = own.function(*point)
            kept.append(functions)
        kept.append(1 - (h * x[4:] / (FAST * self.units[:4])) ** 2)
        excess = ca.fmin(ca.vertcat(*kept), 0)
        accelerations = self.units[4] ** 2 / self.units[0] * problem.length
        self.unit = weights["effort"] * self.torque**2 + weights["time"]
        self.unit += weights["jerk"] * (2 * math.pi / duration * accelerations) ** 2
        if problem.has_own_cost:
            self.unit += self._own_unit()
        both = ca.vertcat(x, torques)
        squares = ca.vertcat(*residuals)
        everything = ca.vertcat(squares, math.sqrt(BROKEN * self.unit) * excess)
        slopes = ca.jacobian(everything, both)
        hessian = 2 * slopes.T @ slopes
        gradient = 2 * slopes.T @ everything
        if problem.has_own_cost:
            bend, slope = ca.hessian(smooth, both)
            hessian += bend
            gradient += slope
        outputs = [ca.sumsqr(squares) + smooth, ca.sumsqr(excess), gradient, hessian]
        return _function([x, torques, t, h], [ca.densify(each) for each in outputs])


def _function(inputs, outputs):
    return ca.Function("f", inputs, outputs, {"cse": True})


def _closed(robot, x):
    bars, rates, _ = closed(robot, tuple(ca.vertsplit(x[:4])), tuple(ca.vertsplit(x[4:])))
    return ca.vertcat(*bars, *rates)


@lru_cache(maxsize=64)  # of about three plans
def _mapped(function, count):
    return function.map(count)


def at_all(function: ca.Function, *inputs: np.ndarray) -> list[np.ndarray]:
    """Return a function's outputs for a batch, (*batch, rows, columns) or (*batch, rows)."""
    shape = inputs[0].shape[:-1]
    buffer: Any
    buffer, run = _mapped(function, math.prod(shape)).buffer()
    given: list[Any] = [np.ascontiguousarray(each) for each in inputs]
    for k, each in enumerate(given):
        buffer.set_arg(k, memoryview(each))
    results = []
    for k in range(function.n_out()):
        rows, columns = function.size_out(k)
        result: Any = np.empty((*shape, columns, rows))  # CasADi's matrices are stored by columns
        buffer.set_res(k, memoryview(result))
        results.append(result.swapaxes(-1, -2) if columns > 1 else result[..., 0, :])
    run()
    return results


class Motions:
    """A batch of k coarse motions, each of n intervals.

    x: the bars and their rates at the nodes (k, n + 1, 8). torques: (k, n, 2). times: of the nodes
    (k, n + 1), s. stops: numbers of the nodes whose bars are given; at the first and the last one
    the bars rest.
    """

    def __init__(self, shooting, x, torques, times, stops):
        self.shooting = shooting
        self.stops = stops
        given = x[:, stops]
        x = at_all(shooting.close, x)[0]
        x[:, stops[1:-1], :4] = given[:, 1:-1, :4]
        x[:, [0, -1]] = given[:, [0, -1]]
        self.x, self.torques, self.times = x, torques, times
        self.h = np.diff(times)
        self.damping = np.ones(len(x))
        self.share = np.ones(len(x))
        self.weights = np.zeros(self.h.shape)  # of gaps, in the merit
        self.values = self._valued(x, torques)
        self.linear = self._linear(np.arange(len(x)))

    @property
    def duration(self) -> np.ndarray:
        return self.times[:, -1]

    @property
    def cost(self) -> np.ndarray:
        """Return the objective (k,), SI, whatever the gaps."""
        time = self.shooting.problem.weights["time"]
        return (self.h * self.values[3]).sum(axis=1) + time * self.duration

    def _valued(self, x, torques):
        """Return ends of the intervals, both inner points, cost, excess, gradients and Hessians."""
        h = self.h[..., None]
        moved = at_all(self.shooting.step, x[:, :-1], torques, h)
        at = self.times[:, :-1, None]
        cost, excess, *derivatives = at_all(self.shooting.stage, x[:, :-1], torques, at, h)
        return *moved, cost[..., 0], excess[..., 0], *derivatives

    def _linear(self, which):
        """Return tangents at the nodes, and matrices of the intervals' ends by their begins."""
        x = self.x[which]
        ends, *inner = (each[which] for each in self.values[:3])
        h = self.h[which][..., None, None]
        eye = np.eye(8)
        rates = []
        to_torques = 0.0
        for place, point in zip(GAUSS, inner):
            slope = at_all(self.shooting.slope, point, self.torques[which])[0]
            rate = np.zeros((*slope.shape[:2], 8, 8))
            rate[..., :4, 4:] = np.eye(4)
            rate[..., 4:, :] = slope[..., :8]
            rates.append(rate)
            left = h * (1 - place) * rate
            kick = np.zeros((*slope.shape[:2], 8, 2))
            kick[..., 4:, :] = h / 2 * slope[..., 8:]
            to_torques = to_torques + (eye + left + left @ left / 2) @ kick
        # Magnus's expansion of order 4, and the series of its exponential.
        one, two = rates
        magnus = h / 2 * (one + two) - h**2 * math.sqrt(3) / 12 * (one @ two - two @ one)
        power = eye + magnus / 4
        for k in (3, 2, 1):
            power = eye + magnus @ power / k
        by_bars, of_rate = at_all(self.shooting.loop, x)
        across = by_bars.swapaxes(-1, -2)
        along = np.linalg.qr(across, mode="complete")[0][..., 2:]
        bend = across @ np.linalg.solve(by_bars @ across, of_rate @ along)
        tangent = np.zeros((*x.shape[:2], 8, 4))
        tangent[..., :4, :2] = along
        tangent[..., 4:, 2:] = along
        back = tangent[:, 1:].swapaxes(-1, -2).copy()
        tangent[..., 4:, :2] = -bend
        gap = (back @ (ends - x[:, 1:])[..., None])[..., 0]
        return [tangent, back @ power @ tangent[:, :-1], back @ to_torques, gap]

    def gaps(self, ends: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return the gaps after the intervals (k, n), scaled."""
        return np.linalg.norm((ends - x[:, 1:]) / self.shooting.units, axis=-1)

    def merit(self) -> np.ndarray:
        """Return the merits (k,), SI: cost, limits and gaps."""
        gaps = self.gaps(self.values[0], self.x)
        return self._merit(self.values, gaps) * self.duration * self.shooting.unit

    @property
    def open(self) -> np.ndarray:
        """Return the sums of the gaps (k,), scaled."""
        return self.gaps(self.values[0], self.x).sum(axis=1)

    @classmethod
    def together(cls, batches: list[Motions]) -> Motions:
        """Return the motions of batches with the same stops as one."""
        columns = zip(*((each.x, each.torques, each.times) for each in batches))
        x, torques, times = map(np.concatenate, columns)
        return cls(batches[0].shooting, x, torques, times, batches[0].stops)

    def _merit(self, values, gaps):
        cost = values[3] / self.shooting.unit + BROKEN * values[4]
        return (self.h * cost).sum(axis=1) / self.duration + (self.weights * gaps).sum(axis=1)

    def improve(self) -> None:
        """Take a step of each motion where it lowers the merit; else make the next one smaller."""
        bend, move, forces = self._step()
        limit = forces * 1.3
        limit += 0.1 * limit.mean(axis=1, keepdims=True)
        self.weights = np.where(self.weights > 5 * limit, 2 * limit, self.weights.clip(min=limit))
        share = self.share[:, None, None]
        x = self.x + share * bend
        x = at_all(self.shooting.close, x)[0]
        inner = self.stops[1:-1]
        x[:, inner, :4] = self.x[:, inner, :4]
        x[:, [0, -1]] = self.x[:, [0, -1]]
        torques = self.torques + share * move
        values = self._valued(x, torques)
        before = self._merit(self.values, self.gaps(self.values[0], self.x))
        after = self._merit(values, self.gaps(values[0], x))
        far = np.abs(share * bend / self.shooting.units)[..., :4].max(axis=(1, 2)) > FARTHEST
        better = (after < before) & ~far
        self.damping *= np.where(better, 1 / EASIER, HARDER)
        self.damping = self.damping.clip(1e-5, 1e4)
        self.share = np.where(better, self.share * HARDER, self.share / HARDER).clip(max=1.0)
        taken = np.flatnonzero(better)
        self.x[taken] = x[taken]
        self.torques[taken] = torques[taken]
        for own, new in zip(self.values, values):
            own[taken] = new[taken]
        if len(taken):
            for own, new in zip(self.linear, self._linear(taken)):
                own[taken] = new

    def _step(self):
        """Return the step of x and of the torques, and sizes of the gaps' multipliers, scaled.

        The linear and quadratic problem is solved from the last node to the first one (Riccati).
        """
        tangent, by_start, by_torques, gap = self.linear
        share = (self.h / self.duration[:, None] / self.shooting.unit)[..., None]
        gradient = share * self.values[5]
        hessian = share[..., None] * self.values[6]
        count, n = self.h.shape
        units = self.shooting.units
        damping = 2 * self.damping / n
        torque_damping = damping[:, None, None] * np.eye(2) / self.shooting.torque**2
        start = tangent[:, :-1]
        back = start.swapaxes(-1, -2)
        # In a tangent, the size of a direction is that of its bars and its rates.
        scaled = tangent / units[:, None]
        metric = scaled.swapaxes(-1, -2) @ scaled
        xx = back @ hessian[..., :8, :8] @ start
        ux = hessian[..., 8:, :8] @ start
        uu = hessian[..., 8:, 8:] + torque_damping[:, None]
        whole = np.block([[xx, ux.swapaxes(-1, -2)], [ux, uu]])
        size, axes = np.linalg.eigh(np.nan_to_num(whole))
        whole = (axes * size.clip(min=1e-9)[..., None, :]) @ axes.swapaxes(-1, -2)
        xx, ux, uu = whole[..., :4, :4], whole[..., 4:, :4], whole[..., 4:, 4:]
        xx = xx + damping[:, None, None, None] * metric[:, :-1]
        gx = (back @ gradient[..., :8, None])[..., 0]
        gu = gradient[..., 8:]
        value = STOP * metric[:, -1]
        force = np.zeros((count, 4))
        values, slopes, gains = [value], [force], []
        for k in range(n - 1, -1, -1):
            on_torques = by_torques[:, k].swapaxes(-1, -2)
            ahead = (force + _times(value, gap[:, k]))[..., None]
            pulled = on_torques @ value
            cross = ux[:, k] + pulled @ by_start[:, k]
            right = np.concatenate([cross, gu[:, k, :, None] + on_torques @ ahead], axis=-1)
            square = uu[:, k] + pulled @ by_torques[:, k]
            try:
                gain = np.linalg.solve(square, right)
            except np.linalg.LinAlgError:  # by rounding, of a motion near which all ends diverge
                gain = np.linalg.solve(square * (1 + RIDGE * np.eye(2)), right)
            # Joseph's form, in which rounding keeps the value positive.
            held = gain[..., :4]
            back_held = held.swapaxes(-1, -2)
            moved = by_start[:, k] - by_torques[:, k] @ held
            mixed = back_held @ ux[:, k]
            value = xx[:, k] + moved.swapaxes(-1, -2) @ value @ moved
            value += back_held @ uu[:, k] @ held - mixed - mixed.swapaxes(-1, -2)
            force = gx[:, k] + (moved.swapaxes(-1, -2) @ ahead)[..., 0]
            force = force - _times(back_held, gu[:, k])
            if k in self.stops[1:-1]:
                value[:, :2, :2] += STOP * metric[:, k, :2, :2]
            values.append(value)
            slopes.append(force)
            gains.append(gain)
        bend = np.zeros((count, n + 1, 4))
        move = np.zeros((count, n, 2))
        forces = np.zeros((count, n))
        z = bend[:, 0]
        for k in range(n):
            gain = gains[-1 - k]
            move[:, k] = -gain[..., 4] - _times(gain[..., :4], z)
            z = _times(by_start[:, k], z) + _times(by_torques[:, k], move[:, k]) + gap[:, k]
            multipliers = slopes[-2 - k] + _times(values[-2 - k], z)
            size = np.linalg.norm(scaled[:, k + 1], axis=1)
            forces[:, k] = np.linalg.norm(multipliers / size, axis=1)
            bend[:, k + 1] = z
        bend[:, -1] = 0.0
        return _times(tangent, bend), move, forces


def _times(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]


def spline(times: np.ndarray, x: np.ndarray) -> CubicHermiteSpline:
    """Return the bars by time through states x (n, 8)."""
    return CubicHermiteSpline(times, x[:, :4], x[:, 4:])
