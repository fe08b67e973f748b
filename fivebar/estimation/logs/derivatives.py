"""Rates and accelerations of a sampled motion, without phase: polynomials of degree 6 in a window
about each row.

Least squares of a polynomial over 2 n + 1 rows (Savitzky and Golay 1964; Schafer 2011 for its
response) is a symmetric
filter: it shifts nothing in time. Below the cut-off it is as good as exact, above it noise is taken
away. The window is the longest that still gets position, rate and acceleration of a sine at the
cut-off within FIDELITY of its own.

The cut-off is where the motion sinks into its noise: with P(f) the spectrum of second differences
of q, and the noise of an encoder white, the level of P over that of white noise at high frequencies
is its floor; the motion ends at the highest frequency where P is more than ABOVE times as high; or
at WIDER times that below which NEARLY all of its acceleration is, as torques are products of few of
its waves, and beyond these there is only noise to learn from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

DEGREE, FIDELITY, MOST = 6, 1e-3, 500  # MOST: rows on either side
ABOVE = 6.0  # times the floor
HIGHEST = (
    1 / 12
    # Of the sampling rate: what a cut-off may be at most, and more than it is too fast for the
    # sampling.
)
NEARLY, WIDER = (
    1 - 1e-4,
    4.0,
)  # of the acceleration's power; times the frequency below which that is
PARTS = 8  # of a log, over which its spectrum is averaged


@dataclass(frozen=True)
class Spectrum:
    """cutoff: Hz; noise: standard deviation of q's noise per joint, (2,); fast: of the
    acceleration's power, where it is above the noise, the share at frequencies that this sampling
    rate cannot follow, the larger of both joints.
    """

    cutoff: float
    noise: tuple[float, float]
    fast: float


def spectrum(pieces: Sequence[np.ndarray], step: float) -> Spectrum:
    """What the pieces (n, 2) of a motion, in rows `step` s apart, say of their frequencies."""
    from scipy.signal import welch  # half a second to load, and a simulated run needs none of it

    rate, longest = 1 / step, max(pieces, key=len)
    window = max(16, min(4096, 2 * len(longest) // PARTS))
    power, weight = 0.0, 0
    for piece in pieces:
        if len(piece) >= window + 2:
            f, each = welch(np.diff(piece, 2, axis=0), rate, nperseg=window, axis=0, detrend=False)
            power, weight = power + len(piece) * each, weight + len(piece)
    if not weight:
        return Spectrum(HIGHEST * rate, (0.0, 0.0), 0.0)
    power = power / weight
    shape = (2 * np.sin(np.pi * f * step)) ** 4  # of white noise, differenced twice
    high = f > 0.3 * rate
    floor = np.median(power[high] / shape[high, None], axis=0)
    clear = (power > ABOVE * floor * shape[:, None]) & (f < 0.3 * rate)[:, None] & (f > 0)[:, None]
    # of neighbours two of three: one alone may be chance
    clear[1:-1] &= clear[:-2] | clear[2:]
    highest = max(
        (f[np.flatnonzero(column)[-1]] for column in clear.T if column.any()), default=0.0
    )
    signal = np.where(clear, power, 0.0)
    beyond = signal[f > HIGHEST * rate].sum(axis=0) / np.maximum(
        signal.sum(axis=0), np.finfo(float).tiny
    )
    share = np.cumsum(signal, axis=0) / np.maximum(signal.sum(axis=0), np.finfo(float).tiny)
    nearly = max((f[np.argmax(column >= NEARLY)] for column in share.T), default=0.0)
    cutoff = float(np.clip(min(1.2 * highest, WIDER * nearly), 4 * f[1], HIGHEST * rate))
    noise = np.sqrt(floor * rate / 2)
    return Spectrum(cutoff, (float(noise[0]), float(noise[1])), float(beyond.max()))


@lru_cache(maxsize=32)
def kernels(cutoff_rows: float) -> tuple[np.ndarray, ...]:
    """Weights of rows -n..n for the position, its rate and its acceleration per row; cutoff_rows:
    cycles per row.
    """
    best = None
    omega = 2 * np.pi * cutoff_rows
    n = DEGREE // 2
    while n <= MOST:
        rows = np.arange(-n, n + 1)
        fit = np.linalg.pinv(
            np.vander(rows / n, DEGREE + 1, increasing=True)
        )  # in rows / n it is well conditioned
        found = fit[0], fit[1] / n, 2 * fit[2] / n**2
        wave = np.exp(1j * omega * rows)
        errors = (abs(found[order] @ wave / (1j * omega) ** order - 1) for order in range(3))
        if max(errors) > FIDELITY:
            break
        best, n = found, n + max(1, n // 16)
    if best is None:
        raise ValueError(
            f"a cut-off of {cutoff_rows:g} of the sampling rate is too high: at most {HIGHEST:g}"
        )
    return best


def half_window(cutoff: float, step: float) -> int:
    """Rows on either side of one that its derivatives ask for."""
    return len(kernels(cutoff * step)[0]) // 2


def derivatives(
    q: np.ndarray, step: float, cutoff: float, ends: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(q, q', q''), (n, 2), of a piece in rows `step` s apart; nan in its first and last
    `half_window` rows.

    ends: those rows by the polynomials of the first and the last whole window, which are several
        times less exact.
    """
    from scipy.signal import correlate

    rows = kernels(cutoff * step)
    n = len(rows[0]) // 2
    found = []
    for order, weights in enumerate(rows):
        out = np.full(q.shape, np.nan)
        if len(q) > 2 * n:
            out[n : len(q) - n] = np.stack(
                [correlate(column, weights, "valid") for column in q.T], axis=1
            )
        found.append(out / step**order)
    if ends and len(q) > 2 * n:
        window = np.arange(-n, n + 1) / n
        for outer, inner in (
            (slice(0, n), slice(0, 2 * n + 1)),
            (slice(-n, None), slice(-2 * n - 1, None)),
        ):
            basis = chebyshev.chebfit(window, q[inner], DEGREE)
            for order, out in enumerate(found):
                at = window[:n] if outer.start == 0 else window[-n:]
                out[outer] = (
                    chebyshev.chebval(at, chebyshev.chebder(basis, order)).T / (n * step) ** order
                )
    return tuple(found)
