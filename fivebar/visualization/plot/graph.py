"""How the aspects hang together as a picture: a node for each, a line for each passage between
two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch

from ...singularities.locus import MODES
from ...singularities.passages import known_aspects, passages
from ..style import INK, LEFT, PALE, RIGHT

if TYPE_CHECKING:
    from ...models.robots import FiveBar

LINES = {  # by the leg that changes its mode, and whether it folds for that
    (0, False): dict(color=LEFT, lw=1.8, ls="-", label="Type 1, the left leg in line"),
    (0, True): dict(
        color=LEFT,
        lw=1.8,
        ls=(0, (1.2, 1.4)),
        label="the left leg folded on its base joint",
    ),
    (1, False): dict(color=RIGHT, lw=1.8, ls="-", label="Type 1, the right leg in line"),
    (1, True): dict(
        color=RIGHT,
        lw=1.8,
        ls=(0, (1.2, 1.4)),
        label="the right leg folded on its base joint",
    ),
    (None, False): dict(color=INK, lw=1.4, ls=(0, (6, 2.5)), label="Type 2"),
}
FILL = {1: "white", -1: "#d6dbe0"}
RING, BOW = (
    0.27,
    0.12,
)  # of the nodes of one pair of modes, which are 1 apart; how far a line bends


def aspect_graph(robot: FiveBar) -> Figure:
    """Figure of the graph of a five-bar's aspects: numbers as `aspects` gives them, lines where a
    motion may pass.

    The left leg's mode goes across the picture and the right leg's up, so that the lines of either
    leg's Type 1 go across or up, and those of Type 2 stay with their modes. Raises as `aspects`.
    """
    found = known_aspects(robot)
    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_aspect("equal")
    at = _places(found)
    for working in MODES:
        x, y = np.array(working) / 2
        words = f"working modes ({working[0]:+d}, {working[1]:+d})".replace("-", "−")
        axes.text(
            x,
            y + np.sign(y) * 0.45,
            words,
            ha="center",
            va="center",
            color=PALE,
            fontsize=10,
        )
    drawn = {}
    for passage in passages(robot):
        style = LINES[passage.leg, passage.fold]
        drawn[passage.leg, passage.fold] = style
        kind = {name: style[name] for name in ("color", "lw", "ls")}
        bow = f"arc3,rad={BOW}"
        ends = [at[number] for number in passage.between]
        axes.add_patch(
            FancyArrowPatch(
                *ends,
                connectionstyle=bow,
                arrowstyle="-",
                shrinkA=0,
                shrinkB=0,
                zorder=1,
                **kind,
            )
        )
    for aspect in found:
        box = dict(
            boxstyle="circle,pad=0.35",
            fc=FILL[aspect.assembly],
            ec=INK,
            lw=1.0,
        )
        text = dict(
            ha="center",
            va="center",
            fontsize=11,
            fontweight="bold",
            color=INK,
            bbox=box,
            zorder=3,
        )
        axes.text(*at[aspect.number], str(aspect.number), **text)
    axes.set(xlim=(-1.02, 1.02), ylim=(-1.02, 1.02))
    handles = [Line2D([], [], **drawn[key]) for key in LINES if key in drawn]
    dots = dict(marker="o", ms=11, mec=INK, ls="none")
    for sign in sorted({aspect.assembly for aspect in found}, reverse=True):
        label = f"assembly mode {sign:+d}".replace("-", "−")
        handles.append(Line2D([], [], mfc=FILL[sign], label=label, **dots))
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=2,
        fontsize=9,
        frameon=False,
        handlelength=3.2,
    )
    return figure


def _places(found):
    """Where each aspect stands: on a ring about the place of its modes, one assembly mode above the
    other.
    """
    places = {}
    for working in MODES:
        own = sorted(
            (a for a in found if a.working == working),
            key=lambda a: (-a.assembly, a.point[0]),
        )
        # Begun a little off the axes, so that no line to another ring passes behind a node between.
        angles = 2.0 - 2 * np.pi * np.arange(len(own)) / max(len(own), 1)
        for aspect, angle in zip(own, angles):
            places[aspect.number] = tuple(
                np.array(working) / 2 + RING * np.array([np.cos(angle), np.sin(angle)])
            )
    return places
