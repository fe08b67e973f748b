"""How the aspects hang together as a picture: a node for each, a line for each passage between
two.
"""

from __future__ import annotations

from itertools import islice, permutations
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch

from ...singularities.locus import MODES
from ...singularities.passages import known_aspects, passages
from ..style import INK, SIDES, signs
from .panels import figure_legend, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...models.robots import FiveBar

FOLD = (0, (1.2, 1.4))
# By the leg that changes its mode, and whether it folds for that.
LINES: dict = {}
for _leg, (_side, _colour) in enumerate(SIDES):
    _line = dict(color=_colour, lw=1.8)
    LINES[_leg, False] = dict(ls="-", label=f"Type 1, the {_side} leg in line", **_line)
    LINES[_leg, True] = dict(
        ls=FOLD,
        label=f"the {_side} leg folded on its base joint",
        **_line,
    )
LINES[None, False] = dict(color=INK, lw=1.4, ls=(0, (6, 2.5)), label="Type 2")
FILL = {1: "white", -1: "#d6dbe0"}
RING = 0.29  # radius, of the nodes of one pair of modes, which are 1 apart
ANGLES = np.pi / 8 * np.arange(16)  # by which a ring may be turned
ORDERS = 24  # of a ring's nodes, at most
BOWS = np.array([0.0, 0.12, -0.12, 0.25, -0.25])  # how far a line may bend, of its length
CLEAR = 0.14  # that a line keeps from the nodes that it does not join


def aspect_graph(robot: FiveBar) -> Figure:
    """Return the figure of the graph of a five-bar's aspects.

    The left leg's mode goes across the picture and the right leg's up, so that the lines of either
    leg's Type 1 go across or up, and those of Type 2 stay with their modes.

    Parameters
    ----------
    robot : FiveBar
        The robot.

    Returns
    -------
    Figure
        Numbers as `aspects` gives them, lines where a motion may pass.

    Raises
    ------
    ValueError
        As `aspects`.
    """
    regions = known_aspects(robot)
    figure = new_figure(7.2, 7.4)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set(
        xlim=(-1.02, 1.02),
        ylim=(-1.02, 1.02),
        aspect="equal",
    )
    middle: dict = dict(ha="center", va="center")
    for x, y in MODES:
        words = f"working modes ({signs(x, y)})"
        axes.text(x / 2, 0.98 * y, words, color=INK, fontsize=10, **middle)
    lines = passages(robot)
    places, bows = arranged(regions, [passage.between for passage in lines])
    for region in regions:
        box = dict(boxstyle="circle,pad=0.35", fc=FILL[region.assembly], ec=INK, lw=1.0)
        text: dict = dict(fontsize=11, fontweight="bold", color=INK, bbox=box, zorder=3)
        axes.text(*places[region.number], str(region.number), **middle, **text)
    drawn = set()
    plain: dict = dict(arrowstyle="-", shrinkA=0, shrinkB=0, zorder=1)
    for passage, bow in zip(lines, bows):
        kind = passage.leg, passage.fold
        drawn.add(kind)
        style = LINES[kind] | plain | {"label": None}
        ends = [places[number] for number in passage.between]
        axes.add_patch(FancyArrowPatch(*ends, connectionstyle=f"arc3,rad={bow}", **style))
    handles = [Line2D([], [], **LINES[kind]) for kind in LINES if kind in drawn]
    dots: dict = dict(marker="o", ms=11, mec=INK, ls="none")
    for sign in sorted({region.assembly for region in regions}, reverse=True):
        label = f"assembly mode {signs(sign)}"
        handles.append(Line2D([], [], mfc=FILL[sign], label=label, **dots))
    figure_legend(figure, handles, 2)
    return figure


def arranged(regions: tuple, pairs: list) -> tuple[dict, list]:
    """Return where nodes are, {number: (x, y)}, and how far the line of each pair bends.

    The nodes of one pair of working modes are on a ring. Each ring in turn gets the order and the
    angle in which the lines keep clear of the nodes that they do not join.
    """
    rings: dict = {}
    places: dict = {}
    for region in regions:
        rings.setdefault(region.working, []).append(region.number)
    for working, numbers in rings.items():
        places |= _ring(working, numbers, 0.0)
    for _ in range(2):
        for working, (first, *others) in rings.items():
            candidates = [
                places | _ring(working, (first, *order), angle)
                for order in islice(permutations(others), ORDERS)
                for angle in ANGLES
            ]
            places = min(candidates, key=lambda each: _crowding(each, pairs))
    bows: dict = {}
    for pair, clear in zip(pairs, _clearances(places, pairs)):
        taken = bows.setdefault(pair, [])
        free = [k for k in range(len(BOWS)) if k not in taken]
        taken.append(max(free, key=lambda k: clear[k]))
    return places, [float(BOWS[bows[pair].pop(0)]) for pair in pairs]


def _ring(working, numbers, angle):
    """Return places of the nodes of these modes, evenly around the place of the modes."""
    angles = angle + 2 * np.pi / len(numbers) * np.arange(len(numbers))
    ring = np.array(working) / 2 + RING * np.column_stack([np.cos(angles), np.sin(angles)])
    return dict(zip(numbers, ring))


def _crowding(places, pairs):
    """Return how near the lines come to nodes, and a little of how long they are."""
    missing = CLEAR - _clearances(places, pairs).max(axis=1)
    lengths = [np.hypot(*(places[first] - places[second])) for first, second in pairs]
    return np.sum(missing**2) + 1e-3 * np.sum(lengths)


def _clearances(places, pairs):
    """Return how far from other nodes each line (n) stays with each bow (b), up to CLEAR."""
    numbers = list(places)
    nodes = np.array([places[number] for number in numbers])
    ends = np.reshape([places[number] for pair in pairs for number in pair], (-1, 2, 2))
    first, last = ends[:, None, None, 0], ends[:, None, None, 1]
    x, y = np.moveaxis(last - first, -1, 0)
    # A bent line is a Bézier curve, whose middle control point is beside the straight one's middle.
    beside = BOWS[:, None, None] * np.stack([y, -x], axis=-1)
    s = np.linspace(0, 1, 15)[:, None]
    points = first + s * (last - first) + 2 * s * (1 - s) * beside
    distance = np.linalg.norm(points[..., None, :] - nodes, axis=-1)
    for k, pair in enumerate(pairs):
        distance[k][..., [numbers.index(number) for number in pair]] = CLEAR
    return np.minimum(distance.min(axis=(2, 3)), CLEAR)
