"""Boundaries of constraints in one working mode: exact arcs, and traced curves where links meet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, partial

import numpy as np

from ..base.backend import pairs
from ..models.geometry import task_pose
from ..models.robots import FiveBar
from ..singularities.aspects import Aspect
from ..singularities.leg_circles import LegCircles, size_of
from ..singularities.level_curves import LevelCurves
from ..singularities.locus import TRACED, Locus, divided, pieces_of
from ..singularities.margins import Singularity
from ..singularities.regions import LocusArc
from .constraints import Constraints
from .load import Load

GRID = 301  # nodes a side of the grid on which curves along which links touch are traced
STEPS = 40  # of bisection: 2^-40 of a chord is rounding error
DIVISIONS, PARTS = 10, np.arange(17) / 16  # as near, of few points, in fewer calls
OFF = 1e-8  # share of the size at which both sides of an exact boundary are sampled


@lru_cache(maxsize=8)  # the aspects of a mode have them in common
def boundaries(
    robot: FiveBar, working: tuple[int, int], constraints: Constraints, load: Load | None = None
) -> tuple[LocusArc, ...]:
    """Return the curves across which a constraint may begin to be violated.

    Lines, circles and coupler curves are exact. Curves along which links touch, or a load takes all
    torque, are traced on a grid, and each of their points is moved onto the curve by bisection.
    """
    curves = list(_of_lines(robot, constraints))
    curves += _of_joints(robot, working, constraints)
    if constraints.det_A or constraints.sin:
        circles = LegCircles(robot, constraints.sin)
        if constraints.sin:
            curves += circles.pieces
        if constraints.det_A:
            curves += LevelCurves(robot, constraints.det_A, circles).pieces(working)
    if constraints.collisions or load is not None:
        curves += _traced(robot, working, constraints.collisions, load)
    arcs = []
    for curve in curves:
        if len(curve.points) > 1:
            arcs.append(LocusArc(curve, *curve.interval))
    return tuple(arcs)


def facing(
    arcs: Iterable[LocusArc], allowed: Callable, size: float, right: Callable | None = None
) -> list[LocusArc]:
    """Return the parts of arcs with allowed points on one side only, directed to have it left.

    right: what is allowed on the right side, where that is another function.
    """
    both = allowed, right or allowed
    parts = []
    for arc in arcs:
        # The chords of a traced curve are that far off it at most.
        if arc.locus.kind == TRACED:
            off = 0.02 * np.abs(np.diff(arc.z)).max()
        else:
            off = OFF * size
        chords = np.abs(np.diff(arc.z))
        counts = np.ceil(chords / (0.002 * size))
        s = divided(arc.s, np.maximum(counts, 1).astype(int))
        state = _sides(arc, s, off, *both)
        changes = (state[1:] != state[:-1]).any(axis=1)
        k = np.flatnonzero(changes)
        ends = np.stack([s[k], s[k + 1]], axis=1)
        for _ in range(DIVISIONS if len(k) else 0):
            places = ends[:, :1] + np.diff(ends) * PARTS
            there = _sides(arc, places.ravel(), off, *both).reshape(*places.shape, 2)
            same = (there == state[k][:, None]).all(axis=2)
            after = 1 + np.argmin(np.pad(same[:, 1:-1], ((0, 0), (0, 1))), axis=1)
            ends = np.take_along_axis(places, np.stack([after - 1, after], axis=1), axis=1)
        middle = ends.mean(axis=1)
        cuts = [s[0], *middle, s[-1]]
        states = state[np.append(k, -1)]
        for start, end, (left, right) in zip(cuts, cuts[1:], states):
            if left == right or start == end:
                continue
            if left:
                parts.append(LocusArc(arc.locus, start, end))
            else:
                parts.append(LocusArc(arc.locus, end, start))
    return parts


def _sides(arc, s, off, left, right):
    """Return whether the points on the left and on the right of an arc are allowed, (n, 2)."""
    z, tangent = arc.curve(s)
    across = off * 1j * tangent / np.abs(tangent)
    return np.stack([left(z + across), right(z - across)], axis=-1)


def satisfied_at(aspect: Aspect, constraints: Constraints, load: Load | None = None) -> Callable:
    """Return a function of complex points (n,): whether all constraints hold there, in the
    aspect's modes, bool (n,).
    """

    def satisfied(z):
        pose = task_pose(aspect.robot, (z.real, z.imag), aspect.working)
        holds = np.atleast_1d(constraints.satisfied(pose)) & (pose.det_A * aspect.assembly < 0)
        return holds if load is None else holds & load.satisfied(pose)

    return satisfied


def _of_lines(robot, constraints) -> Iterator[Locus]:
    reach = 2 * size_of(robot)
    for a, b, c in constraints.half_planes:
        foot = c * complex(a, b)
        if abs(foot) < reach:
            half = reach * complex(-b, a)
            yield line_of(foot - half, foot + half)
    if constraints.region:
        corners = np.array(constraints.region) @ (1, 1j)
        ends = np.roll(corners, -1)
        yield from map(line_of, corners, ends)


def line_of(a: complex, b: complex) -> Locus:
    """Return the line from a to b."""

    def curve(s):
        way = complex(b - a)
        return a + s * way, np.full(np.shape(s), way)

    ends = np.array([0.0, 1.0])
    points = pairs(curve(ends)[0])
    return Locus(Singularity.NONE, "line", (), (), points, ends, False, curve)


def _of_joints(robot, working, constraints) -> Iterator[Locus]:
    """Yield the half circles of the distal bar about the elbow of a crank at its limit."""
    for leg, limits in enumerate(constraints.joints or ()):
        drive = robot.drives[leg]
        bar = robot.distal[leg]
        for q in limits or ():
            base = drive.x + 1j * drive.y
            elbow = base + drive.length * np.exp(1j * q)

            def curve(t, elbow=elbow, bar=bar):
                arm = bar * np.exp(1j * np.asarray(t))
                return elbow + arm, 1j * arm

            span = np.array([q, q - working[leg] * np.pi])
            label = Singularity.NONE, "joint limit", (working,), ()
            yield from pieces_of(curve, np.sort(span), [label], size_of(robot))


def _traced(robot, working, collisions, load) -> list[Locus]:
    """Return the curves on which the least clearance of links, or a load's margin, is 0."""
    from contourpy import LineType, contour_generator  # comes with matplotlib

    left = robot.l11 + robot.l12
    right = robot.l21 + robot.l22
    half_base = robot.d / 2
    low = -min(left + half_base, right - half_base)
    high = min(left - half_base, right + half_base)
    top = min(left, right)
    x = np.linspace(low, high, GRID)
    y = np.linspace(-top, top, GRID)

    def least(z, assembly):
        pose = task_pose(robot, (z.real, z.imag), working)
        margins = list(collisions.clearances(pose).values()) if collisions else []
        if load is not None:
            margins.append(load.margin(pose, assembly))
        return np.min(margins, axis=0)

    curves = []
    for assembly in (0,) if load is None else (1, -1):
        margin = partial(least, assembly=assembly)
        known = np.ma.masked_invalid(margin(x + 1j * y[:, None]))
        for line in contour_generator(x, y, known, line_type=LineType.Separate).lines(0.0):
            z = np.asarray(line) @ (1, 1j)
            points, sound = _put(margin, z, 1j * np.gradient(z))
            # At the limit of reach a contour ends somewhere in its cell.
            breaks = np.flatnonzero(~sound)
            for part in np.split(np.arange(len(z)), breaks):
                part = part[sound[part]]
                if len(part) > 2:
                    curves.append(polyline(points[part]))
    return curves


def polyline(points: np.ndarray) -> Locus:
    """Return a curve of chords through points (n,)."""

    def curve(s):
        k = np.clip(np.floor(s).astype(int), 0, len(points) - 2)
        chord = points[k + 1] - points[k]
        return points[k] + (s - k) * chord, chord

    s = np.arange(len(points), dtype=float)
    return Locus(Singularity.NONE, TRACED, (), (), pairs(points), s, False, curve)


def _put(clearance, z, across):
    """Move points along `across`, by less than a chord, to where the clearance is 0.

    Return the points and which of them are there, bool (n,).
    """
    low = -np.ones(len(z))
    high = np.ones(len(z))
    at_low = clearance(z - across)
    at_high = clearance(z + across)
    for _ in range(STEPS):
        middle = (low + high) / 2
        same = clearance(z + middle * across) * at_low > 0
        low = np.where(same, middle, low)
        high = np.where(same, high, middle)
    middle = (low + high) / 2
    return z + middle * across, at_low * at_high < 0
