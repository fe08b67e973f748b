"""Several runs in one picture: how far off each was, with what torques and limits, and how long its
steps took; maps of several designs side by side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogFormatter

from ...singularities.maps import singularity_map
from ..style import COLOURS, SIDES, field_scale, largest_of, length_unit, readable
from .designs import quantity
from .maps import MapPicture
from .panels import draw, draw_level, finish, over_time
from .sheets import Sheet, small_letters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...optimal_design.comparison import DesignComparison
    from ...simulation.comparison import Comparison


def draw_comparison(compared: Comparison, sheet: Sheet) -> Figure:
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
    over_t = ["errors", "left motor", "right motor"]
    rows = [["errors", "solve time" if logs else "errors"], over_t[1:]]
    figure, (top, *others) = sheet.mosaic(rows, (12, 7.5), over_t)
    _errors(top, compared, styles)
    for motor, (axes, (side, _)) in enumerate(zip(others[-2:], SIDES)):
        ylabel = _torques(axes, list(runs.values()), styles, motor)
        over_time(axes, 3, ylabel, f"{side} motor")
    if logs:
        colours = {style["label"]: style["color"] for style in styles}
        _solve_times(others[0], logs, colours)
    return figure


def draw_designs(compared: DesignComparison, sheet: Sheet, field: str = "parallel") -> Figure:
    """Draw the maps of a DesignComparison in the task's modes, to one scale, under their figures.

    field: of `fb.singularity_map`.
    """
    robots = compared.robots
    ends = [singularity_map(robot, field, shape=(21, 21)) for robot in robots.values()]
    corners = np.array([(data.x[0], data.x[-1], data.y[0], data.y[-1]) for data in ends])
    low, high = corners.min(axis=0), corners.max(axis=0)
    window = low[0], high[1], low[2], high[3]
    maps = [singularity_map(robot, field, window=window) for robot in robots.values()]
    colours = max(map(field_scale, maps), key=lambda scale: scale.high)
    kinds: dict[str, None] = {}
    _, unit = length_unit(*robots.values())
    pictures = [MapPicture(data, colours, unit, kinds=kinds) for data in maps]
    quantities = {}
    for of in compared.of:
        row = np.array([compared.figures[name][of.name] for name in robots])
        quantities[of.name] = quantity(of.name, row, of.unit)
    figure, panels = sheet.grid(list(robots), 3, 4.0, pictures[0].shape)
    for axes, name, picture in zip(panels, robots, pictures):
        picture.draw(axes, compared.task.working)
        own = compared.figures[name]
        lines = [of.value(own[each]).replace("nan", "-") for each, of in quantities.items()]
        axes.set_title("\n".join([name, *lines]), fontsize=small_letters())
    pictures[0].finish(figure, panels, sheet, len(quantities))
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
