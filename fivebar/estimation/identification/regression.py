"""Weighted linear regression by QR, its honest covariance, and the smallest model that the data do
not reject.

Residuals of measured motions may be neither white nor of one size. Standard deviations are those of
white residuals, or those of Newey and West (1987), which ask for neither, but are too small of few
rows: the larger of both. A set R of parameters is left out at the cost theta_R^T C_RR^-1 theta_R
(Wald), a chi square of as many degrees of freedom where they are 0; each that stays costs log n + 3
log p (the extended BIC of Chen and Chen 2008 with gamma = 3/2; n rows, p
candidates: of 14 that are 0 one stays in about 0.3 % of the logs). The chosen model has the lowest
    cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from .filtering import Rows

# Rows: with more, two threads of OpenBLAS wait for each other, up to 100 ms on a busy machine.
BLOCK = 64
FINEST = (
    1e-5  # of a motor's torque: no log is believed to be better, a simulated one's own rows are not
)


@dataclass(frozen=True, eq=False)
class Fit:
    """theta (p,), cov (p, p), of the given columns; residual (n, 2), 0 where a row does not count;
    sigma (2,) N m, the standard deviation of each motor's rows; misfit: rms of both motors'
    residuals in units of the torques' own rms.
    """

    theta: np.ndarray
    cov: np.ndarray
    residual: np.ndarray
    sigma: np.ndarray
    misfit: float


def fit(rows: Rows, columns: list[int], tau: np.ndarray | None = None) -> Fit:
    """Least squares of these columns; each motor's weight by its own residuals. tau: in place of
    the rows' own.
    """
    tau = rows.tau if tau is None else tau
    W = rows.W[:, :, columns]
    size = np.maximum(
        np.sqrt((tau**2).sum(axis=0) / np.maximum(rows.counts.sum(axis=0), 1)), 1e-300
    )
    sigma = size.copy()
    free = np.maximum(rows.counts.sum(axis=0) - len(columns) / 2, 1)
    # each motor's rows as a triangle: weights are put on that
    halves = [triangle(np.column_stack([W[:, k], tau[:, k]])) for k in (0, 1)]
    for _ in range(3):
        theta, R, scales = _solve(
            np.concatenate([half / each for half, each in zip(halves, sigma)])
        )
        missed = np.array([np.linalg.norm(half[:, -1] - half[:, :-1] @ theta) for half in halves])
        sigma = np.maximum(missed / np.sqrt(free), FINEST * size)
    residual = np.where(rows.counts, tau - W @ theta, 0.0)
    inverse = np.linalg.inv(R) / scales[:, None]
    bread = inverse @ inverse.T
    scores = np.einsum("nmp,nm->np", W / sigma[:, None], residual / sigma)
    robust = bread @ _meat(scores, rows.breaks) @ bread * (free.sum() + len(columns)) / free.sum()
    more = np.sqrt(np.maximum(np.diag(robust) / np.diag(bread), 1.0))
    cov = bread * np.outer(more, more)
    misfit = float(
        np.sqrt(np.mean((residual**2).sum(axis=0) / np.maximum((tau**2).sum(axis=0), 1e-300)))
    )
    return Fit(theta, cov, residual, sigma, misfit)


def _solve(flat):
    scales = np.maximum(np.linalg.norm(flat[:, :-1], axis=0), 1e-300)
    Q, R = np.linalg.qr(flat[:, :-1] / scales)
    return np.linalg.solve(R, Q.T @ flat[:, -1]) / scales, R, scales


def triangle(flat: np.ndarray) -> np.ndarray:
    """R of the QR decomposition of a tall matrix (n, p): of blocks of rows first, then of their
    triangles.
    """
    rows, columns = flat.shape
    if rows <= max(BLOCK, 2 * columns):
        return np.linalg.qr(flat, mode="r")
    size = max(BLOCK, 2 * columns)
    padded = np.zeros((-(-rows // size), size, columns))
    padded.reshape(-1, columns)[:rows] = flat
    return triangle(np.linalg.qr(padded, mode="r").reshape(-1, columns))


def _meat(scores, breaks):
    """Sum of products of scores up to some rows apart, with Bartlett's weights; pieces of a log are
    apart.
    """
    lags = int(4 * (len(scores) / 100) ** (2 / 9))
    ends = [*breaks[1:], len(scores)]
    total = scores.T @ scores
    for lag in range(1, lags + 1):
        products = sum(
            scores[first : end - lag].T @ scores[first + lag : end]
            for first, end in zip(breaks, ends)
            if end - first > lag
        )
        total = total + (1 - lag / (lags + 1)) * (products + np.transpose(products))
    return total


def price(rows: int, candidates: int) -> float:
    """What a parameter costs that stays."""
    return float(np.log(max(rows, 2)) + 3 * np.log(max(candidates, 1)))


def smallest(
    theta: np.ndarray, cov: np.ndarray, optional: list[int], each: float, forbidden=()
) -> list[int]:
    """Which of the optional columns the lowest cost keeps: by leaving out, taking in again, and
    exchanging one by one.

    each: the price of one; forbidden: columns that never stay.
    """
    out = set(forbidden)

    def cost(left_out):
        return left_out_cost(theta, cov, sorted(left_out)) + each * (len(optional) - len(left_out))

    now = cost(out)
    while True:
        inside = [k for k in optional if k not in out]
        steps = [out | {k} for k in inside] + [out - {k} for k in out if k not in forbidden]
        steps += [out - {k} | {i} for k in out if k not in forbidden for i in inside]
        best = min(steps, key=cost, default=out)
        if not cost(best) < now - 1e-9:
            return [k for k in optional if k not in out]
        out, now = best, cost(best)


def left_out_cost(theta: np.ndarray, cov: np.ndarray, left_out: list[int]) -> float:
    """theta_R^T C_RR^-1 theta_R."""
    if not left_out:
        return 0.0
    part = theta[left_out]
    scale = np.sqrt(np.diag(cov)[left_out])
    block = cov[np.ix_(left_out, left_out)] / np.outer(scale, scale)
    block = block + 1e-12 * np.eye(len(left_out))
    return float((part / scale) @ cho_solve(cho_factor(block), part / scale))


def spread(full: Fit, kept: list[int], last: Fit) -> np.ndarray:
    """Covariance (k, k) of the kept parameters where the others may not be 0, though they are left
    out.

    Leaving out moves a value by b and its variance from that of the full model to that of the last
    fit, whose deviation holds if all that is left out is 0. The mean square of the error is
    estimated by var_last + b^2, or var_full where that is more; correlations are those of the full
    model.
    """
    whole = full.cov[np.ix_(kept, kept)]
    moved = full.theta[kept] - last.theta
    scale = np.sqrt(np.maximum((np.diag(last.cov) + moved**2) / np.diag(whole), 1.0))
    return whole * np.outer(scale, scale)
