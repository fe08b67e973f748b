"""How pictures look, said once: colours, dashes, readable units, legends, and what the singularity
loci are called.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.checks import strings
from ..singularities.maps import SIGNED
from ..singularities.margins import Singularity

if TYPE_CHECKING:
    from ..models.robots import Robot
    from ..singularities.locus import Locus
    from ..singularities.maps import Map

# Okabe and Ito's colours, told apart by the colour-blind; dashes tell curves apart in any colours.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
BLUE, ORANGE, GREEN, PINK, AMBER, SKY, BLACK = COLOURS
DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)))
LEFT, RIGHT = BLUE, ORANGE  # legs, and what is of their motors
SIDES = ("left", LEFT), ("right", RIGHT)
# Bars have a contrast of 3 : 1 or more to white paper and to the dark ground of pages.
RUST, OCHRE, AZURE, GREY = "#C7443C", "#B65818", "#5393D8", "#7D7D7D"
LEGS = (BLUE, AZURE), (RUST, OCHRE)  # a hue for each leg, its bars dark and light by turns
LINKS = BLUE, RUST, GREEN, OCHRE, AZURE, GREY  # of a linkage; pink is left to the path
PATH, REFERENCE = "#BF65A2", GREEN
INK = "#222222"
# From −1 to 1, lighter all the way: a map printed in grey keeps its signs. Ink is seen on all.
SIGNED_COLOURS = "#3f66a8", "#7d8fb3", "#b0afad", "#d9cb90", "#ffe680"
BASE = "#888888"  # named, as GUIDE is, in plot/styles.toml
GUIDE = "#d9d9d9"
PALE = "#8a939c"
NO_VALUE = "#ececec"  # ground of what is out of reach
LENGTHS = "l11", "l12", "l21", "l22", "l1", "l2", "d"

TYPE_1, ACROSS, TYPE_3 = ("Type 1: a leg in line", "Type 1: a bar across its guide", "Type 3")
TYPE_2 = {
    "stretched": "Type 2: distal bars stretched",
    "folded": "Type 2: distal bars folded",
    "self-motion": "Type 2: elbows coincide, self-motion",
}
ALONG, DEXTEROUS = ("path, from ● to ■", "region that is left, inside its border")
POINTS = {
    Singularity.SERIAL: "Type 1 in a point: a leg folded on its base",
    Singularity.PARALLEL: "Type 2 in a point: elbows coincide, self-motion",
}


def locus_words(piece: Locus) -> str:
    """Return what a piece of the loci is called in a legend."""
    if len(piece.points) > 1:
        return TYPE_2.get(piece.kind, ACROSS if piece.unbounded else TYPE_1)
    return POINTS.get(piece.type, TYPE_3)


class Scale(NamedTuple):
    """How a map is coloured: palette "diverging", "rising" or "falling" (pale where singular), from
    low to high.
    """

    words: str
    palette: str
    low: float
    high: float
    logarithmic: bool = False
    factor: float = 1.0  # what is shown of a value


def field_scale(data: Map) -> Scale:
    """Return the Scale of a Map, with the field in words."""
    field, words = data.field, data.description
    if field in SIGNED:
        return Scale(words, "diverging", -1.0, 1.0)
    if field == "transmission_angle":
        return Scale(words.replace("rad", "deg"), "falling", 0.0, 90.0, factor=180 / np.pi)
    if field.startswith("condition"):
        return Scale(words, "rising", 1.0, 100.0, logarithmic=True)
    finite = data.values[np.isfinite(data.values)]
    high = float(np.quantile(finite, 0.95)) if finite.size else 0.0
    return Scale(words, "rising" if field == "manipulability" else "falling", 0.0, high or 1.0)


def largest_of(values: np.ndarray) -> float:
    """Return the size of the largest that is a number, 0 where none is."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


SMALLEST = 1e-12  # in SI units; what is smaller is rounding error


def readable(largest: float, unit: str, smallest: float = SMALLEST) -> tuple[float, str]:
    """Return factor and name of the unit in which numbers up to `largest` read well.

    The factor is 0 if all are below `smallest`, so that rounding error reads as 0.
    """
    if largest < smallest:
        return 0.0, unit
    whole = 1.0
    if unit.startswith("kg"):
        whole, unit = 1e3, unit[1:]
    largest = whole * largest
    for limit, prefix in ((1e-6, "n"), (1e-3, "µ"), (1.0, "m")):
        if largest < limit:
            return whole * 1e3 / limit, prefix + unit
    if largest >= 1e4 and unit[:1] in ("m", "N", "J") or largest >= whole > 1:
        return whole * 1e-3, "k" + unit
    return whole, unit


def shown_unit(
    columns: Iterable[np.ndarray], unit: str, size: float, degrees: bool = False
) -> tuple[float, str]:
    """Return factor and name of the unit in which columns of `unit` are shown together.

    Lengths, speeds and accelerations below 1e-9 of a mechanism's size, m, are 0. Numbers without
    unit and angles of a hundredth and more stay as they are; degrees: as these.
    """
    largest = max(map(largest_of, columns))
    scale, shown = readable(largest, unit, 1e-9 * size if unit[:1] == "m" else SMALLEST)
    if degrees and unit == "rad":
        return 180 / np.pi * (scale > 0), "deg"
    if scale and (not unit or (unit.startswith("rad") and largest >= 0.01)):
        scale, shown = 1.0, unit
    return scale, of_unit(shown)


def group_words(names: Sequence[str]) -> tuple[str, list[str]]:
    """Return title and labels of quantities that share a panel: of one kind, their links; of one
    link or point, their kinds.
    """
    links = [name.rpartition(".")[0] for name in names]
    kinds = [_kind(name.rpartition(".")[2]) for name in names]
    if len(set(kinds)) == 1 < len(names):
        return kinds[0], links
    if len(set(links)) == 1 and links[0]:
        return f"{', '.join(kinds)} of {links[0]}", kinds
    return ", ".join(names), list(names)


def _kind(name):
    if name in ("tangential", "normal"):
        return f"{name} acceleration"
    return name.replace("_", " ")


def length(metres: float) -> str:
    """Return a length in the unit in which it reads well."""
    scale, unit = readable(metres, "m")
    return f"{scale * metres:.2f} {unit}"


def length_unit(*robots: Robot) -> tuple[float, str]:
    """Return factor and name of the unit of all lengths about robots: mm where the longest distal
    bar is of what stands on a desk, else µm or m.
    """
    longest = max(max(robot.distal) for robot in robots)
    if longest < 1e-3:
        return 1e6, "µm"
    return (1e3, "mm") if longest <= 3.0 else (1.0, "m")


def robot_title(robot: Robot) -> str:
    """Return what a robot is called over a picture, with its lengths."""
    scale, unit = length_unit(robot)
    *bars, base = (f"{scale * x:.4g}" for name, x in robot.parameters.items() if name in LENGTHS)
    if len(set(bars)) == 1:
        lengths = f"all bars {bars[0]}"
    else:
        lengths = f"bars {', '.join(bars)}"
    return f"{robot.words.title}, {lengths} {unit}, base {base} {unit}"


def signs(*modes: int) -> str:
    """Return modes as pictures write them."""
    return ", ".join(f"{mode:+d}" for mode in modes).replace("-", "−")


def names_of(show: str | Iterable[str]) -> tuple[str, ...]:
    """Return the names in `show`, one or several; TypeError for what is neither."""
    return tuple(strings([show] if isinstance(show, str) else show, "show"))


def of_unit(unit: str) -> str:
    """Return a unit as pictures write it."""
    return unit.replace("^2", "²").replace("um", "µm")
