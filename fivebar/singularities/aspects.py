"""Aspects: the singularity-free components of the workspace in each working mode, bounded by the
exact loci.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import pairs, real_numbers
from ..base.checks import shown
from ..base.robot_uses import takes_robot
from ..models.dyads import SINGULAR
from ..models.geometry import Pose, task_pose
from ..models.robots import FiveBar
from .degenerate import settled
from .faces import SLIVER, faces
from .five_bar_loci import FiveBarLoci
from .leg_circles import size_of
from .locus import MODES, Vertex
from .margins import Singularity
from .mirror import Mirror
from .regions import LocusArc, beside, crossings, inside, off_border, points_of_largest_clearance

SAME_AREA = 1e-6  # share to which the working modes' areas must agree; lost faces are far larger
SAMPLES = 120  # of a border, for an aspect's point
ROUNDING = 1e-13  # of det A and the sines
LONG = 0.02  # of the robot's size: of an arc that bounds more than a sliver
SEPARATE = (
    3e-8  # of the robot's size: a singular point that is nearer to an end of a locus is no puncture
)


@dataclass(frozen=True, eq=False, repr=False)
class Aspect:
    """A connected part of the workspace in one working mode without any singularity, from
    `aspects`.

    number: counts from 1 over all working modes; working: pair of +1 and -1; assembly: +1 or -1;
        area m^2;
    boundary: loops of regions.LocusArc with the aspect on their left, the outer one first;
        punctures (n, 2) m: isolated singular points inside.
    """

    robot: FiveBar
    number: int
    working: tuple[int, int]
    assembly: int
    area: float
    boundary: tuple
    punctures: np.ndarray

    def __repr__(self) -> str:
        names = ("number", "working", "assembly", "area", "point")
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__name__}({values})"

    @cached_property
    def point(self) -> np.ndarray:
        """(2,) m: about the point that is farthest from the boundary; `largest_disc` gives it
        exactly.
        """
        found = points_of_largest_clearance(
            self.boundary, self.punctures @ (1, 1j), self.area, samples=SAMPLES
        )
        # Of slivers the samples may tell it wrong.
        if found and inside(self.boundary, np.array([found[0][0]]))[0]:
            z = found[0][0]
        else:
            z = off_border(self.boundary, size_of(self.robot))
        return pairs(np.array(z))

    @cached_property
    def polygons(self) -> tuple[np.ndarray, ...]:
        """The boundary's loops as points (n, 2), m, between which it turns by less than 1
        degree.
        """
        return tuple(_polygon(loop) for loop in self.boundary)

    def contains(self, xi: ArrayLike) -> bool | np.ndarray:
        """Return whether points xi (*batch, 2), m, are in the aspect, by its exact boundary, which
        is not: bool (*batch,).
        """
        xi = real_numbers(xi, "xi")
        if xi.ndim == 0 or xi.shape[-1] != 2:
            raise ValueError(f"xi must have shape (2,) or (*batch, 2), not {xi.shape}")
        z = (xi @ (1, 1j)).ravel()
        found = (
            -self.assembly * task_pose(self.robot, (z.real, z.imag), self.working).det_A > SINGULAR
        )  # which no nan is
        found[found] = inside(self.boundary, z[found])
        if xi.ndim > 1:
            return found.reshape(xi.shape[:-1])
        return bool(found[0])


def _polygon(loop):
    return pairs(np.concatenate([arc.z[:-1] for arc in loop]))


def as_kind(kind: type[Any], aspect: Aspect, *more: object) -> Any:
    """Return the aspect as one of a class derived from it, with what that has more."""
    return kind(*(getattr(aspect, each.name) for each in fields(Aspect)), *more)


@takes_robot()
def aspects(robot: FiveBar) -> tuple[Aspect, ...]:
    """Return all aspects of a five-bar: the connected sets of regular poses in a working mode.

    They are ordered by working mode (++, +-, -+, --), then by falling area. Areas are integrals
    along the loci. A mode in which every pose is singular has none. Parts that meet in a point only
    are two. Where lengths almost sum to 0, to 3e-11 of their sum, the aspects are those of the
    robot in which they do, which `Aspect.robot` is.

    Parameters
    ----------
    robot : FiveBar

    Returns
    -------
    tuple of Aspect

    Raises
    ------
    ValueError
        For a biglide, whose aspects have no ends.
    ArithmeticError
        An aspect fails its proof, by areas and signs of det A. No such robot is known.

    References
    ----------
    Wenger and Chablat, Definition sets for the direct kinematics of parallel manipulators, 1997.

    Examples
    --------
    >>> import fivebar as fb
    >>> len(fb.aspects(fb.FiveBar()))
    10
    """
    robot = settled(robot)
    loci = FiveBarLoci(robot)

    def active(working):
        everywhere = working in loci.everywhere
        if everywhere:
            return None
        return [piece for piece in loci.task if working in piece.working]

    found = numbered(parts(Aspect, robot, active, loci.touches))
    areas = []
    for working in MODES:
        if working not in loci.everywhere:
            areas.append(sum(part.area for part in found if part.working == working))
    if (
        areas
        and max(areas) - min(areas) > SAME_AREA * max(areas) + 4 * SLIVER * size_of(robot) ** 2
    ):
        # Every mode has the same workspace: where the sums differ, faces were lost where loci
        # touch.
        sums = ", ".join(f"{1e6 * area:.4f}" for area in areas)
        raise ArithmeticError(
            f"aspects: a part of the workspace was lost: the modes' areas are {sums} mm² and should"
            " be equal; please report this robot; lengths that differ by 1e-4 of their size may"
            " help"
        )
    return found


@takes_robot()
def aspect(robot: FiveBar, number: int) -> Aspect:
    """Return the aspect of a number, as `aspects` counts them from 1.

    Parameters
    ----------
    robot : FiveBar
    number : int

    Returns
    -------
    Aspect

    Raises
    ------
    ValueError
        There is no such aspect.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.aspect(fb.FiveBar(), 9).working
    (-1, -1)
    """
    found = aspects(robot)
    if not isinstance(number, (int, np.integer)) or not 1 <= number <= len(found):
        raise ValueError(
            f"number: no aspect {shown(number)}: this robot has {len(found)}, numbered from 1"
        )
    return found[number - 1]


def numbered(found: Iterable[Any]) -> tuple[Any, ...]:
    """Sorted by working mode, then by falling area, and numbered so."""
    found = list(found)
    if not found:
        return ()
    size = size_of(found[0].robot)
    area = {id(part): (MODES.index(part.working), -round(part.area / size**2, 7)) for part in found}
    often = Counter(area.values())

    def rank(part):
        # Equal areas of a symmetric robot differ by rounding: then the higher face is first, then
        # the one to the right.
        if often[area[id(part)]] > 1:
            place = tuple(-round(each / size, 7) for each in part.point[::-1])
        else:
            place = ()
        return (*area[id(part)], *place)

    found.sort(key=rank)
    for number, part in enumerate(found, start=1):
        object.__setattr__(part, "number", number)  # known only now
    return tuple(found)


def parts(
    kind: type[Any], robot: FiveBar, active: Callable, touches: tuple, **levels: float
) -> Iterator[Any]:
    """Yield the parts of all working modes in which |det A| >= det_A and |sin q_i2| >= sin, as
    `kind`, without numbers.

    active: working mode -> its boundaries, a list of Locus, or None where it has no part; touches:
    vertices of circles that touch; levels: det_A and sin. The modes with a left elbow of the other
    kind are the mirror images in the line
    of the bases: q -> -q.
    """
    for working in MODES[:2]:
        pieces = active(working)
        if pieces is None:
            continue
        mirror = Mirror(pieces)
        limits = levels.get("det_A", 0.0), levels.get("sin", 0.0)
        for assembly, area, boundary, punctures in in_mode(
            robot, pieces, touches, working, *limits
        ):
            yield kind(robot, 0, working, assembly, area, boundary, pairs(punctures), **levels)
            other = (-working[0], -working[1])
            image = mirror.loops(boundary)
            mirrored = pairs(punctures.conj())
            yield kind(robot, 0, other, -assembly, area, image, mirrored, **levels)


def in_mode(
    robot: FiveBar,
    pieces: list,
    touches: tuple,
    working: tuple[int, ...],
    det_A: float = 0.0,
    sin: float = 0.0,
    bends: Mapping = MappingProxyType({}),
) -> Iterator[tuple]:
    """Yield the parts of one working mode: assembly mode, area, boundary, punctures.

    bends: of `LegCircles`, which bound the parts.
    """
    size = size_of(robot)
    edges = _edges([piece for piece in pieces if len(piece.points) > 1], touches)
    isolated = np.unique(
        [piece.points[0] @ (1, 1j) for piece in pieces if len(piece.points) == 1]
    ).astype(complex)
    ends = np.array([vertex.z for _, *both in edges for vertex in both])
    if len(isolated):
        isolated = isolated[[(np.abs(ends - z) > SEPARATE * size).all() for z in isolated]]
    for assembly, area, boundary in _proved(robot, edges, working, det_A, sin, bends):
        yield assembly, area, boundary, isolated[crossings(boundary, isolated)]


def _proved(robot, edges, working, det_A, sin, bends):
    """Yield faces of the edges that are inside: assembly mode, area, boundary; ArithmeticError
    where one is not wholly.
    """
    size = size_of(robot)
    levels = {}
    for area, boundary in faces(edges, size):
        z = beside(boundary, size)
        pose = task_pose(robot, (z.real, z.imag), working)
        room = least_margin(pose, det_A, sin, bends)
        if not (room > SINGULAR).any():  # nan in the faces that are holes of the workspace
            continue
        signs = -np.sign(pose.det_A[~(np.abs(room) <= ROUNDING)])
        if (room < -ROUNDING).any() or np.ptp(signs) != 0:
            raise ArithmeticError(
                f"in working modes {working} a boundary was lost: around ({z[0].real:.6g},"
                f" {z[0].imag:.6g}) m det A or the sines are on both sides of it; please report"
                " this robot"
            )
        for arc in (arc for loop in boundary for arc in loop if not arc.locus.circle):
            key = id(arc.locus), min(arc.start, arc.end)
            levels[key] = levels.get(key, 0) + 1
        yield int(signs[0]), area, boundary
    if det_A:  # of a curve of det A one side is inside, the other is not
        for arc, *_ in edges:
            sides = levels.get((id(arc.locus), arc.start), 0)
            if not arc.locus.circle and (
                sides > 1 or (sides < 1 and np.abs(np.diff(arc.z)).sum() > LONG * size)
            ):
                raise ArithmeticError(
                    f"in working modes {working} a region at the curve of det A around"
                    f" ({arc.z[0].real:.6g}, {arc.z[0].imag:.6g}) m was lost or is two; please"
                    " report this robot"
                )


def least_margin(pose: Pose, det_A: float, sin: float, bends: Mapping) -> np.ndarray:
    """Return the least of |det A| - det_A, |sin q_i2| - sin, and of the sines of how much farther
    the legs are bent than on the circles of `bends`: (*batch,), below 0 beyond a border.
    """
    margins = [np.abs(pose.det_A) - det_A, *(np.abs(sine) - sin for sine in pose.sines)]
    for (leg, side), (cosine, sine) in bends.items():
        x1, y1 = pose.legs[leg].direction
        x2, y2 = pose.u2[leg]
        margins.append(np.abs(pose.sines[leg]) * cosine - side * sine * (x1 * x2 + y1 * y2))
    return np.min(margins, axis=0)


def _edges(pieces, touches):
    """Return (arc, vertex where it starts, where it ends): the pieces, circles cut where others end
    on them or touch them.
    """
    # Where a leg is in line on a Type-2 locus all along, this is one of the circles.
    pieces = [piece for piece in pieces if piece.type != Singularity.SERIAL | Singularity.PARALLEL]
    ends = {vertex for piece in pieces for vertex in piece.vertices} | set(touches)
    circles = []
    edges = []
    same = {}
    for piece in pieces:
        whole = LocusArc(piece, *piece.interval)
        first, last = piece.vertices or [Vertex(complex(whole.z[0]))] * 2
        cuts = [(whole.start, first), (whole.end, last)]
        if piece.circle:
            if any(_same(whole, other) for other in circles):
                continue
            circles.append(whole)
            passed = [vertex for vertex in ends - {first, last} if piece.circle in vertex.circles]
            cuts += [
                (s, vertex) for vertex in passed if (s := _parameter(whole, vertex.z)) is not None
            ]
            cuts.sort(key=lambda cut: cut[0])
        for (low, one), (high, other) in zip(cuts, cuts[1:]):
            if high - low <= SEPARATE**2:
                same[one] = same.get(other, other)
            else:
                edges.append((LocusArc(piece, low, high), one, other))
    return [(arc, same.get(one, one), same.get(other, other)) for arc, one, other in edges]


def _parameter(circle, z):
    """Return where a circle passes a point, None where its arc does not."""
    on, tangent = circle.curve(0.0)
    radius = tangent / 1j
    s = circle.start + (np.angle((z - on + radius) / radius) - circle.start) % (2 * np.pi)
    return float(s) if s <= circle.end else None


def _same(circle, other):
    """Return whether two closed curves are one: bases in one point can give both legs the same
    circle.
    """
    if not (circle.locus.closed and other.locus.closed):
        return False
    thirds = circle.z[:: len(circle.z) // 3]
    return bool(other.nearest(thirds)[1].max() <= 1e-9 * np.abs(np.diff(other.z)).sum())
