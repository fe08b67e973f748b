"""A run and its simulation: both paths, both motors' torques, and how far apart they were."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..style import INK, LEFT, PATH, RIGHT, finish, readable

if TYPE_CHECKING:
    from ...estimation.logs.replays import Replay


def replayed(replay: Replay) -> Figure:
    """Figure of a Replay."""
    measured, simulated = replay.measured, replay.simulated
    figure = Figure(figsize=(12, 7), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.2))
    path = figure.add_subplot(grid[:, 0])
    path.plot(*(1e3 * measured.xi.T), color=INK, lw=2.4, alpha=0.6, label="measured")
    path.plot(*(1e3 * simulated.xi.T), color=PATH, lw=1.2, label="simulated")
    path.set_aspect("equal", adjustable="datalim")
    finish(
        path,
        2,
        xlabel="x (mm)",
        ylabel="y (mm)",
        title=f"end-effector; simulated by the {replay.by}",
    )
    apart = figure.add_subplot(grid[0, 1])
    size = np.hypot(*replay.difference.T)
    scale, unit = readable(np.nanmax(size), "m")
    apart.plot(measured.t, scale * size, color=INK, lw=1.2, label="distance")
    finish(
        apart,
        1,
        ylabel=f"apart ({unit})",
        title=f"difference: {scale * replay.figures['rms_error_m']:.3g} {unit} rms",
    )
    words = measured.robot.words
    both = np.concatenate([measured.tau, simulated.tau])
    scale, unit = readable(
        np.nanmax(np.abs(both)) if np.isfinite(both).any() else 1.0, words.effort_unit
    )
    for k, (side, colour) in enumerate((("left", LEFT), ("right", RIGHT))):
        axes = figure.add_subplot(grid[1 + k, 1], sharex=apart)
        axes.plot(
            measured.t, scale * measured.tau[:, k], color=INK, lw=2.0, alpha=0.5, label="measured"
        )
        axes.plot(measured.t, scale * simulated.tau[:, k], color=colour, lw=1.0, label="simulated")
        axes.plot(
            measured.t,
            scale * replay.tau_difference[:, k],
            color=INK,
            lw=0.7,
            ls=":",
            label="difference",
        )
        axes.margins(x=0)
        finish(
            axes,
            3,
            xlabel="time (s)" if k else "",
            ylabel=f"{words.effort} ({unit})",
            title=f"{side} motor",
        )
    return figure
