"""Rows of a regression, tau = W theta, out of samples: the same filter over both sides.

The equation holds at every sample, so it holds for any weighted sum of samples, without bias. What
must not count (at a singularity, where a motor with dry friction hardly turns) is 0 on both sides
before the filter. The filter is a low-pass, as what is above the cut-off is noise, and leaves so
few rows that their noise is nearly white.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy import ndarray
from scipy.ndimage import binary_opening
from scipy.signal import firwin, kaiserord, upfirdn

RIPPLE = 60.0  # dB


@dataclass(frozen=True, eq=False)
class RegressionRows:
    """Rows of a regression.

    W (n, 2 motors, p); tau (n, 2) N m; counts (n, 2) bool: what is used; t (n,) s; cover (n, 2):
    the weight of the samples that count, by whose root both sides are divided, so that all rows are
    as noisy; breaks: first row of each piece; gain: of white noise from a sample to a row; change
    (n, 2, p): of W, by noise of the encoders drawn anew.
    """

    W: ndarray
    tau: ndarray
    counts: ndarray
    t: ndarray
    cover: ndarray
    breaks: tuple[int, ...]
    gain: float
    change: ndarray | None = None


def filtered(pieces: Iterable[tuple], step: float, cutoff: float) -> RegressionRows:
    """Return the rows of pieces (t (n,), W (n, 2, p), tau (n, 2), counts (n, 2)) of samples.

    Samples are `step` s apart; a row is made of 1 / (2.5 cutoff) s.
    """
    down = max(int(1 / (2.5 * cutoff * step)), 1)
    width = min(1.5 * cutoff * step, 0.9)
    taps, beta = kaiserord(RIPPLE, width)
    half = taps // 2
    kernel = firwin(2 * half + 1, min(1.25 * cutoff * step * 2, 0.95), window=("kaiser", beta))
    first = -half % down  # so that a kept row is at a sample
    parts = []
    breaks = []
    rows = 0
    for t, W, tau, counts in pieces:
        inside = counts[..., None]
        both = np.concatenate([W, tau[..., None], inside.astype(float)], axis=2)
        both = np.where(inside, both, 0.0)
        padded = np.concatenate([np.zeros((first, *both.shape[1:])), both])
        out = upfirdn(kernel, padded, 1, down, axis=0)
        at = np.arange(len(out)) * down - half - first
        good = (at >= 0) & (at < len(t))
        out = out[good]
        at = at[good]
        cover = out[..., -1]
        keep = cover > 0.2 * np.clip(cover.max(axis=0, initial=0.0), 1e-9, 1.0)
        scale = np.where(keep, 1 / np.sqrt(np.where(keep, cover, 1.0)), 0.0)
        parts.append((scale[..., None] * out[..., :-2], scale * out[..., -2], keep, t[at], cover))
        breaks.append(rows)
        rows += len(at)
    W, tau, keep, t, cover = (np.concatenate(part) for part in zip(*parts))
    return RegressionRows(W, tau, keep, t, cover, tuple(breaks), float(np.linalg.norm(kernel)))


def at_limit(tau: ndarray, low: ndarray, high: ndarray) -> ndarray:
    """Return where torques (n, 2) stay at an extreme value (2,) for 2 rows more than at others.

    Of others, the median counts: 1 row, or as many as a drive holds a torque.
    """
    near = 1e-9 * np.maximum(np.maximum(np.abs(low), np.abs(high)), 1e-300)
    flat = (np.abs(tau - high) <= near) | (np.abs(tau - low) <= near)
    limited = np.zeros_like(flat)
    for k, column in enumerate(tau.T):
        starts = np.flatnonzero(np.diff(column, prepend=np.nan) != 0)
        lengths = np.diff(starts, append=len(column))
        others = lengths[~flat[starts, k]]
        usual = int(np.median(np.repeat(others, others))) if len(others) else 1
        limited[:, k] = binary_opening(flat[:, k], np.ones(usual + 2))
    return limited
