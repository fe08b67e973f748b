"""Backlash of the motors, from residuals that depend on the direction of approach.

Where a motor came to a row turning to the left, its joint is behind it by half of the backlash, and
ahead by as much where it came turning to the right. Rows in the order in which they were measured
tell which: a step of the calibration with both backlashes among the unknowns finds their sizes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy import ndarray

from .fit import residuals
from .measured_robot import OFFSETS
from .outliers import outlying_rows

if TYPE_CHECKING:
    from .result import Calibration

STILL = 1e-9  # rad, a motor that moved less did not
CLEAR = 5.0  # standard deviations: a smaller backlash is not named
RCOND = 1e-10  # of the largest singular value: smaller ones count as zero
SPARE = 4  # numbers beyond the unknowns that are needed


def backlashes(found: Calibration) -> tuple[ndarray, ndarray] | None:
    """Return the backlashes of both motors and their deviations, rad; None where no rows tell them.

    Half of it is an offset, to the one side or the other: rows with distances have two of them.
    """
    rows = found.rows
    before = np.diff(rows.q, axis=0, prepend=rows.q[:1])
    came = np.sign(before) * (np.abs(before) > STILL)
    off, jacobian = found._with_prior
    numbers, unknowns = jacobian.shape
    one_way = (came == came[-1]).all(axis=0).any()
    if one_way or numbers < unknowns + 2 + SPARE or len(rows.measured[2]):
        return None
    slopes = residuals(found.p, rows, found.assembly)[1][:, OFFSETS]
    columns = np.zeros((numbers, 2))
    columns[: len(slopes)] = -came[rows.row_of] / 2 * slopes * found.weight[:, None]
    together = np.hstack([jacobian, columns])
    # Rows that are wrong though there may be backlash would else pass for it.
    own = slice(len(slopes))
    wrong = list(outlying_rows(off[own], together[own], unknowns + 2, rows.row_of, found.absolute))
    kept = np.append(~np.isin(rows.row_of, wrong), np.ones(numbers - len(slopes), bool))
    off, together = off[kept], together[kept]
    inverse = np.linalg.pinv(together, RCOND)
    step = -inverse @ off
    rest = off + together @ step
    variance = 1.0 if found.absolute else float(rest @ rest) / (len(off) - unknowns - 2)
    return step[-2:], np.sqrt((inverse[-2:] ** 2).sum(axis=1) * variance)


def told(found: Calibration) -> list[str]:
    """Return a sentence for each motor whose backlash is clear."""
    if (both := backlashes(found)) is None:
        return []
    return [
        f"the residuals depend on the direction of approach: about {np.degrees(value):.2g}° of"
        f" backlash in motor {motor}"
        for motor, value, sd in zip((1, 2), *both)
        if value > CLEAR * sd
    ]
