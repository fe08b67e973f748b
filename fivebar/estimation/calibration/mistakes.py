"""What is wrong with data, found by trying: the change of a column or a row after which everything
fits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .fit import Task
from .measured_robot import PLACE, bars_off, seen, sines_at
from .starts import SUSPECT, begin, doubt
from .wrong_columns import (
    ANGLES,
    FALLS,
    PLACES,
    Mistake,
    columns,
    crudely,
    double,
    mended,
    mm,
    more_unknown,
    single,
)

FEW = 8  # rows of which none is alone
SURE = 0.05  # sine beyond which a mode is certain


def mistakes(task: Task, sigma: float) -> tuple[list[Mistake], Task, np.ndarray]:
    """The mistakes found, the task with its rows mended, and values (13,) to begin with.

    sigma: m, typical, 0 where it is not known. Columns first, then rows, then the modes that rows
        note.
    """
    if task.rows.whole.sum() < 4:
        found = crudely(task)
        task = mended(task, found)
        return found, task, begin(task)
    p, found, limit = begin(task, far=False), [], max(SUSPECT * task.bar, 5 * sigma)
    for tried in (
        single,
        None,
        double,
    ):  # offsets far from the start are likelier than two mistakes
        if doubt(task, p) < limit:
            break
        if tried is None:
            p = begin(task)
        elif found := columns(task, p, tried(task)):
            task = mended(task, found)
            p = begin(task)
            break
    if doubt(task, p) > limit and (more := more_unknown(task, p)):
        return [*found, more], task, p
    rows_found, p = _rows(task, p, sigma)
    task = mended(task, rows_found)
    noted = _modes(task, p, sigma)
    return [*found, *rows_found, *noted], mended(task, noted), p


def lone_rows(task: Task, p: np.ndarray) -> list[str]:
    """Rows whose points are in other modes than almost all, where no modes are noted: right
    perhaps, but to be looked at.
    """
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
        f"{rows.where[whole[k]]} is in {_modes_in_words(modes[k])}, almost all others in {others}:"
        " no modes are noted"
        for k in np.flatnonzero(kind.ravel() != usual)
    ]


def _rows(task, p, sigma):
    """Rows that fit after a change of themselves, and values that the rows off the rest have no
    part in.
    """
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
        changes = ANGLES | PLACES
        changed = {words: change(own) for words, change in changes.items()}
        after = {
            words: np.hypot(*bars_off(p, row.q, row.points)[0][0]) for words, row in changed.items()
        }
        best = min(after, key=after.__getitem__)
        if after[best] < max(5 * scale, 2e-4 * task.bar) and after[best] < FALLS * off[k]:
            notes = f"(misses the point by {mm(after[best])} then, by {mm(off[k])} as it is)"
            found.append(Mistake(f"{rows.where[k]}: {best}? {notes}", _in_row(k, changes[best])))
    return found, p


def _in_row(k, change):
    def mend(rows):
        changed, here = change(rows), np.arange(len(rows)) == k
        parts = {
            n: np.where(here[:, None], getattr(changed, n), getattr(rows, n))
            for n in ("q", "points")
        }
        return replace(rows, **parts)

    return mend


def _modes(task, p, sigma):
    """Rows whose modes are others than they note; of a column that is wrong in most rows, the
    column.
    """
    rows = task.rows
    if doubt(task, p) > max(4 * SUSPECT * task.bar, 20 * sigma):
        return []  # of what fits nothing no modes are known
    off, sines = np.full(len(rows), np.inf), sines_at(p, rows.q, rows.points)
    off[rows.whole] = (
        np.hypot(*bars_off(p, rows.q[rows.whole], rows.points[rows.whole])[0].T) / p[PLACE["scale"]]
    )
    fits = off < max(20 * sigma, 0.02 * task.bar)
    real = -np.sign(np.nan_to_num(sines)).astype(np.int8)
    sure = fits[:, None] & (
        np.abs(np.nan_to_num(sines)) > np.maximum(SURE, 5 * off / task.bar)[:, None]
    )
    noted = np.column_stack([rows.working, rows.assembly])
    wrong = sure & (noted != 0) & (noted != real)
    found = []
    for column, name in enumerate(("working1", "working2", "assembly")):
        checked = sure[:, column] & (noted[:, column] != 0)
        if checked.sum() > 3 and wrong[:, column].mean() > 0.6:
            words = (
                f"column {name} with the wrong sign in {wrong[:, column].sum()} of {checked.sum()}"
                " rows"
            )
            found.append(Mistake(words, _with_modes(rows.where, real, sure, column)))
            wrong[:, column] = False
    for k in np.flatnonzero(wrong.any(axis=1)):
        says = _modes_in_words(noted[k])
        words = (
            f"{rows.where[k]}: noted {says}, but its angles and its point are"
            f" {_modes_in_words(real[k], noted[k])}"
        )
        found.append(Mistake(words, _with_modes((rows.where[k],), real, sure, slice(None))))
    return found + _half_measured(task, p, sigma)


def _half_measured(task, p, sigma):
    """The same of rows with one coordinate, where the other assembly mode fits and the noted one
    does not.
    """
    rows = task.rows
    half = np.isfinite(rows.points).any(axis=1) & ~rows.whole & (rows.assembly != 0)
    found = []
    if not half.any():
        return found
    off = [
        np.nansum(np.abs(seen(p, rows.q, side * rows.assembly, False)[0] - rows.points), axis=1)
        for side in (1, -1)
    ]
    fits = (off[0] > 0.05 * task.bar) & (off[1] < max(5 * sigma, 0.1 * SUSPECT * task.bar))
    for k in np.flatnonzero(half & fits):
        real = rows.assembly[k] * -1
        noted, other = (
            _modes_in_words((0, 0, mode), np.array([0, 0, 1])) for mode in (rows.assembly[k], real)
        )
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
