"""Where a trajectory breaks what it must keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..base.backend import EPS
from ..models.geometry import task_pose
from .constraints import Constraints

# A sample's room over what the room changes to the next ones: so little is looked at between
# samples.
NEAR = 4


class Broken(NamedTuple):
    """What is not kept, first at this time, s, and by how much at most (m, rad, or of a sine), then
    at `worst`, s.
    """

    what: str
    time: float
    by: float
    worst: float


def broken(
    robot, path: Callable, working: tuple, constraints: Constraints, t: np.ndarray
) -> tuple[Broken, ...]:
    """What a path does not keep at times from t[0] to t[-1], by the time at which it breaks first.

    t (n,): samples; between them rooms are followed to their zeros, and to their smallest values
    where those may be below 0. Where the pose is nan nothing is said.
    """

    def clearances(t):
        x, y = path(np.atleast_1d(t))[0].T
        return {
            name: np.broadcast_to(clearance, x.shape)
            for name, clearance in constraints.clearances(task_pose(robot, (x, y), working)).items()
        }

    found = []
    for name, values in clearances(t).items():

        def clearance(s, name=name):
            value = float(clearances(s)[name][0])
            return value if np.isfinite(value) else np.inf

        known = np.where(np.isfinite(values), values, np.inf)
        times, lowest = t, known
        with np.errstate(invalid="ignore"):  # of samples without a pose
            steps = np.abs(np.diff(known, prepend=known[0], append=known[-1]))
            near = known <= NEAR * np.fmax(steps[:-1], steps[1:])
        least = (
            near
            & (known >= 0)
            & (known <= np.append(np.inf, known[:-1]))
            & (known <= np.append(known[1:], np.inf))
        )
        for k in {*np.flatnonzero(least).tolist(), int(np.argmin(known))}:
            ends = t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)]
            best = minimize_scalar(
                clearance, bounds=ends, method="bounded", options=dict(xatol=1e-12 * (t[-1] - t[0]))
            )
            if best.fun < min(known[k], 0.0):
                times, lowest = np.append(times, best.x), np.append(lowest, best.fun)
        if lowest.min(initial=np.inf) >= -4 * EPS:
            continue
        order = np.argsort(times)
        times, lowest = times[order], lowest[order]
        first = int(np.argmax(lowest < -4 * EPS))
        start = times[first]
        if first and np.isfinite(
            lowest[first - 1]
        ):  # a sample at the limit itself is where it begins
            ends = times[first - 1], start
            start = brentq(clearance, *ends, xtol=1e-15) if lowest[first - 1] > 0 else ends[0]
        worst = int(np.argmin(lowest))
        found.append(Broken(name, float(start), float(-lowest[worst]), float(times[worst])))
    return tuple(sorted(found, key=lambda each: each.time))
