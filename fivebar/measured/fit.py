"""Least squares on measured rows: a start that needs no modes, the modes of each row, the fit, its last digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from .._backend import wrap
from ..models.dyads import Crank
from ..models.geometry import reach
from .machine import PLACE, UNKNOWNS, bars_off, place, seen, sines_at, unframe
from .rows import Rows

NEAR = 1e-3  # of a mean bar: a leg that misses a point by more is no noise, and weighs less in the start
FAR = 0.4  # of a length's logarithm from its start: no five-bar is built so wrong
HOLD = 1e-5  # of a start, to itself: less than any noise
MUCH = 8.0  # rad: a motor of a five-bar turns no more while it is measured
USUAL = (
    400,
    500,
    512,
    600,
    800,
    1000,
    1024,
    1200,
    1600,
    2000,
    2048,
    2400,
    2500,
    3200,
    3600,
    4000,
    4096,
    5000,
    6400,
    8000,
    8192,
    10000,
    12800,
    16384,
    20000,
    32768,
    36000,
    40000,
    65536,
)  # counts a turn
SUSPECT = 5e-3  # of a mean bar: missed by more in the median, something is wrong
CLEAR = 0.1  # sine of Type 2 beyond which a pose's assembly mode is certain


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be fitted: rows, which of UNKNOWNS are free, where they begin, how large they are, weights."""

    rows: Rows
    free: np.ndarray  # places in UNKNOWNS
    start: np.ndarray  # (13,)
    size: np.ndarray  # of the free
    weight: np.ndarray  # (residuals,), 1/m: 1 / sigma
    bounds: Mapping | None = None
    loss: str = "linear"

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(UNKNOWNS[k] for k in self.free)

    @cached_property
    def bar(self) -> float:
        """Mean bar of the start, m."""
        return float(np.mean(np.abs(self.start[:4])))

    def at(self, z: np.ndarray) -> np.ndarray:
        """All values (13,) with the free ones moved from their start by z of their sizes."""
        p = self.start.copy()
        p[self.free] += z * self.size
        return p

    def with_rows(self, rows: Rows, weight: np.ndarray) -> Task:
        return replace(self, rows=rows, weight=weight)


def misses(p: np.ndarray, rows: Rows, assembly: np.ndarray, derive: bool = True) -> tuple:
    """Predicted minus measured numbers (m,), m, and their derivatives by all UNKNOWNS (m, 13)."""
    points, slope = seen(p, rows.q, assembly, derive)
    row, axis, far = rows.asked
    found = points[row, axis]
    jacobian = slope[row, axis] if derive else None
    if len(far):
        own = p.copy()
        own[9:] = 0.0, 0.0, 0.0, 1.0  # a ruler's metres, whatever the frame's
        inner, inner_slope = seen(own, rows.q, assembly, derive)
        gap = inner[far] - inner[rows.to[far]]
        length = np.hypot(*gap.T)
        found = np.concatenate([found, length])
        if derive:
            inner_slope[:, :, 9:] = 0.0
            along = gap / np.where(length, length, 1.0)[:, None]
            apart = inner_slope[far] - inner_slope[rows.to[far]]
            jacobian = np.concatenate([jacobian, np.einsum("ni,nij->nj", along, apart)])
    return found - rows.numbers, jacobian


def begin(task: Task, far: bool = True) -> np.ndarray:
    """Values (13,) to begin with: from points alone, whatever the modes; a bad row or two do not matter.

    If the start leads nowhere, the measured points say where the angles begin, usual encoders are tried where ratios
    are free, and (far) a whole turn of offsets.
    """
    if task.rows.whole.sum() < 3:
        return _shifted(task)
    found = settled(task, first(task))
    for more in (_read_off, _counted, _turned)[: 2 + far]:
        if doubt(task, found) > SUSPECT * task.bar and (tried := more(task)):
            found = min(found, settled(task, _best(task, tried)), key=lambda p: doubt(task, p))
    return found


def first(task: Task) -> np.ndarray:
    """The start, or the start with the frame that fits best to either assembly mode, whichever misses least."""
    return _best(task, [task.start, *_framed(task, task.start)])


def _best(task, tried):
    return min(tried, key=lambda p: doubt(task, p))


def miss(task: Task, p: np.ndarray) -> float:
    """Median over the rows with whole points of how far the legs miss them, m; inf where that is no number."""
    rows = task.rows
    off = bars_off(p, rows.q[rows.whole], rows.points[rows.whole])[0]
    return float(np.nan_to_num(np.median(np.hypot(*off.T)), nan=np.inf))


def doubt(task: Task, p: np.ndarray) -> float:
    """`miss`, by which starts are compared, and more for lengths far from the start's and for points in one place.

    A robot without cranks would be in one point, whatever the angles; metres that are millimetres look like one.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(np.log(p[:5] / task.start[:5]))[task.start[:5] > 0]
    strange = task.bar * np.maximum(np.nan_to_num(change, nan=np.inf) - FAR, 0.0).max()
    spread = np.std(unframe(p, task.rows.points[task.rows.whole]), axis=1).max()
    return (miss(task, p) + strange) * max(1.0, 0.5 * task.bar / max(spread, 1e-300))


def settled(task: Task, p: np.ndarray, steps: int = 60) -> np.ndarray:
    """Least squares of the legs' misses from these values, held weakly to their start."""
    rows, size = task.rows, task.bar
    q, points = rows.q[rows.whole], rows.points[rows.whole]
    if not np.isfinite(miss(task, p)):
        return p
    shape, hold = (-1, len(task.free)), HOLD * np.eye(len(task.free))

    def off(z):
        return np.concatenate([bars_off(_moved(p, task, z), q, points)[0].ravel() / size, HOLD * z])

    def slope(z):
        own = bars_off(_moved(p, task, z), q, points)[1][:, :, task.free].reshape(shape) * task.size / size
        return np.concatenate([own, hold])

    start = np.zeros(shape[1])
    done = least_squares(
        off, start, slope, loss="soft_l1", f_scale=NEAR, max_nfev=steps, ftol=1e-7, xtol=1e-7, gtol=1e-9
    )
    return _moved(p, task, done.x)


def _moved(p, task, z):
    p = p.copy()
    p[task.free] += z * task.size
    p[PLACE["scale"]] = abs(p[PLACE["scale"]]) or 1e-12
    return p


def _read_off(task):
    """The start with offsets, and ratios, that bring the readings to the angles at which the points are reached."""
    rows, free = task.rows, set(task.names)
    if not free & {"offset1", "offset2", "ratio1", "ratio2"}:
        return []
    tried = []
    for modes in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        p = task.start.copy()
        for leg in (0, 1):
            ratio, offset = reading(task.start, rows, leg, modes[leg])
            own = f"ratio{leg + 1}" in free, f"offset{leg + 1}" in free
            p[7 + leg] = ratio if own[0] else p[7 + leg]
            p[5 + leg] = offset if own[1] and own[0] else p[5 + leg]
            if own[1] and not own[0]:
                away = angle_at(task.start, rows, leg, modes[leg]) - p[7 + leg] * rows.q[:, leg]
                p[5 + leg] = np.angle(np.nansum(np.exp(1j * away)))
        tried.append(p)
    return tried


def angle_at(p: np.ndarray, rows: Rows, leg: int, working: int) -> np.ndarray:
    """The drive's angle (n,) with which a leg reaches the measured points, in the mode noted, else in `working`."""
    robot_xi = np.stack(unframe(p, rows.points), axis=-1)
    mode = np.where(rows.working[:, leg], rows.working[:, leg], working)
    with np.errstate(invalid="ignore", divide="ignore"):
        drive = Crank((-1, 1)[leg] * p[4] / 2, 0.0, p[2 * leg])
        return reach(drive, (robot_xi[:, 0], robot_xi[:, 1]), p[2 * leg + 1], mode).q


def reading(p: np.ndarray, rows: Rows, leg: int, working: int) -> tuple[float, float]:
    """(ratio, offset) with which a leg's readings are the angles at its points: medians of slopes, so a bad row or two
    do not matter."""
    angle, q = angle_at(p, rows, leg, working), rows.q[:, leg]
    good = np.isfinite(angle)
    angle, q = angle[good], q[good]
    first, second = np.triu_indices(len(q), 1)
    apart = np.abs(q[first] - q[second]) > 0.1 * np.ptp(q) if len(q) > 1 else np.zeros(0, bool)
    if not apart.any():
        return float(p[7 + leg]), float(p[5 + leg])
    ratio = np.median(wrap(angle[first] - angle[second])[apart] / (q[first] - q[second])[apart])
    return float(ratio), float(np.angle(np.sum(np.exp(1j * (angle - ratio * q)))))


def _turned(task):
    """Starts with the free offsets all over a turn, each with its own frame."""
    turns = np.arange(0, 2 * np.pi, np.pi / 4)
    grids = [turns if f"offset{leg}" in task.names else [0.0] for leg in (1, 2)]
    return _all_framed(task, 5, [(one, other) for one in grids[0] for other in grids[1] if one or other])


def _counted(task):
    """Starts in which readings are counts of usual encoders, where ratios are free and angles would be absurd."""
    wide = wide_legs(task)
    return _all_framed(task, 7, [np.where(wide, 2 * np.pi / turn, 1.0) - 1 for turn in USUAL]) if wide.any() else []


def wide_legs(task: Task, free: bool = True) -> np.ndarray:
    """Which legs (2,) have readings that no motor turns through, and a ratio that is free (or not)."""
    return np.array([
        np.ptp(task.rows.q[:, leg]) > MUCH and (f"ratio{leg + 1}" in task.names) == free for leg in (0, 1)
    ])  # fmt: skip


def _all_framed(task, first_place, pairs):
    """The start with each pair added to two of its values, with the frames that fit."""
    tried = []
    for pair in pairs:
        start = task.start.copy()
        start[first_place : first_place + 2] += pair
        tried += [start, *_framed(task, start)]
    return tried


def _framed(task, start):
    """A start with the frames, as far as they are free, that lay the robot's points on the measured ones: in the modes
    noted, and in either assembly mode."""
    free = set(task.names)
    if not free & {"x0", "y0", "turn", "scale"}:
        return []
    noted = noted_assembly(start, task.rows)
    sides = [np.full(len(noted), side) for side in (-1, 1)]
    return [_laid(task.rows, start.copy(), free, mode) for mode in [noted, *sides] if mode.all()]


def _laid(rows, p, free, mode):
    xi = place(p, rows.q, mode).xi
    z, m = xi[0] + 1j * xi[1], rows.points[:, 0] + 1j * rows.points[:, 1]
    good = np.isfinite(z) & np.isfinite(m)
    if good.sum() < 2:
        return p
    z, m = z[good], m[good]
    if free >= {"x0", "y0"}:
        around = z - z.mean()
        if "turn" in free and np.abs(around).max() > 0:
            slope = np.vdot(around, m - m.mean()) / np.vdot(around, around)
            p[PLACE["turn"]] = np.angle(slope)
            if "scale" in free:
                p[PLACE["scale"]] = abs(slope) or 1.0
        rest = m - p[12] * np.exp(1j * p[11]) * z
        p[9], p[10] = np.median(rest.real), np.median(rest.imag)
    elif free >= {"turn"}:
        p[PLACE["turn"]] = np.angle(np.vdot(z, m - p[9] - 1j * p[10]))
    return p


def _shifted(task):
    """Where one coordinate alone is measured: the start with that of the frame moved to the measured ones' middle."""
    p, rows = task.start.copy(), task.rows
    points = seen(p, rows.q, np.where(noted_assembly(p, rows), noted_assembly(p, rows), -1), False)[0]
    for axis, name in ((0, "x0"), (1, "y0")):
        gap = (rows.points - points)[:, axis]
        if name in task.names and np.isfinite(gap).any():
            p[PLACE[name]] += np.nanmedian(gap)
    return p


def noted_assembly(p: np.ndarray, rows: Rows) -> np.ndarray:
    """The assembly mode (n,) that a row notes, or that its working modes leave; 0 where both or none would do."""
    mode = rows.assembly.copy()
    fits = []
    for side in (-1, 1):
        at = place(p, rows.q, np.full(len(rows), side))
        sines = np.stack([c[0] * u[1] - c[1] * u[0] for c, u in zip(at.cranks, at.bars)], axis=-1)
        with np.errstate(invalid="ignore"):
            fits.append(((rows.working == 0) | (-np.sign(sines) == rows.working)).all(axis=1) & np.isfinite(at.xi[0]))
    only = fits[1].astype(np.int8) - fits[0].astype(np.int8)
    return np.where(mode, mode, only)


def modes_found(p: np.ndarray, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """The assembly mode (n,) of each row, and where (n,) it is uncertain: at a point its own, else as noted, or the
    nearer one."""
    noted = noted_assembly(p, rows)
    both = [seen(p, rows.q, np.full(len(rows), side), False)[0] for side in (-1, 1)]
    off = [np.abs(points - rows.points) for points in both]
    off = [np.where(np.isfinite(rows.points), each, 0.0).sum(axis=1) for each in off]
    with np.errstate(invalid="ignore"):
        nearer = np.where(np.nan_to_num(off[0], nan=np.inf) <= np.nan_to_num(off[1], nan=np.inf), -1, 1)
        apart = np.hypot(*(both[0] - both[1]).T)
        measured = np.isfinite(rows.points).any(axis=1)
        sine = sines_at(p, rows.q, rows.points)[:, 2]
        sure = rows.whole & (np.abs(sine) > CLEAR)
    found = np.where(sure, -np.sign(np.nan_to_num(sine)), np.where(noted, noted, np.where(measured, nearer, 0)))
    close = np.abs(off[0] - off[1]) < 1e-3 * np.mean(p[:4])
    unsure = ~sure & (noted == 0) & (~measured | (close & (apart > 0)))
    return found.astype(np.int8), unsure


def solve(task: Task, p: np.ndarray, assembly: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (13,) of least weighted squares from p, and which free ones are at a bound.

    Combinations that the rows do not tell stay as near to the start as they can.
    """
    z0 = (p[task.free] - task.start[task.free]) / task.size
    scale = task.weight

    def off(z):
        return misses(task.at(z), task.rows, assembly, derive=False)[0] * scale

    def slope(z):
        return misses(task.at(z), task.rows, assembly)[1][:, task.free] * task.size * scale[:, None]

    low, high = _box(task)
    z0 = np.clip(z0, low, high)
    first = off(z0)
    spread = 1.4826 * np.median(np.abs(first)) if task.loss != "linear" else 1.0
    done = least_squares(
        off, z0, slope, bounds=(low, high), loss=task.loss, f_scale=max(spread, 1e-12), x_scale=1.0, max_nfev=200,
        ftol=1e-12, xtol=1e-12, gtol=1e-12,
    )  # fmt: skip
    if task.loss != "linear":  # once more with the scatter of the fit, not of the start
        spread = max(1.4826 * np.median(np.abs(off(done.x))), 1e-12)
        done = least_squares(
            off, done.x, slope, bounds=(low, high), loss=task.loss, f_scale=spread, max_nfev=200,
            ftol=1e-14, xtol=1e-14, gtol=1e-14,
        )  # fmt: skip
    held = done.active_mask != 0
    z = done.x
    if not held.any() and task.loss == "linear":
        z = _polished(off, slope, z, low, high)
    return task.at(z), held


def _box(task):
    low, high = np.full(len(task.free), -np.inf), np.full(len(task.free), np.inf)
    for k, name in enumerate(task.names):
        if task.bounds and name in task.bounds:
            limits = np.array(task.bounds[name], float)
            low[k], high[k] = (limits - task.start[PLACE[name]]) / task.size[k]
    return low, high


def _shares(loss, ratio):
    """Derivative of SciPy's loss by the square, at ratio^2: how much a residual weighs."""
    square = ratio**2
    if loss == "huber":
        return 1 / np.sqrt(np.maximum(square, 1.0))
    return {"linear": np.ones_like(square), "soft_l1": 1 / np.sqrt(1 + square), "cauchy": 1 / (1 + square),
            "arctan": 1 / (1 + square**2)}[loss]  # fmt: skip


def _polished(off, slope, z, low, high):
    """Gauss-Newton steps to the last digit, and back to the start along what the rows do not tell."""
    best = off(z)
    for round_ in range(12):
        null = _null(slope(z))
        nearer = z - null.T @ (null @ z)
        if len(null) and np.isfinite(off(nearer)).all():
            z, best = nearer, off(nearer)
        left, s, right, tolerance = spectrum(slope(z))
        good = s > tolerance
        step = -right[: len(s)][good].T @ ((left[:, good].T @ best) / s[good])
        new = off(z + step)
        better = np.isfinite(new).all() and new @ new <= best @ best
        if better:
            z, best = z + step, new
        if (not better or np.abs(step).max(initial=0.0) < 1e-15) and (round_ or not len(null)):
            break
    return np.clip(z, low, high)


def _null(jacobian):
    s, right, tolerance = spectrum(jacobian)[1:]
    return right[int((s > tolerance).sum()) :]


def spectrum(jacobian: np.ndarray) -> tuple:
    """Left vectors, singular values, all right vectors (k, k) of a scaled Jacobian, and what of it is rounding."""
    left, s, right = np.linalg.svd(jacobian, full_matrices=jacobian.shape[0] < jacobian.shape[1])
    s = np.concatenate([s, np.zeros(jacobian.shape[1] - len(s))])
    if left.shape[1] < len(s):
        left = np.concatenate([left, np.zeros((len(left), len(s) - left.shape[1]))], axis=1)
    return left[:, : len(s)], s, right, ROUNDING * max(jacobian.shape) * s[0] if len(s) else 0.0


ROUNDING = 64 * np.finfo(float).eps  # of a singular value over the largest; poses near Type 2 multiply it


def loss_slopes(loss: str, off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A robust loss's psi(r) and psi'(r) at residuals (m,), scaled by their own scatter."""
    spread = max(1.4826 * float(np.median(np.abs(off))), 1e-300)
    step = 1e-6 * spread

    def psi(r):
        return r * _shares(loss, r / spread)

    return psi(off), (psi(off + step) - psi(off - step)) / (2 * step)
