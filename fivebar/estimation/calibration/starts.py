"""Where a calibration begins: values that bring the legs to the measured points, in any modes."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy import ndarray
from scipy.optimize import least_squares

from .few_rows import only_solution
from .fit import LeastSquares
from .measured_robot import FRAME, PLACE, as_complex, bars_off, seen, unframe

SUSPECT = 5e-3  # of a mean bar: where the legs miss the points by more, something is wrong
OFF = 15  # times the median miss: so far off is a mistake
TURNS = np.pi / 4 * np.arange(-3, 5)  # at which what may be turned begins
SETTLED = 8  # of such starts, the best, from which least squares begin
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
    near = [task.start, *_framed(task, task.start)]
    best = settled(task, _least_doubtful(task, near))
    if doubt(task, best) > SUSPECT * task.bar:  # a few rows may be far off
        best = _least_doubtful(task, [best, settled(task, best, loss="cauchy")])
    for starts in (lambda _: near, _counted, _turned):
        if doubt(task, best) > SUSPECT * task.bar and (tried := starts(task)):
            first = sorted(tried, key=lambda p: doubt(task, p))[:SETTLED]
            best = _least_doubtful(task, [best, *(settled(task, p) for p in first)])
    return best


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


def doubt(task: LeastSquares, p: ndarray) -> float:
    """Return `median_error` with two penalties, m, by which starts are compared.

    For lengths far from the start's, as no five-bar is built so wrong; and for points in one place,
    which a robot without cranks would reach at all angles.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(np.log(p[:5] / task.start[:5]))
    change = change[task.start[:5] > 0]
    strange = task.bar * np.maximum(np.nan_to_num(change, nan=np.inf) - 0.4, 0.0).max()
    missed = median_error(task, p) / p[PLACE["scale"]] + strange
    points = unframe(p, as_complex(task.rows.points[task.rows.whole]))
    spread = max(np.std(points.real), np.std(points.imag), 1e-300)
    return float(missed * max(1.0, 0.5 * task.bar / spread))


def settled(task: LeastSquares, p: ndarray, loss: str = "soft_l1") -> ndarray:
    """Return robust least squares of the legs' errors from these values, weakly held to them."""
    rows = task.rows
    unit = abs(p[PLACE["scale"]])  # of the measuring frame: a camera's are pixels
    bar = task.bar * unit
    size = task.size * np.where(np.isin(task.names, ("x0", "y0", "scale")), unit, 1.0)
    hold = 1e-5
    q = rows.q[rows.whole]
    points = rows.points[rows.whole]
    if not np.isfinite(median_error(task, p)):
        return p
    count = len(task.free)

    def moved(z):
        values = p.copy()
        values[task.free] += z * size
        values[PLACE["scale"]] = abs(values[PLACE["scale"]]) or 1e-12
        return values

    def off(z):
        return np.concatenate([bars_off(moved(z), q, points)[0].ravel() / bar, hold * z])

    def slope(z):
        _, slopes = bars_off(moved(z), q, points)
        jacobian = slopes[:, :, task.free].reshape(-1, count)
        return np.concatenate([jacobian * size / bar, hold * np.eye(count)])

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
    """Return starts whose free frame is turned all over, with the robot's points about the measured
    ones: those of one assembly mode, of the other, or of both.
    """
    free = [name for name in FRAME if name in task.names]
    if not free:
        return []
    starts = []
    points = task.rows.points
    for turn in TURNS if "turn" in free else (0.0,):
        for modes in ((-1,), (1,), (-1, 1)):
            p = start.copy()
            p[PLACE["turn"]] += turn
            own = _own(task, p, modes)
            if not np.isfinite(own).any():
                continue
            if "scale" in free:
                size = np.linalg.norm(np.nanstd(own, axis=(0, 1))) or 1.0
                p[PLACE["scale"]] *= np.linalg.norm(np.nanstd(points, axis=0)) / size or 1.0
                own = _own(task, p, modes)
            away = np.nanmean(points, axis=0) - np.nanmean(own, axis=(0, 1))
            for name, shift in zip(FRAME, away.tolist()):
                p[PLACE[name]] += shift * (name in free)
            starts.append(p)
    return starts


def _own(task, p, modes):
    """Return the robot's points (m, n, 2) in m assembly modes."""
    q = task.rows.q
    return np.array([seen(p, q, np.full(len(q), mode), derive=False)[0] for mode in modes])
