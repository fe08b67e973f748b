"""Where something that a motion must keep ends, in one working mode: exact arcs, and traced curves
where bars meet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from ..models.geometry import task_pose
from ..models.robots import FiveBar
from ..singularities.leg_circles import LegCircles, size_of
from ..singularities.level_curves import LevelCurves
from ..singularities.locus import Locus, divided, pairs, pieces_of
from ..singularities.margins import Singularity
from ..singularities.regions import Arc
from .constraints import Constraints

GRID = 301  # nodes a side, on which curves are found along which bars touch
STEPS = (
    40  # of the bisection that puts a point on such a curve, or finds where a wall begins to be one
)
TRACED = "bars touch"
OFF = 1e-8  # of the size of what is kept, off a wall: there it is asked what is kept


def boundaries(robot: FiveBar, working: tuple[int, int], constraints: Constraints) -> list[Arc]:
    """Curves of the plane across which something is no longer kept: arcs of lines, circles and
    coupler curves, exactly; where bars touch, curves traced from node to node of a grid, each point
    of them where they do to rounding.
    """
    found = [*_of_lines(robot, constraints), *_of_joints(robot, working, constraints)]
    if constraints.det_A or constraints.sin:
        circles = LegCircles(robot, constraints.sin)
        found += circles.pieces if constraints.sin else ()
        found += (
            LevelCurves(robot, constraints.det_A, circles).pieces(working)
            if constraints.det_A
            else ()
        )
    found += _of_bars(robot, working, constraints) if constraints.collisions else []
    return [Arc(piece, *piece.interval) for piece in found if len(piece.points) > 1]


def facing(found: Iterable[Arc], allowed: Callable, size: float) -> list[Arc]:
    """Of walls the parts with what is kept on one side only, and run through so that it is on their
    left.
    """
    parts = []
    for wall in found:
        # The chords of a traced curve are that far off it at most.
        off = 0.02 * np.abs(np.diff(wall.z)).max() if wall.locus.kind == TRACED else OFF * size

        def sides(s, wall=wall, off=off):
            z, tangent = wall.curve(s)
            across = off * 1j * tangent / np.abs(tangent)
            return np.stack([allowed(z + across), allowed(z - across)], axis=-1)

        s = divided(
            wall.s, np.maximum(np.ceil(np.abs(np.diff(wall.z)) / (0.002 * size)), 1).astype(int)
        )
        state = sides(s)
        k = np.flatnonzero((state[1:] != state[:-1]).any(axis=1))
        low, high = s[k], s[k + 1]
        for _ in range(STEPS if len(k) else 0):
            middle = (low + high) / 2
            same = (sides(middle) == state[k]).all(axis=1)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        cuts = [s[0], *((low + high) / 2), s[-1]]
        for start, end, (left, right) in zip(cuts, cuts[1:], state[np.append(k, -1)]):
            if left != right and start != end:
                parts.append(Arc(wall.locus, start, end) if left else Arc(wall.locus, end, start))
    return parts


def satisfied_at(robot: FiveBar, working: tuple[int, int], constraints: Constraints) -> Callable:
    """Complex points (n,) -> whether all is kept there, bool (n,)."""
    return lambda z: np.atleast_1d(
        constraints.satisfied(task_pose(robot, (z.real, z.imag), working))
    )


def _of_lines(robot, constraints) -> Iterator[Locus]:
    reach = 2 * size_of(robot)
    for a, b, c in constraints.half_planes:
        foot = c * complex(a, b)
        if abs(foot) < reach:
            yield _line(foot - reach * complex(-b, a), foot + reach * complex(-b, a))
    if constraints.region:
        corners = np.array(constraints.region) @ (1, 1j)
        yield from map(_line, corners, np.roll(corners, -1))


def _line(a, b):
    def curve(s):
        return a + s * (b - a), np.full(np.shape(s), complex(b - a))

    ends = np.array([0.0, 1.0])
    return Locus(Singularity.NONE, "line", (), (), pairs(curve(ends)[0]), ends, False, curve)


def _of_joints(robot, working, constraints) -> Iterator[Locus]:
    """With a crank at a limit the distal bar turns about a fixed elbow, half a turn of it in one
    working mode.
    """
    for leg, limits in enumerate(constraints.joints or ()):
        drive, bar = robot.drives[leg], robot.distal[leg]
        for q in limits or ():
            elbow = drive.x + 1j * drive.y + drive.length * np.exp(1j * q)

            def curve(t, elbow=elbow, bar=bar):
                arm = bar * np.exp(1j * np.asarray(t))
                return elbow + arm, 1j * arm

            span = np.array([q, q - working[leg] * np.pi])
            label = Singularity.NONE, "joint limit", (working,), ()
            yield from pieces_of(curve, np.sort(span), [label], size_of(robot))


def _of_bars(robot, working, constraints) -> list[Locus]:
    from contourpy import LineType, contour_generator  # comes with matplotlib

    low, high = (
        side
        * min(
            robot.l11 + robot.l12 + side * robot.drives[0].x,
            robot.l21 + robot.l22 + side * robot.drives[1].x,
        )
        for side in (-1, 1)
    )
    top = min(robot.l11 + robot.l12, robot.l21 + robot.l22)
    x, y = np.linspace(low, high, GRID), np.linspace(-top, top, GRID)

    def clearances(z):
        return constraints.collisions.clearances(task_pose(robot, (z.real, z.imag), working))

    found = []
    for name, values in clearances(x + 1j * y[:, None]).items():
        lines = contour_generator(
            x, y, np.ma.masked_invalid(values), line_type=LineType.Separate
        ).lines(0.0)

        def clearance(z, name=name):
            return clearances(z)[name]

        for line in lines:
            z = line @ (1, 1j)
            points, sound = _put(clearance, z, 1j * np.gradient(z))
            # At the limit of reach a contour ends somewhere in its cell.
            parts = np.split(np.arange(len(z)), np.flatnonzero(~sound))
            found += [_polyline(points[own]) for part in parts if len(own := part[sound[part]]) > 2]
    return found


def _polyline(points):
    """A curve of chords through points (n,)."""

    def curve(s):
        k = np.clip(np.floor(s).astype(int), 0, len(points) - 2)
        return points[k] + (s - k) * (points[k + 1] - points[k]), points[k + 1] - points[k]

    s = np.arange(len(points), dtype=float)
    return Locus(Singularity.NONE, TRACED, (), (), pairs(points), s, False, curve)


def _put(clearance, z, across):
    """Points moved along `across`, by less than a chord, to where the room is 0, and which of them
    are: bool (n,).
    """
    low, high = -np.ones(len(z)), np.ones(len(z))
    at_low, at_high = clearance(z - across), clearance(z + across)
    for _ in range(STEPS):
        middle = (low + high) / 2
        same = clearance(z + middle * across) * at_low > 0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return z + (low + high) / 2 * across, at_low * at_high < 0
