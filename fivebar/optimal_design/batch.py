"""Many five-bars at once: the models' own equations, on columns of parameters in place of
numbers.
"""

from __future__ import annotations

from dataclasses import fields, replace
from numbers import Real
from typing import Any

import numpy as np

from ..base.checks import LONGEST, RATIO, SHORTEST
from ..models.robots import Biglide, FiveBar

# What a design may name beside the robot's own parameters, and what of the robot it is.
BOTH = {
    "l1": ("both proximal bars, m", {"l11": 1.0, "l21": 1.0}),
    "l2": ("both distal bars, m", {"l12": 1.0, "l22": 1.0}),
    "r1": ("Liu's r1, both proximal bars", {"l11": 1.0, "l21": 1.0}),
    "r2": ("Liu's r2, both distal bars", {"l12": 1.0, "l22": 1.0}),
    "r3": ("Liu's r3, half the distance of the base joints", {"d": 2.0}),
    "zz": ("both grouped inertias, kg m²", {"zz1": 1.0, "zz2": 1.0}),
}
PLACE = {"task_x": "m, where the task's own origin is", "task_y": "m, the same"}
LENGTHS = ("l11", "l12", "l21", "l22", "d")


def alone(value: Any) -> bool:
    """Whether this is one number, and not a pair of them."""
    return isinstance(value, Real) or (isinstance(value, np.ndarray) and value.ndim == 0)


class Robots(FiveBar):
    """Five-bars whose parameters are columns (n, 1): what the models compute of it is (n, poses).

    Made without the checks of one robot, which `checked` makes.
    """

    def __post_init__(self):
        pass


def known_variables(robot: FiveBar | Biglide) -> dict[str, dict[str, float]]:
    """What a design of such a robot may name, as {name: {parameter: factor}}; where its task is, as
    {}.
    """
    own = {f.name: {f.name: 1.0} for f in fields(robot) if f.name != "gravity"}
    both = {name: parts for name, (_, parts) in BOTH.items()} if isinstance(robot, FiveBar) else {}
    return {**both, **own, **{name: {} for name in PLACE}}


def check_variables(names: tuple[str, ...], robot: FiveBar | Biglide, what: str) -> None:
    """Refuse what no design can name, and what would set a parameter twice; what: the argument."""
    known, seen = known_variables(robot), {}
    if not names:
        raise ValueError(f"{what} must name at least one of {', '.join(known)}")
    for name in names:
        if name not in known:
            raise ValueError(
                f"{what}: no parameter {name!r} of a design; the known ones are {', '.join(known)}"
            )
        for part in known[name] or {name: 1.0}:
            if part in seen:
                raise ValueError(f"{what}: {name} and {seen[part]} both set {part}")
            seen[part] = name


def parameters(
    names: tuple[str, ...], rows: np.ndarray, robot: FiveBar | Biglide
) -> dict[str, np.ndarray]:
    """{parameter: column (n,)} that designs (n, len(names)) set; task_x, task_y among them."""
    known, found = known_variables(robot), {}
    for name, column in zip(names, rows.T):
        for part, factor in (known[name] or {name: 1.0}).items():
            found[part] = factor * column
    return found


def robot_of_design(
    names: tuple[str, ...], row: np.ndarray, robot: FiveBar | Biglide
) -> FiveBar | Biglide:
    """The robot of one design; ValueError for one that there cannot be."""
    found = parameters(names, np.asarray(row, dtype=float)[None], robot)
    return replace(
        robot, **{name: float(column[0]) for name, column in found.items() if name not in PLACE}
    )


def place_of_design(names: tuple[str, ...], rows: np.ndarray) -> np.ndarray:
    """Where each design's task is, (n, 2) m."""
    columns = dict(zip(names, rows.T))
    return np.stack([columns.get(name, np.zeros(len(rows))) for name in PLACE], axis=-1)


def at_once(names: tuple[str, ...], rows: np.ndarray, robot: FiveBar) -> Robots:
    """The robots of designs (n, len(names)), as one whose parameters are columns (n, 1)."""
    given = {f.name: getattr(robot, f.name) for f in fields(robot)}
    given |= {n: c[:, None] for n, c in parameters(names, rows, robot).items() if n not in PLACE}
    given |= {
        name: np.broadcast_to(np.reshape(given[name], (-1, 1)), (len(rows), 1)) for name in LENGTHS
    }
    return Robots(**given)


def checked(
    names: tuple[str, ...], rows: np.ndarray, robot: FiveBar | Biglide
) -> tuple[np.ndarray, list[tuple[int, str]]]:
    """(good (n,), [(row, why it is no robot), ...]): rows that are surely good are not made one by
    one.
    """
    good = (
        _surely(names, rows, robot)
        if isinstance(robot, FiveBar)
        else np.zeros(len(rows), dtype=bool)
    )
    errors = []
    for k in np.flatnonzero(~good):
        try:
            if not np.isfinite(rows[k]).all():
                name = names[int(np.flatnonzero(~np.isfinite(rows[k]))[0])]
                raise ValueError(f"{name} must be finite, not {rows[k][names.index(name)]}")
            robot_of_design(names, rows[k], robot)
            good[k] = True
        except ValueError as error:
            errors.append((int(k), str(error)))
    return good, errors


def _surely(names, rows, robot):
    """Where nothing but lengths varies, and these are ordinary and close."""
    known = known_variables(robot)
    if any(part not in LENGTHS for name in names for part in known[name]):
        return np.zeros(len(rows), dtype=bool)
    robots = at_once(names, rows, robot)
    lengths = np.concatenate([getattr(robots, name) for name in LENGTHS], axis=1)
    bars, d = lengths[:, :4], lengths[:, 4]
    with np.errstate(invalid="ignore"):
        ordinary = (bars.min(axis=1) >= SHORTEST) & (bars.max(axis=1) <= LONGEST)
        ordinary &= (bars.max(axis=1) <= 0.9 * RATIO * bars.min(axis=1)) & (
            (d == 0) | (d >= SHORTEST)
        )
        ordinary &= (d <= LONGEST) & (d * 0.9 * RATIO >= np.where(d > 0, bars.max(axis=1), 0.0))
        closes = 2 * lengths.max(axis=1) < lengths.sum(axis=1) * (1 - 1e-12)
    return ordinary & closes & np.isfinite(rows).all(axis=1)
