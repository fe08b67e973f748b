"""A mechanism's body, stated once for every picture: where its joints are, and what joins them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.four_joints import four_joint_pose
from ..models.joint_positions import beside_joint, elbows
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
    and the joint on it; names: a text for each point, or empty; link_names: one for each link of a
    linkage; legs: of a robot for each bar (0 proximal or 1 distal, leg), by which it has its hue.
    """

    points: np.ndarray
    bars: tuple
    grounded: tuple = ()
    actuated: tuple = ()
    traced: int | None = None
    rails: tuple = ()
    blocks: tuple = ()
    names: tuple = ()
    link_names: tuple = ()
    legs: tuple = ()

    def at(self, samples: np.ndarray | slice) -> Skeleton:
        """Return the body in some of its poses."""
        return replace(self, points=self.points[samples])

    def span(self, pair: tuple) -> np.ndarray:
        """Return the vector from the first to the second of two points, (m, 2) m."""
        return self.points[:, pair[1]] - self.points[:, pair[0]]

    @cached_property
    def _ends(self):
        """Points that only mark the ends of guides and blocks."""
        return {point for pair in (*self.rails, *self.blocks) for point in pair[:2]}

    @property
    def joints(self) -> list:
        """All other points."""
        return [point for point in range(self.points.shape[1]) if point not in self._ends]

    @property
    def feet(self) -> list:
        """Joints that are fixed to the base."""
        return [joint for joint in self.grounded if joint not in self._ends]

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
    def links(self) -> list:
        """For each bar the number of its link: three bars that close a triangle are one."""
        links = np.arange(len(self.bars))
        for three in map(list, combinations(links, 3)):
            if len(set(np.take(self.bars, three, axis=0).ravel())) == 3:
                links[np.isin(links, links[three])] = links[three].min()
        return np.unique(links, return_inverse=True)[1].tolist()

    @property
    def colours(self) -> list[str]:
        """For each bar."""
        if self.legs:
            return [LEGS[leg][depth] for depth, leg in self.legs]
        return [LINKS[link % len(LINKS)] for link in self.links]

    @property
    def key(self) -> dict[str, list[str]]:
        """What the colours of the bars say: {link or leg: its colours}."""
        numbers = [leg for _, leg in self.legs] or self.links
        names = self.link_names or ("left leg", "right leg")
        key: dict = {}
        for number, colour in dict.fromkeys(zip(numbers, self.colours)):
            if number < len(names):
                key.setdefault(names[number], []).append(colour)
        return key


def robot_body(
    robot: Robot, pivots: np.ndarray, xi: np.ndarray, tool: tuple[int, float, float] | None = None
) -> Skeleton:
    """Return the body of a robot from its elbows or feet (m, 2, 2) m and end-effector (m, 2) m.

    Guides, which have no ends, are as long as these poses need. tool: leg, along and across, m; it
    is drawn as a bar of its leg from the joint on.
    """
    points = joint_points(robot, pivots, xi)
    if robot.turns:
        bars: tuple = (0, 1), (1, 2), (4, 3), (3, 2)
        legs: tuple = (0, 0), (1, 0), (0, 1), (1, 1)
        traced = 2
        if tool is not None:
            leg, along, across = tool
            tip = beside_joint(pivots[:, leg - 1], xi, along, across)
            points = np.concatenate([points, tip[:, None]], axis=1)
            traced = 5
            bars += ((2, traced),)
            legs += ((1, leg - 1),)
        return Skeleton(points, bars, grounded=(0, 4), actuated=(0, 4), traced=traced, legs=legs)
    bar = max(robot.distal)
    low = np.fmin.reduce(pivots[..., 1], axis=None) - 0.3 * bar
    high = np.fmax.reduce(pivots[..., 1], axis=None) + 0.3 * bar
    left, right = (np.full(len(xi), drive.x) for drive in robot.drives)
    rails = [(left, 0 * left + low), (left, 0 * left + high)]
    rails += [(right, 0 * right + low), (right, 0 * right + high)]
    half = np.array([0, 0.07 * bar])
    blocks = np.concatenate([pivots - half, pivots + half], axis=1)[:, [0, 2, 1, 3]]
    ends = np.moveaxis(np.array(rails), -1, 0)
    points = np.concatenate([points, ends, blocks], axis=1)
    return Skeleton(
        points,
        ((0, 1), (2, 1)),
        grounded=(3, 4, 5, 6),
        actuated=(0, 2),
        traced=1,
        rails=((3, 4), (5, 6)),
        blocks=((7, 8, 0), (9, 10, 2)),
        legs=((0, 0), (0, 1)),
    )


def run_body(run: Run) -> Skeleton:
    """Return the body of a robot at all samples of its Run."""
    return robot_body(run.robot, elbows(run.robot, run.q), run.xi, run.tool)


def pose_body(poses: Iterable[Pose], tool: tuple[int, float, float] | None = None) -> Skeleton:
    """Return the body of one robot in poses or batches of poses, one after the other."""
    poses = list(poses)
    pivots = np.concatenate([pose.elbows.reshape(-1, 2, 2) for pose in poses])
    xi = np.concatenate([pose.xi.reshape(-1, 2) for pose in poses])
    return robot_body(poses[0].robot, pivots, xi, tool)


def measured_pose(robot: Robot, q: np.ndarray, xi: np.ndarray) -> Pose:
    """Return the pose of joints q (m, 2) and end-effector xi (m, 2) as they were simulated,
    singular or not.
    """
    x, y = np.moveaxis(xi[:, None] - elbows(robot, q), -1, 0)
    phi = np.arctan2(y, x).T
    passive = [drive.relative(*angles) for drive, *angles in zip(robot.drives, phi, q.T)]
    return four_joint_pose(robot, tuple(q.T), tuple(passive))


def study_body(study: Study) -> Skeleton:
    """Return the body of a linkage at all samples of its Study."""
    chain = study.motion.chain
    names = study.motion.points
    links = []
    for begin, _ in chain.bars:
        origin = chain.points[begin]
        links += [name for name, link in chain.links.items() if link.origin is origin]
    links = tuple(dict.fromkeys(links))
    texts = tuple("" if name in chain.marks else name for name in names)
    return Skeleton(study.points(), **chain_parts(chain), names=texts, link_names=links)


def chain_parts(chain: Any) -> dict:
    """Return bars, rails and so on of a linkage's chain by the numbers of its points."""
    index = {name: k for k, name in enumerate(chain.points)}

    def numbers(names):
        return tuple(index[name] for name in names)

    return {
        "bars": tuple(map(numbers, chain.bars)),
        "grounded": numbers(chain.grounded),
        "actuated": numbers(chain.actuated),
        "traced": index[chain.traced],
        "rails": tuple(map(numbers, chain.rails)),
        "blocks": tuple(map(numbers, chain.blocks)),
    }
