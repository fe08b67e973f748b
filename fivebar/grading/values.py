"""Reading what real files return: 0-d, 1-element and column arrays, lists, tuples, where floats
were asked.
"""

from __future__ import annotations

import numpy as np

from .exercise import Exercise

# An imaginary part where a real number was asked: of the largest number, or of this one.
ROUNDING, SMALL = 1e-12, 1e-3


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
    remarks = []
    if isinstance(value, dict) and value.get("~") == "dict":
        given = {key: part for key, part in value["pairs"] if isinstance(key, str)}
        if set(given) != set(names) or len(value["pairs"]) != len(names):
            raise Unfit(
                "shape",
                f"returned a dict of {', '.join(given) or 'no names'} where {_listed(names)} are"
                " asked",
            )
        remarks.append("came as a dict")
        value = [given[name] for name in names] if len(names) > 1 else given[names[0]]
    if len(names) == 1:
        parts = [value]
    elif isinstance(value, np.ndarray) and value.size == len(names) and not exercise.shapes:
        parts = list(value.ravel())
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.ndim):
        parts = list(value)
        if exercise.shapes and np.shape(_loose(value)) == exercise.shape(names[0]) != ():
            raise Unfit("shape", f"returned {names[0]} alone where {_listed(names)} are asked")
        if len(parts) != len(names):
            raise Unfit("shape", f"returned {len(parts)} values where {_listed(names)} are asked")
    else:
        raise Unfit(
            "shape",
            f"returned {_kind(value).replace('a ', 'one ', 1)} where {_listed(names)} are asked",
        )
    if isinstance(value, np.ndarray) and len(names) > 1:
        remarks.append(
            f"came as an array of shape {value.shape}, not as {len(names)} values"
            f" {', '.join(names)}"
        )
    numbers = [
        _numbers(name, part, exercise.shape(name), remarks) for name, part in zip(names, parts)
    ]
    return np.concatenate(numbers), remarks


def _numbers(name, part, shape, remarks):
    array = _array(name, part)
    if array.shape != shape:
        kept = tuple(n for n in array.shape if n != 1)
        if kept != tuple(n for n in shape if n != 1):
            if kept == tuple(n for n in reversed(shape) if n != 1):
                raise Unfit(
                    "shape", f"{name} has shape {array.shape}, asked is {shape}: its transpose?"
                )
            terms = ": print the shapes of what you add and multiply" if len(kept) == 1 else ""
            raise Unfit(
                "shape", f"{name} has shape {array.shape}, asked is {shape or 'a number'}{terms}"
            )
        remarks.append(f"{name} came with shape {array.shape}, asked is {shape or 'a number'}")
    return array.ravel()


def _array(name, part):
    if isinstance(part, str | dict) or part is None:
        raise Unfit("type", f"{name} is {_kind(part)}, not a number")
    try:
        array = np.asarray(part)
    except ValueError:
        raise Unfit("shape", f"{name} is a list of lists of different lengths") from None
    if array.dtype.kind == "c":
        size = max(np.abs(array).max(initial=0.0), SMALL)
        if np.any(np.abs(array.imag) > ROUNDING * size):
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
        return (
            "a dict"
            if value["~"] == "dict"
            else f"an object of type {value.get('type', 'unknown')}"
        )
    return "None" if value is None else "a string" if isinstance(value, str) else "a number"
