"""A model-predictive tracker by real-time iteration, usable wherever a controller is."""

from __future__ import annotations

import math
import time
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.checks import jit as must_be_jit
from ..base.checks import modes, optional, positive, whole
from ..base.checks import seconds as span
from ..base.robot_uses import takes_robot
from ..constraints.constraints import Constraints, kept_by
from ..models.loaded_robot import LoadedRobot, refuse_numbers, robot_and_torques
from ..models.motors import torque_bounds
from ..models.physics import loads_of, physics_of, smoothed
from .estimator import EXACT, Estimator
from .fallback import free_of_modes, reference_torques, safe_torque
from .laws import motion_at
from .prediction import CHART, JOINTS, RATES, SIZE, Model
from .qp import QP, Condenser, Status, stage_lengths

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .laws import Reference

ASTRAY = 0.1  # of a bar, by which a prediction may err
FARTHEST = 0.5  # rad that a bar turns in a stage, m that a foot moves
LEAST_STAGES = 3  # that a prediction must reach
# Of the torque's noise, and of the change of the disturbance per sample, in units of the torque
# scale: with exact and with rounded angles. Less noise lets the disturbance follow a wrong mass
# more slowly, more follows the rounding.
TORQUE_NOISE, WALK, WALK_ROUNDED = 3e-3, 3e-3, 3e-4
RATE, ARM = (6.0, 10.0)  # of the torques' change, over their scale; of that, rad/s^2 (m/s^2)
TORQUE_RATE, FORCE_RATE = (100.0, 0.15)  # 1/(N m), 1/N: RATE over that scale, of the lab's robots


class TrackerLog(NamedTuple):
    """A tracker's k steps since its reset.

    t (k,) s; solve_time (k,) s, of the whole step; iterations (k,) of the QP; status (k,), of
    `Status`; disturbance (k, 2) N m, estimated.
    """

    t: np.ndarray
    solve_time: np.ndarray
    iterations: np.ndarray
    status: np.ndarray
    disturbance: np.ndarray


class Tracker:
    """Nonlinear model-predictive tracking of an end-effector motion.

    Call it once each period, as any controller: (t, q, q_dot, reference) -> tau (2,), N m. It reads
    the reference over the horizon ahead. A time that does not increase resets
    it. It makes one Gauss-Newton step per sample, linearised about its last plan in the angles of
    the four bars. These are regular at Type 1 and Type 2, so it goes on through both. Along a plan
    that is free of modes it also follows the elbows. The cost beyond the horizon is that of a
    Riccati equation. A constant disturbance of the torques is estimated and compensated, so there
    is no offset at rest.

    Where the QP fails or its solution is not optimal, the torque is that of computed torque, near
    Type 2 of a PD, clipped. `log` reports the steps.

    Parameters
    ----------
    robot : FiveBar, Biglide or LoadedRobot
        Of a LoadedRobot the torques are part of the prediction, and must be of CasADi's functions.
        Where they change much within a stage, as steep friction does, give a short `seconds`.
    horizon : int
        Stages ahead. The first lasts a period, the others grow so that all cover `seconds`.
    period : float
        Control period, s.
    seconds : float, optional
        Length of the horizon, s. By default 1, less where stages of at most 0.14 s cover less.
    constraints : Constraints, optional
        motors, torque, N m, and joint_speed, rad/s, the last two the same for both joints. The
        speed is kept unless that is impossible.
    delay : int
        Samples between a measurement and its torque, bridged by prediction.
    encoder_resolution : float, optional
        Resolution, rad, to which joint angles are rounded. Rates are then estimated from angles.
    position, acceleration, torque_rate : float
        Weights of residuals, 1/m, s^2/m and 1/(N m). The ratio of the first two is the square of
        the error's bandwidth in 1/s. By default torque_rate is 100, of a biglide 0.15, and of a
        robot with gravity, friction or heavy bars it follows from the inertia.
    assembly : int
        Assembly mode in which the first measurement is read. It is followed by prediction, as at
        Type 2 the joints do not determine it.
    jit : bool or str
        As of `compile`.

    Raises
    ------
    ValueError
        Options make no sense together, or calls are not a period apart.
    SingularityError, UnreachableError
        The first measurement gives no motion.

    Examples
    --------
    >>> import fivebar as fb
    >>> tracker = fb.Tracker(fb.FiveBar(), constraints=fb.Constraints(torque=0.5))
    >>> reference = fb.line((0.09, 0.068), (0.085, 0.072), 0.2)
    >>> run = fb.simulate(fb.FiveBar(), tracker, reference)
    >>> bool(abs(run.error[-1]).max() < 1e-4)
    True
    """

    @takes_robot(
        LoadedRobot,
        horizon=whole(2, 500),
        period=span,
        seconds=optional(span),
        constraints=kept_by("fb.Tracker"),
        delay=whole(0, 1000),
        encoder_resolution=optional(positive),
        position=positive,
        acceleration=positive,
        torque_rate=optional(positive),
        assembly=modes(1),
        jit=must_be_jit,
    )
    def __init__(
        self,
        robot: Robot | LoadedRobot,
        horizon: int = 20,
        period: float = 0.01,
        *,
        seconds: float | None = None,
        constraints: Constraints | None = None,
        delay: int = 0,
        encoder_resolution: float | None = None,
        position: float = 1e4,
        acceleration: float = 10.0,
        torque_rate: float | None = None,
        assembly: int = -1,
        jit: bool | str = False,
    ) -> None:
        self._arguments = {name: value for name, value in locals().items() if name != "self"}
        robot, torques = robot_and_torques(robot)
        refuse_numbers(torques, "a tracker's prediction")
        # Grouped inertias may be negative, but not 0.
        for name, inertia in zip((*robot.words.inertias, "m"), (*robot.inertias, robot.m)):
            positive(abs(inertia), f"a tracker's robot: {name}")
        if torque_rate is None:
            torque_rate = TORQUE_RATE if robot.turns else FORCE_RATE
            if physics_of(robot) is not None and moved(robot):
                torque_rate = RATE / (ARM * moved(robot))
        if seconds is not None and seconds < horizon * period * (1 - 1e-9):
            raise ValueError(
                f"seconds = {seconds:g} is less than horizon = {horizon} periods of {period:g} s"
            )
        self.robot = robot
        self.horizon = horizon
        self.period = period
        self.delay = delay
        self.assembly = assembly
        constraints = Constraints() if constraints is None else constraints
        self.motors = constraints.motors
        torque_limit = _same(constraints.torque, "torque")
        self.torque_limit = np.inf if torque_limit is None else torque_limit
        self.speed_limit = _same(constraints.joint_speed, "joint_speed")
        self.inertia = moved(robot)
        self.scale = ARM * self.inertia  # of the torques among the QP's unknowns
        measured, walk = EXACT, WALK
        if encoder_resolution is not None:
            measured, walk = (encoder_resolution / math.sqrt(12), 1e3), WALK_ROUNDED
        noise = *measured, TORQUE_NOISE * self.scale, walk * self.scale
        self.lengths = stage_lengths(horizon, period, seconds)
        edges = np.concatenate([[0.0], np.cumsum(self.lengths)])
        self.middles = (edges[1:] + edges[:-1]) / 2
        self.ahead = edges + period * delay
        # Where in the last plan a stage's torque is found, a period later.
        self.shift = np.minimum(np.searchsorted(edges, self.middles + period) - 1, horizon - 1)
        try:
            self.condense = Condenser(
                self.lengths, position, acceleration, torque_rate, self.scale, SIZE
            )
        except np.linalg.LinAlgError:
            raise ValueError(
                "the tracker's position, acceleration and torque_rate are too different for one"
                f" cost: {position:g}, {acceleration:g}, {torque_rate:g}"
            ) from None
        # Of a joint speed over its limit, per rad/s: more than tracking errors of the robot's size.
        self.price = sum(self.lengths) / period * (position * max(robot.distal)) ** 2
        n = 2 * horizon
        soft = self.speed_limit is not None
        # A limit on the speed adds one unknown, the excess over it.
        self.qp = QP(n + soft, 2 * n * soft)
        self.high = np.full(n + soft, self.torque_limit / self.scale)
        self.low = -self.high
        self.rows = np.zeros((2 * n * soft, n + soft))
        self.upper = np.zeros(2 * n * soft)
        if soft:
            self.low[-1], self.high[-1] = 0.0, np.inf
            self.rows[:, -1] = -1.0
        self.levers = [drive.length for drive in robot.drives]
        predicted = _differentiable(robot, max(self.lengths))
        self.lift = _lift(robot)
        self.model = Model(predicted, self.lengths, jit, torques)
        self.estimator = Estimator(predicted, period, noise, self.scale, assembly, jit, torques)
        self.reset()

    def __reduce__(self) -> tuple:
        # In another process, a tracker begins anew: its compiled functions stay where they are.
        return partial(type(self), **self._arguments), ()

    def reset(self) -> None:
        """Forget the motion, the disturbance and the log."""
        self.last: float | None = None
        self.estimator.reset()
        self.sent = [np.zeros(2)] * self.delay
        self.tau = np.zeros(2)
        self.guess = None
        self._steps: list[tuple] = []

    @property
    def log(self) -> TrackerLog:
        if not self._steps:
            return TrackerLog._make([np.zeros(0)] * 4 + [np.zeros((0, 2))])
        return TrackerLog._make(np.array(column) for column in zip(*self._steps))

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference
    ) -> np.ndarray:
        before = time.perf_counter()
        if self.last is not None and t <= self.last:
            self.reset()
        iterations, status = 0, Status.NOT_FINITE
        is_known = self._observe(t, q, q_dot)
        self.last = t
        if is_known:
            plan, iterations, status = self._plan(t, reference)
        if status == Status.SOLVED:
            self.tau = self._clip(self.scale * plan[:2])
            self.guess = plan[: 2 * self.horizon].reshape(-1, 2)[self.shift].ravel()
        else:
            known = self.estimator
            call = t, q, q_dot, reference
            safe = safe_torque(self.robot, self.inertia, known.margins, known.assembly, call)
            self.tau = self._clip(safe)
            self.guess = None
        self.sent.append(self.tau)
        elapsed = time.perf_counter() - before
        self._steps.append((t, elapsed, iterations, status, self.estimator.disturbance))
        return self.tau.copy()

    def _observe(self, t, q, q_dot):
        """Bring the estimate to time t. Return whether there is one."""
        if self.last is None:
            self.estimator.locate(q, q_dot)
            return True
        if abs(t - self.last - self.period) > self.period / 2:
            raise ValueError(
                f"a tracker made for a period of {self.period:g} s was called again after"
                f" {t - self.last:g} s"
            )
        return self.estimator.follow(self.last, self.sent.pop(0), q, q_dot)

    def _clip(self, tau):
        """Return the torque within its limit, on it where it differs by rounding error."""
        limit = self.torque_limit
        return np.where(np.abs(tau) >= limit * (1 - 1e-12), np.copysign(limit, tau), tau)

    def _plan(self, t, reference):
        """Return (scaled torques over the horizon, QP iterations, status)."""
        xi, xi_dot, _ = motion_at(reference, t + self.ahead)
        known = self.estimator
        state = known.state
        for k, tau in enumerate(self.sent):
            now = t + k * self.period
            state = self.model.step(state, tau + known.disturbance, now)[0].copy()
        begin = t + self.period * self.delay
        target = np.concatenate([xi, xi_dot], axis=1)
        now = self.model.look(state)[0] - target[0]
        guesses, predicted = [], []
        if self.guess is not None:
            guesses.append(self.guess)
            predicted.append(self._predict(begin, state, self.guess, target))
        astray = max(ASTRAY * min(self.robot.distal), 2 * math.hypot(*now[:2]))
        if not predicted or predicted[0][-1] > astray:
            # The last plan leads astray: the reference's own torques may be the better beginning.
            times = begin + np.append(0.0, self.middles)
            tau = reference_torques(self.robot, known.margins, reference, times)
            limit = min(self.torque_limit, self.scale + self.lift)
            tau = np.clip(tau - known.disturbance, -limit, limit)
            if not self._steps:
                self.tau = tau[0]  # that the drives hold where the motion begins, and not 0
            guesses.append(tau[1:].ravel() / self.scale)
            predicted.append(self._predict(begin, state, guesses[-1], target))
        self.guess, prediction = min(zip(guesses, predicted), key=lambda pair: pair[1][-1])
        states, AB, error, C, ends, _ = prediction
        if ends < LEAST_STAGES:
            return None, 0, Status.NOT_FINITE
        for array in (error, AB, C):
            array[ends:] = 0.0
        arcs = None
        if free_of_modes(reference):
            q = reference.joints(t + self.ahead[1:])[0]
            lengths = self.robot.joint_difference(states[:, JOINTS] - q) * self.levers
            lengths[ends:] = 0.0
            arcs = lengths, JOINTS, np.array([self.levers])
        states[ends:] = 0.0
        if self.motors is not None:
            rates = np.vstack([state[RATES], states[:-1, RATES]])
            limit = self.torque_limit
            low, high = np.clip(torque_bounds(self.motors, rates), -limit, limit) / self.scale
            self.low[: low.size] = low.ravel()
            self.high[: high.size] = high.ravel()
        H, g = self.condense(now, error, AB, C, self.tau / self.scale, self.guess, arcs)
        if self.speed_limit is not None:
            H, g = self._limit_speed(H, g, states[:, RATES])
        return self.qp(H, g, self.rows, self.upper, self.low, self.high)

    def _predict(self, t, state, guess, target):
        """Predict the horizon, which begins at time t.

        Return states, slopes, errors, slopes of the motion, how many stages count, and the largest
        error of these.
        """
        N = self.horizon
        torques = self.scale * guess.reshape(N, 2) + self.estimator.disturbance
        states, AB, motion, C = (array.copy() for array in self.model.rollout(state, torques, t))
        AB = AB.reshape(N, SIZE, SIZE + 2)
        error = motion - target[1:]
        # The midpoint rule does not hold where a bar turns far in a stage, nor after that.
        turns = np.abs(states[:, CHART.size :]).max(axis=1) * self.lengths
        holds = (turns < FARTHEST) & np.isfinite(AB).all(axis=(1, 2))
        ends = int(np.argmin(np.append(holds, False)))
        farthest = np.inf if ends < N else np.hypot(*error[:, :2].T).max()
        return states, AB, error, C.reshape(N, 4, SIZE), ends, farthest

    def _limit_speed(self, H, g, speeds):
        """Add a row per joint, stage and sign, and the price of the excess."""
        n = 2 * self.horizon
        slope = self.condense.G[1:, RATES].reshape(n, n)
        without = speeds.ravel() - slope @ self.guess
        self.rows[:n, :n], self.rows[n:, :n] = slope, -slope
        self.upper[:n], self.upper[n:] = (self.speed_limit - without, self.speed_limit + without)
        wide = np.diag(np.full(n + 1, self.price))
        wide[:n, :n] = H
        return wide, np.append(g, self.price)


def _differentiable(robot, longest):
    """Return the robot with dry friction so smooth that it stops no drive within a stage."""
    loads = loads_of(robot)
    if not loads.sticks:
        return robot
    rates = [fs * longest / z for fs, z in zip(loads.coulomb, robot.inertias)]
    return smoothed(robot, max(rates))


def moved(robot):
    """Return the inertia that a drive moves, kg m^2 (kg)."""
    lever = max(drive.length for drive in robot.drives)
    # Grouped parameters may be negative.
    return sum(map(abs, robot.inertias)) / 2 + abs(robot.m) * lever**2


def _lift(robot):
    """Return a bound of the torque, N m, that weights need away from Type 2."""
    physics = loads_of(robot)
    if not physics.has_gravity:
        return 0.0
    moments = [math.hypot(*pair) for pair in zip(physics.levers, physics.sides)]
    lever = max(drive.length for drive in robot.drives)
    return math.hypot(*physics.gravity) * (max(moments) + robot.m * lever)


def _same(limits, name):
    """Return the limit of both joints; ValueError if they differ."""
    if limits is not None and limits[0] != limits[1]:
        raise ValueError(f"Tracker: {name} must be the same for both joints, not {limits}")
    return limits and limits[0]
