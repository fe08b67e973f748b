"""Tables as people have them: whatever stands between their columns, before their decimals and
after their names.

`tables` reads what fivebar wrote; this reads what others did, in SI units, and says what it made of
it.
"""

from __future__ import annotations

import csv
import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from types import MappingProxyType

import numpy as np

from .backend import HUGE
from .checks import shown
from .tables import TextFile, whole_text

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254}
RADIANS = {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3, "rev": 2 * math.pi}
RADIANS_PER_SECOND = {
    "rad/s": 1.0,
    "deg/s": math.pi / 180,
    "rpm": math.pi / 30,
    "rev/s": 2 * math.pi,
}
RADIANS_PER_SECOND2 = {"rad/s2": 1.0, "deg/s2": math.pi / 180}
NEWTON_METRES = {"nm": 1.0, "mnm": 1e-3, "ncm": 1e-2, "kgcm": 0.0980665}
COUNTS = {"counts": 1.0}
NO_UNIT = {"1": 1.0}

_WORDS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millis", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("microsecond", "microseconds"), "us"),
    **dict.fromkeys(("nanosecond", "nanoseconds", "nsec", "nsecs"), "ns"),
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("millimetre", "millimetres", "millimeter", "millimeters"), "mm"),
    **dict.fromkeys(("inch", "inches"), "in"),
    **dict.fromkeys(("°", "degree", "degrees", "degre", "degres"), "deg"),
    **dict.fromkeys(("°/s", "degrees/s"), "deg/s"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("turn", "turns", "revolution", "revolutions", "tr", "tour", "tours"), "rev"),
    "tr/min": "rpm",
    **dict.fromkeys(("count", "ticks", "steps", "inc"), "counts"),
}
_CLOCK = re.compile(r"\d{4}-\d\d-\d\d[ T]\d\d:\d\d:\d\d(\.\d+)?(Z|[-+]\d\d:?\d\d)?")
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-"}


@dataclass(frozen=True)
class Quantity:
    """A column that is looked for: the names it goes by, its units with what each is in the first,
    which is SI, whether there must be one, and a regular expression of further headings.
    """

    names: tuple[str, ...]
    units: Mapping[str, float]
    needed: bool = True
    pattern: str = ""


# What a French, German, Spanish or Italian table calls it, too.
TIME = Quantity(
    ("time", "times", "timestamp", "stamp", "seconds", "temps", "zeit", "tiempo", "tempo"), SECONDS
)


@dataclass(frozen=True, eq=False)
class Columns:
    """What a file holds. values: name -> (n,), SI, nan where a cell is empty; lines: (n,), the
    row's line in the file.

    said: sentences on what was converted, assumed or passed over; stated: the names whose unit
        somebody named.
    """

    name: str
    values: dict[str, np.ndarray]
    lines: np.ndarray
    notes: tuple[str, ...] = ()
    stated: frozenset[str] = field(default_factory=frozenset)

    def error(self, row: int, message: str) -> ValueError:
        """What to raise where a row is wrong."""
        return ValueError(f"{self.name}, line {self.lines[row]}: {message}")


def read(
    file: TextFile,
    wanted: Mapping[str, Quantity],
    units: Mapping[str, str] | Sequence[str] = MappingProxyType({}),
) -> Columns:
    """The wanted columns of a CSV file, by their headings, in SI units.

    Columns are parted by commas, semicolons, tabs, bars or blanks; decimals by points or commas. A
    heading is a name
    and perhaps a unit: x, X [mm], q1 (deg), time/ms, x_mm; or a row of units follows. Lines with #
    or % are comments, the last of them the header where none follows (as NumPy and ROS write it).
    Times may be of a clock, as 2024-05-01 10:00:00.25, or have their unit with them, as 0.25 sec.

    file: path or open text file; units: {name: unit} or units alone ("mm", "t=ms"), for headings
    without one. ValueError with file and line for what is missing, twice there, no number, not
    finite, or of contradicting units.
    """
    text, name = whole_text(file, "a table")
    numbered = [(k, line.strip()) for k, line in enumerate(text.splitlines(), 1)]
    comments = [(k, line) for k, line in numbered if line.startswith(("#", "%"))]
    numbered = [(k, line) for k, line in numbered if line and not line.startswith(("#", "%"))]
    mark = None
    if numbered and (excel := re.fullmatch(r"(?i)sep=(.)", numbered[0][1])):
        mark, numbered = excel[1], numbered[1:]
    before = [(k, line.lstrip("#% ")) for k, line in comments if not numbered or k < numbered[0][0]]
    if (
        numbered
        and before
        and not _only_numbers(before[-1][1])
        and _is_a_row(numbered[0][1], before[-1][1])
    ):
        numbered.insert(0, before[-1])
    if not numbered:
        raise ValueError(f"{name}: empty; needed a header with {_listed(wanted)}")
    (top, header), rows = numbered[0], numbered[1:]
    if _only_numbers(header):
        raise ValueError(
            f"{name}, line {top}: no header, but numbers; needed one with {_listed(wanted)}"
        )
    mark = mark or next((c for c in ";\t,|" if c in header), None)
    headings = [cell.strip() for cell in _cells(header, mark, f"{name}, line {top}")]
    if rows and (
        own := _units_row(
            _cells(rows[0][1], mark, f"{name}, line {rows[0][0]}"), wanted, len(headings)
        )
    ):
        headings, rows = (
            [f"{heading} [{unit}]" if unit else heading for heading, unit in zip(headings, own)],
            rows[1:],
        )
    found, notes, stated = _matched(headings, wanted, units, f"{name}, line {top}")
    if before and before[0][1].startswith("fivebar ") and "SI units" in before[0][1]:
        stated |= set(found)
    if not rows:
        raise ValueError(f"{name}: no rows under the header")
    table, comma = _numbers(
        rows, mark, len(headings), {key: place for key, (place, _) in found.items()}, name
    )
    if comma:
        notes.append("decimal commas were read as decimal points")
    for (key, (place, unit)), column in zip(found.items(), table.T):
        column *= wanted[key].units[unit]
        if (huge := np.abs(column) >= HUGE).any():
            line = rows[huge.argmax()][0]
            raise ValueError(
                f"{name}, line {line}: {key} must be below {HUGE:g} in size, not"
                f" {column[huge][0]:g}"
            )
        if unit != next(iter(wanted[key].units)):
            notes.append(f"{headings[place]}: read in {unit}")
    return Columns(
        name,
        dict(zip(found, table.T)),
        np.array([k for k, _ in rows]),
        tuple(notes),
        frozenset(stated),
    )


def units_named(value: object, name: str) -> Mapping[str, str] | tuple[str, ...]:
    """Rule: what `read` takes as units; one word alone is one unit."""
    if value is None or isinstance(value, str):
        return (value,) if value else ()
    if isinstance(value, Mapping) and all(
        isinstance(each, str) for pair in value.items() for each in pair
    ):
        return value
    if (
        isinstance(value, Sequence)
        and not isinstance(value, bytes)
        and all(isinstance(each, str) for each in value)
    ):
        return tuple(value)
    raise TypeError(f"{name} must be units in words, as mm, or {{name: unit}}, not {shown(value)}")


def _cells(line: str, mark: str | None, where: str) -> list[str]:
    try:
        return (
            next(csv.reader([line], delimiter=mark, skipinitialspace=True))
            if mark
            else line.split()
        )
    except csv.Error as error:
        raise ValueError(f"{where}: {error}: {line[:40]!r}...") from None


def _only_numbers(line: str) -> bool:
    return all(
        re.fullmatch(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?", c)
        for c in re.split(r"[;,\t| ]+", line)
        if c
    )


def _is_a_row(line: str, header: str) -> bool:
    """Whether a line has numbers, and as many cells as this header."""
    mark = next((c for c in ";\t,|" if c in header), None)
    cells = line.split(mark)
    return _only_numbers(line) or (
        len(cells) == len(header.split(mark)) and any(map(_only_numbers, filter(None, cells)))
    )


def _units_row(cells: list[str], wanted: Mapping[str, Quantity], count: int) -> list[str]:
    """The units that a row under the header names, "" where none; [] if it is no such row."""
    known = {unit for quantity in wanted.values() for unit in quantity.units} - {"1"}
    words = [cell.strip().strip("[](){}").strip() for cell in cells]
    if len(words) < count or any(word and _only_numbers(word) for word in words):
        return []
    return (
        ["" if word == "-" else word for word in words]
        if any(_unit(word) in known for word in words)
        else []
    )


def _listed(wanted: Mapping[str, Quantity]) -> str:
    needed = [key for key, quantity in wanted.items() if quantity.needed]
    rest = [key for key in wanted if key not in needed]
    return ", ".join(needed) + (f" (and perhaps {', '.join(rest)})" if rest else "")


def _plain(heading: str) -> str:
    return re.sub(r"[\s_.\-]", "", _unaccented(heading))


def _unaccented(word: str) -> str:
    return "".join(
        c for c in unicodedata.normalize("NFKD", word).casefold() if not unicodedata.combining(c)
    )


def _unit(word: str) -> str:
    word = re.sub(r"[\s·*.^]", "", _unaccented(word).replace("μ", "u"))
    return _WORDS.get(word, word)


def _parted(
    heading: str, wanted: Mapping[str, Quantity], where: str
) -> tuple[str | None, str | None]:
    """Which quantity a heading names, and its unit in the quantity's own word, if any."""
    names = {
        _plain(name): key for key, quantity in wanted.items() for name in (key, *quantity.names)
    }
    if _plain(heading) in names:
        return names[_plain(heading)], None
    for key, quantity in wanted.items():
        if quantity.pattern and re.fullmatch(quantity.pattern, heading, re.IGNORECASE):
            return key, None
    bracket = re.fullmatch(r"(.*?)\s*[(\[{<]\s*(.*?)\s*[)\]}>]", heading)
    if bracket and _plain(bracket[1]) in names:
        key = names[_plain(bracket[1])]
        unit = _unit(bracket[2])
        if unit in ("", "-") or unit in wanted[key].units:
            return key, unit if unit in wanted[key].units else None
        raise ValueError(
            f"{where}: column {heading!r}: {bracket[2]!r} is none of {', '.join(wanted[key].units)}"
        )
    for parts in re.finditer(r"[\s_/,]+", heading):
        key = names.get(_plain(heading[: parts.start()]))
        unit = _unit(re.sub(r"^in\s+(?=\w)", "", heading[parts.end() :]))
        if key and unit in wanted[key].units:
            return key, unit
    return None, None


def _matched(headings, wanted, units, where):
    given = _given(units, wanted)
    found, notes, stated = {}, [], set()
    for place, heading in enumerate(headings):
        key, unit = _parted(heading, wanted, where)
        if key is None:
            if heading:
                notes.append(f"column {heading!r} is not used")
            continue
        if key in found:
            raise ValueError(
                f"{where}: {headings[found[key][0]]!r} and {heading!r} both are {key}; leave one"
            )
        if unit and given.get(key, unit) != unit:
            raise ValueError(
                f"{where}: column {heading!r} is in {unit}, but its unit is given as {given[key]}"
            )
        unit = unit or given.get(key)
        if unit:
            stated.add(key)
        found[key] = place, unit or next(iter(wanted[key].units))
    if missing := [key for key, quantity in wanted.items() if quantity.needed and key not in found]:
        names = "; ".join(" or ".join(dict.fromkeys([key, *wanted[key].names])) for key in missing)
        raise ValueError(f"{where}: no column {names}; found {', '.join(map(repr, headings))}")
    return found, notes, stated


def _given(units, wanted):
    """{name: unit} of what a user says beside the file."""
    pairs = (
        units.items()
        if isinstance(units, Mapping)
        else [w.split("=", 1) if "=" in w else ("", w) for w in units]
    )
    given = {}
    for key, word in pairs:
        unit = _unit(word)
        fits = [k for k, quantity in wanted.items() if unit in quantity.units and key in ("", k)]
        if not fits:
            known = (
                wanted[key].units
                if key in wanted
                else dict.fromkeys(u for q in wanted.values() for u in q.units)
            )
            what = f"{key}={word}" if key else word
            raise ValueError(f"units: {what}: known are {', '.join(known)}, of {', '.join(wanted)}")
        given |= dict.fromkeys(fits, unit)
    return given


def _numbers(rows, mark, count, places, name):
    """The columns at these places, (n, len(places)), and whether decimals were commas."""
    lines = [line for _, line in rows]
    comma = mark != "," and any("," in line for line in lines)
    if comma and not any("." in line for line in lines):
        lines = [line.replace(",", ".") for line in lines]
    try:  # in one go; what is wrong, or missing, is looked for below
        if {line.count(mark) for line in lines} == {count - 1} if mark else True:
            table = np.loadtxt(
                lines, delimiter=mark, usecols=list(places.values()), comments=None, ndmin=2
            )
            if np.isfinite(table).all():
                return table, comma
    except ValueError:
        pass
    table = np.empty((len(rows), len(places)))
    for row, (number, line) in enumerate(rows):
        where = f"{name}, line {number}"
        cells = _cells(line, mark, where)
        if len(cells) != count and (any(cells[count:]) or len(cells) < count):
            hint = (
                "; decimal commas need ; between the columns"
                if mark == "," and len(cells) >= 2 * count - 1
                else ""
            )
            raise ValueError(f"{where}: {len(cells)} cells, where the header has {count}{hint}")
        comma |= any("," in cells[place] for place in places.values())
        table[row] = [_number(cells[place], key, where) for key, place in places.items()]
    return table, comma


def _number(cell, key, where):
    cell = cell.strip()
    if cell.casefold() in _MISSING:
        return math.nan
    if key == "t" and _CLOCK.fullmatch(cell):
        at = datetime.fromisoformat(cell.replace("Z", "+00:00"))
        return (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()
    if key == "t":
        cell = re.sub(r"(?<=\d)\s*s(ec(onds?)?)?$", "", cell)
    try:
        value = float(cell if "." in cell else cell.replace(",", "."))
    except ValueError:
        raise ValueError(f"{where}: {key} must be a number, not {cell[:40]!r}") from None
    if not math.isfinite(value):
        raise ValueError(f"{where}: {key} must be finite, not {value}")
    return value
