"""How the aspects hang together: where a motion may pass from one to another, and by which of them
to go.

Two aspects in working modes that differ in one leg share the arcs of Type 1 on which that leg is in
line: there both modes have one pose. Two in one mode share arcs of Type 2, across which the
assembly mode changes. A leg of equal bars may also fold on its base joint, turn there, and open in
either mode.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..base.backend import pairs
from ..base.representation import one_line
from ..base.robot_uses import takes_robot
from ..models.geometry import Pose, igm
from ..models.kinematics import a_pose
from ..models.robots import FiveBar
from .aspects import Aspect, aspects
from .margins import Singularity

SAMPLES = 33  # places on an arc, of which the one farthest from other singularities is kept
SHORTEST = 1e-6  # of an arc's range of parameters: less in common is rounding
BESIDE = 1e-4  # of the leg's bars: how far from its base joint it is asked what lies around a fold
DIRECTIONS = 16
MOST_ROUTES = 8


@dataclass(frozen=True, eq=False)
class Passage:
    """Where a motion can pass between two aspects, to and fro.

    between: numbers of both; type: SERIAL, where leg (0 left, 1 right) changes its working mode, or
    PARALLEL, leg None; xi (2,) m: a place on the arc far from other singularities; fold: only by
    folding the leg on its base joint.
    """

    between: tuple[int, int]
    type: Singularity
    leg: int | None
    xi: np.ndarray
    fold: bool = False


@dataclass(frozen=True, eq=False)
class Route:
    """A way from aspect to aspect: their numbers, and the passages between them in order."""

    aspects: tuple[int, ...]
    passages: tuple[Passage, ...]

    @property
    def folds(self) -> bool:
        """Whether a leg has to fold on its base joint."""
        return any(passage.fold for passage in self.passages)

    def __repr__(self) -> str:
        return one_line("Route", str(self))

    def __str__(self) -> str:
        words = [f"aspect {self.aspects[0]}"]
        for number, passage in zip(self.aspects[1:], self.passages):
            if passage.leg is None:
                how = "Type 2"
            else:
                how = f"{('left', 'right')[passage.leg]} leg"
            words.append(f"{how}{' folded' * passage.fold} -> {number}")
        return ", ".join(words)


@lru_cache(maxsize=8)
def known_aspects(robot: FiveBar) -> tuple[Aspect, ...]:
    """`aspects`, found once."""
    return aspects(robot)


@lru_cache(maxsize=8)
def passages(robot: FiveBar) -> tuple[Passage, ...]:
    """Return all passages between the aspects of a five-bar, the best of each kind between each
    two. Raises as `aspects`.

    What only single poses join is none: all four bars parallel (change-point robots), a leg folded
    on its base joint where the other one is in line.
    """
    found = []
    everything = known_aspects(robot)
    for k, one in enumerate(everything):
        for other in everything[k + 1 :]:
            differ = [leg for leg in (0, 1) if one.working[leg] != other.working[leg]]
            if len(differ) > 1 or (differ and one.assembly != other.assembly):
                continue
            leg = differ[0] if differ else None
            xi = _shared_place(robot, one, other, leg)
            if xi is not None:
                kind = Singularity.PARALLEL if leg is None else Singularity.SERIAL
                found.append(Passage((one.number, other.number), kind, leg, xi))
    joined = {passage.between for passage in found}
    return (*found, *(fold for fold in _folds(robot, everything) if fold.between not in joined))


def _shared_place(robot, one, other, leg):
    """Return the place, far from other singularities, on the arcs that both have: of Type 2, or
    where that leg is in line.
    """
    wanted = Singularity.PARALLEL if leg is None else Singularity.SERIAL
    best = None
    farthest = 0.0
    for a in _arcs(one, wanted, leg):
        for b in _arcs(other, wanted, leg):
            if a.locus is not b.locus:
                continue
            low = max(min(a.start, a.end), min(b.start, b.end))
            high = min(max(a.start, a.end), max(b.start, b.end))
            if high - low <= SHORTEST * abs(a.end - a.start):
                continue
            z = a.at(low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES)
            pose = igm(robot, pairs(z), one.working, unreachable="nan")
            if leg is None:
                others = [*pose.sines]
            else:
                others = [pose.sines[1 - leg], pose.det_A]
            clear = np.nan_to_num(np.abs(others).min(axis=0))
            if clear.max() > farthest:
                best = pairs(z)[clear.argmax()]
                farthest = float(clear.max())
    return best


def _arcs(aspect, wanted, leg):
    if leg is None:
        side = ""
    else:
        side = ("left", "right")[leg]
    for loop in aspect.boundary:
        for arc in loop:
            if arc.locus.type == wanted and arc.locus.kind.startswith(side):
                yield arc


def _folds(robot, everything):
    """Passages through a leg of equal bars folded on its base joint, where the aspects share no
    arc.
    """
    around = BESIDE * pairs(np.exp(1j * np.linspace(0.1, 6.0, DIRECTIONS)))
    for leg, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        if drive.length != bar:
            continue
        centre = np.array([drive.x, drive.y])
        meeting = [aspect for aspect in everything if aspect.contains(centre + bar * around).any()]
        for k, one in enumerate(meeting):
            for other in meeting[k + 1 :]:
                same = (
                    one.working[1 - leg] == other.working[1 - leg]
                    and one.assembly == other.assembly
                )
                if same and one.working[leg] != other.working[leg]:
                    yield Passage((one.number, other.number), Singularity.SERIAL, leg, centre, True)


def aspect_of(pose: Pose) -> Aspect:
    """Return the aspect in which a pose is; ValueError where it is singular."""
    working = tuple(int(mode) for mode in pose.working)
    found = known_aspects(pose.robot)
    for aspect in found:
        if aspect.working == working and aspect.contains(pose.xi):
            return aspect
    x, y = pose.xi
    raise ValueError(
        f"this pose is in no aspect, as it is singular: xi = ({x:.9g}, {y:.9g}) m, modes {working}"
    )


@takes_robot(start=a_pose, goal=a_pose)
def routes(robot: FiveBar, start: Pose, goal: Pose) -> tuple[Route, ...]:
    """Return the ways from start to goal through aspects, those with fewest crossings first.

    At most eight of them. None visits an aspect twice.

    Parameters
    ----------
    robot : FiveBar
    start, goal : Pose
        Regular poses.

    Returns
    -------
    tuple of Route
        () where no way joins them.

    Raises
    ------
    ValueError
        A pose is not regular.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> start = fb.igm(robot, (0.05, 0.09), (-1, -1))
    >>> goal = fb.igm(robot, (0.05, 0.09), (1, -1))
    >>> len(fb.routes(robot, start, goal)[0].passages)
    1
    """
    for name, pose in (("start", start), ("goal", goal)):
        if np.shape(pose.xi) != (2,) or not np.isfinite(pose.xi).all():
            raise ValueError(f"routes: {name} must be one Pose that closes, of numbers")
        if pose.robot != robot:
            raise ValueError(
                f"routes: {name} is a pose of another robot: {pose.robot}, not {robot}"
            )
    first = aspect_of(start).number
    last = aspect_of(goal).number
    neighbours: dict[int, list] = {}
    for passage in passages(robot):
        for here, there in (passage.between, passage.between[::-1]):
            neighbours.setdefault(here, []).append((there, passage))
    found: list[Route] = []
    waiting: deque[tuple[tuple, tuple]] = deque([((first,), ())])
    while waiting and len(found) < MOST_ROUTES:  # by breadth, so that the shortest come first
        way, taken = waiting.popleft()
        if way[-1] == last:
            found.append(Route(way, taken))
            continue
        waiting += [
            ((*way, there), (*taken, p))
            for there, p in neighbours.get(way[-1], ())
            if there not in way
        ]
    return tuple(found)
