"""Whether a trajectory of the end-effector can be followed: reach, singularities, and how it meets
the first one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from ..base.backend import EPS, check_modes
from ..base.checks import instance, not_negative, optional, shown, takes
from ..base.checks import robot as must_be_robot
from ..base.representation import one_line
from ..models.dyads import cross, dot
from ..models.geometry import Pose, igm, task_pose
from ..models.kinematics import Rates
from ..models.robots import Biglide, FiveBar
from ..singularities.criterion import force_at, largest_force
from ..singularities.locus import divided
from ..singularities.margins import Singularity
from .constraints import ON_POSES, Constraints, refuse_others
from .violations import Broken, broken

SAMPLES = 2049
TOUCH = 1e-9  # a sine as small as this counts as 0, as in `singularity`
TOUCH_REACH = 32 * EPS  # a square of a sine, whose rounding error is of this size
# Of the largest inertial force: a path that does not tell its own error is given at least so
# exactly.
EXACT = 1e-6


@dataclass(frozen=True, eq=False)
class PathCheck:
    """What `check_path` found.

    reachable: the whole path is in the workspace; singularity_free: reachable, and no pose on it is
        singular;
    leaves: the time at which it leaves the workspace, s, or None; time: of the first singular pose,
        s, or None;
    pose: that pose; type: its Singularity (leaving is Type 1); touching: the margin is 0 there
        without changing sign;
    criterion: t_s . m xi'' in N at a Type-2 pose, t_s = u_12 turned by +90 degrees (A t_s = 0),
    None elsewhere (of a robot with gravity or heavy bars t_s . the whole force that the motion asks
    for there, `models.loads`), and criterion_holds whether it is 0, as exactly as the path is
    given, so that the torque stays finite; min_margin: the smallest |sin q_i2| (of a biglide |sin
    phi_i|) or |sin(phi2 - phi1)| on the path, as far as it is reachable, and min_margin_time;
    broken: of what was to be kept, what is not: its name, the time, by how much at most and when.
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

    def __repr__(self) -> str:
        words = [f"leaves the workspace at {self.leaves:.6g} s"] if self.leaves is not None else []
        if self.time not in (None, self.leaves):
            met = "touches" if self.touching else "meets"
            torque = {None: "", True: " with finite torque", False: ", where its torque diverges"}[
                self.criterion_holds
            ]
            words.append(f"{met} Type {int(self.type)} at {self.time:.6g} s{torque}")
        words += ["free of singularities"] if self.singularity_free else []
        words += [f"breaks {each.what} from {each.time:.6g} s" for each in self.broken]
        return one_line(
            "PathCheck",
            *words,
            f"least margin {self.min_margin:.3g} at {self.min_margin_time:.6g} s",
        )


@takes(
    robot=must_be_robot,
    tolerance=optional(not_negative),
    constraints=optional(instance(Constraints)),
)
def check_path(
    robot: FiveBar | Biglide,
    path: Callable,
    working: ArrayLike = (-1, -1),
    tolerance: float | None = None,
    constraints: Constraints | None = None,
) -> PathCheck:
    """Check a trajectory in one working mode: PathCheck.

    path: t -> (xi, xi_dot, xi_ddot), t (n,) s from path.start (0 if it has none) for path.duration
        s, each (n, 2).
    working: (2,), +1 or -1. tolerance: share of the largest inertial force on the path up to which
    the criterion counts as 0; by default the path's own `error`, at least 1e-6. A plan has one: its
    bars carry the inertial force but for a defect of this share, and at the crossing, where they
    can give nothing along t_s, t_s . m xi'' is all defect.
    constraints: what each pose must keep, as far as the path is reachable.
    A margin is a smooth function of time of which 2049 samples are taken with its rate, more where
    it may reach 0 between them; then its zeros are found to rounding, double ones as zeros of the
    rate.
    Crossing criterion: Briot and Arakelian 2008. ValueError for a path that is not one, or is not
    finite at a time, which it names.
    """
    refuse_others(constraints, "check_path", ON_POSES)
    tolerance = max(EXACT, float(getattr(path, "error", 0.0))) if tolerance is None else tolerance
    path = _finite(path)
    start, stop, largest = _times(path)
    working = check_modes(working, "working")
    if working.shape != (2,):
        raise ValueError(f"working must have shape (2,), not {working.shape}")
    modes = tuple(int(m) for m in working)

    legs = zip(robot.drives, robot.distal)
    reaches = [
        _reach(path, drive, bar, *limit) for drive, bar in legs for limit in drive.limits(bar)
    ]
    t = np.linspace(start, stop, SAMPLES)
    found = [list(_zeros(reach, t, TOUCH_REACH, limit=True)) for reach in reaches]
    leaving = min(
        (zero.time for zeros in found for zero in zeros if not zero.touching), default=None
    )
    end = stop if leaving is None else leaving
    if end > start:
        inner = np.linspace(start, end, SAMPLES)
        parallel = _parallel(robot, path, modes)
        found.append(list(_zeros(parallel, inner, TOUCH)))
    first = min((zeros[0] for zeros in found if zeros), key=lambda zero: zero.time, default=None)
    margin, margin_time = _smallest(robot, path, modes, start, end) if end > start else (0.0, start)
    out = (
        broken(robot, path, modes, constraints, np.linspace(start, end, SAMPLES))
        if constraints and end > start
        else ()
    )
    if first is None:
        return PathCheck(
            True,
            True,
            None,
            None,
            None,
            Singularity.NONE,
            False,
            None,
            None,
            margin,
            margin_time,
            out,
        )
    kind = Singularity.NONE
    for k, zeros in enumerate(found):
        if zeros and zeros[0].time - first.time <= 1e-9 * (stop - start):
            kind |= Singularity.PARALLEL if k == len(reaches) else Singularity.SERIAL
    pose = _pose_at(robot, path, modes, first.time)
    criterion = holds = None
    if kind & Singularity.PARALLEL:
        criterion = float(
            cross(
                pose.u2[0], force_at(pose, *(each[0] for each in path(np.array([first.time]))[1:]))
            )
        )
        holds = bool(abs(criterion) <= tolerance * largest_force(robot, path, modes, largest))
    return PathCheck(
        leaving is None,
        False,
        leaving,
        first.time,
        pose,
        kind,
        first.touching,
        criterion,
        holds,
        0.0,
        first.time,
        out,
    )


def _pose_at(robot, path, modes, time):
    for steps in (0, 2, 8, 32):  # the limit of reach may be rounded to beyond it
        xi = path(np.array([time - steps * EPS * max(abs(time), path.duration)]))[0][0]
        pose = igm(robot, xi, modes, unreachable="nan")
        if np.isfinite(pose.q).all():
            break
    return pose


@dataclass(frozen=True)
class _Zero:
    time: float
    touching: bool


def _reach(path, drive, bar, limit, outer):
    """t -> (margin, rate) of one limit of a leg's reach: differences of squares, smooth through the
    limit.
    """
    scale = max(abs(distance) for distance, _ in drive.limits(bar)) ** 2
    sign = -1 if outer else 1

    def margin(t):
        xi, velocity, _ = path(t)
        x, y = drive.apart(xi[:, 0], xi[:, 1])
        value = sign * (x * x + y * y - limit * limit) / scale
        return value, sign * 2 * (x * velocity[:, 0] + y * velocity[:, 1]) / scale

    return margin


def _parallel(robot, path, modes):
    """t -> (margin, rate) of det A = sin(phi2 - phi1), nan where the path is out of reach."""

    def margin(t):
        xi, velocity, _ = path(t)
        pose = task_pose(robot, (xi[:, 0], xi[:, 1]), modes)
        velocity = velocity[:, 0], velocity[:, 1]
        # At the limit of reach the bars turn infinitely fast: the rate there only has to have a
        # sign.
        b = [np.where(b == 0, np.finfo(float).tiny ** 0.5, b) for b in pose.b]
        q_dot = tuple(dot(u, velocity) / each for u, each in zip(pose.u2, b))
        return cross(*pose.u2), Rates(pose, q_dot, velocity).margin_rates[2]

    return margin


def _zeros(margin: Callable, t: np.ndarray, touch: float, limit: bool = False) -> Iterator[_Zero]:
    """The zeros of a margin on the samples t and between them, in order, up to the first that it
    passes.

    limit: below 0 there is nothing, so that a start there, or on 0 and then downwards, is a
        passage.
    """
    value, rate = margin(t)
    for _ in range(3):
        counts = np.where(_near(t, value, rate), 8, 1)
        if counts.sum() > 4 * SAMPLES * 8:
            break
        t = divided(t, counts)
        value, rate = margin(t)
    known = np.isfinite(value)
    t, value, rate = t[known], value[known], rate[known]
    if len(t) == 0:
        return
    at = np.abs(value) <= touch
    if limit and (value[~at][:1] < 0).any():
        yield _Zero(float(t[0]), False)
        return
    low, high = value[:-1], value[1:]
    apart = ~(at[:-1] | at[1:])
    turning = (low * rate[:-1] < 0) & (high * rate[1:] > 0) & _near(t, value, rate)
    passing = apart & ((low * high < 0) | turning)
    arriving = at & ~np.append(False, at[:-1])
    for i in np.flatnonzero(np.append(passing, False) | arriving):
        first, last = i, i + 1
        if at[i]:
            last = i + int(np.argmin(np.append(at[i:], False)))
            if i == 0:  # it starts there
                yield _Zero(float(t[0]), True)
                continue
            if last == len(t):
                yield _Zero(float(t[i + np.argmin(np.abs(value[i:]))]), True)
                continue
            first = i - 1
        zero = _zero_between(margin, t[first], t[last], value[first], value[last], touch)
        if zero:
            yield zero
            if not zero.touching:
                return


def _near(t, value, rate):
    """Between which samples the margin may reach 0, as fast as it changes there."""
    value, rate = np.abs(value), np.abs(rate)
    return np.minimum(value[1:], value[:-1]) < np.diff(t) * np.maximum(rate[1:], rate[:-1])


def _zero_between(margin, a, b, at_a, at_b, touch):
    """The first zero between two samples, of which the margin has another sign or a minimum of its
    size.
    """
    if np.sign(at_a) == np.sign(at_b):
        rate_a, rate_b = margin(np.array([a, b]))[1]
        lowest = (
            _root(lambda t: margin(t)[1], a, b, rate_a, rate_b)
            if rate_a * rate_b < 0
            else (a + b) / 2
        )
        value = margin(np.array([lowest]))[0][0]
        if abs(value) <= touch:
            return _Zero(lowest, True)
        if np.sign(value) == np.sign(at_a):
            return None
        b, at_b = lowest, value
    time = _root(lambda t: margin(t)[0], a, b, at_a, at_b)
    # Else it jumps: a leg of equal bars passes its base joint.
    return _Zero(time, False) if abs(margin(np.array([time]))[0][0]) < 1e-6 else None


def _root(f, a, b, at_a, at_b):
    """A zero of f in [a, b], at whose ends it is known with opposite signs."""

    def margin(s):
        if s in (a, b):  # alone, a time is rounded otherwise than in the batch that saw the signs
            return at_a if s == a else at_b
        value = f(np.array([s]))[0]
        return (
            0.0 if np.isnan(value) else value
        )  # a leg folded on its base joint: its sine is a zero there

    return float(brentq(margin, a, b, xtol=1e-300, maxiter=500))


def _smallest(robot, path, modes, start, end):
    """The smallest of both |sin q_i2| (|sin phi_i|) and |det A| on [start, end], and its time."""

    def margins(t):
        xi = path(t)[0]
        pose = task_pose(robot, (xi[:, 0], xi[:, 1]), modes)
        return np.abs(np.stack([*pose.sines, pose.det_A]))

    t = np.linspace(start, end, SAMPLES)
    values = margins(t)
    found = []
    for k, each in enumerate(values):
        i = int(np.nanargmin(each))
        found.append((float(each[i]), float(t[i])))
        around = t[max(i - 1, 0)], t[min(i + 1, SAMPLES - 1)]
        refined = minimize_scalar(lambda s, k=k: margins(np.array([s]))[k, 0], bounds=around)
        if np.isfinite(refined.fun):
            found.append((float(refined.fun), float(refined.x)))
    return min(found)


def _finite(path):
    """The path, which raises a ValueError where it is asked at a time and does not answer with
    finite numbers.
    """
    if not callable(path) or not hasattr(path, "duration"):
        raise ValueError(
            f"path must be callable, t -> (xi, xi_dot, xi_ddot), with a duration, not {shown(path)}"
        )

    def motion(t):
        answer = tuple(np.asarray(value) for value in path(t))
        if len(answer) != 3 or any(value.shape != (len(t), 2) for value in answer):
            raise ValueError(
                "path: for times (n,) it must give xi, xi_dot and xi_ddot, each (n, 2)"
            )
        for name, value in zip(("xi", "xi_dot", "xi_ddot"), answer):
            if not np.isfinite(value).all():
                k = int(np.argmin(np.isfinite(value).all(axis=1)))
                raise ValueError(
                    f"path: at t = {t[k]:.12g} s its {name} is {value[k].tolist()}, not finite"
                )
        return answer

    motion.start, motion.duration = getattr(path, "start", 0.0), path.duration
    return motion


def _times(path):
    """When the path starts and stops, s, and its largest acceleration, m/s^2."""
    start, duration = float(path.start), float(path.duration)
    if not (math.isfinite(start) and math.isfinite(duration) and duration > 0):
        raise ValueError(
            f"path: its start and duration must be finite and the duration > 0, not {start},"
            f" {duration}"
        )
    largest = np.linalg.norm(path(np.linspace(start, start + duration, SAMPLES))[2], axis=1).max()
    return start, start + duration, largest
