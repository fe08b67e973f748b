"""A run and its simulation: both paths, both motors' torques, and how far apart they were."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..style import SIDES, readable
from .panels import draw, draw_measured, draw_points, over_time, plane
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.logs.replays import Replay


def draw_replay(replay: Replay, sheet: Sheet) -> Figure:
    """Draw a Replay."""
    measured, simulated = replay.measured, replay.simulated
    over_t = "difference", "left motor", "right motor"
    rows = [["path", name] for name in over_t]
    figure, (path, top, *motors) = sheet.mosaic(rows, (12, 7), over_t, width_ratios=(1, 1.2))
    draw_points(path, "path.measured", measured.xi)
    draw_points(path, "path.simulated", simulated.xi)
    plane(path, 2, "end-effector")
    path.set_aspect("equal", adjustable="datalim")
    size = np.hypot(*replay.difference.T)
    scale, unit = readable(np.nanmax(size), "m")
    draw(top, "line.distance", measured.t, scale * size)
    title = f"difference: {scale * replay.figures['rms_error_m']:.3g} {unit} rms"
    over_time(top, 1, f"distance ({unit})", title, last=False)
    tau = np.array([measured.tau, simulated.tau])
    words = measured.robot.words
    for k, (axes, (side, colour)) in enumerate(zip(motors, SIDES)):
        ylabel = draw_measured(axes, measured.t, tau[..., k], words, colour, "simulated")
        over_time(axes, 3, ylabel, f"{side} motor", last=k == 1)
    return figure
