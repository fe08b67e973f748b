"""What is known before a calibration, and how many unknowns poor data bear: by twins with a truth."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.estimation.calibration.measured_robot import LENGTHS
from tests.helpers.twins import HOME, LAB, measured, poses, robot_of, seen, twin

NAMES = (*LENGTHS, "offset1", "offset2")
GRID = np.stack(np.meshgrid(np.linspace(-0.03, 0.03, 7), np.linspace(0.06, 0.13, 7)), -1)


def by_ruler(rng, n, sd):
    """A twin, and n distances between its points, one after another, measured to sd, m."""
    true = twin(rng, LAB, NAMES)
    q, points, assembly, _ = seen(true, poses(true, n, rng, HOME, 0.4))
    to = (np.arange(n) + 1) % n
    distance = np.hypot(*(points - points[to]).T) + sd * rng.standard_normal(n)
    return true, {
        "q1": q[:, 0],
        "q2": q[:, 1],
        "assembly": assembly,
        "distance": distance,
        "to": to + 1,
    }


def tip_error(true, found):
    """RMS distance, m, from where the calibrated robot is told to go to where the true one goes."""
    pose = fb.igm(found.robot, GRID, unreachable="nan")
    readings = found.machine.readings(np.nan_to_num(pose.q))
    angles = readings + (true["offset1"], true["offset2"])
    missed = fb.dgm(robot_of(true), angles, unreachable="nan").xi - pose.xi
    return np.sqrt(np.nanmean((missed**2).sum(axis=-1)))


def test_chi2_is_of_the_residuals_and_of_what_was_known():
    """Each prior adds the square of how far its unknown has moved, over its deviation."""
    _, data = by_ruler(np.random.default_rng(5), 8, 4e-4)
    names, priors = ("l11", "d", "offset1"), {"l11": 3e-4, "offset1": 0.01}
    found = fb.calibrate(LAB, data, names, sigma=4e-4, priors=priors, mistakes="keep")
    moved = {"l11": found.values["l11"] - LAB.l11, "offset1": found.values["offset1"]}
    known = sum((moved[name] / sd) ** 2 for name, sd in priors.items())
    q = np.stack([data["q1"] + found.values["offset1"], data["q2"]], axis=1)
    points = fb.dgm(found.robot, q, data["assembly"]).xi
    off = data["distance"] - np.hypot(*(points - points[data["to"] - 1]).T)
    assert found.chi2 == pytest.approx(np.sum((off / 4e-4) ** 2) + known, rel=1e-6) and known > 0.1
    assert found.dof == len(off) + len(priors) - len(names)


@pytest.mark.deep
def test_advised_priors_predict_better_on_ruler_data():
    rng = np.random.default_rng(1)
    errors = []
    for _ in range(40):
        true, data = by_ruler(rng, 8, 4e-4)
        options = {"sigma": 4e-4, "mistakes": "keep"}
        full = fb.calibrate(LAB, data, NAMES, **options)
        advised = full.advised_priors
        chosen = fb.calibrate(LAB, data, NAMES, priors=advised, **options) if advised else full
        known = fb.calibrate(LAB, data, NAMES, priors=dict.fromkeys(LENGTHS, 3e-4), **options)
        errors.append([tip_error(true, found) for found in (full, chosen, known)])
        if advised:
            assert tuple(advised) == LENGTHS and "more exactly with --prior l11=" in str(full)
    full, chosen, known = np.median(errors, axis=0)
    assert chosen < 0.5 * full and chosen == pytest.approx(known, rel=0.1)
    assert np.mean([e[1] <= e[0] for e in errors]) > 0.85


def test_no_priors_are_advised_about_what_these_rows_gave():
    """A first calibration's robot is no drawing: its rows would count twice."""
    rng = np.random.default_rng(1)
    advised = []
    for _ in range(8):
        _, data = by_ruler(rng, 8, 4e-4)
        options = {"sigma": 4e-4, "mistakes": "keep"}
        first = fb.calibrate(LAB, data, NAMES, **options)
        advised.append(first.advised_priors)
        start = {name: first.values[name] for name in NAMES if name not in LENGTHS}
        again = fb.calibrate(first.robot, data, NAMES, start=start, **options)
        assert again.advised_priors == {} and "workshop" not in str(again)
    assert any(advised)


def test_many_exact_points_bear_all_unknowns():
    rng = np.random.default_rng(2)
    for _ in range(20):
        data = measured(twin(rng, LAB, NAMES), 40, rng, 1e-5)
        found = fb.calibrate(LAB, data, NAMES, sigma=1e-5)
        assert found.advised_priors == {} and "workshop" not in str(found)


@pytest.mark.deep
def test_intervals_with_priors_hold_the_truth():
    """Truths are drawn from the prior: 95 % of the intervals hold them, and are narrower."""
    rng = np.random.default_rng(3)
    sd = {"l11": 2e-4, "l12": 2e-4, "offset1": 5e-3, "d": 1e-4}
    held, width = 0, []
    for _ in range(150):
        true = twin(rng, LAB, ())
        for name, spread in sd.items():
            true[name] += spread * rng.standard_normal()
        data = measured(true, 6, rng, 2e-4, HOME)
        known = fb.calibrate(LAB, data, tuple(sd), sigma=2e-4, priors=sd, mistakes="keep")
        alone = fb.calibrate(LAB, data, tuple(sd), sigma=2e-4, mistakes="keep")
        intervals = known.intervals()
        held += sum(low <= true[name] <= high for name, (low, high) in intervals.items())
        width.append([np.mean([found.sd[name] for name in sd]) for found in (known, alone)])
    assert held / (150 * len(sd)) == pytest.approx(0.95, abs=0.03)
    assert np.mean(width, axis=0)[0] < 0.8 * np.mean(width, axis=0)[1]


def test_a_prior_is_one_more_measurement():
    """A length that is known as well as it is measured goes half of the way; the least squares of
    a linear problem by hand.
    """
    rng = np.random.default_rng(4)
    true = twin(rng, LAB, ("l11",), 0.01)
    data = measured(true, 5, rng, 1e-4, HOME)
    alone = fb.calibrate(LAB, data, ("l11",), sigma=1e-4)
    sd = alone.sd["l11"]
    known = fb.calibrate(LAB, data, ("l11",), sigma=1e-4, priors={"l11": sd})
    half = (LAB.l11 + alone.values["l11"]) / 2
    assert known.values["l11"] == pytest.approx(half, abs=1e-3 * sd)
    assert known.sd["l11"] == pytest.approx(sd / np.sqrt(2), rel=1e-3)
    assert known.dof == alone.dof + 1 and known.chi2 > alone.chi2


def test_a_calibration_with_priors_is_saved(tmp_path):
    rng = np.random.default_rng(5)
    data = measured(twin(rng, LAB, NAMES), 12, rng, 1e-4, HOME)
    found = fb.calibrate(LAB, data, NAMES, sigma=1e-4, priors={"l11": 3e-4, "offset2": 0.01})
    found.to_json(tmp_path / "c.json")
    again = fb.Calibration.from_json(tmp_path / "c.json")
    assert again.sd == found.sd and str(again) == str(found)
    assert "known before: l11 within 0.3 mm (sd)" in str(found)


@pytest.mark.parametrize(
    "priors, options, words",
    [
        ({"l11": 1e-4}, {}, "priors need sigma"),
        ({"x0": 1e-4}, {"sigma": 1e-4}, "priors: 'x0' is none of unknown"),
        ({"l11": -1.0}, {"sigma": 1e-4}, "priors\\['l11'\\] must be"),
        (3, {"sigma": 1e-4}, "priors must be a mapping"),
    ],
)
def test_what_is_no_prior(priors, options, words):
    data = measured(twin(np.random.default_rng(6), LAB, NAMES), 12, np.random.default_rng(6), 1e-4)
    with pytest.raises((ValueError, TypeError), match=words):
        fb.calibrate(LAB, data, NAMES, priors=priors, **options)


def test_priors_on_the_command_line(tmp_path, capsys):
    rng = np.random.default_rng(7)
    data = measured(twin(rng, LAB, NAMES), 12, rng, 1e-4, HOME)
    rows = zip(*data.values())
    lines = [",".join(data), *(",".join(map(repr, map(float, row))) for row in rows)]
    (tmp_path / "data.csv").write_text("\n".join(lines), "utf-8")
    words = ["calibrate", str(tmp_path / "data.csv"), "--sigma", "1e-4"]
    assert main([*words, "--prior", "l11=0.3mm", "offset1=1deg", "l12=2e-4"]) == 0
    said = capsys.readouterr().out
    for part in ("l11 within 0.3 mm", "offset1 within 1 deg", "l12 within 0.2 mm"):
        assert part in said
    for wrong in ("l11", "l11=3furlongs", "l11=mm"):
        assert main([*words, "--prior", wrong]) == 2
    assert "--prior" in capsys.readouterr().err
