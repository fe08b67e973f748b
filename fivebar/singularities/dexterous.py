"""Dexterous regions: the parts of the aspects in which no singularity comes nearer than given
margins, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..base.backend import pairs
from ..base.checks import share
from ..base.robot_uses import takes_robot
from ..models.robots import FiveBar
from .aspects import Aspect, as_kind, aspects, in_mode, numbered, parts
from .degenerate import settled
from .five_bar_loci import FiveBarLoci
from .leg_circles import LegCircles
from .level_curves import LevelCurves

# Of a margin that is not 0: with less, corners can be closer together than rounding tells apart.
LEAST = 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class DexterousRegion(Aspect):
    """A connected part of an aspect in which |det A| >= det_A and both |sin q_i2| >= sin, from
    `dexterous`.

    All that an Aspect has, and `largest_disc` and `largest_rectangle` take it as one.
    """

    det_A: float = 0.0
    sin: float = 0.0


@takes_robot(det_A=share, sin=share)
def dexterous(robot: FiveBar, det_A: float = 0.0, sin: float = 0.0) -> tuple[DexterousRegion, ...]:
    """Return the connected regions that keep a distance from singularities.

    There |det A| >= det_A and |sin q_i2| >= sin. Their boundaries are exact: det A = +-k fixes the
    distance of the elbows, so the end-effector is on the coupler curve of a four-bar, and the sine
    of an elbow fixes the distance from a base joint. They are ordered as `aspects`, which they are
    with 0 and 0.

    Parameters
    ----------
    robot : FiveBar
    det_A, sin : float
        In [0, 1].

    Returns
    -------
    tuple of DexterousRegion
        () where no pose keeps both.

    Raises
    ------
    ValueError
        Margins outside [0, 1]; a biglide, whose regions have no ends.
    ArithmeticError
        A region fails its proof, known only of margins below 1e-4 with bars whose sums vanish.

    References
    ----------
    Wenger and Chablat 1997 (aspects); Chablat, Wenger and Angeles 2001 (curves of constant det A).

    Examples
    --------
    >>> import fivebar as fb
    >>> regions = fb.dexterous(fb.FiveBar(), det_A=0.3, sin=0.3)
    >>> all(region.area > 0 for region in regions)
    True
    """
    if max(det_A, sin) >= 1:
        return ()  # curves alone
    if det_A == sin == 0:
        return tuple(as_kind(DexterousRegion, part) for part in aspects(robot))
    robot = settled(robot)
    circles = LegCircles(robot, sin)
    levels = LevelCurves(robot, det_A, circles)
    singular = FiveBarLoci(robot).everywhere

    def active(working):
        if working in singular:
            return None
        return [*circles.pieces, *levels.pieces(working)]

    try:
        return numbered(
            parts(DexterousRegion, robot, active, circles.touches, det_A=det_A, sin=sin)
        )
    except ArithmeticError as error:
        if any(0 < margin < LEAST for margin in (det_A, sin)):
            raise ArithmeticError(f"{error}; margins of 0 or above {LEAST:g} may help") from None
        raise


def bent_parts(
    robot: FiveBar, working: Any, circles: LegCircles, det_A: float = 0.0
) -> list[Aspect]:
    """Return the parts of one working mode within circles of the legs, with |det A| >= det_A.

    The circles may have angles of their own, for the sides on which a leg is stretched or folded.
    The parts have no numbers.
    """
    loci = FiveBarLoci(robot)
    if working in loci.everywhere:
        return []
    pieces = [*circles.pieces, *LevelCurves(robot, det_A, circles).pieces(working)]
    touches = circles.touches
    if not (circles.sin or circles.bends or det_A):
        pieces = [piece for piece in loci.task if working in piece.working]
        touches = loci.touches
    found = []
    limits = det_A, circles.sin, circles.bends
    for assembly, area, boundary, punctures in in_mode(robot, pieces, touches, working, *limits):
        isolated = pairs(punctures)
        found.append(Aspect(robot, 0, working, assembly, area, boundary, isolated))
    return found
