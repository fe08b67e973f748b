"""Rows near Type 2: which they are, and their weights against draws of many."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.fit import LeastSquares, weighted_by_loops
from fivebar.estimation.calibration.measured_robot import bars_off, values_of, whitening
from fivebar.estimation.calibration.rows import rows_of

ROBOT = fb.FiveBar(0.1, 0.14, 0.09, 0.13, 0.11)


@pytest.mark.parametrize("scale", [1.0, 40.0])
@pytest.mark.parametrize("bend", [0.0, 1e-3, 0.05, 0.8])
def test_whitened_errors_of_legs_are_independent_and_of_size_1(bend, scale):
    """Of 25,000 noisy points at one pose: mean 0, variance 1, no correlation; at Type 2, too."""
    l12, l22 = ROBOT.l12, ROBOT.l22
    left = np.array([-ROBOT.d / 2 + ROBOT.l11 * np.cos(2.2), ROBOT.l11 * np.sin(2.2)])
    point = left + l12 * np.array([np.cos(0.3), np.sin(0.3)])
    right = point + l22 * np.array([np.cos(0.3 + bend), np.sin(0.3 + bend)])
    # A robot whose right crank just reaches there.
    crank = right - (ROBOT.d / 2, 0.0)
    robot = replace(ROBOT, l21=float(np.hypot(*crank)))
    q = np.array([[2.2, np.arctan2(crank[1], crank[0])]])
    p = values_of(robot, {"scale": scale, "turn": 0.4, "x0": 0.2})
    c, s = np.cos(0.4), np.sin(0.4)
    seen = scale * np.array([[c, -s], [s, c]]) @ point + (0.2, 0.0)
    sigma = 0.004 * scale * l12
    count = 25_000
    noise = sigma * np.random.default_rng(1).normal(size=(count, 2))
    errors, _ = bars_off(p, np.repeat(q, count, axis=0), seen + noise)
    W = whitening(p, q, np.array([sigma]))[0]
    residuals = errors @ W[:, :2].T - W[:, 2]
    assert residuals.mean(axis=0) == pytest.approx((0.0, 0.0), abs=0.02)
    assert np.cov(residuals.T) * sigma**-2 == pytest.approx(np.eye(2), abs=0.03)


def near_and_far(rng, n=60):
    """Readings of poses in assembly mode -1, their points and sines, most of them near Type 2."""
    found = []
    while len(found) < n:
        q = rng.uniform(-np.pi, np.pi, 2)
        pose = fb.dgm(ROBOT, q, -1, unreachable="nan")
        if np.isfinite(pose.det_A) and (pose.det_A < 0.3 or len(found) % 3 == 0):
            found.append((q, pose.xi, pose.det_A))
    return map(np.array, zip(*found))


@pytest.mark.parametrize("sigma", [1e-5, 2e-4, 1.2e-3, 4e-3])
def test_rows_whose_noise_may_open_the_loop_are_fitted_by_their_loops(sigma):
    """Those whose sine^2 is below 20 sigma / bar, and below 0.2; no half points, nor too rough ones."""
    scale = 2.0
    q, xi, det_A = near_and_far(np.random.default_rng(6))
    points = scale * xi
    points[::7, 1] = np.nan
    columns = {"q1": q[:, 0], "q2": q[:, 1], "x": points[:, 0], "y": points[:, 1]}
    rows = rows_of(columns)
    weight = np.where(rows.row_of % 2, 1.0, 0.5)
    p = values_of(ROBOT, {"scale": scale})
    task = LeastSquares(rows, np.array([0]), p, np.ones(1), weight)
    own = sigma * np.where(np.arange(60) % 2, 1.0, 2.0)
    share = own / (scale * 0.13)
    near = (det_A**2 < 20 * share) & (det_A < 0.2) & np.isfinite(points[:, 1]) & (share < 0.02)
    found = weighted_by_loops(task, p, sigma)
    if not near.any():
        assert found is task
        return
    assert 3 < near.sum() < 45
    loop = found.rows.loop
    assert np.array_equal(np.isfinite(loop).all(axis=(1, 2)), near)
    assert loop[near] == pytest.approx(whitening(p, q[near], own[near]))
    assert found.rows.looped[0].tolist() == np.flatnonzero(near).tolist()
    # Once chosen, they stay; only their weights are renewed.
    again = weighted_by_loops(found, p, 2 * sigma).rows.loop
    assert again[near] == pytest.approx(whitening(p, q[near], 2 * own[near]))
    assert np.isnan(again[~near]).all()
