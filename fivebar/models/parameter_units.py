"""The units of what robot files and options name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base import units
from ..base.units import NO_UNIT, number_in

# Numbers at the end of a name do not count: l11, or links.11.
NAMES = {
    "l d x y along across shift clearance region widths posts half_planes": units.METRES,
    "task_x task_y": units.METRES,
    "turn offset joints q": units.RADIANS,
    "ratio": dict(units.RADIANS),  # of a drive that reads degrees "1 deg"; no angle has it
    "links m mf mass payload": units.KILOGRAMS,
    "mx my": units.FIRST_MOMENTS,
    "zz rotor inertia inertia_about_centre": units.INERTIAS,
    "gravity acceleration": units.ACCELERATIONS,
    "speed": units.SPEEDS,
    "jerk": units.JERKS,
    "joint_speed no_load_speed": units.RADIANS_PER_SECOND,
    "joint_acceleration": units.ANGULAR_ACCELERATIONS,
    "fs coulomb torque stall_torque largest_torque": units.NEWTON_METRES,
    "fv viscous elbows": units.DAMPINGS,
}
OF_SLIDES = {
    "offset ratio joints q": units.METRES,
    "joint_speed": units.SPEEDS,
    "joint_acceleration": units.ACCELERATIONS,
    "fs torque": units.NEWTONS,
    "fv": units.SLIDING_DAMPINGS,
}


def units_of(name: str, turns: bool = True) -> Mapping[str, float]:
    """Return the table of units of a parameter by its name, NO_UNIT where it has none."""
    plain = name.rstrip("0123456789.")
    for table in (NAMES,) if turns else (OF_SLIDES, NAMES):
        for names, known in table.items():
            if plain in names.split():
                return known
    return NO_UNIT


def parameter_in_si(text: Any, name: str, turns: bool = True) -> float:
    """Return the number in SI units that a parameter's text says; ValueError names it."""
    try:
        return number_in(text, units_of(name, turns), is_bar=name[0] == "l")
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def table_in_si(value: Any, turns: bool, name: str = "") -> Any:
    """Return a robot file's table with numbers in place of texts with units, as "80 mm".

    Texts of what has no unit stay, as a motor's name. ValueError: a length without a unit is
    unusual, or a unit is none of its quantity.
    """
    if isinstance(value, Mapping):
        table = {}
        for key, part in value.items():
            own = key if units_of(key, turns) is not NO_UNIT else f"{name}.{key}"
            table[key] = table_in_si(part, turns, own)
        return table
    if isinstance(value, list | tuple):
        # Of a half plane (a, b, c) c alone is a length.
        if name == "half_planes" and len(value) == 3 and not isinstance(value[0], list):
            return [*value[:2], table_in_si(value[2], turns, name)]
        return [table_in_si(part, turns, name) for part in value]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if (is_number or isinstance(value, str)) and units_of(name, turns) is not NO_UNIT:
        return parameter_in_si(value, name, turns)
    return value
