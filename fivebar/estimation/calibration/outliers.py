"""Rows against all others: leave-one-out error and outliers, from the leverage of each."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, fdtrc

CHANCE = 0.01  # of naming a good row, in all rows together
FULL = 1e-9  # a row whose leverage leaves less than this is told by itself alone


def left_out(off: np.ndarray, left: np.ndarray, row_of: np.ndarray, weight: np.ndarray) -> float:
    """RMS, m, of the misses of rows that a fit of all others (to first order) predicts: (1 -
    H_rr)^-1 e_r.

    off (m,) weighted; left (m, rank): orthonormal columns that span the Jacobian's; row_of (m,);
    inf where a row tells something that no other does.
    """
    total = 0.0
    for own in _numbers_of(row_of).values():
        rest = np.eye(len(own)) - left[own] @ left[own].T
        if np.linalg.eigvalsh(rest)[0] < FULL:
            return np.inf
        total += float(np.sum((np.linalg.solve(rest, off[own]) / weight[own]) ** 2))
    return float(np.sqrt(total / len(off)))


def _numbers_of(row_of):
    """{row: places of its numbers}."""
    order = np.argsort(row_of, kind="stable")
    rows, first = np.unique(row_of[order], return_index=True)
    return dict(zip(rows.tolist(), np.split(order, first[1:])))


def off_rows(
    off: np.ndarray, jacobian: np.ndarray, rank: int, row_of: np.ndarray, absolute: bool
) -> dict[int, float]:
    """Rows that are off: {row: p}, of externally studentized residuals, times the rows
    (Bonferroni).

    One at a time, the worst first, and the others are fitted again without it: one bad row hides or
    blames another.
    """
    found: dict[int, float] = {}
    rows = np.unique(row_of)
    for _ in range(max(1, len(rows) // 4)):
        kept = ~np.isin(row_of, list(found))
        left, s, right = np.linalg.svd(jacobian[kept], full_matrices=False)
        own_rank = min(rank, int((s > 1e-12 * s[0]).sum()))
        left = left[:, :own_rank]
        rest = off[kept] - left @ (left.T @ off[kept])
        square, dof, of = float(rest @ rest), int(kept.sum()) - own_rank, row_of[kept]
        worst = None
        if square <= (1e-13 * np.abs(off).sum()) ** 2:
            break
        for row, own in _numbers_of(of).items():
            leverage = np.eye(len(own)) - left[own] @ left[own].T
            if np.linalg.eigvalsh(leverage)[0] < FULL:
                continue
            gain = float(rest[own] @ np.linalg.solve(leverage, rest[own]))
            spare = dof - len(own)
            if absolute:
                chance = float(chdtrc(len(own), gain))
            elif spare > 0:
                ratio = gain / len(own) / max((square - gain) / spare, 1e-300)
                chance = float(fdtrc(len(own), spare, ratio))
            else:
                continue
            if worst is None or (chance, -gain) < worst[1:]:
                worst = row, chance, -gain
        if worst is None or worst[1] * len(rows) >= CHANCE:
            break
        found[int(worst[0])] = worst[1] * len(rows)
    return found
