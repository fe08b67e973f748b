"""Fit quintics to lines so short that their corners are those of a curve.

Where each corner is blended by itself, the curvature rises and falls on every line, though the rows
of a table follow a smooth curve. So one quintic spline is fitted to the rows of all lines between
two corners, by least squares. Where single rows of a span are too far off, as those of a hand that
trembles, their weight rises; any other span that is too far off is halved. Where neither helps, the
rows have a sharp corner, and the spline ends there.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import numpy as np
from scipy.interpolate import make_lsq_spline

from ..base.backend import pairs
from ..base.progress import progress
from .curve import Path
from .fit import STEADY, quintic_as_long
from .pieces import Line, Piece, Polynomial

DEGREE = 5
FEWEST = 4  # lines under a span of the spline; fewer tell nothing of it
HELD = 1e3  # weight of the row at which a spline ends
SHORTEST = 4  # times the distance allowed: the way under a span, and beside a corner
HEAVIER = 2.0  # by which the weight of a row that is too far off rises
TRIES = 10  # of that on one span
RARE = 0.05  # share of a span's lines: where fewer are too far off, weights rise
FEET = 4  # steps of Newton to the foot of a row
BETWEEN = np.array([[0.25], [0.5], [0.75]])  # where the curve is compared with each line


def curves_of_lines(path: Path, within: float) -> tuple[Path, np.ndarray]:
    """Return the path with quintics for its short lines, and how far each piece is off (n,), m.

    Each row is within the distance `within` of the quintics, and they are of the lines. The rows at
    which a quintic meets any other piece stay.
    """
    n = len(path.pieces)
    rows = np.append(path.on(np.arange(n), 0.0)[0], [path.pieces[-1].end], axis=0) @ (1, 1j)
    cut = _corners(path, rows, within)
    knot = cut.copy()
    way = np.append(0.0, np.cumsum(np.abs(np.diff(rows))))
    weight = np.ones(n + 1)
    tries = np.zeros(n + 1, dtype=int)
    for _ in progress(count(), desc="short lines", unit=" fits", delay=2, leave=False):
        first = np.flatnonzero(knot)[:-1]
        last = np.flatnonzero(knot)[1:]
        ends = np.flatnonzero(cut)
        run = np.searchsorted(ends, first, side="right")
        long = np.diff(ends)[run - 1] >= 2 * FEWEST
        if not long.any():
            return path, np.zeros(n)
        counts = (last - first)[long]
        weight[ends] = HELD
        coefficients, length, off, lines = _fitted(rows, first[long], last[long], cut, weight)
        begins = np.cumsum(counts) - counts
        largest = np.maximum.reduceat(off, begins)
        share = np.add.reduceat((off > within).astype(float), begins) / counts
        bad = np.zeros(len(first), dtype=bool)
        few = bad.copy()
        bad[long] = ~(largest <= within)
        if not bad.any():
            break
        few[long] = share < RARE
        few &= bad & (tries[first] < TRIES)
        tries[first[few]] += 1
        far = lines[(off > within) & np.repeat(few[long], counts)]
        weight[far] *= HEAVIER
        weight[lines[np.repeat((bad & ~few)[long], counts)]] = 1.0
        bad &= ~few
        wide = last - first >= 2 * FEWEST
        wide &= way[last] - way[first] >= SHORTEST * within
        tries[first[bad]] = 0
        knot[_middles(way, first[bad & wide], last[bad & wide])] = True
        stuck = bad & ~wide
        if stuck.any():
            sharp = _sharpest(rows, way, ends, first[stuck], last[stuck], SHORTEST * within)
            cut[sharp] = True
            again = np.isin(run, run[stuck])[np.searchsorted(last, np.arange(n), side="right")]
            knot[:-1][again] = cut[:-1][again]  # those ends have spans that are too short
            weight[:-1][again] = 1.0
    note = (
        f"short lines that follow a curve: {sum(counts)}, replaced by quintics: {sum(long)}, at"
        f" most {largest.max():.2g} m off"
    )
    path = replace(path, notes=(*path.notes, note))
    return _with_quintics(path, first, last, long, zip(coefficients, length, largest))


def _with_quintics(path, first, last, long, fits):
    """Return the path with quintics in place of its long spans, and how far each piece is off."""
    table: list[tuple[Piece, float, int]] = []  # piece, how far it is off, the line it begins with
    for k, end, is_long in zip(first.tolist(), last.tolist(), long):
        if is_long:
            coefficients, length, off = next(fits)
            table.append((Polynomial(pairs(coefficients), float(length)), off, k))
        else:
            table += [(path.pieces[j], 0.0, j) for j in range(k, end)]
    pieces, off, begins = zip(*table)
    knots = np.append(0.0, np.cumsum([piece.length for piece in pieces])).tolist()
    dwells = {
        knots[np.searchsorted(begins, np.abs(path.knots - s).argmin())]: seconds
        for s, seconds in path.dwells.items()
    }
    pen, feed, lines = ([each[k] for k in begins] for each in (path.pen, path.feed, path.lines))
    path = replace(path, pieces=pieces, pen=pen, feed=feed, lines=lines, dwells=dwells)
    return path, np.array(off)


def _corners(path, rows, within):
    """Return at which rows (n + 1,) no curve goes on: it would be off its lines, or it is no line,
    or the pen, the speed or a dwell begins there.
    """
    line = np.diff(rows)
    size = np.array([piece.length for piece in path.pieces])
    is_line = np.array([isinstance(piece, Line) for piece in path.pieces])
    longer = np.maximum(size[1:], size[:-1])
    with np.errstate(all="ignore"):
        turn = np.abs(np.angle(line[1:] / line[:-1]))
    sagitta = turn * longer**2 / (size[1:] + size[:-1]) / 4  # of an arc with these turns
    goes_on = ((sagitta <= within) | (longer <= SHORTEST * within)) & is_line[1:] & is_line[:-1]
    goes_on &= (np.diff(path.pen) == 0) & ~np.isin(path.knots[1:-1], list(path.dwells))
    goes_on &= np.array(path.feed[1:]) == path.feed[:-1]
    return np.concatenate([[True], ~goes_on, [True]])


def _fitted(rows, first, last, cut, weight):
    """Return the quintics (n, 6) of spans from row to row, their lengths (n,), how far they are off
    each line (k,) and the rows at which these lines begin.
    """
    begins = cut[first]
    ends = cut[last]
    counts = last - first
    line = np.concatenate([np.arange(a, b) for a, b in zip(first, last)])
    # The rows of each run from corner to corner: one more than it has lines.
    at = np.cumsum(counts)
    row = np.insert(line, at[ends], last[ends])
    is_end = np.insert(np.zeros(len(line), dtype=bool), at[ends], True)
    size = np.abs(np.diff(rows)[line])
    way = np.append(0.0, np.cumsum(size))
    starts = way[at - counts]
    stops = np.nextafter(way[at], 0.0)  # where a spline ends, another may begin
    x = np.insert(way[:-1], at[ends], stops[ends])
    knots = np.repeat(starts, np.where(begins, DEGREE + 1, 1))
    knots = np.append(knots, np.full(DEGREE + 1, way[-1]))
    spline = make_lsq_spline(x, rows[row].view(float).reshape(-1, 2), knots, DEGREE, weight[row])
    with np.errstate(all="ignore"):
        sides = []
        for places, held, corner in ((starts, begins, first), (stops, ends, last)):
            z, dz, ddz = (spline(places, order) @ (1, 1j) for order in range(3))
            tangent = dz / np.abs(dz)
            bend = (dz.conj() * ddz).imag / np.abs(dz) ** 3
            sides.append((np.where(held, rows[corner], z), tangent, 1j * bend * tangent))
        coefficients, length = quintic_as_long(tuple(sides), way[at] - way[at - counts])
        # Span and share of it: at first by the way along the lines.
        span = np.repeat(np.arange(len(first)), counts + ends)
        low = np.maximum.accumulate(np.where(begins, np.arange(len(first)), 0))[span]
        high = np.flatnonzero(ends)[np.searchsorted(np.flatnonzero(ends), span)]
        place = span + (x - starts[span]) / (stops - starts)[span]

        def along(place, low, high):
            k = np.clip(place.astype(int), low, high)
            powers = (place - k)[..., None] ** np.arange(6)
            z = (coefficients[k] * powers).sum(axis=-1)
            rates = coefficients[k, 1:] * np.arange(1, 6) * powers[..., :-1]
            return z, rates.sum(axis=-1), length[k]

        for _ in range(FEET):
            z, dz, _ = along(place, low, high)
            step = ((rows[row] - z) * dz.conj()).real / np.abs(dz) ** 2
            place = np.clip(np.nan_to_num(place + step), low, high + 1)
        z, dz, own = along(place, low, high)
        off = np.abs(rows[row] - z)
        off = np.where(np.abs(np.abs(dz) - own) <= STEADY * own, off, np.inf)
        # Between the feet of a line's ends.
        since = np.flatnonzero(~is_end)
        between = place[since] + BETWEEN * (place[since + 1] - place[since])
        away = along(between, low[since], high[since])[0] - rows[line]
        chord = np.diff(rows)[line]
        share = np.clip((away * chord.conj()).real / size**2, 0, 1)
        beside = np.abs(away - share * chord).max(axis=0)
    return coefficients, length, np.max([off[since], off[since + 1], beside], axis=0), line


def _middles(way, first, last):
    """Return the rows (n,) nearest the middles of the ways from row to row."""
    middle = np.searchsorted(way, (way[first] + way[last]) / 2)
    return np.clip(middle, first + FEWEST, last - FEWEST)


def _sharpest(rows, way, ends, first, last, reach):
    """Return the row of the largest turn in or beside each span (n,), inside its run, by the
    directions over at least the way `reach`, m.
    """
    k = np.arange(len(rows))
    run = np.searchsorted(ends, k, side="right")
    low = ends[run - 1]
    high = ends[np.minimum(run, len(ends) - 1)]
    back = np.minimum(k - FEWEST, np.searchsorted(way, way - reach))
    on = np.maximum(k + FEWEST, np.searchsorted(way, way + reach))
    before = rows - rows[np.maximum(back, low)]
    after = rows[np.minimum(on, high)] - rows
    turn = np.where((k > low) & (k < high), np.abs(np.angle(after * before.conj())), -1.0)
    found = []
    for a, b in zip(np.maximum(first - FEWEST, low[first]), last + FEWEST):
        b = min(b, high[a])
        found.append(a + int(turn[a : b + 1].argmax()))
    return found
