"""A mechanism's body, stated once for every picture: where its joints are, and what joins them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..models.four_joints import four_joint_pose
from ..models.joint_positions import elbows
from ..models.joint_positions import joints as joint_points
from .style import LEGS, LINKS

if TYPE_CHECKING:
    from ..linkages import Study
    from ..models.geometry import Pose
    from ..models.robots import Robot
    from ..simulation.run import Run


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A mechanism's body in m poses.

    points (m, k, 2) m, joints and ends of guides and blocks; bars: pairs (i, j) of points, each
    leg's from the base outwards; grounded: points fixed to the base; actuated: joints that a motor
    turns or moves; traced: the point whose path is drawn, or None; rails: pairs of points between
    which a straight guide is; blocks: (i, j, joint), both ends of a block that slides on a guide
    and the joint on it; names: a text for each point, or empty; called: what each
    link is called, or empty: then each leg has a hue, not each link a colour.
    """

    points: np.ndarray
    bars: tuple
    grounded: tuple = ()
    actuated: tuple = ()
    traced: int | None = None
    rails: tuple = ()
    blocks: tuple = ()
    names: tuple = ()
    called: tuple = ()

    def __post_init__(self):
        count = self.points.shape[1]
        groups = {"bars": self.bars, "rails": self.rails, "blocks": self.blocks}
        named = [
            (f"{name}[{k}]", each) for name, group in groups.items() for k, each in enumerate(group)
        ]
        named += [("grounded", self.grounded), ("actuated", self.actuated)]
        for name, joints in [*named, ("traced", () if self.traced is None else (self.traced,))]:
            for joint in joints:
                if joint not in range(count):
                    raise ValueError(
                        f"{name} names joint {joint}, but points has joints 0 to {count - 1}"
                    )

    def at(self, samples: np.ndarray | slice) -> Skeleton:
        """The body in some of its poses."""
        return replace(self, points=self.points[samples])

    def span(self, pair: tuple) -> np.ndarray:
        """From the first to the second of two points, (m, 2) m."""
        return self.points[:, pair[1]] - self.points[:, pair[0]]

    @cached_property
    def ends(self) -> set:
        """Points that only mark the ends of guides and blocks."""
        return {point for pair in (*self.rails, *self.blocks) for point in pair[:2]}

    @property
    def joints(self) -> list:
        """All other points."""
        return [point for point in range(self.points.shape[1]) if point not in self.ends]

    @property
    def feet(self) -> list:
        """Joints that are fixed to the base."""
        return [joint for joint in self.grounded if joint not in self.ends]

    @property
    def travelling(self) -> set:
        """Joints with a motor that travels with them and not on a guide."""
        return set(self.actuated) - set(self.grounded) - {joint for *_, joint in self.blocks}

    @property
    def fixed_rails(self) -> list:
        return [rail for rail in self.rails if set(rail) <= set(self.grounded)]

    @property
    def moving_rails(self) -> list:
        return [rail for rail in self.rails if rail not in self.fixed_rails]

    @cached_property
    def legs(self) -> list:
        """(depth, leg) of each bar: how many bars are between it and the nearest fixed joint, and
        which one that is.
        """
        fixed = [
            j
            for j in dict.fromkeys([*self.grounded, *self.actuated])
            if any(j in bar for bar in self.bars)
        ]
        roots = fixed or dict.fromkeys(bar[0] for bar in self.bars)
        reached, legs = {joint: (0, leg) for leg, joint in enumerate(roots)}, {}
        while wave := {
            b: min(reached[joint] for joint in bar if joint in reached)
            for b, bar in enumerate(self.bars)
            if b not in legs and not reached.keys().isdisjoint(bar)
        }:
            legs |= wave
            for b, (depth, leg) in wave.items():
                for joint in self.bars[b]:
                    reached.setdefault(joint, (depth + 1, leg))
        return [legs.get(b, (0, 0)) for b in range(len(self.bars))]

    @cached_property
    def links(self) -> list:
        """For each bar the number of its link: three bars that close a triangle are one."""
        links = list(range(len(self.bars)))
        for three in combinations(range(len(self.bars)), 3):
            if len({joint for b in three for joint in self.bars[b]}) == 3:
                first = min(links[b] for b in three)
                links = [first if link in [links[b] for b in three] else link for link in links]
        return [sorted(set(links)).index(link) for link in links]

    @property
    def colours(self) -> list[str]:
        """For each bar."""
        if self.called:
            return [LINKS[link % len(LINKS)] for link in self.links]
        return [LEGS[leg % len(LEGS)][depth % 2] for depth, leg in self.legs]

    @property
    def key(self) -> dict[str, list[str]]:
        """What the colours of the bars say: {link or leg: its colours}."""
        whose = self.links if self.called else [leg for _, leg in self.legs]
        words, key = self.called or ("left leg", "right leg"), {}
        for number, colour in dict.fromkeys(zip(whose, self.colours)):
            if number < len(words):
                key.setdefault(words[number], []).append(colour)
        return key

    @property
    def paths(self) -> list:
        """Of each leg the points from its first bar outwards."""
        legs = {}
        for (first, last), (_, leg) in zip(self.bars, self.legs):
            legs.setdefault(leg, [first]).append(last)
        return list(legs.values())


def robot_body(robot: Robot, pivots: np.ndarray, xi: np.ndarray) -> Skeleton:
    """The body of a robot from its elbows or feet (m, 2, 2) m and its end-effector (m, 2) m.

    Guides, which have no ends, are as long as these poses need.
    """
    points = joint_points(robot, pivots, xi)
    if robot.turns:
        return Skeleton(
            points, ((0, 1), (1, 2), (4, 3), (3, 2)), grounded=(0, 4), actuated=(0, 4), traced=2
        )
    bar = max(robot.distal)
    low, high = (
        np.fmin.reduce(pivots[..., 1].ravel()) - 0.3 * bar,
        np.fmax.reduce(pivots[..., 1].ravel()) + 0.3 * bar,
    )
    rails = [
        np.broadcast_to((drive.x, end), xi.shape) for drive in robot.drives for end in (low, high)
    ]
    blocks = [
        foot + (0, side * 0.07 * bar) for foot in np.moveaxis(pivots, 1, 0) for side in (-1, 1)
    ]
    points = np.concatenate([points, np.stack([*rails, *blocks], axis=1)], axis=1)
    return Skeleton(
        points,
        ((0, 1), (2, 1)),
        grounded=(3, 4, 5, 6),
        actuated=(0, 2),
        traced=1,
        rails=((3, 4), (5, 6)),
        blocks=((7, 8, 0), (9, 10, 2)),
    )


def run_body(run: Run) -> Skeleton:
    """The body of a robot at all samples of its Run."""
    return robot_body(run.robot, elbows(run.robot, run.q), run.xi)


def pose_body(poses: Iterable[Pose]) -> Skeleton:
    """The body of one robot in poses or batches of poses, one after the other."""
    poses = list(poses)
    pivots = np.concatenate([pose.elbows.reshape(-1, 2, 2) for pose in poses])
    return robot_body(
        poses[0].robot, pivots, np.concatenate([pose.xi.reshape(-1, 2) for pose in poses])
    )


def measured_pose(robot: Robot, q: np.ndarray, xi: np.ndarray) -> Pose:
    """The pose of joints q (m, 2) and end-effector xi (m, 2) as they were simulated, singular or
    not.
    """
    spans = np.moveaxis(xi[:, None] - elbows(robot, q), -1, 0)
    phi = np.arctan2(spans[1], spans[0]).T
    passive = [drive.relative(*angles) for drive, *angles in zip(robot.drives, phi, q.T)]
    return four_joint_pose(robot, tuple(q.T), tuple(passive))


def study_body(study: Study) -> Skeleton:
    """The body of a linkage at all samples of its Study."""
    chain, known = study.motion.chain, study.motion.points
    begins = [chain.points[first] for first, _ in chain.bars]
    called = [
        name for begin in begins for name, link in chain.links.items() if link.origin is begin
    ]

    def index(names):
        return tuple(map(known.index, names))

    return Skeleton(
        study.points(),
        tuple(map(index, chain.bars)),
        index(chain.grounded),
        index(chain.actuated),
        known.index(chain.traced),
        tuple(map(index, chain.rails)),
        tuple(map(index, chain.blocks)),
        tuple("" if name in chain.marks else name for name in known),
        tuple(dict.fromkeys(called)),
    )
