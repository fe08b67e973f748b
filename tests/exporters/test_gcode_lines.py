"""What each line of joint-space G-code says, found from the text and the motion alone."""

import functools
import math
import re
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.exporters import gcode
from fivebar.exporters.gcode_replay import JointProgram, read_joint_gcode, replayed
from fivebar.paths.strokes import with_pen_time

LIMITS = fb.Constraints(speed=0.05, acceleration=0.5)
ROBOT = fb.FiveBar(l11=0.1, l21=0.08)
PLAIN = fb.Machine(ROBOT)
TURNED = fb.Machine(ROBOT, offset=(0.3, -0.2), ratio=(-1.5, 0.25))
LOOSE = dict(deviation=1e-3, speed_error=0.3)


@functools.cache
def motion_at(y, robot=ROBOT):
    strokes = [[(0.0, y), (0.02, y)], [(0.02, y + 0.01), (0.0, y + 0.01)]]
    return fb.time_path(robot, with_pen_time(fb.path(strokes), 0.2), constraints=LIMITS)


@pytest.fixture(scope="module", params=[0.11, -0.13], ids=["above", "below"])
def motion(request):
    """In both assembly modes."""
    return motion_at(request.param)


@pytest.fixture(scope="module")
def above():
    return motion_at(0.11)


def told(text):
    """Of each axis what the head says of its joint: (name, m or rad for one of it, offset, unit)."""
    found = re.findall(r"(q\d+|y\d) = (\S+) ([XYAB]) \+ (\S+) (rad|m)\b", text)
    return {axis: (name, float(one), float(at), unit) for name, one, axis, at, unit in found}


def moves(text):
    """Seconds and axes, at the end, of each line that takes time; G93 and G94."""
    at, seconds, rows, inverse = (), 0.0, [], False
    for line in text.splitlines():
        words = dict(re.findall(r"([A-Z])([-+.\d]+)", re.sub(r"\(.*\)|;.*", "", line)))
        code = words.get("G")
        inverse = code == "93" if code in ("93", "94") else inverse
        if code in ("0", "1"):
            values = tuple(float(words[axis]) for axis in words if axis in "XYAB")
            if code == "1":
                way = 1.0 if inverse else math.dist(values, at)
                seconds += 60 * way / float(words["F"])
            at = values or at
        elif code == "4":
            seconds += float(words.get("P") or words["S"])
        if code in ("0", "1", "4") and len(at) == 2:
            rows.append((seconds, *at))
    return np.array(rows)


DIALECTS = {
    "grbl": fb.Gcode(**LOOSE),
    "units": fb.Gcode(feed="units", **LOOSE),
    "steps": fb.Gcode(unit="steps", per_turn=3200, gear=5.0, **LOOSE),
    "mm": fb.Gcode(firmware="fluidnc", unit="mm", per_turn=40.0, axes="AB", **LOOSE),
    "rad": fb.Gcode(firmware="linuxcnc", unit="rad", pen="Z", **LOOSE),
    "marlin": fb.Gcode(firmware="marlin", **LOOSE),
    "rrf": fb.Gcode(firmware="reprapfirmware", pen="M3", down=7, **LOOSE),
}


@pytest.mark.every(5)
@pytest.mark.parametrize("machine", [PLAIN, TURNED], ids=["plain", "turned"])
@pytest.mark.parametrize("name", DIALECTS)
def test_the_joints_are_at_the_end_of_each_line_where_the_head_says(name, machine, motion):
    dialect = DIALECTS[name]
    text = fb.export(motion, "gcode", machine=machine, dialect=dialect)
    head, (t, *axes) = told(text), moves(text).T
    assert list(head) == list(dialect.axes)
    assert [each[0] for each in head.values()] == ["q11", "q21"]
    expected, _ = motion.joints(t)
    for k, (_, one, at, unit) in enumerate(head.values()):
        assert unit == "rad" and at == machine.offset[k]
        off = np.abs(np.exp(1j * (one * axes[k] + at)) - np.exp(1j * expected[:, k]))
        assert off.max() < 2e-3  # a tenth of the deviation, on bars of 0.1 m
    assert t[-1] == pytest.approx(motion.duration, rel=1e-3)


@pytest.mark.parametrize("name", DIALECTS)
def test_the_head_counts_the_lines_and_names_the_axes(name, above):
    dialect = DIALECTS[name]
    text = fb.export(above, "gcode", machine=PLAIN, dialect=dialect)
    seconds, count, most, who, within = re.search(
        r"([\d.]+) s, (\d+) lines, at most (\S+) lines/s; (.*) within (\d+) um", text
    ).groups()
    rows = [line for line in text.splitlines() if line.startswith(("G1 ", "G4 "))]
    assert int(count) == len(rows) and float(seconds) == pytest.approx(above.duration, rel=1e-5)
    t = moves(text)[:, 0]
    shortest = np.diff(t)[np.diff(t) > 1e-9].min()
    assert float(most) == pytest.approx(1 / shortest, rel=0.02)
    assert (who, int(within)) == ("joint C", 1000)
    units = {"steps": "steps", "mm": "mm", "rad": "readings", "deg": "degrees"}
    turn = {"steps": ", 3200 a turn of the motor, gear 5", "mm": ", 40 a turn of the motor"}
    left, right = dialect.axes
    said = (
        f"axes {left} left, {right} right, in {units[dialect.unit_of(PLAIN)]}{turn.get(name, '')}"
    )
    marlin = dialect.firmware in ("marlin", "reprapfirmware")
    lines = text.splitlines()
    assert lines[1] == (f"; {said}" if marlin else f"({said})")
    title = "fivebar: joint angles of a five-bar robot, working modes"
    assert lines[0] == (f"; {title} (-1, -1)" if marlin else f"({title} [-1, -1])")
    assert lines[4][1:].strip(" )").startswith("the first move is straight in the joints: start")
    assert lines[5:7] == ["G21", "G90"]
    assert lines[-1] == ("M400" if marlin else "M2")
    assert (lines[-2] == "G94") == dialect.inverse_time == ("G93" in lines)
    assert (" S0.2" in text) == marlin and (" P0.2" in text) != marlin


@pytest.mark.parametrize(
    "options, up, down",
    [
        (dict(), "M5", "M3 S1000"),
        (dict(down=12.5, up=3), "M5", "M3 S12.5"),
        (dict(pen="Z"), "G0 Z5", "G0 Z0"),
        (dict(pen="Z", down=-0.5), "G0 Z5", "G0 Z-0.5"),
        (dict(pen="Z", up=2.0), "G0 Z2", "G0 Z0"),
        (dict(firmware="marlin"), "G0 Z5", "G0 Z0"),
        (dict(firmware="reprapfirmware", pen="M3"), "M5", "M3 S1000"),
        (dict(firmware="marlin", pen="servo", down=30, up=0), "M280 P0 S0", "M280 P0 S30"),
    ],
)
def test_the_pen_goes_down_for_each_stroke_and_ends_up(options, up, down, above):
    dialect = fb.Gcode(**options, **LOOSE)
    assert dialect.pen_commands == (up, down)
    text = fb.export(above, "gcode", machine=PLAIN, dialect=dialect)
    found = [line for line in text.splitlines() if line in (up, down)]
    assert found == [up, down, up, down, up]


def test_the_pen_is_lifted_before_the_end_where_no_rest_follows():
    path = with_pen_time(fb.path([[(0.0, 0.11), (0.02, 0.11)]]), 0.0)
    text = fb.export(fb.time_path(ROBOT, path, constraints=LIMITS), "gcode")
    assert text.splitlines()[-3:] == ["M5", "G94", "M2"]
    assert "G4" not in text


def test_both_joints_come_from_below(above):
    dialect = fb.Gcode(approach=0.04, **LOOSE)
    text = fb.export(above, "gcode", machine=TURNED, dialect=dialect)
    found = re.findall(r"G0 X(\S+) Y(\S+)\nG0 X(\S+) Y(\S+)\nM3", text)
    assert len(found) == 2
    for row in np.array(found, float):
        for k, (_, one, _, _) in enumerate(told(text).values()):
            assert one * (row[2 + k] - row[k]) == pytest.approx(0.04, abs=1e-3)


def test_the_turn_is_the_one_of_the_limits_or_the_one_about_upwards():
    below = motion_at(-0.13)
    q = np.degrees(below.robot.continuous(below.joints(np.linspace(0, below.duration, 50))[0]))
    limits = [(2 * math.pi, 4 * math.pi - 0.1), (-4 * math.pi, -2 * math.pi - 0.1)]
    for joints in (None, limits, [None, limits[1]]):
        machine = fb.Machine(ROBOT, constraints=fb.Constraints(joints=joints))
        _, *axes = moves(fb.export(below, "gcode", machine=machine, dialect=fb.Gcode(**LOOSE))).T
        for k, (low, high) in enumerate(
            np.degrees(each) if each else (-90, 270) for each in joints or (None, None)
        ):
            middle = q[:, k].min() / 2 + q[:, k].max() / 2
            turns = [n for n in range(-4, 5) if low - 60 <= middle + 360 * n <= high + 60]
            nearest = min(turns, key=lambda n: abs(middle + 360 * n - (low + high) / 2))
            assert axes[k][0] == pytest.approx(q[0, k] + 360 * nearest, abs=0.2)


def test_feeds_up_to_the_limit_pass_and_the_axis_beyond_it_is_named(above):
    text = fb.export(above, "gcode", machine=TURNED, dialect=fb.Gcode(**LOOSE))
    rows = moves(text)
    rows = rows[np.append(np.diff(rows[:, 0]) > 1e-9, True)]
    feeds = 60 * np.abs(np.diff(rows[:, 1:], axis=0)) / np.diff(rows[:, :1], axis=0)
    k, axis = divmod(int(feeds.argmax()), 2)
    most = feeds[k, axis]
    fine = fb.Gcode(max_feed=1.001 * most, **LOOSE)
    assert fb.export(above, "gcode", machine=TURNED, dialect=fine) == text
    with pytest.raises(ValueError) as caught:
        fb.export(above, "gcode", machine=TURNED, dialect=replace(fine, max_feed=most / 2))
    name, feed, unit, at, limit, share = re.search(
        r"axis (\w) moves at (\S+) (\w+)/min at t = (\S+) s, beyond the (\S+) of .* to (\S+) of",
        str(caught.value),
    ).groups()
    assert (name, unit, float(share)) == ("XY"[axis], "deg", 0.5)
    assert float(feed) == pytest.approx(most, rel=1e-4)
    assert float(limit) == pytest.approx(most / 2, rel=1e-4)
    assert rows[k, 0] <= float(at) + 1e-3 and float(at) <= rows[k + 1, 0] + 1e-3


def tip_moved_by_units(motion, machine, t, scale):
    """m, by one unit of both axes where it is most, by differences of poses."""
    moved, q = 0.0, motion.joints(t)[0]
    start = fb.igm(motion.robot, motion(0.0)[0], motion.working)
    for step in np.diag(machine.ratio) / scale * 1e-6:
        first, second = (
            fb.dgm(motion.robot, q + side * step, int(start.assembly)) for side in (-1, 1)
        )
        moved += np.linalg.norm(second.xi - first.xi, axis=-1).max() / 2e-6
    return moved


@pytest.mark.every(5)
@pytest.mark.parametrize("share", np.geomspace(1.0, 10.0, 12)[:-1])
@pytest.mark.parametrize("of", ["deviation", "speed_error"])
def test_axes_have_as_many_decimals_as_rounding_to_a_fifth_needs(of, share, motion):
    options = dict(deviation=1e-3, speed_error=0.5) | {of: share * {"d": 1e-4, "s": 0.03}[of[0]]}
    dialect = fb.Gcode(unit="steps", per_turn=200, **options)
    text = fb.export(motion, "gcode", machine=TURNED, dialect=dialect)
    decimals = len(re.search(r"G1 X[-\d]+\.?(\d*)", text)[1])
    t = np.unique(moves(text)[:, 0])
    t = np.append(t[:-1][np.diff(t) > 1e-6], t[-1])
    unit = tip_moved_by_units(motion, TURNED, t, 200 / (2 * math.pi))
    speed = np.linalg.norm(motion(np.linspace(0, motion.duration, 1000))[1], axis=-1).max()
    allowed = 0.2 * min(dialect.deviation, dialect.speed_error * speed * np.diff(t).min())
    # Where a line is as good as the bound, either number will do.
    assert decimals in {max(0, math.ceil(math.log10(unit / allowed) + e)) for e in (-0.01, 0.01)}


def test_microsteps_far_below_the_deviation_are_whole(above):
    dialect = fb.Gcode(unit="steps", per_turn=1e7, **LOOSE)
    assert re.search(r"\nG1 X-?\d+ Y-?\d+ F", fb.export(above, "gcode", dialect=dialect))


@pytest.mark.parametrize(
    "options, kept",
    [(dict(deviation=2e-4, speed_error=1.0), 0), (dict(deviation=0.1, speed_error=0.2), 1)],
)
def test_lines_are_as_long_as_what_is_allowed(options, kept, motion):
    """They use a good part of it and never more, and a tenth of it takes more lines."""
    found, counts = [], []
    for share in (1.0, 0.1):
        dialect = fb.Gcode(
            deviation=options["deviation"] * share, speed_error=options["speed_error"] * share
        )
        program = read_joint_gcode(fb.export(motion, "gcode", dialect=dialect), dialect)
        replay = replayed(program, motion, dialect=dialect)
        found.append(
            (replay.deviation / dialect.deviation, replay.speed_error / dialect.speed_error)[kept]
        )
        counts.append(len(program.down))
    assert all(0.3 < each <= 1 for each in found) and counts[1] > 2 * counts[0]


def test_too_many_lines_are_refused(above, monkeypatch):
    dialect = fb.Gcode(deviation=2e-5, speed_error=0.05)
    count = len(read_joint_gcode(fb.export(above, "gcode", dialect=dialect)).down)
    monkeypatch.setattr(gcode, "MOST_LINES", count)
    fb.export(above, "gcode", dialect=dialect)
    monkeypatch.setattr(gcode, "MOST_LINES", count - 1)
    with pytest.raises(ValueError) as caught:
        fb.export(above, "gcode", dialect=dialect)
    assert str(caught.value) == (
        f"gcode: more than {count - 1} lines keep a deviation of 2e-05 m and a speed error of 0.05:"
        " allow more of them"
    )


@pytest.mark.parametrize(
    "options, message",
    [
        (dict(firmware="tinyg"), "Gcode: firmware must be one of grbl, fluidnc, linuxcnc, marlin,"),
        (dict(unit="turns"), "Gcode: unit must be one of deg, steps, mm, rad, not 'turns'"),
        (dict(feed="fast"), "Gcode: feed must be one of inverse, units, not 'fast'"),
        (dict(pen="laser"), "Gcode: pen must be one of M3, servo, Z, not 'laser'"),
        (dict(gear=0.0), "Gcode: gear must be finite and > 0"),
        (dict(unit="mm", per_turn=-1.0), "Gcode: per_turn must be finite and > 0"),
        (dict(max_feed=0.0), "Gcode: max_feed must be finite and > 0"),
        (dict(deviation=0.0), "Gcode: deviation must be finite and > 0"),
        (dict(speed_error=0.9e-6), "Gcode: speed_error must be finite and from 1e-06 to 1"),
        (dict(speed_error=1.01), "Gcode: speed_error must be finite and from 1e-06 to 1"),
        (dict(approach=-0.1), "Gcode: approach must be finite and >= 0"),
        (dict(down="low"), "Gcode: down must be a number, not 'low'"),
        (dict(up=math.nan), "Gcode: up must be finite"),
        (dict(unit="steps"), "Gcode: per_turn says how many steps or mm are a turn of the motor:"),
        (dict(unit="rad", per_turn=4), "Gcode: per_turn says how many steps or mm are a turn"),
        (dict(firmware="marlin", feed="inverse"), "Gcode: marlin has no inverse time (G93): leave"),
        (dict(pen="servo"), "Gcode: grbl has no pen='servo': take M3 or Z"),
        (dict(axes=("X", "Z"), pen="Z"), "Gcode: pen='Z' and a joint on the axis Z"),
        (dict(axes=("Z", "X"), firmware="marlin"), "Gcode: pen='Z' and a joint on the axis Z"),
        *(
            (
                dict(firmware="marlin", pen="servo") | one,
                "Gcode: pen='servo' needs down and up that differ",
            )
            for one in (dict(), dict(down=1.0), dict(up=1.0))
        ),
        *(
            (
                dict(axes=axes),
                f"Gcode: axes must be two letters of X, Y, Z, A, B, C, U, V, W, not {axes!r}",
            )
            for axes in (("X", "X"), ("X",), "XYZ", ("X", "Q"), ("Q", "X"), 3, ["XY", "Z"], None)
        ),
    ],
)
def test_what_is_wrong_in_a_dialect_is_named(options, message):
    with pytest.raises(ValueError) as caught:
        fb.Gcode(**options)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    "options",
    [
        dict(speed_error=1e-6),
        dict(speed_error=1.0),
        dict(axes=("Y", "Z")),
        dict(axes=("U", "W"), pen="Z"),
        dict(pen="servo", down=0.0, up=1.0, firmware="marlin"),
        dict(down=1.0),
        dict(up=1.0),
        dict(max_feed=1.0),
        dict(firmware="marlin", feed="units"),
        dict(firmware="marlin", axes="ZA", pen="M3"),
    ],
)
def test_what_firmware_has_is_taken(options):
    dialect = fb.Gcode(**options)
    assert dialect.axes == tuple(options.get("axes", "XY"))
    assert dialect.inverse_time == (dialect.firmware == "grbl")


def test_feed_says_whether_lines_have_their_times():
    for firmware in ("grbl", "fluidnc", "linuxcnc"):
        assert fb.Gcode(firmware=firmware).inverse_time
        assert fb.Gcode(firmware=firmware, feed="inverse").inverse_time
        assert not fb.Gcode(firmware=firmware, feed="units").inverse_time


def test_another_robot_sliding_joints_and_type_2_are_refused(above):
    with pytest.raises(ValueError, match="^gcode: the motion is of another robot than the machine"):
        fb.export(above, "gcode", machine=fb.Machine(fb.FiveBar()))
    slide = fb.time_path(
        fb.Biglide(),
        fb.path([(0.0, 0.2), (0.02, 0.22)]),
        constraints=fb.Constraints(acceleration=1.0),
    )
    with pytest.raises(
        ValueError, match="joints of a biglide slide, they have no angles, of which"
    ):
        fb.export(slide, "gcode", dialect=fb.Gcode(unit="deg"))
    text = fb.export(slide, "gcode", dialect=fb.Gcode(**LOOSE))
    head, (t, *axes) = told(text), moves(text).T
    assert [each[3] for each in head.values()] == ["m", "m"]
    assert [each[1] for each in head.values()] == [1e-3, 1e-3] and "in mm)\n" in text
    np.testing.assert_allclose(1e-3 * np.transpose(axes), slide.joints(t)[0], atol=2e-4)
    assert fb.export(slide, "gcode", dialect=fb.Gcode(unit="mm", **LOOSE)) == text
    in_mm = fb.Machine(fb.Biglide(), ratio=(0.001, 0.001))  # what it reads is written as it is
    assert moves(
        fb.export(slide, "gcode", machine=in_mm, dialect=fb.Gcode(**LOOSE))
    ) == pytest.approx(moves(text))
    for dialect, machine, words in (
        (dict(unit="mm", per_turn=4.0), None, "unit='mm' has no per_turn: the joints slide"),
        (dict(unit="mm"), in_mm, "read 1000 a m, by the ratio of the machine: mm could be"),
        (dict(max_feed=500.0), None, r"moves at .* mm/min at"),
        (dict(max_feed=500.0), in_mm, r"moves at .* readings/min at"),
    ):
        with pytest.raises(ValueError, match=words):
            fb.export(slide, "gcode", machine=machine, dialect=fb.Gcode(**dialect))
    with pytest.raises(ValueError, match="unit='mm' needs per_turn"):
        fb.Machine(fb.FiveBar()).scale("mm")


@pytest.mark.parametrize(
    "y, wrong", [(0.11, "early"), (-0.13, "late"), (0.11, "pen"), (0.11, "place")]
)
def test_a_replay_finds_what_is_wrong(y, wrong):
    """Of a program that is the motion itself in short lines, and of one that is wrong in one thing."""
    motion = motion_at(y)
    t = np.unique(np.append(np.linspace(0, motion.duration, 150), motion.pen_changes[0]))
    q = motion.robot.continuous(motion.joints(t)[0])
    down = motion.pen((t[:-1] + t[1:]) / 2)
    dialect = fb.Gcode(unit="rad")
    good = replayed(JointProgram(t, q, down), motion, dialect=dialect)
    assert good.deviation < 2e-5 and good.pen_errors == 0 and good.duration == t[-1]
    assert good.speed_error < 0.2 and len(good.t) == len(good.off) == len(good.down)
    np.testing.assert_allclose(good.tip, motion(good.t)[0], atol=2e-5)
    assert repr(good).startswith(f"<Replay: {1e6 * good.deviation:.4g} µm off, speeds off by")
    assert repr(good).endswith(f" by {100 * good.speed_error:.3g} %, {t[-1]:.6g} s>")
    if wrong == "pen":
        down[[3, 50, 90]] ^= True
        bad = replayed(JointProgram(t, q, down), motion, dialect=dialect)
        assert bad.pen_errors == 3 and repr(bad).endswith("pen wrong on 3 lines>")
    elif wrong == "place":
        bad = replayed(JointProgram(t, q + (0.01, 0.0), down), motion, dialect=dialect)
        moved = fb.dgm(ROBOT, q + (0.01, 0.0)).xi - fb.dgm(ROBOT, q).xi
        most = np.linalg.norm(moved, axis=-1).max()
        assert bad.deviation == pytest.approx(most, abs=3e-5)
    else:
        pace = {"early": 0.8, "late": 1.25}[wrong]
        bad = replayed(JointProgram(pace * t, q, down), motion, dialect=dialect)
        assert bad.duration == pytest.approx(pace * motion.duration)
        assert bad.deviation > 1e-3 and bad.speed_error > 0.15


def test_joints_out_of_reach_are_refused(above):
    program = JointProgram(
        np.array([0.0, 1.0]), np.array([[0.0, 0.0], [3.1, 0.0]]), np.array([False])
    )
    with pytest.raises(fb.UnreachableError, match="^joint G-code: its joints cannot be reached$"):
        replayed(program, replace_d(above), dialect=fb.Gcode(unit="rad"))


def replace_d(motion):
    """The same strokes by a robot that does not close everywhere."""
    return motion_at(0.11, replace(motion.robot, d=0.16))


READ = """\
; a comment
g21
G90 (another)
M5
G0 X1 Y2
G0 Y4
M3 S1000
G1 X4 Y8 F60
G1 X-2
G4 P0.5
G93
M5
G1 Y-8.5 F120
G0 X1
G0 X-2
G94
G1 X.5 F30
M2
"""


def test_lines_are_read_as_a_controller_runs_them():
    program = read_joint_gcode(READ)
    seconds = [5.0, 6.0, 0.5, 0.5, 5.0]
    np.testing.assert_allclose(program.t, np.append(0.0, np.cumsum(seconds)), rtol=1e-15)
    axes = [(1, 4), (4, 8), (-2, 8), (-2, 8), (-2, -8.5), (0.5, -8.5)]
    np.testing.assert_array_equal(program.axes, axes)
    assert program.down.tolist() == [True, True, True, False, False]
    assert repr(program) == "<JointProgram: 5 lines, 17 s>"
    assert not read_joint_gcode("G0 X0 Y0\nG1 X1 F5\n").down.any()


@pytest.mark.parametrize(
    "text, message",
    [
        ("G21\n", "joint G-code: no move"),
        ("G0 X0 Y0\n", "joint G-code: no move"),
        ("G4 P1\n", "joint G-code: no move"),
        ("G0 X0 Y0\nG1 X1\n", "joint G-code, line 2: a move without F, or from no known place"),
        ("G0 X0 Y0\nG1 X1 F0\n", "joint G-code, line 2: a move without F"),
        ("G1 X1 Y1 F5\n", "joint G-code, line 1: a move without F, or from no known place"),
        ("G0 X1\nG1 X1 Y1 F5\n", "joint G-code, line 2: a move without F, or from no known"),
        ("G93\nG0 X0 Y0\nG1 X1 F5\nG1 X2\n", "joint G-code, line 4: a move without F"),
        ("G0 X0 Y0\nG1 X1 F5\nG93\nG1 X2\n", "joint G-code, line 4: a move without F"),
        ("G0 X0 Y0\nG4 S1\n", "joint G-code, line 2: G4 without its seconds"),
        ("G0 X0 Y0 Z1\n", "joint G-code, line 1: 'G0 X0 Y0 Z1' is not read"),
        ("G0 X0 Y0 ?\n", "joint G-code, line 1: 'G0 X0 Y0 ?' is not read"),
        ("G90 G0 X0 Y0\n", "joint G-code, line 1: 'G90 G0 X0 Y0' is not read"),
        ("G28\n", "joint G-code, line 1: 'G28' is not read"),
        ("X1 Y1\n", "joint G-code, line 1: 'X1 Y1' is not read"),
        (
            "G0 X0 Y0\nG1 X1 F5\nG0 X3 Y4\nG1 X2\n",
            "joint G-code, line 4: rapid moves before it led from (1.0, 0.0) to (3.0, 4.0)",
        ),
    ],
)
def test_a_line_that_is_not_read_is_named(text, message):
    with pytest.raises(ValueError) as caught:
        read_joint_gcode(text)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("firmware", gcode.FIRMWARES)
def test_what_each_firmware_is_written_is_read(firmware, above):
    """Of each pen, with heights and angles that are not the usual ones."""
    for pen in gcode.FIRMWARES[firmware].pens:
        for down, up in ((15, 19), (19.5, 15)):
            dialect = fb.Gcode(firmware, pen=pen, down=down, up=up, **LOOSE)
            program = read_joint_gcode(fb.export(above, "gcode", dialect=dialect), dialect)
            replay = replayed(program, above, dialect=dialect)
            assert replay.pen_errors == 0 and replay.deviation < LOOSE["deviation"]
            assert 0 < program.down.sum() < len(program.down)
