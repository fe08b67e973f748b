"""Pieces of calibration and identification by themselves, against sums written out, trials of all, and changed units."""

import re
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.indistinguishable import combination
from fivebar.estimation.calibration.poses import _exchanged, _modes
from fivebar.estimation.calibration.report import _table
from fivebar.estimation.identification.filtering import RegressionRows
from fivebar.estimation.identification.regression import fit
from tests.helpers.twins import LAB, measured, twin


@pytest.mark.parametrize("seed", range(8))
def test_exchanged_poses_are_about_the_best_of_all(seed):
    """4 of 12 candidates with two rows each: at least 0.9 of the determinant of the best of 495."""
    jacobian = np.random.default_rng(seed).normal(size=(12, 2, 3))

    def det(chosen):
        return np.linalg.det(sum(jacobian[k].T @ jacobian[k] for k in chosen))

    chosen = _exchanged(jacobian, 4)
    assert len(set(chosen)) == 4
    assert det(chosen) > 0.9 * max(map(det, combinations(range(12), 4)))


def rows_of(scale=1.0, seed=1):
    """Two motors, the second in other units, with noise that lasts for some rows."""
    rng = np.random.default_rng(seed)
    n = 400
    W = rng.normal(size=(n, 2, 3))
    noise = np.apply_along_axis(
        np.convolve, 0, rng.normal(size=(n, 2)) * (0.1, 0.4), np.ones(6), "same"
    )
    tau = W @ (1.0, -2.0, 0.5) + noise * (1 + np.abs(W[:, :, 0]))
    factors = np.array([1.0, scale])
    return RegressionRows(
        W * factors[:, None],
        tau * factors,
        np.ones((n, 2), bool),
        np.arange(n) * 0.01,
        np.ones((n, 2)),
        (0,),
        1.0,
    )


def test_a_regression_does_not_depend_on_the_units_of_a_motor():
    one, other = fit(rows_of(), [0, 1, 2]), fit(rows_of(1000.0), [0, 1, 2])
    assert other.theta == pytest.approx(one.theta, rel=1e-9)
    assert other.cov == pytest.approx(one.cov, rel=1e-9, abs=1e-15)
    assert other.sigma == pytest.approx(one.sigma * (1, 1000))


def test_deviations_of_a_regression_are_those_of_many():
    """Of noise that is neither white nor of one size: within a third, and not too small on the whole."""
    found = [fit(rows_of(seed=seed), [0, 1, 2]) for seed in range(60)]
    spread = np.std([each.theta for each in found], axis=0)
    said = np.mean([np.sqrt(np.diag(each.cov)) for each in found], axis=0)
    assert (said > 0.7 * spread).all() and (said < 1.5 * spread).all()


def test_a_report_says_by_how_much_the_noise_is_larger_than_told():
    rng = np.random.default_rng(2)
    unknown = ("l11", "l12", "l21", "l22", "d")
    data = measured(twin(rng, LAB, unknown), 40, rng, 5e-5)
    report = str(fb.calibrate(LAB, data, unknown, sigma=1e-5))
    times = float(re.search("the misses are (.*) x sigma", report)[1])
    assert times == pytest.approx(5.0, rel=0.3)


def test_measurement_poses_say_how_many_modes_they_have():
    poses = fb.measurement_poses(LAB, n=12)
    modes = {
        (*working, assembly)
        for working, assembly in zip(poses.working.tolist(), poses.assembly.tolist())
    }
    worst = f"tip within {poses.worst_tip:.3g} sigma"
    assert repr(poses) == f"<MeasurementPoses: 12 poses, {len(modes)} modes, {worst}>"


@pytest.mark.parametrize("size", 10.0 ** np.arange(-13, 3))
def test_a_report_shows_two_digits_of_what_is_uncertain_and_nine_decimals_at_most(size):
    sd = 2.345 * size / 1000  # m; it is shown in millimetres
    found = SimpleNamespace(
        values={"l11": 0.09},
        sd={"l11": sd},
        told=np.array([True]),
        start=np.full(16, 0.08),
        intervals=lambda: {"l11": (0.09 - 2 * sd, 0.09 + 2 * sd)},
    )
    cells = list(_table(found))[1].split()
    assert cells[:2] == ["l11", "mm"] and len(cells) == 7
    decimals = {len(cell.partition(".")[2]) for cell in cells[2:]}
    assert len(decimals) == 1 and max(decimals) <= 9
    assert float(cells[4]) == pytest.approx(2.345 * size, rel=0.05, abs=6e-10)


@pytest.mark.parametrize("pairs", [[], [(1, 0)], [(1, 1), (2, -1)], [(1, -1), (1, 1, 1)], (1,)])
def test_modes_to_measure_in_are_pairs_of_signs(pairs):
    with pytest.raises((ValueError, TypeError), match="working"):
        _modes(pairs)
    assert _modes((1, -1)) == [(1, -1)] and _modes([(1, -1), (1, 1), (1, -1)]) == [(1, -1), (1, 1)]


@pytest.mark.parametrize("rank, words", [(5, ""), (3, ", 2 not told")])
def test_a_calibration_says_in_one_line_what_it_left(rank, words):
    found = SimpleNamespace(
        unknown=range(5), rank=rank, rows=range(40), rms_before=2e-3, rms=1e-5, fits=True
    )
    line = f"<Calibration: 5 unknowns, 40 rows, RMS 2 -> 0.01 mm{words}>"
    assert fb.Calibration.__repr__(found) == line


@pytest.mark.parametrize(
    "share, words",
    [
        (1.0, "grows by 1 mm"),
        (-1.0, "falls by 1 mm"),
        (0.5, "grows by 0.5 mm"),
        (-0.25, "falls by 0.25 mm"),
    ],
)
def test_what_two_lengths_leave_untold(share, words):
    told = combination(np.array([0.5, 0.5 * share]), ("l11", "l12"), np.ones(2))
    together = "l11 and l12 only together: nothing measured changes if l11 grows by 1 mm and l12"
    assert told == f"{together} {words}"
