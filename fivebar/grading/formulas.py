"""A formula for the values that a place in a student's program needs, from the values that stand
beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, combinations_with_replacement, product

import numpy as np

OLD = "__old__"  # what stands in the place now
CLOSE = 1e-6  # of the largest value: the robot's numbers are typed with seven digits
SMALL = 1e-2  # of the old value: what is less is compared with so much
MOST_ATOMS = 120  # values beside the place, of which two are multiplied
MOST_FACTORS = 40  # of which three are multiplied, or sums of products are made
MATH, NUMPY = "__import__('math').", "__import__('numpy')."
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
        """Return whether two formulas are worth the same in all samples."""
        off = a - b
        if self.turns:
            off = (off + np.pi) % (2 * np.pi) - np.pi
        scale = max(np.abs(b).max(), SMALL * np.abs(self.old).max())
        return bool(np.all(np.abs(off) <= CLOSE * scale))


def short_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with one other value at most."""
    with np.errstate(all="ignore"):
        for step in (_of_itself, _of_another, _with_one):
            yield from step(values)


def long_formulas(values: Values) -> Iterator[Found]:
    """Yield formulas that are worth what is needed, with more values than one."""
    with np.errstate(all="ignore"):
        for step in (_with_two, _with_three, _sums, _angles, _by_parts):
            yield from step(values)


def _of_itself(values):
    """Yield the old value with another sign, factor, power or term."""
    old, wanted = values.old, values.wanted
    if factor := _number(wanted / old):
        yield _kind_of_factor(factor), _times(factor, OLD)
    for kind, text, made in (
        ("a square", f"{OLD}**2", old**2),
        ("a root", f"{MATH}sqrt({OLD})", np.sqrt(old)),
        ("a square", f"{OLD}**3", old**3),
        ("an operator", f"1/{OLD}", 1 / old),
        ("a sign", f"abs({OLD})", np.abs(old)),
        ("a sign", f"-abs({OLD})", -np.abs(old)),
    ):
        if values.alike(made, wanted):
            yield kind, text
    for quarters in (2, -2, 1, -1):
        for text, made in ((OLD, old), (f"-{OLD}", -old)):
            if values.alike(made + quarters * np.pi / 2, wanted):
                yield "a term", f"{text} {'+' if quarters > 0 else '-'} {_quarters(quarters)}"
    if term := _number(wanted - old):
        yield "a term", f"{OLD} + {term}".replace("+ -", "- ")


def _quarters(count):
    return f"{MATH}pi" + ("" if abs(count) == 2 else "/2")


def _of_another(values):
    """Yield another value in place of the old one."""
    if number := _number(values.wanted):
        yield "a number", number
    if values.alike(values.wanted, 0 * values.wanted):
        yield "a term", "0"
        return
    for name, value in values.beside.items():
        if values.alike(value, values.wanted):
            yield "a variable", name
        elif factor := _number(values.wanted / value):
            yield "a formula", _times(factor, name)


def _with_one(values):
    """Yield the old value with one factor or one term more."""
    old, wanted = values.old, values.wanted
    for name, value in values.beside.items():
        for text, one in ((name, value), (f"{name}**2", value**2)):
            if factor := _number(wanted / old / one):
                yield "a factor", _times(factor, f"{OLD}*{text}")
            if not _is_turned(name) and (factor := _number(wanted / old * one)):
                yield "a factor", _times(factor, f"{OLD}/{text}")
            if factor := _number(_ratio(wanted - old, one)):
                yield "a term", _plus(factor, text)
        if values.turns:
            for sign, text in ((1, "+"), (-1, "-")):
                if values.alike(old + sign * value, wanted):
                    yield "a term", f"{OLD} {text} {name}"


def _by_parts(values):
    """Yield an array with a term more in each of its parts, in some of them 0."""
    if values.size == 1:
        return
    terms = []
    for k in range(values.size):
        old, wanted = values.old[k :: values.size], values.wanted[k :: values.size]
        beside = {
            name: value[k :: values.size]
            for name, value in values.beside.items()
            if len({*map(float, value[: values.size])}) == 1
        }
        part = Values(old, wanted, beside)
        if part.alike(wanted, old):
            terms.append("0")
            continue
        found = (text for kind, text in (*_with_one(part), *_with_two(part)) if kind == "a term")
        term = next(found, "")
        if not term:
            return
        terms.append(term.removeprefix(f"{OLD} + ").replace(f"{OLD} - ", "-"))
    rows = [terms] if values.size != 4 else [terms[:2], terms[2:]]
    told = ", ".join(f"[{', '.join(row)}]" for row in rows)
    yield "a term", f"{OLD} + {NUMPY}array({told if len(rows) == 1 else f'[{told}]'})"


def _with_two(values):
    yield from _with_products(values, 2, MOST_ATOMS)


def _with_three(values):
    yield from _with_products(values, 3, MOST_FACTORS)


def _with_products(values, count, most):
    """Yield the old value with a product of so many values more, as a term or a factor, or such
    a product in its place.
    """
    names, table = _table(values, most)
    if not names:
        return
    picked = np.array([*combinations_with_replacement(range(len(names)), count)])
    products = np.prod(table[picked], axis=1)
    for chosen, factor in _fitting((values.wanted - values.old) / products, picked):
        yield "a term", _plus(factor, _product(names, chosen))
    for chosen, factor in _fitting(values.wanted / products, picked):
        yield "a formula", _times(factor, _product(names, chosen))
    for chosen, factor in _fitting(values.wanted / values.old / products, picked):
        yield "a factor", _times(factor, f"{OLD}*{_product(names, chosen)}")
    whole = np.array([not _is_turned(name) for name in names])
    for split in range(count):
        some = picked[whole[picked[:, split]]]
        products = np.prod(table[some], axis=1)
        over = products / table[some[:, split]] ** 2
        for chosen, factor in _fitting((values.wanted - values.old) / over, some):
            yield "a term", _plus(factor, _quotient(names, chosen, split))
        for chosen, factor in _fitting(values.wanted / over, some):
            yield "a formula", _times(factor, _quotient(names, chosen, split))
        for chosen, factor in _fitting(values.wanted / values.old / over, some):
            yield "a factor", _times(factor, f"{OLD}*{_quotient(names, chosen, split)}")


def _is_turned(name):
    """Return whether a name is a sine or cosine that the program does not have: nobody forgets to
    divide by it.
    """
    return name.startswith(MATH)


def _fitting(ratios, picked):
    """Yield what is picked where the ratio (candidates, samples) is one number, and that number."""
    first = ratios[:, :1]
    same = np.all(np.abs(ratios - first) <= CLOSE * np.abs(first), axis=1)
    for place in np.flatnonzero(same & np.isfinite(first[:, 0])):
        if factor := _number(ratios[place]):
            yield picked[place], factor


def _table(values, most):
    """Return names and values (names, samples) of what can be multiplied: 0 and 1 cannot."""
    names = [
        name
        for name, value in values.beside.items()
        if np.all(np.abs(value) > 1e-12) and not _number(value)
    ][:most]
    return names, np.array([values.beside[name] for name in names])


def _sums(values):
    """Yield a sum or difference of two products in place of the old value, or beside it."""
    names, table = _table(values, MOST_FACTORS)
    if len(names) < 2:
        return
    picked = [(k,) for k in range(len(names))]
    picked += [*combinations_with_replacement(range(len(names)), 2)]
    products = np.array([np.prod(table[[*chosen]], axis=0) for chosen in picked])
    order = np.argsort(products[:, 0])
    first = products[order, 0]
    ways = ("", values.wanted), (f"{OLD} + ", values.wanted - values.old)
    for (head, wanted), sign in product(ways, (1, -1)):
        left = (wanted[0] - products[:, 0]) * sign
        slack = CLOSE * (np.abs(wanted[0]) + np.abs(left))
        low, high = np.searchsorted(first, left - slack), np.searchsorted(first, left + slack)
        for one in np.flatnonzero(high > low):
            for other in order[low[one] : high[one]]:
                if sign > 0 and other < one:
                    continue
                if values.alike(products[one] + sign * products[other], wanted):
                    texts = [_product(names, picked[k]) for k in (one, other)]
                    whole = f" {'+' if sign > 0 else '-'} ".join(texts)
                    yield "a term" if head else "a formula", head + whole


def _angles(values):
    """Yield a direction or an arc of values beside the place."""
    wanted, sine, cosine = values.wanted, np.sin(values.wanted), np.cos(values.wanted)
    names = [*values.beside]
    for name in names:
        value = values.beside[name]
        for function, made in (("acos", np.arccos(value)), ("asin", np.arcsin(value))):
            for sign in ("", "-"):
                if values.alike(-made if sign else made, wanted):
                    yield "a function", f"{sign}{MATH}{function}({name})"
    if not values.turns or np.abs(wanted).max() > 7:
        return
    for above, below in combinations(names, 2):
        for up, down in ((above, below), (below, above)):
            y, x = values.beside[up], values.beside[down]
            across = np.abs(y * cosine - x * sine)
            if np.all(across <= CLOSE * np.hypot(x, y)) and np.all(np.hypot(x, y) > 0):
                along = np.sign(y * sine + x * cosine)
                if np.all(along == along[0]):
                    sign = "" if along[0] > 0 else "-"
                    yield "a function", f"{MATH}atan2({sign}{up}, {sign}{down})"


def _product(names, chosen):
    powers = {names[k]: list(chosen).count(k) for k in chosen}
    return "*".join(name if n == 1 else f"{name}**{n}" for name, n in powers.items())


def _quotient(names, chosen, split):
    above = [k for place, k in enumerate(chosen) if place != split]
    return f"{_product(names, above)}/{names[chosen[split]]}"


def _number(values: np.ndarray) -> str:
    """Return a number of few digits that all values are, in words; "" where they are none."""
    first = values[0]
    if not np.isfinite(first) or not np.all(np.abs(values - first) <= CLOSE * abs(first)):
        return ""
    for below in (1, 2, 3, 4, 6, 8):
        above = round(first * below)
        if above and abs(above) <= 24 and abs(first * below - above) <= CLOSE * abs(above):
            return str(above) if below == 1 else f"{above}/{below}"
    return ""


def _ratio(above, below):
    """Return quotients of two values where the one below is not 0, if the other is 0 there, too."""
    none = np.abs(below) <= CLOSE * np.abs(below).max()
    zero = np.abs(above) <= CLOSE * np.abs(above).max()
    return above[~none] / below[~none] if np.all(zero[none]) and not np.all(none) else _NONE


_NONE = np.array([np.nan])


def _times(factor, text):
    if factor in ("1", "-1"):
        return text if factor == "1" else f"-{text}"
    above, _, below = factor.partition("/")
    head = {"1": "", "-1": "-"}.get(above, f"{above}*")
    return f"{head}{text}" + (f"/{below}" if below else "")


def _plus(factor, text):
    made = _times(factor, text)
    return f"{OLD} - {made[1:]}" if made.startswith("-") else f"{OLD} + {made}"


def _kind_of_factor(factor):
    return "a sign" if factor == "-1" else "a factor"
