"""A limit on the jerk: s(t) of the fastest motion without it, averaged over a while.

The mean of s over [t - w, t] has s''' = (s''(t) - s''(t - w)) / w, which is finite, and comes to
rest w later. The w with which a straight path is fastest is sought. The mean passes small blends
faster than the motion itself, so that is slowed down on each piece where too much is asked for,
again and again. What is left is met by a slower pace of the whole. All this is done with the limits
as they are, and with less of them, as `enough` says; the faster motion is kept. Straight ways with
rests at their ends take 0.3 % longer than S-curves. It is not promised that nothing is faster: with
tiny blends it may take longer than with rests at the corners. The lower bound stays that without
the limit. The limits are looked at beside all times at which a derivative jumps, at PLACES in
between, and at FEWEST places of the whole motion at least.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ...base.errors import SingularityError
from ...base.progress import progress
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import Accelerations, ikm, ikm2
from ...models.pose import Pose
from .refusals import where
from .solve import TimingError

if TYPE_CHECKING:
    from ..curve import Path
    from .constraint_rows import Limits
    from .timed_path import TimedPath

PLACES = 7  # between two times at which a derivative jumps
FEWEST = 2000
MARGIN = 1e-5  # of the limits: between those places
SHORTEST = 0.01  # of the longest w, or
SHARE = 0.1  # of the mean time between dips: the least w that is looked at
WIDTHS = 15  # near one of which w is sought
STEPS = 7  # of that search
ROUNDS = 8  # in which pieces are slowed down
ALIKE = 0.05  # of w
STEP = 2.0  # by which at most they are at once
NEAR = 0.01  # of the pace, to which they are
JUMP = 1e-6  # of the largest curvature, or of one over the length, that is none


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
    largest = max(1 / path.length, *(np.abs(each).max() for each in (*bends, inner)))
    rests = np.isin(path.knots[1:-1], [stop.s for stop in path.stops])
    bad = (np.abs(bends[1] - bends[0]).max(axis=1) > JUMP * largest) & ~rests
    if bad.any():
        k = int(np.argmax(bad))
        raise ValueError(
            "time_path: jerk limit needs a path whose curvature does not jump, as it does at "
            f"{where(path, path.knots[k + 1])}: with a deviation fivebar.path(..., curvature=True)"
            " and `fivebar draw` blend corners so"
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


def eased(path: Path, jerk: float) -> np.ndarray:
    """Return speeds on the pieces of a path, m/s, that, kept, take no more than this jerk: in small
    blends they are far below what accelerations allow.
    """
    n = len(path.pieces)
    lengths = np.array([piece.length for piece in path.pieces])
    s = lengths[:, None] * np.linspace(0, 1, PLACES + 2)
    _, tip_s, _, tip_sss = path.drawn.on(np.arange(n)[:, None], s)
    with np.errstate(divide="ignore"):
        rate = np.cbrt(jerk / np.linalg.norm(tip_sss, axis=-1))
    speed = (rate * np.linalg.norm(tip_s, axis=-1)).min(axis=1)
    return np.minimum(path.feed, speed)


def enough(path: Path, limits: Limits, jerk: float) -> tuple[Limits, tuple[float, ...]]:
    """Return the limits and the feeds on the pieces, m/s, under which the mean is a fast motion
    where the jerk rules.

    Of a straight way L between two rests none reaches more speed than (L^2 j / 4)^(1/3), nor more
    acceleration than sqrt(v j) on the way to a speed v. Averaged over a / j, a way on which a speed
    is kept as long as that takes least.
    """
    speed = limits.speed or np.inf
    stops = np.array([stop.s for stop in path.stops])
    ways = np.diff(stops)
    top = min(speed, np.cbrt(jerk * ways.max() ** 2 / 4))
    acceleration = float(min(limits.acceleration or np.inf, np.sqrt(top * jerk)))
    width = acceleration / jerk
    reached = acceleration / 2 * (np.sqrt(width**2 + 4 * ways / acceleration) - width)
    reached[reached >= speed] = np.inf
    way = np.searchsorted(stops, path.knots[:-1], side="right") - 1
    feeds = np.minimum(path.feed, reached[way])
    return replace(limits, acceleration=acceleration), tuple(feeds.tolist())


def smoothed(
    motion: TimedPath, with_feeds: Callable[[np.ndarray], TimedPath], until: float
) -> TimedPath:
    """Return a motion along the path that keeps its limit on jerk.

    motion: the fastest without that limit. with_feeds: returns that with other feeds. until: the
    thread's processor time, s, after which no slower motion is tried.
    """
    refuse_crossing(motion)
    feeds = eased(motion.path, motion.limits.jerk or np.inf)
    slow = with_feeds(feeds)
    dips = _dips(motion, feeds)
    rests = np.count_nonzero(motion.x == 0) - 1
    # A dip takes about w longer, or one w before it and one after it.
    widths = [_best_width(slow, rests + share * dips) for share in (1, 2)]
    if abs(widths[1] / widths[0] - 1) < ALIKE:
        del widths[1]
    tried = [_paced(replace(motion, smooth=widths[0]))]
    for width in widths:
        tried += _slowed(replace(slow, smooth=width), feeds, with_feeds, until)
    return min(tried, key=lambda each: each.duration)


def in_time(motion: TimedPath, duration: float | None) -> TimedPath:
    """Return the motion slowed down to a duration, s, if one is given."""
    if duration is None:
        return motion
    if duration < motion.duration:
        raise TimingError(
            f"time_path: duration = {duration:g} s is less than {motion.duration:.6g} s, the least"
            " that was found with this jerk limit",
            0.0,
            False,
        )
    rests = sum(stop.seconds for stop in motion.path.stops)
    return replace(motion, pace=motion.pace * (duration - rests) / (motion.duration - rests))


def _slowed(motion, feeds, with_feeds, until):
    """Return motions that are slowed down more and more on the pieces where it is needed."""
    pace = max(1.0, _pace_along(motion))
    tried = []
    for _ in progress(range(ROUNDS), desc="jerk", unit=" motions", delay=2, leave=False):
        tried.append(_paced(motion))
        samples = _sampled(motion)
        piece = motion.piece[samples.k]
        needed = np.zeros((2, len(feeds)))  # the largest pace and speed on each piece
        np.maximum.at(needed[0], piece, _needed(motion, samples, pace))
        np.maximum.at(needed[1], piece, samples.v)
        if needed[0].max() < (1 + NEAR) * pace or time.thread_time() > until:
            break
        slower = needed[0] > (1 + NEAR / 2) * pace
        # A feed far below the mean's speed is no measure of it: a large step would be too large.
        share = np.minimum(needed[0] / pace, STEP)
        feeds = np.where(slower, np.minimum(feeds, needed[1]) / share, feeds)
        motion = replace(with_feeds(feeds), smooth=motion.smooth)
    return tried


def _dips(motion, feeds):
    """Return how often the motion slows down to feeds on some pieces."""
    fast = np.zeros(len(feeds))
    np.maximum.at(fast, motion.piece, np.maximum(motion.x[:-1], motion.x[1:]))
    is_slow = fast > feeds**2
    return np.count_nonzero(np.diff(is_slow, prepend=False)[is_slow])


def _best_width(motion, dips):
    """Return the time over which to average s, s, as if each of its dips took so much longer."""
    push = np.abs(motion.clock.pushes).max()
    longest = 2 * push / motion.limits.jerk  # of the change from all of it to all against it
    moving = motion.clock.taken.sum()
    least = min(SHORTEST * longest, SHARE * moving / dips)

    def taken(w):
        averaged = replace(motion, smooth=float(np.exp(w)))
        return (moving + dips * averaged.smooth) * max(1.0, _pace_along(averaged))

    widths = np.linspace(np.log(least), np.log(longest), WIDTHS)
    bar = progress(widths, desc="jerk", unit=" averages", delay=2, leave=False)
    k = int(np.argmin([taken(w) for w in bar]))
    ends = widths[max(k - 1, 0)], widths[min(k + 1, WIDTHS - 1)]
    found = minimize_scalar(taken, bounds=ends, method="bounded", options={"maxiter": STEPS})
    return float(np.exp(min((found.x, widths[k]), key=taken)))


def _pace_along(motion):
    """Return the pace at which s''' alone keeps the limit on jerk."""
    return float(np.cbrt(np.abs(motion.clock.jerk(_times(motion))).max() / motion.limits.jerk))


def _times(motion):
    """Return the times (n,), s, at which limits are looked at."""
    turns = (
        np.flatnonzero(np.diff(motion.piece) * motion.x[1:-1]) + 1
    )  # nodes where xi_sss jumps, and it does not rest
    edges = np.union1d(motion.clock.breaks, motion.clock.passed(turns))
    edges = edges[np.append(True, np.diff(edges) > 1e-12)]
    places = max(PLACES, FEWEST // len(edges))
    inside = np.concatenate([[1e-6], np.linspace(0, 1, places + 2)[1:-1], [1 - 1e-6]])
    return (edges[:-1, None] + np.diff(edges)[:, None] * inside).ravel()


class Samples(NamedTuple):
    """A motion at its own pace at n times.

    k: its stretches; v, u, j: s', s'', s'''; xi_s, xi_ss (n, 2) of joint C, tip of the tool.
    """

    k: np.ndarray
    v: np.ndarray
    u: np.ndarray
    j: np.ndarray
    pose: Pose
    xi: tuple[np.ndarray, ...]
    tip: tuple[np.ndarray, ...]

    def moved(self, pace: float) -> Accelerations:
        """Return how the robot moves at a slower pace."""
        v = self.v[:, None] / pace
        xi_s, xi_ss = self.xi
        return ikm2(ikm(self.pose, xi_s * v), xi_ss * v**2 + xi_s * self.u[:, None] / pace**2)


def _sampled(motion):
    t = _times(motion)
    k, gone, speed, push = motion.clock.along(t)
    place = motion.piece[k], motion.first[k] + gone
    xi, *xi_s, _ = motion.path.on(*place)
    pose = igm(motion.robot, xi, motion.working)
    tip = motion.path.drawn.on(*place)[1:]
    return Samples(k, speed, push, motion.clock.jerk(t), pose, tuple(xi_s), tip)


def _needed(motion, samples, pace=None):
    """Return by how much slower the motion must be at each time (n,).

    Torques need not be less at a slower pace: they count only where they are too large at `pace`.
    """
    limits = motion.limits
    tip_s, tip_ss, tip_sss = samples.tip
    v = samples.v[:, None]
    u = samples.u[:, None]
    acc = samples.moved(1.0)
    feed = np.array(motion.path.feed)[motion.piece[samples.k]]
    tip = np.linalg.norm(tip_s, axis=1) * samples.v
    third = tip_sss * v**3 + 3 * tip_ss * v * u + tip_s * samples.j[:, None]
    shares = [
        tip / np.minimum(feed, limits.speed or np.inf),
        np.cbrt(np.linalg.norm(third, axis=1) / limits.jerk),
    ]
    if limits.joint_speed:
        shares.append(np.max(np.abs(acc.rates.q_dot) / limits.joint_speed, axis=1))
    if limits.joint_acceleration:
        shares.append(np.sqrt(np.max(np.abs(acc.q_ddot) / limits.joint_acceleration, axis=1)))
    if limits.acceleration:
        size = np.linalg.norm(tip_ss * v**2 + tip_s * u, axis=1)
        shares.append(np.sqrt(size / limits.acceleration))
    if limits.torque and pace:
        used = _torques_used(limits, samples.moved(pace)).max(axis=1)
        shares.append(np.where(used > 1, pace * np.sqrt(used), 0.0))
    return np.max(shares, axis=0)


def _torques_used(limits, acc):
    """Return the torques as shares (n, 2) of what the motors have."""
    tau = inverse_dynamics(acc)
    shares = np.abs(tau) / limits.torque
    if limits.stall:
        line = tau / limits.stall + acc.rates.q_dot / limits.no_load
        shares = np.maximum(shares, np.abs(line))
    return shares


def _paced(motion):
    """At the pace at which it keeps its limits."""
    samples = _sampled(motion)
    pace = max(1e-9, float(_needed(motion, samples).max())) * (1 + MARGIN)
    if motion.limits.torque:

        def fits(pace):
            return (_torques_used(motion.limits, samples.moved(pace)) <= 1 - MARGIN).all()

        low = pace
        while not fits(pace) and pace < 1e6:
            low = pace
            pace = 1.5 * pace
        while pace > low * (1 + MARGIN):
            middle = np.sqrt(low * pace)
            low, pace = (low, middle) if fits(middle) else (middle, pace)
    return replace(motion, pace=pace)
