"""Backlash of the motors, from residuals that depend on the direction of approach.

Where a motor came to a row turning to the left, its joint is behind it by half of the backlash, and
ahead by as much where it came turning to the right. Rows in the order in which they were measured
tell which: a step of the calibration with both backlashes among the unknowns finds their sizes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .fit import residuals

if TYPE_CHECKING:
    from .result import Calibration

STEP = 1e-7  # rad, of a derivative
STILL = 1e-9  # rad, a motor that moved less did not
CLEAR = 5.0  # standard deviations: a smaller backlash is not named
SPARE = 4  # numbers beyond the unknowns that are needed


class Backlash(NamedTuple):
    """Of one motor: its value and standard deviation, rad."""

    value: float
    sd: float

    @property
    def clear(self) -> bool:
        return self.value > CLEAR * self.sd


def backlashes(found: Calibration) -> tuple[Backlash, Backlash] | None:
    """Return the backlashes of both motors, None where the rows do not tell them."""
    before = np.diff(found.rows.q, axis=0, prepend=found.rows.q[:1])
    came = np.sign(before) * (np.abs(before) > STILL)
    off, jacobian = found._with_prior
    if len(off) < jacobian.shape[1] + 2 + SPARE or (came == came[-1]).all(axis=0).any():
        return None
    columns = np.zeros((len(off), 2))
    for motor in (0, 1):
        ratio = found.p[7 + motor]
        behind = np.zeros_like(found.rows.q)
        behind[:, motor] = -came[:, motor] / 2 * STEP / ratio
        ends = []
        for q in (found.rows.q + behind, found.rows.q - behind):
            rows = replace(found.rows, q=q)
            ends.append(residuals(found.p, rows, found.assembly, derive=False)[0])
        change = (ends[0] - ends[1]) / (2 * STEP) * found.weight
        columns[: len(change), motor] = change
    together = np.hstack([jacobian, columns])
    if not np.isfinite(together).all():
        return None
    left, s, right = np.linalg.svd(together, full_matrices=False)
    told_by = s > 1e-10 * s[0]
    told_part = left[:, told_by].T @ off
    inverse = right[told_by, -2:] / s[told_by, None]
    step = -told_part @ inverse
    freedom = len(off) - int(told_by.sum())
    variance = 1.0 if found.absolute else float(off @ off - told_part @ told_part) / freedom
    sd = np.sqrt((inverse**2).sum(axis=0) * variance)
    values = zip(step.tolist(), sd.tolist())
    return tuple(Backlash(*pair) for pair in values)  # type: ignore[return-value]  # two


def told(found: Calibration) -> list[str]:
    """Return a sentence for each motor whose backlash is clear."""
    words = []
    for motor, backlash in enumerate(backlashes(found) or (), 1):
        if backlash.clear:
            size = f"about {math.degrees(backlash.value):.2g}° of backlash in motor {motor}"
            words.append(f"the residuals depend on the direction of approach: {size}")
    return words
