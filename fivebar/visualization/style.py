"""How pictures look, said once: colours, dashes, readable units, legends, and what the singularity
loci are called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..singularities.maps import SIGNED
from ..singularities.margins import Singularity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..models.robots import Robot
    from ..singularities.locus import Locus
    from ..singularities.maps import Map

# Okabe and Ito's colours, told apart by the colour-blind; dashes tell curves apart in any colours.
COLOURS = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"
BLUE, ORANGE, GREEN, PINK, AMBER, SKY, BLACK = COLOURS
DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)))
LEFT, RIGHT = BLUE, ORANGE  # legs, and what is of their motors
LEGS = (
    (BLUE, SKY),
    (ORANGE, AMBER),
    (GREEN, "#7FCEB9"),
)  # a hue for each leg, its bars dark and light by turns
LINKS = BLUE, ORANGE, GREEN, AMBER, SKY, BLACK  # of a linkage; pink is left to the path
PATH, REFERENCE = PINK, GREEN
INK, BASE, GUIDE, PALE = "#222222", "#888888", "#d9d9d9", "#8a939c"
LENGTHS = "l11", "l12", "l21", "l22", "l1", "l2", "d"
PREFIXES = (
    (1e-6, 1e9, "n"),
    (1e-3, 1e6, "µ"),
    (1.0, 1e3, "m"),
)  # below so many units, so many of these to one

TYPE_1, ACROSS, TYPE_3 = "Type 1: a leg in line", "Type 1: a bar across its guide", "Type 3"
TYPE_2 = {
    "stretched": "Type 2: distal bars stretched",
    "folded": "Type 2: distal bars folded",
    "self-motion": "Type 2: elbows coincide, self-motion",
}
ALONG, DEXTEROUS = "path, from ● to ■", "dexterous region, inside its border"
POINTS = {
    Singularity.SERIAL: "Type 1 in a point: a leg folded on its base",
    Singularity.PARALLEL: "Type 2 in a point: elbows coincide, self-motion",
}


def locus_words(piece: Locus) -> str:
    """What a piece of the loci is called in a legend."""
    if len(piece.points) > 1:
        return TYPE_2.get(piece.kind, ACROSS if piece.unbounded else TYPE_1)
    return POINTS.get(piece.type, TYPE_3)


class Scale(NamedTuple):
    """How a map is coloured: palette "diverging", "rising" or "falling" (pale where singular), from
    low to high.
    """

    palette: str
    low: float
    high: float
    logarithmic: bool = False
    factor: float = 1.0  # what is shown of a value
    words: str = ""


def field_scale(data: Map) -> Scale:
    """The Scale of a Map, with the field in words."""
    field, words = data.field, data.description
    if field in SIGNED:
        return Scale("diverging", -1.0, 1.0, words=words)
    if field == "transmission_angle":
        return Scale("falling", 0.0, 90.0, factor=180 / np.pi, words=words.replace("rad", "deg"))
    if field.startswith("condition"):
        return Scale("rising", 1.0, 100.0, logarithmic=True, words=words)
    finite = data.values[np.isfinite(data.values)]
    high = float(np.quantile(finite, 0.95)) if finite.size else 0.0
    return Scale(
        "rising" if field == "manipulability" else "falling", 0.0, high or 1.0, words=words
    )


def largest_of(values: np.ndarray) -> float:
    """The size of the largest that is a number, 0 where none is."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def readable(largest: float, unit: str) -> tuple[float, str]:
    """Factor and name of the unit in which numbers up to `largest` read well."""
    return next(
        ((scale, prefix + unit) for limit, scale, prefix in PREFIXES if 0 < largest < limit),
        (1.0, unit),
    )


def length(metres: float) -> str:
    """A length in the unit in which it reads well."""
    scale, unit = readable(metres, "m")
    return f"{scale * metres:.2f} {unit}"


def robot_title(robot: Robot) -> str:
    """What a robot is called over a picture, with its lengths in mm."""
    *bars, base = (1e3 * value for name, value in robot.parameters.items() if name in LENGTHS)
    each = (
        f"all bars {bars[0]:.4g}"
        if len(set(bars)) == 1
        else f"bars {', '.join(f'{bar:.4g}' for bar in bars)}"
    )
    return f"{robot.words.title}, {each} mm, base {base:.4g} mm"


def of_unit(unit: str) -> str:
    """A unit as pictures write it."""
    return unit.replace("^2", "²")


def finish(axes: Axes, columns: int, **words) -> None:
    """Labels, title and limits of a panel, a pale grid, and its legend under it."""
    axes.set(**words)
    axes.grid(alpha=0.25)
    pad = (
        5 if axes.get_xlabel() else 2.5
    )  # in letters, so that it clears the labels whatever the panel's height
    place = dict(loc="upper center", bbox_to_anchor=(0.5, 0), borderaxespad=pad)
    axes.legend(ncols=columns, fontsize=8, frameon=False, **place)
