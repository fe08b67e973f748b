"""Figures of merit of the lengths alone, in closed form, on columns of robots."""

from __future__ import annotations

import numpy as np

from .batch import Robots
from .task import Task


def _disc(r):
    return np.pi * r * r


def _lens(r1, r2, d):
    """Area that two discs with centres d apart have in common."""
    small = np.minimum(r1, r2)
    large = np.maximum(r1, r2)
    apart = d >= r1 + r2
    within = d <= large - small
    crossed = ~(apart | within)
    d, r1, r2 = (
        np.where(crossed, length, 1.0) for length in (d, r1, r2)
    )  # elsewhere what can be divided by
    a1 = np.arccos(np.clip((d * d + (r1 - r2) * (r1 + r2)) / (2 * d * r1), -1, 1))
    a2 = np.arccos(np.clip((d * d - (r1 - r2) * (r1 + r2)) / (2 * d * r2), -1, 1))
    # Sectors less their triangles.
    area = r1 * r1 * (a1 - 0.5 * np.sin(2 * a1)) + r2 * r2 * (a2 - 0.5 * np.sin(2 * a2))
    return np.where(apart, 0.0, np.where(within, _disc(small), area))


def _workspace_area(robots):
    """Return the area that both rings have in common.

    It is that of both outer discs, less what an inner disc takes, plus what both take.
    """
    (o1, i1), (o2, i2) = (
        (p + q, abs(p - q)) for p, q in ((robots.l11, robots.l12), (robots.l21, robots.l22))
    )
    d = robots.d
    return (_lens(o1, o2, d) - _lens(i1, o2, d) - _lens(o1, i2, d) + _lens(i1, i2, d))[:, 0]


def _bars(robots):
    return (robots.l11 + robots.l12 + robots.l21 + robots.l22)[:, 0]


def workspace_bound(robots: Robots, task: Task) -> np.ndarray:
    """Return the area (n,), m^2, of the smaller of the two outer discs."""
    return _disc(np.minimum(robots.l11 + robots.l12, robots.l21 + robots.l22))[:, 0]


def _bars_bound(robots, task):
    return _bars(robots)


# Name, unit, better, words, of, needs, bound.
CLOSED = (
    (
        "workspace_area",
        "m²",
        "large",
        "what the end-effector reaches, in any mode",
        _workspace_area,
        (),
        workspace_bound,
    ),
    ("bars", "m", "small", "length of the four bars together", _bars, (), _bars_bound),
)
