"""Sampled computed torque over the plane of its gains: growth of a disturbance, gain of noise."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ....models.robots import FiveBar
from ....visualization.style import INK
from ...pitfalls.sampled import exact_noise_gain, growth, noise_gain, spectral_radius
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel

if TYPE_CHECKING:
    from ..store import Result

ROBOT = FiveBar()
SIDES = {"growth": 29, "noise": 15}  # points of a side; odd: every other point is a chessboard
WINDOWS = {0: (4.5, 2.45), 1: (0.3, 1.1)}  # Kp h^2 and Kd h up to these, by samples of delay
NEVER = 1e9  # for the gain of noise where nothing is stable
KINDS = {
    "growth": ("growth per sample", growth, spectral_radius),
    "noise": ("gain of measurement noise", noise_gain, exact_noise_gain),
}
DELAYS = "no delay", "one sample of delay"
PROBLEMS = {
    f"{kind}-{delay}": f"{words}: {what}"
    for kind, (what, *_) in KINDS.items()
    for delay, words in enumerate(DELAYS)
}
FINE = 121  # exact values on a side


def parts(problem: str) -> tuple[str, int]:
    """Return kind and delay of a problem."""
    kind, delay = problem.split("-")
    return kind, int(delay)


def gains(problem: str, index: int) -> tuple[float, float]:
    """Return (Kp h^2, Kd h) of a point, in the middle of a cell of the problem's grid."""
    kind, delay = parts(problem)
    side = SIDES[kind]
    row, column = divmod(int(index), side)
    width, height = WINDOWS[delay]
    return width * (row + 0.5) / side, height * (column + 0.5) / side


def simulated(problem: str, index: int) -> Attempt:
    """Prepare one run at one pair of gains, whose time is that of its only call."""
    kind, delay = parts(problem)
    _, measure, exact = KINDS[kind]
    p, q = gains(problem, index)
    times = []

    def call():
        before = time.perf_counter()
        value = measure(ROBOT, p, q, delay)
        times.append(time.perf_counter() - before)
        return value

    def judge(value):
        expected, radius = exact(p, q, delay), spectral_radius(p, q, delay)
        if np.isinf(value):
            raise Failed("grows" if np.isinf(expected) else "grows where it should not")
        return {"p": p, "q": q, "value": value, "exact": min(expected, NEVER), "radius": radius}

    return Attempt(call, judge, times=lambda: np.array(times))


def figure(result: Result) -> Figure:
    """Return maps of the simulated values in colour, the exact limits on them."""
    made = Figure(figsize=(12, 8), layout="constrained")
    for axes, panel in zip(made.subplots(2, 2).flat, result.chart.all_panels):
        kind, delay = parts(panel.problem)
        side, corner = SIDES[kind], WINDOWS[delay]
        values = np.full(side * side, np.nan)
        for row in result.of(panel.problem):
            values[int(row["knob"])] = row["value"]
        reach = (1.0, 0.3)[delay]
        colours = {"cmap": "PuOr_r", "vmin": 1 - reach, "vmax": 1 + reach}
        if kind == "noise":
            colours = {"cmap": "cividis_r", "vmin": 1.0, "vmax": 6.0}
        edges = [np.linspace(0, high, side + 1) for high in corner]
        image = axes.pcolormesh(*edges, values.reshape(side, side).T, **colours)
        made.colorbar(image, ax=axes, extend="max", label=f"{KINDS[kind][0]}, simulated")
        lost = [gains(panel.problem, r["knob"]) for r in result.of(panel.problem, status="failed")]
        axes.plot(*np.reshape(lost, (-1, 2)).T, "x", color="#999999", ms=4)
        p, q = (np.linspace(1e-6, high, FINE) for high in corner)
        exact = np.vectorize(KINDS[kind][2])(*np.meshgrid(p, q), delay)
        levels = [0.5, 0.8, 1.0] if kind == "growth" else [1.5, 2.0, 3.0, 5.0, 90.0]
        lines = axes.contour(p, q, np.minimum(exact, 99.0), levels, colors=[INK], linewidths=1.1)
        axes.clabel(lines, levels[:-1], fontsize=7.5, fmt="%g")
        axes.set(xlabel="Kp h² (no unit)", ylabel="Kd h (no unit)", title=panel.title)
    return made


def summary(result: Result) -> tuple[str, list]:
    """Return how far the simulated robot is from the exact values, in a sentence and a table."""
    rows = []
    for problem, words in PROBLEMS.items():
        values, failed = result.of(problem), result.of(problem, status="failed")
        # A run with noise that comes to its end has not grown.
        grows = [row["value"] > 1 and problem.startswith("growth") for row in values]
        wrong = sum(grown != (row["radius"] > 1) for grown, row in zip(grows, values))
        wrong += sum(row["word"] != "grows" for row in failed)
        off = [100 * abs(r["value"] / r["exact"] - 1) for r in values if r["exact"] < NEVER]
        rows.append([words, wrong, len(values) + len(failed), np.median(off), max(off)])
    _, wrong, total, medians, _ = zip(*rows)
    caption = (
        f"On {sum(wrong)} of {sum(total)} pairs of gains simulated and exact disagree about"
        f" stability; the values differ by at most {max(medians):.2g} % in the median of a map."
    )
    head = ["problem", "disagree", "pairs of gains", "values differ by, median (%)", "at most (%)"]
    cells = [
        [f"{cell:.2g}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows
    ]
    return caption, [("Simulated against exact", head, cells)]


def chart() -> Chart:
    """Return the chart of gains."""
    knobs = {problem: tuple(range(SIDES[parts(problem)[0]] ** 2)) for problem in PROBLEMS}
    return Chart(
        name="stability",
        title=(
            "Which gains of sampled computed torque hold the robot: simulated (colour) over exact"
            " (lines)"
        ),
        reading=(
            "Each point of the plane is a pair of gains, h the period, 10 ms. Above: how a"
            " disturbance of 1e-7 rad on the simulated robot grows or shrinks from sample to"
            " sample; lines: where the exact factor is 0.5, 0.8 and 1."
            " Below: how much of the measurement's noise comes out in the angles; lines: exact"
            " gains; crosses: it does not hold."
        ),
        problems=PROBLEMS,
        methods=(Method("simulated robot", OURS, simulated, knobs),),
        panels=(tuple(Panel(problem, words, y="value") for problem, words in PROBLEMS.items()),),
        figure=figure,
        summary=summary,
    )
