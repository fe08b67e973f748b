"""Pictures of what was measured: a calibration's misses as arrows, its rows, its unknowns with
intervals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...estimation.calibration.measured_robot import FRAME, PLACE, UNITS
from ...estimation.calibration.report import shown_in
from ..style import BLUE, GREEN, INK, ORANGE, PALE, finish, readable

if TYPE_CHECKING:
    from ...estimation.calibration.result import Calibration

ARROW = 0.08  # of the picture's width: the longest arrow


def calibrated(found: Calibration) -> Figure:
    """Figure of a Calibration: misses before and after as arrows, misses by row, change of each
    unknown.
    """
    figure = Figure(figsize=(12.5, 7.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1))
    left = figure.add_subplot(grid[:, 0])
    if np.isfinite(found.rows.points).all(axis=1).any():
        _arrows(left, found)
    else:
        _numbers(left, found)
    _rows(figure.add_subplot(grid[0, 1]), found)
    _unknowns(figure.add_subplot(grid[1, 1]), found)
    return figure


def _arrows(axes, found):
    whole = found.rows.whole
    points = 1e3 * found.rows.points[whole]
    width = max(float(np.ptp(points, axis=0).max()), 1e-9)
    for off, colour, words in (
        (-found.residuals_before[whole], ORANGE, "before"),
        (-found.residuals[whole], BLUE, "after"),
    ):
        longest = float(np.nanmax(np.hypot(*off.T), initial=0.0))
        factor = _round(ARROW * width / (1e3 * longest)) if longest > 1e-15 else 1.0
        scale, unit = readable(longest, "m")
        axes.quiver(
            *points.T,
            *(1e3 * factor * off.T),
            angles="xy",
            scale_units="xy",
            scale=1,
            width=0.003,
            color=colour,
            label=f"miss {words}, × {factor:g}: longest {scale * longest:.3g} {unit}",
            zorder=4,
        )
    axes.plot(*points.T, "o", ms=4, mfc="white", color=INK, label="measured", zorder=3)
    for row in np.flatnonzero(whole):
        if found.rows.where[row] in found.outliers:
            place = 1e3 * found.rows.points[row]
            axes.plot(*place, "o", ms=13, mfc="none", color=ORANGE, zorder=5)
            axes.annotate(
                found.rows.where[row], place, textcoords="offset points", xytext=(8, 6), fontsize=8
            )
    axes.set_aspect("equal")
    axes.margins(0.12)
    finish(
        axes,
        2,
        xlabel="x (mm)",
        ylabel="y (mm)",
        title="predicted − measured, from the measured point",
    )


def _numbers(axes, found):
    """Where no whole points are measured: predicted against measured numbers."""
    from ...estimation.calibration.fit import residuals

    measured = 1e3 * found.rows.numbers
    for p, colour, words in ((found.before, ORANGE, "before"), (found.p, BLUE, "after")):
        off = 1e3 * residuals(p, found.rows, found.assembly, derive=False)[0]
        axes.plot(measured, off, "o", ms=5, color=colour, label=f"miss {words}")
    finish(axes, 2, xlabel="measured (mm)", ylabel="predicted − measured (mm)", title="misses")


def _rows(axes, found):
    size = np.sqrt(np.nansum(found.residuals**2, axis=1))
    if not np.isfinite(found.rows.points).any():
        return _numbers(axes, found)
    scale, unit = readable(float(size.max()), "m")
    number = np.arange(1, len(size) + 1)
    out = np.array([where in found.outliers for where in found.rows.where])
    axes.vlines(number, 0, scale * size, color=PALE, lw=1)
    axes.plot(number[~out], scale * size[~out], "o", ms=4, color=BLUE, label="miss of a row")
    if out.any():
        axes.plot(
            number[out], scale * size[out], "D", ms=6, color=ORANGE, label="off all other rows"
        )
    axes.axhline(
        scale * found.rms,
        color=INK,
        lw=1,
        ls="--",
        label=f"RMS of a coordinate {scale * found.rms:.3g} {unit}",
    )
    title = "rows"
    if found.p_value is not None:
        title += f"; p = {found.p_value:.2g}: the model {'fits' if found.fits else 'does not fit'}"
    finish(axes, 3, xlabel="row", ylabel=f"miss ({unit})", title=title)


def _unknowns(axes, found):
    """Changes in their own units: mm, deg, and per mille of ratios and scale."""
    names = [name for name in found.unknown if name not in FRAME] or list(found.unknown)
    intervals = found.intervals()
    for k, name in enumerate(names):
        start = found.start[PLACE[name]]
        factor = shown_in(name)[0] if name in UNITS else 1e3 / abs(start)
        change = factor * (found.values[name] - start)
        if np.isfinite(found.sd[name]):
            low, high = (factor * (limit - start) for limit in intervals[name])
            axes.plot([low, high], [k, k], color=BLUE, lw=3, solid_capstyle="butt", zorder=2)
            axes.plot(change, k, "o", color=BLUE, ms=6, zorder=3)
        else:
            axes.plot(change, k, "X", color=ORANGE, ms=8, zorder=3)
    axes.plot([], [], "o-", color=BLUE, lw=3, label="found, with its 95 % interval")
    if any(not np.isfinite(found.sd[name]) for name in names):
        axes.plot([], [], "X", color=ORANGE, ls="none", label="not told by these data")
    axes.axvline(0, color=GREEN, lw=1.2, label="before")
    labels = [f"{name} ({shown_in(name)[1] or '1/1000'})" for name in names]
    axes.set_yticks(range(len(names)), labels)
    axes.invert_yaxis()
    finish(axes, 3, xlabel="change", title="unknowns of the robot")


def _round(factor):
    """The nearest of 1, 2, 5 times a power of ten below."""
    power = 10.0 ** np.floor(np.log10(max(factor, 1e-9)))
    return power * max(
        (step for step in (1, 2, 5) if step * power <= factor * (1 + 1e-9)), default=1
    )
