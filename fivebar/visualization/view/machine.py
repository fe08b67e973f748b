"""A planar mechanism in motion, as all pictures of it take it, and its body: bars, joints, motors,
slides and base.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..skeleton import Skeleton
from ..style import PATH
from .frames import Frames
from .solids import box, cylinder, link, polygon
from .tracks import Part, angles_of, placed

PLATE, MOTOR, PIN, STEEL, RAIL = "#b9c1c9", "#4a5058", "#2a2e33", "#e8ebee", "#98a2ac"
EVENT = "#e51c23"


class Notice(NamedTuple):
    """What is marked on the time line: s from the first sample, what it is, and where, m."""

    t: float
    text: str
    place: tuple


@dataclass(frozen=True, eq=False)
class Machine:
    """A mechanism at the frames of its motion; events are marked on the time line, layers shown of
    it besides.
    """

    frames: Frames
    body: Skeleton
    events: tuple[Notice, ...] = ()
    layers: tuple = ()

    @cached_property
    def lengths(self) -> list[float]:
        """Mean length of each bar, m."""
        return [float(np.hypot(*self.body.span(bar).T).mean()) for bar in self.body.bars]

    @cached_property
    def extent(self) -> tuple[np.ndarray, np.ndarray]:
        """((x, y) low, (x, y) high) of the joints, m."""
        flat = self.body.points.reshape(-1, 2)
        return flat.min(axis=0), flat.max(axis=0)

    @cached_property
    def size(self) -> float:
        """The larger side of `extent`, m; that of a point is 1."""
        return float((self.extent[1] - self.extent[0]).max()) or 1.0

    @cached_property
    def width(self) -> float:
        """A bar's width, m: slim for its length, and never as wide as the shortest bar is long."""
        lengths = [length for length in self.lengths if length > 1e-6 * self.size]
        return (
            min(0.085 * float(np.mean(lengths)), 0.5 * min(lengths))
            if lengths
            else 0.03 * self.size
        )

    @cached_property
    def pen(self) -> float:
        """By what lines and arrows are measured, m: a bar's width, or more where bars are thin for
        the whole.
        """
        return max(self.width, 0.022 * self.size)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """((x, y) low, (x, y) high) of all that is drawn, m."""
        shown = np.concatenate(
            [self.body.points.reshape(-1, 2), *(layer.reach(self) for layer in self.layers)]
        )
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
        order = sorted(range(len(self.lengths)), key=self.body.legs.__getitem__)
        return [order.index(b) * self.layer for b in range(len(order))]


def parts(machine: Machine) -> Iterator[Part]:
    """The machine's own parts, as Part: base, guides, blocks, bars with their shadows, and
    joints.
    """
    body = machine.body
    yield Part("base", _base(machine))
    for number, rail in enumerate(body.moving_rails):
        yield _rail(machine, number, rail)
    for number, block in enumerate(body.blocks):
        yield _block(machine, number, *block)
    w, layer = machine.width, machine.layer
    for b, (bar, length) in enumerate(zip(body.bars, machine.lengths)):
        tracks = placed(body.points[:, bar[0]], angles_of(body.span(bar)))
        low, colour = machine.heights[b], body.colours[b]
        yield Part(
            f"shadows/{b}",
            [link(length, 1.05 * w, -4.4 * layer, -4.3 * layer, "#000000", **SHADOW)],
            tracks,
        )
        solids = [link(length, w, low, low + 0.9 * layer, colour)]
        if length > 4 * w:
            groove = link(length - 2.4 * w, 0.36 * w, low, low + 0.93 * layer, _darker(colour))
            solids.append({**groove, "matrix": [*groove["matrix"][:12], 1.2 * w, 0.0, 0.0, 1.0]})
        yield Part(f"bars/{b}", solids, tracks)
    for joint in body.joints:
        yield _joint(machine, joint)


SHADOW = {"type": "MeshBasicMaterial", "transparent": True, "opacity": 0.13, "depthWrite": False}


def _darker(colour, share=0.82):
    return "#" + "".join(f"{int(share * int(colour[k : k + 2], 16)):02x}" for k in (1, 3, 5))


def _joint(machine, joint):
    w, layer, body = machine.width, machine.layer, machine.body
    here = [height for bar, height in zip(body.bars, machine.heights) if joint in bar] or [0.0]
    top = max(here) + 0.9 * layer
    solids = [
        cylinder(0.36 * w, min(here), top + 0.12 * layer, STEEL),
        cylinder(0.22 * w, min(here), top + 0.3 * layer, PATH if joint == body.traced else PIN),
    ]
    moved = body.points[:, joint]
    if joint in body.grounded:
        moved = moved[:1]
        if joint in body.actuated:
            solids += [cylinder(1.25 * w, -3 * layer, -0.35 * layer, MOTOR)]
            solids += [cylinder(0.85 * w, -3 * layer, -0.15 * layer, _darker(MOTOR, 1.3))]
        else:
            solids.append(cylinder(0.75 * w, -3 * layer, -0.15 * layer, RAIL))
    elif joint in body.travelling:  # the motor is between the two bars it drives
        solids.append(cylinder(0.62 * w, min(here) - 0.4 * layer, top + 0.06 * layer, MOTOR))
    return Part(f"joints/{joint}", solids, placed(moved))


def _base(machine):
    w, layer, fixed = machine.width, machine.layer, machine.body.points[0]
    feet, solids = fixed[machine.body.feet], []
    for foot in feet:
        solids.append(box(foot, 3.4 * w, 3.4 * w, -4 * layer, -3 * layer, PLATE))
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            solids.append(
                cylinder(
                    0.2 * w, -3 * layer, -2.8 * layer, RAIL, foot + 1.35 * w * np.array([x, y])
                )
            )
    for a, b in zip(feet, feet[1:]):
        angle = np.arctan2(*(b - a)[::-1])
        solids.append(
            box((a + b) / 2, np.hypot(*(b - a)), 2.2 * w, -4 * layer, -3.2 * layer, PLATE, angle)
        )
    for rail in machine.body.fixed_rails:
        ends = a, b = fixed[list(rail)]
        angle, length, middle = np.arctan2(*(b - a)[::-1]), np.hypot(*(b - a)), (a + b) / 2
        solids.append(box(middle, length + w, 1.5 * w, -4 * layer, -3 * layer, PLATE, angle))
        solids.append(box(middle, length, 0.5 * w, -3 * layer, -1.6 * layer, RAIL, angle))
        for end in ends:
            solids.append(box(end, 0.5 * w, 1.7 * w, -4 * layer, -1.2 * layer, MOTOR, angle))
    return solids


def _rail(machine, number, rail):
    w, layer, span = machine.width, machine.layer, machine.body.span(rail)
    length = float(np.hypot(*span.T).mean())
    solids = [box((length / 2, 0.0), length, 0.6 * w, -1.2 * layer, -0.3 * layer, RAIL)]
    return Part(f"rails/{number}", solids, placed(machine.body.points[:, rail[0]], angles_of(span)))


def _block(machine, number, i, j, joint):
    w, layer, body = machine.width, machine.layer, machine.body
    span, driven = body.span((i, j)), joint in body.actuated
    length = max(float(np.hypot(*span.T).mean()), 2.6 * w)
    solids = [
        box((0.0, 0.0), length, 2.0 * w, -2.2 * layer, -0.25 * layer, MOTOR if driven else RAIL)
    ]
    if driven:
        solids += [
            box((0.0, side * 0.75 * w), 0.7 * length, 0.2 * w, -0.5 * layer, -0.15 * layer, RAIL)
            for side in (-1, 1)
        ]
    return Part(
        f"blocks/{number}",
        solids,
        placed((body.points[:, i] + body.points[:, j]) / 2, angles_of(span)),
    )


def flash(machine: Machine) -> Part:
    """A ring about the place of an event, which the page moves and shows."""
    w, turn = machine.width, np.linspace(0, 2 * np.pi, 49)[:-1]
    rings = []
    for inner, outer, opacity in ((1.5, 2.1, 0.9), (0.0, 1.5, 0.25)):
        for k in range(0, 48, 2) if inner else (0,):
            piece = turn[[k, (k + 1) % 48]] if inner else turn
            edge = np.stack([np.cos(piece), np.sin(piece)], axis=1)
            corners = np.concatenate([inner * edge, outer * edge[::-1]]) if inner else outer * edge
            rings.append(
                polygon(
                    w * corners, machine.top + 0.4 * w, EVENT, transparent=True, opacity=opacity
                )
            )
    return Part("flash", rings)
