"""Aspects: the singularity-free components of the workspace in each working mode, bounded by the exact loci."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .._backend import real_numbers
from ..checks import instance, shown, takes
from ..models.dyads import SINGULAR
from ..models.geometry import task_pose
from ..models.robots import Biglide, FiveBar
from .faces import faces
from .loci import singularity_loci
from .locus import MODES, Vertex, pairs
from .margins import Singularity
from .regions import Arc, beside, crossings, inside, off_border, roomiest

SAME_AREA = 1e-6  # share to which the working modes' areas must agree; lost faces are far larger
SAMPLES = 120  # of a border, for an aspect's point
SEPARATE = 3e-8  # of the robot's size: a singular point that is nearer to an end of a locus is no puncture


@dataclass(frozen=True, eq=False)
class Aspect:
    """A connected part of the workspace in one working mode without any singularity, from `aspects`.

    number: counts from 1 over all working modes; working: pair of +1 and -1; assembly: +1 or -1; area m^2;
    point (2,) m: about the point of the aspect that is farthest from its boundary, clearance: its distance from it, m;
    boundary: loops of regions.Arc with the aspect on their left, the outer one first; punctures (n, 2) m: isolated
    singular points inside.
    """

    robot: FiveBar = field(repr=False)
    number: int
    working: tuple[int, int]
    assembly: int
    area: float
    point: np.ndarray
    clearance: float
    boundary: tuple = field(repr=False)
    punctures: np.ndarray = field(repr=False)

    @cached_property
    def polygons(self) -> tuple[np.ndarray, ...]:
        """The boundary's loops as points (n, 2), m, between which it turns by less than 1 degree."""
        return tuple(pairs(np.concatenate([arc.z[:-1] for arc in loop])) for loop in self.boundary)

    def contains(self, xi: ArrayLike) -> bool | np.ndarray:
        """Whether points xi (*batch, 2), m, are in the aspect, by its exact boundary, which is not: bool (*batch,)."""
        xi = real_numbers(xi, "xi")
        if xi.ndim == 0 or xi.shape[-1] != 2:
            raise ValueError(f"xi must have shape (2,) or (*batch, 2), not {xi.shape}")
        z = (xi @ (1, 1j)).ravel()
        found = -self.assembly * _det_a(self.robot, z, self.working) > SINGULAR  # which no nan is
        found[found] = inside(self.boundary, z[found])
        return found.reshape(xi.shape[:-1]) if xi.ndim > 1 else bool(found[0])


@takes(robot=instance(FiveBar, Biglide))
def aspects(robot: FiveBar) -> tuple[Aspect, ...]:
    """All aspects of a five-bar, a tuple of Aspect: by working mode (++, +-, -+, --), then by falling area.

    Areas are integrals along the loci. A mode in which every pose is singular has none. Parts that meet in a point only
    are two. ArithmeticError where an aspect fails its proof, by areas and signs of det A: no such robot is known.
    Wenger and Chablat 1997. ValueError for a biglide, whose aspects have no ends.
    """
    loci = singularity_loci(robot)
    if not robot.turns:
        raise ValueError(
            "aspects: the guides of a biglide have no ends, so its aspects are strips without ends and have no area, "
            "between the lines of singularity_loci(robot).task; areas need strokes of the feet, which it does not have"
        )
    size = robot.l11 + robot.l12 + robot.l21 + robot.l22 + robot.d

    def rank(face):
        # Equal areas of a symmetric robot differ by rounding: then the higher face is first, then the one to the right.
        _, _, area, (x, y), *_ = face
        return tuple(-round(value, 7) for value in (area / size**2, y / size, x / size))

    found = []
    for working in MODES:
        if working not in loci.everywhere:
            found += sorted(_in_mode(robot, loci, working, size), key=rank)
    areas = [
        sum(face[2] for face in found if face[0] == working) for working in MODES if working not in loci.everywhere
    ]
    if areas and max(areas) - min(areas) > SAME_AREA * max(areas):
        # Every mode has the same workspace: where the sums differ, faces were lost where loci touch.
        sums = ", ".join(f"{1e6 * area:.4f}" for area in areas)
        raise ArithmeticError(
            f"aspects: a part of the workspace was lost: the modes' areas are {sums} mm^2 and should be equal; please "
            "report this robot; lengths that differ by 1e-4 of their size may help"
        )
    return tuple(Aspect(robot, number, *face) for number, face in enumerate(found, start=1))


@takes(robot=instance(FiveBar, Biglide))
def aspect(robot: FiveBar, number: int) -> Aspect:
    """The aspect of that number; ValueError where there is none."""
    found = aspects(robot)
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not 1 <= number <= len(found):
        raise ValueError(f"number: no aspect {shown(number)}: this robot has {len(found)}, numbered from 1")
    return found[number - 1]


def _in_mode(robot, loci, working, size):
    """The aspects of one working mode: all but their numbers, unsorted."""
    active = [piece for piece in loci.task if working in piece.working]
    edges = _edges([piece for piece in active if len(piece.points) > 1], loci.touches)
    isolated = np.unique([piece.points[0] @ (1, 1j) for piece in active if len(piece.points) == 1]).astype(complex)
    ends = np.array([vertex.z for _, *both in edges for vertex in both])
    if len(isolated):
        isolated = isolated[[(np.abs(ends - z) > SEPARATE * size).all() for z in isolated]]
    for area, boundary in faces(edges, size):
        punctures = isolated[crossings(boundary, isolated)]
        found = roomiest(boundary, punctures, area, samples=SAMPLES)
        exact = found and inside(boundary, np.array([found[0][0]]))[0]  # of slivers the samples may tell it wrong
        point, clearance = found[0] if exact else off_border(boundary, size)
        det_a = float(_det_a(robot, np.array([point]), working)[0])
        if abs(det_a) > SINGULAR:  # it is nan in the faces that are holes of the workspace
            assembly = -1 if det_a > 0 else 1
            z = beside(boundary, clearance / 4)
            signs = -assembly * np.sign(_det_a(robot, z[inside(boundary, z)], working))
            if not (signs > 0).all():
                raise ArithmeticError(
                    f"aspects: in working modes {working} a locus was lost: det A has both signs around "
                    f"({point.real:.6g}, {point.imag:.6g}) m; please report this robot"
                )
            yield working, assembly, area, pairs(np.array(point)), clearance, boundary, pairs(punctures)


def _edges(pieces, touches):
    """(arc, vertex where it starts, where it ends): the pieces, circles cut where others end on them or touch them."""
    # Where a leg is in line on a Type-2 locus all along, this is one of the circles.
    pieces = [piece for piece in pieces if piece.type != Singularity.SERIAL | Singularity.PARALLEL]
    ends = {vertex for piece in pieces for vertex in piece.vertices} | set(touches)
    circles, edges, same = [], [], {}
    for piece in pieces:
        whole = Arc(piece, *piece.interval)
        first, last = piece.vertices or [Vertex(complex(whole.z[0]))] * 2
        cuts = [(whole.start, first), (whole.end, last)]
        if piece.circle:
            if any(_same(whole, other) for other in circles):
                continue
            circles.append(whole)
            passed = [vertex for vertex in ends - {first, last} if piece.circle in vertex.circles]
            cuts += [(s, vertex) for vertex in passed if (s := _parameter(whole, vertex.z)) is not None]
            cuts.sort(key=lambda cut: cut[0])
        for (low, one), (high, other) in zip(cuts, cuts[1:]):
            if high - low <= SEPARATE**2:
                same[one] = same.get(other, other)
            else:
                edges.append((Arc(piece, low, high), one, other))
    return [(arc, same.get(one, one), same.get(other, other)) for arc, one, other in edges]


def _parameter(circle, z):
    """Where a circle passes a point, None where its arc does not."""
    on, tangent = circle.curve(0.0)
    radius = tangent / 1j
    s = circle.start + (np.angle((z - on + radius) / radius) - circle.start) % (2 * np.pi)
    return float(s) if s <= circle.end else None


def _same(circle, other):
    """Whether two closed curves are one: bases in one point can give both legs the same circle."""
    if not (circle.locus.closed and other.locus.closed):
        return False
    thirds = circle.z[:: len(circle.z) // 3]
    return bool(other.nearest(thirds)[1].max() <= 1e-9 * np.abs(np.diff(other.z)).sum())


def _det_a(robot, z, working):
    return task_pose(robot, (z.real, z.imag), working).det_A
