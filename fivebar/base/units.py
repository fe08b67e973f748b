"""Units of files and options: one table, and numbers with a unit, as "80 mm"."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from typing import Any

from .checks import shown

SHORTEST_BAR = 1e-4  # m, of what stands on a desk

# {unit: its size in SI units}; the first is the SI unit.
METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254}
RADIANS = {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3, "rev": 2 * math.pi}
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
KILOGRAMS = {"kg": 1.0, "g": 1e-3}
NEWTONS = {"N": 1.0, "mN": 1e-3}
NEWTON_METRES = {"N m": 1.0, "mN m": 1e-3, "N cm": 1e-2, "N mm": 1e-3, "kg cm": 0.0980665}
FIRST_MOMENTS = {"kg m": 1.0, "g mm": 1e-6}
INERTIAS = {"kg m²": 1.0, "kg cm²": 1e-4, "g cm²": 1e-7, "g mm²": 1e-9}
SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "in/s": 0.0254}
ACCELERATIONS = {"m/s²": 1.0, "mm/s²": 1e-3}
JERKS = {"m/s³": 1.0, "mm/s³": 1e-3}
RADIANS_PER_SECOND = {
    "rad/s": 1.0,
    "deg/s": math.pi / 180,
    "rpm": math.pi / 30,
    "rev/s": 2 * math.pi,
}
ANGULAR_ACCELERATIONS = {"rad/s²": 1.0, "deg/s²": math.pi / 180}
STIFFNESSES = {"N m/rad": 1.0, "N m/deg": 180 / math.pi}
DAMPINGS = {"N m s/rad": 1.0, "mN m s/rad": 1e-3}
SLIDING_DAMPINGS = {"N s/m": 1.0}
AMPERES = {"A": 1.0, "mA": 1e-3}
HERTZ = {"Hz": 1.0, "kHz": 1e3}
COUNTS = {"counts": 1.0}
NO_UNIT = {"1": 1.0}
ALL = (
    METRES, RADIANS, SECONDS, KILOGRAMS, NEWTONS, NEWTON_METRES, FIRST_MOMENTS, INERTIAS, SPEEDS,
    ACCELERATIONS, JERKS, RADIANS_PER_SECOND, ANGULAR_ACCELERATIONS, STIFFNESSES, DAMPINGS,
    SLIDING_DAMPINGS, AMPERES, HERTZ, COUNTS,
)  # fmt: skip

# Of what stands on a desk: (largest value, the unit that a larger one is more likely to be in).
USUAL = (
    (METRES, 3.0, "mm"),
    (RADIANS, 6.3, "deg"),
    (SPEEDS, 10.0, "mm/s"),
    (KILOGRAMS, 50.0, "g"),
    (NEWTON_METRES, 100.0, "mN m"),
    (ACCELERATIONS, 1000.0, "mm/s²"),
)

SYNONYMS = {
    "s": "sec secs second seconds",
    "ms": "msec millis millisecond milliseconds",
    "us": "microsecond microseconds",
    "ns": "nsec nsecs nanosecond nanoseconds",
    "m": "metre metres meter meters",
    "mm": "millimetre millimetres millimeter millimeters",
    "in": 'inch inches "',
    "deg": "° degree degrees degre degres grad grado grados gradi grau graus",
    "deg/s": "°/s degrees/s",
    "rad": "radian radians",
    "rev": "turn turns revolution revolutions tr tour tours",
    "rpm": "tr/min",
    "counts": "count ticks steps inc",
    "kg cm": "kgfcm",
    "N m s/rad": "nms",
    "mN m s/rad": "mnms",
}
NUMBER = re.compile(r"\s*([-+]?(?:inf|[\d.]+(?:e[-+]?\d+)?))\s*((?![\d,/\s]).*?)\s*", re.IGNORECASE)


def unaccented(word: str) -> str:
    """Return a word in small letters without accents."""
    letters = unicodedata.normalize("NFKD", word).casefold()
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def _squeezed(word):
    return re.sub(r"[\s·*.^]", "", unaccented(word).replace("μ", "u"))


_UNITS = {_squeezed(unit): unit for units in ALL for unit in units}
_UNITS |= {word: unit for unit, words in SYNONYMS.items() for word in words.split()}


def unit_named(word: str) -> str:
    """Return a unit as the tables write it; an unknown word without blanks and accents."""
    squeezed = _squeezed(word)
    return _UNITS.get(squeezed, squeezed)


def number_in(
    value: Any, units: Mapping[str, float], unit: str = "", is_bar: bool = False
) -> float:
    """Return the number in a unit that a number says, or a text with or without a unit.

    Parameters
    ----------
    value : number or str
    units : mapping
        A table of units, of which it may have one; NO_UNIT of numbers.
    unit : str
        The unit of the result, and of a number without a unit; the SI unit by default.
    is_bar : bool
        Whether it is a bar, which has a usual least length, too.

    Raises
    ------
    ValueError
        It is no number, its unit is not in the table, or without a unit it is unusual.
    """
    found = NUMBER.fullmatch(value) if isinstance(value, str) else None
    try:
        number = float(found[1] if found else value)
    except (TypeError, ValueError):
        number = math.nan
    if math.isnan(number):
        raise ValueError(f"{shown(value)} is not a number, as 1.5")
    word = unit_named(found[2]) if found else ""
    if word in units:
        size = units[word] / (units[unit] if unit else 1.0)
        # 118 mm are 0.118 m to the last digit, which 118 * 0.001 are not.
        return number * size if size >= 1 else number / (1 / size)
    if word:
        known = ", ".join(units) if units is not NO_UNIT else "none"
        raise ValueError(f"{shown(value)}: its unit must be {known}")
    of_si = next(iter(units))
    if unit in ("", of_si) and (question := unusual(number, units, is_bar)):
        smaller = next((small for table, _, small in USUAL if table is units), "")
        raise ValueError(
            f'{question} Write the unit, as "{number:g} {smaller}" or "{number:g} {of_si}"'
        )
    return number


def unusual(value: float, units: Mapping[str, float], is_bar: bool = False) -> str:
    """Return what to ask about a value in SI units where nobody wrote its unit; "" of a usual one.

    units: the table of its units; is_bar: whether it is a bar.
    """
    for table, largest, smaller in USUAL:
        if table is units and largest < abs(value) < math.inf:
            return f"{value:g} {next(iter(units))}: did you mean {value:g} {smaller}?"
    if is_bar and units is METRES and 0 < value < SHORTEST_BAR:
        return f"a bar of {1e3 * value:g} mm: is it in another unit?"
    return ""
