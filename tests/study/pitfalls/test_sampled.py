"""Sampled computed torque: the measured limit of stability, and what continuous-time reasoning says of it."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.sampled import boundary, growth, measure_limit, spectral_radius
from tests.benchmarks.gains import is_stable

ROBOT = fb.FiveBar()
DELAYS = (0, 1)
# The largest s = sqrt(Kp) h of critically damped gains, Kd = 2 sqrt(Kp), that are stable.
CRITICALLY_DAMPED = {0: 1.0, 1: 0.426158909}


@pytest.mark.deep
@pytest.mark.parametrize("delay", [0, pytest.param(1, marks=pytest.mark.deep)])
def test_measured_limit_is_the_exact_one(delay):
    limit = measure_limit(ROBOT, delay)
    assert limit.measured.shape == (8, 2) and limit.worst < 0.01


def in_continuous_time(p, q, delay):
    """Any positive gains are stable there."""
    return p > 0 and q > 0


def foretells_the_robot(criterion, delay):
    """Just inside and just outside the limit of critically damped gains."""
    for share in (0.97, 1.03, 1.2):
        s = share * CRITICALLY_DAMPED[delay]
        if bool(criterion(s * s, 2 * s, delay)) != (growth(ROBOT, s * s, 2 * s, delay) < 1):
            return False
    return True


@pytest.mark.every(2)
@pytest.mark.parametrize("delay", DELAYS)
def test_criteria(delay):
    assert foretells_the_robot(is_stable, delay)
    assert not foretells_the_robot(in_continuous_time, delay)
    assert not foretells_the_robot(lambda p, q, _: is_stable(p, q, 1 - delay), delay)


@pytest.mark.parametrize("delay", DELAYS)
def test_growth_is_the_spectral_radius(delay):
    s = 1.03 * CRITICALLY_DAMPED[delay]
    assert growth(ROBOT, s * s, 2 * s, delay) == pytest.approx(
        spectral_radius(s * s, 2 * s, delay), rel=0.01
    )
    assert spectral_radius(
        CRITICALLY_DAMPED[delay] ** 2, 2 * CRITICALLY_DAMPED[delay], delay
    ) == pytest.approx(1)


@pytest.mark.parametrize("delay", DELAYS)
def test_conditions_against_eigenvalues(delay):
    p, q = np.random.default_rng(5).uniform((-0.5, -0.5), (5, 3), (4000, 2)).T / (1 + 3 * delay)
    radius = np.array([spectral_radius(*gains, delay) for gains in zip(p, q)])
    clear = np.abs(radius - 1) > 1e-6
    assert (is_stable(p, q, delay) == (radius < 1))[clear].all()
    assert is_stable(p, q, delay).mean() > 0.02
    for gains in boundary(delay):
        assert spectral_radius(*gains, delay) == pytest.approx(1, abs=1e-6)
