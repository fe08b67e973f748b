"""How far noise of the positions bends a regression whose columns are made of it.

With accelerations q'' + n the columns are W + sum_j W_j n_j, W_j the inertial columns of joint j,
and least squares gives theta off by -(W^T W)^-1 N theta, N = sum of W_j^T W_j var n_j: most where
columns are nearly dependent. The variance of n grows with the fifth power of the cut-off, so a
lower one is the cure.
"""

from __future__ import annotations

import numpy as np
from numpy import ndarray

from .regression import RegressionFit
from .regressor import regressor
from .samples import Samples, noise_gain


def bias(found: list[Samples], columns: list[int], full: RegressionFit) -> ndarray:
    """Return by how many standard deviations each value (p,) is off."""
    inertia = np.zeros((len(columns), len(columns)))
    for sample in found:
        used = [counts.any(axis=1) for *_, counts in sample.pieces]
        q = np.concatenate([motion[0][own] for motion, own in zip(sample.motion, used)])
        q = q[:: max(len(q) // 200, 1)]
        if not len(q):
            continue
        weight = np.sqrt(sample.rows.counts.sum(axis=0) / len(q)) / full.sigma
        still = np.zeros_like(q)
        at_rest = regressor(sample.robot, q, still, still, sample.assembly)
        for joint, noise in enumerate(sample.noise):
            moved = still.copy()
            moved[:, joint] = noise * noise_gain(sample.step, sample.cutoff)
            change = regressor(sample.robot, q, still, moved, sample.assembly) - at_rest
            weighted = change[:, :, columns] * weight[:, None]
            inertia += np.einsum("nmp,nmq->pq", weighted, weighted)
    bias = full.cov @ inertia @ full.theta
    sd = np.sqrt(np.diag(full.cov))
    return np.abs(bias) / sd
