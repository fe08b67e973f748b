"""First motions between two poses: straight in the bars' angles or for the tip, bent to a side, and
by way of a third pose.
"""

from __future__ import annotations

from itertools import islice, product
from typing import NamedTuple

import numpy as np

from ..constraints.constraints import Constraints
from ..models.four_joints import bars_pose, closed, loop_gap
from ..models.geometry import Pose, igm
from ..models.robots import Robot
from ..singularities.locus import MODES
from ..singularities.passages import routes
from .coordinates import bars
from .guess import BENDS, bent
from .problem import PlanError, refuse_pose

IMAGES = 30  # turns of the goal's bars that are tried, at most
DIRECT = 8  # straight ways, at most
DETOURS = 24  # places of a pose between
BY_WAY = 6  # ways through these, at most
MOST = 6  # ways between two poses
CLOSES = 1e-9  # of the bars
POINTS = 61  # of a way, between each two of its poses, and of all of it
JUMP = 0.7  # rad, between these: more is no motion
NEWTON = 12  # steps that close the loop
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
    paths += _in_their_modes(robot, start, goal)
    by_way = (_path(robot, each) for each in _detours(robot, start, goal, begin, end))
    paths += islice((path for path in by_way if path is not None), BY_WAY)
    return _distinct(robot, paths)


def _distinct(robot, paths):
    """Return the paths in even steps, without those that are one with a shorter one."""
    found = []
    for path in paths:
        along = _along(path)
        share = np.linspace(0, along[-1], POINTS)
        columns = [np.interp(share, along, column) for column in path.T]
        even = _closed(robot, np.stack(columns, axis=1))
        found.append(Way(even, float(_along(even)[-1])))
    kept: list[Way] = []
    for way in sorted(found, key=lambda way: way.length):
        if all(np.abs(way.path - other.path).max() > SAME for other in kept):
            kept.append(way)
    return kept[:MOST]


def _along(path):
    """Return the length of a path (n, 4) up to each of its points."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))


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


def _in_their_modes(robot, start, goal):
    """Yield ways of the tip that is straight or bent to a side, where the modes are the same."""
    if (start.working != goal.working).any():
        return
    for bend in (0.0, *BENDS):
        points = bent(start.xi, goal.xi, bend * sum(robot.distal) / 2)
        pose = igm(robot, points, start.working, unreachable="nan")
        path = _continuous(np.unwrap(bars(pose), axis=0))
        if path is not None:
            yield path


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
    path = _closed(robot, np.concatenate([*parts, points[-1][None]]))
    ends = np.array([points[0], points[-1]])
    if np.abs(path[[0, -1]] - ends).max() > 1e-6:
        return None
    return _continuous(path)


def _continuous(path):
    return path if np.abs(np.diff(path, axis=0)).max() < JUMP else None  # None for nan, too


def _closed(robot, a):
    c = tuple(np.moveaxis(a, -1, 0))
    rest = tuple(np.zeros_like(each) for each in c)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON):
            c = closed(robot, c, rest)[0]
    return np.stack(c, axis=-1)
