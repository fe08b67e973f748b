"""Exciting motions: within their limits at every time, at rest at both ends, better than what chance gives."""

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.ROBOTS["iri-vertical"].robot
LIMITS = dict(period=5.0, harmonics=4, rate=5.0, acceleration=60.0, torque=9.0, starts=20)


@pytest.fixture(scope="module")
def found():
    return fb.exciting_trajectory(ROBOT, **LIMITS)


@pytest.mark.deep
def test_limits_hold_at_every_time_and_both_ends_rest(found):
    t = np.linspace(0, 5, 20_011)
    xi, xi_dot, xi_ddot = found(t)
    pose = fb.igm(ROBOT, xi, found.working)
    acc = fb.ikm2(fb.ikm(pose, xi_dot), xi_ddot)
    assert np.abs(acc.rates.q_dot).max() <= 5.0 and np.abs(acc.q_ddot).max() <= 60.0
    assert np.abs(fb.inverse_dynamics(acc)).max() <= 9.0 * (1 + 1e-6)
    assert (pose.assembly == -1).all()
    assert min(np.abs(each).min() for each in (*pose.sines, pose.det_A)) >= 0.25 * (1 - 1e-3)
    for values, exact in zip(found.joints(t), (pose.q, acc.rates.q_dot, acc.q_ddot)):
        np.testing.assert_allclose(values - exact, 0, atol=1e-8 * np.abs(exact).max())
    assert max(np.abs(each).max() for each in found(0.0)[1:] + found(5.0)[1:]) < 1e-12
    for name, values in (("rate", acc.rates.q_dot), ("acceleration", acc.q_ddot)):
        np.testing.assert_allclose(found.peaks[name], np.abs(values).max(axis=0), rtol=1e-3)


@pytest.mark.deep
def test_the_same_seed_gives_the_same_motion_and_improving_helps(found):
    again = fb.exciting_trajectory(ROBOT, **LIMITS)
    np.testing.assert_array_equal(again(1.234)[0], found(1.234)[0])
    assert "condition" in repr(found) and found.condition < 400
    first = fb.exciting_trajectory(ROBOT, **{**LIMITS, "starts": 1}, seed=3)
    assert found.condition < first.condition


def test_it_is_simulated_written_and_read(tmp_path, found):
    run = fb.simulate(
        ROBOT,
        fb.ComputedTorque(ROBOT, 400.0, 40.0),
        found,
        control_period=5e-3,
        step=5e-3,
        duration=1.0,
    )
    assert np.abs(run.error).max() < 1e-3 and run.events == ()
    found.to_csv(tmp_path / "a.csv")
    again = fb.from_csv(tmp_path / "a.csv")
    np.testing.assert_allclose(again(2.345)[0], found(2.345)[0], atol=1e-6)


@pytest.mark.deep
def test_a_biglide_and_what_cannot_be():
    found = fb.exciting_trajectory(fb.Biglide(), period=4.0, harmonics=3, starts=5)
    assert found.margin >= 0.25 * (1 - 1e-3) and np.isfinite(found.condition)
    with pytest.raises(ValueError, match="no motion was found within these limits"):
        fb.exciting_trajectory(ROBOT, torque=0.01, starts=2)
    with pytest.raises(ValueError, match="margin must be finite and from 0.01 to 0.9"):
        fb.exciting_trajectory(ROBOT, margin=0.0)
