"""Weighted linear regression by QR, its covariance, and the smallest model that the data allow.

Noise of encoders becomes torque by the square of its frequency, so that residuals are not white:
neighbours tend to cancel, most where friction and slow motions act. Each row is taken minus what
the residual before foretells of its own [Cochrane1949]_, which leaves white noise. Deviations do
not ask for noise of one size: they are of residuals, each of a fit without its row (HC3
[MacKinnon1985]_), as near a singularity a few rows, with the most noise, draw the fit to them.

Noise of the encoders is in the columns, too: least squares of W + D instead of W, both white, gives
theta off by -(W^T W)^-1 D^T D theta [Fuller1987]_, most where columns are nearly dependent. D of a
second draw of the noise, through the same filters, foretells this bias. It is taken off, and counts
in the deviations as a whole, as real noise is not quite that of the draw.

A set R of parameters is left out at the cost theta_R^T C_RR^-1 theta_R (Wald), a chi square of as
many degrees of freedom where they are 0. Each that stays costs log n + 3 log p (the extended BIC
[Chen2008]_ with gamma = 3/2; n rows, p candidates: of 14 that are 0 one stays in about 0.3 % of the
logs). The chosen model has the lowest cost.

.. [Cochrane1949] D. Cochrane, G. Orcutt, Application of least squares regression to relationships
   containing auto-correlated error terms, 1949.
.. [Fuller1987] W. Fuller, Measurement error models, 1987.
.. [MacKinnon1985] J. MacKinnon, H. White, Some heteroskedasticity-consistent covariance matrix
   estimators with improved finite sample properties, 1985.
.. [Chen2008] J. Chen, Z. Chen, Extended Bayesian information criteria, 2008.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import ndarray
from scipy.linalg import cho_factor, cho_solve

from .filtering import RegressionRows

FINEST = 1e-5  # of a motor's torque: the least noise that is believed
WHITENED = 2  # times that residuals are made white, each by the fit before
RETURNED = 4  # times that the bias is computed, each of the theta that the last one gives
LEAST_FREE = 0.05  # of a row's own residual that a fit is taken to leave


@dataclass(frozen=True, eq=False)
class RegressionFit:
    """A regression: theta (p,) and cov (p, p) of its columns.

    residual (n, 2), 0 where a row does not count; sigma (2,) N m: the standard deviation of each
    motor's rows; misfit: rms of both motors' residuals in units of the torques' own rms; bias (p,):
    what noise in the columns took from theta, which has it back, in standard deviations.
    """

    theta: ndarray
    cov: ndarray
    residual: ndarray
    sigma: ndarray
    misfit: float
    bias: ndarray


def fit(rows: RegressionRows, columns: list[int]) -> RegressionFit:
    """Return least squares of these columns, each motor weighted by its own residuals."""
    tau = rows.tau
    W = rows.W[:, :, columns]
    change = np.zeros_like(W) if rows.change is None else rows.change[:, :, columns]
    counts = rows.counts.sum(axis=0)
    power = (tau**2).sum(axis=0)
    size = np.maximum(np.sqrt(power / np.maximum(counts, 1)), 1e-300)
    free = np.maximum(counts - len(columns) / 2, 1)
    system = np.concatenate([change, W, tau[..., None]], axis=2)
    p = len(columns)
    theta, *_ = _weighted(system[..., p:], size, free)
    for _ in range(WHITENED):
        residual = np.where(rows.counts, tau - W @ theta, 0.0)
        white = _whitened(system, residual, rows.breaks)
        theta, bread, sigma = _weighted(white[..., p:], size, free)
    weighted = white / sigma[:, None]
    weighted_W = weighted[..., p:-1]
    leverage = ((weighted_W @ bread) * weighted_W).sum(axis=2)
    error = weighted[..., -1] - weighted_W @ theta
    left_out = error / np.maximum(1.0 - leverage, LEAST_FREE)  # of a fit without the row
    scores = np.einsum("nmp,nm->np", weighted_W, left_out)
    influence = scores @ bread
    robust = influence.T @ influence
    weighted_change = weighted[..., :p].reshape(-1, p)
    lost = bread @ (weighted_change.T @ weighted_change)
    bias = np.zeros(p)
    for _ in range(RETURNED):
        bias = lost @ (theta + bias)
    theta = theta + bias
    residual = np.where(rows.counts, tau - W @ theta, 0.0)
    rms = np.maximum(np.sqrt((residual**2).sum(axis=0) / free), FINEST * size)
    shares = (residual**2).sum(axis=0) / np.maximum(power, 1e-300)
    misfit = float(np.sqrt(np.mean(shares)))
    of_sd = np.abs(bias) / np.sqrt(np.diag(robust))
    cov = robust + np.outer(bias, bias)
    return RegressionFit(theta, cov, residual, rms, misfit, of_sd)


def _weighted(system, size, free):
    """Return least squares of [W, tau] (n, 2, p + 1), its (W^T W)^-1 in sigmas, and sigma (2,)."""
    # Each motor's rows as a triangle, on which the weights are put.
    triangles = [np.linalg.qr(system[:, k], mode="r") for k in (0, 1)]
    sigma = size.copy()
    for _ in range(3):
        weighted = [own / each for own, each in zip(triangles, sigma)]
        theta, R, scales = _solve(np.concatenate(weighted))
        missed = [np.linalg.norm(own[:, -1] - own[:, :-1] @ theta) for own in triangles]
        sigma = np.maximum(np.array(missed) / np.sqrt(free), FINEST * size)
    inverse = np.linalg.inv(R) / scales[:, None]
    return theta, inverse @ inverse.T, sigma


def _whitened(system, residual, breaks):
    """Return each row minus the row before it, as much as their residuals are alike."""
    follows = np.ones((len(system), 1))
    follows[list(breaks)] = 0.0
    before = follows * np.roll(residual, 1, axis=0)
    products = (before * residual).sum(axis=0)
    factor = products / np.maximum((before**2).sum(axis=0), 1e-300)
    return system - (factor * follows)[..., None] * np.roll(system, 1, axis=0)


def _solve(flat):
    """Return theta of [W, tau], and R and the scales of W's columns, by QR."""
    scales = np.maximum(np.linalg.norm(flat[:, :-1], axis=0), 1e-300)
    Q, R = np.linalg.qr(flat[:, :-1] / scales)
    return (np.linalg.solve(R, Q.T @ flat[:, -1]) / scales, R, scales)


def price(rows: int, candidates: int) -> float:
    """Return what a parameter costs that stays."""
    return float(np.log(max(rows, 2)) + 3 * np.log(max(candidates, 1)))


def smallest(
    theta: ndarray, cov: ndarray, optional: list[int], each: float, forbidden=()
) -> list[int]:
    """Return the optional columns that the set of lowest cost keeps.

    Columns are left out and taken in again one by one while the cost falls. `each` is
    the price of one; `forbidden` columns never stay.
    """
    out = set(forbidden)

    def cost(left_out):
        return left_out_cost(theta, cov, sorted(left_out)) + each * (len(optional) - len(left_out))

    while True:
        inside = [k for k in optional if k not in out]
        back = [k for k in out if k not in forbidden]
        steps = [out | {k} for k in inside]
        steps += [out - {k} for k in back]
        best = min(steps, key=cost, default=out)
        if cost(best) >= cost(out) - 1e-9:
            return inside
        out = best


def left_out_cost(theta: ndarray, cov: ndarray, left_out: list[int]) -> float:
    """Return theta_R^T C_RR^-1 theta_R."""
    if not left_out:
        return 0.0
    scale = np.sqrt(np.diag(cov)[left_out])
    part = theta[left_out] / scale
    block = cov[np.ix_(left_out, left_out)] / np.outer(scale, scale)
    return float(part @ cho_solve(cho_factor(block + 1e-12 * np.eye(len(left_out))), part))


def spread(full: RegressionFit, kept: list[int], last: RegressionFit) -> ndarray:
    """Return the covariance (k, k) of the kept parameters where the others may not be 0.

    Leaving out moves a value by b and its variance from that of the full model to that of the last
    fit, whose deviation holds if all that is left out is 0. The mean square of the error is
    estimated by var_last + b^2: where what is left out is 0, the mean of b^2 is
    var_full - var_last. Correlations are those of the full model.
    """
    whole = full.cov[np.ix_(kept, kept)]
    moved = full.theta[kept] - last.theta
    scale = np.sqrt((np.diag(last.cov) + moved**2) / np.diag(whole))
    return whole * np.outer(scale, scale)
