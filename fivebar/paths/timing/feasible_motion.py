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
FINE = 34  # halvings in which a polygon's corner is found


def profile(found: Polygons, above: Ceiling, rest: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Return (x at the nodes (n + 1,), the nodes from which no motion leads on).

    rest (n + 1,): nodes at rest. From rest to rest x is 0 where there is such a node.
    """
    table, n = found.table, len(found.table)
    top = np.where(rest, 0.0, above.x)
    p, q, r = (np.ascontiguousarray(table[..., k]) for k in range(3))
    up = p > TINY
    down = p < -TINY
    flat = np.abs(p) <= TINY
    with np.errstate(all="ignore"):
        reach = np.where(flat, 0.0, -1 / p)
        # The x1 with which x0 = 0 is allowed.
        ends = -r / q
        first = np.where(q < -TINY, ends, 0.0).max(axis=1).tolist()
        last = np.where(q > TINY, ends, np.inf).min(axis=1).tolist()
    always = ~((np.abs(q) <= TINY) & (r > 0)).any(axis=1)
    corner = _corners(p, q, r, reach, top[1:], True).tolist()
    low = [0.0] * (n + 1)
    high = top.tolist()
    lowest = None
    stuck = []
    least = 1e-12 * above.x.max() + 1e-300
    begins = np.maximum.accumulate(np.where(rest[:-1], np.arange(n), 0)).tolist()
    i = n - 1
    while i >= 0:
        x1 = min(max(corner[i], low[i + 1]), high[i + 1])
        value = (r[i] + q[i] * x1) * reach[i]
        at_most = value[up[i]].min(initial=np.inf)
        can_rest = always[i] and max(first[i], low[i + 1]) <= min(last[i], high[i + 1])
        if not can_rest:
            if lowest is None:
                lowest = _corners(p, q, r, reach, top[1:], False)
            x1 = min(max(lowest[i], low[i + 1]), high[i + 1])
            value = (r[i] + q[i] * x1) * reach[i]
            low[i] = max(value[down[i]].max(initial=0.0), 0.0)
        high[i] = min(high[i], at_most)
        if not low[i] <= high[i]:
            if low[i] - high[i] > least or rest[i] and low[i] > 0:
                stuck.append(i)
                i = begins[i]
            low[i] = high[i] = max(high[i], 0.0)
        i -= 1
    return _forwards(p, q, r, low, high, begins, stuck)


def _forwards(p, q, r, low, high, begins, stuck):
    """Return the largest x from node to node, and the nodes from which none leads on."""
    n = len(p)
    x = [high[0]]
    closed = {begins[i] for i in stuck}
    up = q > TINY
    with np.errstate(all="ignore"):
        reach = np.where(up, -1 / q, 0.0)
    base = r * reach
    slope = p * reach
    for i in range(n):
        if begins[i] in closed:
            x.append(0.0)
            continue
        most = (base[i] + slope[i] * x[i])[up[i]].min(initial=np.inf)
        x.append(min(float(most), high[i + 1]))
        if x[-1] < low[i + 1] or (x[-1] <= 0 and i < n - 1 and high[i + 1] > 0):
            stuck.append(i)
            closed.add(begins[i])
            x[begins[i] + 1 :] = [0.0] * (i + 1 - begins[i])
    return np.array(x), stuck


def _corners(p, q, r, reach, top, largest):
    """Return for each polygon the x1 in [0, top] at which x0 is largest, or least, (n,)."""
    low = np.zeros(len(p))
    high = top.copy()
    left = np.arange(len(p))
    good = np.full(len(p), np.nan)
    for k in range(FINE):
        if k == 0:
            x1 = high[left]
        else:
            x1 = (low[left] + high[left]) / 2
        p_ = p[left]
        q_ = q[left]
        reach_ = reach[left]
        value = r[left] + q_ * x1[:, None]
        x0 = value * reach_
        index = np.arange(len(left))
        most = np.where(p_ > TINY, x0, np.inf)
        least = np.where(p_ < -TINY, x0, -np.inf)
        wrong = np.where(np.abs(p_) <= TINY, value, -np.inf)
        i = most.argmin(axis=1)
        j = least.argmax(axis=1)
        m = wrong.argmax(axis=1)
        slope_i = q_[index, i] * reach_[index, i]
        slope_j = q_[index, j] * reach_[index, j]
        closed = most[index, i] < least[index, j]
        outside = wrong[index, m] > 0
        slope = np.where(closed, slope_i - slope_j, slope_i if largest else -slope_j)
        slope = np.where(outside, -q_[index, m], slope)
        good[left] = np.where(closed | outside, good[left], x1)
        low[left] = np.where(slope > 0, x1, low[left])
        high[left] = np.where(slope > 0, high[left], x1)
        if k == 0:
            # Most are done: x0 grows up to the top.
            left = left[(slope < 0) | closed | outside]
            if not len(left):
                break
    return np.where(np.isnan(good), (low + high) / 2, good)
