"""Collisions between links: widths, layers, and distances in a pose."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from ..base.backend import finite_numbers
from ..base.checks import instance, not_negative, shown
from ..models.robots import FiveBar

BARS = ("11", "12", "21", "22")
# m^2, added to a squared distance, so that its root has a slope where the distance is 0.
SMOOTHING = 1e-9**2
# Bars joined by a joint, about which one lies over the other.
JOINED = {("11", "12"), ("21", "22"), ("12", "22")}


@dataclass(frozen=True)
class LinkCollisions:
    """Links that must not meet.

    Two bars of one layer that no joint connects keep half of both widths apart. The ends of bars
    are round. Only five-bar robots have them.

    Parameters
    ----------
    widths : float or (4,)
        Widths, m, of all bars or of the bars 11, 12, 21 and 22.
    layers : (4,) of int
        Layers of these bars. Bars of different layers pass over each other.
    posts : float
        Radius, m, of a motor's axle at each base joint, 0 for none.
    post_layers : int or sequence of int
        Layers that the axles stand in. There every bar keeps off them, except the proximal bar that
        the axle turns.

    Raises
    ------
    ValueError, TypeError
        A value is no such width or layer; the message names it.

    Examples
    --------
    >>> import fivebar as fb
    >>> pose = fb.dgm(fb.FiveBar(), (0.0, 0.0))
    >>> collisions = fb.LinkCollisions(widths=0.01)
    >>> {name: round(float(m), 4) for name, m in collisions.clearances(pose).items()}
    {'bars 11 and 21': 0.018, 'bars 11 and 22': 0.0791, 'bars 12 and 21': 0.0111}
    """

    widths: float | tuple[float, float, float, float] = 0.0
    layers: tuple[int, int, int, int] = (1, 1, 1, 1)
    posts: float = 0.0
    post_layers: Any = (1,)  # int or sequence of int, a tuple once checked

    def __post_init__(self) -> None:
        widths = finite_numbers(self.widths, "LinkCollisions: widths")
        if widths.ndim == 0:
            widths = np.full(4, widths)
        layers = _whole_numbers(self.layers, "layers")
        four = {"widths": widths, "layers": layers}
        for name, values in four.items():
            if len(values) != 4:
                raise ValueError(
                    f"LinkCollisions: {name} must be four, of the bars 11, 12, 21 and 22, not"
                    f" {shown(getattr(self, name))}"
                )
        widths = tuple(not_negative(width, "LinkCollisions: widths") for width in widths.tolist())
        object.__setattr__(self, "widths", widths)
        object.__setattr__(self, "layers", layers)
        posts = not_negative(self.posts, "LinkCollisions: posts")
        object.__setattr__(self, "posts", posts)
        post_layers = _whole_numbers(self.post_layers, "post_layers")
        object.__setattr__(self, "post_layers", post_layers)

    def clearances(self, pose: Any) -> dict[str, np.ndarray]:
        """Return the distances, m, between links that must not meet.

        Parameters
        ----------
        pose : Pose
            One pose or a batch, of a five-bar robot.

        Returns
        -------
        dict
            (*batch,) arrays by the links' names: negative where they meet, nan where the pose is.
        """
        instance(FiveBar)(pose.robot, "robot with link collisions")
        half = self._half_widths
        result = {}
        with np.errstate(invalid="ignore"):
            bars, bases = _ends(pose)
            for one, other in self.pairs(pose.robot.d):
                distance = segment_distance(*bars[one], *bars[other])
                name = f"bars {one} and {other}"
                result[name] = distance - half[one] - half[other]
            sides = "left", "right"
            for k, bar in self.posted(pose.robot.d):
                distance = point_segment_distance(bases[k], *bars[bar])
                name = f"bar {bar} and the {sides[k]} post"
                result[name] = distance - self.posts - half[bar]
        return result

    @property
    def _half_widths(self):
        return {bar: width / 2 for bar, width in zip(BARS, self.widths)}

    def pairs(self, d: float) -> list[tuple[str, str]]:
        """Return the bars that must not meet, of a robot whose bases are d apart."""
        layer = dict(zip(BARS, self.layers))
        pairs = []
        for pair in combinations(BARS, 2):
            one, other = pair
            joined = pair in JOINED
            if d == 0 and pair == ("11", "21"):
                joined = True
            if layer[one] == layer[other] and not joined:
                pairs.append(pair)
        return pairs

    def posted(self, d: float) -> list[tuple[int, str]]:
        """Return (post 0 or 1, bar) of those that must not meet."""
        result: list[tuple[int, str]] = []
        if not self.posts:
            return result
        for k in (0, 1):
            for bar, layer in zip(BARS, self.layers):
                proximal = bar[1] == "1"
                of_this_motor = d == 0 or bar[0] == str(k + 1)
                on_axle = proximal and of_this_motor
                if layer in self.post_layers and not on_axle:
                    result.append((k, bar))
        return result

    def smooth(self, pose: Any) -> list:
        """Return the clearances of CasADi symbols, m.

        They are differentiable, except where another end becomes the nearest.
        """
        import casadi as ca

        half = self._half_widths
        tip = ca.vertcat(*pose.point)
        ends = {}
        bases = []
        for leg in (0, 1):
            drive = pose.robot.drives[leg]
            length = pose.robot.distal[leg]
            u = pose.u2[leg]
            base = ca.vertcat(drive.x, drive.y)
            elbow = tip - length * ca.vertcat(*u)
            ends[f"{leg + 1}1"] = base, elbow
            ends[f"{leg + 1}2"] = elbow, tip
            bases.append(base)

        def distance(z, a, b):
            way = b - a
            offset = z - a
            share = ca.dot(offset, way) / ca.dot(way, way)
            share = ca.fmax(share, 0)
            share = ca.fmin(share, 1)
            offset = offset - share * way
            square = ca.dot(offset, offset)
            return ca.sqrt(square + SMOOTHING)

        def side(p, q, r):
            u = q - p
            v = r - p
            return u[0] * v[1] - u[1] * v[0]

        clearances = []
        for one, other in self.pairs(pose.robot.d):
            a, b = ends[one]
            c, d = ends[other]
            first = ca.fmin(distance(a, c, d), distance(b, c, d))
            second = ca.fmin(distance(c, a, b), distance(d, a, b))
            least = ca.fmin(first, second)
            divides = side(a, b, c) * side(a, b, d) < 0
            is_divided = side(c, d, a) * side(c, d, b) < 0
            crosses = ca.logic_and(divides, is_divided)
            signed = ca.if_else(crosses, -least, least)
            clearances.append(signed - half[one] - half[other])
        for k, bar in self.posted(pose.robot.d):
            centre = distance(bases[k], *ends[bar])
            clearances.append(centre - self.posts - half[bar])
        return clearances


def _whole_numbers(values, name):
    numbers = finite_numbers(values, f"LinkCollisions: {name}")
    numbers = np.atleast_1d(numbers)
    broken = numbers != np.round(numbers)
    if numbers.ndim != 1 or broken.any():
        raise ValueError(f"LinkCollisions: {name} must be whole numbers, not {shown(values)}")
    return tuple(map(int, numbers))


def _ends(pose):
    """Return {bar: its two ends} and the base joints, as complex numbers."""
    x, y = pose.point
    z = np.asarray(x) + 1j * np.asarray(y)
    bars = {}
    bases = []
    for leg in (0, 1):
        drive = pose.robot.drives[leg]
        ux, uy = pose.u2[leg]
        along = ux + 1j * np.asarray(uy)
        base = complex(drive.x, drive.y) + 0 * z
        elbow = z - pose.robot.distal[leg] * along
        bars[f"{leg + 1}1"] = base, elbow
        bars[f"{leg + 1}2"] = elbow, z
        bases.append(base)
    return bars, bases


def point_segment_distance(z: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distance of points from the segments a to b, all complex."""
    way = b - a
    offset = z - a
    projection = (offset * way.conj()).real
    share = np.clip(projection / np.abs(way) ** 2, 0, 1)
    return np.abs(offset - share * way)


def segment_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the distance of the segments a to b and c to d, all complex.

    Where they cross it is negative, by how far the nearest end is across.
    """
    distances = [
        point_segment_distance(a, c, d),
        point_segment_distance(b, c, d),
        point_segment_distance(c, a, b),
        point_segment_distance(d, a, b),
    ]
    least = np.min(distances, axis=0)

    def side(p, q, r):
        u = q - p
        v = r - p
        return (u.conj() * v).imag

    divides = side(a, b, c) * side(a, b, d) < 0
    is_divided = side(c, d, a) * side(c, d, b) < 0
    return np.where(divides & is_divided, -least, least)
