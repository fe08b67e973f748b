"""A timed path as a picture: the drawing in the colour of its speed, the phase plane, the torques
and their limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection

from ...singularities.margins import Singularity
from ..skeleton import robot_body
from ..style import readable
from .panels import (
    PALETTES,
    draw,
    draw_loci_of,
    draw_points,
    draw_robot,
    draw_torques,
    finish,
    mark_crossing,
    over_time,
    plane,
    set_window,
)
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...paths.timing.timed_path import TimedPath

FINE = 12  # times on each stretch


def draw_timed_path(motion: TimedPath, sheet: Sheet) -> Figure:
    """Draw a TimedPath."""
    rows = [["path", "phase plane"], ["path", "torques"]]
    figure, (path, plane_of_speed, axes) = sheet.mosaic(rows, (12.5, 7.5), width_ratios=(1, 1.15))
    inside = np.linspace(1e-9, 1 - 1e-9, FINE)
    t = (motion.times[:-1, None] + np.diff(motion.times)[:, None] * inside).ravel()
    _drawing(path, motion, t)
    _phase_plane(plane_of_speed, motion, t)
    words = motion.robot.words
    ylabel = draw_torques(axes, words, t, motion.torques(t), motion.limits, "limit")
    for time in motion.times[motion.crossing]:
        mark_crossing(axes, time, Singularity.PARALLEL)
    over_time(axes, 3, ylabel, f"{words.effort}s")
    return figure


def _drawing(axes, motion, t):
    k, way, speed, _ = motion.along(t)
    drawn, drawn_s, *_ = motion.path.drawn.on(motion.piece[k], motion.first[k] + way)
    pose = motion.accelerations(np.array([motion.times[0], motion.duration])).rates.pose
    body = robot_body(motion.robot, pose.elbows, pose.xi, motion.tool)
    draw_robot(axes, body, 0, alpha=0.35)
    ends = set_window(axes, np.concatenate([body.points[0, body.joints], drawn]))
    tool = None if motion.path.tool is None else motion.path.tool.tool
    draw_loci_of(axes, motion.robot, motion.working, ends, tool)
    parts = 1e3 * np.stack([drawn[:-1], drawn[1:]], axis=1)
    pen_down = motion.pen(t[:-1])
    speed = (np.linalg.norm(drawn_s, axis=-1) * speed)[:-1]
    for down, width, alpha in ((True, 2.6, 1.0), (False, 1.0, 0.45)):
        now = pen_down == down
        if now.any():
            style = dict(cmap=PALETTES["lines"], linewidths=width, alpha=alpha, zorder=3)
            lines = LineCollection(parts[now], capstyle="round", **style)
            lines.set(array=speed[now], clim=(0, speed.max()))
            axes.add_collection(lines)
            if down or now.all():
                axes.figure.colorbar(
                    lines, ax=axes, location="top", shrink=0.8, label="speed (m/s)"
                )
    if motion.crossing.any():
        places = motion.path.drawn(motion.s[motion.crossing])[0]
        draw_points(axes, "mark.crossing", places, marker="x", label="crossing of Type 2")
    plane(axes, 4, "the path, with the robot at its start")


def _phase_plane(axes, motion, t):
    k, way, speed, _ = motion.along(t)
    s = motion.path.knots[motion.piece[k]] + motion.first[k] + way
    scale, unit = readable(motion.path.length, "m")
    crossing = motion.crossing
    # Next to a crossing the maximum velocity is not known.
    unknown = crossing | np.roll(crossing, 1) | np.roll(crossing, -1) | ~np.isfinite(motion.cap)
    with np.errstate(invalid="ignore"):
        cap = np.sqrt(np.where(unknown, np.nan, motion.cap))
        ceiling = np.sqrt(motion.ceiling)
    draw(axes, "line.speed", scale * s, speed)
    draw(axes, "line.ceiling", scale * motion.s, ceiling)
    draw(axes, "line.velocity-limit", scale * motion.s, cap)
    for place in motion.s[crossing]:
        mark_crossing(axes, scale * place, Singularity.PARALLEL)
    axes.set_ylim(0, 1.6 * speed.max())
    axes.margins(x=0)
    proved = f", proved: none below {motion.lower_bound:.6g} s" if motion.lower_bound else ""
    title = f"{motion.duration:.6g} s{proved} ({len(motion.bent)} stretches)"
    finish(axes, 3, xlabel=f"s ({unit})", ylabel="ds/dt (m/s)", title=title)
