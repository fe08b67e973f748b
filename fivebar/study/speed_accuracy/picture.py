"""A chart's picture from its measurements: panels of error against time, and above each a strip of
what failed.
"""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from PIL import Image

from ...visualization.style import COLOURS as OKABE_ITO
from ...visualization.style import INK
from .chart import OURS
from .findings import caption, counted, failures, orders, words_of

if TYPE_CHECKING:
    from .store import Result

PALE = "#777777"
COLOURS = (
    *OKABE_ITO[:-1],
    "#8C6239",
    "#332288",
)  # brown and indigo for black, which is near our ink
MARKERS = "osD^vP*X<>"  # first hollow, then filled; ours filled
# Inches.
WIDTH, HEIGHT, LEFT, RIGHT, BELOW, ABOVE, LANE, EDGE = 4.3, 3.3, 0.8, 0.25, 0.62, 0.34, 0.27, 0.15
HEAD = 0.45  # for the title
LONGEST = 86  # letters in a strip
LINE, LETTER = 0.158, 0.0655  # of small text: height of a line, mean width of a letter


def figure(result: Result) -> Figure:
    """Matplotlib figure of a Result."""
    chart, styles = result.chart, _styles(result.chart)
    lanes = [[_lanes(result, chart, panel) for panel in row] for row in chart.panels]
    strips = [LANE * max(map(len, row)) for row in lanes]
    width = max(map(len, chart.panels)) * (LEFT + WIDTH + RIGHT)
    labels = _labels(result)
    verdict = wrapped(caption(result), width)
    columns = max(1, int((width - 2 * EDGE) / (LETTER * max(map(len, labels.values())) + 0.75)))
    key = LINE * 1.25 * -(-len(labels) // columns) + 0.1
    head, foot = HEAD, key + LINE * len(verdict) + 3 * EDGE
    height = head + foot + sum(strip + ABOVE + HEIGHT + BELOW for strip in strips)
    made = Figure(figsize=(width, height))
    title(made, chart.title)
    top = height - head
    for panels, failed, strip in zip(chart.panels, lanes, strips):
        top -= ABOVE + strip + HEIGHT
        for k, (panel, lane) in enumerate(zip(panels, failed)):
            box = (
                (k * (LEFT + WIDTH + RIGHT) + LEFT) / width,
                top / height,
                WIDTH / width,
                HEIGHT / height,
            )
            axes = made.add_axes(box)
            _draw(axes, result, panel, styles)
            axes.set_title(panel.title, fontsize=10.5, color=INK, pad=5 + 72 * LANE * len(lane))
            if lane:
                above = made.add_axes(
                    (box[0], box[1] + box[3], box[2], LANE * len(lane) / height), sharex=axes
                )
                _strip(above, panel, lane, styles)
            _decades(axes)
        top -= BELOW
    handles = [Line2D([], [], label=label, **styles[name]) for name, label in labels.items()]
    made.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(EDGE / width, (foot - key - EDGE) / height),
        ncols=columns,
        fontsize=8.5,
        frameon=False,
        borderaxespad=0,
        columnspacing=2.0,
        labelspacing=0.35,
    )
    y = (foot - key - 1.6 * EDGE) / height
    made.text(
        EDGE / width, y, "\n".join(verdict), fontsize=8.5, va="top", linespacing=1.3, color=INK
    )
    return made


def plain(made: Figure, image: Image.Image) -> Image.Image:
    """The image without the figure's own words, title and verdict, for a page that has them as
    text.
    """
    above, below = (text.get_window_extent() for text in made.texts)
    scale = image.height / made.bbox.height
    return image.crop(
        (
            0,
            round(image.height - scale * above.y0),
            image.width,
            round(image.height - scale * below.y1),
        )
    )


def title(made: Figure, text: str) -> None:
    """Above all else, as large as fits."""
    width, height = made.get_size_inches()
    size = min(15, (width - 2 * EDGE) * 108 / len(text))
    made.text(
        EDGE / width, 1 - 0.12 / height, text, fontsize=size, fontweight="bold", va="top", color=INK
    )


def wrapped(text: str, width: float) -> list[str]:
    """Lines of small text that fit into a figure `width` inches wide."""
    return textwrap.wrap(text, int((width - 2 * EDGE) / LETTER))


def _styles(chart):
    """{method: how its line is drawn}: a colour for a family, a marker for a method."""
    others = list(dict.fromkeys(m.family for m in chart.methods if m.family != OURS))
    colours = {OURS: INK} | dict(zip(others, COLOURS))
    return {
        m.name: dict(
            color=colours[m.family],
            marker=MARKERS[k % len(MARKERS)],
            ms=6 if m.family == OURS else 5,
            lw=1.7 if m.family == OURS else 1.1,
            mew=1.1,
            mfc=colours[m.family] if m.family == OURS or k >= len(MARKERS) else "white",
        )
        for k, m in enumerate(chart.methods)
    }


def _labels(result):
    """{method: its legend entry}, with the order of convergence measured on the first panel that
    shows one.
    """
    labels = {method.name: method.name for method in result.chart.methods}
    measured = {}
    for panel in (panel for row in result.chart.panels for panel in row):
        for name, order in orders(result, panel).items():
            measured.setdefault(name, order)
    return {
        n: f"{label}, measured order {measured[n]:.2f}" if n in measured else label
        for n, label in labels.items()
    }


def _lanes(result, chart, panel):
    """What the strip above a panel shows: {method: [(row, word), ...]}; a problem's failures once,
    above the first.
    """
    found = failures(result, panel)
    first = next(p for row in chart.panels for p in row if p.problem == panel.problem)
    if panel is first:
        return found
    kept = {
        name: [(row, word) for row, word in failed if row["status"] == "ok"]
        for name, failed in found.items()
    }
    return {name: failed for name, failed in kept.items() if failed}


def _draw(axes, result, panel, styles):
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(alpha=0.25, which="major")
    heights = {max(row[panel.y], panel.floor) for row in counted(result, panel)}
    if len(heights) == 1:  # no range to scale to
        axes.set_ylim(min(heights) / 10, max(heights) * 10)
    for method in result.chart.methods:
        points = counted(result, panel, method.name)
        if not points:
            continue
        y = np.maximum([row[panel.y] for row in points], panel.floor)
        if panel.x == "knob" and len(points) == 1:
            style = {k: v for k, v in styles[method.name].items() if k in ("color", "lw")}
            axes.axhline(y[0], **style, ls="--")
            continue
        x = np.array([row[panel.x] for row in points])
        axes.plot(x, y, **styles[method.name])
        if panel.x == "seconds":
            spread = np.array(
                [
                    [r["seconds"] - r["seconds_low"], r["seconds_high"] - r["seconds"]]
                    for r in points
                ]
            )
            axes.errorbar(
                x, y, xerr=spread.T, fmt="none", ecolor=styles[method.name]["color"], elinewidth=1
            )
    if panel.guide:
        factor, words = panel.guide
        x = np.array(axes.get_xlim())
        axes.plot(x, factor * x, ":", color=PALE, lw=1.3, zorder=0)
        axes.text(x[0] * 3, factor * x[0], words, fontsize=7.5, color=PALE, va="top")
        axes.set_xlim(x)
    if panel.x == "seconds":
        arrow = dict(arrowstyle="-|>", color=PALE, lw=1.3)
        axes.annotate(
            "",
            (-0.15, -0.125),
            (-0.1, -0.06),
            "axes fraction",
            arrowprops=arrow,
            annotation_clip=False,
        )
        axes.text(
            -0.12, -0.15, "better", transform=axes.transAxes, fontsize=8, color=PALE, va="center"
        )
    axes.set_xlabel(panel.xlabel, fontsize=9)
    axes.set_ylabel(panel.ylabel, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.margins(x=0.07, y=0.09)


def _strip(axes, panel, lanes, styles):
    """Failed attempts at their times, a lane for each method, and above them in words how they
    failed.
    """
    axes.tick_params(left=False, labelleft=False, bottom=False, labelbottom=False, which="both")
    axes.set_facecolor("#f1f1f1")
    axes.set_ylim(len(lanes), 0)
    for k, (name, failed) in enumerate(lanes.items()):
        times = [row[panel.x] for row, _ in failed if panel.x in row]
        axes.plot(times, [k + 0.72] * len(times), "x", color=styles[name]["color"], ms=4.5, mew=1.3)
        text = textwrap.shorten(f"{name}: {words_of(failed)}", LONGEST, placeholder=" …")
        axes.text(
            0.008,
            k + 0.3,
            text,
            transform=axes.get_yaxis_transform(),
            fontsize=6.6,
            va="center",
            color=INK,
        )


def _decades(axes):
    """Ticks at powers of ten, at least two on each axis."""
    for low_high, set_limits, axis in (
        (axes.get_xlim(), axes.set_xlim, axes.xaxis),
        (axes.get_ylim(), axes.set_ylim, axes.yaxis),
    ):
        low, high = np.log10(low_high)
        if np.floor(high) - np.ceil(low) < 1:
            low, high = min(low, np.floor(low + 0.15)), max(high, np.ceil(high - 0.15))
            set_limits(10**low, 10**high)
        axis.set_minor_formatter(NullFormatter())
