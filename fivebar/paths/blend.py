"""Blend corners by quintics with the points, tangents and curvatures of both sides; of short lines
that follow a curve, fit the curve.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.backend import pairs
from ..base.checks import flag, not_negative
from .curve import SMOOTH, Path
from .dense_lines import curves_of_lines
from .fit import quintic_as_long
from .pieces import Piece, Polynomial

ALONG = np.linspace(0, 1, 17)
BACK = -0.9995  # cosine of a turn, from which on it is a turning back: the motion rests there
POWERS = 1.0, 1.0, *[0.5] * 10  # of a distance off: its blend is so much longer or shorter
NEAR = 0.98  # of the deviation, which blends use
OF_LINES = 0.9  # of the deviation: within which curves take the place of short lines


def blended(path: Path, deviation: float, curvature: bool = False) -> Path:
    """Return the path with its corners blended, and curves for short lines, within `deviation`, m.

    Corners where the path turns back, where the pen changes and where it dwells stay as they are.
    curvature: blend also where only the curvature jumps.
    """
    deviation = not_negative(deviation, "blended: deviation")
    curvature = flag(curvature, "blended: curvature")
    if path.tool is not None:
        return replace(blended(path.drawn, deviation, curvature), tool=path.tool)
    if not deviation:
        return path
    path, used = curves_of_lines(path, OF_LINES * deviation)
    corner, kept = _corners(path, curvature)
    if kept:
        places = "1 place" if kept == 1 else f"{kept} places"
        words = f"at {places} it turns back, which is no corner to round: a motion rests there"
        path = replace(path, notes=(*path.notes, words))
    if not len(corner):
        return path
    lengths = np.array([piece.length for piece in path.pieces])
    cut = np.zeros((2, len(lengths)))  # from the start and from the end of each piece
    is_corner = np.zeros(len(lengths) + 1, dtype=bool)
    is_corner[corner] = True
    room = lengths * np.where(is_corner[:-1] & is_corner[1:], 0.5, 0.95)
    most = np.minimum(room[corner - 1], room[corner])
    unused = deviation - np.maximum(used[corner - 1], used[corner])
    reach = _reaches(path, corner, lengths, most, 0.999 * unused)
    corner = corner[reach > 0]
    reach = reach[reach > 0]
    cut[1, corner - 1] = cut[0, corner] = reach
    coefficients, own = _blends(path, corner, lengths, reach)
    blends = {
        k: Polynomial(pairs(c), float(h)) for k, c, h in zip(corner.tolist(), coefficients, own)
    }
    rows: list[tuple[Piece, int]] = []
    feed = []
    for k, piece in enumerate(path.pieces):
        if k in blends:
            rows.append((blends[k], k))
            feed.append(min(path.feed[k - 1], path.feed[k]))
        first = cut[0, k]
        last = lengths[k] - cut[1, k]
        if last - first > 1e-9 * lengths[k]:
            rows.append((piece if last - first == lengths[k] else piece.part(first, last), k))
            feed.append(path.feed[k])
    return replace(path.rebuilt(rows), feed=tuple(feed))


def _corners(path, curvature):
    """Return the pieces (n,) at whose start to blend, and how many other corners turn back."""
    n = len(path.pieces)
    before = np.arange(n - 1)
    after = np.arange(1, n)
    _, d0, c0, _ = path.on(before, [piece.length for piece in path.pieces[:-1]])
    _, d1, c1, _ = path.on(after, 0.0)
    jump = np.linalg.norm(d1 - d0, axis=-1)
    jumps = jump > SMOOTH
    size0 = np.linalg.norm(d0, axis=-1)
    size1 = np.linalg.norm(d1, axis=-1)
    cosine = (d0 * d1).sum(axis=-1) / (size0 * size1)
    if curvature:
        change = np.linalg.norm(c1 - c0, axis=-1)
        bend0 = np.linalg.norm(c0, axis=-1)
        bend1 = np.linalg.norm(c1, axis=-1)
        jumps |= change > SMOOTH * (bend0 + bend1 + 1 / path.length)
    dwelt = np.isin(path.knots[1:-1], list(path.dwells))
    free = jumps & (np.diff(path.pen) == 0) & ~dwelt
    return after[free & (cosine > BACK)], int((free & (cosine <= BACK)).sum())


def _reaches(path, corner, lengths, most, deviation):
    """Return how far from each corner, m, its blend begins: as far as the deviation allows."""
    best = np.zeros(len(corner))
    reach = np.minimum(most, 4 * deviation)
    left = np.arange(len(corner))
    for power in POWERS:
        off = _off(path, corner[left], lengths, reach[left])
        most_off = deviation[left]
        kept = off <= most_off
        best[left[kept]] = np.maximum(best, reach)[left[kept]]
        rough = ~kept | (off < NEAR * most_off) & (reach[left] < most[left])
        left = left[rough]
        step = (1 + NEAR) / 2 * most_off / np.maximum(off, most_off / 100)
        reach[left] = np.minimum(reach[left] * step[rough] ** power, most[left])
    return best


def _blends(path, corner, lengths, reach):
    """Return the coefficients (n, 6), complex, of the quintics, and their lengths (n,)."""
    leaves = lengths[corner - 1] - reach
    before = np.array(path.on(corner - 1, leaves)[:3])
    after = np.array(path.on(corner, reach)[:3])
    ends = tuple(before @ (1, 1j)), tuple(after @ (1, 1j))
    return quintic_as_long(ends, 2 * reach)


def _off(path, corner, lengths, reach):
    """Return the largest distances (n,) between blends and what they replace."""
    found = np.empty(len(corner))
    powers = ALONG[:, None] ** np.arange(6)
    for first in range(0, len(corner), 512):
        part = slice(first, first + 512)
        own = corner[part]
        far = reach[part, None]
        blend = _blends(path, own, lengths, reach[part])[0] @ powers.T
        before = path.on(own[:, None] - 1, lengths[own - 1][:, None] - far * (1 - ALONG))[0]
        after = path.on(own[:, None], far * ALONG)[0]
        sides = np.concatenate([before, after[:, 1:]], axis=1) @ (1, 1j)
        found[part] = np.maximum(_to_polyline(blend, sides), _to_polyline(sides, blend))
    return found


def _to_polyline(points, line):
    """Return the largest distance (n,) of points (n, a) to polylines (n, b)."""
    chord = np.diff(line)[:, None, :]
    away = points[:, :, None] - line[:, None, :-1]
    square = np.abs(chord) ** 2
    along = np.clip((away * chord.conj()).real / np.where(square > 0, square, 1.0), 0, 1)
    return np.abs(away - along * chord).min(axis=2).max(axis=1)
