"""Reference motions: callables t -> (xi, xi_dot, xi_ddot) that rest before and after."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ..base.checks import number, positive, seconds, shown, two_numbers
from ..base.columns import Origin
from ..base.representation import one_line, vector


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion of the end-effector over [start, start + duration] s, from `line`, `circle`, ...

    Call it with a time, a float or an array (n,), s, for position, m, velocity, m/s, and
    acceleration, m/s^2, each (2,) or (n, 2). Before and after, it rests at its first and last
    point. A time of nan is a ValueError.

    Attributes
    ----------
    start, duration : float
        Times, s.
    notes : tuple of str
        Remarks on a file that it was read from.
    origin : Origin, optional
        Whose points they are, where such a file is fivebar's; it is lost where they are placed.

    Examples
    --------
    >>> import fivebar as fb
    >>> xi, xi_dot, xi_ddot = fb.line((0.09, 0.068), (0.05, 0.09), 2.0)(2.0)
    >>> xi.round(12).tolist()
    [0.05, 0.09]
    """

    start: float
    duration: float
    _motion: Callable[[np.ndarray], np.ndarray]  # times (n,) inside -> (n, 6)
    notes: tuple[str, ...] = ()
    origin: Origin | None = field(default=None, kw_only=True)

    def __repr__(self) -> str:
        end = self.start + self.duration
        first = vector("from", tuple(self(self.start)[0]), "m")
        last = vector("to", tuple(self(end)[0]), "m")
        return one_line(
            type(self).__name__, f"{self.start:g} to {end:g} s", first, last, *self.notes[:2]
        )

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        times = np.asarray(t, dtype=float)
        inside = np.clip(times, self.start, self.start + self.duration)
        motion = self._motion(inside)
        if (times != inside).any():
            refuse_nan(times)
            motion[..., 2:] = np.where((times == inside)[..., None], motion[..., 2:], 0.0)
        xi, xi_dot, xi_ddot = np.split(motion, 3, axis=-1)
        return xi, xi_dot, xi_ddot


def refuse_nan(t: np.ndarray) -> None:
    """Raise ValueError if a time is nan, with its index."""
    if np.isnan(t).any():
        index = np.argwhere(np.isnan(t))[0].tolist()
        raise ValueError(f"t must be a number of seconds, but t{index or ''} is nan")


def polynomial(conditions: Iterable[tuple[float, dict[int, ArrayLike]]]) -> Trajectory:
    """Return the polynomial of lowest degree through conditions.

    It is the lab's P a = c, solved in Chebyshev polynomials of a time scaled to [-1, 1], where it
    is well conditioned.

    Parameters
    ----------
    conditions : sequence of (t, {order: (x, y)})
        Times, s, increase. Order 0 is a position, m, 1 a velocity, m/s, 2 an acceleration, m/s^2.
        The first and the last time need a position.

    Returns
    -------
    Trajectory

    Raises
    ------
    ValueError
        The conditions do not determine a polynomial.

    Examples
    --------
    >>> import fivebar as fb
    >>> rest = {1: (0, 0), 2: (0, 0)}
    >>> motion = fb.polynomial([(0, {0: (0, 0), **rest}), (1, {0: (0.1, 0.2), **rest})])
    >>> motion(0.5)[0].round(6).tolist()
    [0.05, 0.1]
    """
    try:
        conditions = [(number(t, "time"), dict(values)) for t, values in conditions]
    except (TypeError, ValueError) as error:
        raise ValueError(
            "polynomial: conditions must be [(t, {order: (x, y), ...}), ...], not"
            f" {shown(conditions)}: {error}"
        ) from None
    times = np.array([t for t, _ in conditions])
    if len(times) < 2 or (np.diff(times) <= 0).any():
        raise ValueError(
            "polynomial: times must be two or more, finite and increasing, not"
            f" {times.tolist()}, in conditions"
        )
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
    derivatives: list[np.ndarray] = [np.eye(degree + 1)]
    for _ in range(2):
        derivatives.append(chebyshev.chebder(derivatives[-1], axis=0))
    rows = []
    values = []
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

    return Trajectory(
        float(times[0]), float(times[-1] - times[0]), partial(_chebyshev, table, times[0], half)
    )


def _chebyshev(table, start, half, t):
    """Return the series of T_k in rows of a table at times t, with T_k(cos a) = cos k a."""
    angle = np.arccos(np.clip((t - start) / half - 1, -1, 1))
    return np.cos(np.multiply.outer(angle, np.arange(len(table)))) @ table


def line(a: ArrayLike, b: ArrayLike, duration: float) -> Trajectory:
    """Return a straight line from a to b, at rest at both ends: the lab's quintic.

    Parameters
    ----------
    a, b : (2,)
        Points, m.
    duration : float
        Duration, s.

    Returns
    -------
    Trajectory

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.line((0.09, 0.068), (0.05, 0.09), 2.0)(1.0)[0].round(6).tolist()
    [0.07, 0.079]
    """
    duration = seconds(duration, "line: duration")
    rest: dict[int, ArrayLike] = {1: (0.0, 0.0), 2: (0.0, 0.0)}
    first = {0: two_numbers(a, "line: a"), **rest}
    last = {0: two_numbers(b, "line: b"), **rest}
    return polynomial([(0.0, first), (duration, last)])


def circle(center: ArrayLike, radius: float, period: float) -> Trajectory:
    """Return one turn counter-clockwise at constant speed, from center + (radius, 0).

    Parameters
    ----------
    center : (2,)
        Center, m.
    radius, period : float
        Radius, m, and duration of the turn, s.

    Returns
    -------
    Trajectory

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.circle((0, 0.1), 0.02, 4.0)(1.0)[0].round(6).tolist()
    [0.0, 0.12]
    """
    center = np.array(two_numbers(center, "circle: center"))
    radius = positive(radius, "circle: radius")
    period = seconds(period, "circle: period")
    return Trajectory(0.0, period, partial(_turn, center, radius, 2 * math.pi / period))


def _turn(center, radius, omega, t):
    angle = omega * t
    u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    v = np.stack([-u[..., 1], u[..., 0]], axis=-1)
    return np.concatenate(
        [center + radius * u, radius * omega * v, -radius * omega**2 * u], axis=-1
    )
