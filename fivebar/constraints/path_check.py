"""Check a trajectory of the end-effector: reach, singularities, crossing criterion, constraints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from ..base.backend import EPS, check_modes
from ..base.checks import not_negative, optional, shown
from ..base.representation import one_line
from ..base.robot_uses import takes_robot
from ..models.dyads import cross, dot
from ..models.geometry import Pose, igm, task_pose
from ..models.kinematics import Rates
from ..models.robots import Biglide, FiveBar
from ..singularities.criterion import force_at, largest_force
from ..singularities.degenerate import EVERYWHERE, singular_everywhere
from ..singularities.locus import divided
from ..singularities.margins import Singularity
from .constraints import Constraints, kept_by
from .violations import Broken, broken

SAMPLES = 2049
TOUCH = 1e-9  # a sine as small as this counts as 0, as in `singularity`
TOUCH_REACH = 32 * EPS  # a square of a sine, whose rounding error is of this size
# Of the largest inertial force: a path that does not tell its own error is given at least so
# exactly.
EXACT = 1e-6


@dataclass(frozen=True, eq=False)
class PathCheck:
    """The result of `check_path`.

    Attributes
    ----------
    reachable : bool
        The whole path is in the workspace.
    singularity_free : bool
        It is reachable, and no pose on it is singular.
    leaves : float or None
        Time, s, at which it leaves the workspace.
    time : float or None
        Time, s, of the first singular pose.
    pose : Pose or None
        That pose.
    type : Singularity
        Its type. Leaving the workspace is Type 1.
    touching : bool
        The margin is 0 there without changing its sign.
    criterion : float or None
        t_s . m xi'', N, at a pose of Type 2, where A t_s = 0. With gravity or heavy bars it is
        t_s . the whole force that the motion needs.
    criterion_holds : bool or None
        The criterion is 0, as exactly as the path is known, so the torque stays finite.
    min_margin, min_margin_time : float
        Smallest |sin q_i2| (of a biglide |sin phi_i|) or |sin(phi2 - phi1)| on the reachable part,
        and its time, s.
    everywhere : bool
        All poses of these working modes are singular, as those of a robot whose legs are equal and
        in one place.
    broken : tuple of Broken
        Violated constraints: name, time, largest violation and its time.
    """

    reachable: bool
    singularity_free: bool
    leaves: float | None
    time: float | None
    pose: Pose | None
    type: Singularity
    touching: bool
    criterion: float | None
    criterion_holds: bool | None
    min_margin: float
    min_margin_time: float
    broken: tuple[Broken, ...] = ()
    everywhere: bool = False

    def __repr__(self) -> str:
        words = []
        if self.leaves is not None:
            words.append(f"leaves the workspace at {self.leaves:.6g} s")
        if self.everywhere:
            words.append(EVERYWHERE)
        elif self.time not in (None, self.leaves):
            verb = "touches" if self.touching else "meets"
            words.append(f"{verb} Type {int(self.type)} at {self.time:.6g} s")
        if self.criterion_holds is not None:
            words.append("finite torque" if self.criterion_holds else "torque diverges")
        if self.singularity_free:
            words.append("free of singularities")
        for one in self.broken:
            words.append(f"breaks {one.what} from {one.time:.6g} s")
        margin = f"{self.min_margin:.3g} at {self.min_margin_time:.6g} s"
        words.append(f"least margin {margin}")
        return one_line("PathCheck", *words)


@takes_robot(tolerance=optional(not_negative), constraints=kept_by("fb.check_path"))
def check_path(
    robot: FiveBar | Biglide,
    path: Callable,
    working: ArrayLike | None = None,
    tolerance: float | None = None,
    constraints: Constraints | None = None,
) -> PathCheck:
    """Check whether a trajectory can be followed in one working mode.

    A margin is a smooth function of time. It is sampled 2049 times with its rate, more densely
    where it may reach 0 between samples. Its zeros are found to rounding error, double ones as
    zeros of the rate.

    Parameters
    ----------
    robot : FiveBar, Biglide or Machine
        Of a Machine, or of the name or file of one, the path is that of its tool in its measuring
        frame, and its constraints on poses are checked, too.
    path : callable
        t (n,) s -> (xi, xi_dot, xi_ddot), each (n, 2), from path.start (default 0) for
        path.duration s.
    working : (2,), optional
        Working modes, +1 or -1. By default those of a plan, else (-1, -1).
    tolerance : float, optional
        Share of the largest inertial force on the path up to which the criterion counts as 0. By
        default it is the path's own `error`, at least 1e-6.
    constraints : Constraints, optional
        Constraints on poses, checked as far as the path is reachable.

    Returns
    -------
    PathCheck

    Raises
    ------
    ValueError
        The path is not callable or not finite; the message names the time. Or it is a plan between
        Poses, that may pass several modes, and none are given.

    References
    ----------
    Briot, Arakelian: Optimal force generation in parallel manipulators for passing through the
    singular positions, IJRR 2008.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.check_path(fb.FiveBar(), fb.line((0.05, 0.09), (0.09, 0.07), 1.0)).singularity_free
    True
    """
    if tolerance is None:
        tolerance = max(EXACT, float(getattr(path, "error", 0.0)))
    if working is None:
        working = getattr(path, "working", (-1, -1))
        if working is None:
            raise ValueError(
                "check_path: this plan is free of modes, and a path is checked in one pair: name"
                " working, or read plan.accelerations(t).rates.pose.sines and .det_A"
            )
    path = _finite(path)
    start, stop, largest = _times(path)
    working = check_modes(working, "working")
    if working.shape != (2,):
        raise ValueError(f"working must have shape (2,), not {working.shape}")
    modes = int(working[0]), int(working[1])

    reaches = []
    for leg in (0, 1):
        drive = robot.drives[leg]
        bar = robot.distal[leg]
        reaches += [_reach(path, drive, bar, *limit) for limit in drive.limits(bar)]
    t = np.linspace(start, stop, SAMPLES)
    zeros = [list(_zeros(reach, t, TOUCH_REACH, limit=True)) for reach in reaches]
    passages = [zero.time for some in zeros for zero in some if not zero.touching]
    leaving = min(passages, default=None)
    end = stop if leaving is None else leaving
    margin = 0.0
    margin_time = start
    violated = ()
    if end > start:
        inner = np.linspace(start, end, SAMPLES)
        zeros.append(list(_zeros(_parallel(robot, path, modes), inner, TOUCH)))
        margin, margin_time = _smallest(robot, path, modes, inner)
        if constraints:
            violated = broken(robot, path, modes, constraints, inner)
    firsts = []
    for some in zeros:
        firsts += some[:1]
    first = min(firsts, key=lambda zero: zero.time, default=None)
    if first is None:
        return PathCheck(
            reachable=True,
            singularity_free=True,
            leaves=None,
            time=None,
            pose=None,
            type=Singularity.NONE,
            touching=False,
            criterion=None,
            criterion_holds=None,
            min_margin=margin,
            min_margin_time=margin_time,
            broken=violated,
        )
    kind = Singularity.NONE
    for k, some in enumerate(zeros):
        if not some or some[0].time - first.time > 1e-9 * (stop - start):
            continue
        if k == len(reaches):
            kind |= Singularity.PARALLEL
        else:
            kind |= Singularity.SERIAL
    pose = _pose_at(robot, path, modes, first.time)
    criterion = None
    holds = None
    everywhere = singular_everywhere(robot, modes)
    if kind & Singularity.PARALLEL and not everywhere:
        _, velocity, acceleration = path(np.array([first.time]))
        force = force_at(pose, velocity[0], acceleration[0])
        criterion = float(cross(pose.u2[0], force))
        allowed = tolerance * largest_force(robot, path, modes, largest)
        holds = bool(abs(criterion) <= allowed)
    return PathCheck(
        reachable=leaving is None,
        singularity_free=False,
        leaves=leaving,
        time=first.time,
        pose=pose,
        type=kind,
        touching=first.touching,
        criterion=criterion,
        criterion_holds=holds,
        min_margin=0.0,
        min_margin_time=first.time,
        broken=violated,
        everywhere=everywhere,
    )


def _pose_at(robot, path, modes, time):
    rounding = EPS * max(abs(time), path.duration)
    for steps in (0, 2, 8, 32):  # the limit of reach may be rounded to beyond it
        before = np.array([time - steps * rounding])
        (xi,), _, _ = path(before)
        pose = igm(robot, xi, modes, unreachable="nan")
        if np.isfinite(pose.q).all():
            break
    return pose


@dataclass(frozen=True)
class _Zero:
    time: float
    touching: bool


def _reach(path, drive, bar, limit, outer):
    """Return t -> (margin, rate) of one limit of a leg's reach.

    The margin is a difference of squares, so it is smooth through the limit.
    """
    farthest = max(abs(distance) for distance, _ in drive.limits(bar))
    scale = farthest**2
    sign = -1 if outer else 1

    def margin(t):
        xi, velocity, _ = path(t)
        x, y = xi.T
        x, y = drive.apart(x, y)
        excess = x * x + y * y - limit * limit
        value = sign * excess / scale
        vx, vy = velocity.T
        approach = x * vx + y * vy
        return value, sign * 2 * approach / scale

    return margin


def _parallel(robot, path, modes):
    """Return t -> (margin, rate) of det A = sin(phi2 - phi1), nan out of reach."""

    def margin(t):
        xi, velocity, _ = path(t)
        pose = task_pose(robot, (xi[:, 0], xi[:, 1]), modes)
        velocity = velocity[:, 0], velocity[:, 1]
        # At the limit of reach the bars turn infinitely fast: the rate there only has to have a
        # sign.
        b = [np.where(b == 0, np.finfo(float).tiny ** 0.5, b) for b in pose.b]
        along = (dot(u, velocity) for u in pose.u2)
        q_dot = tuple(speed / each for speed, each in zip(along, b))
        return cross(*pose.u2), Rates(pose, q_dot, velocity).margin_rates[2]

    return margin


def _zeros(margin: Callable, t: np.ndarray, touch: float, limit: bool = False) -> Iterator[_Zero]:
    """Yield the zeros of a margin in order, up to the first that it passes.

    limit: the margin ends at 0, so a start below 0, or on 0 and then downwards, is a passage.
    """
    value, rate = margin(t)
    for _ in range(3):
        counts = np.where(_near(t, value, rate), 8, 1)
        if counts.sum() > 4 * SAMPLES * 8:
            break
        t = divided(t, counts)
        value, rate = margin(t)
    known = np.isfinite(value)
    t = t[known]
    value = value[known]
    rate = rate[known]
    if len(t) == 0:
        return
    at = np.abs(value) <= touch
    if limit and (value[~at][:1] < 0).any():
        yield _Zero(float(t[0]), False)
        return
    low = value[:-1]
    high = value[1:]
    off_zero = ~(at[:-1] | at[1:])
    towards = low * rate[:-1] < 0
    away = high * rate[1:] > 0
    turning = towards & away & _near(t, value, rate)
    passing = off_zero & ((low * high < 0) | turning)
    arriving = at & ~np.append(False, at[:-1])
    for i in np.flatnonzero(np.append(passing, False) | arriving):
        first = i
        last = i + 1
        if at[i]:
            still_at = np.append(at[i:], False)
            last = i + int(np.argmin(still_at))
            if i == 0:  # it starts there
                yield _Zero(float(t[0]), True)
                continue
            if last == len(t):
                nearest = i + np.argmin(np.abs(value[i:]))
                yield _Zero(float(t[nearest]), True)
                continue
            first = i - 1
        zero = _zero_between(margin, t[first], t[last], value[first], value[last], touch)
        if zero:
            yield zero
            if not zero.touching:
                return


def _near(t, value, rate):
    """Return between which samples the margin may reach 0, as fast as it changes there."""
    value = np.abs(value)
    rate = np.abs(rate)
    nearest = np.minimum(value[1:], value[:-1])
    fastest = np.maximum(rate[1:], rate[:-1])
    return nearest < np.diff(t) * fastest


def _zero_between(margin, a, b, at_a, at_b, touch):
    """Return the first zero between two samples; None if there is none.

    The margin has different signs there, or a minimum between them.
    """
    if np.sign(at_a) == np.sign(at_b):
        rate_a, rate_b = margin(np.array([a, b]))[1]
        lowest = (a + b) / 2
        if rate_a * rate_b < 0:
            lowest = _root(lambda t: margin(t)[1], a, b, rate_a, rate_b)
        value = margin(np.array([lowest]))[0][0]
        if abs(value) <= touch:
            return _Zero(lowest, True)
        if np.sign(value) == np.sign(at_a):
            return None
        b = lowest
        at_b = value
    time = _root(lambda t: margin(t)[0], a, b, at_a, at_b)
    # Else it jumps: a leg of equal bars passes its base joint.
    (value,), _ = margin(np.array([time]))
    if abs(value) < 1e-6:
        return _Zero(time, False)
    return None


def _root(f, a, b, at_a, at_b):
    """Return a zero of f in [a, b], whose values at both ends have opposite signs."""

    def margin(s):
        # A single time is rounded otherwise than in the batch that saw the signs.
        if s == a:
            return at_a
        if s == b:
            return at_b
        value = f(np.array([s]))[0]
        # nan: a leg folded on its base joint, where its sine is 0.
        return 0.0 if np.isnan(value) else value

    return float(brentq(margin, a, b, xtol=1e-300, maxiter=500))


def _smallest(robot, path, modes, t):
    """Return the smallest |sin q_i2| (|sin phi_i|) or |det A| from t[0] to t[-1], and its time."""

    def margins(t):
        xi = path(t)[0]
        x, y = xi.T
        pose = task_pose(robot, (x, y), modes)
        return np.abs(np.stack([*pose.sines, pose.det_A]))

    minima = []
    for k, values in enumerate(margins(t)):
        i = int(np.nanargmin(values))
        minima.append((float(values[i]), float(t[i])))
        before = t[max(i - 1, 0)]
        after = t[min(i + 1, SAMPLES - 1)]
        refined = minimize_scalar(
            lambda s, k=k: margins(np.array([s]))[k, 0], bounds=(before, after)
        )
        if np.isfinite(refined.fun):
            minima.append((float(refined.fun), float(refined.x)))
    return min(minima)


def _finite(path):
    """Return the path with a check that its values are finite; ValueError if it is no path."""
    if not callable(path) or not hasattr(path, "duration"):
        raise ValueError(
            f"path must be callable, t -> (xi, xi_dot, xi_ddot), with a duration, not {shown(path)}"
        )

    def motion(t):
        values = tuple(np.asarray(value) for value in path(t))
        if [value.shape for value in values] != 3 * [(len(t), 2)]:
            raise ValueError(
                "path: for times (n,) it must give xi, xi_dot and xi_ddot, each (n, 2)"
            )
        for name, value in zip(("xi", "xi_dot", "xi_ddot"), values):
            finite = np.isfinite(value).all(axis=1)
            if not finite.all():
                k = int(np.argmin(finite))
                found = value[k].tolist()
                raise ValueError(f"path: at t = {t[k]:.12g} s its {name} is {found}, not finite")
        return values

    motion.start = getattr(path, "start", 0.0)
    motion.duration = path.duration
    return motion


def _times(path):
    """Return when the path starts and stops, s, and its largest acceleration, m/s^2."""
    start = float(path.start)
    duration = float(path.duration)
    if not (math.isfinite(start) and math.isfinite(duration) and duration > 0):
        raise ValueError(
            f"path: its start and duration must be finite and the duration > 0, not {start},"
            f" {duration}"
        )
    stop = start + duration
    _, _, acceleration = path(np.linspace(start, stop, SAMPLES))
    return start, stop, np.linalg.norm(acceleration, axis=1).max()
