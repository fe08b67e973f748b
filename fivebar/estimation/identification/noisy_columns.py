"""How far noise of the positions bends a regression whose columns are made of it.

With accelerations q'' + n the columns are W + sum_j W_j n_j, W_j the inertial columns of joint j,
and least squares gives theta off by -(W^T W)^-1 N theta, N = sum of W_j^T W_j var n_j: most where
columns are nearly dependent. The variance of n grows with the fifth power of the cut-off: a lower
one is the cure.
"""

from __future__ import annotations

import numpy as np

from .regression import Fit
from .regressor import regressor
from .samples import Samples, rough

POSES = 200


def bias(found: list[Samples], columns: list[int], full: Fit) -> np.ndarray:
    """Size of what each of the columns' values is off by, (p,), in its standard deviations."""
    total, inertia = 0.0, 0.0
    for sample in found:
        used = [counts.any(axis=1) for *_, counts in sample.pieces]
        q = np.concatenate([rates[0][own] for rates, own in zip(sample.motion, used)])
        rows = sample.rows.counts.sum(axis=0)
        q = q[:: max(len(q) // POSES, 1)]
        if not len(q):
            continue
        still = np.zeros_like(q)
        at_rest = regressor(sample.robot, q, still, still, sample.assembly)
        for joint, noise in enumerate(sample.noise):
            moved = still.copy()
            moved[:, joint] = noise * rough(sample.step, sample.cutoff)
            W = (regressor(sample.robot, q, still, moved, sample.assembly) - at_rest)[:, :, columns]
            weighted = W * (np.sqrt(rows / len(q)) / full.sigma)[:, None]
            inertia = inertia + np.einsum("nmp,nmq->pq", weighted, weighted)
        total += len(q)
    if not total:
        return np.zeros(len(columns))
    return np.abs(full.cov @ inertia @ full.theta) / np.sqrt(np.diag(full.cov))
