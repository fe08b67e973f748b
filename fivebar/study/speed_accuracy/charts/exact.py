"""Positions, velocities and accelerations of the end-effector to 50 digits, by decimals."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext

import numpy as np

from ....models.robots import FiveBar

DIGITS = 50


def exact_motion(
    robot: FiveBar,
    q: Sequence[float],
    q_dot: Sequence[float] = (0.0, 0.0),
    q_ddot: Sequence[float] = (0.0, 0.0),
    assembly: int = -1,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return xi, xi', xi'' (2 decimals each) of joint angles (2,) rad, their rates, accelerations.

    The circles about the elbows E_i meet in xi; then r_i . xi' = r_i . E_i' and
    r_i . xi'' = r_i . E_i'' - |xi' - E_i'|^2 with r_i = xi - E_i. The floats given are exact.
    """
    with localcontext(prec=DIGITS + 15):
        half = Decimal(robot.d) / 2
        elbows = []
        for base, length, *state in zip((-half, half), (robot.l11, robot.l21), q, q_dot, q_ddot):
            angle, w, a = (Decimal(float(value)) for value in state)
            u = np.array(cos_sin(angle))
            v = np.array([-u[1], u[0]])
            bar = Decimal(length)
            elbows.append((np.array([base, 0]) + bar * u, bar * w * v, bar * (a * v - w * w * u)))
        (e1, v1, a1), (e2, v2, a2) = elbows
        span = e2 - e1
        l1 = Decimal(robot.l12)
        l2 = Decimal(robot.l22)
        square = span @ span
        along = (square + l1 * l1 - l2 * l2) / (2 * square)
        across = -assembly * (l1 * l1 / square - along * along).sqrt()
        xi = e1 + along * span + across * np.array([-span[1], span[0]])
        r1 = xi - e1
        r2 = xi - e2
        det = r1[0] * r2[1] - r1[1] * r2[0]

        def solve(s1, s2):
            return np.array([s1 * r2[1] - s2 * r1[1], s2 * r1[0] - s1 * r2[0]]) / det

        xi_dot = solve(r1 @ v1, r2 @ v2)
        d1 = xi_dot - v1
        d2 = xi_dot - v2
        return xi, xi_dot, solve(r1 @ a1 - d1 @ d1, r2 @ a2 - d2 @ d2)


def cos_sin(x: Decimal) -> tuple[Decimal, Decimal]:
    """Return both by their series, of a small part of the angle that is then doubled."""
    halvings = 12
    small = x / 2**halvings
    sin = small
    term = small
    k = 1
    # cos - 1 keeps its digits when doubled
    cos_less_1 = Decimal(0)
    other = Decimal(1)
    while abs(term) > Decimal(10) ** -(2 * DIGITS):
        other *= -small * small / (k * (k + 1))
        cos_less_1 += other
        term *= -small * small / ((k + 1) * (k + 2))
        sin += term
        k += 2
    for _ in range(halvings):
        sin = 2 * sin * (1 + cos_less_1)
        cos_less_1 = 2 * cos_less_1 * (2 + cos_less_1)
    return 1 + cos_less_1, sin


def distance(point: Sequence[float], exact: Sequence[Decimal]) -> float:
    """Return |point - exact| of two numbers and two decimals, without rounding the exact ones."""
    with localcontext(prec=DIGITS + 15):
        squares = [(Decimal(float(a)) - b) ** 2 for a, b in zip(point, exact)]
        return float(sum(squares, Decimal(0)).sqrt())
