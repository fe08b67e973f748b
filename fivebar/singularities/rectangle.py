"""The largest axis-aligned rectangle in an aspect, touching its exact boundary.

It is searched on a lattice over the whole aspect, for the global optimum, then solved for on the exact curves.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .disc import CANDIDATES, arcs_of, checked_margin, punctures, room_at, too_narrow
from .regions import inside

LATTICE = 120, 400  # points in each direction on which rectangles are searched, at least and at most
CORNERS = (0, 2), (0, 3), (1, 2), (1, 3)  # of the borders x_min, x_max, y_min, y_max


@dataclass(frozen=True)
class Rectangle:
    """Borders, m."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    @property
    def area(self):
        return (self.x_max - self.x_min) * (self.y_max - self.y_min)


def largest_rectangle(aspect, margin=0.0):
    """The largest rectangle along x and y in an aspect that keeps `margin`, m, from all its singularities: Rectangle.

    Solved to 1e-6 of its size from the best starts on a lattice that has some points across the aspect where it is
    roomiest; what the lattice cannot tell apart, the search cannot.
    ValueError where no such rectangle keeps the margin.
    """
    margin = checked_margin(margin)
    best = None
    for start in _on_lattice(aspect, margin):
        found = _fitted(aspect, start, margin)
        if found is not None and (best is None or found.area > best.area):
            best = found
    if best is None:
        raise ValueError(too_narrow(aspect, "rectangle", margin, room_at(aspect, complex(*aspect.point))))
    return best


def _on_lattice(aspect, margin):
    """Starts (x_min, x_max, y_min, y_max): the largest rectangles of lattice points inside, unlike one another."""
    from scipy.spatial import cKDTree

    outline = np.concatenate(aspect.polygons)
    low, high = outline.min(axis=0), outline.max(axis=0)
    # A narrow aspect needs a narrow lattice: some points across it.
    counts = np.clip(4 * (high - low) / aspect.clearance, *LATTICE).astype(int)
    x, y = (np.linspace(*each) for each in zip(low, high, counts))
    points = np.stack(np.meshgrid(x, y), axis=-1)
    free = aspect.contains(points)
    for puncture in aspect.punctures:
        # No rectangle of the lattice's points may close over an isolated point between them.
        free &= (np.abs(points - puncture) > (x[1] - x[0], y[1] - y[0])).any(axis=-1)
    if margin > 0:
        free &= cKDTree(np.concatenate([outline, aspect.punctures])).query(points)[0] >= margin
    found = []
    for low in range(len(y)):
        # Columns that are free from this row up to each row above it, and the longest run of them.
        columns = np.logical_and.accumulate(free[low:], axis=0)
        if not columns[0].any():
            continue
        count = np.cumsum(columns, axis=1)
        run = count - np.maximum.accumulate(np.where(columns, 0, count), axis=1)
        last = run.argmax(axis=1)
        length = run.max(axis=1)
        high = int(np.argmax((length - 1) * np.arange(len(length))))
        area = (length[high] - 1) * high * (x[1] - x[0]) * (y[1] - y[0])
        if area > 0:
            found.append((area, x[last[high] - length[high] + 1], x[last[high]], y[low], y[low + high]))
    found.sort(reverse=True)
    starts = []
    for area, *borders in found:
        if area < 0.8 * found[0][0] or len(starts) == CANDIDATES:
            break
        if all(np.abs(np.subtract(borders, other)).max() > 0.1 * np.ptp(outline) for other in starts):
            starts.append(borders)
    return starts


def _fitted(aspect, start, margin):
    """The largest rectangle near a start; None if its solution is not in the aspect.

    What it may not pass is collected as it grows: extrema bound its sides, and each corner stays on its side of the
    arcs that it would have crossed on its way from the start.
    """
    arcs = arcs_of(aspect)
    flat, steep = (np.concatenate([points, punctures(aspect)]) for points in _extrema(arcs))
    start = np.array(start)
    v, pairs, bounds = start, [], _bounds(start, flat, steep, margin)
    for _ in range(30):
        scale = np.repeat([v[1] - v[0], v[3] - v[2]], 2)
        previous, v = v, _grown(v, scale, pairs, bounds, margin)
        tighter = np.array(_bounds(v, flat, steep, margin))
        bounds = [(max(a[0], b[0]), min(a[1], b[1])) for a, b in zip(bounds, tighter)]
        corners = np.array([complex(*v[[i, j]]) for i, j in CORNERS])
        crossed = [
            (i, j, arc)
            for (i, j), corner, within in zip(CORNERS, corners, inside(aspect.boundary, corners))
            for arc in ([] if within else _in_the_way(arcs, complex(*start[[i, j]]), corner))
            if (i, j, arc) not in pairs
        ]
        pairs += crossed
        if crossed:
            v = start  # from which all of them can be kept
        elif np.abs((v - previous) / scale).max() < 1e-9:
            break
    x_min, x_max, y_min, y_max = v + 1e-7 * scale * np.array([1, -1, 1, -1])
    between = np.linspace(0, 1, 200)
    x, y = x_min + between * (x_max - x_min), y_min + between * (y_max - y_min)
    rim = [(x, y[:1]), (x, y[-1:]), (x[:1], y), (x[-1:], y)]
    if not all(aspect.contains(np.stack(np.broadcast_arrays(*side), axis=-1)).all() for side in rim):
        return None
    return Rectangle(*map(float, v))


def _grown(v, scale, pairs, bounds, margin):
    """The borders of the largest rectangle within bounds whose corners stay on their side of their arcs.

    No border moves by more than a third at a time: what is in the way is seen before it is passed by far.
    """
    from scipy.optimize import minimize

    height = scale.min()

    @lru_cache(maxsize=4)
    def heights(u):
        borders, jacobian, found = v + scale * u, np.zeros((len(pairs), 4)), []
        for row, (i, j, arc) in zip(jacobian, pairs):
            distance, normal = _height(arc, complex(borders[i], borders[j]))
            row[i], row[j] = normal.real, normal.imag
            found.append(distance - margin)
        return np.array(found) / height, jacobian * scale / height

    def sides(u):
        return 1 + u[1] - u[0], 1 + u[3] - u[2]

    def shrinking(u):
        width, height = sides(u)
        return np.array([height, -height, width, -width])

    corner = dict(type="ineq", fun=lambda u: heights(tuple(u))[0], jac=lambda u: heights(tuple(u))[1])
    free = [
        (np.clip((low - own) / by, -0.3, 0.3), np.clip((high - own) / by, -0.3, 0.3))
        for (low, high), own, by in zip(bounds, v, scale)
    ]
    solution = minimize(
        lambda u: -np.prod(sides(u)),
        np.zeros(4),
        jac=shrinking,
        bounds=free,
        constraints=[corner] if pairs else [],
        method="SLSQP",
        options=dict(ftol=1e-14, maxiter=60),
    )
    return v + scale * solution.x


def _in_the_way(arcs, a, b):
    """The arcs whose polylines cross the way from a to b, and the arc that is nearest to b."""
    found = {min(arcs, key=lambda arc: arc.nearest(np.array([b]))[1][0])}
    for arc in arcs if a != b else ():
        z = (arc.z - a) / (b - a)  # the way is now from 0 to 1
        p, q = z[:-1], z[1:]
        k = np.flatnonzero((p.imag > 0) != (q.imag > 0))
        x = p.real[k] - p.imag[k] * (q.real[k] - p.real[k]) / (q.imag[k] - p.imag[k])
        if ((x > 0) & (x < 1)).any():
            found.add(arc)
    return sorted(found, key=arcs.index)


def _height(arc, z):
    """Signed distance of z from an arc, positive on its left, and its gradient; beyond its ends, from its tangent."""
    (s,), _ = arc.nearest(np.array([z]))
    on, tangent = map(complex, arc.curve(s))
    normal = 1j * tangent / abs(tangent)
    return ((z - on) * normal.conjugate()).real, normal


def _extrema(arcs):
    """Points of the arcs with a horizontal tangent, and with a vertical one."""
    found = []
    for part in (np.imag, np.real):
        points = []
        for arc in arcs:
            slope = part(arc.tangent(arc.s))
            for k in np.flatnonzero(slope[:-1] * slope[1:] <= 0):
                low, high = arc.s[k], arc.s[k + 1]
                for _ in range(60):
                    middle = (low + high) / 2
                    below = part(arc.tangent(middle)) * slope[k] > 0
                    low, high = (middle, high) if below else (low, middle)
                points.append(complex(arc.at((low + high) / 2)))
        found.append(np.array(points, dtype=complex))
    return found


def _bounds(v, flat, steep, margin):
    """Bounds of the four borders by the extrema that lie over, under or beside the rectangle v."""
    x_min, x_max, y_min, y_max = v
    middle = complex(x_min + x_max, y_min + y_max) / 2
    over = flat[(flat.real > x_min) & (flat.real < x_max)].imag
    beside = steep[(steep.imag > y_min) & (steep.imag < y_max)].real
    low, high = beside[beside < middle.real], beside[beside >= middle.real]
    under, above = over[over < middle.imag], over[over >= middle.imag]
    return [
        (max(low, default=-np.inf) + margin, middle.real),
        (middle.real, min(high, default=np.inf) - margin),
        (max(under, default=-np.inf) + margin, middle.imag),
        (middle.imag, min(above, default=np.inf) - margin),
    ]
