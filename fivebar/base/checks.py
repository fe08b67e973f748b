"""Checks of the arguments of public functions.

A rule is called (value, name) and returns the value as it is to be used, or raises an error that
names the argument. `takes` applies rules to the arguments of a function. Functions of a single
pose, which take microseconds, come here only where the type of an argument is unusual.
"""

from __future__ import annotations

import inspect
import math
import os
import sys
from collections.abc import Callable, Iterable
from functools import partial, wraps
from numbers import Real
from typing import ParamSpec, TypeVar

import numpy as np

from .backend import HUGE, finite_numbers, is_symbolic, real_numbers

P = ParamSpec("P")
T = TypeVar("T")
# Between these limits products stay far from where doubles overflow, underflow or lose digits.
SHORTEST, LONGEST, RATIO = 1e-9, 1e9, 1e6  # m, of bars, and the longest over the shortest
NARROWEST = 1e-12  # of the longest bar, between base joints that are not in one point
LIGHTEST, HEAVIEST = 1e-30, 1e30  # kg, kg m^2


def takes(**rules: Callable) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Return a decorator that replaces the named arguments by what their rules make of them.

    Defaults are not checked.
    """

    def check(name, value):
        return rules[name](value, name) if name in rules else value

    def decorate(function):
        names = list(inspect.signature(function).parameters)

        @wraps(function)
        def checked(*args, **kwargs):
            positional = [check(name, value) for name, value in zip(names, args)]
            named = {name: check(name, value) for name, value in kwargs.items()}
            return function(*positional, *args[len(names) :], **named)

        return checked

    return decorate


def shown(value: object) -> str:
    """Return a value as a message repeats it, cut after 80 letters."""
    words = repr(value)
    return words if len(words) <= 80 else f"{words[:80]}..."


def instance(*kinds: type | str, what: str = "") -> Callable:
    """Rule: an instance of one of these classes; TypeError for anything else.

    A class that a lower room does not know is given by its name. what: the message's words for it.
    """
    names = [kind if isinstance(kind, str) else kind.__name__ for kind in kinds]
    classes = tuple(kind for kind in kinds if not isinstance(kind, str))

    def rule(value, name):
        known = isinstance(value, classes)
        if known or any(kind.__name__ in names for kind in type(value).__mro__):
            return value
        wanted = what or " or ".join(map(_article, names))
        raise TypeError(f"{name} must be {wanted}, not {shown(value)}")

    return rule


def _article(name):
    return f"{'an' if name[0] in 'AEIO' else 'a'} {name}"


ROBOT_PARTS = (
    "drives",
    "distal",
    "inertias",
    "m",
    "turns",
    "words",
    "joint_difference",
    "continuous",
)


def robot(value: object, name: str) -> object:
    """Rule: a robot, which has all of `models.robots.Robot`; TypeError for anything else."""
    kind = type(value)
    has_all = all(hasattr(kind, part) or hasattr(value, part) for part in ROBOT_PARTS)
    if isinstance(value, type) or not has_all:
        hint = "; give its .robot" if hasattr(value, "robot") else ""
        if isinstance(value, str | os.PathLike):
            hint = "; fb.load_robot and fb.load_machine read files and names"
        raise TypeError(
            f"{name} must be a robot, as FiveBar() or Biglide(), not {shown(value)}{hint}"
        )
    return value


def named_functions(value: object, name: str) -> tuple[tuple[str, Callable], ...]:
    """Rule: {name: function}, as pairs; TypeError for anything else."""
    try:
        pairs = tuple(dict(value).items())  # type: ignore[call-overload]
    except (TypeError, ValueError):
        pairs = ((None, None),)
    if not all(isinstance(key, str) and callable(function) for key, function in pairs):
        raise TypeError(f"{name} must be {{name: function}}, not {shown(value)}")
    return pairs


def number(
    value: object, name: str, low: float = -HUGE, high: float = HUGE, above: bool = False
) -> float:
    """Rule: a finite number from low to high, as a float; above: more than low. ValueError."""
    if isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype != object:
        value = value.item()
    if not isinstance(value, Real):
        raise ValueError(f"{name} must be a number, not {shown(value)}")
    try:
        x = math.nan if isinstance(value, bool) else float(value)
    except OverflowError:
        x = math.inf
    if low <= x <= high and not (above and x == low):
        return x
    if math.isfinite(x) and abs(x) > HUGE:
        wanted = f"below {HUGE:g} in size"
    elif (low == 0 and not high < x < math.inf) or high == HUGE > -low:
        wanted = f"finite and {'>' if above else '>='} {low:g}"
    elif math.isfinite(x):
        wanted = f"finite and from {low:g} to {high:g}"
    else:
        wanted = "finite"
    raise ValueError(f"{name} must be {wanted}, not {shown(value)}")


def positive(value: object, name: str) -> float:
    """Rule: a finite number > 0, whose inverse is below HUGE."""
    x = number(value, name, 0.0, above=True)
    if x < 1 / HUGE:
        raise ValueError(
            f"{name} must be finite and > 0, at least {1 / HUGE:g}, not {shown(value)}"
        )
    return x


not_negative = partial(number, low=0.0)  # Rule: a finite number >= 0.
share = partial(number, low=0.0, high=1.0)  # Rule: from 0 to 1, as the sine of an angle is.


def seconds(value: object, name: str) -> float:
    """Rule: a duration, s; outside 1e-12 to 1e12 its powers might overflow. ValueError."""
    return number(positive(value, name), name, 1e-12, 1e12)


def two_numbers(value: object, name: str) -> tuple[float, float]:
    """Rule: two finite numbers, as (x, y); ValueError for anything else."""
    try:
        array = finite_numbers(value, name)
    except ValueError as error:
        raise ValueError(
            f"{name} must be two finite numbers, not {shown(value)} ({error})"
        ) from None
    if array.shape != (2,):
        raise ValueError(f"{name} must be two finite numbers, not {shown(value)}")
    return tuple(array.tolist())


def returned_pair(value: object, what: str, efforts: str = "torques") -> np.ndarray:
    """Return the two numbers (2,), finite or not, that a user's function returned; ValueError."""
    try:
        return np.array(value, dtype=float).reshape(2)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must return two {efforts}, not {shown(value)}") from None


def table_of(rule: Callable) -> Callable:
    """Rule: a dict of names, each value by another rule."""

    def check(value, name):
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise ValueError(f"{name} must be a table by names, not {shown(value)}")
        return {key: rule(item, f"{name}[{key!r}]") for key, item in value.items()}

    return check


def strings(value: object, name: str) -> list[str]:
    """Rule: strings, not one string; TypeError for anything else."""
    one = isinstance(value, (str, bytes, np.ndarray)) or is_symbolic(value)
    if isinstance(value, Iterable) and not one:
        words = list(value)
        if all(isinstance(word, str) for word in words):
            return words
    raise TypeError(f"{name} must be a list of strings, not {shown(value)}")


def optional(rule: Callable) -> Callable:
    """Return the rule for what may also be None."""
    return lambda value, name: None if value is None else rule(value, name)


def whole(low: int, high: int) -> Callable:
    """Rule: a whole number from low to high; ValueError for anything else."""

    def rule(value, name):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < low:
            raise ValueError(f"{name} must be a whole number >= {low}, not {shown(value)}")
        if value > high:
            raise ValueError(f"{name} must be at most {high}, not {shown(value)}")
        return int(value)

    return rule


def one_of(*known: object) -> Callable:
    """Rule: one of these values; ValueError for anything else."""

    def rule(value, name):
        if not any(type(value) is type(choice) and value == choice for choice in known):
            choices = ", ".join(map(str, known))
            raise ValueError(f"{name} must be one of {choices}, not {shown(value)}")
        return value

    return rule


flag = one_of(True, False)  # Rule: True or False.
jit = one_of(False, True, "auto")  # Rule: whether to compile.
text = instance(str, what="a string")  # Rule: a string; TypeError for anything else.


def a_callable(value: object, name: str) -> Callable:
    """Rule: a function or another callable; TypeError for anything else."""
    if not callable(value) or isinstance(value, type):
        raise TypeError(f"{name} must be a function or another callable, not {shown(value)}")
    return value


def modes(count: int) -> Callable:
    """Rule: +1 or -1, or two of them, as plain ints; ValueError for anything else."""

    def rule(value, name):
        wanted = "two modes in one argument, as (-1, 1)," if count == 2 else "+1 or -1"
        try:
            signs = real_numbers(value, name).tolist()
        except ValueError:
            signs = None
        listed = signs if isinstance(signs, list) else [signs]
        if isinstance(signs, list) != (count == 2) or len(listed) != count:
            raise ValueError(f"{name} must be {wanted}, not {shown(value)}")
        if any(sign not in (1, -1) for sign in listed):
            raise ValueError(f"{name} must be +1 or -1, not {shown(value)}")
        return int(signs) if count == 1 else tuple(map(int, signs))

    return rule


def size(value: object, name: str) -> float:
    """Rule: a bar's length, m, from SHORTEST to LONGEST; ValueError for anything else."""
    x = number(value, name, 0.0, sys.float_info.max, above=True)
    if not SHORTEST <= x <= LONGEST:
        raise ValueError(
            f"{name} = {x:g} m is outside {SHORTEST:g} to {LONGEST:g} m: choose another unit of"
            " length"
        )
    return x


def base(value: object, name: str) -> float:
    """Rule: a distance of base joints or guides, m, from 0 to LONGEST; ValueError otherwise."""
    return number(value, name, 0.0, LONGEST)


def inertia(value: object, name: str) -> float:
    """Rule: a mass or an inertia, 0 or from LIGHTEST to HEAVIEST; ValueError for anything else."""
    x = not_negative(value, name)
    if x and not LIGHTEST <= x <= HEAVIEST:
        raise ValueError(f"{name} = {x:g} is outside {LIGHTEST:g} to {HEAVIEST:g}, and not 0")
    return x


def moment(value: object, name: str) -> float:
    """Rule: a first moment or a grouped inertia, of any sign; its size is checked as `inertia`."""
    x = number(value, name)
    inertia(abs(x), f"the size of {name}")
    return x


def not_too_different(lengths: dict[str, float]) -> None:
    """Raise ValueError where one of the lengths {name: m} is RATIO times another; 0 is none."""
    sizes = {name: abs(length) for name, length in lengths.items() if length}
    short, long = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    if sizes[long] > RATIO * sizes[short]:
        raise ValueError(
            f"{long} = {sizes[long]:g} m is more than {RATIO:g} times {short} = {sizes[short]:g} m:"
            " rounding of the one would be as large as the effect of the other"
        )


def not_too_narrow(d: float, longest: float) -> None:
    """Raise ValueError for base joints all but in one point, by the longest bar; d = 0 is one."""
    if not is_symbolic(d) and 0 < d < NARROWEST * longest:
        raise ValueError(
            f"d = {d:g} m is less than {NARROWEST:g} of the longest bar, {longest:g} m, and not 0"
        )


def bounded(count: float, most: float, what: str, bytes_each: float) -> None:
    """Raise ValueError for so many rows, or the like, and say how much memory they would take."""
    if not count <= most:
        raise ValueError(
            f"{what}: at most {most:g} are possible, and these would take about"
            f" {count * bytes_each / 1e9:.3g} GB"
        )
