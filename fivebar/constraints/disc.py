"""The largest disc in an aspect, touching its exact boundary.

It is searched on samples of the whole aspect, for the global optimum, then solved for on the exact
curves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np

from ..base.checks import instance, takes
from ..singularities.aspects import Aspect, as_kind
from ..singularities.locus import TRACED
from ..singularities.regions import LocusArc, points_of_largest_clearance
from .boundaries import boundaries, satisfied_at
from .constraints import ON_POSES, Constraints, kept_by
from .load import Load

# Candidates of the search that are solved for exactly, as far as their samples promise more than
# the best one found. Along a thin aspect there are many.
CANDIDATES = 40


@dataclass(frozen=True, eq=False)
class Disc:
    """A disc: center (2,) m, radius m."""

    center: np.ndarray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class BoundedAspect(Aspect):
    """An aspect in which constraints hold only in a part.

    walls: arcs across which a constraint is violated; allowed: a function that tells where none is;
    area_error: by how much the area, m^2, may be wrong.
    """

    walls: tuple = ()
    allowed: Callable | None = None
    area_error: float = 0.0


def bounded_by(aspect: Aspect, constraints: Constraints | None, load: Load | None = None) -> Aspect:
    """Return the aspect with the boundaries of the constraints on poses in it, and of a load."""
    constraints = constraints or Constraints()
    if load is None and not set(constraints.named) & set(ON_POSES):
        return aspect
    walls = boundaries(aspect.robot, aspect.working, constraints, load)
    return as_kind(BoundedAspect, aspect, walls, satisfied_at(aspect, constraints, load))


@takes(aspect=instance(Aspect), constraints=kept_by("fb.largest_disc"))
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
    0.078719
    """
    margin = constraints.clearance if constraints else 0.0
    aspect = bounded_by(aspect, constraints)
    center, clearance = farthest_point(aspect)
    if clearance and any(arc.locus.kind == TRACED for arc in arcs_of(aspect)):
        clearance = _largest_kept_radius(aspect, center, clearance)
    if clearance <= margin:
        raise ValueError(too_narrow(aspect, "disc", margin, clearance))
    return Disc(np.array([center.real, center.imag]), clearance - margin)


def farthest_point(aspect: Aspect) -> tuple[complex, float]:
    """Return the point of an aspect that is farthest from all boundaries, and its distance, m.

    The distance is 0 where no point keeps the constraints.
    """
    limits: dict[str, Any] = {}
    if isinstance(aspect, BoundedAspect):
        limits = {"walls": aspect.walls, "allowed": aspect.allowed}
    candidates = points_of_largest_clearance(
        aspect.boundary, punctures(aspect), aspect.area, CANDIDATES, **limits
    )
    best = 0j
    clearance = 0.0
    for z, coarse in candidates:
        if coarse <= clearance:
            break  # samples are never nearer than the boundary itself
        polished = _polished(aspect, z)
        exact = clearance_at(aspect, polished)
        if exact > clearance:
            best = polished
            clearance = exact
    return best, clearance


def _largest_kept_radius(aspect, z, clearance):
    """Return the radius up to which all rings around a point are allowed.

    Traced boundaries end short of the limit of reach, so the rings are sampled.
    """
    angles = np.linspace(0, 2 * np.pi, 721)[:-1]
    ring = np.exp(1j * angles)
    shares = np.append(1 - 1e-9, np.linspace(0.99, 0, 100))
    radii = clearance * shares

    def is_allowed(radius):
        return aspect.allowed(z + radius * ring).all()

    violated = []
    for k, radius in enumerate(radii[:-1]):
        if not is_allowed(radius):
            violated.append(k)
    if not violated:
        return clearance
    high = radii[violated[-1]]
    low = radii[violated[-1] + 1]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if is_allowed(middle) else (low, middle)
    return float(low)


def too_narrow(aspect: Aspect, shape: str, margin: float, clearance: float) -> str:
    """Return why a shape does not fit: its clearance is no more than the margin."""
    if not clearance:
        return f"no {shape} in aspect {aspect.number}: no pose in it keeps the constraints"
    return (
        f"no {shape} in aspect {aspect.number} keeps a clearance of {margin:g} m: its largest"
        f" clearance is {clearance:.6g} m"
    )


def punctures(aspect: Aspect) -> np.ndarray:
    return aspect.punctures @ (1, 1j)


def arcs_of(aspect: Aspect) -> list[LocusArc]:
    """Return all arcs that bound an aspect, those of constraints too."""
    return [*(arc for loop in aspect.boundary for arc in loop), *getattr(aspect, "walls", ())]


def clearance_at(aspect: Aspect, z: complex) -> float:
    """Return the exact distance of a point from the boundary and the punctures."""
    # No point of an arc is nearer than its samples by more than half a step.
    arcs = arcs_of(aspect)
    sampled = [np.abs(arc.z - z).min() for arc in arcs]
    of_punctures = np.abs(punctures(aspect) - z)
    clearance = min(sampled + of_punctures.tolist())
    for arc, least in zip(arcs, sampled):
        if least - 0.51 * arc.step <= clearance:
            _, distance = arc.nearest(np.array([z]))
            clearance = min(clearance, distance[0])
    return float(clearance)


def _polished(aspect, z):
    """Return the point near z that is farthest from all boundaries.

    It has equal distances to two or three feet on the exact curves.
    """
    samples = punctures(aspect)
    for arc in arcs_of(aspect):
        samples = np.append(samples, arc.z)
    clearance = clearance_at(aspect, z)
    for _ in range(4):
        before = clearance
        feet = _feet(aspect, z, 1.2 * clearance)
        proposals = []
        for chosen in [*combinations(feet, 2), *combinations(feet, 3)]:
            p = _equidistant(z, clearance, [foot[1:] for foot in chosen])
            if abs(p - z) < clearance:
                proposals.append((np.abs(samples - p).min(), p))
        for bound, p in sorted(proposals, key=lambda proposal: -proposal[0]):
            if bound <= clearance:
                break
            exact = clearance_at(aspect, p)
            if exact > clearance:
                z = p
                clearance = exact
        if clearance <= before * (1 + 1e-14):
            break
    return z


def _feet(aspect, z, within):
    """Return (distance, arc, parameter), or (distance, None, point), of the six nearest points."""
    feet = []
    for point in punctures(aspect):
        distance = abs(point - z)
        if distance <= within:
            feet.append((distance, None, complex(point)))
    for arc in arcs_of(aspect):
        for s, distance in zip(*arc.feet(z, within)):
            feet.append((distance, arc, float(s)))
            # Where arcs join, their curvatures differ, and the foot can rest there.
            if s in (arc.start, arc.end):
                feet.append((distance, None, complex(arc.at(s))))
    feet.sort(key=lambda foot: foot[0])
    return feet[:6]


def _equidistant(z, clearance, feet):
    """Return the point near z that has one distance from all feet; z where Newton's steps leave.

    The unknowns are the center, the distance and the feet's parameters. Two feet are to be on
    opposite sides.
    """
    curves = [k for k, (arc, _) in enumerate(feet) if arc is not None]

    @cache
    def on_curve(k, s):
        return tuple(map(complex, feet[k][0].curve(s)))

    def residual(v):
        center = complex(v[0], v[1])
        residuals = []
        ways = []
        parameters = iter(v[3:])
        for k, (arc, point) in enumerate(feet):
            if arc is None:
                way = center - point
            else:
                on, tangent = on_curve(k, next(parameters))
                way = center - on
                residuals.append((way * tangent.conjugate()).real / abs(tangent))
            residuals.append(abs(way) - v[2])
            ways.append(way)
        if len(feet) == 2:
            one, other = ways
            turn = (one * other.conjugate()).imag
            residuals.append(turn / clearance)
        return np.array(residuals)

    v = np.array([z.real, z.imag, clearance, *(feet[k][1] for k in curves)])
    steps = 1e-6 * np.ones(3 + len(curves))
    steps[:3] *= clearance
    for _ in range(12):
        columns = []
        for h, step in zip(np.diag(steps), steps):
            change = residual(v + h) - residual(v - h)
            columns.append(change / (2 * step))
        jacobian = np.stack(columns, axis=1)
        change = np.linalg.lstsq(jacobian, -residual(v), rcond=1e-9)[0]
        v = v + change
        center = complex(v[0], v[1])
        if not abs(center - z) < clearance:
            return z
        if np.abs(change / steps).max() < 1e-8:
            break
    return complex(v[0], v[1])
