"""Numbers of an identification of one log, whose truth is known, by other ways."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.identification.regressor import linear_names, regressor
from fivebar.estimation.identification.samples import CREEPING, log_of, samples
from fivebar.estimation.logs.derivatives import HIGHEST, half_window
from fivebar.estimation.logs.logs import AT_THE_JOINTS
from tests.helpers.mujoco_logs import mujoco_log
from tests.helpers.needs import need
from tests.helpers.synthetic_logs import motion_of, torques_of
from tests.helpers.twins import LENGTHS

GIVEN = fb.FiveBar()
BUILT = fb.FiveBar(zz1=0.003, zz2=0.0015, m=0.6, fv1=0.01, fs2=0.02)
NOISE = 2e-3
STEP = 2e-3


def log_from(seed, n=2500, noise=NOISE):
    t = STEP * np.arange(n)
    phase = 2 * np.pi * t
    waves = [(0.9, 0.02, 0.015), (1.7, -0.015, 0.02), (2.6, 0.01, -0.01)]
    xi = np.tile([0.0, 0.115], (n, 1))
    xi_dot, xi_ddot = np.zeros((n, 2)), np.zeros((n, 2))
    for frequency, a, b in waves:
        own = 2 * np.pi * frequency
        angle = frequency * phase
        s, c = np.sin(angle), np.cos(angle)
        xi += np.stack([a * s, b * c], axis=1)
        xi_dot += own * np.stack([a * c, -b * s], axis=1)
        xi_ddot -= own**2 * np.stack([a * s, b * c], axis=1)
    acc = fb.ikm2(fb.ikm(fb.igm(BUILT, xi), xi_dot), xi_ddot)
    tau = fb.inverse_dynamics(acc)
    tau = tau + noise * np.random.default_rng(seed).normal(size=tau.shape)
    motion = acc.rates.pose.q, acc.rates.q_dot, acc.q_ddot
    return {"t": t, "q": motion[0], "tau": tau}, motion


@pytest.fixture(scope="module")
def found():
    return fb.identify(GIVEN, log_from(1)[0], validate=log_from(2)[0])


def test_the_robot_comes_back_with_what_it_has_and_no_more(found):
    assert found.chosen == ("zz1", "zz2", "m", "fv1", "fs2")
    for name in found.chosen:
        assert abs(found.values[name] - getattr(BUILT, name)) < 4.5 * found.sd[name]
        assert getattr(found.robot, name) == found.values[name]
        assert 0 < found.sd[name] < 0.1 * abs(found.values[name]) + 1e-3
    for name in found.rejected:
        assert name not in found.chosen and getattr(found.robot, name) == 0.0
    assert "fv2" in found.rejected and "fs1" in found.rejected
    assert set(found.chosen) | set(found.rejected) <= set(linear_names(GIVEN))
    assert found.given == GIVEN
    # Without gravity, no motion shows the weights of the bars.
    assert any("without gravity" in each for each in found.indistinguishable)
    assert 0.001 < found.p_value <= 1.0


def test_figures_of_the_fit_are_those_of_its_rows(found):
    missed = found.tau - found.predicted
    counts = np.isfinite(missed)
    sd = np.sqrt(np.nansum(missed**2, axis=0) / (counts.sum(axis=0) - len(found.chosen) / 2))
    assert found.noise == pytest.approx(sd, rel=0.1)
    power = np.nansum(np.where(counts, found.tau, 0.0) ** 2, axis=0)
    share = np.sqrt(np.mean(np.nansum(missed**2, axis=0) / power))
    assert found.misfit == pytest.approx(share, rel=0.1)
    steps = np.diff(found.t)
    down = int(1 / (2.5 * found.cutoff * STEP))
    assert steps == pytest.approx(np.full(len(steps), down * STEP))
    assert np.diag(found.correlation) == pytest.approx(1.0)
    assert np.abs(found.correlation).max() <= 1.0 + 1e-9
    assert found.correlation == pytest.approx(found.correlation.T)
    assert found.validation.ratio == pytest.approx((1.0, 1.0), abs=0.25)
    assert found.validation.misfit == pytest.approx(found.misfit, rel=0.25)
    assert len(found.validation.t) == len(found.t)
    missed = f"misses {100 * found.validation.misfit:.3g} % of the torque"
    times = f"{max(found.validation.ratio):.3g} times the noise"
    assert repr(found.validation) == f"<Validation: {missed}, {times}>"


def test_what_is_known_is_not_sought():
    """A wrong mass that is held bends the inertias; the right one does not."""
    log, _ = log_from(3)
    known = fb.FiveBar(m=BUILT.m, fv1=BUILT.fv1, fs2=BUILT.fs2)
    right = fb.identify(known, log, unknown=["zz1", "zz2"])
    assert right.chosen == ("zz1", "zz2") and right.robot.m == BUILT.m
    assert right.robot.fs2 == BUILT.fs2 and not right.rejected and right.p_value == 1.0
    for name in ("zz1", "zz2"):
        assert abs(right.values[name] - getattr(BUILT, name)) < 4.5 * right.sd[name]
    heavy = fb.FiveBar(m=0.62, fv1=BUILT.fv1, fs2=BUILT.fs2)
    bent = fb.identify(heavy, log, unknown=["zz1", "zz2"])
    assert bent.values["zz1"] < right.values["zz1"] and bent.misfit > right.misfit
    with pytest.raises(ValueError, match="unknown: no parameter 'mass'"):
        fb.identify(GIVEN, log, unknown=["mass"])
    with pytest.raises(ValueError, match="at least one log"):
        fb.identify(GIVEN, [])


def test_samples_are_differentiated_and_those_of_creeping_motors_do_not_count():
    log, (q, q_dot, q_ddot) = log_from(4, noise=0.0)
    own, held = log_of(log, GIVEN, AT_THE_JOINTS)
    assert not held
    found = samples(own, held, GIVEN, -1, 25.0)
    ((t, W, tau, counts),) = found.pieces
    ((_, rates, accelerations),) = found.motion
    known = np.isfinite(rates).all(axis=1)
    half = np.flatnonzero(known)[0]
    assert known[half:-half].all() and not known[:half].any() and not known[-half:].any()
    assert rates[known] == pytest.approx(q_dot[known], abs=2e-3 * np.abs(q_dot).max())
    size = np.abs(q_ddot).max()
    assert accelerations[known] == pytest.approx(q_ddot[known], abs=5e-3 * size)
    exact = regressor(GIVEN, q, q_dot, q_ddot, -1)
    masses = [linear_names(GIVEN).index(name) for name in ("zz1", "zz2", "m")]
    assert W[known][..., masses] == pytest.approx(exact[known][..., masses], abs=0.05 * size)
    rms = np.sqrt(np.nanmean(rates**2, axis=0))
    for motor in (0, 1):
        creeps = ~(np.abs(rates[:, motor]) > CREEPING * rms[motor])
        places = np.flatnonzero(creeps)
        distance = np.abs(np.arange(len(t))[:, None] - places).min(axis=1)
        assert not counts[distance < half, motor].any()
        assert counts[(distance > half + 2) & known, motor].all()
        friction = W[:, motor, linear_names(GIVEN).index(f"fs{motor + 1}")]
        assert np.array_equal(friction[known], np.sign(rates[known, motor]))
    assert counts.any(axis=0).all()
    assert found.cutoff == 25.0 and found.step == pytest.approx(STEP) and found.assembly == -1
    means = samples(own, True, GIVEN, -1, 25.0).pieces[0][2]
    assert means[1:] == pytest.approx((tau[1:] + tau[:-1]) / 2) and means[0] == pytest.approx(
        tau[0]
    )
    assert samples(own, held, GIVEN, -1, HIGHEST / own.step).cutoff == HIGHEST / own.step
    with pytest.raises(ValueError, match="cutoff = 60 Hz must be above 0 and at most 41.67 Hz"):
        samples(own, held, GIVEN, -1, 60.0)
    with pytest.raises(ValueError, match="hardly moves"):
        still = {**log, "q": np.column_stack([q[:, 0], np.full(len(q), q[0, 1])])}
        samples(log_of(still, GIVEN, AT_THE_JOINTS)[0], False, GIVEN, -1, 25.0)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-4, 1e-2])
@pytest.mark.parametrize("motor", [0, 1])
def test_a_motor_that_moves_by_the_noise_of_its_encoder_alone_stands_still(size, motor):
    log, _ = log_from(4)
    noise = size * np.random.default_rng(6).normal(size=2500)
    log["q"][:, motor] = log["q"][0, motor] + noise
    name = ("q11", "q21")[motor]
    words = f"{name} hardly moves: its .* of (.*) rad is that of its noise, (.*) rad, or"
    with pytest.raises(ValueError, match=words) as refused:
        fb.identify(GIVEN, log)
    for number in re.search(words, str(refused.value)).groups():
        assert float(number) == pytest.approx(size, rel=0.1)
    # A slow wave of some times the noise is a motion.
    log["q"][:, motor] += (5 * size + 1e-9) * np.sin(log["t"])
    own, held = log_of(log, GIVEN, AT_THE_JOINTS)
    assert len(samples(own, held, GIVEN, -1, None).pieces) == 1


def test_a_log_of_fewer_than_two_rows_for_each_unknown_is_refused():
    short, _ = log_from(5, n=130)
    words = "only 31 and 31 independent rows of the two motors are left, and at least 34 of each"
    with pytest.raises(ValueError, match=words):
        fb.identify(GIVEN, short)
    assert len(fb.identify(GIVEN, short, unknown=linear_names(GIVEN)[:15]).t) == 33


UNITS = {"zz1": "kg m²", "zz2": "kg m²", "m": "kg", "fv1": "N m s/rad", "fs2": "N m"}


def test_the_report_has_all_values_and_all_sentences(found):
    head, *lines = str(found).splitlines()
    assert head.split() == ["value", "±", "1", "sd"]
    values = lines[: len(found.chosen)]
    for name, line in zip(found.chosen, values, strict=True):
        cells = line.split(maxsplit=3)
        sd = f"{found.sd[name]:.2g}"
        assert cells == [name, f"{found.values[name]:.6g}", sd, UNITS[name]]
        assert line.index(cells[1]) + len(cells[1]) == head.index("value") + len("value")
        assert line.index(f" {sd} ") + len(f" {sd}") == len(head)
    first, second = found.noise
    ratio = found.validation.ratio
    missed, by = 100 * found.misfit, 100 * found.validation.misfit
    p_value = f"what was left out is 0 with p = {found.p_value:.2g}"
    assert lines[len(values) :] == [
        f"misses {missed:.3g} % of the torques; noise of a row {first:.3g} and {second:.3g} N m",
        f"second run: misses {by:.3g} %, {ratio[0]:.3g} and {ratio[1]:.3g} times the noise of the first",
        f"{p_value}; the deviations count that it need not be",
        *(f"left out: {name}: {why}" for name, why in found.rejected.items()),
        *(f"not told apart: {sentence}" for sentence in found.indistinguishable),
        *(f"of the log: {sentence}" for sentence in found.notes),
    ]
    names = " ".join(found.chosen)
    second = f"{max(ratio):.3g} times the noise in a second run"
    line = f"<Identification: {names}, misses {missed:.3g} % of the torques, {second}>"
    assert repr(found) == line
    alone = replace(found, validation=None, rejected={}, notes=("a note", "another"))
    assert f"{p_value}\nnot told" in str(alone) and "second run" not in str(alone)
    assert str(alone).endswith("\nof the log: a note\nof the log: another")
    assert repr(alone) == f"<Identification: {names}, misses {missed:.3g} % of the torques>"


def test_a_notebook_shows_each_value_with_its_unit(found):
    html = found._repr_html_()
    for name in found.chosen:
        assert f"{found.values[name]:.6g} ± {found.sd[name]:.2g} {UNITS[name]}" in html
        assert f">{name}<" in html
    forces = replace(found, robot=fb.Biglide())
    assert "of the forces" in str(forces) and "N s/m" in forces._repr_html_()


def test_a_file_has_all_but_the_rows(found):
    out = io.StringIO()
    found.to_json(out)
    again = fb.Identification.from_json(io.StringIO(out.getvalue()))
    for name in ("robot", "given", "values", "sd", "chosen", "rejected", "notes", "noise"):
        assert getattr(again, name) == getattr(found, name)
    assert again.p_value == found.p_value
    assert again.cutoff == found.cutoff and again.indistinguishable == found.indistinguishable
    assert again.correlation == pytest.approx(found.correlation, abs=0.0)
    assert again.validation.ratio == found.validation.ratio
    for rows in (again, again.validation):
        assert rows.t.shape == (0,) and rows.tau.shape == rows.predicted.shape == (0, 2)
    assert not {"t", "tau", "predicted"} & (set(found.table) | set(found.table["validation"]))
    alone = replace(found, validation=None).table
    assert alone["validation"] is None and set(alone) == set(found.table)


def test_gaps_of_three_rows_are_bridged_without_torques_and_longer_ones_are_not():
    log, _ = log_from(7)
    lost = np.r_[600:603, 1200:1204, 1800]
    cut = {name: np.delete(column, lost, axis=0) for name, column in log.items()}
    own, held = log_of(cut, GIVEN, AT_THE_JOINTS)
    found = samples(own, held, GIVEN, -1, 20.0)
    assert [len(t) for t, *_ in found.pieces] == [1200, 2500 - 1204]
    words = "2 gaps of up to 3 rows were bridged by cubic splines, without torques"
    assert words in found.notes
    (_, _, tau, counts), _ = found.pieces
    assert np.isnan(tau[600:603]).all() and not counts[600:603].any()
    assert tau[603] == pytest.approx(log["tau"][603])
    assert not any(
        "bridged by" in note
        for note in samples(*log_of(log, GIVEN, AT_THE_JOINTS), GIVEN, -1, 20.0).notes
    )


def test_rows_of_one_piece_need_a_window_on_either_side():
    """One row fewer than a window holds, or no row more than its own, is no stretch."""
    log, _ = log_from(8, n=400)
    own, held = log_of(log, GIVEN, AT_THE_JOINTS)
    least = 2 * half_window(5.0, STEP) + 3
    short = {name: column[:least] for name, column in log.items()}
    found = samples(*log_of(short, GIVEN, AT_THE_JOINTS), GIVEN, -1, 5.0)
    assert np.isfinite(found.motion[0][2]).all(axis=1).sum() == 3
    shorter = {name: column[: least - 1] for name, column in log.items()}
    words = f"has {least - 1} rows, and derivatives at a cut-off of 5 Hz need {least}"
    with pytest.raises(ValueError, match=words):
        samples(*log_of(shorter, GIVEN, AT_THE_JOINTS), GIVEN, -1, 5.0)
    with pytest.raises(ValueError, match="cutoff = 0 Hz must be above 0"):
        samples(own, held, GIVEN, -1, 0.0)


def test_rows_near_type_2_and_rows_that_do_not_close_are_counted():
    """A motion to a pose whose distal bars are almost in line, of bars that are too short there."""
    t = STEP * np.arange(2000)
    xi = np.stack([0.01 * np.sin(7 * t), 0.0415 + 0.04 * np.cos(5 * t)], axis=1)
    q = fb.igm(GIVEN, xi).q
    log = {"t": t, "q": q, "tau": np.stack([np.sin(3 * t), np.cos(2 * t)], axis=1)}
    elbows = 0.09 * np.exp(1j * q) + np.array([-0.059, 0.059])
    shorter = np.quantile(np.abs(elbows[:, 1] - elbows[:, 0]), 0.99) / 2
    short = replace(GIVEN, l12=shorter, l22=shorter)
    for robot in (GIVEN, short):
        found = samples(*log_of(log, robot, AT_THE_JOINTS), robot, -1, 20.0)
        ((own, _, _),) = found.motion
        known = np.isfinite(own).all(axis=1)
        pose = fb.dgm(robot, own[known], -1, unreachable="nan")
        closes = np.isfinite(pose.xi).all(axis=1)
        singular = np.abs(np.where(closes, pose.det_A, 1.0)) < 0.1
        total = known.sum()
        words = [
            f"{singular.sum()} of {total} rows are within |det A| < 0.1 of a Type-2 singularity"
        ]
        if robot is short:
            words.append(
                f"{(~closes).sum()} of {total} rows do not close the loop of this robot's bars and do"
            )
        for each in words:
            assert any(each in note for note in found.notes), (each, found.notes)
        counts = found.pieces[0][3][known]
        assert not counts[singular | ~closes].any() and singular.any()


@pytest.mark.deep
def test_deviations_hold_for_logs_of_mujoco():
    """Of 6 robots in another simulator, under a digital controller; small friction is found."""
    need("other simulators")
    errors, friction = [], []
    for seed in range(2, 8):
        robot, log = mujoco_log(seed, viscous=1e-3 * (seed % 2), duration=10.0)
        found = fb.identify(replace(fb.FiveBar(), **{n: getattr(robot, n) for n in LENGTHS}), log)
        for name, value in found.values.items():
            errors.append((value - getattr(robot, name)) / found.sd[name])
        friction += [name in found.values for name in ("fv1", "fv2") if seed % 2]
    assert (np.abs(errors) < 1.96).mean() > 0.87 and 0.5 < np.std(errors) < 1.3
    assert np.mean(friction) > 0.7


@pytest.mark.deep
def test_deviations_hold_for_encoders_of_14_bits_and_little_friction():
    """Of 100 robots: 95 % intervals hold the truth that often, and errors are as large as the deviations say."""
    step, errors = 2 * np.pi / 2**14, []
    for k in range(100):
        if k % 50 == 0:
            rng = np.random.default_rng(2 + k // 50)
        friction = 1e-3 * (k % 2)
        while True:
            lengths, d = rng.uniform(0.08, 0.2, 4), rng.uniform(0.05, 0.2)
            if d + lengths.max() < lengths.sum() - lengths.max() and d < lengths.sum() / 3:
                break
        inertias = *rng.uniform(1e-3, 4e-3, 2), rng.uniform(0.2, 0.8)
        robot = fb.FiveBar(*lengths, d, *inertias, fv1=friction, fv2=friction)
        t, q, q_dot, q_ddot = motion_of(robot, rng, duration=10.0)
        tau = torques_of(robot, q, q_dot, q_ddot) + 1e-3 * rng.standard_normal(q.shape)
        log = {"t": t, "q": np.round(q / step) * step, "tau": tau}
        found = fb.identify(fb.FiveBar(*lengths, d), log)
        for name, value in found.values.items():
            errors.append((value - getattr(robot, name)) / found.sd[name])
    errors = np.array(errors)
    # A few belong to inertia of the distal bars, which the robots do not have.
    assert 0.92 < (np.abs(errors) < 1.96).mean() < 0.98
    assert 0.85 < errors.std() < 1.15
