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
    """A cubic whose control points are in line, as the lines that it runs; None for any other."""
    p = curve.control - curve.control[0]
    size = np.abs(p).max()
    along = p[np.abs(p).argmax()] / size
    if np.abs((p * along.conjugate()).imag).max() > 1e-12 * size:
        return None
    x = (p * along.conjugate()).real
    # Where it turns back: roots of the derivative inside.
    slope = (
        np.array(
            [
                x[1] - x[0],
                2 * (x[0] - 2 * x[1] + x[2]),
                x[3] - x[0] + 3 * (x[1] - x[2]),
            ]
        )
        / size
    )
    t = np.roots(
        np.trim_zeros(
            slope[::-1] * (np.abs(slope[::-1]) > 1e-14),
            "f",
        )
    )
    t = np.sort(t[(np.abs(t.imag) < 1e-7) & (t.real > 1e-9) & (t.real < 1 - 1e-9)].real)
    at = [
        x[0] * (1 - s) ** 3 + 3 * x[1] * s * (1 - s) ** 2 + 3 * x[2] * s * s * (1 - s) + x[3] * s**3
        for s in t
    ]
    points = [
        curve.control[0],
        *(curve.control[0] + along * np.array(at)),
        curve.control[3],
    ]
    return [
        Line((a.real, a.imag), (b.real, b.imag))
        for a, b in zip(points, points[1:])
        if abs(b - a) > 1e-9 * size
    ]


def _round(ellipse):
    """An arc of a circle as an Arc, of a line as lines; None for any other."""
    a = ellipse.a
    b = ellipse.b
    c = ellipse.centre
    size = max(abs(a), abs(b))
    if abs((a * b.conjugate()).imag) <= 1e-12 * size**2:  # flat: it runs to and fro
        return _flat(ellipse, size)
    turned = b / a
    if abs(turned.real) > 1e-12 or abs(abs(turned.imag) - 1) > 1e-12:
        return None
    side = np.sign(turned.imag)
    start = float(np.angle(a))
    return [
        Arc(
            (c.real, c.imag),
            size,
            start + side * ellipse.t0,
            start + side * ellipse.t1,
        )
    ]


def _flat(ellipse, size):
    along = max((ellipse.a, ellipse.b), key=abs)
    along = along / abs(along)
    x = (ellipse.a * along.conjugate()).real
    y = (ellipse.b * along.conjugate()).real
    turn = np.arctan2(y, x)  # x cos t + y sin t is largest there
    low, high = sorted((ellipse.t0, ellipse.t1))
    cuts = turn + np.pi * np.arange(
        np.ceil((low - turn) / np.pi),
        np.floor((high - turn) / np.pi) + 1,
    )
    t = np.unique(np.concatenate([[low], cuts, [high]]))
    if ellipse.t0 > ellipse.t1:
        t = t[::-1]
    z = ellipse.centre + ellipse.a * np.cos(t) + ellipse.b * np.sin(t)
    return [
        Line((p.real, p.imag), (q.real, q.imag))
        for p, q in zip(z, z[1:])
        if abs(q - p) > 1e-9 * size
    ]
