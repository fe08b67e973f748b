"""Pictures of what was measured: a calibration's misses as arrows, its rows, its unknowns with
intervals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...estimation.calibration.fit import residuals
from ...estimation.calibration.measured_robot import FRAME, PLACE, UNITS
from ...estimation.calibration.report import shown_in
from ..style import BLUE, ORANGE, PALE, readable
from .panels import STYLES, draw, draw_level, draw_points, finish, note, plane
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.calibration.result import Calibration

ARROW = 0.08  # of the picture's width: the longest arrow


def draw_calibration(result: Calibration, sheet: Sheet) -> Figure:
    """Draw a Calibration: misses before and after as arrows, misses by row, change of each
    unknown.
    """
    mosaic = [["residuals", "rows"], ["residuals", "unknowns"]]
    figure, panels = sheet.mosaic(mosaic, (12.5, 7.2), width_ratios=(1.25, 1))
    known = np.isfinite(result.rows.points)
    (_arrows if known.all(axis=1).any() else _numbers)(panels[0], result)
    (_rows if known.any() else _numbers)(panels[1], result)
    _unknowns(panels[2], result)
    return figure


def _arrows(axes, result):
    rows = result.rows
    points = rows.points[rows.whole]
    width = max(float(np.ptp(points, axis=0).max()), 1e-12)
    before = result.residuals_before[rows.whole]
    after = result.residuals[rows.whole]
    for miss, colour, words in ((before, ORANGE, "before"), (after, BLUE, "after")):
        longest = float(np.nanmax(np.hypot(*miss.T), initial=0.0))
        factor = _round_down(ARROW * width / longest) if longest > 1e-15 else 1.0
        scale, unit = readable(longest, "m")
        label = f"residual {words}, × {factor:g}: longest {scale * longest:.3g} {unit}"
        units = dict(angles="xy", scale_units="xy", scale=1, width=0.003)
        arrows = 1e3 * np.column_stack([points, -factor * miss])
        axes.quiver(*arrows.T, color=colour, label=label, zorder=4, **units)
    draw_points(axes, "mark.point", points)
    for row in np.flatnonzero(rows.whole):
        if rows.where[row] in result.outliers:
            draw_points(axes, "mark.outlier", rows.points[row])
            note(axes, rows.where[row], rows.points[row])
    axes.margins(0.12)
    plane(axes, 2, "predicted − measured, from the measured point")


def _numbers(axes, result):
    """Where no whole points are measured: predicted against measured numbers."""
    measured = 1e3 * result.rows.numbers
    for p, colour, words in ((result.before, ORANGE, "before"), (result.p, BLUE, "after")):
        miss = 1e3 * residuals(p, result.rows, result.assembly, derive=False)[0]
        draw(axes, "mark.pose", measured, miss, color=colour, label=f"residual {words}")
    finish(axes, 2, xlabel="measured (mm)", ylabel="predicted − measured (mm)", title="residuals")


def _rows(axes, result):
    size = np.sqrt(np.nansum(result.residuals**2, axis=1))
    scale, unit = readable(float(size.max()), "m")
    number = np.arange(1, len(size) + 1)
    out = np.isin(result.rows.where, list(result.outliers))
    axes.vlines(number, 0, scale * size, color=PALE, lw=1)
    draw(axes, "mark.row", number[~out], scale * size[~out])
    if out.any():
        draw(axes, "mark.outlying-row", number[out], scale * size[out])
    label = f"RMS of a coordinate {scale * result.rms:.3g} {unit}"
    draw_level(axes, "line.rms", scale * result.rms, label=label)
    title = "rows"
    if result.p_value is not None:
        verdict = "fits" if result.fits else "does not fit"
        title = f"rows; p = {result.p_value:.2g}: the model {verdict}"
    finish(axes, 3, xlabel="row", ylabel=f"residual ({unit})", title=title)


def _unknowns(axes, result):
    """Changes in their own units: mm, deg, and per mille of ratios and scale."""
    names = [name for name in result.unknown if name not in FRAME] or list(result.unknown)
    intervals, labels = result.intervals(), []
    draw(axes, "line.interval", [], [], marker="o", label="estimate, with its 95 % interval")
    for k, name in enumerate(names):
        start = result.start[PLACE[name]]
        factor = shown_in(name)[0] if name in UNITS else 1e3 / abs(start)
        change = factor * (result.values[name] - start)
        if np.isfinite(result.sd[name]):
            draw(axes, "line.interval", factor * np.subtract(intervals[name], start), [k, k])
            draw(axes, "mark.estimate", change, k)
        else:
            label = "not determined by these data"
            draw(axes, "mark.undetermined", change, k, label=label)
        labels.append(f"{name} ({shown_in(name)[1] or '1/1000'})")
    axes.axvline(0, **STYLES["line.start"])
    axes.set_yticks(range(len(names)), labels)
    axes.invert_yaxis()
    finish(axes, 3, xlabel="change", title="unknowns of the robot")


def _round_down(factor):
    """Return the next of 1, 2, 5 times a power of ten below."""
    power = 10.0 ** np.floor(np.log10(max(factor, 1e-9)))
    return power * (5 if factor >= 5 * power else 2 if factor >= 2 * power else 1)
