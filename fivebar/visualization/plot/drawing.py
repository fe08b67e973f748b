"""What a robot's pen drew, beside what was asked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from ...models.geometry import igm
from ..skeleton import pose_body
from ..style import GUIDE, INK, REFERENCE, finish, readable
from .maps import PALETTES
from .plans import draw_loci
from .pose_panels import draw_robot

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ...paths.curve import Path

WIDTH = 12.0  # in


def drawing(
    robot: Robot,
    working: tuple[int, int],
    asked: Sequence[np.ndarray],
    drawn: Sequence[np.ndarray],
    errors: Sequence[np.ndarray],
    title: str = "",
) -> Figure:
    """Figure of strokes asked for and drawn, lists of (n, 2) m, with errors, (n,) m, of what was
    drawn.

    Left the robot where it begins, with its singularities in these working modes; right the
    strokes, those drawn in the colour of their error.
    """
    everything = np.concatenate([*asked, *drawn])
    low, high = everything.min(axis=0), everything.max(axis=0)
    pad = 0.06 * float((high - low).max())
    shape = float((high - low + 2 * pad)[1] / (high - low + 2 * pad)[0])
    figure = Figure(
        figsize=(WIDTH, min(max(0.62 * WIDTH * 2 * shape + 1.6, 5.0), 11.0)), layout="constrained"
    )
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.55))
    _place(figure.add_subplot(grid[:, 0]), robot, working, asked)
    above, below = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    for stroke in asked:
        above.plot(*(1e3 * stroke.T), color=REFERENCE, lw=1.6, solid_capstyle="round")
    largest = max((float(each.max()) for each in errors), default=0.0)
    scale, unit = readable(largest, "m")
    segments, colours = [], []
    for stroke, error in zip(drawn, errors):
        points = 1e3 * stroke
        segments += list(np.stack([points[:-1], points[1:]], axis=1))
        colours.append(scale * np.maximum(error[:-1], error[1:]))
    lines = LineCollection(segments, cmap=PALETTES["lines"].reversed(), lw=1.8, capstyle="round")
    if colours:
        lines.set_array(np.concatenate(colours))
        lines.set_clim(0.0, scale * largest or 1.0)
    below.add_collection(lines)
    figure.colorbar(lines, ax=below, label=f"error ({unit})", fraction=0.05, pad=0.02)
    for axes, words in (
        (above, "asked"),
        (below, f"drawn by the simulated robot, at most {scale * largest:.3g} {unit} off"),
    ):
        axes.set(
            xlim=1e3 * np.array([low[0] - pad, high[0] + pad]),
            ylim=1e3 * np.array([low[1] - pad, high[1] + pad]),
        )
        axes.set_aspect("equal")
        axes.grid(alpha=0.25)
        axes.set(xlabel="x (mm)", ylabel="y (mm)", title=words)
    if title:
        figure.suptitle(title)
    return figure


def path_picture(path: Path) -> Figure:
    """Draw a Path: strokes, dotted lines where the pen is up, and the points of rest."""
    piece, share = np.meshgrid(np.arange(len(path.pieces)), np.linspace(0, 1, 33), indexing="ij")
    lengths = np.array([each.length for each in path.pieces])
    pieces = path.on(piece, share * lengths[:, None])[0]
    rests = path(np.array([stop.s for stop in path.stops]))[0]
    pen = np.array(path.pen)
    wide, high = np.maximum(np.ptp(pieces.reshape(-1, 2), axis=0), 1e-12)
    figure = Figure(figsize=(7, min(max(7 * high / wide, 1.5), 7) + 1.2), layout="constrained")
    axes = figure.add_subplot()
    for down, style in (
        (True, dict(color=REFERENCE, lw=1.6)),
        (False, dict(color=INK, lw=0.8, ls=(0, (1, 2)))),
    ):
        label = "pen down" if down else "pen up"
        axes.add_collection(
            LineCollection(
                1e3 * pieces[pen == down], label=label if (pen == down).any() else None, **style
            )
        )
    axes.plot(*(1e3 * rests.T), "o", color=INK, ms=3, ls="none", label="rests")
    axes.autoscale()
    axes.set_aspect("equal")
    finish(axes, 3, xlabel="x (mm)", ylabel="y (mm)")
    return figure


def _place(axes, robot, working, asked):
    start = igm(robot, asked[0][0], working)
    draw_robot(axes, pose_body([start]), 0)
    for stroke in asked:
        axes.plot(*(1e3 * stroke.T), color=REFERENCE, lw=1.0, zorder=5)
    draw_loci(axes, robot, tuple(working))
    axes.plot(
        *(1e3 * start.xi), "o", color=INK, mfc=GUIDE, ms=5, zorder=6, label="pen, where it begins"
    )
    axes.set_aspect("equal")
    signs = ", ".join(f"{sign:+d}" for sign in working).replace("-", "−")
    finish(
        axes, 3, xlabel="x (mm)", ylabel="y (mm)", title=f"the robot, in working modes ({signs})"
    )
