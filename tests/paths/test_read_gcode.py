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


def test_a_whole_circle_and_absolute_centres():
    (circle,) = read("G21\nG0 X10 Y0\nG2 X10 Y0 I-10 J0").pieces
    assert circle.angle1 - circle.angle0 == pytest.approx(
        -2 * math.pi
    ) and circle.radius == pytest.approx(0.01)
    (quarter,) = read("G21 G90.1\nG0 X10 Y0\nG3 X0 Y10 I0 J0").pieces
    assert quarter.centre == pytest.approx((0, 0)) and quarter.length == pytest.approx(
        0.005 * math.pi
    )
    (longer,) = read("G21\nG0 X10 Y0\nG3 X0 Y10 R-10").pieces
    assert longer.length == pytest.approx(0.015 * math.pi)


def test_circles_in_a_row_and_a_unit_that_comes_late_as_printers_write_it():
    path = read("G92 E0\nG0 X1 F6000\nM83\nG1 F900 E-5\nG2 I.5\nG92 E0\nG3 X1 Y0 I-.5\nG20")
    assert [type(piece) for piece in path.pieces] == [Arc, Arc] and path.length == pytest.approx(
        4 * math.pi * 0.0127
    )
    assert "lengths before the first G20 are read as after it (line 2)" in path.notes


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
        ("G21\nG0 X0 Y0\nG2 X1 Y0 R1 I1", "line 3: an arc with R and with I or J"),
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
        ("G21\nG0 X1 Y1 Z5\nG1 X9 Z5", "nothing is drawn: no move is at Z 0 or below"),
        (
            "G21\nG1 X1 Y1 Z5\nG1 X9 Z3\nG1 X2\nG1 X3 Z1",
            r"no move is at Z 0 or below.*Z is 1, 3, 5 mm",
        ),
        ("G21\nG0 X1 Y1\nG1 X1 Y1", "nothing is drawn: .*a move of no length: passed over"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(text, message):
    with pytest.raises(ValueError, match=message):
        read(text)


CURA = """;FLAVOR:Marlin
;Generated with Cura_SteamEngine 5.4.0
M140 S60
M104 S200
M82 ;absolute extrusion mode
G92 E0
G28
G1 Z2.0 F3000
M201 X500.00 Y500.00 Z100.00
;LAYER:0
M107
G1 F2400 E-5
G0 F6000 X10 Y10 Z0.2
;TYPE:SKIRT
G1 F2400 E0
G1 F1200 X20 Y10 E0.5
G1 X20 Y20 E1
G1 F2400 E-4
G0 F6000 X20 Y20 Z0.4
G0 X30 Y20
G0 Z.2
G1 F2400 E1
G3 F1200 X30 Y30 I0 J5 E1.7
G92 E0
G1 X20 Y30 E.5
G1 X19 Y30 E.3
M1002 gcode_claim_action : 2
G91
G1 E-2 Z0.2
G90
M84 X Y E
"""
PRUSA = """; generated by PrusaSlicer 2.7.1+linux-x64
START_PRINT BED=60 EXTRUDER=215
M862.3 P "MK3S" ; printer model check
G21 ; set units to millimeters
G90
M83 ; use relative distances for extrusion
G29
G10 ; retract
G11
;LAYER_CHANGE
;Z:0.2
G1 Z.2 F720
G1 X10 Y10 F10800
G1 E.8 F2100
G1 X20 Y10 E.5 F1200
G1 X20 Y20 E.5
G1 X15 Y20 E-.2 ; wipe
G1 E-.6 F2100
G1 Z.8
G1 X30 Y20 F10800
G1 Z.2
G1 E.8
M106 S255
G1 X30 Y30 E.5
G1 X20 Y30 E.5
G1 E-.8 F2100
M107
"""


@pytest.mark.parametrize("text", [CURA, PRUSA], ids=["Cura", "PrusaSlicer"])
def test_a_printer_draws_where_it_extrudes_at_any_height(text):
    """Not in travels at any height, in wipes, and where it only takes in or out."""
    path = read(text)
    on = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
    points = 1e-3 * np.array(
        [[(10, 10), (20, 10)], [(20, 10), (20, 20)], [(30, 20), (30, 30)], [(30, 30), (20, 30)]]
    )
    np.testing.assert_allclose(on, points, atol=1e-15)
    assert "the pen is down where E grows" in path.notes and not any(
        "E word" in words for words in path.notes
    )
    assert ("neither G20 nor G21: read in mm, as printers do" in path.notes) is (text == CURA)
    two = read(text + "G0 Z.4\nG1 X10 Y10\nG1 X11 Y10 E9")
    assert any(words.startswith("2 layers, Z 0.2 to 0.4 mm") for words in two.notes) and two.pen[-1]


LASERS = {
    "J Tech Photonics, from Inkscape": (
        "G90\nG21\nG1 F3000\nG4 P0\nM05\nG1 X10 Y0\nG4 P0\nM03 S255\nG1 F600\nG1 X20 Y0\nG4 P0\nM05 S0\nG1 X20 Y10\n"
        "M03 S255\nG1 X10 Y10\nM05 S0\nG1 F3000\nG1 X0 Y0\nM18"
    ),
    "its fan output": "G21\nM107\nG1 X10 Y0\nM106 S255\nG1 X20 Y0\nM106 S0\nG1 X20 Y10\nM106\nG1 X10 Y10\nM107\nG1 X0",
    "LightBurn": (
        "; LightBurn 1.2.04\n; GRBL device profile, absolute coords\nG00 G17 G40 G21 G54\nG90\nM4\nM8\nG0 X10Y0\nG91\n"
        "G1 X10S200F1000\nG0Y10\nX-10 Y0\nG1S0\nG0X10\nG1 X-10S200\nM9\nG1S0\nM5\nG90\nG0 X0Y0\nM2"
    ),
    "focus at Z 3": "$32=1\nG21\nG0 Z3\nM3 S0\nG0 X10 Y0\nG1 X20 S9\nG1 Y10 S0\nG1 X10 S9\nM5",
    "gcodetools": (
        "%\n(Header)\nM3\nG21 (All units in mm)\nG00 Z5.000000\nG00 X10 Y0\n\nG01 Z-0.125 F100.0(Penetrate)\n"
        "G01 X20 Y0 Z-0.125 F400\nG00 Z5\nG00 X20 Y10\nG01 Z-.1\nG01 X10\nG00 Z5\nM5\nG00 X0.0000 Y0.0000\nM2\n%"
    ),
    "a mill whose zero is the table": "G21\nM3\nG53 G0 Z0\nG0 X10 Y0 Z15\nG1 Z8\nG1 X20\nG0 Z15\nG0 Y10\nG1 Z6\nG1 X10",
    "a pen at Z 1 and 4": "G21\nG1 Z4\nG1 X10 Y0\nG1 Z1\nG1 X20\nG1 Z4\nG1 Y10\nG1 Z1\nG1 X10\nG1 Z4\nG1 X0",
}  # fmt: skip


@pytest.mark.parametrize("kind", LASERS)
def test_two_strokes_of_lasers_mills_and_plotters(kind):
    path = read(LASERS[kind])
    on = [(p.start, p.end) for p, pen in zip(path.pieces, path.pen) if pen]
    np.testing.assert_allclose(
        on, 1e-3 * np.array([[(10, 0), (20, 0)], [(20, 10), (10, 10)]]), atol=1e-15
    )


def test_units_that_contradict():
    with pytest.raises(ValueError, match="line 1: G20, but units are given as mm"):
        read("G20\nG1 X1", units="mm")
    assert read("G1 X1", units="in").length == pytest.approx(0.0254)
    with pytest.raises(ValueError, match='units of G-code must be "mm" or "in"'):
        read("G1 X1", units="cm")


def test_what_is_passed_over_is_listed():
    path = read(
        "G21 G54\nM8\nG0 X1\nG1 X2\nG1 X2\nG28 X0\nT1\nG1 X3 A0.5\nG4 P500\nG28 W\nM201 X1000 Y1000 ; limits\n"
        'M117 Layer 1 of X9\nN12 M862.3 P "MK3S"\nM205 X8\nG28\n'
    )
    assert path.length == pytest.approx(0.002) and path.pieces[-1].end[0] == pytest.approx(0.003)
    notes = " | ".join(path.notes)
    for words in (
        "G54: passed over (line 1)", "M8: passed over (line 2)", "G28: passed over (lines 6, 10", "T word: passed over",
        "A word: passed over (line 8)", "a move of no length: passed over (line 5)", "G4 P500: read as milliseconds",
    ):  # fmt: skip
        assert words in notes
    assert path.stops[-1].seconds == 0.5


def test_an_arc_in_moves_that_begin_at_the_origin_is_said():
    path = read("G21\nM3\nG1 X1")
    assert path.length == pytest.approx(1e-3) and "it begins at X0 Y0" in path.notes[0]
    assert isinstance(read("G21\nG0 X5\nG2 X7 I1").pieces[0], Arc)


words = st.lists(
    st.one_of(
        st.sampled_from("G0 G1 G2 G3 G4 G20 G21 G90 G91 G92 M3 M5 E1 S0 S9 ( ) ; % # = / \n N1 F9 Z-1 Z1".split(" ")),
        st.builds(lambda c, v: f"{c}{v:.3f}", st.sampled_from("XYIJRPF"), st.floats(-50, 50)), st.text(max_size=3),
    ), max_size=25,
)  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(words)
def test_any_text_is_read_or_refused(parts):
    try:
        path = read("G21\n" + " ".join(parts))
    except ValueError as error:
        assert "the open file" in str(error)
    else:
        assert np.isfinite(path(np.linspace(0, path.length, 50))[0]).all()
