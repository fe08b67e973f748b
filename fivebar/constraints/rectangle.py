"""The largest axis-aligned rectangle in an aspect, touching its exact outline.

It is searched on samples of the outline, for the global optimum, then solved for on the exact
curves.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from ..base.backend import pairs
from ..base.checks import instance, positive, takes
from ..base.progress import progress
from ..singularities.aspects import Aspect
from .constraints import Constraints, kept_by
from .disc import bounded_by, clearance_at, farthest_point, too_narrow
from .outline import INWARDS, Outline

LEVELS = 64  # of the lower and of the upper border in the search
STARTS = 4  # rectangles of the search, that are solved for exactly


@dataclass(frozen=True)
class Rectangle:
    """A rectangle along x and y: its borders, m."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    @property
    def area(self) -> float:
        return (self.x_max - self.x_min) * (self.y_max - self.y_min)


@takes(aspect=instance(Aspect), constraints=kept_by("fb.largest_rectangle"))
def largest_rectangle(
    aspect: Aspect, constraints: Constraints | None = None, ratio: float | None = None
) -> Rectangle:
    """Return the largest rectangle along x and y in an aspect.

    Parameters
    ----------
    aspect : Aspect
        From `aspects`, `aspect` or `dexterous`.
    constraints : Constraints, optional
        Constraints on poses that hold all over the rectangle, and its clearance, m, from
        singularities and from the borders of the constraints.
    ratio : float, optional
        Width : height of the rectangle, from 0.01 to 100; free by default.

    Returns
    -------
    Rectangle
        Borders x_min, x_max, y_min, y_max, m, accurate to 1e-6 of its size. It is the best of local
        solutions around points all over the aspect.

    Raises
    ------
    ValueError
        No rectangle keeps the clearance, or none of that ratio is wide enough to be found.

    Examples
    --------
    >>> import fivebar as fb
    >>> rectangle = fb.largest_rectangle(fb.aspect(fb.FiveBar(), 9))
    >>> round(1e4 * rectangle.area, 2)  # cm^2
    161.56
    >>> sheet = fb.largest_rectangle(fb.aspect(fb.FiveBar(), 9), ratio=0.21 / 0.148)
    >>> round(1e3 * (sheet.y_max - sheet.y_min), 2)  # mm
    104.71
    """
    margin = constraints.clearance if constraints else 0.0
    if ratio is not None and not 0.01 <= positive(ratio, "ratio") <= 100:
        raise ValueError(f"largest_rectangle: ratio must be from 0.01 to 100, not {ratio:g}")
    aspect = bounded_by(aspect, constraints)
    outline = Outline(aspect, margin)
    starts = progress(_starts(outline, ratio), desc="rectangle", delay=2, leave=False)
    rectangles = [_fitted(outline, start, ratio) for start in starts]
    rectangles = [v for v in rectangles if v is not None]
    if not rectangles:
        _, clearance = farthest_point(aspect)
        if clearance <= margin:
            raise ValueError(too_narrow(aspect, "rectangle", margin, clearance))
        which = "" if ratio is None else f" with ratio {ratio:g}"
        raise ValueError(
            f"no rectangle{which} in aspect {aspect.number}: a side would be shorter than"
            f" {outline.spacing:.2g} m, which is not searched"
        )
    return Rectangle(*map(float, max(rectangles, key=_area)))


def _area(v):
    x_min, x_max, y_min, y_max = v
    return (x_max - x_min) * (y_max - y_min)


def _starts(outline, ratio=None):
    """Return borders (4,) of large rectangles between the obstacles, unlike one another."""
    seeds = progress(outline.seeds, desc="rectangle", delay=2, leave=False)
    rectangles = [_around(outline, seed, ratio) for seed in seeds]
    order = sorted(range(len(rectangles)), key=lambda k: -_area(rectangles[k]))
    starts = []
    for k in order:
        v = rectangles[k]
        if _area(v) < 0.9 * _area(rectangles[order[0]]):
            break
        if len(starts) == STARTS:
            break
        if any(_alike(v, other) for other in starts):
            continue
        starts.append(_around(outline, outline.seeds[k], ratio, rounds=4))
    largest = max(map(_area, starts), default=0.0)
    starts = [v for v in starts if _area(v) > 0.98 * largest]
    # A square fits wherever a disc does, and so does a rectangle of another ratio.
    z, clearance = _point_of_largest_clearance(outline, starts)
    if clearance <= outline.margin:
        return starts
    sides = np.repeat([1.0 if ratio is None else ratio, 1.0], 2)
    diagonal = np.hypot(*sides[1:3])
    half = sides / diagonal * (clearance - outline.margin)
    center = np.array([z.real, z.real, z.imag, z.imag])
    return [*starts, center - half * INWARDS]


def _alike(v, other):
    """Return whether no border is 5 % of the other's half rim away."""
    half_rim = np.ptp(other[:2]) + np.ptp(other[2:])
    return np.abs(v - other).max() <= 0.05 * half_rim


def _point_of_largest_clearance(outline, starts):
    """Return a point that is far from all obstacles, and its exact clearance.

    It is the farthest one where there are no other starts. The clearance is 0 where no point keeps
    the constraints.
    """
    if not starts:
        return farthest_point(outline.aspect)
    z = complex(*outline.aspect.point)
    if outline.allowed:
        distance, _ = outline.tree.query(pairs(outline.seeds))
        z = outline.seeds[distance.argmax()]
    return z, clearance_at(outline.aspect, z)


def _around(outline, seed, ratio=None, rounds=1):
    """Return the largest rectangle around a point with no obstacle in it.

    Its upper and its lower border are searched on LEVELS levels, in `rounds` ever narrower windows.
    """
    z = outline.obstacles - seed
    k = np.searchsorted(z.imag, 0)
    first, last = np.searchsorted(z.imag, [-outline.spacing, outline.spacing])
    level = z.real[first:last]
    left_end = level[level < 0].max(initial=z.real.min())
    right_end = level[level >= 0].min(initial=z.real.max())
    halves = []
    windows = []
    above = z[k:]
    below = z[:k][::-1].conj()
    for half in (above, below):
        x = half.real
        y = half.imag
        on_left = np.where(x < 0, x, -np.inf)
        on_right = np.where(x >= 0, x, np.inf)
        left = np.maximum.accumulate(np.append(left_end, on_left))
        right = np.minimum.accumulate(np.append(right_end, on_right))
        passes = np.count_nonzero(right - left > outline.spacing)
        halves.append((y, left, right))
        heights = np.append(0.0, y)
        windows.append((0.0, heights[min(passes, len(y))]))
    for _ in range(rounds):
        levels = []
        ends = []
        for window, (y, left, right) in zip(windows, halves):
            levels.append(np.linspace(*window, LEVELS))
            index = np.searchsorted(y, levels[-1])
            ends.append((left[index], right[index]))
        (upper_left, upper_right), (lower_left, lower_right) = ends
        low = np.maximum(upper_left[:, None], lower_left)
        high = np.minimum(upper_right[:, None], lower_right)
        width = np.maximum(high - low, 0)
        height = levels[0][:, None] + levels[1]
        if ratio is not None:
            width = np.minimum(width, ratio * height)
            height = width / ratio
        area = width * height
        best = np.unravel_index(np.argmax(area), area.shape)
        windows = []
        for level, i in zip(levels, best):
            lowest = level[max(i - 2, 0)]
            highest = level[min(i + 2, LEVELS - 1)]
            windows.append((lowest, highest))
    top = levels[0][best[0]]
    bottom = levels[1][best[1]]
    borders = np.array([low[best], high[best], -bottom, top])
    if ratio is not None:
        ends = [low[best] + high[best], top - bottom]
        sides = [width[best], height[best]]
        middle = np.repeat(ends, 2) / 2
        half = np.repeat(sides, 2) / 2
        borders = middle - half * INWARDS
    return borders + np.repeat([seed.real, seed.imag], 2)


def _fitted(outline, start, ratio=None):
    """Return the largest rectangle near a start; None if none there keeps the clearance."""
    inwards = INWARDS
    if ratio is not None:
        inwards = INWARDS * np.repeat([ratio, 1.0], 2) / max(ratio, 1.0)
    v = outline.shrunk(start, outline.spacing, inwards)
    reach = 0.1
    for _ in range(12 if v is not None else 0):
        width = v[1] - v[0]
        height = v[3] - v[2]
        scale = np.repeat([width, height], 2)
        kept = outline.broken(v - 4 * outline.spacing * INWARDS, 0.0)
        for _ in range(30):
            new = _grown(outline, v, scale, reach, sorted(kept), ratio)
            more = outline.broken(new, 1e-11 * scale.min()) - kept
            if not more:
                break
            kept |= more
        # Without a margin the rim would be singular where it touches.
        tolerance = 1e-15 if outline.margin else 1e-11
        new = outline.shrunk(new, tolerance * scale.max(), inwards)
        if new is not None:
            change = np.abs((new - v) / scale).max()
            if change < 1e-9:
                break
        if new is not None and _area(new) > _area(v):
            v = new
        else:
            reach = reach / 4
        if reach < 1e-4:
            break
    return v


def _grown(outline, v, scale, reach, kept, ratio=None):
    """Return borders of the largest rectangle that keeps the clearance from some pieces and ends.

    No border moves by more than `reach` times its side, so obstacles are seen before they are
    passed by far.
    """
    rules = []
    for k in kept:
        if k >= 0:
            rules.append(_off_piece(*outline.pieces[k]))
        else:
            rules.append(_off_end(outline, outline.ends[-1 - k], v))
    # Beyond its ends a piece limits nothing, and a rectangle there may violate its tangent.
    rules = [rule for rule in rules if rule(v)[0] >= outline.margin]
    height = scale.min()

    @lru_cache(maxsize=4)
    def clearances(u):
        borders = v + scale * u
        values, gradients = zip(*(rule(borders) for rule in rules))
        clearance = (np.array(values) - outline.margin) / height
        return clearance, np.array(gradients) * scale / height

    def sides(u):
        width = 1 + u[1] - u[0]
        height = 1 + u[3] - u[2]
        return width, height

    def shrinking(u):
        width, height = sides(u)
        return np.array([height, -height, width, -width])

    keeps_clearance = {
        "type": "ineq",
        "fun": lambda u: clearances(tuple(u))[0],
        "jac": lambda u: clearances(tuple(u))[1],
    }
    conditions = [keeps_clearance] if rules else []
    if ratio is not None:
        same_growth = np.array([-1.0, 1.0, 1.0, -1.0])
        conditions.append(
            {"type": "eq", "fun": lambda u: u @ same_growth, "jac": lambda u: same_growth}
        )
    solution = minimize(
        lambda u: -np.prod(sides(u)),
        np.zeros(4),
        jac=shrinking,
        bounds=[(-reach, reach)] * 4,
        constraints=conditions,
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 30},
    )
    return v + scale * solution.x


def _off_piece(arc, corner):
    """Return v -> (signed distance of a corner from an arc, positive on its left, its gradient).

    Beyond the arc's ends it is the distance from a tangent.
    """

    def rule(v):
        z = complex(*v[list(corner)])
        (s,), _ = arc.nearest(np.array([z]))
        on, tangent = map(complex, arc.curve(s))
        normal = 1j * tangent / abs(tangent)
        gradient = np.zeros(4)
        gradient[list(corner)] = normal.real, normal.imag
        return ((z - on) * normal.conjugate()).real, gradient

    return rule


def _off_end(outline, z, start):
    """Return v -> (distance of a point from the rectangle's nearest side or corner, its gradient).

    Which side or corner it is depends on the start only.
    """
    beyond = np.array([start[0] - z.real, z.real - start[1], start[2] - z.imag, z.imag - start[3]])
    sides = [int(np.argmax(beyond[:2])), 2 + int(np.argmax(beyond[2:]))]
    if outline.margin == 0 or min(beyond[sides]) <= 0:
        sides = [max(sides, key=lambda k: beyond[k])]

    def rule(v):
        point = np.array([z.real, z.real, z.imag, z.imag])
        away = INWARDS[sides] * (v[sides] - point[sides])
        if away.max() > 0:
            away = np.maximum(away, 0)
        else:
            away = np.where(away == away.max(), away, 0)
        distance = np.copysign(np.hypot.reduce(away), away.sum())
        if distance:
            share = away / distance
        else:
            share = 1 / len(sides)
        gradient = np.zeros(4)
        gradient[sides] = INWARDS[sides] * share
        return distance, gradient

    return rule
