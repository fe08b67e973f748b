"""Where a calibration begins: values that bring the legs to the measured points, in any modes."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy import ndarray
from scipy.optimize import least_squares

from ...base.backend import pairs
from .few_rows import only_solution
from .fit import LeastSquares, noted_assembly
from .measured_robot import PLACE, as_complex, bars_off, place, seen, tip, unframe

SUSPECT = 5e-3  # of a mean bar: where the legs miss the points by more, something is wrong
OFF = 15  # times the median miss: so far off is a mistake
TURNS = np.arange(0, 2 * np.pi, np.pi / 4)  # at which what may be turned begins
SETTLED = 6  # of such starts, the best, from which least squares begin
MUCH = 8.0  # rad: while it is measured, a motor of a five-bar turns no more
COUNTS_PER_TURN = (
    "400 500 512 600 800 1000 1024 1200 1600 2000 2048 2400 2500 3200 3600 4000 4096 5000 6400 8000"
    " 8192 10000 12800 16384 20000 32768 36000 40000 65536"
)


def begin(task: LeastSquares) -> ndarray:
    """Return values (16,) to begin with, by the points alone; a bad row or two do not matter.

    Where the start leads nowhere, usual encoders are tried for free ratios, and a whole turn of a
    free frame and of the free offsets.
    """
    if (few := only_solution(task)) is not None:
        return few
    if task.rows.whole.sum() < 3:
        return task.start.copy()
    start = first(task)
    best = settled(task, start)
    if doubt(task, best) > SUSPECT * task.bar:  # a few rows may be far off
        best = _least_doubtful(task, [best, settled(task, start, loss="cauchy")])
    for starts in (_counted, _turned_frames, _turned):
        if doubt(task, best) > SUSPECT * task.bar and (tried := starts(task)):
            best = _least_doubtful(task, [best, best_of(task, tried)])
    return best


def first(task: LeastSquares) -> ndarray:
    """Return the start, or the start with the frame that fits best, whichever misses least."""
    return _least_doubtful(task, [task.start, *_framed(task, task.start)])


def best_of(task: LeastSquares, starts: list[ndarray]) -> ndarray:
    """Return the values in which least squares ends with the least doubt, of the best starts."""
    tried = sorted(starts, key=lambda p: doubt(task, p))[:SETTLED]
    return _least_doubtful(task, [settled(task, p) for p in tried])


def _least_doubtful(task, tried):
    return min(tried, key=lambda p: doubt(task, p))


def rows_far_off(task: LeastSquares, start: ndarray) -> tuple[ndarray, float]:
    """Return which rows (n,) the legs miss by far more than the others do, and from what distance
    on, m.
    """
    p = settled(task, start, loss="cauchy")
    far = OFF * median_error(task, p)
    off = np.zeros(len(task.rows))
    off[task.rows.whole] = errors(task, p)
    return off > far, far


def errors(task: LeastSquares, p: ndarray) -> ndarray:
    """Return the distances (n,), m, by which the legs miss the whole points."""
    rows = task.rows
    off, _ = bars_off(p, rows.q[rows.whole], rows.points[rows.whole])
    return np.hypot(*off.T)


def median_error(task: LeastSquares, p: ndarray) -> float:
    """Return the median of `errors`, m; inf for nan and without points."""
    off = errors(task, p)
    return float(np.nan_to_num(np.median(off), nan=np.inf)) if len(off) else np.inf


def misfit(task: LeastSquares, p: ndarray) -> float:
    """Return `median_error` and a penalty for lengths far from the start's, m: no five-bar is built
    so wrong.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(np.log(p[:5] / task.start[:5]))
    change = change[task.start[:5] > 0]
    strange = task.bar * np.maximum(np.nan_to_num(change, nan=np.inf) - 0.4, 0.0).max()
    return float(median_error(task, p) / p[PLACE["scale"]] + strange)


def doubt(task: LeastSquares, p: ndarray) -> float:
    """Return `misfit` with a penalty for points in one place, by which starts are compared: a robot
    without cranks would reach these at all angles.
    """
    points = pairs(unframe(p, as_complex(task.rows.points[task.rows.whole])))
    spread = np.std(points, axis=0).max()
    crowded = max(1.0, 0.5 * task.bar / max(spread, 1e-300))
    return misfit(task, p) * crowded


def settled(task: LeastSquares, p: ndarray, loss: str = "soft_l1") -> ndarray:
    """Return robust least squares of the legs' errors from these values, weakly held to them."""
    rows = task.rows
    bar = task.bar
    hold = 1e-5
    q = rows.q[rows.whole]
    points = rows.points[rows.whole]
    if not np.isfinite(median_error(task, p)):
        return p
    count = len(task.free)

    def moved(z):
        values = p.copy()
        values[task.free] += z * task.size
        values[PLACE["scale"]] = abs(values[PLACE["scale"]]) or 1e-12
        return values

    def off(z):
        return np.concatenate([bars_off(moved(z), q, points)[0].ravel() / bar, hold * z])

    def slope(z):
        _, slopes = bars_off(moved(z), q, points)
        jacobian = slopes[:, :, task.free].reshape(-1, count)
        return np.concatenate([jacobian * task.size / bar, hold * np.eye(count)])

    result = least_squares(
        off,
        np.zeros(count),
        slope,
        loss=loss,
        f_scale=1e-3,  # a leg that misses by more is no noise, and weighs less
        max_nfev=60,
    )
    return moved(result.x)


def _turned(task: LeastSquares) -> list[ndarray]:
    """Return starts with the free offsets all over a turn, each with its own frame."""
    grids = [TURNS if f"offset{leg}" in task.names else [0.0] for leg in (1, 2)]
    pairs = [pair for pair in product(*grids) if any(pair)]
    return _with_frames(task, 5, pairs)


def _counted(task):
    """Return starts in which readings are counts of usual encoders, where ratios are free."""
    is_free = np.array([name in task.names for name in ("ratio1", "ratio2")])
    wide = (np.ptp(task.rows.q, axis=0) > MUCH) & is_free
    if not wide.any():
        return []
    counts = np.array(COUNTS_PER_TURN.split(), float)
    return _with_frames(task, 7, [np.where(wide, 2 * np.pi / each - 1, 0.0) for each in counts])


def _with_frames(task, place_of_pair, pairs):
    """Return the start with each pair added to two of its values, and with the frames that fit."""
    tried = []
    for pair in pairs:
        start = task.start.copy()
        start[place_of_pair : place_of_pair + 2] += pair
        tried += [start, *_framed(task, start)]
    return tried


def _framed(task, start):
    """Return starts whose free frame lays the robot's points on the measured ones.

    At first in the modes noted, or else all in one assembly mode, then each in the nearer one.
    """
    free = set(task.names)
    rows = task.rows
    if not free & {"x0", "y0", "turn", "scale"}:
        return []
    noted = noted_assembly(start, rows)
    starts = []
    for side in (-1, 1):
        p = _laid(rows, start.copy(), free, np.where(noted, noted, side))
        starts.append(_nearer(rows, p, free))
    return starts


def _nearer(rows, p, free):
    """Return p with the free frame laid on the points, each row in the nearer assembly mode."""
    for _ in range(4):
        distances = np.linalg.norm(_both(rows, p) - rows.points, axis=2)
        left, right = np.nan_to_num(distances, nan=np.inf)
        p = _laid(rows, p, free, np.where(left <= right, -1, 1))
    return p


def _both(rows, p):
    """Return the points (2, n, 2) of all rows in assembly mode -1, and those in +1."""
    each = [seen(p, rows.q, np.full(len(rows), mode), derive=False)[0] for mode in (-1, 1)]
    return np.array(each)


def _turned_frames(task):
    """Return starts with the free frame all over a turn, for rows of both assembly modes."""
    free = set(task.names)
    rows = task.rows
    if not free >= {"x0", "y0", "turn"}:
        return []
    starts = []
    for turn in TURNS:
        p = task.start.copy()
        p[PLACE["turn"]] += turn
        if "scale" in free:
            p[PLACE["scale"]] *= np.nanstd(rows.points) / np.nanstd(_both(rows, p))
        p[9:11] += np.nanmean(rows.points, axis=0) - np.nanmean(_both(rows, p), axis=(0, 1))
        starts.append(_nearer(rows, p, free))
    return starts


def _laid(rows, p, free, mode):
    robot = tip(p, place(p, rows.q, mode))
    camera = as_complex(rows.points)
    good = np.isfinite(robot) & np.isfinite(camera)
    if good.sum() < 2:
        return p
    robot = robot[good]
    camera = camera[good]
    if free >= {"x0", "y0"}:
        around = robot - robot.mean()
        if "turn" in free and np.abs(around).max() > 0:
            slope = np.vdot(around, camera - camera.mean()) / np.vdot(around, around)
            p[PLACE["turn"]] = np.angle(slope)
            if "scale" in free:
                p[PLACE["scale"]] = abs(slope) or 1.0
        rest = camera - p[12] * np.exp(1j * p[11]) * robot
        p[9] = np.median(rest.real)
        p[10] = np.median(rest.imag)
    elif "turn" in free:
        rest = camera - p[9] - 1j * p[10]
        p[PLACE["turn"]] = np.angle(np.vdot(robot, rest))
    return p
