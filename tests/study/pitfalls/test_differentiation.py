"""Differences of positions have a best step, and at that step still half or two thirds of the digits are gone."""

import mpmath
import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.differentiation import OURS, analytic, differences, error_curve

ROBOT = fb.FiveBar()
TIMES = np.array([0.1, 0.7, 1.3, 1.9])
STEPS = np.geomspace(1e-12, 1.0, 49)


def exact_position(t, component):
    size, rate, phase = ("0.3", "0.25"), (3, 4), ("0.4", "1.1")
    q = [mpmath.mpf(s) * mpmath.sin(r * t + mpmath.mpf(f)) for s, r, f in zip(size, rate, phase)]
    bar, half = mpmath.mpf("0.09"), mpmath.mpf("0.059")
    (x1, y1), (x2, y2) = (
        (s * half + bar * mpmath.cos(a), bar * mpmath.sin(a)) for s, a in zip((-1, 1), q)
    )
    dx, dy = (x2 - x1) / 2, (y2 - y1) / 2
    share = mpmath.sqrt(bar * bar / (dx * dx + dy * dy) - 1)
    return (x1 + dx - share * dy, y1 + dy + share * dx)[component]


@pytest.fixture(scope="module")
def exact():
    with mpmath.workdps(50):
        return [
            np.array(
                [
                    [
                        float(
                            mpmath.diff(
                                lambda s, k=k: exact_position(s, k), mpmath.mpf(float(t)), order
                            )
                        )
                        for k in (0, 1)
                    ]
                    for t in TIMES
                ]
            )
            for order in (1, 2)
        ]


def rates_are_exact(found, exact):
    return all(
        np.abs(rate - true).max() <= OURS * np.abs(true).max() for rate, true in zip(found, exact)
    )


def test_rates_against_50_digits(exact):
    assert rates_are_exact(analytic(ROBOT, TIMES), exact)
    for step in STEPS:
        assert not rates_are_exact(differences(ROBOT, TIMES, step), exact)


def test_the_error_is_v_shaped():
    curve = error_curve(ROBOT, STEPS)
    for error, best, between in (
        (curve.velocity, 1e-9, (1e-9, 1e-7)),
        (curve.acceleration, 1e-6, (1e-6, 1e-4)),
    ):
        k = int(np.argmin(error))
        assert between[0] < STEPS[k] < between[1]
        assert error[k] > best
        truncation = (STEPS > 30 * STEPS[k]) & (STEPS < 1e-2)
        slope = np.polyfit(np.log(STEPS[truncation]), np.log(error[truncation]), 1)[0]
        assert slope == pytest.approx(1, abs=0.1)  # backward differences: of first order
        assert error[0] > 1e3 * error[k]
    slope = np.polyfit(np.log(STEPS[:16]), np.log(curve.velocity[:16]), 1)[0]
    assert slope == pytest.approx(-1, abs=0.15)  # rounding over the step
