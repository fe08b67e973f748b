"""Measured rows: readings of the joints, points or distances, and the modes that were noted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy import ndarray

from ...base.columns import read
from ...base.headings import Quantity
from ...base.tables import FilePath, named
from ...base.units import COUNTS, METRES, NO_UNIT, RADIANS

NAMED = 12  # rows that a message names
MODES = "working1", "working2", "assembly"
ANGLE = RADIANS | COUNTS
WANTED = {
    "q1": Quantity(("q11", "theta1", "counts1", "encoder1"), ANGLE),
    "q2": Quantity(("q21", "theta2", "counts2", "encoder2"), ANGLE),
    "x": Quantity(("x_measured",), METRES, needed=False),
    "y": Quantity(("y_measured",), METRES, needed=False),
    "working1": Quantity(("gamma1",), NO_UNIT, needed=False),
    "working2": Quantity(("gamma2",), NO_UNIT, needed=False),
    "assembly": Quantity(("assembly_mode",), NO_UNIT, needed=False),
    "distance": Quantity((), METRES, needed=False),
    "to": Quantity(("to_row",), NO_UNIT, needed=False),
    "sigma": Quantity(("sd",), METRES, needed=False),
}


@dataclass(frozen=True, eq=False)
class MeasuredRows:
    """Measured rows.

    Attributes
    ----------
    q : (n, 2) array
        Readings of the joints.
    points : (n, 2) array
        m, nan where not measured.
    working, assembly : (n, 2) and (n,) arrays of int
        Modes as noted, 0 where not.
    distance : (n,) array
        m, nan where not measured.
    to : (n,) array of int
        The row at the other end of the distance, -1 for none.
    sigma : (n,) array
        Standard deviation of a measured number, m, nan where not given.
    where : tuple of str
        What messages call each row: "line 7", "row 6".
    notes : tuple of str
        What was converted and left out.
    loop : (n, 2, 3) array, optional
        Of poses near Type 2, the matrix W of `whitening`; nan for the others.
    """

    q: ndarray
    points: ndarray
    working: ndarray
    assembly: ndarray
    distance: ndarray
    to: ndarray
    sigma: ndarray
    where: tuple[str, ...]
    notes: tuple[str, ...] = ()
    loop: ndarray | None = None

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def whole(self) -> ndarray:
        """(n,) where both coordinates of the point are measured."""
        return np.isfinite(self.points).all(axis=1)

    @cached_property
    def modes(self) -> ndarray:
        """(n, 3) both working modes and the assembly mode as noted."""
        return np.column_stack([self.working, self.assembly])

    @cached_property
    def measured(self) -> tuple:
        """(row, axis) of the measured coordinates, and the rows of the measured distances."""
        return (*np.nonzero(np.isfinite(self.points)), np.flatnonzero(self.to >= 0))

    @cached_property
    def looped(self) -> tuple:
        """The rows (k,) that are fitted by their loop, and the residuals (k, 2) they have."""
        if self.loop is None:
            return np.zeros(0, int), np.zeros((0, 2), int)
        rows = np.flatnonzero(np.isfinite(self.loop[:, 0, 0]))
        return rows, np.searchsorted(self.measured[0], rows)[:, None] + [0, 1]

    @cached_property
    def row_of(self) -> ndarray:
        """The row of each residual."""
        return np.concatenate([self.measured[0], self.measured[2]])

    @cached_property
    def numbers(self) -> ndarray:
        """All measured numbers, m, in the order of the residuals."""
        row, axis, far = self.measured
        return np.concatenate([self.points[row, axis], self.distance[far]])

    def named(self, chosen: ndarray) -> str:
        """Return what a message calls rows (n,) bool, of many the first ones; "" for none."""
        if len(self) > NAMED and np.all(chosen):
            return f"all {len(self)} rows"
        places = np.flatnonzero(chosen)
        words = [self.where[k] for k in places[:NAMED]]
        more = len(places) - NAMED
        return ", ".join(words) + (f" and {more} more" if more > 0 else "")

    def without(self, out: ndarray) -> MeasuredRows:
        """Return the rows but those (n,) bool; a distance to one of these is left out, too."""
        kept = np.flatnonzero(~out)
        new = np.full(len(self) + 1, -1)
        new[kept] = np.arange(len(kept))
        arrays = ("q", "points", "working", "assembly", "distance", "sigma")
        return replace(
            self,
            **{name: getattr(self, name)[kept] for name in arrays},
            loop=None if self.loop is None else self.loop[kept],
            to=new[self.to[kept]],
            where=tuple(self.where[k] for k in kept),
        )


def rows_of(
    data: Mapping | FilePath,
    units: Mapping[str, str] | Sequence[str] = (),
    columns: Mapping[str, str] | Sequence[str] = (),
) -> MeasuredRows:
    """Return the Rows of a file or a mapping of arrays.

    Rows in which nothing is measured are left out and named.
    """
    table = read(data, WANTED, units, columns=columns)
    with named(table.name):
        n = len(table.lines)
        values = dict.fromkeys(WANTED, np.full(n, np.nan)) | table.values
        where = tuple(table.where(row) for row in range(n))
        modes = np.stack([_modes(values[name], name, where) for name in MODES], axis=1)
        rows = MeasuredRows(
            np.stack([values["q1"], values["q2"]], axis=1),
            np.stack([values["x"], values["y"]], axis=1),
            modes[:, :2],
            modes[:, 2],
            values["distance"],
            _targets(values["to"], values["distance"], where),
            values["sigma"],
            where,
            table.notes,
        )
        return _without_useless(rows)


def _modes(column, name, where):
    wrong = np.isfinite(column) & ~np.isin(column, (-1.0, 0.0, 1.0))
    if wrong.any():
        k = int(np.argmax(wrong))
        raise ValueError(f"{where[k]}: {name} must be +1 or -1, or empty, not {column[k]:g}")
    return np.nan_to_num(column).astype(np.int8)


def _targets(to, distance, where):
    """Return the row at the other end of each distance, from its number counted from 1."""
    n = len(to)
    own = np.arange(1, n + 1)
    good = np.isin(to, own) & (to != own) & ~(distance < 0)
    good |= np.isnan(to) & np.isnan(distance)
    if not good.all():
        k = int(np.argmin(good))
        raise ValueError(
            f"{where[k]}: distance = {distance[k]:g} and to = {to[k]:g} must be a length >= 0 and"
            f" the number of another row, counted from 1 to {n}"
        )
    return np.nan_to_num(to).astype(int) - 1


def _without_useless(rows):
    blind = ~np.isfinite(rows.q).all(axis=1)
    open_ends = (rows.to >= 0) & np.isnan(rows.distance)
    rows = replace(rows, to=np.where(open_ends, -1, rows.to))
    needed = np.isfinite(rows.points).any(axis=1) | (rows.to >= 0)
    needed[rows.to[rows.to >= 0]] = True
    empty = ~blind & ~needed
    notes = list(rows.notes)
    for out, why in (
        (blind, "without q1 or q2"),
        (empty, "without x, y or distance"),
        (open_ends & ~empty, "distance without a number"),
    ):
        if out.any():
            notes.append(f"left out, {why}: {rows.named(out)}")
    rows = replace(rows.without(blind | empty), notes=tuple(notes))
    if not len(rows.numbers):
        reasons = "; ".join(notes) or "neither x, y nor distance"
        raise ValueError(
            f"nothing is measured in data: {reasons}. Say which columns are, by columns= or"
            " --columns x=HEADING y=HEADING"
        )
    bad = rows.sigma <= 0
    if bad.any():
        raise ValueError(f"{rows.where[int(np.argmax(bad))]}: sigma must be > 0")
    return rows
