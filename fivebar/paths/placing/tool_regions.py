"""The aspects as a tool beside the joint sees them: exact images of those of joint C.

In a working mode the place of C tells that of the tool, T = C + (along + i across) u, and the other
way about, but where the proximal bar is in line with the tool: there the map folds. The leg is bent
by a constant angle on that fold, so that it is a circle of the leg, as Type 1 is. So the parts of
an aspect up to this circle are mapped one to one, and their boundaries onto the tool's.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.backend import pairs
from ...base.progress import progress
from ...base.robot_uses import takes_robot
from ...constraints.boundaries import facing, polyline
from ...constraints.constraints import Constraints, kept_by
from ...constraints.disc import BoundedAspect, bounded_by
from ...constraints.load import Load
from ...models.geometry import igm, task_pose
from ...models.robots import FiveBar
from ...singularities.aspects import Aspect, as_kind, least_margin, numbered
from ...singularities.degenerate import settled
from ...singularities.dexterous import bent_parts
from ...singularities.leg_circles import LegCircles, size_of
from ...singularities.locus import MODES, TRACED, pieces_of
from ...singularities.margins import Singularity
from ...singularities.regions import LocusArc, inside, roughly_inside
from ..tool import MountedTool, Tool

IN_LINE = 1e-6  # a sine: nearer to Type 1 an end of a curve is one where the bar turns fast
FLAT = 3e-8  # a sine whose square is rounding error
SAME = 1e-7  # of the robot's size: places that are nearer are one
CLOSES = 1e-5  # of it, by which two images of a corner may differ, next to the base joint
BESIDE = 1e-5, 1e-8  # of a curve: so far from such an end its tangent, its points are read
ROOT = (1e-4, 1 - 1e-4), (1e-2, 1 - 1e-2)  # of an arc: here a root is 0.1 of it there, a line 0.01
PANELS = np.arange(64)[:, None] / 64
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
PLACES = (PANELS + (1 + NODES) / 128).ravel()  # of a curve's x, for its integral
SHARES = np.tile(WEIGHTS / 128, 64)


@dataclass(frozen=True, eq=False, repr=False)
class ToolRegion(BoundedAspect):
    """A part of the plane in which a tool moves without a singularity, from `tool_regions`.

    All that an Aspect has, of the tool's places. mounted: the tool on its robot.
    """

    mounted: Any = field(default=None)

    def contains(self, xi: ArrayLike) -> bool | np.ndarray:
        """Return whether the tool may be at points xi (*batch, 2), m: bool (*batch,)."""
        points = np.asarray(xi, float)
        joint = self.mounted.joint(points)
        reached = np.isfinite(joint[..., 0]).ravel()
        z = (points @ (1, 1j)).ravel()
        reached[reached] = inside(self.boundary, z[reached])
        return reached.reshape(points.shape[:-1]) if points.ndim > 1 else bool(reached[0])


@takes_robot(constraints=kept_by("fb.tool_regions"))
def tool_regions(
    tool: Tool,
    robot: FiveBar,
    working: tuple[int, int] | None = None,
    constraints: Constraints | None = None,
    load: Load | None = None,
) -> tuple[ToolRegion, ...]:
    """Return the regions of a tool, numbered as `aspects` are.

    Parameters
    ----------
    tool : Tool
    robot : FiveBar
    working : (2,), optional
        Working modes; by default all.
    constraints : Constraints, optional
        Constraints on poses; half-planes and the region are those of joint C.
    load : Load, optional
        That the motors hold.

    Returns
    -------
    tuple of ToolRegion

    Raises
    ------
    ArithmeticError
        A boundary does not close. No such robot is known.

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar.paths.placing.tool_regions import tool_regions
    >>> len(tool_regions(fb.Tool(1, 0.02), fb.FiveBar(), (-1, -1)))
    2
    """
    constraints = constraints or Constraints()
    margins = constraints.det_A, constraints.sin
    found: list[ToolRegion] = []
    for mode in progress(MODES, desc="regions of the tool", delay=2, leave=False):
        # Walls of the constraints take long: modes that are only counted go without.
        walls = Constraints(), None
        if working in (None, mode):
            walls = replace(constraints, det_A=0.0, sin=0.0), load
        found += _of_mode(tool, settled(robot), mode, *margins, *walls)
    regions = numbered(found)
    return tuple(region for region in regions if working in (None, region.working))


@lru_cache(maxsize=16)  # a map, its picture and its page ask for the same ones
def _of_mode(tool, robot, mode, det_A, sin, constraints, load):
    """Return the regions of a working mode, without their numbers."""
    mounted = MountedTool(tool, robot, mode)
    circles = LegCircles(robot, sin, _bends(mounted, sin))
    image = _Image(mounted, circles)
    found = bent_parts(robot, mode, circles, det_A)
    return [
        image.region(bounded_by(part, constraints, load), det_A, constraints, load)
        for part in found
    ]


def _bends(mounted, sin):
    """Return the angle, as (cosine, sine), of the circle on which the tool folds, by leg and side;
    {} where it folds with the leg in line, or in poses that are left out by the sine.
    """
    offset = mounted.from_elbow
    turn = cmath.phase(offset if offset.real >= 0 else -offset)
    if abs(math.sin(turn)) <= sin:
        return {}
    leg = mounted.tool.leg - 1
    side = 1 if turn * mounted.working[leg] > 0 else -1
    return {(leg, side): (math.cos(turn), abs(math.sin(turn)))}


class _Image:
    """The map from places of C to those of a tool, and images of arcs.

    Points are complex numbers, m.
    """

    def __init__(self, mounted: MountedTool, circles: LegCircles) -> None:
        self.mounted = mounted
        self.circles = circles
        self.leg = mounted.tool.leg - 1
        self.mode = mounted.working[self.leg]
        self.drive = circles.robot.drives[self.leg]
        self.base = complex(self.drive.x)
        self.bar = circles.robot.distal[self.leg]
        self.offset = complex(mounted.tool.along, mounted.tool.across)
        self.size = size_of(circles.robot)

    def region(
        self, part: Aspect, det_A: float, constraints: Constraints, load: Load | None
    ) -> ToolRegion:
        """Return the image of a part of an aspect, up to the fold of the tool."""
        loops = [self.loop(loop) for loop in part.boundary]
        at_base = np.abs(part.punctures @ (1, 1j) - self.base) <= SAME * self.size
        if at_base.any():
            # The leg may turn about its base joint there, and the tool goes around it.
            loops.append([self.around(0.0, -2 * math.pi)])
        punctures = self.points(part.punctures[~at_base] @ (1, 1j))[0]
        if self.mounted.from_elbow.real < 0:  # the map turns the plane over
            loops = list(map(_reversed, loops))
        areas = list(map(_area, loops))
        outer = int(np.argmax(areas))
        boundary = [loops[outer], *loops[:outer], *loops[outer + 1 :]]
        walls: tuple = ()
        allowed = None
        if isinstance(part, BoundedAspect):
            walls, allowed = self.bounds(part, det_A, constraints, load)
        image = replace(
            part,
            area=float(sum(areas)),
            boundary=tuple(map(tuple, boundary)),
            punctures=pairs(punctures),
        )
        return as_kind(ToolRegion, image, walls, allowed, 0.0, self.mounted)

    def bounds(
        self, part: BoundedAspect, det_A: float, constraints: Constraints, load: Load | None
    ) -> tuple:
        """Return the walls of the constraints, and a function that tells where they hold."""

        def within(z):
            # Near a border the pose tells on which side of it a point is.
            found, near = roughly_inside(part.boundary, z)
            found |= near
            found[found] = part.allowed(z[found])
            z = z[found]
            pose = task_pose(self.circles.robot, (z.real, z.imag), self.mounted.working)
            margin = least_margin(pose, det_A, self.circles.sin, self.circles.bends)
            found[found] = margin > 0
            return found

        def allowed(z):
            joint = self.mounted.joint(pairs(z))
            lost = np.isnan(joint[:, 0])
            joint[lost] = 10 * self.size
            pose = igm(self.circles.robot, joint, self.mounted.working, unreachable="nan")
            holds = constraints.satisfied(pose) & ~lost & (pose.assembly == part.assembly)
            return holds if load is None else holds & load.satisfied(pose)

        images = []
        for wall in facing(part.walls, within, self.size):
            # Of a shorter arc at the base joint the leg's direction is rounding error.
            if np.abs(np.diff(wall.z)).sum() > SAME * self.size:
                images.append(self.wall(wall))
        return tuple(images), allowed

    def wall(self, arc: LocusArc) -> LocusArc:
        """Return the image of an arc of a constraint; of chords chords."""
        if arc.locus.kind != TRACED:
            return self._traced(self.curve(arc), arc.locus.type, arc.locus.kind)
        locus = polyline(self.points(arc.z)[0])
        return LocusArc(locus, *locus.interval)

    def loop(self, arcs: Iterable[LocusArc]) -> list[LocusArc]:
        """Return the image of a loop, with an arc where it goes through the base joint."""
        arcs = list(arcs)
        curves = [self.curve(arc) for arc in arcs]
        ends = [curve(np.array([0.0, 1.0]))[0] for curve in curves]
        corners: list[LocusArc | None] = []
        for arc, own, after in zip(arcs, ends, ends[1:] + ends[:1]):
            if abs(own[1] - after[0]) <= CLOSES * self.size:
                # The arcs of a corner differ by rounding, and are to end in one point.
                own[1] = after[0]
                corners.append(None)
                continue
            first, last = own[1] - self.base, after[0] - self.base
            if abs(arc.z[-1] - self.base) > SAME * self.size:
                raise ArithmeticError(
                    f"tool_regions: a boundary does not close at ({own[1].real:.6g},"
                    f" {own[1].imag:.6g}) m for {self.mounted.tool!r}; please report this robot"
                )
            turn = cmath.phase(first / last) % (2 * math.pi)
            corners.append(self.around(cmath.phase(first), -turn))
        closed = []
        for arc, curve, own, corner in zip(arcs, curves, ends, corners):
            closed.append(self._traced(_between(curve, *own), arc.locus.type, arc.locus.kind))
            closed += [] if corner is None else [corner]
        return closed

    def around(self, start: float, turn: float) -> LocusArc:
        """Return the arc of the tool about the base joint with the leg folded on it."""
        radius = abs(self.mounted.from_elbow - self.bar)

        def curve(x):
            way = radius * np.exp(1j * (start + turn * np.asarray(x)))
            return self.base + way, 1j * turn * way

        return self._traced(curve, Singularity.SERIAL, "folded leg")

    def curve(self, arc: LocusArc) -> Callable:
        """Return the image of an arc, run through in the same direction by x from 0 to 1."""
        turn = self._turn(arc)
        if turn is not None:
            # The leg does not bend along its circle, so that the tool is on another one.
            proximal = self.drive.length
            ratio = (proximal + self.mounted.from_elbow * turn) / (proximal + self.bar * turn)

            def curve(x):
                z, dz = arc.curve(arc.start + (arc.end - arc.start) * np.asarray(x))
                way = abs(arc.end - arc.start) * dz
                return self.base + ratio * (z - self.base), ratio * way

            return curve
        return self._bent(arc)

    def _turn(self, arc):
        """Return the unit number by which the leg is bent along a circle about its base joint; None
        where it bends along the arc.
        """
        circle = arc.locus.circle
        # Circles of a coaxial robot are about both base joints.
        if not circle or (circle[0] != self.leg and self.circles.robot.d > 0):
            return None
        proximal = self.drive.length
        square = abs(arc.z[0] - self.base) ** 2 - proximal**2 - self.bar**2
        cosine = square / (2 * proximal * self.bar)
        sine = math.sqrt(max((1 - cosine) * (1 + cosine), 0.0))
        if sine < IN_LINE:
            cosine, sine = math.copysign(1.0, cosine), 0.0
        return complex(cosine, -self.mode * sine)

    def _traced(self, curve, type_, kind):
        label = type_, kind, (self.mounted.working,), ()
        (locus,) = pieces_of(curve, np.array([0.0, 1.0]), [label], self.size)
        traced = LocusArc(locus, 0.0, 1.0)
        # The curve is smooth in x, but its tangent is no derivative to the last digits at the ends.
        z, dz = curve(PLACES)
        traced.__dict__["moment"] = float((z.conj() * dz).imag @ SHARES) / 2
        return traced

    def _bent(self, arc):
        """Return the image of an arc along which the leg bends.

        An arc may come to Type 1 so that the bar turns with the root of the way on it; its
        parameter goes with the square of x there. With C on the base joint the bar's direction is
        a limit.
        """
        start, span = arc.start, arc.end - arc.start
        ends = arc.at(np.array([arc.start, arc.end]))
        at_base = np.abs(ends - self.base) <= SAME * self.size
        at_line = np.abs(self._sines(ends)) < IN_LINE
        near, far = np.abs(self._sines(arc.at(start + span * np.array(ROOT))))
        low, high = (at_line & ~at_base & (near > 0.03 * far)).tolist()
        lowest, highest = (at_base * BESIDE[1]).tolist()
        first, last = ((at_line | at_base) * BESIDE[0]).tolist()

        def curve(x):
            x = np.asarray(x, float)
            inner = np.clip(x, first, 1 - last)
            share, rate = _share(inner, low, high)
            on, tangent = arc.curve(start + span * share)
            z, slope = self.points(on, abs(span) * rate * tangent)
            if (inner != x).any():
                places = np.clip(x, lowest, 1 - highest)
                z, _ = self.points(arc.at(start + span * _share(places, low, high)[0]))
            return z, slope

        return curve

    def _legs(self, z):
        """Return unit vectors of the proximal and the distal bar with C at points, and by how much
        the way from the base joint to it is shortened to what the leg reaches.
        """
        way = z - self.base
        distance = np.abs(way)
        proximal = self.drive.length
        near = np.clip(distance, abs(proximal - self.bar), proximal + self.bar)
        share = near / np.where(distance, distance, 1.0)
        way = way * share
        on = self.base + way
        x, y = self.drive.close((on.real, on.imag), self.bar, self.mode).last
        u2 = x + 1j * y
        return (way - self.bar * u2) / proximal, u2, share

    def _sines(self, z):
        u1, u2, _ = self._legs(z)
        return (u1.conjugate() * u2).imag

    def points(self, z: Any, dz: Any = 0.0) -> tuple[Any, Any]:
        """Return where the tool is with C at points z, and its derivative where that of C is dz."""
        u1, u2, share = self._legs(z)
        tangent = 1j * self.drive.length * u1
        with np.errstate(divide="ignore", invalid="ignore"):
            # u2 . (C' - P' q') = 0, and l2 phi' = v2 . (C' - P' q').
            rate = (u2.conjugate() * dz).real / (u2.conjugate() * tangent).real
            # Where rounding error tells how a leg is bent, or that it does not reach C, it turns as
            # if it were in line.
            bent = (share == 1) & (np.abs((u1.conjugate() * u2).imag) > FLAT)
            rate = np.where(bent, rate, (dz / (z - self.base)).imag)
            phi = (u2.conjugate() * (share * dz - tangent * rate)).imag / self.bar
        return z + self.offset * u2, dz + 1j * self.offset * u2 * phi


def _reversed(loop):
    return [arc.reversed for arc in reversed(loop)]


def _area(loop):
    return sum(arc.moment for arc in loop)


def _between(curve, first, last):
    """Return a curve with these points at x = 0 and 1."""

    def ended(x):
        z, dz = curve(x)
        z = np.where(np.equal(x, 0), first, z)
        return np.where(np.equal(x, 1), last, z), dz

    return ended


def _share(x, low, high):
    """Return the share of an arc's parameter, and its derivative, at x from 0 to 1; it goes with
    the square of x at the low end, of 1 - x at the high end, if asked.
    """
    if low and high:
        return x * x * (3 - 2 * x), 6 * x * (1 - x)
    if low:
        return x * x, 2 * x
    if high:
        return x * (2 - x), 2 * (1 - x)
    return x, np.ones_like(x)
