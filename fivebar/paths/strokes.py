"""The strokes of a path, of a motion along it, and of what was drawn: where the pen is down."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .curve import Path

if TYPE_CHECKING:
    from .timing.timed_path import TimedPath


def outlines(path: Path, each: int = 33) -> list[np.ndarray]:
    """The strokes of a path as points (n, 2) m, so many of each piece."""
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


def pen_down(motion: TimedPath, t: np.ndarray) -> np.ndarray:
    """Whether the pen is down at times t (n,) of a motion along a path."""
    return np.array(motion.path.pen)[motion.piece[motion.along(t)[0]]]


def runs(down: np.ndarray) -> list[slice]:
    """The rows of each stroke, of rows (n,) in which the pen is down or up."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(int)))
    return [slice(int(first), int(end)) for first, end in zip(edges[::2], edges[1::2])]


def cut(path: Path) -> list[Path]:
    """The strokes of a path, each a path of its own."""
    found = []
    for rows in runs(np.array(path.pen)):
        first = path.knots[rows.start]
        last = path.knots[rows.stop]
        dwells = {s - first: seconds for s, seconds in path.dwells.items() if first <= s <= last}
        found.append(
            Path(
                path.pieces[rows],
                None,
                dwells,
                path.feed[rows],
                (),
                path.lines[rows],
            )
        )
    return found
