"""The picture of the stability chart: colours over the plane of the gains, the exact limits on
it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..picture import (
    ABOVE,
    BELOW,
    EDGE,
    HEAD,
    HEIGHT,
    INK,
    LEFT,
    LINE,
    RIGHT,
    WIDTH,
    title,
    wrapped,
)
from .stability import NEVER, PROBLEMS, WINDOWS, gains, side_of

if TYPE_CHECKING:
    from ..store import Result

LEVELS = {"growth": (0.5, 0.8, 1.0), "noise": (1.5, 2.0, 3.0, 5.0)}
BAR = 0.75  # in, for the colour bar
FINE = 121  # exact values on a side


def figure(result: Result) -> Figure:
    """Matplotlib figure of the stability chart's Result."""
    rows = result.chart.panels
    width = len(rows[0]) * (LEFT + WIDTH + RIGHT + BAR)
    verdict = wrapped(caption(result), width)
    foot = LINE * len(verdict) + 2 * EDGE
    height = HEAD + foot + len(rows) * (ABOVE + HEIGHT + BELOW)
    made = Figure(figsize=(width, height))
    title(made, result.chart.title)
    top = height - HEAD
    for row in rows:
        top -= ABOVE + HEIGHT
        for k, panel in enumerate(row):
            left = k * (LEFT + WIDTH + RIGHT + BAR) + LEFT
            axes = made.add_axes((left / width, top / height, WIDTH / width, HEIGHT / height))
            bar = made.add_axes(
                ((left + WIDTH + 0.1) / width, top / height, 0.13 / width, HEIGHT / height)
            )
            _map(made, axes, bar, result, panel)
        top -= BELOW
    made.text(
        EDGE / width,
        1.3 * EDGE / height,
        "\n".join(verdict),
        fontsize=8.5,
        va="bottom",
        linespacing=1.3,
        color=INK,
    )
    return made


def _map(made, axes, bar, result, panel):
    words, delay, _, exact = PROBLEMS[panel.problem]
    kind = panel.problem.split("-")[0]
    if kind == "growth":
        reach = (1.0, 0.3)[delay]
        colours, label = (
            dict(cmap="PuOr_r", vmin=1 - reach, vmax=1 + reach),
            "factor per sample, simulated",
        )
    else:
        colours, label = (
            dict(cmap="cividis_r", vmin=1.0, vmax=6.0),
            "angles' deviation over the noise's, simulated",
        )
    edges = (np.linspace(0, high, side_of(panel.problem) + 1) for high in WINDOWS[delay])
    image = axes.pcolormesh(*edges, _grid(result, panel.problem), **colours)
    if lost := result.of(panel.problem, status="failed"):
        axes.plot(
            *np.transpose([gains(panel.problem, row["knob"]) for row in lost]),
            "x",
            color="#999999",
            ms=4,
        )
    x, y = (np.linspace(1e-6, high, FINE) for high in WINDOWS[delay])
    field = np.array([[min(exact(a, b, delay), 99.0) for a in x] for b in y])
    styles = dict(colors=[INK], linewidths=1.6)
    if kind == "growth":
        axes.contour(x, y, field, [1.0], **styles)
        lines = axes.contour(x, y, field, [0.5, 0.8], colors=[INK], linewidths=1.0, linestyles="--")
    else:
        lines = axes.contour(
            x, y, np.where(field > 90, np.nan, field), LEVELS["noise"], colors=[INK], linewidths=1.1
        )
        axes.contour(x, y, field, [90.0], **styles)
    axes.clabel(lines, fontsize=7.5, fmt="%g")
    axes.set(xlim=(0, x[-1]), ylim=(0, y[-1]))
    axes.set_title(words, fontsize=10.5, color=INK)
    axes.set_xlabel("Kp h² (no unit)", fontsize=9)
    axes.set_ylabel("Kd h (no unit)", fontsize=9)
    axes.tick_params(labelsize=8)
    made.colorbar(image, cax=bar, extend="max").set_label(label, fontsize=8.5)
    bar.tick_params(labelsize=8)


def _grid(result, problem):
    """Values over the grid, [Kd, Kp]; what a quick run left out is the mean of the neighbours."""
    side = side_of(problem)
    values = np.full(side * side, np.nan)
    measured = np.zeros(side * side, bool)
    for row in result.of(problem):
        values[int(row["knob"])] = row["value"]
    for row in [*result.of(problem), *result.of(problem, status="failed")]:
        measured[int(row["knob"])] = True
    wide, known = (
        np.pad(values.reshape(side, side), 1, constant_values=np.nan),
        measured.reshape(side, side),
    )
    around = np.stack([wide[:-2, 1:-1], wide[2:, 1:-1], wide[1:-1, :-2], wide[1:-1, 2:]])
    found = np.isfinite(around)
    mean = np.where(found, around, 0.0).sum(axis=0) / np.maximum(found.sum(axis=0), 1)
    inside = found.sum(axis=0) >= 2
    return np.where(known, wide[1:-1, 1:-1], np.where(inside, mean, np.nan)).T


def _holds(problem, row):
    return (
        row["value"] < 1 if problem.startswith("growth") else True
    )  # it grows less than the run is long


def _compared(result):
    """Per map: its words, pairs of gains, on which simulated and exact disagree about stability,
    how far these are from the limit, and by which share the others' values differ, (n,).
    """
    for problem, (words, *_) in PROBLEMS.items():
        rows, lost = result.of(problem), result.of(problem, status="failed")
        if rows:
            off = np.array(
                [abs(row["value"] / row["exact"] - 1) for row in rows if row["exact"] < NEVER]
            )
            wrong = [
                abs(row["radius"] - 1)
                for row in rows
                if (row["radius"] < 1) != _holds(problem, row)
            ]
            astray = sum(row["word"] != "grows" for row in lost)
            yield words, len(rows) + len(lost), len(wrong) + astray, max(wrong, default=0.0), off


def caption(result: Result) -> str:
    """How far the simulated robot is from the exact values, in a sentence."""
    _, pairs, apart, limit, off = zip(*_compared(result))
    medians = [100 * np.median(each) for each in off]
    text = (
        f"On {sum(apart)} of {sum(pairs)} pairs of gains simulated and exact disagree about"
        " stability"
    )
    text += f", none farther than {max(limit):.2g} from a factor of 1" if any(limit) else ""
    return (
        f"{text}; the values differ by {min(medians):.2g} to {max(medians):.2g} % in the median of"
        " a map."
    )


def table(result: Result) -> list[tuple[str, list[str], list[list[str]]]]:
    """The numbers behind the caption, a row for each map."""
    head = [
        "problem",
        "pairs of gains",
        "disagree about stability",
        "values differ by, median (%)",
        "at most (%)",
    ]
    rows = [
        [words, str(pairs), str(apart), f"{100 * np.median(off):.2g}", f"{100 * off.max():.2g}"]
        for words, pairs, apart, _, off in _compared(result)
    ]
    return [("Simulated against exact", head, rows)]
