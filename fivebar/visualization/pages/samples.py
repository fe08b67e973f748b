"""What motions on a page have in common: samples that fit into the file, plots in readable units,
notes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..style import of_unit, readable
from .document import packed

if TYPE_CHECKING:
    from ..skeleton import Skeleton

NUMBERS = 400_000  # in one page at most: 4.3 MB of it


def kept(samples: int, columns: int, everywhere: str) -> tuple[np.ndarray, list[str]]:
    """Indices of the samples that fit in, evenly spaced, and a note where they are not all: (k,),
    list of str.

    columns: numbers for each sample; everywhere: where all samples are to be had.
    """
    most = max(2, NUMBERS // columns)
    if samples <= most:
        return np.arange(samples), []
    note = (
        f"This page, its CSV included, holds {most} of {samples} samples, evenly spaced;"
        f" {everywhere} has all."
    )
    return np.linspace(0, samples - 1, most).round().astype(int), [note]


def parts(body: Skeleton) -> dict:
    """What the picture joins the points of a body by, and its colours."""
    return {
        "bars": [[*bar, colour] for bar, colour in zip(body.bars, body.colours)],
        "key": list(body.key.items()),
        "pins": body.joints,
        "grounded": body.feet,
        "actuated": body.actuated,
        "traced": body.traced,
    }


def subject(name: str, t: np.ndarray, body: Skeleton, columns: dict, **more) -> dict:
    """A motion on the page: times (n,) s, its body in these poses, columns {key: (n,)}, and what
    else it has.
    """
    blocks = [
        ends for *ends, joint in body.blocks if joint not in body.actuated
    ]  # others are drawn as motors
    drawn = max(0, *body.joints, *(point for pair in (*body.rails, *blocks) for point in pair)) + 1
    return {
        "name": name,
        "t": packed(t),
        "x": None,
        "joints": _joints(body.points[:, :drawn]),
        "names": [text.removeprefix("joint ") for text in body.names],
        **parts(body),
        "rails": body.rails,
        "blocks": blocks,
        "reference": None,
        "columns": {key: packed(values) for key, values in columns.items()},
        "marks": [],
    } | more


def _joints(points):
    """Points (n, k, 2), m, for the picture: columns, or a pair of numbers where a point stays."""
    finite = points[np.isfinite(points).all(axis=(1, 2))]
    if not len(finite):
        raise ValueError("no sample has a pose that could be drawn: all are nan")
    return [
        (
            finite[0, k].tolist()
            if not np.ptp(finite[:, k], axis=0).any()
            else [packed(x) for x in points[:, k].T]
        )
        for k in range(points.shape[1])
    ]


def panel(
    title: str, unit: str, curves: list, limits: Sequence[float] = (), step: bool = False
) -> dict:
    """A plot: curves are (label, subject, key, values), in `unit`, shown in one in which they read
    well.
    """
    finite = [np.abs(values[np.isfinite(values)]) for *_, values in curves]
    largest = max((values.max() for values in finite if len(values)), default=0.0)
    shown = _shown_unit(unit, max(largest, *map(abs, limits), 0.0) if limits else largest)
    return {
        "title": title,
        "unit": of_unit(shown[1]),
        "scale": shown[0],
        "limits": list(limits),
        "step": step,
        "curves": [
            {"label": label, "subject": subject, "key": key} for label, subject, key, _ in curves
        ],
    }


def _shown_unit(unit, largest):
    """Factor and name: a number without unit stays as it is, and so does an angle of a hundredth
    and more.
    """
    return (
        (1.0, unit)
        if not unit or (unit.startswith("rad") and largest >= 0.01)
        else readable(largest, unit)
    )


def gaps(whose: str, columns: dict) -> list[str]:
    """A note where samples are not finite, for columns {name: (n, ...)}."""
    holes = {
        name: ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        for name, values in columns.items()
    }
    holes = {name: hole for name, hole in holes.items() if hole.any()}
    if not holes:
        return []
    listed = ", ".join(f"{name} in {hole.sum()}" for name, hole in holes.items())
    count = len(next(iter(holes.values())))
    return [f"Not finite, so gaps{' in ' + whose if whose else ''}: {listed} of {count} samples."]
