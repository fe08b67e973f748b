"""What stands beside a place in a student's program: values that have a name or a formula there,
and what is easily made of them.
"""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np

from .formulas import MATH, OLD

DIGITS = 9  # after the point, in which two values are the same
_NAME = re.compile(r"[A-Za-z_][\w.]*")
_ARRAY = re.compile(r"[A-Za-z_][\w.]*(\(\w+\))?")  # a name, or what a function gives for one
_ANGLE = re.compile(r"\(?[^()*/]*(q|phi|theta|psi|angle|alpha|beta)\w*(?<![Dd])\b[^()*/]*\)?")


def known_values(visits: list[dict[str, list[float]]], size: int) -> dict[str, np.ndarray]:
    """Return formula -> its values (samples,) of what a place of so many numbers can be computed
    from, OLD's among them; visits: formula -> its numbers, of each visit.
    """
    numbers, arrays = {}, {}
    for text in visits[0]:
        parts = [visit.get(text, []) for visit in visits]
        sizes = {*map(len, parts)}
        if sizes in ({1}, {size}):
            values = np.broadcast_to(np.array(parts), (len(visits), size))
            name = text if _NAME.fullmatch(text) else f"({text})"
            numbers[name] = values.ravel()
        if len(sizes) == 1 and _ARRAY.fullmatch(text):
            arrays[text] = np.array(parts)
    old = {OLD: numbers.pop(OLD)} if OLD in numbers else {}
    # Before sums and sines, of which there may be more than are looked at.
    made = _parts(arrays) if size == 1 else _images(arrays, size)
    numbers |= made | _sums(numbers)
    numbers |= _turned(numbers)
    return old | _different(numbers)


def _sums(numbers):
    """Return the sums and differences of names that are alike: q11 and q12, qaD and qpD."""
    made = {}
    for (one, a), (other, b) in combinations(numbers.items(), 2):
        if _NAME.fullmatch(one) and _kin(one) == _kin(other):
            made[f"({one} + {other})"] = a + b
            made[f"({one} - {other})"] = a - b
    return made


def _kin(name):
    """Return a name without what tells a leg or a bar: its first letter, and the derivative."""
    return name[0], len(name), len(name) - len(name.rstrip("D"))


def _turned(numbers):
    """Return the sines and cosines of what may be an angle."""
    made = {}
    for name, value in numbers.items():
        if _ANGLE.fullmatch(name):
            made[f"{MATH}sin({name})"] = np.sin(value)
            made[f"{MATH}cos({name})"] = np.cos(value)
    return made


def _parts(arrays):
    """Return the parts of plane vectors and matrices."""
    made = {}
    for name, value in arrays.items():
        if value.shape[1] in (2, 4):
            for k, number in enumerate(value.T):
                row = f"{name}[{k // 2}]" if value.shape[1] == 4 else name
                made[f"{row}[{k % 2}]"] = number
    return made


def _images(arrays, size):
    """Return the products of so many numbers: of what has two columns, and what has two rows."""
    made = {}
    for one, a in arrays.items():
        for other, b in arrays.items():
            width = b.shape[1] // 2
            fits = b.shape[1] in (2, 4) and a.shape[1] % 2 == 0
            if fits and a.shape[1] * width == 2 * size:
                left = a.reshape(len(a), -1, 2)
                right = b.reshape(len(b), 2, width)
                made[f"({one} @ {other})"] = (left @ right).ravel()
    return made


def _different(numbers):
    """Return those values that no other one before them equals, but for the sign."""
    known: dict = {}
    for name, value in numbers.items():
        first = value[np.flatnonzero(value)[:1]].sum()
        size = value * np.sign(first or 1)
        known.setdefault(tuple(np.round(size, DIGITS)), name)
    return {name: numbers[name] for name in known.values()}
