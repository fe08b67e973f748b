"""Rows of a regression, tau = W theta, out of samples: both sides by the same filter, so that it
leaves no bias.

The equation holds at every sample, so it holds for any weighted sum of samples. What must not count
(at a singularity, where a motor with dry friction hardly turns, where the torque is cut off) is 0
on both sides before the filter; it is a low-pass, as what is above the cut-off is noise, and it
leaves so few rows that their noise is nearly white.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import firwin, upfirdn

PASS, RATE, RIPPLE = 1.25, 2.5, 60.0  # of the cut-off: the filter's own, and rows per second; dB
AROUND, OUT, OF_RANGE, FEW = (
    7,
    30.0,
    0.25,
    0.01,
)  # rows; of their usual distance, of the range; of all rows
COVERED = 0.2  # of a row's weight that must be of samples that count


@dataclass(frozen=True, eq=False)
class Rows:
    """W (n, 2 motors, p), tau (n, 2) N m; counts (n, 2) bool: what is used; t (n,) s; cover (n, 2):
    the weight of the samples that count, by whose root both sides are divided, so that all rows are
    as noisy; breaks: first row of each piece; share: of the samples, per motor, that count; gain:
    of white noise from a sample to a row.
    """

    W: np.ndarray
    tau: np.ndarray
    counts: np.ndarray
    t: np.ndarray
    cover: np.ndarray
    breaks: tuple[int, ...]
    share: tuple[float, float]
    gain: float


def filtered(pieces: Iterable[tuple], step: float, cutoff: float) -> Rows:
    """Rows of pieces (t (n,), W (n, 2, p), tau (n, 2), counts (n, 2) bool), in samples `step` s
    apart.
    """
    down = max(int(1 / (RATE * cutoff * step)), 1)
    width = min(0.75 * cutoff * step * 2, 0.9)
    # Kaiser's estimate of the length
    half = int(np.ceil((RIPPLE - 7.95) / (2.285 * np.pi * width) / 2))
    kernel = firwin(
        2 * half + 1,
        min(PASS * cutoff * step * 2, 0.95),
        window=("kaiser", 0.1102 * (RIPPLE - 8.7)),
    )
    parts, breaks, rows = [], [], 0
    used, total = np.zeros(2), 0
    for t, W, tau, counts in pieces:
        n = len(t)
        inside = counts[..., None]
        both = np.where(
            inside, np.concatenate([W, tau[..., None], inside.astype(float)], axis=2), 0.0
        )
        first = -half % down  # so that a kept row is at a sample
        out = upfirdn(
            kernel, np.concatenate([np.zeros((first, *both.shape[1:])), both]), 1, down, axis=0
        )
        at = np.arange(len(out)) * down - half - first
        good = (at >= 0) & (at < n)
        out, at = out[good], at[good]
        cover = out[..., -1]
        keep = cover > COVERED
        scale = np.where(keep, 1 / np.sqrt(np.where(keep, cover, 1.0)), 0.0)[..., None]
        parts.append((scale * out[..., :-2], (scale * out[..., -2:-1])[..., 0], keep, t[at], cover))
        breaks.append(rows)
        rows += len(at)
        used, total = used + counts.sum(axis=0), total + n
    W, tau, keep, t, cover = (np.concatenate(each) for each in zip(*parts))
    share = used / max(total, 1)
    return Rows(
        W,
        tau,
        keep,
        t,
        cover,
        tuple(breaks),
        (float(share[0]), float(share[1])),
        float(np.linalg.norm(kernel)),
    )


def spikes(column: np.ndarray) -> np.ndarray:
    """Where (n,) a few rows of a column leave those around them, as a step or a peak of the motion
    does not.

    They are far from the median of the rows about them, by the usual distance and by the range;
    none where many are.
    """
    known = np.isfinite(column)
    if known.sum() < AROUND:
        return np.zeros(len(column), dtype=bool)
    filled = np.interp(np.arange(len(column)), np.flatnonzero(known), column[known])
    smooth = median_filter(filled, AROUND, mode="nearest")
    apart = np.abs(filled - smooth)
    found = known & (apart > np.maximum(OUT * np.median(apart), OF_RANGE * np.ptp(smooth)))
    return found & (found.mean() <= FEW)
