"""The four-bar: Grashof's classes, dead centres, transmission angle, inversions, and its chain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from ..base.backend import EPS, is_symbolic
from ..base.checks import instance, modes, one_of, takes
from ..models.robots import must_close
from .chain import Fixed, Reach, Still, Turned, meet
from .checks import check, check_lengths, coordinate, pair
from .limits import TURN, four_bar_limits
from .motion import Body, Chain, MovingLink, one_drive

if TYPE_CHECKING:
    from .chain import Number

SIDES = ("ground", "crank", "coupler", "rocker")


@dataclass(frozen=True)
class FourBar:
    """Four-bar A B C D.

    Ground AD, crank AB (driven), coupler BC and rocker CD. Crank angles count from +x. On branch +1
    C is on the left of B -> D. ValueError for lengths that no four-bar can have.

    Parameters
    ----------
    ground, crank, coupler, rocker : float
        m.
    point : tuple of float, optional
        The coupler point M, along BC from B and to its left, m; None: the middle of BC.
    base : tuple of float
        A, m.
    tilt : float
        Direction of the ground A -> D, rad.
    crank_body, coupler_body, rocker_body : Body
        Masses for `driving_torque`.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.FourBar(0.2, 0.06, 0.16, 0.14).kind
    'crank-rocker'
    """

    ground: float
    crank: float
    coupler: float
    rocker: float
    point: tuple | None = None
    base: tuple = (0.0, 0.0)
    tilt: float = 0.0
    crank_body: Body = Body()
    coupler_body: Body = Body()
    rocker_body: Body = Body()

    usual_branch = 1

    def __post_init__(self) -> None:
        check_lengths(self, *SIDES)
        check(self, pair, "point", "base")
        check(self, coordinate, "tilt")
        check(self, instance(Body), "crank_body", "coupler_body", "rocker_body")
        must_close("four-bar", {name: getattr(self, name) for name in SIDES})

    @property
    def sides(self) -> tuple[float, ...]:
        """Ground, crank, coupler, rocker, m."""
        return self.ground, self.crank, self.coupler, self.rocker

    def chain(self, q: Number, branch: Any) -> Chain:
        a = Fixed(self.base)
        heading = Turned(Still(), q)
        b = Reach(a, heading, self.crank)
        x, y = self.base
        d = Fixed((x + self.ground * math.cos(self.tilt), y + self.ground * math.sin(self.tilt)))
        c, bc, dc = meet(b, d, self.coupler, self.rocker, branch)
        m = Reach(b, bc, *(self.point or (self.coupler / 2, 0.0)))
        links = {
            "crank": MovingLink(a, heading, self.crank, self.crank_body),
            "coupler": MovingLink(b, bc, self.coupler, self.coupler_body),
            "rocker": MovingLink(d, dc, self.rocker, self.rocker_body),
        }
        bars = [("A", "B"), ("B", "C"), ("D", "C")]
        if self.point and (is_symbolic(self.point[1]) or self.point[1]):
            bars += [("B", "M"), ("C", "M")]
        elif self.point and not 0 <= self.point[0] <= self.coupler:
            bars += [("B", "M")]
        points: dict[str, Any] = {"A": a, "B": b, "C": c, "D": d, "M": m}
        return Chain(points, links, {}, (c.dyad,), tuple(bars), ("A", "D"), ("A",), "M")

    start = one_drive
    driven = "crank"

    @property
    def title(self) -> str:
        return f"four-bar, {self.kind}"

    @property
    def flats(self) -> list[float]:
        """Crank angles, rad, at which a change point has all bars in line."""
        (g, a, b, c), tolerance = self.sides, 8 * EPS * sum(self.sides)
        if abs(abs(g - a) - abs(b - c)) <= tolerance:
            near = [self.tilt]
        else:
            near = []
        return near + ([self.tilt + math.pi] if abs(g + a - b - c) <= tolerance else [])

    def crank_limits(self, branch: Any) -> list[float]:
        """Crank angles, rad, at which coupler and rocker are in line."""
        return four_bar_limits(self.tilt, *self.sides)

    @property
    def grashof(self) -> float:
        """Shortest + longest - the two others, m: < 0 where a link can turn fully, 0 at a change
        point.
        """
        shortest, p, q, longest = sorted(self.sides)
        excess = (longest - q) - (p - shortest)
        if abs(excess) <= 8 * EPS * sum(self.sides):
            return 0.0
        return excess

    @property
    def kind(self) -> str:
        """Grashof's class by name."""
        if self.grashof > 0:
            return "non-Grashof triple-rocker"
        if self.grashof == 0:
            return "change point"
        names = (
            "double-crank (drag link)",
            "crank-rocker",
            "Grashof double-rocker",
            "rocker-crank",
        )
        return names[self.sides.index(min(self.sides))]

    @property
    def turning(self) -> tuple[str, ...]:
        """Names of the moving links that can turn fully against the ground."""
        if self.grashof > 0:
            return ()
        if self.grashof == 0:
            return tuple(name for name in SIDES[1:] if self._revolves(name))
        shortest = SIDES[self.sides.index(min(self.sides))]
        return SIDES[1:] if shortest == "ground" else (shortest,)

    def _revolves(self, name):
        """Return whether a link closes both stretched from the ground and folded on it."""
        index = SIDES.index(name)
        length = self.sides[index]
        first, second = (side for k, side in enumerate(self.sides) if k not in (0, index))
        tolerance = 8 * EPS * sum(self.sides)
        stretches = self.ground + length <= first + second + tolerance
        return stretches and abs(self.ground - length) >= abs(first - second) - tolerance

    def inversion(self, held: str) -> FourBar:
        """Return the four-bar with another link held, of "ground", "crank", "coupler", "rocker".

        The next link is driven.
        """
        k = SIDES.index(one_of(*SIDES)(held, "held"))
        first, second, third, fourth = (*self.sides[k:], *self.sides[:k])
        return FourBar(first, second, third, fourth)


class DeadCentre(NamedTuple):
    """A pose with crank and coupler in line, from `dead_centres`.

    Attributes
    ----------
    kind : "extended" or "folded"
    crank, rocker : float
        Angles, rad in (-pi, pi].

    Examples
    --------
    >>> from fivebar import linkages
    >>> [dead.kind for dead in linkages.dead_centres(linkages.FourBar(0.2, 0.06, 0.16, 0.14))]
    ['extended', 'folded']
    """

    kind: str
    crank: float
    rocker: float


@takes(four_bar=instance(FourBar), branch=modes(1))
def dead_centres(four_bar: FourBar, branch: int = 1) -> tuple[DeadCentre, ...]:
    """Return the poses of a branch in which crank and coupler are in line, up to two.

    They are the ends of the rocker's swing.

    Parameters
    ----------
    four_bar : FourBar
    branch : int
        +1 or -1.

    Returns
    -------
    tuple of DeadCentre

    Examples
    --------
    >>> from fivebar import linkages
    >>> len(linkages.dead_centres(linkages.FourBar(0.2, 0.06, 0.16, 0.14)))
    2
    """
    g, a, b, c = four_bar.sides
    centres = []
    for kind, reach, turn in (("extended", b + a, 0.0), ("folded", b - a, math.pi)):
        if reach == 0:
            continue  # C is in A at any crank angle that closes: no end of a swing
        # Triangle A C D; the coupler's direction has A -> D on its right (branch +1) by this angle.
        cosine = (g * g + reach * reach - c * c) / (2 * g * reach)
        if abs(cosine) <= 1:
            angle = branch * math.acos(cosine)
            rocker = math.atan2(reach * math.sin(angle), reach * math.cos(angle) - g)
            crank = _wrap(angle + turn + four_bar.tilt)
            centres.append(DeadCentre(kind, crank, _wrap(rocker + four_bar.tilt)))
    return tuple(centres)


@takes(four_bar=instance(FourBar), branch=modes(1))
def time_ratio(four_bar: FourBar, branch: int = 1) -> float | None:
    """Return the duration of the rocker's slower stroke over that of its faster one.

    The crank turns at constant speed.

    Parameters
    ----------
    four_bar : FourBar
    branch : int
        +1 or -1.

    Returns
    -------
    float or None
        None where the crank cannot turn, or the rocker has no two ends.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.time_ratio(linkages.FourBar(0.2, 0.06, 0.16, 0.14)) >= 1
    True
    """
    ends = dead_centres(four_bar, branch)
    if four_bar.turning != ("crank",) or len(ends) < 2:
        return None
    stroke = (ends[1].crank - ends[0].crank) % TURN
    return max(stroke, TURN - stroke) / min(stroke, TURN - stroke)


@takes(four_bar=instance(FourBar))
def transmission_range(four_bar: FourBar) -> tuple[float, float]:
    """Return the least and the largest angle between coupler and rocker over all crank angles.

    Parameters
    ----------
    four_bar : FourBar

    Returns
    -------
    (least, largest) : tuple of float
        rad, from 0 to pi.

    Examples
    --------
    >>> from fivebar import linkages
    >>> low, high = linkages.transmission_range(linkages.FourBar(0.2, 0.06, 0.16, 0.14))
    >>> 0 < low < high
    True
    """
    g, a, b, c = four_bar.sides
    low = max(abs(g - a), abs(b - c))
    high = min(g + a, b + c)
    return _angle_opposite(low, b, c), _angle_opposite(high, b, c)


def _angle_opposite(side, b, c):
    """Return a triangle's angle by the tangent of its half: accurate at 0 and pi."""
    above = max((side - b + c) * (side + b - c), 0.0)
    below = max((b + c - side) * (b + c + side), 0.0)
    return 2 * math.atan2(math.sqrt(above), math.sqrt(below))


def _wrap(angle):
    angle = math.remainder(angle, TURN)
    return math.pi if angle == -math.pi else angle
