"""A calibration in words: what fits, what was found with which certainty, what cannot be told,
which rows are off.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from ...base.representation import aligned
from .measured_robot import PLACE, UNITS

if TYPE_CHECKING:
    from .result import Calibration

LARGE = 0.01  # of a mean bar
SHOWN = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg")}


def shown_in(name: str) -> tuple[float, str]:
    """Factor and unit in which an unknown is shown."""
    return SHOWN.get(UNITS.get(name, ""), (1.0, ""))


def calibration_text(found: Calibration) -> str:
    """The report, some lines."""
    return "\n".join(
        [*_fit(found), "", *_table(found), *_told(found), *_rows(found), *_said(found)]
    )


def verdict(found: Calibration) -> str:
    """What chi^2 says, "" where sigma is not given."""
    if found.p_value is None:
        share = found.rms / (sum(found.start[:4]) / 4)
        return (
            f"THE MISSES ARE LARGE, {share:.1%} of a bar: is all unknown that is not known?"
            if share > LARGE
            else ""
        )
    chance = f"chi2 = {found.chi2:.4g} for {found.dof} degrees of freedom, p = {found.p_value:.2g}"
    if found.fits:
        return f"{chance}: the model fits to the sigma given"
    times = np.sqrt(found.chi2 / found.dof)
    return (
        f"{chance}: THE MODEL DOES NOT FIT: the misses are {times:.3g} x sigma. Wrong rows, a"
        " tilted measuring plane, backlash, bars out of the plane? The intervals below do not hold"
    )


def _fit(found):
    points, far = len(found.rows.asked[0]), len(found.rows.asked[2])
    counted = [f"{points} coordinates"] if points else []
    counted += [f"{far} distances"] if far else []
    modes = Counter(
        (*map(int, working), int(mode)) for working, mode in zip(found.working, found.assembly)
    )
    shown = ", ".join(
        "({:+d}, {:+d}) {:+d}: {}".format(*mode, count) for mode, count in modes.most_common()
    )
    lines = [
        (
            f"{len(found.rows)} rows with {' and '.join(counted)}, in working and assembly modes"
            f" {shown}; {len(found.unknown)} unknowns, of which {found.rank} combinations can be"
            " told"
        ),
        f"misses, RMS: {1e3 * found.rms_before:.4g} mm before, {1e3 * found.rms:.4g} mm after, "
        + (f"{1e3 * found.leave_one_out:.4g} mm" if np.isfinite(found.leave_one_out) else "unknown")
        + " of rows left out",
    ]
    return [*lines, *filter(None, [verdict(found)])]


def _table(found):
    lines = [["", "unit", "before", "found", "sd", "95 % from", "to"]]
    intervals = found.intervals()
    for name, value in found.values.items():
        factor, unit = shown_in(name)
        sd = found.sd[name]
        digits = (
            4
            if not np.isfinite(sd) or sd == 0
            else int(np.clip(1 - np.floor(np.log10(factor * sd)), 0, 9))
        )
        numbers = [found.start[PLACE[name]], value]
        row = [name, unit, *(f"{factor * v:.{digits}f}" for v in numbers)]
        if np.isfinite(sd):
            row += [f"{factor * v:.{digits}f}" for v in (sd, *intervals[name])]
        else:
            row += ["not told", "", ""]
        lines.append(row)
    return aligned(lines, 2)


def _told(found):
    lines = ["", "not told apart by these data:"] if found.indistinguishable else []
    lines += [f"- {sentence}" for sentence in found.indistinguishable]
    lines += [f"- {sentence}" for sentence in found.weakly_identified]
    return lines or ["", "all unknowns are told apart"]


def _rows(found):
    if not found.outliers:
        return []
    named = [f"{where} (p = {chance:.1g})" for where, chance in found.outliers.items()]
    return ["", f"off all other rows: {', '.join(named)}"]


def _said(found):
    held = [name for name, out in zip(found.unknown, found.held) if out] if len(found.held) else []
    lines = [f"at a bound: {', '.join(held)}"] if held else []
    return ["", *lines, *found.notes] if lines or found.notes else []
