"""Points in the plane, and CSV files of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...base.backend import finite_numbers
from ...base.checks import shown
from ...base.columns import read
from ...base.headings import Quantity
from ...base.tables import TextFile
from ...planning.samples import PLACES, refuse_unclear_lengths
from ..pieces import Arc, Line, Polynomial
from .draft import Draft, Move, listed

COLUMNS = {
    "x": PLACES["x"],
    "y": PLACES["y"],
    "t": replace(PLACES["t"], needed=False),
    "pen": Quantity(("pen", "pendown", "down"), {"1": 1.0}, needed=False),
}


def read_csv(
    file: TextFile,
    units: Mapping[str, str] | Sequence[str] = (),
    columns: Mapping[str, str] | Sequence[str] | None = (),
) -> Draft:
    """Return the Draft of a CSV file with columns x, y and perhaps pen (1 down, 0 up, on the way to
    the row's point).
    """
    table = read(file, COLUMNS, units, columns=columns)
    refuse_unclear_lengths(table)
    draft = Draft(table.name, notes=list(table.notes), origin=table.origin)
    if "t" in table.values:
        draft.notes.append("the times in it are not used: from_csv follows them")
    points = np.stack([table.values["x"], table.values["y"]], axis=-1)
    missing = np.flatnonzero(np.isnan(points).any(axis=1))
    if len(missing):
        raise table.error(missing[0], "x or y is missing")
    pen = table.values.get("pen", np.ones(len(points)))
    odd = np.flatnonzero(~np.isin(pen, (0.0, 1.0)))
    if len(odd):
        raise table.error(odd[0], f"pen must be 0 or 1, not {pen[odd[0]]:g}")
    draft.moves = _lines(points, pen, table.lines, draft)
    return draft


def read_points(points: object) -> Draft:
    """Return the Draft of points (n, 2) m, of strokes, a list of such, or of pieces."""
    draft = Draft("path")
    if isinstance(points, Line | Arc | Polynomial):
        points = [points]
    if (
        isinstance(points, Sequence)
        and points
        and all(isinstance(p, Line | Arc | Polynomial) for p in points)
    ):
        draft.moves = [Move(piece) for piece in points]
        return draft
    for k, stroke in enumerate(_strokes(points)):
        if len(stroke) < 2:
            raise ValueError(
                f"path: {'points' if k == 0 else f'stroke {k}'}: at least 2 points are needed, not"
                f" {len(stroke)}"
            )
        draft.moves += _lines(stroke, np.ones(len(stroke)), None, draft)
    return draft


def _strokes(points):
    try:
        strokes = list(points)
    except TypeError:
        raise TypeError(
            "path: points (n, 2), strokes of points, pieces or a file are needed, not"
            f" {shown(points)}"
        ) from None
    if not strokes:
        raise ValueError("path: no points")
    try:
        shape = np.shape(strokes[0])
    except ValueError:  # no array, nor points: refused below
        shape = ()
    if len(shape) == 2 or shape == (0,):
        return [_pairs(stroke, f"path: stroke {k}") for k, stroke in enumerate(strokes)]
    return [_pairs(points, "path: points")]


def _pairs(points, name):
    found = finite_numbers(points, name)
    if found.ndim != 2 or found.shape[1] != 2:
        raise ValueError(f"{name} must be (n, 2), not {found.shape}")
    return found


def _lines(points, pen, lines, draft):
    """Moves from point to point; points that repeat are passed over and said."""
    same = (points[1:] == points[:-1]).all(axis=1)
    if same.any():
        rows = np.flatnonzero(same) + 1
        where = listed(rows, "point") if lines is None else listed(lines[rows])
        draft.notes.append(f"points that repeat the one before are passed over: {len(rows)}{where}")
    return [
        Move(
            Line(tuple(points[k]), tuple(points[k + 1])),
            bool(pen[k + 1]),
            line=None if lines is None else int(lines[k + 1]),
        )
        for k in np.flatnonzero(~same)
    ]
