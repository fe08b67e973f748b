"""Backlash: found by the direction of approach, and as a tolerance of the tip."""

import math

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.backlash import backlashes

DRAWN = fb.FiveBar()
BUILT = fb.FiveBar(l11=0.0905, l22=0.0897, d=0.1185)
UNKNOWN = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")


def measured(backlash, sigma, seed, rows=60):
    """Points that a robot with backlash reaches, visited in a random order."""
    rng = np.random.default_rng(seed)
    poses = fb.measurement_poses(DRAWN, rows)
    order = rng.permutation(rows)
    q = poses.q[order]
    came = np.sign(np.diff(q, axis=0, prepend=q[:1]))
    true = q - came * np.array(backlash) / 2
    pose = fb.dgm(BUILT, true, np.asarray(poses.assembly)[order])
    xi = pose.xi + sigma * rng.standard_normal((rows, 2))
    return dict(q1=q[:, 0], q2=q[:, 1], x=xi[:, 0], y=xi[:, 1])


@pytest.mark.every(2)
@pytest.mark.parametrize("seed", range(3))
def test_a_calibration_names_the_motor_with_backlash(seed):
    backlash = math.radians(0.3)
    found = fb.calibrate(DRAWN, measured((0.0, backlash), 2e-5, seed), UNKNOWN)
    words = [note for note in found.notes if "approach" in note]
    sentence = "the residuals depend on the direction of approach: about {} of backlash in motor 2"
    assert len(words) == 1 and words[0] in [sentence.format(f"{b}°") for b in (0.29, 0.3, 0.31)]
    assert words[0] in str(found)


@pytest.mark.deep
def test_the_value_is_within_its_interval():
    truth = np.radians([0.05, 0.2])
    off = []
    for seed in range(8):
        data = measured(truth, 2e-5, seed + 10)
        found = fb.calibrate(DRAWN, data, UNKNOWN, sigma=2e-5)
        values, sd = backlashes(found)
        off += list((values - truth) / sd)
    assert np.abs(off).max() < 4 and 0.4 < np.sqrt(np.mean(np.square(off))) < 1.7


@pytest.mark.every(3)
@pytest.mark.parametrize("seed", range(4))
def test_none_is_named_without_backlash(seed):
    found = fb.calibrate(DRAWN, measured((0.0, 0.0), 2e-5, seed), UNKNOWN)
    assert not any("approach" in note for note in found.notes)


@pytest.mark.parametrize("loss", ["linear", "huber"])
@pytest.mark.parametrize("seed", range(3))
def test_rows_that_are_wrong_are_no_backlash(seed, loss):
    data = measured((0.0, 0.0), 5e-5, seed, rows=40)
    data["x"][5] += 3e-3
    data["y"][17] -= 5e-3
    found = fb.calibrate(DRAWN, data, UNKNOWN, sigma=5e-5, loss=loss)
    assert not any("approach" in note for note in found.notes)


def test_backlashes_need_six_numbers_beyond_the_unknowns():
    data = measured((0.0, 0.01), 2e-5, 3, rows=7)
    assert backlashes(fb.calibrate(DRAWN, data, UNKNOWN)) is not None
    data["x"][3] = np.nan
    assert backlashes(fb.calibrate(DRAWN, data, UNKNOWN)) is not None
    data["y"][5] = np.nan
    assert backlashes(fb.calibrate(DRAWN, data, UNKNOWN)) is None


def test_backlash_is_a_tolerance_of_the_tip():
    point = (0.0, 0.1)
    play = math.radians(0.2)
    found = fb.tip_error(DRAWN, {"backlash1": play, "backlash2": play}, point)
    J = fb.igm(DRAWN, point).J
    ends = [np.linalg.norm(J @ (play / 2 * np.array(s))) for s in ((1, 1), (1, -1))]
    assert found.worst[0] == pytest.approx(max(ends), rel=1e-4)
    assert found.sd[0] == pytest.approx(np.sqrt(np.mean(np.square(ends))), rel=1e-12)
    drawn = np.linalg.norm(found.drawn[0], axis=1)
    assert drawn.max() == pytest.approx(max(ends), rel=2e-3)
    assert drawn.min() == pytest.approx(min(ends), rel=2e-3)
    with pytest.raises(ValueError, match="no 'backlash3'"):
        fb.tip_error(DRAWN, {"backlash3": play}, point)
