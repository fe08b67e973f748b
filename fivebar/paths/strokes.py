"""Strokes of a path: its parts with the pen down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .curve import Path
from .pieces import Line, Piece


def outlines(path: Path, each: int = 33) -> list[np.ndarray]:
    """Return the strokes of a path as points (n, 2) m, `each` of them on a piece."""
    found = []
    for rows in runs(np.array(path.pen)):
        k, u = np.meshgrid(np.arange(rows.start, rows.stop), np.linspace(0, 1, each), indexing="ij")
        found.append(path.on(k, u * np.diff(path.knots)[k])[0].reshape(-1, 2))
    return found


def with_pen_time(path: Path, seconds: float) -> Path:
    """Return the path with a rest where the pen goes down or up, its two ends among them."""
    pen = np.array([False, *path.pen, False])
    dwells = dict(path.dwells)
    for s in path.knots[np.flatnonzero(pen[1:] != pen[:-1])].tolist():
        dwells[s] = dwells.get(s, 0.0) + seconds
    return replace(path, dwells=dwells)


def with_leads(path: Path, length: float) -> Path:
    """Return the strokes of a path, each with a straight run-up and run-out of this length, m, in
    the air: the pen goes down and up in motion. Straight lines lead from one to the next.
    """
    table: list[tuple[Piece, int]] = []
    drawn: list[bool] = []
    before = None
    dwells: dict[float, float] = {}
    for rows in runs(np.array(path.pen)):
        first, last = rows.start, rows.stop - 1
        start, along = path.drawn.on(first, 0.0)[:2]
        end, onwards = path.drawn.on(last, path.pieces[last].length)[:2]
        begin = start - length * along
        after = end + length * onwards
        ways = [Line(before, tuple(begin))] if before and before != tuple(begin) else []
        ways.append(Line(tuple(begin), tuple(start)))
        own = [(path.pieces[k], k) for k in range(first, rows.stop)]
        table += [*((way, first) for way in ways), *own, (Line(tuple(end), tuple(after)), last)]
        drawn += [False] * len(ways) + [True] * len(own) + [False]
        before = tuple(after)
        knots = path.knots[first + 1 : rows.stop].tolist()
        dwells |= {s: path.dwells[s] for s in knots if s in path.dwells}
    path = replace(path, dwells=dwells, rests_for_pen=False).rebuilt(table)
    feed = tuple(most if down else np.inf for most, down in zip(path.feed, drawn))
    return replace(path, pen=tuple(drawn), feed=feed)


def runs(down: np.ndarray) -> list[slice]:
    """Return the rows of each stroke, from whether the pen is down in each row (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(int)))
    return [slice(int(first), int(end)) for first, end in zip(edges[::2], edges[1::2])]


def cut(path: Path) -> list[Path]:
    """Return the strokes of a path, each as a path."""
    found = []
    for rows in runs(np.array(path.pen)):
        first = path.knots[rows.start]
        last = path.knots[rows.stop]
        dwells = {s - first: seconds for s, seconds in path.dwells.items() if first <= s <= last}
        found.append(
            Path(path.pieces[rows], dwells=dwells, feed=path.feed[rows], lines=path.lines[rows])
        )
    return found
