"""Several runs in one picture: how far off each was, with what torques and limits, and how long its
steps took; maps of several designs side by side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogFormatter

from ...singularities.maps import singularity_map
from ..style import COLOURS, SIDES, largest_of, readable
from .maps import singularity_map as draw_map
from .panels import draw, draw_level, finish, new_figure, new_panels, over_time

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...optimal_design.comparison import DesignComparison
    from ...simulation.comparison import Comparison


def draw_comparison(compared: Comparison) -> Figure:
    """Draw a Comparison: errors, both motors' torques with their time at the limit, solve times
    where there are.

    Later runs are drawn thinner, so that one under another is seen.
    """
    runs = compared.runs
    widths = np.linspace(3.0, 1.2, len(runs) + 1)[1:]
    styles = [
        dict(color=COLOURS[k % len(COLOURS)], lw=width, label=name)
        for k, (name, width) in enumerate(zip(runs, widths))
    ]
    logs = {name: run.log for name, run in runs.items() if getattr(run, "log", None) is not None}
    figure = new_figure(12, 7.5)
    grid = figure.add_gridspec(2, 2)
    top = figure.add_subplot(grid[0, 0] if logs else grid[0, :])
    _errors(top, compared, styles)
    for motor, (side, _) in enumerate(SIDES):
        axes = figure.add_subplot(grid[1, motor], sharex=top)
        ylabel = _torques(axes, list(runs.values()), styles, motor)
        over_time(axes, 3, ylabel, f"{side} motor")
    if logs:
        colours = {style["label"]: style["color"] for style in styles}
        _solve_times(figure.add_subplot(grid[0, 1]), logs, colours)
    return figure


def draw_designs(compared: DesignComparison, field: str = "parallel") -> Figure:
    """Draw the maps of a DesignComparison in the task's modes, to one scale, over their figures.

    field: of `fb.singularity_map`.
    """
    robots, modes = compared.robots, [compared.task.working]
    ends = [singularity_map(robot, field, shape=(21, 21)) for robot in robots.values()]
    corners = np.array([(data.x[0], data.x[-1], data.y[0], data.y[-1]) for data in ends])
    low, high = corners.min(axis=0), corners.max(axis=0)
    window = low[0], high[1], low[2], high[3]
    height = 4.4 * (window[3] - window[2]) / (window[1] - window[0]) + 0.2 * len(compared.of)
    figure, panels = new_panels(None, len(robots), 3, 4.4, height)
    for axes, (name, robot) in zip(panels, robots.items()):
        draw_map(singularity_map(robot, field, window=window), modes=modes, axes=axes)
        lines = (f"{of.label}: {compared.words(name, of)}" for of in compared.of)
        axes.set_title(name)
        axes.set_xlabel("\n".join(["x (mm)", *lines]))
    return figure


def _errors(axes, compared, styles):
    for (name, run), style in zip(compared.runs.items(), styles):
        rms = compared.figures[name]["rms_error_m"]
        scale, unit = readable(rms, "m")
        # In powers of ten; a nanometre is finer than any robot.
        size = 1e6 * np.maximum(np.linalg.norm(run.error, axis=1), 1e-9)
        label = f"{name}, RMS {scale * rms:.3g} {unit}"
        axes.semilogy(run.t, size, **style | {"label": label})
    title = "tracking error of the end-effector"
    over_time(axes, 3, "distance from reference (µm)", title)


def _torques(axes, runs, styles, motor):
    words = runs[0].robot.words
    scale, unit = readable(max(largest_of(run.tau) for run in runs), words.effort_unit)
    for run, style in zip(runs, styles):
        if run.torque_limit is not None:
            time = np.diff(run.t)[run.saturated[:-1, motor]].sum()
            style = style | {"label": f"{style['label']}, at the limit {time:.2f} s"}
        draw(axes, "line.step", run.t, scale * run.tau[:, motor], **style)
    for limit in {run.largest_torque for run in runs} - {None}:
        draw_level(axes, "line.limit", scale * limit, -scale * limit)
    return f"{words.effort} ({unit})"


def _solve_times(axes, logs, colours):
    times = {name: 1e6 * log.solve_time for name, log in logs.items()}
    together = np.concatenate(list(times.values()))
    bins = np.geomspace(together.min(), together.max() * 1.001, 60)
    for name, us in times.items():
        style = dict(color=colours[name], lw=1.4)
        median, slow = np.percentile(us, (50, 99))
        axes.hist(us, bins, color=colours[name], alpha=0.6, label=f"{name}, {len(us)} steps")
        axes.axvline(median, label=f"median {median:.0f} µs", **style)
        axes.axvline(slow, ls="--", label=f"99 % below {slow:.0f} µs", **style)
    axes.set_xscale("log")
    for set_formatter in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        set_formatter(LogFormatter(labelOnlyBase=False, minor_thresholds=(1.5, 0.5)))
    finish(axes, 3, xlabel="time of a control step (µs)", ylabel="steps", title="solve time")
