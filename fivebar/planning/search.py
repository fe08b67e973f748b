"""First motions between two poses: straight in the bars' angles, both ways round, and by way of the aspects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice, product

import numpy as np

from ..models.four_joints import bars_rates, closed, loop_gap
from ..models.geometry import Pose, igm
from ..models.robots import Robot
from ..singularities.locus import MODES
from ..singularities.passages import Passage, known_aspects, routes
from .coordinates import bars
from .problem import PlanError, number, pairs_of

DIRECT, ROUTES = 4, 4  # guesses of either kind
MOST = 6  # of both, between two poses
CLOSES = 1e-9  # of the bars
POINTS = 61  # of a guess, between each two of its poses
JUMP = 0.7  # rad, between these: more is no motion
NEWTON = 12  # steps that close the loop
INSIDE = 1e-7  # of the bars: how far a place on a limit of reach is moved inward


def ways(robot: Robot, start: Pose, goal: Pose) -> Iterator[np.ndarray]:
    """Paths (n, 4) of the four bars from pose to pose, on which the loop is closed; the likeliest first.

    PlanError where no motion joins the poses, whatever it crosses.
    """
    begin, end = bars(start), bars(goal)
    if robot.turns:
        images = [end + 2 * np.pi * np.array(turns) for turns in product((-1, 0, 1), repeat=4)]
        images.sort(key=lambda image: np.abs(image - begin).sum())
    else:
        images = [end + 2 * np.pi * np.array([0, first, 0, second]) for first, second in product((0, -1, 1), repeat=2)]
    found = _routes(robot, start, goal)
    if found == ():
        raise PlanError(
            "plan: no motion joins start and goal: the aspects that they are in are not connected, whatever "
            "singularity is crossed", {},
        )  # fmt: skip
    direct = (_path(robot, [begin, image]) for image in images)
    yield from islice((path for path in direct if path is not None), DIRECT)
    by_way = (_path(robot, _waypoints(robot, route, begin, end)) for route in found or ())
    yield from islice((path for path in by_way if path is not None), ROUTES)


def ways_between(robot: Robot, start: object, goal: object, duration: float | None, via: Iterable) -> Iterator[tuple]:
    """(stops, paths) of a motion between Poses, checked: `ways` from each to the next, the likeliest combined first."""
    via = pairs_of(via)
    times, given = [0.0, *(t for t, _ in via), duration], [start, *(pose for _, pose in via), goal]
    names = ["start", *(f"via[{k}]" for k in range(len(given) - 2)), "goal"]
    last = 0.0
    for t, name in zip(times[1:], names[1:]):
        if t is not None:
            last = number(t, "duration" if name == "goal" else f"the time of {name}", last, np.inf)
    choices = [_poses(robot, each, name) for each, name in zip(given, names)]
    for poses in product(*choices):
        legs = [list(islice(ways(robot, *pair), MOST)) for pair in zip(poses, poses[1:])]
        for paths in product(*legs):
            moved, stops = [paths[0]], [({0: paths[0][0], 1: np.zeros(4)}, 0.0)]
            for path in paths[1:]:  # each begins in the turn of the bars in which the last one ends
                moved.append(path + (moved[-1][-1] - path[0]))
            for k, (path, t) in enumerate(zip(moved, times[1:]), start=1):
                at_rest = {1: np.zeros(4)} if k == len(moved) else {}
                stops.append(({0: path[-1], **at_rest}, t))
            yield tuple(stops), moved


def _poses(robot, given, name):
    """A Pose as itself; a point as the poses that reach it in any modes."""
    if not isinstance(given, Pose):
        pose = igm(robot, given, unreachable="raise")  # says how far it is out of reach
        return [igm(robot, pose.xi, modes) for modes in MODES]
    if given.robot != robot:
        raise ValueError(f"plan: {name} is a Pose of another robot: {given.robot}, not {robot}")
    if np.shape(given.xi) != (2,) or not np.isfinite(bars(given)).all():
        raise ValueError(f"plan: {name} must be one Pose that closes, not a batch or one out of reach")
    gap = float(np.hypot(*loop_gap(bars_rates(robot, tuple(bars(given).tolist()), (0.0,) * 4).pose)))
    if gap > CLOSES * max(robot.distal):
        raise ValueError(f"plan: {name} is a Pose whose loop does not close, by {gap:.3g} m")
    return [given]


def _routes(robot, start, goal):
    """Routes by the aspects; None where these are not known, or a pose is singular."""
    try:
        return routes(robot, start, goal)
    except (ValueError, ArithmeticError):
        return None


def _waypoints(robot, route, begin, end):
    points, everything = [begin], known_aspects(robot)
    for before, after, passage in zip(route.aspects, route.aspects[1:], route.passages):
        points.append(_nearest(_at(robot, passage, everything[before - 1]), points[-1]))
        inner = everything[after - 1]
        points.append(_nearest(bars(igm(robot, inner.point, inner.working)), points[-1]))
    return [*points[:-1], _nearest(end, points[-2])]


def _at(robot, passage: Passage, aspect):
    """The bars where a passage is crossed, coming from an aspect."""
    if not passage.fold:
        inward = aspect.point - passage.xi
        pose = igm(robot, passage.xi + INSIDE * inward, aspect.working, unreachable="nan")
        return bars(pose)
    own, other = passage.leg, 1 - passage.leg
    drive, bar = robot.drives[other], robot.distal[other]
    dyad = drive.close(tuple(passage.xi.tolist()), bar, aspect.working[other])
    q, (x, y) = drive.coordinate(drive.held(dyad)), drive.bar(dyad)
    phi = np.arctan2(y, x)
    # Across the other distal bar, on the side that keeps the assembly mode; the proximal bar lies back on it.
    folded = phi + (1 if own else -1) * -aspect.assembly * np.pi / 2
    pairs = [None, None]
    pairs[own], pairs[other] = (folded + np.pi, folded), (q, phi)
    return np.array([*pairs[0], *pairs[1]])


def _nearest(angles, before):
    return angles + 2 * np.pi * np.round((before - angles) / (2 * np.pi))


def _path(robot, points):
    """The straight way through points (k, 4) moved onto the closed loop; None where that does not go smoothly."""
    if not np.isfinite(points).all():
        return None
    parts = [a + np.linspace(0, 1, POINTS)[:-1, None] * (b - a) for a, b in zip(points, points[1:])]
    c = tuple(np.concatenate([*parts, points[-1][None]]).T)
    rest = tuple(np.zeros_like(each) for each in c)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON):
            c = closed(robot, c, rest)[0]
    path = np.stack(c, axis=1)
    if not np.isfinite(path).all() or np.abs(path[[0, -1]] - [points[0], points[-1]]).max() > 1e-6:
        return None
    return path if np.abs(np.diff(path, axis=0)).max() < JUMP else None
