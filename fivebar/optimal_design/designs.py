"""Designs to be swept: columns, grids, samples, Liu's triangle, files, or whatever gives robots one
by one.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..base.backend import finite_numbers, is_symbolic, real_numbers
from ..base.checks import number, shown, whole
from ..base.columns import METRES, NO_UNIT, Quantity, read
from ..base.representation import one_line
from ..base.tables import STRANGE, arrays_in, opened
from ..models.robots import Biglide, FiveBar
from .batch import PLACE, alone, known_variables
from .closed_forms import CLOSED
from .one_by_one import ONE_BY_ONE
from .over_poses import OVER_POSES

MOST = 10**12  # designs
# Columns of a sweep's own table that are no design's.
PASSED_OVER = {"design", *(row[0] for rows in (CLOSED, OVER_POSES, ONE_BY_ONE) for row in rows)}


@dataclass(frozen=True, eq=False)
class Designs:
    """Rows of parameters by name, made a chunk at a time; from `grid`, `sample`, `triangle`, or
    what `designs_of` took.

    names; count (None: not known before the end); about: what a manifest says of them, where they
    follow from it.
    """

    names: tuple[str, ...]
    count: int | None
    about: dict
    _rows: Any  # (start, stop) -> rows, or () -> an iterator of rows

    def __repr__(self) -> str:
        return one_line(
            "Designs", ", ".join(self.names), f"{'?' if self.count is None else self.count} rows"
        )

    def __len__(self) -> int:
        if self.count is None:
            raise TypeError("designs that come one by one have no length")
        return self.count

    def chunks(self, size: int) -> Iterator[np.ndarray]:
        """Rows (size, len(names)), fewer at the end."""
        if self.count is not None:
            for start in range(0, self.count, size):
                yield self._rows(start, min(start + size, self.count))
            return
        rows = self._rows()
        while part := list(itertools.islice(rows, size)):
            yield np.array(part)


def digest(rows: np.ndarray) -> str:
    """What tells a chunk from every other."""
    return hashlib.sha256(np.ascontiguousarray(rows, dtype="<f8").tobytes()).hexdigest()


def columns(given: Mapping[str, Any]) -> Designs:
    """Designs of columns by name, all of one length; a single number is in every design."""
    parts = {name: finite_or_not(value, f"designs[{name}]") for name, value in given.items()}
    if not parts:
        raise ValueError("designs: no column is given")
    lengths = {name: len(part) for name, part in parts.items() if part.ndim}
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"designs: columns of unlike lengths, {lengths}; for all combinations there is"
            " designing.grid"
        )
    count = next(iter(lengths.values()), 1)
    table = np.stack([np.broadcast_to(part, count) for part in parts.values()], axis=1)
    if not count:
        raise ValueError("designs: the columns are empty")
    return Designs(
        tuple(parts), count, {"sha256": digest(table)}, lambda start, stop: table[start:stop]
    )


def finite_or_not(value: Any, name: str) -> np.ndarray:
    """A number or a column of them; nan and inf are of the design's own making, and recorded with
    it.
    """
    found = real_numbers(value, name)
    if found.ndim > 1:
        raise ValueError(f"{name} must be a number or a column, not of shape {found.shape}")
    return found


def grid(**axes: Any) -> Designs:
    """All combinations of values by name, the last name changing fastest; never all in memory."""
    if not axes:
        raise ValueError("grid: name the values of at least one parameter, as l1=[0.08, 0.1]")
    values = {name: np.atleast_1d(finite_numbers(value, name)) for name, value in axes.items()}
    for name, value in values.items():
        if value.ndim != 1 or not len(value):
            raise ValueError(f"{name} must be a row of numbers, not {shown(axes[name])}")
    shape = tuple(len(value) for value in values.values())
    count = math.prod(shape)
    if count > MOST:
        raise ValueError(f"grid: {count:g} designs are more than {MOST:g}")

    def rows(start, stop):
        places = np.unravel_index(np.arange(start, stop), shape)
        return np.stack([value[place] for value, place in zip(values.values(), places)], axis=1)

    return Designs(
        tuple(values),
        count,
        {"grid": {name: value.tolist() for name, value in values.items()}},
        rows,
    )


def sample(bounds: Mapping[str, Any], count: int, seed: int = 0) -> Designs:
    """Designs spread evenly between bounds {name: (low, high)}, the k-th of them at once.

    Roberts' sequence: x_k = (x_0 + k a) mod 1 with a_j = g^-j, g^(n+1) = g + 1; in whole numbers of
    2^-64, so that a late one is as exact as the first. seed: of x_0.
    """
    limits = limits_of(bounds)
    count, seed = whole(1, MOST)(count, "count"), whole(0, 2**63)(seed, "seed")
    low, high = np.array(list(limits.values())).T
    g = 2.0
    for _ in range(64):
        g = (1 + g) ** (1 / (len(limits) + 1))
    steps = np.array([int(2.0**64 / g**j) for j in range(1, len(limits) + 1)], dtype=np.uint64)
    first = np.random.default_rng(seed).integers(2**64 - 1, size=len(limits), dtype=np.uint64)

    def rows(start, stop):
        place = first + np.arange(start, stop, dtype=np.uint64)[:, None] * steps  # modulo 2^64
        return low + (high - low) * (place >> np.uint64(11)) * 2.0**-53

    about = {
        "sample": {name: list(pair) for name, pair in limits.items()},
        "count": count,
        "seed": seed,
    }
    return Designs(tuple(limits), count, about, rows)


def limits_of(bounds: Mapping[str, Any], name: str = "bounds") -> dict[str, tuple[float, float]]:
    """{name: (low, high)}; a single number is both."""
    if not isinstance(bounds, Mapping) or not bounds:
        raise TypeError(f"{name} must be a table, as {{'l1': (0.05, 0.2)}}, not {shown(bounds)}")
    found = {}
    for each, pair in bounds.items():
        try:
            low, high = (pair, pair) if alone(pair) else pair
        except (TypeError, ValueError):
            raise ValueError(
                f"{name}: {each} must be (low, high) or a number, not {shown(pair)}"
            ) from None
        low, high = number(low, f"{name}: {each}'s low"), number(high, f"{name}: {each}'s high")
        if low > high:
            raise ValueError(f"{name}: {each} = ({low:g}, {high:g}) is the wrong way round")
        found[str(each)] = low, high
    return found


def triangle(count: int = 30) -> Designs:
    """Liu's design space of symmetric robots: r1 + r2 + r3 = 3, r3 <= r1 + r2, on a grid of so many
    parts a side.

    r1, r2: proximal and distal bars, r3: half the base, over their mean. Without the edges r1 = 0
        and r2 = 0.
    """
    count = whole(2, 10**4)(count, "count")
    k = np.array([(i, j) for i in range(1, count) for j in range(1, count - i + 1)])
    r = 3 * np.column_stack([k, count - k.sum(axis=1)]) / count
    r = r[2 * k.sum(axis=1) >= count]
    return Designs(
        ("r1", "r2", "r3"), len(r), {"triangle": count}, lambda start, stop: r[start:stop]
    )


def designs_of(given: Any, robot: FiveBar | Biglide) -> Designs:
    """Designs from a mapping of columns, a CSV or NPZ file, or an iterable of robots or of tables
    {name: value}.
    """
    if isinstance(given, Designs):
        return given
    if isinstance(given, Mapping):
        return columns(given)
    if isinstance(given, (str, os.PathLike)):
        return _from_file(Path(given), robot)
    if (
        not isinstance(given, Iterable)
        or isinstance(given, (bytes, np.ndarray))
        or is_symbolic(given)
    ):
        raise TypeError(
            f"designs must be columns by name, a file, or robots one by one, not {shown(given)}"
        )
    return _one_by_one(given, robot)


def _one_by_one(given, robot):
    """The first tells which parameters vary."""
    again = not isinstance(given, Iterator)
    rows = iter(given)
    try:
        first = next(rows)
    except StopIteration:
        raise ValueError("designs: there is none") from None
    names = (
        tuple(f.name for f in fields(robot) if f.name != "gravity")
        if isinstance(first, type(robot))
        else None
    )
    if names is None and not isinstance(first, Mapping):
        raise TypeError(
            f"designs must be robots as {type(robot).__name__}, or tables by name, not"
            f" {shown(first)}"
        )
    names = names or tuple(first)

    def row(k, each):
        if isinstance(each, type(robot)) and not isinstance(first, Mapping):
            if each.__dict__.get("gravity", (0, 0)) != robot.__dict__.get("gravity", (0, 0)):
                raise ValueError(
                    f"designs[{k}]: gravity {each.gravity} is not that of robot=, {robot.gravity}"
                )
            return [getattr(each, name) for name in names]
        if not isinstance(each, Mapping) or tuple(sorted(each)) != tuple(sorted(names)):
            raise ValueError(
                f"designs[{k}] must name {', '.join(names)}, as the first does, not {shown(each)}"
            )
        return [float(finite_or_not(each[name], f"designs[{k}][{name}]")) for name in names]

    def all_rows():
        source = iter(given) if again else itertools.chain([first], rows)
        return (row(k, each) for k, each in enumerate(source))

    return Designs(names, None, {"one by one": True}, all_rows)


def _from_file(path, robot):
    if path.suffix == ".npz":
        found = arrays_in(path)
        try:
            return columns(found)
        except STRANGE as error:
            raise ValueError(f"{path}: {error}") from None
    if path.suffix != ".csv":
        raise ValueError(f"designs must be in a .csv or .npz file, not {str(path)!r}")
    known = known_variables(robot)
    try:
        with opened(path) as table:
            names = tuple(table.header)
    except ValueError:
        names = ()  # of other letters, or a mark that spreadsheets put first
    if not names or not set(names) <= set(known):
        return _as_people_have_it(path, known)

    def rows():
        with opened(path) as table:
            for cells in table.rows() if table.header else ():
                try:
                    row = [float(cell) for cell in cells]
                except ValueError:
                    row = []
                if len(row) != len(names):
                    raise table.error(f"a design has {len(names)} numbers, not {shown(cells)}")
                yield row

    return Designs(names, None, {"file": path.name}, rows)


def _as_people_have_it(path, known):
    """Other separators, decimal commas, millimetres, and beside them figures of an earlier sweep:
    read at once.
    """
    wanted = {
        name: Quantity(
            (name,), METRES if name[0] in "ldr" or name in PLACE else NO_UNIT, needed=False
        )
        for name in known
    }
    found = read(path, wanted)
    strange = [
        notes
        for notes in found.notes
        if notes.endswith("is not used") and notes.split("'")[1] not in PASSED_OVER
    ]
    if strange or not found.values:
        first = (
            f"{strange[0].removesuffix(' is not used')} is none" if strange else "no column is one"
        )
        raise ValueError(f"{path}: {first} of the parameters of a design, {', '.join(known)}")
    return columns(found.values)
