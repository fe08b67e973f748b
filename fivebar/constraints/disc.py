"""The largest disc in an aspect, touching its exact boundary.

It is searched on samples of the whole aspect, for the global optimum, then solved for on the exact
curves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np

from ..base.checks import instance, optional, takes
from ..singularities.aspects import Aspect, as_kind
from ..singularities.regions import Arc, points_of_largest_clearance
from .boundaries import boundaries, satisfied_at
from .constraints import ON_POSES, Constraints, refuse_others

CANDIDATES = 4  # of the search, that are solved for exactly


@dataclass(frozen=True, eq=False)
class Disc:
    """center (2,) m, radius m."""

    center: np.ndarray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class BoundedAspect(Aspect):
    """An aspect within which something must be kept: walls, arcs across which it is not; allowed:
    where it is.
    """

    walls: tuple = ()
    allowed: Callable | None = None


def bounded_by(aspect: Aspect, constraints: Constraints | None) -> Aspect:
    """Return the aspect with the boundaries of the constraints on poses in it."""
    if constraints is None or not set(constraints.named) & set(ON_POSES):
        return aspect
    place = aspect.robot, aspect.working, constraints
    return as_kind(BoundedAspect, aspect, tuple(boundaries(*place)), satisfied_at(*place))


@takes(aspect=instance(Aspect), constraints=optional(instance(Constraints)))
def largest_disc(aspect: Aspect, constraints: Constraints | None = None) -> Disc:
    """Return the largest disc in an aspect.

    Its center is the point farthest from the boundary. There the disc touches three arcs, or two on
    opposite sides.

    Parameters
    ----------
    aspect : Aspect
        From `aspects`, `aspect` or `dexterous`.
    constraints : Constraints, optional
        Constraints on poses that hold all over the disc, and the clearance, m, of the disc from
        singularities and from the borders of the constraints.

    Returns
    -------
    Disc
        center (2,) m and radius, m. It is accurate to rounding error, with collisions to 1e-6 of
        the robot's size.

    Raises
    ------
    ValueError
        No disc keeps the clearance.

    Examples
    --------
    >>> import fivebar as fb
    >>> disc = fb.largest_disc(fb.aspect(fb.FiveBar(), 9))
    >>> round(disc.radius, 6)
    0.075248
    """
    refuse_others(constraints, "largest_disc", (*ON_POSES, "clearance"))
    margin = constraints.clearance if constraints else 0.0
    aspect = bounded_by(aspect, constraints)
    best, clearance = None, 0.0
    bounded = isinstance(aspect, BoundedAspect)
    own = dict(walls=aspect.walls, allowed=aspect.allowed) if bounded else {}
    for z, coarse in points_of_largest_clearance(
        aspect.boundary, punctures(aspect), aspect.area, CANDIDATES, **own
    ):
        if coarse <= clearance:
            break  # samples are never nearer than the boundary itself
        polished = _polished(aspect, z)
        if clearance_at(aspect, polished) > clearance:
            best, clearance = polished, clearance_at(aspect, polished)
    if clearance and bounded and constraints.collisions:
        clearance = _largest_kept_radius(aspect, best, clearance)
    if clearance <= margin:
        raise ValueError(too_narrow(aspect, "disc", margin, clearance))
    return Disc(np.array([best.real, best.imag]), clearance - margin)


def _largest_kept_radius(aspect, z, clearance):
    """The radius up to which all is kept on rings around a point: traced walls end short of the
    limit of reach.
    """
    ring = np.exp(1j * np.linspace(0, 2 * np.pi, 721)[:-1])
    radii = clearance * np.append(1 - 1e-9, np.linspace(0.99, 0, 100))
    broken = [
        k for k, radius in enumerate(radii[:-1]) if not aspect.allowed(z + radius * ring).all()
    ]
    if not broken:
        return clearance
    high, low = radii[broken[-1]], radii[broken[-1] + 1]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if aspect.allowed(z + middle * ring).all() else (low, middle)
    return float(low)


def too_narrow(aspect: Aspect, what: str, margin: float, clearance: float) -> str:
    return f"no {what} in aspect {aspect.number} keeps a clearance of {margin:g} m: " + (
        f"its point of largest clearance is {clearance:.6g} m from the next singularity"
        if clearance
        else "nothing of it is kept"
    )


def punctures(aspect: Aspect) -> np.ndarray:
    return aspect.punctures @ (1, 1j)


def arcs_of(aspect: Aspect) -> list[Arc]:
    """All that bounds it, walls too."""
    return [*(arc for loop in aspect.boundary for arc in loop), *getattr(aspect, "walls", ())]


def clearance_at(aspect: Aspect, z: complex) -> float:
    """Exact distance of a point to the boundary and the punctures."""
    # Samples tell which arcs can be nearest: nothing of an arc is nearer than its samples by more
    # than half a step.
    samples = [(np.abs(arc.z - z).min(), arc) for arc in arcs_of(aspect)]
    clearance = min([least for least, _ in samples] + np.abs(punctures(aspect) - z).tolist())
    near = [
        arc.nearest(np.array([z]))[1][0]
        for least, arc in samples
        if least - 0.51 * arc.step <= clearance
    ]
    return float(min([clearance, *near]))


def _polished(aspect, z):
    """The point near z that is farthest from all, by equal distances to two or three feet on the
    exact curves.
    """
    samples, clearance = (
        np.concatenate([punctures(aspect), *(arc.z for arc in arcs_of(aspect))]),
        clearance_at(aspect, z),
    )
    for _ in range(4):
        before, feet = clearance, _feet(aspect, z, 1.2 * clearance)
        chosen = [foot for count in (2, 3) for foot in combinations(feet, count)]
        proposals = [_equidistant(z, clearance, [foot[1:] for foot in each]) for each in chosen]
        most = [(np.abs(samples - p).min(), p) for p in proposals if abs(p - z) < clearance]
        for bound, p in sorted(most, key=lambda each: -each[0]):
            if bound <= clearance:
                break
            if (own := clearance_at(aspect, p)) > clearance:
                z, clearance = p, own
        if clearance <= before * (1 + 1e-14):
            break
    return z


def _feet(aspect, z, within, most=6):
    """(distance, arc or None, parameter or point) of the nearest points that block the way from
    z.
    """
    feet = [
        (abs(point - z), None, complex(point))
        for point in punctures(aspect)
        if abs(point - z) <= within
    ]
    for arc in arcs_of(aspect):
        for s, distance in zip(*arc.feet(z, within)):
            feet.append((distance, arc, float(s)))
            if s in (
                arc.start,
                arc.end,
            ):  # where arcs join, their curvatures differ and the foot can rest
                feet.append((distance, None, complex(arc.at(s))))
    feet.sort(key=lambda foot: foot[0])
    return feet[:most]


def _equidistant(z, clearance, feet):
    """Newton for the center, its distance to all feet, and their parameters; two feet are to be on
    opposite sides.
    """
    curves = [k for k, (arc, _) in enumerate(feet) if arc is not None]

    @cache
    def on_curve(k, s):
        return tuple(map(complex, feet[k][0].curve(s)))

    def residual(v):
        center, residuals, ways = complex(v[0], v[1]), [], []
        at = 3
        for k, (arc, where) in enumerate(feet):
            if arc is None:
                way = center - where
            else:
                on, tangent = on_curve(k, v[at])
                way = center - on
                residuals.append((way * tangent.conjugate()).real / abs(tangent))
                at += 1
            residuals.append(abs(way) - v[2])
            ways.append(way)
        if len(feet) == 2:
            residuals.append((ways[0] * ways[1].conjugate()).imag / clearance)
        return np.array(residuals)

    v = np.array([z.real, z.imag, clearance, *(feet[k][1] for k in curves)])
    steps = 1e-6 * np.array([clearance, clearance, clearance, *(1.0 for _ in curves)])
    for _ in range(12):
        jacobian = np.stack(
            [
                (residual(v + h) - residual(v - h)) / (2 * step)
                for h, step in zip(np.diag(steps), steps)
            ],
            axis=1,
        )
        change = np.linalg.lstsq(jacobian, -residual(v), rcond=1e-9)[0]
        v = v + change
        if not abs(complex(v[0], v[1]) - z) < clearance:
            return z
        if np.abs(change / steps).max() < 1e-8:
            break
    return complex(v[0], v[1])
