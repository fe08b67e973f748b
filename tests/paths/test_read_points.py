"""Points and CSV files as people have them."""

import io

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.pieces import Arc, Line


def test_points_strokes_and_pieces():
    path = fb.path([(0, 0), (0.1, 0), (0.1, 0), (0.1, 0.1)])
    assert path.length == pytest.approx(0.2) and path.notes == (
        "points that repeat the one before are passed over: 1 (point 2)",
    )
    strokes = fb.path([[(0, 0), (0.1, 0)], np.array([(0.1, 0.1), (0, 0.1), (0, 0)])])
    assert strokes.pen == (True, False, True, True) and len(strokes.stops) == 5
    assert fb.path(Arc((0, 0), 0.1, 0, 1)).length == pytest.approx(0.1)
    assert fb.path([Line((0, 0), (1, 0)), Line((2, 0), (3, 0))]).pen == (True, False, True)
    placed = fb.path([(0, 0), (0.1, 0)], placement=fb.Placement((0.01, 0.02), np.pi / 2, 0.5))
    np.testing.assert_allclose(placed.pieces[0].end, (0.01, 0.07), atol=1e-16)


def test_csv_files_as_people_have_them(tmp_path):
    german = tmp_path / "punkte.csv"
    german.write_bytes("Zeit;X (mm);Y (mm);Stift\n0;10,5;20;1\n1;30;20;1\n".encode("cp1252"))
    path = fb.path(german)
    assert path.pieces == (Line((0.0105, 0.02), (0.03, 0.02)),)
    assert "decimal commas were read as decimal points" in path.notes
    with_pen = io.StringIO("x,y,pen\n0,0,0\n0.1,0,1\n0.1,0.1,0\n0,0.1,1\n")
    assert fb.path(with_pen).pen == (True, False, True)
    assert fb.path(io.StringIO("x,y\n0,0\n100,50\n"), units="mm").length == pytest.approx(
        np.hypot(0.1, 0.05)
    )
    assert "from_csv follows them" in " ".join(
        fb.path(io.StringIO("t,x,y\n0,0,0\n1,0.1,0\n")).notes
    )


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "empty; needed a header with x, y"),
        ("x,y\n", "no rows under the header"),
        ("x,y\n0,0\n", "nothing is drawn"),
        ("x,y\n0,0\n0,0\n", "nothing is drawn: points that repeat"),
        ("x,y\n0,0\n1,\n", "line 3: x or y is missing"),
        ("x,y\n0,0\n100,50\n", "could be in metres or in millimetres"),
        ("x_mm,y\n0,0\n100,50\n", "x has a unit in its heading, but y has none"),
        ("x_mm,y_mm,pen\n0,0,1\n100,50,2\n", "line 3: pen must be 0 or 1, not 2"),
        ("x_mm,x [m],y\n0,0,1\n", "line 1: .*both are x"),
    ],
)
def test_bad_files(text, message):
    with pytest.raises(ValueError, match=message):
        fb.path(io.StringIO(text))


def test_units_that_contradict():
    with pytest.raises(ValueError, match="column 'x_mm' is in mm, but its unit is given as m"):
        fb.path(io.StringIO("x_mm,y_mm\n0,0\n100,50\n"), units="m")


@pytest.mark.parametrize(
    "points, message",
    [
        ([], "no points"),
        ([(0, 0)], "at least 2 points are needed, not 1"),
        ([(0, 0), (0, 0)], "nothing is drawn"),
        (np.zeros((3, 3)), r"points must be \(n, 2\), not \(3, 3\)"),
        (5, "points .* or a file are needed, not 5"),
        ([[(0, 0), (1, 1)], [(2, 2)]], "stroke 1: at least 2 points"),
        ([(0, 0), (np.nan, 1)], "must be finite"),
        ([[(0, 0), (1, 1)], []], "stroke 1"),
        ([[1.0, b"\xed", "'"], 2.0], "path: points must be real numbers"),
    ],
)
def test_bad_points(points, message):
    with pytest.raises((ValueError, TypeError), match=message):
        fb.path(points)


def test_options_of_files_alone():
    with pytest.raises(ValueError, match="units is of a file, and there is none"):
        fb.path([(0, 0), (1, 1)], units="mm")
    with pytest.raises(ValueError, match="kind must be one of None, csv, svg, gcode"):
        fb.path(io.StringIO("x"), kind="dxf")
    with pytest.raises(FileNotFoundError):
        fb.path("nowhere.csv")


def test_the_kind_is_found_by_the_beginning():
    svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M0 0H96"/></svg>'
    assert fb.path(io.StringIO(svg)).length == pytest.approx(0.0254)
    assert fb.path(io.StringIO("x,y\n0,0\n0,1")).length == 1.0
