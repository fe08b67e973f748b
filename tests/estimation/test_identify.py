"""Identification: the regression against the models, simulated robots, what a log cannot tell, files."""

import time
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.identification.filtering import RegressionRows, filtered
from fivebar.estimation.identification.regression import fit, left_out_cost, smallest, spread
from fivebar.estimation.identification.regressor import ladder, linear_names, regressor
from fivebar.estimation.identification.samples import log_of, samples
from fivebar.estimation.logs.logs import AT_THE_JOINTS
from tests.helpers.synthetic_logs import RUNGS, case_of, jerky_motion, motion_of, torques_of

ALL = case_of(3, RUNGS["all"])
BIGLIDE = fb.Biglide(
    zz1=-0.01,
    zz2=0.01,
    my1=0.02,
    my2=-0.01,
    gravity=(0.0, -9.81),
    fv1=2.0,
    fv2=1.0,
    fs1=0.5,
    fs2=0.2,
)


def slides(t):
    """q, q', q'' of a biglide's feet."""
    k = 2 * np.pi * np.array([0.3, 0.7, 1.1])
    a = np.array([[0.06, 0.02, 0.01], [-0.03, 0.04, -0.01]])
    s, c = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
    return s @ a.T, (c * k) @ a.T, -(s * k * k) @ a.T


@pytest.mark.parametrize("robot", [ALL.robot, BIGLIDE], ids=["five-bar", "biglide"])
def test_the_torque_is_the_regressor_times_the_parameters(robot):
    rng = np.random.default_rng(0)
    q, q_dot, q_ddot = (
        motion_of(robot, rng, 2.0, 0.01)[1:] if robot.turns else slides(np.arange(0, 2, 0.01))
    )
    theta = np.array([getattr(robot, name) for name in linear_names(robot)])
    tau = torques_of(robot, q, q_dot, q_ddot)
    np.testing.assert_allclose(
        regressor(robot, q, q_dot, q_ddot, -1) @ theta, tau, atol=1e-12 * np.abs(tau).max()
    )


def test_the_ladder_has_every_parameter_once():
    assert len(linear_names(fb.FiveBar())) == 17 and len(linear_names(fb.Biglide())) == 11
    assert ladder(fb.FiveBar())["gravity"] == ("mx11", "my11", "mx21", "my21")
    assert ladder(fb.Biglide())["turning bars"] == ("zz1", "zz2", "my1", "my2")


def test_the_same_filter_on_both_sides_leaves_no_bias():
    """Whatever is cut out of the samples, and whatever the filter: the equation holds in every row."""
    rng = np.random.default_rng(1)
    t, W = np.arange(4000) * 1e-3, rng.normal(size=(4000, 2, 5))
    theta = rng.normal(size=5)
    counts = np.repeat(rng.random((80, 2)) > 0.3, 50, axis=0)
    rows = filtered([(t, W, W @ theta, counts)], 1e-3, 7.0)
    np.testing.assert_allclose(rows.W @ theta, rows.tau, atol=1e-13)
    assert rows.counts.sum() > 80 and not np.any(rows.tau[~rows.counts])


def test_the_chosen_set_has_the_lowest_cost_of_all_sets():
    rng = np.random.default_rng(5)
    for _ in range(20):
        A = rng.normal(size=(12, 7))
        cov, price = np.linalg.inv(A.T @ A), 4.0
        theta = rng.normal(size=7) * rng.choice([0.0, 1.5], 7) + np.linalg.cholesky(
            cov
        ) @ rng.normal(size=7)
        kept = smallest(theta, cov, list(range(7)), price)

        def cost(inside, theta=theta, cov=cov, price=price):
            return left_out_cost(
                theta, cov, [k for k in range(7) if k not in inside]
            ) + price * len(inside)

        every = [[k for k in range(7) if mask >> k & 1] for mask in range(2**7)]
        assert cost(kept) == pytest.approx(
            min(map(cost, every)), abs=0.5
        )  # by exchanges, not by all 2^n


def test_deviations_count_that_what_is_left_out_need_not_be_0():
    """One column beside another nearly like it, whose small share no data of this size tell from 0: of 200 logs the
    value is within 2 sd in 9 of 10, and within 2 sd of a fit that takes the share for 0 in far fewer."""
    rng, n, inside = np.random.default_rng(6), 50, np.zeros(2)
    first = rng.normal(size=(n, 2))
    W = np.stack(
        [first, 0.9 * first + 0.4 * rng.normal(size=(n, 2)), rng.normal(size=(n, 2))], axis=-1
    )
    counts, t = np.ones((n, 2), bool), np.arange(n) * 1.0
    for _ in range(200):
        tau = W @ (1.0, 0.5, 2.0) + rng.normal(size=(n, 2))  # 0.5 is two of its standard deviations
        rows = RegressionRows(W, tau, counts, t, np.ones((n, 2)), (0,), 1.0)
        full, last = fit(rows, [0, 1, 2]), fit(rows, [0, 2])
        sd = [np.sqrt(cov[0, 0]) for cov in (spread(full, [0, 2], last), last.cov)]
        inside += np.abs(last.theta[0] - 1.0) <= 2 * np.array(sd)
    assert inside[0] >= 0.85 * 200 and inside[1] < 0.4 * 200


@pytest.mark.deep
def test_a_simulated_robot_that_sticks_and_slips_comes_back():
    robot = replace(fb.ROBOTS["iri-vertical"].robot, fs1=0.05, fs2=0.08)
    path = fb.Trajectory(0.0, 5.0, _lissajous)
    run = fb.simulate(
        robot, fb.ComputedTorque(robot, 400.0, 40.0), path, control_period=2e-3, step=2e-3
    )
    known = fb.FiveBar(robot.l11, robot.l12, robot.l21, robot.l22, robot.d, gravity=robot.gravity)
    unknown = "zz1", "zz2", "m", "mx11", "mx21", "fv1", "fv2", "fs1", "fs2", "zz12", "zz22"
    found = fb.identify(known, run, unknown=unknown)
    for name, value in found.values.items():  # without noise, what is left is that of steps of 2 ms
        assert value == pytest.approx(getattr(robot, name), rel=3e-3)
    assert found.misfit < 1e-3 and found.validation is None
    assert found.robot.fs2 == pytest.approx(0.08, rel=2e-3)


def _lissajous(t):
    t = np.asarray(t)
    k = np.array([2.1, 3.3, 7.9])
    a, b = np.array([0.05, 0.0, 0.012]), np.array([0.0, 0.04, 0.01])
    angle = np.multiply.outer(t, k)
    x = [np.sin(angle) @ a, (k * np.cos(angle)) @ a, -(k * k * np.sin(angle)) @ a]
    y = [np.sin(angle) @ b + 0.22, (k * np.cos(angle)) @ b, -(k * k * np.sin(angle)) @ b]
    return np.stack([x[0], y[0], x[1], y[1], x[2], y[2]], axis=-1)


def test_a_biglide_from_a_log():
    t = np.arange(0, 20, 2e-3)
    q, q_dot, q_ddot = slides(t)
    tau = torques_of(BIGLIDE, q, q_dot, q_ddot)
    rng = np.random.default_rng(2)
    log = {
        "t": t,
        "q": q + 1e-6 * rng.normal(size=q.shape),
        "tau": tau + 0.05 * rng.normal(size=q.shape),
    }
    found = fb.identify(fb.Biglide(gravity=BIGLIDE.gravity), log)
    assert {"mf1", "mf2", "m", "fv1", "fv2", "fs1", "fs2"} <= set(found.chosen)
    z = [
        (found.values[name] - getattr(BIGLIDE, name)) / found.sd[name]
        for name in ("fv1", "fv2", "fs1", "fs2")
    ]
    assert np.abs(z).max() < 4


def test_naive_differences_fail_where_the_filter_does_not():
    """Central differences of the same log, and least squares of them: inertias from noise."""
    case = case_of(4, RUNGS["friction"], 12.0)
    t, q = case.log["t"], case.log["q"]
    step = t[1]
    q_dot, q_ddot = (q[2:] - q[:-2]) / (2 * step), (q[2:] - 2 * q[1:-1] + q[:-2]) / step**2
    names = linear_names(case.robot)
    used = [names.index(name) for name in ("zz1", "zz2", "m", "fv1", "fv2", "fs1", "fs2")]
    W = regressor(case.known, q[1:-1], q_dot, q_ddot, -1)[:, :, used].reshape(-1, len(used))
    naive = np.linalg.lstsq(W, case.log["tau"][1:-1].ravel(), rcond=None)[0]
    found = fb.identify(case.known, case.log)
    truth = case.robot.m
    assert abs(naive[2] / truth - 1) > 0.5  # most of the mass is gone
    assert (
        abs(found.values["m"] / truth - 1) < 0.01 and not found.notes
    )  # torques of these very times: not held


@pytest.mark.deep
def test_the_cut_off_falls_until_noise_in_the_columns_bends_nothing():
    """Of nearly dependent columns, noise of the encoders is the first to be seen: values far off for their sd."""
    case = case_of(21, RUNGS["heavy bars, gravity, friction"], 16.0, encoder=2e-4, torque=1e-3)
    for cutoff in (None, 40.0):
        found = fb.identify(case.known, case.log, cutoff=cutoff)
        for name, value in found.values.items():
            assert abs(value - getattr(case.robot, name)) < 4 * found.sd[name]
        assert (found.cutoff < 8.0) is (cutoff is None)
        bent = [note for note in found.notes if note.startswith("noise of the encoders bent")]
        assert len(bent) == (cutoff is not None)
    assert "it was taken off and counts in the deviations; a cutoff of" in bent[0]


@pytest.mark.parametrize("seed", [0, 2])
def test_of_jerky_moves_noise_of_the_encoders_bends_nothing_whatever_the_cut_off(seed):
    """Their torques jump at rows, to what lasts until the next: half a row of doubt counts."""
    has = RUNGS["heavy bars, gravity, friction"]
    case = case_of(seed, has, 6.0, 2e-3, jerky_motion, encoder=2e-4, torque=4e-3)
    log, held = log_of(case.log, case.known, AT_THE_JOINTS)
    highest = 2 * samples(log, held, case.known, -1, None).cutoff
    for cutoff in (None, highest):
        found = fb.identify(case.known, case.log, cutoff=cutoff)
        assert (found.cutoff < 0.71 * highest) is (cutoff is None)
        for name, value in found.values.items():
            assert abs(value - getattr(case.robot, name)) < 3 * found.sd[name]


def test_what_no_motion_shows_and_what_this_log_does_not():
    plain = case_of(0, RUNGS["plain"], 8.0)
    found = fb.identify(plain.known, plain.log)
    assert found.chosen == ("zz1", "zz2", "m")
    assert (
        "without gravity" in found.indistinguishable[0]
        and "mx11, my11, mx21, my21" in found.indistinguishable[0]
    )
    rhombus = fb.FiveBar(
        0.1, 0.1, 0.1, 0.1, 0.0, zz1=0.002, zz2=0.003, m=0.4
    )  # distal bars turn as the cranks do
    t = np.arange(0, 8, 1e-3)
    k = 2 * np.pi * np.array([0.4, 1.0, 1.4])
    s, c = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
    a = np.array([[0.2, 0.1, 0.05], [-0.1, 0.15, 0.05]])
    motion = s @ a.T + [2.2, 0.9], (c * k) @ a.T, -(s * k * k) @ a.T
    tau = torques_of(rhombus, *motion)
    rng = np.random.default_rng(7)
    log = {"t": t, "q": motion[0], "tau": tau + 1e-3 * np.std(tau) * rng.normal(size=tau.shape)}
    found = fb.identify(replace(rhombus, zz1=0.0, zz2=0.0, m=0.0), log)
    words = " ".join(found.indistinguishable)
    assert "zz12: no motion of this robot shows it by itself" in words and "zz22" in words
    assert found.values["zz1"] == pytest.approx(0.002, abs=4 * found.sd["zz1"])


def test_the_result_is_kept_and_shown(tmp_path):
    case = case_of(4, RUNGS["friction"], 10.0)
    found = fb.identify(case.known, case.log, validate=case.log)
    found.to_json(tmp_path / "a.json")
    again = fb.Identification.from_json(tmp_path / "a.json")
    assert again.table == found.table and repr(again) == repr(found) and "\n" not in repr(found)
    found.plot(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000
    with pytest.raises(ValueError, match="no rows to draw"):
        again.plot()
    with pytest.raises(ValueError, match="not a file of kind 'identification'"):
        (tmp_path / "b.json").write_text("{}", encoding="utf-8")
        fb.Identification.from_json(tmp_path / "b.json")


@pytest.mark.deep
def test_a_hundred_thousand_rows():
    case = case_of(5, RUNGS["gravity, friction"], 100.0)
    fb.identify(case.known, {name: values[:8000] for name, values in case.log.items()})  # compiles
    spent = []
    for _ in range(2):
        before = time.process_time()
        found = fb.identify(case.known, case.log)
        spent.append(time.process_time() - before)
    assert len(case.log["t"]) > 100_000 and set(found.chosen) == case.named | {"zz1", "zz2", "m"}
    assert min(spent) < 6.0  # 1.3 s on one core alone; one shared with others is slower
