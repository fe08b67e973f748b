"""How a crank is driven: turning evenly, up to where it locks, or to and fro; and two motors
together.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.errors import UnreachableError
from .limits import TURN, crank_range
from .moving import move

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .five_bar import FiveBarLinkage
    from .limits import CrankRange
    from .motion import CrankLinkage

DRIVES = ("turn", "until-lock", "swing")
MARGIN = 0.02  # of the range that a swing keeps from a lock, where rates have no limit
AMPLITUDE = 0.4  # rad, of two motors that swing


class Law(NamedTuple):
    """t (n,) s; q, q_dot, q_ddot (n,) or, for two motors, (n, 2); lock: (crank angle, time) where
    it locks, or None.
    """

    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    q_ddot: np.ndarray
    lock: tuple | None = None


def law(
    linkage: Any,
    drive: str,
    speed: float,
    turns: float,
    samples: int,
    branch: Any,
    start: float | None,
    between: tuple[float, float] | None,
) -> Law:
    """Return the motion of a linkage's crank: Law. UnreachableError where a turning crank locks,
    with angle and time.
    """
    allowed = crank_range(linkage, branch)
    if not allowed.intervals:
        raise UnreachableError(
            f"unreachable: on this branch no angle of the {linkage.driven} closes", math.nan
        )
    t = np.linspace(0.0, turns * TURN / abs(speed), round(turns * (samples - 1)) + 1)
    if drive == "swing":
        return _swing(t, speed, *_inside(linkage, allowed, start, between))
    if between is not None:
        raise ValueError(f'between is for the drive "swing", not "{drive}"')
    start = usual_start(linkage, allowed) if start is None else start
    end = _around(linkage, allowed, start)[speed > 0]
    lock = None
    if abs(end - start) / abs(speed) <= t[-1]:
        lock = end, abs(end - start) / abs(speed)
        if drive == "turn":
            raise UnreachableError(
                f"unreachable: the {linkage.driven} cannot turn: from {math.degrees(start):.9g}"
                " deg at "
                f"{math.degrees(speed):.9g} deg/s it locks at {math.degrees(lock[0]):.9g} deg after"
                f' {lock[1]:.9g} s; drives "until-lock" and "swing" stay inside its range',
                math.nan,
            )
        t = np.linspace(0.0, lock[1], len(t))[:-1]  # at the lock itself rates have no limit
    return Law(t, start + speed * t, np.full(len(t), float(speed)), np.zeros(len(t)), lock)


def usual_start(linkage: CrankLinkage, allowed: CrankRange) -> float:
    """Return where a crank starts that was not told: as the linkage says, else at 0 or in the
    middle of its last range.

    Half a degree off 0 where it passes flat poses, which have no rates: the usual samples then miss
    them.
    """
    if hasattr(linkage, "usual_start"):
        return linkage.usual_start
    if not allowed.full:
        return sum(allowed.intervals[-1]) / 2
    return math.radians(0.5) if linkage.flats else 0.0


def smooth_branch(linkage: Any, q: np.ndarray, branch: Any) -> np.ndarray:
    """Return the branch at each of the angles q as the linkage moves through its flat poses: there
    it passes to the other one.

    The one given is that of the start. Where it stayed, rates would jump: a parallelogram would
    cross its bars.
    """
    flips = sum(
        np.floor((q - flat) / TURN) - np.floor((q[0] - flat) / TURN) for flat in linkage.flats
    )
    return np.where(flips % 2, -branch, branch).astype(int)


def _around(linkage, allowed, start):
    """Return the interval around a start."""
    interval = allowed.interval(start)
    if interval is None:
        raise UnreachableError(
            f"unreachable: the {linkage.driven} cannot start at {math.degrees(start):.9g} deg; the"
            f" nearest allowed angle is {math.degrees(allowed.nearest(start)):.9g} deg; it may turn"
            f" {allowed}",
            math.nan,
        )
    return interval


def _inside(linkage, allowed, start, between):
    """Return the two angles of a swing, or else the range around the start; where an end is a
    lock, a bit before it.
    """
    if between is not None:
        if start is not None:
            raise ValueError("a swing has a start, whose range it takes, or between, not both")
        low, high = allowed.interval(between[0]) or (math.inf, -math.inf)
        if not low <= between[1] <= high:
            first, last = np.degrees(between)
            raise UnreachableError(
                f"unreachable: the {linkage.driven} cannot swing from {first:.9g} to {last:.9g}"
                f" deg; it may turn {allowed}",
                math.nan,
            )
        margin = MARGIN / 20 * abs(between[1] - between[0])
        return tuple(np.clip(between, low + margin, high - margin).tolist())
    if allowed.full:
        raise ValueError("this crank turns fully: it has no range of its own to swing in")
    low, high = allowed.intervals[-1] if start is None else _around(linkage, allowed, start)
    margin = MARGIN * (high - low)
    first = low + margin
    last = high - margin
    middle = (low + high) / 2
    if any(
        abs(math.remainder(flat - middle, TURN)) < 1e-6 for flat in getattr(linkage, "flats", ())
    ):
        # The usual samples then miss the flat pose, which has no rates.
        last -= MARGIN / 4 * (last - first)
    return first, last


def _swing(t, speed, low, high):
    """To and fro once a turn's time, harmonically, from `low`."""
    middle = (low + high) / 2
    half = (high - low) / 2
    phase = abs(speed) * t
    return Law(
        t,
        middle - half * np.cos(phase),
        abs(speed) * half * np.sin(phase),
        speed * speed * half * np.cos(phase),
    )


def two_motors(
    linkage: FiveBarLinkage,
    drive: str,
    speed: ArrayLike,
    turns: float,
    samples: int,
    branch: Any,
    start: ArrayLike | None,
) -> Law:
    """Return the motion of a five-bar's two motors: Law; `speed` a number for both or a pair.

    "turn": both turn evenly; "swing": both go to and fro about the start, a quarter period apart,
    by AMPLITUDE or the half, quarter ... of it that closes.
    """

    def closes(q):
        motion = move(linkage, q, branch=branch, unreachable="nan")
        return np.isfinite(motion.position("joint 3")).all(axis=-1)

    speed = np.broadcast_to(np.asarray(speed, dtype=float), 2)
    fastest = np.abs(speed).max()
    start = np.array(
        [linkage.home[k] for k in linkage.motors] if start is None else start, dtype=float
    )
    t = np.linspace(0.0, turns * TURN / fastest, round(turns * (samples - 1)) + 1)
    if drive == "swing":
        phase = np.outer(t, [fastest, fastest]) + (0.0, math.pi / 2)
        amplitude = AMPLITUDE
        while amplitude > AMPLITUDE / 16 and not closes(start + amplitude * np.sin(phase)).all():
            amplitude /= 2
        return Law(
            t,
            start + np.sin(phase) * amplitude,
            np.cos(phase) * amplitude * fastest,
            -np.sin(phase) * amplitude * fastest**2,
        )

    open_at = np.flatnonzero(~closes(start + np.outer(t, speed)))
    lock = None
    if len(open_at):
        if open_at[0] == 0:
            raise UnreachableError(
                f"unreachable: with the motors at {np.degrees(start)} deg the bars cannot meet",
                math.nan,
            )
        low = t[open_at[0] - 1]
        high = t[open_at[0]]
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if closes(start + middle * speed) else (low, middle)
        where = ", ".join(f"{angle:.6f}" for angle in np.degrees(start + low * speed))
        lock = tuple((start + low * speed).tolist()), float(low)
        if drive == "turn":
            raise UnreachableError(
                f"unreachable: the motors lock at {where} deg after {low:.9g} s", math.nan
            )
        t = np.linspace(0.0, low, len(t))[:-1]
    q_dot = np.broadcast_to(speed, (len(t), 2))
    return Law(t, start + np.outer(t, speed), q_dot, np.zeros((len(t), 2)), lock)
