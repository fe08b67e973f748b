"""Poses of a robot as a picture, a panel each: bars, motors and end-effector."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...models.geometry import Pose
from ..skeleton import Skeleton, pose_body
from ..style import GUIDE, INK, LEGS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

IN_A_ROW = 4
WIDTH, ROOM = 3.2, 0.12  # in, of a panel; share of the picture around what is drawn


def pose(poses: Pose | Iterable[Pose], titles: Sequence[str] | None = None) -> Figure:
    """Figure of one Pose, a batch (n,) of them or a list of poses of one robot, side by side to one
    scale.

    titles: a text for each; None: their modes. ValueError for no pose, poses that do not close,
        titles that do not fit.
    """
    poses = [poses] if isinstance(poses, Pose) else list(poses)
    modes = [
        _modes(*one)
        for given in poses
        for one in zip(given.working.reshape(-1, 2), np.ravel(given.assembly))
    ]
    titles = modes if titles is None else list(titles)
    if not modes:
        raise ValueError("there is no pose to draw")
    if len(titles) != len(modes):
        raise ValueError(f"{len(titles)} titles for {len(modes)} poses")
    body = pose_body(poses)
    points = body.points[:, body.joints]
    if not np.isfinite(points).all():
        raise ValueError("a pose that does not close (nan) cannot be drawn")
    low, high = around(points)
    columns = min(len(modes), IN_A_ROW)
    rows = -(-len(modes) // columns)
    shape = np.divide(*(high - low)[::-1])
    figure = Figure(
        figsize=(WIDTH * columns + 0.5, rows * (WIDTH * shape + 0.35) + 0.5), layout="constrained"
    )
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for sample, (axes, title) in enumerate(zip(panels, titles)):
        draw_robot(axes, body, sample)
        axes.plot(*(1e3 * body.points[sample, body.traced]), "o", color=INK, ms=7, zorder=4)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.set_aspect("equal")
        axes.set_title(title, fontsize=9)
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        axes.label_outer()
        axes.grid(alpha=0.25)
    for axes in panels[len(modes) :]:
        axes.remove()
    return figure


def draw_robot(axes: Axes, body: Skeleton, sample: int = 0, **style) -> None:
    """A robot in mm: a hue for each leg, its proximal bar dark; squares at what its motors turn or
    move.

    Guides go from border to border.
    """
    points = 1e3 * body.points[sample]
    for path, colours in zip(body.paths, LEGS):
        for bar, colour in reversed(
            list(zip(zip(path, path[1:]), colours))
        ):  # a bar folded back lies under the other
            axes.plot(
                *points[list(bar)].T, "o-", color=colour, lw=3, ms=6, mfc="white", zorder=2, **style
            )
    axes.plot(*points[list(body.actuated)].T, "s", color=INK, ms=9, ls="none", zorder=3, **style)
    for low, _ in body.rails:
        axes.axvline(points[low, 0], color=GUIDE, lw=6, zorder=0)


def around(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """((x, y) low, (x, y) high) in mm of a window about points (..., 2) m, with room around
    them.
    """
    points = 1e3 * points.reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = ROOM * (high - low).max()
    return low - margin, high + margin


def _modes(working, assembly):
    left, right = working
    return f"working ({left:+d}, {right:+d}), assembly {assembly:+d}".replace("-", "−")
