"""What is wrong with data, found by trying: the change of a column or a row after which everything fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .._backend import wrap
from .fit import Task
from .machine import FRAME, PLACE, UNKNOWNS, bars_off, seen, sines_at
from .rows import Rows
from .starts import SUSPECT, USUAL, begin, doubt, first, miss, reading, settled, wide_legs

DEG = np.pi / 180
FALLS = 0.15  # to this part of itself a misfit falls if a mistake is found
NOISE = 1e-4  # of a mean bar: what is missed by less is missed alike
MUCH_TURNED = 1.0  # rad
FEW = 8  # rows of which none is alone
SURE = 0.05  # sine beyond which a mode is certain


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
    ("q1", "q2"): ("q1 and q2 in rad, not in the unit that is stated", _readings(lambda q: q / DEG)),
    ("x", "y"): ("x and y in m, not in the unit that is stated", _points(lambda xi: xi * 1e3)),
}


def mistakes(task: Task, sigma: float) -> tuple[list[Mistake], Task, np.ndarray]:
    """The mistakes found, the task with its rows mended, and values (13,) to begin with.

    sigma: m, typical, 0 where it is not known. Columns first, then rows, then the modes that rows note.
    """
    if task.rows.whole.sum() < 4:
        return [], task, begin(task)
    p, found = begin(task, far=False), []
    for tried in (_single, None, _double):  # offsets far from the start are likelier than two mistakes
        if doubt(task, p) < max(SUSPECT * task.bar, 5 * sigma):
            break
        if tried is None:
            p = begin(task)
        elif found := _columns(task, p, tried(task)):
            for mistake in found:
                task = remade(task, mistake.mend(task.rows))
            p = begin(task)
    if doubt(task, p) > max(SUSPECT * task.bar, 5 * sigma) and (more := _more_unknown(task, p)):
        return [*found, more], task, p
    rows_found, p = _rows(task, p, sigma)
    for mistake in rows_found:
        task = remade(task, mistake.mend(task.rows))
    noted = _modes(task, p, sigma)
    for mistake in noted:
        task = remade(task, mistake.mend(task.rows))
    return [*found, *rows_found, *noted], task, p


def _more_unknown(task, before):
    """What would have to be unknown, too, for the legs to reach the points; None where nothing does."""
    for names in (
        ("offset1", "offset2"),
        ("x0", "y0"),
        ("x0", "y0", "turn"),
        ("offset1", "offset2", *FRAME[:3]),
        FRAME,
    ):
        more = [PLACE[name] for name in names if name not in task.names]
        if not more:
            continue
        free = np.concatenate([task.free, more])
        wider = replace(task, free=free, size=np.concatenate([task.size, np.where(np.array(more) > 10, 1.0, task.bar)]))
        p = begin(wider)
        if doubt(wider, p) < min(FALLS * doubt(task, before), 4 * SUSPECT * task.bar):
            said = f"(the bars miss the points by {_mm(miss(wider, p))} then, by {_mm(miss(task, before))} as it is)"
            added = ", ".join(UNKNOWNS[k] for k in more)
            return Mistake(
                f"{added} should be unknown, too: the points are in another frame, or zeros elsewhere {said}", None
            )
    return None


def lone_rows(task: Task, p: np.ndarray) -> list[str]:
    """Rows whose points are in other modes than almost all, where no modes are noted: right perhaps, but to be looked
    at."""
    rows = task.rows
    whole = np.flatnonzero(rows.whole)
    if len(whole) < FEW or rows.working.any() or rows.assembly.any():
        return []
    modes = -np.sign(np.nan_to_num(sines_at(p, rows.q[whole], rows.points[whole]))).astype(int)
    kinds, kind, count = np.unique(modes, axis=0, return_inverse=True, return_counts=True)
    usual = int(np.argmax(count))
    if len(whole) - count[usual] > 0.15 * len(whole):
        return []
    others = _modes_in_words(kinds[usual])
    return [
        f"{rows.where[whole[k]]} is in {_modes_in_words(modes[k])}, almost all others in {others}: no modes are noted"
        for k in np.flatnonzero(kind.ravel() != usual)
    ]


def remade(task: Task, rows: Rows) -> Task:
    """The task with changed rows: of the same number, with the same weights."""
    return replace(task, rows=rows, size=_sizes(task, rows))


def _sizes(task, rows):
    size = task.size.copy()
    for k, name in enumerate(task.names):
        if name.startswith("ratio"):
            size[k] = 1 / (np.max(np.abs(rows.q[:, int(name[-1]) - 1])) or 1.0)
    return size


def _single(task):
    """Changes of columns by their words, in groups, and how many of each are worth a fit."""
    stated = dict(change for names, change in STATED.items() if task.rows.stated.issuperset(names))
    groups = (PLACES | ANGLES | stated, 20), (_counts(task), 6)
    return [({(words,): (change,) for words, change in group.items()}, most) for group, most in groups]


def _double(task):
    """One of angles and one of points at a time."""
    groups = (ANGLES, 16), (_counts(task), 4)
    return [
        ({(a, b): (one, other) for a, one in group.items() for b, other in PLACES.items()}, most)
        for group, most in groups
    ]


def _columns(task, before, groups):
    """The change of columns after which the legs reach the points, if there is one; of several that which turns the
    frame and the joints least: a reflected frame is another, turned."""
    tasks, tried, promising = {}, {}, []
    for group, most in groups:
        tried |= group
        for words, changes in group.items():
            rows = task.rows
            for change in changes:
                rows = change(rows)
            tasks[words] = remade(task, rows)
        starts = {words: first(tasks[words]) for words in group}
        near = sorted(group, key=lambda words, starts=starts: doubt(tasks[words], starts[words]))[:most]
        promising += [(words, starts[words]) for words in group if words in near]
    ends = {words: settled(tasks[words], start, 30) for words, start in promising}
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
    said = f"(the bars miss the points by {_mm(after)} then, by {_mm(miss(task, before))} as it is; medians)"
    said += f", or {' or '.join(others)}, which looks the same" if others else ""
    return [Mistake(f"column {words}? {said}", change) for words, change in zip(best, tried[best])]


def _turned_by(task, p):
    """How far offsets and frame are turned from their start, rad."""
    return float(np.abs(wrap(p - task.start))[[5, 6, 11]].sum())


def _counts(task):
    """Readings that are counts of an encoder: of a usual number a turn, or of what the points themselves tell."""
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
    return f"{' and '.join(names)} in counts, {turn} a turn, for which start and unknown have {' and '.join(ratios)}"


def _rows(task, p, sigma):
    """Rows that fit after a change of themselves, and values that the rows off the rest have no part in."""
    rows = task.rows
    least = max(1e-9 * task.bar, sigma)
    for _ in range(3):
        off = np.full(len(rows), np.nan)
        off[rows.whole] = np.hypot(*bars_off(p, rows.q[rows.whole], rows.points[rows.whole])[0].T)
        scale = max(1.4826 * np.nanmedian(off), least)
        bad = np.nan_to_num(off) > max(8 * scale, 1e-3 * task.bar)
        if not bad.any() or (rows.whole & ~bad).sum() < max(4, 0.6 * rows.whole.sum()):
            break
        p = begin(replace(task, rows=rows.without(bad), start=p))
    found = []
    for k in np.flatnonzero(bad):
        own = rows.without(np.arange(len(rows)) != k)
        after = {}
        for words, change in {**ANGLES, **PLACES}.items():
            changed = change(own)
            after[words] = np.hypot(*bars_off(p, changed.q, changed.points)[0][0])
        best = min(after, key=lambda words: after[words])
        if after[best] < max(5 * scale, 2e-4 * task.bar) and after[best] < FALLS * off[k]:
            change = {**ANGLES, **PLACES}[best]
            said = f"(misses the point by {_mm(after[best])} then, by {_mm(off[k])} as it is)"
            found.append(Mistake(f"{rows.where[k]}: {best}? {said}", _in_row(k, change)))
    return found, p


def _in_row(k, change):
    def mend(rows):
        changed, here = change(rows), np.arange(len(rows)) == k
        parts = {n: np.where(here[:, None], getattr(changed, n), getattr(rows, n)) for n in ("q", "points")}
        return replace(rows, **parts)

    return mend


def _modes(task, p, sigma):
    """Rows whose modes are others than they note; of a column that is wrong in most rows, the column."""
    rows = task.rows
    off, sines = np.full(len(rows), np.inf), sines_at(p, rows.q, rows.points)
    off[rows.whole] = np.hypot(*bars_off(p, rows.q[rows.whole], rows.points[rows.whole])[0].T)
    fits = off < max(20 * sigma, 0.02 * task.bar)
    real = -np.sign(np.nan_to_num(sines)).astype(np.int8)
    sure = fits[:, None] & (np.abs(np.nan_to_num(sines)) > np.maximum(SURE, 5 * off / task.bar)[:, None])
    noted = np.column_stack([rows.working, rows.assembly])
    wrong = sure & (noted != 0) & (noted != real)
    found = []
    for column, name in enumerate(("working1", "working2", "assembly")):
        checked = sure[:, column] & (noted[:, column] != 0)
        if checked.sum() > 3 and wrong[:, column].mean() > 0.6:
            words = f"column {name} with the wrong sign in {wrong[:, column].sum()} of {checked.sum()} rows"
            found.append(Mistake(words, _with_modes(rows.where, real, sure, column)))
            wrong[:, column] = False
    for k in np.flatnonzero(wrong.any(axis=1)):
        says = _modes_in_words(noted[k])
        words = f"{rows.where[k]}: noted {says}, but its angles and its point are {_modes_in_words(real[k], noted[k])}"
        found.append(Mistake(words, _with_modes((rows.where[k],), real, sure, slice(None))))
    return found + _half_measured(task, p, sigma)


def _half_measured(task, p, sigma):
    """The same of rows with one coordinate, where the other assembly mode fits and the noted one does not."""
    rows = task.rows
    half = np.isfinite(rows.points).any(axis=1) & ~rows.whole & (rows.assembly != 0)
    found = []
    if not half.any():
        return found
    off = [np.nansum(np.abs(seen(p, rows.q, side * rows.assembly, False)[0] - rows.points), axis=1) for side in (1, -1)]
    fits = (off[0] > 0.05 * task.bar) & (off[1] < max(5 * sigma, 0.1 * SUSPECT * task.bar))
    for k in np.flatnonzero(half & fits):
        real = rows.assembly[k] * -1
        noted, other = (_modes_in_words((0, 0, mode), np.array([0, 0, 1])) for mode in (rows.assembly[k], real))
        words = f"{rows.where[k]}: noted {noted}, but its angles and its point are {other}"
        real_all, sure = np.zeros((len(rows), 3), np.int8), np.zeros((len(rows), 3), bool)
        real_all[k, 2], sure[k, 2] = real, True
        found.append(Mistake(words, _with_modes((rows.where[k],), real_all, sure, slice(None))))
    return found


def _with_modes(where, real, sure, column):
    def mend(rows):
        noted = np.column_stack([rows.working, rows.assembly])
        here = np.isin(rows.where, where)[:, None] & sure & (noted != 0)
        mended = noted.copy()
        mended[:, column] = np.where(here, real, noted)[:, column]
        return replace(rows, working=mended[:, :2], assembly=mended[:, 2])

    return mend


def _modes_in_words(modes, noted=None):
    noted = modes if noted is None else noted
    words = []
    if noted[:2].any():
        words.append("working ({:+d}, {:+d})".format(*modes[:2]))
    if noted[2]:
        words.append(f"assembly {modes[2]:+d}")
    return ", ".join(words)


def _mm(length):
    return f"{1e3 * length:.3g} mm"
