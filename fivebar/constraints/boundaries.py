"""Boundaries of constraints in one working mode: exact arcs, and traced curves where links meet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from ..models.geometry import task_pose
from ..models.robots import FiveBar
from ..singularities.leg_circles import LegCircles, size_of
from ..singularities.level_curves import LevelCurves
from ..singularities.locus import Locus, divided, pairs, pieces_of
from ..singularities.margins import Singularity
from ..singularities.regions import LocusArc
from .constraints import Constraints

GRID = 301  # nodes a side of the grid on which curves along which links touch are traced
STEPS = 40  # of bisection: 2^-40 of a chord is rounding error
TRACED = "bars touch"
OFF = 1e-8  # share of the size at which both sides of an exact boundary are sampled


def boundaries(
    robot: FiveBar, working: tuple[int, int], constraints: Constraints
) -> list[LocusArc]:
    """Return the curves across which a constraint may begin to be violated.

    Lines, circles and coupler curves are exact. Curves along which links touch are traced on a
    grid, and each of their points is moved onto the curve by bisection.
    """
    curves = list(_of_lines(robot, constraints))
    curves += _of_joints(robot, working, constraints)
    if constraints.det_A or constraints.sin:
        circles = LegCircles(robot, constraints.sin)
        if constraints.sin:
            curves += circles.pieces
        if constraints.det_A:
            curves += LevelCurves(robot, constraints.det_A, circles).pieces(working)
    if constraints.collisions:
        curves += _of_bars(robot, working, constraints)
    arcs = []
    for curve in curves:
        if len(curve.points) > 1:
            arcs.append(LocusArc(curve, *curve.interval))
    return arcs


def facing(arcs: Iterable[LocusArc], allowed: Callable, size: float) -> list[LocusArc]:
    """Return the parts of arcs with allowed points on one side only, directed to have it left."""
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
        state = _sides(arc, s, off, allowed)
        changes = (state[1:] != state[:-1]).any(axis=1)
        k = np.flatnonzero(changes)
        low = s[k]
        high = s[k + 1]
        for _ in range(STEPS if len(k) else 0):
            middle = (low + high) / 2
            there = _sides(arc, middle, off, allowed)
            same = (there == state[k]).all(axis=1)
            low = np.where(same, middle, low)
            high = np.where(same, high, middle)
        middle = (low + high) / 2
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


def _sides(arc, s, off, allowed):
    """Return whether the points on the left and on the right of an arc are allowed, (n, 2)."""
    z, tangent = arc.curve(s)
    across = off * 1j * tangent / np.abs(tangent)
    return np.stack([allowed(z + across), allowed(z - across)], axis=-1)


def satisfied_at(robot: FiveBar, working: tuple[int, int], constraints: Constraints) -> Callable:
    """Return a function of complex points (n,): whether all constraints hold there, bool (n,)."""

    def satisfied(z):
        pose = task_pose(robot, (z.real, z.imag), working)
        return np.atleast_1d(constraints.satisfied(pose))

    return satisfied


def _of_lines(robot, constraints) -> Iterator[Locus]:
    reach = 2 * size_of(robot)
    for a, b, c in constraints.half_planes:
        foot = c * complex(a, b)
        if abs(foot) < reach:
            half = reach * complex(-b, a)
            yield _line(foot - half, foot + half)
    if constraints.region:
        corners = np.array(constraints.region) @ (1, 1j)
        ends = np.roll(corners, -1)
        yield from map(_line, corners, ends)


def _line(a, b):
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


def _of_bars(robot, working, constraints) -> list[Locus]:
    from contourpy import LineType, contour_generator  # comes with matplotlib

    left = robot.l11 + robot.l12
    right = robot.l21 + robot.l22
    half_base = robot.d / 2
    low = -min(left + half_base, right - half_base)
    high = min(left - half_base, right + half_base)
    top = min(left, right)
    x = np.linspace(low, high, GRID)
    y = np.linspace(-top, top, GRID)

    def clearances(z):
        return constraints.collisions.clearances(task_pose(robot, (z.real, z.imag), working))

    curves = []
    for name, values in clearances(x + 1j * y[:, None]).items():
        known = np.ma.masked_invalid(values)
        lines = contour_generator(x, y, known, line_type=LineType.Separate).lines(0.0)

        def clearance(z, name=name):
            return clearances(z)[name]

        for line in lines:
            z = np.asarray(line) @ (1, 1j)
            points, sound = _put(clearance, z, 1j * np.gradient(z))
            # At the limit of reach a contour ends somewhere in its cell.
            breaks = np.flatnonzero(~sound)
            for part in np.split(np.arange(len(z)), breaks):
                part = part[sound[part]]
                if len(part) > 2:
                    curves.append(_polyline(points[part]))
    return curves


def _polyline(points):
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
