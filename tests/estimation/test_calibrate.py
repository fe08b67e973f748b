"""Calibration on synthetic twins: exact data give exact lengths, noise honest intervals, in every form of data."""

import os
import time
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import FRAME, LENGTHS, READING, UNKNOWNS
from tests.benchmarks.calibration import coverage
from tests.helpers.twins import LAB, MODES, NOMINAL, measured, poses, seen, twin

GEOMETRY = (*LENGTHS, "offset1", "offset2")
NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))


def off(found, true, names=None):
    return max(abs(found.values[name] - true[name]) for name in names or found.values)


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "nominal",
    [LAB, NOMINAL, fb.FiveBar(0.06, 0.1, 0.06, 0.1, 0.1), fb.FiveBar(0.2, 0.2, 0.2, 0.2, 0.1)],
)
@pytest.mark.parametrize(
    "unknown",
    [LENGTHS, GEOMETRY, (*GEOMETRY, "x0", "y0", "turn"), (*LENGTHS, *READING, *FRAME[:3])],
)
def test_exact_data_give_lengths_to_1e_12(nominal, unknown):
    rng = np.random.default_rng(len(unknown))
    true = twin(rng, nominal, unknown)
    found = fb.calibrate(nominal, measured(true, 40, rng), unknown)
    assert off(found, true, LENGTHS) < 1e-12 and off(found, true) < 1e-11
    assert found.indistinguishable == () and found.rank == len(unknown)
    assert isinstance(found.robot, fb.FiveBar) and found.robot.l11 == found.values["l11"]


def test_robots_with_both_motors_on_one_axis():
    rng, unknown = np.random.default_rng(5), (*LENGTHS[:4], "offset1", "offset2")
    nominal = fb.FiveBar(0.1, 0.2, 0.1, 0.2, 0.0)
    true = twin(rng, nominal, unknown)
    assert off(fb.calibrate(nominal, measured(true, 30, rng), unknown), true) < 1e-12
    # With the base distance unknown, which cannot be below 0, and with noise around it.
    found = fb.calibrate(nominal, measured(true, 30, rng, 1e-5), GEOMETRY)
    assert found.robot.d >= 0 and off(found, true) < 2e-3


@pytest.mark.parametrize("axis", ["x", "y"])
def test_one_coordinate_alone(axis):
    rng = np.random.default_rng(6)
    true = twin(rng, LAB, GEOMETRY)
    data = measured(true, 40, rng)
    del data[axis]
    found = fb.calibrate(LAB, data, GEOMETRY)
    assert off(found, true) < 1e-12 and found.rank == 7


@pytest.mark.parametrize("modes", [((1, -1),), MODES])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_modes_that_one_coordinate_tells_only_after_the_fit(axis, modes):
    """The start is off by 1 mm and a degree, so that the other mode is nearer in some rows."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        true = twin(rng, NOMINAL, GEOMETRY, spread=2.0)
        data = measured(true, 40, rng, 2e-5, modes)
        del data[axis]
        found = fb.calibrate(NOMINAL, data, sigma=2e-5)
        assert found.fits
        assert max(abs(found.values[name] - true[name]) / found.sd[name] for name in GEOMETRY) < 5


def test_missing_coordinates_here_and_there_and_useless_rows():
    rng = np.random.default_rng(7)
    true = twin(rng, LAB, GEOMETRY)
    data = measured(true, 30, rng)
    data["x"][[2, 5]], data["y"][[3, 5]], data["q1"][8] = np.nan, np.nan, np.nan
    found = fb.calibrate(LAB, data, GEOMETRY)
    assert off(found, true) < 1e-12
    assert found.notes == (
        "left out, without q1 or q2: row 9",
        "left out, without x, y or distance: row 6",
    )
    data["x"][7] = np.inf
    with pytest.raises(ValueError, match="row 8: x must be below 1e\\+60 in size, not inf"):
        fb.calibrate(LAB, data, GEOMETRY)


def test_distances_between_points_alone():
    """A ruler: no frame, no coordinates; the rows' numbers count from 1."""
    rng = np.random.default_rng(8)
    true = twin(rng, LAB, GEOMETRY)
    shown = poses(true, 30, rng)
    q, points, assembly, working = seen(true, shown)
    to = np.array([(k + 7) % 30 + 1 for k in range(30)])
    distance = np.hypot(*(points - points[to - 1]).T)
    data = dict(q1=q[:, 0], q2=q[:, 1], distance=distance, to=to, assembly=assembly)
    data["distance"][4] = np.nan
    found = fb.calibrate(LAB, data, GEOMETRY)
    assert off(found, true) < 1e-11
    assert found.notes == ("left out, distance without a number: row 5",)
    working_data = {key: column for key, column in data.items() if key != "assembly"}
    with pytest.raises(ValueError, match="all 30 rows: no mode is noted"):
        fb.calibrate(LAB, working_data, GEOMETRY)
    lost = fb.calibrate(LAB, data, (*GEOMETRY, "x0", "turn")).indistinguishable
    assert [sentence.split(":")[0] for sentence in lost] == ["x0 not at all", "turn not at all"]
    assert "points x, y in a measuring frame would tell" in lost[0]


@pytest.mark.parametrize(
    "change, noted, words",
    [
        (dict(q=np.degrees), "working", "does not close in the modes noted. Are q1, q2 in degrees"),
        (dict(q=np.degrees), "both", "no robot has the lengths that fit best.* in degrees or rad"),
        (dict(q=np.negative), "working", "row 1, .* swapped, or of the wrong sign"),
        (dict(distance=1e3), "working", "^row 6, row 13: both assembly modes have the"),
        (dict(distance=1e3), "both", "x, y or distance in mm"),
    ],
)
def test_mistakes_in_a_rulers_data_are_asked_about(change, noted, words):
    where = fb.measurement_poses(LAB, 14, working=[(-1, -1)])
    to = np.roll(np.arange(14), 5)
    distance = np.hypot(*(where.xi - where.xi[to]).T) * change.get("distance", 1.0)
    q = change.get("q", np.positive)(where.q)
    data = dict(q1=q[:, 0], q2=q[:, 1], distance=distance, to=to + 1)
    data |= dict(working1=where.working[:, 0], working2=where.working[:, 1])
    data |= dict(assembly=where.assembly) if noted == "both" else {}
    with pytest.raises(ValueError, match=words):
        fb.calibrate(LAB, data, sigma=2e-4)


def test_a_ruler_beside_a_frame_of_unknown_scale():
    """A camera knows no millimetres: points alone leave the scale open, one known distance tells it."""
    rng = np.random.default_rng(9)
    unknown = (*GEOMETRY, *FRAME)
    true = twin(rng, LAB, unknown)
    q, points, assembly, _ = seen(true, poses(true, 30, rng))
    data = dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])
    (sentence,) = fb.calibrate(LAB, data, unknown).indistinguishable
    assert sentence.startswith("l11, l12, l21, l22, d and scale only together: nothing measured")
    assert "a distance between two of its points by a ruler" in sentence
    distance, to = np.full(30, np.nan), np.full(30, np.nan)
    distance[4], to[4] = np.hypot(*(points[4] - points[20])) / true["scale"], 21
    found = fb.calibrate(LAB, data | dict(distance=distance, to=to), unknown)
    assert found.rank == len(unknown) and off(found, true) < 1e-11


def test_pixels_of_a_camera_are_metres_of_an_unknown_scale():
    """Nobody is accused of millimetres; the ratios of lengths are right, and with one length known all are."""
    rng = np.random.default_rng(22)
    unknown = ("l12", "l21", "l22", "d", "offset1", "offset2", *FRAME)
    true = twin(rng, LAB, unknown) | dict(x0=640.0, y0=480.0, turn=3.0, scale=5200.0)
    q, points, _, working = seen(true, poses(true, 20, rng))
    points = points + 0.3 * rng.standard_normal(points.shape)
    data = dict(
        q1=q[:, 0],
        q2=q[:, 1],
        x=points[:, 0],
        y=points[:, 1],
        working1=working[:, 0],
        working2=working[:, 1],
    )
    found = fb.calibrate(LAB, data, unknown, sigma=0.3)
    assert found.fits and found.notes == () and found.rank == len(unknown)
    assert all(abs(found.values[name] - true[name]) < 5 * found.sd[name] for name in unknown)


@pytest.mark.deep
def test_counts_of_an_encoder():
    rng = np.random.default_rng(10)
    true = twin(rng, LAB, GEOMETRY)
    data = measured(true, 30, rng)
    counts = {**data, "q1": data["q1"] * 4096 / (2 * np.pi), "q2": data["q2"] * 2000 / (2 * np.pi)}
    start = dict(ratio1=2 * np.pi / 4096, ratio2=2 * np.pi / 2000)
    assert off(fb.calibrate(LAB, counts, GEOMETRY, start=start), true) < 1e-12
    found = fb.calibrate(
        LAB, counts, (*GEOMETRY, "ratio1", "ratio2"), start={k: 1.01 * v for k, v in start.items()}
    )
    assert off(found, true | start) < 1e-11
    alone = fb.calibrate(LAB, counts, (*GEOMETRY, "ratio1", "ratio2"))  # usual encoders are tried
    assert off(alone, true | start) < 1e-11 and alone.notes == ()
    assert np.allclose(
        found.machine.angles([[4096.0, 2000.0]]),
        2 * np.pi + np.array([true["offset1"], true["offset2"]]),
    )
    assert np.allclose(
        found.machine.readings(found.machine.angles([[300.0, -70.0]])), [[300.0, -70.0]]
    )


def test_a_start_that_leads_nowhere_is_replaced():
    """A frame that lies anywhere."""
    rng = np.random.default_rng(11)
    unknown = (*GEOMETRY, "x0", "y0", "turn")
    true = twin(rng, LAB, unknown) | dict(x0=1.3, y0=-0.4, turn=2.0)
    found = fb.calibrate(LAB, measured(true, 30, rng), unknown)
    assert off(found, true) < 1e-11


@pytest.mark.deep
def test_a_start_whose_motors_have_their_zero_anywhere_is_replaced():
    rng = np.random.default_rng(11)
    unknown = (*GEOMETRY, "x0", "y0", "turn")
    true = twin(rng, LAB, unknown) | dict(x0=1.3, y0=-0.4, turn=2.0)
    true |= dict(offset1=1.9, offset2=-2.6)
    data = measured(true, 30, rng)
    found = fb.calibrate(LAB, data, unknown)
    assert off(found, true) < 1e-11
    points, q = np.column_stack([data["x"], data["y"]]), np.column_stack([data["q1"], data["q2"]])
    assert np.allclose(
        found.machine.frame(found.machine.frame.inverse(points)), points, rtol=0, atol=1e-13
    )
    working = fb.dgm(found.robot, found.machine.angles(q), found.assembly).working
    turned = (
        found.machine.angles(q)
        - fb.igm(found.robot, found.machine.frame.inverse(points), working).q
    )  # commanded for these points
    assert np.abs(np.sin(turned / 2)).max() < 1e-10


@pytest.mark.deep
def test_noise_is_known_by_its_intervals():
    """Some of 10^4 sets, or all of them: `python -m tests.benchmarks.calibration`."""
    rng = np.random.default_rng(12)
    sets = 10_000 if NIGHTLY else 60
    for given in (True, False):
        inside, beyond = coverage(sets, rng, given)
        spread = 0.01 if NIGHTLY else 0.04  # unknowns of a set go together: fewer sets scatter more
        assert abs(inside - 0.95) < spread
        # Student's t of 31 degrees of freedom leaves 0.53 % beyond 3 sd, the normal distribution 0.27 %.
        assert abs(beyond - (0.0027 if given else 0.0053)) < (0.001 if NIGHTLY else 0.01)


def test_fifty_poses_and_nine_unknowns_take_no_noticeable_time():
    rng = np.random.default_rng(13)
    unknown = (*GEOMETRY, "x0", "y0")
    data = measured(twin(rng, LAB, unknown), 50, rng, 1e-4)
    spent = []
    for _ in range(6):
        began = time.process_time()
        assert max(fb.calibrate(LAB, data, unknown, sigma=1e-4).sd.values()) < 1e-3
        spent.append(time.process_time() - began)
    assert min(spent) < 0.2  # s of the processor: it is 0.03 to 0.05


def test_what_the_fit_says_of_itself():
    rng = np.random.default_rng(14)
    true = twin(rng, LAB, GEOMETRY)
    data = measured(true, 40, rng, 1e-4)
    found = fb.calibrate(LAB, data, GEOMETRY, sigma=1e-4)
    assert found.fits and found.dof == 73 and 40 < found.chi2 < 120 and found.outliers == {}
    assert found.rms_before > 3e-4 > found.rms
    assert np.allclose(np.diag(found.correlation), 1) and np.abs(found.correlation).max() < 1 + 1e-9
    assert repr(found).startswith("<Calibration: 7 unknowns, 40 rows, RMS ") and "\n" not in repr(
        found
    )
    assert "the model fits to the sigma given" in str(
        found
    ) and "all unknowns are told apart" in str(found)
    assert fb.calibrate(LAB, data, GEOMETRY, sigma=1e-5).fits is False
    assert "THE MODEL DOES NOT FIT" in str(fb.calibrate(LAB, data, GEOMETRY, sigma=1e-5))
    doubtful = replace(found, weight=found.weight * np.sqrt(stats.chi2.isf(5e-3, 73) / found.chi2))
    assert doubtful.p_value == pytest.approx(5e-3) and doubtful.fits
    assert "x sigma, more than by chance: are readings rounded to counts" in str(doubtful)
    rough = str(fb.calibrate(LAB, data, GEOMETRY, sigma=4e-3))
    assert "THE MISSES ARE ONLY 0.02 x sigma. Is sigma in m" in rough


@pytest.mark.deep
def test_standard_deviations_are_those_of_repeated_measurements():
    """Against the scatter of 400 calibrations, with sigma of each row its own."""
    rng = np.random.default_rng(15)
    true = twin(rng, LAB, LENGTHS)
    clean = measured(true, 15, rng)
    sigma = np.where(np.arange(15) % 2, 5e-5, 2e-4)
    values = []
    for _ in range(250):
        data = (
            clean
            | {axis: clean[axis] + sigma * rng.standard_normal(15) for axis in "xy"}
            | dict(sigma=sigma)
        )
        found = fb.calibrate(LAB, data, LENGTHS, mistakes="keep")
        values.append(list(found.values.values()))
    assert np.std(values, axis=0) == pytest.approx(list(found.sd.values()), rel=0.2)
    assert np.corrcoef(np.array(values).T) == pytest.approx(found.correlation, abs=0.2)
    assert found.absolute and found.p_value is not None


def test_intervals_of_one_degree_of_freedom_are_students_and_of_none_infinite():
    rng = np.random.default_rng(23)
    data = measured(twin(rng, LAB, LENGTHS), 3, rng, 1e-4)
    found = fb.calibrate(LAB, data, LENGTHS)
    assert found.dof == 1
    for name, interval in found.intervals(0.9).items():
        expected = stats.t(1, found.values[name], found.sd[name]).interval(0.9)
        assert interval == pytest.approx(expected, abs=1e-9)
    data["x"][1] = np.nan
    found = fb.calibrate(LAB, data, LENGTHS)
    assert found.dof == 0
    assert set(found.intervals().values()) == {(-np.inf, np.inf)}


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_motors_on_one_axis_are_no_less_than_0_apart(seed):
    """By noise, half of such robots have their least squares at a base distance below 0."""
    nominal = fb.FiveBar(0.1, 0.2, 0.1, 0.2, 0.0)
    rng = np.random.default_rng(seed)
    data = measured(twin(rng, nominal, (*LENGTHS[:4], "offset1", "offset2")), 12, rng, 1e-5)
    found = fb.calibrate(nominal, data, GEOMETRY, mistakes="keep")
    assert (found.robot.d == 0.0) == ("d fits best below 0" in str(found)) == (seed != 3)
    if seed != 3:
        known = fb.calibrate(nominal, data, found.unknown, mistakes="keep")
        assert found.unknown == tuple(name for name in GEOMETRY if name != "d")
        assert off(found, known.values, found.unknown) < 1e-10
        assert found.sd == pytest.approx(known.sd, rel=1e-6)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_robust_losses_pass_over_wrong_rows(loss):
    rng = np.random.default_rng(18)
    true = twin(rng, LAB, LENGTHS)
    data = measured(true, 30, rng, 2e-5)
    data["x"][[3, 11, 20]] += (2e-3, -3e-3, 1e-3)
    plain, robust = (fb.calibrate(LAB, data, LENGTHS, loss=each) for each in ("linear", loss))
    assert off(robust, true) < min(8e-5, 0.3 * off(plain, true))
    assert all(abs(robust.values[n] - true[n]) < 5 * robust.sd[n] for n in LENGTHS)
    assert list(plain.outliers) == ["row 12", "row 4", "row 21"] or set(plain.outliers) == {
        "row 4",
        "row 12",
        "row 21",
    }


def test_all_but_the_scale_are_told_of_joint_c():
    rng = np.random.default_rng(21)
    found = fb.calibrate(LAB, measured(twin(rng, LAB), 40, rng, 1e-5), UNKNOWNS[:13])
    lost = {name for name, sd in found.sd.items() if np.isinf(sd)}
    assert found.rank == 12 and lost == {*LENGTHS, "scale"} and not np.isnan(found.covariance).any()


def test_lengths_that_no_robot_has_are_refused():
    """Mirrored points, which nobody asks about, fit a bar of less than no length best."""
    rng = np.random.default_rng(4)
    data = measured(twin(rng, LAB, LENGTHS), 8, rng, 1e-5)
    data["y"] = -data["y"]
    with pytest.raises(ValueError, match=r"no robot has the lengths that fit best, .*l11 = -74"):
        fb.calibrate(LAB, data, GEOMETRY, mistakes="keep")
