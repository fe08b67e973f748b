"""`fivebar draw`, `fivebar plan`, and what `fivebar track` and `map` say of a file."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.cli.draw import _say_leaps
from fivebar.paths.certificates.checker import check

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">{}</svg>'
STROKES = '<path d="M2 2 L30 5 L20 25 Z"/><circle cx="30" cy="20" r="5"/>'


@pytest.fixture
def drawing(tmp_path):
    (tmp_path / "drawing.svg").write_text(SVG.format("<text>no</text>" + STROKES), encoding="utf-8")
    return str(tmp_path / "drawing.svg")


def table(file, skip=1):
    lines = file.read_text("utf-8").splitlines()[skip:]
    return lines[0].split(","), np.array([line.split(",") for line in lines[1:]], dtype=float)


@pytest.mark.deep
def test_a_drawing_is_drawn(drawing, tmp_path, capsys):
    out = tmp_path / "out"
    assert (
        main(["draw", drawing, "--out", str(out), "--json", "--rate", "500", "--period", "0.01"])
        == 0
    )
    printed = capsys.readouterr()
    figures = json.loads(printed.out)
    assert "<text> is not drawn (line 1)" in printed.err
    assert figures["strokes"] == 2 and figures["certified"] and figures["working"] == [-1, -1]
    assert figures["max_error_m"] < 1e-4 and figures["largest_scale"] > 2
    assert figures["duration_s"] <= 1.001 * figures["lower_bound_s"]
    assert [file.split("/")[-1] for file in figures["files"]] == [
        "drawing.png",
        "setpoints.csv",
        "run.csv",
        "proof.json",
    ]
    assert check(out / "proof.json") is None
    # The setpoints are those of the ends, evenly apart, and lead along the drawing.
    names, rows = table(out / "setpoints.csv")
    assert names[:8] == ["t", "x", "y", "q1", "q2", "q1_dot", "q2_dot", "pen"]
    t, q, pen = rows[:, 0], rows[:, 3:5], rows[:, 7]
    np.testing.assert_allclose(np.diff(t), 0.002, rtol=1e-9)
    assert t[0] == 0 and 0 <= t[-1] - figures["duration_s"] < 0.002 and not rows[[0, -1], 5:7].any()
    xi = fb.dgm(fb.FiveBar(), q, assembly=-1).xi
    path = fb.path(drawing, deviation=2e-5)
    np.testing.assert_allclose(
        xi[-1] - xi[0], path.pieces[-1].end - path.pieces[0].start, atol=1e-12
    )
    moved = np.linalg.norm(np.diff(xi, axis=0), axis=1)
    assert moved[pen[1:] == 1].sum() == pytest.approx(figures["drawn_m"], rel=2e-3)
    run = fb.Run.from_csv(out / "run.csv")
    assert np.linalg.norm(run.xi[0] - xi[0]) < 1e-12


def test_a_leap_of_the_simulated_error_or_torque_is_said_with_its_place(capsys):
    t = np.linspace(0.0, 1.0, 101)
    motion = SimpleNamespace(torques=lambda t: np.full((len(t), 2), 0.04))
    xi = np.stack([0.1 * t, 0.1 + 0 * t], axis=1)
    tau, off = np.full((101, 2), -0.05), np.full(101, 1e-6)
    run = SimpleNamespace(t=t, drawn_ref=xi, tau=tau)
    machine = fb.Machine(fb.FiveBar())
    off[30] = 1.4e-5  # fourteen times the median, but none that is seen
    _say_leaps(machine, motion, run, off, 0.1, None)
    assert not capsys.readouterr().err
    # An error that all of a drawing has is said where it is over a hundredth of its size.
    for size, is_said in ((0.1, True), (0.3, False)):
        _say_leaps(machine, motion, run, np.full(101, 2e-3), size, None)
        assert ("error is up to 2.00 mm" in capsys.readouterr().err) == is_said
    off[60], tau[80, 1] = 7.5e-4, 1.15
    _say_leaps(machine, motion, run, off, 0.1, 1e-4)
    error, torque = capsys.readouterr().err.splitlines()
    assert "error is up to 750.00 µm, at (60, 100) mm, 750 times" in error and "--margin" in error
    assert "torque is up to 1.15 N m, at (80, 100) mm, 28.7 times" in torque
    _say_leaps(machine, motion, run, off, 0.1, 3e-4)
    for line in capsys.readouterr().err.splitlines():
        assert "a count of the encoders is up to 300.00 µm" in line and "--margin" not in line


@pytest.mark.deep
def test_a_place_of_ones_own_and_degrees(drawing, tmp_path, capsys):
    options = [
        "--at",
        "0.02",
        "0.1",
        "--turn-deg",
        "90",
        "--scale",
        "0.5",
        "--angles",
        "deg",
        "--torque-limit",
        "20",
        "--reserve",
        "0.3",
    ]
    assert main(["draw", drawing, "--out", str(tmp_path), *options]) == 0
    notes = capsys.readouterr()
    assert "certified            yes" in notes.out and "the simulated" not in notes.err
    names, rows = table(tmp_path / "setpoints.csv")
    assert names[3] == "q1_deg"
    run = fb.Run.from_csv(tmp_path / "run.csv")
    xi = run.xi
    assert 14 < np.abs(run.tau).max() <= 20 and run.torque_limit == 20
    # Accelerations of hundreds of m/s^2 are held: the tracker's period, horizon and weights are of this motion.
    assert "tracker's period     0.5 ms" in notes.out and np.hypot(*run.error.T).max() < 5e-5
    np.testing.assert_allclose((xi.min(axis=0) + xi.max(axis=0)) / 2, (0.02, 0.1), atol=2e-4)
    assert (
        main(
            [
                "draw",
                drawing,
                "--out",
                str(tmp_path),
                *options,
                "--reserve",
                "0",
                "--period",
                "0.05",
            ]
        )
        == 0
    )
    assert "too fast for its tracker" in capsys.readouterr().err


@pytest.fixture
def two_strokes(tmp_path):
    text = "x,y,pen\n0,0,0\n0.01,0,1\n0.02,0,0\n0.02,0.01,1\n"
    (tmp_path / "strokes.csv").write_text(text, encoding="utf-8")
    return [
        str(tmp_path / "strokes.csv"),
        "--at",
        "0.02",
        "0.1",
        "--period",
        "0.02",
        "--rate",
        "100",
    ]


@pytest.mark.deep
def test_the_pen_has_time_and_setpoints_are_read_back(two_strokes, tmp_path, capsys):
    out = ["--out", str(tmp_path)]
    assert main(["draw", *two_strokes, *out, "--json"]) == 0
    fast = json.loads(capsys.readouterr().out)
    assert main(["draw", *two_strokes, *out, "--json", "--pen-time", "0.3"]) == 0
    slow = json.loads(capsys.readouterr().out)
    # Down, up, down, up: the last one is at the end.
    assert slow["duration_s"] == pytest.approx(fast["duration_s"] + 4 * 0.3, abs=1e-9)
    names, rows = table(tmp_path / "setpoints.csv")
    assert names[:8] == ["t", "x", "y", "q1", "q2", "q1_dot", "q2_dot", "pen"]
    t, xi, q_dot, pen = rows[:, 0], rows[:, 1:3], rows[:, 5:7], rows[:, 7]
    changes = np.flatnonzero(np.diff(pen)) + 1
    assert pen[0] == 1 and list(pen[changes]) == [0, 1, 0]
    # The robot rests for so long once the pen is told to move.
    for k in (0, *changes):
        rests = (t >= t[k]) & (t < t[k] + 0.29)
        assert not q_dot[rests].any() and np.ptp(xi[rests], axis=0).max() == 0
    motion = fb.from_csv(tmp_path / "setpoints.csv")
    assert (motion(t)[0] == xi).all()
    between = fb.Run.from_csv(tmp_path / "run.csv")
    inside = between.t < motion.duration
    away = motion(between.t[inside])[0] - between.xi_ref[inside]
    assert np.abs(away).max() < 1e-6  # accelerations of 0.5 m/s^2 jump between rows
    again = fb.TimedPath.from_csv(tmp_path / "setpoints.csv")
    assert (again(t)[0] == xi).all() and (again.pen(t) == pen).all()
    assert again.working == tuple(slow["working"]) and again.duration == t[-1]
    np.testing.assert_allclose(fb.igm(again.robot, again(t)[0], again.working).q, rows[:, 3:5])


@pytest.mark.deep
def test_strokes_begin_and_end_in_motion_with_leads(two_strokes, tmp_path, capsys):
    """v^2 / 2 a = 10 mm at 0.1 m/s and 0.5 m/s^2: after 12 mm the pen goes down at full speed."""
    out = ["--out", str(tmp_path), "--rate", "1000", "--json"]
    assert main(["draw", *two_strokes, *out]) == 0
    plain = json.loads(capsys.readouterr().out)
    assert main(["draw", *two_strokes, *out, "--lead", "0.012"]) == 0
    led = json.loads(capsys.readouterr().out)
    assert led["strokes"] == 2 and led["drawn_m"] == pytest.approx(plain["drawn_m"], abs=1e-12)
    assert led["max_error_m"] < 5e-5
    names, rows = table(tmp_path / "setpoints.csv")
    speed = np.hypot(*rows[:, [names.index("x_dot"), names.index("y_dot")]].T)
    pen = rows[:, names.index("pen")].astype(bool)
    edges = np.flatnonzero(np.diff(pen))
    assert not pen[0] and not pen[-1] and len(edges) == 4
    assert speed[edges] == pytest.approx(0.1, rel=0.02) and speed[[0, -1]].max() < 1e-9


@pytest.mark.deep
def test_all_of_the_page_is_in_the_workspace(tmp_path, capsys):
    (tmp_path / "corner.csv").write_text("x (mm),y (mm)\n5,5\n25,5\n25,15\n", "utf-8")
    command = ["draw", str(tmp_path / "corner.csv"), "--json", "--page", "0.09", "0.06"]
    command += ["--out", str(tmp_path), "--period", "0.02", "--rate", "100", "--turn-deg", "20"]
    assert main(command) == 0
    figures = json.loads(capsys.readouterr().out)
    page = np.array(figures["page"])
    first, along, _, up, _ = page
    assert np.hypot(*(along - first)) == pytest.approx(0.09)
    assert np.hypot(*(up - first)) == pytest.approx(0.06)
    # 0, 0 of the drawing is the page's lower left corner.
    _, rows = table(tmp_path / "setpoints.csv")
    x, y = (along - first) / 0.09, (up - first) / 0.06
    np.testing.assert_allclose(rows[0, 1:3], first + 0.005 * x + 0.005 * y, atol=1e-12)
    # All of it is 5 mm off singularities in the modes of the drawing, not only its rim.
    u, v = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 40))
    inside = first + u[..., None] * (along - first) + v[..., None] * (up - first)
    robot, working = fb.FiveBar(), figures["working"]
    assert fb.locus_distance(robot, inside.reshape(-1, 2), working)[0].min() > 0.005 - 1e-6
    assert len(set(np.unique(fb.igm(robot, inside, working).assembly))) == 1
    capsys.readouterr()
    assert main([*command, "--fit"]) == 0
    fitted = json.loads(capsys.readouterr().out)
    assert np.allclose(fitted["page"], page)
    assert fitted["drawn_m"] == pytest.approx(figures["drawn_m"] * 4.5, rel=1e-3)


@pytest.mark.deep
def test_counts_encoders_delay_and_backlash(two_strokes, tmp_path, capsys):
    options = ["--counts-per-turn", "4096", "--delay", "1", "--backlash", "0.004"]
    out = ["--out", str(tmp_path), "--angles", "counts"]
    assert main(["draw", *two_strokes, *out, "--json"]) == 2
    assert "--angles counts needs --counts-per-turn" in capsys.readouterr().err
    assert main(["draw", *two_strokes, *out, *options, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    names, rows = table(tmp_path / "setpoints.csv")
    assert names[3:5] == ["q1_counts", "q2_counts"]
    q = rows[:, 3:5]
    assert np.array_equal(q, np.round(q)) and q.dtype == float
    exact = fb.igm(fb.FiveBar(), rows[:, 1:3]).q
    np.testing.assert_allclose(q * 2 * np.pi / 4096, exact, atol=np.pi / 4096 * (1 + 1e-9))
    run = fb.Run.from_csv(tmp_path / "run.csv")
    steps = run.control.q * 4096 / (2 * np.pi)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert 2e-5 < figures["max_error_m"] < 1e-3
    # Both joints off by half of the backlash, against poses of such joints.
    tips = []
    for off in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        pose = fb.igm(fb.FiveBar(), run.xi_ref)
        shifted = fb.dgm(fb.FiveBar(), pose.q + 0.002 * np.array(off), pose.assembly)
        tips.append(np.linalg.norm(shifted.xi - pose.xi, axis=1))
    assert figures["backlash_error_m"] == pytest.approx(np.max(tips), rel=0.02)


@pytest.mark.deep
def test_the_constraints_of_a_file_are_kept(two_strokes, tmp_path, capsys):
    robot = fb.FiveBar()
    limits = fb.Constraints(joint_speed=0.1, half_planes=[(0.0, 1.0, 0.09)])
    fb.Machine(robot, constraints=limits).save(tmp_path / "robot.toml")
    drawn = ["draw", *two_strokes, "--robot", str(tmp_path / "robot.toml"), "--out", str(tmp_path)]
    assert main([*drawn, "--acceleration-limit", "1"]) == 0
    _, rows = table(tmp_path / "setpoints.csv")
    assert 0.09 < np.abs(rows[:, 5:7]).max() <= 0.1
    assert main([*drawn, "--at", "0.02", "0.09"]) == 1
    assert "violated by 0.005 m at" in capsys.readouterr().err


@pytest.mark.deep
def test_a_duration_asked_for_is_named_as_such(two_strokes, tmp_path, capsys):
    assert main(["draw", *two_strokes, "--duration", "20", "--out", str(tmp_path)]) == 0
    assert "20.0000 s, as asked for; the least is" in capsys.readouterr().out
    limits = ["--speed-limit", "0.1", "--duration", "20", "--out", str(tmp_path)]
    assert main(["draw", *two_strokes, *limits]) == 0
    assert "20.0000 s, as asked for\n" in capsys.readouterr().out
    assert main(["draw", *two_strokes, *limits, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lower_bound_s"] is None
    first = (tmp_path / "run.csv").read_text("utf-8").partition("\n")[0]
    assert len(first) < 1000


@pytest.mark.parametrize(
    "body, options, code, message",
    [
        (STROKES, ["--scale", "9"], 1, " mm, with scale 4.2"),
        (
            STROKES,
            ["--at", "0.2", "0.1"],
            1,
            "it leaves the workspace at (183.5, 111.5) mm, 0 mm along it (line 1)",
        ),
        (
            STROKES,
            ["--at", "0.05", "0.0", "--scale", "4"],
            1,
            "cannot be drawn there in working modes",
        ),
        (STROKES, ["--at", "0.05", "0.0", "--fit"], 2, "--fit chooses scale and place"),
        (STROKES, ["--page", "0.1", "0.1", "--at", "0", "0"], 2, "--page finds a place"),
        (STROKES, ["--at", "0", "0.1", "--margin", "0.01"], 2, "for which --margin looks"),
        (STROKES, ["--as-drawn", "--margin", "0.01"], 2, "--as-drawn keeps a drawing where it is"),
        (STROKES, ["--page", "0.02", "0.02"], 2, "not all on the page of 20 x 20 mm"),
        pytest.param(
            STROKES, ["--page", "0.3", "0.2"], 1, "300 x 200 mm is larger", marks=pytest.mark.deep
        ),
        (STROKES, ["--lead", "0.01", "--pen-time", "0.1"], 2, "--lead goes without --pen-time"),
        (
            STROKES,
            ["--format", "gcode", "--line-deviation", "0"],
            2,
            "fivebar: --line-deviation must be finite and > 0",
        ),
        (STROKES, ["--example"], 2, "draw needs one drawing: a file or --example"),
        (STROKES, ["--robot", "biglide"], 2, "a biglide's aspects have no ends"),
        ("<text>hi</text>", [], 2, "drawing.svg: nothing is drawn: <text> is not drawn (line 1)"),
        ('<path d="M0 0L1"/>', [], 2, "drawing.svg, line 1: <path>: d is not valid path data"),
    ],
)
def test_what_cannot_be_drawn_is_said(body, options, code, message, tmp_path, capsys):
    (tmp_path / "drawing.svg").write_text(SVG.format(body), encoding="utf-8")
    assert (
        main(["draw", str(tmp_path / "drawing.svg"), "--out", str(tmp_path / "out"), *options])
        == code
    )
    assert message in capsys.readouterr().err


@pytest.mark.deep
def test_a_path_of_two_modes_is_refused_or_crosses_type_2(tmp_path, capsys):
    """From the lab's home to its task 2: no working mode leads there without Type 2."""
    (tmp_path / "task_2.csv").write_text("x,y\n0.09,0.068\n0.07,0.034\n0.05,0\n", encoding="utf-8")
    options = ["--at", "0.07", "0.034", "--torque-limit", "0.02", "--out", str(tmp_path), "--json"]
    assert main(["draw", str(tmp_path / "task_2.csv"), *options]) == 1
    assert (
        "in working modes -1 -1: it meets Type 2 at (52.53, 4.304) mm, 73.9 mm along it (line 4)"
        in (capsys.readouterr().err)
    )
    (tmp_path / "proof.json").write_text("of an earlier drawing", encoding="utf-8")
    assert (
        main(["draw", str(tmp_path / "task_2.csv"), *options, "--through", "--working", "-1", "-1"])
        == 0
    )
    notes = capsys.readouterr()
    assert not (tmp_path / "proof.json").exists()
    figures = json.loads(notes.out)
    assert (
        figures["max_error_m"] < 5e-5
        and max(figures["peak_torque_Nm"]) <= 0.02
        and not figures["certified"]
    )
    run = fb.Run.from_csv(tmp_path / "run.csv")
    assert np.sign(fb.igm(run.robot, run.xi[[0, -1]]).det_A).tolist() == [1.0, -1.0]


@pytest.mark.deep
def test_plan_between_points(tmp_path, capsys):
    ends = ["--from", "0.09", "0.068", "--to", "0.05", "0"]
    assert main(["plan", *ends, "--duration", "4", "--out", str(tmp_path)]) == 0
    assert "Type 2 at about 3.0" in capsys.readouterr().out
    plan = fb.Plan.from_csv(tmp_path / "plan.csv")
    names, rows = table(tmp_path / "setpoints.csv")
    assert names[:7] == ["t", "x", "y", "q1", "q2", "q1_dot", "q2_dot"] and rows[-1, 0] == 4.0
    np.testing.assert_allclose(rows[:, 3:5], plan.joints(rows[:, 0])[0], atol=1e-9)
    assert (tmp_path / "plan.png").stat().st_size > 10_000


@pytest.mark.deep
def test_plan_in_the_frame_of_a_machine(tmp_path):
    machine = fb.Machine(fb.FiveBar(), (0.1, 0.2), frame=fb.Placement((0.3, 0.1), 0.5))
    machine.save(tmp_path / "robot.toml")
    ends = {name: machine.frame(xi) for name, xi in (("from", (0.09, 0.068)), ("to", (0.0, 0.1)))}
    words = ["plan", "--robot", str(tmp_path / "robot.toml"), "--out", str(tmp_path)]
    words += [word for name, (x, y) in ends.items() for word in (f"--{name}", str(x), str(y))]
    assert main([*words, "--duration", "2", "--rate", "100"]) == 0
    _, rows = table(tmp_path / "setpoints.csv")
    np.testing.assert_allclose(rows[[0, -1], 1:3], [*ends.values()], atol=1e-9)
    xi = fb.dgm(machine.robot, machine.angles(rows[:, 3:5]), -1).xi
    np.testing.assert_allclose(machine.frame(xi), rows[:, 1:3], atol=1e-9)


@pytest.mark.parametrize(
    "options, message",
    [
        ([], "minimum time needs a torque"),
        (["--duration", "-1"], "duration must be finite and > 0"),
        (["--working", "1", "1", "--to-working", "1", "1"], "--working keeps the modes"),
        (["--to-working", "1", "1", "--to", "0.5", "0.5"], "unreachable|out of reach"),
    ],
)
def test_plan_refuses(options, message, capsys):
    assert main(["plan", "--from", "0.09", "0.068", "--to", "0.05", "0.1", *options]) == 2
    err = capsys.readouterr().err
    assert any(words in err for words in message.split("|")), err


@pytest.mark.parametrize("controller", ["ctc", "pd", "mpc"])
def test_track_in_other_modes(controller, capsys):
    ends = [
        "--from",
        "0",
        "0.1",
        "--to",
        "0.03",
        "0.12",
        "--duration",
        "0.3",
        "--controller",
        controller,
    ]
    assert main(["track", *ends, "--working", "1", "-1", "--json"]) == 0
    error = {"ctc": 2e-3, "pd": 0.1, "mpc": 5e-5}[controller]  # the motion is a fast one: 2.3 m/s^2
    assert json.loads(capsys.readouterr().out)["max_error_m"] < error


def test_track_says_what_it_makes_of_a_file(tmp_path, capsys):
    (tmp_path / "corner.csv").write_text(
        "t [ms];X (mm);Y (mm)\n0;50;100\n500;60,5;100\n1000;60,5;110\n", encoding="utf-8"
    )
    assert main(["track", str(tmp_path / "corner.csv"), "--polyline", "1e-4"]) == 0
    err = capsys.readouterr().err
    assert "it leaves the chords between samples by up to" in err and "X (mm): read in mm" in err
    (tmp_path / "ms.csv").write_text(
        "t,x,y\n" + "\n".join(f"{10 * k},0.05,0.10{k}" for k in range(8)), encoding="utf-8"
    )
    assert main(["track", str(tmp_path / "ms.csv")]) == 2
    assert "is t in ms?" in capsys.readouterr().err
    assert main(["track", str(tmp_path / "ms.csv"), "--units", "t=ms"]) == 0


@pytest.mark.deep
def test_a_slow_motion_is_written_only_where_it_is_accepted(drawing, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fivebar.paths.timing.time_path.SLOW", 0.0)  # each motion counts as slow
    asked = ["draw", drawing, "--out", str(tmp_path / "out"), "--format", "gcode"]
    assert main(asked) == 1
    assert "fivebar: slow: the motion takes" in capsys.readouterr().err
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
    assert main([*asked, "--accept-slow"]) == 0
    assert "fivebar: slow: the motion takes" in capsys.readouterr().err
    assert (tmp_path / "out" / "drawing.nc").exists()


def test_a_limit_on_jerk_is_drawn_with_blends_whose_curvature_does_not_jump(tmp_path, capsys):
    body = '<path d="M0 0H20V20M0 20H11A9 9 0 0 0 20 11" fill="none" stroke="red"/>'
    (tmp_path / "drawing.svg").write_text(SVG.format(body), encoding="utf-8")
    machine = fb.Machine(fb.FiveBar(), constraints=fb.Constraints(acceleration=4.0, jerk=20.0))
    machine.save(tmp_path / "robot.toml")
    asked = ["draw", str(tmp_path / "drawing.svg"), "--robot", str(tmp_path / "robot.toml")]
    assert main([*asked, "--format", "gcode", "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr()
    assert "s leaves the limit on jerk out" in printed.err
    assert "s; without the limit on jerk the least is" in printed.out
    assert (tmp_path / "out" / "drawing.nc").exists()
    assert main([*asked, "--deviation", "0", "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert ", line 1, joint C at" in error and "frame: with a deviation" in error


def test_as_drawn_keeps_the_coordinates_of_the_file(tmp_path, monkeypatch, capsys):
    """The set-points, in the measuring frame, are the file's own points."""
    (tmp_path / "line.csv").write_text("x_mm,y_mm\n-10,60\n20,70\n", encoding="utf-8")
    robot = tmp_path / "robot.toml"
    machine = fb.Machine(fb.FiveBar(), frame=fb.Placement((0.03, -0.05), 0.4, 1.01))
    machine.save(robot)
    words = ["draw", str(tmp_path / "line.csv"), "--as-drawn", "--out", str(tmp_path)]
    monkeypatch.setattr("fivebar.cli.draw.LARGE_ERROR", 0.0)  # each error counts as large
    assert main([*words, "--robot", str(robot), "--rate", "50"]) == 0
    told = capsys.readouterr()
    assert "middle of it         (5, 65) mm" in told.out
    assert "the simulated error is up to " in told.err
    text = (tmp_path / "setpoints.csv").read_text("utf-8").splitlines()
    rows = np.array([line.split(",")[1:3] for line in text if line[0].isdigit()], float)
    np.testing.assert_allclose(rows[[0, -1]], [(-0.01, 0.06), (0.02, 0.07)], atol=1e-9)
    for other in (["--at", "0", "0.1"], ["--turn-deg", "3"], ["--fit"]):
        assert main([*words, *other]) == 2
        assert "--as-drawn keeps a drawing where it is: it goes without" in capsys.readouterr().err


def test_what_is_in_the_way_is_said_of_the_modes_that_come_nearest(tmp_path, capsys):
    """In modes +1 -1 one joint is a little off its range; in the others both are far off."""
    (tmp_path / "line.csv").write_text("x_mm,y_mm\n-20,150\n20,150\n", encoding="utf-8")
    robot = fb.FiveBar(0.1, 0.15, 0.1, 0.15, 0.08)
    q = fb.igm(robot, [(-0.02, 0.15), (0.0, 0.15), (0.02, 0.15)], (1, -1)).q
    joints = [(each.min() + 0.05, each.max() + 0.1) for each in q.T]
    fb.Machine(robot, constraints=fb.Constraints(joints=joints)).save(tmp_path / "robot.toml")
    words = ["draw", str(tmp_path / "line.csv"), "--as-drawn", "--out", str(tmp_path)]
    assert main([*words, "--robot", str(tmp_path / "robot.toml")]) == 1
    said = capsys.readouterr().err
    assert "in working modes +1 -1: " in said and "is violated by 0.05 rad at" in said


def test_nothing_is_written_where_a_drive_cannot_go_there(tmp_path, capsys):
    words = ["draw", "--example", "--robot", "plotclock", "--fit", "--out", str(tmp_path / "out")]
    assert main([*words, "--drive", "dynamixel"]) == 2
    assert "give another zero (--zero-counts), or wrap=True (--wrap)" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("ratio", [(np.pi / 180, -np.pi / 180), (2 * np.pi / 4096,) * 2])
def test_gcode_of_a_robot_whose_drives_read_degrees_or_counts(ratio, tmp_path, capsys):
    """The axes are what the drives read, as the replay in the robot's angles says."""
    robot = tmp_path / "robot.toml"
    measured = ((-1, -1, int(fb.igm(fb.FiveBar(), (0.06, 0.07)).assembly)),)
    fb.Machine(fb.FiveBar(), offset=(0.1, 0.2), ratio=ratio, measured=measured).save(robot)
    (tmp_path / "line.csv").write_text("x_mm,y_mm\n60,70\n90,68\n", encoding="utf-8")
    words = ["draw", str(tmp_path / "line.csv"), "--as-drawn", "--format", "gcode", "--json"]
    assert (
        main([*words, "--robot", str(robot), "--out", str(tmp_path), "--working", "-1", "-1"]) == 0
    )
    told = json.loads(capsys.readouterr().out)
    assert told["max_error_m"] < 2e-5 and told["measured_modes"] is True
    names = [Path(file).name for file in told["files"]]
    assert names == ["drawing.png", "drawing.nc", "proof.json"]
    lines = (tmp_path / "drawing.nc").read_text("utf-8").splitlines()
    last = [line for line in lines if line.startswith("G1")][-1]
    axes = [float(word[1:]) for word in last.split()[1:3]]
    q = np.array(axes) * ratio + (0.1, 0.2)
    np.testing.assert_allclose(fb.dgm(fb.FiveBar(), q).xi, (0.09, 0.068), atol=2e-5)
