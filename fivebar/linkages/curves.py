"""Coupler curves: all that a coupler point can trace, on both branches; and the five-bar's Type-2
locus as such.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.checks import RATIO, SHORTEST, instance, takes, text, whole
from ..models.robots import FiveBar
from .four_bar import FourBar
from .limits import crank_range
from .moving import move


@dataclass(frozen=True, eq=False)
class Curve:
    """A closed curve.

    Attributes
    ----------
    label : str
    points : (n, 2), m
    locks : (k, 2), m
        Where the mechanism locks: the crank can only turn back, on the other branch.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.coupler_curves(linkages.FourBar(0.2, 0.06, 0.16, 0.14))[0].label
    'coupler curve'
    """

    label: str
    points: np.ndarray
    locks: np.ndarray | tuple = ()


@takes(four_bar=instance(FourBar), label=text, samples=whole(3, 10**6))
def coupler_curves(
    four_bar: FourBar, label: str = "coupler curve", samples: int = 1440
) -> tuple[Curve, ...]:
    """Return every closed curve that the coupler point M can trace.

    A crank that turns gives one for each branch; a crank that rocks goes back on the other branch.

    Parameters
    ----------
    four_bar : FourBar
    label : str
        Of the curves.
    samples : int
        Points of a curve.

    Returns
    -------
    tuple of Curve

    Examples
    --------
    >>> from fivebar import linkages
    >>> len(linkages.coupler_curves(linkages.FourBar(0.2, 0.06, 0.16, 0.14)))
    2
    """
    allowed, curves = crank_range(four_bar), []
    if allowed.full:
        q = np.linspace(-np.pi, np.pi, samples + 1)
        paths = [move(four_bar, q, branch=branch).position("M") for branch in (1, -1)]
        curves = [Curve(label, points) for points in paths]
    for low, high in () if allowed.full else allowed.intervals:
        # The dyad's height is a square root at either end: even steps of this angle are nearly even
        # on the curve.
        turn = np.linspace(0, 2 * np.pi, samples + 1)
        # A little inside, or rounding could leave the loop open where it locks.
        q = (low + high) / 2 - ((high - low) / 2 - 1e-14) * np.cos(turn)
        points = move(four_bar, q, branch=np.where(turn < np.pi, 1, -1)).position("M")
        curves.append(Curve(label, points, points[[0, samples // 2]]))
    return tuple(curves)


@takes(robot=instance(FiveBar), samples=whole(3, 10**6))
def type_2_curves(robot: FiveBar, samples: int = 1440) -> tuple[Curve, ...]:
    """Return the Type-2 locus of a five-bar in task space as coupler curves.

    Distal bars in line are one coupler, l12 + l22 long (stretched) or |l12 - l22| (folded), with
    the end-effector on it at l12 from the left elbow. Equal distal bars fold to a point: circles of
    self-motion.

    Parameters
    ----------
    robot : FiveBar
    samples : int
        Points of a curve.

    Returns
    -------
    tuple of Curve

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar import linkages
    >>> len(linkages.type_2_curves(fb.FiveBar())) > 0
    True
    """
    curves = []
    base = (-robot.d / 2, 0.0)
    for label, reach in (
        ("Type 2, stretched", robot.l12 + robot.l22),
        ("Type 2, folded", robot.l12 - robot.l22),
    ):
        sides = robot.d, robot.l11, abs(reach), robot.l21
        if robot.d == 0:
            raise ValueError("type_2_curves: with d = 0 the ground of the four-bar has no length")
        if reach == 0:
            curves += _self_motion(robot, samples)
        elif abs(reach) < max(SHORTEST, max(sides) / RATIO):
            raise ValueError(
                f"type_2_curves: l12 and l22 differ by {abs(reach):.3g} m, too little for a"
                " coupler; singularity_loci traces this locus too"
            )
        elif 2 * max(sides) <= sum(sides):
            point = (robot.l12 if reach > 0 else -robot.l12, 0.0)
            traced = coupler_curves(FourBar(*sides, point=point, base=base), label, samples)
            curves += [Curve(label, curve.points) for curve in traced]
    return tuple(curves)


def _self_motion(robot, samples):
    """Circles about the points in which the elbows of equal distal bars coincide."""
    along = (robot.d**2 + robot.l11**2 - robot.l21**2) / (2 * robot.d)
    square = robot.l11**2 - along**2
    turn = np.linspace(0, 2 * np.pi, samples + 1)
    circle = robot.l12 * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    if square < 0:
        return []
    height = np.sqrt(square)
    return [
        Curve("Type 2, elbows coincide", circle + (along - robot.d / 2, y))
        for y in dict.fromkeys((height, -height))
    ]
