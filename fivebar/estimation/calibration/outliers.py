"""Compare rows with all others, by the leverage of each: which are outliers."""

from __future__ import annotations

import numpy as np
from numpy import ndarray
from scipy.special import chdtrc, fdtrc

CHANCE = 0.01  # probability of naming a good row, in all rows together
FULL = 1e-9  # a row whose leverage leaves less than this is told by itself alone


def outlying_rows(
    off: ndarray, jacobian: ndarray, rank: int, row_of: ndarray, absolute: bool
) -> dict[int, float]:
    """Return outlying rows as {row: p}, of externally studentized residuals, p times the rows.

    One at a time, the worst first; the others are fitted again without it, as one bad row hides or
    blames another.
    """
    found: dict[int, float] = {}
    count = len(np.unique(row_of))
    for _ in range(max(1, count // 4)):
        kept = ~np.isin(row_of, list(found))
        left, s, _ = np.linalg.svd(jacobian[kept], full_matrices=False)
        left = left[:, : min(rank, int((s > 1e-12 * s[0]).sum()))]
        rest = off[kept] - left @ (left.T @ off[kept])
        if rest @ rest <= (1e-13 * np.abs(off).sum()) ** 2:
            break
        chances = _chances(rest, left, row_of[kept], absolute)
        if not chances or chances[0][0] * count >= CHANCE:
            break
        chance, _, row = chances[0]
        found[row] = chance * count
    return found


def _chances(rest, left, row_of, absolute):
    """Return (probability of such a row by chance, -its part of chi2, row), the worst row first."""
    square = float(rest @ rest)
    dof = len(rest) - left.shape[1]
    chances = []
    for row in np.unique(row_of).tolist():
        own = np.flatnonzero(row_of == row)
        leverage = np.eye(len(own)) - left[own] @ left[own].T
        spare = dof - len(own)
        if np.linalg.eigvalsh(leverage)[0] < FULL or (spare <= 0 and not absolute):
            continue
        gain = float(rest[own] @ np.linalg.solve(leverage, rest[own]))
        if absolute:
            chance = chdtrc(len(own), gain)
        else:
            ratio = gain / len(own) / max((square - gain) / spare, 1e-300)
            chance = fdtrc(len(own), spare, ratio)
        chances.append((float(chance), -gain, row))
    return sorted(chances)
