"""A formula for the values that a place in a student's program needs, from the values that stand
beside it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain, combinations_with_replacement, permutations

import numpy as np

from ..base.backend import wrap

OLD = "__old__"  # what stands in the place now
CLOSE = 1e-6  # of the largest value: the robot's numbers are typed with seven digits
SMALL = 1e-2  # of the old value: what is less is compared with so much
SMALLEST = 1e-12  # of a factor
# Of numbers that people write.
DENOMINATORS = (1, 2, 3, 4, 6, 8)
MOST_ABOVE = 24
MOST_ATOMS = 120  # values beside the place, of which two are multiplied
MOST_FACTORS = 40  # of which three are multiplied, or sums of products are made
MOST_OF_FOUR = 30
MATRIX = 4  # numbers
# A name, its sine or cosine, what a function gives for it, the sum of two rates.
_PLAIN = re.compile(r"[\w.]+|__import__\('math'\)\.\w+\(\w+\)|\([\w.]+\(\w+\)\)|\(\w+D [+-] \w+D\)")
_DERIVATIVE = re.compile(r"[\w.]*[^D\W]D+")
_MADE_SUM = re.compile(r"\([\w.]+ [+-] [\w.]+\)")
MATH, NUMPY = "__import__('math').", "__import__('numpy')."
Found = tuple[str, str]  # kind of the mistake, and the formula


@dataclass(frozen=True)
class Values:
    """Of each sample (n,), what a place is worth, what it needs to be, and what stands beside it;
    turns: whether a whole turn more is the same; size: so many samples after the other are the
    parts of one array; slopes: of the answer's numbers (rows, samples of a row, numbers), where
    these do not tell all that is needed.
    """

    old: np.ndarray
    wanted: np.ndarray
    beside: Mapping[str, np.ndarray]
    turns: bool = False
    size: int = 1
    slopes: np.ndarray | None = None

    def seen(self, values: np.ndarray) -> np.ndarray:
        """Return what the answer shows of values (..., n)."""
        if self.slopes is None:
            return values
        rows, unknowns, _ = self.slopes.shape
        parts = values.reshape(*values.shape[:-1], rows, unknowns)
        return np.einsum("...ru,ruk->...rk", parts, self.slopes).reshape(*values.shape[:-1], -1)

    def alike(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Return whether two formulas are worth the same in all samples, but for half turns: a
        direction and its opposite may give the same answer.
        """
        off = wrap(a - b) if self.turns else wrap(2 * (a - b)) / 2
        scale = max(np.abs(b).max(), SMALL * np.abs(self.old).max())
        return bool(np.all(np.abs(off) <= CLOSE * scale))


def short_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with one other value at most."""
    steps = (_another, _of_itself, _of_another, _with_one)
    with np.errstate(all="ignore"):
        for step in steps if values.slopes is None else (_with_another,):
            yield from step(values)


def long_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with more values than one."""
    more = (_sums, _angles, _by_parts) if values.slopes is None else ()
    with np.errstate(all="ignore"):
        for step in (_with_two, _with_three, *more, _with_four):
            yield from step(values)


def _of_itself(values):
    """Yield a number, or the old value with another sign, factor, power or term."""
    old, wanted = values.old, values.wanted
    if number := _number(wanted):
        yield "a number", number
    if factor := _number(wanted / old):
        kind = "a sign" if factor == "-1" else "a factor"
        yield kind, _times(factor, OLD)
    made = {
        f"{OLD}**2": ("a square", old**2),
        f"{MATH}sqrt({OLD})": ("a root", np.sqrt(old)),
        f"1/{OLD}": ("an operator", 1 / old),
        f"abs({OLD})": ("a sign", np.abs(old)),
    }
    half, quarter = f"{MATH}pi", f"{MATH}pi/2"
    for text, turned in ((OLD, old), (f"-{OLD}", -old)):
        made[f"{text} + {half}"] = "a term", turned + np.pi
        made[f"{text} - {half}"] = "a term", turned - np.pi
        made[f"{text} + {quarter}"] = "a term", turned + np.pi / 2
        made[f"{text} - {quarter}"] = "a term", turned - np.pi / 2
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


def _of_another(values):
    """Yield another value times a number in place of the old one."""
    wanted = values.wanted
    if values.alike(wanted, 0 * wanted):
        yield "a term", "0"
        return
    for name, value in values.beside.items():
        if values.alike(value, wanted):
            continue
        if factor := _number(wanted / value):
            yield "a formula", _times(factor, name)


def _with_one(values):
    """Yield the old value with one factor or one term more."""
    old, wanted = values.old, values.wanted
    more = wanted - old
    for name, value in values.beside.items():
        for text, one in ((name, value), (f"{name}**2", value**2)):
            if factor := _number(wanted / old / one):
                yield "a factor", _times(factor, f"{OLD}*{text}")
            if _divides(name) and (factor := _number(wanted / old * one)):
                yield "a factor", _times(factor, f"{OLD}/{text}")
            if factor := _number(_ratio(more, one)):
                yield "a term", _plus(factor, text)
        if values.alike(old + value, wanted):
            yield "a term", f"{OLD} + {name}"
        if values.alike(old - value, wanted):
            yield "a term", f"{OLD} - {name}"


def _with_another(values):
    yield from _with_products(values, 1, MOST_ATOMS)


def _with_two(values):
    yield from _with_products(values, 2, MOST_ATOMS)


def _with_three(values):
    yield from _with_products(values, 3, MOST_FACTORS)


def _with_four(values):
    plain = {name: value for name, value in values.beside.items() if _PLAIN.fullmatch(name)}
    yield from _with_products(replace(values, beside=plain), 4, MOST_OF_FOUR)


def _with_products(values, count, most):
    """Yield the old value with a product of so many values more, as a term or a factor, or such
    a product in its place; in the product one value may be divided by.
    """
    names, table = _factors(values, most)
    if not names:
        return
    every = np.array([*combinations_with_replacement(range(len(names)), count)])
    below = np.array([_divides(name) for name in names])
    wanted, more = values.seen(values.wanted), values.seen(values.wanted - values.old)
    for split in (None, *range(count)):
        picked = every
        if split is not None:
            divisors = every[:, [split]]
            once = np.sum(every == divisors, axis=1) == 1  # others would cancel it
            picked = every[below[divisors[:, 0]] & once]
        products = np.prod(table[picked], axis=1)
        if split is not None:
            products = products / table[picked[:, split]] ** 2
        terms, factors = values.seen(products), values.seen(products * values.old)
        for chosen, factor in _fitting(more / terms, picked):
            yield "a term", _plus(factor, _product(names, chosen, split))
        for chosen, factor in _fitting(wanted / terms, picked):
            text = _times(factor, _product(names, chosen, split))
            yield "a variable" if text in names else "a formula", text
        for chosen, factor in _fitting(wanted / factors, picked):
            yield "a factor", _times(factor, f"{OLD}*{_product(names, chosen, split)}")


def _fitting(ratios, picked):
    """Yield what is picked where the ratio (candidates, samples) is one number, and that number."""
    first = ratios[:, :1]
    same = np.all(np.abs(ratios - first) <= CLOSE * np.abs(first), axis=1)
    for place in np.flatnonzero(same):
        if factor := _number(ratios[place]):
            yield picked[place], factor


def _factors(values, most):
    """Return names and values (names, samples) of what can be multiplied: 0 and 1 cannot, and
    nobody multiplies matrices by elements on purpose.
    """
    names = [
        name
        for name, value in values.beside.items()
        if np.all(np.abs(value) > SMALLEST)
        and not _number(value)
        and (values.size < MATRIX or _is_repeated(value, values.size))
    ]
    names = names[:most]
    return names, np.array([values.beside[name] for name in names])


def _product(names, chosen, split=None):
    """Return the product of the chosen names, divided by the one at place `split`."""
    above = [names[k] for place, k in enumerate(chosen) if place != split]
    powers = []
    for name in dict.fromkeys(above):
        count = above.count(name)
        powers.append(name if count == 1 else f"{name}**{count}")
    text = "*".join(powers)
    return text if split is None else f"{text}/{names[chosen[split]]}"


def _sums(values):
    """Yield a sum or difference of two products in place of the old value, or beside it."""
    plain = {name: value for name, value in values.beside.items() if "[0]*" not in name}
    names, table = _factors(replace(values, beside=plain), MOST_FACTORS)
    if len(names) < 2:
        return
    picked = [(k,) for k in range(len(names))]
    picked += [*combinations_with_replacement(range(len(names)), 2)]
    products = np.array([np.prod(table[[*chosen]], axis=0) for chosen in picked])
    for sign in (1, -1):
        joint = " + " if sign > 0 else " - "
        for one, other in _adding_up(values, values.wanted, products, sign):
            first = _product(names, picked[one])
            second = _product(names, picked[other])
            yield "a formula", first + joint + second
        for one, other in _adding_up(values, values.wanted - values.old, products, sign):
            first = _product(names, picked[one])
            second = _product(names, picked[other])
            yield "a term", f"{OLD} + {first}{joint}{second}"


def _adding_up(values, wanted, products, sign):
    """Yield pairs of products of which the sum, or the difference, is what is wanted."""
    order = np.argsort(products[:, 0])
    first = products[order, 0]
    left = (wanted[0] - products[:, 0]) * sign
    slack = CLOSE * (np.abs(wanted[0]) + np.abs(left))
    low = np.searchsorted(first, left - slack)
    high = np.searchsorted(first, left + slack)
    for one in np.flatnonzero(high > low):
        for other in order[low[one] : high[one]]:
            again = sign > 0 and other < one
            if not again and values.alike(products[one] + sign * products[other], wanted):
                yield one, other


def _angles(values):
    """Yield an arc or a direction of values beside the place."""
    wanted = values.wanted
    for name, value in values.beside.items():
        for function, arc in (("acos", np.arccos(value)), ("asin", np.arcsin(value))):
            if values.alike(arc, wanted):
                yield "a function", f"{MATH}{function}({name})"
            if values.alike(-arc, wanted):
                yield "a function", f"-{MATH}{function}({name})"
    for above, below in permutations(values.beside, 2) if values.turns else ():
        y, x = values.beside[above], values.beside[below]
        size = np.hypot(x, y)
        across = np.abs(y * np.cos(wanted) - x * np.sin(wanted))
        along = np.sign(y * np.sin(wanted) + x * np.cos(wanted))
        if np.all(across <= CLOSE * size) and np.all(along == along[0]) and along[0]:
            sign = "" if along[0] > 0 else "-"
            yield "a function", f"{MATH}atan2({sign}{above}, {sign}{below})"


def _by_parts(values):
    """Yield an array with a term more in each of its parts, in some of them 0."""
    size = values.size
    if size == 1:
        return
    numbers = {
        name: value[::size] for name, value in values.beside.items() if _is_repeated(value, size)
    }
    terms = []
    for k in range(size):
        part = Values(values.old[k::size], values.wanted[k::size], numbers)
        terms.append(_term(part))
    if not all(terms):
        return
    told = f"[{', '.join(terms)}]"
    if size == 4:
        first, second = ", ".join(terms[:2]), ", ".join(terms[2:])
        told = f"[[{first}], [{second}]]"
    yield "a term", f"{OLD} + {NUMPY}array({told})"


def _is_repeated(value, size):
    """Return whether a value beside an array is a number, once for each of the array's parts."""
    return np.all(value.reshape(-1, size) == value[::size, None])


def _term(values):
    """Return what is to be added to the old value, "" where no formula is."""
    if values.alike(values.wanted, values.old):
        return "0"
    if number := _number(values.wanted - values.old):
        return number
    for kind, text in chain(_with_one(values), _with_two(values)):
        if kind == "a term":
            return text.removeprefix(f"{OLD} + ").replace(f"{OLD} - ", "-")
    return ""


def _divides(name):
    """Return whether a formula may be divided by it: nobody forgets to divide by a rate, or by a
    sum, a sine or a cosine that the program does not have.
    """
    return not (name.startswith(MATH) or _MADE_SUM.fullmatch(name) or _DERIVATIVE.fullmatch(name))


def _number(values: np.ndarray) -> str:
    """Return a number of few digits that all values are, in words; "" where they are none."""
    first = values[0]
    if not np.isfinite(first) or not np.all(np.abs(values - first) <= CLOSE * abs(first)):
        return ""
    for below in DENOMINATORS:
        above = round(first * below)
        whole = abs(first * below - above) <= CLOSE * abs(above)
        if above and abs(above) <= MOST_ABOVE and whole:
            return str(above) if below == 1 else f"{above}/{below}"
    return ""


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
