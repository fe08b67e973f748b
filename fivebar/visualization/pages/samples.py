"""What motions on a page have in common: samples that fit into the file, plots in readable units,
notes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..style import shown_unit
from .document import packed

if TYPE_CHECKING:
    from ..skeleton import Skeleton

NUMBERS = 400_000  # in one page at most: 4.3 MB of it
TIME = {"name": "time", "unit": "s", "scale": 1.0}


def samples_to_keep(samples: int, columns: int, everywhere: str) -> tuple[np.ndarray, list[str]]:
    """Return indices of the samples that fit in, evenly spaced, and a note where they are not all.

    columns: numbers for each sample; everywhere: where all samples are to be had.
    """
    most = max(2, NUMBERS // columns)
    if samples <= most:
        return np.arange(samples), []
    part = f"{most} of {samples} samples, evenly spaced"
    note = f"This page, its CSV included, holds {part}; {everywhere} has all."
    return np.linspace(0, samples - 1, most).round().astype(int), [note]


def parts(body: Skeleton) -> dict:
    """Return what the picture joins the points of a body by, and its colours."""
    return {
        "bars": [[*bar, colour] for bar, colour in zip(body.bars, body.colours)],
        "key": list(body.key.items()),
        "pins": body.joints,
        "grounded": body.feet,
        "actuated": body.actuated,
        "traced": body.traced,
    }


def subject(name: str, t: np.ndarray, body: Skeleton, columns: dict, **more) -> dict:
    """Return a motion on the page: times (n,) s, its body, columns {key: (n,)}, and what else."""
    # Other blocks are drawn as motors.
    blocks = [ends for *ends, joint in body.blocks if joint not in body.actuated]
    drawn = {*body.joints, *np.ravel(body.rails).tolist(), *np.ravel(blocks).tolist()}
    points = body.points[:, : int(max(drawn)) + 1]
    known = points[np.isfinite(points).all(axis=(1, 2))]
    if not len(known):
        raise ValueError("no sample has a pose that could be drawn: all are nan")
    # Columns, or a pair of numbers where a point stays.
    joints = [
        list(map(packed, points[:, k].T)) if moves else known[0, k].tolist()
        for k, moves in enumerate(np.ptp(known, axis=0).any(axis=1))
    ]
    return {
        "name": name,
        "t": packed(t),
        "x": None,
        "joints": joints,
        "names": [text.removeprefix("joint ") for text in body.names],
        **parts(body),
        "rails": body.rails,
        "blocks": blocks,
        "reference": None,
        "columns": {key: packed(values) for key, values in columns.items()},
        "marks": [],
    } | more


def panel(
    title: str,
    unit: str,
    curves: list,
    limits: Sequence[float] = (),
    step: bool = False,
    size: float = 0.0,
    degrees: bool = False,
) -> dict:
    """Return a plot: curves are (label, subject, key, values), in `unit`, shown in one in which
    they read well, angles in degrees if asked; size: of the mechanism, m.
    """
    *_, values = zip(*curves)
    scale, shown = shown_unit((*values, np.asarray(limits)), unit, size, degrees)
    names = "label", "subject", "key"
    return {
        "title": title,
        "unit": shown,
        "scale": scale,
        "limits": list(limits),
        "step": step,
        "curves": [dict(zip(names, curve)) for curve in curves],
    }


def gap_notes(whose: str, columns: dict) -> list[str]:
    """Return a note where samples are not finite, for columns {name: (n, ...)}."""
    words, count = [], 0
    for name, values in columns.items():
        count = len(values)
        hole = ~np.isfinite(values.reshape(count, -1)).all(axis=1)
        if hole.any():
            words.append(f"{name} in {hole.sum()}")
    whose = f" in {whose}" if whose else ""
    note = f"Gaps{whose} where values are not finite: {', '.join(words)} of {count} samples."
    return [note] if words else []
