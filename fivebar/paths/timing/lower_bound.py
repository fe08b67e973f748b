"""A curve that no motion along a path can pass: from it, a lower bound of the time.

Every limit is a row a u + b x + v sqrt(x) + c <= 0 with x = s'^2, u = x_s / 2. Let a > 0 on a
stretch, and X a function of s with a X_s / 2 + b X + v sqrt(X) + c > 0 throughout. A motion with x
<= X at the start of the stretch stays below: where it first met X it would have x_s <= -2 (b X + v
sqrt(X) + c) / a < X_s. So X bounds it, whatever else limits it; where a < 0 the same holds
backwards from the stretch's end. Here X is a parabola with X_s / 2 = u0 + (u1 - u0) t, the row's
left side a polynomial of degree 4 in t but for what `bounds` leaves open, and its Bernstein
coefficients, all kept above 0, prove the sign. Where two rows leave no u at all, x is bounded at
once (the maximum velocity curve). With friction or motors' lines they may leave u again for a
larger x. A motion whose x is bounded within such a gap is below the gap. So every motion has
sqrt(x) below the square root of the least of these curves, and its time is at least the integral of
one over it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .constraint_rows import PARTS, ConstraintRows

# Of the limits, by which they are widened here and narrowed where a motion is made: rounding.
MARGIN = 1e-9
# Bernstein coefficients of t (1 - t).
BUMP = (0.0, 0.25, 1 / 3, 0.25, 0.0)
FREE = (math.inf, math.inf, math.inf)  # a parabola that bounds nothing


class Ceiling(NamedTuple):
    """A curve that no motion is above.

    x: at the nodes (n + 1,). time: least time (n,), s, on each stretch. size: largest |u| (n,) of
    the curves. stuck: the stretch that no motion passes, or None.
    """

    x: np.ndarray
    time: np.ndarray
    size: np.ndarray
    stuck: int | None


def caps(rows: ConstraintRows, alone: ConstraintRows) -> tuple[np.ndarray, list[list]]:
    """Return the largest x with a feasible u, and the gaps below it.

    The first is (2, n), of both ends of stretches, < 0 where no x is feasible. The second is a list
    for each of the n + 1 nodes, of (low, high): between these no u is feasible, 0 < low.
    """
    result = []
    nodes = rows.parts["a"].shape[2] + 1
    gaps: list[list] = [[] for _ in range(nodes)]
    with np.errstate(all="ignore"):
        for end, at in enumerate((0, 2)):
            a, b, v, c = (rows.parts[name][at] for name in PARTS)
            da = rows.slack["a"] + 1e-13 * np.abs(a)
            db = rows.slack["b"] + 1e-13 * np.abs(b)
            dv = rows.slack["v"] + 1e-13 * np.abs(v)
            dc = rows.slack["c"] + 1e-13 * np.abs(c) + MARGIN * 4
            best = np.full(a.shape[1], np.inf)
            for k in range(len(a)):
                # Row k with a > 0 and others with a < 0: P x + V sqrt(x) <= Q, whatever u.
                up = a[k]
                down = -a
                P = _without_u(a, da, b, db, k)
                V = _without_u(a, da, v, dv, k)
                Q = -_without_u(a, da, c, dc, k)
                discriminant = V * V + 4 * P * Q
                square_root = np.sqrt(np.maximum(discriminant, 0.0))
                root = (-V + square_root) / (2 * P)
                convex = P > 0
                negative = Q < 0
                none = convex & negative & ((V >= 0) | (discriminant < 0))
                none |= (P == 0) & (V >= 0) & negative
                bound = np.where(convex, root * root, np.inf)
                bound = np.where(none, -1.0, bound)
                opposed = (up > 0) & (down > 0)
                if V.any():
                    gap = opposed & (P < 0) & (V > 0)
                    gap &= (Q > 0) & (discriminant > 0)
                    root = V + square_root
                    low = (2 * Q / root) ** 2 * (1 + MARGIN)
                    high = (root / (2 * P)) ** 2 * (1 - MARGIN)
                    gap &= low < high
                    _, stretch = np.nonzero(gap)
                    limits = np.stack([low[gap], high[gap]], axis=-1)
                    for i, pair in zip(stretch.tolist(), limits.tolist()):
                        gaps[i + end].append(pair)
                bound = np.where(opposed, bound, np.inf)
                best = np.minimum(best, bound.min(axis=0))
            if alone.parts["b"].shape[1]:
                w = alone.parts["b"][at]
                limit = MARGIN - alone.parts["c"][at]
                bound = np.where(w > 0, limit / w, np.inf)
                best = np.minimum(best, bound.min(axis=0))
            result.append(best * (1 + MARGIN))
    return np.array(result), gaps


def _below_gaps(x, gaps):
    """Return the largest x of a motion that is not above x, where these gaps (low, high) are."""
    for low, high in sorted(gaps, reverse=True):
        if low < x < high:
            x = low
    return x


def _without_u(a, da, f, df, k):
    """Return the least f of row k, a > 0, and of each other row, weighted so that u drops out."""
    lowest = f - df
    least = a[k] * lowest - a * lowest[k]
    size = np.abs(f)
    return least - da[k] * size - da * size[k]


def ceiling(
    rows: ConstraintRows,
    alone: ConstraintRows,
    length: np.ndarray,
    top: np.ndarray,
    gaps: list[list],
) -> Ceiling:
    """Return the Ceiling of n stretches of these lengths, m.

    At the nodes x <= top (n + 1,), and x is in none of their gaps.
    """
    n = len(length)
    x = top.tolist()
    h = length.tolist()
    forward = _lists(rows, 1)
    backward = _lists(rows, -1)
    ahead = [FREE] * n
    behind = [FREE] * n
    for i in range(n):
        ahead[i] = _above(x[i], forward[i], h[i])
        end = min(x[i + 1], ahead[i][2])
        x[i + 1] = _below_gaps(end, gaps[i + 1])
        if x[i + 1] < 0:
            return Ceiling(np.array(x), np.zeros(n), np.zeros(n), i)
    for i in reversed(range(n)):
        behind[i] = _above(x[i + 1], backward[i], h[i])
        start = min(x[i], behind[i][2])
        x[i] = _below_gaps(start, gaps[i])
        if x[i] < 0:
            return Ceiling(np.array(x), np.zeros(n), np.zeros(n), i)
    time = np.zeros(n)
    size = np.zeros(n)
    for i in range(n):
        ahead[i] = _above(x[i], forward[i], h[i])
        time[i] = _least_time(x[i], ahead[i], x[i + 1], behind[i], h[i])
        slopes = [*ahead[i][:2], *behind[i][:2]]
        sizes = [abs(u) for u in slopes if math.isfinite(u)]
        size[i] = max(sizes, default=math.inf)
    if alone.parts["b"].shape[1]:
        cruise = _cruise(alone, length)
        time = np.maximum(time, cruise)
    return Ceiling(np.array(x), time, size, None)


def _lists(rows, way):
    """Return each stretch's rows with a > 0 (way 1), or backwards those with a < 0, as numbers."""
    a, b, v, c = (rows.parts[name][::way] for name in PARTS)
    a = way * a
    ends = np.minimum(a[0], a[2])
    middle = a[1] - rows.bend["a"] / 2
    least = np.minimum(ends, middle) - rows.slack["a"]
    largest = a.max(axis=0)
    positive = least > 1e-6 * largest
    counts = largest > 1e-9 * largest.max(axis=0)
    fits = positive & counts
    bend = np.stack([rows.bend[name] for name in PARTS])
    slack = np.stack([rows.slack[name] for name in PARTS])
    table = np.concatenate([a, b, v, c, bend, slack])
    table = table.transpose(2, 1, 0)
    return [stretch[kept].tolist() for stretch, kept in zip(table, fits.T)]


def _above(x0, rows, h):
    """Return (u0, u1, x1), the lowest of the rows' parabolas from x0 that no motion can pass."""
    if x0 == math.inf:
        return FREE
    root0 = math.sqrt(x0)
    guesses = []
    for row in rows:
        a0, _, a1, b0, _, b1, v0, _, v1, c0, _, c1 = row[:12]
        u0 = -(b0 * x0 + v0 * root0 + c0) / a0
        steep = a1 + b1 * h
        y = x0 + h * u0
        if steep <= 0:
            continue
        u1 = -(b1 * y + c1) / steep
        if v1:
            end = max(y + h * u1, 0.0)
            root1 = math.sqrt(end)
            u1 = -(b1 * y + v1 * root1 + c1) / steep
        guesses.append((u0 + u1, row))
    best = FREE
    # A row's parabola ends above its guess, far above it where its a is nearly 0.
    for guess, row in sorted(guesses):
        if x0 + h * guess >= best[2]:
            break
        parabola = _parabola(x0, row, h, guess)
        best = min(best, parabola, key=_end)
    return best


def _end(parabola):
    return parabola[2]


def _parabola(x0, row, h, guess):
    """Return (u0, u1, x1) of one row, `guess` about u0 + u1; FREE where it bounds nothing."""
    a0, am, a1, b0, bm, b1, v0, vm, v1, c0, cm, c1 = row[:12]
    (a_bend, b_bend, v_bend, c_bend, a_slack, b_slack, v_slack, c_slack) = row[12:]
    x1 = x0 + h * guess
    loose = 1e-3
    for _ in range(60):
        high = max(x0, x1)
        low = min(x0, x1)
        low = max(low * (1 - loose), 0.0)
        high = high * (1 + loose)
        if low == 0 and loose > 1:
            high *= 2
        # Least v sqrt(X) by parts of one sign.
        r_low = math.sqrt(low)
        r_high = math.sqrt(high)
        root = r_high
        if v0 > 0 and vm > 0 and v1 > 0:
            root = r_low
        elif not (v0 <= 0 and vm <= 0 and v1 <= 0):
            v0 = vm = v1 = min(v0, vm, v1)
        slope = abs(guess)
        size = 1.5 * max(slope, 1e-300) + loose * slope
        open_ = a_slack * size + b_slack * high + v_slack * r_high
        open_ = open_ + c_slack + MARGIN
        bend = a_bend * size + b_bend * high
        bend = bend + v_bend * r_high + c_bend
        drag0 = v0 * root
        drag1 = v1 * root
        u0 = -(b0 * x0 + drag0 + c0 - open_) / a0
        y = x0 + h * u0
        # The row's Bernstein coefficients 1 to 4 are p + q u1.
        left1 = (a0 * u0 + 2 * am * u0) / 4
        left2 = (2 * am * u0 + a1 * u0) / 6
        left3 = a1 * u0 / 4
        speed1 = (b0 * y + bm * x0) / 2
        speed2 = (b0 * y + 4 * bm * y + b1 * x0) / 6
        speed3 = (bm + b1) * y / 2
        rest1 = (drag0 + vm * root + c0 + cm) / 2
        rest2 = (drag0 + 4 * vm * root + drag1 + c0 + 4 * cm + c1) / 6
        rest3 = (vm * root + drag1 + cm + c1) / 2
        p = (
            left1 + speed1 + rest1,
            left2 + speed2 + rest2,
            left3 + speed3 + rest3,
            b1 * y + drag1 + c1,
        )
        q = (a0 / 4, (a0 + 2 * am) / 6 + b0 * h / 6, (2 * am + a1) / 4 + bm * h / 2, a1 + b1 * h)
        if min(q) <= 0:
            return FREE
        terms = zip(BUMP[1:], p, q)
        u1 = max((open_ + bend * bump - p_j) / q_j for bump, p_j, q_j in terms)
        end = x0 + h * (u0 + u1)
        steepest = max(abs(u0), abs(u1))
        # No motion is below 0: a parabola that ends there is a bound if it counts roots from 0 on.
        above = low == 0 or low <= min(x0, end, y)
        below = max(x0, end, y) <= high
        if steepest <= size and above and below:
            return u0, u1, end
        guess = math.copysign(max(slope, steepest), guess)
        loose = loose * 2
        x1 = end
    return FREE


def duration(h: float, x0: float, x1: float, bent: float) -> float:
    """Return the time, s, over a stretch h on which x goes from x0 to x1 with x_ss = 2 bent."""
    total = math.sqrt(max(x0, 0.0)) + math.sqrt(max(x1, 0.0))
    if total == 0:
        return math.inf
    half = h / total
    part = bent * half**2
    if abs(part) < 1e-6:
        return 2 * half * (1 + part / 3)
    root = math.sqrt(abs(part))
    if part > 0 and root >= 1:
        return math.inf
    if part > 0:
        return 2 * half * math.atanh(root) / root
    return 2 * half * math.atan(root) / root


def _least_time(x0, ahead, x1, behind, h):
    """Return the least time below both curves, from x0 on and back from x1."""
    curves = []
    bounds = []
    for start, (u0, u1, end) in ((x0, ahead), (x1, behind)):
        lowest = min(start + h * u0, start, end)
        if end < math.inf and lowest >= 0:
            bent = (u1 - u0) / h
            time = duration(h, start, end, bent)
            bounds.append(time)
            curves.append((start, u0, bent, end))
    if len(curves) == 2 and curves[0][3] > x1 and curves[1][3] > x0:
        first, last = curves
        f0, fu, fk, _ = first
        g0, gu, gk, g1 = last
        # Where they meet: any place is valid, as below both is below either.
        a = fk - gk
        b = 2 * (fu + gu + gk * h)
        c = f0 - g1
        root = b * b - 4 * a * c
        s = 0.0
        if root >= 0 and b > 0:
            s = -2 * c / (b + math.sqrt(root))
        if 0 < s < h:
            rest = h - s
            before = duration(s, f0, f0 + s * (2 * fu + s * fk), fk)
            after = duration(rest, g0, g0 + rest * (2 * gu + rest * gk), gk)
            bounds.append(before + after)
    return max(bounds, default=0.0) * (1 - 1e-12)


def _cruise(alone, length):
    """Return the least time (n,), s, by rows w x + c <= 0, c < 0 constant: of sqrt(w / -c)."""
    w = alone.parts["b"]
    c = -alone.parts["c"][0] + MARGIN
    chord = (w[0] + w[2]) / 2
    sag = np.maximum(chord - w[1], 0.0)
    less = sag / 2 + alone.bend["b"] / 4 + alone.slack["b"]
    first = np.maximum(w[0] - less, 0.0) / c
    last = np.maximum(w[2] - less, 0.0) / c
    roots = np.sqrt(first) + np.sqrt(last)
    squares = first + np.sqrt(first * last) + last
    with np.errstate(all="ignore"):
        mean = np.where(roots > 0, 2 / 3 * squares / roots, 0.0)
    return (mean * length).max(axis=0)
