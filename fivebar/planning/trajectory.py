"""Reference motions: callables t -> (xi, xi_dot, xi_ddot) that hold their first and last point
outside their time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ..base.checks import number, positive, seconds, shown, two_numbers
from ..base.representation import one_line, vector


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion of the end-effector over [start, start + duration] s.

    Called with a time, a float or an array (n,), it gives position (m), velocity (m/s) and
    acceleration (m/s^2), each (2,) or (n, 2). Before and after, it rests at its first and last
    point. ValueError for a time that is nan.
    said: sentences on what was made of a file on the way here.
    """

    start: float
    duration: float
    _motion: Callable[[np.ndarray], np.ndarray]  # times (n,) inside -> (n, 6)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        end = self.start + self.duration
        places = [
            vector(name, tuple(self(t)[0]), "m") for name, t in (("from", self.start), ("to", end))
        ]
        return one_line("Trajectory", f"{self.start:g} to {end:g} s", *places, *self.notes[:2])

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        times = np.asarray(t, dtype=float)
        inside = np.clip(times, self.start, self.start + self.duration)
        motion = self._motion(inside)
        if (times != inside).any():
            refuse_nan(times)
            motion[..., 2:] = np.where((times == inside)[..., None], motion[..., 2:], 0.0)
        return motion[..., :2], motion[..., 2:4], motion[..., 4:]


def refuse_nan(t: np.ndarray) -> None:
    """ValueError for times of which one is nan, with its index."""
    if np.isnan(t).any():
        index = ", ".join(map(str, np.argwhere(np.isnan(t))[0]))
        raise ValueError(
            f"t must be a number of seconds, but t{f'[{index}]' if index else ''} is nan"
        )


def polynomial(conditions: Iterable[tuple[float, dict[int, ArrayLike]]]) -> Trajectory:
    """The polynomial of lowest degree through conditions [(t, {order: (x, y), ...}), ...], times in
    s, increasing.

    order: 0 position (m), 1 velocity (m/s), 2 acceleration (m/s^2); any set of them that determines
    a polynomial, the first and last time with a position. ValueError where it does not. The lab's P
    a = c, solved in Chebyshev polynomials of a time scaled to [-1, 1], where it is well
    conditioned.
    """
    try:
        conditions = [
            (number(t, "the time of each of conditions"), dict(given)) for t, given in conditions
        ]
    except (TypeError, ValueError) as error:
        what = (
            "polynomial: conditions must be [(t, {order: (x, y), ...}), ...], not"
            f" {shown(conditions)}: {error}"
        )
        raise ValueError(what) from None
    times = np.array([t for t, _ in conditions])
    if len(times) < 2 or (np.diff(times) <= 0).any():
        found = f"not {times.tolist()}, in conditions"
        raise ValueError(f"polynomial: times must be two or more, finite and increasing, {found}")
    seconds(times[-1] - times[0], "polynomial: the time from the first to the last of conditions")
    for t, given in conditions:
        for order, value in given.items():
            if type(order) is not int or order not in (0, 1, 2):
                raise ValueError(
                    f"polynomial: the order at t = {t:g} s must be 0, 1 or 2, not {order!r}"
                )
            two_numbers(value, f"polynomial: order {order} at t = {t:g} s")
    half = (times[-1] - times[0]) / 2
    degree = sum(len(given) for _, given in conditions) - 1
    derivatives = [np.eye(degree + 1)]
    for _ in range(2):
        derivatives.append(chebyshev.chebder(derivatives[-1], axis=0))
    rows, values = [], []
    for t, given in conditions:
        s = (t - times[0]) / half - 1
        for order, value in sorted(given.items()):
            rows.append(chebyshev.chebval(s, derivatives[order]))
            values.append(np.asarray(value, float) * half**order)
    rows = np.array(rows)
    if np.linalg.matrix_rank(rows) <= degree:
        raise ValueError(
            "polynomial: these conditions do not determine a polynomial (a position is missing?)"
        )
    coefficients = np.linalg.solve(rows, np.array(values))
    # One table for position, velocity and acceleration: they are evaluated together.
    table = np.zeros((degree + 1, 6))
    for order in range(3):
        column = derivatives[order] @ coefficients / half**order
        table[: len(column), 2 * order : 2 * order + 2] = column

    orders = np.arange(len(table))

    def motion(t):
        angle = np.arccos(np.clip((t - times[0]) / half - 1, -1, 1))
        return np.cos(np.multiply.outer(angle, orders)) @ table  # T_k(cos a) = cos k a

    return Trajectory(float(times[0]), float(times[-1] - times[0]), motion)


def line(a: ArrayLike, b: ArrayLike, duration: float) -> Trajectory:
    """Straight line from a to b, (2,) m, at rest at both ends: the lab's quintic. duration: s, >
    0.
    """
    duration = seconds(duration, "line: duration")
    rest = {1: (0.0, 0.0), 2: (0.0, 0.0)}
    return polynomial(
        [
            (0.0, {0: two_numbers(a, "line: a"), **rest}),
            (duration, {0: two_numbers(b, "line: b"), **rest}),
        ]
    )


def circle(center: ArrayLike, radius: float, period: float) -> Trajectory:
    """One turn counter-clockwise at constant speed from center + (radius, 0). center (2,) m; radius
    m, period s > 0.
    """
    center = np.array(two_numbers(center, "circle: center"))
    radius, period = positive(radius, "circle: radius"), seconds(period, "circle: period")
    omega = 2 * math.pi / period

    def motion(t):
        u = np.stack([np.cos(omega * t), np.sin(omega * t)], axis=-1)
        v = np.stack([-u[..., 1], u[..., 0]], axis=-1)
        return np.concatenate(
            [center + radius * u, radius * omega * v, -radius * omega**2 * u], axis=-1
        )

    return Trajectory(0.0, period, motion)
