"""A planar mechanism in motion, and its body: bars, joints, motors, slides and base."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..skeleton import Skeleton
from ..style import PATH
from .frames import Frames
from .solids import arc, box, circle, cylinder, link, polygon
from .tracks import Part, place_tracks

PLATE = "#b9c1c9"
MOTOR = "#4a5058"
PIN = "#2a2e33"
STEEL = "#e8ebee"
RAIL = "#98a2ac"
EVENT = "#e51c23"
SHADOW_OFFSET = np.array([0.3, -0.4])  # widths of a bar: the light comes from the upper left
SHADOW = {"type": "MeshBasicMaterial", "transparent": True, "opacity": 0.13, "depthWrite": False}


class Notice(NamedTuple):
    """What is marked on the time line: s from the first sample, what it is, and where, m."""

    t: float
    text: str
    place: tuple


@dataclass(frozen=True, eq=False)
class Machine:
    """A mechanism at the frames of its motion.

    events are marked on the time line, layers are shown of it besides.
    """

    frames: Frames
    body: Skeleton
    events: tuple[Notice, ...] = ()
    layers: tuple = ()

    @cached_property
    def lengths(self) -> list[float]:
        """Mean length of each bar, m."""
        return [self._mean_length(bar) for bar in self.body.bars]

    def _mean_length(self, pair):
        return float(np.hypot(*self.body.span(pair).T).mean())

    @cached_property
    def size(self) -> float:
        """The larger side of the joints' extent, m; that of a point is 1."""
        return float(np.ptp(self.body.points.reshape(-1, 2), axis=0).max()) or 1.0

    @cached_property
    def width(self) -> float:
        """A bar's width, m: slim for its length, and never as wide as the shortest bar is long."""
        lengths = [length for length in self.lengths if length > 1e-6 * self.size]
        if not lengths:
            return 0.03 * self.size
        return min(0.085 * float(np.mean(lengths)), 0.5 * min(lengths))

    @cached_property
    def pen(self) -> float:
        """By what lines and arrows are measured, m: a bar's width, or more where bars are thin for
        the whole.
        """
        return max(self.width, 0.022 * self.size)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """((x, y) low, (x, y) high) of all that is drawn, m."""
        reach = [layer.reach(self) for layer in self.layers]
        shown = np.concatenate([self.body.points.reshape(-1, 2), *reach])
        border = 2.9 * self.width
        return shown.min(axis=0) - border, shown.max(axis=0) + border

    @property
    def layer(self) -> float:
        """A bar's share of the height, m."""
        return 0.4 * self.width

    @property
    def top(self) -> float:
        """The height over all bars, m."""
        return (len(self.body.bars) + 0.5) * self.layer

    @cached_property
    def heights(self) -> list[float]:
        """Where each bar is in the stack, m: its own layer, so that none cuts another."""
        order = list(range(len(self.lengths)))
        if self.body.legs:
            order.sort(key=self.body.legs.__getitem__)
        return [order.index(b) * self.layer for b in range(len(order))]

    @cached_property
    def groups(self) -> list[tuple[str, Part]]:
        """All parts, those of the layers too, each with its group: still or moving."""
        groups = [("still" if part.path == "base" else "moving", part) for part in self.parts()]
        for number, layer in enumerate(self.layers):
            group = "still" if layer.still else "moving"
            groups += [(group, part) for part in layer.parts(self, number)]
        return groups

    def parts(self) -> Iterator[Part]:
        """Yield the machine's own parts: base, guides, blocks, bars with their shadows, joints."""
        body = self.body
        w = self.width
        layer = self.layer
        yield Part("base", list(self._base()))
        for number, rail in enumerate(body.moving_rails):
            length = self._mean_length(rail)
            span = body.span(rail)
            guide = box((length / 2, 0.0), length, 0.6 * w, -1.2 * layer, -0.3 * layer, RAIL)
            yield Part(f"rails/{number}", [guide], place_tracks(body.points[:, rail[0]], span))
        for number, (i, j, joint) in enumerate(body.blocks):
            length = max(self._mean_length((i, j)), 2.6 * w)
            colour = MOTOR if joint in body.actuated else RAIL
            block = box((0.0, 0.0), length, 2.0 * w, -2.2 * layer, -0.25 * layer, colour)
            middle = (body.points[:, i] + body.points[:, j]) / 2
            yield Part(f"blocks/{number}", [block], place_tracks(middle, body.span((i, j))))
        for b, (bar, length) in enumerate(zip(body.bars, self.lengths)):
            tracks = place_tracks(body.points[:, bar[0]], body.span(bar))
            low = self.heights[b]
            colour = body.colours[b]
            shadow = link(length, 1.05 * w, -4.4 * layer, -4.3 * layer, "#000000", **SHADOW)
            yield Part(f"shadows/{b}", [shadow], tracks)
            solids = [link(length, w, low, low + 0.9 * layer, colour)]
            if length > 4 * w:
                groove = (length - 2.4 * w, 0.36 * w, low, low + 0.93 * layer)
                solids.append(link(*groove, _shaded(colour, 0.82), 1.2 * w))
            yield Part(f"bars/{b}", solids, tracks)
        for joint in body.joints:
            yield self._joint(joint)

    def _base(self):
        w = self.width
        layer = self.layer
        fixed = self.body.points[0]
        feet = fixed[self.body.feet]
        for foot in feet:
            yield box(foot, 3.4 * w, 3.4 * w, -4 * layer, -3 * layer, PLATE)
        for ends in zip(feet, feet[1:]):
            yield _beam(ends, 0.0, 2.2 * w, -4 * layer, -3.2 * layer, PLATE)
        for rail in self.body.fixed_rails:
            ends = fixed[list(rail)]
            yield _beam(ends, w, 1.5 * w, -4 * layer, -3 * layer, PLATE)
            yield _beam(ends, 0.0, 0.5 * w, -3 * layer, -1.6 * layer, RAIL)

    def _joint(self, joint):
        w = self.width
        layer = self.layer
        body = self.body
        bars = [height for bar, height in zip(body.bars, self.heights) if joint in bar] or [0.0]
        low = min(bars)
        top = max(bars) + 0.9 * layer
        solids = [
            cylinder(0.36 * w, low, top + 0.12 * layer, STEEL),
            cylinder(0.22 * w, low, top + 0.3 * layer, PATH if joint == body.traced else PIN),
        ]
        moved = body.points[:, joint]
        if joint in body.grounded:
            moved = moved[:1]
            if joint in body.actuated:
                solids.append(cylinder(1.25 * w, -3 * layer, -0.35 * layer, MOTOR))
                cover = _shaded(MOTOR, 1.3)
                solids.append(cylinder(0.85 * w, -3 * layer, -0.15 * layer, cover))
            else:
                solids.append(cylinder(0.75 * w, -3 * layer, -0.15 * layer, RAIL))
        elif joint in body.travelling:  # the motor is between the two bars it drives
            solids.append(cylinder(0.62 * w, low - 0.4 * layer, top + 0.06 * layer, MOTOR))
        return Part(f"joints/{joint}", solids, place_tracks(moved))

    @cached_property
    def flash(self) -> list[dict]:
        """The meshes of a ring about the place of an event, which the page moves and shows."""
        w = self.width
        height = self.top + 0.4 * self.width
        glass = {"transparent": True, "opacity": 0.25}
        disc = polygon(circle((0.0, 0.0), 1.5 * w, 49), height, EVENT, **glass)
        return [arc(1.8 * w, 0.6 * w, 2 * np.pi, 48, height, EVENT), disc]


def _shaded(colour, share):
    return "#" + "".join(f"{int(share * int(colour[k : k + 2], 16)):02x}" for k in (1, 3, 5))


def _beam(ends, longer, *size_and_colour):
    """Return a box from one end to the other, longer by so much."""
    start, end = ends
    dx, dy = end - start
    length = np.hypot(dx, dy) + longer
    return box((start + end) / 2, length, *size_and_colour, np.arctan2(dy, dx))
