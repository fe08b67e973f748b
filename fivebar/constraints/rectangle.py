"""The largest axis-aligned rectangle in an aspect, touching its exact outline.

It is searched on samples of the outline, for the global optimum, then solved for on the exact
curves.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from ..base.checks import instance, optional, takes
from ..base.progress import progress
from ..singularities.aspects import Aspect
from .constraints import ON_POSES, Constraints, refuse_others
from .disc import CANDIDATES, BoundedAspect, bounded_by, clearance_at, too_narrow
from .outline import INWARDS, Outline

LEVELS = 64  # of the lower and of the upper border in the search


@dataclass(frozen=True)
class Rectangle:
    """Borders, m."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    @property
    def area(self) -> float:
        return (self.x_max - self.x_min) * (self.y_max - self.y_min)


@takes(aspect=instance(Aspect), constraints=optional(instance(Constraints)))
def largest_rectangle(aspect: Aspect, constraints: Constraints | None = None) -> Rectangle:
    """Return the largest rectangle along x and y in an aspect.

    Parameters
    ----------
    aspect : Aspect
        From `aspects`, `aspect` or `dexterous`.
    constraints : Constraints, optional
        Constraints on poses that hold all over the rectangle, and its clearance, m, from
        singularities and from the borders of the constraints.

    Returns
    -------
    Rectangle
        Borders x_min, x_max, y_min, y_max, m, accurate to 1e-6 of its size. It is the best of local
        solutions around points all over the aspect.

    Raises
    ------
    ValueError
        No rectangle keeps the clearance.

    Examples
    --------
    >>> import fivebar as fb
    >>> rectangle = fb.largest_rectangle(fb.aspect(fb.FiveBar(), 9))
    >>> round(1e4 * rectangle.area, 2)  # cm^2
    117.51
    """
    refuse_others(constraints, "largest_rectangle", (*ON_POSES, "clearance"))
    margin = constraints.clearance if constraints else 0.0
    aspect = bounded_by(aspect, constraints)
    outline = Outline(aspect, margin)
    starts = progress(_starts(outline), desc="rectangle", delay=2, leave=False)
    found = [each for start in starts if (each := _fitted(outline, start)) is not None]
    if not found:
        clearance = (
            _point_of_largest_clearance(outline)[1]
            if isinstance(aspect, BoundedAspect)
            else clearance_at(aspect, complex(*aspect.point))
        )
        raise ValueError(too_narrow(aspect, "rectangle", margin, clearance))
    return Rectangle(*map(float, max(found, key=_area)))


def _area(v):
    return (v[1] - v[0]) * (v[3] - v[2])


def _starts(outline):
    """Borders (4,) of the largest rectangles that pass between the obstacles, unlike one
    another.
    """
    found = [
        _around(outline, seed)
        for seed in progress(outline.seeds, desc="rectangle", delay=2, leave=False)
    ]
    order = sorted(range(len(found)), key=lambda k: -_area(found[k]))
    starts = []
    for k in order:
        if _area(found[k]) < 0.9 * _area(found[order[0]]) or len(starts) == CANDIDATES:
            break
        if all(
            np.abs(found[k] - other).max() > 0.05 * (np.ptp(other[:2]) + np.ptp(other[2:]))
            for other in starts
        ):
            starts.append(_around(outline, outline.seeds[k], rounds=4))
    starts = [each for each in starts if _area(each) > 0.98 * max(map(_area, starts))]
    # There is room for a square wherever there is for a disc.
    z, clearance = _point_of_largest_clearance(outline)
    if clearance <= outline.margin:
        return starts
    half = np.sqrt(0.5) * (clearance - outline.margin)
    return [*starts, np.array([z.real, z.real, z.imag, z.imag]) - half * INWARDS]


def _point_of_largest_clearance(outline):
    """About the point that is farthest from all that is kept off, and its exact distance; 0 where
    nothing is kept.
    """
    z = complex(*outline.aspect.point)
    if outline.allowed:
        if not len(outline.seeds):
            return z, 0.0
        z = outline.seeds[
            outline.tree.query(np.stack([outline.seeds.real, outline.seeds.imag], axis=-1))[
                0
            ].argmax()
        ]
    return z, clearance_at(outline.aspect, z)


def _around(outline, seed, rounds=1):
    """The largest rectangle around a point with no obstacle in it, by its highest and lowest y on
    so many levels.
    """
    z = outline.obstacles - seed
    k = np.searchsorted(z.imag, 0)
    beside = z.real[slice(*np.searchsorted(z.imag, [-outline.spacing, outline.spacing]))]
    ends = (
        beside[beside < 0].max(initial=z.real.min()),
        beside[beside >= 0].min(initial=z.real.max()),
    )
    halves, windows = [], []
    for x, y in ((z.real[k:], z.imag[k:]), (z.real[:k][::-1], -z.imag[:k][::-1])):
        left = np.maximum.accumulate(np.append(ends[0], np.where(x < 0, x, -np.inf)))
        right = np.minimum.accumulate(np.append(ends[1], np.where(x >= 0, x, np.inf)))
        passes = np.count_nonzero(right - left > outline.spacing)
        halves.append((y, left, right))
        windows.append((0.0, np.append(0.0, y)[min(passes, len(y))]))
    for _ in range(rounds):
        levels = [np.linspace(*window, LEVELS) for window in windows]
        (left, right), (left2, right2) = (
            [each[np.searchsorted(y, level)] for each in ends]
            for (y, *ends), level in zip(halves, levels)
        )
        low, high = np.maximum(left[:, None], left2), np.minimum(right[:, None], right2)
        area = np.maximum(high - low, 0) * (levels[0][:, None] + levels[1])
        best = np.unravel_index(np.argmax(area), area.shape)
        windows = [
            (level[max(i - 2, 0)], level[min(i + 2, LEVELS - 1)]) for level, i in zip(levels, best)
        ]
    top, bottom = (level[i] for level, i in zip(levels, best))
    return np.array([low[best], high[best], -bottom, top]) + np.repeat([seed.real, seed.imag], 2)


def _fitted(outline, start):
    """The largest rectangle near a start; None if nothing there keeps the margin."""
    v, reach = outline.shrunk(start, outline.spacing), 0.1
    for _ in range(12 if v is not None else 0):
        scale = np.repeat([v[1] - v[0], v[3] - v[2]], 2)
        kept = outline.broken(v - 4 * outline.spacing * INWARDS, 0.0)
        for _ in range(30):
            new = _grown(outline, v, scale, reach, sorted(kept))
            more = outline.broken(new, 1e-11 * scale.min()) - kept
            if not more:
                break
            kept |= more
        # Without a margin the rim would be singular where it touches.
        new = outline.shrunk(new, (1e-15 if outline.margin else 1e-11) * scale.max())
        if new is not None and np.abs((new - v) / scale).max() < 1e-9:
            break
        if new is not None and _area(new) > _area(v):
            v = new
        elif (reach := reach / 4) < 1e-4:
            break
    return v


def _grown(outline, v, scale, reach, kept):
    """The borders of the largest rectangle that keeps the margin from some pieces and ends, on its
    side of them.

    No border moves by more than `reach` times its side: what is in the way is seen before it is
    passed by far.
    """
    rules = [
        _off_piece(*outline.pieces[k]) if k >= 0 else _off_end(outline, outline.ends[-1 - k], v)
        for k in kept
    ]
    # Beyond its ends a piece limits nothing: what is kept off it already may be on the other side
    # of its tangent.
    rules = [rule for rule in rules if rule(v)[0] >= outline.margin]
    height = scale.min()

    @lru_cache(maxsize=4)
    def clearances(u):
        found, gradients = zip(*(rule(v + scale * u) for rule in rules))
        return (np.array(found) - outline.margin) / height, np.array(gradients) * scale / height

    def sides(u):
        return 1 + u[1] - u[0], 1 + u[3] - u[2]

    def shrinking(u):
        width, height = sides(u)
        return np.array([height, -height, width, -width])

    kept_off = dict(
        type="ineq", fun=lambda u: clearances(tuple(u))[0], jac=lambda u: clearances(tuple(u))[1]
    )
    solution = minimize(
        lambda u: -np.prod(sides(u)),
        np.zeros(4),
        jac=shrinking,
        bounds=[(-reach, reach)] * 4,
        constraints=[kept_off] if rules else [],
        method="SLSQP",
        options=dict(ftol=1e-13, maxiter=30),
    )
    return v + scale * solution.x


def _off_piece(arc, corner):
    """v -> signed distance of a corner from an arc, positive on its left, and its gradient; beyond,
    from a tangent.
    """

    def rule(v):
        z = complex(*v[list(corner)])
        (s,), _ = arc.nearest(np.array([z]))
        on, tangent = map(complex, arc.curve(s))
        normal, gradient = 1j * tangent / abs(tangent), np.zeros(4)
        gradient[list(corner)] = normal.real, normal.imag
        return ((z - on) * normal.conjugate()).real, gradient

    return rule


def _off_end(outline, z, start):
    """v -> distance of a point from the side of the rectangle that it is off at the start, or from
    its corner there.
    """
    beyond = np.array([start[0] - z.real, z.real - start[1], start[2] - z.imag, z.imag - start[3]])
    sides = [int(np.argmax(beyond[:2])), 2 + int(np.argmax(beyond[2:]))]
    if outline.margin == 0 or min(beyond[sides]) <= 0:
        sides = [max(sides, key=lambda k: beyond[k])]

    def rule(v):
        away = INWARDS[sides] * (v[sides] - np.array([z.real, z.real, z.imag, z.imag])[sides])
        away = np.maximum(away, 0) if away.max() > 0 else np.where(away == away.max(), away, 0)
        distance, gradient = np.copysign(np.hypot.reduce(away), away.sum()), np.zeros(4)
        gradient[sides] = INWARDS[sides] * (away / distance if distance else 1 / len(sides))
        return distance, gradient

    return rule
