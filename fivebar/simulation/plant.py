"""The robot in motion by steps as long as a tolerance allows."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from functools import lru_cache
from operator import itemgetter

import numpy as np

from ..base.backend import pack
from ..models.charts import BarAngles
from ..models.compiled import Buffered, compiled
from ..models.four_joints import FourJointRates, bars_rates, closed
from ..models.kinematics import Rates
from ..models.loaded_robot import JointTorques, refuse_numbers
from ..models.loads import lost_power
from ..models.parameters import names_of, parameters_of
from ..models.robots import Robot
from .steps import COLUMNS, JOINT_RATES, JOINTS, between, free_step, observation

# Chosen steps in one call of `advance`, a fraction of a second of work: at least, and per second.
MOST_STEPS, MOST_PER_SECOND = 20_000, 2_000
SHORTEST = 1e-11  # s: below, a step is too short to go on
FIRST = 0.01  # s
SLOW = 1e-3  # rad that a bar turns in a step: below, it is not its speed that makes steps short
# How a step's length follows from the last one's error, as usual for a method of order 8.
ORDER = 8
SAFETY = 0.9
SHRINKING = 0.2
GROWTH = 8.0
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact for squares of polynomials of degree 7
STRETCH = 8192  # times that are read from the polynomials at once, so that memory stays small


class Plant:
    """The robot moving by steps of order 8, on the angles of its four bars.

    Parameters
    ----------
    robot : FiveBar or Biglide
    start : Rates
    tolerance : float
        rad, of each step.
    jit : bool or "auto"
    torques : JointTorques, optional
        At the joints, of a LoadedRobot.

    Attributes
    ----------
    t : float
        s, now.
    state : (8,)
        The angles of the bars and their rates, now.
    """

    def __init__(
        self,
        robot: Robot,
        start: Rates,
        tolerance: float,
        jit: bool | str = False,
        torques: JointTorques | None = None,
    ) -> None:
        check_start(robot, start)
        if jit:
            refuse_numbers(torques, "machine code of a step (jit)")
        self.robot = robot
        self.tolerance = tolerance
        self.torques = torques
        self.parameters = np.array(parameters_of(robot))
        self.t, self.length = 0.0, FIRST
        c, c_dot, _ = BarAngles().coordinates(start)
        self.state = np.array([*c, *c_dot])
        self._step = self._function(free_step, jit, torques)
        self._pieces: list[tuple] = []  # (t, length, state, polynomial, tau)

    def _function(self, make, jit, *options):
        """Return one of the compiled functions of `steps` for robots of this kind."""
        names = names_of([self.robot])
        function = fast(make(type(self.robot), names, *options), jit)
        return Buffered(function) if hasattr(function, "buffer") else _unbuffered(function)

    @property
    def moves(self) -> bool:
        """Whether any drive moves."""
        return True

    @property
    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """q and q' now."""
        q = self.state[JOINTS].copy()
        return q, self.state[JOINT_RATES].copy()

    @property
    def rates(self) -> FourJointRates:
        """The motion now, as Rates of floats."""
        return bars_rates(self.robot, self.state[:4].tolist(), self.state[4:].tolist())

    def advance(self, until: float, tau: np.ndarray) -> None:
        """Move on to the time `until`, s, under the torques tau; where that fails, stay."""
        before = self.t, self.state, len(self._pieces)
        try:
            self._advance(until, tau)
        except ArithmeticError:
            self.t, self.state, count = before
            del self._pieces[count:]
            raise

    def _advance(self, until, tau):
        first = len(self._pieces)
        most = MOST_STEPS + int(MOST_PER_SECOND * (until - self.t))
        while self.moves and until - self.t > 1e-12 * (abs(until) + 1e-9):
            rest = until - self.t
            length = self.length
            if rest <= 2 * length:
                length = rest / max(math.ceil(rest / length), 1)
            after, error, polynomial = self._try_step(tau, length)
            error = error.item()
            if error <= 1:
                if len(self._pieces) - first > most:
                    self._refuse(tau, f"{most} steps do not bring it to {until:g} s")
                done = self._keep_step(tau, length, after, polynomial.copy())
                self.t = until if done == rest else self.t + done
                if done == rest and length < self.length and error < 1:
                    # The period's end cut it short: the next may be as long as this could be.
                    continue
            elif length < SHORTEST:
                self._refuse(tau, f"a step of {length:.2g} s is too long")
            if error > 0:
                factor = SAFETY * error ** (-1 / ORDER)
            else:
                factor = GROWTH
            if not math.isfinite(error):
                factor = SHRINKING
            self.length = length * min(max(factor, SHRINKING), GROWTH)

    def _try_step(self, tau, length):
        time = () if self.torques is None else (self.t,)
        known = *self._known, *time
        return self._step(self.state, tau, length, self.tolerance, *known)

    @property
    def _known(self):
        """What else a step depends on."""
        return (self.parameters,)

    def _at_joints(self, t, state, tau):
        """Return the torques at the joints, (2,) N m, where the controller applies tau."""
        if self.torques is None:
            return tau
        return self.torques.at(t, state[JOINTS], state[JOINT_RATES], tau)

    def _keep_step(self, tau, length, after, polynomial):
        """Keep a step; return how much of it was kept, s."""
        self._pieces.append((self.t, length, self.state, polynomial, tau))
        self.state = after.copy()
        return length

    def _refuse(self, tau, why):
        pose = self.rates.pose
        x, y = pose.point
        words = self.robot.words
        margins = *pose.sines, pose.det_A
        sines = ", ".join(f"{sine:.2g}" for sine in margins)
        cause = "is too fast"
        turned = np.abs(self.state[4:]).max() * self.length
        if turned < SLOW < max(map(abs, margins)):
            cause = "is slow, but friction, or a torque of a LoadedRobot, is too stiff or jumps"
        raise ArithmeticError(
            f"the motion at t = {self.t:.9g} s, xi = ({x:.9g}, {y:.9g}) m"
            f" {cause}: {why} (joint rates {self.state[4]:.3g}, {self.state[6]:.3g}"
            f" {words.unit}/s, {words.effort}s {tau[0]:.3g}, {tau[1]:.3g} {words.effort_unit};"
            f" {', '.join(words.sines)} = {sines}; where all three are 0 all bars are parallel)"
        )

    @property
    def pieces(self) -> tuple[np.ndarray, ...]:
        """Times (n,), lengths (n,), states (n, 8), polynomials (n, 7, 8) and torques (n, 2) of the
        steps so far.
        """
        return tuple(np.array(column) for column in zip(*self._pieces))

    def rows(self, t: np.ndarray) -> np.ndarray:
        """Return the observations (n, columns) at times t (n,) up to now."""
        rows = np.empty((len(t), COLUMNS))
        begins, lengths, all_states, all_polynomials, _ = self.pieces
        for part, at, places in _stretches(t, begins, lengths):
            states = all_states[at]
            polynomials = all_polynomials[at]
            columns = between(states, polynomials, places).T.copy()
            free = self._free(states, polynomials)
            _, _, rates = closed(self.robot, tuple(columns[:4]), tuple(columns[4:]), free)
            rows[part] = observation(rates)
        return rows

    def _free(self, states, polynomials):
        """Return per drive which of these steps move it, None: all."""
        return None

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (n,), s, between which is one step each; sines and det A (n, 3) then, their rates.

        Within a step each of them turns once at most.
        """
        times = [piece[0] for piece in self._pieces]
        states = [piece[2] for piece in self._pieces]
        columns = np.array([*states, self.state]).T
        sines, rates = self._margins(tuple(columns))
        return np.array([*times, self.t]), pack(*sines), pack(*rates)

    def margins(self, t: float) -> tuple[tuple, tuple]:
        """Return sin q12, sin q22 and det A at a time, and their rates."""
        k = max(bisect_right(self._pieces, t, key=itemgetter(0)) - 1, 0)
        t0, length, state, polynomial, _ = self._pieces[k]
        place = np.array([(t - t0) / length])
        return self._margins(between(state[None], polynomial[None], place)[0].tolist())

    def _margins(self, state):
        rates = bars_rates(self.robot, state[:4], state[4:])
        return (*rates.pose.sines, rates.pose.det_A), rates.margin_rates

    def friction_loss(self, t: np.ndarray) -> np.ndarray:
        """Return what friction, and torques of a LoadedRobot, have taken until times t, (n,) J.

        It is integrated on the polynomials.
        """
        pieces = self.pieces
        of_steps = self._lost(np.ones(len(pieces[0])), *pieces)
        before = np.concatenate([[0.0], np.cumsum(of_steps)])
        loss = np.empty(len(t))
        for part, at, places in _stretches(t, *pieces[:2]):
            begun = (column[at] for column in pieces)
            loss[part] = before[at] + self._lost(places, *begun)
        return loss

    def _lost(self, places, t0, lengths, states, polynomials, tau):
        """Return what is taken from each step's beginning to a place in it, J."""
        total = 0.0
        for node, weight in zip(GAUSS, WEIGHTS):
            columns = between(states, polynomials, places * (1 + node) / 2).T
            rates = bars_rates(self.robot, tuple(columns[:4]), tuple(columns[4:]))
            power = lost_power(rates)
            if self.torques is not None:
                t = t0 + places * lengths * (1 + node) / 2
                q, q_dot = columns[JOINTS].T, columns[JOINT_RATES].T
                taken = self.torques.taken(t, q, q_dot, tau)
                power = power + (taken * q_dot).sum(axis=1)
            total = total + weight / 2 * power
        return total * places * lengths


def _stretches(t, begins, lengths):
    """Yield slices of t, the numbers of the steps that these times are in, places in these."""
    for first in range(0, len(t), STRETCH):
        part = slice(first, first + STRETCH)
        at = np.clip(np.searchsorted(begins, t[part], side="right") - 1, 0, None)
        yield part, at, (t[part] - begins[at]) / lengths[at]


def fast(function, jit):
    """Return steps, with jit their machine code; with "auto" not before they are used again."""
    if jit == "auto" and not next(_uses(function)):
        return function
    return compiled(function, jit)


@lru_cache(maxsize=64)
def _uses(function):
    """Return how often steps were used, and count on."""
    return itertools.count()


def _unbuffered(step):
    """Return a step of CasADi's numbers with arrays as of `Buffered`."""

    def call(*given):
        after, error, polynomial = step(*given)
        return after.full().ravel(), error.full().ravel(), polynomial.full().T

    return call


def check_start(robot: Robot, start: Rates) -> None:
    """Refuse Rates from which no motion of this robot can begin."""
    if start.pose.robot != robot:
        raise ValueError(f"start is of another robot: {start.pose.robot}, not {robot}")
    if start.q_dot.shape != (2,) or start.xi_dot.shape != (2,):
        raise ValueError("start must be the Rates of a single pose")
    if not any((*robot.inertias, robot.m)):
        raise ValueError("this robot has no inertia, so it cannot be simulated: name its masses")
    rates = np.array([start.xi_dot, start.q_dot])
    if not np.isfinite(rates).all():
        raise ValueError("start must be finite: its pose is unreachable")
