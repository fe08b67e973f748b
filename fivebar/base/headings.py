"""Which column of a table a heading names, and in which unit: by itself, or as the caller says."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .checks import shown
from .units import SECONDS, unaccented, unit_named

# How the caller names a column: its heading, the place in its lists, and its unit.
_CALLED = re.compile(r"(.*?)\s*(?:\[(\d+)\])?\s*(?:[(\[{<]\s*(\D.*?|)\s*[)\]}>])?")


@dataclass(frozen=True)
class Quantity:
    """A column that is looked for.

    Attributes
    ----------
    names : tuple of str
        Headings besides the column's own name; case, spaces, dots and accents do not count.
    units : mapping
        {unit: its size in SI units}; the first is the SI unit.
    needed : bool
        Whether a table without it is refused.
    """

    names: tuple[str, ...]
    units: Mapping[str, float]
    needed: bool = True


TIME = Quantity(
    ("time", "times", "timestamp", "stamp", "seconds", "temps", "zeit", "tiempo", "tempo"), SECONDS
)


def units_named(value: Any, name: str) -> Mapping[str, str] | tuple[str, ...]:
    """Rule: what `read` takes as units or columns; one word alone is one unit."""
    if value is None or isinstance(value, str):
        return (value,) if value else ()
    words: Iterable = ()
    if isinstance(value, Mapping):
        words = [*value, *value.values()]
    elif isinstance(value, Sequence) and not isinstance(value, bytes):
        words = value = tuple(value)
    else:
        words = (None,)
    if not all(isinstance(word, str) for word in words):
        raise TypeError(
            f"{name} must be words, as mm or t=ms, or a mapping of words, not {shown(value)}"
        )
    return value


def units_by_name(
    units: Mapping[str, str] | Iterable[str], wanted: Mapping[str, Quantity]
) -> dict[str, str]:
    """Return {name: unit} of what the caller says besides the table."""
    if isinstance(units, Mapping):
        pairs = list(units.items())
    else:
        pairs = [word.rpartition("=")[::2] for word in units]
    result: dict[str, str] = {}
    for key, word in pairs:
        unit = unit_named(word)
        fitting = [k for k in wanted if unit in wanted[k].units and key in ("", k)]
        if not fitting:
            known = dict.fromkeys(u for quantity in wanted.values() for u in quantity.units)
            if key in wanted:
                known = wanted[key].units
            what = f"{key}={word}" if key else word
            raise ValueError(
                f"units: {what}: known are {', '.join(known)}, of the columns {', '.join(wanted)}"
            )
        result |= dict.fromkeys(fitting, unit)
    return result


def headings_by_name(
    columns: Mapping[str, str] | Sequence[str] | None, wanted: Iterable[str]
) -> dict[str, str]:
    """Return {name: heading} of what the caller says about columns, the names among the wanted."""
    columns = units_named(columns, "columns")
    pairs = columns.items() if isinstance(columns, Mapping) else map(_halves, columns)
    calls = dict(pairs)
    for key, heading in calls.items():
        if key not in wanted or not heading:
            known = ", ".join(wanted)
            raise ValueError(f"columns: {key}={heading} must be NAME=HEADING, NAME one of {known}")
    return calls


def _halves(word):
    return word.partition("=")[::2]


def called_column(call: str, headings: Sequence[str], where: str) -> tuple[int, int | None, str]:
    """Return the place of the heading that the caller names, the place in its lists or None, and
    its unit.
    """
    name, index, unit = _parts(call)
    bare = [_parts(heading)[0] for heading in headings]
    for words, fitting in ((headings, call), (headings, name), (bare, name)):
        if fitting in words:
            place = words.index(fitting)
            of_heading = _parts(headings[place])[2]
            unit = of_heading if fitting == call else unit or of_heading
            index = None if index is None or headings[place] == call else int(index)
            return place, index, unit or ""
    found = ", ".join(map(repr, headings))
    raise ValueError(f"{where}: columns: no heading is {call!r}; found {found}")


def _parts(words):
    """Return the heading, the place in its lists and the unit in what the caller says."""
    return _CALLED.fullmatch(words).groups()


def plain(heading: str) -> str:
    """Return a heading in small letters, without spaces, dots and accents."""
    return re.sub(r"[\s_.\-]", "", unaccented(heading))


def names_of(wanted: Mapping[str, Quantity]) -> dict[str, str]:
    """Return {heading without case, spaces and accents: column}."""
    names: dict[str, str] = {}
    for key, quantity in wanted.items():
        names |= {plain(name): key for name in (key, *quantity.names)}
    return names


def column_and_unit(heading, wanted, names, units, where):
    """Return the column that a heading names, and its unit; None for what nothing names."""
    key, unit = _in_words(heading, wanted, names, units, where)
    if unit and units.get(key, unit) != unit:
        raise ValueError(
            f"{where}: column {heading!r} is in {unit}, but its unit is given as {units[key]}"
        )
    return key, unit or units.get(key)


def _in_words(heading, wanted, names, units, where):
    if plain(heading) in names:
        return names[plain(heading)], None
    bracket = re.fullmatch(r"(.*?)\s*[(\[{<]\s*(.*?)\s*[)\]}>]", heading)
    if bracket and plain(bracket[1]) in names:
        key, unit = (names[plain(bracket[1])], unit_named(bracket[2]))
        if unit in wanted[key].units:
            return key, unit
        if unit in ("", "-") or key in units:
            return key, None
        known = ", ".join(wanted[key].units)
        raise ValueError(f"{where}: column {heading!r}: {bracket[2]!r} is none of {known}")
    for separator in re.finditer(r"[\s_/,]+", heading):
        key = names.get(plain(heading[: separator.start()]))
        unit = unit_named(re.sub(r"^in\s+(?=\w)", "", heading[separator.end() :]))
        if key and unit in wanted[key].units:
            return key, unit
    return None, None


def matched(
    headings: Sequence[str],
    wanted: Mapping[str, Quantity],
    units: Mapping[str, str],
    where: str,
    calls: Mapping[str, str],
    called: Mapping[int, str],
) -> tuple[dict[str, int], dict[str, str], list[str]]:
    """Return {column: its place}, {column: its unit} where one is named, and unused headings."""
    names = names_of(wanted)
    places: dict[str, int] = {}
    own_units: dict[str, str] = {}
    unused = []
    for place, heading in enumerate(headings):
        key, unit = column_and_unit(called.get(place, heading), wanted, names, units, where)
        if key is None or (key in calls and place not in called):
            if heading:
                unused.append(heading)
            continue
        if key in places:
            raise ValueError(
                f"{where}: {headings[places[key]]!r} and {heading!r} both are {key}; leave one"
            )
        places[key] = place
        if unit:
            own_units[key] = unit
    if missing := missing_of(wanted, places):
        found = ", ".join(map(repr, headings))
        raise ValueError(
            f"{where}: no column {', '.join(missing)}; found {found}: {how_to_name(missing)}"
        )
    return places, own_units, unused


def missing_of(wanted: Mapping[str, Quantity], there: Iterable[str]) -> list[str]:
    """Return the columns that are needed and not there."""
    return [key for key, quantity in wanted.items() if quantity.needed and key not in there]


def how_to_name(missing: Iterable[str]) -> str:
    """Return how the caller says which columns these are."""
    words = " ".join(f"{key}=HEADING" for key in missing)
    return f"say which they are, by columns= or --columns {words}"
