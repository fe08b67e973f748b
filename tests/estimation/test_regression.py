"""Parts of the regression against sums written out: filtered rows, weights, models."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.signal import lfilter

import fivebar as fb
from fivebar.estimation.identification.filtering import RegressionRows, at_limit, filtered
from fivebar.estimation.identification.regression import (
    RegressionFit,
    fit,
    left_out_cost,
    price,
    smallest,
    spread,
)
from fivebar.estimation.logs.logs import off_their_neighbours

ROBOT = fb.FiveBar()
STEP, CUTOFF = 2e-3, 10.0


def pieces_of(rng, lengths, theta):
    pieces = []
    start = 0.0
    for n in lengths:
        t = start + STEP * np.arange(n)
        W = rng.normal(size=(n, 2, len(theta)))
        pieces.append((t, W, W @ theta, np.ones((n, 2), bool)))
        start = t[-1] + 1.0
    return pieces


def test_filtered_rows_keep_the_equation_whatever_counts():
    """Both sides have the same filter, so that exact samples make exact rows."""
    rng = np.random.default_rng(1)
    theta = np.array([0.5, -2.0, 3.0])
    pieces = pieces_of(rng, (400, 250), theta)
    for _, _, tau, counts in pieces:
        counts[rng.uniform(size=counts.shape) < 0.2] = False
        counts[100:160, 0] = False
        tau[~counts] = np.nan
    rows = filtered(pieces, STEP, CUTOFF)
    assert rows.W @ theta == pytest.approx(rows.tau, abs=1e-12)
    down = int(1 / (2.5 * CUTOFF * STEP))
    assert rows.breaks[0] == 0 and len(rows.breaks) == 2
    for piece, own in zip(pieces, np.split(np.arange(len(rows.t)), rows.breaks[1:])):
        t = rows.t[own]
        assert np.diff(t) == pytest.approx(np.full(len(t) - 1, down * STEP))
        places = (t - piece[0][0]) / STEP
        assert places == pytest.approx(np.round(places), abs=1e-6)
        assert places[0] < down and places[-1] >= len(piece[0]) - down
    middle = (rows.t > 0.23) & (rows.t < 0.29)
    assert middle.any() and not rows.counts[middle, 0].any() and rows.counts[middle, 1].all()
    assert not rows.tau[~rows.counts].any() and not rows.W[~rows.counts].any()
    assert np.array_equal(rows.counts, rows.cover > 0.2)


def test_filtered_rows_of_what_is_slow_are_the_samples_themselves():
    n = 600
    t = STEP * np.arange(n)
    for frequency, share in ((0.0, 1.0), (2.0, 1.0), (0.9 * CUTOFF, 0.99), (2.2 * CUTOFF, 0.0)):
        wave = np.cos(2 * np.pi * frequency * t)
        tau = np.stack([wave, -wave], axis=1)
        rows = filtered([(t, tau[..., None], tau, np.ones((n, 2), bool))], STEP, CUTOFF)
        inner = (rows.t > 0.2) & (rows.t < 1.0)
        assert rows.cover[inner] == pytest.approx(1.0, abs=2e-3)
        place = np.round(rows.t[inner] / STEP).astype(int)
        assert rows.tau[inner] == pytest.approx(share * tau[place], abs=0.02)
        assert rows.W[inner, :, 0] == pytest.approx(rows.tau[inner], abs=1e-12)


def test_rows_of_white_noise_are_as_noisy_as_said_where_few_samples_count_too():
    rng = np.random.default_rng(2)
    n = 60_000
    counts = np.ones((n, 2), bool)
    counts[:, 1] = rng.uniform(size=n) < 0.5
    piece = (STEP * np.arange(n), np.ones((n, 2, 1)), rng.normal(size=(n, 2)), counts)
    rows = filtered([piece], STEP, CUTOFF)
    assert rows.tau.std(axis=0) == pytest.approx(np.full(2, rows.gain), rel=0.05)
    assert rows.cover[:, 1].mean() == pytest.approx(0.5, abs=0.01)
    noise = rows.tau[:, 0]
    assert abs(np.mean(noise[1:] * noise[:-1])) < 0.2 * noise.var()


@pytest.mark.parametrize("size", [0.05, 0.3, 5.0])
def test_wrong_torques_are_up_to_three_rows_far_from_their_neighbours(size):
    t = np.linspace(0.0, 1.0, 400)
    tau = np.stack([np.sin(2 * np.pi * t), np.cos(5 * t)], axis=1)
    tau[120] = np.nan
    assert not off_their_neighbours(tau).any()
    tau[[50, 51, 300], [0, 0, 1]] += size
    assert np.flatnonzero(off_their_neighbours(tau)).tolist() == [50, 51, 300]
    assert off_their_neighbours(tau, 0.25).sum() == (3 if size > 0.5 else 0)
    tau[::50] += size
    assert not off_their_neighbours(tau).any()
    assert np.flatnonzero(off_their_neighbours(tau[260:350])).tolist() == []
    tau[90:] = np.nan
    assert not off_their_neighbours(tau[:100]).any()


def test_torques_that_stay_at_their_extreme_are_at_a_limit():
    tau = np.linspace(0.0, 0.4, 24).reshape(12, 2)
    tau[2:5, 0] = 2.0
    tau[7:9, 0] = 2.0
    tau[0:4, 1] = -1.0
    tau[6, 1] = 0.5
    expected = np.zeros((12, 2), bool)
    expected[2:5, 0] = expected[0:4, 1] = True
    tau[3, 0] += 1e-9
    assert np.array_equal(at_limit(tau, tau.min(axis=0), tau.max(axis=0)), expected)
    tau[3, 0] += 1e-6
    assert not at_limit(tau, tau.min(axis=0), tau.max(axis=0))[:, 0].any()


@pytest.mark.parametrize("rows, limited", [(5, False), (6, False), (7, True), (10, True)])
def test_a_torque_that_is_held_at_its_peak_is_at_no_limit(rows, limited):
    """Each is held for 5 rows."""
    held = np.repeat(np.sin(0.3 * np.arange(20)), 5)
    peak = np.argmax(held)
    tau = np.insert(held, peak, np.full(rows - 5, held[peak]))[:, None].repeat(2, axis=1)
    found = at_limit(tau, np.full(2, -9.0), tau.max(axis=0))
    expected = (np.arange(len(tau)) >= peak) & (np.arange(len(tau)) < peak + rows)
    assert np.array_equal(found, (expected & limited)[:, None].repeat(2, axis=1))


def rows_of(rng, n, theta, sigma):
    W = rng.normal(size=(n, 2, len(theta))) * (1.0, 10.0, 0.1)
    counts = np.ones((n, 2), bool)
    counts[: n // 4, 0] = False
    tau = W @ theta + rng.normal(size=(n, 2)) * sigma
    W[~counts] = 0.0
    tau[~counts] = 0.0
    return RegressionRows(W, tau, counts, np.arange(n, dtype=float), counts * 1.0, (0, n // 2), 1.0)


def test_a_fit_weighs_each_motor_by_its_noise():
    """Against weighted least squares of all rows, and the noise that was put in."""
    rng = np.random.default_rng(3)
    theta, sigma = np.array([1.0, -0.3, 20.0]), np.array([0.5, 0.05])
    rows = rows_of(rng, 4000, theta, sigma)
    found = fit(rows, [0, 1, 2])
    assert found.sigma == pytest.approx(sigma, rel=0.05)
    flat = (rows.W / found.sigma[:, None]).reshape(-1, 3)
    expected = np.linalg.lstsq(flat, (rows.tau / found.sigma).ravel(), rcond=None)[0]
    assert found.theta == pytest.approx(expected, rel=2e-2)
    residual = np.where(rows.counts, rows.tau - rows.W @ found.theta, 0.0)
    assert found.residual == pytest.approx(residual, abs=1e-12)
    free = rows.counts.sum(axis=0) - 1.5
    assert found.sigma == pytest.approx(np.sqrt((residual**2).sum(axis=0) / free), rel=1e-3)
    power = (rows.tau**2).sum(axis=0)
    misfit = np.sqrt(np.mean((residual**2).sum(axis=0) / power))
    assert found.misfit == pytest.approx(misfit, rel=1e-9)
    white = np.linalg.inv(flat.T @ flat)
    assert np.diag(found.cov) == pytest.approx(np.diag(white), rel=0.15)
    part = fit(replace(rows, tau=2 * rows.tau), [2, 0])
    assert part.theta == pytest.approx(2 * theta[[2, 0]], rel=0.3)
    assert part.residual.shape == rows.tau.shape


def test_deviations_of_a_fit_grow_with_residuals_that_belong_together():
    """Noise that lasts k rows is as good as n / k rows: its neighbours are alike."""
    rng = np.random.default_rng(4)
    n = 2000
    slow = np.repeat(rng.normal(size=(n // 5, 2)), 5, axis=0)
    W = np.repeat(rng.normal(size=(n // 5, 2, 1)), 5, axis=0)
    ones = np.ones((n, 2), bool)
    rows = RegressionRows(W, W[..., 0] + slow, ones, np.arange(n * 1.0), ones * 1.0, (0,), 1.0)
    found = fit(rows, [0])
    white = 1 / (W[..., 0] ** 2 / found.sigma**2).sum()
    assert 1.5 < found.cov[0, 0] / white < 6.0


@pytest.mark.parametrize(("n", "neighbours"), [(70, -0.7), (70, 0.0), (300, -0.7), (300, 0.6)])
def test_deviations_of_a_fit_are_the_size_of_its_errors(n, neighbours):
    """Of slow columns under noise whose neighbours cancel or are alike, in two pieces."""
    rng = np.random.default_rng(8)
    phases = np.arange(n)[:, None, None] * [0.09, 0.17] + [[0.0, 1.0], [2.0, 0.5]]
    W = np.sin(phases)
    ones = np.ones((n, 2), bool)
    errors = []
    for _ in range(100):
        drawn = rng.normal(size=(n + 20, 2)) * [1.0, 3.0]
        noise = lfilter([1.0], [1.0, -neighbours], drawn, axis=0)[20:]
        tau = W @ [1.0, -2.0] + noise
        rows = RegressionRows(W, tau, ones, np.arange(n * 1.0), ones * 1.0, (0, n // 2), 1.0)
        found = fit(rows, [0, 1])
        errors.append((found.theta - [1.0, -2.0]) / np.sqrt(np.diag(found.cov)))
    assert 0.85 < np.std(errors) < 1.17
    assert 0.91 < (np.abs(errors) < 1.96).mean() < 0.985


def test_the_smallest_model_costs_least_of_all():
    """Among all subsets of 6 columns, of which two never stay."""
    rng = np.random.default_rng(7)
    for _ in range(12):
        root = rng.normal(size=(6, 6))
        cov = root @ root.T
        theta = rng.normal(size=6) * 6.0
        each = 4.0
        for forbidden in ((), (2,)):
            optional = [1, 2, 3, 4, 5]
            found = smallest(theta, cov, optional, each, forbidden)
            free = [k for k in optional if k not in forbidden]
            costs = {}
            for count in range(len(free) + 1):
                for kept in combinations(free, count):
                    out = [k for k in optional if k not in kept]
                    part = theta[out]
                    cost = part @ np.linalg.solve(cov[np.ix_(out, out)], part) if out else 0.0
                    costs[kept] = cost + each * count
            own = costs[tuple(found)]
            assert own <= sorted(costs.values())[1] * (1 + 1e-6)
            out = [k for k in optional if k not in found]
            assert left_out_cost(theta, cov, out) == pytest.approx(
                own - each * len(found), rel=1e-6
            )
    assert smallest(np.array([9.0, 0.1]), np.eye(2), [0, 1], 5.0) == [0]
    assert left_out_cost(theta, cov, []) == 0.0


def test_prices_and_the_spread_of_what_was_kept():
    assert price(100, 5) == pytest.approx(np.log(100) + 3 * np.log(5))
    assert price(0, 0) == pytest.approx(np.log(2))
    full = RegressionFit(
        np.array([1.0, 2.0, 3.0]),
        np.array([[4.0, 1.0, 0.5], [1.0, 9.0, 0.2], [0.5, 0.2, 1.0]]),
        np.zeros((0, 2)),
        np.ones(2),
        0.0,
        np.zeros(3),
    )
    last = RegressionFit(
        np.array([1.5, 12.0]), np.diag([1.0, 8.0]), np.zeros((0, 2)), np.ones(2), 0.0, np.zeros(2)
    )
    found = spread(full, [0, 1], last)
    # The first moved by 0.5, the second by 10.
    assert found[0, 0] == pytest.approx(1.0 + 0.25)
    assert found[1, 1] == pytest.approx(8.0 + 100.0)
    assert found[0, 1] / np.sqrt(found[0, 0] * found[1, 1]) == pytest.approx(1 / 6)


@pytest.mark.parametrize("neighbours", [-0.7, 0.5])
def test_what_noise_in_the_columns_takes_comes_back_and_counts_in_the_deviations(neighbours):
    """The noise of columns is of neighbours that cancel or are alike, and makes most of the torques'."""
    rng = np.random.default_rng(10)
    n, theta = 600, np.array([1.0, -2.0])
    phases = np.arange(n)[:, None, None] * [0.09, 0.1] + [[0.0, 1.0], [2.0, 0.5]]
    W = np.sin(phases)
    ones = np.ones((n, 2), bool)

    def drawn():
        white = rng.normal(size=(n + 20, 2, 2)) * 0.25
        return lfilter([1.0], [1.0, -neighbours], white, axis=0)[20:]

    errors, plain, bent = [], [], []
    for _ in range(60):
        tau = W @ theta + 0.1 * rng.normal(size=(n, 2))
        t = np.arange(n * 1.0)
        rows = RegressionRows(W + drawn(), tau, ones, t, ones * 1.0, (0,), 1.0, drawn())
        found = fit(rows, [0, 1])
        uncorrected = fit(replace(rows, change=None), [0, 1])
        errors.append((found.theta - theta) / np.sqrt(np.diag(found.cov)))
        plain.append((uncorrected.theta - theta) / np.sqrt(np.diag(uncorrected.cov)))
        bent.append(found.bias)
        moved = found.theta - uncorrected.theta
        assert np.abs(moved) / found.bias == pytest.approx(np.sqrt(np.diag(uncorrected.cov)))
        assert found.cov == pytest.approx(uncorrected.cov + np.outer(moved, moved))
        assert not uncorrected.bias.any()
    assert np.abs(np.mean(plain, axis=0)).min() > 1.0
    assert (np.abs(errors) < 1.96).mean() > 0.95
    assert np.abs(np.mean(errors, axis=0)).max() < 0.5 * np.abs(np.mean(plain, axis=0)).min()
    assert np.mean(bent, axis=0) == pytest.approx(np.abs(np.mean(plain, axis=0)), rel=0.4)
