"""The figure of a chart: panels of error against time, and above each a strip of what failed."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from ...visualization.style import COLOURS as OKABE_ITO
from ...visualization.style import DASHES, INK
from .chart import OURS
from .findings import counted, failures, orders, summary, words_of
from .store import Result

PALE = "#777777"
COLOURS = *OKABE_ITO[:-1], "#8C6239", "#332288"  # brown, indigo: black is near the colour of ours
MARKERS = "osD^vP*X<>"  # first hollow, then filled; ours filled
# inches of a panel, and of a line in a strip
WIDTH = 5.3
HEIGHT = 3.8
LANE = 0.27
LETTERS = 15  # of small text in an inch


def draw(result: Result) -> Figure:
    """Return the Matplotlib figure of a Result."""
    figure = (result.chart.figure or panels)(result)
    figure.suptitle(result.chart.title, fontsize=13, fontweight="bold", color=INK)
    handles = []
    width = figure.get_figwidth()
    if not result.chart.figure:
        styles = method_styles(result.chart)
        labels = _labels(result)
        handles = [Line2D([], [], label=labels[name], **style) for name, style in styles.items()]
    figure.legend(
        handles=handles,
        title=textwrap.fill(summary(result)[0], int(LETTERS * width)),
        loc="outside lower left",
        ncols=max(1, int(width / 4.5)),
        alignment="left",
        fontsize=8.5,
        title_fontsize=8.5,
        frameon=False,
    )
    return figure


def panels(result: Result) -> Figure:
    """Return a figure of all panels, each below the strip of its failures."""
    rows = result.chart.panels
    styles = method_styles(result.chart)
    columns = max(map(len, rows))
    failed = []
    heights = []
    for row in rows:
        failed.append([failures(result, panel) for panel in row])
        heights += [LANE * max(0.1, *map(len, failed[-1])), HEIGHT]
    words = 0.3 * len(styles) / max(1, int(columns * WIDTH / 4.5)) + 1.2
    size = columns * WIDTH, sum(heights) + words
    figure = Figure(figsize=size)
    figure.set_layout_engine("constrained", h_pad=0.02, hspace=0)
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    for i, row in enumerate(rows):
        for k, panel in enumerate(row):
            axes = figure.add_subplot(grid[2 * i + 1, k])
            _draw_panel(axes, result, panel, styles)
            strip = figure.add_subplot(grid[2 * i, k], sharex=axes)
            strip.set_title(panel.title, fontsize=10.5, color=INK)
            _draw_strip(strip, panel, failed[i][k], styles, max(map(len, failed[i])))
    return figure


def method_styles(chart):
    """Return {method: how its line is drawn}: ours in ink, each other one in its own colour.

    Dashes tell apart ours, and others of one colour; each has a marker too.
    """
    counts = {True: 0, False: 0}
    styles = {}
    for k, method in enumerate(chart.methods):
        ours = method.family == OURS
        place = counts[ours]
        counts[ours] += 1
        turn, colour = (place, INK) if ours else divmod(place, len(COLOURS))
        if not ours:
            colour = COLOURS[colour]
        styles[method.name] = {
            "color": colour,
            "ls": DASHES[turn % len(DASHES)],
            "marker": MARKERS[k % len(MARKERS)],
            "ms": 6 if ours else 5,
            "lw": 1.7 if ours else 1.2,
            "mew": 1.1,
            "mfc": colour if ours or k >= len(MARKERS) else "white",
        }
    return styles


def _labels(result):
    """Return {method: legend entry}, with the order of convergence that the first panel shows."""
    labels = {method.name: method.name for method in result.chart.methods}
    for panel in reversed(result.chart.all_panels):
        for name, order in orders(result, panel).items():
            labels[name] = f"{name}, measured order {order:.2f}"
    return labels


def _draw_panel(axes, result, panel, styles):
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel(panel.xlabel, fontsize=9)
    axes.set_ylabel(panel.ylabel, fontsize=9)
    axes.tick_params(labelsize=8, which="both")
    axes.margins(x=0.07, y=0.09)
    axes.grid(alpha=0.25, which="major")
    known = [row[panel.x] for name in styles for row in counted(result, panel, name)]
    widths = [min(known, default=1.0), max(known, default=1.0)]
    for name, style in styles.items():
        points = counted(result, panel, name)
        x = np.array([row[panel.x] for row in points])
        y = np.maximum([row[panel.y] for row in points], panel.floor)
        if panel.x == "knob" and len(points) == 1:
            axes.plot(widths, [y[0]] * 2, color=style["color"], lw=style["lw"], ls="--")
        elif points:
            axes.plot(x, y, **style)
        if panel.x == "seconds" and points:
            spread = [
                [row["seconds_low"] for row in points],
                [row["seconds_high"] for row in points],
            ]
            axes.hlines(y, *spread, color=style["color"], lw=1)
    low, high = axes.dataLim.get_points()
    one = high < 1.001 * low  # point, which has no width by itself
    axes.update_datalim([np.where(one, low / 2, low), np.where(one, 2 * high, high)])
    low, high = axes.get_xlim()
    if high > 10 * low:  # or numbers between powers of ten would run into each other
        axes.xaxis.set_minor_formatter(NullFormatter())
    if panel.guide:
        factor, words = panel.guide
        limits = np.array(axes.get_xlim())
        axes.plot(limits, factor * limits, ":", color=PALE, lw=1.3, zorder=0)
        axes.text(3 * limits[0], factor * limits[0], words, fontsize=7.5, color=PALE, va="top")
        axes.set_xlim(limits)
    if panel.x == "seconds":
        axes.text(0.01, 0.01, "↙ better", transform=axes.transAxes, fontsize=8, color=PALE)


def _draw_strip(axes, panel, failed, styles, lanes):
    """Draw failed attempts at their times, a lane for each method, and how they failed."""
    axes.tick_params(left=False, labelleft=False, bottom=False, labelbottom=False, which="both")
    axes.set_facecolor("none")
    axes.spines[:].set_visible(False)
    axes.set_ylim(max(lanes, 0.1), 0)
    for k, (name, items) in enumerate(failed.items()):
        times = [row[panel.x] for row, _ in items if panel.x in row]
        axes.plot(times, [k + 0.72] * len(times), "x", color=styles[name]["color"], ms=4.5, mew=1.3)
        text = textwrap.shorten(f"{name}: {words_of(items)}", 86, placeholder=" …")
        place = axes.get_yaxis_transform()
        axes.text(0.008, k + 0.3, text, transform=place, fontsize=7, va="center", color=INK)
