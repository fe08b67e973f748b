"""What readers make of a file, move by move, and the path that becomes of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...base.checks import positive
from ...base.columns import Origin
from ..blend import blended
from ..curve import GAP, Path
from ..fit import Bezier, Ellipse, fitted
from ..pieces import Arc, Line, Piece
from ..placement import Placement

FINE = 1e-9  # m: what curves that are no arcs are kept within where no deviation is allowed
SHARE = 0.1  # of the deviation allowed, for them; blends have the rest
ROUND = 1e-10  # of a drawing's size: what is shorter is no move
EXACT = 1e-12  # of its size, to which a curve can be kept
LISTED = 8  # lines that a sentence names


class Move(NamedTuple):
    """Along a shape, with the pen down or up, at a speed asked for, m/s, from this line of the
    file.
    """

    shape: Piece | Bezier | Ellipse
    pen: bool = True
    feed: float = np.inf
    line: int | None = None


@dataclass
class Draft:
    """A drawing in metres, y up.

    dwells: (after how many moves, s); notes: what was passed over or converted; origin: whose
    points they are, where that is known.
    """

    name: str
    moves: list[Move] = field(default_factory=list)
    dwells: list[tuple[int, float]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    origin: Origin | None = None

    def finished(self, placement: Placement, deviation: float, curvature: bool) -> Path:
        """Return the path: placed, its curves fitted, its corners blended.

        Between strokes the pen travels straight. ValueError where nothing is drawn.
        """
        notes = list(self.notes)
        drawn = [k for k, move in enumerate(self.moves) if move.pen]
        first, last = (drawn[0], drawn[-1] + 1) if drawn else (0, 0)
        if drawn and last - first < len(self.moves):
            notes.append(
                "ways with the pen up before the first stroke and after the last are passed over"
            )
        by = complex(*placement.shift)
        turned = placement.turned
        moves = [
            move._replace(shape=move.shape.moved(by, turned)) for move in self.moves[first:last]
        ]
        extents = [_extent(move.shape) for move in moves]
        size = max([_width(moves), *extents])  # of whole circles the ends are one point
        empty = {k for k, extent in enumerate(extents) if extent <= ROUND * size}
        if empty:
            lines = listed(moves[k].line for k in empty)
            notes.append(f"{len(empty)} moves of no length passed over{lines}")
        if not any(move.pen for k, move in enumerate(moves) if k not in empty):
            reasons = "; ".join(notes)
            raise ValueError(f"{self.name}: nothing is drawn{f': {reasons}' if notes else ''}")
        positive(size, f"{self.name}: the drawing's size, m,")
        fine = max(FINE, SHARE * deviation)
        for move, extent in zip(moves, extents):
            if isinstance(move.shape, Bezier | Ellipse) and extent * EXACT > fine:
                where = f", line {move.line}" if move.line else ""
                raise ValueError(
                    f"{self.name}{where}: a curve {extent:.3g} m large cannot be kept within"
                    f" {fine:g} m"
                )
        parts = _parts([move.shape for move in moves], fine, empty)
        rows: list[tuple] = []  # piece, pen, feed, line
        s = 0.0
        starts = [s]  # of each move, and the end
        for move, pieces in zip(moves, parts):
            for piece in pieces:
                start = tuple(piece.start)
                end = tuple(rows[-1][0].end) if rows else start
                if math.dist(start, end) > GAP * size:
                    rows.append((Line(end, start), False, np.inf, move.line))
                    s += rows[-1][0].length
                rows.append((piece, move.pen, move.feed, move.line))
                s += piece.length
            starts.append(s)
        dwells: dict[float, float] = {}
        for k, seconds in self.dwells:
            if first <= k <= last:
                s = starts[k - first]
                dwells[s] = dwells.get(s, 0.0) + seconds
        path_pieces, pen, feed, lines = zip(*rows)
        rough = Path(path_pieces, pen, dwells, feed, tuple(notes), lines, origin=self.origin)
        return blended(rough, max(deviation - fine, 0.0), curvature)


def listed(lines: Iterable[int | None], word: str = "line") -> str:
    """Return (line 3), (lines 3, 4, 9, ...) or nothing."""
    known = sorted({line for line in lines if line is not None})
    words = ", ".join(map(str, known[:LISTED])) + ", ..." * (len(known) > LISTED)
    if known:
        return f" ({word}{'s' * (len(known) > 1)} {words})"
    return ""


def _places(shape):
    """Return points that say where a shape is, roughly."""
    if isinstance(shape, Bezier):
        return shape.control
    if isinstance(shape, Ellipse):
        return [shape.centre]
    return [complex(*shape.start), complex(*shape.end)]


def _extent(shape):
    """Return how long a shape is, roughly."""
    if isinstance(shape, Bezier):
        return float(np.abs(shape.control - shape.control[0]).max())
    if isinstance(shape, Ellipse):
        return max(abs(shape.a), abs(shape.b)) * abs(shape.t1 - shape.t0)
    return shape.length


def _width(moves):
    """Return the larger side, m, of the box around all moves, roughly."""
    if not moves:
        return 0.0
    places = np.concatenate([_places(move.shape) for move in moves])
    return float(max(np.ptp(places.real), np.ptp(places.imag)))


def _parts(shapes, within, empty):
    """Return for each shape the pieces of the path that it becomes."""
    parts = [[] for _ in shapes]
    curves = {Bezier: [], Ellipse: []}
    for k, shape in enumerate(shapes):
        if k in empty:
            continue
        exact = [shape]
        if isinstance(shape, Bezier):
            exact = _straight(shape)
        elif isinstance(shape, Ellipse):
            exact = _round(shape)
        if exact is None:
            curves[type(shape)].append(k)
        else:
            parts[k] = exact
    for rows in curves.values():
        for k, pieces in zip(rows, fitted([shapes[k] for k in rows], within)):
            parts[k] = pieces
    return parts


def _straight(curve):
    """Return a cubic whose control points follow each other on a line, as [Line]; else None."""
    chord = curve.control[-1] - curve.control[0]
    if chord == 0:
        return None
    along = (curve.control - curve.control[0]) / chord
    if np.abs(along.imag).max() > 1e-12 or (np.diff(along.real) < -1e-12).any():
        return None
    start = curve.control[0]
    end = curve.control[-1]
    return [Line((start.real, start.imag), (end.real, end.imag))]


def _round(ellipse):
    """Return the arc of a circle as [Arc], of any other ellipse None."""
    ratio = ellipse.b / ellipse.a
    if abs(ratio.real) > 1e-12 or abs(abs(ratio.imag) - 1) > 1e-12:
        return None
    side = np.sign(ratio.imag)
    start = float(np.angle(ellipse.a))
    centre = (ellipse.centre.real, ellipse.centre.imag)
    radius = max(abs(ellipse.a), abs(ellipse.b))
    return [Arc(centre, radius, start + side * ellipse.t0, start + side * ellipse.t1)]
