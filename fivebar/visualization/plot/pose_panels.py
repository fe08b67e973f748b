"""Poses of a robot as a picture, a panel each: bars, motors and end-effector."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.checks import one_of
from ...base.errors import SingularityError
from ...models.geometry import Pose
from ..skeleton import pose_body
from ..style import PATH, signs
from .panels import draw_points, draw_robot, plane, set_window
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IN_A_ROW = 4
WIDTH = 3.2  # in, of a panel
ELLIPSES = {"velocity": "m/s for 1 {unit}/s", "force": "N for 1 {effort_unit}"}


def pose(
    poses: Pose | Iterable[Pose],
    titles: Sequence[str] | None = None,
    ellipse: str | None = None,
    axes: Any = None,
) -> Figure:
    """Return the figure of poses of one robot, side by side to one scale.

    Parameters
    ----------
    poses : Pose or sequence of Pose
        Single ones or batches (n,).
    titles : sequence of str, optional
        A text for each; their modes by default.
    ellipse : {"velocity", "force"}, optional
        Around the end-effector, the ends of all velocities at motor rates q1'^2 + q2'^2 = 1, or of
        all forces at motor torques of size 1; to one scale, its longest half axis is in the title.
    axes : Axes or sequence of Axes, optional
        Panels of a figure of one's own, one for each pose; a new figure without.

    Returns
    -------
    Figure
        A panel for each pose.

    Raises
    ------
    ValueError
        For no pose, poses that do not close, and titles that do not fit.
    SingularityError
        An ellipse where it has no end: of velocity at Type 2, of force at Type 1.

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
    width, height = np.ptp(points.reshape(-1, 2), axis=0)
    margin = 0.24 * max(width, height)
    shape = (height + margin) / (width + margin)
    figure, panels = Sheet(axes).grid(
        [f"pose {k + 1}" for k in range(len(modes))], IN_A_ROW, WIDTH, WIDTH * shape + 0.35
    )
    if ellipse is not None:
        ends = _ends(poses, one_of(*ELLIPSES)(ellipse, "ellipse"))
        sizes = np.linalg.norm(ends, axis=-1).max(axis=-1)
        words = poses[0].robot.words
        unit = ELLIPSES[ellipse].format(unit=words.unit, effort_unit=words.effort_unit)
        titles = [
            f"{title}\n{ellipse} up to {size:.3g} {unit}" for title, size in zip(titles, sizes)
        ]
        curves = (
            body.points[:, body.traced][:, None] + 0.3 * max(width, height) / sizes.max() * ends
        )
        points = np.concatenate([points, curves], axis=1)
    for sample, (panel, title) in enumerate(zip(panels, titles)):
        draw_robot(panel, body, sample)
        draw_points(panel, "robot.end-effector", body.points[sample, body.traced])
        set_window(panel, points)
        if ellipse is not None:
            draw_points(panel, "line.medium", curves[sample], color=PATH)
        plane(panel)
        panel.set_title(title, fontsize=9)
        if axes is None:
            panel.label_outer()
    return figure


def _ends(poses, ellipse):
    """Return ends (poses, angles, 2) at the end-effector of the motors' unit rates or torques."""
    A, B = (
        np.concatenate([getattr(batch, name).reshape(-1, 2, 2) for batch in poses]) for name in "AB"
    )
    singular, other, kind = (A, B, 2) if ellipse == "velocity" else (B, A, 1)
    margins = np.abs(np.linalg.det(singular)) / np.abs(singular).max(axis=(1, 2)) ** 2
    worst = int(np.argmin(margins))
    if margins[worst] < 1e-12:
        words = f"the {ellipse} has no bound: pose {worst} is of Type {kind}"
        raise SingularityError(words, margins[worst], (worst,))
    shares = np.linalg.solve(singular, other)
    if ellipse == "velocity":
        shares = shares.swapaxes(-1, -2)
    angles = np.linspace(0, 2 * np.pi, 181)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1) @ shares
