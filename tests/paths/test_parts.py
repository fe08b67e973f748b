"""Strokes, pieces, readers, setpoints and machines, each against the same computed by hand."""

import io
import json
import math

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.fit import Bezier, Ellipse, fitted, quintic
from fivebar.paths.pieces import Arc, Line, Polynomial
from fivebar.paths.reading.draft import Draft, Move, listed
from fivebar.paths.setpoints import setpoints
from fivebar.paths.strokes import cut, outlines, with_leads, with_pen_time

ROBOT = fb.FiveBar()


# Strokes


SQUARE = (Line((0, 0), (1, 0)), Line((1, 0), (1, 1)), Line((1, 1), (0, 1)), Line((0, 1), (0, 3)))
PATH = Path(
    SQUARE,
    (True, True, False, True),
    {1.0: 0.5, 3.0: 0.2},
    (0.1, 0.2, 0.3, 0.4),
    lines=(1, 2, 3, 4),
)


def test_outlines_are_points_on_each_stroke():
    first, second = outlines(PATH, 3)
    assert first.tolist() == [[0, 0], [0.5, 0], [1, 0], [1, 0], [1, 0.5], [1, 1]]
    assert second.tolist() == [[0, 1], [0, 2], [0, 3]]
    assert [len(each) for each in outlines(PATH)] == [66, 33]


def test_the_pen_takes_its_time_at_both_ends_of_a_stroke():
    assert with_pen_time(PATH, 0.3).dwells == {0.0: 0.3, 1.0: 0.5, 2.0: 0.3, 3.0: 0.5, 5.0: 0.3}


def test_strokes_are_cut_apart():
    first, second = cut(PATH)
    assert first.pieces == SQUARE[:2] and second.pieces == SQUARE[3:]
    assert first.dwells == {1.0: 0.5} and second.dwells == {0.0: 0.2}
    assert first.feed == (0.1, 0.2) and second.lines == (4,)


def test_leads_are_straight_on_at_both_ends_of_a_stroke():
    led = with_leads(PATH, 0.5)
    ends = [(-0.5, 0), (0, 0), (1, 0), (1, 1), (1, 1.5), (0, 0.5), (0, 1), (0, 3), (0, 3.5)]
    for piece, start, end in zip(led.pieces, ends[:-1], ends[1:], strict=True):
        np.testing.assert_allclose([piece.start, piece.end], [start, end], atol=1e-15)
    assert led.pen == (False, True, True, False, False, False, True, False)
    assert led.feed == (np.inf, 0.1, 0.2, np.inf, np.inf, np.inf, 0.4, np.inf)
    assert led.lines == (1, 1, 2, 2, 4, 4, 4, 4)
    assert led.dwells == {1.5: 0.5} and not led.rests_for_pen


# Paths


def test_a_path_says_what_it_is():
    words = "4 pieces, 5 m, 4 m of it drawn, from = (0, 0) m, to = (0, 3) m, 3 stops on the way"
    assert repr(PATH) == f"<Path: {words}>"
    plain = Path(SQUARE[:1])
    assert "drawn" not in repr(plain) and "stops" not in repr(plain)


def test_lines_of_the_file_along_a_path():
    places = (0.0, 0.5, 1.0, 1.5, 2.999, 3.0, 5.0)
    assert [PATH.line_of(s) for s in places] == [1, 1, 2, 2, 3, 4, 4]
    assert Path(SQUARE).line_of(0.3) is None


def test_dwells_at_one_knot_add_up_and_move_with_the_path():
    path = Path(SQUARE, dwells={1.0: 0.5, 1.0 + 1e-10: 0.25, 2.0: 0.0})
    assert path.dwells == {1.0: 0.75}
    larger = fb.Placement(scale=2.0)(path)
    assert larger.dwells == {2.0: 0.75} and larger.length == 10.0
    with pytest.raises(ValueError, match=r"a dwell at s = 1.001 m is at no knot; the nearest.* 1$"):
        Path(SQUARE, dwells={1.001: 1.0})


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_a_dwell_is_at_its_knot_whatever_the_size(size):
    line = Line((0, 0), (size, 0)), Line((size, 0), (2 * size, 0))
    assert Path(line, dwells={size * (1 + 1e-9): 1.0}).dwells == {size: 1.0}
    with pytest.raises(ValueError, match="is at no knot"):
        Path(line, dwells={size * (1 + 1e-8): 1.0})


@pytest.mark.parametrize(
    "options, words",
    [
        ({"pen": (1, 0, 2, 0)}, "Path: pen must be True or False, not 2"),
        ({"pen": True}, "Path: pen must be a list or a tuple, not True"),
        ({"feed": (1, 1, 0, 1)}, "Path: feed must be finite and > 0"),
        ({"feed": (1, 1, -math.inf, 1)}, "Path: feed must be finite and > 0"),
        ({"lines": (1, 2, 0, 3)}, "Path: lines must be a whole number >= 1"),
        ({"lines": (1, 2)}, "Path: lines has 2 values for 4 pieces"),
        ({"notes": "all"}, "Path: notes must be a list or a tuple"),
        ({"dwells": (1.0,)}, "Path: dwells must be {s: seconds}"),
        ({"dwells": {1.0: -1.0}}, "Path: seconds of dwells must be"),
        ({"rests_for_pen": "no"}, "Path: rests_for_pen must be True or False"),
    ],
)
def test_bad_parts_of_a_path(options, words):
    with pytest.raises((ValueError, TypeError), match=words):
        Path(SQUARE, **options)


def test_a_motion_may_go_on_where_the_pen_changes():
    line = (Line((0, 0), (1, 0)), Line((1, 0), (2, 0)))
    assert [stop.s for stop in Path(line, (True, False)).stops] == [0, 1, 2]
    assert [stop.s for stop in Path(line, (True, False), rests_for_pen=False).stops] == [0, 2]


# Curves


def test_a_quintic_has_both_ends_points_tangents_and_curvatures():
    ends = ((1 + 2j, 0.6 + 0.8j, -0.3 + 0.1j), (2 - 1j, -1j, 0.5))
    c = quintic(tuple(tuple(np.array([v]) for v in end) for end in ends), np.array([1.7]))[:, 0]
    for u, end in zip((0.0, 1.0), ends):
        for order, value in enumerate(end):
            derivative = np.polynomial.polynomial.polyder(c, order)
            here = np.polynomial.polynomial.polyval(u, derivative) / 1.7**order
            assert here == pytest.approx(value, abs=1e-13)


@pytest.mark.parametrize("within", [1e-5, 1e-8, 1e-11])
def test_a_circle_is_fitted_by_as_few_quintics_as_keep_the_distance(within):
    """Halves of halves; how far each is off the circle is told by its distance from the centre."""
    u = np.linspace(0, 1, 301)
    count = 1
    while True:
        angle = 2.0 / count
        turn = np.exp(1j * angle)
        ends = ((0.1, 1j, -10), (0.1 * turn, 1j * turn, -10 * turn))
        ends = tuple(tuple(np.array([v]) for v in end) for end in ends)
        curve = np.polynomial.polynomial.polyval(u, quintic(ends, np.array([0.1 * angle]))[:, 0])
        if np.abs(np.abs(curve) - 0.1).max() <= within:
            break
        count *= 2
    (pieces,) = fitted([Ellipse(0j, 0.1, 0.1j, 0.0, 2.0)], within)
    assert len(pieces) == count
    for piece in pieces:
        z = piece(np.linspace(0, piece.length, 100))[0] @ (1, 1j)
        assert np.abs(np.abs(z) - 0.1).max() <= within


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Bezier(np.array([0, 1, 1e160j, 1])), "a curve reaches beyond"),
        (lambda: Bezier(np.array([0, np.nan, 0, 1])), "a curve reaches beyond"),
        (lambda: Ellipse(0j, np.inf, 1j, 0, 1), "an ellipse reaches beyond"),
    ],
)
def test_curves_beyond_all_bounds(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_curves_are_moved():
    curve = Bezier(np.array([0, 1, 1j, 1 + 1j])).moved(2.0, 1j)
    assert curve.control.tolist() == [2, 2 + 1j, 1, 1 + 1j]
    ellipse = Ellipse(1 + 0j, 2.0, 1j, 0.1, 0.9).moved(1j, 2j)
    assert (ellipse.centre, ellipse.a, ellipse.b) == (3j, 4j, -2)
    assert (ellipse.t0, ellipse.t1) == (0.1, 0.9)


def test_pieces_say_what_they_are():
    arc = Arc((0, 1), 2, 0, -1.5)
    assert repr(arc) == "<Arc: about = (0, 1) m, radius 2 m, from 0 to -1.5 rad>" and arc.side == -1
    assert repr(Line((0, 0), (3, 4))) == "<Line: from = (0, 0) m, to = (3, 4) m>"
    assert "degree 2" in repr(Polynomial([(0, 0), (1, 0), (0, 1)], 1.0))
    part = Line((0, 0), (4, 0)).part(1.0, 4.0)
    assert (part.start, part.end) == ((1.0, 0.0), (4.0, 0.0))
    curve = Polynomial([(0, 0), (1, 0), (0, 1), (2, 0)], 3.0)
    third = curve.part(1.0, 2.0)
    assert third.length == 1.0
    for here, there in zip(third(0.4), curve(1.4)):
        np.testing.assert_allclose(here, there, atol=1e-14)
    half = arc.part(1.0, 3.0)
    assert (half.angle0, half.angle1) == (-0.5, -1.5) and half.length == pytest.approx(2.0)


@pytest.mark.parametrize("shape", [(1, 2), (25, 2), (3, 3), (4,)])
def test_polynomials_of_other_shapes(shape):
    with pytest.raises(ValueError, match=r"coefficients must be \(degree \+ 1, 2\)"):
        Polynomial(np.ones(shape), 1.0)


# Readers


def test_lines_are_listed_once_and_not_too_many():
    assert listed([None]) == "" and listed([3, None, 3]) == " (line 3)"
    assert listed([9, 2, 3, 2]) == " (lines 2, 3, 9)"
    assert listed(range(1, 10)) == " (lines 1, 2, 3, 4, 5, 6, 7, 8, ...)"
    assert listed(range(1, 9)) == " (lines 1, 2, 3, 4, 5, 6, 7, 8)"


def test_a_draft_becomes_a_path():
    """Ways between strokes are straight, dwells stay where they were, short moves are told."""
    draft = Draft("file")
    draft.moves = [
        Move(Line((9, 9), (0, 0)), False, line=1),
        Move(Line((0, 0), (1, 0)), True, 0.5, line=2),
        Move(Line((1, 0), (1, 1e-11)), True, line=3),
        Move(Line((2, 0), (3, 0)), True, 0.25, line=4),
        Move(Line((3, 0), (9, 0)), False, line=5),
    ]
    draft.dwells = [(2, 0.5), (2, 0.25), (4, 1.0)]
    path = draft.finished(fb.Placement(), 0.0, False)
    assert path.pen == (True, False, True) and path.lines == (2, 4, 4)
    assert path.feed == (0.5, np.inf, 0.25) and path.dwells == {1.0: 0.75, 3.0: 1.0}
    assert path.notes == (
        "ways with the pen up before the first stroke and after the last are passed over",
        "1 moves of no length passed over (line 3)",
    )


def gcode(text):
    return fb.path(io.StringIO(text), kind="gcode")


def test_words_of_gcode():
    """Numbers of lines and programs, checksums, codes with a leading 0 and blocks to be left out."""
    path = gcode("O7\nN1 G21*33\nG00 X0 Y0\nN2 G01 X 10 F 120*9\n/G1 X99\nX20\nG1 Y-5. F60\nM02\n")
    assert [piece.length for piece in path.pieces] == pytest.approx([0.01, 0.01, 0.005])
    assert path.feed == pytest.approx((0.002, 0.002, 0.001)) and path.lines == (4, 6, 7)
    assert "block with /: passed over (line 5)" in path.notes


@pytest.mark.parametrize(
    "words, seconds", [("P9.5", 9.5), ("P100", 0.1), ("S50", 50), ("S200", 200), ("P250", 0.25)]
)
def test_dwells_of_gcode(words, seconds):
    path = gcode(f"G21\nG0 X0\nG1 X1\nG4 {words}\nG1 X2\n")
    assert path.dwells == {path.knots[1]: seconds}
    assert any("read as milliseconds" in note for note in path.notes) == (seconds < 1)


@pytest.mark.parametrize("words", ["P10", "P99", "P-1", "S-1"])
def test_dwells_that_could_be_two_things(words):
    with pytest.raises(ValueError, match="line 4: G4 (P(10|99) could be|needs S or P)"):
        gcode(f"G21\nG0 X0\nG1 X1\nG4 {words}\nG1 X2\n")


@pytest.mark.parametrize("code", ["G2", "G3"])
@pytest.mark.parametrize("radius", [8.0, -8.0])
def test_arcs_by_their_radius(code, radius):
    """R > 0 is the shorter arc and R < 0 the longer one, clockwise or not."""
    (arc,) = gcode(f"G21\nG0 X0 Y0\n{code} X10 Y0 R{radius}\n").pieces
    small = 2 * math.asin(5 / 8)
    turn = small if radius > 0 else 2 * math.pi - small
    assert arc.angle1 - arc.angle0 == pytest.approx(turn if code == "G3" else -turn)
    np.testing.assert_allclose([arc.start, arc.end], [(0, 0), (0.01, 0)], atol=1e-15)
    assert arc.radius == pytest.approx(0.008)


def test_a_pen_is_down_at_z_0_and_below():
    text = "G21\nG0 X0 Y0 Z5\nG1 Z0\nG1 X1\nG1 Z0.1\nG1 X2\nG1 Z-1\nG1 X3\nG1 Z5\nG1 X4\n"
    assert gcode(text).pen == (True, False, True)
    spindle = "G21\nM3\nG0 X0 Y0 Z5\nG1 X1 Z-1\nM5\nG1 X2\nM03\nG1 X3\nG1 X4 Z1\n"
    assert gcode(spindle).pen == (True, False, True)


def test_g92_sets_the_origin_and_g28_says_nothing():
    path = gcode("G21\nG92 X10 Y5\nG1 X12 Y5\nG28 X0 Y0\nG91\nG1 X1 Y1\n")
    np.testing.assert_allclose(path.pieces[0].start, (0.01, 0.005))
    np.testing.assert_allclose(path.pieces[-1].end, (0.013, 0.006))
    assert path.pen == (True, True)


# Setpoints and machines


MOTION = fb.line((0.05, 0.09), (0.04, 0.1), 1.0)


def test_rows_of_setpoints_are_at_a_steady_rate():
    table = setpoints(ROBOT, MOTION, 30.0)
    assert len(table.t) == 31 and table.t[1] == pytest.approx(1 / 30)
    uneven = setpoints(ROBOT, MOTION, 10.5)
    assert len(uneven.t) == 12 and uneven.t[-1] > 1.0
    np.testing.assert_allclose(uneven.xi[-1], (0.04, 0.1), atol=1e-15)
    assert "31 rows, 0.0333333 s apart" in repr(table)
    poses = fb.igm(ROBOT, table.xi, (-1, -1))
    np.testing.assert_allclose(table.q, poses.q, atol=1e-14)
    np.testing.assert_allclose(table.q_dot, fb.ikm(poses, table.xi_dot).q_dot, atol=1e-12)
    other = setpoints(ROBOT, MOTION, 30.0, working=(-1, 1))
    assert other.working == (-1, 1) and np.abs(other.q - table.q).max() > 0.1
    with pytest.raises(ValueError, match="setpoints: 1 s at 1e.08 Hz"):
        setpoints(ROBOT, MOTION, 1e8)


def written(table, *arguments):
    file = io.StringIO()
    table.to_csv(file, *arguments)
    head, names, *lines = file.getvalue().splitlines()
    rows = np.array([[float(cell or "nan") for cell in line.split(",")] for line in lines])
    return json.loads(head[head.index("{") :]), names.split(","), rows


@pytest.mark.parametrize(
    "angles, factor", [("rad", 1.0), ("deg", 180 / np.pi), ("turns", 0.5 / np.pi)]
)
def test_a_file_of_setpoints_has_the_drives_readings(angles, factor):
    frame = fb.Placement((0.3, -0.1), 0.7, 2.0)
    machine = fb.Machine(ROBOT, (0.1, -0.2), (2.0, -0.5), frame)
    table = setpoints(ROBOT, MOTION, 20.0, tool=fb.Tool(1, 0.01, 0.002))
    about, names, rows = written(table, angles, machine)
    ending = {"rad": "", "deg": "_deg", "turns": "_turns"}[angles]
    joints = [f"{name}{ending}" for name in ("q1", "q2", "q1_dot", "q2_dot")]
    assert names == ["t", "x", "y", *joints, "x_dot", "y_dot", "x_ddot", "y_ddot"]
    expected = (table.q - (0.1, -0.2)) / (2.0, -0.5) * factor
    np.testing.assert_allclose(rows[:, 3:5], expected, rtol=1e-12)
    np.testing.assert_allclose(rows[:, 5:7], table.q_dot / (2.0, -0.5) * factor, atol=1e-12)
    turn = 2 * np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    np.testing.assert_allclose(rows[:, 1:3], table.xi @ turn.T + (0.3, -0.1), atol=1e-14)
    np.testing.assert_allclose(rows[:, 7:9], table.xi_dot @ turn.T, atol=1e-14)
    np.testing.assert_allclose(rows[:, 9:11], table.xi_ddot @ turn.T, atol=1e-13)
    assert about["offset"] == [0.1, -0.2] and about["ratio"] == [2.0, -0.5]
    assert about["tool"] == {"leg": 1, "along": 0.01, "across": 0.002}
    assert about["frame"] == {"shift": [0.3, -0.1], "turn": 0.7, "scale": 2.0}
    assert about.get("angles", "rad") == angles
    assert set(written(table)[0]) == {"robot", "working", "tool"}
    assert set(written(setpoints(ROBOT, MOTION, 20.0))[0]) == {"robot", "working"}


def test_which_modes_a_machine_was_calibrated_in():
    known = fb.Machine(ROBOT, measured=[(1, -1, -1), (-1, -1, 1)])
    assert known.is_measured((1, -1), -1) and not known.is_measured((1, -1), 1)
    assert fb.Machine(ROBOT).is_measured((1, 1), 1)
    assert known.measured_words == (
        "working modes +1 -1 with assembly mode -1, working modes -1 -1 with assembly mode +1"
    )
    assert "calibrated in working modes +1 -1" in repr(known) and "offset" not in repr(known)
    other = fb.Machine(
        ROBOT, (0.1, 0.0), (1.0, 2.0), fb.Placement((1, 2)), fb.Constraints(torque=1)
    )
    for words in ("offset = (0.1, 0) rad", "ratio = (1, 2)", "Placement", "torque"):
        assert words in repr(other)


@pytest.mark.parametrize(
    "unit, per_turn, ratio, words",
    [
        ("counts", None, 1.0, "unit='counts' needs per_turn"),
        ("deg", 360, 1.0, "unit='deg' has no per_turn"),
        (
            "deg",
            None,
            0.0175,
            r"the drives read 359.039 a turn, by the ratio of the machine: deg could",
        ),
        ("mm", -1, 1.0, "mm per turn must be"),
    ],
)
def test_units_that_could_be_two_things(unit, per_turn, ratio, words):
    with pytest.raises(ValueError, match=words):
        fb.Machine(ROBOT, ratio=(ratio, -ratio)).scale(unit, per_turn)


def test_units_of_drives():
    machine = fb.Machine(ROBOT, ratio=(0.001, 0.02))  # not below the border of 0.02
    assert machine.scale("steps", 200) == pytest.approx(100 / np.pi)
    with pytest.raises(
        ValueError, match="joints of a biglide slide, they have no angles, of which deg"
    ):
        fb.Machine(fb.Biglide()).scale("deg")
    assert fb.Machine(fb.Biglide()).scale("rad") == 1.0
