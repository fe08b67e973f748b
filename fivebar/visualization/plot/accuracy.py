"""Pictures of a robot's accuracy: tip errors under tolerances, repeated poses, a tour of poses to
measure at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..style import BLUE, COLOURS, GREEN, INK, ORANGE, PALE, signs
from ..view.solids import circle
from .panels import draw_line, finish, new_figure, plane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.calibration.poses import MeasurementPoses
    from ...estimation.calibration.repeatability import Repeatability
    from ...estimation.calibration.tip_error import TipError


def tip_errors(result: TipError) -> Figure:
    """Draw a TipError: first order against Monte Carlo, and their ratio over the distance from
    Type 2.
    """
    figure = new_figure(11.5, 5.2)
    left, right = figure.subplots(1, 2)
    linear, sampled = 1e3 * result.sd, 1e3 * result.monte_carlo_sd
    good = np.isfinite(sampled) & (sampled > 0) & (linear > 0)
    both = np.concatenate([linear[good], sampled[good]]) if good.any() else np.array([1, 2])
    left.loglog(*[[both.min(), both.max()]] * 2, color=INK, lw=1, label="equal")
    left.loglog(linear[good], sampled[good], "o", ms=5, color=BLUE, label="a pose, RMS")
    closed = good & np.isfinite(result.radius)
    worst = dict(ms=4, color=ORANGE, mfc="none", label="worst case, and radius of 95 %")
    left.loglog(1e3 * result.worst[closed], 1e3 * result.radius[closed], "s", **worst)
    words = dict(xlabel="by Jacobian (mm)", ylabel="by Monte Carlo (mm)")
    finish(left, 3, title="error of the tip", **words)
    det = np.abs(np.ravel(result.pose.det_A))
    ratio = np.divide(sampled, linear, where=good, out=np.full(len(good), np.nan))
    right.plot(det, ratio, "o", ms=5, color=BLUE, label="Monte Carlo / Jacobian")
    right.axhline(1.0, color=INK, lw=1)
    if result.open.max() > 0:
        label = "share of robots that do not close"
        right.plot(det, result.open, "x", ms=6, color=ORANGE, label=label)
    words = dict(xlabel="|det A|, 0 at Type 2", ylabel="ratio")
    finish(right, 2, title="where first order no longer does", **words)
    return figure


def repeated(result: Repeatability) -> Figure:
    """Draw a Repeatability: for each pose (nine at most) its points, barycentre and circle of RP."""
    count = min(len(result.points), 9)
    columns = min(count, 3)
    rows = -(-count // columns)
    figure = new_figure(4.2 * columns, 4.6 * rows)
    for k in range(count):
        axes = figure.add_subplot(rows, columns, k + 1)
        centre = result.barycentre[k]
        draw_line(axes, result.points[k] - centre, "o", ms=4, color=BLUE, label="attained")
        axes.plot(0, 0, "+", ms=10, color=INK, label="barycentre")
        label = f"RP = {1e3 * result.RP[k]:.4g} mm"
        draw_line(axes, circle(0.0, result.RP[k], 181), color=GREEN, lw=1.2, label=label)
        if result.commanded is not None:
            label = f"commanded, AP = {1e3 * result.AP[k]:.4g} mm"
            draw_line(axes, result.commanded[k] - centre, "X", ms=8, color=ORANGE, label=label)
        plane(axes, 2, f"pose {k + 1}")
    return figure


def toured(result: MeasurementPoses) -> Figure:
    """Draw MeasurementPoses: the points by their modes, joined in the order of the tour."""
    figure = new_figure(7.2, 7.6)
    axes = figure.add_subplot()
    draw_line(axes, result.xi, color=PALE, lw=0.8, zorder=1)
    modes = np.column_stack([result.working, result.assembly]).tolist()
    for k, mode in enumerate(dict.fromkeys(map(tuple, modes))):
        label = f"working ({signs(*mode[:2])}), assembly {signs(mode[2])}"
        style = dict(color=COLOURS[k % 7], ms=7, label=label, zorder=3)
        points = result.xi[[tuple(other) == mode for other in modes]]
        draw_line(axes, points, "os^Dv<>p"[k % 8], ls="none", **style)
    place = dict(textcoords="offset points", xytext=(6, 5), fontsize=8)
    for number, point in enumerate(result.xi, 1):
        axes.annotate(str(number), 1e3 * point, **place)
    for drive in result.pose.robot.drives:
        draw_line(axes, (drive.x, drive.y), "^", ms=9, mfc="white", color=INK, zorder=2)
    title = f"{len(modes)} poses to measure at, in this order; "
    plane(axes, 2, f"{title}tip within {result.worst_tip:.3g} sigma after that")
    return figure
