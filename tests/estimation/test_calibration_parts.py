"""Parts of calibrations against sums written out: chosen poses, intervals, frames."""

from dataclasses import replace
from itertools import permutations
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

import fivebar as fb
from fivebar.estimation.calibration.calibrate import _reaching
from fivebar.estimation.calibration.candidates import candidates
from fivebar.estimation.calibration.fit import (
    LeastSquares,
    assembly_modes,
    loss_slopes,
    noted_assembly,
    robust_scatter,
    solve,
    spectrum,
)
from fivebar.estimation.calibration.measured_robot import UNKNOWNS, seen, values_of
from fivebar.estimation.calibration.outliers import outlying_rows
from fivebar.estimation.calibration.poses import _exchanged, _gain, _spread, _tour
from fivebar.estimation.calibration.rows import rows_of
from fivebar.estimation.calibration.starts import _framed, begin, doubt, median_error

ROBOT = fb.FiveBar(0.1, 0.14, 0.09, 0.13, 0.11)


def slopes_of(rng, count=60, unknowns=4):
    return rng.normal(size=(count, 2, unknowns)) * rng.uniform(0.2, 2.0, (count, 1, 1))


def information_of(slopes, ridge=0.0):
    return sum(each.T @ each for each in slopes) + ridge * np.eye(slopes.shape[2])


def test_gains_and_spreads_of_candidates():
    rng = np.random.default_rng(1)
    slopes = slopes_of(rng)
    covariance = np.linalg.inv(information_of(slopes[:4]))
    for each, gain, spread in zip(slopes, _gain(slopes, covariance), _spread(slopes, covariance)):
        own = each @ covariance @ each.T
        assert gain == pytest.approx(np.linalg.det(np.eye(2) + own))
        assert spread == pytest.approx(np.trace(own))


def test_no_exchange_of_one_pose_tells_more():
    """And the determinant is far above that of poses drawn at random."""
    rng = np.random.default_rng(2)
    slopes = slopes_of(rng)
    chosen = _exchanged(slopes, 5)
    assert len(set(chosen)) == 5
    best = np.linalg.det(information_of(slopes[chosen]))
    for place in range(5):
        for other in set(range(60)) - set(chosen):
            changed = [*chosen[:place], other, *chosen[place + 1 :]]
            assert np.linalg.det(information_of(slopes[changed])) <= best * (1 + 1e-6)
    drawn = [rng.choice(60, 5, replace=False) for _ in range(100)]
    assert best > 1.5 * max(np.linalg.det(information_of(slopes[each])) for each in drawn)


def test_a_tour_is_short_and_enters_a_mode_once():
    rng = np.random.default_rng(4)
    q = rng.uniform(-3.0, 3.0, (7, 2))
    modes = np.array([[1, 1], [-1, 1], [1, 1], [-1, 1], [1, 1], [-1, 1], [1, 1]])
    order = _tour(ROBOT, q, modes)
    assert sorted(order) == list(range(7))
    assert np.abs(np.diff(modes[order, 0])).sum() == 2

    def length(order):
        moves = ROBOT.joint_difference(np.diff(q[list(order)], axis=0))
        changes = np.abs(np.diff(modes[list(order)], axis=0)).any(axis=1)
        return np.abs(moves).max(axis=1).sum() + 10.0 * changes.sum()

    shortest = min(length(each) for each in permutations(range(7)))
    assert length(order) <= 1.25 * shortest


def test_candidates_are_the_poses_of_a_grid_that_keep_the_margin():
    modes = [(-1, -1), (1, -1)]
    window = (-0.1, 0.15, 0.0, 0.2)
    found = candidates(ROBOT, 0.3, modes, window)
    sines = np.abs([*found.sines, found.det_A])
    assert sines.min() > 0.3
    x, y = np.meshgrid(np.linspace(-0.1, 0.15, 27), np.linspace(0.0, 0.2, 27))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    count = 0
    for mode in modes:
        pose = fb.igm(ROBOT, points, mode, unreachable="nan")
        with np.errstate(invalid="ignore"):
            count += (np.abs([*pose.sines, pose.det_A]) > 0.3).all(axis=0).sum()
    assert len(found.q) == count
    whole = candidates(ROBOT, 0.3, modes, None).xi
    assert len(whole) > 50
    for point in whole:
        assert np.hypot(point[0] + 0.055, point[1]) < 0.24 > 0.0
        assert np.hypot(point[0] - 0.055, point[1]) < 0.22
    assert whole[:, 1].max() > 0.13 and whole[:, 1].min() < -0.13
    assert len(candidates(ROBOT, 0.9, modes, (0.5, 0.6, 0.5, 0.6)).q) == 0


def linear(rng, rows=14, unknowns=3):
    """A linear model of two numbers a row, one of the last row: X, y, row of each number."""
    row_of = np.append(np.repeat(np.arange(rows - 1), 2), rows - 1)
    X = rng.normal(size=(len(row_of), unknowns))
    y = X @ rng.normal(size=unknowns) + rng.normal(size=len(row_of))
    return X, y, row_of


@pytest.mark.parametrize("absolute", [True, False])
def test_outlying_rows_and_their_chances(absolute):
    """The worst first, each against a fit of all others; p by the fit without it."""
    rng = np.random.default_rng(6)
    X, y, row_of = linear(rng, 20)
    assert outlying_rows(y - X @ np.linalg.lstsq(X, y, rcond=None)[0], X, 3, row_of, absolute) == {}
    y[row_of == 4] += (9.0, -12.0)
    y[row_of == 11] += (-8.0, 8.0)
    off = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    found = outlying_rows(off, X, 3, row_of, absolute)
    assert list(found) in ([4, 11], [11, 4])
    kept = np.ones(len(y), bool)
    for row, p in found.items():
        out = row_of == row

        def square(rows):
            missed = y[rows] - X[rows] @ np.linalg.lstsq(X[rows], y[rows], rcond=None)[0]
            return missed @ missed

        rest = square(kept & ~out)
        gain = square(kept) - rest
        if absolute:
            chance = stats.chi2.sf(gain, 2)
        else:
            spare = kept.sum() - 3 - 2
            chance = stats.f.sf(gain / 2 / (rest / spare), 2, spare)
        assert p == pytest.approx(20 * chance, rel=1e-6)
        kept &= ~out


LOSSES = {  # rho(z), as of SciPy's least_squares
    "huber": lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1),
    "cauchy": np.log1p,
}


@pytest.mark.parametrize("loss", LOSSES)
def test_slopes_of_a_loss_are_those_of_scipy(loss):
    """psi is half of rho's derivative, rho as in SciPy's least_squares, over the scatter."""
    off = np.random.default_rng(8).normal(size=41) * 3.0
    scatter = 1.4826 * np.median(np.abs(off))

    def half(r):
        return scatter**2 * LOSSES[loss]((r / scatter) ** 2) / 2

    h = 1e-4
    psi, slope = loss_slopes(loss, off)
    assert psi == pytest.approx((half(off + h) - half(off - h)) / (2 * h), abs=1e-5)
    curve = (half(off + h) - 2 * half(off) + half(off - h)) / h**2
    corner = np.abs(np.abs(off) - scatter) < 1e-2
    assert slope[~corner] == pytest.approx(curve[~corner], abs=1e-3)


@pytest.mark.parametrize("shape", [(9, 4), (3, 5)])
def test_a_spectrum_is_whole_of_few_rows_too(shape):
    jacobian = np.random.default_rng(9).normal(size=shape)
    left, s, right, tolerance = spectrum(jacobian)
    assert right.shape == (shape[1], shape[1]) and len(s) == shape[1] == left.shape[1]
    assert right @ right.T == pytest.approx(np.eye(shape[1]), abs=1e-12)
    assert (left[:, : shape[1]] * s) @ right == pytest.approx(jacobian, abs=1e-12)
    assert (s > tolerance).sum() == min(shape)
    assert tolerance == pytest.approx(64 * 2.0**-52 * max(shape) * s[0])


def measured(rng, n=12, modes=(-1, -1), frame=(0.0, 0.0, 0.0, 1.0), note=()):
    """Rows of poses of ROBOT, measured without an error in a frame."""
    points = rng.uniform((-0.04, 0.1), (0.06, 0.16), (n, 2))
    pose = fb.igm(ROBOT, points, modes)
    x0, y0, turn, scale = frame
    z = x0 + 1j * y0 + scale * np.exp(1j * turn) * (pose.xi @ (1, 1j))
    data = {"q1": pose.q[:, 0], "q2": pose.q[:, 1], "x": z.real, "y": z.imag}
    if "assembly" in note:
        data["assembly"] = pose.assembly
    if "working" in note:
        data |= {"working1": pose.working[:, 0], "working2": pose.working[:, 1]}
    return rows_of(data), pose


def task_of(rows, names):
    free = np.array([UNKNOWNS.index(name) for name in names])
    return SimpleNamespace(
        rows=rows,
        names=tuple(names),
        free=free,
        start=values_of(ROBOT),
        size=np.ones(len(free)),
        bar=float(np.mean(values_of(ROBOT)[:4])),
    )


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_robust_fit_has_the_least_sum_of_its_loss(loss):
    """Against a simplex on points of `dgm`; the scatter is that of the start, then of the fit."""
    rng = np.random.default_rng(15)
    rows, pose = measured(rng)
    points = rows.points + 1e-4 * rng.normal(size=(12, 2))
    points[3] += (5e-3, -4e-3)
    rows = replace(rows, points=points)
    free = np.array([UNKNOWNS.index(name) for name in ("l11", "l22")])
    start = values_of(ROBOT)
    task = LeastSquares(rows, free, start, np.ones(2), np.full(24, 1e4), loss=loss)
    found = solve(task, start, pose.assembly)

    def off(z):
        robot = replace(ROBOT, l11=z[0], l22=z[1])
        return 1e4 * (fb.dgm(robot, rows.q, pose.assembly).xi - points)

    z = start[free]
    for _ in range(2):
        scatter = 1.4826 * np.median(np.abs(off(z)))
        z = minimize(
            lambda z, scatter=scatter: LOSSES[loss]((off(z) / scatter) ** 2).sum(),
            z,
            method="Nelder-Mead",
            options={"xatol": 1e-10, "fatol": 1e-12},
        ).x
    assert found[free] == pytest.approx(z, abs=1e-8)


@pytest.mark.parametrize("note", [(), ("assembly",)])
@pytest.mark.parametrize("scale", [1.2, 4000.0])
def test_a_free_frame_is_found_by_the_points(note, scale):
    """In metres or in pixels, turned by any angle."""
    frame = (0.3, -0.2, 2.5, scale)
    rng = np.random.default_rng(10)
    rows, _ = measured(rng, frame=frame, note=note)
    task = task_of(rows, ["x0", "y0", "turn", "scale"])
    best = begin(task)
    assert best[9:13] == pytest.approx(frame, rel=1e-4)
    assert doubt(task, best) < 1e-5 < 1e-2 < doubt(task, task.start)
    assert len(_framed(task, task.start)) == 24
    assert _framed(task_of(rows, ["l11"]), task.start) == []
    for p in _framed(task, task.start):
        in_both = np.nanmean([seen(p, rows.q, np.full(len(rows), side))[0] for side in (-1, 1)], 0)
        away = np.nanmean(rows.points, axis=0) - np.nanmean(in_both, axis=0)
        assert np.abs(away).max() < 0.2 * scale
    open_ = task.start.copy()
    open_[4] = 10.0  # a base on which no row closes
    assert _framed(task, open_) == []
    rows, _ = measured(rng, frame=(0.3, -0.2, 0.0, 1.0), note=note)
    task = task_of(rows, ["x0", "y0"])
    assert begin(task)[9:13] == pytest.approx((0.3, -0.2, 0.0, 1.0), abs=1e-5)
    assert len(_framed(task, task.start)) == 3
    rows, _ = measured(rng, frame=(0.3, 0.0, 0.0, 1.0), note=note)
    assert begin(task_of(rows, ["x0"]))[9] == pytest.approx(0.3, abs=1e-5)
    rows, _ = measured(rng, frame=(0.0, 0.0, -0.7, 1.0), note=note)
    assert begin(task_of(rows, ["turn"]))[11] == pytest.approx(-0.7, abs=1e-5)


def test_doubts_about_strange_lengths_and_crowded_points():
    rows, _ = measured(np.random.default_rng(11))
    task = task_of(rows, ["l11"])
    p = task.start.copy()
    assert median_error(task, p) < 1e-12 and doubt(task, p) < 1e-12
    p[1] += 0.004
    # Only the left leg misses, each point by 4 mm.
    assert median_error(task, p) == pytest.approx(0.004)
    spread = np.std(rows.points, axis=0).max()
    crowded = max(1.0, 0.5 * task.bar / spread)
    assert doubt(task, p) == pytest.approx(0.004 * crowded)
    long = task.start.copy()
    long[1] *= np.exp(0.5)
    missed = task.start[1] * (np.exp(0.5) - 1)
    assert doubt(task, long) == pytest.approx((missed + 0.1 * task.bar) * crowded)
    for length in (0.0, -0.1):
        none = task.start.copy()
        none[1] = length
        assert doubt(task, none) > 1e300
    shut = task_of(rows, ["l11"])
    shut.start[4] = 0.0  # motors on one axis: no share of that can be said
    assert doubt(shut, p) == pytest.approx(doubt(task, p))
    small = task.start.copy()
    small[12] = 4.0
    # In a frame four times as large, the points are four times as near to each other.
    assert doubt(task, small) == pytest.approx(median_error(task, small) / 4 * 4 * crowded)


def test_modes_that_rows_note_or_leave_open():
    rng = np.random.default_rng(12)
    rows, pose = measured(rng, note=("working",))
    p = values_of(ROBOT)
    found = noted_assembly(p, rows)
    points = {side: seen(p, rows.q, np.full(12, side), False)[0] for side in (-1, 1)}
    for k in range(12):
        fits = []
        for side in (-1, 1):
            own = fb.dgm(ROBOT, rows.q[k], side)
            if np.array_equal(own.working, pose.working[k]):
                fits.append(side)
            assert points[side][k] == pytest.approx(own.xi, abs=1e-12)
        assert found[k] == (fits[0] if len(fits) == 1 else 0)
    rows, pose = measured(rng, note=("assembly",))
    assert np.array_equal(noted_assembly(p, rows), pose.assembly)
    rows, _ = measured(rng)
    assert not noted_assembly(p, rows).any()


def test_distances_to_rows_that_are_left_out_are_left_out():
    data = {
        "q1": [0.1, np.nan, 0.3, 0.4, 0.5],
        "q2": [1.0, 2.0, 2.1, 2.2, 2.3],
        "distance": [np.nan, 0.1, 0.2, 0.3, np.nan],
        "to": [np.nan, 1, 2, 5, np.nan],
        "x": [0.0, 0.1, 0.2, np.nan, np.nan],
        "y": [0.1, 0.1, np.nan, np.nan, np.nan],
    }
    rows = rows_of(data)
    assert rows.notes == ("left out, without q1 or q2: row 2",)
    assert rows.where == ("row 1", "row 3", "row 4", "row 5")
    assert rows.to.tolist() == [-1, -1, 3, -1]
    assert rows.whole.tolist() == [True, False, False, False]
    assert rows.row_of.tolist() == [0, 0, 1, 2]
    assert rows.numbers.tolist() == [0.0, 0.1, 0.2, 0.3]
    to_first = rows_of({**data, "to": [np.nan, 1, 1, 5, np.nan]})
    assert to_first.to.tolist() == [-1, 0, 3, -1]
    assert to_first.numbers.tolist() == [0.0, 0.1, 0.2, 0.2, 0.3]
    out = rows.without(np.array([True, False, False, False]))
    assert out.to.tolist() == [-1, 2, -1] and len(out) == 3
    for to, words in ((3.0, "row 3"), (6.0, "row 3"), (0.0, "row 3"), (1.5, "row 3")):
        with pytest.raises(ValueError, match=f"{words}: distance = 0.2 and to = {to:g}"):
            rows_of({**data, "to": [np.nan, 1, to, 5, np.nan]})
    with pytest.raises(ValueError, match="row 3: distance = -0.2"):
        rows_of({**data, "distance": [np.nan, 0.1, -0.2, 0.3, np.nan]})


def test_a_row_out_of_reach_is_reached_by_a_fit_of_the_others():
    """With distances to and from it, which are left out, too; each number keeps its own weight."""
    q = np.array([(1.8, 1.2), (2.0, 1.4), (1.6, 0.9), (1.9, 1.3), (2.2, 0.7)])
    xi = fb.dgm(ROBOT, q, -1).xi
    x, y = xi.T.copy()
    x[4] = y[4] = np.nan
    distance = np.full(5, np.nan)
    to = np.array([4, 5, np.nan, np.nan, 3])
    for row, other in ((0, 3), (1, 4), (4, 2)):
        distance[row] = np.linalg.norm(xi[row] - xi[other])
    distance[0] += 0.01
    columns = {"x": x, "y": y, "distance": distance, "to": to, "assembly": np.full(5, -1)}
    rows = rows_of({"q1": q[:, 0], "q2": q[:, 1], **columns})
    weight = np.full(11, 1e4)
    weight[8] = 1e-4  # of the wrong distance
    short = values_of(ROBOT)
    short[[1, 3]] -= 0.02
    assert np.isnan(seen(short, rows.q, rows.assembly, False)[0][:, 0]).tolist() == [False] * 4 + [
        True
    ]
    task = LeastSquares(rows, np.array([1, 3]), short, np.full(2, 0.1), weight)
    found, modes, _ = _reaching(task, short, rows.assembly, np.zeros(5, bool))
    assert np.array_equal(modes, rows.assembly)
    assert found == pytest.approx(values_of(ROBOT), abs=1e-12)


def both_sides(rng, n=10):
    """Readings whose poses close in both assembly modes, far from Type 2, and these poses."""
    found = []
    while len(found) < n:
        q = rng.uniform(-np.pi, np.pi, 2)
        poses = [fb.dgm(ROBOT, q, side, unreachable="nan") for side in (-1, 1)]
        if all(abs(pose.det_A) > 0.3 for pose in poses):
            found.append((q, [pose.xi for pose in poses]))
    q, points = zip(*found)
    return np.array(q), np.array(points)


MODES = [(a, b) for a in (-1, 1) for b in (-1, 1)]


def test_assembly_modes_are_those_of_the_points_or_noted_or_of_the_nearer_pose():
    rng = np.random.default_rng(13)
    q, points = both_sides(rng)
    sides = rng.integers(0, 2, 10)
    own = points[np.arange(10), sides]
    own += 1e-4 * rng.normal(size=own.shape)
    modes = 2 * sides - 1
    p = values_of(ROBOT)
    data = {"q1": q[:, 0], "q2": q[:, 1], "x": own[:, 0], "y": own[:, 1]}
    found, uncertain = assembly_modes(p, rows_of(data))
    assert np.array_equal(found, modes) and not uncertain.any()
    # A whole point counts more than what is noted; a half one does not.
    noted = {**data, "assembly": -modes}
    found, uncertain = assembly_modes(p, rows_of(noted))
    assert np.array_equal(found, modes) and not uncertain.any()
    half = {name: column.copy() for name, column in noted.items()}
    half["y"][:5] = np.nan
    found, uncertain = assembly_modes(p, rows_of(half))
    assert np.array_equal(found, np.where(np.arange(10) < 5, -modes, modes))
    assert not uncertain.any()
    half.pop("assembly")
    found, uncertain = assembly_modes(p, rows_of(half))
    assert np.array_equal(found, modes) and not uncertain.any()
    # Where the distal bars are nearly in line a whole point does not tell: what is noted counts.
    locus = fb.singularity_loci(ROBOT).task
    xi = next(piece.points[len(piece.points) // 3] for piece in locus if int(piece.type) == 2)
    mode = next(m for m in MODES if abs(fb.igm(ROBOT, xi, m, unreachable="nan").det_A) < 1e-3)
    near = fb.igm(ROBOT, xi, mode)
    row = {"q1": near.q[:1], "q2": near.q[1:], "x": xi[:1], "y": xi[1:]}
    for side in (-1, 1):
        found, uncertain = assembly_modes(p, rows_of(row | {"assembly": np.array([side])}))
        assert found.tolist() == [side] and not uncertain.any()
    # On a line midway between both points, neither is nearer.
    middle = points[:5, :, 0].mean(axis=1)
    half["x"][:5] = middle + 1e-5
    _, uncertain = assembly_modes(p, rows_of(half))
    assert np.array_equal(uncertain, np.arange(10) < 5)
    # A distance alone tells no mode.
    ruler = {name: column.copy() for name, column in data.items()}
    ruler["x"][:2] = ruler["y"][:2] = np.nan
    ruler["distance"] = np.append(0.1, np.full(9, np.nan))
    ruler["to"] = np.append(2.0, np.full(9, np.nan))
    found, uncertain = assembly_modes(p, rows_of(ruler))
    assert found.tolist() == [0, 0, *modes[2:]]
    assert uncertain.tolist() == [True, True] + [False] * 8
    found, uncertain = assembly_modes(p, rows_of({**ruler, "assembly": -modes}))
    assert found.tolist() == [*-modes[:2], *modes[2:]] and not uncertain.any()


def test_scatters_pass_over_what_is_not_reached():
    q, points = both_sides(np.random.default_rng(14))
    off = np.linspace(-1e-3, 1e-3, 10)
    data = {"q1": q[:, 0], "q2": q[:, 1], "x": points[:, 0, 0] + off, "y": points[:, 0, 1] + off}
    rows = rows_of(data)
    task = SimpleNamespace(rows=rows, weight=np.full(20, 2.0))
    modes = np.full(10, -1)
    expected = 1.4826 * 2.0 * np.median(np.abs(off))
    assert robust_scatter(task, values_of(ROBOT), modes) == pytest.approx(expected)
    short = values_of(ROBOT)
    short[[1, 3]] = 1e-3
    assert robust_scatter(task, short, modes) == 1.0


def test_a_machine_is_what_was_calibrated():
    """It reads, at a point of the measuring frame, what the calibration was given there."""
    rng = np.random.default_rng(15)
    frame = (0.3, -0.2, 0.5, 1.1)
    rows, pose = measured(rng, frame=frame)
    start = {"x0": 0.3, "y0": -0.2, "turn": 0.5, "scale": 1.1, "offset1": 0.1}
    q = pose.q - (0.1, 0.0)
    data = {"q1": q[:, 0], "q2": q[:, 1], "x": rows.points[:, 0], "y": rows.points[:, 1]}
    names = ("l11", "offset1")
    found = fb.calibrate(ROBOT, data, names, start=start, sigma=1e-5)
    machine = found.machine
    assert machine.robot == found.robot
    assert machine.frame.inverse(rows.points) == pytest.approx(pose.xi, abs=1e-9)
    assert machine.readings(pose.q) == pytest.approx(q, abs=1e-9)
    assert machine.measured == ((-1, -1, int(pose.assembly[0])),)
    assert found.predict(q, pose.assembly) == pytest.approx(rows.points, abs=1e-9)
    assert found.chi2 == pytest.approx(0.0, abs=1e-9) and found.dof == 22
    slope = found.sd["l11"]
    assert np.diag(found.correlation) == pytest.approx(1.0)
    low, high = found.intervals(0.9)["l11"]
    assert high - low == pytest.approx(2 * stats.norm.ppf(0.95) * slope)


def test_no_priors_are_advised_without_lengths_or_beside_priors():
    rows, pose = measured(np.random.default_rng(16))
    points = rows.points + 1e-4 * np.random.default_rng(17).normal(size=rows.points.shape)
    data = {"q1": pose.q[:, 0], "q2": pose.q[:, 1], "x": points[:, 0], "y": points[:, 1]}
    turned = fb.calibrate(ROBOT, data, ("offset1", "offset2"), sigma=1e-4)
    assert turned.advised_priors == {}
    lengths = ("l11", "l12", "l21", "l22", "d")
    known = fb.calibrate(ROBOT, data, lengths, sigma=1e-4, priors={"d": 1e-3})
    assert known.advised_priors == {}
    free = fb.calibrate(ROBOT, data, lengths, sigma=1e-4)
    assert set(free.advised_priors) in (set(), set(lengths))
