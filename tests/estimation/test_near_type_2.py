"""Calibration on poses near Type 2, where the loop nearly opens: no row is refused, intervals stay honest."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import LENGTHS, bars_off, values_of, whitening
from tests.helpers.twins import LAB, MODES, NOMINAL, robot_of, seen, twin

UNKNOWN = (*LENGTHS, "offset1", "offset2")
SIGMA = 2e-5


def anywhere(true, n, rng, margin=0.0):
    """n poses all over the workspace: only Type 1 is kept away from."""
    robot, found = robot_of(true), []
    while len(found) < n:
        xi = rng.uniform(-0.2, 0.2, 2)
        pose = fb.igm(robot, xi, MODES[rng.integers(4)], unreachable="nan")
        if np.isfinite(pose.q).all() and min(np.abs(pose.sines)) > margin:
            found.append(pose)
    return found


def data_of(true, found, rng, sigma):
    q, points, *_ = seen(true, found)
    points = points + sigma * rng.standard_normal(points.shape)
    return dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])


def share_inside(sets, rng, given, n, margin=0.0, unknown=UNKNOWN):
    inside, near, poor = 0, 0, 0
    for _ in range(sets):
        true = twin(rng, LAB, unknown, spread=0.55)
        found = anywhere(true, n, rng, margin)
        data = data_of(true, found, rng, SIGMA)
        result = fb.calibrate(LAB, data, unknown, sigma=SIGMA if given else None)
        inside += sum(low <= true[name] <= high for name, (low, high) in result.intervals().items())
        by_loops = result.rows.looped[0]
        near += len(by_loops)
        opened = np.flatnonzero(np.isnan(result.residuals).any(axis=1))
        assert set(opened) <= set(by_loops)
        assert result.rms < 3 * SIGMA
        poor += result.fits is False
    assert near > 0 and poor <= 1 + sets // 200
    return inside / (sets * len(unknown))


@pytest.mark.deep
@pytest.mark.parametrize("given", [True, False])
def test_clean_data_are_never_refused(given):
    rng = np.random.default_rng(40)
    assert abs(share_inside(80, rng, given, 60, 0.15) - 0.95) < 0.04


@pytest.mark.deep
@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("n", [12, 60])
def test_intervals_hold_the_truth_without_any_margin(n, given):
    rng = np.random.default_rng(41)
    assert abs(share_inside(400, rng, given, n) - 0.95) < 0.016


@pytest.mark.deep
def test_a_measuring_frame_of_another_scale():
    rng = np.random.default_rng(42)
    unknown = (*LENGTHS[:4], "offset1", "offset2", "x0", "y0", "turn", "scale")
    assert abs(share_inside(100, rng, True, 60, unknown=unknown) - 0.95) < 0.03


@pytest.mark.deep
@pytest.mark.parametrize("det", [0.3, 1e-2, 1e-3, 1e-4, 1e-6, 0.0])
def test_whitened_errors_of_the_legs_are_independent_and_of_variance_one(det):
    """4 10^5 points with noise at a pose with this det A; at 1e-4, its second order matters as much as its first."""
    p = values_of(NOMINAL)
    # The bars' triangle over the span of the elbows; symmetric cranks make that span.
    span = np.sqrt(p[1] ** 2 + p[3] ** 2 + 2 * p[1] * p[3] * np.sqrt(1 - det**2))
    p[0] = p[2] = 0.1
    turn = np.arcsin((span - p[4]) / 0.2)
    q = np.array([[np.pi / 2 + turn, np.pi / 2 - turn]])
    height = 0.1 * np.cos(turn)
    x = (p[1] ** 2 - p[3] ** 2) / (2 * span)
    y = height + np.sqrt(max(p[1] ** 2 - (x + span / 2) ** 2, 0.0))
    rng = np.random.default_rng(43)
    points = np.array([x, y]) + SIGMA * rng.standard_normal((400_000, 2))
    errors, _ = bars_off(p, np.repeat(q, len(points), axis=0), points)
    whiten = whitening(p, q, np.array([SIGMA]))[0]
    residuals = (errors @ whiten[:, :2].T - whiten[:, 2]) / SIGMA
    assert np.abs(residuals.mean(axis=0)).max() < 0.01
    assert np.abs(np.cov(residuals.T) - np.eye(2)).max() < 0.04


def test_exact_data_near_type_2_give_exact_lengths():
    rng = np.random.default_rng(44)
    true = twin(rng, LAB, UNKNOWN)
    robot = robot_of(true)
    spans = robot.l12 + robot.l22 - 10.0 ** -np.arange(4.0, 9.0)
    found = anywhere(true, 30, rng, 0.1)
    for span in spans:
        turn = np.arcsin((span - robot.d) / (robot.l11 + robot.l21))
        q = (np.pi / 2 + turn, np.pi / 2 - turn)
        pose = fb.dgm(robot, q, -1, unreachable="nan")
        if np.isfinite(pose.xi).all():
            found.append(pose)
    result = fb.calibrate(LAB, data_of(true, found, rng, 0.0), UNKNOWN)
    assert max(abs(result.values[name] - true[name]) for name in UNKNOWN) < 1e-11


@pytest.mark.deep
def test_a_file_keeps_the_weights_of_the_loops(tmp_path):
    rng = np.random.default_rng(45)
    true = twin(rng, LAB, UNKNOWN, spread=0.55)
    result = fb.calibrate(LAB, data_of(true, anywhere(true, 60, rng), rng, SIGMA), UNKNOWN)
    assert len(result.rows.looped[0])
    result.to_json(tmp_path / "c.json")
    again = fb.Calibration.from_json(tmp_path / "c.json")
    assert again.sd == result.sd and again.chi2 == result.chi2


def test_a_wrong_reading_is_still_named():
    rng = np.random.default_rng(46)
    true = twin(rng, LAB, UNKNOWN)
    data = data_of(true, anywhere(true, 40, rng, 0.3), rng, SIGMA)
    data["q1"][7] += 2.0
    try:
        result = fb.calibrate(LAB, data, UNKNOWN, sigma=SIGMA)
    except ValueError as error:
        assert "row 8: with these angles" in str(error)
    else:
        assert next(iter(result.outliers)) == "row 8"
