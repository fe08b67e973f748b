"""How the aspects hang together as a picture: a node for each, a line for each passage between
two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch

from ...singularities.locus import MODES
from ...singularities.passages import known_aspects, passages
from ..style import INK, PALE, SIDES, signs
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
RING = 0.27  # radius, of the nodes of one pair of modes, which are 1 apart
BOW = 0.12  # how far a line bends


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
    places = {}
    for working in MODES:
        x, y = working[0] / 2, working[1] / 2
        height = 1.9 * y
        axes.text(
            x,
            height,
            f"working modes ({signs(*working)})",
            color=PALE,
            fontsize=10,
            **middle,
        )
        # On a ring about the place of its modes, one assembly mode above the other.
        ring = [region for region in regions if region.working == working]
        ring.sort(key=lambda region: (-region.assembly, region.point[0]))
        for k, region in enumerate(ring):
            # Begun a little off the axes, so that no line to another ring passes behind a node.
            angle = 2.0 - 2 * np.pi * k / len(ring)
            places[region.number] = (
                x + RING * np.cos(angle),
                y + RING * np.sin(angle),
            )
            box = dict(
                boxstyle="circle,pad=0.35",
                fc=FILL[region.assembly],
                ec=INK,
                lw=1.0,
            )
            text: dict = dict(
                fontsize=11,
                fontweight="bold",
                color=INK,
                bbox=box,
                zorder=3,
            )
            x_text, y_text = places[region.number]
            axes.text(x_text, y_text, str(region.number), **middle, **text)
    drawn = set()
    bow: dict = dict(
        connectionstyle=f"arc3,rad={BOW}",
        arrowstyle="-",
        shrinkA=0,
        shrinkB=0,
        zorder=1,
    )
    for passage in passages(robot):
        drawn.add((passage.leg, passage.fold))
        style = LINES[passage.leg, passage.fold] | bow | {"label": None}
        ends = [places[number] for number in passage.between]
        axes.add_patch(FancyArrowPatch(*ends, **style))
    handles = [Line2D([], [], **LINES[kind]) for kind in LINES if kind in drawn]
    dots: dict = dict(marker="o", ms=11, mec=INK, ls="none")
    for sign in sorted({region.assembly for region in regions}, reverse=True):
        label = f"assembly mode {signs(sign)}"
        handles.append(Line2D([], [], mfc=FILL[sign], label=label, **dots))
    figure_legend(figure, handles, 2)
    return figure
