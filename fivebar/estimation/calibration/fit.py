"""Least squares on measured rows: the assembly mode of each row, and the fit to its last digits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy import ndarray
from scipy.optimize import least_squares

from .measured_robot import (
    FRAMES,
    PLACE,
    SIDES,
    UNKNOWNS,
    bars_off,
    length_ok,
    place,
    seen,
    sines_at,
    tool_in,
    whitening,
)
from .rows import MeasuredRows

LOSSES = "linear", "huber", "cauchy"
# Of sine^2 over sigma / bar: below it, a pose is fitted by its loop. Where its own noise may open
# the loop, that quotient is about 1.
NEAR = 20.0
NEAREST = 0.2  # sine beyond which no pose is fitted by its loop
NOISIEST = 0.02  # sigma / bar, beyond which the values are not yet near enough to tell
CLEAR = 0.1  # sine of Type 2 beyond which a pose's assembly mode is certain
TOLERANCE = 1e-14  # of least squares: changes below it are rounding
USUAL = 5.0  # times the median miss: the other mode's pose may miss by so much, too
ROUNDS = 10  # of weights near Type 2, each by the fit before
SETTLED = 1e-9  # change of all unknowns, over their sizes, after which no round follows
# Of the largest singular value: smaller ones are rounding, which poses near Type 2 multiply.
ROUNDING = 64 * np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """A least-squares problem.

    Attributes
    ----------
    rows : MeasuredRows
        What was measured.
    free : array of int
        The places of the unknowns in UNKNOWNS.
    start : (16,) array
        All values at the start.
    size : array
        The sizes of the unknowns, by which they are scaled.
    weight : array
        1 / sigma of each measured number, 1/m.
    loss : str
        One of LOSSES.
    prior : array, optional
        Sizes of the unknowns over the standard deviations of their starts, 0 without one.
    sigma : float
        Typical standard deviation of a measured number, m, 0 where it is not known.
    turned : tuple of str
        Unknown angles that may be anywhere in a turn, as no start of theirs is known.
    """

    rows: MeasuredRows
    free: ndarray
    start: ndarray
    size: ndarray
    weight: ndarray
    loss: str = "linear"
    prior: ndarray | None = None
    sigma: float = 0.0
    turned: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(UNKNOWNS[k] for k in self.free)

    @property
    def left_over(self) -> int:
        """How many more numbers are measured, or known by priors, than there are unknowns."""
        known = 0 if self.prior is None else np.count_nonzero(self.prior)
        return int(len(self.rows.numbers) + known - len(self.free))

    @cached_property
    def bar(self) -> float:
        """Mean bar of the start, m."""
        return float(np.mean(np.abs(self.start[:4])))

    def at(self, z: ndarray) -> ndarray:
        """Return all values with the unknowns moved from their start by z sizes."""
        p = self.start.copy()
        p[self.free] += z * self.size
        return p


def residuals(p: ndarray, rows: MeasuredRows, assembly: ndarray, derive: bool = True) -> tuple:
    """Return predicted minus measured numbers (m,), m, and their derivatives by UNKNOWNS (m, 15).

    Rows near Type 2 have the errors of their legs in place of those of their points.
    Without `derive` the derivatives are None.
    """
    row, axis, far = rows.measured
    points, slopes = seen(p, rows.q, assembly, derive)
    predicted = points[row, axis]
    jacobian = slopes[row, axis] if derive else None
    near, places = rows.looped
    if rows.loop is not None:
        loop = rows.loop[near]
        whiten = loop[:, :, :2]
        mean = loop[:, :, 2]
        errors, by_unknowns = bars_off(p, rows.q[near], rows.points[near])
        whitened = (whiten @ errors[:, :, None])[:, :, 0]
        predicted[places] = rows.numbers[places] - (whitened - mean)
        if jacobian is not None:
            jacobian[places] = -(whiten @ by_unknowns)
    if len(far):
        p = p.copy()
        p[FRAMES] = 0.0, 0.0, 0.0, 1.0  # a ruler knows no frame and no scale
        points, slopes = seen(p, rows.q, assembly, derive)
        to = rows.to[far]
        gap = points[far] - points[to]
        length = np.hypot(*gap.T)
        predicted = np.concatenate([predicted, length])
        if derive:
            slopes[:, :, FRAMES] = 0.0
            divisor = np.where(length, length, 1.0)
            along = gap / divisor[:, None]
            by_gap = slopes[far] - slopes[to]
            by_unknowns = np.einsum("ni,nij->nj", along, by_gap)
            jacobian = np.concatenate([jacobian, by_unknowns])
    return predicted - rows.numbers, jacobian


def possible_sides(p: ndarray, rows: MeasuredRows) -> ndarray:
    """Return whether (2, n) the robot closes in assembly modes -1 and +1, in the working modes that
    a row notes.
    """
    fits = []
    for side in SIDES:
        at = place(p, rows.q, side)
        as_noted = (rows.working == 0) | (-np.sign(at.sines) == rows.working)
        fits.append(as_noted.all(axis=1) & np.isfinite(at.xi))
    return np.array(fits)


def noted_assembly(p: ndarray, rows: MeasuredRows) -> ndarray:
    """Return the assembly mode (n,) that a row notes, or that its working modes leave.

    It is 0 where both modes or none would do.
    """
    minus, plus = possible_sides(p, rows).astype(int)
    return np.where(rows.assembly, rows.assembly, plus - minus)


def assembly_modes(p: ndarray, rows: MeasuredRows) -> tuple[ndarray, ndarray]:
    """Return the assembly mode (n,) of each row, and where (n,) it is uncertain.

    At a measured point it is the point's own, else as noted, else that of the nearer pose. It is
    uncertain where the other pose would be no unusual miss either.
    """
    noted = noted_assembly(p, rows)
    known = np.isfinite(rows.points)
    off = []
    for side in SIDES:
        own, _ = seen(p, rows.q, side, derive=False)
        off.append(np.where(known, np.abs(own - rows.points), 0.0).sum(axis=1))
    minus, plus = np.nan_to_num(off, nan=np.inf)
    usual = USUAL * np.median(np.minimum(minus, plus))
    sine = sines_at(p, rows.q, rows.points)[:, 2]
    sure = rows.whole & (np.abs(sine) > CLEAR)
    measured = known.any(axis=1)
    nearer = np.where(minus <= plus, -1, 1) * measured
    otherwise = np.where(noted, noted, nearer)
    modes = np.where(sure, -np.sign(sine), otherwise)
    alike = np.ptp(off, axis=0) < 1e-3 * np.mean(p[:4]) + usual
    uncertain = ~sure & (noted == 0) & (~measured | alike)
    return modes.astype(np.int8), uncertain


def robust_scatter(task: LeastSquares, p: ndarray, assembly: ndarray) -> float:
    """Return the standard deviation of a weighted number, from the rows that p reaches."""
    missed, _ = residuals(p, task.rows, assembly, derive=False)
    off = missed * task.weight
    reached = np.abs(off[np.isfinite(off)])
    if not len(reached):
        return 1.0
    return 1.4826 * float(np.median(reached))


def weighted_by_loops(task: LeastSquares, p: ndarray, scatter: float) -> LeastSquares:
    """Return the task with its rows near Type 2 to be fitted by their loops.

    Where noise may open the loop, a point is no smooth function of the unknowns; the legs' errors
    are. `scatter` is the standard deviation of a weighted number.
    """
    rows = task.rows
    sigma = np.ones(len(rows))
    sigma[rows.row_of] = scatter / task.weight
    if rows.loop is None:
        scale = p[PLACE["scale"]]
        shorter = min(p[1], p[3])
        share = sigma / np.abs(scale * shorter)
        sines = sines_at(p, rows.q, rows.points)
        sine = np.abs(sines[:, 2])
        near = (sine < np.sqrt(NEAR * share)) & (sine < NEAREST)
        near &= rows.whole & (share < NOISIEST) & (tool_in(p)[0] == 0)
        if not near.any():
            return task
    else:
        near = np.isfinite(rows.loop[:, 0, 0])
    loop = np.full((len(rows), 2, 3), np.nan)
    loop[near] = whitening(p, rows.q[near], sigma[near])
    weighted = replace(rows, loop=loop)
    return replace(task, rows=weighted)


def solve_by_loops(
    task: LeastSquares, p: ndarray, assembly: ndarray, scatter: float, absolute: bool
) -> tuple[LeastSquares, ndarray]:
    """Return the task and `solve`'s answer, rows near Type 2 weighted by that answer.

    Where weights are not `absolute`, the scatter is that of the answer, too.
    """
    for _ in range(ROUNDS):
        task = weighted_by_loops(task, p, scatter)
        before = p
        p = solve(task, before, assembly)
        change = np.abs(p - before)[task.free] / task.size
        if task.rows.loop is None or not length_ok(p) or change.max() < SETTLED:
            break
        if not absolute:
            scatter = robust_scatter(task, p, assembly)
    return task, p


def solve(task: LeastSquares, p: ndarray, assembly: ndarray) -> ndarray:
    """Return the values (16,) of least weighted squares from p; rows of weight 0 may be unreached.

    Combinations that the rows do not tell stay as near to the start as they can.
    """
    prior = np.zeros((0, len(task.free)))
    if task.prior is not None:
        prior = np.diag(task.prior)

    def off(z):
        missed, _ = residuals(task.at(z), task.rows, assembly, derive=False)
        weighted = np.where(task.weight, missed, 0.0) * task.weight
        return np.concatenate([weighted, prior @ z])

    def slope(z):
        _, by_all = residuals(task.at(z), task.rows, assembly)
        weight = task.weight[:, None]
        weighted = np.where(weight, by_all[:, task.free], 0.0) * task.size * weight
        return np.concatenate([weighted, prior])

    def fitted(z):
        scatter = 1.0
        if task.loss != "linear":
            median = np.median(np.abs(off(z)))
            scatter = max(1.4826 * median, 1e-12)
        return least_squares(
            off,
            z,
            slope,
            loss=task.loss,
            f_scale=scatter,
            max_nfev=200,
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
        ).x

    z = fitted((p - task.start)[task.free] / task.size)
    if task.loss == "linear":
        return task.at(_polish(off, slope, z))
    return task.at(fitted(z))  # once more with the scatter of the fit, not of the start


def _polish(off, slope, z):
    """Return z after Gauss-Newton steps to the last digit.

    Along what the rows do not tell, it goes back to the start.
    """
    best = off(z)
    for k in range(12):
        _, s, right, tolerance = spectrum(slope(z))
        rank = np.count_nonzero(s > tolerance)
        null = right[rank:]
        if len(null):
            nearer = z - null.T @ (null @ z)
            at_nearer = off(nearer)
            if np.isfinite(at_nearer).all():
                z = nearer
                best = at_nearer
        left, s, right, tolerance = spectrum(slope(z))
        good = s > tolerance
        along = (left[:, good].T @ best) / s[good]
        told = right[: len(s)][good]
        step = -told.T @ along
        moved = z + step
        new = off(moved)
        better = np.isfinite(new).all() and new @ new <= best @ best
        if better:
            z = moved
            best = new
        longest = np.abs(step).max(initial=0.0)
        done = longest < 1e-15 or not better
        if done and (k > 0 or not len(null)):
            break
    return z


def spectrum(jacobian: ndarray) -> tuple:
    """Return left vectors, singular values and right vectors (k, k) of a scaled Jacobian.

    The last of the four results is the singular value below which all is rounding.
    """
    m, k = jacobian.shape
    left, s, right = np.linalg.svd(jacobian, full_matrices=m < k)
    if m < k:
        missing = k - m
        s = np.pad(s, (0, missing))
        left = np.pad(left, ((0, 0), (0, missing)))
    tolerance = ROUNDING * max(m, k) * s[0]
    return left, s, right, tolerance


def loss_slopes(loss: str, off: ndarray) -> tuple[ndarray, ndarray]:
    """Return a robust loss's psi(r) and psi'(r) at residuals (m,), scaled by their own scatter."""
    median = float(np.median(np.abs(off)))
    scatter = max(1.4826 * median, 1e-300)
    step = 1e-6 * scatter

    def psi(r):
        square = (r / scatter) ** 2
        weights = {"huber": 1 / np.sqrt(np.maximum(square, 1.0)), "cauchy": 1 / (1 + square)}
        return r * weights[loss]

    rise = psi(off + step) - psi(off - step)
    return psi(off), rise / (2 * step)
