"""What a worker process sends, read as a stranger's text: lines of JSON with a limit, into Replies
of plain values.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np

from .replies import KINDS, Reply

MOST_LINE = 1_000_000  # bytes of a message
MOST_TEXT = 500  # characters of a message or a name
MOST_BITS = 1000  # of an integer
MOST_NUMBERS = 10_000  # in one array
MOST_BESIDE = 150  # values beside a place
DEEPEST = 16  # lists in each other, those of the protocol among them


@dataclass(eq=False)
class Lost(Exception):
    """A worker's end: a Reply's kind, and what is known of it; outside: it was none of the
    program's own doing.
    """

    kind: str
    text: str = ""
    outside: bool = False


class Garbled(Lost):
    """A line that is no message of the protocol."""

    def __init__(self, text: str):
        super().__init__("garbled", text)


def message(line: bytes, nonce: str) -> dict:
    """Return the JSON object in a line that carries the nonce. Raises Garbled."""
    try:
        data = json.loads(line)
    except (ValueError, RecursionError):
        raise Garbled("a line that is no message") from None
    if not isinstance(data, dict) or data.get("n") != nonce:
        raise Garbled("a message that answers nothing asked")
    return data


def reply(data: dict, lines: list[str]) -> Reply:
    """Return reply in a worker's message; `lines` are the student's own, to quote from. Raises
    Garbled.
    """
    kind = data.get("k")
    if not isinstance(kind, str) or kind not in KINDS or not isinstance(data.get("t", ""), str):
        raise Garbled("a message of no known kind")
    seconds = data.get("s", 0.0)
    if type(seconds) not in (int, float) or not 0 <= seconds < 1e6:
        raise Garbled("a message with no duration")
    line, source = place(data.get("l"), lines)
    found = value(data.get("v")) if kind == "value" else None
    visits, beside = visits_of(data.get("visits", [])), beside_of(data.get("beside", []))
    text = clean(data.get("t", ""))
    return Reply(kind, found, text, line, source, float(seconds), visits, beside)


def place(line: object, lines: list[str]) -> tuple[int | None, str]:
    """Return (line number or None, its text), for a claimed line number."""
    if type(line) is not int or not 1 <= line <= len(lines):
        return None, ""
    return line, clean(lines[line - 1].strip())


def clean(text: str, most: int = MOST_TEXT) -> str:
    """Return text of a limited length without control characters, safe on a terminal."""
    return "".join(
        c if c.isprintable() or c in "\n\t" else "\N{REPLACEMENT CHARACTER}" for c in text[:most]
    )


def outlined(data: object) -> dict[str, tuple[list[str], list[str]]]:
    """Return function -> (its arguments, the functions that it mentions), as a worker tells them;
    none where that is no such message.
    """
    if not isinstance(data, dict):
        return {}
    outline = {}
    for name, pair in data.items():
        if not isinstance(pair, list) or len(pair) != 2:
            return {}
        for words in pair:
            if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
                return {}
        outline[name] = tuple(pair)
    return outline


@dataclass(frozen=True)
class Change:
    """A change of a student's program that a worker can try: its line, what it is about, the
    function that it is in, what stands there and what would.
    """

    line: int
    kind: str
    function: str
    old: str
    new: str


def told(data: object) -> list[Change]:
    """Return the changes that a worker tells. Raises Garbled."""
    if not isinstance(data, list):
        raise Garbled("changes that are no list")
    changes = []
    for row in data:
        line, *words = row if isinstance(row, list) and row else [None]
        are_words = all(isinstance(word, str) for word in words)
        if type(line) is not int or len(words) != 4 or not are_words:
            raise Garbled("a change that is none")
        changes.append(Change(line, *map(clean, words)))
    return changes


def visits_of(data: object) -> dict[int, list[list[float]]]:
    """Return place -> the numbers of each visit, as a watched program tells them. Raises
    Garbled.
    """
    visits = {}
    for place, told in _pairs(data):
        if type(place) is not int or not isinstance(told, list):
            raise Garbled("visits of no place")
        visits[place] = [_numbers(numbers) for numbers in told]
    return visits


def beside_of(data: object) -> list[dict[str, list[float]]]:
    """Return formula -> its numbers, for each visit of one place, as a watched program tells them.
    Raises Garbled.
    """
    if not isinstance(data, list):
        raise Garbled("visits that are no list")
    told = []
    for visit in data:
        known = {}
        for name, numbers in _pairs(visit, MOST_BESIDE):
            if not isinstance(name, str):
                raise Garbled("a value that belongs to nothing")
            known[clean(name)] = _numbers(numbers)
        told.append(known)
    return told


def _pairs(data, most=MOST_NUMBERS):
    if not isinstance(data, list) or len(data) > most:
        raise Garbled("pairs that are no list, or too many")
    if not all(isinstance(pair, list) and len(pair) == 2 for pair in data):
        raise Garbled("a pair that is none")
    return data


def _numbers(data):
    if not isinstance(data, list) or not all(type(n) is float and math.isfinite(n) for n in data):
        raise Garbled("a value that is no number")
    return data


def whole(data: object) -> int:
    """Return a count that a worker tells. Raises Garbled."""
    if type(data) is not int or not 0 <= data < 1e6:
        raise Garbled("a count that is none")
    return data


def value(data: object, depth: int = 0) -> object:
    """Return python and NumPy values of plain data: numbers, text, None, lists, and objects marked
    by "~".
    """
    if depth > DEEPEST:
        raise Garbled("lists too deep in each other")
    if isinstance(data, list):
        return [value(part, depth + 1) for part in data]
    if isinstance(data, str):
        return clean(data)
    if type(data) is int and data.bit_length() > MOST_BITS:
        raise Garbled("an integer too long")
    if not isinstance(data, dict):
        return data
    kind = data.get("~")
    if kind == "complex" and _is_number(data.get("re")) and _is_number(data.get("im")):
        return complex(data["re"], data["im"])
    if kind == "dict":
        pairs = []
        for key, part in _pairs(data.get("pairs")):
            pairs.append([value(key, depth + 2), value(part, depth + 2)])
        return {"~": "dict", "pairs": pairs}
    if kind == "array":
        return _array(data.get("shape"), data.get("data"), depth + 1)
    if kind == "other" and isinstance(data.get("type"), str) and isinstance(data.get("text"), str):
        return {"~": "other", "type": clean(data["type"]), "text": clean(data["text"])}
    raise Garbled("a value of no known kind")


def _is_number(data):
    return isinstance(data, float) or (type(data) is int and data.bit_length() <= MOST_BITS)


def _array(shape, data, depth):
    """Return an array as the worker described it; of objects where its parts are not all
    numbers.
    """
    ok = (
        isinstance(shape, list)
        and isinstance(data, list)
        and all(type(n) is int and n >= 0 for n in shape)
    )
    if (
        not ok
        or len(shape) > 32
        or math.prod(max(n, 1) for n in shape) > MOST_NUMBERS
        or math.prod(shape) != len(data)
    ):
        raise Garbled("an array whose parts do not fit its shape")
    parts = [value(part, depth) for part in data]
    if all(isinstance(part, bool | int | float | complex) for part in parts):
        found = np.array(parts, dtype=None if parts else float)
    else:
        found = np.empty(len(parts), dtype=object)
        for i, part in enumerate(parts):
            found[i] = part
    return found.reshape(shape)
