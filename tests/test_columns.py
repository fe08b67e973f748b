"""Tables in the forms in which people have them."""

import calendar
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fivebar.base import columns
from fivebar.base.headings import TIME, Quantity
from fivebar.base.units import METRES, RADIANS

PATH = {
    "t": TIME,
    "x": Quantity((), METRES),
    "y": Quantity((), METRES),
    "q1": Quantity(("q11", "theta1"), RADIANS, needed=False),
}
EXPECTED = np.array([[0.0, 0.09, 0.068], [0.5, 0.0455, 0.08]])


def rows(found):
    return np.stack([found.values[name] for name in ("t", "x", "y")], axis=1)


@pytest.mark.parametrize(
    "text",
    [
        "t,x,y\n0,0.09,0.068\n0.5,0.0455,0.08\n",
        "\ufeffTime,X,Y\r\n0,0.09,0.068\r\n0.5,0.0455,0.08\r\n",
        "t (ms);x [mm];y in mm\n0;90;68\n500;45,5;80\n",
        "sep=;\nt;x;y\n0;0,09;0,068\n0,5;0,0455;0,08\n",
        "Zeit/s\tx_mm\ty_mm\n0\t90\t68\n0.5\t45.5\t80\n",
        "# made by hand\n# t x y\n0 0.09 0.068\n0.5 0.0455 0.08\n",
        "y|x|comment|t\n0.068|0.09|start|0\n\n# half way\n0.08|0.0455|end|0.5\n",
        "Time,x,y\n[ms],[mm],m\n0,90,0.068\n500,45.5,0.08\n",
        "t;x;y;note\ns;mm;mm;-\n0;90;68;a\n0,5;45,5;80;b\n",
        "%time,frame_id,x,y\n0,map,0.09,0.068\n0.5,map,0.0455,0.08\n",
        "t,x,y\n1970-01-01 00:00:00,0.09,0.068\n1970-01-01T00:00:00.5Z,0.0455,0.08\n",
        '"t","x (mm)","y (cm)"\n"0","90","6,8"\n"0.5","45.5","8"\n',
    ],
)
def test_one_table_in_many_hands(text):
    found = columns.read(io.StringIO(text), PATH)
    np.testing.assert_allclose(rows(found), EXPECTED, rtol=1e-15)


def test_what_was_made_of_it_is_said_and_lines_are_the_files(tmp_path):
    file = tmp_path / "a.csv"
    file.write_bytes(
        "# from the bench\nt (µs);x (mm);y;volt\n0;90;0,068;1\n\n5e5;;0,08;2\n".encode("cp1252")
    )
    found = columns.read(file, PATH)
    assert set(found.stated) == {"t", "x"}
    assert found.lines.tolist() == [3, 5]
    assert math.isnan(found.values["x"][1])
    assert found.notes == (
        "unused columns: 'volt'",
        "decimal commas were read as decimal points",
        "t (µs): read in us",
        "x (mm): read in mm",
    )
    assert str(found.error(1, "no")) == f"{file}, line 5: no"


def test_a_unit_may_be_given_for_what_the_heading_leaves_open():
    text = "t,x,y,theta1\n0,90,68,180\n500,45.5,80,90\n"
    for units in (
        {"t": "ms", "x": "mm", "y": "mm", "q1": "deg"},
        ["ms", "mm", "deg"],
        ["t=ms", "mm", "q1=degrees"],
    ):
        found = columns.read(io.StringIO(text), PATH, units)
        np.testing.assert_allclose(rows(found), EXPECTED, rtol=1e-15)
        np.testing.assert_allclose(found.values["q1"], [math.pi, math.pi / 2], rtol=1e-15)
        assert set(found.stated) == set(PATH)


@pytest.mark.parametrize(
    "text, units, message",
    [
        ("", (), "empty; needed a header with t, x, y, q1"),
        ("0,0.09,0.068\n", (), "line 1: no header, but numbers"),
        ("t,x\n0,1\n", (), "line 1: no column y; found 't', 'x'"),
        ("t,x,y\n", (), "no rows under the header"),
        ("t,x,X (mm),y\n0,1,2,3\n", (), "line 1: 'x' and 'X (mm)' both are x; leave one"),
        (
            "t,x (deg),y\n0,1,2\n",
            (),
            "line 1: column 'x (deg)': 'deg' is none of m, mm, cm, um, in",
        ),
        (
            "t,x (mm),y\n0,1,2\n",
            ["x=cm"],
            "line 1: column 'x (mm)' is in mm, but its unit is given as cm",
        ),
        ("t,x,y\n0,1,2\n", ["furlong"], "units: furlong: known are s, ms, us, ns, min, m, mm"),
        ("t,x,y\n0,1,2\n", ["z=mm"], "units: z=mm: known are"),
        (
            "t,x,y\n0,0.1,0.2\n0,5,0,1,0,2\n",
            (),
            "line 3: 6 cells, where the header has 3; decimal commas need ;",
        ),
        ("t;x;y\n0;1.234,5;0\n", (), "line 2: x must be a number, not '1.234,5'"),
        ("t,x,y\n0,1,abc\n", (), "line 2: y must be a number, not 'abc'"),
        ("t,x,y\n0,1,-inf\n", (), "line 2: y must be finite, not -inf"),
        ("t,x,y\n0,1,2\n1,2\n", (), "line 3: 2 cells, where the header has 3"),
        ("t,x,y\n# a remark!\n#DIV/0!,1,2\n", (), "line 3: t must be a number, not '#DIV/0!'"),
        ("t;x;y\n#N/A;1;2\n", (), "line 2: t must be a number, not '#N/A'"),
    ],
)
def test_what_is_wrong_is_named(text, units, message):
    with pytest.raises(ValueError) as error:
        columns.read(io.StringIO(text), PATH, units)
    assert message in str(error.value)


def test_other_files_are_named_for_what_they_are(tmp_path):
    for content, message in (
        (b"PK\x03\x04", "a spreadsheet or a zip file"),
        (b"a\0b", "a binary one"),
    ):
        (tmp_path / "a").write_bytes(content)
        with pytest.raises(ValueError, match=message):
            columns.read(tmp_path / "a", PATH)
    with pytest.raises(TypeError, match="open for bytes"):
        columns.read(io.BytesIO(b"t,x,y\n"), PATH)


NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@given(
    st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=5),
    st.sampled_from(",;\t|"),
    st.booleans(),
)
def test_numbers_come_back_to_the_bit(table, mark, commas):
    text = mark.join("txy") + "\n" + "\n".join(mark.join(map(repr, row)) for row in table)
    if commas and mark != ",":
        text = text.replace(".", ",")
    assert rows(columns.read(io.StringIO(text), PATH)).tolist() == [list(row) for row in table]


@given(st.text(alphabet="txyq1 (ms)[deg],;\t|0.5-e#\"'\n\r%=°", max_size=80))
def test_any_text_is_read_or_refused(text):
    try:
        found = columns.read(io.StringIO(text), PATH)
    except ValueError:
        return
    assert all(
        len(values) == len(found.lines) and not np.isinf(values).any()
        for values in found.values.values()
    )


HEADED = (
    "__time,/arm/left/position,/arm/right (mm),pose\n"
    '0,90,68,"[0.5, −3.0]"\n500,45.5,80,"[0.25, 1e-1, 7]"\n'
)


@pytest.mark.parametrize("of_file", [True, False])
def test_the_caller_says_which_heading_is_which(of_file):
    called = {"t": "__time (ms)", "x": "/arm/left/position [mm]", "y": "/arm/right (mm)"}
    text = io.StringIO(HEADED)
    if of_file:
        source = text
    else:
        source = {"__time": [0, 500], "/arm/left/position": [90, 45.5], "/arm/right (mm)": [68, 80]}
        source |= {"pose": [[0.5, -3.0], [0.25, 0.1]]}
    found = columns.read(source, PATH, columns=called | {"q1": "pose[1] (deg)"})
    np.testing.assert_allclose(rows(found), EXPECTED, rtol=1e-15)
    np.testing.assert_allclose(found.values["q1"], np.radians([-3.0, 0.1]), rtol=1e-15)
    assert set(found.stated) == {"t", "x", "y", "q1"}


@pytest.mark.parametrize(
    "called, message",
    [
        ((), "no column x, y; found .*: say which they are, by columns= or --columns x=HEADING y="),
        (["t=time"], "columns: no heading is 'time'; found '__time', '/arm/left/position'"),
        (["u=__time"], "columns: u=__time must be NAME=HEADING, NAME one of t, x, y, q1"),
        (["t"], "columns: t= must be NAME=HEADING"),
        (["t=__time", "x=pose[7]"], r"columns: no list has a number pose\[7\]"),
        (["t=__time", "x=__time"], "columns: '__time' is named twice"),
        (["t=__time (furlong)"], "'furlong' is none of s, ms"),
    ],
)
def test_a_heading_that_is_not_there_is_named(called, message):
    with pytest.raises(ValueError, match=message):
        columns.read(io.StringIO(HEADED), PATH, columns=called)


def test_a_heading_that_is_called_takes_the_place_of_others():
    found = columns.read(io.StringIO("t,x,y,a\n0,1,2,3\n"), PATH, columns={"x": "a"})
    assert found.values["x"].tolist() == [3.0] and found.unused == ("x",)


@pytest.mark.parametrize("unit, size", [("s", 1), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_times_since_1970_tell_their_unit_by_their_size(unit, size):
    t = 1.7e9 + np.array([0.0, 0.5, 1.0])
    found = columns.read({"t": t * size, "x": t, "y": t}, PATH)
    np.testing.assert_allclose(found.values["t"], t, rtol=0, atol=1e-6)
    assert found.notes == (f"t: {unit} since 1970, by their size",) and "t" in found.stated
    clock = columns.read({"t": np.array([0.0, 2.0, 4.0]) * size, "x": t, "y": t}, PATH)
    assert clock.values["t"][-1] == 4.0 * size and not clock.notes


@pytest.mark.parametrize(
    "first, second, day",
    [
        ("2026-03-29T01:59:55.000", "2026-03-29T02:00:00.250", (2026, 3, 29)),
        ("2026-03-29 03:59:55.000+02:00", "2026-03-29 04:00:00.250+02:00", (2026, 3, 29)),
        ("29.03.2026 01:59:55,000", "29.03.2026 02:00:00,250", (2026, 3, 29)),
        ("01:59:55.000", "02:00:00.250", (1970, 1, 1)),
        ("01:59:55,000", "02:00:00,250", (1970, 1, 1)),
    ],
)
def test_times_may_be_dates_or_times_of_day(first, second, day):
    table = columns.read(io.StringIO(f"t;x;y\n{first};0,5;1\n{second};1;2\n"), PATH)
    begin = calendar.timegm((*day, 1, 59, 55))
    assert table.values["t"].tolist() == [begin, begin + 5.25]
    assert "t: read from dates or times of day" in table.notes
    assert not any("1970" in note for note in table.notes)
    columns.refuse_unclear_times(table, 1.0)


@pytest.mark.parametrize("cell", ["03/04/2026 01:59:55", "29.03.2026", "25:00:00", "1:59"])
def test_moments_that_are_unclear_are_no_numbers(cell):
    with pytest.raises(ValueError, match="line 2: t must be a number"):
        columns.read(io.StringIO(f"t;x;y\n{cell};0,5;1\n"), PATH)


@pytest.mark.parametrize("step, unit", [(2.0, "ms"), (4000.0, "us"), (5e6, "ns")])
def test_steps_that_are_no_seconds_are_asked_about(step, unit):
    numbers = np.arange(3) * step
    table = columns.read({"t": numbers, "x": numbers, "y": numbers}, PATH)
    with pytest.raises(ValueError, match=f"t has no unit, and its steps are .*: is t in {unit}"):
        columns.refuse_unclear_times(table, 1.0)
    columns.refuse_unclear_times(table, 1e9)


def test_a_given_unit_stands_in_place_of_an_unknown_word_in_brackets():
    wanted = {"q1": Quantity((), RADIANS)}
    for heading, units in (("q1 (Grad)", ()), ("q1 (Drehung)", ["q1=deg"]), ("q1 [grados]", ())):
        table = columns.read(io.StringIO(f"{heading};b\n180;1\n"), wanted, units)
        assert table.values["q1"] == pytest.approx([np.pi])


@pytest.mark.parametrize("about", ["5", "[1]", "null", "{"])
def test_a_first_line_that_is_no_mapping_is_refused(about):
    text = f"# fivebar setpoints, SI units: {about}\nt,x\n0,1\n1,2\n"
    with pytest.raises(ValueError, match="line 1: not of a file of setpoints"):
        columns.read(io.StringIO(text), {"t": TIME, "x": Quantity((), METRES)})
