"""Several runs in one picture: how far off each was, with what torques and limits, and how long its
steps took.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from ..style import COLOURS, INK, finish, largest_of, readable

if TYPE_CHECKING:
    from ...simulation.comparison import Comparison


def comparison(compared: Comparison) -> Figure:
    """Figure of a Comparison: errors, both motors' torques with their time at the limit, solve
    times where there are.

    Later runs are drawn thinner, so that one under another is seen.
    """
    runs = compared.runs
    styles = {
        name: dict(color=COLOURS[k % len(COLOURS)], lw=1.2 + 1.8 * (1 - (k + 1) / len(runs)))
        for k, name in enumerate(runs)
    }
    logs = {name: run.log for name, run in runs.items() if getattr(run, "log", None) is not None}
    figure = Figure(figsize=(12, 7.5), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    above = figure.add_subplot(grid[0, 0] if logs else grid[0, :])
    _errors(above, compared, styles)
    for motor, side in enumerate(("left", "right")):
        _torques(figure.add_subplot(grid[1, motor], sharex=above), runs, styles, motor, side)
    if logs:
        _solve_times(figure.add_subplot(grid[0, 1]), logs, styles)
    return figure


def _errors(axes, compared, styles):
    for name, run in compared.runs.items():
        size, rms = np.linalg.norm(run.error, axis=1), compared.figures[name]["rms_error_m"]
        scale, unit = readable(rms, "m")
        # In powers of ten; a nanometre is finer than any robot.
        axes.semilogy(
            run.t,
            1e6 * np.maximum(size, 1e-9),
            **styles[name],
            label=f"{name}, RMS {scale * rms:.3g} {unit}",
        )
    axes.margins(x=0)
    title = "tracking error of the end-effector"
    finish(axes, 3, xlabel="time (s)", ylabel="distance from reference (µm)", title=title)


def _torques(axes, runs, styles, motor, side):
    words = next(iter(runs.values())).robot.words
    scale, unit = readable(max(largest_of(run.tau) for run in runs.values()), words.effort_unit)
    for name, run in runs.items():
        label = name
        if run.torque_limit is not None:
            full = run.saturated[:-1, motor]
            label += f", at the limit {np.diff(run.t)[full].sum():.2f} s"
        axes.step(run.t, scale * run.tau[:, motor], where="post", **styles[name], label=label)
    for limit in sorted({run.torque_limit for run in runs.values()} - {None}):
        for sign in (-1, 1):
            axes.axhline(sign * scale * limit, color=INK, lw=1, ls=":")
    axes.margins(x=0)
    finish(axes, 3, xlabel="time (s)", ylabel=f"{words.effort} ({unit})", title=f"{side} motor")


def _solve_times(axes, logs, styles):
    times = {name: 1e6 * log.solve_time for name, log in logs.items()}
    together = np.concatenate(list(times.values()))
    bins = np.geomspace(together.min(), together.max() * 1.001, 60)
    for name, us in times.items():
        colour, median, slow = styles[name]["color"], np.median(us), np.percentile(us, 99)
        axes.hist(us, bins, color=colour, alpha=0.6, label=f"{name}, {len(us)} steps")
        axes.axvline(median, color=colour, lw=1.4, label=f"median {median:.0f} µs")
        axes.axvline(slow, color=colour, lw=1.4, ls="--", label=f"99 % below {slow:.0f} µs")
    axes.set_xscale("log")
    for axis in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        axis(LogFormatter(labelOnlyBase=False, minor_thresholds=(1.5, 0.5)))
    finish(axes, 3, xlabel="time of a control step (µs)", ylabel="steps", title="solve time")
