"""Differentiate a sampled motion without phase: polynomials of degree 6 in a window about each row.

Least squares of a polynomial over 2 n + 1 rows is a symmetric filter: it shifts nothing in time
[Savitzky1964]_, [Schafer2011]_. The window is the longest that still gives position, rate and
acceleration of a sine at the cut-off to 1e-3.

The cut-off is where the motion sinks into its noise. P(f) is the spectrum of q, from that of its
second differences. Its median at the highest frequencies is the floor of the encoders' noise. Slow
motions make counts that stay for many rows, whose noise falls by 4 from octave to octave, where
motions fall by 64: the floor rises towards low frequencies as long as P rises so little. The motion
ends at the highest frequency where P is more than 20 times the floor, or at 4 times the frequency
below which nearly all of its acceleration is: torques are products of few of its waves.

.. [Savitzky1964] A. Savitzky, M. Golay, Smoothing and differentiation of data by simplified least
   squares procedures, 1964.
.. [Schafer2011] R. Schafer, What is a Savitzky-Golay filter?, 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy import ndarray
from numpy.polynomial import chebyshev

DEGREE = 6
FIDELITY = 1e-3  # largest relative error of a sine's derivatives at the cut-off
MOST = 500  # rows on either side
HIGHEST = 1 / 12  # of the sampling rate: the highest cut-off
CLEAR = 20.0  # times the noise's median: none of 1e6 bins of one period, again and again, is there
ROUNDING = 0.06  # of its variance: most of it is at higher frequencies than those of the motion
RISE = 10.0  # of a spectrum from octave to octave: below, it is noise


@dataclass(frozen=True)
class Spectrum:
    """What a motion's spectrum says.

    cutoff: Hz; noise: standard deviation of q's noise, of both joints; fast: the share of the
    acceleration's power at frequencies that the sampling rate cannot follow, of the worse joint.
    """

    cutoff: float
    noise: tuple[float, float]
    fast: float


def spectrum(pieces: Sequence[ndarray], step: float) -> Spectrum:
    """Return the Spectrum of the pieces (n, 2) of a motion, in rows `step` s apart."""
    from scipy.signal import welch  # half a second to load, and a simulated run needs none of it

    rate = 1 / step
    window = max(16, min(4096, 2 * max(map(len, pieces)) // 8))
    power = np.zeros(())
    weight = 0
    for piece in pieces:
        if len(piece) >= window + 2:
            second = np.diff(piece, 2, axis=0)
            f, density = welch(second, rate, nperseg=window, axis=0, detrend=False)
            power = power + len(piece) * density
            weight += len(piece)
    if not weight:
        return Spectrum(HIGHEST * rate, (0.0, 0.0), 0.0)
    f = f[1:]
    power = power[1:] / weight
    position = power / (2 * np.sin(np.pi * f * step))[:, None] ** 4  # q is differenced twice
    edge = 0.3 * rate
    level = np.median(position[f > edge], axis=0)
    floor = np.tile(level, (len(f), 1))
    while (octave := (f > edge / 2) & (f <= edge)).sum() > 2:
        median = np.median(position[octave], axis=0)
        level = np.where((median > 2 * level) & (median < RISE * level), median, level)
        floor[f <= edge] = level
        edge /= 2
    clear = (position > CLEAR * floor) & (f < 0.3 * rate)[:, None]
    clear[1:-1] &= clear[:-2] | clear[2:]  # one alone may be chance
    # From where what is clear is not larger than what rounding to counts has there, it may be that.
    swing = np.cumsum((position * clear)[::-1], axis=0)[::-1] * f[0]
    clear &= swing > ROUNDING * _count(pieces) ** 2 / 12
    highest = np.max(f[:, None] * clear)
    signal = np.where(clear, power, 0.0)
    total = np.maximum(signal.sum(axis=0), np.finfo(float).tiny)
    fast = signal[f > HIGHEST * rate].sum(axis=0) / total
    share = np.cumsum(signal, axis=0) / total
    nearly_all = max(f[np.argmax(column >= 1 - 1e-4)] for column in share.T)
    cutoff = np.clip(min(1.2 * highest, 4.0 * nearly_all), 4 * f[0], HIGHEST * rate)
    noise = np.sqrt(floor[min(np.searchsorted(f, 4 * highest), len(f) - 1)] * rate / 2)
    return Spectrum(float(cutoff), (float(noise[0]), float(noise[1])), float(fast.max()))


def _count(pieces):
    """Return the least change (2,) of a motion that sometimes has none: it is rounded to counts."""
    changes = np.abs(np.concatenate([np.diff(piece, axis=0) for piece in pieces]))
    least = np.where(changes > 0, changes, np.inf).min(axis=0)
    return np.where((changes == 0).any(axis=0), least, 0.0)


@lru_cache(maxsize=32)
def kernels(cutoff: float) -> tuple[ndarray, ...]:
    """Return the weights of rows -n..n for position, rate and acceleration per row.

    `cutoff` is in cycles a row.
    """
    best = None
    omega = 2 * np.pi * cutoff
    n = DEGREE // 2
    while n <= MOST:
        rows = np.arange(-n, n + 1)
        # In rows / n the polynomials are well conditioned.
        fit = np.linalg.pinv(np.vander(rows / n, DEGREE + 1, increasing=True))
        weights = fit[0], fit[1] / n, 2 * fit[2] / n**2
        wave = np.exp(1j * omega * rows)
        errors = []
        for k in range(3):
            exact = (1j * omega) ** k
            errors.append(abs(weights[k] @ wave / exact - 1))
        if max(errors) > FIDELITY:
            break
        best = weights
        n += max(1, n // 16)
    if best is None:
        raise ValueError(
            f"a cut-off of {cutoff:g} of the sampling rate is too high: at most {HIGHEST:g}"
        )
    return best


def half_window(cutoff: float, step: float) -> int:
    """Return how many rows on either side the derivatives at a row need."""
    return len(kernels(cutoff * step)[0]) // 2


def derivatives(
    q: ndarray, step: float, cutoff: float, ends: bool = False
) -> tuple[ndarray, ndarray, ndarray]:
    """Return (q, q', q''), (n, 2), of a piece in rows `step` s apart.

    The first and last `half_window` rows are nan; with `ends` they come from the polynomials of the
    first and the last whole window, which are several times less exact.
    """
    from scipy.signal import correlate

    weights = kernels(cutoff * step)
    n = len(weights[0]) // 2
    result = np.full((3, *q.shape), np.nan)
    if len(q) <= 2 * n:
        return tuple(result)
    for order in range(3):
        columns = [correlate(column, weights[order], "valid") for column in q.T]
        result[order, n : len(q) - n] = np.stack(columns, axis=1)
        result[order] /= step**order
    if ends:
        window = np.arange(-n, n + 1) / n
        first = slice(0, n)
        last = slice(-n, None)
        for outer, whole in ((first, q[: 2 * n + 1]), (last, q[-2 * n - 1 :])):
            basis = chebyshev.chebfit(window, whole, DEGREE)
            for order in range(3):
                slope = chebyshev.chebder(basis, order)
                values = chebyshev.chebval(window[outer], slope).T
                result[order, outer] = values / (n * step) ** order
    return tuple(result)
