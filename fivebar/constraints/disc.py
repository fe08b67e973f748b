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

from ..base.checks import instance, not_negative, optional, takes
from ..singularities.aspects import Aspect, as_kind
from ..singularities.regions import Arc, points_of_largest_clearance
from .boundaries import kept_at, walls
from .constraints import Keep

CANDIDATES = 4  # of the search, that are solved for exactly


@dataclass(frozen=True, eq=False)
class Disc:
    """center (2,) m, radius m."""

    center: np.ndarray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Walled(Aspect):
    """An aspect within which something must be kept: walls, arcs across which it is not; allowed:
    where it is.
    """

    walls: tuple = ()
    allowed: Callable | None = None


def walled(aspect: Aspect, keep: Keep | None) -> Aspect:
    """The aspect with the walls of what must be kept in it."""
    if keep is None:
        return aspect
    own = aspect.robot, aspect.working, keep
    return as_kind(Walled, aspect, tuple(walls(*own)), kept_at(*own))


@takes(aspect=instance(Aspect), margin=not_negative, keep=optional(instance(Keep)))
def largest_disc(aspect: Aspect, margin: float = 0.0, keep: Keep | None = None) -> Disc:
    """The largest disc in an aspect that keeps `margin`, m, from all its singularities: Disc.

    keep: what else is kept all over the disc, by the same margin. Its center is the point farthest
    from the boundary: there the disc touches three arcs, or two on opposite sides; exactly, but for
    where bars touch, 1e-6 of the robot. ValueError where no disc keeps the margin.
    """
    aspect = walled(aspect, keep)
    best, room = None, 0.0
    own = dict(walls=aspect.walls, allowed=aspect.allowed) if isinstance(aspect, Walled) else {}
    for z, coarse in points_of_largest_clearance(
        aspect.boundary, punctures(aspect), aspect.area, CANDIDATES, **own
    ):
        if coarse <= room:
            break  # samples are never nearer than the boundary itself
        polished = _polished(aspect, z)
        if room_at(aspect, polished) > room:
            best, room = polished, room_at(aspect, polished)
    if room and isinstance(aspect, Walled) and keep.bars:
        room = _kept_room(aspect, best, room)
    if room <= margin:
        raise ValueError(too_narrow(aspect, "disc", margin, room))
    return Disc(np.array([best.real, best.imag]), room - margin)


def _kept_room(aspect, z, room):
    """The radius up to which all is kept on rings around a point: traced walls end short of the
    limit of reach.
    """
    ring = np.exp(1j * np.linspace(0, 2 * np.pi, 721)[:-1])
    radii = room * np.append(1 - 1e-9, np.linspace(0.99, 0, 100))
    broken = [
        k for k, radius in enumerate(radii[:-1]) if not aspect.allowed(z + radius * ring).all()
    ]
    if not broken:
        return room
    high, low = radii[broken[-1]], radii[broken[-1] + 1]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if aspect.allowed(z + middle * ring).all() else (low, middle)
    return float(low)


def too_narrow(aspect: Aspect, what: str, margin: float, room: float) -> str:
    return f"no {what} in aspect {aspect.number} keeps a margin of {margin:g} m: " + (
        f"its roomiest point is {room:.6g} m from the next singularity"
        if room
        else "nothing of it is kept"
    )


def punctures(aspect: Aspect) -> np.ndarray:
    return aspect.punctures @ (1, 1j)


def arcs_of(aspect: Aspect) -> list[Arc]:
    """All that bounds it, walls too."""
    return [*(arc for loop in aspect.boundary for arc in loop), *getattr(aspect, "walls", ())]


def room_at(aspect: Aspect, z: complex) -> float:
    """Exact distance of a point to the boundary and the punctures."""
    # Samples tell which arcs can be nearest: nothing of an arc is nearer than its samples by more
    # than half a step.
    samples = [(np.abs(arc.z - z).min(), arc) for arc in arcs_of(aspect)]
    room = min([least for least, _ in samples] + np.abs(punctures(aspect) - z).tolist())
    near = [
        arc.nearest(np.array([z]))[1][0]
        for least, arc in samples
        if least - 0.51 * arc.step <= room
    ]
    return float(min([room, *near]))


def _polished(aspect, z):
    """The point near z that is farthest from all, by equal distances to two or three feet on the
    exact curves.
    """
    samples, room = (
        np.concatenate([punctures(aspect), *(arc.z for arc in arcs_of(aspect))]),
        room_at(aspect, z),
    )
    for _ in range(4):
        before, feet = room, _feet(aspect, z, 1.2 * room)
        chosen = [foot for count in (2, 3) for foot in combinations(feet, count)]
        proposals = [_equidistant(z, room, [foot[1:] for foot in each]) for each in chosen]
        most = [(np.abs(samples - p).min(), p) for p in proposals if abs(p - z) < room]
        for bound, p in sorted(most, key=lambda each: -each[0]):
            if bound <= room:
                break
            if (own := room_at(aspect, p)) > room:
                z, room = p, own
        if room <= before * (1 + 1e-14):
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


def _equidistant(z, room, feet):
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
            residuals.append((ways[0] * ways[1].conjugate()).imag / room)
        return np.array(residuals)

    v = np.array([z.real, z.imag, room, *(feet[k][1] for k in curves)])
    steps = 1e-6 * np.array([room, room, room, *(1.0 for _ in curves)])
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
        if not abs(complex(v[0], v[1]) - z) < room:
            return z
        if np.abs(change / steps).max() < 1e-8:
            break
    return complex(v[0], v[1])
