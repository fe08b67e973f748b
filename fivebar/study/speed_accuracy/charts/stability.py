"""Sampled computed torque over the plane of its gains: growth, and its exact limits."""

from __future__ import annotations

import time

import numpy as np
from matplotlib.figure import Figure

from ....models.robots import FiveBar
from ....visualization.style import INK, NO_VALUE
from ...pitfalls.sampled import growth, spectral_radius
from ..chart import OURS, Attempt, Chart, Method, Panel
from ..store import Result

ROBOT = FiveBar()
SIDE = 28  # points of a side of the grid; even: every other point is every other row of it
PROBLEMS = "no delay", "one sample of delay"
WINDOWS = {"no delay": (4.5, 2.45), "one sample of delay": (0.3, 1.1)}  # largest Kp h^2, Kd h
FINE = 121  # exact values on a side


def gains(problem: str, index: int) -> tuple[float, float]:
    """Return (Kp h^2, Kd h) of a point, in the middle of a cell of the problem's grid."""
    row, column = divmod(int(index), SIDE)
    width, height = WINDOWS[problem]
    return width * (row + 0.5) / SIDE, height * (column + 0.5) / SIDE


def simulated(problem: str, index: int) -> Attempt:
    """Prepare one run at one pair of gains, whose time is that of its only call."""
    p, q = gains(problem, index)
    delay = PROBLEMS.index(problem)
    times = []

    def call():
        before = time.perf_counter()
        value = growth(ROBOT, p, q, delay)
        times.append(time.perf_counter() - before)
        return value

    def judge(value):
        return {"p": p, "q": q, "growth": value, "exact": spectral_radius(p, q, delay)}

    return Attempt(call, judge, times=lambda: np.array(times))


def figure(result: Result) -> Figure:
    """Return maps of the simulated growth in colour, with the exact one as lines."""
    made = Figure(figsize=(12, 5), layout="constrained")
    for axes, panel in zip(made.subplots(1, 2), result.chart.all_panels):
        corner = WINDOWS[panel.problem]
        delay = PROBLEMS.index(panel.problem)
        values = np.full((SIDE, SIDE), np.nan)
        for row in result.of(panel.problem):
            values.flat[int(row["knob"])] = row["growth"]
        measured = slice(None, None, 2 if result.about["quick"] else 1)
        reach = (1.0, 0.3)[delay]
        colours = {"cmap": "PuOr_r", "vmin": 1 - reach, "vmax": 1 + reach}
        p, q = (high * np.arange(0.5, SIDE) / SIDE for high in corner)
        image = axes.pcolormesh(p, q[measured], values.T[measured], **colours)
        top = q[measured][-1] + q[0]
        axes.set(facecolor=NO_VALUE, xlim=(0, corner[0]), ylim=(0, top))
        made.colorbar(image, ax=axes, extend="max", label="growth per sample, simulated")
        p, q = (np.linspace(1e-6, high, FINE) for high in corner)
        exact = np.vectorize(spectral_radius)(*np.meshgrid(p, q), delay)
        lines = axes.contour(p, q, exact, [0.5, 0.8, 1.0], colors=[INK], linewidths=1.1)
        axes.clabel(lines, fontsize=7.5, fmt="%g")
        axes.set(xlabel="Kp h² (no unit)", ylabel="Kd h (no unit)", title=panel.title)
    return made


def summary(result: Result) -> tuple[str, list]:
    """Return how far the simulated robot is from the exact growth, in a sentence and a table."""
    cells = []
    for problem in PROBLEMS:
        pairs = np.array([(row["growth"], row["exact"]) for row in result.of(problem)])
        wrong = ((pairs[:, 0] < 1) != (pairs[:, 1] < 1)).sum()
        percent = 100 * np.abs(pairs[:, 0] / pairs[:, 1] - 1)
        numbers = f"{np.median(percent):.2g}", f"{percent.max():.2g}"
        cells.append([problem, f"{wrong} of {len(pairs)}", *numbers])
    caption = "; ".join(
        f"{problem}: on {wrong} pairs of gains simulated and exact disagree about stability, and"
        f" they differ by {median} % in the median"
        for problem, wrong, median, _ in cells
    )
    head = ["problem", "disagree about stability", "differ by, median (%)", "at most (%)"]
    return f"{caption.capitalize()}.", [("Simulated against exact", head, cells)]


def chart() -> Chart:
    """Return the chart of gains."""
    return Chart(
        name="stability",
        title=(
            "Which gains of sampled computed torque hold the robot: simulated (colour) over exact"
            " (lines)"
        ),
        reading=(
            "Each point of the plane is a pair of gains, h the period, 10 ms. The colour is how a"
            " disturbance of 1e-7 rad on the simulated robot grows or shrinks from sample to"
            " sample; lines: where the exact factor is 0.5, 0.8 and 1."
        ),
        problems={problem: problem for problem in PROBLEMS},
        methods=(Method("simulated robot", OURS, simulated, tuple(range(SIDE * SIDE))),),
        panels=(tuple(Panel(problem, problem, y="growth") for problem in PROBLEMS),),
        figure=figure,
        summary=summary,
    )
