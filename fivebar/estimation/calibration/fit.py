"""Least squares on measured rows: the modes of each row, the fit, its last digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from .measured_robot import PLACE, UNKNOWNS, place, seen, sines_at
from .rows import Rows

LOSSES = "linear", "soft_l1", "huber", "cauchy", "arctan"
CLEAR = 0.1  # sine of Type 2 beyond which a pose's assembly mode is certain


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be fitted: rows, which of UNKNOWNS are free, where they begin, how large they are,
    weights.
    """

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


def noted_assembly(p: np.ndarray, rows: Rows) -> np.ndarray:
    """The assembly mode (n,) that a row notes, or that its working modes leave; 0 where both or
    none would do.
    """
    mode = rows.assembly.copy()
    fits = []
    for side in (-1, 1):
        at = place(p, rows.q, np.full(len(rows), side))
        sines = np.stack(at.sines, axis=-1)
        with np.errstate(invalid="ignore"):
            fits.append(
                ((rows.working == 0) | (-np.sign(sines) == rows.working)).all(axis=1)
                & np.isfinite(at.xi[0])
            )
    only = fits[1].astype(np.int8) - fits[0].astype(np.int8)
    return np.where(mode, mode, only)


def modes_found(p: np.ndarray, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """The assembly mode (n,) of each row, and where (n,) it is uncertain: at a point its own, else
    as noted, or the nearer one.
    """
    noted = noted_assembly(p, rows)
    both = [seen(p, rows.q, np.full(len(rows), side), False)[0] for side in (-1, 1)]
    off = [np.abs(points - rows.points) for points in both]
    off = [np.where(np.isfinite(rows.points), each, 0.0).sum(axis=1) for each in off]
    with np.errstate(invalid="ignore"):
        nearer = np.where(
            np.nan_to_num(off[0], nan=np.inf) <= np.nan_to_num(off[1], nan=np.inf), -1, 1
        )
        apart = np.hypot(*(both[0] - both[1]).T)
        measured = np.isfinite(rows.points).any(axis=1)
        sine = sines_at(p, rows.q, rows.points)[:, 2]
        sure = rows.whole & (np.abs(sine) > CLEAR)
    found = np.where(
        sure, -np.sign(np.nan_to_num(sine)), np.where(noted, noted, np.where(measured, nearer, 0))
    )
    close = np.abs(off[0] - off[1]) < 1e-3 * np.mean(p[:4])
    unsure = ~sure & (noted == 0) & (~measured | (close & (apart > 0)))
    return found.astype(np.int8), unsure


def solve(task: Task, p: np.ndarray, assembly: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (13,) of least weighted squares from p, and which free ones are at a bound.

    Combinations that the rows do not tell stay as near to the start as they can. Bounds count where
    a fit without them
    leaves them: within them SciPy's steps would drift along what the rows do not tell.
    """
    low, high = _box(task)
    if task.bounds:
        free, held = solve(replace(task, bounds=None), p, assembly)
        inside = (free[task.free] - task.start[task.free]) / task.size
        if np.all((inside >= low) & (inside <= high)):
            return free, held

    def off(z):
        return misses(task.at(z), task.rows, assembly, derive=False)[0] * task.weight

    def slope(z):
        return (
            misses(task.at(z), task.rows, assembly)[1][:, task.free]
            * task.size
            * task.weight[:, None]
        )

    def fitted(z, tolerance):
        spread = max(1.4826 * np.median(np.abs(off(z))), 1e-12) if task.loss != "linear" else 1.0
        return least_squares(
            off,
            z,
            slope,
            bounds=(low, high),
            loss=task.loss,
            f_scale=spread,
            max_nfev=200,
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
        )

    done = fitted(np.clip((p[task.free] - task.start[task.free]) / task.size, low, high), 1e-12)
    if task.loss != "linear":  # once more with the scatter of the fit, not of the start
        done = fitted(done.x, 1e-14)
    held = done.active_mask != 0
    if not held.any() and task.loss == "linear":
        return task.at(_polished(off, slope, done.x, low, high)), held
    return task.at(done.x), held


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
    return {
        "linear": np.ones_like(square),
        "soft_l1": 1 / np.sqrt(1 + square),
        "cauchy": 1 / (1 + square),
        "arctan": 1 / (1 + square**2),
    }[loss]


def _polished(off, slope, z, low, high):
    """Gauss-Newton steps to the last digit, and back to the start along what the rows do not
    tell.
    """
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
    """Left vectors, singular values, all right vectors (k, k) of a scaled Jacobian, and what of it
    is rounding.
    """
    left, s, right = np.linalg.svd(jacobian, full_matrices=jacobian.shape[0] < jacobian.shape[1])
    s = np.concatenate([s, np.zeros(jacobian.shape[1] - len(s))])
    if left.shape[1] < len(s):
        left = np.concatenate([left, np.zeros((len(left), len(s) - left.shape[1]))], axis=1)
    return left[:, : len(s)], s, right, ROUNDING * max(jacobian.shape) * s[0] if len(s) else 0.0


ROUNDING = (
    64 * np.finfo(float).eps
)  # of a singular value over the largest; poses near Type 2 multiply it


def loss_slopes(loss: str, off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A robust loss's psi(r) and psi'(r) at residuals (m,), scaled by their own scatter."""
    spread = max(1.4826 * float(np.median(np.abs(off))), 1e-300)
    step = 1e-6 * spread

    def psi(r):
        return r * _shares(loss, r / spread)

    return psi(off), (psi(off + step) - psi(off - step)) / (2 * step)
