"""s by time: on each stretch s'' = u0 + bent (s - s0), a linear equation; its running mean has a
finite jerk.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np
from numpy.polynomial.polynomial import polyval

from .lower_bound import duration

NEVER = 1e-12  # s
COEFFICIENTS = np.array(
    [[1 / factorial(2 * j + k) for k in (2, 3)] for j in range(9)]
)  # of Stumpff's c2 and c3


@dataclass(frozen=True, eq=False)
class Clock:
    """length, bent (n,) and x = s'^2 at the nodes (n + 1,) of n stretches; waits (n + 1,) s of rest
    at the nodes.

    smooth: s over which s(t) is averaged, 0: not. All times are in the motion's own pace.
    """

    length: np.ndarray
    x: np.ndarray
    bent: np.ndarray
    waits: np.ndarray
    smooth: float = 0.0

    @cached_property
    def s(self) -> np.ndarray:
        """Of the nodes (n + 1,), m."""
        return np.cumsum(np.insert(self.length, 0, 0.0))

    @cached_property
    def taken(self) -> np.ndarray:
        """By each stretch (n,), s, without averaging."""
        return np.array(
            [duration(*each) for each in zip(self.length, self.x[:-1], self.x[1:], self.bent)]
        )

    @cached_property
    def _starts(self):
        """When each stretch begins, and the end. What is averaged rests so much longer that it
        comes to rest.
        """
        rests = self.waits + self.smooth * (self.x == 0)
        rests[0] -= self.smooth
        return np.cumsum(np.insert(self.taken, 0, 0.0)) + np.cumsum(rests)

    @property
    def end(self) -> float:
        return float(self._starts[-1])

    @cached_property
    def times(self) -> np.ndarray:
        """At which it passes its nodes (n + 1,), or leaves them after a rest, s."""
        return self.passed(np.arange(len(self.x)))

    def passed(self, k: np.ndarray) -> np.ndarray:
        """The times of nodes k (m,)."""
        plain = np.append(self._starts[:-1], self._starts[-2] + self.taken[-1])[k]
        if not self.smooth:
            return plain
        low, high = plain, plain + self.smooth  # the mean of s from t - smooth to t
        for _ in range(50):
            t = (low + high) / 2
            behind = self._mean(t)[0] < self.s[k]
            low, high = np.where(behind, t, low), np.where(behind, high, t)
        return high

    @property
    def breaks(self) -> np.ndarray:
        """Times between which all derivatives go on, s."""
        edges = np.concatenate([self._starts[:-1], self._starts[:-1] + self.taken])
        return np.unique(np.clip(np.concatenate([edges, edges + self.smooth]), 0.0, self.end))

    def along(self, t: np.ndarray) -> tuple[np.ndarray, ...]:
        """(stretch, s from the stretch's begin, s', s'') at times t (*batch)."""
        if not self.smooth:
            k, gone, speed, push, _ = self._plain(t)
            return k, gone, speed, push
        s, speed, push, _ = self._mean(t)
        k = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.length) - 1)
        return k, np.clip(s - self.s[k], 0.0, self.length[k]), np.maximum(speed, 0.0), push

    def jerk(self, t: np.ndarray) -> np.ndarray:
        """s''' of the averaged motion."""
        return self._mean(t)[3]

    def _mean(self, t):
        now, before = self._plain(t), self._plain(t - self.smooth)
        sums = (self._sum(t, *now[:2]) - self._sum(t - self.smooth, *before[:2])) / self.smooth
        places = (self.s[k] + gone for k, gone, *_ in (now, before))
        here, there = places
        return (
            sums,
            (here - there) / self.smooth,
            *((a - b) / self.smooth for a, b in zip(now[2:4], before[2:4])),
        )

    def _plain(self, t):
        begins, taken = self._starts[:-1], self.taken
        k = np.clip(np.searchsorted(begins, t, side="right") - 1, 0, len(begins) - 1)
        dt = np.clip(t - begins[k], 0.0, taken[k])
        bent, v0, u0 = self.bent[k], np.sqrt(self.x[k]), self._push[k]
        c0, c1, c2, _ = _stumpff(bent * dt * dt)
        gone = np.clip(v0 * dt * c1 + u0 * dt * dt * c2, 0.0, self.length[k])
        speed, push = v0 * c0 + u0 * dt * c1, u0 + bent * gone
        speed = np.where(dt < taken[k], np.maximum(speed, 0.0), np.sqrt(self.x[k + 1]))
        still = (t < begins[k]) | (t > begins[k] + taken[k] + NEVER)
        return k, gone, np.where(still, 0.0, speed), np.where(still, 0.0, push), dt

    @cached_property
    def _push(self):
        return np.diff(self.x) / (2 * self.length) - self.bent * self.length / 2

    def _sum(self, t, k, gone):
        """The integral of s from the begin of the motion to t."""
        since = np.maximum(t - self._starts[k], 0.0)
        dt = np.minimum(since, self.taken[k])
        return self._sums[k] + self._own_sum(k, dt) + (since - dt) * self.s[k + 1]

    @cached_property
    def _sums(self):
        """That up to where each stretch begins."""
        n, taken = np.arange(len(self.taken)), self.taken
        after = np.diff(self._starts) - taken  # rest at the stretch's end
        return np.cumsum(np.insert(self._own_sum(n, taken) + after * self.s[1:], 0, 0.0))

    def _own_sum(self, k, dt):
        _, _, c2, c3 = _stumpff(self.bent[k] * dt * dt)
        return dt * (self.s[k] + dt * (np.sqrt(self.x[k]) * c2 + dt * self._push[k] * c3))


def _stumpff(z):
    """c0, ..., c3 of Stumpff at -z: sum of z^j / (2 j + k)!; cosh(r), sinh(r) / r, ... with r =
    sqrt(z).
    """
    root = np.sqrt(np.abs(z))
    small = root < 0.5
    r = np.where(small, 1.0, root)
    grows, turns = np.where(z > 0, np.minimum(r, 700.0), 0.0), r
    c0 = np.where(z > 0, np.cosh(grows), np.cos(turns))
    c1 = np.where(z > 0, np.sinh(grows), np.sin(turns)) / r
    sign = np.where(z > 0, 1.0, -1.0)
    c2, c3 = sign * (c0 - 1) / r**2, sign * (c1 - 1) / r**2
    near = np.where(small, z, 0.0)
    c, d = polyval(near, COEFFICIENTS)
    series = 1 + near * c, 1 + near * d, c, d
    return tuple(np.where(small, a, b) for a, b in zip(series, (c0, c1, c2, c3)))
