"""What public functions take: one rule for each kind of argument, and an error that names the
argument.

A rule is called (value, name) and gives the value as it is to be used. `takes` puts rules before a
function; those of a single pose, which takes microseconds, ask for the type of what they get and
come here only where it is not the usual one.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Iterable
from functools import wraps
from numbers import Real
from typing import ParamSpec, TypeVar

import numpy as np

from .backend import HUGE, finite_numbers, is_symbolic, real_numbers

P = ParamSpec("P")
T = TypeVar("T")
# In between, all products keep far off where doubles overflow, underflow or lose their digits.
SHORTEST, LONGEST, RATIO = 1e-6, 1e6, 1e6  # m, of bars, and the longest over the shortest
NARROWEST = 1e-12  # m, between base joints that are not in one point
LIGHTEST, HEAVIEST = 1e-30, 1e30  # kg, kg m^2
WORDS = 80  # letters of a value that a message repeats


def takes(**rules: Callable) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorator: the named arguments, where they are given, are what their rules make of them."""

    def decorate(function):
        names = list(inspect.signature(function).parameters)

        @wraps(function)
        def checked(*args, **kwargs):
            args = [
                *(rules[n](a, n) if n in rules else a for n, a in zip(names, args)),
                *args[len(names) :],
            ]
            return function(
                *args, **{n: rules[n](a, n) if n in rules else a for n, a in kwargs.items()}
            )

        return checked

    return decorate


def shown(value: object) -> str:
    """A value as a message repeats it, cut where it is long."""
    words = repr(value)
    return words if len(words) <= WORDS else f"{words[:WORDS]}..."


def instance(*kinds: type | str, what: str = "") -> Callable:
    """Rule: an instance of one of these classes; TypeError for anything else. what: to be called in
    the message.

    A class that a lower room does not know is given by its name.
    """
    names = [kind if isinstance(kind, str) else kind.__name__ for kind in kinds]
    classes = tuple(kind for kind in kinds if not isinstance(kind, str))

    def rule(value, name):
        if isinstance(value, classes) or any(own.__name__ in names for own in type(value).__mro__):
            return value
        raise TypeError(
            f"{name} must be {what or ' or '.join(map(_article, names))}, not {shown(value)}"
        )

    return rule


def _article(name):
    return f"{'an' if name[0] in 'AEIO' else 'a'} {name}"


def robot(value: object, name: str) -> object:
    """Rule: a robot, that is all that `models.robots.Robot` asks for; TypeError for anything
    else.
    """
    asked = (
        "drives",
        "distal",
        "inertias",
        "m",
        "turns",
        "words",
        "joint_difference",
        "continuous",
    )
    if isinstance(value, type) or not all(
        hasattr(type(value), each) or hasattr(value, each) for each in asked
    ):
        raise TypeError(f"{name} must be a robot, as FiveBar() or Biglide(), not {shown(value)}")
    return value


def number(
    value: object, name: str, low: float = -HUGE, high: float = HUGE, above: bool = False
) -> float:
    """Rule: a finite number from low (above: more than it) to high, as a float; ValueError for
    anything else.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype != object:
        value = value.item()
    if not isinstance(value, Real):
        raise ValueError(f"{name} must be a number, not {shown(value)}")
    try:
        found = math.nan if isinstance(value, bool) else float(value)
    except OverflowError:
        found = math.inf
    if low <= found <= high and not (above and found == low):
        return found
    words = ["finite"]
    if math.isfinite(found) and abs(found) > HUGE:
        words = [f"below {HUGE:g} in size"]
    elif low == 0 and not high < found < math.inf or high == HUGE > -low:
        words.append(f"{'>' if above else '>='} {low:g}")
    elif math.isfinite(found):
        words.append(f"from {low:g} to {high:g}")
    raise ValueError(f"{name} must be {' and '.join(words)}, not {shown(value)}")


def positive(value: object, name: str) -> float:
    """Rule: a finite number > 0, whose inverse is below HUGE."""
    found = number(value, name, 0.0, above=True)
    if found < 1 / HUGE:
        raise ValueError(
            f"{name} must be finite and > 0, at least {1 / HUGE:g}, not {shown(value)}"
        )
    return found


def not_negative(value: object, name: str) -> float:
    """Rule: a finite number >= 0."""
    return number(value, name, 0.0)


def share(value: object, name: str) -> float:
    """Rule: a number from 0 to 1, as the sine of an angle is."""
    return number(value, name, 0.0, 1.0)


def seconds(value: object, name: str) -> float:
    """Rule: how long something takes, s; outside 1e-12 to 1e12 powers of it might overflow.
    ValueError.
    """
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


def table_of(rule: Callable) -> Callable:
    """Rule: a dict of names, each value by another rule."""

    def check(value, name):
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise ValueError(f"{name} must be a table by names, not {shown(value)}")
        return {key: rule(each, f"{name}[{key!r}]") for key, each in value.items()}

    return check


def flag(value: object, name: str) -> bool:
    """Rule: True or False; ValueError for anything else."""
    return one_of(True, False)(value, name)


def strings(value: object, name: str) -> list[str]:
    """Rule: strings, not one string; TypeError for anything else."""
    if (
        isinstance(value, Iterable)
        and not isinstance(value, (str, bytes, np.ndarray))
        and not is_symbolic(value)
    ):
        found = list(value)
        if all(isinstance(each, str) for each in found):
            return found
    raise TypeError(f"{name} must be a list of strings, not {shown(value)}")


def optional(rule: Callable) -> Callable:
    """The rule for what may also be None."""
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
        if not any(type(value) is type(each) and value == each for each in known):
            raise ValueError(
                f"{name} must be one of {', '.join(map(str, known))}, not {shown(value)}"
            )
        return value

    return rule


def jit(value: object, name: str) -> bool | str:
    """Rule: what `compile` takes as jit; ValueError for anything else."""
    if not (isinstance(value, bool) or (isinstance(value, str) and value == "auto")):
        raise ValueError(f'{name} must be False, True or "auto", not {shown(value)}')
    return value


def text(value: object, name: str) -> str:
    """Rule: a string; TypeError for anything else."""
    return instance(str, what="a string")(value, name)


def a_callable(value: object, name: str) -> Callable:
    """Rule: something that can be called; TypeError for anything else."""
    if not callable(value) or isinstance(value, type):
        raise TypeError(f"{name} must be a function or another callable, not {shown(value)}")
    return value


def modes(count: int) -> Callable:
    """Rule: +1 or -1, or two of them, as plain ints; ValueError for anything else."""

    def rule(value, name):
        try:
            found = real_numbers(value, name)
        except ValueError:
            found = np.array(np.nan)
        if found.shape != ((), (2,))[count - 1]:
            raise ValueError(
                f"{name} must be {'two modes, ' * (count == 2)}+1 or -1, not {shown(value)}"
            )
        if not np.all(np.abs(found) == 1):
            raise ValueError(f"{name} must be +1 or -1, not {shown(value)}")
        return int(found) if count == 1 else tuple(int(mode) for mode in found)

    return rule


def size(value: object, name: str) -> float:
    """Rule: a bar's length, m, from SHORTEST to LONGEST; ValueError for anything else."""
    found = number(value, name, 0.0, sys.float_info.max, above=True)
    if not SHORTEST <= found <= LONGEST:
        raise ValueError(
            f"{name} = {found:g} m is outside {SHORTEST:g} to {LONGEST:g} m: choose another unit of"
            " length"
        )
    return found


def base(value: object, name: str) -> float:
    """Rule: a distance of base joints or guides, m: 0, or from NARROWEST to LONGEST; ValueError for
    anything else.
    """
    found = number(value, name, 0.0, sys.float_info.max)
    if found and not NARROWEST <= found <= LONGEST:
        raise ValueError(
            f"{name} = {found:g} m is outside {NARROWEST:g} to {LONGEST:g} m, and not 0"
        )
    return found


def inertia(value: object, name: str) -> float:
    """Rule: a mass or an inertia, 0 or from LIGHTEST to HEAVIEST; ValueError for anything else."""
    found = not_negative(value, name)
    if found and not LIGHTEST <= found <= HEAVIEST:
        raise ValueError(f"{name} = {found:g} is outside {LIGHTEST:g} to {HEAVIEST:g}, and not 0")
    return found


def moment(value: object, name: str) -> float:
    """Rule: a first moment, or a grouped inertia that may be negative: 0 or from LIGHTEST to
    HEAVIEST in size.
    """
    found = number(value, name)
    inertia(abs(found), f"the size of {name}")
    return found


def not_too_different(lengths: dict[str, float]) -> None:
    """Refuse lengths (name -> m) of which one is RATIO times another; 0 is none."""
    found = {name: abs(length) for name, length in lengths.items() if length}
    short, long = (extreme(found, key=lambda name: found[name]) for extreme in (min, max))
    if found[long] > RATIO * found[short]:
        raise ValueError(
            f"{long} = {found[long]:g} m is more than {RATIO:g} times {short} = {found[short]:g} m:"
            " rounding of the one would be as large as what the other does"
        )


def bounded(count: float, most: float, what: str, bytes_each: float) -> None:
    """Refuse what would take too much memory, and say how much; what: where so many rows, or the
    like, come from.
    """
    if not count <= most:
        raise ValueError(
            f"{what}: at most {most:g}, and these would take about"
            f" {count * bytes_each / 1e9:.3g} GB"
        )
