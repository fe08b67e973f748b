"""Poses to measure at, tip errors and repeatability, against other ways to the same numbers."""

import warnings

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.candidates import candidates
from fivebar.estimation.calibration.measured_robot import LENGTHS, UNKNOWNS, seen, sizes, values_of
from tests.benchmarks.calibration import GRID, against_quadratic
from tests.helpers.twins import HOME, LAB, MODES, NOMINAL

GEOMETRY = (*LENGTHS, "offset1", "offset2")
NINE = (*GEOMETRY, "x0", "y0")


def tip_gain(robot, q, assembly, unknown, working):
    """Return the largest standard deviation of the tip over the workspace, after poses q."""
    p, columns = values_of(robot), [UNKNOWNS.index(name) for name in unknown]
    over = candidates(robot, 0.3, working, None)
    size = sizes(robot, over.q, unknown)
    own, everywhere = (
        seen(p, readings, modes)[1][:, :, columns] * size
        for readings, modes in ((q, assembly), (over.q, over.assembly))
    )
    information = np.einsum("nij,nik->jk", own, own)
    if np.linalg.cond(information) > 1e20:
        return np.inf
    spread = np.einsum("nij,jk,nik->n", everywhere, np.linalg.inv(information), everywhere)
    return np.sqrt(spread.max())


@pytest.mark.parametrize(
    "robot, unknown",
    [
        (LAB, GEOMETRY),
        pytest.param(LAB, NINE, marks=pytest.mark.deep),
        pytest.param(NOMINAL, NINE, marks=pytest.mark.deep),
    ],
)
def test_chosen_poses_tell_three_times_more_than_nine_of_a_grid(robot, unknown):
    chosen = fb.measurement_poses(robot, 9, unknown)
    box = candidates(
        robot, 0.3, HOME, None
    ).xi  # the grid is as large as the home mode's regular workspace lets it
    high = box[box[:, 1] > 0.02]
    sides = np.quantile(high, (0.15, 0.85), axis=0)
    wide = np.stack(np.meshgrid(*(np.linspace(*sides[:, k], 3) for k in (0, 1))), axis=-1).reshape(
        -1, 2
    )
    for grid in (GRID, wide):
        pose = fb.igm(robot, grid, (-1, -1), unreachable="nan")
        kept = np.isfinite(pose.q).all(axis=1)
        for modes in (MODES, HOME):  # the worst error anywhere, or in the home mode alone
            nine = tip_gain(robot, pose.q[kept], pose.assembly[kept], unknown, working=modes)
            assert nine >= 3 * tip_gain(robot, chosen.q, chosen.assembly, unknown, working=modes)


@pytest.mark.deep
def test_the_promised_tip_error_comes_true():
    """What the formula says of the worst tip, against the scatter of 150 calibrations at that place."""
    rng = np.random.default_rng(1)
    chosen, sigma = fb.measurement_poses(LAB, 9, GEOMETRY), 1e-5
    over = candidates(LAB, 0.3, MODES, None)
    values, off = [], []
    for _ in range(150):
        points = chosen.xi + sigma * rng.standard_normal(chosen.xi.shape)
        data = dict(
            q1=chosen.q[:, 0],
            q2=chosen.q[:, 1],
            x=points[:, 0],
            y=points[:, 1],
            assembly=chosen.assembly,
        )
        found = fb.calibrate(LAB, data, GEOMETRY, mistakes="keep")
        values.append(list(found.values.values()))
        off.append(found.predict(over.q, over.assembly) - over.xi)
    worst = np.sqrt(np.mean(np.sum(np.square(off), axis=2), axis=0)).max()
    assert worst == pytest.approx(chosen.worst_tip * sigma, rel=0.15)
    assert np.std(values, axis=0) == pytest.approx(list(chosen.sd(sigma).values()), rel=0.25)


def test_poses_keep_their_margin_their_modes_and_their_window():
    found = fb.measurement_poses(
        LAB, 8, GEOMETRY, margin=0.4, working=[(-1, -1), (1, 1)], window=(-0.1, 0.1, 0.03, 0.2)
    )
    sines = np.abs([*found.pose.sines, found.pose.det_A])
    assert sines.min() > 0.4 and set(map(tuple, found.working.tolist())) <= {(-1, -1), (1, 1)}
    assert np.abs(found.xi[:, 0]).max() <= 0.1 and found.xi[:, 1].min() >= 0.03
    assert len(np.unique(found.xi, axis=0)) == 8
    steps = (
        np.abs(np.diff(np.column_stack([found.working, found.assembly]), axis=0)).any(axis=1).sum()
    )
    kinds = len({(*w, a) for w, a in zip(found.working.tolist(), found.assembly.tolist())})
    assert steps == kinds - 1  # a mode is entered once
    assert "8 poses" in repr(found) and len(found.plot().axes) == 1


def test_a_list_of_poses_to_fill_in(tmp_path):
    found = fb.measurement_poses(LAB, 6, GEOMETRY, start={"offset1": 0.1})
    found.to_csv(tmp_path / "poses.csv")
    text = (tmp_path / "poses.csv").read_text("utf-8").splitlines()
    filled = [text[0]] + [
        ",".join([*(c := line.split(","))[:2], c[7], c[8], *c[4:]]) for line in text[1:]
    ]
    (tmp_path / "filled.csv").write_text("\n".join(filled), encoding="utf-8")
    calibrated = fb.calibrate(LAB, tmp_path / "filled.csv", GEOMETRY, start={"offset1": 0.1})
    assert calibrated.values == pytest.approx(
        {n: getattr(LAB, n, 0.0) for n in GEOMETRY} | {"offset1": 0.1}, abs=1e-11
    )


@pytest.mark.parametrize(
    "options, words",
    [
        (dict(n=3), "n = 3 poses give 6 numbers, fewer than the 7 unknowns"),
        (
            dict(unknown=(*GEOMETRY, "scale")),
            "unknown: no points x, y tell these apart: l11, l12, l21, l22, d and scale",
        ),
        (dict(margin=0.94, window=(0.0, 0.001, 0.0, 0.001)), "only 0 poses keep the margin 0.94"),
        (
            dict(margin=0.93, working=[(-1, -1)]),
            r"only 6 poses keep the margin 0.93 \(and are in the window\): a smaller margin\?",
        ),
        (dict(margin=0.0), "margin must be finite and from 0.01 to 0.95, not 0.0"),
        (dict(working=[(1, 2)]), "working must be"),
        (dict(window=(1, 0, 0, 1)), "window must be"),
    ],
)
def test_poses_that_cannot_be(options, words):
    with pytest.raises(ValueError, match=words):
        fb.measurement_poses(LAB, **dict(n=9, unknown=GEOMETRY) | options)


TOLERANCES = dict.fromkeys(LENGTHS, 1e-4) | dict(offset1=1e-3, offset2=1e-3)


def test_tip_error_by_jacobian_is_that_of_differences_and_of_monte_carlo():
    points = np.array([[0.02, 0.06], [0.0, 0.1], [-0.03, 0.14]])
    found = fb.tip_error(LAB, TOLERANCES, points, samples=40_000)
    assert found.monte_carlo_sd == pytest.approx(found.sd, rel=0.01)
    assert found.open.max() == 0
    total = np.zeros((3, 2, 2))
    pose = fb.igm(LAB, points)
    for name, size in TOLERANCES.items():
        up, down = (
            fb.dgm(
                fb.FiveBar(
                    **{n: getattr(LAB, n) + (s * 1e-6 if n == name else 0) for n in LENGTHS}
                ),
                pose.q + s * 1e-6 * np.array([name == "offset1", name == "offset2"]),
                pose.assembly,
            ).xi
            for s in (1, -1)
        )
        slope = size * (up - down) / 2e-6
        total += slope[:, :, None] * slope[:, None, :]
    assert found.covariance == pytest.approx(total, rel=1e-6)
    assert (found.worst >= found.sd).all() and repr(found).startswith("<TipError: 3 poses")


def test_worst_case_is_reached_by_a_corner_of_the_tolerances():
    sizes = dict(l11=1e-5, l22=2e-5, offset1=1e-4)
    found = fb.tip_error(LAB, sizes, (0.02, 0.1), samples=2000)
    corners = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T * found.tolerances
    assert found.worst[0] == pytest.approx(
        np.hypot(*(found.jacobian[0] @ corners.T)).max(), rel=1e-4
    )
    assert found.monte_carlo_sd == pytest.approx(found.sd, rel=0.05)


def test_near_type_2_the_tip_gets_away_and_robots_do_not_close(tmp_path):
    points = np.stack([np.zeros(4), [0.06, 0.1, 0.152, 0.1575]], axis=-1)
    found = fb.tip_error(
        LAB, TOLERANCES | dict.fromkeys(LENGTHS, 3e-4), points, working=(-1, 1), samples=5000
    )
    assert (found.monte_carlo_sd / found.sd)[:2] == pytest.approx([1, 1], abs=0.03)
    assert (
        found.sd[3] > 50 * found.sd[0] and found.radius[3] == np.inf
    )  # of more than 5 % there is no tip
    assert found.open[:2].max() == 0 and found.open[3] == pytest.approx(0.06, abs=0.02)
    assert len(found.plot(tmp_path / "tip.png").axes) == 2


@pytest.mark.parametrize(
    "change, error, words",
    [
        (dict(tolerances={}), ValueError, "tolerances is empty"),
        (dict(tolerances={"l13": 1.0}), ValueError, "tolerances: no 'l13'"),
        (
            dict(tolerances={"l11": -1.0}),
            ValueError,
            r"tolerances\['l11'\] must be finite and >= 0",
        ),
        (dict(tolerances=5), TypeError, "tolerances must be a mapping"),
        (dict(poses=(1.0, 1.0)), fb.UnreachableError, "unreachable"),
        (dict(samples=5), ValueError, "samples must be a whole number >= 10"),
    ],
)
def test_tip_errors_that_cannot_be(change, error, words):
    with pytest.raises(error, match=words):
        fb.tip_error(**dict(robot=LAB, tolerances=TOLERANCES, poses=(0.0, 0.1)) | change)


def test_repeatability_of_a_case_by_hand():
    """A triangle about (1, 1) mm: distances sqrt 2, sqrt 5, sqrt 5; ISO 9283: mean + 3 sd, with n - 1."""
    points = 1e-3 * np.array([[0, 0], [3, 0], [0, 3]])
    found = fb.repeatability(points, commanded=(0.001, 0.004))
    distances = np.sqrt([2, 5, 5])
    mean = distances.sum() / 3
    sd = np.sqrt(((distances - mean) ** 2).sum() / 2)
    assert found.barycentre[0] == pytest.approx([1e-3, 1e-3]) and found.distances[
        0
    ] == pytest.approx(1e-3 * distances)
    assert found.RP[0] == pytest.approx(1e-3 * (mean + 3 * sd)) == pytest.approx(3.38561011e-3)
    assert found.AP[0] == pytest.approx(3e-3)
    assert "worst RP 3.3856 mm" in str(
        found
    ) and "3 cycles at a pose, where the standard asks for 30" in str(found)
    heading, row, *_ = str(found).splitlines()
    assert row.split() == ["1", "1.0000", "1.0000", "1.9621", "0.4745", "3.3856", "3.0000"]
    assert len(heading) == len(row)
    assert len(found.plot().axes) == 1
    with pytest.raises(ValueError, match="points must have shape"):
        fb.repeatability([[0.0, 0.0]])
    with pytest.raises(ValueError, match="commanded must be one point for each"):
        fb.repeatability(points, [[0, 0], [1, 1]])


@pytest.mark.parametrize(
    "name",
    [
        "all three",
        pytest.param("backlash", marks=pytest.mark.deep),
        pytest.param("tilted plane", marks=pytest.mark.deep),
    ],
)
def test_outside_the_model_it_says_so_and_is_no_worse_than_a_quadratic_correction(name):
    rng = np.random.default_rng(2)
    sigma = (
        2e-6 if name == "tilted plane" else 1e-5
    )  # 1 degree moves points by 0.02 mm: to be measured first
    old, new, notes = against_quadratic(rng, name, sets=6, sigma=sigma)
    assert new < old and notes == 1.0


@pytest.mark.parametrize("scale", [1e-3, 50.0])
def test_poses_to_measure_at_are_those_of_a_robot_of_another_size(scale):
    lengths = np.array([0.08, 0.11, 0.1, 0.095, 0.12])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of unusual lengths
        own, other = (fb.measurement_poses(fb.FiveBar(*k * lengths), 8) for k in (1.0, scale))
    # Mirrored in x they tell as much, and rounding must not decide between them.
    assert np.abs(other.xi / scale - own.xi).max() < 1e-9
    assert other.worst_tip == pytest.approx(own.worst_tip, rel=1e-9)
