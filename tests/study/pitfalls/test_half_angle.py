"""The tangent half-angle formula divides 0 by 0 where the other root is 180 degrees; the RRR dyad notices nothing."""

import mpmath
import numpy as np

import fivebar as fb
from fivebar.study.pitfalls.half_angle import approach, half_angle_igm

ROBOT = fb.FiveBar()
CASE = approach(ROBOT, np.append(10.0 ** -np.arange(1, 17), 0.0), angle=1.0)


def exact_q11(xi):
    with mpmath.workdps(50):
        x, y = mpmath.mpf(xi[0]) + mpmath.mpf(ROBOT.d) / 2, mpmath.mpf(xi[1])
        span = x * x + y * y
        return float(
            mpmath.atan2(y, x) - mpmath.acos(mpmath.sqrt(span) / (2 * mpmath.mpf(ROBOT.l11)))
        )


def keeps_its_digits(q11):
    exact = np.array([exact_q11(xi) for xi in CASE.xi])
    return bool((np.abs(np.angle(np.exp(1j * (q11 - exact)))) <= 1e-14).all())


def test_near_b_equals_c():
    assert keeps_its_digits(CASE.dyad)
    assert not keeps_its_digits(CASE.formula)
    lost = np.abs(CASE.formula - CASE.dyad)
    assert (
        lost[0] < 1e-14 and 1e-10 < lost[7] < 1e-6 and lost[12] > 1e-6
    )  # a digit lost for each digit nearer
    assert np.isnan(CASE.formula[-1])


def test_elsewhere_the_formula_is_right():
    xi = np.random.default_rng(3).uniform((-0.1, 0.05), (0.0, 0.12), (200, 2))
    for working in (-1, 1):
        difference = (
            half_angle_igm(ROBOT, xi, working)
            - fb.igm(ROBOT, xi, (working, -1), unreachable="nan").q[:, 0]
        )
        assert np.abs(np.angle(np.exp(1j * difference))).max() < 1e-11
