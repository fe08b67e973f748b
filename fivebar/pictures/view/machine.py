"""A planar mechanism in motion, as all pictures of it take it, and its body: bars, joints, motors, slides and base."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .frames import Frames
from .solids import box, cylinder, link, polygon
from .tracks import Part, angles_of, placed

# Okabe and Ito's colours, told apart by the colour-blind: a hue for each leg, its bars dark and light by turns.
LEGS = ((0x0072B2, 0x56B4E9), (0xD55E00, 0xE69F00), (0x009E73, 0x7FCEB9))
PATH = 0xCC79A7
PLATE, MOTOR, PIN, STEEL, RAIL = 0xB9C1C9, 0x4A5058, 0x2A2E33, 0xE8EBEE, 0x98A2AC


class Event(NamedTuple):
    """What is marked on the time line: s from the first sample, what it is, and where, m."""

    t: float
    text: str
    place: tuple


@dataclass(frozen=True, eq=False)
class Machine:
    """A mechanism at the frames of its motion.

    frames; points (m, k, 2) m, the joints' positions; bars: pairs (i, j) of joints; grounded: joints fixed to the base;
    actuated: joints with a motor; traced: the joint whose path is drawn, or None; rails: pairs of joints between which
    a straight guide is; blocks: pairs of joints, the ends of a block that slides on a guide, each with whether it is
    driven; events: tuple of Event; layers: what is shown of it besides.
    """

    frames: Frames
    points: np.ndarray
    bars: tuple
    grounded: tuple = ()
    actuated: tuple = ()
    traced: int | None = None
    rails: tuple = ()
    blocks: tuple = ()
    events: tuple = ()
    layers: tuple = ()

    def __post_init__(self):
        count = self.points.shape[1]
        named = [(f"bars[{b}]", bar) for b, bar in enumerate(self.bars)]
        named += [(f"rails[{b}]", rail) for b, rail in enumerate(self.rails)]
        named += [(f"blocks[{b}]", block[:2]) for b, block in enumerate(self.blocks)]
        named += [("grounded", self.grounded), ("actuated", self.actuated)]
        for name, joints in [*named, ("traced", () if self.traced is None else (self.traced,))]:
            for joint in joints:
                if joint not in range(count):
                    raise ValueError(f"{name} names joint {joint}, but points has joints 0 to {count - 1}")

    @cached_property
    def lengths(self):
        """Mean length of each bar, m."""
        return [float(np.hypot(*(self.points[:, j] - self.points[:, i]).T).mean()) for i, j in self.bars]

    @cached_property
    def extent(self):
        """((x, y) low, (x, y) high) of the joints, m."""
        flat = self.points.reshape(-1, 2)
        return flat.min(axis=0), flat.max(axis=0)

    @cached_property
    def size(self):
        """The larger side of `extent`, m; that of a point is 1."""
        return float((self.extent[1] - self.extent[0]).max()) or 1.0

    @cached_property
    def width(self):
        """A bar's width, m: slim for its length, and never as wide as the shortest bar is long."""
        lengths = [length for length in self.lengths if length > 1e-6 * self.size]
        return min(0.085 * float(np.mean(lengths)), 0.5 * min(lengths)) if lengths else 0.03 * self.size

    @cached_property
    def pen(self):
        """By what lines and arrows are measured, m: a bar's width, or more where bars are thin for the whole."""
        return max(self.width, 0.022 * self.size)

    @cached_property
    def box(self):
        """((x, y) low, (x, y) high) of all that is drawn, m."""
        shown = np.concatenate([self.points.reshape(-1, 2), *(layer.reach(self) for layer in self.layers)])
        border = 2.9 * self.width
        return shown.min(axis=0) - border, shown.max(axis=0) + border

    @property
    def layer(self):
        """A bar's share of the height, m."""
        return 0.4 * self.width

    @property
    def top(self):
        """The height over all bars, m."""
        return (len(self.bars) + 0.5) * self.layer

    @cached_property
    def legs(self):
        """(depth, leg) of each bar: how many bars are between it and the nearest fixed joint, and which one that is."""
        fixed = [j for j in dict.fromkeys([*self.grounded, *self.actuated]) if any(j in bar for bar in self.bars)]
        roots = fixed or dict.fromkeys(bar[0] for bar in self.bars)
        reached, legs = {joint: (0, leg) for leg, joint in enumerate(roots)}, {}
        while wave := {b: min(reached[joint] for joint in bar if joint in reached) for b, bar in enumerate(self.bars)
                       if b not in legs and not reached.keys().isdisjoint(bar)}:  # fmt: skip
            legs |= wave
            for b, (depth, leg) in wave.items():
                for joint in self.bars[b]:
                    reached.setdefault(joint, (depth + 1, leg))
        return [legs.get(b, (0, 0)) for b in range(len(self.bars))]

    @cached_property
    def colours(self):
        return [LEGS[leg % len(LEGS)][depth % 2] for depth, leg in self.legs]

    @cached_property
    def heights(self):
        """Where each bar is in the stack, m: its own layer, so that none cuts another."""
        order = sorted(range(len(self.bars)), key=self.legs.__getitem__)
        return [order.index(b) * self.layer for b in range(len(self.bars))]

    @cached_property
    def ends(self):
        """Joints that only mark the ends of guides and blocks."""
        return {joint for pair in (*self.rails, *self.blocks) for joint in pair[:2]} - {j for b in self.bars for j in b}


def parts(machine):
    """The machine's own parts, as Part: base, guides, blocks, bars with their shadows, and joints."""
    yield Part("base", _base(machine))
    for number, (i, j) in enumerate(machine.rails):
        if not {i, j} <= set(machine.grounded):
            yield _rail(machine, number, i, j)
    for number, block in enumerate(machine.blocks):
        yield _block(machine, number, *block)
    w, layer = machine.width, machine.layer
    for b, (bar, length) in enumerate(zip(machine.bars, machine.lengths)):
        tracks = placed(machine.points[:, bar[0]], angles_of(machine.points[:, bar[1]] - machine.points[:, bar[0]]))
        low, colour = machine.heights[b], machine.colours[b]
        yield Part(f"shadows/{b}", [link(length, 1.05 * w, -4.4 * layer, -4.3 * layer, 0, **SHADOW)], tracks)
        solids = [link(length, w, low, low + 0.9 * layer, colour)]
        if length > 4 * w:
            groove = link(length - 2.4 * w, 0.36 * w, low, low + 0.93 * layer, _darker(colour))
            solids.append({**groove, "matrix": [*groove["matrix"][:12], 1.2 * w, 0.0, 0.0, 1.0]})
        yield Part(f"bars/{b}", solids, tracks)
    for joint in range(machine.points.shape[1]):
        if joint not in machine.ends:
            yield _joint(machine, joint)


SHADOW = {"type": "MeshBasicMaterial", "transparent": True, "opacity": 0.13, "depthWrite": False}


def _darker(colour, share=0.82):
    return sum(int(share * (colour >> shift & 255)) << shift for shift in (16, 8, 0))


def _joint(machine, joint):
    w, layer = machine.width, machine.layer
    here = [height for bar, height in zip(machine.bars, machine.heights) if joint in bar] or [0.0]
    top = max(here) + 0.9 * layer
    solids = [
        cylinder(0.36 * w, min(here), top + 0.12 * layer, STEEL),
        cylinder(0.22 * w, min(here), top + 0.3 * layer, PATH if joint == machine.traced else PIN),
    ]
    moved = machine.points[:, joint]
    if joint in machine.grounded:
        moved = moved[:1]
        if joint in machine.actuated:
            solids += [cylinder(1.25 * w, -3 * layer, -0.35 * layer, MOTOR)]
            solids += [cylinder(0.85 * w, -3 * layer, -0.15 * layer, _darker(MOTOR, 1.3))]
        else:
            solids.append(cylinder(0.75 * w, -3 * layer, -0.15 * layer, RAIL))
    elif joint in machine.actuated:  # a motor that travels: between the two bars it drives
        solids.append(cylinder(0.62 * w, min(here) - 0.4 * layer, top + 0.06 * layer, MOTOR))
    return Part(f"joints/{joint}", solids, placed(moved))


def _base(machine):
    w, layer, fixed = machine.width, machine.layer, machine.points[0]
    feet = [fixed[joint] for joint in machine.grounded if joint not in machine.ends]
    solids = []
    for foot in feet:
        solids.append(box(foot, 3.4 * w, 3.4 * w, -4 * layer, -3 * layer, PLATE))
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            solids.append(cylinder(0.2 * w, -3 * layer, -2.8 * layer, RAIL, foot + 1.35 * w * np.array([x, y])))
    for a, b in zip(feet, feet[1:]):
        angle = np.arctan2(*(b - a)[::-1])
        solids.append(box((a + b) / 2, np.hypot(*(b - a)), 2.2 * w, -4 * layer, -3.2 * layer, PLATE, angle))
    for i, j in machine.rails:
        if {i, j} <= set(machine.grounded):
            angle, length = np.arctan2(*(fixed[j] - fixed[i])[::-1]), np.hypot(*(fixed[j] - fixed[i]))
            middle = (fixed[i] + fixed[j]) / 2
            solids.append(box(middle, length + w, 1.5 * w, -4 * layer, -3 * layer, PLATE, angle))
            solids.append(box(middle, length, 0.5 * w, -3 * layer, -1.6 * layer, RAIL, angle))
            for end in (fixed[i], fixed[j]):
                solids.append(box(end, 0.5 * w, 1.7 * w, -4 * layer, -1.2 * layer, MOTOR, angle))
    return solids


def _rail(machine, number, i, j):
    w, layer = machine.width, machine.layer
    span = machine.points[:, j] - machine.points[:, i]
    length = float(np.hypot(*span.T).mean())
    solids = [box((length / 2, 0.0), length, 0.6 * w, -1.2 * layer, -0.3 * layer, RAIL)]
    return Part(f"rails/{number}", solids, placed(machine.points[:, i], angles_of(span)))


def _block(machine, number, i, j, driven):
    w, layer = machine.width, machine.layer
    span = machine.points[:, j] - machine.points[:, i]
    length = max(float(np.hypot(*span.T).mean()), 2.6 * w)
    solids = [box((0.0, 0.0), length, 2.0 * w, -2.2 * layer, -0.25 * layer, MOTOR if driven else RAIL)]
    if driven:
        solids += [box((0.0, side * 0.75 * w), 0.7 * length, 0.2 * w, -0.5 * layer, -0.15 * layer, RAIL)
                   for side in (-1, 1)]  # fmt: skip
    middle = (machine.points[:, i] + machine.points[:, j]) / 2
    return Part(f"blocks/{number}", solids, placed(middle, angles_of(span)))


def flash(machine):
    """A ring about the place of an event, which the page moves and shows."""
    w, turn = machine.width, np.linspace(0, 2 * np.pi, 49)[:-1]
    rings = []
    for inner, outer, opacity in ((1.5, 2.1, 0.9), (0.0, 1.5, 0.25)):
        for k in range(0, 48, 2) if inner else (0,):
            piece = turn[[k, (k + 1) % 48]] if inner else turn
            edge = np.stack([np.cos(piece), np.sin(piece)], axis=1)
            corners = np.concatenate([inner * edge, outer * edge[::-1]]) if inner else outer * edge
            rings.append(polygon(w * corners, machine.top + 0.4 * w, 0xE51C23, transparent=True, opacity=opacity))
    return Part("flash", rings)
