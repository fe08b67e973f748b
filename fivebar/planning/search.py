"""First motions between two poses: straight in the bars' angles, and by way of a third pose.

All of them are pulled taut.
"""

from __future__ import annotations

from itertools import islice, product
from typing import NamedTuple

import numpy as np

from ..base.backend import atan2
from ..constraints.constraints import Constraints
from ..models.four_joints import bars_pose, closed, loop_gap
from ..models.geometry import Pose, igm
from ..models.robots import Robot
from ..singularities.locus import MODES
from ..singularities.passages import routes
from .coordinates import bars
from .problem import PlanError, refuse_pose

IMAGES = 30  # turns of the goal's bars that are tried, at most
DIRECT = 8  # straight ways, at most
DETOURS = 24  # places of a pose between
BY_WAY = 6  # ways through these, at most
MOST = 6  # ways between two poses
CLOSES = 1e-9  # of the bars
POINTS = 61  # of a way, between each two of its poses, and of all of it pulled taut
JUMP = 0.7  # rad, between these: more is no motion
NEWTON = 12  # steps that close the loop
PULLS = 25  # steps of pulling taut
STIFF = 30.0  # how far each goes
LIGHT = 1e-2  # of the robot's inertia is added where it has none
SAME = 0.3  # rad: ways that are nowhere farther apart are one


class Way(NamedTuple):
    """A path (POINTS, 4) of the four bars with a closed loop, and its length."""

    path: np.ndarray
    length: float


def ways(robot: Robot, start: Pose, goal: Pose) -> list[Way]:
    """Return ways of the four bars from pose to pose, the shortest first.

    PlanError where no motion joins the poses, whatever it crosses.
    """
    begin = bars(start)
    end = bars(goal)
    turns = product((-1, 0, 1) if robot.turns else (0,), (-1, 0, 1), repeat=2)
    images = sorted(
        (end + 2 * np.pi * np.array(counts) for counts in turns),
        key=lambda image: np.abs(image - begin).sum(),
    )
    if _are_apart(robot, start, goal):
        raise PlanError(
            "plan: no motion joins start and goal: the aspects that they are in are not connected,"
            " whatever singularity is crossed",
            {},
        )
    direct = (_path(robot, [begin, image]) for image in images[:IMAGES])
    paths = list(islice((path for path in direct if path is not None), DIRECT))
    by_way = (_path(robot, each) for each in _detours(robot, start, goal, begin, end))
    paths += islice((path for path in by_way if path is not None), BY_WAY)
    return _distinct(robot, paths) if paths else []


def _distinct(robot, paths):
    """Return the paths pulled taut, without those that are one with a shorter one.

    A path that pulling tears stays as it is.
    """
    even = np.stack([_even(robot, path) for path in paths])
    taut = _closed(robot, _pulled(robot, even), NEWTON)
    with np.errstate(invalid="ignore"):
        jumps = np.abs(np.diff(taut, axis=1)).max(axis=(1, 2))
        torn = ~(jumps < JUMP)
    taut[torn] = even[torn]
    lengths = _lengths(robot, taut)[:, -1]
    kept = []
    for k in np.lexsort((lengths, torn)):  # what could not be pulled comes last
        if all(np.abs(taut[k] - way.path).max() > SAME for way in kept):
            kept.append(Way(taut[k], float(lengths[k])))
    return kept[:MOST]


def ways_between(robot: Robot, stops: list[tuple], constraints: Constraints) -> list[tuple]:
    """Return [(stops, paths, length)] of `ways` from stop to stop of `timed`, shortest first."""
    choices = [_poses(robot, point, name, constraints) for name, _, point in stops]
    times = [t for _, t, _ in stops]
    result = []
    failure = None
    for poses in product(*choices):
        try:
            legs = [ways(robot, *pair) for pair in zip(poses, poses[1:])]
        except PlanError as error:
            failure = error
            continue
        for chosen in islice(product(*legs), MOST**2):
            length = sum(way.length for way in chosen)
            result.append((*_stops([way.path for way in chosen], times), length))
    if failure is not None and not result:
        raise failure
    return sorted(result, key=lambda one: one[-1])


def _stops(paths, times):
    """Return (stops, paths), where each path begins in the turn in which the last one ends."""
    moved = [paths[0]]
    stops = [({0: paths[0][0], 1: np.zeros(4)}, 0.0)]
    for path in paths[1:]:
        moved.append(path + (moved[-1][-1] - path[0]))
    for k, (path, t) in enumerate(zip(moved, times[1:]), start=1):
        at_rest = {1: np.zeros(4)} if k == len(moved) else {}
        stops.append(({0: path[-1], **at_rest}, t))
    return tuple(stops), moved


def _poses(robot, given, name, constraints):
    """Return a Pose that keeps the constraints as itself, a point as the poses that reach it."""
    if not isinstance(given, Pose):
        pose = igm(robot, given, unreachable="raise")  # says how far it is out of reach
        return [igm(robot, pose.xi, modes) for modes in MODES]
    if given.robot != robot:
        raise ValueError(f"plan: {name} is a Pose of another robot: {given.robot}, not {robot}")
    if np.shape(given.xi) != (2,) or not np.isfinite(bars(given)).all():
        raise ValueError(
            f"plan: {name} must be one Pose that closes, not a batch or one out of reach"
        )
    closed_pose = bars_pose(robot, tuple(bars(given).tolist()))
    gap = float(np.hypot(*loop_gap(closed_pose)))
    if gap > CLOSES * max(robot.distal):
        raise ValueError(f"plan: {name} is a Pose whose loop does not close, by {gap:.3g} m")
    refuse_pose(constraints, name, given)
    return [given]


def _are_apart(robot, start, goal):
    """Whether no route joins poses; False where aspects are not known, or a pose is singular."""
    try:
        return not routes(robot, start, goal)
    except (ValueError, ArithmeticError):
        return False


def _detours(robot, start, goal, begin, end):
    """Yield points by way of a pose in any modes, farther and farther about the middle of both."""
    reach = min(robot.distal) * np.linspace(0.5, 1.5, DETOURS)[:, None]
    aside = reach * np.random.default_rng(0).uniform(-1, 1, (DETOURS, 2))
    for xi, modes in product((start.xi + goal.xi) / 2 + aside, MODES):
        middle = bars(igm(robot, xi, modes, unreachable="nan"))
        yield [begin, nearest_turn(robot, middle, begin), nearest_turn(robot, end, middle)]


def nearest_turn(robot: Robot, angles: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the bars in the turn nearest to others; what slides does not turn."""
    turns = robot.turns, True, robot.turns, True
    return np.where(turns, _nearest(angles, before), angles)


def _nearest(angles, before):
    turns = np.round((before - angles) / (2 * np.pi))
    return angles + 2 * np.pi * turns


def _path(robot, points):
    """Return the straight way through points (k, 4), its loop closed; None where it jumps."""
    if not np.isfinite(points).all():
        return None
    share = np.linspace(0, 1, POINTS)[:-1, None]
    parts = []
    for a, b in zip(points, points[1:]):
        parts.append(a + share * (b - a))
    path = _closed(robot, np.concatenate([*parts, points[-1][None]]), NEWTON)
    if not np.isfinite(path).all():
        return None
    ends = np.array([points[0], points[-1]])
    if np.abs(path[[0, -1]] - ends).max() > 1e-6:
        return None
    if np.abs(np.diff(path, axis=0)).max() < JUMP:
        return path
    return None


def _closed(robot, a, steps):
    c = tuple(np.moveaxis(a, -1, 0))
    rest = tuple(np.zeros_like(each) for each in c)
    with np.errstate(all="ignore"):
        for _ in range(steps):
            c = closed(robot, c, rest)[0]
    return np.stack(c, axis=-1)


def _embedded(robot, a):
    """Return (q1, q2, x, y) of bars (..., 4) times the roots of the inertias, and these roots.

    Then twice the kinetic energy is the square of the speed. The inertias are a little larger than
    the robot's, so that none is 0.
    """
    size = max(robot.distal)
    lever = size if robot.turns else 1.0
    # Grouped parameters may be negative.
    inertias = [abs(inertia) for inertia in robot.inertias]
    m = abs(robot.m)
    turning = sum(inertias) * (size / lever) ** 2
    light = LIGHT * (m * size**2 + turning)
    drives = [inertia + light * (lever / size) ** 2 for inertia in inertias]
    tip = m + light / size**2
    roots = np.sqrt([*drives, tip, tip])
    c = tuple(np.moveaxis(a, -1, 0))
    x, y = bars_pose(robot, c).point
    coordinates = np.stack([c[0], c[2], x, y], axis=-1)
    return coordinates * roots, roots


def _lengths(robot, a):
    """Return the lengths of paths (..., n, 4) up to each of their points."""
    steps = np.linalg.norm(np.diff(_embedded(robot, a)[0], axis=-2), axis=-1)
    return np.insert(np.cumsum(steps, axis=-1), 0, 0.0, axis=-1)


def _even(robot, path):
    """Return POINTS points of a path in even steps, with a closed loop."""
    along = _lengths(robot, path)
    even = np.linspace(0, along[-1], POINTS)
    columns = [np.interp(even, along, column) for column in path.T]
    return _closed(robot, np.stack(columns, axis=1), NEWTON)


def _pulled(robot, paths):
    """Return paths (k, POINTS, 4) pulled taut on the surface of poses, towards least energy."""
    chain = np.zeros((POINTS, POINTS))
    for k in range(1, POINTS - 1):
        chain[k, k - 1 : k + 2] = -1.0, 2.0, -1.0
    smooth = np.linalg.inv(np.eye(POINTS) + STIFF * chain)
    for _ in range(PULLS):
        points, roots = _embedded(robot, paths)
        q1, q2, *xi = np.moveaxis(smooth @ points / roots, -1, 0)
        pulled = []
        for q, column, drive in zip((q1, q2), (1, 3), robot.drives):
            x, y = drive.pivot(drive.direction(q))
            phi = atan2(xi[1] - y, xi[0] - x)
            pulled += [q, _nearest(phi, paths[..., column])]
        ends = paths[:, [0, -1]]
        paths = _closed(robot, np.stack(pulled, axis=-1), 3)
        paths[:, [0, -1]] = ends
    return paths
