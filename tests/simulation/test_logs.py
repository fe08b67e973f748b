"""Logs as runs: units, gears, gaps, restarts and jumps; derivatives without phase; what a run does with its gaps."""

import io

import numpy as np
import pytest

import fivebar as fb
from fivebar.simulation.derivatives import DEGREE, FIDELITY, derivatives, half_window, kernels, spectrum

ROBOT = fb.FiveBar()
RUN = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 400.0, 40.0), fb.line((0.09, 0.068), (0.0, 0.1), 1.0), step=2e-3)
COLUMNS = {"t": RUN.t, "q": RUN.q, "tau": RUN.tau}


def rows_of(run):
    return np.isfinite(run.q).all(axis=1)


@pytest.mark.parametrize("cutoff", [0.002, 0.01, 0.05, 1 / 12])
def test_derivatives_have_no_phase_and_the_documented_error(cutoff):
    rows = kernels(cutoff)
    n = len(rows[0]) // 2
    k = np.arange(-n, n + 1)
    for order, weights in enumerate(rows):
        sign = (-1) ** order
        np.testing.assert_allclose(weights[::-1], sign * weights, atol=1e-12 * np.abs(weights).max())  # no phase
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
    q = np.stack([np.sin(2 * np.pi * 1.3 * t) + 0.3 * np.cos(2 * np.pi * 5 * t), np.cos(2 * np.pi * 2 * t)], axis=1)
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
        * np.array([1.3 * np.cos(2 * np.pi * 1.3 * t) - 1.5 * np.sin(2 * np.pi * 5 * t), -2 * np.sin(4 * np.pi * t)])
    )
    np.testing.assert_allclose(again[1][n:-n], exact.T[n:-n], atol=1e-4)
    np.testing.assert_allclose(again[1], exact.T, atol=2e-2)  # at the ends too, less exactly


@pytest.mark.parametrize(
    "made",
    [
        lambda: fb.Run.from_log(RUN.t, *RUN.q.T, *RUN.tau.T),
        lambda: fb.Run.from_log(COLUMNS, robot=ROBOT),
        lambda: fb.Run.from_log(
            {"t": 1e3 * RUN.t, "q": np.degrees(RUN.q), "tau": RUN.tau}, units={"t": "ms", "q1": "deg", "q2": "deg"}
        ),
        lambda: fb.Run.from_log(
            RUN.t, *((RUN.q - [0.1, 0.2]) * [-50, 50] * 4096 / (2 * np.pi)).T, *(RUN.tau / [-50, 50] / 0.062).T,
            counts_per_turn=4096, gear_ratio=(-50, 50), offset=(0.1, 0.2), torque_constant=0.062,
        ),
        lambda: fb.Run.from_log(csv_of("time (ms);theta1 [deg];theta2 [deg];torque1 (mNm);torque2 (mNm)")),
    ],
    ids=["arrays", "mapping", "units", "counts", "csv"],
)  # fmt: skip
def test_the_same_run_from_logs_in_all_forms(made):
    run = made()
    np.testing.assert_allclose(run.q, RUN.q, atol=1e-12)
    np.testing.assert_allclose(run.tau, RUN.tau, atol=1e-12)
    np.testing.assert_allclose(run.xi, RUN.xi, atol=1e-12)
    np.testing.assert_allclose(run.q_dot, RUN.q_dot, atol=2e-3)
    np.testing.assert_allclose(run.energy, RUN.energy, atol=1e-4)
    assert run.measured is not None and RUN.measured is None


def csv_of(header):
    rows = np.column_stack([1e3 * RUN.t, np.degrees(RUN.q), 1e3 * RUN.tau])
    return io.StringIO(header + "\n" + "\n".join(";".join(repr(float(v)) for v in row) for row in rows))


def test_gaps_and_restarts_are_marked_and_bridged_by_nothing(tmp_path):
    keep = np.r_[0:200, 240 : len(RUN.t)]
    t = RUN.t[keep].copy()
    t[350:] -= t[350]
    q = RUN.q[keep].copy()
    q[50] = np.nan
    run = fb.Run.from_log(t, *q.T, *RUN.tau[keep].T)
    assert [why.split(" at ")[0].split(" before")[0] for _, _, why in run.measured.gaps] == [
        "1 row missing", "40 rows missing", "time jumps back from 0.778 to 0 s"]  # fmt: skip
    assert (~rows_of(run)).sum() == 3 and (np.diff(run.t) > 0).all()
    assert any("taken for a restart" in sentence for sentence in run.measured.said)
    run.to_csv(tmp_path / "a.csv")
    again = fb.Run.from_csv(tmp_path / "a.csv")
    assert again.measured == run.measured
    np.testing.assert_array_equal(again.q, run.q)
    run.plot(tmp_path / "a.png")
    run.page(tmp_path / "a.html")
    run.animate(tmp_path / "b.html")
    assert all((tmp_path / name).stat().st_size > 10_000 for name in ("a.png", "a.html", "b.html"))
    assert "Run: five-bar robot" in repr(run) and np.isfinite(run.energy_error[rows_of(run)][:50]).all()


def test_a_log_with_its_reference_and_end_effector():
    log = {**COLUMNS, "xi": RUN.xi, "xi_ref": RUN.xi_ref}
    run = fb.Run.from_log(log)
    np.testing.assert_allclose(run.error, RUN.error, atol=1e-15)
    other = fb.dgm(ROBOT, RUN.q, 1, unreachable="nan").xi
    assert np.allclose(fb.Run.from_log({**COLUMNS, "xi": other}).xi, other)  # the mode that fits
    said = fb.Run.from_log({**COLUMNS, "xi": RUN.xi + 0.03}).measured.said
    assert any("mm (median) from where the joints say" in sentence for sentence in said)


@pytest.mark.parametrize(
    ("log", "words"),
    [
        ({"t": RUN.t, "q1": RUN.q[:, 0]}, "q1, but no q2|no q2"),
        ({"q": RUN.q}, "the log has no t"),
        ({"t": RUN.t[:1], "q": RUN.q[:1]}, "1 rows: a motion needs more"),
        ({"t": RUN.t, "q": RUN.q, "colour": RUN.t}, "no column 'colour'"),
        ({"t": RUN.t, "q": np.full_like(RUN.q, np.nan)}, "0 rows with a time and both joints"),
        ({"t": 0 * RUN.t, "q": RUN.q}, "rows with a time|never increase"),
    ],
)
def test_what_is_no_log_is_refused(log, words):
    with pytest.raises(ValueError, match=words):
        fb.Run.from_log(log)
