"""The robot in motion: by steps of any length that keep a tolerance, or by fixed ones, each of them
checked.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..base.errors import SingularityError
from ..models.charts import BarAngles
from ..models.compiled import Buffered, compiled
from ..models.four_joints import bars_rates, closed
from ..models.loads import lost_power, potential
from ..models.parameters import names_of, parameters_of
from ..models.physics import loads_of, physics_of
from ..models.robots import nearest_equivalent_angle
from .steps import (
    COLUMNS,
    ENERGY,
    MARGIN_RATES,
    MARGINS,
    Q_DOT,
    XI,
    Q,
    between,
    block_function,
    free_step,
    model_functions,
    motion_of,
    observation,
)

MOST_STEPS, MOST_PER_SECOND = (
    20_000,
    2_000,
)  # of steps that are chosen, in one call: a fraction of a second of work
SHORTEST = 1e-11  # s, where nothing else says how short a step may become
FIRST = 0.01  # s
GROWTH, SHRINKING, SAFETY, ORDER = (
    8.0,
    0.2,
    0.9,
    8,
)  # of the steps' length, as usual for this method
# Of the energy that a fixed step turns over: to lose more is a jump, not an integration error.
LOST_ENERGY = 1e-3
ROUNDING = 1e-14  # rad, m: rounding of a joint step, where next to nothing moves
NEAR = 0.3  # a sine: farther from a singularity, a step that loses energy is just too long
# Steps: a chart with a singularity is held to end where its margin would vanish within them.
AHEAD = 1.5
BLOCK = 50  # fixed steps in one compiled call
STRETCH = 8192  # rows that are read from the polynomials at once


class Plant:
    """The state of every pose, the four bars, by steps that keep `tolerance` (rad) each; t, state:
    now.
    """

    def __init__(self, robot, start, tolerance, jit=False):
        check_start(robot, start)
        self.robot, self.tolerance, self.parameters = (
            robot,
            tolerance,
            np.array(parameters_of(robot)),
        )
        self._step = self._call(free_step, jit)
        self.length, self.t = FIRST, 0.0
        c, c_dot, _ = BarAngles().coordinates(start)
        self.state = np.array([*c, *c_dot])
        self._pieces = []  # (t, length, state, polynomial)

    moves = True

    def _call(self, make, jit):
        """One of the compiled functions of `steps` for robots of this kind, with its own arrays."""
        return Buffered(_compiled(make, type(self.robot), names_of([self.robot]), jit))

    @property
    def joints(self):
        """(q, q') now."""
        return self.state[0:3:2].copy(), self.state[4:7:2].copy()

    @property
    def rates(self):
        """The motion now, as Rates of floats."""
        return bars_rates(self.robot, self.state[:4].tolist(), self.state[4:].tolist())

    def advance(self, until, tau):
        """Move on to the time `until`, s, under the torque tau; where that fails, the plant stays
        where it was.
        """
        before = self.t, self.state, len(self._pieces)
        try:
            self._advance(until, tau)
        except ArithmeticError:
            self.t, self.state, count = before
            del self._pieces[count:]
            raise

    def _advance(self, until, tau):
        count, most = len(self._pieces), MOST_STEPS + int(MOST_PER_SECOND * (until - self.t))
        while self.moves and until - self.t > 1e-12 * (abs(until) + 1e-9):
            rest = until - self.t
            length = (
                self.length
                if 2 * self.length < rest
                else rest / max(math.ceil(rest / self.length), 1)
            )
            after, error, polynomial = self._tried(tau, length)
            error = error.item()
            if error <= 1:
                if len(self._pieces) - count > most:
                    self._refuse(tau, f"{most} steps do not bring it to {until:g} s")
                done = self._kept(tau, length, after, polynomial.copy())
                self.t = until if done == rest else self.t + done
                if done == rest and length < self.length and error < 1:
                    # Cut short by the period's end: the next step may be as long as this could have
                    # been.
                    continue
            elif length < SHORTEST:
                self._refuse(tau, f"a step of {length:.2g} s is too long")
            factor = SAFETY * error ** (-1 / ORDER) if error > 0 else GROWTH
            self.length = length * (
                min(max(factor, SHRINKING), GROWTH) if math.isfinite(error) else SHRINKING
            )

    def _tried(self, tau, length):
        return self._step(self.state, tau, length, self.tolerance, self.parameters)

    def _kept(self, tau, length, after, polynomial):
        """Keep a step; how much of it was kept, s."""
        self._pieces.append((self.t, length, self.state, polynomial))
        self.state = after.copy()
        return length

    def _refuse(self, tau, why):
        pose, rates = self.rates.pose, self.state[4:]
        sines = ", ".join(f"{s:.2g}" for s in (*pose.sines, pose.det_A))
        words = self.robot.words
        raise ArithmeticError(
            f"the motion at t = {self.t:.9g} s, xi = ({pose.point[0]:.9g}, {pose.point[1]:.9g}) m"
            f" is too fast: {why} (joint rates {rates[0]:.3g}, {rates[2]:.3g} {words.unit}/s,"
            f" {words.effort}s {tau[0]:.3g}, {tau[1]:.3g} {words.effort_unit};"
            f" {', '.join(words.sines)} = {sines}; where all three are 0 all bars are parallel)"
        )

    @property
    def pieces(self):
        """Times (n,), lengths (n,), states (n, 8) and polynomials (n, 7, 8) of the steps until
        now.
        """
        columns = []
        for k in range(4):
            columns.append(np.array([piece[k] for piece in self._pieces]))
        return tuple(columns)

    def rows(self, t):
        """Observations (n, columns) and states (n, 8) at times t (n,), none of them past."""
        t0, lengths, states, polynomials = self.pieces
        rows, found = np.empty((len(t), COLUMNS)), np.empty((len(t), 8))
        for part, at, places in stretches(t, t0, lengths):
            columns = between(states[at], polynomials[at], places).T.copy()
            free = self._free(states[at], polynomials[at])
            c, c_dot, rates = closed(self.robot, tuple(columns[:4]), tuple(columns[4:]), free)
            rows[part], found[part] = observation(rates), np.stack([*c, *c_dot], axis=-1)
        return rows, found

    def _free(self, states, polynomials):
        """Per drive which of these steps move it, None: all."""
        return None

    def after(self, state, tau, length):
        """The Rates, of floats, `length` s after a state under the torque tau."""
        a = self._step(state, tau, length, self.tolerance, self.parameters)[0].tolist()
        return bars_rates(self.robot, a[:4], a[4:])


def stretches(t, t0, lengths):
    """(slice, steps that its times are in, places in these) of times t (n,): so many that memory
    stays small.
    """
    for first in range(0, len(t), STRETCH):
        part = slice(first, first + STRETCH)
        at = np.clip(np.searchsorted(t0, t[part], side="right") - 1, 0, None)
        yield part, at, (t[part] - t0[at]) / lengths[at]


def margins_after(plant, states, tau, k, length):
    """The sines and det A, and their rates, (3,) each, `length` s after row k of a motion: see
    `crossings`.
    """
    rates = plant.after(states[k], tau[k], length)
    return (*rates.pose.sines, rates.pose.det_A), rates.margin_rates


@lru_cache(maxsize=16)
def _compiled(make, kind, names, jit):
    return compiled(make(kind, names), jit)


class FixedPlant:
    """The same by fixed steps in a chart: `step` s by RK4 or the method of order 8."""

    def __init__(self, robot, start, chart, method, step, jit=False):
        check_start(robot, start)
        refuse_sticking(robot)
        self.robot, self.chart, self.step, self.t, self.k = robot, chart, step, 0.0, 0
        c, c_dot, modes = chart.coordinates(start)
        self.state, self.modes = np.array([*c, *c_dot]), np.array(modes, dtype=float)
        self._block = lambda count: Buffered(
            compiled(block_function(robot, chart, method, step, count), jit)
        )
        self._calls, self._rows, self._states, self._torques = {}, [], [], []
        self._last = model_functions(robot, chart)[1](self.state, self.modes).full().ravel()

    @property
    def joints(self):
        return self._last[Q].copy(), self._last[Q_DOT].copy()

    def advance(self, until, tau):
        steps = round(until / self.step) - self.k
        while steps:
            count = min(steps, BLOCK)
            if count not in self._calls:
                self._calls[count] = self._block(count)
            states, rows, last = self._calls[count](self.state, tau, self.modes)
            states = states.reshape(-1, len(self.state))
            self._states.append(np.vstack([self.state, states[:-1]]))
            self._rows.append(rows.reshape(-1, COLUMNS).copy())
            self._torques += [tau] * count
            if self.chart.wraps:
                last[Q] = nearest_equivalent_angle(self.robot, last[Q], self._last[Q])
            self.state, self._last = states[-1].copy(), last.copy()
            self.k, steps = self.k + count, steps - count
        self.t = until

    def rows(self, t):
        rows = np.vstack([*self._rows, self._last])
        refuse_losses(self.robot, rows, np.array(self._torques), self.chart, self.step)
        return rows, np.vstack([*self._states, self.state])


def check_start(robot, start):
    """Refuse Rates from which no motion of this robot can begin."""
    if start.pose.robot != robot:
        raise ValueError(f"start is of another robot: {start.pose.robot}, not {robot}")
    if start.q_dot.shape != (2,) or start.xi_dot.shape != (2,):
        raise ValueError("start must be the Rates of a single pose")
    if not (np.isfinite(start.xi_dot).all() and np.isfinite(start.q_dot).all()):
        raise ValueError("start must be finite: its pose is unreachable")


def refuse_sticking(robot):
    """Raise where fixed steps would jump what the robot does."""
    if loads_of(robot).sticks:
        names = " and ".join(name for name in ("fs1", "fs2") if name in robot.parameters)
        raise ValueError(
            f"{names}: dry friction sticks and lets go between fixed steps; simulate(...) with"
            " neither method= nor chart= chooses its steps so that they end there"
        )


def refuse_losses(robot, rows, tau, chart, step):
    """Raise at the first fixed step that lost energy, or in which a chart with a singularity
    ends.
    """
    work = np.sum(np.diff(robot.continuous(rows[:, Q]), axis=0) * tau, axis=1)
    gained, turned = np.diff(rows[:, ENERGY]), rows[1:, ENERGY] + rows[:-1, ENERGY] + np.abs(work)
    if physics_of(robot) is not None:
        seen = motion_of(robot, rows)
        high, power = (
            potential(seen.pose) + 0.0 * rows[:, ENERGY],
            lost_power(seen) + 0.0 * rows[:, ENERGY],
        )
        lost = step * (power[1:] + power[:-1]) / 2
        gained, turned = gained + np.diff(high) + lost, turned + np.abs(np.diff(high)) + lost
    bad = ~(np.abs(gained - work) <= LOST_ENERGY * turned + ROUNDING * np.abs(tau).sum(axis=1))
    columns = list(chart.margins)
    margins = rows[:-1, MARGINS][:, columns]
    bad |= (margins * (margins + AHEAD * step * rows[:-1, MARGIN_RATES][:, columns]) <= 0).any(
        axis=1
    )
    if not bad.any():
        return
    k = int(np.argmax(bad))
    sines, (x, y), when, words = rows[k, MARGINS], rows[k, XI], k * step, robot.words
    nearest = min(columns, key=lambda column: abs(sines[column]), default=None)
    if nearest is None or abs(sines[nearest]) > NEAR:
        raise ArithmeticError(
            f"the motion at t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m is too fast for steps of"
            f" {step:g} s (joint rates {rows[k, 2]:.3g}, {rows[k, 3]:.3g} {words.unit}/s,"
            f" {words.effort}s {tau[k, 0]:.3g}, {tau[k, 1]:.3g} {words.effort_unit}); without"
            " method= the steps choose their own length"
        )
    raise SingularityError(
        f"the step from t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m jumps the singularity of the"
        f" {chart.name} "
        f'chart ({words.sines[nearest]} = {sines[nearest]:.3g}): chart="auto" has none',
        float(sines[nearest]),
    )
