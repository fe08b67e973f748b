"""Designs to sweep: columns, grids, samples, Liu's triangle, files, or robots one by one."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..base.backend import finite_numbers, is_symbolic, real_numbers
from ..base.checks import number, shown, whole
from ..base.columns import read
from ..base.headings import Quantity
from ..base.representation import one_line
from ..base.tables import STRANGE, arrays_in
from ..base.units import METRES, unusual
from ..models.parameter_units import units_of
from ..models.robots import Biglide, FiveBar
from .batch import check_known, is_number, known_variables, scalar_parameters
from .closed_forms import CLOSED
from .one_by_one import ONE_BY_ONE
from .over_poses import OVER_POSES

MOST = 10**12  # designs


@dataclass(frozen=True, eq=False)
class Designs:
    """Rows of parameters by name, made a chunk at a time.

    From `grid`, `sample`, `triangle` or `designs_of`.

    Parameters
    ----------
    names : tuple of str
        What varies.
    count : int
    about : dict
        What a manifest says of them; they follow from it, or it has their hash.
    """

    names: tuple[str, ...]
    count: int
    about: dict
    _rows: Callable[[int, int], np.ndarray]  # (start, stop) -> rows

    def __repr__(self) -> str:
        return one_line("Designs", ", ".join(self.names), f"{self.count} rows")

    def __len__(self) -> int:
        return self.count

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """The first and the last design, (len(names),)."""
        return self._rows(0, 1)[0], self._rows(self.count - 1, self.count)[0]

    def chunks(self, size: int) -> Iterator[np.ndarray]:
        """Yield rows (size, len(names)), fewer at the end."""
        for start in range(0, self.count, size):
            yield self._rows(start, min(start + size, self.count))


def columns(values: Mapping[str, Any]) -> Designs:
    """Return designs of columns of one length by name; a number is in every design."""
    if not values:
        raise ValueError("designs: no column is given")
    parts = {name: _number_or_column(value, f"designs[{name}]") for name, value in values.items()}
    lengths = {name: len(part) for name, part in parts.items() if part.ndim}
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"designs: columns of unlike lengths, {lengths}; optimal_design.grid gives all"
            " combinations"
        )
    count = next(iter(lengths.values()), 1)
    if not count:
        raise ValueError("designs: the columns are empty")
    table = np.stack([np.broadcast_to(part, count) for part in parts.values()], axis=1)
    return _of_table(tuple(parts), table, {"sha256": hashlib.sha256(table.tobytes()).hexdigest()})


def _of_table(names, table, about):
    return Designs(names, len(table), about, lambda start, stop: table[start:stop])


def _number_or_column(value, name):
    """Return an array of at most one axis; nan and inf are errors of their design only."""
    array = real_numbers(value, name)
    if array.ndim > 1:
        raise ValueError(f"{name} must be a number or a column, not of shape {array.shape}")
    return array


def grid(axes: Mapping[str, Any]) -> Designs:
    """Return all combinations of values by name, the last name changing fastest.

    They are never all in memory.

    Parameters
    ----------
    axes : mapping
        {name: (low, high, count)} for so many values evenly from low to high, as --grid takes
        them; {name: [value, ...]}, a list or an array; or {name: value}.

    Returns
    -------
    Designs

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.optimal_design.grid({"l1": [0.1, 0.2], "l2": (0.1, 0.2, 5), "d": 0.1})
    <Designs: l1, l2, d, 10 rows>
    """
    if not isinstance(axes, Mapping) or not axes:
        raise TypeError(f"axes must be a table, as {{'l1': (0.08, 0.12, 5)}}, not {shown(axes)}")
    check_known(axes, "grid")
    values = {name: _axis(value, f"grid: {name}") for name, value in axes.items()}
    shape = tuple(len(value) for value in values.values())
    count = math.prod(shape)
    if count > MOST:
        raise ValueError(f"grid: {count:g} designs are more than {MOST:g}")

    def rows(start, stop):
        places = np.unravel_index(np.arange(start, stop), shape)
        return np.stack([value[place] for value, place in zip(values.values(), places)], axis=1)

    about = {"grid": {name: value.tolist() for name, value in values.items()}}
    return Designs(tuple(values), count, about, rows)


def _axis(given, name):
    """Return the values (n,) of one parameter of a grid."""
    if isinstance(given, tuple):
        if len(given) != 3:
            words = "(low, high, count), or a list or array of values"
            raise ValueError(f"{name} must be {words}, not {shown(given)}")
        return np.linspace(*interval(given[:2], name), whole(1, 10**6)(given[2], f"{name}'s count"))
    values = np.atleast_1d(finite_numbers(given, name))
    if values.ndim != 1 or not len(values):
        raise ValueError(f"{name} must be a row of numbers, not {shown(given)}")
    return values


def sample(bounds: Mapping[str, Any], count: int, seed: int = 0) -> Designs:
    """Return designs spread evenly between bounds, by Roberts' sequence.

    x_k = (x_0 + k a) mod 1 with a_j = g^-j and g^(n + 1) = g + 1, in whole numbers of 2^-64, so
    that a late design is as exact as the first, and each is made without those before it.

    Parameters
    ----------
    bounds : mapping
        {name: (low, high)}.
    count : int
        Designs.
    seed : int
        Of x_0.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.optimal_design.sample({"l1": (0.05, 0.2), "d": (0, 0.1)}, 1000)
    <Designs: l1, d, 1000 rows>
    """
    limits = limits_of(bounds)
    check_known(limits, "sample")
    count = whole(1, MOST)(count, "sample: its count")
    seed = whole(0, 2**63)(seed, "seed")
    low, high = np.array(list(limits.values())).T
    g = 2.0
    for _ in range(64):
        g = (1 + g) ** (1 / (len(limits) + 1))
    steps = np.array([int(2.0**64 / g**j) for j in range(1, len(limits) + 1)], dtype=np.uint64)
    first = np.random.default_rng(seed).integers(2**64 - 1, size=len(limits), dtype=np.uint64)

    def rows(start, stop):
        place = first + np.arange(start, stop, dtype=np.uint64)[:, None] * steps  # modulo 2^64
        return low + (high - low) * (place >> np.uint64(11)) * 2.0**-53

    ranges = {name: list(pair) for name, pair in limits.items()}
    about = {"sample": ranges, "count": count, "seed": seed}
    return Designs(tuple(limits), count, about, rows)


def limits_of(bounds: Mapping[str, Any]) -> dict[str, tuple]:
    """Return {name: (low, high)}; a single number is both."""
    if not isinstance(bounds, Mapping) or not bounds:
        example = "{'l1': (0.05, 0.2)}"
        raise TypeError(f"bounds must be a table, as {example}, not {shown(bounds)}")
    return {str(name): interval(pair, f"bounds: {name}") for name, pair in bounds.items()}


def interval(pair: Any, name: str) -> tuple[float, float]:
    """Return (low, high) of such a pair or of one number; ValueError names what is wrong."""
    try:
        low, high = (pair, pair) if is_number(pair) else pair
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be (low, high) or a number, not {shown(pair)}") from None
    low = number(low, f"{name}'s low")
    high = number(high, f"{name}'s high")
    if low > high:
        raise ValueError(f"{name} = ({low:g}, {high:g}) is the wrong way round")
    return low, high


def triangle(count: int = 30) -> Designs:
    """Return Liu's space of symmetric robots: r1 + r2 + r3 = 3, r3 <= r1 + r2.

    r1 and r2 are the proximal and the distal bars and r3 half the base, over their mean. The edges
    r1 = 0 and r2 = 0 are left out.

    Parameters
    ----------
    count : int
        Parts of a side of the grid.

    Returns
    -------
    Designs

    References
    ----------
    Liu, Wang and Pritschow, Mechanism and Machine Theory 41, 2006.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.optimal_design.triangle(6)
    <Designs: r1, r2, r3, 14 rows>
    """
    count = whole(2, 10**4)(count, "triangle: its count")
    first, second = np.mgrid[1:count, 1:count].reshape(2, -1)
    k = np.column_stack([first, second, count - first - second])
    inside = (k[:, 2] >= 0) & (2 * k[:, 2] <= count)
    return _of_table(("r1", "r2", "r3"), 3 * k[inside] / count, {"triangle": count})


def designs_of(source: Any, robot: FiveBar | Biglide) -> Designs:
    """Return designs of a mapping of columns, a file, or an iterable of robots or of mappings."""
    if isinstance(source, Designs):
        return source
    if isinstance(source, Mapping):
        return columns(source)
    if isinstance(source, (str, os.PathLike)):
        return _from_file(Path(source), robot)
    sequence = isinstance(source, Iterable) and not isinstance(source, (bytes, np.ndarray))
    if not sequence or is_symbolic(source):
        raise TypeError(
            f"designs must be columns by name, a file, or robots one by one, not {shown(source)}"
        )
    return _one_by_one(source, robot)


def _one_by_one(source, robot):
    """Return designs whose names are those of the first."""
    tables = [_by_name(design, robot) for design in source]
    if not tables:
        raise ValueError("designs: there is none")
    names = tuple(tables[0])
    for k, table in enumerate(tables):
        if set(table) != set(names):
            raise ValueError(
                f"designs[{k}] must name {', '.join(names)}, as the first does, not {shown(table)}"
            )
    values = {}
    for name in names:
        values[name] = [table[name] for table in tables]
    return columns(values)


def _by_name(design, robot):
    if isinstance(design, Mapping):
        return design
    if not isinstance(design, type(robot)):
        raise TypeError(
            f"designs must be robots as {type(robot).__name__}, or tables by name, not"
            f" {shown(design)}"
        )
    if design.gravity != robot.gravity:
        raise ValueError(
            f"designs: gravity {design.gravity} is not that of robot=, {robot.gravity}"
        )
    return {name: getattr(design, name) for name in scalar_parameters(robot)}


def _from_file(path, robot):
    """Return designs of a CSV or NPZ file; columns of figures, of an earlier sweep, are ignored."""
    if path.suffix not in (".npz", ".csv"):
        raise ValueError(f"designs must be in a .csv or .npz file, not {str(path)!r}")
    known = known_variables(robot)
    wanted = {}
    for name in known:
        units = METRES if name[0] == "r" else units_of(name, robot.turns)
        wanted[name] = Quantity((name,), units, needed=False)
    if path.suffix == ".npz":
        arrays = arrays_in(path)
        try:
            return columns(arrays)
        except STRANGE as error:
            raise ValueError(f"{path}: {error}") from None
    table = read(path, wanted)
    figures = [row[0] for row in (*CLOSED, *OVER_POSES, *ONE_BY_ONE)]
    unknown = [name for name in table.unused if name not in ("design", *figures)]
    if unknown or not table.values:
        reason = f"column {unknown[0]!r} is not used" if unknown else "no column is known"
        raise ValueError(f"{path}: {reason}; the parameters of a design are {', '.join(known)}")
    for name in table.values.keys() - table.stated.keys():
        for k, value in enumerate(table.values[name].tolist()):
            if name[0] in "ld" and (question := unusual(value, METRES, name[0] == "l")):
                words = f"{name}: {question} Write the unit: {name} (m) or {name} (mm)"
                raise table.error(k, f"{words} in the heading")
    return columns(table.values)
