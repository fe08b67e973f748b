"""A simulated run as a picture: path against reference, the errors themselves, torques and their
limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..skeleton import run_body
from ..style import LEFT, PALE, RIGHT, SIDES, largest_of, readable, robot_title
from .panels import STYLES, draw, draw_level, draw_points, draw_robot, note, over_time, plane
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...simulation.run import Run


def draw_run(run: Run, sheet: Sheet) -> Figure:
    """Draw a run: where it went, how far off it was (RMS and largest), and with what torques."""
    if not len(run.t):
        raise ValueError("a run without samples cannot be drawn")
    right = ["torques"] if run.xi_ref is None else ["error", "torques"]
    rows = [["path", name] for name in right]
    figure, (path, *errors, torques) = sheet.mosaic(rows, (12, 6), right, width_ratios=(1, 1.1))
    if sheet.axes is None:
        figure.suptitle(robot_title(run.robot))
    _path(path, run)
    for axes in errors:
        _errors(axes, run)
    _torques(torques, run)
    return figure


def _path(axes, run):
    body = run_body(run)
    draw_robot(axes, body, 0, alpha=0.35)
    draw_robot(axes, body, -1)
    if run.xi_ref is not None:
        draw_points(axes, "path.reference", run.drawn_ref)
    draw_points(axes, "path.end-effector", run.drawn, label=_tip(run))
    for event in run.events:
        place = np.array([np.interp(event.t, run.t, column) for column in run.drawn.T])
        draw_points(axes, "mark.event", place)
        note(axes, f"Type {int(event.type)}", place)
    plane(axes, 2, "path, with the robot at start (pale) and end")


def _tip(run):
    return "end-effector" if run.tool is None else "tool"


def _errors(axes, run):
    size = np.linalg.norm(run.error, axis=1)
    known = size[np.isfinite(size)]  # not in the gaps of a log
    if not len(known):
        raise ValueError("a run whose error is nowhere known cannot be drawn")
    largest = known.max()
    rms = np.sqrt(np.mean(known**2))
    scale, unit = readable(largest, "m")
    for name, error, colour in zip("xy", run.error.T, (LEFT, RIGHT)):
        draw(axes, "line.thin", run.t, scale * error, color=colour, label=name)
    draw(axes, "line.distance", run.t, scale * size)
    draw_level(axes, "line.rms", scale * rms, label=f"RMS {scale * rms:.3g} {unit}")
    label = f"maximum {scale * largest:.3g} {unit}"
    draw(axes, "mark.peak", run.t[np.nanargmax(size)], scale * largest, label=label)
    _crossings(axes, run)
    title = f"tracking error of the {_tip(run)}"
    over_time(axes, 5, f"error ({unit})", title, last=False)


def _torques(axes, run):
    words = run.robot.words
    scale, unit = readable(largest_of(run.tau), words.effort_unit)
    for (name, colour), tau in zip(SIDES, run.tau.T):
        draw(axes, "line.step", run.t, scale * tau, color=colour, label=name)
    if run.torque_limit is not None:
        limit = scale * run.largest_torque
        draw_level(axes, "line.limit", limit, -limit, label="limit")
        saturated = run.saturated.any(axis=1)
        label = f"saturated, {100 * np.mean(saturated[:-1]):.0f} % of the time"
        area = dict(step="post", transform=axes.get_xaxis_transform(), color="0.85", zorder=0)
        axes.fill_between(run.t, 0, 1, where=saturated, label=label, **area)
    _crossings(axes, run)
    over_time(axes, 4, f"{words.effort} ({unit})", f"motor {words.effort}s")


def _crossings(axes, run):
    """When a singularity is crossed, on a panel over time."""
    words = dict(rotation=90, ha="right", va="top", fontsize=7, color=PALE)
    for event in run.events:
        axes.axvline(event.t, **STYLES["line.crossing"])
        kind = f"Type {int(event.type)}"
        axes.text(event.t, 0.98, kind, transform=axes.get_xaxis_transform(), **words)
