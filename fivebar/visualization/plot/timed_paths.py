"""A timed path as a picture: the drawing in the colour of its speed, the phase plane, the torques
and their limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from ...singularities.margins import Singularity
from ..skeleton import robot_body
from ..style import INK, LEFT, RIGHT, finish, readable
from .maps import PALETTES
from .plans import LOCI, draw_loci, draw_torques
from .pose_panels import around, draw_robot

if TYPE_CHECKING:
    from ...paths.timing.timed_path import TimedPath

FINE = 12  # times on each stretch


def timed(motion: TimedPath) -> Figure:
    """Figure of a TimedPath."""
    figure = Figure(figsize=(12.5, 7.5), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.15))
    edges = motion.times
    inside = np.linspace(1e-9, 1 - 1e-9, FINE)
    t = (edges[:-1, None] + np.diff(edges)[:, None] * inside).ravel()
    _drawing(figure, figure.add_subplot(grid[:, 0]), motion, t)
    _phase_plane(figure.add_subplot(grid[0, 1]), motion, t)
    _torques(figure.add_subplot(grid[1, 1]), motion, t)
    return figure


def _drawing(figure, axes, motion, t):
    xi, xi_dot, _ = motion(t)
    pose = motion.accelerations(np.array([motion.times[0], motion.duration])).rates.pose
    body = robot_body(motion.robot, pose.elbows, pose.xi)
    draw_robot(axes, body, 0, alpha=0.35)
    low, high = around(np.concatenate([*body.points[[0]][:, body.joints], xi]))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    draw_loci(axes, motion.robot, motion.working, (low[1], high[1]))
    points = 1e3 * xi
    parts = np.stack([points[:-1], points[1:]], axis=1)
    drawn = motion.pen(t[:-1])
    speed = np.linalg.norm(xi_dot, axis=-1)[:-1]
    for down, width, alpha in ((True, 2.6, 1.0), (False, 1.0, 0.45)):
        if (drawn == down).any():
            style = dict(cmap=PALETTES["lines"], linewidths=width, alpha=alpha, zorder=3)
            lines = LineCollection(parts[drawn == down], **style)
            lines.set(array=speed[drawn == down], clim=(0, speed.max()), capstyle="round")
            axes.add_collection(lines)
            if down or not drawn.any():
                figure.colorbar(lines, ax=axes, location="top", shrink=0.8, label="speed (m/s)")
    if motion.crossing.any():
        places = 1e3 * motion.path(motion.s[motion.crossing])[0]
        axes.plot(
            *places.T,
            "x",
            color=INK,
            ms=9,
            mew=1.6,
            ls="none",
            zorder=5,
            label="crossing of Type 2",
        )
    axes.set_aspect("equal")
    finish(axes, 4, xlabel="x (mm)", ylabel="y (mm)", title="the path, with the robot at its start")


def _phase_plane(axes, motion, t):
    k, gone, speed, _ = motion.along(t)
    s = motion.path.knots[motion.piece[k]] + motion.first[k] + gone
    scale, unit = readable(motion.path.length, "m")
    with np.errstate(invalid="ignore"):
        beside = (
            motion.crossing | np.roll(motion.crossing, 1) | np.roll(motion.crossing, -1)
        )  # there it is not known
        top = np.sqrt(np.where(np.isfinite(motion.cap) & ~beside, motion.cap, np.nan))
        above = np.sqrt(motion.ceiling)
    axes.plot(scale * s, speed, color=LEFT, lw=1.8, label="the motion", zorder=3)
    axes.plot(
        scale * motion.s, above, color=INK, lw=0.9, ls=":", label="no motion is above", zorder=4
    )
    axes.plot(scale * motion.s, top, color=RIGHT, lw=1.1, label="maximum velocity curve", zorder=2)
    for place in motion.s[motion.crossing]:
        axes.axvline(
            scale * place, **LOCI[Singularity.PARALLEL] | dict(label=None, lw=0.8, color=INK)
        )
    axes.set_ylim(0, 1.6 * speed.max())
    axes.margins(x=0)
    proved = f", proved: none below {motion.lower_bound:.6g} s" if motion.lower_bound else ""
    title = f"{motion.duration:.6g} s{proved} ({len(motion.bent)} stretches)"
    finish(axes, 3, xlabel=f"s ({unit})", ylabel="ds/dt (m/s)", title=title)


def _torques(axes, motion, t):
    own = motion.robot.words
    unit = draw_torques(axes, own, t, motion.tau(t), motion.limits, "limit")
    for place in motion.times[motion.crossing]:
        axes.axvline(place, **LOCI[Singularity.PARALLEL] | dict(label=None, lw=0.8, color=INK))
    axes.margins(x=0)
    finish(axes, 3, xlabel="time (s)", ylabel=f"{own.effort} ({unit})", title=f"{own.effort}s")
