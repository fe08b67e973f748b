"""A simulated run as a picture: path against reference, the errors themselves, torques and their
limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..skeleton import run_body
from ..style import INK, LEFT, PALE, REFERENCE, RIGHT, finish, largest_of, readable, robot_title
from .pose_panels import draw_robot

if TYPE_CHECKING:
    from ...simulation.run import Run


def tracking(run: Run) -> Figure:
    """Figure of a run: where it went, how far off it was (RMS and largest), and with what
    torques.
    """
    if not len(run.t):
        raise ValueError("a run without samples cannot be drawn")
    figure = Figure(figsize=(12, 6), layout="constrained")
    figure.suptitle(robot_title(run.robot))
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.1))
    _path(figure.add_subplot(grid[:, 0]), run)
    if run.xi_ref is None:
        _torques(figure.add_subplot(grid[:, 1]), run)
    else:
        above = figure.add_subplot(grid[0, 1])
        _errors(above, run)
        _torques(figure.add_subplot(grid[1, 1], sharex=above), run)
    return figure


def _path(axes, run):
    body = run_body(run)
    draw_robot(axes, body, 0, alpha=0.35)
    draw_robot(axes, body, -1)
    if run.xi_ref is not None:
        axes.plot(
            *(1e3 * run.xi_ref.T), color=REFERENCE, lw=4, alpha=0.6, label="reference", zorder=3
        )
    axes.plot(*(1e3 * run.xi.T), color=INK, lw=1.2, label="end-effector", zorder=4)
    for event in run.events:
        where = [np.interp(event.t, run.t, 1e3 * run.xi[:, k]) for k in (0, 1)]
        axes.plot(*where, "x", color=INK, ms=7, zorder=5)
        axes.annotate(
            f"Type {int(event.type)}", where, textcoords="offset points", xytext=(6, 4), fontsize=8
        )
    axes.set_aspect("equal")
    finish(
        axes,
        2,
        xlabel="x (mm)",
        ylabel="y (mm)",
        title="path, with the robot at start (pale) and end",
    )


def _errors(axes, run):
    size = np.linalg.norm(run.error, axis=1)
    known = size[np.isfinite(size)]  # not in the gaps of a log
    if not len(known):
        raise ValueError("a run whose error is nowhere known cannot be drawn")
    largest, rms = known.max(), np.sqrt(np.mean(known**2))
    scale, unit = readable(largest, "m")
    for k, (name, colour) in enumerate((("x", LEFT), ("y", RIGHT))):
        axes.plot(run.t, scale * run.error[:, k], color=colour, lw=1.2, label=name)
    axes.plot(run.t, scale * size, color=INK, lw=1.6, label="distance")
    axes.axhline(scale * rms, color=INK, lw=1, ls="--", label=f"RMS {scale * rms:.3g} {unit}")
    peak = int(np.nanargmax(size))
    axes.plot(
        run.t[peak],
        scale * largest,
        "o",
        color=INK,
        ms=5,
        label=f"maximum {scale * largest:.3g} {unit}",
    )
    _crossings(axes, run)
    finish(axes, 5, ylabel=f"error ({unit})", title="tracking error of the end-effector")


def _torques(axes, run):
    words = run.robot.words
    scale, unit = readable(largest_of(run.tau), words.effort_unit)
    for k, (name, colour) in enumerate((("left", LEFT), ("right", RIGHT))):
        axes.step(run.t, scale * run.tau[:, k], where="post", color=colour, lw=1.2, label=name)
    if run.torque_limit is not None:
        for limit in (-run.torque_limit, run.torque_limit):
            axes.axhline(
                scale * limit, color=INK, lw=1, ls=":", label="limit" if limit > 0 else None
            )
        saturated = run.saturated.any(axis=1)
        axes.fill_between(
            run.t,
            0,
            1,
            where=saturated,
            step="post",
            transform=axes.get_xaxis_transform(),
            color="0.85",
            zorder=0,
            label=f"saturated, {100 * np.mean(saturated[:-1]):.0f} % of the time",
        )
    _crossings(axes, run)
    axes.margins(x=0)
    finish(
        axes,
        4,
        xlabel="time (s)",
        ylabel=f"{words.effort} ({unit})",
        title=f"motor {words.effort}s",
    )


def _crossings(axes, run):
    """When a singularity is crossed, on a panel over time."""
    for event in run.events:
        axes.axvline(event.t, color=PALE, lw=1, ls=(0, (4, 3)), zorder=0.5)
        words = dict(rotation=90, ha="right", va="top", fontsize=7, color=PALE)
        axes.text(
            event.t, 0.98, f"Type {int(event.type)}", transform=axes.get_xaxis_transform(), **words
        )
