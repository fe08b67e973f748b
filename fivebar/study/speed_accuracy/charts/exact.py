"""Positions, velocities and accelerations of the end-effector to 50 digits, by the standard
library's decimals.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ....models.robots import FiveBar

DIGITS = 50


def exact_motion(
    robot: FiveBar,
    q: Sequence[float],
    q_dot: Sequence[float] = (0.0, 0.0),
    q_ddot: Sequence[float] = (0.0, 0.0),
    assembly: int = -1,
) -> tuple:
    """xi, xi', xi'' (3 x 2 decimals) of joint angles (2,) rad, their rates and accelerations; the
    floats are exact.

    From the elbows E_i: the circles' intersection, then r_i . xi' = r_i . E_i' and
    r_i . xi'' = r_i . E_i'' - |xi' - E_i'|^2 with r_i = xi - E_i.
    """
    with localcontext(prec=DIGITS + 15):
        elbows = []
        for base, length, angle, rate, acceleration in zip(
            (-Decimal(robot.d) / 2, Decimal(robot.d) / 2), (robot.l11, robot.l21), q, q_dot, q_ddot
        ):
            (cos, sin), length = cos_sin(Decimal(float(angle))), Decimal(length)
            w, a = Decimal(float(rate)), Decimal(float(acceleration))
            place = base + length * cos, length * sin
            speed = -length * sin * w, length * cos * w
            bend = -length * (cos * w * w + sin * a), length * (cos * a - sin * w * w)
            elbows.append((place, speed, bend))
        (e1, v1, a1), (e2, v2, a2) = elbows
        dx, dy = e2[0] - e1[0], e2[1] - e1[1]
        l1, l2 = Decimal(robot.l12), Decimal(robot.l22)
        square = dx * dx + dy * dy
        along = (square + l1 * l1 - l2 * l2) / (2 * square)
        across = -assembly * (l1 * l1 / square - along * along).sqrt()
        xi = e1[0] + along * dx - across * dy, e1[1] + along * dy + across * dx
        r1, r2 = ((xi[0] - e[0], xi[1] - e[1]) for e in (e1, e2))
        det = r1[0] * r2[1] - r1[1] * r2[0]

        def solve(s1, s2):
            return (s1 * r2[1] - s2 * r1[1]) / det, (s2 * r1[0] - s1 * r2[0]) / det

        xi_dot = solve(*(r[0] * v[0] + r[1] * v[1] for r, v in ((r1, v1), (r2, v2))))
        xi_ddot = solve(
            *(
                r[0] * a[0] + r[1] * a[1] - (xi_dot[0] - v[0]) ** 2 - (xi_dot[1] - v[1]) ** 2
                for r, v, a in ((r1, v1, a1), (r2, v2, a2))
            )
        )
    return xi, xi_dot, xi_ddot


def cos_sin(x: Decimal) -> tuple[Decimal, Decimal]:
    """Both by their series, of a small part of the angle that is then doubled."""
    halvings = 12
    small = x / 2**halvings
    sin, term, k = small, small, 1
    cos_less_1, other = Decimal(0), Decimal(1)  # cos - 1 keeps its digits when doubled
    while abs(term) > Decimal(10) ** -(2 * DIGITS):
        other *= -small * small / (k * (k + 1))
        cos_less_1 += other
        term *= -small * small / ((k + 1) * (k + 2))
        sin += term
        k += 2
    for _ in range(halvings):
        sin, cos_less_1 = 2 * sin * (1 + cos_less_1), 2 * cos_less_1 * (2 + cos_less_1)
    return 1 + cos_less_1, sin


def distance(found: Sequence[float], exact: Sequence[Decimal]) -> float:
    """|found - exact| of two numbers and two decimals, as a float: without the rounding of the
    exact ones.
    """
    with localcontext(prec=DIGITS + 15):
        return float(sum((Decimal(float(a)) - b) ** 2 for a, b in zip(found, exact)).sqrt())
