"""What stands beside a place in a student's program: values that have a name or a formula there,
and what is easily made of them.
"""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np

from .formulas import MATH, NUMPY, OLD

DIGITS = 9  # after the point, in which two values are the same
_NAME = re.compile(r"[A-Za-z_][\w.]*")
_ARRAY = re.compile(r"[A-Za-z_][\w.]*(\(\w+\))?")  # a name, or what a function gives for one
_RATE = re.compile(r"\w*[^D]D")
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
    plain = dict(numbers)
    numbers |= _sums(numbers)
    numbers |= _turned(numbers)
    numbers |= _speeds(plain)
    if size == 1:
        numbers |= _products(arrays)
    else:
        vectors = arrays | _pairs(arrays)
        numbers |= _images(arrays, vectors, size)
    return old | _different(numbers)


def _sums(numbers):
    """Return the sums and differences of names that are alike: q11 and q12, qaD and qpD."""
    made = {}
    for (one, a), (other, b) in combinations(numbers.items(), 2):
        if _NAME.fullmatch(one) and _kin(one) == _kin(other):
            made[f"({one} + {other})"] = a + b
            made[f"({one} - {other})"] = a - b
    return made


def _speeds(numbers):
    """Return the differences of rates of other kinds: yD and q11D."""
    rates = [name for name in numbers if _RATE.fullmatch(name)]
    made = {}
    for one, other in combinations(rates, 2):
        if _kin(one) != _kin(other):
            made[f"({one} - {other})"] = numbers[one] - numbers[other]
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


def _products(arrays):
    """Return the parts of plane vectors, and the scalar and the cross products of any two."""
    vectors = {name: value.T for name, value in arrays.items() if value.shape[1] == 2}
    made = {}
    for name, value in arrays.items():
        if value.shape[1] == 4:
            for k, number in enumerate(value.T):
                made[f"{name}[{k // 2}][{k % 2}]"] = number
    for name, (x, y) in vectors.items():
        made[f"{name}[0]"] = x
        made[f"{name}[1]"] = y
    for one, other in combinations(vectors, 2):
        x, y = vectors[one]
        u, v = vectors[other]
        made[f"({one}[0]*{other}[0] + {one}[1]*{other}[1])"] = x * u + y * v
        made[f"({one}[0]*{other}[1] - {one}[1]*{other}[0])"] = x * v - y * u
    return made


def _pairs(arrays):
    """Return the vectors of two numbers that belong together: of both legs, x and y."""
    made = {}
    for name, value in arrays.items():
        for other in (name.replace("1", "2", 1), name.replace("x", "y", 1)):
            if other != name and other in arrays:
                text = f"{NUMPY}array([{name}, {other}])"
                made[text] = np.concatenate([value, arrays[other]], axis=1)
    return made


def _images(matrices, vectors, size):
    """Return the products of so many numbers: of what has two columns, and what has two rows."""
    made = {}
    for one, a in matrices.items():
        for other, b in vectors.items():
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
