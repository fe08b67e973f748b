"""Read tables of numbers: CSV files with units in their headings, NPZ files, mappings of arrays.

`tables` reads the files that fivebar itself wrote. This reads what other programs wrote, converts
it to SI units, and notes what it converted, assumed or did not use.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

from .backend import HUGE, real_numbers
from .checks import shown
from .headings import (
    Quantity,
    called_column,
    column_and_unit,
    headings_by_name,
    how_to_name,
    matched,
    missing_of,
    names_of,
    units_by_name,
    units_named,
)
from .tables import STRANGE, TextFile, arrays_in, whole_text
from .units import NUMBER, SECONDS, unit_named

EPOCH = 5e8  # s since 1970, in 1985: later times are dates
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-"}
_MOMENT = re.compile(r"(?:(\d\d)\.(\d\d)\.(\d{4})[ T])?(\d\d:\d\d:\d\d(?:\.\d+)?)")
# A line of its own; not a first cell in which a spreadsheet has an error, as #DIV/0! or #N/A.
_REMARK = re.compile(r"%|#(?!(N/A|[^\s;,|]+[!?])([;,\t|]|$))")
_NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?")


class Origin(NamedTuple):
    """Whose points x, y are, as the first line of a file that fivebar wrote says.

    of_tool: a tool's, else those of joint C; measured: in the measuring frame of a robot's file,
    else in the robot's own frame.
    """

    of_tool: bool
    measured: bool


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of a table, in SI units.

    Attributes
    ----------
    name : str
        The file, or what a message calls the mapping.
    values : dict
        {name: array (n,)}, nan where a cell is empty.
    lines : (n,) array of int
        The line of each row in the file; of a mapping the number of the row, from 1.
    notes : tuple of str
        What was converted, assumed or not used.
    stated : mapping
        {column: its unit} of those whose unit a heading or the caller names; "" for the SI unit.
    row_word : str
        "line" or "row": what `lines` counts.
    comment : str
        The first comment above the header of a file.
    unused : tuple of str
        Headings of columns that are not wanted.
    origin : Origin, optional
        Whose points x, y are; None where the file does not say.
    """

    name: str
    values: dict[str, np.ndarray]
    lines: np.ndarray
    notes: tuple[str, ...] = ()
    stated: Mapping[str, str] = field(default_factory=dict)
    row_word: str = "line"
    comment: str = ""
    unused: tuple[str, ...] = ()
    origin: Origin | None = None

    def where(self, row: int) -> str:
        """Return what a message calls a row: "line 7"."""
        return f"{self.row_word} {self.lines[row]}"

    def error(self, row: int, message: str) -> ValueError:
        """Return the error to raise where a row is wrong."""
        return ValueError(f"{self.name}, {self.where(row)}: {message}")


def read(
    source: TextFile | Mapping,
    wanted: Mapping[str, Quantity],
    units: Mapping[str, str] | Sequence[str] | str | None = (),
    name: str = "data",
    columns: Mapping[str, str] | Sequence[str] | None = (),
) -> Columns:
    """Return the wanted columns of a CSV file, an NPZ file or a mapping of arrays, in SI units.

    Parameters
    ----------
    source : path, open text file or mapping
        In a CSV file, columns are separated by commas, semicolons, tabs, bars or blanks, and
        decimals by points or commas. A heading is a name and perhaps a unit: x, X [mm], q1 (deg),
        time/ms, x_mm; or a row of units follows. Lines that begin with # or % are comments; the
        last of them is the header where none follows. Times may be dates, 2024-05-01 10:00:00.25 or
        01.05.2024 10:00:00,25, or times of day, 10:00:00.25.
    wanted : mapping
        {name: Quantity}.
    units : mapping or sequence of str
        {name: unit} or units alone ("mm", "t=ms"), of headings that name none.
    name : str
        What a message calls a mapping.
    columns : mapping or sequence of str
        {name: heading} or "name=heading", of columns with other headings: {"q1": "pos[0]", "tau1":
        "M1 (mNm)"}. [0] is the first number of lists in the cells; a unit may follow.

    Raises
    ------
    ValueError
        A column is missing, appears twice or contradicts its unit, or a cell is no number: the
        message names the file and the line.
    TypeError
        The source is none of these.
    """
    named_units = units_by_name(units_named(units, "units"), wanted)
    calls = headings_by_name(columns, wanted)
    if isinstance(source, Mapping):
        return _from_arrays(source, wanted, named_units, name, calls)
    if not (isinstance(source, (str, os.PathLike)) or hasattr(source, "read")):
        raise TypeError(
            f"{name} must be a CSV file, an NPZ file or a mapping of arrays, not {shown(source)}"
        )
    path = str(source)
    if path.endswith(".npz"):
        return _from_arrays(arrays_in(path), wanted, named_units, path, calls)
    return _from_text(source, wanted, named_units, calls)


def _from_arrays(arrays, wanted, units, name, calls):
    names = names_of(wanted)
    if calls:
        arrays, units = _chosen(arrays, wanted, names, units, name, calls)
    values = {}
    stated = {}
    for heading, array in arrays.items():
        if array is None:
            continue
        key, unit = column_and_unit(str(heading), wanted, names, units, name)
        if key is None or key in values:
            raise ValueError(
                f"{name} has no column {heading!r}, or has it twice; the known ones are"
                f" {', '.join(wanted)}"
            )
        column = real_numbers(array, f"{name}[{heading!r}]")
        if column.ndim > 1:
            raise ValueError(f"{name}[{heading!r}] must have shape (n,), not {column.shape}")
        factor = 1.0
        if unit:
            stated[key] = unit
            factor = wanted[key].units[unit]
        values[key] = column * factor
    if missing := missing_of(wanted, values):
        raise ValueError(f"{name} has no column {', '.join(missing)}: {how_to_name(missing)}")
    lengths = {key: len(column) for key, column in values.items() if column.ndim}
    if len(set(lengths.values())) != 1:
        raise ValueError(f"the columns of {name} differ in length: {lengths or 'none is an array'}")
    n = next(iter(lengths.values()))
    values = {key: np.broadcast_to(column, n).copy() for key, column in values.items()}
    rows = np.arange(1, n + 1)
    notes: list[str] = []
    stated |= _since_1970(values, stated, notes)
    _refuse_huge(values, rows, name, "row")
    return Columns(name, values, rows, tuple(notes), stated, "row")


def _chosen(arrays, wanted, names, units, name, calls):
    """Return the arrays by the names that the caller gives them, and the units."""
    chosen = {}
    for heading, array in arrays.items():
        key, _ = column_and_unit(str(heading), wanted, names, units, name)
        if key and key not in calls:
            chosen[heading] = array
    headings = list(map(str, arrays))
    for key, call in calls.items():
        place, index, unit = called_column(call, headings, name)
        array = list(arrays.values())[place]
        chosen[key] = array if index is None else np.asanyarray(array)[:, index]
        if unit:
            units = units | units_by_name([f"{key}={unit}"], wanted)
    return chosen, units


def _from_text(file, wanted, units, calls):
    text, name = whole_text(file, "a table")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, line) for number, line in lines if line and not _REMARK.match(line)]
    if rows and rows[0][1].lower().startswith("sep="):  # Excel's name of the delimiter
        del rows[0]
    if not rows:
        raise ValueError(f"{name}: empty; needed a header with {', '.join(wanted)}")
    above = lines[: rows[0][0] - 1]
    comments = [(n, line.lstrip("#% ")) for n, line in above if line.startswith(("#", "%"))]
    first = rows[0][1]
    if any(map(_is_number, first.split(_delimiter(first)))):
        if not comments or all(map(_is_number, re.split(r"[;,\t| ]+", comments[-1][1]))):
            raise ValueError(
                f"{name}, line {rows[0][0]}: no header, but numbers; needed one with"
                f" {', '.join(wanted)}"
            )
        rows.insert(0, comments[-1])
    (top, header), *rows = rows
    delimiter = _delimiter(header)
    headings = [cell.strip() for cell in _cells(header, delimiter, f"{name}, line {top}")]
    if rows:
        cells = _cells(rows[0][1], delimiter, f"{name}, line {rows[0][0]}")
        if row_of_units := _row_of_units(cells, wanted, len(headings)):
            headings = [
                f"{heading} [{unit}]" if unit else heading
                for heading, unit in zip(headings, row_of_units)
            ]
            del rows[0]
    called = {}
    for key, call in calls.items():
        place, index, unit = called_column(call, headings, f"{name}, line {top}")
        if index is not None:
            cells = [_listed(line, delimiter, place, index) for _, line in rows]
            if not any(cells):
                raise ValueError(f"{name}, line {top}: columns: no list has a number {call}")
            rows = [(n, f"{line}{delimiter or ' '}{cell}") for (n, line), cell in zip(rows, cells)]
            place = len(headings)
            headings.append(call)
        if place in called:
            raise ValueError(f"{name}: columns: {headings[place]!r} is named twice")
        called[place] = f"{key} [{unit}]"
    places, own_units, unused = matched(
        headings, wanted, units, f"{name}, line {top}", calls, called
    )
    notes = [f"unused columns: {', '.join(map(repr, unused))}"] if unused else []
    if not rows:
        raise ValueError(f"{name}: no rows under the header")
    table, comma = _numbers(rows, delimiter, len(headings), places, name)
    if comma:
        notes.append("decimal commas were read as decimal points")
    if "t" in places and re.search(r"\d:\d\d", rows[0][1]):
        own_units["t"] = "s"
        notes.append("t: read from dates or times of day")
    for key, column in zip(places, table.T):
        unit = own_units.get(key)
        if unit is not None:
            column *= wanted[key].units[unit]
            if unit != next(iter(wanted[key].units)):
                notes.append(f"{headings[places[key]]}: read in {unit}")
    values = dict(zip(places, table.T))
    numbers = np.array([number for number, _ in rows])
    comment = comments[0][1] if comments else ""
    from_fivebar = re.match("fivebar .*SI units", comment)
    stated = dict.fromkeys(places, "") if from_fivebar else own_units
    stated |= _since_1970(values, stated, notes)
    _refuse_huge(values, numbers, name, "line")
    origin = _origin(comments[0], calls, name) if from_fivebar else None
    about = stated, "line", comment, tuple(unused), origin
    return Columns(name, values, numbers, tuple(notes), *about)


def _origin(comment, calls, name):
    """Return the Origin of a file whose first comment is this (line, text); None where x, y are not
    those of a motion of the robot.
    """
    line, text = comment
    kind, _, about = text.removeprefix("fivebar ").partition(", SI units: ")
    if kind in ("plan", "run"):
        return Origin(calls.get("x", "x").startswith("x_tip"), False)
    if kind != "setpoints":
        return None
    try:
        told = json.loads(about).keys()
    except STRANGE as error:
        raise ValueError(f"{name}, line {line}: not of a file of setpoints: {error}") from None
    return Origin("tool" in told, "frame" in told)


def _since_1970(values, stated, notes):
    """Convert times since 1970, whose size tells their unit; return {"t": this unit}."""
    t = values.get("t")
    if t is None or "t" in stated:
        return {}
    first, last = np.nanmin(t, initial=np.inf), np.nanmax(t, initial=0.0)
    for unit in ("ns", "us", "ms", "s"):
        # A clock that began at 0 has gone on by as much as it shows.
        if EPOCH < first * SECONDS[unit] and last < 1.1 * first:
            t *= SECONDS[unit]
            notes.append(f"t: {unit} since 1970, by their size")
            return {"t": unit}
    return {}


def refuse_unclear_times(table: Columns, slow: float) -> None:
    """Raise ValueError if the steps of a column t without a unit are of `slow` s or more."""
    t = table.values["t"]
    steps = np.diff(t[np.isfinite(t)])
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if step < slow or "t" in table.stated:
        return
    unit = next(unit for unit, size in (("ns", 1e6), ("us", 1e3), ("ms", 0.0)) if step >= size)
    raise ValueError(
        f"{table.name}: t has no unit, and its steps are {step:g}: is t in {unit}? Head it t_s or"
        f" t_{unit}, or give units: t=s or t={unit}"
    )


def _refuse_huge(values, lines, name, row_word):
    for key, column in values.items():
        huge = np.abs(column) >= HUGE
        if huge.any():
            raise ValueError(
                f"{name}, {row_word} {lines[huge.argmax()]}: {key} must be below {HUGE:g} in size,"
                f" not {column[huge][0]:g}"
            )


def _delimiter(line):
    return next((mark for mark in ";\t,|" if mark in line), None)


def _cells(line, delimiter, where):
    if delimiter is None:
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    except csv.Error as error:
        raise ValueError(f"{where}: {error}: {line[:40]!r}...") from None


def _is_number(cell):
    return _NUMBER.fullmatch(cell.strip(' "')) is not None


def _row_of_units(cells, wanted, count):
    """Return the units that a row under the header names, "" where none; [] of another row."""
    known = {unit for quantity in wanted.values() for unit in quantity.units}
    words = [cell.strip("[](){} ") for cell in cells]
    if len(words) < count or any(map(_is_number, words)):
        return []
    if not any(unit_named(word) in known for word in words):
        return []
    return ["" if word == "-" else word for word in words]


def _listed(line, delimiter, place, index):
    """Return a number of the list in a cell, "" where it has fewer."""
    cells = _cells(line, delimiter, "a list")
    text = "".join(cells[place : place + 1]).replace("\u2212", "-")
    numbers = re.findall(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", text)
    return "".join(numbers[index : index + 1])


def _numbers(rows, delimiter, width, places, name):
    """Return the columns at these places (n, len(places)), and whether decimals are commas."""
    lines = [line for _, line in rows]
    comma = delimiter != "," and any("," in line for line in lines)
    if comma and not any("." in line for line in lines):
        lines = [line.replace(",", ".") for line in lines]
    even = delimiter is None or all(line.count(delimiter) == width - 1 for line in lines)
    try:  # all at once; cells that are wrong or missing are looked for below
        table = np.loadtxt(
            lines, delimiter=delimiter, usecols=list(places.values()), comments=None, ndmin=2
        )
        if even and np.isfinite(table).all():
            return table, comma
    except ValueError:
        pass
    table = np.empty((len(rows), len(places)))
    for row, (number, line) in enumerate(rows):
        where = f"{name}, line {number}"
        cells = _cells(line, delimiter, where)
        if len(cells) < width or any(cells[width:]):
            several = delimiter == "," and len(cells) >= 2 * width - 1
            hint = "; decimal commas need ; between the columns" if several else ""
            raise ValueError(f"{where}: {len(cells)} cells, where the header has {width}{hint}")
        comma |= any("," in cells[place] for place in places.values())
        table[row] = [_number(cells[place], key, where) for key, place in places.items()]
    return table, comma


def _number(cell, key, where):
    cell = cell.strip()
    if cell.casefold() in _MISSING:
        return math.nan
    try:
        value = float(cell if "." in cell else cell.replace(",", "."))
    except ValueError:
        value = _date(cell) if key == "t" else None
    if value is None:
        found = NUMBER.fullmatch(cell)
        hint = f"; its unit goes into the heading: {key} ({found[2]})" if found else ""
        raise ValueError(f"{where}: {key} must be a number, not {cell[:40]!r}{hint}")
    if not math.isfinite(value):
        raise ValueError(f"{where}: {key} must be finite, not {value}")
    return value


def _date(cell):
    """Return the seconds since 1970 of a date with a time, UTC where no zone is named; of a time
    alone those since midnight.
    """
    if found := _MOMENT.fullmatch(cell.replace(",", ".")):
        day, month, year, time = found.groups()
        cell = f"{year or 1970}-{month or '01'}-{day or '01'} {time}"
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
