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

from typing import NamedTuple

import numpy as np

from .constraint_rows import PARTS, ConstraintRows

# Of the limits, by which they are widened here and narrowed where a motion is made: rounding.
MARGIN = 1e-9
# Bernstein coefficients of t (1 - t).
BUMP = (0.0, 0.25, 1 / 3, 0.25, 0.0)
STEPS = 12  # of Newton
NUDGE = 1e-5  # of x, for its slopes
CLOSE = 1e-8  # of x
LOOSE = 1e-6  # of x, which Newton steps may leave above the parabolas
TRIES = 3  # at rows, or until one bounds
WIDENINGS = 14  # of the range of x and u, in which a parabola is proved


class Ceiling(NamedTuple):
    """A curve that no motion is above.

    x: at the nodes (n + 1,). time: least time (n,), s, on each stretch. size: largest |u| (n,) of
    the curves. stuck: the node that no motion passes, or None.
    """

    x: np.ndarray
    time: np.ndarray
    size: np.ndarray
    stuck: int | None


def caps(rows: ConstraintRows, alone: ConstraintRows) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest x with a feasible u, and the gaps below it.

    The first is (2, n), of both ends of stretches, < 0 where no x is feasible. The second is (2, m,
    n + 1), of the nodes: between low and high no u is feasible, 0 < low; a node's gaps fall, and
    the missing ones are nan.
    """
    result = []
    gaps: list[tuple] = [(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))]
    # The rows of the tip's acceleration, by themselves, leave a u up to the row of x alone.
    first = np.flatnonzero(~rows.tip)
    with np.errstate(all="ignore"):
        for end, at in enumerate((0, 2)):
            a, b, v, c = (rows.parts[name][at] for name in PARTS)
            da, db, dv, dc = (
                rows.slack[name] + 1e-13 * np.abs(value) for name, value in zip(PARTS, (a, b, v, c))
            )
            dc = dc + MARGIN * 4
            best = np.full(a.shape[1], np.inf)
            for k in first:
                # Two rows of unlike a: P x + V sqrt(x) <= Q, whatever u.
                P = _without_u(a, da, b, db, k)
                V = _without_u(a, da, v, dv, k)
                Q = -_without_u(a, da, c, dc, k)
                discriminant = V * V + 4 * P * Q
                square_root = np.sqrt(np.maximum(discriminant, 0.0))
                root = (square_root - V) / (2 * P)
                convex = P > 0
                negative = Q < 0
                none = convex & negative & ((V >= 0) | (discriminant < 0))
                none |= (P == 0) & (V >= 0) & negative
                bound = np.where(convex, root * root, np.inf)
                bound = np.where(none, -1.0, bound)
                opposed = a[k] * a < 0
                if V.any():
                    gap = opposed & (P < 0) & (V > 0) & (Q > 0) & (discriminant > 0)
                    low = (2 * Q / (V + square_root)) ** 2 * (1 + MARGIN)
                    high = ((V + square_root) / (2 * P)) ** 2 * (1 - MARGIN)
                    gap &= low < high
                    gaps.append((np.nonzero(gap)[1] + end, low[gap], high[gap]))
                bound = np.where(opposed, bound, np.inf)
                best = np.minimum(best, bound.min(axis=0))
            if alone.parts["b"].shape[1]:
                w = alone.parts["b"][at]
                limit = MARGIN - alone.parts["c"][at]
                bound = np.where(w > 0, limit / w, np.inf)
                best = np.minimum(best, bound.min(axis=0))
            result.append(best * (1 + MARGIN))
    return np.array(result), _gap_table(gaps, a.shape[1] + 1)


def _gap_table(gaps, count):
    """Return the table (2, m, count) of pieces (nodes, low, high), of each node highest first."""
    node, low, high = (np.concatenate(column) for column in zip(*gaps))
    order = np.lexsort((-low, node))
    node = node[order]
    rank = np.arange(len(node)) - np.searchsorted(node, node)
    table = np.full((2, max(rank, default=-1) + 1, count), np.nan)
    table[:, rank, node] = low[order], high[order]
    return table


def _below_gaps(x, gaps):
    """Return the largest x (m,) of a motion that is not above x, where these gaps are."""
    for low, high in zip(*gaps):
        x = np.where((low < x) & (x < high), low, x)
    return x


def _without_u(a, da, f, df, k):
    """Return the least f of row k and of each other row, weighted so that u drops out."""
    lowest = f - df
    least = np.abs(a[k]) * lowest + np.abs(a) * lowest[k]
    size = np.abs(f)
    return least - da[k] * size - da * size[k]


def ceiling(
    rows: ConstraintRows,
    alone: ConstraintRows,
    length: np.ndarray,
    top: np.ndarray,
    gaps: np.ndarray,
) -> Ceiling:
    """Return the Ceiling of n stretches of these lengths, m.

    At the nodes x <= top (n + 1,), and x is in none of their gaps.
    """
    n = len(length)
    back = slice(None, None, -1)
    forward = _table(rows)
    backward = _table(rows.turned(np.ones(n, dtype=bool)))[..., back]
    x, ahead = _swept(top, forward, length, gaps)
    stuck = np.flatnonzero(ahead[2] < 0) + 1
    if not len(stuck):
        x, behind = _swept(x[back], backward, length[back], gaps[..., back])
        x = x[back]
        behind = behind[:, back]
        stuck = np.flatnonzero(behind[2] < 0)
    if len(stuck):
        return Ceiling(x, np.zeros(n), np.zeros(n), int(stuck[0]))
    ahead = _above(x[:-1], forward, length)
    slopes = np.abs([*ahead[:2], *behind[:2]])
    size = np.where(np.isfinite(slopes), slopes, -np.inf).max(axis=0)
    time = _least_time(x[:-1], ahead, x[1:], behind, length)
    if alone.parts["b"].shape[1]:
        time = np.maximum(time, _cruise(alone, length))
    return Ceiling(x, time, np.where(size < 0, np.inf, size), None)


def _swept(top, table, h, gaps):
    """Return (x at the nodes (n + 1,), parabolas (3, n) from each to the next); where x is less
    than `top`, no parabola ends above it.

    Newton steps on all nodes at once come close; then x is raised wherever it is not proved,
    and let down where it is far above what is.
    """
    n = len(h)
    # Where x is free at first, it is taken to grow as it does from rest.
    grown = _above(np.zeros(n), table, h)[2]
    x = np.cumsum(np.insert(np.where(np.isfinite(grown), np.maximum(grown, 0.0), 0.0), 0, 0.0))
    x = np.where(np.isinf(top), x, top)
    for _ in range(STEPS):
        before = x
        less = before * (1 - NUDGE)
        end = _above(before[:-1], table, h)[2]
        with np.errstate(all="ignore"):
            slope = (end - _above(less[:-1], table, h)[2]) / (before - less)[:-1]
        below = _below_gaps(end, gaps[..., 1:])
        slope = np.where(below < end, 0.0, slope)
        end = below
        x = _recurrence(top, end, np.where(np.isfinite(slope), slope, 0.0), before)
        if np.allclose(x, before, rtol=CLOSE, atol=0.0):
            break
    curves = np.empty((3, n))
    moved = np.arange(n)
    while len(moved):
        curves[:, moved] = _above(x[moved], table[..., moved], h[moved])
        end = np.minimum(curves[2, moved], top[moved + 1])
        end = _below_gaps(end, gaps[..., moved + 1])
        known = x[moved + 1]
        more = (end > known) | (end < known * (1 - LOOSE))
        moved = moved[more] + 1
        x[moved] = end[more]
        moved = moved[moved < n]
    return x, curves


def _recurrence(top, end, slope, about):
    """Return x (n + 1,) with x[i + 1] = end[i] + slope[i] (x[i] - about[i]), from 0 to top."""
    x = [float(top[0])]
    for most, value, steep, old in zip(*(each.tolist() for each in (top[1:], end, slope, about))):
        here = value + steep * (x[-1] - old) if steep else value
        x.append(max(min(most, here + CLOSE * abs(here)), 0.0))
    return np.array(x)


def _table(rows):
    """Return (20, rows, n): a, b, v, c at three places, then bend and slack; a is nan in a row that
    bounds nothing.
    """
    a = rows.parts["a"]
    ends = np.minimum(a[0], a[2])
    middle = a[1] - rows.bend["a"] / 2
    least = np.minimum(ends, middle) - rows.slack["a"]
    largest = a.max(axis=0)
    positive = least > 1e-6 * largest
    counts = largest > 1e-9 * largest.max(axis=0)
    parts = [rows.parts[name] for name in PARTS]
    parts[0] = np.where(positive & counts, a, np.nan)
    bend = [rows.bend[name][None] for name in PARTS]
    slack = [rows.slack[name][None] for name in PARTS]
    return np.concatenate(parts + bend + slack)


def _above(x0, table, h):
    """Return (3, m): u0, u1, x1 of the lowest of the rows' parabolas from x0 (m,) that no motion
    can pass, inf where none bounds.
    """
    best = np.full((3, len(h)), np.inf)
    a0, _, _, b0, _, b1, v0, _, v1, c0, _, c1 = table[:12]
    with np.errstate(all="ignore"):
        root = np.sqrt(x0)
        u0 = -(b0 * x0 + c0 + v0 * root) / a0
        y = x0 + h * u0
        steep = table[2] + b1 * h
        rest = b1 * y + c1
        u1 = -rest / steep
        if v1.any():
            u1 = -(rest + v1 * np.sqrt(np.maximum(y + h * u1, 0.0))) / steep
        guess = u0 + u1
        guess = np.where((steep > 0) & np.isfinite(guess), guess, np.inf)
        # A row's parabola ends above its guess, far above it where its a is nearly 0.
        left = np.arange(len(h))
        for tries in range(len(guess)):
            if tries >= TRIES:
                left = left[np.isinf(best[2, left])]
            k = guess[:, left].argmin(axis=0)
            least = guess[k, left]
            open_ = x0[left] + h[left] * least < best[2, left]
            left = left[open_]
            if not len(left):
                break
            k = k[open_]
            found = _parabola(x0[left], table[:, k, left], h[left], least[open_])
            lower = found[2] < best[2, left]
            best[:, left[lower]] = found[:, lower]
            guess[k, left] = np.inf
    return best


def _parabola(x0, rows, h, guess):
    """Return (3, m): u0, u1, x1 by one row (20, m) each, `guess` about u0 + u1; inf where it bounds
    nothing.
    """
    result = np.full((3, len(h)), np.inf)
    left = np.arange(len(h))
    x1 = x0 + h * guess
    loose = 1e-3
    for _ in range(WIDENINGS):
        a0, am, a1, b0, bm, b1, v0, vm, v1, c0, cm, c1 = rows[:12]
        a_bend, b_bend, v_bend, c_bend, a_slack, b_slack, v_slack, c_slack = rows[12:]
        high = np.maximum(x0, x1) * (1 + loose)
        low = np.maximum(np.minimum(x0, x1) * (1 - loose), 0.0)
        if loose > 1:
            high = np.where(low == 0, 2 * high, high)
        r_high = np.sqrt(high)
        root = r_high
        if rows[6:9].any():
            # Least v sqrt(X) by parts of one sign.
            positive = (v0 > 0) & (vm > 0) & (v1 > 0)
            mixed = ~positive & ((v0 > 0) | (vm > 0) | (v1 > 0))
            v0, vm, v1 = np.where(mixed, rows[6:9].min(axis=0), rows[6:9])
            root = np.where(positive, np.sqrt(low), r_high)
        slope = np.abs(guess)
        size = 1.5 * np.maximum(slope, 1e-300) + loose * slope
        open_ = a_slack * size + b_slack * high + v_slack * r_high + c_slack + MARGIN
        bend = a_bend * size + b_bend * high + v_bend * r_high + c_bend
        drag0 = v0 * root
        drag1 = v1 * root
        u0 = -(b0 * x0 + drag0 + c0 - open_) / a0
        y = x0 + h * u0
        # The row's Bernstein coefficients 1 to 4 are p + q u1.
        rest1 = (drag0 + vm * root + c0 + cm) / 2
        rest2 = (drag0 + 4 * vm * root + drag1 + c0 + 4 * cm + c1) / 6
        rest3 = (vm * root + drag1 + cm + c1) / 2
        p = (
            (a0 + 2 * am) * u0 / 4 + (b0 * y + bm * x0) / 2 + rest1,
            (2 * am + a1) * u0 / 6 + (b0 * y + 4 * bm * y + b1 * x0) / 6 + rest2,
            a1 * u0 / 4 + (bm + b1) * y / 2 + rest3,
            b1 * y + drag1 + c1,
        )
        q = (a0 / 4, (a0 + 2 * am) / 6 + b0 * h / 6, (2 * am + a1) / 4 + bm * h / 2, a1 + b1 * h)
        terms = [(open_ + bend * bump - p_j) / q_j for bump, p_j, q_j in zip(BUMP[1:], p, q)]
        u1 = np.max(terms, axis=0)
        end = x0 + h * (u0 + u1)
        steepest = np.maximum(np.abs(u0), np.abs(u1))
        # No motion is below 0: a parabola that ends there is a bound if it counts roots from 0 on.
        above = (low == 0) | (low <= np.minimum(np.minimum(x0, end), y))
        below = np.maximum(np.maximum(x0, end), y) <= high
        never = np.min(q, axis=0) <= 0
        proved = (steepest <= size) & above & below & ~never
        result[:, left[proved]] = np.stack([u0, u1, end])[:, proved]
        more = ~(proved | never)
        left = left[more]
        if not len(left):
            break
        guess = np.copysign(np.maximum(slope, steepest), guess)[more]
        loose = loose * 2
        x0, x1, h = x0[more], end[more], h[more]
        rows = rows[:, more]
    return result


def duration(h: np.ndarray, x0: np.ndarray, x1: np.ndarray, bent: np.ndarray) -> np.ndarray:
    """Return the times, s, over stretches h on which x goes from x0 to x1 with x_ss = 2 bent; inf
    where it comes to rest within.
    """
    with np.errstate(all="ignore"):
        half = h / (np.sqrt(np.maximum(x0, 0.0)) + np.sqrt(np.maximum(x1, 0.0)))
        part = bent * half**2
        root = np.sqrt(np.abs(part))
        curved = np.where(part > 0, np.arctanh(np.minimum(root, 1.0)), np.arctan(root)) / root
        time = 2 * half * np.where(np.abs(part) < 1e-6, 1 + part / 3, curved)
    return np.where(np.isnan(time), np.inf, time)


def _least_time(x0, ahead, x1, behind, h):
    """Return the least times (n,) below both curves, from x0 on and back from x1."""
    best = np.zeros(len(h))
    curves = []
    with np.errstate(all="ignore"):
        for start, (u0, u1, end) in ((x0, ahead), (x1, behind)):
            bent = (u1 - u0) / h
            bounds = np.minimum(np.minimum(start + h * u0, start), end) >= 0
            bounds &= end < np.inf
            time = duration(h, start, end, bent)
            best = np.where(bounds, np.maximum(best, time), best)
            curves.append((start, u0, bent, end, bounds))
        (f0, fu, fk, f1, ahead_bounds), (g1, gu, gk, g0, behind_bounds) = curves
        # Where they meet: any place is valid, as below both is below either.
        a = fk - gk
        b = 2 * (fu + gu + gk * h)
        c = f0 - g0
        root = b * b - 4 * a * c
        s = -2 * c / (b + np.sqrt(root))
        meet = ahead_bounds & behind_bounds & (f1 > x1) & (g0 > x0)
        meet &= (b > 0) & (s > 0) & (s < h)
        rest = h - s
        before = duration(s, f0, f0 + s * (2 * fu + s * fk), fk)
        after = duration(rest, g1, g1 + rest * (2 * gu + rest * gk), gk)
        best = np.where(meet, np.maximum(best, before + after), best)
    return best * (1 - 1e-12)


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
