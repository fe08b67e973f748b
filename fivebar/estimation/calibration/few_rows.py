"""Calibrations of few rows: all values that fit them, in all modes.

A few points are reached by several robots: each leg may be bent the other way, with another offset.
The search begins at offsets and turns all over and closes the legs on the points (`bars_off`),
which needs no mode. Coordinates that were not measured are unknowns beside the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy import ndarray
from scipy.stats.qmc import Sobol

from ...base.backend import wrap
from .fit import LeastSquares
from .measured_robot import PLACE, UNITS, bars_off, seen, sines_at

FEW = 5  # rows
STARTS = 9  # 2 to the power of it, and eight times as many with a frame among the unknowns
# Of the search: with the start's lengths, with all unknowns, and of those ends that fit.
STEPS = 15, 40, 100
KEPT = 512  # places that steps end in, the best, from which they go on
CELL = 0.05  # of the unknowns' sizes: starts that end nearer to each other end in one place
CHANGED = 0.1  # of a length, beyond which no five-bar is built so wrong
WALL = 0.99  # of that change
EXACT = 1e-3  # of a mean bar: scatter of points whose sigma is not given
FAR = 5.0  # standard deviations: what fits worse by more is no solution
WORST = 2e-2  # of a mean bar: rms by which the legs may miss the points
APART = 1e-3  # of the unknowns' sizes: values that differ by less are one solution
UNTOLD = 1e-6  # of the largest singular value: combinations that few rows do not tell
TURNS = [5, 6, 11]  # places of the angles
NAMED = 8  # solutions in a message
SIGN = {-1: "-1", 0: "±1", 1: "+1"}  # of modes; too near a singularity to tell, either


def only_solution(task: LeastSquares) -> ndarray | None:
    """Return the values (16,) that fit few rows in the modes noted; None where none do.

    Raises
    ------
    ValueError
        Several fit, or none in the modes noted: the message names modes and values of each.
    """
    rows = task.rows
    if len(rows) > FEW or (rows.to >= 0).any():
        return None
    values, modes = solutions(task)
    fits = (rows.modes * modes >= 0).all(axis=(1, 2))
    if fits.sum() == 1:
        return values[fits.argmax()]
    if fits.any():
        # Steps end at the limits of the lengths in as many places as there are starts.
        inside = fits & (_length_changes(task, values.T).max(axis=0) < WALL)
        count = f"{inside.sum()} solutions fit"
        if (inside != fits).any():
            count += f" within {CHANGED:.0%} of the lengths, others at that limit"
        listed = inside if inside.any() else fits
        named = _named(task, values[listed], modes[listed])
        raise ValueError(
            f"{count}, and these few rows do not tell which is right: {named}."
            " Note working1, working2 and assembly, measure more rows, or give values to begin with"
            " (start, on the command line --start)"
        )
    if len(rows) > 3 or "scale" in task.names:  # in more rows, mistakes are looked for
        return values[0] if len(values) == 1 else None
    if len(values):
        raise ValueError(
            "in the modes noted the robot does not reach the points; it would in"
            f" {_named(task, values, modes)}"
        )
    raise ValueError(
        "no robot reaches these points whose lengths are within 10 % of this one's. Are the units"
        " right (headings as x (mm), q1_deg; units=, --units), and are offsets and the frame (x0,"
        " y0, turn) unknown, where they are?"
    )


def solutions(task: LeastSquares) -> tuple[ndarray, ndarray]:
    """Return all values (m, 16) that fit the rows, and the rows' modes (m, n, 3) with them.

    A mode is 0 near its singularity.
    """
    n = len(task.rows)
    starts = _starts(task)
    z = np.zeros((len(starts.points), len(task.free) + starts.missing.sum()))
    lengths = np.append(task.free, np.full(starts.missing.sum(), -1)) // 5 == 0
    z, cost = _descend(task, starts, z, STEPS[0], ~lengths)
    for steps, cell in zip(STEPS[1:], (CELL, APART)):
        best = _best_of_each_place(task, starts, z, cost, cell)
        starts = replace(starts, p=starts.p[:, best], points=starts.points[best])
        z, cost = _descend(task, starts, z[best], steps, np.ones_like(lengths))
    least = cost.min()
    scatter = task.sigma / task.bar or EXACT
    variance = max(scatter**2, least / max(task.left_over, 1))
    good = (cost < least + FAR**2 * variance) & (
        cost < 2 * n * max(WORST, FAR * task.sigma / task.bar) ** 2
    )
    values, points = starts.moved(task, z)
    sines = sines_at(*_flat(task, values, points)).reshape(-1, n, 3)
    # A leg that lacks s of being stretched has a sine of about sqrt(2 s / bar).
    clear = np.abs(sines) > np.sqrt(2 * FAR * scatter)
    modes = -np.sign(np.where(clear, sines, 0.0)).astype(int)
    good = np.flatnonzero(good)
    _, s, _ = np.linalg.svd(_errors(task, starts, z)[1][good], full_matrices=False)
    # Where noise keeps a robot from closing, one alone may not be told, of solutions that are.
    told = ((s > UNTOLD * s[:, :1]).sum(axis=1) == z.shape[1]).any()
    chosen: list[int] = []
    for new in good[np.argsort(cost[good])].tolist():
        change = values[:, chosen] - values[:, [new]]
        change[TURNS] = wrap(change[TURNS])
        apart = np.abs(change[task.free] / task.size[:, None]).max(axis=0) > APART
        alike = (modes[chosen] == modes[new]).all(axis=(1, 2))
        if not (alike & ~(apart & told)).any():
            chosen.append(new)
    return values[:, chosen].T, modes[chosen]


def _best_of_each_place(task, starts, z, cost, cell):
    """Return the numbers of the starts that ended best, one of each place."""
    values, points = starts.moved(task, z)
    values[TURNS] = wrap(values[TURNS])
    ends = np.column_stack(
        [(values[task.free] / task.size[:, None]).T, points[:, starts.missing] / task.bar]
    )
    order = np.argsort(cost, kind="stable")
    _, first = np.unique(np.round(ends[order] / cell), axis=0, return_index=True)
    return order[np.sort(first)[:KEPT]]


def _named(task, values, modes):
    """Return in words the modes of solutions, and the values that turn something."""
    turns = [name for name in task.names if UNITS.get(name) == "rad"]
    sentences = []
    for p, signs in zip(values[:NAMED], modes):
        rows = task.rows.where
        if (signs == signs[0]).all():
            rows, signs = ["all rows" if len(rows) > 1 else rows[0]], signs[:1]
        words = [f"{row} ({SIGN[a]}, {SIGN[b]}), {SIGN[c]}" for row, (a, b, c) in zip(rows, signs)]
        words += [f"{name} = {np.degrees(wrap(p[PLACE[name]])):.4g}°" for name in turns]
        sentences.append(", ".join(words))
    if len(values) > NAMED:
        sentences.append(f"and {len(values) - NAMED} more")
    return f"(working modes, assembly mode) {'; '.join(sentences)}"


@dataclass(frozen=True, eq=False)
class _Starts:
    """Values p (16, m) and points (m, n, 2) to begin with; where (n, 2) a coordinate is missing."""

    p: ndarray
    points: ndarray
    missing: ndarray

    def moved(self, task, z):
        """Return values and points moved by z (m, k and the missing coordinates) sizes."""
        k = len(task.free)
        p = self.p.copy()
        p[task.free] += z[:, :k].T * task.size[:, None]
        points = self.points.copy()
        points[:, self.missing] += z[:, k:] * task.bar
        return p, points


def _flat(task, p, points):
    """Return values, readings and points of all rows of all starts, one after the other."""
    m, n = points.shape[:2]
    return np.repeat(p, n, axis=1), np.tile(task.rows.q, (m, 1)), points.reshape(-1, 2)


def _starts(task):
    """Return the _Starts: turned all over, frames on the points, missing coordinates guessed."""
    rows = task.rows
    n = len(rows)
    missing = np.isnan(rows.points)
    frame = {"x0", "y0", "turn"} & set(task.names)
    draws = Sobol(len(task.turned) + n, seed=0).random_base2(STARTS + 3 * bool(frame))
    m = len(draws)
    p = np.repeat(task.start[:, None], m, axis=1)
    for name, share in zip(task.turned, draws.T):
        p[PLACE[name]] += 2 * np.pi * share
    side = np.where(rows.assembly, rows.assembly, np.where(draws[:, -n:] < 0.5, -1, 1))
    values, q, _ = _flat(task, p, np.zeros((m, n, 2)))
    guess = seen(values, q, side.ravel(), derive=False)[0].reshape(m, n, 2)
    guess = np.where(np.isfinite(guess), guess, 0.0)
    for axis, name in enumerate(("x0", "y0")):
        if name in frame and not missing[:, axis].all():
            known = ~missing[:, axis]
            shift = (rows.points[known, axis] - guess[:, known, axis]).mean(axis=1)
            p[PLACE[name]] += shift
            guess[:, :, axis] += shift[:, None]
    return _Starts(p, np.where(missing, guess, rows.points), missing)


def _errors(task, starts, z):
    """Return the legs' errors and priors (m, r), in mean bars, and their derivatives by z."""
    p, points = starts.moved(task, z)
    m, n = points.shape[:2]
    off, slopes = bars_off(*_flat(task, p, points))
    slopes = slopes.reshape(m, n, 2, -1) / task.bar
    # A point that moves to the right is a frame that moves to the left.
    by_points = np.zeros((m, n, 2, n, 2))
    rows = np.arange(n)
    by_points[:, rows, :, rows] = -task.bar * np.moveaxis(slopes[..., 9:11], 1, 0)
    by_unknowns = slopes[..., task.free] * task.size
    jacobian = np.concatenate([by_unknowns, by_points[..., starts.missing]], axis=3)
    jacobian = jacobian.reshape(m, 2 * n, -1)
    off = off.reshape(m, -1) / task.bar
    prior = np.zeros(z.shape[1])
    if task.prior is not None:
        prior[: len(task.free)] = task.prior * task.sigma / task.bar
    off = np.concatenate([off, z * prior], axis=1)
    own = np.broadcast_to(np.diag(prior), (m, len(prior), len(prior)))
    strange = _length_changes(task, p).max(axis=0) > 1
    off[strange | (p[4] < 0) | (p[PLACE["scale"]] <= 0)] = np.inf
    return off, np.concatenate([jacobian, own], axis=1)


def _length_changes(task, p):
    """Return the changes (5, m) of the lengths, as shares of what they may change by."""
    limit = CHANGED * np.append(task.start[:4], task.bar)
    return np.abs(p[:5] - task.start[:5, None]) / limit[:, None]


def _descend(task, starts, z, steps, moved):
    """Return z (m, k) after steps of Levenberg and Marquardt, all starts at once, and costs.

    Only what is `moved` (k,) moves.
    """
    damping = np.full(len(z), 1e-2)
    off, slope = _errors(task, starts, z)
    cost = (off**2).sum(axis=1)
    for _ in range(steps):
        slope = slope * moved
        normal = slope.mT @ slope + damping[:, None, None] * np.eye(z.shape[1])
        step = np.linalg.solve(normal, slope.mT @ off[:, :, None])
        new = z - step[:, :, 0]
        off_new, slope_new = _errors(task, starts, new)
        cost_new = (off_new**2).sum(axis=1)
        better = cost_new < cost
        damping *= np.where(better, 0.1, 10.0)
        z[better] = new[better]
        off[better] = off_new[better]
        slope = np.where(better[:, None, None], slope_new, slope)
        cost[better] = cost_new[better]
        damping = np.clip(damping, 1e-12, 1e12)
    return z, cost
