"""Derivatives of sampled motions without phase, and the spectrum that says where the motion ends in its noise."""

from types import SimpleNamespace

import numpy as np
import pytest

from fivebar.estimation.logs import measured_runs
from fivebar.estimation.logs.derivatives import (
    DEGREE,
    FIDELITY,
    Spectrum,
    derivatives,
    half_window,
    kernels,
    spectrum,
)


@pytest.mark.parametrize("cutoff", [0.002, 0.01, 0.05, 1 / 12])
def test_derivatives_have_no_phase_and_the_documented_error(cutoff):
    rows = kernels(cutoff)
    n = len(rows[0]) // 2
    k = np.arange(-n, n + 1)
    for order, weights in enumerate(rows):
        sign = (-1) ** order
        np.testing.assert_allclose(
            weights[::-1], sign * weights, atol=1e-12 * np.abs(weights).max()
        )  # no phase
        for share in (0.25, 0.5, 1.0):
            omega = 2 * np.pi * cutoff * share
            gain = (weights @ np.exp(1j * omega * k)) / (1j * omega) ** order
            assert abs(gain - 1) <= FIDELITY * share**5
        for degree in range(DEGREE + 1):  # polynomials come out exactly
            exact = [0.0, 0.0, 0.0]
            exact[min(degree, 2)] = (1.0, 1.0, 2.0)[degree] if degree < 3 else 0.0
            assert weights @ (k / n) ** float(degree) * n**order == pytest.approx(
                exact[order] if degree < 3 else 0, abs=1e-9
            )


def test_the_cut_off_is_where_the_motion_ends_in_its_noise():
    rng, t = np.random.default_rng(0), np.arange(0, 20, 1e-3)
    q = np.stack(
        [np.sin(2 * np.pi * 1.3 * t) + 0.3 * np.cos(2 * np.pi * 5 * t), np.cos(2 * np.pi * 2 * t)],
        axis=1,
    )
    for noise in (1e-6, 1e-5, 1e-4):
        found = spectrum([q + noise * rng.normal(size=q.shape)], 1e-3)
        assert 5 < found.cutoff < 25
        np.testing.assert_allclose(found.noise, noise, rtol=0.1)
        assert found.fast < 0.02
    again = derivatives(q, 1e-3, 20.0, ends=True)
    n = half_window(20.0, 1e-3)
    exact = (
        2
        * np.pi
        * np.array(
            [
                1.3 * np.cos(2 * np.pi * 1.3 * t) - 1.5 * np.sin(2 * np.pi * 5 * t),
                -2 * np.sin(4 * np.pi * t),
            ]
        )
    )
    np.testing.assert_allclose(again[1][n:-n], exact.T[n:-n], atol=1e-4)
    np.testing.assert_allclose(again[1], exact.T, atol=2e-2)  # at the ends too, less exactly
    for rows in (3, 2 * n):  # of less than one window nothing is told
        assert all(np.isnan(each).all() for each in derivatives(q[:rows], 1e-3, 20.0, ends=True))
    whole = derivatives(q[: 2 * n + 1], 1e-3, 20.0)
    assert np.isfinite(whole[0][n]).all() and np.isnan(whole[0]).sum() == 4 * n


def test_the_spectrum_of_pieces():
    rng, rate = np.random.default_rng(2), 1000.0
    assert spectrum([np.zeros((17, 2))], 1 / rate) == Spectrum(rate / 12, (0.0, 0.0), 0.0)
    still = spectrum([np.zeros((4000, 2)), np.zeros((2000, 2))], 1 / rate)
    assert (
        still.noise == (0.0, 0.0) and still.fast == 0.0 and 0 < still.cutoff < 10
    )  # the lowest that it can tell
    assert (
        spectrum([np.zeros((4000, 2))], 2 / rate).cutoff == still.cutoff / 2
    )  # of rows half as often
    t = np.arange(12_000) / rate
    wave = np.stack([np.sin(6 * np.pi * t), np.cos(4 * np.pi * t)], axis=1)
    # Pieces count by their rows: noise of variances 1 and 9 over a third and two thirds of them.
    sizes, pieces = (1e-5, 3e-5), (slice(0, 4000), slice(4000, 12_000))
    found = spectrum(
        [wave[p] + s * rng.normal(size=wave[p].shape) for s, p in zip(sizes, pieces)], 1 / rate
    )
    np.testing.assert_allclose(found.noise, 1e-5 * np.sqrt(1 / 3 + 9 * 2 / 3), rtol=0.05)
    assert found.fast == 0.0
    # Differenced twice, a wave of 200 Hz has (a (sin 0.2 pi)^2 / (sin 0.003 pi)^2)^2 times the power of one of 3 Hz.
    a = 0.5 * (np.sin(0.003 * np.pi) / np.sin(0.2 * np.pi)) ** 2
    fast = (
        wave
        + np.stack([a * np.sin(400 * np.pi * t), 0 * t], axis=1)
        + 1e-9 * rng.normal(size=wave.shape)
    )
    found = spectrum([fast, fast[:20]], 1 / rate)
    assert found.fast == pytest.approx(0.25 / 1.25, rel=0.02) and found.cutoff == pytest.approx(
        rate / 12
    )
    assert found.noise == pytest.approx((1e-9, 1e-9), rel=0.1)


def test_a_stretch_too_short_for_the_logs_own_window_has_a_narrower_one(monkeypatch):
    """A cut-off of 1 Hz asks for 63 rows: 20 are differentiated with a higher one, not by differences."""
    monkeypatch.setattr(measured_runs, "spectrum", lambda *_: SimpleNamespace(cutoff=1.0))
    t, swing = 0.01 * np.arange(20), 2 * np.pi * 0.4
    q = np.stack([0.3 * np.sin(swing * t), 0.2 * np.cos(swing * t)], axis=1)
    exact = swing * np.stack([0.3 * np.cos(swing * t), -0.2 * np.sin(swing * t)], axis=1)
    assert np.abs(np.gradient(q, 0.01, axis=0) - exact).max() > 1e-3
    log = SimpleNamespace(t=t, q=q, step=0.01, stretches=[slice(0, 20)])
    np.testing.assert_allclose(measured_runs.rates_of(log), exact, atol=1e-6)
