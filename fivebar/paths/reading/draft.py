"""What readers make of a file, move by move, and the path that becomes of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...base.checks import positive
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
    """A drawing in metres, y up. dwells: (after how many moves, s); said: what was passed over or
    converted.
    """

    name: str
    moves: list[Move] = field(default_factory=list)
    dwells: list[tuple[int, float]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def finished(
        self,
        placement: Placement,
        deviation: float,
        curvature: bool,
    ) -> Path:
        """The path: placed, its curves fitted, its corners blended; between strokes the pen travels
        straight.

        ValueError where nothing is drawn.
        """
        notes = list(self.notes)
        drawn = [k for k, move in enumerate(self.moves) if move.pen]
        if drawn:  # ways to the first stroke and from the last are no part of it
            first = drawn[0]
            last = drawn[-1] + 1
            if last - first < len(self.moves):
                notes.append(
                    "ways with the pen up before the first stroke and after the last are passed"
                    " over"
                )
            self = Draft(
                self.name,
                self.moves[first:last],
                [(k - first, t) for k, t in self.dwells],
            )
        by = complex(*placement.shift)
        turned = placement.turned
        moves = [move._replace(shape=move.shape.moved(by, turned)) for move in self.moves]
        ends = [_ends(move.shape) for move in moves]
        extents = [_extent(move.shape) for move in moves]
        if ends:
            size = float(np.ptp(np.array(ends).view(float).reshape(-1, 2), axis=0).max())
        else:
            size = 0.0
        size = max([size, *extents])  # of whole circles the ends are one point
        none = [k for k, extent in enumerate(extents) if extent <= ROUND * size]
        if none:
            lines = listed(moves[k].line for k in none)
            notes.append(
                f"{len(none)} {'move' if len(none) == 1 else 'moves'} of no length passed"
                f" over{lines}"
            )
        if len(none) == len(moves) or not any(
            move.pen for k, move in enumerate(moves) if k not in set(none)
        ):
            words = "; ".join(notes)
            raise ValueError(f"{self.name}: nothing is drawn{f': {words}' if words else ''}")
        positive(size, f"{self.name}: the drawing's size, m,")
        fine = max(FINE, SHARE * deviation)
        far = max(
            (k for k, m in enumerate(moves) if isinstance(m.shape, Bezier | Ellipse)),
            key=lambda k: _extent(moves[k].shape),
            default=None,
        )
        if far is not None and (wide := _extent(moves[far].shape)) * EXACT > fine:
            if moves[far].line:
                where = f", line {moves[far].line}"
            else:
                where = ""
            raise ValueError(
                f"{self.name}{where}: a curve {wide:.3g} m large cannot be kept within {fine:g} m"
            )
        parts = _parts(
            [move.shape for move in moves],
            fine,
            set(none),
        )
        pieces = []
        pen = []
        feed = []
        lines = []
        dwells = {}
        s = 0.0
        at = None
        rests = {}
        for k, seconds in self.dwells:
            rests[k] = rests.get(k, 0.0) + seconds
        for k, (move, own) in enumerate(zip(moves, parts)):
            if k in rests:
                dwells[s] = dwells.get(s, 0.0) + rests[k]
            for piece in own:
                start = complex(*piece.start)
                if at is not None and abs(start - at) > GAP * size:
                    travel = Line((at.real, at.imag), (start.real, start.imag))
                    pieces.append(travel)
                    pen.append(False)
                    feed.append(np.inf)
                    lines.append(move.line)
                    s += travel.length
                pieces.append(piece)
                pen.append(move.pen)
                feed.append(move.feed)
                lines.append(move.line)
                s += piece.length
                at = complex(*piece.end)
        if len(moves) in rests:
            dwells[s] = dwells.get(s, 0.0) + rests[len(moves)]
        rough = Path(
            tuple(pieces),
            tuple(pen),
            dwells,
            tuple(feed),
            tuple(notes),
            tuple(lines),
        )
        return blended(rough, max(deviation - fine, 0.0), curvature)


def listed(lines: Iterable[int | None]) -> str:
    """(line 3), (lines 3, 4, 9, ...) or nothing."""
    lines = sorted({line for line in lines if line is not None})
    words = ", ".join(map(str, lines[:LISTED])) + ", ..." * (len(lines) > LISTED)
    if lines:
        return f" ({'line' if len(lines) == 1 else 'lines'} {words})"
    return ""


def _ends(shape):
    if isinstance(shape, Bezier):
        return complex(shape.control[0]), complex(shape.control[-1])
    if isinstance(shape, Ellipse):
        return tuple(
            complex(shape.centre + shape.a * np.cos(t) + shape.b * np.sin(t))
            for t in (shape.t0, shape.t1)
        )
    return complex(*shape.start), complex(*shape.end)


def _extent(shape):
    """How long a shape is, roughly."""
    if isinstance(shape, Bezier):
        return float(np.abs(shape.control - shape.control[0]).max())
    if isinstance(shape, Ellipse):
        return max(abs(shape.a), abs(shape.b)) * abs(shape.t1 - shape.t0)
    return shape.length


def _parts(shapes, within, none):
    """For each shape the pieces of the path that it becomes."""
    found = [[] if k in none else [shape] for k, shape in enumerate(shapes)]
    for k, own in enumerate(found):
        if own and isinstance(own[0], Bezier):
            found[k] = _straight(own[0]) or own
        elif own and isinstance(own[0], Ellipse):
            found[k] = _round(own[0]) or own
    for kind in (Bezier, Ellipse):
        rows = [k for k, own in enumerate(found) if own and isinstance(own[0], kind)]
        for k, pieces in zip(rows, fitted([found[k][0] for k in rows], within)):
            found[k] = pieces
    return found


def _straight(curve):
    """Return a cubic whose control points follow each other on a line, as [Line]; else None."""
    chord = curve.control[-1] - curve.control[0]
    if chord == 0:
        return None
    along = (curve.control - curve.control[0]) / chord
    if np.abs(along.imag).max() > 1e-12 or (np.diff(along.real) < 0).any():
        return None
    start, end = curve.control[0], curve.control[-1]
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
