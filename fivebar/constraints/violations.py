"""Where a trajectory breaks what it must keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..base.backend import EPS
from ..models.geometry import task_pose
from .constraints import Constraints

# Between samples is searched where a clearance is less than so many times its change to the next.
NEAR = 4
LEAST = -4 * EPS  # of a clearance, which is rounding error


class Broken(NamedTuple):
    """A violated constraint: its name, the first time, s, the largest violation, and its time, s.

    The violation is in m, in rad, or a difference of sines.
    """

    what: str
    time: float
    by: float
    worst: float


def broken(
    robot, path: Callable, working: tuple, constraints: Constraints, t: np.ndarray
) -> tuple[Broken, ...]:
    """Return the constraints that a path violates from t[0] to t[-1], the first one first.

    t (n,): samples. Between them clearances are followed to their zeros, and to their smallest
    values where those may be below 0. Poses of nan are left out.
    """

    def clearances(t):
        x, y = path(np.atleast_1d(t))[0].T
        values = constraints.clearances(task_pose(robot, (x, y), working))
        return {name: np.broadcast_to(value, x.shape) for name, value in values.items()}

    violated = []
    for name, values in clearances(t).items():

        def clearance(s, name=name):
            value = float(clearances(s)[name][0])
            return value if np.isfinite(value) else np.inf

        known = np.where(np.isfinite(values), values, np.inf)
        times, lowest = _with_minima(clearance, t, known)
        if lowest.min(initial=np.inf) < LEAST:
            violated.append(_violation(name, clearance, times, lowest))
    return tuple(sorted(violated, key=lambda violation: violation.time))


def _with_minima(clearance, t, values):
    """Return times and clearances: the samples, and between them the minima below 0."""
    times = t
    lowest = values
    with np.errstate(invalid="ignore"):  # of samples without a pose
        steps = np.abs(np.diff(values, prepend=values[0], append=values[-1]))
        largest_step = np.fmax(steps[:-1], steps[1:])
        near = values <= NEAR * largest_step
    least = near & (values >= 0)
    least &= values <= np.append(np.inf, values[:-1])
    least &= values <= np.append(values[1:], np.inf)
    least[np.argmin(values)] = True
    for k in np.flatnonzero(least).tolist():
        before = t[max(k - 1, 0)]
        after = t[min(k + 1, len(t) - 1)]
        best = minimize_scalar(
            clearance,
            bounds=(before, after),
            method="bounded",
            options={"xatol": 1e-12 * (t[-1] - t[0])},
        )
        if best.fun < min(values[k], 0.0):
            times = np.append(times, best.x)
            lowest = np.append(lowest, best.fun)
    order = np.argsort(times)
    return times[order], lowest[order]


def _violation(name, clearance, times, lowest):
    """Return where a clearance that is below 0 begins to be so, and its smallest value."""
    first = int(np.argmax(lowest < LEAST))
    start = times[first]
    if first and np.isfinite(lowest[first - 1]):
        before = times[first - 1]
        # A sample at the limit itself is where the violation begins.
        if lowest[first - 1] > 0:
            start = brentq(clearance, before, start, xtol=1e-15)
        else:
            start = before
    worst = int(np.argmin(lowest))
    return Broken(name, float(start), float(-lowest[worst]), float(times[worst]))
