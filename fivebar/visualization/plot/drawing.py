"""What a robot's pen drew, beside what was asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection

from ...models.geometry import igm
from ...paths.placement import Placement
from ..skeleton import pose_body
from ..style import INK, REFERENCE, readable, signs
from .panels import PALETTES, draw_loci_of, draw_points, draw_robot, plane
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...models.robots import Robot
    from ...paths.curve import Path
    from ...paths.tool import Tool

WIDTH = 12.0  # in


def drawing(
    robot: Robot,
    working: tuple[int, int],
    desired: Sequence[np.ndarray],
    drawn: Sequence[np.ndarray],
    errors: Sequence[np.ndarray],
    title: str = "",
    tool: Tool | None = None,
    by: str = "the simulated robot",
    page: np.ndarray | None = None,
    frame: Placement | None = None,
    axes: Any = None,
) -> Figure:
    """Return the figure of desired and drawn strokes, beside the robot where it begins.

    Parameters
    ----------
    robot, working
        The robot and its working modes, whose singularities are drawn.
    desired, drawn : sequence of (n, 2) arrays
        Strokes in m.
    errors : sequence of (n,) arrays
        Errors of what was drawn, m, shown by colour.
    title : str
        Text over the figure.
    tool : Tool, optional
        What draws, where that is not joint C.
    by : str
        What drew, in words.
    page : (5, 2) array, optional
        Corners of the sheet, m.
    frame : Placement, optional
        From the robot's frame to the one in which all is shown, that of the table.
    axes : sequence of Axes, optional
        Panels of a figure of one's own: of the robot, of the desired strokes and, where there
        are any, of the drawn ones; a new figure without.

    Returns
    -------
    Figure
        Left the robot; right the strokes, desired over drawn.

    Examples
    --------
    >>> import fivebar as fb
    >>> import numpy as np
    >>> stroke = np.array([(0.05, 0.09), (0.06, 0.09), (0.06, 0.1)])
    >>> figure = fb.plot.drawing(
    ...     fb.FiveBar(), (-1, -1), [stroke], [stroke + 1e-5], [np.full(3, 1.4e-5)]
    ... )
    >>> len(figure.axes)
    4
    """
    frame = Placement() if frame is None else frame
    strokes = desired
    desired = [frame(stroke) for stroke in desired]
    drawn = [frame(stroke) for stroke in drawn]
    sheet = [] if page is None else [frame(page)]
    points = 1e3 * np.concatenate([*desired, *drawn, *sheet])
    low = points.min(axis=0)
    high = points.max(axis=0)
    pad = 0.06 * (high - low).max()
    low = low - pad
    high = high + pad
    width, height = high - low
    rows = [["robot", "desired"], ["robot", "drawn"]][: 1 + bool(len(drawn))]
    size = WIDTH, float(np.clip(1.24 * WIDTH * height / width + 1.6, 5.0, 11.0))
    figure, (left, top, *others) = Sheet(axes).mosaic(rows, size, width_ratios=(1, 1.55))
    _robot(left, robot, working, strokes, tool, frame)
    draw_points(top, "path.desired", _one_line(desired))
    panels = [(top, "desired drawing")]
    for bottom in others:
        error = _draw_errors(bottom, drawn, errors)
        panels.append((bottom, f"drawn by {by}, largest error {error}"))
    for corners in sheet:
        for panel in (left, *(panel for panel, _ in panels)):
            draw_points(panel, "path.page", corners)
    for panel, words in panels:
        panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        plane(panel, title=words)
    if title:
        figure.suptitle(title)
    return figure


def _one_line(strokes):
    """Return the points (n, 2) of strokes as one line with gaps: a line each would take long."""
    return np.concatenate([np.vstack([stroke, (np.nan, np.nan)]) for stroke in strokes])


def _draw_errors(axes, drawn, errors):
    """Draw strokes coloured by their errors and return the largest error in words."""
    segments = [1e3 * np.stack([stroke[:-1], stroke[1:]], axis=1) for stroke in drawn]
    colours = np.concatenate([np.maximum(error[:-1], error[1:]) for error in errors])
    largest = float(np.concatenate(errors).max())
    scale, unit = readable(largest, "m")
    lines = LineCollection(
        np.concatenate(segments), cmap=PALETTES["lines"].reversed(), lw=1.8, capstyle="round"
    )
    lines.set(array=scale * colours, clim=(0.0, scale * largest or 1.0))
    axes.add_collection(lines)
    axes.figure.colorbar(lines, ax=axes, label=f"error ({unit})", fraction=0.05, pad=0.02)
    return f"{scale * largest:.3g} {unit}"


def draw_path(path: Path, sheet: Sheet) -> Figure:
    """Draw a Path: strokes, dotted lines where the pen is up, and the points of rest."""
    piece, share = np.meshgrid(np.arange(len(path.pieces)), np.linspace(0, 1, 33), indexing="ij")
    lengths = np.array([piece.length for piece in path.pieces])
    points = path.drawn.on(piece, share * lengths[:, None])[0]
    stops: Any = path.stops  # type: ignore[attr-defined]  # set by __post_init__
    rests = path.drawn(np.array([stop.s for stop in stops]))[0]
    pen = np.array(path.pen)
    width, height = np.maximum(np.ptp(points.reshape(-1, 2), axis=0), 1e-12)
    size = 7, min(max(7 * height / width, 1.5), 7) + 1.2
    figure, (axes,) = sheet.mosaic([["path"]], size)
    pen_up: dict = dict(color=INK, lw=0.8, ls=(0, (1, 2)), label="pen up")
    for down, style in ((True, dict(color=REFERENCE, lw=1.6, label="pen down")), (False, pen_up)):
        if (pen == down).any():
            axes.add_collection(LineCollection(1e3 * points[pen == down], **style))
    draw_points(axes, "mark.rest", rests)
    axes.autoscale()
    plane(axes, 3)
    return figure


def _robot(axes, robot, working, desired, tool, frame):
    pen = desired[0][0]
    if tool is None:
        start = igm(robot, pen, working)
    else:
        start = tool.pose(robot, pen, working)
    draw_robot(axes, pose_body([start], None if tool is None else astuple(tool)))
    draw_points(axes, "path.desired-small", _one_line(desired))
    draw_loci_of(axes, robot, tuple(working), (), tool)
    draw_points(axes, "mark.pen", pen)
    for line in axes.lines:
        z = 1e3 * complex(*frame.shift) + frame.turned * (line.get_xydata() @ (1, 1j))
        line.set_data(z.real, z.imag)
    axes.relim()
    plane(axes, 3, f"the robot, in working modes ({signs(*working)})")
