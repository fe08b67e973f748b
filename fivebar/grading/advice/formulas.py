"""A formula for the values that a place in a student's program needs, from the values that stand
beside it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, product

import numpy as np

from ...base.backend import wrap

OLD = "__old__"  # what stands in the place now
CLOSE = 1e-6  # of the largest value: the robot's numbers are typed with seven digits
SMALL = 1e-2  # of the old value: what is less is compared with so much
SMALLEST = 1e-12  # of a factor
# Of numbers that people write.
DENOMINATORS = (1, 2, 3, 4, 6, 8)
MOST_ABOVE = 24
MOST_ATOMS = 120  # values beside the place, of which two are multiplied
MOST_FACTORS, MOST_OF_FOUR = 40, 30  # of which three, or four, are multiplied
MATRIX = 4  # numbers
# A name, its sine or cosine, what a function gives for it, the sum of two rates.
_PLAIN = re.compile(r"[\w.]+|__import__\('math'\)\.\w+\(\w+\)|\([\w.]+\(\w+\)\)|\(\w+D [+-] \w+D\)")
_DERIVATIVE = re.compile(r"[\w.]*[^D\W]D+")
_MADE_SUM = re.compile(r"\([\w.]+ [+-] [\w.]+\)")
MATH = "__import__('math')."
Found = tuple[str, str]  # kind of the mistake, and the formula


@dataclass(frozen=True)
class Values:
    """Of each sample (n,), what a place is worth, what it needs to be, and what stands beside it;
    turns: whether a whole turn more is the same; size: so many samples after the other are the
    parts of one array.
    """

    old: np.ndarray
    wanted: np.ndarray
    beside: Mapping[str, np.ndarray]
    turns: bool = False
    size: int = 1

    def alike(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Return whether two formulas are worth the same in all samples, but for half turns: a
        direction and its opposite may give the same answer.
        """
        off = wrap(a - b) if self.turns else wrap(2 * (a - b)) / 2
        scale = max(np.abs(b).max(), SMALL * np.abs(self.old).max())
        return bool(np.all(np.abs(off) <= CLOSE * scale))


def short_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with one other value at most."""
    with np.errstate(all="ignore"):
        yield from _another(values)
        yield from _of_itself(values)
        yield from _with_one(values)


def long_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with a product of two to four values more."""
    plain = {name: value for name, value in values.beside.items() if _PLAIN.fullmatch(name)}
    with np.errstate(all="ignore"):
        yield from _with_products(values, 2, MOST_ATOMS)
        yield from _with_products(values, 3, MOST_FACTORS)
        yield from _with_products(replace(values, beside=plain), 4, MOST_OF_FOUR)


def _of_itself(values):
    """Yield a number, or the old value with another sign, factor, power or term."""
    old, wanted = values.old, values.wanted
    if values.alike(wanted, 0 * wanted):
        yield "a term", "0"
    if number := _number(wanted):
        yield "a number", number
    if factor := _number(wanted / old):
        kind = "a sign" if factor == "-1" else "a factor"
        yield kind, _times(factor, OLD)
    made = {f"{OLD}**2": ("a square", old**2), f"{MATH}sqrt({OLD})": ("a root", np.sqrt(old))}
    turns = {"+ pi": np.pi, "- pi": -np.pi, "+ pi/2": np.pi / 2, "- pi/2": -np.pi / 2}
    for (text, value), turn in product(((OLD, old), (f"-{OLD}", -old)), turns):
        term = turn.replace("pi", f"{MATH}pi")
        made[f"{text} {term}"] = "a term", value + turns[turn]
    for text, (kind, value) in made.items():
        if values.alike(value, wanted):
            yield kind, text
    if term := _number(wanted - old):
        yield "a term", f"{OLD} + {term}".replace("+ -", "- ")


def _another(values):
    """Yield another value in place of the old one."""
    if not values.alike(values.wanted, 0 * values.wanted):
        for name, value in values.beside.items():
            if values.alike(value, values.wanted):
                yield "a variable", name


def _with_one(values):
    """Yield the old value with one factor or one term more."""
    old, wanted = values.old, values.wanted
    more = wanted - old
    for name, value in values.beside.items():
        for text, one in ((name, value), (f"{name}**2", value**2)):
            if factor := _number(wanted / old / one):
                yield "a factor", _times(factor, f"{OLD}*{text}")
            is_divisor = _divides(name) or name.startswith(MATH)
            if is_divisor and (factor := _number(wanted / old * one)):
                yield "a factor", _times(factor, f"{OLD}/{text}")
            if factor := _number(_ratio(more, one)):
                yield "a term", _plus(factor, text)
        if values.alike(np.hypot(old, value), wanted):
            yield "a hypotenuse", f"{MATH}sqrt({OLD}**2 + {name}**2)"
        if values.alike(old + value, wanted):
            yield "a term", f"{OLD} + {name}"
        if values.alike(old - value, wanted):
            yield "a term", f"{OLD} - {name}"


def _with_products(values, count, most):
    """Yield the old value with a product of so many values more, as a term or a factor, or such
    a product in its place; in the product one value may be divided by.
    """
    names, table, is_matrix = _factors(values, most)
    if not names:
        return
    every = np.array([*combinations_with_replacement(range(len(names)), count)])
    every = every[is_matrix[every].sum(axis=1) <= 1]
    below = np.array([_divides(name) for name in names]) & ~is_matrix
    wanted, more = values.wanted, values.wanted - values.old
    for split in (None, *range(count)):
        picked = every
        if split is not None:
            divisors = every[:, [split]]
            once = np.sum(every == divisors, axis=1) == 1  # others would cancel it
            picked = every[below[divisors[:, 0]] & once]
        if not len(picked):
            continue
        products = np.prod(table[picked], axis=1)
        if split is not None:
            products = products / table[picked[:, split]] ** 2
        for chosen, factor in _fitting(more / products, picked):
            yield "a term", _plus(factor, _product(names, chosen, split))
        for chosen, factor in _fitting(wanted / products, picked):
            yield "a formula", _times(factor, _product(names, chosen, split))
        plain = ~is_matrix[picked].any(axis=1)
        for chosen, factor in _fitting(wanted / values.old / products[plain], picked[plain]):
            yield "a factor", _times(factor, f"{OLD}*{_product(names, chosen, split)}")


def _fitting(ratios, picked):
    """Yield what is picked where the ratio (candidates, samples) is one number, and that number."""
    first = ratios[:, :1]
    same = np.all(np.abs(ratios - first) <= CLOSE * np.abs(first), axis=1)
    same[same] = _numerators(first[same]).any(axis=1)
    for place in np.flatnonzero(same):
        yield picked[place], _number(ratios[place])


def _factors(values, most):
    """Return names and values (names, samples) of what can be multiplied, as 0 and 1 cannot, and
    which of them are matrices: nobody multiplies two of these by elements on purpose.
    """
    names = [
        name
        for name, value in values.beside.items()
        if np.all(np.abs(value) > SMALLEST) and not _number(value)
    ]
    matrices = [name for name in names if _is_matrix(values.beside[name], values.size)]
    # Matrices first: sums of angles are many, and would take their places.
    names = [*matrices, *(name for name in names if name not in matrices)][:most]
    table = np.array([values.beside[name] for name in names])
    return names, table, np.arange(len(names)) < len(matrices)


def _product(names, chosen, split=None):
    """Return the product of the chosen names, divided by the one at place `split`."""
    above = [names[k] for place, k in enumerate(chosen) if place != split]
    powers = []
    for name in dict.fromkeys(above):
        count = above.count(name)
        powers.append(name if count == 1 else f"{name}**{count}")
    text = "*".join(powers)
    return text if split is None else f"{text}/{names[chosen[split]]}"


def _is_matrix(value, size):
    """Return whether a value beside an array of so many numbers is a matrix, too, and no number
    that is repeated for each of the array's parts.
    """
    return size >= MATRIX and bool(np.any(value.reshape(-1, size) != value[::size, None]))


def _divides(name):
    """Return whether a formula may be divided by it: nobody forgets to divide by a rate, or by a
    sum, a sine or a cosine that the program does not have.
    """
    return not (name.startswith(MATH) or _MADE_SUM.fullmatch(name) or _DERIVATIVE.fullmatch(name))


def _number(values: np.ndarray) -> str:
    """Return a number of few digits that all values are, in words; "" where they are none."""
    first = values[0]
    if np.all(np.abs(values - first) <= CLOSE * abs(first)):
        for above, below in zip(_numerators(first), DENOMINATORS):
            if above:
                return f"{above:g}" if below == 1 else f"{above:g}/{below}"
    return ""


def _numerators(numbers):
    """Return what is above each of the DENOMINATORS in numbers, 0 where that is not whole, or not
    small.
    """
    scaled = numbers * np.array(DENOMINATORS)
    above = np.round(scaled)
    whole = np.abs(scaled - above) <= CLOSE * np.abs(above)
    return np.where(whole & (np.abs(above) <= MOST_ABOVE), above, 0.0)


def _ratio(above, below):
    """Return quotients of two values where the one below is not 0, if the other is 0 there, too."""
    none = np.abs(below) <= CLOSE * np.abs(below).max()
    zero = np.abs(above) <= CLOSE * np.abs(above).max()
    if np.all(none) or not np.all(zero[none]):
        return np.full(1, np.nan)
    return above[~none] / below[~none]


def _times(factor, text):
    """Return a text times a number."""
    above, _, below = factor.partition("/")
    head = {"1": "", "-1": "-"}.get(above, f"{above}*")
    return f"{head}{text}/{below}" if below else f"{head}{text}"


def _plus(factor, text):
    """Return the old value plus a text times a number."""
    made = _times(factor, text)
    return f"{OLD} - {made[1:]}" if made.startswith("-") else f"{OLD} + {made}"
