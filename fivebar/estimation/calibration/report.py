"""Print a calibration: its fit, its unknowns with intervals, what is not told, outlying rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...base.representation import aligned
from .measured_robot import PLACE, shown_in
from .outliers import CHANCE

if TYPE_CHECKING:
    from .result import Calibration

LESS = 'leave them out of the data, or count them less (loss="cauchy", --loss cauchy)'
SMALL = 0.05  # of sigma: misses below it are of another sigma


def report(found: Calibration) -> str:
    """Return the report, some lines."""
    lines = [*_fit(found), "", *_table(found), ""]
    lines += [f"- {sentence}" for sentence in found.weakly_identified]
    if found.indistinguishable:
        lines.append("not told apart by these data:")
    lines += [f"- {sentence}" for sentence in found.indistinguishable]
    if not found.weakly_identified and not found.indistinguishable:
        lines.append("all unknowns are told apart")
    if found.outliers:
        rows = (f"{where} (p = {p:.1g})" for where, p in found.outliers.items())
        lines += ["", f"off all other rows: {', '.join(rows)}"]
        if found.loss == "linear":
            lines.append(f"if these are mistakes, {LESS}")
    notes = list(found.notes)
    if advised := found.advised_priors:
        words = " ".join(f"{name}={1e3 * sd:.2g}mm" for name, sd in advised.items())
        scatter = np.sqrt(found.variance) / np.median(found.weight)
        sigma = "" if found.absolute else f"--sigma {scatter:.2g} "
        notes.insert(
            0,
            "these data tell lengths no better than a workshop makes them: a robot that is built as"
            f" it is drawn goes where it should more exactly with {sigma}--prior {words}, or with"
            " what you know of its lengths",
        )
    for name, size, known in zip(found.unknown, found.sizes, found.prior):
        if known:
            factor, unit = shown_in(name)
            sd = factor * size / known
            notes.append(f"known before: {name} within {sd:.4g} {unit} (sd)")
    if notes:
        lines += ["", *notes]
    return "\n".join(lines)


def _fit(found):
    coordinates = len(found.rows.measured[0])
    distances = len(found.rows.measured[2])
    counted = [f"{coordinates} coordinates"] if coordinates else []
    if distances:
        counted.append(f"{distances} distances")
    modes = np.unique(np.column_stack([found.working, found.assembly]), axis=0)
    count = len(found.rows)
    lines = [
        f"{count} row{'s' * (count > 1)} with {' and '.join(counted)}, in {len(modes)} of 8 modes;"
        f" {len(found.unknown)} unknowns, of which {found.rank} combinations can be told",
        f"misses, RMS: {1e3 * found.rms_before:.4g} mm before, {1e3 * found.rms:.4g} mm after",
    ]
    if found.p_value is None:
        share = found.rms / np.mean(found.start[:4])
        if share > 0.01:
            lines.append(
                f"THE MISSES ARE LARGE, {share:.1%} of a bar: is all unknown that is not known?"
            )
        return lines
    chance = f"chi2 = {found.chi2:.4g} for {found.dof} degrees of freedom, p = {found.p_value:.2g}"
    times = np.sqrt(found.chi2 / found.dof)
    words = "the model fits to the sigma given"
    if not found.fits:
        words = (
            f"THE MODEL DOES NOT FIT: the misses are {times:.3g} x sigma. Wrong rows, readings"
            " rounded to counts, a pen beside the joint or on the other leg, backlash, a tilted"
            " measuring plane, bars out of the plane? The intervals below do not hold"
        )
    elif found.p_value < CHANCE:
        words = (
            f"the misses are {times:.3g} x sigma, more than by chance: are readings rounded to"
            " counts, or is sigma larger? The intervals below may be too narrow"
        )
    elif found.chi2 < SMALL**2 * (found.dof - 1):
        words = (
            f"THE MISSES ARE ONLY {times:.1g} x sigma. Is sigma in m (--sigma 0.02mm)? The"
            " intervals below are as wide as sigma says"
        )
    return [*lines, f"{chance}: {words}"]


def _table(found):
    rows = [["", "unit", "before", "found", "sd", "95 % from", "to"]]
    intervals = found.intervals()
    for told, (name, value) in zip(found.told, found.values.items()):
        factor, unit = shown_in(name)
        sd = factor * found.sd[name]
        known = np.isfinite(sd)
        digits = 4
        if known and sd > 0:
            digits = int(np.clip(1 - np.floor(np.log10(sd)), 0, 9))
        numbers = [factor * found.start[PLACE[name]], factor * value]
        if known:
            numbers += [sd, *(factor * limit for limit in intervals[name])]
        cells = [f"{number:.{digits}f}" for number in numbers]
        missing = "no scatter" if told else "not told"
        rows.append([name, unit, *cells, *([] if known else [missing, "", ""])])
    return aligned(rows, 2)
