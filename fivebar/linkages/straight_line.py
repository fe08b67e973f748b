"""Four-bars whose coupler point goes nearly straight, with their proportions, sources and
straightness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.checks import instance, takes, text, whole
from .four_bar import FourBar
from .moving import move

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class StraightLine:
    """A straight-line mechanism, from `straight_line`.

    Attributes
    ----------
    linkage : FourBar
        Lengths in its source's unit, taken as m.
    branch : int
    through, direction : (2,)
        Of the nominal line.
    stroke : (2,)
        First and last crank angle of its usual stroke, rad.
    source : str

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.straight_line("watt").branch in (1, -1)
    True
    """

    linkage: FourBar
    branch: int
    through: tuple
    direction: tuple
    stroke: tuple
    source: str


class Straightness(NamedTuple):
    """How straight a stroke is, from `straightness`.

    Attributes
    ----------
    stroke : float
        Its length, m.
    deviation : float
        Largest distance from the nominal line, m.
    band : float
        Width of the band around it, m.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.straightness(linkages.straight_line("watt")).band >= 0
    True
    """

    stroke: float
    deviation: float
    band: float

    @property
    def ratio(self) -> float:
        """Band over stroke."""
        return self.band / self.stroke


@takes(mechanism=instance(StraightLine), samples=whole(2, 10**6))
def straightness(mechanism: StraightLine, samples: int = 4001) -> Straightness:
    """Return how straight the coupler point goes over its usual stroke.

    Parameters
    ----------
    mechanism : StraightLine
    samples : int
        Crank angles.

    Returns
    -------
    Straightness

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.straightness(linkages.straight_line("watt")).stroke
    0.5
    """
    first, last = mechanism.stroke
    q = np.linspace(first, last, samples)
    point = move(mechanism.linkage, q, branch=mechanism.branch).position("M") - mechanism.through
    x, y = mechanism.direction
    along = point @ (x, y)
    across = point @ (-y, x)
    return Straightness(float(np.ptp(along)), float(np.abs(across).max()), float(np.ptp(across)))


def crank_at(
    linkage: FourBar,
    branch: int,
    through: ArrayLike,
    direction: ArrayLike,
    along: float,
    guess: float,
) -> float:
    """Return the crank angle with the coupler point at a coordinate along a line, m.

    By Newton's method from a guess.
    """
    for _ in range(50):
        motion = move(linkage, guess, branch=branch)
        step = (along - np.dot(direction, motion.position("M") - through)) / np.dot(
            direction, motion.velocity("M")
        )
        guess += float(step)
        if abs(step) < 1e-14:
            return guess
    raise ArithmeticError(f"the coupler point does not come to {along:g} m on the line")


def roberts(r: float) -> StraightLine:
    """Return Roberts' mechanism of arms r: ground 2, coupler 1, the point at r below both ends.

    It is exact at A, at D and between them once.
    """
    linkage = FourBar(2.0, r, 1.0, r, point=(0.5, -math.sqrt(r * r - 0.25)))
    if not r >= 1.18615:  # there coupler and rocker come in line with the point at A
        raise ValueError(
            f"the arms must be at least 1.18615, not {r:g}: else the crank turns back before the"
            " point is at A"
        )
    last = math.acos(1 / r)
    return StraightLine(
        linkage,
        1,
        (0.0, 0.0),
        (1.0, 0.0),
        (last + 2 * math.asin(0.5 / r), last),
        f"2 : {r:g} : 1 : {r:g}, isosceles coupler of sides {r:g}; stroke from A to D; Roberts, in"
        " Norton, Design of Machinery (2 : 1 : 1 : 1 there)",
    )


def _watt():
    linkage = FourBar(math.sqrt(4.25), 1.0, 0.5, 1.0, base=(-1.0, 0.25), tilt=math.atan2(-0.5, 2.0))
    line = (0.0, 0.0), (0.0, 1.0)
    ends = tuple(crank_at(linkage, -1, *line, y, math.asin(y)) for y in (-0.25, 0.25))
    return StraightLine(
        linkage,
        -1,
        *line,
        ends,
        "equal arms 1, coupler 0.5, its middle; stroke +-0.25 about the pose with level arms; Watt"
        " 1784",
    )


_CHEBYSHEV = StraightLine(
    FourBar(4.0, 5.0, 2.0, 5.0),
    -1,
    (0.0, 4.0),
    (1.0, 0.0),
    (math.pi / 2, math.atan2(3.0, 4.0)),
    "4 : 5 : 2 : 5 crossed, middle of the coupler; stroke between the poses with the coupler"
    " upright over A and D, exact there and midway; Chebyshev, in Norton, Design of Machinery (2 :"
    " 2.5 : 1 : 2.5)",
)
_HOEKEN = StraightLine(
    FourBar(2.0, 1.0, 2.5, 2.5, point=(5.0, 0.0)),
    1,
    (0.0, 4.0),
    (1.0, 0.0),
    (math.pi / 2, 3 * math.pi / 2),
    "2 : 1 : 2.5 : 2.5, the point at 5 from the crank pin through C; stroke: half a turn of the"
    " crank about 180 deg; Hoeken 1926, in Norton, Design of Machinery",
)
_EVANS = StraightLine(
    FourBar(10.0, 5.0, 5.0, 5.0, point=(-5.0, 0.0), tilt=-math.pi / 6),
    1,
    (0.0, 0.0),
    (0.0, 1.0),
    (-math.pi / 6, math.pi / 6),
    "10 : 5 : 5 : 5, the point at 5 beyond the crank pin, ground at -30 deg: r1 and r4 are free, r2"
    " = r3 = rp; stroke +-5 about the pose with crank and coupler in line, exact there and at both"
    " ends; Evans 1801, as in the Ch Mechanism Toolkit of SoftIntegration",
)

BUILDERS = {
    "evans": lambda: _EVANS,
    "chebyshev": lambda: _CHEBYSHEV,
    "watt": _watt,
    "hoeken": lambda: _HOEKEN,
    "roberts": lambda: roberts(1.2),
}


@takes(name=text)
def straight_line(name: str) -> StraightLine:
    """Return a straight-line mechanism by name.

    Parameters
    ----------
    name : "evans", "chebyshev", "watt", "hoeken" or "roberts"

    Returns
    -------
    StraightLine

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.straight_line("watt").stroke[0] < linkages.straight_line("watt").stroke[1]
    True
    """
    if name not in BUILDERS:
        raise ValueError(
            f"no straight-line mechanism {name!r}; the known ones are {', '.join(BUILDERS)}"
        )
    return BUILDERS[name]()
