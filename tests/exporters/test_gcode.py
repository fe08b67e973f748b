"""Joint-space G-code: read back, replayed, and run by LinuxCNC's interpreter where there is one."""

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.exporters.gcode_replay import read_joint_gcode, replayed
from fivebar.paths.strokes import with_pen_time

PLOTCLOCK = fb.load_machine("plotclock")
RRF = fb.load_machine("reprapfirmware")
STROKES = [[(-0.02, 0.05), (0.02, 0.05), (0.02, 0.065)], [(-0.02, 0.065), (-0.02, 0.05)]]
LIMITS = fb.Constraints(speed=0.05, acceleration=0.5)
TURNED = replace(PLOTCLOCK, offset=(0.3, -0.2), ratio=(-1.0, 0.25))


@pytest.fixture(scope="module")
def motion():
    path = with_pen_time(fb.path(STROKES, deviation=2e-4), 0.2)
    led = PLOTCLOCK.tool.path(PLOTCLOCK.robot, path, (1, -1))
    return fb.time_path(PLOTCLOCK.robot, led, constraints=LIMITS, working=(1, -1))


DIALECTS = {
    "grbl": fb.Gcode(),
    "units": fb.Gcode(feed="units"),
    "steps": fb.Gcode(unit="steps", per_turn=3200, gear=5.0, deviation=1e-4),
    "mm": fb.Gcode(firmware="fluidnc", unit="mm", per_turn=40.0),
    "linuxcnc": fb.Gcode(firmware="linuxcnc", axes=("A", "B"), pen="Z", speed_error=0.003),
    "marlin": fb.Gcode(firmware="marlin"),
    "servo": fb.Gcode(firmware="reprapfirmware", pen="servo", down=30.0, up=70.0),
    "approach": fb.Gcode(approach=0.05),
    "coarse": fb.Gcode(deviation=1e-3, speed_error=0.3),
}


@pytest.mark.every(5)
@pytest.mark.parametrize("machine", [PLOTCLOCK, TURNED], ids=["plain", "turned"])
@pytest.mark.parametrize("name", DIALECTS)
def test_a_replayed_file_keeps_deviation_speed_time_and_pen(name, machine, motion, tmp_path):
    dialect = DIALECTS[name]
    text = fb.export(motion, "gcode", tmp_path / "a.nc", machine=machine, dialect=dialect)
    assert (tmp_path / "a.nc").read_text("utf-8") == text
    program = read_joint_gcode(text, dialect)
    replay = replayed(program, motion, machine, dialect)
    assert replay.deviation <= dialect.deviation
    assert replay.speed_error <= dialect.speed_error
    assert replay.duration == pytest.approx(motion.duration, rel=1e-5)
    assert replay.pen_errors == 0 and set(replay.down.tolist()) == {True, False}


@pytest.mark.deep
def test_places_and_times_are_those_of_the_motion(motion):
    """Read by plain regular expressions, without the reader of the package."""
    text = fb.export(motion, "gcode", machine=PLOTCLOCK)
    t = 0.0
    lines = re.findall(r"G1 X(\S+) Y(\S+) F(\S+)|G4 P(\S+)", text)
    assert len(lines) > 50
    for x, y, feed, seconds in lines:
        t += float(seconds) if seconds else 60 / float(feed)
        if x:
            q = np.radians([float(x), float(y)])
            np.testing.assert_allclose(np.exp(1j * q), np.exp(1j * motion.joints(t)[0]), atol=3e-5)
    assert text.count("M3 S1000") == text.count("M5") - 1 == 2


def test_axes_are_the_readings_of_the_machine(motion):
    """RepRapFirmware's machine reads degrees; its joint limits say which turn is meant."""
    path = fb.path([(-0.05, 0.2), (0.05, 0.2), (-0.12, 0.1)])
    limits = fb.Constraints(acceleration=1.0, speed=0.2)
    timed = fb.time_path(RRF.robot, path, constraints=limits, working=(1, -1))
    text = fb.export(timed, "gcode", machine=RRF)
    assert text == fb.export(timed, "gcode", machine=RRF, dialect=fb.Gcode(unit="rad"))
    axes = read_joint_gcode(text).axes
    low, high = np.array([(34, 251), (-71, 146)]).T
    assert (axes >= low).all() and (axes <= high).all() and axes[:, 0].max() > 180
    with pytest.raises(
        ValueError, match="the drives read 360 a turn.*could be theirs or the motor"
    ):
        fb.export(timed, "gcode", machine=RRF, dialect=fb.Gcode(unit="deg"))


@pytest.mark.deep
def test_what_firmware_cannot_do_is_refused(motion):
    with pytest.raises(ValueError, match=r"axis [XY] moves at .* deg/min at t = .* beyond the 500"):
        fb.export(motion, "gcode", machine=PLOTCLOCK, dialect=fb.Gcode(max_feed=500.0))
    fb.export(motion, "gcode", machine=PLOTCLOCK, dialect=fb.Gcode(max_feed=1e5))
    with pytest.raises(TypeError, match="gcode is written of a TimedPath"):
        fb.export(fb.FiveBar(), "gcode")
    with pytest.raises(TypeError, match="other formats of a robot"):
        fb.export(motion, "urdf")
    with pytest.raises(ValueError, match="another robot"):
        fb.export(motion, "gcode", machine=fb.Machine(fb.FiveBar()))
    stroke = fb.path([(0.09, 0.068), (0.05, 0.0), (0.03, 0.04)], deviation=1e-3)
    across = fb.time_path(fb.FiveBar(), stroke, constraints=fb.Constraints(torque=0.05))
    with pytest.raises(ValueError, match="crosses Type 2"):
        fb.export(across, "gcode")
    line = fb.path([(0.0, 0.2), (0.02, 0.22)])
    slide = fb.time_path(fb.Biglide(), line, constraints=fb.Constraints(acceleration=1.0))
    with pytest.raises(ValueError, match="joints of a biglide slide"):
        fb.export(slide, "gcode", dialect=fb.Gcode(unit="deg"))
    program = read_joint_gcode(fb.export(slide, "gcode"))
    assert replayed(program, slide).deviation < 2e-5


def test_joints_come_from_one_side(motion):
    text = fb.export(motion, "gcode", machine=PLOTCLOCK, dialect=fb.Gcode(approach=math.radians(3)))
    found = re.findall(r"G0 X(\S+) Y(\S+)\nG0 X(\S+) Y(\S+)\nM3", text)
    assert len(found) == 2
    for low_x, low_y, x, y in found:
        assert float(x) - float(low_x) == pytest.approx(3, abs=1e-3)
        assert float(y) - float(low_y) == pytest.approx(3, abs=1e-3)
    with pytest.raises(ValueError, match="line 4: rapid moves before it led"):
        read_joint_gcode("G0 X0 Y0\nG1 X1 Y1 F60\nG0 X5 Y5\nG1 X2 Y2 F60\n")


@pytest.mark.parametrize(
    "options, words",
    [
        (dict(unit="steps"), "per_turn says how many"),
        (dict(per_turn=3200), "per_turn says how many"),
        (dict(unit="turn"), "unit must be one of"),
        (dict(axes=("X", "X")), "axes must be two letters"),
        (dict(axes=("X", "Q")), "axes must be two letters"),
        (dict(firmware="marlin", feed="inverse"), "no inverse time"),
        (dict(pen="servo", down=1.0, up=2.0), "grbl has no pen='servo'"),
        (dict(firmware="marlin", pen="servo"), "needs down and up"),
        (dict(axes=("X", "Z"), pen="Z"), "a joint on the axis Z"),
        (dict(pen="Z", down=5.0), "down and up that differ, .*: with 5 and 5"),
        (dict(firmware="marlin", pen="servo", down=30.0, up=30.0), "with 30 and 30"),
        (dict(down=0.0), "with 0 and 0 it would not move"),
        (dict(deviation=0.0), "deviation must be"),
    ],
)
def test_bad_dialects_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        fb.Gcode(**options)


@pytest.mark.parametrize(
    "line, words",
    [
        ("G1 X1", "without F"),
        ("G2 X1 Y1 I1 F5", "is not read"),
        ("G4", "without its seconds"),
        ("hello", "is not read"),
        ("M3", "is not read"),
    ],
)
def test_what_the_reader_does_not_know_is_named_with_its_line(line, words):
    with pytest.raises(ValueError, match=f"line 3: .*{words}|line 3: {words}"):
        read_joint_gcode(
            f"G0 X0 Y0\nG1 X1 Y1 F60\n{line}\n"
            if "X1" not in line or "G2" in line
            else f"G93\nG0 X0 Y0\n{line}\n"
        )


@pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 comes with Debian's linuxcnc-uspace"
)
@pytest.mark.parametrize("name", ["grbl", "units", "linuxcnc"])
def test_linuxcnc_takes_the_same_time(name, motion, tmp_path):
    for file in ("tool.tbl", "a.var"):
        (tmp_path / file).touch()
    fb.export(motion, "gcode", tmp_path / "a.ngc", machine=PLOTCLOCK, dialect=DIALECTS[name])
    command = ["rs274", "-t", "tool.tbl", "-v", "a.var", "-g", "a.ngc", "out.txt"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    place, feed, t = None, None, 0.0
    pattern = r"(STRAIGHT_TRAVERSE|SET_FEED_RATE|STRAIGHT_FEED|DWELL)\(([^)]*)\)"
    for what, values in re.findall(pattern, (tmp_path / "out.txt").read_text("utf-8")):
        numbers = [float(value) for value in values.split(",")]
        if what == "SET_FEED_RATE":
            feed = numbers[0]
        elif what == "DWELL":
            t += numbers[0]
        else:
            if what == "STRAIGHT_FEED":
                t += 60 * math.dist(numbers, place) / feed
            place = numbers
    assert t == pytest.approx(motion.duration, rel=1e-3)  # it prints four decimals


@pytest.mark.deep
def test_from_a_drawing_to_gcode_of_a_plotclock(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("x,y\n0,0\n30,0\n30,20\n", encoding="utf-8")
    options = ["--fit", "--robot", "plotclock", "--format", "gcode", "--units", "mm"]
    out = ["--out", str(tmp_path / "out"), "--json"]
    drawing = str(tmp_path / "a.csv")
    assert main(["draw", drawing, *options, "--sign", "-1", "1", *out]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["certified"] and figures["working"] == [1, -1]
    assert figures["max_error_m"] <= 2e-5 and figures["speed_error"] <= 0.01
    names = [file.split("/")[-1] for file in figures["files"]]
    assert names == ["drawing.png", "drawing.nc", "proof.json"]
    text = (tmp_path / "out/drawing.nc").read_text("utf-8")
    x = float(re.search(r"G0 X(\S+)", text)[1])
    assert x < 0  # the left motor counts to the right


@pytest.mark.parametrize(
    "options, words",
    [
        (["--pen", "Z"], "--pen goes with --format gcode"),
        (["--format", "gcode", "--steps-per-turn", "1", "--mm-per-turn", "1"], "in steps or in mm"),
        (
            ["--format", "gcode", "--robot", "reprapfirmware", "--sign", "-1", "1"],
            "has a table readings",
        ),
        (["--format", "gcode", "--axes", "X", "X"], "axes must be two letters"),
    ],
)
def test_bad_options_are_refused(options, words, capsys):
    assert main(["draw", "--example", *options]) == 2
    assert words in capsys.readouterr().err
