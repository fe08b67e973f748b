"""Parts of an identification by themselves: noise of a row, delays, exciting series."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.identification import exciting
from fivebar.estimation.identification.dependent_columns import any_motion
from fivebar.estimation.identification.exciting import _best, _Search
from fivebar.estimation.identification.filtering import RegressionRows, filtered
from fivebar.estimation.identification.identify import (
    _joined,
    _refuse_few,
    _refuse_impossible,
    _shown,
    _smallest_model,
    _validation,
    _why_left_out,
    _working,
)
from fivebar.estimation.identification.misfit import _noise, beyond_the_model, lateness
from fivebar.estimation.identification.regression import RegressionFit, fit
from fivebar.estimation.identification.regressor import linear_names, regressor
from fivebar.estimation.identification.samples import Samples
from fivebar.estimation.logs import replays
from fivebar.estimation.logs.derivatives import derivatives
from fivebar.estimation.logs.logs import AT_THE_JOINTS
from fivebar.estimation.logs.replays import _simulated, _stretches

ROBOT = fb.FiveBar()
NAMES = linear_names(ROBOT)
MASSES = [NAMES.index(name) for name in ("zz1", "zz2", "m")]


def sample_of(rng, n=3000, step=1e-3, cutoff=15.0, delay=0.0, noise=0.0, wrong=0.0, q_noise=1e-9):
    """A circle of the robot's own torques, `delay` s late."""
    t = step * np.arange(n)
    path = fb.circle((0.0, 0.12), 0.03, 0.5)

    def motion(t):
        xi, xi_dot, xi_ddot = (np.asarray(each) for each in path(np.mod(t, 0.5)))
        acc = fb.ikm2(fb.ikm(fb.igm(ROBOT, xi), xi_dot), xi_ddot)
        return acc.rates.pose.q, acc.rates.q_dot, acc.q_ddot

    own = motion(t)
    theta = np.zeros(len(NAMES))
    theta[MASSES] = [ROBOT.zz1, ROBOT.zz2, ROBOT.m]
    W = regressor(ROBOT, *own, -1)
    tau = regressor(ROBOT, *motion(t - delay), -1) @ theta
    tau = tau + noise * rng.normal(size=(n, 2)) + wrong * np.sin(9 * t)[:, None]
    counts = np.ones((n, 2), bool)
    drawn = derivatives(rng.normal(size=(n, 2)) * [q_noise, 2 * q_noise], step, cutoff)
    noisy = [values + np.nan_to_num(noise) for values, noise in zip(own, drawn)]
    changes = [regressor(ROBOT, *noisy, -1) - W]
    sample = Samples(ROBOT, [(t, W, tau, counts)], [own], changes, step, cutoff, (), -1)
    return sample, theta


def told(sample, theta):
    last = fit(sample.rows, MASSES)
    known = theta.copy()
    known[MASSES] = 0.0
    delay = lateness(sample, MASSES, theta[MASSES], known)
    return beyond_the_model(ROBOT, sample, theta, last, delay), last


@pytest.mark.parametrize("delay, word", [(2e-3, "late"), (-1.5e-3, "early")])
def test_torques_that_come_late_are_said_to_be_so(delay, word):
    sample, theta = sample_of(np.random.default_rng(1), delay=delay, noise=1e-3)
    notes, _ = told(sample, theta)
    (note,) = [each for each in notes if "shift their times" in each]
    assert f"ms too {word} for the motion" in note
    size, sd = (float(part.split()[0]) for part in note.split("come ")[1].split("± "))
    assert size == pytest.approx(1e3 * abs(delay), abs=max(4 * sd, 0.1))
    assert 0.0 < sd < 0.3


def test_a_model_that_is_whole_has_nothing_to_tell():
    sample, theta = sample_of(np.random.default_rng(2), noise=2e-3)
    assert told(sample, theta)[0] == []


def test_what_the_model_misses_is_compared_with_the_noise_of_the_log():
    sample, theta = sample_of(np.random.default_rng(3), noise=1e-4, wrong=5e-3)
    notes, last = told(sample, theta)
    times = last.sigma / _noise(sample, theta)
    words = f"{100 * last.misfit:.3g} % of the torques, {times[0]:.3g} and {times[1]:.3g} times the"
    assert times.min() > 3 and any(f"{words} noise of this log. Is" in each for each in notes)
    far, theta = sample_of(np.random.default_rng(3), wrong=0.5)
    with pytest.raises(
        ValueError, match="misses [3-9].* % of the torques, .* of this log. Is t in"
    ):
        told(far, theta)


def test_a_mass_surely_below_0_is_refused_and_friction_is_not():
    sd = np.array([0.1, 0.2, 0.3])

    def last(below):
        return SimpleNamespace(theta=-below * sd, cov=np.diag(sd**2))

    for below, names in ((3.9, ("zz1", "m", "fv1")), (4.1, ("fv1", "fs1", "mx11"))):
        _refuse_impossible(ROBOT, names, last(below), True, AT_THE_JOINTS)
    with pytest.raises(ValueError, match="m = -1.23 ± 0.3 comes out, and no robot has less than 0"):
        _refuse_impossible(ROBOT, ("fv1", "fs1", "m"), last(4.1), True, AT_THE_JOINTS)


@pytest.mark.parametrize("noise, q_noise", [(3e-3, 1e-9), (0.0, 2e-6), (1e-3, 1e-6)])
def test_the_noise_of_a_row_is_of_torques_and_encoders(noise, q_noise):
    """By the mass matrix at the poses, and the gains of the filters for white noise."""
    sample, theta = sample_of(np.random.default_rng(4), noise=noise, q_noise=q_noise)
    q = sample.motion[0][0][::30]
    still = fb.dkm(fb.dgm(ROBOT, q), np.zeros_like(q))
    columns = []
    for unit in np.eye(2):
        columns.append(fb.inverse_dynamics(fb.dkm2(still, np.broadcast_to(unit, q.shape))))
    M = np.stack(columns, axis=2)
    white = np.random.default_rng(5).normal(size=(90_000, 2))
    accelerations = derivatives(white, 1e-3, 15.0)[2]
    known = np.isfinite(accelerations)
    t = 1e-3 * np.arange(len(white))
    rows = filtered([(t, accelerations[..., None], accelerations, known)], 1e-3, 15.0)
    gain = rows.tau.std()
    by_q = np.array([1.0, 2.0]) * q_noise * gain
    expected = np.hypot(noise * sample.rows.gain, np.sqrt((M**2).mean(axis=0) @ by_q**2))
    assert _noise(sample, theta) == pytest.approx(expected, rel=0.12)


def rows_of(W, tau, counts, cover=None, breaks=(0,)):
    cover = np.ones(tau.shape) if cover is None else cover
    return RegressionRows(W, tau, counts, np.arange(len(tau)) * 1.0, cover, breaks, 0.3)


def test_rows_of_several_logs_are_joined_without_the_known():
    rng = np.random.default_rng(5)
    found = []
    for n, breaks in ((5, (0, 3)), (4, (0, 1, 2))):
        W = rng.normal(size=(n, 2, 3))
        rows = rows_of(W, rng.normal(size=(n, 2)), np.ones((n, 2), bool), breaks=breaks)
        found.append(SimpleNamespace(rows=replace(rows, change=2 * W)))
    known = np.array([1.0, 0.0, -2.0])
    joined = _joined(found, known)
    assert joined.breaks == (0, 3, 5, 6, 7) and joined.gain == 0.3
    expected = np.concatenate([each.rows.tau - each.rows.W @ known for each in found])
    assert joined.tau == pytest.approx(expected)
    assert np.array_equal(joined.change, 2 * joined.W)
    assert len(joined.W) == len(joined.t) == len(joined.cover) == 9
    counts = np.array([[True, False], [True, True]])
    shown = _shown(
        rows_of(np.zeros((2, 2, 1)), np.zeros((2, 2)), counts, np.array([[0.25, 1.0], [4.0, 1.0]])),
        np.array([[1.0, 2.0], [3.0, 4.0]]),
    )
    assert shown == pytest.approx(np.array([[2.0, np.nan], [1.5, 4.0]]), nan_ok=True)


def test_too_few_rows_are_counted():
    counts = np.array([[True, True]] * 5 + [[True, False]] * 2)
    rows = rows_of(np.zeros((7, 2, 1)), np.zeros((7, 2)), counts)
    found = [SimpleNamespace(notes=("one thing", "another")), SimpleNamespace(notes=("a third",))]
    _refuse_few(rows, found, 5)
    with pytest.raises(
        ValueError, match="only 7 and 5 independent .* 6 of each .*one thing. another. a third"
    ):
        _refuse_few(rows, found, 6)


def test_a_second_run_is_predicted_by_the_first():
    rng = np.random.default_rng(6)
    n = 400
    W = rng.normal(size=(n, 2, len(NAMES)))
    theta = np.array([getattr(ROBOT, name) for name in NAMES])
    counts = np.ones((n, 2), bool)
    counts[:100, 1] = False
    tau = W @ theta + rng.normal(size=(n, 2)) * (0.1, 0.4)
    found = SimpleNamespace(robot=ROBOT, given=ROBOT, noise=(0.1, 0.2))
    second = _validation(found, rows_of(W, tau, counts))
    missed = np.where(counts, tau - W @ theta, 0.0)
    rms = np.sqrt((missed**2).sum(axis=0) / counts.sum(axis=0))
    assert second.ratio == pytest.approx((rms[0] / 0.1, rms[1] / 0.2))
    share = (missed**2).sum(axis=0) / (np.where(counts, tau, 0.0) ** 2).sum(axis=0)
    assert second.misfit == pytest.approx(np.sqrt(share.mean()))
    assert np.isnan(second.tau[:100, 1]).all() and np.isnan(second.predicted[:100, 1]).all()
    assert second.tau[counts] == pytest.approx(tau[counts])
    assert second.predicted[counts] == pytest.approx((W @ theta)[counts])


def fit_of(theta, sd):
    return RegressionFit(
        np.array(theta),
        np.diag(np.array(sd) ** 2),
        np.zeros((0, 2)),
        np.ones(2),
        0.0,
        np.zeros(len(theta)),
    )


def test_why_a_parameter_was_left_out():
    full = fit_of([0.012, -0.0034], [0.01, 0.002])
    assert _why_left_out("fv1", full, 0) == (
        "0.012 ± 0.01 beside all others, not told from 0: below about 0.035 this log would not"
        " show it"
    )
    assert _why_left_out("fs1", full, 1) == "friction would be -0.0034 ± 0.002, less than none"
    assert "not told from 0" in _why_left_out("my11", full, 1)


def test_the_smallest_model_keeps_masses_and_no_friction_below_0():
    rng = np.random.default_rng(7)
    wanted = ("zz1", "zz2", "m", "fv1", "fs1", "fs2", "my11")
    columns = [NAMES.index(name) for name in wanted]
    W = np.zeros((600, 2, len(NAMES)))
    W[:, :, columns] = rng.normal(size=(600, 2, 7))
    theta = np.zeros(len(NAMES))
    theta[columns] = [0.0, 2.0, 3.0, 1.0, -1.0, 0.0, -2.0]
    tau = W @ theta + 0.1 * rng.normal(size=(600, 2))
    rows = rows_of(W, tau, np.ones((600, 2), bool))
    chosen, last = _smallest_model(ROBOT, rows, columns, fit(rows, columns))
    assert [NAMES[k] for k in chosen] == ["zz1", "zz2", "m", "fv1", "my11"]
    assert last.theta == pytest.approx(fit(rows, chosen).theta)


@pytest.fixture(scope="module")
def search():
    limits = 4.0, 40.0, 0.3
    bar = SimpleNamespace(update=lambda: None)
    return _Search(ROBOT, 2.0, 4, limits, 0.3, (-1, -1), -1, MASSES, bar)


def test_series_rest_at_both_ends_and_are_their_own_derivatives(search):
    shape = search.random(np.random.default_rng(8))
    series = search.series(shape, 0.2)
    q, q_dot, q_ddot = series.joints(np.array([0.0, 2.0]))
    assert np.abs(q_dot).max() < 1e-9 and np.abs(q_ddot).max() < 1e-9
    assert q[0] == pytest.approx(q[1])
    t, h = np.linspace(0.1, 1.9, 19), 1e-5
    before, middle, after = (series.joints(t + shift) for shift in (-h, 0.0, h))
    for order in (0, 1):
        slope = (after[order] - before[order]) / (2 * h)
        assert slope == pytest.approx(middle[order + 1], abs=1e-6)
    k = np.tile(np.arange(1, 5), 2)
    assert np.linalg.norm(series.coefficients / np.sqrt(k)) == pytest.approx(0.2)
    double = search.series(shape, 0.4).joints(t)[0] - shape[:2]
    assert double == pytest.approx(2 * (middle[0] - shape[:2]))
    acc = series(t)
    xi = fb.dgm(ROBOT, middle[0], -1).xi
    assert acc[:, :2] == pytest.approx(xi)
    assert (series(t + h) - series(t - h))[:, :4] / (2 * h) == pytest.approx(acc[:, 2:], abs=1e-5)


def test_amplitudes_are_the_largest_that_keep_to_the_limits(search):
    rng = np.random.default_rng(9)
    found = 0
    for _ in range(4):
        shape = search.random(rng)
        pose = fb.dgm(ROBOT, shape[:2], -1)
        assert min(*pose.sines, pose.det_A) >= 0.3
        amplitude = search.amplitude(shape, search.t)
        if not amplitude:
            continue
        found += 1
        worst = []
        for own in (amplitude, amplitude + 1 / 512):
            q, q_dot, q_ddot = search.series(shape, own).joints(search.t)
            pose = fb.dgm(ROBOT, q, -1, unreachable="nan")
            tau = fb.inverse_dynamics(fb.dkm2(fb.dkm(pose, q_dot), q_ddot))
            used = [np.abs(q_dot).max() / 4.0, np.abs(q_ddot).max() / 40.0, np.abs(tau).max() / 0.3]
            margin = min(each.min() for each in (*pose.sines, pose.det_A))
            worst.append(max(*used, 1.0 + (0.3 - margin) if margin < 0.3 else 0.0))
        assert worst[0] <= 1.0 + 1e-9
        assert not worst[1] <= 1.0
        q, q_dot, q_ddot = search.series(shape, amplitude).joints(search.t)
        W = regressor(ROBOT, q, q_dot, q_ddot, -1)[:, :, MASSES].reshape(-1, 3)
        condition = np.linalg.cond(W / np.linalg.norm(W, axis=0))
        assert search.condition(q, q_dot, q_ddot) == pytest.approx(condition)
        size = np.sqrt(np.mean(q_ddot**2)) * 4.0
        assert search.cost(shape) == pytest.approx(np.log(condition) - 0.1 * np.log(size))
    assert found >= 2


def test_limits_that_are_not_given_do_not_count(search):
    """Only the margin stays: a motion within it may be as fast as it likes."""
    free = _Search(ROBOT, 2.0, 4, (None, None, None), 0.3, (-1, -1), -1, MASSES, search.bar)
    q = np.tile(fb.igm(ROBOT, (0.0, 0.12)).q, (5, 1))
    fast = np.full((5, 2), 1e3)
    assert free.keeps(q, fast, 1e3 * fast) and not search.keeps(q, fast, 0.0 * fast)
    assert not search.keeps(q, 0.0 * fast, 1e3 * fast)
    slow = _Search(ROBOT, 2.0, 4, (None, None, 0.3), 0.3, (-1, -1), -1, MASSES, search.bar)
    assert slow.keeps(q, 0.0 * fast, 0.0 * fast) and not slow.keeps(q, 0.0 * fast, 1e3 * fast)
    folded = np.tile(fb.igm(ROBOT, (0.0, 0.17)).q, (5, 1))
    assert not free.keeps(folded, 0.0 * fast, 0.0 * fast)


def test_the_best_of_shapes_is_no_worse_than_any_of_them(search, monkeypatch):
    monkeypatch.setattr(exciting, "STEPS", 12)
    rng = np.random.default_rng(10)
    shapes = [search.random(rng) for _ in range(5)]
    best = _best(search, shapes)
    assert search.cost(best) <= min(search.cost(each) for each in shapes)
    shut = SimpleNamespace(cost=lambda shape: np.inf)
    assert _best(shut, shapes) is None


def test_stretches_of_a_run_are_where_time_goes_on():
    t = np.concatenate([np.arange(10) * 0.1, 2.0 + np.arange(8) * 0.1])
    known = np.ones(18, bool)
    known[14] = False

    def ends(restart=None):
        return [(each.start, each.stop) for each in _stretches(known, t, restart)]

    # A row is lost after the time 2.3 s; three rows are left there.
    assert ends() == [(0, 10), (10, 14), (15, 18)]
    known[14] = True
    assert ends() == [(0, 10), (10, 18)]
    # No part is shorter than four rows, and none is left over.
    assert ends(0.4) == [(0, 5), (5, 10), (10, 18)]
    assert ends(0.01) == [(0, 4), (4, 10), (10, 14), (14, 18)]


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_any_motion_covers_the_workspace_of_a_biglide_of_any_size(size):
    robot = fb.Biglide(0.3 * size, 0.3 * size, 0.4 * size)
    W = any_motion(robot, -1, (-1, -1))
    assert len(W) == 400 and np.isfinite(W).all()
    columns = W.reshape(-1, W.shape[-1])
    same = any_motion(fb.Biglide(0.3, 0.3, 0.4), -1, (-1, -1))[..., :3].reshape(-1, 3)
    # Masses of the feet and of the load make forces of any size alike.
    spread = np.linalg.norm(columns[:, :2], axis=0) / np.linalg.norm(same[:, :2], axis=0)
    assert spread == pytest.approx((1.0, 1.0), rel=0.2)


@pytest.mark.parametrize("held", [True, False])
def test_torques_of_uneven_rows_are_interpolated(monkeypatch, held):
    """Of a straight line in time; those at their times are means from each time to the next."""
    monkeypatch.setattr(replays, "simulate", lambda robot, law, **options: (law, options))
    n, step = 20, 0.01
    even = step * np.arange(n)
    t = 3.0 + even + 0.3 * step * np.sin(even * 50.0) * (even > 0) * (even < even[-1])
    q = np.tile(fb.igm(ROBOT, (0.0, 0.12)).q, (n, 1))
    xi = np.tile((0.0, 0.12), (n, 1))
    tau = np.stack([t - 3.0, 1.0 - 5.0 * (t - 3.0)], axis=1)
    run = SimpleNamespace(t=t, tau=tau, q=q, q_dot=0.0 * q, xi=xi)
    law, options = _simulated(run, ROBOT, slice(0, n), held)
    assert options["duration"] == pytest.approx(even[-1])
    assert options["step"] == options["control_period"] == pytest.approx(step)
    assert options["start"].pose.xi == pytest.approx((0.0, 0.12))
    for k in (0, 1, 7, 18):
        middle = even[k] + (0.0 if held else 0.5 * step)
        expected = (middle, 1.0 - 5.0 * middle)
        near = 1e-12 if held else 0.25 * step
        assert law(even[k] + 0.4 * step, None, None, None) == pytest.approx(expected, abs=5 * near)
    assert law(99.0, None, None, None) == pytest.approx(tau[-1])


@pytest.mark.parametrize("working", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_the_modes_of_a_log_are_those_of_its_angles_most_of_the_time(working):
    draw = np.random.default_rng(5)
    xi = draw.uniform((-0.04, 0.1), (0.04, 0.13), (40, 2))
    poses = fb.igm(ROBOT, xi, working)
    assembly = int(np.median(poses.assembly))
    q = poses.q[poses.assembly == assembly]
    other = -np.array(working)
    strays = fb.igm(ROBOT, xi[:5], tuple(other.tolist())).q
    parts = np.concatenate([strays, q]), np.full((3, 2), np.nan)
    rates = [draw.normal(0, 3, part.shape) for part in parts]
    motion = [(part, rate, 10 * rate) for part, rate in zip(parts, rates)]
    first = SimpleNamespace(motion=motion, assembly=assembly)
    assert _working(ROBOT, first) == working
