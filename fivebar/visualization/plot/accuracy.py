"""Pictures of a robot's accuracy: tip errors under tolerances, repeated poses, a tour of poses to
measure at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..style import BLUE, COLOURS, GREEN, INK, ORANGE, PALE, finish

if TYPE_CHECKING:
    from ...estimation.calibration.poses import MeasurementPoses
    from ...estimation.calibration.repeatability import Repeatability
    from ...estimation.calibration.tip_error import TipError

TURN = np.linspace(0, 2 * np.pi, 181)


def tip_errors(found: TipError) -> Figure:
    """Figure of a TipError: first order against Monte Carlo, and their ratio over the distance from
    Type 2.
    """
    figure = Figure(figsize=(11.5, 5.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    linear, drawn = 1e3 * found.sd, 1e3 * found.monte_carlo_sd
    good = np.isfinite(drawn) & (drawn > 0) & (linear > 0)
    both = np.concatenate([linear[good], drawn[good]]) if good.any() else np.array([1, 2])
    span = [both.min(), both.max()]
    left.loglog(span, span, color=INK, lw=1, label="equal")
    left.loglog(linear[good], drawn[good], "o", ms=5, color=BLUE, label="a pose, RMS")
    all_there = good & np.isfinite(found.radius)
    left.loglog(
        1e3 * found.worst[all_there],
        1e3 * found.radius[all_there],
        "s",
        ms=4,
        color=ORANGE,
        mfc="none",
        label="worst case, and radius of 95 %",
    )
    finish(
        left, 3, xlabel="by Jacobian (mm)", ylabel="by Monte Carlo (mm)", title="error of the tip"
    )
    det = np.abs(np.atleast_1d(found.pose.det_A)).ravel()
    ratio = np.where(good, drawn / np.where(linear > 0, linear, 1.0), np.nan)
    right.plot(det, ratio, "o", ms=5, color=BLUE, label="Monte Carlo / Jacobian")
    right.axhline(1.0, color=INK, lw=1)
    if (lost := found.open).max() > 0:
        right.plot(det, lost, "x", ms=6, color=ORANGE, label="share of robots that do not close")
    finish(
        right,
        2,
        xlabel="|det A|, 0 at Type 2",
        ylabel="ratio",
        title="where first order no longer does",
    )
    return figure


def repeated(found: Repeatability) -> Figure:
    """Figure of a Repeatability: a panel for each pose (nine at most) with its points, barycentre
    and circle of RP.
    """
    count = min(len(found.points), 9)
    across = min(count, 3)
    figure = Figure(figsize=(4.2 * across, 4.6 * -(-count // across)), layout="constrained")
    for k in range(count):
        axes = figure.add_subplot(-(-count // across), across, k + 1)
        away = 1e3 * (found.points[k] - found.barycentre[k])
        axes.plot(*away.T, "o", ms=4, color=BLUE, label="attained")
        axes.plot(0, 0, "+", ms=10, color=INK, label="barycentre")
        circle = 1e3 * found.RP[k] * np.array([np.cos(TURN), np.sin(TURN)])
        axes.plot(*circle, color=GREEN, lw=1.2, label=f"RP = {1e3 * found.RP[k]:.4g} mm")
        if found.commanded is not None:
            off = 1e3 * (found.commanded[k] - found.barycentre[k])
            axes.plot(
                *off, "X", ms=8, color=ORANGE, label=f"commanded, AP = {1e3 * found.AP[k]:.4g} mm"
            )
        axes.set_aspect("equal")
        finish(axes, 2, xlabel="x (mm)", ylabel="y (mm)", title=f"pose {k + 1}")
    return figure


def toured(found: MeasurementPoses) -> Figure:
    """Figure of MeasurementPoses: the points by their modes, joined in the order of the tour."""
    figure = Figure(figsize=(7.2, 7.6), layout="constrained")
    axes = figure.add_subplot()
    points = 1e3 * found.xi
    modes = [
        (*map(int, working), int(assembly))
        for working, assembly in zip(found.working, found.assembly)
    ]
    axes.plot(*points.T, color=PALE, lw=0.8, zorder=1)
    for k, mode in enumerate(dict.fromkeys(modes)):
        own = points[[each == mode for each in modes]]
        label = "working ({:+d}, {:+d}), assembly {:+d}".format(*mode).replace("-", "−")
        axes.plot(*own.T, "os^Dv<>p"[k % 8], color=COLOURS[k % 7], ms=7, label=label, zorder=3)
    for k, point in enumerate(points, 1):
        axes.annotate(str(k), point, textcoords="offset points", xytext=(6, 5), fontsize=8)
    for drive in found.pose.robot.drives:
        axes.plot(1e3 * drive.x, 1e3 * drive.y, "^", ms=9, mfc="white", color=INK, zorder=2)
    axes.set_aspect("equal")
    title = (
        f"{len(points)} poses to measure at, in this order; tip within {found.worst_tip:.3g} sigma"
        " after that"
    )
    finish(axes, 2, xlabel="x (mm)", ylabel="y (mm)", title=title)
    return figure
