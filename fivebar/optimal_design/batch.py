"""Robots of designs: one by one, or many at once with columns of parameters in place of numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from numbers import Real
from typing import Any

import numpy as np

from ..base.checks import number, shown
from ..models.parameters import with_values
from ..models.robots import Biglide, FiveBar
from ..models.values import ask_about_units

# What a design of a five-bar may name beside its parameters: {parameter: factor}.
SHARED = {
    "l1": {"l11": 1.0, "l21": 1.0},
    "l2": {"l12": 1.0, "l22": 1.0},
    "r1": {"l11": 1.0, "l21": 1.0},  # Liu's lengths: r3 is half the base
    "r2": {"l12": 1.0, "l22": 1.0},
    "r3": {"d": 2.0},
    "zz": {"zz1": 1.0, "zz2": 1.0},
}
PLACE = ("task_x", "task_y")  # m, the origin of the task
LENGTHS = ("l11", "l12", "l21", "l22", "d")


def is_number(value: Any) -> bool:
    """Return whether this is one number, and not a pair of them."""
    return isinstance(value, Real) or (isinstance(value, np.ndarray) and value.ndim == 0)


class Robots(FiveBar):
    """Five-bars whose parameters are columns (n, 1): the models compute (n, poses) of them.

    Made without the checks of one robot; see `valid_rows`.
    """

    def __post_init__(self):
        pass


def scalar_parameters(robot: FiveBar | Biglide) -> list[str]:
    """Return the names of a robot's parameters that are numbers."""
    return [field.name for field in fields(robot) if field.name != "gravity"]


def known_variables(robot: FiveBar | Biglide) -> dict[str, dict[str, float]]:
    """Return {name: {parameter: factor}} of all that a design of such a robot may name."""
    names = (*scalar_parameters(robot), *PLACE)
    shared = SHARED if isinstance(robot, FiveBar) else {}
    return {**shared, **{name: {name: 1.0} for name in names}}


def check_known(names: Iterable[str], argument: str, *robots: FiveBar | Biglide) -> None:
    """Raise ValueError for a name that no design of one of these robots has; of any without."""
    known: dict = {}
    for robot in robots or (FiveBar(), Biglide()):
        known |= known_variables(robot)
    for name in names:
        if name not in known:
            raise ValueError(
                f"{argument}: no parameter {shown(name)} of a design; the known ones are"
                f" {', '.join(known)}"
            )


def check_variables(
    names: tuple[str, ...], robot: FiveBar | Biglide, argument: str, *rows: np.ndarray
) -> None:
    """Raise ValueError for an unknown name, and for two names that set one parameter; warn of bars
    in these designs that seem to be in millimetres.
    """
    known = known_variables(robot)
    if not names:
        raise ValueError(f"{argument} must name at least one of {', '.join(known)}")
    check_known(names, argument, robot)
    set_by: dict[str, str] = {}
    for name in names:
        for parameter in known[name]:
            if parameter in set_by:
                raise ValueError(f"{argument}: {name} and {set_by[parameter]} both set {parameter}")
            set_by[parameter] = name
    for row in rows:
        ask_about_units(dict(zip(names, row)))


def varied_parameters(names: Iterable[str], robot: FiveBar | Biglide) -> set[str]:
    """Return the parameters that designs set by these names, with the place."""
    known = known_variables(robot)
    return {parameter for name in names for parameter in known[name]}


def parameters(
    names: tuple[str, ...], rows: np.ndarray, robot: FiveBar | Biglide
) -> dict[str, np.ndarray]:
    """Return {parameter: column (n,)} that designs (n, len(names)) set, without the place."""
    known = known_variables(robot)
    columns = {}
    for name, column in zip(names, rows.T):
        if name not in PLACE:
            columns.update({part: factor * column for part, factor in known[name].items()})
    return columns


def robot_of_design(
    names: tuple[str, ...], row: np.ndarray, robot: FiveBar | Biglide
) -> FiveBar | Biglide:
    """Return the robot of one design; ValueError where there is none."""
    columns = parameters(names, np.asarray(row, dtype=float)[None], robot)
    changes: dict[str, Any] = {name: float(column[0]) for name, column in columns.items()}
    return with_values(robot, changes)


def place_of_design(names: tuple[str, ...], rows: np.ndarray) -> np.ndarray:
    """Return the origin of each design's task, (n, 2) m."""
    columns = dict(zip(names, rows.T))
    return np.stack([columns.get(name, np.zeros(len(rows))) for name in PLACE], axis=-1)


def robots_of_designs(names: tuple[str, ...], rows: np.ndarray, robot: Any) -> Robots:
    """Return the robots of designs (n, len(names)) as one whose parameters are columns (n, 1)."""
    values = {field.name: getattr(robot, field.name) for field in fields(robot)}
    for name, column in parameters(names, rows, robot).items():
        values[name] = column[:, None]
    for name in LENGTHS:
        values[name] = np.broadcast_to(values[name], (len(rows), 1))
    return Robots(**values)


def valid_rows(
    names: tuple[str, ...], rows: np.ndarray, robot: FiveBar | Biglide
) -> tuple[np.ndarray, list[tuple[int, str]]]:
    """Return (valid (n,), [(row, why it is no robot), ...]) of designs.

    Robots of ordinary lengths are not made one by one, which would take longer than most figures.
    """
    valid = _ordinary(names, rows, robot)
    errors = []
    for k in np.flatnonzero(~valid):
        try:
            for name, value in zip(names, rows[k].tolist()):
                number(value, name)
            robot_of_design(names, rows[k], robot)
            valid[k] = True
        except ValueError as error:
            errors.append((int(k), str(error)))
    return valid, errors


def _ordinary(names, rows, robot):
    """Return where only lengths vary, all from 1 mm to 1 km, and the loop closes by a margin."""
    if not isinstance(robot, FiveBar) or varied_parameters(names, robot) - {*LENGTHS, *PLACE}:
        return np.zeros(len(rows), dtype=bool)
    robots = robots_of_designs(names, rows, robot)
    lengths = np.concatenate([getattr(robots, name) for name in LENGTHS], axis=1)
    long_enough = lengths >= 1e-3
    long_enough[:, 4] |= lengths[:, 4] == 0
    closes = 2 * lengths.max(axis=1) < lengths.sum(axis=1) * (1 - 1e-12)
    sound = long_enough.all(axis=1) & (lengths.max(axis=1) <= 1e3)
    return sound & closes & np.isfinite(rows).all(axis=1)
