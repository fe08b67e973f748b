"""What the figures of the labs' statements are drawn with."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fivebar.visualization.style import COLOURS, INK

LEFT, RIGHT, GREEN, PINK = COLOURS[:4]
MM = 1e3


def panels(count, width=3.2, height=3.0, axis=False):
    figure = Figure(figsize=(width * count, height), layout="constrained")
    axes = figure.subplots(1, count, squeeze=False)[0]
    if not axis:
        for each in axes:
            each.set_aspect("equal")
            each.set_axis_off()
    return figure, axes


def label(axes, at, text, offset, **style):
    axes.annotate(
        text,
        at,
        xytext=offset,
        textcoords="offset points",
        fontsize=11,
        ha="center",
        va="center",
        **style,
    )


def arrow(axes, start, vector, colour, text="", offset=(8, 8), **style):
    tip = np.add(start, vector)
    props = (
        dict(arrowstyle="-|>", color=colour, lw=2, shrinkA=0, shrinkB=0, mutation_scale=14) | style
    )
    axes.annotate("", tip, start, arrowprops=props, zorder=6)
    if text:
        label(axes, tip, text, offset, color=colour)


def arc(axes, center, radius, start, stop, text, far=1.5):
    angle = np.linspace(start, stop, 40)
    axes.plot(
        center[0] + radius * np.cos(angle), center[1] + radius * np.sin(angle), color=INK, lw=1.2
    )
    tangent = np.array([-np.sin(angle[-1]), np.cos(angle[-1])]) * np.sign(stop - start)
    end = np.array(center) + radius * np.array([np.cos(angle[-1]), np.sin(angle[-1])])
    axes.annotate(
        "", end, end - 2 * tangent, arrowprops=dict(arrowstyle="-|>", color=INK, lw=1.2), zorder=3
    )
    middle = (start + stop) / 2
    at = np.array(center) + far * radius * np.array([np.cos(middle), np.sin(middle)])
    axes.text(*at, text, ha="center", va="center", fontsize=11)


def ray(axes, start, direction, length):
    axes.plot(
        *np.array([start, np.add(start, length * np.asarray(direction))]).T,
        color=INK,
        lw=0.9,
        ls=(0, (4, 3)),
    )


def main(figures):
    """Draw {lab: functions} into the labs of the folder on the command line, else of this one."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for lab, drawings in figures.items():
        place = folder / lab / "figures"
        place.mkdir(parents=True, exist_ok=True)
        for drawing in drawings:
            drawing().savefig(place / f"{drawing.__name__}.png", dpi=100)
