"""The ladder as a figure: for each robot the tracking error and the cost over the rungs."""

from __future__ import annotations

import math
import textwrap

from matplotlib.figure import Figure

from ...visualization.style import COLOURS, INK
from .rungs import CASES, RUNGS, Rung

READING = (
    "The plant has all of it; the controller (computed torque at 1 kHz) knows the rungs up to the"
    " one on the axis. Hollow: the robot has nothing of that kind, and the rung costs nothing. An"
    " error of 0 is not drawn."
)
# Attribute of a Rung -> (row of the figure, factor, label).
CURVES = {
    "rms": (0, 1e3, "tracking error, rms, mm"),
    "missed": (0, 1e3, "torque missed, rms, mN m"),
    "instructions": (1, 1, "instructions of the inverse model"),
    "step": (1, 1e6, "time of a step of the plant, µs"),
}


def figure(cases: dict[str, list[Rung]]) -> Figure:
    """Return a Matplotlib figure of the rungs {case: [Rung, ...]}: errors above, cost below."""
    made = Figure(figsize=(4.2 * len(cases) + 0.4, 7.6), layout="constrained")
    made.suptitle("Which physics is worth its cost", fontsize=14, fontweight="bold", color=INK)
    made.supxlabel(textwrap.fill(READING, 40 * len(cases)), fontsize=8.5)
    axes = made.subplots(2, len(cases), sharex="col", squeeze=False)
    for (name, rungs), column in zip(cases.items(), axes.T):
        title = textwrap.fill(f"{name}: {CASES[name].source}", 52)
        column[0].set_title(title, fontsize=8.5, color=INK)
        for (attribute, (row, factor, label)), colour in zip(CURVES.items(), COLOURS):
            # Errors are on a logarithmic axis, which has no 0.
            values = [factor * getattr(rung, attribute) or math.nan for rung in rungs]
            column[row].plot(values, color=colour, lw=1.2, label=label)
            for place, rung in enumerate(rungs):
                fill = colour if rung.named else "white"
                column[row].plot(place, values[place], "o", color=colour, mfc=fill, ms=6)
        column[0].set_yscale("log")
        column[1].set_ylim(bottom=0)
        labels = ["masses", *(f"+ {rung}" for rung in list(RUNGS)[1:])]
        column[1].set_xticks(range(len(RUNGS)), labels, rotation=25, ha="right")
        for panel in column:
            panel.grid(True, color="#e5e5e5", lw=0.6)
            panel.tick_params(labelsize=8.5)
    for panel in axes[:, 0]:
        panel.legend(fontsize=8.5, frameon=False)
    return made
