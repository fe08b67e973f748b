"""The picture of the stability chart: colours over the plane of the gains, the exact limits on it."""

import numpy as np
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from .picture import ABOVE, BELOW, EDGE, HEIGHT, INK, LEFT, LINE, RIGHT, WIDTH, _wrapped
from .stability import PROBLEMS, WINDOWS

LEVELS = {"growth": (0.5, 0.8, 1.0), "noise": (1.5, 2.0, 3.0, 5.0)}
BAR = 0.75  # in, for the colour bar
FINE = 121  # exact values on a side


def figure(result):
    """Matplotlib figure of the stability chart's Result."""
    rows = result.chart.panels
    width = len(rows[0]) * (LEFT + WIDTH + RIGHT + BAR)
    reading, findings = _wrapped(result.chart.reading, width), _wrapped(caption(result), width)
    head, foot = 0.5 + LINE * len(reading), LINE * len(findings) + 2 * EDGE
    height = head + foot + len(rows) * (ABOVE + HEIGHT + BELOW)
    made = Figure(figsize=(width, height))
    made.text(EDGE / width, 1 - 0.12 / height, result.chart.title, fontsize=15, fontweight="bold", va="top", color=INK)
    made.text(EDGE / width, 1 - 0.48 / height, "\n".join(reading), fontsize=8.5, va="top", linespacing=1.3, color=INK)
    top = height - head
    for row in rows:
        top -= ABOVE + HEIGHT
        for k, panel in enumerate(row):
            left = k * (LEFT + WIDTH + RIGHT + BAR) + LEFT
            axes = made.add_axes((left / width, top / height, WIDTH / width, HEIGHT / height))
            bar = made.add_axes(((left + WIDTH + 0.1) / width, top / height, 0.13 / width, HEIGHT / height))
            _map(made, axes, bar, result, panel)
        top -= BELOW
    made.text(
        EDGE / width, 1.3 * EDGE / height, "\n".join(findings), fontsize=8.5, va="bottom", linespacing=1.3, color=INK
    )
    return made


def _map(made, axes, bar, result, panel):
    words, delay, _, exact = PROBLEMS[panel.problem]
    kind = panel.problem.split("-")[0]
    rows = result.of(panel.problem)
    p, q, value = (np.array([row[name] for row in rows]) for name in ("p", "q", "value"))
    if kind == "growth":
        colours = dict(cmap="PuOr_r", norm=TwoSlopeNorm(1.0, 0.0, 2.0))
        label = "factor per sample, simulated"
    else:
        colours, label = dict(cmap="cividis_r", vmin=1.0, vmax=6.0), "angles' deviation over the noise's, simulated"
    image = axes.scatter(p, q, c=value, s=_mark(len(result.of(panel.problem)) + len(_lost(result, panel))), marker="s",
                         linewidths=0, **colours)  # fmt: skip
    lost = _lost(result, panel)
    if lost:
        from .stability import gains

        points = np.array([gains(panel.problem, row["knob"]) for row in lost])
        axes.plot(*points.T, "x", color="#aaaaaa", ms=4, label="does not hold")
    x, y = (np.linspace(1e-6, high, FINE) for high in WINDOWS[delay])
    field = np.array([[min(exact(a, b, delay), 99.0) for a in x] for b in y])
    styles = dict(colors=[INK], linewidths=1.6)
    if kind == "growth":
        axes.contour(x, y, field, [1.0], **styles)
        lines = axes.contour(x, y, field, [0.5, 0.8], colors=[INK], linewidths=1.0, linestyles="--")
    else:
        lines = axes.contour(x, y, np.where(field > 90, np.nan, field), LEVELS["noise"], colors=[INK], linewidths=1.1)
        axes.contour(x, y, field, [90.0], **styles)
    axes.clabel(lines, fontsize=7.5, fmt="%g")
    axes.set(xlim=(0, x[-1]), ylim=(0, y[-1]))
    axes.set_title(words, fontsize=10.5, color=INK)
    axes.set_xlabel("Kp h² (no unit)", fontsize=9)
    axes.set_ylabel("Kd h (no unit)", fontsize=9)
    axes.tick_params(labelsize=8)
    made.colorbar(image, cax=bar, extend="max").set_label(label, fontsize=8.5)
    bar.tick_params(labelsize=8)


def _mark(count):
    """Area of a square marker, pt^2, that `count` points (a grid, or every other point of one) fill the axes with."""
    return WIDTH * HEIGHT * 72**2 / count * 0.9


def _lost(result, panel):
    return result.of(panel.problem, status="failed")


def caption(result):
    """How far the simulated robot is from the exact values."""
    sentences = []
    for problem, (words, *_) in PROBLEMS.items():
        rows = result.of(problem)
        lost = result.of(problem, status="failed")
        if not rows:
            continue
        off = np.array([abs(row["value"] / row["exact"] - 1) for row in rows])
        text = f"{words[0].upper()}{words[1:]}, {len(rows) + len(lost)} pairs of gains: simulated and exact differ by "
        text += f"{100 * np.median(off):.2g} % in the median, {100 * off.max():.2g} % at most"
        if problem.startswith("growth"):
            wrong = [row for row in rows if (row["value"] < 1) != (row["exact"] < 1)]
            farthest = max((abs(row["exact"] - 1) for row in wrong), default=0.0)
            text += f"; they disagree on stability {len(wrong)} times"
            text += f", there the exact factor is within {farthest:.2g} of 1" if wrong else ""
        else:
            wrong = sum(row["word"] != "grows" for row in lost) + sum(row["exact"] > 1e8 for row in rows)
            text += f"; they disagree on stability {wrong} times"
        sentences.append(text + ".")
    return " ".join(sentences)
