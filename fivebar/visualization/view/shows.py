"""What `show` can name: each item computes only what it draws."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from ...singularities.loci import singularity_loci
from ..style import LEGS, PATH, REFERENCE, largest_of, names_of
from .frames import stretches
from .layers import Arrows, Layer, LineLayer, TurningArrows
from .solids import circle

if TYPE_CHECKING:
    from .sources import RobotSource, StudySource

# Colours that the colour-blind can tell apart, too.
SINGULAR, VELOCITY, ACCELERATION, FORCE, TORQUE = "#7e6bd9 #9933ff #87A512 #ff1166 #994477".split()
MOST_POINTS = 2000  # of a reference: on a simulator's steps it would outweigh the motion
# In widths of a bar.
LOCUS_DASHES = {"stretched": (0.9, 0.5), "folded": (1.2, 0.5), "self-motion": (0.3, 0.35)}


def shown(source: RobotSource | StudySource, items: str | Iterable[str] | None) -> list[Layer]:
    """Return the layers of the named items; None: the path, and the reference where there is one.

    Raises ValueError for a name that is not known, or not of this motion.
    """
    if items is None:
        items = "trace" if source.xi_ref is None else ("reference", "trace")
    items = names_of(items)
    for item in items:
        if item not in ITEMS:
            known = ", ".join(ITEMS)
            raise ValueError(f"nothing named {item!r} can be shown; the known names are {known}")
        if item not in source.items:
            raise ValueError(f"a {source.title} has no {item!r} to show, but {source.items}")
        if item == "reference" and source.xi_ref is None:
            raise ValueError(f"this motion has no reference, so no {item!r} to show")
    return list(chain.from_iterable(ITEMS[item](source) for item in items))


def with_common_scale(groups: list[list[Layer]]) -> list[tuple[Layer, ...]]:
    """Return the layers of several mechanisms with arrows of one scale."""
    largest: dict = {}
    for layer in chain(*groups):
        if hasattr(layer, "largest"):
            largest[layer.name] = max(largest.get(layer.name, 0.0), layer.largest)

    def rescaled(layer):
        return replace(layer, largest=largest[layer.name]) if layer.name in largest else layer

    return [tuple(map(rescaled, layers)) for layers in groups]


def _trace(source):
    cuts = [int(np.searchsorted(source.frames.t, low)) for low, _ in source.frames.gaps]
    paths = [piece for piece in np.split(source.traced, cuts) if len(piece)]
    yield LineLayer("trace", PATH, paths, over=True, lift=0.12, words="path")


def _reference(source):
    path = source.xi_ref
    if len(path) > MOST_POINTS:
        path = path[np.linspace(0, len(path) - 1, MOST_POINTS).astype(int)]
    paths = [path[first : last + 1] for first, last in stretches(np.isfinite(path).all(axis=1))]
    yield LineLayer("reference", REFERENCE, paths, width=0.34, over=True, lift=0.06, opacity=0.75)


def _loci(source):
    """Yield the loci of each pair of working modes while the motion is in it, by their dashes."""
    longest = max(source.robot.distal)
    dot = 0.017 * sum(source.robot.distal)
    heights = np.append(source.elbows[..., 1], source.xi[:, 1])
    ends = (heights.min() - longest / 2, heights.max() + longest / 2)  # of lines without ends
    for mode in np.unique(source.working, axis=0):
        now = (source.working == mode).all(axis=1)
        groups = {}
        for piece in singularity_loci(source.robot).task:
            if tuple(mode.tolist()) in piece.working:
                one = len(piece.points) == 1
                path = circle(piece.points[0], dot, 25) if one else piece.drawn(*ends)
                groups.setdefault(LOCUS_DASHES.get(piece.kind), []).append(path)
        for dash, paths in groups.items():
            good = None if now.all() else now
            words = "loci: Type 1 solid, Type 2 dashed"
            yield LineLayer("loci", SINGULAR, paths, 0.16, dash, good=good, words=words)


def _elbow_circles(source):
    if not source.robot.turns:
        raise ValueError("elbow-circles are for cranks: this robot's feet slide along its rails")
    for leg, drive in zip(LEGS, source.robot.drives):
        path = circle((drive.x, drive.y), drive.length, 181)
        words = "circles of the elbows"
        yield LineLayer("elbow-circles", leg[0], [path], dash=(0.5, 0.5), lift=0.1, words=words)


def _arrows(name, colour, unit, *words_and_sign):
    """Yield the item of arrows at the traced point; words and sign of each of them."""
    attribute = name.replace("-", "_")

    def arrows(source):
        vectors = getattr(source, attribute)
        largest = largest_of(np.linalg.norm(vectors, axis=-1))
        vectors = np.moveaxis(vectors.reshape(len(vectors), -1, 2), 1, 0)
        for (words, sign), values in zip(words_and_sign, vectors):
            yield Arrows(name, colour, source.traced, values, unit, largest, words=words, sign=sign)

    return arrows


def _torques(source):
    letter = "τ" if source.effort == "torque" else "F"
    several = len(source.torques) > 1
    signs = [letter + "₁", letter + "₂"] if several else [letter]
    text = {"words": f"{', '.join(signs)}: motor {source.effort}{'s' if several else ''}"}
    largest = max(largest_of(values) for *_, values in source.torques)
    for text["sign"], (place, axis, values) in zip(signs, source.torques):
        name = f"{source.effort}s", TORQUE, place
        if axis is None:
            yield TurningArrows(*name, values, "N m", largest, **text)
        else:
            yield Arrows(*name, values[:, None] * axis, "N", largest, **text)


_BAR_FORCES = "f₁, f₂: forces of the distal bars"
ITEMS = {
    "trace": _trace,
    "reference": _reference,
    "loci": _loci,
    "elbow-circles": _elbow_circles,
    "velocity": _arrows("velocity", VELOCITY, "m/s", ("v: velocity", "v")),
    "acceleration": _arrows("acceleration", ACCELERATION, "m/s²", ("a: acceleration", "a")),
    "bar-forces": _arrows("bar-forces", FORCE, "N", (_BAR_FORCES, "f₁"), (_BAR_FORCES, "f₂")),
    "torques": _torques,
}
