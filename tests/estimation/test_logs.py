"""Logs as runs: units, gears, gaps, restarts and jumps; what a run does with its gaps."""

import io

import numpy as np
import pytest
from scipy.optimize import brentq

import fivebar as fb
from fivebar.estimation.logs.logs import Gauges, evenly, read_log, wanted
from fivebar.estimation.logs.measured_runs import rates_of

ROBOT = fb.FiveBar()
RUN = fb.simulate(
    ROBOT, fb.ComputedTorque(ROBOT, 400.0, 40.0), fb.line((0.09, 0.068), (0.0, 0.1), 1.0), step=2e-3
)
COLUMNS = {"t": RUN.t, "q": RUN.q, "tau": RUN.tau}


def rows_of(run):
    return np.isfinite(run.q).all(axis=1)


@pytest.mark.parametrize(
    "made",
    [
        lambda: fb.from_log(RUN.t, *RUN.q.T, *RUN.tau.T),
        lambda: fb.from_log(COLUMNS, robot=ROBOT),
        lambda: fb.from_log(
            {"t": 1e3 * RUN.t, "q": np.degrees(RUN.q), "tau": RUN.tau},
            units={"t": "ms", "q1": "deg", "q2": "deg"},
        ),
        lambda: fb.from_log(
            RUN.t,
            *((RUN.q - [0.1, 0.2]) * [-50, 50] * 4096 / (2 * np.pi)).T,
            *(RUN.tau / [-50, 50] / 0.062).T,
            counts_per_turn=4096,
            gear_ratio=(-50, 50),
            offset=(0.1, 0.2),
            torque_constant=0.062,
        ),
        lambda: fb.from_log(
            csv_of("time (ms);theta1 [deg];theta2 [deg];torque1 (mNm);torque2 (mNm)")
        ),
    ],
    ids=["arrays", "mapping", "units", "counts", "csv"],
)
def test_the_same_run_from_logs_in_all_forms(made):
    run = made()
    np.testing.assert_allclose(run.t, RUN.t, atol=1e-12)
    np.testing.assert_allclose(run.q, RUN.q, atol=1e-12)
    np.testing.assert_allclose(run.tau, RUN.tau, atol=1e-12)
    np.testing.assert_allclose(run.xi, RUN.xi, atol=1e-12)
    np.testing.assert_allclose(run.q_dot, RUN.q_dot, atol=2e-3)
    np.testing.assert_allclose(run.energy, RUN.energy, atol=1e-4)
    assert run.measured is not None and RUN.measured is None


def csv_of(header):
    rows = np.column_stack([1e3 * RUN.t, np.degrees(RUN.q), 1e3 * RUN.tau])
    return io.StringIO(
        header + "\n" + "\n".join(";".join(repr(float(v)) for v in row) for row in rows)
    )


def test_gaps_and_restarts_are_marked_and_bridged_by_nothing(tmp_path):
    keep = np.r_[0:200, 240 : len(RUN.t)]
    t = RUN.t[keep].copy()
    t[350:] -= t[350]
    q = RUN.q[keep].copy()
    q[50] = np.nan
    run = fb.from_log(t, *q.T, *RUN.tau[keep].T)
    assert [why.split(" at ")[0].split(" before")[0] for _, _, why in run.measured.gaps] == [
        "1 rows missing",
        "40 rows missing",
        "time jumps back from 0.778 to 0 s",
    ]
    assert (~rows_of(run)).sum() == 3 and (np.diff(run.t) > 0).all()
    assert any("taken for a restart" in sentence for sentence in run.measured.notes)
    run.to_csv(tmp_path / "a.csv")
    again = fb.Run.from_csv(tmp_path / "a.csv")
    assert again.measured == run.measured
    np.testing.assert_array_equal(again.q, run.q)
    run.plot(tmp_path / "a.png")
    run.page(tmp_path / "a.html")
    run.animate(tmp_path / "b.html")
    assert all((tmp_path / name).stat().st_size > 10_000 for name in ("a.png", "a.html", "b.html"))
    assert (
        "Run: five-bar robot" in repr(run)
        and np.isfinite(run.energy_error[rows_of(run)][:50]).all()
    )


def test_a_log_with_its_reference_and_end_effector():
    log = {**COLUMNS, "xi": RUN.xi, "xi_ref": RUN.xi_ref}
    run = fb.from_log(log)
    np.testing.assert_allclose(run.error, RUN.error, atol=1e-15)
    other = fb.dgm(ROBOT, RUN.q, 1, unreachable="nan").xi
    assert np.allclose(fb.from_log({**COLUMNS, "xi": other}).xi, other)  # the mode that fits
    partly = other.copy()
    partly[20:] = np.nan
    np.testing.assert_allclose(fb.from_log({**COLUMNS, "xi": partly}).xi, other, atol=1e-15)
    notes = fb.from_log({**COLUMNS, "xi": RUN.xi + 0.03}).measured.notes
    assert any("mm (median) from where the joints say" in sentence for sentence in notes)


@pytest.mark.parametrize(
    ("log", "words"),
    [
        ({"t": RUN.t, "q1": RUN.q[:, 0]}, "no column q2"),
        ({"q": RUN.q}, "no column t"),
        ({"t": RUN.t[:1], "q": RUN.q[:1]}, "1 rows with a time and both joints"),
        ({"t": RUN.t, "q": RUN.q, "colour": RUN.t}, "no column 'colour'"),
        ({"t": RUN.t, "q": np.full_like(RUN.q, np.nan)}, "0 rows with a time and both joints"),
        ({"t": -RUN.t, "q": RUN.q}, "the log: its times never increase"),
        ({"t": RUN.t, "q": RUN.q, "tau1": RUN.t}, "the log has tau1, but no tau2"),
        ({"t": RUN.t, "q": RUN.q[:, 0]}, r"q must have shape \(n, 2\), not \(501,\)"),
        ({"t": RUN.t, "q1": RUN.q, "q2": RUN.t}, r"must have shape \(n,\), not \(501, 2\)"),
        ({"t": RUN.t, "q": RUN.q[:7]}, "differ in length"),
        ({"t": RUN.t, "q1": "far", "q2": RUN.t}, "q1.* must be"),
        (
            {"t": [*0.01 * np.arange(8), 1e17], "q": np.zeros((9, 2))},
            "row 9: t = .* s is no time of a log with rows every 0.01 s",
        ),
    ],
)
def test_what_is_no_log_is_refused(log, words):
    with pytest.raises(ValueError, match=words):
        fb.from_log(log)


@pytest.mark.parametrize(
    ("log", "options", "words"),
    [
        (COLUMNS, dict(units={"q1": "mm"}), "units: q1=mm: known are rad, deg, mrad, rev, counts"),
        (COLUMNS, dict(units={"speed": "m"}), "units: speed=m: known are"),
        (COLUMNS, dict(units={"q1": 1.0}), "units must be"),
        (COLUMNS, dict(gear_ratio=(1.0, 0.0)), r"gear_ratio must not be 0, but is \[1.0, 0.0\]"),
        (COLUMNS, dict(gear_ratio=5e-324), "gear_ratio must not be 0, but is .5e-324"),
        (COLUMNS, dict(counts_per_turn=(10, 0)), "counts_per_turn must not be 0"),
        (COLUMNS, dict(offset=(1.0, "b")), "offset must be"),
        (COLUMNS, dict(torque_constant=(1.0, 2.0, 3.0)), "torque_constant must be"),
        (COLUMNS, dict(tau1=RUN.t), "columns beside a file or a mapping: tau1"),
        (COLUMNS, dict(q1_dot=RUN.t), "columns beside a file or a mapping: q1_dot"),
        (COLUMNS, dict(robot=5), "robot must be"),
        (COLUMNS, dict(assembly=2), "assembly must be"),
        (RUN.t, {}, "no column q1, q2"),
    ],
)
def test_options_that_cannot_be(log, options, words):
    with pytest.raises((TypeError, ValueError), match=words):
        fb.from_log(log, **options)


def test_columns_in_any_units_of_both_kinds_of_robots():
    rng, t = np.random.default_rng(3), 0.01 * np.arange(20)
    pairs = {name: rng.normal(size=(20, 2)) * 0.1 for name in ("q", "tau", "q_dot", "xi", "xi_ref")}
    turn = np.degrees(1.0)
    for robot, head, scale in (
        (
            ROBOT,
            "theta1 (degrés),q21 (deg),Torque1 mNm,effort2 (Nm),q1_dot (deg/s),velocity_2 (tr/min)",
            (turn, turn, 1e3, 1, turn, 30 / np.pi),
        ),
        (
            fb.Biglide(),
            "q1 (mm),position2 (m),effort1 (mN),tau2 (N),q1_dot (mm/s),q2_dot (m/s)",
            (1e3, 1, 1e3, 1, 1e3, 1),
        ),
    ):
        table = np.hstack([1e3 * t[:, None], *(pairs[name] for name in pairs)])
        table[:, 1:] *= (*scale, 1e3, 100, 1e3, 1)
        rows = "\n".join(",".join(map(repr, row)) for row in table.tolist())
        log = read_log(
            io.StringIO(f"Temps (ms),{head},x (mm),y (cm),x_ref (mm),y_ref\n{rows}"), robot
        )
        np.testing.assert_allclose(log.t, t, atol=1e-15)
        for name, pair in pairs.items():
            np.testing.assert_allclose(getattr(log, name), pair, atol=1e-14, err_msg=name)
        assert log.step == pytest.approx(0.01) and log.cuts == ()
        needed = [name for name, column in wanted(robot).items() if column.needed]
        assert needed == ["t", "q1", "q2"]
        mapping = {
            "t": t,
            "theta1": pairs["q"][:, 0],
            "q2": 2 * pairs["q"][:, 1],
            "effort1": t,
            "tau2": t,
        }
        gauges = Gauges(None, (2.0, -4.0), (0.0, 0.5), (0.1, 0.2))
        joints = read_log(mapping, robot, gauges)
        np.testing.assert_allclose(joints.q, pairs["q"] * [0.5, -0.5] + [0, 0.5], atol=1e-15)
        np.testing.assert_allclose(joints.tau, t[:, None] * [0.2, -0.8], atol=1e-15)
        units = {"tau1": "a", "tau2": "ma", "q1": "mrad" if robot.turns else "mm"}
        joints = read_log(mapping, robot, gauges._replace(units=units))
        np.testing.assert_allclose(joints.tau, t[:, None] * [0.2, -0.8e-3], atol=1e-15)
        counts = read_log({"t": t, "q": pairs["q"]}, robot, Gauges(counts_per_turn=(-500, 250))).q
        np.testing.assert_allclose(
            counts, pairs["q"] * (2 * np.pi if robot.turns else 1) / [-500, 250], atol=1e-15
        )


def test_what_was_done_to_the_rows_is_said():
    t = 0.01 * np.arange(20)
    q = np.linspace([2.9, 0.1], [3.6, 0.3], 20)
    log = {"t": t.copy(), "q": np.angle(np.exp(1j * q)), "tau": np.ones((20, 2)), "q_dot": None}
    log["t"][[3, 5]] = np.nan
    log["q"][8, 1] = log["q"][9, 0] = np.nan
    log["t"][12] = log["t"][11]
    log["t"][14:] += 0.05
    log["t"][17:] -= 0.5
    found = read_log(log, ROBOT)
    assert found.notes == (
        "2 rows without a time were left out, the first row 4",
        "2 rows without both joints' positions were left out, the first row 9",
        "1 rows with the time of the row before were left out, the first row 13",
        "time jumps back from 0.21 to -0.28 s at row 18: taken for a restart, 0.51 s are added from there on",
        "5 gaps in time: 0.02 to 0.04 s, 0.04 to 0.06 s, 0.07 to 0.1 s and more",
        "q jumps by more than half a turn 1 times, the first at row 8: taken for whole turns",
    )
    assert [(cut.row, cut.missing, cut.why) for cut in found.cuts[2:]] == [
        (6, 2, "2 rows missing before row 11"),
        (8, 1, "1 rows missing before row 14"),
        (9, 5, "5 rows missing before row 15"),
        (12, 0, "time jumps back from 0.21 to -0.28 s at row 18"),
    ]
    assert [(cut.start, cut.end) for cut in found.cuts[4:]] == [
        pytest.approx((0.13, 0.19)),
        pytest.approx((0.21, 0.23)),
    ]
    kept = [0, 1, 2, 4, 6, 7, 10, 11, 13, 14, 15, 16, 17, 18, 19]
    np.testing.assert_allclose(found.q, q[kept], atol=1e-14)
    np.testing.assert_allclose(found.t[-4:], [0.21, 0.23, 0.24, 0.25], atol=1e-15)
    assert [(part.start, part.stop) for part in found.stretches] == [
        (0, 3),
        (3, 4),
        (4, 6),
        (6, 8),
        (8, 9),
        (9, 12),
        (12, 15),
    ]
    assert (found.step, found.q_dot, found.xi) == (pytest.approx(0.01), None, None)
    file = "t_s,q1 (unit),q2 (unit)\n# a comment\n0,3,0\n1,-3,0\n2,-2.9,0\n4,-2.8,0\n"
    assert read_log(io.StringIO(file.replace("unit", "rad")), ROBOT).notes[-2:] == (
        "1 gaps in time: 2 to 4 s",
        "q jumps by more than half a turn 1 times, the first at line 4: taken for whole turns",
    )
    assert (
        read_log(io.StringIO(file.replace("unit", "m")), fb.Biglide()).notes[-1]
        == "1 gaps in time: 2 to 4 s"
    )


def test_rows_out_of_order_are_sorted_and_only_far_jumps_back_are_restarts():
    """Neighbours exchanged, a row 8 periods late and two restarts: one note of each kind."""
    t = np.arange(120.0)
    order = np.arange(120)
    order[[10, 11]] = 11, 10
    order[20:29] = np.roll(order[20:29], -1)
    q = np.stack([np.sin(0.1 * t), np.cos(0.1 * t)], axis=1)
    found = read_log({"t": 0.01 * t[order], "q": q[order]}, ROBOT)
    assert found.notes == ("11 rows were not in the order of time, the first row 11: sorted",)
    np.testing.assert_array_equal(found.q, q)
    np.testing.assert_allclose(found.t, 0.01 * t)
    assert found.cuts == ()
    again = 0.01 * (t[order] % 50)
    found = read_log({"t": again, "q": q[order]}, ROBOT)
    assert found.notes == (
        "11 rows were not in the order of time, the first row 11: sorted",
        "time jumps back from 0.49 to 0 s at row 51: taken for a restart, 0.51 s are added from"
        " there on; so are 1 more jumps back",
    )
    np.testing.assert_array_equal(found.q, q)
    assert [cut.row for cut in found.cuts] == [50, 100]


def test_torques_in_rows_of_their_own_are_those_of_rows_near_by():
    """At 0.2 periods after every third position, up to a restart; a straight line in time."""
    t = 0.01 * np.arange(40)
    own = t[::3] + 0.002
    empty = np.full((40, 2), np.nan)
    log = {
        "t": np.concatenate([t, own, t]),
        "q": np.concatenate([np.stack([t, -t], axis=1), empty[: len(own)], empty + 0.0]),
        "tau": np.concatenate([empty, np.stack([own, 1 - own], axis=1), empty]),
    }
    log["q"][len(t) + len(own) :] = 0.5
    order = np.concatenate(
        [np.argsort(log["t"][: len(t) + len(own)]), len(t) + len(own) + np.arange(40)]
    )
    found = read_log({name: values[order] for name, values in log.items()}, ROBOT)
    near = np.flatnonzero(np.isfinite(found.tau).all(axis=1))
    assert near.tolist() == list(range(0, 40, 3))
    np.testing.assert_allclose(found.tau[near[1:]], np.stack([t, 1 - t], axis=1)[near[1:]])
    assert found.notes[:2] == (
        "torques are in other rows than positions: interpolated to rows near by",
        "66 of 80 rows with positions lack torques",
    )


def test_torques_of_few_rows_are_put_on_a_grid_near_these():
    t = 0.01 * np.arange(30) + 0.001 * np.sin(np.arange(30))
    t[[0, -1]] = 0.0, 0.29
    tau = np.stack([t, -t], axis=1)
    tau[np.arange(30) % 5 != 0] = np.nan
    even, pairs, _ = evenly(t, {"tau": tau}, 0.01)
    known = np.isfinite(pairs["tau"]).all(axis=1)
    assert np.flatnonzero(known).tolist() == list(range(0, 30, 5))
    np.testing.assert_allclose(
        pairs["tau"][known][:-1], np.stack([even, -even], axis=1)[known][:-1]
    )
    nothing = evenly(t, {"tau": np.full_like(tau, np.nan)}, 0.01)[1]["tau"]
    assert np.isnan(nothing).all()


def test_rows_off_an_even_grid_are_moved_onto_it():
    """Splines give cubics exactly, straight lines torques; these are not bridged where rows are missing."""
    step, k = 0.01, np.array([0, 1, 2, 3, 4, 5, 8, 9, 10, 11])

    def pairs(t):
        cubic = np.stack([1 + t - 2 * t**2 + 3e3 * t**3, t**3], axis=1)
        return {
            "q": cubic,
            "tau": np.stack([1 - t, 2 * t], axis=1),
            "xi": np.stack([t, 3 * t], axis=1),
        }

    t = step * (k + np.array([0, 0.2, -0.2, 0.1, 0.3, 0.0, -0.2, 0.1, 0.2, 0]))
    given, grid = pairs(t), step * np.arange(12)
    given["xi"][0] = np.nan
    even, moved, away = evenly(t, given, step)
    np.testing.assert_allclose(even, grid, atol=1e-16)
    np.testing.assert_allclose(moved["q"], pairs(grid)["q"], atol=1e-13)
    np.testing.assert_allclose(
        moved["xi"][2:], pairs(grid)["xi"][2:], atol=1e-15
    )  # not by splines, all of them nan
    lost = (grid > t[5]) & (grid < t[6]) | (grid == t[5])
    assert lost.sum() == 3 and (np.isnan(moved["tau"]) == lost[:, None]).all()
    np.testing.assert_allclose(moved["tau"][~lost], pairs(grid)["tau"][~lost], atol=1e-15)
    assert away == pytest.approx(0.3)
    del given["tau"]
    assert set(evenly(t, given, step)[1]) == {"q", "xi"}
    nearly = grid + step * np.array([0, *[0.009, -0.009] * 5, 0])
    even, same, away = evenly(nearly, given, step)
    assert same == given and away == pytest.approx(0.009) and even == pytest.approx(grid, abs=1e-16)
    beyond = grid + step * np.array([0, *[0.011, -0.011] * 5, 0])
    assert evenly(beyond, pairs(beyond), step)[1]["q"] == pytest.approx(pairs(grid)["q"], abs=1e-13)
    for few in (np.array([0.0, 0.013, 0.03]), np.array([0.0, 0.012, 0.02]), np.array([0.3])):
        even, same, away = evenly(few, pairs(few), step)
        assert len(even) == len(few) and even[[0, -1]] == pytest.approx(few[[0, -1]])
        assert (same["q"] == pairs(few)["q"]).all()
    assert evenly(few, pairs(few), step)[2] == 0


def test_rates_of_long_of_short_and_of_single_stretches():
    t = 0.01 * np.array([*range(100), 105, 106, 107, 115, 120, 121])
    log = read_log({"t": t, "q1": 0.3 * t, "q2": 1.0 - 0.2 * t}, ROBOT)
    assert [part.stop - part.start for part in log.stretches] == [100, 3, 1, 2]
    expected = np.tile((0.3, -0.2), (106, 1))
    expected[103] = 0.0
    np.testing.assert_allclose(rates_of(log), expected, atol=1e-9)
    run = fb.from_log({"t": t, "q1": 0.3 * t, "q2": 1.0 - 0.2 * t})
    at = np.flatnonzero(~rows_of(run))
    assert at.tolist() == [100, 104, 106] and run.t[at] == pytest.approx([1.02, 1.11, 1.175])
    assert [gap[:2] for gap in run.measured.gaps] == [
        pytest.approx(pair) for pair in ((0.99, 1.05), (1.07, 1.15), (1.15, 1.2))
    ]
    assert np.isnan(run.tau).all() and np.isnan(run.xi[at]).all() and not run.measured.rates


def test_what_a_log_says_of_poses():
    """Rows without rates, out of all bars' reach and on Type 2 have no energy; a leg that stretches is an event."""
    flat, t = np.arccos((0.18 - 0.118) / 0.18), 0.01 * np.arange(9)
    q = np.linspace([0.1, 0.2], [0.2, 0.3], 9)
    q[4], q[6] = (np.pi - flat, flat), (np.pi, 0.0)
    rates = np.full((9, 2), 0.3)
    rates[2, 1] = np.nan
    run = fb.from_log({"t": t, "q": q, "q_dot": rates})
    assert np.flatnonzero(np.isnan(run.energy)).tolist() == [2, 4, 6] and run.measured.rates
    assert run.energy[0] == fb.energy(fb.dkm(fb.dgm(ROBOT, q[0]), (0.3, 0.3)))
    assert "1 of 9 rows do not close the loop of this robot's bars, the first at 0.06 s" in (
        run.measured.notes
    )
    # A bar of the biglide that turns evenly through the horizontal; a leg of the five-bar that straightens.
    bar, phi, t = 0.2828427, np.linspace(0.16, -0.15, 12), 0.1 * np.arange(12)
    right = bar * np.sin(phi) - np.sqrt(bar**2 - (bar * np.cos(phi) - 0.4) ** 2)
    for robot, q, leg, when, before in (
        (fb.Biglide(), np.stack([0 * t, right], axis=1), 0, 0.16 / 0.31 * 1.1, (-1, -1, -1)),
        (ROBOT, np.linspace([2.5, 2.3], [2.5, 2.45], 12), 1, None, (1, -1, -1)),
    ):
        ((found, kind, margin, *modes),) = fb.from_log(t, *q.T, robot=robot).events
        if when is None:
            when = brentq(
                lambda x, q=q: fb.dgm(ROBOT, q[0] + x / 1.1 * (q[-1] - q[0])).sines[1], 0.5, 0.8
            )
        assert found == pytest.approx(when, abs=1e-4) and kind == fb.Singularity.SERIAL
        after = tuple(-mode if k == leg else mode for k, mode in enumerate(before))
        assert margin == robot.words.sines[leg] and modes == [before, after]
        assert fb.from_log(t + (t > found), *q.T, robot=robot).events == ()  # in a gap nobody knows
        long, back = 0.1 * np.arange(24), np.concatenate([q, q[::-1]])
        (event,) = fb.from_log(
            long + (long > found), *back.T, robot=robot
        ).events  # but on the way back
        assert event.t == pytest.approx(3.3 - found, abs=1e-9)


def straight_to_the_last_digit(rng):
    """Return a robot and joints (2,) at which the sine of its right leg is exactly 0."""
    while True:
        robot = fb.FiveBar(*rng.uniform(0.08, 0.12, 4), rng.uniform(0.1, 0.2))
        q = np.full((400, 2), rng.uniform(1.0, 2.6))
        q[:, 1] = np.linspace(-np.pi, np.pi, 400)
        sines = fb.dgm(robot, q, unreachable="nan").sines[1]
        for k in np.flatnonzero(sines[:-1] * sines[1:] < 0):
            root = brentq(
                lambda q2, q1=q[0, 0], robot=robot: fb.dgm(robot, (q1, q2)).sines[1],
                *q[k : k + 2, 1],
                xtol=1e-16,
            )
            near = np.column_stack([q[:200, 0], root + np.spacing(root) * np.arange(-100, 100)])
            exact = fb.dgm(robot, near).sines[1] == 0
            if exact.any():
                return robot, near[exact][0]


@pytest.mark.parametrize("hold", [1, 4])
def test_a_leg_that_is_straight_in_a_row_itself(hold):
    """Its mode changes in the rows in which its sine is exactly 0."""
    rng = np.random.default_rng(35)
    for _ in range(3):
        robot, q = straight_to_the_last_digit(rng)
        away = np.concatenate([np.arange(-5, 0), np.zeros(hold), np.arange(1, 6)])
        t = 0.1 * np.arange(len(away))
        rows = q + np.outer(away, (0.0, 2e-4))
        modes = fb.dgm(robot, rows).working[:, 1]
        assert (modes[5 : 5 + hold] == 0).all() and modes[4] == -modes[5 + hold] != 0
        (event,) = fb.from_log(t, *rows.T, robot=robot).events
        assert 0.5 - 1e-9 <= event.t <= 0.1 * (4 + hold) + 1e-9 and event.margin == "sin q22"
        assert event.before[1] == modes[4] and event.after[1] == modes[-1]
        # Who turns round there has crossed nothing, and in a gap nobody knows.
        back = q - np.outer(np.abs(away), (0.0, 2e-4))
        assert fb.from_log(t, *back.T, robot=robot).events == ()
        assert fb.from_log(t + (away > 0), *rows.T, robot=robot).events == ()


def test_where_the_end_effector_was_logged_and_where_not():
    """Noise moves its median beyond 2 % of a bar: then it is said; what is missing is by the joints."""
    xi = RUN.xi + np.array([0.0, 0.0015])
    xi[:30] = np.nan
    run = fb.from_log({**COLUMNS, "xi": xi})
    np.testing.assert_allclose(run.xi[:30], RUN.xi[:30], atol=1e-15)
    assert (run.xi[30:] == xi[30:]).all() and run.measured.notes == ()
    notes = fb.from_log({**COLUMNS, "xi": xi + np.array([0.0, 0.0005])}).measured.notes
    assert notes == (
        "x and y are 2 mm (median) from where the joints say in assembly mode -1: another mode, frame or other "
        "lengths; fb.calibrate tells",
    )
    other = fb.from_log({**COLUMNS, "xi": np.full_like(xi, np.nan)}, assembly=1)
    np.testing.assert_allclose(other.xi, fb.dgm(ROBOT, RUN.q, 1).xi, atol=1e-15)
    assert other.measured.notes == () and other.measured.gaps == ()


def test_headings_of_a_mapping_name_units_as_those_of_a_file_do():
    t = np.linspace(0.0, 1.0, 30)
    q = 0.1 * np.sin(t)
    columns = {"q1": q, "q2": q / 2}
    plain = fb.from_log({"t": t, **columns})
    for other in (
        {"t_ms": 1e3 * t, **columns},
        {"t (ms)": 1e3 * t, "q1_deg": np.degrees(q), "q2": q / 2},
    ):
        run = fb.from_log(other)
        assert run.t == pytest.approx(plain.t) and run.q == pytest.approx(plain.q)
    with_a_call = {"t_ms": 1e3 * t, "position": np.stack([q, q / 2], axis=1)}
    run = fb.from_log(with_a_call, columns={"q1": "position[0]", "q2": "position[1]"})
    assert run.t == pytest.approx(plain.t) and run.q == pytest.approx(plain.q)
    with pytest.raises(ValueError, match="column 't_ms' is in ms, but its unit is given as s"):
        fb.from_log({"t_ms": t, **columns}, units={"t": "s"})
    with pytest.raises(ValueError, match="has no column 't_parsec', or has it twice"):
        fb.from_log({"t_parsec": t, **columns})


@pytest.mark.parametrize("how", ["columns", "pairs", "lists"])
def test_what_a_masked_array_hides_is_a_gap_and_never_a_number(how):
    t = np.linspace(0.0, 1.0, 30)
    q = np.ma.masked_array(np.stack([0.1 * np.sin(t), 0.1 * t], axis=1), mask=np.zeros((30, 2)))
    q[7, 0] = np.ma.masked
    q.data[7, 0] = 99.0
    if how == "columns":
        run = fb.from_log(t, q[:, 0], q[:, 1])
    elif how == "pairs":
        run = fb.from_log({"t": t, "q": q})
    else:
        places = {"q1": "position[0]", "q2": "position[1]"}
        run = fb.from_log({"t": t, "position": q}, columns=places)
    assert np.nanmax(run.q) < 0.11 and len(run.measured.notes) == 2
    assert "1 rows without both joints' positions were left out" in run.measured.notes[0]
    whole = np.ma.masked_array([0, 99], mask=[False, True])
    with pytest.raises(ValueError, match="finite"):
        fb.dgm(fb.FiveBar(), whole, unreachable="nan")


@pytest.mark.parametrize("step", [5e-4, 1e-3, 1 / 3e3])
def test_a_clock_of_1970_is_as_even_as_one_from_0(step):
    """A double of today's seconds has a last digit of 0.24 us, which is in each of the steps."""
    t = step * np.arange(8001)
    columns = {"q": np.stack([np.sin(3 * t), np.cos(2 * t)], 1), "tau": np.zeros((len(t), 2))}
    log = read_log(columns | {"t": 1.7e9 + t}, ROBOT)
    assert log.step == pytest.approx(step, rel=1e-7)
    assert evenly(log.t, {"q": log.q}, log.step)[2] < 1e-3
