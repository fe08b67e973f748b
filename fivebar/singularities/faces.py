"""Faces of the plane between arcs that meet at their ends."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .locus import Vertex
from .regions import LocusArc, inside

SLIVER = 1e-12  # faces of a smaller share of the size's square are rounding errors


def faces(edges: list[tuple[LocusArc, Vertex, Vertex]], size: float) -> list[tuple[float, tuple]]:
    """Return faces of the planar graph of arcs that meet at their ends only: (area, loops), arcs
    with the face on their left.

    edges: (arc, the vertex where it starts, where it ends); size: of the whole, m. The first loop
    is the outer one. A hole belongs to the innermost outer loop around it.
    """
    numbers: dict = {}
    corners = [numbers.setdefault(vertex, len(numbers)) for _, *ends in edges for vertex in ends]
    links = coo_array(
        (np.ones(len(edges)), (corners[::2], corners[1::2])), shape=(len(numbers),) * 2
    )
    parts = connected_components(links)[1]
    sides = [
        side for arc, *_ in edges for side in (arc, arc.reversed)
    ]  # side k starts at corners[k], its twin is k ^ 1
    outer = []
    holes = []
    small: dict[int, list] = {}
    for cycle in _cycles(sides, corners, size):
        loop = tuple(sides[k] for k in cycle)
        area = sum(side.moment for side in loop)
        part = parts[corners[cycle[0]]]
        if area > SLIVER * size**2:
            outer.append((area, part, [loop]))
        elif area < -SLIVER * size**2:
            holes.append((area, part, loop))
        else:
            small.setdefault(part, []).append((_swept(loop), area, loop))
    # What all of it is small has one cycle around it, a hole in what is around; the others are
    # rounding errors.
    large = {part for _, part, _ in holes}
    for part, loops in small.items():
        if part not in large:
            _, area, loop = min(loops, key=lambda each: each[0])
            holes.append((area, part, loop))
    inner = [0.0] * len(outer)
    for area, part, loop in holes:
        start = loop[0].z[:1]
        around = [
            k
            for k, other in enumerate(outer)
            if other[1] != part and inside(other[2][:1], start)[0]
        ]
        if around:
            owner = min(around, key=lambda k: outer[k][0])
            outer[owner][2].append(loop)
            inner[owner] += area
    found = [(area + hole, tuple(loops)) for (area, _, loops), hole in zip(outer, inner)]
    return [(area, loops) for area, loops in found if area > SLIVER * size**2]


def _swept(loop):
    """Return the area about one of its points, of a loop so small that integrals about the origin
    are rounding errors.
    """
    z = np.concatenate([side.z[:-1] for side in loop])
    z = z - z[0]
    return float((z.conj() * np.roll(z, -1)).imag.sum())


def _cycles(sides, corners, size):
    """Return closed walks along the sides that keep the face on their left: at a vertex, the first
    side clockwise.
    """
    at = {}
    for k in range(len(sides)):
        at.setdefault(corners[k], []).append(k)
    follows = {}
    for outgoing in at.values():
        order = _around(sides, outgoing, size)
        for k, clockwise in zip(order, [order[-1], *order[:-1]]):
            follows[k ^ 1] = clockwise
    cycles = []
    left = set(range(len(sides)))
    while left:
        cycle = [min(left)]
        while follows[cycle[-1]] != cycle[0]:
            cycle.append(follows[cycle[-1]])
        left -= set(cycle)
        cycles.append(cycle)
    return cycles


def _around(sides, outgoing, size):
    """Return the sides that leave a vertex, counterclockwise."""
    if len(outgoing) < 3:
        return outgoing
    curves = [k for k in outgoing if not sides[k].locus.circle]
    if (
        len(outgoing) == 3
        and len(curves) == 1
        and len({sides[k].locus.circle for k in outgoing}) == 2
    ):
        # However flatly a locus ends on a circle, it does on the side that the leg reaches: of a
        # stretched one, inside.
        back, ahead = sorted(
            (k for k in outgoing if k not in curves), key=lambda k: sides[k].start < sides[k].end
        )
        if sides[ahead].locus.circle[1] > 0:
            between = curves
        else:
            between = []
        return [ahead, *between, back, *(curves if not between else [])]
    # Loci touch at vertices. On a small circle around the vertex even curves with one tangent are
    # told apart.
    radius = min(1e-3 * size, 0.3 * min(sides[k].extent for k in outgoing))
    return sorted(outgoing, key=lambda k: np.angle(sides[k].leaves(radius) - sides[k].z[0]))
