"""A limit on the jerk: the fastest motion without it, or at the speeds of `eased`, its s(t)
averaged over a while, all slowed down until it fits.

The mean of s over [t - w, t] has s''' = (s''(t) - s''(t - w)) / w, which is finite, and comes to
rest w later. How long w is best is sought. It is not promised that nothing is faster (where the
jerk rules, it takes a fifth longer than the best); the lower bound stays that of the motion without
the limit. The limits are looked at beside all times at which a derivative jumps, at PLACES in
between, and at FEWEST places of the whole motion at least.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

from ...base.errors import SingularityError
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import ikm, ikm2
from .refusals import where
from .solve import TimingError

if TYPE_CHECKING:
    from ..curve import Path
    from .timed_path import TimedPath

PLACES = 7  # between two times at which a derivative jumps
FEWEST = 2000
MARGIN = 1e-5  # of the limits: between those places
SHARES = np.geomspace(0.01, 2.0, 15)  # of the motion's time, near one of which w is sought
STEPS = 7  # of that search
JUMP = 1e-6  # of the largest curvature, that is none


def refuse_kinks(path) -> None:
    """ValueError where the curvature jumps and the motion does not rest; SingularityError is
    `refuse_crossing`'s.
    """
    n = len(path.pieces)
    if n == 1:
        return
    before = np.arange(n - 1)
    after = np.arange(1, n)
    lengths = np.array([piece.length for piece in path.pieces])
    bends = path.on(before, lengths[:-1])[2], path.on(after, np.zeros(n - 1))[2]
    inner = path.on(np.arange(n), lengths / 2)[2]
    largest = max(np.abs(each).max() for each in (*bends, inner))
    rests = np.isin(path.knots[1:-1], [stop.s for stop in path.stops])
    bad = (np.abs(bends[1] - bends[0]).max(axis=1) > JUMP * largest) & ~rests
    if bad.any():
        k = int(np.argmax(bad))
        raise ValueError(
            "time_path: jerk limit needs a path whose curvature does not jump, as it does at "
            f"{where(path, path.knots[k + 1])}: fivebar.path(..., curvature=True) blends corners so"
        )


def refuse_crossing(motion: TimedPath) -> None:
    """SingularityError for a path across Type 2: averaged, it would not keep the crossing
    criterion.
    """
    if motion.crossing.any():
        s = float(motion.s[np.argmax(motion.crossing)])
        raise SingularityError(
            "time_path: jerk limit is not known across Type 2, which the path crosses at"
            f" {where(motion.path, s)}",
            0.0,
        )


def eased(path: Path, jerk: float) -> Path:
    """Return the path with speeds that, kept, take no more than this jerk: in small blends they are
    far below what accelerations allow.
    """
    n = len(path.pieces)
    lengths = np.array([piece.length for piece in path.pieces])
    s = lengths[:, None] * np.linspace(0, 1, PLACES + 2)
    _, tip_s, _, tip_sss = path.drawn.on(np.arange(n)[:, None], s)
    with np.errstate(divide="ignore"):
        rate = np.cbrt(jerk / np.linalg.norm(tip_sss, axis=-1))
    speed = (rate * np.linalg.norm(tip_s, axis=-1)).min(axis=1)
    return replace(path, feed=tuple(np.minimum(path.feed, speed).tolist()))


def smoothed(motions: list[TimedPath], duration: float | None = None) -> TimedPath:
    """Return the fastest of these motions with its jerk limit kept, in `duration` s if it is
    given.
    """
    tried = []
    for motion in motions:
        refuse_crossing(motion)

        def time(w, motion=motion):
            tried.append(_paced(replace(motion, smooth=float(np.exp(w)))))
            return tried[-1].duration

        widths = np.log(SHARES * motion.clock.taken.sum())
        k = int(np.argmin([time(w) for w in widths]))
        ends = widths[max(k - 1, 0)], widths[min(k + 1, len(widths) - 1)]
        minimize_scalar(time, bounds=ends, method="bounded", options={"maxiter": STEPS})
    best = min(tried, key=lambda each: each.duration)
    if duration is None:
        return best
    if duration < best.duration:
        raise TimingError(
            f"time_path: duration = {duration:g} s is less than {best.duration:.6g} s, the least"
            " that was found with this jerk limit",
            0.0,
            False,
        )
    rests = sum(stop.seconds for stop in motion.path.stops)
    return replace(best, pace=best.pace * (duration - rests) / (best.duration - rests))


def _paced(motion):
    """At the pace at which it keeps its limits."""
    turns = (
        np.flatnonzero(np.diff(motion.piece) * motion.x[1:-1]) + 1
    )  # nodes where xi_sss jumps, and it does not rest
    edges = np.union1d(motion.clock.breaks, motion.clock.passed(turns))
    edges = edges[np.append(True, np.diff(edges) > 1e-12)]
    places = max(PLACES, FEWEST // len(edges))
    inside = np.concatenate([[1e-6], np.linspace(0, 1, places + 2)[1:-1], [1 - 1e-6]])
    t = (edges[:-1, None] + np.diff(edges)[:, None] * inside).ravel()
    k, gone, speed, push = motion.clock.along(t)
    jerk = motion.clock.jerk(t)
    place = motion.piece[k], motion.first[k] + gone
    xi, xi_s, xi_ss, _ = motion.path.on(*place)
    _, tip_s, tip_ss, tip_sss = motion.path.drawn.on(*place)
    pose = igm(motion.robot, xi, motion.working)
    v = speed[:, None]
    u = push[:, None]
    j = jerk[:, None]
    rates = ikm(pose, xi_s * v)
    acc = ikm2(rates, xi_ss * v**2 + xi_s * u)
    limits = motion.limits
    feed = np.array(motion.path.feed)[motion.piece[k]]
    tip = np.linalg.norm(tip_s, axis=1) * speed
    tip_ddot = tip_ss * v**2 + tip_s * u
    shares = [1e-9, np.max(tip / np.minimum(feed, limits.speed or np.inf))]
    if limits.joint_speed:
        shares.append(np.max(np.abs(rates.q_dot) / limits.joint_speed))
    if limits.joint_acceleration:
        shares.append(np.sqrt(np.max(np.abs(acc.q_ddot) / limits.joint_acceleration)))
    if limits.acceleration:
        size = np.linalg.norm(tip_ddot, axis=1)
        shares.append(np.sqrt(np.max(size / limits.acceleration)))
    third = tip_sss * v**3 + 3 * tip_ss * v * u + tip_s * j
    shares.append(np.cbrt(np.linalg.norm(third, axis=1).max() / limits.jerk))
    pace = float(max(shares)) * (1 + MARGIN)
    if limits.torque:

        def fits(pace):
            slow = ikm2(ikm(pose, xi_s * v / pace), (xi_ss * v**2 + xi_s * u) / pace**2)
            tau = inverse_dynamics(slow)
            shares = np.abs(tau) / limits.torque
            if limits.stall:
                line = tau / limits.stall + slow.rates.q_dot / limits.no_load
                shares = np.maximum(shares, np.abs(line))
            return (shares <= 1 - MARGIN).all()

        low = pace
        while not fits(pace) and pace < 1e6:
            low = pace
            pace = 1.5 * pace
        while pace > low * (1 + MARGIN):
            middle = np.sqrt(low * pace)
            low, pace = (low, middle) if fits(middle) else (middle, pace)
    return replace(motion, pace=pace)
