"""Logs with mistakes: what is absurd is said and asked about, or what was done about it."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from tests.helpers.synthetic_logs import RUNGS, case_of

CASE = case_of(5, RUNGS["gravity, friction"], 12.0)
LOG, ROBOT = CASE.log, CASE.known
T, Q, TAU = LOG["t"], LOG["q"], LOG["tau"]


def clipped(tau):
    limit = 0.85 * np.abs(tau).max(axis=0)
    return np.clip(tau, -limit, limit)


def spoilt(values, *rows):
    """A whole amplitude off in these rows, of the first column."""
    off = np.zeros_like(values)
    off[list(rows), 0] = 2 * np.abs(values).max()
    return values + off


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (
            {"tau": TAU * [-1, 1]},
            {},
            "misses .* noise of this log. Is t in ms. Has q or tau of a motor the wrong",
        ),
        (
            {"tau": -TAU},
            {},
            "comes out, and no robot has less than 0. Has q or tau of a motor the wrong sign",
        ),
        ({"t": 1e3 * T}, {}, "t has no unit, and its steps are 1: is t in ms"),
        ({"t": 30 * T}, {}, "zz1 = .* comes out, as of a robot of .* kg. Is t in ms"),
        ({"tau": 1e3 * TAU}, {}, "as of a robot of .* torques in mN m"),
        ({"tau": TAU[:, ::-1]}, {}, "misses .* are the motors exchanged"),
        ({"q": np.degrees(Q)}, {}, '100 % as deg: say which, by units={"q1": "deg", "q2": "deg"}'),
        *[
            ({"tau": np.roll(TAU, rows, axis=0)}, {}, "misses .* do torques come late")
            for rows in (60, 150, -60)
        ],
        ({}, {"assembly": 1}, r"misses .* Are the assembly mode \+1, gravity"),
        (
            {"q": np.column_stack([Q[:, 0], np.full(len(T), Q[0, 1])])},
            {},
            "q21 hardly moves: .* move both motors",
        ),
        ({"q": np.full_like(Q, 0.3)}, {}, "q11 hardly moves"),
        ({"q": Q * [-1, 1], "tau": TAU * [-1, 1]}, {}, "misses .* wrong sign"),
        (
            {},
            {"gear_ratio": 10.0},
            "fb.calibrate tells. Are q1 and q2 exchanged, or .* another gear_ratio",
        ),
        (
            {"tau": 1e3 * TAU},
            {"gear_ratio": (1.001, 1)},
            r"kg. Is gear_ratio = .1.001, 1. that of this log. Is t in ms",
        ),
        ({"q": Q[:, ::-1], "tau": TAU[:, ::-1]}, {}, "q1 and q2 exchanged|are the motors exch"),
        ({"tau": None}, {}, "no column tau1, tau2: .*--columns tau1=HEADING tau2=HEADING"),
        ({"tau": 0 * TAU}, {}, "tau1, tau2 are all 0"),
        ({"tau": TAU * [1, 0]}, {}, "tau2 is all 0"),
        ({}, {"unknown": ["mass"]}, "no parameter 'mass'; the torque is linear in zz1, zz2, m"),
        ({}, {"cutoff": 200.0}, "at most 83.33 Hz"),
        ({"speed": T}, {}, "no column 'speed'"),
        ({"q": Q[:-1]}, {}, "differ in length"),
        ({}, {"units": {"q1": "furlong"}}, "q1=furlong: known are rad, deg"),
        ({}, {"gear_ratio": 0.0}, "gear_ratio must not be 0"),
    ],
)
def test_what_is_wrong_is_named(change, options, words):
    with pytest.raises(ValueError, match=words.replace("{", r"\{").replace("}", r"\}")):
        fb.identify(ROBOT, {**LOG, **change}, **options)


def a_file(head="t,q1,q2,tau1,tau2", t=1.0, q=1.0, tau=1.0, rates=()):
    """The log in a file whose headings say no units, in units of these sizes."""
    table = np.column_stack([T * t, Q * q, TAU * tau, *rates])[:6000]
    file = io.StringIO()
    np.savetxt(file, table, "%.9g", ",", header=head, comments="")
    file.seek(0)
    return file


RATES = np.gradient(Q, T, axis=0)
DEGREE = 180 / np.pi


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (
            a_file(tau=1e2),
            "as of a robot of [.0-9]+ kg. .* torques in mN m, N cm or kg cm. Say which",
        ),
        (a_file(q=DEGREE), "q1 and q2 have no unit and reach 206.*, 100 % as deg: say which"),
        (a_file(q=2048 * np.pi), "q1 and q2 have no unit and reach .* by --counts-per-turn"),
        (a_file("t,q1 (counts),q2 (counts),tau1,tau2", q=2048 * np.pi), "give counts_per_turn"),
        (a_file("t,q1,q2,tau1 (A),tau2 (A)", tau=20), "tau1 is in A: give torque_constant"),
        (
            a_file("t,q1,q2,tau1,tau2,q1_dot,q2_dot", rates=[DEGREE * RATES]),
            "q1_dot is 57.3 times the rate of q1: is it in deg/s, not in rad/s",
        ),
        (
            a_file("t,q1,q2,tau1,tau2,q1_dot,q2_dot", rates=[RATES * [1, -1]]),
            "q2_dot is -1 times the rate of q2: is its sign the other one",
        ),
    ],
)
def test_a_file_that_says_no_units_is_asked_for_them_where_two_are_possible(file, words):
    with pytest.raises(ValueError, match=words):
        fb.identify(ROBOT, file)


def test_a_file_that_says_no_units_is_taken_in_SI_units_where_it_says_so():
    found = fb.identify(ROBOT, a_file("t,q1,q2,tau1,tau2,q1_dot,q2_dot", rates=[0 * RATES]))
    assert found.values["m"] == pytest.approx(CASE.robot.m, rel=0.01)
    assert "t, q1, q2, tau1, tau2, q1_dot, q2_dot: no unit in the table" in found.notes[0]
    assert "the velocities are all 0: they are not used" in found.notes
    named = fb.identify(ROBOT, a_file("t (s),q1 (rad),q2 (rad),tau1 (N m),tau2 (N m)"))
    assert not named.notes and named.values["m"] == found.values["m"]


def test_velocities_with_gaps_are_left_out():
    """A filter needs all rows about one: a fifth of them blank had left no row."""
    with_gaps = np.where(np.arange(len(T))[:, None] % 5 == 0, np.nan, RATES)
    found = fb.identify(ROBOT, LOG | {"q_dot": with_gaps})
    assert f"the velocities are missing in {-(-len(T) // 5)} rows: they are not used" in found.notes
    assert found.values == fb.identify(ROBOT, LOG).values


def test_gravity_that_the_robot_does_not_have_is_asked_about():
    with pytest.raises(
        ValueError, match="misses .* gravity, the lengths, gear_ratio and offset of q"
    ):
        fb.identify(replace(ROBOT, gravity=(0.0, 0.0)), LOG)


def test_logs_together_say_what_one_says():
    """Cut in two unequal parts, whose ends are filtered otherwise."""
    parts = [
        {name: values[part] for name, values in LOG.items()}
        for part in (slice(0, 5000), slice(5000, None))
    ]
    whole, both = fb.identify(ROBOT, LOG), fb.identify(ROBOT, parts)
    assert both.chosen == whole.chosen
    for name in whole.chosen:
        assert both.values[name] == pytest.approx(whole.values[name], abs=3 * whole.sd[name])
        assert 0.5 < both.sd[name] / whole.sd[name] < 2


@pytest.mark.parametrize("every", [100, 300])
def test_too_slow_a_log_is_refused(every):
    with pytest.raises(ValueError, match="sampling rate cannot follow|are left"):
        slow = {name: values[::every] for name, values in LOG.items()}
        fb.identify(ROBOT, slow, units={"t": "s"})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"q": (Q + np.pi) % (2 * np.pi) - np.pi + [2 * np.pi, 0]}, ""),
        (
            {"tau": np.roll(TAU, 5, axis=0)},
            "the torques come (4.9|5)[0-9.]* ± 0.[0-9]+ ms too late",
        ),
        ({"tau": clipped(TAU)}, "stay at their largest value.* these rows do not count"),
        (
            {"tau": spoilt(TAU, 3000, 7000, 7001)},
            "leave their neighbours in 3 rows .* do not count",
        ),
        ({"t": T + np.random.default_rng(0).uniform(-2e-4, 2e-4, len(T))}, "off an even grid"),
    ],
)
def test_what_was_done_about_it_is_said(change, words):
    found = fb.identify(ROBOT, {**LOG, **change})
    assert set(found.chosen) == CASE.named | {"zz1", "zz2", "m"} or "late" in words
    if words:
        assert any(re.search(words, sentence) for sentence in found.notes)
    assert found.values["m"] == pytest.approx(CASE.robot.m, rel=0.03 if "late" in words else 0.01)


def test_wrapped_angles_lost_rows_gaps_and_a_restart():
    rng = np.random.default_rng(1)
    half = np.where(Q > Q.mean(axis=0), -2 * np.pi, 0.0)
    keep = np.sort(rng.choice(len(T), int(0.93 * len(T)), replace=False))
    keep = keep[(keep < 3000) | (keep > 3300)]
    t, q, tau = T[keep].copy(), (Q + half)[keep], TAU[keep].copy()
    t[7000:] -= 4.0
    q[500], tau[2000:2010], t[900] = np.nan, np.nan, np.nan
    found = fb.identify(ROBOT, {"t": t, "q": q, "tau": tau})
    notes = " | ".join(found.notes)
    for words in (
        "rows without a time",
        "without both joints' positions",
        "jumps by more than half a turn",
        "a restart",
        "gaps in time",
        "were bridged by cubic splines",
    ):
        assert words in notes
    assert set(found.chosen) == CASE.named | {"zz1", "zz2", "m"}


def test_a_model_that_does_not_have_all_of_the_robot_is_said_to_miss_more_than_noise():
    found = fb.identify(replace(ROBOT, l11=0.95 * ROBOT.l11), LOG)
    assert any("times the noise of this log" in sentence for sentence in found.notes)
    assert not any("times the noise" in sentence for sentence in fb.identify(ROBOT, LOG).notes)


@pytest.mark.parametrize("apart", [False, True])
def test_torques_of_every_fifth_row_are_enough(apart):
    """In the rows of positions, or in rows of their own 0.2 ms later."""
    some = np.arange(len(T)) % 5 == 0
    log = {**LOG, "tau": np.where(some[:, None], TAU, np.nan)}
    if apart:
        log["tau"] = np.full_like(TAU, np.nan)
        later = T + 2e-4
        tau = np.stack([np.interp(later, T, column) for column in TAU.T], axis=1)
        own = {"t": later, "q": np.full_like(Q, np.nan), "tau": tau}
        order = np.argsort(np.concatenate([T, own["t"][some]]))
        log = {name: np.concatenate([log[name], own[name][some]])[order] for name in own}
    found = fb.identify(ROBOT, log)
    assert "9600 of 12001 rows with positions lack torques" in found.notes
    assert set(found.chosen) == CASE.named | {"zz1", "zz2", "m"}
    assert found.values["m"] == pytest.approx(CASE.robot.m, rel=0.01)
    assert any("other rows than positions" in each for each in found.notes) == apart


def test_torques_far_from_all_positions_are_no_torques():
    empty = np.full_like(Q, np.nan)
    log = {
        "t": np.concatenate([T, T + 20.0]),
        "q": np.concatenate([Q, empty]),
        "tau": np.concatenate([empty, TAU]),
    }
    words = (
        r"no row of the log has positions and both torques \(torques are in other rows.*12001 of"
    )
    with pytest.raises(ValueError, match=words):
        fb.identify(ROBOT, log)
    with pytest.raises(ValueError, match="no row of the log has positions and both torques"):
        fb.identify(ROBOT, fb.from_log({"t": T, "q": Q}))


def test_what_is_wrong_in_several_stretches_is_summed_up():
    tau = spoilt(TAU, 3000, 7000, 7001)
    keep = np.delete(np.arange(len(T)), slice(5000, 5100))
    log = {"t": T[keep], "q": Q[keep], "tau": tau[keep]}
    notes = [each for each in fb.identify(ROBOT, log).notes if "neighbours" in each]
    assert notes == [
        "torques leave their neighbours in 3 rows (the first at 3 s): these rows do not count"
    ]


def test_a_simulated_run_has_nothing_wrong(tmp_path):
    """Its torques are held for 5 rows each, and not cut off, late or early."""
    true = fb.FiveBar(zz1=0.0023, zz2=0.0018, m=0.45, fv1=4e-3, fv2=6e-3, fs1=3e-3, fs2=5e-3)
    circle = fb.circle((0.06, 0.09), 0.02, 0.5)
    law = fb.ComputedTorque(fb.FiveBar(), 100, 20)
    fb.simulate(true, law, circle, step=2e-3, duration=4).to_csv(tmp_path / "run.csv")
    unknown = ["zz1", "zz2", "m", "fv1", "fv2", "fs1", "fs2"]
    found = fb.identify(fb.FiveBar(), str(tmp_path / "run.csv"), unknown=unknown)
    assert found.notes == () and found.values["m"] == pytest.approx(0.45, rel=1e-3)


def test_parameters_that_are_not_unknown_are_asked_about_where_the_model_lacks_them():
    names = sorted(CASE.named | {"zz1", "zz2", "m"})
    some = [name for name in names if name[0] != "f"]
    words = "misses 16.* % of the torques, .* and is all unknown that it has .friction.[?]$"
    (note,) = fb.identify(ROBOT, LOG, unknown=some).notes
    assert re.search(words, note)
    assert not any("misses" in each for each in fb.identify(ROBOT, LOG, unknown=names).notes)


def test_other_lengths_and_other_robots():
    with pytest.raises(ValueError, match="do not close the loop.*fb.calibrate|misses|no robot has"):
        fb.identify(replace(ROBOT, l12=0.4 * ROBOT.l12, l22=0.4 * ROBOT.l22), LOG)
    with pytest.raises(TypeError, match="the log must be a CSV file"):
        fb.identify(ROBOT, 5)
    with pytest.raises(ValueError, match="at least one log"):
        fb.identify(ROBOT, [])
