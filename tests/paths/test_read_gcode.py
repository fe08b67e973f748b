"""G-code: what is read, and what is refused with its line."""

import io
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.paths.pieces import Arc, Line

PLOT = """%
O100 (a plot; with a remark)
N10 G21 G90 G17 ; mm
N20 G0 X10 Y10
M3 S1000
G1 X20 F600
G2 X30 Y10 I5 J0
G3 X30 Y30 R10
G4 P0.5
G1 X10
M5
G0 X0 Y0
M30
G1 X999
"""


def read(text, **options):
    return fb.path(io.StringIO(text), kind="gcode", **options)


def test_a_plot_is_read():
    path = read(PLOT)
    line, half, turn, back = path.pieces
    assert (line, back) == (Line((0.01, 0.01), (0.02, 0.01)), Line((0.03, 0.03), (0.01, 0.03)))
    assert half.centre == pytest.approx((0.025, 0.01)) and half.length == pytest.approx(
        0.005 * math.pi
    )
    assert half(half.length / 2)[0] == pytest.approx(
        (0.025, 0.015)
    )  # clockwise from the left: over the top
    assert turn.centre == pytest.approx((0.03, 0.02)) and turn(turn.length / 2)[0] == pytest.approx(
        (0.04, 0.02)
    )
    assert (
        path.pen == (True,) * 4
        and path.feed == pytest.approx((0.01,) * 4)
        and path.lines == (6, 7, 8, 10)
    )
    assert path.line_of(path.length) == 10 and path.line_of(0.01) == 7
    assert [stop.seconds for stop in path.stops if stop.seconds] == [0.5]
    assert "before the first stroke and after the last are passed over" in " ".join(path.notes)


def test_inches_relative_moves_z_as_pen_and_travel():
    path = read("G20 G91\nG0 X1\nG1 Z-0.1\nG1 X1\nG0 Z0.2\nG0 Y1\nG1 Z-.2\nG1 X-1 Y1\n")
    assert path.pen == (True, False, True)
    ends = [(0.0254, 0), (0.0508, 0), (0.0508, 0.0254), (0.0254, 0.0508)]
    for piece, (a, b) in zip(path.pieces, zip(ends, ends[1:])):
        np.testing.assert_allclose([piece.start, piece.end], [a, b], atol=1e-15)


def test_without_pen_codes_all_but_g0_draws():
    assert read("G21\nG0X0Y0\nG1X1\nG0X2\nG1X\t3").pen == (True, False, True)
    laser = read("G21\nM4 S0\nG0 X0 Y0\nG1 X1 S500\nG1 X2 S0\nG1 X3 S500\n")
    assert laser.pen == (True, False, True)
    # A power stays until the next one.
    laser = read("G21\nM4 S0\nG0 X0 Y0\nG1 X1 S500\nG1 X2\nG1 X3 S0\nG1 X4\nG1 X5 S9\n")
    assert laser.pen == (True, True, False, False, True)


def test_a_whole_circle_and_absolute_centres():
    (circle,) = read("G21\nG0 X10 Y0\nG2 X10 Y0 I-10 J0").pieces
    assert circle.angle1 - circle.angle0 == pytest.approx(
        -2 * math.pi
    ) and circle.radius == pytest.approx(0.01)
    (left,) = read("G21\nG0 X10 Y0\nG3 X10 Y0 I-10 J0").pieces
    assert left.angle1 - left.angle0 == pytest.approx(2 * math.pi)
    (quarter,) = read("G21 G90.1\nG0 X10 Y0\nG3 X0 Y10 I0 J0").pieces
    assert quarter.centre == pytest.approx((0, 0)) and quarter.length == pytest.approx(
        0.005 * math.pi
    )
    (longer,) = read("G21\nG0 X10 Y0\nG3 X0 Y10 R-10").pieces
    assert longer.length == pytest.approx(0.015 * math.pi)


def test_rounded_centres_are_mended():
    """Three decimals in mm: both ends are on the arc to rounding."""
    (arc,) = read("G21\nG0 X10 Y0\nG3 X7.071 Y7.071 I-10 J0").pieces
    np.testing.assert_allclose(arc.end, (0.007071, 0.007071), atol=1e-15)


@pytest.mark.parametrize(
    "text, message",
    [
        ("G21\nG5 X1 Y1", "line 2: G5 is not known"),
        ("G21\nG0 X0 Y0\nM99", "line 3: M99 is not known"),
        ("G0 X1", "line 1: neither G20"),
        (
            "G21\nG0 X0 Y0\nG2 X10 Y0 I4 J0",
            "line 3: the arc's centre is 4 mm from its start, but 6 mm from its end",
        ),
        ("G21\nG0 X0 Y0\nG2 X10 Y0 R4", "line 3: R = 4 mm is less than half of the chord, 5 mm"),
        ("G21\nG0 X0 Y0\nG2 X0 Y0 R4", "line 3: an arc with R whose start is its end"),
        ("G21\nG0 X0 Y0\nG2 X1 Y0", "line 3: G2 needs I and J, or R"),
        ("G21\nG0 X0 Y0\nG2 X1 Y0 R1 I1", "line 3: G2 needs I and J, or R"),
        ("G21\nX1", "line 2: a place without G0"),
        ("G21\nG1 X#5", "line 2: '#' is no word of G-code|line 2: .*is no word of G-code"),
        ("G21\nG0 G1 X1", "line 2: G0 and G1 in one line"),
        ("G21\nG1 X1 X2", "line 2: X twice in one line"),
        ("G21\nG1 X1 F0", "line 2: F must be > 0"),
        ("G21\nG4 P50", "line 2: G4 P50 could be in s or in ms"),
        ("G21\nG4", "line 2: G4 needs S or P"),
        ("G21\nG0X1\nG2 I4 P2", "line 3: P2: an arc of more than one turn is not read"),
        ("G0 X1\nG20\nG21", "line 1: neither G20"),
        ("G21\nG1 X1\nG92 X0", "line 3: G92 after the first move"),
        ("", "nothing is drawn"),
        ("G21\nG0 X1 Y1", "nothing is drawn"),
        (
            "G21\nG0 X1 Y1 Z5\nG1 X9 Z5",
            "the pen moves at the heights Z 5: which is down\\? Say pen_values",
        ),
        ("G21\nG0 X1 Y1\nG1 X1 Y1", "nothing is drawn: .*a move of no length: passed over"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(text, message):
    with pytest.raises(ValueError, match=message) as refused:
        read(text)
    assert str(refused.value).startswith("the open file") and "None" not in str(refused.value)


LASERS = {
    "J Tech Photonics, from Inkscape": (
        "G90\nG21\nG1 F3000\nG4 P0\nM05\nG1 X10 Y0\nG4 P0\nM03 S255\nG1 F600\nG1 X20 Y0\nG4 P0\nM05 S0\nG1 X20 Y10\n"
        "M03 S255\nG1 X10 Y10\nM05 S0\nG1 F3000\nG1 X0 Y0\nM18"
    ),
    "LightBurn": (
        "; LightBurn 1.2.04\n; GRBL device profile, absolute coords\nG00 G17 G40 G21 G54\nG90\nM4\nM8\nG0 X10Y0\nG91\n"
        "G1 X10S200F1000\nG0Y10\nX-10 Y0\nG1S0\nG0X10\nG1 X-10S200\nM9\nG1S0\nM5\nG90\nG0 X0Y0\nM2"
    ),
    "gcodetools": (
        "%\n(Header)\nM3\nG21 (All units in mm)\nG00 Z5.000000\nG00 X10 Y0\n\nG01 Z-0.125 F100.0(Penetrate)\n"
        "G01 X20 Y0 Z-0.125 F400\nG00 Z5\nG00 X20 Y10\nG01 Z-.1\nG01 X10\nG00 Z5\nM5\nG00 X0.0000 Y0.0000\nM2\n%"
    ),
}


@pytest.mark.parametrize("kind", LASERS)
def test_two_strokes_of_lasers_mills_and_plotters(kind):
    path = read(LASERS[kind])
    on = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
    np.testing.assert_allclose(
        on, 1e-3 * np.array([[(10, 0), (20, 0)], [(20, 10), (10, 10)]]), atol=1e-15
    )


TWO_STROKES = [((0.01, 0.0), (0.02, 0.0)), ((0.02, 0.01), (0.01, 0.01))]
PLOTTERS = {
    "servo by the unicorn": (
        "(Scribbled version of a.svg)\nG21 (metric ftw)\nG90\nG92 X0.00 Y0.00 Z0.00 (you are here)\n"
        "M300 S30 (pen down)\nG4 P150 (wait 150ms)\nM300 S50 (pen up)\nM18\nM01 (registration?)\nM17\n"
        "G1 X10.0 Y0.0 F3500.00\nM300 S30.00 (pen down)\nG1 X20.0 Y0.0 F3500.00\nM300 S50.00 (pen up)\n"
        "G1 X20 Y10 F3500\nM300 S30.00 (pen down)\nG1 X10 Y10\nM300 S50.00 (pen up)\n"
        "M300 S255 (turn off servo)\nG1 X0 Y0 F3500.00\nG1 Z0.00 F150.00\nM18 (drives off)\n"
    ),
    "servo of Marlin": (
        "G21\nG28 X Y\nM280 P0 S60\nG0 X10 Y0\nM280 P0 S30\nG4 S0.2\nG1 X20 F1000\nM280 P0 S60\n"
        "G0 X20 Y10\nM280 P0 S30\nG1 X10\nM280 P0 S60\nG28 X\nM84 X Y\n"
    ),
    "fan": (
        "G21\nG28\nM107\nG1 X10 Y0 F900\nM106 S255\nG1 X20\nM106 S0\nG1 Y10\nM106\nG1 X10\nM107\nG1 X0\n"
    ),
    "heights": (
        "%\r\nG21\r\nG53 G0 Z0 X0 Y0\r\nG0 Z19\r\nG0 X10 Y0\r\nG1 Z15 F300\r\nG1 X20\r\nG0 Z19\r\nG0 X20 Y10\r\n"
        "G1 Z15\r\nG1 X10\r\nG0 Z30\r\nM400\r\nM84 S60\r\n"
    ),
    "heights, the larger one down": (
        "G21\nG92 X0 Y0\nG1G90 Z0.5F20000\nG0 X10\nG1 Z5\nG1 X20\nG1 Z0.5\nG0 Y10\nG1 Z5\nG1 X10\nG1 Z0.5\n"
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", PLOTTERS)
def test_two_strokes_of_plotters(kind):
    path = read(PLOTTERS[kind])
    drawn = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
    np.testing.assert_allclose(drawn, TWO_STROKES, atol=1e-15)
    if kind != "fan":
        assert "the pen is taken to be down at the" in " ".join(path.notes)


# Two strokes as the posts of Fusion 360 (3-axis mill), FreeCAD (linuxcnc) and hands for LinuxCNC write them.
MILLS = {
    "Fusion 360": """%
(1001)
(T1  D=3. CR=0. - ZMIN=-1. - flat end mill)
N10 G90 G94 G17 G49 G40 G80
N15 G21
N20 G28 G91 Z0.
N22 G90

(2D Contour1)
N25 T1 M6
N30 S5000 M3
N35 G17 G90 G94
N40 G54
N45 M8
N50 G0 X10. Y0.
N55 G43 Z15. H1
N60 G0 Z5.
N65 G1 Z1. F333.
N70 Z-1.
N75 X20. F1000.
N80 G0 Z15.
N85 X20. Y10.
N90 Z5.
N95 G1 Z-1. F333.
N100 X10. F1000.
N105 G0 Z15.
N110 M9
N115 M5
N120 G53 G0 Z0.
N125 G28 G91 Z0.
N130 G90
N135 G53 G0 X0. Y0.
N140 M30
%
""",
    "FreeCAD": """(Exported by FreeCAD)
(Post Processor: linuxcnc_post)
(Output Time:2026-01-01 10:00:00.000000)
(begin preamble)
G17 G54 G40 G49 G80 G90
G21
(begin operation: Fixture)
(machine units: mm/min)
G54
(finish operation: Fixture)
(begin operation: TC: Default Tool)
(machine units: mm/min)
(TC: Default Tool)
(begin toolchange)
( TOOL CHANGE )
M5
M6 T1
G43 H1
M3 S1000
(finish operation: TC: Default Tool)
(begin operation: Engrave)
(machine units: mm/min)
(Engrave)
G0 Z15.000
G0 X10.000 Y0.000
G0 Z3.000
G1 X10.000 Y0.000 Z-1.000 F100.000
G1 X20.000 Y0.000 Z-1.000 F600.000
G0 Z15.000
G0 X20.000 Y10.000
G0 Z3.000
G1 X20.000 Y10.000 Z-1.000 F100.000
G1 X10.000 Y10.000 Z-1.000 F600.000
G0 Z15.000
(finish operation: Engrave)
(begin postamble)
M05
G17 G54 G90 G80 G40
M2
""",
    "LinuxCNC": """%
(AXIS: text.ngc)
G20 G17 G40 G49 G54 G64 P0.001 G80 G90 G94
G21 G91.1
T1 M6 G43
S3000 M3 F600
G53 G0 Z0
G0 X10 Y0
G0 Z2
G1 Z-0.5
G1 X20
G0 Z2
G0 Y10
G1 Z-0.5
G1 X10
G0 Z2
M5 M9
G28 Z0
T0 M6 G49
G0 X0 Y0
M2
%
""",
}


@pytest.mark.parametrize("kind", MILLS)
def test_two_strokes_of_a_mill_with_a_tool_changer(kind):
    path = read(MILLS[kind])
    drawn = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
    np.testing.assert_allclose(drawn, TWO_STROKES, atol=1e-15)
    notes = " | ".join(path.notes)
    for words in ("M6", "T word", "G43", "G49", "G40", "G17"):
        assert f"{words}: passed over" in notes


def test_another_tool_between_strokes_is_refused():
    """As another pen: after the last stroke it changes nothing."""
    change = "G0 Z5\nT2 M6\nG43 H2\nM3 S900\n"
    program = "G21\nT1 M6\nM3 S900\nG0 X10 Y0\nG1 Z-1\nG1 X20\n{0}G0 Y10\nG1 Z-1\nG1 X10\n{1}"
    assert read(program.format("", change)).pen == (True, False, True)
    assert read(program.format(change.replace("T2 M6", "T2"), "")).pen == (True, False, True)
    with pytest.raises(ValueError, match="line 8: M6 changes the tool between strokes"):
        read(program.format(change, ""))
    # The moves to X10 in G1 are above the sheet.
    assert read("G21\nG1 Z5\nG1 X10 Y0\nT1 M6\nG1 Z-1\nG1 X20").length == pytest.approx(0.01)


@pytest.mark.parametrize("down, up", [(15, 19), (19, 15), (14.8, 21)])
def test_values_of_the_pen_are_told_where_a_file_does_not_show_them(down, up):
    text = (
        "G21\nG1 Z{1}\nG1 X10 Y0 F900\nG1 Z{0}\nG1 X20\nG1 Z{1}\nG1 Y10\nG1 Z{0}\nG1 X10\nG1 Z{1}\n"
    )
    for word in ("Z", "M280 P0 S"):
        program = text.replace("G1 Z", "G1 Z" if word == "Z" else word).format(down, up)
        with pytest.raises(ValueError, match="which is down. Say pen_values=.down, up."):
            read(program)
        path = read(program, pen_values=(down, up))
        drawn = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
        np.testing.assert_allclose(drawn, TWO_STROKES, atol=1e-15)


@pytest.mark.parametrize(
    "text, message",
    [
        ("G21\nG28 X\nG1 X Y5", "line 3: 'X' is no word of G-code"),
        ("G21\nM84 Q", "line 2: 'Q' is no word of G-code"),
        ("G21\nG0 X1\nM402 S3.5", "line 3: M402 is not known"),
        ("(fivebar: joint angles of a five-bar robot)\nG21\nG93", "joint-space G-code that fivebar wrote"),
    ],
)  # fmt: skip
def test_words_that_are_refused(text, message):
    with pytest.raises(ValueError, match=message):
        read(text)


def test_gcode_and_what_is_not_read_are_known_by_any_name(tmp_path):
    for text in ("; a\n\n(b)\nG21\nG1 X5\n", "%\r\nM3 S9\r\nG21\r\nG1 X5", "N1 G21\nG1 X5\n"):
        (tmp_path / "line.txt").write_text(text, encoding="utf-8", newline="")
        assert fb.path(tmp_path / "line.txt").length == pytest.approx(0.005)
    (tmp_path / "table.txt").write_text("N2 flow;x (mm);y (mm)\n1;0;0\n1;0;5\n", encoding="utf-8")
    assert fb.path(tmp_path / "table.txt").length == pytest.approx(0.005)
    for name, what in {"a.mp": "a program of a DexTAR robot", "a.DXF": "a DXF drawing"}.items():
        (tmp_path / name).write_text("0\nSECTION\n", encoding="utf-8")
        with pytest.raises(ValueError, match=f"{name}: {what}, which is not read: save it as SVG"):
            fb.path(tmp_path / name)
    with pytest.raises(ValueError, match="pen_values are of G-code"):
        fb.path(io.StringIO("x,y\n0,0\n1,1\n"), kind="csv", pen_values=(0, 1))


def test_units_that_contradict():
    with pytest.raises(ValueError, match="line 1: G20, but units are given as mm"):
        read("G20\nG1 X1", units="mm")
    assert read("G1 X1", units="in").length == pytest.approx(0.0254)
    with pytest.raises(ValueError, match='units of G-code must be "mm" or "in"'):
        read("G1 X1", units="cm")


def test_what_is_passed_over_is_listed():
    path = read("G21 G54\nM8\nG0 X1\nG1 X2\nG1 X2\nG28 X0\nT1\nG1 X3 A0.5\nG4 P500\n")
    assert path.length == pytest.approx(0.002) and path.pieces[-1].end[0] == pytest.approx(0.003)
    notes = " | ".join(path.notes)
    for words in (
        "G54: passed over (line 1)",
        "M8: passed over (line 2)",
        "G28: passed over (line 6)",
        "T word: passed over",
        "A word: passed over (line 8)",
        "a move of no length: passed over (line 5)",
        "G4 P500: read as milliseconds",
    ):
        assert words in notes
    assert path.stops[-1].seconds == 0.5


@pytest.mark.parametrize("beside", ["G53 G0 Z0\n", "$H\n", "G28 Z0\n"])
def test_a_spindle_draws_whatever_is_said_of_heights_that_no_move_has(beside):
    plain = "G0 X4 Y16\nM3 S1000\nG1 X8 Y16\nM5\n"
    path = read(f"G21\n{plain}{beside}M2")
    assert path.length == pytest.approx(4e-3) and len(path.pieces) == 1
    assert read(f"G21\n{beside}{plain}M2").length == pytest.approx(4e-3)


def test_an_arc_in_moves_that_begin_at_the_origin_is_said():
    path = read("G21\nM3\nG1 X1")
    assert path.length == pytest.approx(1e-3) and "it begins at X0 Y0" in path.notes[0]
    assert isinstance(read("G21\nG0 X5\nG2 X7 I1").pieces[0], Arc)


words = st.lists(
    st.one_of(
        st.sampled_from(
            "G0 G1 G2 G3 G4 G20 G21 G90 G91 G92 M3 M5 E1 S0 S9 ( ) ; % # = / \n N1 F9 Z-1 Z1".split(
                " "
            )
        ),
        st.builds(lambda c, v: f"{c}{v:.3f}", st.sampled_from("XYIJRPF"), st.floats(-50, 50)),
        st.text(max_size=3),
    ),
    max_size=25,
)


@settings(max_examples=60, deadline=None)
@given(words)
def test_any_text_is_read_or_refused(parts):
    try:
        path = read("G21\n" + " ".join(parts))
    except ValueError as error:
        assert "the open file" in str(error)
    else:
        assert np.isfinite(path(np.linspace(0, path.length, 50))[0]).all()
