"""Poses of a robot as a picture, a panel each: bars, motors and end-effector."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...models.geometry import Pose
from ..skeleton import pose_body
from ..style import signs
from .panels import draw_points, draw_robot, new_figure, plane, set_window

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IN_A_ROW = 4
WIDTH = 3.2  # in, of a panel


def pose(poses: Pose | Iterable[Pose], titles: Sequence[str] | None = None) -> Figure:
    """Return the figure of poses of one robot, side by side to one scale.

    Parameters
    ----------
    poses : Pose or sequence of Pose
        Single ones or batches (n,).
    titles : sequence of str, optional
        A text for each; their modes by default.

    Returns
    -------
    Figure
        A panel for each pose.

    Raises
    ------
    ValueError
        For no pose, poses that do not close, and titles that do not fit.

    Examples
    --------
    >>> import fivebar as fb
    >>> figure = fb.plot.pose(fb.dgm(fb.FiveBar(), [(0.0, 0.0), (0.1, 0.2)]))
    >>> [axes.get_title() for axes in figure.axes]
    ['working (−1, −1), assembly −1', 'working (−1, −1), assembly −1']
    """
    poses = [poses] if isinstance(poses, Pose) else list(poses)
    modes = []
    for batch in poses:
        for working, assembly in zip(batch.working.reshape(-1, 2), np.ravel(batch.assembly)):
            modes.append(f"working ({signs(*working)}), assembly {signs(assembly)}")
    titles = modes if titles is None else list(titles)
    if not modes:
        raise ValueError("there is no pose to draw")
    if len(titles) != len(modes):
        raise ValueError(f"{len(titles)} titles for {len(modes)} poses")
    body = pose_body(poses)
    points = body.points[:, body.joints]
    if not np.isfinite(points).all():
        raise ValueError("a pose that does not close (nan) cannot be drawn")
    columns = min(len(modes), IN_A_ROW)
    rows = -(-len(modes) // columns)
    width, height = np.ptp(points.reshape(-1, 2), axis=0)
    margin = 0.24 * max(width, height)
    shape = (height + margin) / (width + margin)
    figure = new_figure(WIDTH * columns + 0.5, rows * (WIDTH * shape + 0.35) + 0.5)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for sample, (axes, title) in enumerate(zip(panels, titles)):
        draw_robot(axes, body, sample)
        draw_points(axes, "robot.end-effector", body.points[sample, body.traced])
        set_window(axes, points)
        plane(axes)
        axes.set_title(title, fontsize=9)
        axes.label_outer()
    for axes in panels[len(modes) :]:
        axes.remove()
    return figure
