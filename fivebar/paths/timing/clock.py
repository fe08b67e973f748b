"""s by time: on each stretch s'' = u0 + bent (s - s0), a linear equation.

Its running mean has a finite jerk.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.optimize.elementwise import find_root

from .lower_bound import duration

NEVER = 1e-12  # s
# Of the power series of Stumpff's c2 and c3.
COEFFICIENTS = np.array([(1 / factorial(2 * j + 2), 1 / factorial(2 * j + 3)) for j in range(9)])


@dataclass(frozen=True, eq=False)
class Clock:
    """The timing of n stretches.

    length (n,) m, bent (n,) 1/s^2, x (n + 1,) = s'^2 at the nodes, waits (n + 1,) s of rest at the
    nodes. smooth: s over which s(t) is averaged. All times are in the motion's own pace.
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
        """Return the time of each stretch (n,), s, without averaging."""
        return duration(self.length, self.x[:-1], self.x[1:], self.bent)

    @cached_property
    def _starts(self):
        """Return when each stretch begins, and the end.

        A motion that is averaged rests longer, so that the mean comes to rest.
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
        """Return the times of nodes k (m,)."""
        plain = np.append(self._starts[:-1], self._starts[-2] + self.taken[-1])[k]
        if not self.smooth:
            return plain
        # The mean comes to rest when the rest ends, or w after the end: not to rounding before.
        times = plain + self.smooth * (k == len(self.length))
        moving = self.x[k] > 0
        ends = plain[moving], plain[moving] + self.smooth  # the mean of s from t - smooth to t
        found = find_root(lambda t, s: self._mean(t)[0] - s, ends, args=(self.s[k[moving]],))
        # Where rounding hides the way of that time, all of its times are as good.
        times[moving] = np.where(found.success, found.x, ends[1])
        return times

    @property
    def breaks(self) -> np.ndarray:
        """Times between which all derivatives go on, s."""
        edges = np.concatenate([self._starts[:-1], self._starts[:-1] + self.taken])
        return np.unique(np.clip(np.concatenate([edges, edges + self.smooth]), 0.0, self.end))

    def along(self, t: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return (stretch, s from the stretch's begin, s', s'') at times t (*batch)."""
        if not self.smooth:
            return self._plain(t)
        s, speed, push, _ = self._mean(t)
        k = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.length) - 1)
        return (k, np.clip(s - self.s[k], 0.0, self.length[k]), np.maximum(speed, 0.0), push)

    def jerk(self, t: np.ndarray) -> np.ndarray:
        """s''' of the averaged motion."""
        return self._mean(t)[3]

    def _mean(self, t):
        """Return s and its first three derivatives, averaged from t - smooth to t."""
        k, gone, speed, push = self._plain(t)
        k_before, gone_before, speed_before, push_before = self._plain(t - self.smooth)
        total = self._sum(t, k) - self._sum(t - self.smooth, k_before)
        way = (self.s[k] + gone) - (self.s[k_before] + gone_before)
        changes = total, way, speed - speed_before, push - push_before
        return tuple(change / self.smooth for change in changes)

    def _plain(self, t):
        begins = self._starts[:-1]
        taken = self.taken
        k = np.maximum(np.searchsorted(begins, t, side="right") - 1, 0)
        dt = np.clip(t - begins[k], 0.0, taken[k])
        bent = self.bent[k]
        v0 = np.sqrt(self.x[k])
        u0 = self.pushes[k]
        c0, c1, c2, _ = _stumpff(bent * dt * dt)
        gone = np.clip(v0 * dt * c1 + u0 * dt * dt * c2, 0.0, self.length[k])
        push = u0 + bent * gone
        speed = v0 * c0 + u0 * dt * c1
        speed = np.where(dt < taken[k], np.maximum(speed, 0.0), np.sqrt(self.x[k + 1]))
        rests = (t < begins[k]) | (t > begins[k] + taken[k] + NEVER)
        return (k, gone, np.where(rests, 0.0, speed), np.where(rests, 0.0, push))

    @cached_property
    def pushes(self) -> np.ndarray:
        """s'' where each stretch begins (n,), without averaging."""
        return np.diff(self.x) / (2 * self.length) - self.bent * self.length / 2

    def _sum(self, t, k):
        """Return the integral of s from the begin of the motion to t."""
        since = np.maximum(t - self._starts[k], 0.0)
        dt = np.minimum(since, self.taken[k])
        return self._sums[k] + self._own_sum(k, dt) + (since - dt) * self.s[k + 1]

    @cached_property
    def _sums(self):
        """Return the integrals up to where each stretch begins."""
        on_stretches = self._own_sum(np.arange(len(self.taken)), self.taken)
        rests = np.diff(self._starts) - self.taken
        return np.cumsum(np.insert(on_stretches + rests * self.s[1:], 0, 0.0))

    def _own_sum(self, k, dt):
        """Return the integral of s on stretch k, dt after its begin."""
        _, _, c2, c3 = _stumpff(self.bent[k] * dt * dt)
        moved = np.sqrt(self.x[k]) * c2 + dt * self.pushes[k] * c3
        return dt * (self.s[k] + dt * moved)


def _stumpff(z):
    """Return Stumpff's c0, ..., c3 at -z, the sums of z^j / (2 j + k)!.

    With r = sqrt(z) they are cosh(r), sinh(r) / r, (cosh(r) - 1) / r^2, ...
    """
    root = np.sqrt(np.abs(z))
    small = root < 0.5
    r = np.where(small, 1.0, root)
    bounded = np.where(z > 0, np.minimum(r, 700.0), 0.0)
    c0 = np.where(z > 0, np.cosh(bounded), np.cos(r))
    c1 = np.where(z > 0, np.sinh(bounded), np.sin(r)) / r
    sign = np.where(z > 0, 1.0, -1.0)
    c2 = sign * (c0 - 1) / r**2
    c3 = sign * (c1 - 1) / r**2
    near = np.where(small, z, 0.0)
    series2, series3 = polyval(near, COEFFICIENTS)
    return (
        np.where(small, 1 + near * series2, c0),
        np.where(small, 1 + near * series3, c1),
        np.where(small, series2, c2),
        np.where(small, series3, c3),
    )
