"""Strokes of a path: its parts with the pen down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .curve import Path


def outlines(path: Path, each: int = 33) -> list[np.ndarray]:
    """Return the strokes of a path as points (n, 2) m, `each` of them on a piece."""
    found = []
    for rows in runs(np.array(path.pen)):
        k, u = np.meshgrid(
            np.arange(rows.start, rows.stop),
            np.linspace(0, 1, each),
            indexing="ij",
        )
        found.append(
            path.on(k, u * np.diff(path.knots)[k])[0].reshape(
                -1,
                2,
            )
        )
    return found


def with_pen_time(path: Path, seconds: float) -> Path:
    """Return the path with a rest where the pen goes down or up, its two ends among them."""
    pen = np.array([False, *path.pen, False])
    dwells = dict(path.dwells)
    for s in path.knots[np.flatnonzero(pen[1:] != pen[:-1])].tolist():
        dwells[s] = dwells.get(s, 0.0) + seconds
    return replace(path, dwells=dwells)


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
            Path(
                path.pieces[rows],
                dwells=dwells,
                feed=path.feed[rows],
                lines=path.lines[rows],
            )
        )
    return found
