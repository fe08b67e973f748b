"""Crank angles that a linkage reaches: closed-form limits, and the intervals between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import EPS
from ..base.checks import takes
from .checks import linkage, one_branch

if TYPE_CHECKING:
    from .motion import CrankLinkage

TURN = 2 * math.pi


@dataclass(frozen=True)
class CrankRange:
    """The crank angles at which a linkage closes on a branch, from `crank_range`.

    `str` gives it in degrees.

    Attributes
    ----------
    intervals : tuple of (low, high)
        rad, low in (-pi, pi], high > low.
    full : bool
        Whether the crank turns.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.crank_range(linkages.FourBar(0.2, 0.06, 0.16, 0.14)).full
    True
    """

    intervals: tuple
    full: bool

    def contains(self, q: float) -> bool:
        """Return whether this crank angle closes."""
        return self.full or self.interval(q) is not None

    def interval(self, q: float) -> tuple[float, float] | None:
        """Return the interval around a crank angle, moved by full turns to contain it, or None."""
        if self.full:
            return -math.inf, math.inf
        for low, high in self.intervals:
            turns = math.floor((q - low + 1e-12) / TURN) * TURN
            if q <= high + turns + 1e-12:
                return low + turns, high + turns
        return None

    def nearest(self, q: float) -> float:
        """Return the allowed angle nearest to q, rad in (-pi, pi]; q itself where it is allowed."""
        if self.contains(q):
            return q
        ends = [end for interval in self.intervals for end in interval]
        best = min(ends, key=lambda end: abs(math.remainder(end - q, TURN)))
        return math.remainder(best, TURN)

    def __str__(self) -> str:
        if self.full:
            return "through a full turn"
        parts = (
            f"from {math.degrees(low):.9g} to {math.degrees(high):.9g} deg"
            for low, high in self.intervals
        )
        return " and ".join(parts)


@takes(linkage=linkage)
def crank_range(linkage: CrankLinkage, branch: int | tuple[int, int] | None = None) -> CrankRange:
    """Return the crank angles at which a linkage closes on a branch.

    Their ends come from the linkage in closed form. Which intervals between them close is tried
    inside of them.

    Parameters
    ----------
    linkage : FourBar, SliderCrank or SixBarPress
    branch : int or (2,), optional
        None: its usual one.

    Returns
    -------
    CrankRange

    Examples
    --------
    >>> from fivebar import linkages
    >>> print(linkages.crank_range(linkages.FourBar(0.2, 0.16, 0.06, 0.14)))
    from -66.4218215 to -22.331645 deg and from 22.331645 to 66.4218215 deg
    """
    branch = one_branch(linkage, branch)
    ends = sorted({math.remainder(end, TURN) for end in linkage.crank_limits(branch)})
    if not ends:
        turns = math.isfinite(linkage.chain(0.3, branch).found)
        return CrankRange(((-math.pi, math.pi),) if turns else (), turns)
    pieces = list(zip(ends, [*ends[1:], ends[0] + TURN]))
    low, high = np.array(pieces).T
    # Two places in each: in the middle of a change point's piece both ends of the dyad may meet.
    places = np.stack([low + share * (high - low) for share in (0.5, 0.38)], axis=1)
    closes = np.any(np.isfinite(np.asarray(linkage.chain(places, branch).found)), axis=1)
    kept: list[tuple[float, float]] = []
    for piece, good in zip(pieces, closes.tolist()):
        if good and kept and kept[-1][1] == piece[0]:
            kept[-1] = (kept[-1][0], piece[1])
        elif good:
            kept.append(piece)
    if len(kept) > 1 and kept[-1][1] == kept[0][0] + TURN:  # one interval over +-pi
        first = kept.pop(0)
        kept[-1] = (kept[-1][0], first[1] + TURN)
    full = len(kept) == 1 and kept[0][1] - kept[0][0] >= TURN - 1e-12
    return CrankRange(tuple(kept), full)


def ends_of(axis: float, near: float, far: float) -> list[float]:
    """Return angles at which 1 - cos(q - axis) = near and 1 + cos(q - axis) = far."""
    # Sines of half angles: they keep their digits where the limit is close to a straight or folded
    # pose.
    ends = []
    for square, turn in ((near / 2, 0.0), (far / 2, math.pi)):
        if 4 * EPS < square < 1 - 4 * EPS:
            half = 2 * math.asin(math.sqrt(square))
            ends += [axis + turn - half, axis + turn + half]
    return ends


def four_bar_limits(
    axis: float, ground: float, crank: float, coupler: float, rocker: float
) -> list[float]:
    """Return crank angles with coupler and rocker in line; the axis is the ground's direction."""
    scale = 2 * ground * crank
    short = ground - crank
    long = ground + crank
    folded = coupler - rocker
    stretched = coupler + rocker
    # span^2 = short^2 + scale (1 - cos q) = long^2 - scale (1 + cos q), between folded^2 and
    # stretched^2
    return ends_of(
        axis,
        (folded - short) * (folded + short) / scale,
        (long - stretched) * (long + stretched) / scale,
    )


def guide_limits(crank: float, bar: float, offset: float) -> list[float]:
    """Return crank angles at which a bar is perpendicular to the guide y = offset along +x."""
    return ends_of(math.pi / 2, (crank - offset - bar) / crank, (crank + offset - bar) / crank)
