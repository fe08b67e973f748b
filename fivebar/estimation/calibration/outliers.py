"""Compare rows with all others, by the leverage of each: leave-one-out error and outliers."""

from __future__ import annotations

import numpy as np
from numpy import ndarray
from scipy.special import chdtrc, fdtrc

CHANCE = 0.01  # probability of naming a good row, in all rows together
FULL = 1e-9  # a row whose leverage leaves less than this is told by itself alone


def leave_one_out_error(off: ndarray, left: ndarray, row_of: ndarray, weight: ndarray) -> float:
    """Return the RMS, m, with which a fit of all others predicts a row, to first order.

    (1 - H_rr)^-1 e_r, with the leverages H = left left'.

    Parameters
    ----------
    off : (m,) array
        Weighted residuals.
    left : (m, rank) array
        Orthonormal columns that span the Jacobian's.
    row_of : (m,) array of int
        The row of each number.
    weight : (m,) array
        1 / sigma of each number.

    Returns
    -------
    float
        inf where a row tells something that no other does.
    """
    total = 0.0
    for _, own, rest in _rests(left, row_of):
        if np.linalg.eigvalsh(rest)[0] < FULL:
            return np.inf
        missed = np.linalg.solve(rest, off[own]) / weight[own]
        total += float(missed @ missed)
    return float(np.sqrt(total / len(off)))


def _rests(left, row_of):
    """Yield each row, the places of its numbers, and I - H of these."""
    for row in np.unique(row_of).tolist():
        own = np.flatnonzero(row_of == row)
        yield row, own, np.eye(len(own)) - left[own] @ left[own].T


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
    for row, own, leverage in _rests(left, row_of):
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
