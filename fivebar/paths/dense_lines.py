"""Fit quintics to lines so short that their corners are those of a curve.

Where each corner is blended by itself, the curvature rises and falls on every line, though the rows
of a table follow a smooth curve. So one quintic spline is fitted to the rows of all lines between
two corners, by least squares. Where single rows of a span are too far off, as those of a hand that
trembles, their weight rises; any other span that is too far off is halved. Where neither helps, the
rows are parted at their sharpest turn, and both parts are fitted by themselves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import PPoly, make_lsq_spline

from ..base.backend import pairs
from ..base.progress import progress
from .curve import Path
from .fit import STEADY, quintic_as_long
from .pieces import Line, Piece, Polynomial

DEGREE = 5
FEWEST = 4  # lines under a span of the spline; fewer tell nothing of it
HELD = 1e3  # weight of the row at which a spline ends
SHORTEST = 4  # times the distance allowed: the way beside a corner
RARE = 0.15  # share of a span's lines: where fewer are too far off, weights rise
HEAVIER = 2.0  # by which the weight of a row that is too far off rises
HEAVIEST = 300.0  # where a row weighs as much, its span is halved
BENT = 2.0  # rad, the most by which a curve bends under a span, at the rate of its ends
FEET = 4  # steps of Newton to the foot of a row
BETWEEN = np.array([[0.25], [0.5], [0.75]])  # where the curve is compared with each line


def curves_of_lines(path: Path, within: float) -> tuple[Path, np.ndarray]:
    """Return the path with quintics for its short lines, and how far each piece is off (n,), m.

    Each row is within the distance `within` of the quintics, and they are of the lines. The rows at
    which a quintic meets any other piece stay.
    """
    n = len(path.pieces)
    rows = np.append(path.on(np.arange(n), 0.0)[0], [path.pieces[-1].end], axis=0) @ (1, 1j)
    corners = np.flatnonzero(_corners(path, rows, within)).tolist()
    todo = list(zip(corners, corners[1:]))
    table: list[tuple[Piece, float, int]] = []  # piece, how far it is off, the line it begins with
    replaced = 0
    with progress(total=n, desc="short lines", delay=2, leave=False) as bar:
        while todo:
            first, last = todo.pop()
            own = rows[first : last + 1]
            fits = _fitted(own, within) if last - first >= 2 * FEWEST else []
            if not fits and last - first >= 4 * FEWEST:
                sharpest = first + _sharpest(own, SHORTEST * within)
                todo += [(first, sharpest), (sharpest, last)]
                continue
            if fits:
                table += [(piece, off, first + k) for piece, off, k in fits]
                replaced += last - first
            else:
                table += [(path.pieces[k], 0.0, k) for k in range(first, last)]
            bar.update(last - first)
    if not replaced:
        return path, np.zeros(n)
    table.sort(key=lambda each: each[2])
    off = np.array([distance for _, distance, _ in table])
    note = (
        f"short lines that follow a curve: {replaced}, replaced by quintics:"
        f" {len(table) - n + replaced}, at most {off.max():.2g} m off"
    )
    path = replace(path, notes=(*path.notes, note))
    return path.rebuilt((piece, k) for piece, _, k in table), off


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


def _fitted(rows, within):
    """Return quintics along rows (n + 1,), each with how far it is off and the line it begins with;
    none where they do not keep the distance.
    """
    way = np.append(0.0, np.cumsum(np.abs(np.diff(rows))))
    xy = rows.view(float).reshape(-1, 2)
    weight = np.ones(len(rows))
    held = np.isin(np.arange(len(rows)), [0, len(rows) - 1]) * HELD
    knots = np.array([0, len(rows) - 1])
    while np.diff(knots).min() >= FEWEST:
        places = way[knots]
        clamped = np.pad(places, DEGREE, mode="edge")
        spline = make_lsq_spline(way, xy, clamped, DEGREE, weight + held)
        coefficients, length = _quintics(spline, places, rows)
        guess = np.interp(way, places, np.append(0.0, np.cumsum(length)))
        off = _off(rows, guess, coefficients, length)
        far = ~(off <= within)
        begins = knots[:-1]
        bad = np.logical_or.reduceat(far, begins)
        if not bad.any():
            largest = np.maximum.reduceat(off, begins).tolist()
            pieces = map(Polynomial, map(pairs, coefficients), length.tolist())
            return list(zip(pieces, largest, begins.tolist()))
        few = np.add.reduceat(far, begins) < RARE * np.diff(knots)
        few &= np.maximum.reduceat(weight[:-1], begins) < HEAVIEST
        rises = far & np.repeat(few, np.diff(knots))
        weight[:-1][rises] *= HEAVIER
        halved = bad & ~few
        weight[:-1][np.repeat(halved, np.diff(knots))] = 1.0
        middles = np.searchsorted(way, (places[:-1] + places[1:]) / 2)[halved]
        knots = np.union1d(knots, middles)
    return []


def _quintics(spline, knots, rows):
    """Return quintics (n, 6) between the knots of a spline, and their lengths (n,)."""
    z, dz, ddz = (spline(knots, order) @ (1, 1j) for order in range(3))
    z[[0, -1]] = rows[[0, -1]]
    tangent = dz / np.abs(dz)
    span = np.diff(knots)
    most = BENT / np.maximum(np.append(span, 0.0), np.append(0.0, span))
    bend = np.clip((dz.conj() * ddz).imag / np.abs(dz) ** 3, -most, most)
    side = np.stack([z, tangent, 1j * bend * tangent])
    return quintic_as_long((tuple(side[:, :-1]), tuple(side[:, 1:])), span)


def _off(rows, s, coefficients, length):
    """Return how far lines from row to row are off quintics, (n,), m; s: of the rows, a guess."""
    scaled = coefficients / length[:, None] ** np.arange(DEGREE + 1)
    curve = PPoly(scaled.T[::-1], np.append(0.0, np.cumsum(length)))
    rate = curve.derivative()
    for _ in range(FEET):
        s = s + ((rows - curve(s)) * rate(s).conj()).real / np.abs(rate(s)) ** 2
        s = np.clip(s, 0.0, curve.x[-1])
    steady = np.abs(np.abs(rate(s)) - 1) <= STEADY
    off = np.where(steady, np.abs(rows - curve(s)), np.inf)
    # Between the feet of a line's ends.
    line = np.diff(rows)
    away = curve(s[:-1] + BETWEEN * np.diff(s)) - rows[:-1]
    share = np.clip((away * line.conj()).real / np.abs(line) ** 2, 0, 1)
    return np.max([off[:-1], off[1:], *np.abs(away - share * line)], axis=0)


def _sharpest(rows, reach):
    """Return the row of the largest turn, by the directions over the way `reach`, m, beside it."""
    way = np.append(0.0, np.cumsum(np.abs(np.diff(rows))))
    k = np.arange(FEWEST, len(rows) - FEWEST)
    back = np.minimum(k - 1, np.searchsorted(way, way[k] - reach))
    on = np.maximum(k + 1, np.searchsorted(way, way[k] + reach))
    before = rows[k] - rows[back]
    after = rows[np.minimum(on, len(rows) - 1)] - rows[k]
    return int(k[np.abs(np.angle(after * before.conj())).argmax()])
