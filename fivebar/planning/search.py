"""First motions between two poses: straight in the bars' angles, both ways round, and by way of the aspects."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product

import numpy as np

from ..models.four_joints import closed
from ..models.geometry import Pose, igm
from ..models.robots import Robot
from ..singularities.aspects import aspects
from ..singularities.passages import Passage, routes
from .coordinates import bars
from .problem import PlanError

DIRECT, ROUTES = 4, 4  # guesses of either kind
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


def _routes(robot, start, goal):
    """Routes by the aspects; None where these are not known, or a pose is singular."""
    try:
        return routes(robot, start, goal)
    except (ValueError, ArithmeticError):
        return None


def _waypoints(robot, route, begin, end):
    points, everything = [begin], aspects(robot)
    for number, passage in zip(route.aspects, route.passages):
        points.append(_nearest(_at(robot, passage, everything[number - 1]), points[-1]))
        inner = everything[passage.between[passage.between[0] == number] - 1]
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
