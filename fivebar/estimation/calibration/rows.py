"""What was measured, row by row: readings of the joints, points or distances, the modes somebody
noted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from ...base.backend import HUGE, real_numbers
from ...base.checks import shown
from ...base.columns import COUNTS, METRES, NO_UNIT, RADIANS, Quantity, read
from ...base.tables import FilePath, named

MODES = "working1", "working2", "assembly"
ANGLE, LENGTH = RADIANS | COUNTS, METRES
WANTED = {
    "q1": Quantity(("q1", "q11", "theta1", "counts1", "encoder1"), ANGLE),
    "q2": Quantity(("q2", "q21", "theta2", "counts2", "encoder2"), ANGLE),
    "x": Quantity(("x", "x_measured"), LENGTH, needed=False),
    "y": Quantity(("y", "y_measured"), LENGTH, needed=False),
    "working1": Quantity(("working1", "gamma1"), NO_UNIT, needed=False),
    "working2": Quantity(("working2", "gamma2"), NO_UNIT, needed=False),
    "assembly": Quantity(("assembly", "assembly_mode"), NO_UNIT, needed=False),
    "distance": Quantity(("distance",), LENGTH, needed=False),
    "to": Quantity(("to", "to_row"), NO_UNIT, needed=False),
    "sigma": Quantity(("sigma", "sd"), LENGTH, needed=False),
}


@dataclass(frozen=True, eq=False)
class Rows:
    """Measured rows. q (n, 2), points (n, 2) and distance (n,) m, nan where not measured; to (n,)
    the row at the distance's other end, -1: none; working (n, 2), assembly (n,) as noted, 0 where
    not; sigma (n,) m, nan where not given; where (n,) what each row is called; said: sentences on
    what was converted and left out.
    """

    q: np.ndarray
    points: np.ndarray
    working: np.ndarray
    assembly: np.ndarray
    distance: np.ndarray
    to: np.ndarray
    sigma: np.ndarray
    where: tuple[str, ...]
    notes: tuple[str, ...] = ()
    stated: frozenset[str] = frozenset()

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def whole(self) -> np.ndarray:
        """(n,) where both coordinates of the point are measured."""
        return np.isfinite(self.points).all(axis=1)

    @cached_property
    def asked(self) -> tuple:
        """What is measured, in the order of the residuals: (row, coordinate) of points, rows of
        distances.
        """
        return (*np.nonzero(np.isfinite(self.points)), np.flatnonzero(self.to >= 0))

    @cached_property
    def row_of(self) -> np.ndarray:
        """The row of each residual."""
        return np.concatenate([self.asked[0], self.asked[2]])

    @cached_property
    def numbers(self) -> np.ndarray:
        """What was measured, as one vector, m."""
        row, axis, far = self.asked
        return np.concatenate([self.points[row, axis], self.distance[far]])

    def without(self, out: np.ndarray) -> Rows:
        """The rows but those (n,) bool; a distance to one of these goes too."""
        keep = np.flatnonzero(~out)
        new = np.full(len(self) + 1, -1)
        new[keep] = np.arange(len(keep))
        parts = {
            n: getattr(self, n)[keep]
            for n in ("q", "points", "working", "assembly", "distance", "sigma")
        }
        return replace(
            self, **parts, to=new[self.to[keep]], where=tuple(self.where[k] for k in keep)
        )


def rows_of(
    data: Mapping | FilePath,
    units: Mapping[str, str] | Sequence[str] = MappingProxyType({}),
    weights: np.ndarray | None = None,
    name: str = "data",
) -> Rows:
    """The Rows in a CSV file or in a mapping of arrays; rows in which nothing is measured are left
    out, and named.

    weights: (n,), relative, in place of sigma.
    """
    if isinstance(data, Mapping):
        return _rows(_of_arrays(data, name), None, (), frozenset(), weights, name)
    if not (isinstance(data, (str, os.PathLike)) or hasattr(data, "read")):
        raise TypeError(
            f"{name} must be a mapping of arrays (q1, q2, x, y, ...) or a CSV file, not"
            f" {shown(data)}"
        )
    table = read(data, WANTED, units)
    with named(table.name):
        where = tuple(f"line {line}" for line in table.lines)
        return _rows(dict(table.values), where, table.notes, table.stated, weights, name)


def _rows(columns, where, notes, stated, weights, name):
    for key, column in columns.items():
        if (np.isinf(column) | (np.abs(np.nan_to_num(column)) > HUGE)).any():
            raise ValueError(
                f"{name}[{key!r}] must be below {HUGE:g} in size, or nan where it is missing"
            )
    n = len(columns["q1"])
    where = where or tuple(f"row {k + 1}" for k in range(n))
    if weights is not None:
        if len(weights) != n:
            raise ValueError(f"weights has {len(weights)} numbers for the {n} rows of {name}")
        columns["sigma"] = 1 / np.sqrt(weights)
    nothing = np.full(n, np.nan)
    get = {key: columns.get(key, nothing) for key in WANTED}
    modes = np.stack([_modes(get[key], key, where) for key in MODES], axis=-1)
    to = _targets(get["to"], get["distance"], where)
    rows = Rows(
        np.stack([get["q1"], get["q2"]], axis=-1),
        np.stack([get["x"], get["y"]], axis=-1),
        modes[:, :2],
        modes[:, 2],
        get["distance"],
        to,
        get["sigma"],
        where,
        tuple(notes),
        frozenset(stated),
    )
    return _usable(rows)


def _of_arrays(data, name):
    if unknown := [key for key in data if key not in WANTED]:
        raise ValueError(
            f"{name} has no column {shown(unknown[0])}; the known ones are {', '.join(WANTED)}"
        )
    columns = {
        key: real_numbers(value, f"{name}[{key!r}]").ravel()
        for key, value in data.items()
        if value is not None
    }
    if missing := [key for key in ("q1", "q2") if key not in columns]:
        raise ValueError(
            f"{name} has no column {', '.join(missing)}; needed q1, q2 and x, y or distance, to"
        )
    n = len(columns["q1"])
    for key in {*MODES, "sigma"} & set(columns):  # one for all rows
        columns[key] = np.full(n, columns[key][0]) if len(columns[key]) == 1 else columns[key]
    lengths = {key: len(column) for key, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"the columns of {name} differ in length: {lengths}")
    return columns


def _modes(column, key, where):
    wrong = np.isfinite(column) & ~np.isin(column, (-1.0, 0.0, 1.0))
    if wrong.any():
        k = int(np.argmax(wrong))
        raise ValueError(f"{where[k]}: {key} must be +1 or -1, or empty, not {column[k]:g}")
    return np.nan_to_num(column).astype(np.int8)


def _targets(to, distance, where):
    """Row at a distance's other end, from its number counted from 1."""
    for k in np.flatnonzero(np.isfinite(distance) != np.isfinite(to)):
        what = ("to", "distance") if np.isfinite(distance[k]) else ("distance", "to")
        raise ValueError(
            f"{where[k]}: {what[1]} without {what[0]}: a distance needs the number of the row it"
            " leads to"
        )
    found = np.clip(np.nan_to_num(to), 0, len(to) + 1).astype(int) - 1
    for k in np.flatnonzero(np.isfinite(to)):
        if found[k] + 1 != to[k] or not 0 <= found[k] < len(to) or found[k] == k:
            raise ValueError(
                f"{where[k]}: to = {to[k]:g} must be the number of another row, counted from 1 to"
                f" {len(to)}"
            )
        if not distance[k] >= 0:
            raise ValueError(f"{where[k]}: distance must be >= 0, not {distance[k]:g}")
    return found


def _usable(rows):
    """Without the rows that say nothing, which are named."""
    blind = ~np.isfinite(rows.q).all(axis=1)
    target = np.zeros(len(rows), bool)
    target[rows.to[rows.to >= 0]] = True
    empty = ~blind & ~np.isfinite(rows.points).any(axis=1) & (rows.to < 0) & ~target
    notes = list(rows.notes)
    for out, why in ((blind, "without q1 or q2"), (empty, "without x, y or distance")):
        if out.any():
            notes.append(f"left out, {why}: {', '.join(np.array(rows.where)[out])}")
    found = replace(
        rows.without(blind | empty) if (blind | empty).any() else rows, notes=tuple(notes)
    )
    if not len(found.numbers):
        raise ValueError(
            f"nothing is measured in data: {'; '.join(notes) or 'neither x, y nor distance'}"
        )
    bad = np.isfinite(found.sigma) & ~(found.sigma > 0)
    if bad.any():
        raise ValueError(f"{found.where[int(np.argmax(bad))]}: sigma must be > 0")
    return found
