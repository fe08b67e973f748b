"""How the aspects hang together as a picture: a node for each, a line for each passage between
two.
"""

from __future__ import annotations

from itertools import islice, permutations
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import FancyArrowPatch

from ...singularities.locus import MODES
from ...singularities.passages import known_aspects, passages
from ..style import INK, SIDES, signs
from .panels import STYLES, figure_legend
from .sheets import Sheet, inches_across

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...models.robots import FiveBar

CENTRED: dict = dict(color=INK, ha="center", va="center")
RING = 0.29  # radius, of the nodes of one pair of modes, which are 1 apart
ANGLES = np.pi / 8 * np.arange(16)  # by which a ring may be turned
ORDERS = 24  # of a ring's nodes, at most
BOWS = np.array([0.0, 0.12, -0.12, 0.25, -0.25])  # how far a line may bend, of its length
CLEAR = 0.14  # that a line keeps from the nodes that it does not join


def aspect_graph(robot: FiveBar, axes: Axes | None = None) -> Figure:
    """Return the figure of the graph of a five-bar's aspects.

    The left leg's mode goes across the picture and the right leg's up, so that the lines of either
    leg's Type 1 go across or up, and those of Type 2 stay with their modes.

    Parameters
    ----------
    robot : FiveBar
        The robot.
    axes : Axes, optional
        A panel of a figure of one's own, whose lines have their names for its legend, in letters
        that suit its width; a new figure without.

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
    figure, (panel,) = Sheet(axes).mosaic([["aspects"]], (7.2, 7.4))
    size = min(max(inches_across(panel) / 5.5, 0.5), 1.0)
    panel.set_axis_off()
    panel.set(xlim=(-1.02, 1.02), ylim=(-1.02, 1.02), aspect="equal")
    for x, y in MODES:
        words = f"working modes ({signs(x, y)})" if size > 0.8 else f"({signs(x, y)})"
        panel.text(x / 2, 0.98 * y, words, fontsize=max(10 * size, 6), **CENTRED)
    lines = passages(robot)
    places, bows = arranged(regions, [passage.between for passage in lines])
    for region in regions:
        x, y = places[region.number]
        style = dict(fontsize=11 * size, fontweight="bold", zorder=3)
        label = panel.text(x, y, str(region.number), **CENTRED | style)
        label.set_bbox(STYLES[f"graph.node{region.assembly:+d}"])
    drawn = set()
    for passage, bow in zip(lines, bows):
        kind = _kind(passage)
        drawn.add(kind)
        start, end = (places[number] for number in passage.between)
        style = STYLES[kind] | {"label": None, "connectionstyle": f"arc3,rad={bow}"}
        line = FancyArrowPatch(start, end, arrowstyle="-", shrinkA=0, shrinkB=0, **style)
        panel.add_patch(line)
    drawn |= {f"graph.assembly{region.assembly:+d}" for region in regions}
    for kind, style in STYLES.items():
        if kind in drawn:
            panel.plot([], [], **style)
    if axes is None:
        figure_legend(figure, panel.get_legend_handles_labels()[0], 2)
    return figure


def arranged(regions: tuple, pairs: list) -> tuple[dict, np.ndarray]:
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
    return places, BOWS[_clearances(places, pairs).argmax(axis=1)]


def _kind(passage):
    """Return the style of a passage's line: by the leg that changes its mode, and how."""
    if passage.leg is None:
        return "graph.type-2"
    side, _ = SIDES[passage.leg]
    return f"graph.{side}-fold" if passage.fold else f"graph.{side}"


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
