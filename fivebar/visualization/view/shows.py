"""What `show` can name: each item computes only what it draws."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...singularities.loci import singularity_loci
from ...singularities.margins import Singularity
from ..names import names_of
from ..style import GREEN, LEGS, PATH, REFERENCE
from .frames import stretches
from .layers import Area, Arrows, Ghost, Layer, Line, Turning

if TYPE_CHECKING:
    from .sources import OfRobot
    from .studies import OfStudy

SINGULAR, WORKSPACE = "#7e6bd9", GREEN
VELOCITY, ACCELERATION, FORCE, TORQUE = (
    "#9933ff",
    "#999933",
    "#ff1166",
    "#994477",
)  # told apart by the colour-blind
MOST_POINTS = 2000  # of a reference: on a simulator's steps it would outweigh the motion
DASHES = {
    "stretched": (0.9, 0.5),
    "folded": (1.2, 0.5),
    "self-motion": (0.3, 0.35),
}  # in widths of a bar


def shown(source: OfRobot | OfStudy, items: str | Iterable[str]) -> list[Layer]:
    """The layers of the named items; ValueError for a name that is not known, or not of this
    motion.
    """
    layers = []
    for item in names_of(items):
        if item not in ITEMS:
            raise ValueError(
                f"nothing named {item!r} can be shown; the known names are {', '.join(ITEMS)}"
            )
        if item not in source.known:
            raise ValueError(
                f"a {source.title} has no {item!r} to show, but {', '.join(source.known)}"
            )
        layers += ITEMS[item](source)
    return layers


def usual(source: OfRobot | OfStudy) -> tuple[str, ...]:
    """What is shown where nothing is named: the path, and the reference where there is one."""
    return ("reference", "trace") if getattr(source, "xi_ref", None) is not None else ("trace",)


def alike(groups: list[list[Layer]]) -> list[tuple[Layer, ...]]:
    """The layers of several mechanisms with arrows of one scale."""
    largest = {}
    for layer in (layer for layers in groups for layer in layers):
        if hasattr(layer, "largest"):
            largest[layer.name] = max(largest.get(layer.name, 0.0), layer.largest)
    return [
        tuple(replace(x, largest=largest[x.name]) if x.name in largest else x for x in layers)
        for layers in groups
    ]


def _trace(source):
    return [Line("trace", _pieces(source.frames, source.traced), PATH, over=True, lift=0.12)]


def _reference(source):
    path = _need_reference(source, "reference")
    if len(path) > MOST_POINTS:
        path = path[np.linspace(0, len(path) - 1, MOST_POINTS).astype(int)]
    paths = [path[first : last + 1] for first, last in stretches(np.isfinite(path).all(axis=1))]
    return [Line("reference", paths, REFERENCE, width=0.34, over=True, lift=0.06, opacity=0.75)]


def _ghost(source):
    _need_reference(source, "ghost")
    return [Ghost("ghost", source.ghost)]


def _need_reference(source, item):
    if source.xi_ref is None:
        raise ValueError(f"this motion has no reference, so no {item!r} to show")
    return source.xi_ref


def _pieces(frames, path):
    """A path at the frames, cut where there is a gap."""
    cuts = [int(np.searchsorted(frames.t, low)) for low, _ in frames.gaps]
    return [piece for piece in np.split(path, cuts) if len(piece)]


def _loci(source):
    pieces, modes = singularity_loci(source.robot).task, source.working
    width, room = sum(source.robot.distal) / 2 * 0.085, max(source.robot.distal) / 2
    heights = np.concatenate([source.elbows[..., 1].ravel(), source.xi[:, 1]])
    ends = heights.min() - room, heights.max() + room  # of lines without ends
    layers = []
    for mode in np.unique(modes, axis=0):
        now = (modes == mode).all(axis=1)
        own = [piece for piece in pieces if tuple(mode.tolist()) in piece.working]
        for kind in dict.fromkeys(_style(piece) for piece in own):
            mine = [piece for piece in own if _style(piece) == kind]
            paths = [
                p.drawn(*ends) if len(p.points) > 1 else _circle(p.points[0], 0.4 * width, 25)
                for p in mine
            ]
            good = None if now.all() else now
            words = "loci: Type 1 solid, Type 2 dashed"
            layers.append(
                Line(
                    "loci",
                    paths,
                    SINGULAR,
                    width=0.16,
                    dash=DASHES.get(kind),
                    good=good,
                    words=words,
                )
            )
    return layers


def _style(piece):
    return piece.kind if piece.kind in DASHES else "in line"


def _circle(place, radius, points):
    turn = np.linspace(0, 2 * np.pi, points)
    return place + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def _workspace(source):
    if not source.robot.turns:
        raise ValueError("the workspace of a robot on guides has no end, so it cannot be shown")
    arcs = [
        p.points
        for p in singularity_loci(source.robot).task
        if p.type == Singularity.SERIAL and len(p.points) > 1
    ]
    return [Area("workspace", _strips(source.robot, np.concatenate(arcs)), arcs, WORKSPACE)]


def _strips(robot, border):
    """Strips, rows (n, 2, 2), that fill what both legs reach, between heights at which its border
    may turn.
    """
    y = np.union1d(np.linspace(border[:, 1].min(), border[:, 1].max(), 241), border[:, 1][::7])
    sides = []  # per leg, the intervals of x that it reaches at each height
    for drive, bar in zip(robot.drives, robot.distal):
        outer, inner = (
            np.sqrt(np.maximum((drive.length + side * bar) ** 2 - (y - drive.y) ** 2, 0))
            for side in (1, -1)
        )
        parted = [(drive.x - outer, drive.x - inner), (drive.x + inner, drive.x + outer)]
        sides.append(parted if inner.any() else [(drive.x - outer, drive.x + outer)])
    strips = []
    for left in sides[0]:
        for right in sides[1]:
            first, last = np.maximum(left[0], right[0]), np.minimum(left[1], right[1])
            rows = np.stack(
                [np.stack([first, y], axis=1), np.stack([np.maximum(first, last), y], axis=1)],
                axis=1,
            )
            strips += [rows[max(low - 1, 0) : high + 2] for low, high in stretches(last > first)]
    return strips


def _elbow_circles(source):
    if not source.robot.turns:
        raise ValueError(
            "elbow-circles are for cranks: the feet of this robot slide along its rails"
        )
    style = dict(dash=(0.5, 0.5), lift=0.1, words="circles of the elbows")
    return [
        Line("elbow-circles", [_circle((drive.x, drive.y), drive.length, 181)], leg[0], **style)
        for leg, drive in zip(LEGS, source.robot.drives)
    ]


def _velocity(source):
    return [
        _arrows("velocity", source.traced, source.velocity, VELOCITY, "m/s", "v: velocity", "v")
    ]


def _acceleration(source):
    words = "a: acceleration"
    return [
        _arrows(
            "acceleration", source.traced, source.acceleration, ACCELERATION, "m/s²", words, "a"
        )
    ]


def _bar_forces(source):
    forces = source.bar_forces
    words = "f₁, f₂: forces of the distal bars"
    return [
        _arrows("bar-forces", source.traced, forces[:, leg], FORCE, "N", words, sign, forces)
        for leg, sign in enumerate(("f₁", "f₂"))
    ]


def _torques(source):
    torques = source.torques
    layers, letter = [], "τ" if source.effort == "torque" else "F"
    signs = [f"{letter}{k}" for k in "₁₂"[: len(torques)]] if len(torques) > 1 else [letter]
    words = (
        f"{', '.join(signs)}: motor {source.effort}s"
        if len(torques) > 1
        else f"{letter}: motor {source.effort}"
    )
    for sign, (place, axis, values) in zip(signs, torques):
        largest = max(_largest(v) for _, a, v in torques if (a is None) == (axis is None))
        if axis is None:
            layers.append(
                Turning(f"{source.effort}s", place, values, TORQUE, "N m", largest, words, sign)
            )
        else:
            vectors = values[:, None] * axis
            layers.append(
                Arrows(f"{source.effort}s", place, vectors, TORQUE, "N", largest, words, sign)
            )
    return layers


def _arrows(name, places, vectors, colour, unit, words, sign, of=None):
    lengths = np.linalg.norm(vectors if of is None else of, axis=-1)
    return Arrows(name, places, vectors, colour, unit, _largest(lengths), words, sign)


def _largest(values):
    """The largest size that is a number; 0 where there is none."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


ITEMS = {
    "trace": _trace,
    "reference": _reference,
    "loci": _loci,
    "workspace": _workspace,
    "elbow-circles": _elbow_circles,
    "velocity": _velocity,
    "acceleration": _acceleration,
    "bar-forces": _bar_forces,
    "torques": _torques,
    "ghost": _ghost,
}
