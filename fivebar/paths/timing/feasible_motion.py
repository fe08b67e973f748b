"""The fastest motion that the polygons of all stretches allow, nearly as fast as the ceiling.

A pass backwards gives for each node the x from which the end can be reached; one forwards takes the
largest it can (Pham and Pham, A new approach to time-optimal path parameterization based on
reachability analysis, 2018).
"""

from __future__ import annotations

import numpy as np

from .lower_bound import Ceiling
from .polygons import Polygons

TINY = 1e-12  # share of a row's coefficients that counts as 0
LOOKS = 20  # at most at a polygon, for its corner
FORBIDDEN = 1e6  # times what a line forbids


def profile(found: Polygons, above: Ceiling, rest: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Return (x at the nodes (n + 1,), the nodes from which no motion leads on).

    rest (n + 1,): nodes at rest. From rest to rest x is 0 where there is such a node.
    """
    table, n = found.table, len(found.table)
    top = np.where(rest, 0.0, above.x)
    p, q, r = (np.ascontiguousarray(table[..., k]) for k in range(3))
    up = p > TINY
    down = p < -TINY
    with np.errstate(all="ignore"):
        reach = np.where(np.abs(p) <= TINY, 0.0, -1 / p)
        # The x1 with which x0 = 0 is allowed.
        ends = -r / q
        first = np.where(q < -TINY, ends, 0.0).max(axis=1)
        last = np.where(q > TINY, ends, np.inf).min(axis=1)
    always = ~((np.abs(q) <= TINY) & (r > 0)).any(axis=1)
    corner = _corners(p, q, r, reach, top[1:], True)
    base = r * reach
    slope = q * reach
    most = np.where(up, base, np.inf)
    steep = np.where(up, slope, 0.0)
    corner, always, first, last = (each.tolist() for each in (corner, always, first, last))
    low = [0.0] * (n + 1)
    high = top.tolist()
    lowest = None
    stuck = []
    least = 1e-12 * above.x.max() + 1e-300
    begins = np.maximum.accumulate(np.where(rest[:-1], np.arange(n), 0)).tolist()
    i = n
    while i > 0:
        i -= 1
        x1 = min(max(corner[i], low[i + 1]), high[i + 1])
        high[i] = min(high[i], float((most[i] + steep[i] * x1).min()))
        if not (always[i] and max(first[i], low[i + 1]) <= min(last[i], high[i + 1])):
            if lowest is None:
                lowest = _corners(p, q, r, reach, top[1:], False)
            x1 = min(max(lowest[i], low[i + 1]), high[i + 1])
            value = (base[i] + slope[i] * x1)[down[i]]
            low[i] = max(float(value.max(initial=0.0)), 0.0)
        if not low[i] <= high[i]:
            if low[i] - high[i] > least or rest[i] and low[i] > 0:
                stuck.append(i)
                i = begins[i]
            low[i] = high[i] = max(high[i], 0.0)
    return _forwards(p, q, r, low, high, begins, stuck)


def _forwards(p, q, r, low, high, begins, stuck):
    """Return the largest x from node to node, and the nodes from which none leads on."""
    n = len(p)
    x = [high[0]]
    closed = {begins[i] for i in stuck}
    with np.errstate(all="ignore"):
        reach = np.where(q > TINY, -1 / q, 0.0)
    most = np.where(q > TINY, r * reach, np.inf)
    steep = p * reach
    for i in range(n):
        if begins[i] in closed:
            x.append(0.0)
            continue
        end = min(float((most[i] + steep[i] * x[i]).min()), high[i + 1])
        x.append(end)
        if end < low[i + 1] or (end <= 0 and i < n - 1 and high[i + 1] > 0):
            stuck.append(i)
            closed.add(begins[i])
            x[begins[i] + 1 :] = [0.0] * (i + 1 - begins[i])
    return np.array(x), stuck


def _corners(p, q, r, reach, top, largest):
    """Return for each polygon the x1 in [0, top] at which x0 is largest, or least, (n,).

    Of a concave function of straight lines, x0 less what forbids it times FORBIDDEN, the top is
    sought where the lines that are met on both sides of it cross.
    """
    left = _lines(p, q, r, reach, 0.0 * top, largest)
    right = _lines(p, q, r, reach, top, largest)
    corner = np.where(left[:, 1] <= 0, 0.0, top)
    open_ = np.flatnonzero((left[:, 1] > 0) & (right[:, 1] < 0))
    for _ in range(LOOKS):
        (c0, s0), (c1, s1) = left[open_].T, right[open_].T
        x1 = np.clip((c1 - c0) / (s0 - s1), 0.0, top[open_])
        corner[open_] = x1
        line = _lines(p[open_], q[open_], r[open_], reach[open_], x1, largest)
        rises = line[:, 1] > 0
        left[open_[rises]] = line[rises]
        right[open_[~rises]] = line[~rises]
        known = c0 + s0 * x1
        met = np.abs(line[:, 0] + line[:, 1] * x1 - known) <= 1e-12 * np.abs(known)
        open_ = open_[~met & (line[:, 1] != 0)]
        if not len(open_):
            break
    return corner


def _lines(p, q, r, reach, x1, largest):
    """Return the lines (n, 2), constant and slope, of which `_corners` tells, at x1 (n,)."""
    value = r + q * x1[:, None]
    x0 = value * reach
    index = np.arange(len(x1))
    slopes = q * reach
    i = np.where(p > TINY, x0, np.inf).argmin(axis=1)
    j = np.where(p < -TINY, x0, -np.inf).argmax(axis=1)
    m = np.where(np.abs(p) <= TINY, value, -np.inf).argmax(axis=1)
    most, least = x0[index, i], x0[index, j]
    slope = slopes[index, i] if largest else -slopes[index, j]
    found = most if largest else -least
    closed = FORBIDDEN * (least > most)
    outside = FORBIDDEN * ((np.abs(p[index, m]) <= TINY) & (value[index, m] > 0))
    slope = slope + closed * (slopes[index, i] - slopes[index, j]) - outside * q[index, m]
    found = found + closed * (most - least) - outside * value[index, m]
    return np.stack([found - slope * x1, slope], axis=1)
