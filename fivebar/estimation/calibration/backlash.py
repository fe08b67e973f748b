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
RCOND = 1e-10  # of the largest singular value: smaller ones count as zero
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
    q = found.rows.q
    before = np.diff(q, axis=0, prepend=q[:1])
    moved = np.abs(before) > STILL
    came = np.sign(before) * moved
    one_way = (came == came[-1]).all(axis=0)
    off, jacobian = found._with_prior
    numbers, unknowns = jacobian.shape
    if numbers < unknowns + 2 + SPARE or one_way.any():
        return None
    columns = np.zeros((numbers, 2))
    for motor in (0, 1):
        change = _by_backlash(found, motor, came[:, motor])
        columns[: len(change), motor] = change
    together = np.hstack([jacobian, columns])
    if not np.isfinite(together).all():
        return None
    inverse = np.linalg.pinv(together, RCOND)
    step = -inverse @ off
    rest = off + together @ step
    variance = 1.0 if found.absolute else float(rest @ rest) / (numbers - unknowns - 2)
    sd = np.sqrt((inverse**2).sum(axis=1) * variance)
    first, second = zip(step[-2:].tolist(), sd[-2:].tolist())
    return Backlash(*first), Backlash(*second)


def _by_backlash(found, motor, came):
    """Return the derivative of the weighted residuals by a motor's backlash.

    `came` (n,) is the sign of its last motion before each row.
    """
    ratio = found.p[7 + motor]
    behind = np.zeros_like(found.rows.q)
    behind[:, motor] = -came / 2 * STEP / ratio
    ends = []
    for shift in (behind, -behind):
        rows = replace(found.rows, q=found.rows.q + shift)
        off, _ = residuals(found.p, rows, found.assembly, derive=False)
        ends.append(off)
    later, earlier = ends
    slope = (later - earlier) / (2 * STEP)
    return slope * found.weight


def told(found: Calibration) -> list[str]:
    """Return a sentence for each motor whose backlash is clear."""
    words = []
    both = backlashes(found) or ()
    for motor, backlash in enumerate(both, 1):
        if backlash.clear:
            degrees = math.degrees(backlash.value)
            size = f"about {degrees:.2g}° of backlash in motor {motor}"
            words.append(f"the residuals depend on the direction of approach: {size}")
    return words
