"""Integrators on a motion without torque of a robot without Type 2: who keeps its energy."""

import numpy as np
import pytest

from fivebar.study.pitfalls.energy_drift import drift_by, drift_of_ours


def worst(drift):
    """The largest error; infinite where the solver did not get to the end."""
    return np.abs(drift.error).max() if len(drift.error) else np.inf


def keeps_its_energy(drift):
    return worst(drift) < 1e-9


@pytest.fixture(scope="module")
def ours():
    return drift_of_ours(step=1e-3)


def test_ours_does(ours):
    assert keeps_its_energy(ours)
    assert worst(drift_of_ours(step=1e-2)) / worst(ours) == pytest.approx(1e4, rel=0.5)  # order 4
    assert worst(drift_of_ours(step=1e-4)) < 1e-12


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param("explicit Euler", marks=pytest.mark.deep),
        "semi-implicit Euler",
        "DOP853",
        "Radau",
    ],
)
def test_those_that_do_not(name):
    """Euler's methods at the same step; SciPy's at the tolerances they come with."""
    assert not keeps_its_energy(drift_by(name, step=1e-3))


@pytest.mark.deep
def test_those_that_do_as_well(ours):
    """Away from singularities a careful user of joint coordinates is as well served: the price is the time."""
    assert keeps_its_energy(drift_by("RK4", step=1e-3))
    assert keeps_its_energy(drift_by("DOP853", rtol=1e-12))
