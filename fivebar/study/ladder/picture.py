"""The ladder as a chart: per robot the tracking error and the torque missed, over what each rung
costs.
"""

from __future__ import annotations

import textwrap

from matplotlib.figure import Figure

from ...visualization.style import COLOURS, INK
from .rungs import CASES, RUNGS, Rung

PALE = "#777777"
TITLE = "Which physics is worth its cost"
READING = (
    "The plant has all of it; the controller (computed torque at 1 kHz) knows the rungs up to the"
    " one on the axis. Hollow: the robot has nothing of that kind, and the rung costs nothing. A"
    " line that leaves its frame goes to 0."
)


def figure(found: dict[str, list[Rung]]) -> Figure:
    """Matplotlib figure of the rungs {case: [Rung, ...]}: errors above, cost below."""
    made = Figure(figsize=(4.2 * len(found) + 0.4, 7.2), layout="constrained")
    made.suptitle(f"{TITLE}\n", fontsize=14, fontweight="bold", color=INK)
    axes = made.subplots(2, len(found), sharex="col", squeeze=False)
    places = range(len(RUNGS))
    for k, (name, rungs) in enumerate(found.items()):
        above, below = axes[:, k]
        above.set_title(textwrap.fill(f"{name}: {CASES[name].source}", 52), fontsize=8.5, color=INK)
        for values, label, colour in (
            ([1e3 * r.rms for r in rungs], "tracking error, rms, mm", COLOURS[0]),
            ([1e3 * r.missed for r in rungs], "torque missed, rms, mN m", COLOURS[1]),
        ):
            above.plot(places, values, color=colour, lw=1.2, label=label)
            _marks(above, rungs, values, colour)
        above.set_yscale("log")
        for values, label, colour in (
            ([r.instructions for r in rungs], "instructions of the inverse model", COLOURS[2]),
            ([1e6 * r.step for r in rungs], "time of a step of the plant, µs", COLOURS[3]),
        ):
            below.plot(places, values, color=colour, lw=1.2, label=label)
            _marks(below, rungs, values, colour)
        below.set_ylim(bottom=0)
        below.set_xticks(
            list(places),
            [("" if r.name == "masses" else "+ ") + r.name for r in rungs],
            rotation=25,
            ha="right",
        )
        for part in (above, below):
            part.grid(True, color="#e5e5e5", lw=0.6)
            part.tick_params(labelsize=8.5)
    for part in axes[:, 0]:
        part.legend(fontsize=8.5, frameon=False)
    made.text(
        0.5,
        -0.02,
        textwrap.fill(READING, 40 * len(found)),
        ha="center",
        va="top",
        fontsize=8.5,
        color=PALE,
    )
    return made


def _marks(axes, rungs, values, colour):
    for place, (rung, value) in enumerate(zip(rungs, values)):
        axes.plot(place, value, "o", color=colour, mfc=colour if rung.named else "white", ms=6)
