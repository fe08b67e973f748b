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
    gaps: (from, to) s in which nothing is known; notes: what the viewer should be told, as
        sentences.
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
        times, shown = [0.0], [self.gaps[0][0] > 0]
        for low, high in self.gaps:
            for time, state in ((low, False), (high, True)):
                if 0 < time < self.duration:
                    times.append(time)
                    shown.append(state)
        return np.array(times), np.array(shown)


def choose(t: ArrayLike, *numbers: np.ndarray, lack: str = "are not numbers") -> Frames:
    """The Frames of samples at t (n,) s with these numbers (n, ...), of which some may be nan or
    inf.

    lack: why these cannot be shown, in words.
    Raises ValueError for fewer than 2 samples, unequal lengths, times that do not increase, and
    where all is nan.
    """
    t = np.asarray(t, dtype=float)
    if t.ndim != 1:
        raise ValueError(f"t has shape {t.shape}, not (n,)")
    for values in numbers:
        if len(values) != len(t):
            raise ValueError(f"t has {len(t)} samples and the motion {len(values)}")
    must_increase(t, "the motion")
    good = np.ones(len(t), dtype=bool)
    for values in numbers:
        good &= np.isfinite(values).reshape(len(t), -1).all(axis=1)
    if not good.any():
        raise ValueError(f"all {len(t)} samples {lack}: nothing can be drawn")
    start, t = float(t[0]), t - t[0]
    index, note = _thinned(t)
    gaps = _gaps(t, good)
    edges = [
        i for first, last in stretches(~good) for i in (first - 1, last + 1) if 0 <= i < len(t)
    ]
    index = np.union1d(index, edges).astype(int)
    index = index[good[index]]
    notes = [note] if note else []
    if gaps:
        spans = ", ".join(f"{start + low:.6g} to {start + high:.6g} s" for low, high in gaps[:3])
        more = f" and {len(gaps) - 3} more" if len(gaps) > 3 else ""
        notes.append(
            f"{int((~good).sum())} of {len(t)} samples {lack}: nothing is drawn from {spans}{more}."
        )
    return Frames(index, t[index], start, float(t[-1]), gaps, tuple(notes))


def grid(duration: float) -> np.ndarray:
    """Times (n,) s from 0 to `duration` for a motion that is known at any time."""
    return np.linspace(0.0, duration, int(np.clip(round(duration * PER_SECOND) + 1, 2, MOST)))


def _thinned(t):
    """Indices of the samples nearest to an even grid, and a note where this is coarser than the
    screen.
    """
    times = grid(t[-1])
    if len(t) <= len(times):
        return np.arange(len(t)), None
    after = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    index = np.unique(np.where(times - t[after - 1] < t[after] - times, after - 1, after))
    coarse = len(times) == MOST
    return (
        index,
        (
            f"{len(index)} of {len(t)} samples are shown, {t[-1] / (MOST - 1):.3g} s apart."
            if coarse
            else None
        ),
    )


def stretches(flags: np.ndarray) -> list[tuple[int, int]]:
    """(first, last) index of each stretch of true values."""
    change = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    return list(
        zip(np.flatnonzero(change == 1).tolist(), (np.flatnonzero(change == -1) - 1).tolist())
    )


def _gaps(t, good):
    """(from, to) s of each gap, half-way to its neighbours, which are still shown."""
    gaps = []
    for first, last in stretches(~good):
        low = 0.0 if first == 0 else (t[first - 1] + t[first]) / 2
        high = t[-1] if last == len(t) - 1 else (t[last] + t[last + 1]) / 2
        gaps.append((float(low), float(high)))
    return tuple(gaps)
