"""Calls a student's function and puts what comes back into plain JSON data; standard library
only.
"""

from __future__ import annotations

import signal
import sys
import time
import types
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction

MOST_NUMBERS = 10_000  # in one answer
MOST_TEXT = 500  # characters of a message or a name
MOST_BITS = 1000  # of an integer
DEEPEST = 8  # lists in each other
_VIEWS: tuple = (
    {}.values(),
    {}.keys(),
    range(0),
    map(abs, ()),
    filter(abs, ()),
    zip(),
    reversed(()),
)
ITERATORS = {types.GeneratorType, *map(type, _VIEWS)}


def plain(value: object) -> object:
    """Return jSON data of a returned value; none of the value's own methods are trusted or called,
    but NumPy's and the steps of an iterator.
    """
    return _plain(value, [MOST_NUMBERS], 0)


def _plain(value, room, depth):
    kind = type(value)
    room[0] -= 1
    if room[0] < 0 or depth > DEEPEST:
        raise OverflowError
    if value is None or kind is bool:
        return value
    if issubclass(kind, int):
        value = int.__pos__(value)
        return (
            value
            if value.bit_length() <= MOST_BITS
            else _other(kind, f"of {value.bit_length()} bits")
        )
    numpy = sys.modules.get("numpy")
    if numpy is not None and issubclass(kind, numpy.generic):
        item = value.item()
        return _plain(
            item if type(item) in (bool, int, float, complex, str) else float(value),
            room,
            depth + 1,
        )
    if issubclass(kind, float):
        return float.__pos__(value)
    if issubclass(kind, complex):
        value = complex.__pos__(value)
        return {"~": "complex", "re": value.real, "im": value.imag}
    if issubclass(kind, str):
        return str.__getitem__(value, slice(MOST_TEXT))
    for number in (Fraction, Decimal):
        if issubclass(kind, number):
            return float(number.__float__(value))
    if issubclass(kind, dict):
        pairs = []
        for key, part in dict.items(value):
            pairs.append([_plain(key, room, depth + 1), _plain(part, room, depth + 1)])
        return {"~": "dict", "pairs": pairs}
    for sequence in (list, tuple):
        if issubclass(kind, sequence):
            return [_plain(part, room, depth + 1) for part in sequence.__iter__(value)]
    if kind in ITERATORS:  # the student's own steps, and perhaps without end
        return [_plain(part, room, depth + 1) for part in value]
    if numpy is not None and issubclass(kind, numpy.ndarray):
        if value.size > room[0]:
            raise OverflowError
        flat = numpy.asarray(value).ravel().tolist()
        return {
            "~": "array",
            "shape": list(value.shape),
            "data": [_plain(part, room, depth + 1) for part in flat],
        }
    return _other(kind, "")


def _other(kind, text):
    return {"~": "other", "type": kind.__name__[:MOST_TEXT], "text": text}


class OutOfTime(BaseException):
    """A call has taken all of its time."""


def end_call(*_: object) -> None:
    """End the call that runs, as its timer's signal asks. Raises OutOfTime."""
    raise OutOfTime


def call(function: Callable, row: list, file: str, limit: float = 0.0) -> dict:
    """Return what `function(*row)` did: kind "k", value "v" or text "t" with the line "l" in
    `file`, and seconds "s" of processor time.

    limit: seconds after which `end_call` ends it, 0 for none.
    """
    start = time.process_time()
    try:
        if limit:
            signal.setitimer(signal.ITIMER_REAL, limit)
        try:
            value = function(*row)
        finally:
            left = signal.setitimer(signal.ITIMER_REAL, 0)[0] if limit else 1
        if not left:  # the function has caught its end, and gone on
            raise OutOfTime
        try:
            answer: dict = {"k": "value", "v": plain(value)}
        except OverflowError:
            answer = {
                "k": "flood",
                "t": f"more than {MOST_NUMBERS} numbers, or {DEEPEST} lists in each other",
            }
        del value
    except OutOfTime as error:
        answer = {"k": "timeout", "t": f"no answer within {limit:g} s", "l": _line(error, file)}
    except BaseException as error:
        answer = failure(error, file)
    answer["s"] = time.process_time() - start
    return answer


def failure(error: BaseException, file: str) -> dict:
    """Return kind, text and the student's own line of an exception of any making."""
    if isinstance(error, MemoryError):
        return {"k": "memory", "t": "", "l": _line(error, file)}
    try:
        name, message = type(error).__name__, str(error)
        if isinstance(error, SyntaxError) and error.filename == file:
            message = str(error.msg)  # the line is told apart
        elif isinstance(error, EOFError):
            message += ": nobody answers an input() here, so write the value into the file"
    except BaseException:
        name, message = "exception", "<no message>"
    if isinstance(error, SystemExit):
        return {"k": "exit", "t": f"sys.exit({message})"[:MOST_TEXT], "l": _line(error, file)}
    text = f"{name}: {message}" if message else name
    return {"k": "exception", "t": text[:MOST_TEXT], "l": _line(error, file)}


def _line(error, file):
    """Return the last line of `file` in the exception's traceback, or of the syntax error in it."""
    line, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    if isinstance(error, SyntaxError) and error.filename == file:
        line = error.lineno
    return line if type(line) is int else None
