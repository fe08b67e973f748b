"""Bars that must not meet: their widths, the layers they turn in, and how far apart they are in a
pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..base.backend import finite_numbers
from ..base.checks import instance, not_negative, shown
from ..models.geometry import Pose
from ..models.robots import FiveBar

NAMES = ("11", "12", "21", "22")
TOUCHING = 1e-9  # m, by which a distance is larger, so that it has a slope where it is 0
JOINED = {
    ("11", "12"),
    ("21", "22"),
    ("12", "22"),
}  # by a joint, about which one lies over the other


@dataclass(frozen=True)
class LinkCollisions:
    """Bars that must not meet: two in one layer, not joined to each other, keep their half widths
    apart.

    widths: m, of all bars or of 11, 12, 21, 22; ends are round. layers: of these four; bars of
    different layers pass over each other; joined bars may share one. posts: radius, m, of a motor's
    axle at each base joint, 0: none; it stands in post_layers, where every bar but the proximal one
        that it turns keeps off it.
    """

    widths: float | tuple[float, float, float, float] = 0.0
    layers: tuple[int, int, int, int] = (1, 1, 1, 1)
    posts: float = 0.0
    post_layers: tuple[int, ...] = (1,)

    def __post_init__(self) -> None:
        widths = finite_numbers(self.widths, "LinkCollisions: widths")
        widths = np.full(4, widths) if widths.ndim == 0 else widths
        layers = finite_numbers(self.layers, "LinkCollisions: layers")
        posts = np.atleast_1d(finite_numbers(self.post_layers, "LinkCollisions: post_layers"))
        for name, value, given in (
            ("widths", widths, self.widths),
            ("layers", layers, self.layers),
        ):
            if value.shape != (4,):
                raise ValueError(
                    f"LinkCollisions: {name} must be four, of the bars 11, 12, 21 and 22, not"
                    f" {shown(given)}"
                )
        for name, value, given in (
            ("layers", layers, self.layers),
            ("post_layers", posts, self.post_layers),
        ):
            if value.ndim != 1 or (value != np.round(value)).any():
                raise ValueError(
                    f"LinkCollisions: {name} must be whole numbers, not {shown(given)}"
                )
        object.__setattr__(
            self,
            "widths",
            tuple(not_negative(each, "LinkCollisions: widths") for each in widths.tolist()),
        )
        object.__setattr__(self, "layers", tuple(map(int, layers)))
        object.__setattr__(self, "posts", not_negative(self.posts, "LinkCollisions: posts"))
        object.__setattr__(self, "post_layers", tuple(map(int, posts)))

    def clearances(self, pose: Pose) -> dict[str, np.ndarray]:
        """How far apart what must not meet is, m, (*batch,) by words; below 0 it meets, nan where
        the pose is.
        """
        instance(FiveBar)(pose.robot, "robot of bars")
        with np.errstate(invalid="ignore"):
            return dict(self._rooms(*_ends(pose), pose.robot.d))

    def _rooms(self, bars, bases, d):
        half = {name: width / 2 for name, width in zip(NAMES, self.widths)}
        for one, other in self.pairs(d):
            yield (
                f"bars {one} and {other}",
                apart(*bars[one], *bars[other]) - half[one] - half[other],
            )
        for k, name in self.posted(d):
            clearance = off(bases[k], *bars[name]) - self.posts - half[name]
            yield f"bar {name} and the {('left', 'right')[k]} post", clearance

    def pairs(self, d: float) -> list[tuple[str, str]]:
        """The bars that must not meet, of a robot whose bases are d apart."""
        layer, free = dict(zip(NAMES, self.layers)), JOINED | ({("11", "21")} if d == 0 else set())
        return [
            pair
            for pair in combinations(NAMES, 2)
            if pair not in free and layer[pair[0]] == layer[pair[1]]
        ]

    def posted(self, d: float) -> list[tuple[int, str]]:
        """(which post, bar) of those that must not meet."""
        return [
            (k, name)
            for k, _ in enumerate("lr" if self.posts else "")
            for name, layer in zip(NAMES, self.layers)
            if name != f"{k + 1}1" and layer in self.post_layers and not (d == 0 and name[1] == "1")
        ]

    def smooth(self, pose: Pose) -> list:
        """`rooms` of CasADi symbols, m: they have slopes, but where another end becomes the
        nearest.
        """
        import casadi as ca

        half, ends, bases = {name: width / 2 for name, width in zip(NAMES, self.widths)}, {}, []
        for leg, (drive, length, u) in enumerate(
            zip(pose.robot.drives, pose.robot.distal, pose.u2), start=1
        ):
            base, tip = ca.vertcat(drive.x, drive.y), ca.vertcat(*pose.point)
            elbow = tip - length * ca.vertcat(*u)
            ends[f"{leg}1"], ends[f"{leg}2"] = (base, elbow), (elbow, tip)
            bases.append(base)

        def off(z, a, b):
            way = b - a
            part = ca.fmin(ca.fmax(ca.dot(z - a, way) / ca.dot(way, way), 0), 1)
            away = z - a - part * way
            return ca.sqrt(ca.dot(away, away) + TOUCHING**2)

        def side(p, q, r):
            u, v = q - p, r - p
            return u[0] * v[1] - u[1] * v[0]

        found = []
        for one, other in self.pairs(pose.robot.d):
            (a, b), (c, d) = ends[one], ends[other]
            least = ca.fmin(
                ca.fmin(off(a, c, d), off(b, c, d)), ca.fmin(off(c, a, b), off(d, a, b))
            )
            crossing = ca.logic_and(
                side(a, b, c) * side(a, b, d) < 0, side(c, d, a) * side(c, d, b) < 0
            )
            found.append(ca.if_else(crossing, -least, least) - half[one] - half[other])
        return found + [
            off(bases[k], *ends[name]) - self.posts - half[name]
            for k, name in self.posted(pose.robot.d)
        ]


def _ends(pose):
    """{bar: its two ends}, and the base joints, as complex numbers."""
    z = np.asarray(pose.point[0]) + 1j * np.asarray(pose.point[1])
    bars, bases = {}, []
    for leg, (drive, length, (ux, uy)) in enumerate(
        zip(pose.robot.drives, pose.robot.distal, pose.u2), start=1
    ):
        base, elbow = complex(drive.x, drive.y) + 0 * z, z - length * (ux + 1j * np.asarray(uy))
        bars[f"{leg}1"], bars[f"{leg}2"] = (base, elbow), (elbow, z)
        bases.append(base)
    return bars, bases


def off(z: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distance of points from segments a to b."""
    way = b - a
    part = np.clip(((z - a) * way.conj()).real / np.abs(way) ** 2, 0, 1)
    return np.abs(z - a - part * way)


def apart(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Distance of segments a to b and c to d; where they cross, less than 0, by how far the nearest
    end is across.
    """
    least = np.min([off(a, c, d), off(b, c, d), off(c, a, b), off(d, a, b)], axis=0)

    def side(p, q, r):
        return ((q - p).conj() * (r - p)).imag

    crossing = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return np.where(crossing, -least, least)
