"""A path followed at a steady pace: the motion between two rests is a quintic in time, as slow as it is told."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..checks import instance, positive, takes
from ..described import one_line
from ..planning.trajectory import refuse_nan
from .curve import Path

# Of the lab's quintic over a length L in a time T: the largest speed is SPEED L / T, acceleration ACCELERATION L / T^2.
SPEED, ACCELERATION = 15 / 8, 10 / 3**0.5
SEEN = 17


@dataclass(frozen=True, eq=False)
class Paced:
    """A motion along a path, a reference for every controller: motion(t) gives (xi, xi_dot, xi_ddot).

    times (n, 2): when each stretch between two rests begins and ends, s, from s = marks[k] to marks[k + 1].
    """

    path: Path
    times: np.ndarray
    marks: np.ndarray
    duration: float
    start = 0.0

    def __repr__(self) -> str:
        return one_line("Paced", f"{self.duration:g} s", f"{self.path.length:.6g} m", f"{len(self.times)} stretches")

    def s(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """s, m, and its first two derivatives by time, at t."""
        t = np.asarray(t, float)
        refuse_nan(t)
        k = np.clip(np.searchsorted(self.times[:, 0], t, side="right") - 1, 0, len(self.times) - 1)
        begin, end = self.times[k].T
        span, length = end - begin, np.diff(self.marks)[k]
        u = np.clip((t - begin) / span, 0.0, 1.0)
        s = self.marks[k] + length * u**3 * (10 - 15 * u + 6 * u**2)
        return s, length / span * 30 * u**2 * (1 - u) ** 2, length / span**2 * 60 * u * (1 - u) * (1 - 2 * u)

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s, rate, bend = (each[..., None] for each in self.s(t))
        xi, xi_s, xi_ss, _ = self.path(s[..., 0])
        return xi, xi_s * rate, xi_ss * rate**2 + xi_s * bend

    def pen(self, t: ArrayLike) -> np.ndarray:
        """Whether the pen is down at t: while it draws or rests between two strokes of a drawing that join."""
        s = self.s(t)[0]
        k = np.clip(np.searchsorted(self.path.knots, s, side="right") - 1, 0, len(self.path.pieces) - 1)
        return self._pen[k]

    @cached_property
    def _pen(self):
        return np.array(self.path.pen)


@takes(path=instance(Path), speed=positive, acceleration=positive)
def paced(path: Path, speed: float = 0.1, acceleration: float = 1.0) -> Paced:
    """The path from rest to rest by quintics s(t): Paced, at most `speed`, m/s, and `acceleration`, m/s^2, seen at
    SEEN places of each piece.

    Where the path asks for a lower speed (`feed`), it is kept; it dwells where the path does. What the motion asks of
    the motors is not looked at.
    """
    marks = np.array([stop.s for stop in path.stops])
    slowest = np.full(len(marks) - 1, np.inf)
    row = np.clip(np.searchsorted(marks, path.knots[:-1], side="right") - 1, 0, len(slowest) - 1)
    # Of the acceleration, xi_ss s_dot^2 + xi_s s_ddot, each part has half.
    k, u = np.meshgrid(np.arange(len(path.pieces)), np.linspace(0, 1, SEEN), indexing="ij")
    _, xi_s, xi_ss, _ = path.on(k, u * np.diff(path.knots)[:, None])
    steep, bent = np.linalg.norm(xi_s, axis=-1).max(axis=1), np.linalg.norm(xi_ss, axis=-1).max(axis=1)
    most = np.minimum(np.minimum(path.feed, speed) / steep, np.sqrt(acceleration / 2 / np.maximum(bent, 1e-300)))
    np.minimum.at(slowest, row, most)
    steepest = np.ones_like(slowest)
    np.maximum.at(steepest, row, steep)
    length = np.diff(marks)
    span = np.maximum(SPEED * length / slowest, np.sqrt(ACCELERATION * length * steepest / (acceleration / 2)))
    rests = np.array([stop.seconds for stop in path.stops])
    begin = np.cumsum(np.concatenate([[0.0], span[:-1]])) + np.cumsum(rests[:-1])
    times = np.stack([begin, begin + span], axis=-1)
    return Paced(path, times, marks, float(times[-1, 1] + rests[-1]))
