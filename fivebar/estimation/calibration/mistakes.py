"""Mistakes in measured data: the change of columns, or of noted modes, after which all fits.

Each change that people make is tried: degrees, millimetres, counts, exchanged columns, signs. By
how much the distal bars miss the points needs no mode, so it is compared before anything is fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy import ndarray

from ...base.backend import wrap
from .fit import CLEAR, LeastSquares
from .measured_robot import PLACE, sines_at
from .rows import MeasuredRows
from .starts import (
    SETTLED,
    SUSPECT,
    begin,
    best_of,
    doubt,
    errors,
    first,
    median_error,
    misfit,
    radians_per_count,
    turned,
)

DEG = np.pi / 180
FALLS = 0.15  # to this share the errors fall where a mistake is found
ANOTHER = 2.0  # mean bars: a misfit of lengths that are wrong by a factor, as of a unit
MOST = 20  # changes that are looked at closely
CHECKED = 4  # rows with a point: in fewer no mistake shows


def _readings(*factors):
    return lambda rows: replace(rows, q=rows.q * factors)


def _points(*factors):
    return lambda rows: replace(rows, points=rows.points * factors)


def _swapped_readings(rows):
    return replace(rows, q=rows.q[:, ::-1].copy())


def _swapped_points(rows):
    return replace(rows, points=rows.points[:, ::-1].copy())


READINGS: dict[str, Callable[[MeasuredRows], MeasuredRows]] = {
    "q1 in degrees": _readings(DEG, 1.0),
    "q2 in degrees": _readings(1.0, DEG),
    "q1 and q2 in degrees": _readings(DEG, DEG),
    "q1 and q2 in rad, not in degrees": _readings(1 / DEG, 1 / DEG),
    "q1 and q2 swapped": _swapped_readings,
    "q1 with the wrong sign": _readings(-1.0, 1.0),
    "q2 with the wrong sign": _readings(1.0, -1.0),
    "q1 and q2 with the wrong sign": _readings(-1.0, -1.0),
}
POINTS: dict[str, Callable[[MeasuredRows], MeasuredRows]] = {
    "x in mm": _points(1e-3, 1.0),
    "y in mm": _points(1.0, 1e-3),
    "x and y in mm": _points(1e-3, 1e-3),
    "x and y in m, not in mm": _points(1e3, 1e3),
    "x and y swapped": _swapped_points,
    "x with the wrong sign": _points(-1.0, 1.0),
    "y, or q1 and q2, with the wrong sign": _points(1.0, -1.0),
}


def find_mistakes(task: LeastSquares) -> tuple[list[str], LeastSquares, ndarray]:
    """Return the mistakes found, the task with them put right, and values (16,) to begin with."""
    if task.rows.whole.sum() < CHECKED:
        return [], task, begin(task)
    found: list[str] = []
    limit = max(SUSPECT * task.bar, 5 * task.sigma)
    p = begin(task, far=False)
    if misfit(task, p) >= limit and not _fits_as_measured(task, p):
        readings = READINGS | _counts(task)
        one = {(words,): [change] for words, change in (POINTS | readings).items()}
        two: dict[tuple, list] = {}
        for words, change in readings.items():
            two |= {(words, other): [change, POINTS[other]] for other in POINTS}
        found, mended, end = _wrong_columns(task, p, one, far=False)
        if not found:
            p = begin(task)
        units = {
            pair: changes
            for pair, changes in two.items()
            if pair[0] in READINGS and all(" in " in words for words in pair)
        }
        for changes, far in ((one, True), (units, True), (two, False)):
            if not found and misfit(task, p) >= limit:
                found, mended, end = _wrong_columns(task, p, changes, far)
        if found:
            task = mended
            p = end
    rows_found, task = _wrong_modes(task, p)
    return found + rows_found, task, p


def _fits_as_measured(task, p):
    """Return whether many numbers fit to sigma: then lengths far off are hardly told, not wrong,
    unless one is another many times over.
    """
    many = task.left_over >= len(task.free)
    of_its_size = misfit(task, p) < ANOTHER * task.bar
    return many and of_its_size and median_error(task, p) < task.sigma


def _changed(task, changes):
    """Return the task with its rows changed, one change after the other."""
    rows = task.rows
    for change in changes:
        rows = change(rows)
    size = task.size.copy()
    for k, name in enumerate(task.names):
        if name.startswith("ratio"):
            readings = rows.q[:, int(name[-1]) - 1]
            size[k] = 1 / (np.max(np.abs(readings)) or 1.0)
    return replace(task, rows=rows, size=size)


def _wrong_columns(task, before, changes, far):
    """Return the change after which the legs reach the points, in words, and the changed task with
    its values.

    Of several, one that keeps the noted modes, and of these the one that turns the frame and the
    joints least: a reflected frame is another one, turned. Each begins with the frame on the
    points, if `far` with the free offsets all over a turn.
    """
    tasks = {words: _changed(task, each) for words, each in changes.items()}
    starts = {}
    for words, each in tasks.items():
        tried = [first(each), *(turned(each) if far else [])]
        starts[words] = sorted(tried, key=lambda p, each=each: doubt(each, p))[:SETTLED]
    near = sorted(changes, key=lambda words: doubt(tasks[words], starts[words][0]))[:MOST]
    ends = {words: best_of(tasks[words], starts[words]) for words in near}
    doubts = {words: doubt(tasks[words], ends[words]) for words in near}
    least = min(doubts.values())
    limit = max(1.5 * least, 1e-4 * task.bar)
    alike = {}
    for words in changes:
        if doubts.get(words, np.inf) < limit:
            by = _turned_by(task, ends[words])
            alike[words] = (other_modes(ends[words], tasks[words].rows).sum(), round(by, 1))
    best = min(alike, key=alike.__getitem__)
    fits = least <= min(FALLS * doubt(task, before), 4 * SUSPECT * task.bar)
    if not fits or (alike[best][1] > 1.0 and not far and doubt(task, begin(task)) < limit):
        return [], task, before  # motors and a frame may lie anywhere
    after = median_error(tasks[best], ends[best])
    now = median_error(task, before)
    sizes = (
        f"(the bars miss the points by {1e3 * after:.3g} mm then, by {1e3 * now:.3g} mm as it is;"
        " medians)"
    )
    return [f"column {words}? {sizes}" for words in best], tasks[best], ends[best]


def other_modes(p: ndarray, rows: MeasuredRows) -> ndarray:
    """Return where (n,) bars drawn to the measured points are clearly in other modes than noted."""
    sines = np.nan_to_num(sines_at(p, rows.q, rows.points))
    return (rows.modes * sines > CLEAR).any(axis=1)


def _turned_by(task, p):
    """Return how far offsets and frame are turned from their start, rad."""
    return float(np.abs(wrap(p - task.start))[[5, 6, 11]].sum())


def _counts(task):
    """Return the changes of readings that are counts of usual encoders."""
    changes = {}
    for counts, ratios in radians_per_count(task, free=False).items():
        names = " and ".join(np.array(["q1", "q2"])[ratios != 1.0])
        changes[f"{names} in counts, {counts} a turn"] = _readings(*ratios)
    return changes


def _wrong_modes(task, p):
    """Return the rows whose modes are others than they note, and the task with the right ones."""
    rows = task.rows
    if misfit(task, p) > max(4 * SUSPECT * task.bar, 20 * task.sigma):
        return ([], task)  # of what fits nothing no modes are known
    sines = np.nan_to_num(sines_at(p, rows.q, rows.points))
    off = np.full(len(rows), np.inf)
    off[rows.whole] = errors(task, p)
    off /= p[PLACE["scale"]]
    fits = off < max(20 * task.sigma, 0.02 * task.bar)
    least = np.maximum(0.05, 5 * off / task.bar)
    sure = fits[:, None] & (np.abs(sines) > least[:, None])
    real = -np.sign(sines).astype(np.int8)
    noted = rows.modes
    wrong = sure & (noted != 0) & (noted != real)
    found = [
        f"{rows.where[k]}: noted {_in_words(noted[k], noted[k])}, but its angles and its point are"
        f" {_in_words(real[k], noted[k])}"
        for k in np.flatnonzero(wrong.any(axis=1))
    ]
    right = np.where(wrong, real, noted)
    rows = replace(rows, working=right[:, :2], assembly=right[:, 2])
    return found, replace(task, rows=rows)


def _in_words(modes, noted):
    words = []
    if noted[:2].any():
        words.append(f"working ({modes[0]:+d}, {modes[1]:+d})")
    if noted[2]:
        words.append(f"assembly {modes[2]:+d}")
    return ", ".join(words)
