"""Reading what real files return: 0-d, 1-element and column arrays, lists, tuples, where floats
were asked.
"""

from __future__ import annotations

import numpy as np

from .exercise import Exercise

# An imaginary part where a real number was asked: of the largest number, or of this one.
ROUNDING = 1e-12
SMALL = 1e-3


class Unfit(ValueError):
    """A returned value that cannot be read as the answer; `reason` is "shape" or "type"."""

    def __init__(self, reason: str, text: str):
        super().__init__(text)
        self.reason = reason


def read(exercise: Exercise, value: object) -> tuple[np.ndarray, list[str]]:
    """Return the numbers in a returned value, (numbers,), and remarks on its form. Raises Unfit."""
    names = exercise.returns
    if value is None:
        raise Unfit("type", "returned None: is a return missing?")
    remarks: list[str] = []
    if isinstance(value, dict) and value.get("~") == "dict":
        value = _values_of_dict(names, value["pairs"])
        remarks.append("returned as a dict, which counts like the values alone")
    parts = [value] if len(names) == 1 else _parts(exercise, value)
    if isinstance(value, np.ndarray) and len(names) > 1:
        remarks.append(
            f"returned one array of shape {value.shape} for the {len(names)} values"
            f" {', '.join(names)}, which counts like these"
        )
    numbers = []
    for name, part in zip(names, parts):
        array = _array(name, part)
        shape = exercise.shape(name)
        if array.shape != shape:
            _refuse_other_shape(name, array.shape, shape)
            asked = f"an array of shape {shape}" if shape else "a number"
            remarks.append(
                f"{name} was returned with shape {array.shape} where {asked} is asked, which counts"
                " as well"
            )
        numbers.append(array.ravel())
    return np.concatenate(numbers), remarks


def _values_of_dict(names, pairs):
    """Return what a dict holds, as if the values had been returned without names."""
    given = {key: part for key, part in pairs if isinstance(key, str)}
    if set(given) != set(names) or len(pairs) != len(names):
        listed = ", ".join(given) or "no names"
        text = f"returned a dict of {listed} where {_listed(names)} are asked"
        raise Unfit("shape", text)
    return given[names[0]] if len(names) == 1 else [given[name] for name in names]


def _parts(exercise, value):
    """Return the parts of a value where several are asked."""
    names = exercise.returns
    asked = f"where {_listed(names)} are asked"
    is_array = isinstance(value, np.ndarray)
    if is_array and value.size == len(names) and not exercise.shapes:
        return list(value.ravel())
    is_sequence = isinstance(value, list) or (is_array and value.ndim)
    if not is_sequence:
        kind = _kind(value).replace("a ", "one ", 1)
        raise Unfit("shape", f"returned {kind} {asked}")
    parts = list(value)
    first_shape = exercise.shape(names[0])
    if first_shape and np.shape(_loose(value)) == first_shape:
        raise Unfit("shape", f"returned {names[0]} alone {asked}")
    if len(parts) == 1:
        raise Unfit("shape", f"returned one value {asked}: is the return inside a loop?")
    if len(parts) != len(names):
        raise Unfit("shape", f"returned {len(parts)} values {asked}")
    return parts


def _refuse_other_shape(name, came, asked):
    """Raise Unfit unless the shapes differ only by axes of length 1."""
    kept = _without_ones(came)
    wanted = _without_ones(asked)
    if kept == wanted:
        return
    if kept == wanted[::-1]:
        raise Unfit("shape", f"{name} has shape {came}, asked is {asked}: its transpose?")
    has = f"has shape {came}" if came else "is a number"
    text = f"{name} {has}, asked is {f'shape {asked}' if asked else 'a number'}"
    if len(kept) == 1:
        text += ": print the shapes of what you add and multiply"
    raise Unfit("shape", text)


def _without_ones(shape):
    return tuple(n for n in shape if n != 1)


def _array(name, part):
    if isinstance(part, str | dict) or part is None:
        raise Unfit("type", f"{name} is {_kind(part)}, not a number")
    try:
        array = np.asarray(part)
    except ValueError:
        raise Unfit("shape", f"{name} is a list of lists of different lengths") from None
    if array.dtype.kind == "c":
        largest = np.abs(array).max(initial=0.0)
        limit = ROUNDING * max(largest, SMALL)
        if np.any(np.abs(array.imag) > limit):
            raise Unfit("type", f"{name} is complex: the square root of a negative number?")
        array = array.real
    if array.dtype.kind not in "bif":
        raise Unfit("type", f"{name} holds something that is not a number")
    return array.astype(float)


def _loose(value):
    """Return the value as an array, of nothing where it is none."""
    try:
        return np.asarray(value, complex)
    except (TypeError, ValueError):
        return np.empty(0)


def _listed(names):
    return f"{len(names)} ({', '.join(names)})"


def _kind(value):
    if isinstance(value, dict):
        if value["~"] == "dict":
            return "a dict"
        return f"an object of type {value.get('type', 'unknown')}"
    if value is None:
        return "None"
    if isinstance(value, str):
        return "a string"
    return "a number"
