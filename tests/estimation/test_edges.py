"""How little is enough: the fewest rows, samples and numbers that are taken, and one fewer."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.checks import LONGEST, SHORTEST
from fivebar.estimation.calibration.calibrate import _reaching, start_values
from fivebar.estimation.calibration.candidates import candidates
from fivebar.estimation.calibration.fit import LeastSquares
from fivebar.estimation.calibration.measured_robot import LENGTHS, PLACE, sizes, values_of
from fivebar.estimation.calibration.rows import rows_of
from fivebar.estimation.calibration.starts import _counted
from fivebar.estimation.identification.dependent_columns import independent
from fivebar.estimation.logs.derivatives import derivatives, half_window, spectrum
from fivebar.estimation.logs.logs import evenly, read_log
from tests.helpers.twins import HOME, LAB, measured, poses, seen, twin

NAMES = (*LENGTHS, "offset1", "offset2")


def exact(n, names=NAMES, seed=1, **changes):
    rng = np.random.default_rng(seed)
    return measured(twin(rng, LAB, names) | changes, n, rng, modes=HOME)


@pytest.mark.parametrize("n", [3, 4])
def test_mistakes_are_looked_for_in_four_points(n):
    """Three points bear too many explanations."""
    data = exact(n, ("l11",))
    data["x"] *= 1e3
    if n == 3:
        with pytest.raises(
            ValueError, match="no robot with these unknowns fits: .* or distance in mm"
        ):
            fb.calibrate(LAB, data, ("x0", "y0", "turn", "scale"))
    else:
        with pytest.raises(ValueError, match="x, y move by .* for each rad"):
            fb.calibrate(LAB, data, ("l11",))


def test_two_points_tell_a_frame_and_one_does_not():
    at = dict(x0=0.5, y0=-0.4)
    assert fb.calibrate(LAB, exact(2, (), **at), ("x0", "y0")).values == pytest.approx(at)
    with pytest.raises(ValueError, match="2 solutions fit"):
        fb.calibrate(LAB, exact(1, (), **at), ("x0", "y0"))


def test_what_is_not_measured_at_all_stays_where_it_was():
    data = exact(6)
    del data["y"]
    found = fb.calibrate(LAB, data, ("y0",), start={"y0": 0.25})
    assert found.values == {"y0": 0.25} and found.sd == {"y0": np.inf} and found.rank == 0
    assert found.dof == 6 and found.covariance == pytest.approx(np.zeros((1, 1)))
    assert found.correlation == pytest.approx(np.full((1, 1), np.nan), nan_ok=True)
    (words,) = found.indistinguishable
    assert words == "y0 not at all: no measurement depends on it: measuring y, too, would tell"
    assert found.intervals()["y0"] == (-np.inf, np.inf)


def test_no_row_is_named_where_the_others_leave_no_scatter():
    """Of two rows' numbers too many none can be compared with the others."""
    rng = np.random.default_rng(3)
    data = measured(twin(rng, LAB, NAMES), 5, rng, 1e-4, HOME)
    data["y"][2] = np.nan
    data["x"][4] += 0.01
    found = fb.calibrate(LAB, data, NAMES, mistakes="keep")
    assert found.dof == 2 and found.outliers == {}


def test_lengths_may_be_the_shortest_and_the_longest():
    for name in (*LENGTHS[:4], "scale"):
        for value in (SHORTEST, LONGEST):
            assert start_values(LAB, {name: value}).max() >= value
        with pytest.raises(ValueError, match="start: bars and scale must be from"):
            start_values(LAB, {name: 0.99 * SHORTEST})
    assert start_values(LAB, {"d": 0.0})[4] == 0.0 and start_values(LAB, {"d": LONGEST})[4] > 0
    with pytest.raises(ValueError, match="d from 0 on"):
        start_values(LAB, {"d": -SHORTEST})
    assert start_values(LAB, {"x0": -LONGEST})[9] == -LONGEST
    for name in ("l11", "x0", "offset1"):
        for value in (1.01 * LONGEST, -1.01 * LONGEST):
            with pytest.raises(ValueError, match=rf"start\['{name}'\] must be finite and from"):
                start_values(LAB, {name: value})


def test_sizes_of_ratios_are_of_the_largest_reading():
    """Of a motor that stays at 0 any size will do, but a finite one."""
    q = np.array([[0.0, -4.0], [0.0, 2.0], [np.nan, 1.0]])
    names = ("l11", "turn", "ratio1", "ratio2", "x0", "scale")
    bar = (LAB.l11 + LAB.l12 + LAB.l21 + LAB.l22) / 4
    assert sizes(LAB, q, names).tolist() == [bar, 1.0, 1.0, 0.25, bar, 1.0]


def test_rows_without_a_row_to_compare_are_refused():
    """A distance may be 0; a standard deviation may not."""
    data = exact(3)
    ruler = {"distance": [0.0, np.nan, np.nan], "to": [2.0, np.nan, np.nan]}
    rows = rows_of(data | ruler)
    assert rows.to.tolist() == [1, -1, -1] and rows.numbers[-1] == 0.0
    for sigma in (0.0, -1e-4):
        with pytest.raises(ValueError, match="row 2: sigma must be > 0"):
            rows_of(data | {"sigma": [1e-4, sigma, 1e-4]})


def test_of_too_few_rows_in_reach_none_is_fitted():
    """One point in reach has two numbers, enough for two unknowns and too few for three."""
    rng = np.random.default_rng(4)
    q, points, assembly, _ = seen(twin(rng, LAB, ()), poses(twin(rng, LAB, ()), 1, rng, HOME))
    q = np.vstack([q, [(np.pi, 0.0)] * 2])
    points = np.vstack([points, [(0.0, 0.1)] * 2])
    rows = rows_of({"q1": q[:, 0], "q2": q[:, 1], "x": points[:, 0], "y": points[:, 1]})
    modes = np.array([assembly[0], -1, -1])
    for free in ([0, 1], [0, 1, 2]):
        size = np.full(len(free), 0.09)
        task = LeastSquares(rows, np.array(free), values_of(LAB), size, np.ones(6))
        with pytest.raises(ValueError, match="^row 2, row 3: with these angles the robot"):
            _reaching(task, task.start, modes, np.zeros(3, bool))


def test_counts_are_told_of_each_motor_by_itself():
    """A motor that turns through 8 rad or more reads counts; the other one is left as it is."""
    q = np.stack([np.linspace(0.0, 4000.0, 9), np.linspace(-1.0, 2.0, 9)], axis=1)

    def told(*names):
        task = SimpleNamespace(rows=SimpleNamespace(q=q), names=names, start=values_of(LAB))
        return _counted(task)

    assert told() == [] and told("ratio2") == []
    ratios = [p[7:9] for p in told("ratio1", "ratio2")]
    assert len(ratios) == 29 and ratios[0] == pytest.approx((2 * np.pi / 400, 1.0))
    q[:, 0] = np.linspace(-3.9, 4.0, 9)
    assert told("ratio1") == []


def test_as_many_poses_as_unknowns_need():
    """n poses give 2 n numbers; a window may leave just as many poses as are asked for."""
    names = ("l11", "l12", "l21", "l22", "d", "offset1")
    assert len(fb.measurement_poses(LAB, 3, names).q) == 3
    with pytest.raises(ValueError, match="n = 2 poses give 4 numbers, fewer than the 6 unknowns"):
        fb.measurement_poses(LAB, 2, names)
    window = (-0.05, 0.05, 0.115, 0.135)
    there = len(candidates(LAB, 0.9, [(-1, -1)], window).q)
    assert 4 < there < 30
    options = {"margin": 0.9, "working": (-1, -1), "window": window}
    assert len(fb.measurement_poses(LAB, there, ("l11", "d"), **options).q) == there
    with pytest.raises(ValueError, match=f"only {there} poses keep the margin 0.9"):
        fb.measurement_poses(LAB, there + 1, ("l11", "d"), **options)
    for window in ((0.0, 0.0, 0.1, 0.2), (0.0, 0.1, 0.2, 0.2), (0.1, 0.0, 0.1, 0.2), (0, 1, 2)):
        with pytest.raises(ValueError, match="window must be"):
            fb.measurement_poses(LAB, 4, window=window)


def test_eighteen_rows_show_noise_and_seventeen_do_not():
    q = np.random.default_rng(5).normal(size=(18, 2)) * (1e-3, 2e-3)
    assert spectrum([q[:17]], 0.01).noise == (0.0, 0.0)
    found = spectrum([q], 0.01)
    assert 0.2e-3 < found.noise[0] < 3e-3 and found.noise[1] > found.noise[0]
    # A short piece beside long ones adds nothing.
    long = np.random.default_rng(6).normal(size=(400, 2))
    assert spectrum([long, long[:50]], 0.01).noise == spectrum([long], 0.01).noise


def test_a_piece_needs_one_row_with_a_whole_window():
    n = half_window(5.0, 0.01)
    q = np.random.default_rng(7).normal(size=(2 * n + 1, 2))
    for rows, known in ((2 * n - 1, 0), (2 * n, 0), (2 * n + 1, 1)):
        for each in derivatives(q[:rows], 0.01, 5.0):
            assert each.shape == (rows, 2) and np.isfinite(each).all(axis=1).sum() == known


def test_two_rows_are_a_log_and_four_are_put_on_a_grid():
    log = read_log({"t": [0.0, 0.1], "q": [(0.0, 1.0), (0.1, 1.1)]}, fb.FiveBar())
    assert log.step == pytest.approx(0.1) and len(log.t) == 2 and log.cuts == ()
    t = np.array([0.0, 0.012, 0.018, 0.03])
    even, pairs, off = evenly(t, {"q": np.stack([t**2, t**3], axis=1)}, 0.01)
    assert even == pytest.approx([0.0, 0.01, 0.02, 0.03]) and off == pytest.approx(0.2)
    assert pairs["q"] == pytest.approx(np.stack([even**2, even**3], axis=1), abs=1e-15)


@pytest.mark.parametrize("count", [1, 3, 4])
def test_three_gaps_are_named_and_more_are_counted(count):
    t = 0.01 * np.arange(40)
    for gap in range(count):
        t[8 * (gap + 1) :] += 0.03
    log = read_log({"t": t, "q": np.stack([t, -t], axis=1)}, fb.FiveBar())
    (note,) = log.notes
    named = [f"{cut.start:.6g} to {cut.end:.6g} s" for cut in log.cuts[:3]]
    more = " and more" if count > 3 else ""
    assert note == f"{count} gaps in time: {', '.join(named)}{more}"
    assert [cut.missing for cut in log.cuts] == [3] * count


@pytest.mark.parametrize("leg", [1, 2])
def test_a_far_offset_is_found_and_the_known_one_stays(leg):
    """A motor's zero may lie anywhere; the other motor's is known."""
    far, known = f"offset{leg}", f"offset{3 - leg}"
    data = exact(8, ("l11",), **{far: 2.4, known: 0.2})
    found = fb.calibrate(LAB, data, ("l11", far), start={known: 0.2})
    assert found.values[far] == pytest.approx(2.4, abs=1e-9)
    assert found.p[5:7].tolist() == pytest.approx([2.4, 0.2][:: 3 - 2 * leg], abs=1e-9)
    assert found.p[PLACE[known]] == 0.2 and found.start[PLACE[far]] == 0.0


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_what_depends_on_what_does_not_depend_on_units(size):
    """Columns: two free ones, a sum of them, nothing, and nearly nothing."""
    rng = np.random.default_rng(12)
    W = rng.normal(size=(30, 2, 5))
    W[..., 2] = 2 * W[..., 0] - 0.5 * W[..., 1]
    W[..., 3] = 0.0
    W[..., 4] *= 1e-14
    kept, folded = independent(size * W, [0, 1, 2, 3, 4], 1e-7)
    assert kept == [0, 1] and set(folded) == {2, 3, 4}
    assert folded[2] == pytest.approx({0: 2.0, 1: -0.5}) and folded[3] == folded[4] == {}
    assert independent(size * W, [2, 0, 1], 1e-7)[0] == [2, 0]
