"""The connected parts of an aspect in which constraints hold, with exact boundaries and areas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..base.backend import pairs
from ..singularities.aspects import Aspect
from ..singularities.leg_circles import size_of
from ..singularities.regions import LocusArc, crossings, roughly_inside
from .boundaries import GRID, facing, line_of
from .disc import BoundedAspect

SAME = 1e-6  # of the robot's size: ends of arcs that are nearer are one corner
CLOSING = "closing line"
SLIVER = 1e-7  # of the square of the size: a loop with a smaller area is rounding error


def feasible_parts(aspect: Aspect) -> tuple[Aspect, ...]:
    """Return the connected parts of an aspect, as `bounded_by` gives it, in which all constraints
    hold.

    Their boundaries are the parts of the aspect's and of the constraints' own curves. Areas are
    line integrals along them, and `area_error` says how exact they are: 1e-7 of the robot's size
    squared, and more where curves are traced and end in a cell of their grid, as those along which
    links meet do at the limit of reach. Gaps below 0.2 % of the size are not seen.
    """
    if not isinstance(aspect, BoundedAspect) or aspect.allowed is None:
        return (aspect,)
    size = size_of(aspect.robot)

    def within(z):
        # On the other side of a border the pose is in another assembly mode, or not reached.
        found, near = roughly_inside(aspect.boundary, z)
        found |= near
        found[found] = aspect.allowed(z[found])
        return found

    borders = [arc for loop in aspect.boundary for arc in loop]
    arcs = facing(borders, aspect.allowed, size, lambda z: np.zeros(len(z), bool))
    arcs += facing(aspect.walls, within, size)
    outer: list[tuple] = []
    holes: list[tuple] = []
    for loop in _loops(arcs, size):
        area = sum(arc.moment for arc in loop)
        if abs(area) > SLIVER * size**2:
            (outer if area > 0 else holes).append((area, loop))
    outer.sort(key=lambda each: each[0])  # a hole is in the smallest part around it
    parts = {k: [loop] for k, (_, loop) in enumerate(outer)}
    areas = [area for area, _ in outer]
    for area, loop in holes:
        around = [k for k, (_, own) in enumerate(outer) if crossings([own], loop[0].z[:1])[0]]
        if around:
            parts[around[0]].append(loop)
            areas[around[0]] += area
    found = []
    for k, loops in parts.items():
        isolated = aspect.punctures @ (1, 1j)
        punctures = pairs(isolated[crossings(loops, isolated)])
        boundary = tuple(map(tuple, loops))
        ends = [arc.z[[0, -1]] for loop in loops for arc in loop if arc.locus.kind == CLOSING]
        missing = sum(abs(last - first) for first, last in ends)
        found.append(
            replace(
                aspect,
                area=float(areas[k]),
                boundary=boundary,
                punctures=punctures,
                walls=(),
                area_error=SLIVER * size**2 + missing * size / GRID,
            )
        )
    return tuple(found)


def _loops(arcs: list[LocusArc], size: float) -> list[list[LocusArc]]:
    """Return the closed loops that arcs form, end to start; lines close what is left open."""
    ends = np.array([arc.z[-1] for arc in arcs], dtype=complex)
    starts = np.array([arc.z[0] for arc in arcs], dtype=complex)
    _, after = linear_sum_assignment(np.abs(ends[:, None] - starts))
    rest = set(range(len(arcs)))
    loops = []
    while rest:
        k = min(rest)
        loop = []
        while k in rest:
            rest.remove(k)
            loop.append(arcs[k])
            gap = line_of(ends[k], starts[after[k]])
            k = int(after[k])
            if abs(gap.points[1] - gap.points[0]).max() > SAME * size:
                loop.append(LocusArc(replace(gap, kind=CLOSING), 0.0, 1.0))
        loops.append(loop)
    return loops
