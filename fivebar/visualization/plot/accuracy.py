"""Pictures of a robot's accuracy: tip errors under tolerances, repeated poses, a tour of poses to
measure at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..style import COLOURS, signs
from ..view.solids import circle
from .panels import draw, draw_level, draw_points, finish, note, plane
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.calibration.poses import MeasurementPoses
    from ...estimation.calibration.repeatability import Repeatability
    from ...estimation.calibration.tip_error import TipError


def draw_tip_error(result: TipError, sheet: Sheet) -> Figure:
    """Draw a TipError: first order against Monte Carlo, and their ratio over the distance from
    Type 2.
    """
    figure, (left, right) = sheet.mosaic([["errors", "ratio"]], (11.5, 5.2))
    linear = 1e3 * result.sd
    sampled = 1e3 * result.monte_carlo_sd
    good = np.isfinite(sampled) & (sampled > 0) & (linear > 0)
    if good.any():
        both = np.concatenate([linear[good], sampled[good]])
    else:
        both = np.array([1, 2])
    left.set(xscale="log", yscale="log")
    draw(left, "line.unity", *[[both.min(), both.max()]] * 2, label="equal")
    draw(left, "mark.pose", linear[good], sampled[good], label="a pose, RMS")
    closed = good & np.isfinite(result.radius)
    draw(left, "mark.worst", 1e3 * result.worst[closed], 1e3 * result.radius[closed])
    words = dict(xlabel="by Jacobian (mm)", ylabel="by Monte Carlo (mm)")
    finish(left, 3, title="error of the tip", **words)
    det = np.abs(np.ravel(result.pose.det_A))
    ratio = np.divide(sampled, linear, where=good, out=np.full(len(good), np.nan))
    draw(right, "mark.pose", det, ratio, label="Monte Carlo / Jacobian")
    draw_level(right, "line.unity", 1.0)
    if result.open.max() > 0:
        draw(right, "mark.open", det, result.open)
    words = dict(xlabel="|det A|, 0 at Type 2", ylabel="ratio")
    finish(right, 2, title="where the first-order estimate fails", **words)
    return figure


def draw_repeatability(result: Repeatability, sheet: Sheet) -> Figure:
    """Draw a Repeatability: of nine poses at most points, barycentre and circle of RP."""
    count = min(len(result.points), 9)
    names = [f"pose {k + 1}" for k in range(count)]
    figure, panels = sheet.grid(names, 3, 4.2, 4.6)
    for k, axes in enumerate(panels):
        centre = result.barycentre[k]
        draw_points(axes, "mark.attained", result.points[k] - centre)
        draw(axes, "mark.barycentre", 0, 0)
        label = f"RP = {1e3 * result.RP[k]:.4g} mm"
        draw_points(axes, "path.circle", circle(0.0, result.RP[k], 181), label=label)
        if result.commanded is not None and result.AP is not None:
            label = f"commanded, AP = {1e3 * result.AP[k]:.4g} mm"
            draw_points(axes, "mark.commanded", result.commanded[k] - centre, label=label)
        plane(axes, 2, names[k])
    return figure


def draw_measurement_poses(result: MeasurementPoses, sheet: Sheet) -> Figure:
    """Draw MeasurementPoses: the points by their modes, joined in the order of the tour."""
    figure, (axes,) = sheet.mosaic([["poses"]], (7.2, 7.6))
    draw_points(axes, "line.leader", result.xi)
    modes = np.column_stack([result.working, result.assembly]).tolist()
    for k, mode in enumerate(dict.fromkeys(map(tuple, modes))):
        label = f"working ({signs(*mode[:2])}), assembly {signs(mode[2])}"
        points = 1e3 * result.xi[[tuple(other) == mode for other in modes]]
        style: dict = dict(color=COLOURS[k % 7], ms=7, label=label, zorder=3)
        axes.plot(*points.T, "os^Dv<>p"[k % 8], **style)
    for number, point in enumerate(result.xi, 1):
        note(axes, str(number), point)
    for drive in result.pose.robot.drives:
        draw_points(axes, "robot.base", (drive.x, drive.y))
    title = f"{len(modes)} poses to measure at, in this order; "
    plane(axes, 2, f"{title}tip within {result.worst_tip:.3g} sigma after that")
    return figure
