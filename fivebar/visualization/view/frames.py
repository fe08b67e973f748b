"""Which samples of a motion a page shows: at most 60 a second, none that is not a number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...base.tables import must_increase

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

PER_SECOND = 60
MOST = 3600  # frames: beyond, a page would outgrow what a notebook or a mail takes


@dataclass(frozen=True, eq=False)
class Frames:
    """The shown samples of a motion.

    index (m,): which samples; t (m,) s, from 0; start: s, the first sample's own time; duration: s;
    gaps: (from, to) s in which nothing is known; notes: what the viewer should be told.
    """

    index: np.ndarray
    t: np.ndarray
    start: float
    duration: float
    gaps: tuple
    notes: tuple

    @property
    def switches(self) -> tuple[np.ndarray, np.ndarray] | None:
        """(times (k,), shown (k,) bool): from each time on, whether the mechanism is shown; None
        without gaps.
        """
        if not self.gaps:
            return None
        inside = {time for time in np.ravel(self.gaps) if 0 < time < self.duration}
        times = np.array([0.0, *sorted(inside)])
        lows, highs = np.transpose(self.gaps)[..., None]
        return times, ~((lows <= times) & (times < highs)).any(axis=0)


def choose(t: ArrayLike, *numbers: np.ndarray, lack: str = "are not numbers") -> Frames:
    """Return the Frames of samples at t (n,) s with these numbers (n, ...).

    lack: why these cannot be shown. Raises ValueError for fewer than 2 samples, unequal lengths,
    times that do not increase, and where no sample can be shown.
    """
    t = np.asarray(t, dtype=float)
    must_increase(t, "the motion")
    good = np.ones(len(t), dtype=bool)
    for values in numbers:
        if len(values) != len(t):
            raise ValueError(f"t has {len(t)} samples and the motion {len(values)}")
        good &= np.isfinite(values).reshape(len(t), -1).all(axis=1)
    if not good.any():
        raise ValueError(f"all {len(t)} samples {lack}: nothing can be drawn")
    start = float(t[0])
    t = t - t[0]
    notes = []
    index = _nearest(t, grid(t[-1]))
    if len(index) == MOST < len(t):
        step = t[-1] / (MOST - 1)
        notes.append(f"{MOST} of {len(t)} samples are shown, {step:.3g} s apart.")
    holes = np.array(stretches(~good)).reshape(-1, 2)
    index = np.union1d(index, np.clip(holes + (-1, 1), 0, len(t) - 1)).astype(int)
    index = index[good[index]]
    # A gap reaches half-way to its neighbours, which are still shown.
    middles = np.concatenate([t[:1], (t[:-1] + t[1:]) / 2, t[-1:]])
    gaps = tuple((float(middles[low]), float(middles[high + 1])) for low, high in holes)
    if gaps:
        spans = ", ".join(f"{start + low:.6g} to {start + high:.6g} s" for low, high in gaps[:3])
        if len(gaps) > 3:
            more = f" and {len(gaps) - 3} more"
        else:
            more = ""
        count = f"{(~good).sum()} of {len(t)} samples {lack}"
        notes.append(f"{count}: nothing is drawn from {spans}{more}.")
    return Frames(index, t[index], start, float(t[-1]), gaps, tuple(notes))


def grid(duration: float) -> np.ndarray:
    """Return times (n,) s from 0 to `duration` for a motion that is known at any time."""
    return np.linspace(0.0, duration, int(np.clip(round(duration * PER_SECOND) + 1, 2, MOST)))


def _nearest(t, times):
    """Return indices of the samples nearest to these times; all where there are no more of them."""
    if len(t) <= len(times):
        return np.arange(len(t))
    after = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    return np.unique(np.where(times - t[after - 1] < t[after] - times, after - 1, after))


def stretches(flags: np.ndarray) -> list[tuple[int, int]]:
    """Return (first, last) index of each stretch of true values."""
    change = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    first = np.flatnonzero(change == 1)
    last = np.flatnonzero(change == -1) - 1
    return list(zip(first.tolist(), last.tolist()))


def last_true(flags: np.ndarray) -> np.ndarray:
    """Return for each index (m,) that of the last true flag, before the first one its own."""
    return np.maximum.accumulate(np.where(flags, np.arange(len(flags)), np.argmax(flags)))
