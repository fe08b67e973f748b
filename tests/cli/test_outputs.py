"""What commands print and write, against Python's own functions and the files themselves."""

import csv
import datetime
import json
import os
import sys
import warnings
from argparse import ArgumentParser, Namespace
from copy import copy
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from urllib.request import urlopen

import numpy as np
import pytest

import fivebar as fb
from fivebar.amoro.ros_free.tracking import words as tracking_words
from fivebar.cli import calibrate as calibrate_command
from fivebar.cli import draw, draw_place, grade, grade_folder, main, mark, track
from fivebar.cli import linkage as linkage_command
from fivebar.cli import map as map_command
from fivebar.grading.course.settings import Settings
from fivebar.grading.intake.cohort_folder import HandIn
from fivebar.grading.intake.hand_in import Left, ProgramFile
from fivebar.grading.labs import find_lab
from fivebar.linkages import Study
from fivebar.linkages.quantities import unit as unit_of
from fivebar.planning.plan import LEAST_SIN
from fivebar.simulation.comparison import Comparison
from fivebar.visualization.style import length, of_unit

ROBOT = fb.FiveBar()
LINE = "track --from 0.09 0.068 --to 0.08 0.075 --duration 0.1"
FOUR_BAR = "linkage four-bar 0.2 0.06 0.16 0.14"
MODES = [(a, b) for a in (-1, 1) for b in (-1, 1)]


class Reached(Exception):
    """The function that does the work was called."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def ran(here, capsys):
    """The output of a command that ends with a code."""

    def run(words, code=0):
        assert main(words.split()) == code
        return capsys.readouterr()

    return run


@pytest.fixture
def given(monkeypatch):
    """Let a function be reached, and no further; return what it is given, by name or place."""

    def watch(function):
        found = {}

        def reached(*places, **names):
            found.update(enumerate(places), **names)
            raise Reached

        monkeypatch.setattr(f"fivebar.{function}", reached)
        return found

    return watch


@pytest.fixture
def unplotted(monkeypatch):
    """Pictures that take half a second each are files with one word."""

    def plot(self, path, **style):
        Path(path).write_text("picture", "utf-8")

    for kind in (fb.Run, fb.Plan, fb.Calibration, Comparison):
        monkeypatch.setattr(kind, "plot", plot)
    monkeypatch.setattr(fb.Run, "animate", plot)

    monkeypatch.setattr(draw, "_picture", lambda *_: None)
    monkeypatch.setattr(draw, "saved", plot)


def rows_of(text):
    """{name: value} of what a command prints in two columns."""
    rows = (line.strip().partition("  ") for line in text.splitlines() if line.startswith("  "))
    return {name: value.strip() for name, _, value in rows}


def table_of(file):
    """Names of the columns and rows of a CSV whose first line tells of the robot."""
    lines = [line for line in Path(file).read_text("utf-8").splitlines() if line[0] != "#"]
    return lines[0].split(","), np.array([line.split(",") for line in lines[1:]], float)


def with_line(folder):
    (folder / "line.csv").write_text("x_mm,y_mm\n-10,60\n20,70\n", "utf-8")


# track


def test_a_tracks_table_is_of_its_run(ran, unplotted):
    told = ran(f"{LINE} --torque-limit 0.02 --out out --page page.html").out
    files = [str(Path("out", name)) for name in ("run.csv", "tracking.png", "animation.html")]
    assert told.splitlines()[-4:] == [*files, "page.html"] and all(map(Path, files))
    assert (
        "<svg" in Path("page.html").read_text("utf-8") and Path(files[1]).read_text() == "picture"
    )
    run = fb.Run.from_csv(files[0])
    size = np.linalg.norm(run.error, axis=1)
    rows = rows_of(told)
    assert rows["largest error"] == length(size.max())
    assert rows["RMS error"] == length(np.sqrt(np.mean(size**2)))
    assert rows["error at the end"] == length(size[-1])
    left, right = 1e3 * np.abs(run.q_error).max(axis=0)
    assert rows["largest joint error"] == f"{left:.4f}, {right:.4f} mrad"
    assert rows["peak torque"] == "20.000, 20.000 mN m"
    share = np.mean((np.abs(run.tau[:-1]) >= 0.02 - 1e-12).any(axis=1))
    assert rows["saturated"] == f"{100 * share:.3g} % of the time" and share > 0
    assert "saturated" not in rows_of(ran(f"{LINE} --torque-limit 20").out)
    assert rows["real-time factor"].endswith(" ×")


def test_folders_of_files_to_be_written_are_made(ran, unplotted):
    ran(f"{LINE} --out both --page both/page.html")
    ran(f"{FOUR_BAR} --csv new/in/table.csv --plot ./four.png")
    assert Path("both/page.html").is_file() and Path("new/in/table.csv").is_file()


def test_crossings_of_a_track_are_said(capsys):
    figures = dict.fromkeys(("max_error_m", "rms_error_m", "final_error_m"), 1e-5)
    figures |= {"max_joint_error_m": [1e-5, 2e-5], "peak_force_N": [1.5, 0.25]}
    figures |= {"singularity_crossings": [[1.25, 2]], "real_time_factor": 3.4}
    track._print_table(fb.Biglide(), figures)
    rows = rows_of(capsys.readouterr().out)
    assert rows["crossing"] == "Type 2 at 1.250000 s" and "saturated" not in rows
    assert rows["peak force"] == "1500.000, 250.000 mN"
    assert rows["largest joint error"] == "0.0100, 0.0200 mm" and rows["real-time factor"] == "3 ×"


def test_a_comparison_is_printed_and_written(ran, unplotted, monkeypatch):
    line = fb.line((0.09, 0.068), (0.08, 0.075), 0.1)
    runs = {
        name: fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, kp, 20), line)
        for name, kp in (("ctc", 100), ("stiff", 400))
    }
    monkeypatch.setattr("fivebar.study.control_cases.run_case", lambda name: runs)
    told = ran("track --case mass --out out --page page.html").out.splitlines()
    files = [str(Path("out", name)) for name in ("comparison.png", "ctc.csv", "stiff.csv")]
    assert told == [
        "task 1, mass 20 % larger than known",
        *str(fb.compare(runs)).splitlines(),
        *files,
        "page.html",
    ]
    assert Path(files[0]).read_text() == "picture" and "<svg" in Path("page.html").read_text()
    for file, run in zip(files[1:], runs.values()):
        np.testing.assert_allclose(fb.Run.from_csv(file).xi, run.xi, atol=1e-12)


@pytest.mark.parametrize(
    "words, kind, kp, kd",
    [
        ("", fb.ComputedTorque, 100.0, 20.0),
        ("--controller pd", fb.PD, 0.4, 0.08),
        ("--controller pd --working 1 -1", fb.PD, 0.4, 0.08),
        ("--controller pd --robot biglide", fb.PD, 250.0, 50.0),
        ("--controller ctc --working 1 -1 --kd 9", fb.ComputedTorque, 100.0, 9.0),
    ],
)
def test_gains_and_modes_of_a_controller(words, kind, kp, kd, here, given):
    simulated = given("simulation.simulate.simulate")
    ends = "--from 0 0 --to 0.1 0" if "biglide" in words else "--from 0.01 0.1 --to 0.02 0.11"
    with pytest.raises(Reached):
        main(["track", *ends.split(), "--duration", "0.5", *words.split()])
    robot, controller, reference = (simulated[k] for k in range(3))
    start = simulated["start"].pose
    assert tuple(start.working) == ((1, -1) if "1 -1" in words else (-1, -1))
    assert type(controller) is kind and robot == start.robot
    assert np.all(controller.kp == kp) and np.all(controller.kd == kd)
    held = controller(0.0, start.q, 0 * start.q, reference)
    tau = fb.inverse_dynamics(fb.ikm2(simulated["start"], (0.0, 0.0)))
    assert np.abs(held - tau).max() < 1e-9


# plan


def test_a_plans_table_is_of_its_files(ran, here, unplotted):
    fb.Machine(ROBOT, frame=fb.Placement((0.1, 0.2))).save(here / "robot.toml")
    ends = "--from 0.1 0.3 --to 0.1 0.3 --from-working -1 -1 --to-working -1 1 --robot robot.toml"
    told = ran(f"plan {ends} --duration 2 --out out --rate 50 --angles deg").out
    files = [str(Path("out", name)) for name in ("plan.csv", "plan.png", "setpoints.csv")]
    assert told.splitlines()[-3:] == files
    plan = fb.Plan.from_csv(files[0])
    assert Path(files[1]).read_text() == "picture"
    rows = rows_of(told)
    t = np.linspace(0.0, 2.0, 4001)
    left, right = 1e3 * np.abs(plan.torques(t)).max(axis=0)
    assert rows["peak torque"] == f"{left:.3f}, {right:.3f} mN m" and rows["duration"] == "2 s"
    assert rows["modes at the end"] == "-1, +1" and rows["objective"].endswith(" (SI)")
    assert rows["solved"].startswith(f"on {len(plan.pieces.xi)} intervals in ")
    assert rows["robot's own frame"] == f"{files[0]}, {files[1]}" and "points" in rows
    crossings = [line.split() for line in told.splitlines() if "crossing" in line]
    margins = {1: lambda pose: np.min(np.abs(pose.sines)), 2: lambda pose: abs(pose.det_A)}
    assert {words[2] for words in crossings} == {"1", "2"}
    times = [float(words[-2]) for words in crossings]
    assert times == sorted(times)
    for words, time in zip(crossings, times):
        assert margins[int(words[2])](plan.accelerations(time).rates.pose) < 0.01
    names, setpoints = table_of(files[2])
    assert names[3:5] == ["q1_deg", "q2_deg"] and np.allclose(np.diff(setpoints[:, 0]), 0.02)
    xi = fb.dgm(ROBOT, np.deg2rad(setpoints[0, 3:5]), -1).xi
    np.testing.assert_allclose(xi, (0.0, 0.1), atol=1e-6)
    np.testing.assert_allclose(setpoints[0, 1:3], (0.1, 0.3), atol=1e-9)


def test_a_plan_for_a_tool_bounds_no_joint_in_its_place(here, capsys):
    fb.Machine(ROBOT, tool=fb.Tool(1, 0.02)).save(here / "robot.toml")
    ends = "plan --from 0.05 0.09 --to 0.06 0.09 --robot robot.toml --duration 1"
    for words, message in (
        ("--workspace 0 0.1 0 0.2", "--workspace is of joint C, not of the tool"),
        ("--acceleration-limit 2", "--acceleration-limit is of joint C, not of the tool"),
        ("--from-working 1 1", "give --from-working and --to-working both"),
        ("--to-working 1 1", "give --from-working and --to-working both"),
        ("--from-working 1 1 --to-working 1 1 --via 0.05 0.1", "--via with --working only"),
        ("--via 0.05", "--via takes pairs X Y"),
    ):
        assert main([*ends.split(), *words.split()]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.parametrize("modes", ["--working 1 -1", "--from-working 1 -1 --to-working 1 -1"])
def test_points_of_a_plan_are_the_tools(modes, here, given, capsys):
    limits = fb.Constraints(torque=0.5, acceleration=4.0)
    frame = fb.Placement((0.1, 0.0), 0.3)
    machine = fb.Machine(ROBOT, tool=fb.Tool(1, 0.02), frame=frame, constraints=limits)
    machine.save(here / "robot.toml")
    planned = given("planning.plan.plan")
    via = "--via 0.15 0.1" if modes.startswith("--working") else ""
    ends = f"plan --from 0.14 0.11 --to 0.16 0.1 --robot robot.toml --duration 1 {via} {modes}"
    with pytest.raises(Reached):
        main(ends.split())
    points = [(0.14, 0.11), (0.16, 0.1), (0.15, 0.1)]
    start, goal, passed = (machine.joint(point, (1, -1)) for point in points)
    assert planned[1].xi == pytest.approx(start) and planned[2].xi == pytest.approx(goal)
    assert tuple(planned[1].working) == tuple(planned[2].working) == (1, -1)
    assert [p.tolist() for _, p in planned["via"]] == ([pytest.approx(passed)] if via else [])
    assert planned["constraints"].sin == (LEAST_SIN if via else 0.0)
    assert planned["objective"] == "effort"
    # A limit on the tool's acceleration would silently be kept by joint C in its place.
    assert planned["constraints"].acceleration is None and planned["constraints"].torque[0] == 0.5
    assert "robot.toml: plan leaves out acceleration: it is the tool's" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command, function",
    [
        ("track {}", "simulation.simulate.simulate"),
        ("map --nodes 5 --path {}", "constraints.path_check.check_path"),
        ("certify {}", "paths.certificates.certify.certify"),
        ("draw --as-drawn {}", "constraints.path_check.check_path"),
    ],
)
def test_points_of_a_plan_are_read_as_those_of_joint_c(command, function, here, given, capsys):
    """In the robot's own frame, where other files have a tool's in the measuring frame."""
    frame = fb.Placement((0.1, 0.0), 0.3)
    fb.Machine(ROBOT, tool=fb.Tool(1, 0.02), frame=frame).save(here / "robot.toml")
    t = np.linspace(0.0, 1.0, 7)
    rows = [f"{each},{0.05 + 0.01 * each},{0.09}" for each in t]
    head = '# fivebar plan, SI units: {"robot": {}}\nt,x,y'
    (here / "plan.csv").write_text("\n".join([head, *rows]), "utf-8")
    found = given(function)
    with pytest.raises(Reached):
        main([*command.format("plan.csv").split(), *"--robot robot.toml --working -1 -1".split()])
    path = found[2 if function.endswith("simulate") else 1]
    if function.endswith("certify"):
        path = found[0].led(found[1], (-1, -1))
    assert path(0.0)[0] == pytest.approx((0.05, 0.09))
    words = "plan.csv: its points are of joint C, in the robot's own frame, as its first line says"
    assert words in capsys.readouterr().err


# draw


def massless(folder):
    """A robot that is not simulated, which takes a second."""
    with_line(folder)
    (folder / "robot.toml").write_text("zz1 = 0\nzz2 = 0\nm = 0.5\n", "utf-8")
    return "draw line.csv --robot robot.toml --rate 50 --out out"


def test_a_drawing_lies_where_it_is_put(ran, here, unplotted):
    words = f"{massless(here)} --at 0.01 0.1 --turn-deg 90 --scale 0.5"
    told = ran(f"{words} --angles counts --counts-per-turn 4096 --pen-time 0.2")
    files = [str(Path("out", name)) for name in ("drawing.png", "setpoints.csv", "proof.json")]
    assert told.out.splitlines()[-3:] == files and "it has no inertia" in told.err
    names, rows = table_of(files[1])
    # Turned to the left by a right angle, 30 mm and 10 mm become -5 mm and 15 mm of half the size.
    np.testing.assert_allclose(rows[0, 1:3], (0.0125, 0.0925), atol=1e-9)
    np.testing.assert_allclose(rows[-1, 1:3], (0.0075, 0.1075), atol=1e-9)
    assert names[3:5] == ["q1_counts", "q2_counts"]
    q = fb.igm(ROBOT, rows[:, 1:3]).q
    np.testing.assert_allclose(rows[:, 3:5], 4096 * q / (2 * np.pi), atol=0.5 + 1e-9)
    rests = np.isclose(rows[:, 1:3], rows[0, 1:3]).all(axis=1)
    assert rows[rests, 0].max() == pytest.approx(0.2, abs=0.021)
    rows = rows_of(told.out)
    assert rows["drawn"] == f"{500 * np.hypot(0.03, 0.01):.4g} mm in 1 strokes"
    assert rows["middle of it"] == "(10, 100) mm" and rows["certified"] == "yes, proof.json"


def test_a_drawing_is_certified_where_it_is_proved(ran, here, unplotted):
    words = f"{massless(here)} --as-drawn --json"
    for tolerance, certified in (("1e-5", True), ("0.02", False)):
        told = ran(f"{words} --tolerance {tolerance}")
        figures = json.loads(told.out)
        assert figures["certified"] is certified and figures["measured_modes"] is None
        assert (
            ("out/proof.json" in figures["files"]) == Path("out/proof.json").exists() == certified
        )
        stretch = "line.csv: from s = 0 to 31.6228 mm not proved: "
        assert (stretch in told.err) != certified
    margin = fb.check_path(ROBOT, fb.path("line.csv").at_unit_speed).min_margin
    assert figures["smallest_margin"] == pytest.approx(margin)


def test_drives_get_a_file_in_their_own_counts(ran, here, unplotted):
    words = f"{massless(here)} --as-drawn --drive 4096"
    ran(f"{words} --zero-counts 100 -200 --wrap")
    _, rows = table_of("out/setpoints.csv")
    with open("out/drives.csv", encoding="utf-8") as file:
        table = [row for row in csv.reader(file) if row[0][:1].isdigit()]
    counts = 4096 * rows[:, 3:5] / (2 * np.pi) + (100, -200)
    off = np.array(table, float)[:, 1:3] - counts
    np.testing.assert_allclose(off, 4096 * np.round(off / 4096), atol=0.5 + 1e-6)
    # Of counts a turn nothing is asked but the resolution, where the angles are not in counts.
    told = ran(f"{words} --binary --counts-per-turn 4096")
    np.testing.assert_allclose(table_of("out/setpoints.csv")[1], rows)
    assert str(Path("out", "drives.bin")) in told.out.splitlines()
    assert len(Path("out/drives.bin").read_bytes()) % 4 == 0
    assert "fivebar: " in ran(f"{words[:-4]}none", 2).err


def test_a_page_is_placed_as_a_whole(monkeypatch, here):
    """Its corners are fitted in, not the drawing; 5 mm off singularities, or a tenth of a bar."""
    asked = []
    placement = fb.Placement((0.1, 0.2), 0.3, 2.0)

    def fitted_in(robot, whole, turn, scale, working, kept, tool, measured):
        asked.append((whole, turn, scale, kept.clearance))
        aspect = SimpleNamespace(working=(1, -1))
        return SimpleNamespace(aspect=aspect, placement=placement, scale=3.0)

    monkeypatch.setattr("fivebar.paths.placing.fitting_in.fitted_in", fitted_in)
    path = fb.path([(0.01, 0.005), (0.03, 0.015)])
    options = dict.fromkeys(("at", "as_drawn", "fit", "page", "scale", "margin", "working"))
    options |= {"turn_deg": 90.0, "file": "line.csv", "parser": ArgumentParser()}
    machine = fb.Machine(fb.FiveBar(l11=0.08))
    page = {"page": (0.09, 0.06)}
    for more, scale, clearance in (
        ({}, 1.0, 0.005),
        ({"scale": 2.0, "margin": 0.02}, 2.0, 0.02),
        ({"fit": True}, None, 0.008),
        (page, 1.0, 0.005),
        (page | {"fit": True}, 1.0, 0.005),
    ):
        put, working, known, corners = draw_place.placed(Namespace(**options | more), machine, path)
        whole, turn, given_scale, kept = asked.pop()
        assert (given_scale, kept) == (scale, clearance) and turn == pytest.approx(np.pi / 2)
        assert working == (1, -1) and known == 3.0
        if "page" not in more:
            np.testing.assert_allclose(put.pieces[0].end, placement(np.array([0.03, 0.015])))
            assert whole is path and corners is None
            continue
        sheet = np.array([(0, 0), (0.09, 0), (0.09, 0.06), (0, 0.06), (0, 0)])
        np.testing.assert_allclose([piece.end for piece in whole.pieces], sheet[1:])
        np.testing.assert_allclose(corners, placement(sheet))
        # The drawing, 20 x 10 mm, is as wide as the page, in its middle, or at its lower left.
        ends = ((0.0, 0.0075), (0.09, 0.0525)) if "fit" in more else ((0.01, 0.005), (0.03, 0.015))
        found = put.pieces[0].start, put.pieces[0].end
        np.testing.assert_allclose(found, placement(np.array(ends)), atol=1e-12)
    with pytest.raises(fb.base.errors.UsageError, match=r"\[50. 25.\] and \[150.  75.\] mm"):
        draw_place.placed(Namespace(**options | page | {"scale": 5.0}), machine, path)


def test_motors_keep_a_share_in_reserve(monkeypatch, capsys):
    asked = []

    def timed(robot, path, duration, constraints, working):
        asked.append(constraints)
        return SimpleNamespace(gap=0.5, duration=2.0, lower_bound=1.0)

    monkeypatch.setattr("fivebar.paths.timing.time_path.time_path", timed)
    monkeypatch.setattr("fivebar.paths.timing.time_path.slowness", lambda motion: "so slow")
    names = "torque_limit speed_limit acceleration_limit joint_speed_limit duration motor".split()
    options = dict.fromkeys(names) | {"reserve": 0.25, "accept_slow": True}
    motor = fb.Motor(2.0, 10.0, largest_torque=1.5, gear=2.0, efficiency=0.8)
    machine = fb.Machine(ROBOT, constraints=fb.Constraints(motors=motor))
    _, drives = draw._timed(Namespace(**options), machine, None, (1, -1))
    (kept,) = asked
    assert kept.torque == pytest.approx((0.75 * motor.torque,) * 2)
    for weak in kept.motors:
        assert weak.torque == pytest.approx(0.75 * motor.torque)
        speeds = np.linspace(-2, 2, 41) * motor.speed
        kept = np.stack(weak.bounds(speeds)) / motor.stall + speeds / motor.speed
        # A quarter of the line on both sides of it, also where the joint outruns the motor.
        free = np.abs(np.stack(weak.bounds(speeds))) < weak.torque * (1 - 1e-9)
        assert np.abs(kept[free]).max() == pytest.approx(0.75)
    assert drives.motors == (motor, motor) and drives.torque == pytest.approx((motor.torque,) * 2)
    assert capsys.readouterr() == ("", "fivebar: slow: so slow\n")
    with pytest.raises(ValueError, match="slow: so slow. Nothing is written without"):
        draw._timed(Namespace(**options | {"accept_slow": False}), machine, None, (1, -1))
    # Without limits the pen has usual ones; with a speed alone, the usual acceleration.
    for limit, expected in ((None, (0.5, 0.1)), (0.03, (0.5, 0.03))):
        asked.clear()
        draw._timed(Namespace(**options | {"speed_limit": limit}), fb.Machine(ROBOT), None, None)
        assert (asked[0].acceleration, asked[0].speed) == expected


@pytest.mark.parametrize(
    "words, message",
    [
        ("--counts-per-turn 0", "--counts-per-turn must be finite and > 0"),
        ("--pen-time -1", "--pen-time must be finite and >= 0"),
        ("--lead -1", "--lead must be finite and > 0"),
        ("--backlash -1", "--backlash must be finite and >= 0"),
        ("--angles counts", "--angles counts needs --counts-per-turn"),
        ("--zero-deg 0 0", "--zero-deg goes with --format gcode"),
        ("--lead 0.01 --format gcode", "--lead goes without --pen-time and --format gcode"),
        (
            "--format gcode --steps-per-turn 9 --mm-per-turn 9",
            "--steps-per-turn and --mm-per-turn: the axes are in steps or in mm",
        ),
        ("--as-drawn --reserve 1", "--reserve must be from 0 to below 1, not 1"),
        ("--as-drawn --turn-deg 3", "--as-drawn keeps a drawing where it is: it goes without --at"),
        ("--delay -1 --as-drawn", "delay"),
    ],
)
def test_options_of_a_drawing_that_cannot_be(words, message, here, capsys):
    with_line(here)
    assert main(["draw", "line.csv", *words.split()]) == 2
    assert message in capsys.readouterr().err.splitlines()[-1]


def test_axes_of_gcode_are_those_of_the_options(here, given):
    with_line(here)
    dialect = given("exporters.gcode.Gcode")
    words = "draw line.csv --format gcode --firmware linuxcnc --axes A B --mm-per-turn 40 --gear 3"
    words += " --feed units --max-feed 900 --pen Z --pen-values -1 2 --approach-deg 90"
    with pytest.raises(Reached):
        main([*words.split(), "--line-deviation", "1mm", "--speed-error", "0.02"])
    assert dialect == {
        "axes": ("A", "B"),
        "deviation": 1e-3,
        "feed": "units",
        "max_feed": 900.0,
        "pen": "Z",
        "firmware": "linuxcnc",
        "gear": 3.0,
        "speed_error": 0.02,
        "unit": "mm",
        "per_turn": 40.0,
        "down": -1.0,
        "up": 2.0,
        "approach": pytest.approx(np.pi / 2),
    }


# map


@pytest.fixture
def pictured(monkeypatch):
    """What the picture of a map is given; none is drawn."""
    found = {}

    def picture(data, points, regions, **style):
        found.update(style, data=data, points=points, regions=regions)

    monkeypatch.setattr("fivebar.visualization.plot.maps.singularity_map", picture)
    monkeypatch.setattr("fivebar.visualization.plot.panels.in_frame", lambda *given: given[2])
    monkeypatch.setattr(map_command, "saved", lambda what, path: found.update({str(path): what}))
    return found


def fake_parts(monkeypatch):
    """Discs and rectangles whose sizes are those of their regions' numbers."""

    def rectangle(part, margin, ratio=2.0):
        found.append((part.number, ratio))
        width = 0.01 * part.number
        return SimpleNamespace(x_min=0.0, x_max=width, y_min=0.1, y_max=0.1 + width / ratio)

    def disc(part, margin):
        return SimpleNamespace(radius=1e-3 * part.number, center=(0.02, 0.1))

    found = []
    monkeypatch.setattr("fivebar.constraints.rectangle.largest_rectangle", rectangle)
    monkeypatch.setattr("fivebar.constraints.disc.largest_disc", disc)
    return found


@pytest.mark.parametrize(
    "words, working", [("--space joint", None), ("", None), ("--working 1 -1", (1, -1))]
)
def test_a_board_is_looked_for_in_the_modes_asked_for(ran, pictured, monkeypatch, words, working):
    asked = fake_parts(monkeypatch)
    assert "a board of" in ran(f"map --nodes 3 --fits 0.15 0.05 --out map.png {words}").out
    numbers = [part.number for part in fb.aspects(ROBOT) if working in (None, part.working)]
    assert [number for number, _ in asked] == numbers


def test_a_maps_table_names_what_fits(ran, here, pictured, monkeypatch):
    asked = fake_parts(monkeypatch)
    fb.Machine(ROBOT, frame=fb.Placement((0.0, 0.0), np.pi / 6)).save(here / "robot.toml")
    words = "map --nodes 3 --robot robot.toml --fits 0.15 0.05 --out map.png"
    told = ran(f"{words} --sin 0.3").out.splitlines()
    regions = fb.dexterous(ROBOT, sin=0.3)
    count = len(regions)
    assert [each.area for each in pictured["regions"]] == [each.area for each in regions]
    assert pictured["map.png"] == 1e3
    assert [number for number, _ in asked[1:]] == [each.number for each in regions]
    assert [ratio for _, ratio in asked[1:]] == pytest.approx([3.0] * count)
    for name, parts in (("aspect", fb.aspects(ROBOT)), ("region", regions)):
        begin = next(k for k, line in enumerate(told) if line.startswith(name))
        for part, line in zip(parts, told[begin + 1 :]):
            signs = "".join("+" if mode > 0 else "-" for mode in part.working)
            sign = "+" if part.assembly > 0 else "-"
            assert line.split() == [str(part.number), signs, sign, f"{1e6 * part.area:.4f}"]
    *_, disc, rectangle, board, file = told
    x, y = 1e3 * np.array([0.02 * np.cos(np.pi / 6) - 0.05, 0.01 + 0.1 * np.cos(np.pi / 6)])
    about = f"about ({x:.4g}, {y:.4g}) mm, in region {count}"
    assert disc == f"largest disc: radius {count:.4f} mm {about}"
    corner = f"its lower left corner at (-50, {100 * np.cos(np.pi / 6):.4g}) mm"
    turned = "turned by 30° as the robot"
    sides = f"{10 * count} x {5 * count} mm"
    assert rectangle == f"largest rectangle in it: {sides}, {corner}, {turned}"
    sides = f"{10 * count} x {10 * count / 3:.4g} mm"
    scale = f"scale {count / 15:.4g}, in region {count}"
    begin = "a board of 150 x 50 mm does not fit: the largest of its shape is"
    assert board == f"{begin} {sides}, {corner}, {turned}, {scale}" and file == "map.png"
    found = json.loads(ran(f"{words} --json").out)
    assert found["board"]["in"] == "aspect" and "regions" not in found and not found["path"]
    listed = [
        (part["number"], part["area_m2"], tuple(part["working"])) for part in found["aspects"]
    ]
    assert listed == [(part.number, part.area, part.working) for part in fb.aspects(ROBOT)]
    corner = found["board"]["corner_m"]
    assert corner == pytest.approx([-0.05, 0.1 * np.cos(np.pi / 6)])
    place = fb.Placement((0.0, 0.0), np.pi / 6)(fb.aspects(ROBOT)[0].point)
    assert found["aspects"][0]["point_m"] == pytest.approx(place.tolist())


def test_a_map_has_one_unit_that_fits_the_robot(ran, here, pictured, monkeypatch):
    """Robots of one shape: the same numbers, in µm and in m."""
    fake_parts(monkeypatch)
    told = {}
    for unit in ("um", "m"):
        bars = f"--l11 10{unit} --l12 12{unit} --l21 9{unit} --l22 11{unit} --d 7{unit}"
        told[unit] = ran(f"map --nodes 3 --fits 0.15 0.05 --out map.png {bars}").out
    assert pictured["map.png"] == 1.0
    small, large = (told[unit].splitlines() for unit in told)
    assert small[0].endswith("area (µm²)") and large[0].endswith("area (m²)")
    assert small[3] == large[3] == "     3       +-         -     1025.3574"
    assert small[1:11] == large[1:11]
    assert "a board of 1.5e+05 x 5e+04 µm" in told["um"] and "of 0.15 x 0.05 m " in told["m"]
    ran(f"map --nodes 3 --unit µm --out map.png {bars}")
    assert pictured["map.png"] == pytest.approx(1e6)


def test_a_map_is_of_its_window_and_letters(ran, here, pictured):
    frame = fb.Placement((0.1, 0.0), np.pi / 2)
    fb.Machine(ROBOT, frame=frame).save(here / "robot.toml")
    words = "map --nodes 3 --robot robot.toml --window -0.05 0.05 0.02 0.04 --field condition_J"
    letters = (
        "--labels x=a=b y=c --unit cm --width column --working 1 -1 --data map.csv --page p.html"
    )
    told = ran(f"{words} {letters} --graph graph.png").out
    assert pictured["labels"] == {"x": "a=b", "y": "c"} and pictured["width"] == "column"
    assert pictured["unit"] == "cm" and pictured["modes"] == [(1, -1)]
    assert pictured["map.png"] == 100.0 and "graph.png" in pictured and pictured["points"] is None
    data = pictured["data"]
    # x of the frame is y of the robot, and y is 0.1 m less its x.
    ends = [(axis.min(), axis.max()) for axis in (data.x, data.y)]
    np.testing.assert_allclose(ends, [(0.02, 0.04), (0.05, 0.15)], atol=1e-12)
    assert data.field == "condition_J" and len(data.x) == len(data.y) == 3
    assert told.splitlines()[-4:] == ["map.png", "graph.png", "map.csv", "p.html"]
    assert rows_of(told)["robot's own frame"] == "map.csv, p.html"
    ran("map --nodes 3 --space joint")
    assert pictured["data"].space == "joint" and pictured["regions"] is None


def test_constraints_of_a_file_bound_the_regions_of_a_map(monkeypatch):
    asked = []
    load = fb.constraints.load.Load((0.0, -1.0), (0.1, 0.1))

    def bounded(base, kept, load):
        asked.append((base, kept, load))
        return base

    monkeypatch.setattr("fivebar.constraints.disc.bounded_by", bounded)
    monkeypatch.setattr(
        "fivebar.constraints.feasible.feasible_parts", lambda part: (copy(part), copy(part))
    )
    machine = fb.Machine(ROBOT)
    aspects = fb.aspects(ROBOT)
    for kept, held in ((fb.Constraints(half_planes=[(0, 1, 0)]), None), (fb.Constraints(), load)):
        parts = map_command._feasible(machine, kept, held)
        assert [part.area for part in parts] == [each.area for each in aspects for _ in range(2)]
        assert [part.number for part in parts] == list(range(1, 2 * len(aspects) + 1))
        assert [each[1:] for each in asked] == [(kept, held)] * len(aspects)
        asked.clear()
    assert map_command._feasible(machine, fb.Constraints(), None) is None
    with pytest.raises(ValueError, match="strips without ends"):
        map_command._feasible(fb.Machine(fb.Biglide()), fb.Constraints(sin=0.2), None)


def verdict(**values):
    usual = dict(reachable=True, leaves=None, time=None, singularity_free=False, everywhere=False)
    usual |= dict(touching=False, type=2, criterion=None, criterion_holds=None)
    return map_command._verdict(SimpleNamespace(**usual | values))


def test_what_is_said_of_a_path_on_a_map():
    assert verdict(reachable=False, leaves=0.5, time=0.5) == "leaves the workspace at t = 0.5 s"
    free = verdict(singularity_free=True, min_margin=0.12345, min_margin_time=0.25)
    assert free == "free of singularities, smallest sine 0.123 at t = 0.25 s"
    assert verdict(everywhere=True) == map_command.EVERYWHERE
    assert verdict(time=0.5, type=1, touching=True) == "touches Type 1 at t = 0.5 s"
    # It leaves the workspace after it has crossed.
    for holds, ending in ((True, "the criterion holds"), (False, "off it: the torque diverges")):
        crossing = dict(reachable=False, leaves=0.75, time=0.5, criterion=0.25)
        words = verdict(**crossing, criterion_holds=holds)
        assert (
            words
            == f"crosses Type 2 at t = 0.5 s, it asks for 0.25 N along the free direction t_s, {ending}"
        )
    error = fb.UnreachableError("the tool cannot", 0.1)
    assert map_command._verdict(error) == "the tool cannot"


def test_a_path_is_checked_in_each_mode(ran, here, pictured):
    rows = [f"{t},{0.05 + 0.005 * t},{0.09 + 0.0025 * t}" for t in range(9)]
    (here / "path.csv").write_text("\n".join(["t_s,x_m,y_m", *rows]), "utf-8")
    words = "map --nodes 3 --path path.csv"
    found = json.loads(ran(f"{words} --json").out)["path"]
    told = [line for line in ran(words).out.splitlines() if line.startswith("path in")]
    assert [tuple(row["working"]) for row in found] == list(pictured["data"].modes)
    path = fb.from_csv("path.csv")
    for row, line in zip(found, told, strict=True):
        check = fb.check_path(ROBOT, path, row["working"])
        assert line.endswith(map_command._verdict(check))
        assert row["reachable"] == check.reachable and row["type"] == check.type
        assert row["time_s"] == check.time and row["leaves_s"] == check.leaves
        assert row["criterion_N"] == check.criterion and row["min_margin"] == check.min_margin
        assert row["singularity_free"] == check.singularity_free


def test_a_map_for_a_load_uses_what_bounds_it(ran, here, pictured, monkeypatch):
    """The force is turned into the robot's frame; both motors have the torque."""
    machine = fb.Machine(ROBOT, frame=fb.Placement((0.0, 0.0), np.pi / 2), offset=(0.1, 0.0))
    machine.save(here / "robot.toml")
    asked = []
    monkeypatch.setattr(map_command, "_feasible", lambda *words: asked.append(words))
    words = "map --nodes 3 --robot robot.toml"
    for more, torque in (("--load 0 -2 --torque-limit 0.3", (0.3, 0.3)), ("", None)):
        told = ran(f"{words} {more}")
        used, note = machine.used_by("map --load" if more else "map")
        given_machine, kept, load = asked.pop()
        assert given_machine == used and (note in told.err if note else not told.err)
        assert (load and load.torque) == torque and kept == used.on_poses
        if load:
            np.testing.assert_allclose(load.force, (-2.0, 0.0), atol=1e-12)


# linkage


@pytest.mark.parametrize(
    "words",
    [
        FOUR_BAR,
        f"{FOUR_BAR} --point 0.1 0.05 --held crank",
        "linkage slider-crank 0.05 0.2 --offset 0.01",
        "linkage six-bar-press --turns 1 --l3 0.56",
        "linkage five-bar --motors 1 2 --l11 0.1",
        "linkage straight-line watt",
        "linkage four-bar 0.2 0.06 0.3 0.14 --drive until-lock",
    ],
)
def test_ranges_of_a_study_are_of_its_table(words, ran):
    told = ran(f"{words} --csv study.csv").out.splitlines()
    found = json.loads(ran(f"{words} --csv study.csv --json").out)
    study = Study.from_csv("study.csv")
    begin = len(found["verdict"])
    assert told[:begin] == found["verdict"] and found["files"] == ["study.csv"] == told[-1:]
    head = f"{len(study.t)} samples over {study.t[-1]:.6g} s, least and largest:"
    assert told[begin] == head
    rows = told[begin + 1 : -1]
    if study.lock:
        angle, time = study.lock
        lock = f"the run ends before the lock at {np.degrees(angle):.6f} deg, {time:.6f} s"
        assert rows.pop(0) == lock and "until-lock" in words
    for row, (name, ends) in zip(rows, found["ranges"].items(), strict=True):
        values = study.columns[name]
        values = values[np.isfinite(values)]
        assert ends == pytest.approx([values.min(), values.max()], abs=1e-9)
        assert row.startswith(f"  {name} ")
        least, largest, *unit = row[3 + len(name) :].split()
        assert [float(least), float(largest)] == pytest.approx(ends, rel=1e-5, abs=2e-12)
        assert " ".join(unit) == of_unit(unit_of(name)).strip()


def test_linkages_have_their_lengths(ran):
    words = {
        f"{FOUR_BAR} --held crank": fb.linkages.FourBar(0.2, 0.06, 0.16, 0.14).inversion("crank"),
        "linkage slider-crank 0.05 0.2 --offset 0.01": fb.linkages.SliderCrank(0.05, 0.2, 0.01),
    }
    for text, linkage in words.items():
        ran(f"{text} --csv study.csv")
        assert Study.from_csv("study.csv").linkage == linkage


def test_a_live_page_is_of_the_linkage_in_its_branch(ran, monkeypatch):
    shown = []

    def play(linkage, branch):
        shown.append((linkage, branch))
        return SimpleNamespace(save=lambda path: Path(path).write_text("page", "utf-8"))

    monkeypatch.setattr("fivebar.visualization.play.play", play)
    assert ran(f"{FOUR_BAR} --branch -1 --live live.html").out.splitlines()[-1] == "live.html"
    ran("linkage five-bar --l11 0.1 --live live.html")
    (four_bar, branch), five_bar = shown
    assert (four_bar.crank, branch) == (0.06, -1) and five_bar == (replace(ROBOT, l11=0.1), None)
    said = ran("linkage five-bar --motors 1 2 --live live.html", 2).err
    assert "--live moves a five-bar by the motors at its base, 1 and 5" in said


def test_a_press_without_weights():
    options = Namespace(name="repaired", load=5.0, no_gravity=False)
    vars(options).update(dict.fromkeys(linkage_command.PRESS_LENGTHS))
    linkage, asked, _ = linkage_command._press(options)
    assert asked["gravity"] == linkage_command.GRAVITY and asked["turns"] == 3.0
    assert asked["speed"] == pytest.approx(np.radians(120)) and any(asked["gravity"])


# calibrate


def test_a_calibration_is_told_and_written(ran, here, unplotted):
    built = fb.FiveBar(l11=0.0903, l12=0.0898)
    poses = fb.measurement_poses(ROBOT, 8)
    xi = fb.dgm(built, poses.q, poses.assembly).xi + 1e-4 * np.sin(np.arange(16)).reshape(8, 2)
    table = np.column_stack([poses.q, xi, poses.working])
    head = "q1,q2,x,y,working1,working2"
    np.savetxt(here / "data.csv", table, delimiter=",", header=head, comments="")
    limits = fb.Constraints(torque=0.1)
    fb.Machine(ROBOT, constraints=limits).save(here / "robot.toml")
    words = "calibrate data.csv --unknown l11 l12 --robot robot.toml"
    result = fb.calibrate(ROBOT, "data.csv", ("l11", "l12"), sigma=1e-4)
    told = ran(f"{words} --sigma 1e-4 --json --out out")
    found = json.loads(told.out)
    files = [f"calibration.{end}" for end in ("png", "json", "txt")] + ["robot.toml"]
    assert told.err.splitlines()[-4:] == [str(Path("out", name)) for name in files]
    assert found["values"] == pytest.approx(result.values) and found["rows"] == 8
    assert found["rms_m"] == pytest.approx(result.rms) and found["chi2"] == pytest.approx(
        result.chi2
    )
    assert found["rms_before_m"] == pytest.approx(result.rms_before)
    assert np.shape(found["residuals_m"]) == (8, 2)
    for name, bounds in result.intervals().items():
        assert found["intervals_95"][name] == pytest.approx(list(bounds))
    assert Path("out/calibration.png").read_text() == "picture"
    text = Path("out/calibration.txt").read_text("utf-8")
    assert text.startswith(str(result))
    again = fb.Calibration.from_json("out/calibration.json")
    assert again.values == pytest.approx(result.values)
    robot = fb.load_machine("out/robot.toml")
    assert robot.robot.l11 == pytest.approx(result.robot.l11) and robot.constraints == limits
    assert "calibrated; SI units" in Path("out/robot.toml").read_text("utf-8")
    # Without a standard deviation there is no chi2 to be judged by; text goes to stdout.
    assert json.loads(ran(f"{words} --json").out)["chi2"] is None
    told = ran(f"{words} --sigma 1e-4 --out out").out
    assert told.splitlines()[-4:] == [str(Path("out", name)) for name in files]
    assert told.startswith(str(result))


def test_crosses_of_a_photograph_are_calibrated_with(here, monkeypatch, given):
    """Those that are seen, in the row of those of the drawing, and the sheet's place with them."""
    crosses = np.array([(0.02, 0.1), (0.03, 0.1), (0.03, 0.11)])
    seen = crosses + 0.001

    def points_to_csv(file, points):
        np.savetxt(file, points, delimiter=",", header="x,y", comments="")

    drawn = SimpleNamespace(points_to_csv=points_to_csv)
    asked = []
    monkeypatch.setattr(
        "fivebar.estimation.calibration.sheet.sheet", lambda *words: asked.append(words) or drawn
    )
    monkeypatch.setattr("matplotlib.image.imread", lambda path: path)
    monkeypatch.setattr(
        "fivebar.estimation.calibration.photo.crosses_in",
        lambda *words: asked.append(words) or seen,
    )
    calibrated = given("estimation.calibration.calibrate.calibrate")
    words = "calibrate --from-drawing A4 --photo photo.png --working 1 -1"
    with pytest.raises(Reached):
        main(words.split())
    (machine, *rest), found = asked
    assert machine.robot == ROBOT and rest == ["A4", [1, -1]]
    assert found == (Path("photo.png"), drawn, "A4", None) or found[0] == "photo.png"
    file = Path("fivebar-sheet", "crosses.csv")
    assert calibrated[1] == file
    np.testing.assert_allclose(table_of(file)[1], seen)
    usual = "l11 l12 l21 l22 d offset1 offset2".split()
    assert calibrated[2] == (*usual, "x0", "y0", "turn")
    with pytest.raises(Reached):
        main([*words.split(), "--unknown", "x0", "--out", "own"])
    assert calibrated[2] == ("x0",) and Path("own", "crosses.csv").exists()


def test_calibrations_without_what_they_need_are_refused(here, capsys):
    for words, message in (
        ("", "calibrate needs a file of measured data, or --from-drawing A5"),
        ("--photo a.png", "--photo is of a test drawing: give --from-drawing A4 or A5, too"),
        (". --photo a.png --from-drawing A5", "it goes without measured data"),
        ("--from-drawing A5 --robot biglide", "biglide"),
    ):
        assert main(["calibrate", *words.split()]) == 2
        assert message in capsys.readouterr().err
    assert calibrate_command.OPTIONS["--from-drawing A4|A5"]


# sweep and design, export, play, run


def test_a_design_is_printed_and_written(ran):
    words = "design bars --bound l1=0.1 --bound l2=0.1:0.2 --bound d=0.1 --effort 0.1"
    told = ran(f"{words} --out out --plot robot.svg")
    assert told.err.split() == ["out", "robot.svg"] and "<svg" in Path("robot.svg").read_text(
        "utf-8"
    )
    assert "bars = 0.4 m (min)" in told.out.splitlines()
    assert Path("out/robot.png").read_bytes()[1:4] == b"PNG"
    robot = fb.load_robot("out/robot.json")
    assert (robot.l11, robot.l12, robot.d) == pytest.approx((0.1, 0.1, 0.1))
    (found,) = json.loads(ran(f"{words} --json").out)
    assert found["values"] == {"bars": pytest.approx(0.4)}
    assert json.loads(Path("out/design.json").read_text("utf-8"))


def test_an_export_is_that_of_python(ran):
    words = "export --to mjcf --step 0.002 --start 0.1 0.2 --assembly 1 --name mine"
    start = fb.dgm(ROBOT, (0.1, 0.2), 1)
    text = fb.export(ROBOT, "mjcf", step=0.002, start=start, name="mine")
    assert ran(words).out == text and text != fb.export(ROBOT, "mjcf", name="mine")
    assert ran(f"{words} --out robot.xml").out == "robot.xml\n"
    assert Path("robot.xml").read_text("utf-8") == text


def test_a_page_is_served_until_ctrl_c(ran, monkeypatch):
    from http.server import ThreadingHTTPServer
    from threading import Thread

    pages = []

    def visited(server):
        visit = Thread(target=server.handle_request)
        visit.start()
        with urlopen(f"http://127.0.0.1:{server.server_port}/") as page:
            pages.append((server.server_port, page.read().decode()))
        visit.join()
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", visited)
    told = ran("play --serve")
    ((port, page),) = pages
    assert told.out == f"http://127.0.0.1:{port}/\n" and "until Ctrl C" in told.err
    ran("play --out page.html")
    assert page == Path("page.html").read_text("utf-8")


def test_pages_of_play_say_their_files(ran, here):
    told = ran("play --site site --address https://example.org/robot --link").out.splitlines()
    *files, link = told
    assert all(Path(file).exists() for file in files) and Path("site/index.html") in map(
        Path, files
    )
    assert "https://example.org/robot" in Path("site/index.html").read_text("utf-8")
    assert link.startswith("#") and "--site DIR" in ran("play --address https://a.b", 2).err
    fb.Machine(ROBOT, tool=fb.Tool(1, 0.02)).save(here / "robot.toml")
    told = ran("play --robot robot.toml --fs1 0.1")
    assert rows_of(told.out)["loci of the page"] == "those of joint C, not of the tool"
    assert "dry friction (fs1, fs2) is left out" in told.err


@pytest.mark.parametrize("code", [0, 3, -9])
def test_a_script_ends_the_command_with_its_code(code, here, monkeypatch, capsys):
    """Also after Ctrl-C, which is the script's own."""
    ends = [KeyboardInterrupt, code]

    def wait():
        end = ends.pop(0)
        if isinstance(end, int):
            return end
        raise end

    monkeypatch.setattr("subprocess.Popen", lambda *words, **how: SimpleNamespace(wait=wait))
    (here / "mine.py").write_text("", "utf-8")
    if code < 0:
        assert main(["run", "mine.py"]) == 1
        assert capsys.readouterr().err == "fivebar: mine.py was ended by signal 9\n"
    else:
        with pytest.raises(SystemExit) as ended:
            main(["run", "mine.py"])
        assert ended.value.code == code


# How a command ends


@pytest.mark.parametrize(
    "error, code, said",
    [
        (KeyboardInterrupt(), 130, "fivebar: interrupted\n"),
        (KeyboardInterrupt("interrupted: 2 are done"), 130, "fivebar: interrupted: 2 are done\n"),
        (BrokenPipeError(), 1, ""),
        (FileNotFoundError(2, "No such file", "a.csv"), 1, "fivebar: a.csv: No such file\n"),
        (MemoryError("too\nmuch"), 1, "fivebar: too much\n"),
        (ValueError("a\x1b[31m"), 1, "fivebar: a\\x1b[31m\n"),
        (fb.base.errors.UsageError("wrong"), 2, "fivebar: wrong\n"),
    ],
)
def test_an_error_is_one_line_and_a_code(error, code, said, monkeypatch, capsys):
    def fails(*words, **names):
        raise error

    monkeypatch.setattr("fivebar.study.speed_accuracy.making.make", fails)
    monkeypatch.setattr("fivebar.exporters.export.export", fails)
    assert main(["export", "--to", "mjcf"] if code == 130 else ["chart", "all"]) == code
    assert capsys.readouterr().err == said
    if code == 130:
        assert main(["chart", "all", "--out", "own"]) == 130
        kept = "what was measured is kept in own; the same command goes on there"
        assert kept in capsys.readouterr().err


def test_a_warning_is_one_line_without_control_characters(monkeypatch, capsys):
    def warns(*words, **names):
        warnings.warn("a\x1b[31m", UserWarning, stacklevel=1)
        raise ValueError("b")

    monkeypatch.setattr("fivebar.study.speed_accuracy.making.make", warns)
    assert main(["chart", "all"]) == 1
    assert capsys.readouterr().err == "fivebar: a\\x1b[31m\nfivebar: b\n"


def test_a_full_disk_behind_stdout_is_said(here, monkeypatch, capsys):
    with open(here / "file", "w", encoding="utf-8") as file:

        def flush():
            raise OSError(28, "No space left on device")

        full = SimpleNamespace(write=file.write, flush=flush, fileno=file.fileno)
        monkeypatch.setattr("sys.stdout", full)
        assert main(["export", "--to", "mjcf"]) == 1
    assert capsys.readouterr().err == "fivebar: stdout: No space left on device\n"


def test_options_after_a_script_are_the_commands(here, capsys):
    (here / "mine.py").write_text("", "utf-8")
    with pytest.raises(SystemExit) as ended:
        main(["run", "mine.py", "--until", "soon"])
    said = capsys.readouterr().err.splitlines()[-1]
    assert ended.value.code == 2 and said.startswith("fivebar run: error: argument --until: ")


def test_help_says_what_is_the_scripts(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    assert "what follows -- is the script's" in " ".join(capsys.readouterr().out.split())


def test_charts_are_named_with_their_files(ran, monkeypatch):
    asked = []

    def make(*words):
        asked.append(words)
        return {name: None for name in words[0][:2]}

    monkeypatch.setattr("fivebar.study.speed_accuracy.making.make", make)
    told = ran("chart geometry --out own --quick").out.splitlines()
    files = [Path("own", f"geometry{end}") for end in (".csv", ".png", ".svg")]
    assert list(map(Path, told)) == [*files, Path("own/index.html")]
    assert len(ran("chart all").out.splitlines()) == 7
    (one, every) = asked
    assert one == (["geometry"], Path("own"), True) and every[1:] == (Path("charts"), False)
    assert "geometry" in every[0] and len(every[0]) > 2


def test_a_motion_against_gravity_names_limit_and_place(here, capsys):
    robot = fb.FiveBar(gravity=(0.0, -9.81))
    fb.Machine(robot, frame=fb.Placement((0.1, 0.0))).save(here / "robot.toml")
    (here / "line.csv").write_text("x_mm,y_mm\n190,70\n195,70\n195,75\n", "utf-8")
    words = "draw line.csv --as-drawn --robot robot.toml --torque-limit 0.2 --working -1 -1"
    assert main(words.split()) == 1
    told = capsys.readouterr().err
    hold = np.abs(fb.gravity_torques(fb.igm(robot, (0.09, 0.07))))
    assert f"takes {hold[0]:.4g}, {hold[1]:.4g} N m, and the limit is 0.19, 0.19 N m" in told
    assert "line 3, joint C at (0.09, 0.07) m in the robot's own frame" in told
    assert "the drawing is there at (190, 70) mm in the measuring frame" in told
    assert "--reserve keeps 0.05 of the limit for the tracker" in told


# grade


def test_hints_come_on_their_day():
    lab = find_lab("lab1")
    today = datetime.date.today()
    for days, expected in ((1, True), (0, False), (-1, False)):
        day = (today + datetime.timedelta(days=days)).isoformat()
        assert grade.hints_from(Namespace(hints_from=day), lab) == (day if expected else "")
    assert grade.hints_from(Namespace(hints_from=None), lab) == ""
    with pytest.raises(fb.base.errors.UsageError, match="'soon' is no day; write it as 2027-01-31"):
        grade.hints_from(Namespace(hints_from="soon"), lab)


def test_what_is_not_graded_is_said_of_each_student(capsys):
    many = [("anna", Left(f"{k}.txt", "no program")) for k in range(8)]
    others = [("", Left("a.rar", "no zip")), ("bob", Left(".x", "hidden"))]
    grade_folder._print_ignored([*many, *others, ("carl", Left("b.txt", "no program"))])
    unread, anna, carl = capsys.readouterr().err.splitlines()
    assert unread == "not graded: a.rar: no zip"
    listed = ", ".join(f"{k}.txt (no program)" for k in range(6))
    assert anna == f"anna: also there, not graded: {listed}, ..."
    assert carl == "carl: also there, not graded: b.txt (no program)"


def programs_of(folder, sources):
    found = []
    for name, source in sources.items():
        (folder / name).write_text(source, "utf-8")
        found.append(ProgramFile(folder / name, "", name))
    return HandIn("anna", "", (folder,), tuple(found), ())


def test_the_best_of_a_hand_ins_controllers_counts(here, monkeypatch):
    """Of at most three, or of those that are named so; models and classes of robots are none."""
    asked = []

    def tried(student, name, text, rest, modules, how):
        asked.append((student, name, text, rest, how))
        return mark.Tried(student, name, {"points": len(name)})

    monkeypatch.setattr(mark, "_tried", tried)
    drives = "robot.apply_efforts()\n"
    none = {"models.py": "", "robot.py": f"class Robot:\n    {drives}"}
    assert mark._best(programs_of(here, none), "how").trouble == "no controller"
    assert not asked
    best = mark._best(programs_of(here, none | {"a.py": drives, "long.py": drives}), "how")
    assert best.name == "long.py" and best.student == "anna"
    assert asked == [("anna", name, drives, [], "how") for name in ("a.py", "long.py")]
    asked.clear()
    four = {f"{name}.py": drives for name in "abcd"}
    lost = mark._best(programs_of(here, four), "how")
    assert lost.trouble == "4 programs call apply_efforts: which one is the controller?"
    assert lost.tracking is None and lost.points == -1.0 and not asked
    assert mark._best(programs_of(here, four | {"my_control.py": drives}), "how").name == (
        "my_control.py"
    )
    assert len(asked) == 1


def test_marks_of_a_folder_are_told_as_json(here, ran, monkeypatch):
    (here / "course" / "anna").mkdir(parents=True)
    (here / "course" / "anna" / "control.py").write_text("robot.apply_efforts()\n", "utf-8")
    tried = mark.Tried("anna", "control.py", {"points": 3.0}, "late", "hello", object())
    monkeypatch.setattr(mark, "_tried", lambda *words: tried)
    told = ran("run course --mark 1 --json").out
    expected = tried._asdict() | {"run": None}
    assert told == json.dumps([expected], indent=2) + "\n"


def test_no_command_is_wrong_usage(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--"])
    assert ended.value.code == 2 and "COMMAND" in capsys.readouterr().err


# What is given on


def test_the_simulation_of_a_drawing_is_as_its_options_say(here, given, monkeypatch):
    with_line(here)
    trackers = []
    monkeypatch.setattr("fivebar.control.matched.matched", lambda *words: trackers.append(words))
    simulated = given("simulation.simulate.simulate")
    words = "draw line.csv --as-drawn --working -1 1 --torque-limit 0.2 --reserve 0.5"
    for more, period, step, counts, delay in (
        ("--counts-per-turn 4096 --delay 2 --period 0.0204", 0.0204, 0.00102, 4096, 2),
        ("--lead 0.012 --period 0.0004 --acceleration-limit 0.5", 0.0004, 0.0004, None, 0),
        ("--speed-limit 0.1", None, None, None, 0),
    ):
        with pytest.raises(Reached):
            main([*words.split(), *more.split()])
        resolution = counts and 2 * np.pi / counts
        assert simulated["measurement"].delay == delay
        assert simulated["measurement"].encoder_resolution == resolution
        motion = simulated[2]
        assert bool(motion.pen(np.zeros(1))[0]) == ("--lead" not in more)
        robot, peak, own, drives, assembly, *rest = trackers.pop()
        assert robot == ROBOT and rest == [delay, resolution] and drives.torque == (0.2, 0.2)
        assert assembly == int(fb.igm(ROBOT, (-0.01, 0.06), (-1, 1)).assembly)
        assert simulated["control_period"] == own and simulated["torque_limit"] == 0.2
        t = np.linspace(0.0, motion.duration, 2001)
        largest = np.linalg.norm(motion(t)[2], axis=1).max()
        assert peak == pytest.approx(largest, rel=0.05)
        if period:
            assert own == period and simulated["step"] == pytest.approx(step)
        else:
            assert simulated["step"] == pytest.approx(own / max(1, round(1e3 * own)))
    start = fb.simulation.simulate.start_with(ROBOT, motion, None)
    assert tuple(start.pose.working) == (-1, 1) and not start.xi_dot.any()


@pytest.mark.parametrize("is_gcode", [False, True])
def test_the_picture_of_a_drawing_shows_what_is_drawn(is_gcode, here, monkeypatch):
    drawn = []
    module = import_module("fivebar.visualization.plot.drawing")  # Its function has its name.
    monkeypatch.setattr(module, "drawing", lambda *words: drawn.append(words))
    path = fb.path([(0.0, 0.1), (0.02, 0.1)])
    motion = SimpleNamespace(duration=1.23456, working=(1, -1), path=path)
    machine = fb.Machine(ROBOT, frame=fb.Placement((0.1, 0.0)))
    options = Namespace(out=here, format="gcode" if is_gcode else "csv")
    draw._picture(options, machine, motion, draw.NOTHING, None)
    tip = np.linspace((0.0, 0.1), (0.02, 0.1), 6)
    down = np.array([1, 1, 0, 1, 1, 1], bool)
    off = 1e-6 * np.array([1.0, 2.0, 9.0, 3.0, 4.0, 5.0])
    draw._picture(options, machine, motion, draw.Drawn(tip, off, down, {}), "page")
    (_, _, _, none, nothing, title, *_), words = drawn
    assert not none and not nothing and title == "drawn in 1.235 s"
    robot, working, _, tips, errors, title, tool, name, page, frame = words
    assert (robot, working, tool, page, frame) == (ROBOT, (1, -1), None, "page", machine.frame)
    assert [each.tolist() for each in errors] == [off[:2].tolist(), off[3:].tolist()]
    assert [len(each) for each in tips] == [2, 3] and tips[1][0].tolist() == tip[3].tolist()
    assert title == "drawn in 1.235 s, within 5 µm"
    assert name == ("the G-code" if is_gcode else "the simulated robot")


def test_a_map_of_a_tool_is_of_its_regions(ran, here, pictured, monkeypatch):
    tool = fb.Tool(1, 0.02)
    fb.Machine(ROBOT, tool=tool).save(here / "robot.toml")
    asked, shown, pages = [], [], []

    def regions(*words):
        asked.append(words)
        return fb.aspects(ROBOT)[:2]

    monkeypatch.setattr("fivebar.paths.placing.tool_regions.tool_regions", regions)
    monkeypatch.setattr(
        "fivebar.constraints.feasible.feasible_parts", lambda part: shown.append(part) or (part,)
    )
    monkeypatch.setattr(
        "fivebar.visualization.pages.linked.map_page",
        lambda data, path, along, regions: pages.append((path, along, regions)),
    )
    monkeypatch.setattr("fivebar.constraints.disc.bounded_by", None)
    lost = fb.UnreachableError("the tool cannot", 0.1)
    monkeypatch.setattr(map_command, "_checked", lambda machine, path, working: lost)
    rows = [f"{t},{0.05 + 0.005 * t},{0.09 + 0.0025 * t}" for t in range(9)]
    (here / "path.csv").write_text("\n".join(["t_s,x_m,y_m", *rows]), "utf-8")
    fake_parts(monkeypatch)
    words = "map --nodes 3 --robot robot.toml --sin 0.2 --page page.html --path path.csv"
    told = ran(f"{words} --graph graph.png")
    assert "of the aspects of joint C, without the tool" in told.err
    said = [line for line in told.out.splitlines() if line.startswith("path in working mode ")]
    assert len(said) == 4 and all(line.endswith(": the tool cannot") for line in said)
    bounded, plain = asked
    assert bounded[:3] == (tool, ROBOT, None) and bounded[3].sin == 0.2 and bounded[4] is None
    assert plain == (tool, ROBOT) and len(shown) == 2
    ((path, along, found),) = pages
    assert path == Path("page.html") and found == pictured["regions"]
    np.testing.assert_allclose(along[[0, -1]], [(0.05, 0.09), (0.09, 0.11)], atol=1e-12)
    listed = [line for line in told.out.splitlines() if line.startswith(("     1", "     2"))]
    assert len(listed) == 4


def test_what_takes_long_shows_how_much_is_done(monkeypatch):
    asked = []
    monkeypatch.setattr(
        "fivebar.base.progress.progress", lambda each, **how: asked.append(how) or each
    )
    fake_parts(monkeypatch)
    machine = fb.Machine(ROBOT)
    parts = [SimpleNamespace(number=1)]
    map_command._largest(machine, parts, None)
    map_command._board(machine, parts, None, (0.1, 0.1))
    monkeypatch.setattr("fivebar.constraints.feasible.feasible_parts", lambda part: (part,))
    map_command._feasible(machine, fb.Constraints(half_planes=[(0, 1, 0)]), None)
    assert [how["desc"] for how in asked] == ["discs", "boards", "regions"]
    assert all(how["delay"] > 1 and not how["leave"] for how in asked)


def test_a_proof_is_checked_by_its_file(ran, here, monkeypatch):
    with_line(here)
    bars = []
    told = ran("certify line.csv --out proof.json --tolerance 1e-5").out.splitlines()
    assert told[-1] == "proof.json"
    claim = json.loads(Path("proof.json").read_text("utf-8"))
    monkeypatch.setattr(
        "fivebar.base.progress.progress", lambda each, **how: bars.append(how) or each
    )
    proved = ran("certify --check proof.json").out
    assert told[-2] == proved.strip() and bars[0]["desc"] == "check"
    begin = f"proved on {len(claim['pieces'])} pieces: l11 = 0.09 +- 1e-05 m, "
    assert proved.startswith(begin) and "working [-1, -1], assembly -1, margin 0" in proved
    Path("false.json").write_text(
        Path("proof.json").read_text("utf-8").replace("0.118", "0.119"), "utf-8"
    )
    assert ran("certify --check false.json", 1).err.startswith("fivebar: false.json: refused: ")


def test_what_a_path_is_read_with(here, given):
    with_line(here)
    read = given("paths.reading.read.path")
    more = "line.csv --deviation 1mm --units mm --columns x=East"
    shared = {0: Path("line.csv"), "deviation": 1e-3, "units": "mm", "columns": ["x=East"]}
    with pytest.raises(Reached):
        main(f"draw {more} --pen-values 1 5".split())
    assert read == shared | {"pen_values": [1.0, 5.0], "curvature": False}
    with pytest.raises(Reached):
        main(f"draw {more} --pen-values 1 5 --format gcode --pen Z".split())
    assert read == shared | {"pen_values": None, "curvature": False}
    read.clear()
    with pytest.raises(Reached):
        main(f"certify {more} --shift 0.1 0.2 --turn-deg 90 --scale 2".split())
    assert read.pop("placement") == fb.Placement((0.1, 0.2), np.pi / 2, 2.0)
    assert read == shared


@pytest.mark.parametrize(
    "words, expected",
    [
        ("sdf --closure joint --step 0.002", {"closure": "joint", "step": 0.002}),
        ("ros2_control --plugin mine/System", {"plugin": "mine/System"}),
    ],
)
def test_options_of_an_export(words, expected, here, given):
    found = given("exporters.export.export")
    with pytest.raises(Reached):
        main(["export", "--to", *words.split()])
    used = {name: value for name, value in found.items() if value is not None}
    assert used.pop(0).robot == ROBOT and used == {1: words.split()[0]} | expected


def test_a_tracker_for_a_fast_motion_is_matched_to_it(here, given, monkeypatch):
    monkeypatch.setattr("fivebar.control.matched.asks_for_it", lambda *words: words[2:] + (7.0,))
    found = given("control.matched.matched")
    with pytest.raises(Reached):
        main(f"{LINE} --controller mpc --period 0.02 --torque-limit 0.2 --working 1 -1".split())
    robot, peak, period, limits, assembly = (found[k] for k in range(5))
    assert robot == ROBOT and peak == (0.02, 0.2, (1, -1), 7.0) and period == 0.02
    assert limits.torque == (0.2, 0.2)
    assert assembly == int(fb.igm(ROBOT, (0.09, 0.068), (1, -1)).assembly)


def test_a_live_page_has_the_tool_and_its_point(here, given):
    tool = fb.Tool(1, 0.02)
    machine = fb.Machine(ROBOT, tool=tool)
    machine.save(here / "robot.toml")
    found = given("visualization.play.play")
    with pytest.raises(Reached):
        main("play --robot robot.toml --xi 0.05 0.1 --working 1 -1".split())
    assert found[0] == ROBOT and found["tool"] == tool
    assert tool.point(found[1]) == pytest.approx((0.05, 0.1))
    with pytest.raises(Reached):
        main(["play"])
    assert found[1] is None and found["tool"] is None


@pytest.mark.parametrize(
    "words", ["plan --from 0.05 0.15 --to 0 0.15 --duration 1", "draw line.csv"]
)
def test_angles_that_the_drives_do_not_have_are_refused_before_the_work(words, here, ran, given):
    (here / "line.csv").write_text("x,y\n0,0\n0.01,0\n", encoding="utf-8")
    fb.Machine(ROBOT, ratio=(np.pi / 180,) * 2).save(here / "robot.toml")
    given("planning.plan.plan")
    given("paths.reading.read.path")
    said = ran(f"{words} --robot robot.toml --angles deg", 2).err
    assert "leave out --angles deg: the drives read 360 a turn" in said


def test_the_stroke_of_a_straight_line_is_said(ran):
    told = ran("linkage straight-line hoeken").out
    mechanism = fb.linkages.straight_line("hoeken")
    line = fb.linkages.straightness(mechanism)
    first, last = np.degrees(sorted(mechanism.stroke))
    assert (
        f"straight stroke {line.stroke:.6g} m with the crank from {first:.6f} to {last:.6f}" in told
    )
    assert f"{line.deviation:.6g} m, band {line.band:.6g} m, {100 * line.ratio:.4g} %" in told
    assert f"source: {mechanism.source}" in told


REFUSED = {
    f"{LINE} --controller mpc --kp 9": "mpc has none",
    f"{LINE} --controller mpc --kd 9": "mpc has none",
    "track --case mass here.py": "--case brings its own path, robot and controller",
    "track --case mass --to 0 0.1": "--case brings its own path, robot and controller",
    "track --case mass --duration 2": "--case brings its own path, robot and controller",
    "map --space joint --sin 0.1": "are of task space only",
    "map --space joint --working 1 1": "are of task space only",
    "map --fits 0.1 0.1 --robot biglide": "--fits takes two sizes > 0",
    "design bars --plot a.txt": "--plot must end in .png, .svg or .pdf, not 'a.txt'",
    f"{FOUR_BAR} --plot a.txt": "--plot must end in .png, .svg or .pdf, not 'a.txt'",
    f"{FOUR_BAR} --turns 0 --csv a.csv": "--turns must be finite and > 0",
    "play --out a.txt": "--out must end in .html or .htm, not 'a.txt'",
    "run here.py --bag here": "here is a folder already",
    "run here.py --record here.py/a.csv": "here.py: File exists",
    "run here.py --animate a.txt": "--animate must end in .html, .gif, .mp4, .webm or .png",
    "map --labels x": "--labels must be NAME=TEXT, not 'x'",
    "map --space joint --path here.py": "are of task space only",
    "map --space joint --load 0 1 --torque-limit 1": "are of task space only",
    "certify here.py --check here.py": "certify needs a path's file, or --check and a proof",
    "identify here.py --counts-per-turn 1 2 3": "--counts-per-turn takes one number or two, not 3",
    "sweep bars --mark l1=0.1 --grid l1=0.1": "--mark is of --plot FILE",
    "grade lab1 here.py here.py": "several submissions are graded in folders",
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_is_refused_by_name(words, here, capsys):
    (here / "here.py").write_text("", "utf-8")
    (here / "here").mkdir()
    assert main(words.split()) == 2
    assert REFUSED[words] in capsys.readouterr().err


def test_a_secret_has_eight_bytes(tmp_path, monkeypatch):
    for count in (7, 8):
        text = "x" * count
        (tmp_path / "secret").write_text(f"{text}\n", "utf-8")
        for source in ("file", "environment"):
            if source == "environment":
                monkeypatch.setenv(grade.SECRET, text)
            path = tmp_path / "secret" if source == "file" else None
            if count == 8:
                assert grade._secret(path) == text.encode()
            else:
                with pytest.raises(fb.base.errors.UsageError, match="fewer than 8 bytes"):
                    grade._secret(path)
    assert grade._secret(None) is None


def test_a_hand_in_of_two_labs_is_graded_in_each(here, monkeypatch, capsys):
    """What else is there is said; where several could be meant, that lab's trouble is graded."""
    folder = here / "anna"
    folder.mkdir()
    names = "five_bar_models.py", "biglide_models.py", "notes.txt", ".hidden", "helper.py"
    for name in names:
        (folder / name).write_text(f"# {name}\n", "utf-8")
    jobs = []

    def graded(lab, job, **how):
        jobs.append((lab.name, job.path.name, job.trouble, job.student, len(job.siblings), how))
        return SimpleNamespace(points=len(jobs))

    monkeypatch.setattr("fivebar.grading.grade.grade", graded)
    monkeypatch.setattr("fivebar.grading.judging.results.joined", lambda best: best)
    lab = find_lab("amoro")
    options = Namespace(submission=folder, file=None)

    def how(lab):
        return {"student": f"anna in {lab.name}"}

    found = grade._graded(options, lab, how)
    watched = {"home": False, "watched": True}
    assert jobs == [
        ("amoro", "five_bar_models.py", "", "anna in amoro", 2, watched),
        ("amoro-biglide", "biglide_models.py", "", "anna in amoro-biglide", 2, watched),
    ]
    assert [report.points for report in found] == [1, 2]
    said = capsys.readouterr().err.splitlines()
    assert said[:2] == [f"graded: anna/{name}" for name in names[:2]]
    assert len(said) == 4 and said[2].startswith("not graded: anna/notes.txt: ")
    assert said[3] == "not graded: anna/helper.py"
    # The best of several versions counts; of too many none can be meant.
    jobs.clear()
    for k in range(6):
        (folder / f"biglide_models ({k}).py").write_text(f"# {k}\n", "utf-8")
    (folder / "biglide_models.py").unlink()
    found = grade._graded(options, lab, how)
    (_, *_), (name, file, trouble, student, _, how_it_is) = jobs
    assert (name, file, student) == ("amoro-biglide", "anna", "anna in amoro-biglide")
    assert "programs could be meant" in trouble and how_it_is == {}
    assert f"amoro-biglide: {trouble}" in capsys.readouterr().err


def test_designs_that_cannot_be_fail_and_wrong_ones_are_wrong_usage(ran, monkeypatch):
    messages = ["nothing within the bounds keeps the limits", "reach needs table=..."]

    def design(*words, **names):
        raise ValueError(messages.pop(0))

    monkeypatch.setattr("fivebar.optimal_design.optimum.design", design)
    words = "design bars --bound l1=0.1:0.2"
    assert ran(words, 1).err == "fivebar: nothing within the bounds keeps the limits\n"
    assert ran(words, 2).err == "fivebar: reach needs --table\n"


def test_closed_streams_are_opened_to_nowhere(here, monkeypatch):
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        monkeypatch.setattr(f"sys.{name}", None)
        assert main(["export", "--to", "mjcf", "--out", "robot.xml"]) == 0
        with getattr(sys, name) as stream:
            assert (stream.name, stream.mode) == (os.devnull, mode)
        monkeypatch.undo()
        monkeypatch.chdir(here)


def report(student, percent, **more):
    usual = {"faults": [], "ungraded": False, "no_program": False, "warnings": []}
    told = {"student": student, "percent": percent}
    return SimpleNamespace(**usual | told | more, as_json=lambda: told)


@pytest.fixture
def course(here, monkeypatch):
    """A course whose reports are these; what its parts are given is kept."""
    asked = SimpleNamespace(reports=[report("anna", 50.0), report("bob", 75.0)], filled=None)

    class Course:
        ignored = [("", Left("a.rar", "no zip"))]
        graded = [SimpleNamespace(name="lab1", equal=[(["anna", "bob"], "all")])]
        students = ["anna"]

        def __init__(self, *words):
            asked.made = words
            self.lab = "the lab"

        def find(self, *words):
            asked.found = words

        def grade(self, *words):
            asked.graded = words

        def write(self):
            return asked.filled

        def reports(self):
            return asked.reports

        def words(self):
            return "the course"

        def without_mark(self):
            return {"late": ["carl"]}

    (here / "subs").mkdir()
    monkeypatch.setattr("fivebar.grading.course.course.Course", Course)
    monkeypatch.setattr("fivebar.grading.course.gradebook.Gradebook", lambda *words: words)
    settings = Settings(packages=("scipy",))
    monkeypatch.setattr("fivebar.grading.course.settings.read_settings", lambda out: settings)
    monkeypatch.setattr(
        "fivebar.grading.course.settings.offer_settings",
        lambda *words: setattr(asked, "offered", words),
    )
    monkeypatch.setattr("fivebar.grading.worker.places.bwrap_trouble", lambda: "none here")
    asked.course = Course
    return asked


def test_a_course_is_graded_as_its_options_say(course, ran, here):
    (here / "book.csv").write_text("", "utf-8")
    book = "--gradebook book.csv --column Title --file *_x.py --jobs 3 --time-limit 4 --seed s"
    course.filled = SimpleNamespace(count=2, no_hand_in=1, no_row=["dora"])
    told = ran(f"grade lab1 subs --out out {book}")
    lab, out, settings, gradebook = course.made
    assert lab.name == find_lab("lab1").name and out == Path("out")
    assert gradebook == (Path("book.csv"), lab, "Title") and settings.packages == ("scipy",)
    assert course.found == ([Path("subs")], "*_x.py", False)
    how = ("s", None, "process", 4.0, "", ("scipy",))
    assert course.graded == (how, 3) and course.offered == (Path("out"), "the lab")
    assert told.out == "the course\n"
    assert told.err.splitlines() == [
        "not graded: a.rar: no zip",
        "isolation: process (bubblewrap does not work here: none here)",
        "lab1: equal programs (all): anna, bob",
        "marks.csv: no mark yet (late): carl",
        "gradebook.csv: marks: 2; rows without a hand-in: 1",
        "gradebook.csv: no row, or several, for dora",
    ]
    told = ran("grade lab1 subs --out out --json --isolate bwrap --secret-file book.csv", 2)
    assert "--secret-file" in told.err
    Path("secret").write_text("a long secret", "utf-8")
    told = ran("grade lab1 subs --out out --json --isolate bwrap --secret-file secret")
    assert json.loads(told.out) == [each.as_json() for each in course.reports]
    assert course.found[2] is True and course.made[3] is None
    seed, secret, isolate, *_ = course.graded[0]
    assert secret == b"a long secret" and isolate == "bwrap" and seed
    assert "isolation: bwrap (a disk, processes and network of its own)" in told.err


def test_a_course_that_is_not_all_graded_fails(course, ran, monkeypatch):
    words = "grade lab1 subs --out out"
    assert "1 of 2 below 60 %: anna" in ran(f"{words} --fail-under 60", 1).err
    ran(f"{words} --fail-under 50")
    course.reports[0].no_program = True
    ran(f"{words} --fail-under 60")
    course.reports[0].ungraded = True
    assert "1 of 2 not graded: anna; run it again" in ran(words, 1).err
    course.reports[1].faults = ["no sample", "no sample"]
    said = ran(words, 1).err
    assert "the lab itself has a fault, so the results do not count: no sample\n" in said
    monkeypatch.setattr(course.course, "students", [])
    assert "subs holds no submissions" in ran(words, 2).err
    for more, message in (
        ("", "needs --out DIR for the results"),
        ("--out out --student anna", "--student, --html and --csv are for one submission"),
        ("--out out --html a.html", "--student, --html and --csv are for one submission"),
        ("--out subs/out", "--out subs/out lies within the submissions"),
        ("none --out out", "no file or folder 'none'"),
    ):
        assert message in ran(f"grade lab1 subs {more}", 2).err


def test_one_submissions_report_is_written_as_asked_for(here, ran, monkeypatch):
    (here / "anna.py").write_text("", "utf-8")
    graded = report("anna", 50.0, warnings=["take care"])
    monkeypatch.setattr(grade, "_graded", lambda arguments, lab, how: graded)
    outputs = "fivebar.grading.report.outputs"
    monkeypatch.setattr(f"{outputs}.gradescope_text", lambda each: f"scope of {each.student}")
    monkeypatch.setattr(f"{outputs}.check_rows", lambda each: [each.student])
    monkeypatch.setattr(f"{outputs}.csv_text", lambda columns, rows: f"{len(columns)} {rows[0]}")
    monkeypatch.setattr(f"{outputs}.json_text", lambda each: '{"json": 1}\n')
    monkeypatch.setattr(
        "fivebar.grading.judging.results.withheld", lambda each: f"of {each.student}"
    )
    monkeypatch.setattr("fivebar.grading.report.page.report_page", lambda each: f"page {each}")
    monkeypatch.setattr(
        "fivebar.grading.report.text.report_text",
        lambda each, colour: f"{each.student} in {'colours' if colour else 'grey'}",
    )
    told = ran("grade lab1 anna.py --gradescope r.json --csv c.csv --html p.html")
    isolation, warning = told.err.splitlines()
    assert isolation == grade_folder.isolation("process") and warning == "take care"
    assert told.out == "anna in grey\n"
    texts = [Path(name).read_text("utf-8") for name in ("r.json", "c.csv", "p.html")]
    assert texts[0] == "scope of anna" and texts[2] == "page of anna"
    assert texts[1].endswith(" anna") and int(texts[1].split()[0]) > 3
    assert ran("grade lab1 anna.py --json").out == '{"json": 1}\n'
    assert "1 of 1 below 60 %: anna" in ran("grade lab1 anna.py --fail-under 60", 1).err
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert ran("grade lab1 anna.py").out == "anna in colours\n"
    monkeypatch.setenv("NO_COLOR", "1")
    assert ran("grade lab1 anna.py").out == "anna in grey\n"
    graded.faults.append("no sample")
    assert "so this result does not count: no sample" in ran("grade lab1 anna.py", 1).err


def test_a_marked_script_says_its_points_and_writes_its_files(here, ran, monkeypatch):
    (here / "control.py").write_text("", "utf-8")
    names = "largest_error_m", "rms_error_m", "error_at_the_end_m"
    tracking = dict.fromkeys(names, 2e-3) | {"task": "2", "points": 3.0, "of": 5}
    asked = []
    run = SimpleNamespace(
        to_csv=lambda path: asked.append(("csv", path)),
        plot=lambda path: asked.append(("plot", path)),
        animate=lambda path: asked.append(("page", path)),
    )
    tried = [mark.Tried("control", "control.py", tracking, "late", "hello\n", run)]

    def of_script(path, rest, how):
        asked.append((path.name, rest, how[:2]))
        return tried[0]

    monkeypatch.setattr(mark, "_of_script", of_script)
    words = "run control.py --mark 2 --until 3"
    told = ran(f"{words} --record a.csv --plot a.png --animate a.html own -- --json")
    assert asked.pop(0) == ("control.py", ["own", "--json"], ("2", 3.0))
    assert told.out == f"{tracking_words(tracking)}\n"
    wrote = [f"fivebar run: wrote {name}" for name in ("a.csv", "a.png", "a.html")]
    assert told.err.splitlines() == ["hello", "fivebar run: late", *wrote]
    assert [str(path) for _, path in asked] == ["a.csv", "a.png", "a.html"]
    assert [kind for kind, _ in asked] == ["csv", "plot", "page"]
    asked.clear()
    told = ran(f"{words} --json")
    assert told.out == json.dumps({"tracking": tracking, "trouble": "late"}, indent=2) + "\n"
    tried[0] = mark.Tried("control", "control.py", None, "no robot")
    told = ran(words, 1)
    assert told.err.splitlines() == ["fivebar run: no robot", "fivebar: --mark 2: no mark"]
    assert ran("run control.py --mark 2 --until 0", 2).err


def test_designs_of_a_sweep_are_those_of_python(here, given):
    from fivebar.optimal_design.designs import sample, triangle

    found = given("optimal_design.sweeping.sweep")
    bounds = {"l1": (0.1, 0.2), "l2": (0.1, 0.3)}
    for words, expected in (
        ("--triangle 4", triangle(4)),
        ("--sample 6 --seed 3 --bound l1=0.1:0.2 --bound l2=0.1:0.3", sample(bounds, 6, 3)),
    ):
        with pytest.raises(Reached):
            main(f"sweep bars {words}".split())
        assert found[1].names == expected.names
        own, pythons = (np.concatenate(list(each.chunks(100))) for each in (found[1], expected))
        np.testing.assert_array_equal(own, pythons)
