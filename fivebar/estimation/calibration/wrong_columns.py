"""Columns that are wrong: the change after which the legs reach the points, or the predictions the
measurements.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...base.backend import wrap
from .fit import Task, misses, modes_found
from .measured_robot import FRAME, PLACE, READING, UNKNOWNS
from .rows import Rows
from .starts import SUSPECT, USUAL, begin, doubt, first, miss, reading, settled, wide_legs

DEG = np.pi / 180
FALLS = 0.15  # to this part of itself a misfit falls if a mistake is found
NOISE = 1e-4  # of a mean bar: what is missed by less is missed alike
MUCH_TURNED = 1.0  # rad
CRUDE = 0.15  # of a mean bar: missed by more before anything is fitted, a unit is wrong


@dataclass(frozen=True)
class Mistake:
    """A mistake in words, and the change of the rows that mends it."""

    words: str
    mend: Callable[[Rows], Rows] | None  # None: what is asked has to change, not the rows

    def __str__(self) -> str:
        return self.words


def _readings(change):
    return lambda rows: replace(rows, q=change(rows.q))


def _points(change):
    return lambda rows: replace(rows, points=change(rows.points))


# What people do to angles and to points; of one row or of all.
ANGLES = {
    "q1 in degrees": _readings(lambda q: q * (DEG, 1.0)),
    "q2 in degrees": _readings(lambda q: q * (1.0, DEG)),
    "q1 and q2 in degrees": _readings(lambda q: q * DEG),
    "q1 and q2 swapped": _readings(lambda q: q[:, ::-1].copy()),
    "q1 with the wrong sign": _readings(lambda q: q * (-1.0, 1.0)),
    "q2 with the wrong sign": _readings(lambda q: q * (1.0, -1.0)),
    "q1 and q2 with the wrong sign": _readings(lambda q: -q),
}


PLACES = {
    "x in mm": _points(lambda xi: xi * (1e-3, 1.0)),
    "y in mm": _points(lambda xi: xi * (1.0, 1e-3)),
    "x and y in mm": _points(lambda xi: xi * 1e-3),
    "x and y in cm": _points(lambda xi: xi * 1e-2),
    "x and y swapped": _points(lambda xi: xi[:, ::-1].copy()),
    "x with the wrong sign": _points(lambda xi: xi * (-1.0, 1.0)),
    "y with the wrong sign (downwards, as in pictures?)": _points(lambda xi: xi * (1.0, -1.0)),
}


# The same of columns whose heading or `units` says degrees or mm, and is wrong.
STATED = {
    ("q1",): ("q1 in rad, not in the unit that is stated", _readings(lambda q: q / (DEG, 1.0))),
    ("q2",): ("q2 in rad, not in the unit that is stated", _readings(lambda q: q / (1.0, DEG))),
    ("q1", "q2"): (
        "q1 and q2 in rad, not in the unit that is stated",
        _readings(lambda q: q / DEG),
    ),
    ("x", "y"): ("x and y in m, not in the unit that is stated", _points(lambda xi: xi * 1e3)),
}


def more_unknown(task: Task, before: np.ndarray) -> Mistake | None:
    """What would have to be unknown, too, for the legs to reach the points; None where nothing
    does.
    """
    offsets = READING[:2]
    for names in (offsets, FRAME[:2], FRAME[:3], (*offsets, *FRAME[:3]), FRAME):
        more = [PLACE[name] for name in names if name not in task.names]
        if not more:
            continue
        free = np.concatenate([task.free, more])
        wider = replace(
            task,
            free=free,
            size=np.concatenate([task.size, np.where(np.array(more) > 10, 1.0, task.bar)]),
        )
        p = begin(wider)
        if doubt(wider, p) < min(FALLS * doubt(task, before), 4 * SUSPECT * task.bar):
            notes = (
                f"(the bars miss the points by {mm(miss(wider, p))} then, by"
                f" {mm(miss(task, before))} as it is)"
            )
            added = ", ".join(UNKNOWNS[k] for k in more)
            return Mistake(
                f"{added} should be unknown, too: the points are in another frame, or zeros"
                f" elsewhere {notes}",
                None,
            )
    return None


def remade(task: Task, rows: Rows) -> Task:
    """The task with changed rows: of the same number, with the same weights."""
    size = task.size.copy()
    for k, name in enumerate(task.names):
        if name.startswith("ratio"):
            size[k] = 1 / (np.max(np.abs(rows.q[:, int(name[-1]) - 1])) or 1.0)
    return replace(task, rows=rows, size=size)


def mended(task: Task, found: list[Mistake]) -> Task:
    """The task with its rows mended, one mistake after the other."""
    for mistake in found:
        task = remade(task, mistake.mend(task.rows))
    return task


def crudely(task: Task) -> list[Mistake]:
    """Units of single coordinates and of distances, by what the start predicts: it is nearer than a
    wrong unit.
    """

    def off(rows):
        own = remade(task, rows)
        p = begin(own)
        assembly = modes_found(p, rows)[0]
        found = np.abs(misses(p, rows, np.where(assembly, assembly, -1), derive=False)[0])
        return float(np.median(np.where(np.isfinite(found), found, np.inf)))

    before = off(task.rows)
    if before < CRUDE * task.bar:
        return []
    tried = ANGLES | PLACES
    if (task.rows.to >= 0).any():
        tried["distance in mm"] = lambda rows: replace(rows, distance=rows.distance * 1e-3)
    after = {words: off(change(task.rows)) for words, change in tried.items()}
    best = min(after, key=lambda words: after[words])
    if after[best] > min(FALLS * before, CRUDE * task.bar):
        return []
    notes = (
        f"(misses, in the median, {mm(after[best])} then, {mm(before)} as it is, before anything is"
        " fitted)"
    )
    return [Mistake(f"column {best}? {notes}", tried[best])]


def single(task: Task) -> list:
    """Changes of columns by their words, in groups, and how many of each are worth a fit."""
    stated = dict(change for names, change in STATED.items() if task.rows.stated.issuperset(names))
    groups = (PLACES | ANGLES | stated, 20), (_counts(task), 6)
    return [
        ({(words,): (change,) for words, change in group.items()}, most) for group, most in groups
    ]


def double(task: Task) -> list:
    """One of angles and one of points at a time."""
    groups = (ANGLES, 16), (_counts(task), 4)
    return [
        ({(a, b): (one, other) for a, one in group.items() for b, other in PLACES.items()}, most)
        for group, most in groups
    ]


def columns(task: Task, before: np.ndarray, groups: list) -> list[Mistake]:
    """The change of columns after which the legs reach the points, if there is one; of several that
    which turns the
    frame and the joints least: a reflected frame is another, turned.
    """
    tasks, tried, promising = {}, {}, []
    for group, most in groups:
        tried |= group
        for words, changes in group.items():
            rows = task.rows
            for change in changes:
                rows = change(rows)
            tasks[words] = remade(task, rows)
        starts = {words: first(tasks[words]) for words in group}
        near = sorted(group, key=lambda words, starts=starts: doubt(tasks[words], starts[words]))[
            :most
        ]
        promising += [(words, starts[words]) for words in group if words in near]
    ends = {words: settled(tasks[words], start) for words, start in promising}
    doubts = {words: doubt(tasks[words], p) for words, p in ends.items()}
    least = min(doubts.values())
    if least > min(FALLS * doubt(task, before), 4 * SUSPECT * task.bar):
        return []
    limit = max(1.5 * least, NOISE * task.bar)
    turned = {words: _turned_by(task, ends[words]) for words in doubts if doubts[words] < limit}
    alike = sorted(turned, key=lambda words: round(turned[words], 1))
    best, others = alike[0], [" and ".join(words) for words in alike[1:3]]
    if turned[best] > MUCH_TURNED and doubt(task, begin(task)) < limit:
        return []  # motors and a frame may lie anywhere: no mistake
    after = miss(tasks[best], ends[best])
    notes = (
        f"(the bars miss the points by {mm(after)} then, by {mm(miss(task, before))} as it is;"
        " medians)"
    )
    notes += f", or {' or '.join(others)}, which looks the same" if others else ""
    return [Mistake(f"column {words}? {notes}", change) for words, change in zip(best, tried[best])]


def _turned_by(task, p):
    """How far offsets and frame are turned from their start, rad."""
    return float(np.abs(wrap(p - task.start))[[5, 6, 11]].sum())


def _counts(task):
    """Readings that are counts of an encoder: of a usual number a turn, or of what the points
    themselves tell.
    """
    found, wide = {}, np.flatnonzero(wide_legs(task, free=False))
    for turn in USUAL if len(wide) else ():
        scale = np.where(np.isin((0, 1), wide), 2 * np.pi / turn, 1.0)
        found[_in_counts(wide, f"{turn}")] = _readings(lambda q, scale=scale: q * scale)
    for leg in wide:
        for working in (-1, 1):
            ratio = reading(task.start, task.rows, leg, working)[0]
            if ratio and abs(ratio) < 0.5:
                scale = np.where(np.arange(2) == leg, ratio, 1.0)
                words = _in_counts([leg], f"about {2 * np.pi / ratio:.0f}")
                found[words] = _readings(lambda q, scale=scale: q * scale)
    return found


def _in_counts(legs, turn):
    names, ratios = ([f"{word}{leg + 1}" for leg in legs] for word in ("q", "ratio"))
    return (
        f"{' and '.join(names)} in counts, {turn} a turn, for which start and unknown have"
        f" {' and '.join(ratios)}"
    )


def mm(length: float) -> str:
    """A length in words."""
    return f"{1e3 * length:.3g} mm"
