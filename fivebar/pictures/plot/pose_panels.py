"""Poses of a robot as a picture, a panel each: bars, motors and end-effector."""

import numpy as np
from matplotlib.figure import Figure

from ...models.geometry import Pose
from .runs import GUIDE, INK, LEFT, RIGHT

IN_A_ROW = 4
WIDTH, ROOM = 3.2, 0.12  # in, of a panel; share of the picture around what is drawn


def pose(poses, titles=None):
    """Figure of one Pose, a batch (n,) of them or a list of poses of one robot, side by side to one scale.

    titles: a text for each; None: their modes. ValueError for no pose, poses that do not close, titles that do not fit.
    """
    drawn = [one for given in ([poses] if isinstance(poses, Pose) else poses) for one in _single(given)]
    titles = [_modes(one) for one in drawn] if titles is None else list(titles)
    if not drawn:
        raise ValueError("there is no pose to draw")
    if len(titles) != len(drawn):
        raise ValueError(f"{len(titles)} titles for {len(drawn)} poses")
    points = 1e3 * np.array([one[0] for one in drawn])
    if not np.isfinite(points).all():
        raise ValueError("a pose that does not close (nan) cannot be drawn")
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    margin = ROOM * (high - low).max()
    columns = min(len(drawn), IN_A_ROW)
    rows = -(-len(drawn) // columns)
    shape = np.divide(*(high - low + 2 * margin)[::-1])
    figure = Figure(figsize=(WIDTH * columns + 0.5, rows * (WIDTH * shape + 0.35) + 0.5), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes, title, (_, robot, _), place in zip(panels, titles, drawn, points):
        _draw(axes, robot, place)
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
        axes.set_aspect("equal")
        axes.set_title(title, fontsize=9)
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        axes.label_outer()
        axes.grid(alpha=0.25)
    for axes in panels[len(drawn) :]:
        axes.remove()
    return figure


def _single(given):
    """(points (5, 2) m, robot, modes) of each pose in a Pose."""
    xi = given.xi.reshape(-1, 2)
    elbows, bases = given.elbows.reshape(-1, 2, 2), [(drive.x, drive.y) for drive in given.robot.drives]
    modes = zip(given.working.reshape(-1, 2).tolist(), np.ravel(given.assembly).tolist())
    for end, (left, right), mode in zip(xi, elbows, modes):
        first, last = bases if given.robot.turns else (left, right)
        yield np.array([first, left, end, right, last]), given.robot, mode


def _modes(one):
    (left, right), assembly = one[2]
    return f"working ({left:+d}, {right:+d}), assembly {assembly:+d}".replace("-", "−")


def _draw(axes, robot, points):
    for leg, colour in ((points[:3], LEFT), (points[2:], RIGHT)):
        axes.plot(*leg.T, "o-", color=colour, lw=3, ms=6, mfc="white", zorder=2)
    axes.plot(*points[[0, -1]].T, "s", color=INK, ms=9, ls="none", zorder=3)
    axes.plot(*points[2], "o", color=INK, ms=7, zorder=4)
    for drive in () if robot.turns else robot.drives:
        axes.axvline(1e3 * drive.x, color=GUIDE, lw=6, zorder=0)
