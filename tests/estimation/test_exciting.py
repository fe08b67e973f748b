"""Exciting motions: within their limits at every time, at rest at both ends, better than what chance gives."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.identification import exciting
from fivebar.estimation.identification.regressor import linear_names, regressor

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


@pytest.mark.deep
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
    with pytest.raises(ValueError, match="margin must be finite and from 0.01 to 0.9"):
        fb.exciting_trajectory(ROBOT, margin=0.0)


@pytest.mark.parametrize(
    "robot, unknown, unit",
    [
        (fb.FiveBar(), ["zz1", "zz2", "m"], "rates to {} rad/s, torques to {} N m"),
        (fb.Biglide(), ["mf1", "m"], "rates to {} m/s, forces to {} N"),
    ],
)
def test_a_short_search_says_what_its_motion_is(robot, unknown, unit, monkeypatch, tmp_path):
    """Peaks, margin and condition by the models, at other times than those of the search."""
    monkeypatch.setattr(exciting, "BEST", 2)
    monkeypatch.setattr(exciting, "STEPS", 5)
    limits = {"rate": 5.0, "acceleration": 4.0, "torque": 8.0}
    found = fb.exciting_trajectory(
        robot, period=2.0, cycles=3, harmonics=2, starts=3, unknown=unknown, **limits
    )
    t = np.linspace(0.0, 2.0, 2801)
    q, q_dot, q_ddot = found.joints(t)
    pose = fb.dgm(robot, q, found.assembly)
    acc = fb.dkm2(fb.dkm(pose, q_dot), q_ddot)
    values = {"rate": q_dot, "acceleration": q_ddot, "torque": fb.inverse_dynamics(acc)}
    for name, limit in limits.items():
        peaks = np.abs(values[name]).max(axis=0)
        assert found.peaks[name] == pytest.approx(peaks, rel=1e-4)
        assert peaks.max() <= limit
    margin = min(np.abs(each).min() for each in (*pose.sines, pose.det_A))
    assert found.margin == pytest.approx(margin, rel=1e-4) and margin >= 0.25
    assert pose.working.tolist() == [[-1, -1]] * len(t)
    columns = [linear_names(robot).index(name) for name in unknown]
    W = regressor(robot, q, q_dot, q_ddot, -1)[:, :, columns].reshape(-1, len(columns))
    condition = np.linalg.cond(W / np.linalg.norm(W, axis=0))
    assert found.condition == pytest.approx(condition, rel=1e-3)
    assert (found.start, found.duration) == (0.0, 6.0)
    for value, exact in zip(found(t + 4.0), (pose.xi, acc.rates.xi_dot, acc.xi_ddot)):
        assert value == pytest.approx(exact, abs=1e-9)
    largest = (f"{max(found.peaks[name]):.3g}" for name in ("rate", "torque"))
    words = f"6 s, condition {found.condition:.3g}, {unit.format(*largest)}"
    assert repr(found) == f"<Excitation: {words}>"
    found.to_csv(tmp_path / "a.csv", step=0.05)
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", comments=("#", "t"))
    own = np.linspace(0.0, 6.0, 121)
    xi, xi_dot, _ = found(own)
    rows = np.column_stack([own, xi, xi_dot, found.joints(own)[0]])
    assert table == pytest.approx(rows, abs=1e-12)


def test_limits_that_no_motion_keeps_are_refused():
    with pytest.raises(ValueError, match="no motion was found .* modes .-1, -1. .* mode -1"):
        fb.exciting_trajectory(fb.FiveBar(), period=2.0, harmonics=2, torque=1e-4, starts=2)


@pytest.mark.deep
def test_no_motion_depends_on_the_last_digits():
    """The same seed gives the same motion on machines that round otherwise: here of periods a digit apart."""
    robot = fb.FiveBar(gravity=(0.0, -9.81))
    own, other = (
        fb.exciting_trajectory(robot, period=period, rate=6.0, starts=5)
        for period in (4.0, 4.0 * (1 + 2e-15))
    )
    t = np.linspace(0, 3.999, 50)
    assert np.abs(own(t)[0] - other(t)[0]).max() < 1e-6
    assert other.condition == pytest.approx(own.condition, rel=1e-3)


def test_what_no_motion_tells_and_torques_that_hold_no_pose_are_refused_at_once():
    with pytest.raises(ValueError, match="unknown: .*mx11"):
        fb.exciting_trajectory(fb.FiveBar(), unknown=["mx11"])
    upright = fb.FiveBar(gravity=(0, -9.81))
    with pytest.raises(ValueError, match="no motion was found .* ask for less margin, more torque"):
        fb.exciting_trajectory(upright, torque=0.01)
