"""The largest x = s'^2 from rest to rest that polygons of x at both ends of stretches allow.

A pass backwards gives for each node the x from which the end can be reached; one forwards takes the
largest it can (Pham and Pham, A new approach to time-optimal path parameterization based on
reachability analysis, 2018). From polygons that no motion leaves it gives a curve that none is
above; from polygons in which all limits hold, a motion.
"""

from __future__ import annotations

import numpy as np

TINY = 1e-12  # share of a row's coefficients that counts as 0, and of x
LOOKS = 20  # at most at a polygon, for its corner
FORBIDDEN = 1e6  # times what a line forbids


def profile(table: np.ndarray, top: np.ndarray, rest: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Return (x at the nodes (n + 1,), the nodes from which no motion leads on).

    table (n, rows, 3): p x0 + q x1 + r <= 0 at both ends of each stretch; of each, a row bounds x0
    from above, and one from below. top, rest (n + 1,): the largest x, and nodes at rest. From rest
    to rest x is 0 where there is a node from which none leads on.
    """
    n = len(table)
    # Over 0.0, not over -0.0, a row of r > 0 alone leaves no x.
    p, q, r = (np.ascontiguousarray(table[..., k] + 0.0) for k in range(3))
    up = p > TINY
    down = p < -TINY
    flat = ~(up | down)
    with np.errstate(all="ignore"):
        reach = np.where(flat, 0.0, -1 / p)
        ends = np.where(flat, -r / q, np.nan)
    low = np.append(0.0, np.fmax.reduce(ends, axis=1, where=q < 0, initial=0.0))
    high = np.append(np.inf, np.fmin.reduce(ends, axis=1, where=q >= 0, initial=np.inf))
    high = np.minimum(high, np.where(rest, 0.0, top))
    base = r * reach
    slope = q * reach
    highest, lowest = (
        _corners(base, slope, up, down, high[1:], largest).tolist() for largest in (True, False)
    )
    most = np.where(up, base, np.inf)
    least = np.where(down, base, -np.inf)
    low, high = low.tolist(), high.tolist()
    stuck = []
    begins = np.maximum.accumulate(np.where(rest[:-1], np.arange(n), 0)).tolist()
    i = n
    while i > 0:
        i -= 1
        x1 = min(max(highest[i], low[i + 1]), high[i + 1])
        high[i] = min(high[i], float((most[i] + slope[i] * x1).min()))
        x1 = min(max(lowest[i], low[i + 1]), high[i + 1])
        low[i] = max(low[i], float((least[i] + slope[i] * x1).max()))
        if low[i] > high[i]:
            if low[i] > high[i] + TINY * high[i + 1]:
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


def _corners(base, slope, up, down, top, largest):
    """Return for each polygon the x1 in [0, top] at which x0 is largest, or least, (n,).

    base, slope (n, rows): lines in x1 that bound x0 from above (up) and below (down). Of a concave
    function of straight lines, x0 less what forbids it times FORBIDDEN, the top is sought where the
    lines that are met on both sides of it cross.
    """
    tables = np.stack([base, slope]), up, down
    top = np.maximum(top, 0.0)
    left = _lines(*tables, 0.0 * top, largest)
    right = _lines(*tables, top, largest)
    corner = np.where(left[1] <= 0, 0.0, top)
    open_ = np.flatnonzero((left[1] > 0) & (right[1] < 0))
    for _ in range(LOOKS):
        (c0, s0), (c1, s1) = left[:, open_], right[:, open_]
        x1 = np.clip((c1 - c0) / (s0 - s1), 0.0, top[open_])
        corner[open_] = x1
        line = _lines(*(each[..., open_, :] for each in tables), x1, largest)
        rises = line[1] > 0
        left[:, open_[rises]] = line[:, rises]
        right[:, open_[~rises]] = line[:, ~rises]
        known = c0 + s0 * x1
        met = np.abs(line[0] + line[1] * x1 - known) <= TINY * np.abs(known)
        open_ = open_[~met & (line[1] != 0)]
        if not len(open_):
            break
    return corner


def _lines(lines, up, down, x1, largest):
    """Return the lines (2, n), constant and slope, of which `_corners` tells, at x1 (n,)."""
    x0 = lines[0] + lines[1] * x1[:, None]
    index = np.arange(len(x1))
    i = index, np.where(up, x0, np.inf).argmin(axis=1)
    j = index, np.where(down, x0, -np.inf).argmax(axis=1)
    most, least = lines[:, *i], lines[:, *j]
    return (most if largest else -least) + FORBIDDEN * (x0[j] > x0[i]) * (most - least)
