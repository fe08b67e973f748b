"""A curve that no motion along a path can pass: from it, a lower bound of the time.

Every limit is a row a u + b x + v sqrt(x) + c <= 0 with x = s'^2, u = x_s / 2. Let a > 0 on a
stretch, and X a function of s with a X_s / 2 + b X + v sqrt(X) + c > 0 throughout. A motion with x
<= X at the start of the stretch stays below: where it first met X it would have x_s <= -2 (b X + v
sqrt(X) + c) / a < X_s. So X bounds it, whatever else limits it; where a < 0 the same holds
backwards from the stretch's end. Here each row is u <= beta x + gamma for all x >= 0 that a motion
may have, with beta and gamma linear in t, from 0 to 1 along the stretch. X is a parabola with
X_s / 2 = u0 + (u1 - u0) t that has X_s / 2 >= beta X + gamma: the Bernstein coefficients of this
polynomial of degree 3 are linear in u0, u1 and X at the start. Where two rows leave no u at all, x
is bounded at once (the maximum velocity curve). With friction or motors' lines they may leave u
again for a larger x. A motion whose x is bounded within such a gap is below the gap. So every
motion has sqrt(x) below the square root of the least of these curves, and its time is at least the
integral of one over it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .constraint_rows import PARTS, ConstraintRows

# Of the limits, by which they are widened here and narrowed where a motion is made: rounding.
MARGIN = 1e-9
# Bernstein coefficients of t (1 - t).
BUMP = (0.0, 0.25, 1 / 3, 0.25, 0.0)
STEPS = 30
CLOSE = 1e-6  # of x


class Ceiling(NamedTuple):
    """A curve that no motion is above.

    x: at the nodes (n + 1,). time, high, size (n,): the least time, s, on each stretch, the largest
    x of a motion, and the largest |u| of the curves. stuck: the node that no motion passes, or
    None.
    """

    x: np.ndarray
    time: np.ndarray
    high: np.ndarray
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

    At the nodes x <= top (n + 1,), and x is in none of their gaps. Each step takes on each stretch
    the row that ends lowest from the last x, forwards and backwards. Every choice is a bound, so
    that only the stretches on which the last step changed x take new ones.
    """
    n = len(length)
    turned = rows.turned(np.ones(n, dtype=bool))
    part = np.cumsum(top[:-1] == 0)  # from rest to rest: x of one does not depend on another's
    high = np.full(n, np.inf)
    ahead, behind = np.empty((2, 4, n))
    ahead_lines, behind_lines = np.empty((2, 2, n))
    x = top.copy()
    at = np.arange(n)
    for step in range(STEPS):
        before, high_before = x.copy(), high.copy()
        h = length[at]
        if step == 0 or rows.parts["v"].any():
            whole = own = [_parabolas(each.taken(at), h, high[at]) for each in (rows, turned)]
        else:
            own = [each[..., at] for each in whole]
        forward, backward = own
        chain = np.flatnonzero(np.isin(part, part[at]))
        nodes = np.append(chain, chain[-1] + 1)
        ahead[:, at], ahead_lines[:, at] = _lowest(forward, x[at], h)
        x[nodes] = _recurrence(x[nodes], *ahead_lines[:, chain])
        behind[:, at], behind_lines[:, at] = _lowest(backward, x[at + 1], h)
        x[nodes] = _recurrence(x[nodes][::-1], *behind_lines[:, chain[::-1]])[::-1]
        x = _below_gaps(x, gaps)
        for start, u0, _, end in (ahead[:, at], behind[:, at]):
            high[at] = np.fmin(high[at], np.maximum(np.maximum(start, start + h * u0), end))
        moved = ~np.isclose(x, before, rtol=CLOSE, atol=0.0)
        moved = moved[:-1] | moved[1:] | ~np.isclose(high, high_before, rtol=CLOSE, atol=0.0)
        if not moved.any():
            break
        at = np.flatnonzero(moved)
    stuck = np.append(np.flatnonzero(ahead[3] < 0) + 1, np.flatnonzero(behind[3] < 0))
    if len(stuck):
        return Ceiling(x, 0 * length, high, 0 * length, int(stuck[0]))
    slopes = np.abs([*ahead[1:3], *behind[1:3]])
    size = np.where(np.isfinite(slopes), slopes, -np.inf).max(axis=0)
    time = _least_time(ahead, behind, length)
    if alone.parts["b"].shape[1]:
        time = np.maximum(time, _cruise(alone, length))
    return Ceiling(x, time, high, np.where(size < 0, np.inf, size), None)


def _parabolas(rows, h, high):
    """Return slopes and offsets in x0 (2, 4, rows, n) of u0 and of three least u1 of a parabola.

    high (n,): of x on the stretch, inf where it is not known. Each row is u <= beta x + gamma, both
    linear in t. On the parabola the Bernstein coefficients of u - beta x - gamma are 0 or more.
    """
    v = rows.parts["v"]
    known = np.isfinite(high)
    root = np.sqrt(np.where(known, np.maximum(high, 1e-300), 1.0))
    positive = v.min(axis=0) >= 0
    negative = np.where(v.max(axis=0) <= 0, v, v.min(axis=0))
    tangent = 1 / (2 * root)
    with np.errstate(all="ignore"):
        by_x = np.where(positive, v * known / root, negative * tangent)
        beta0, beta1 = _quotient(rows, "b", by_x, tangent)
        gamma0, gamma1 = _quotient(
            rows, "c", np.where(positive, 0.0, negative * root / 2), root / 2
        )
        # The parabola's middle is (1 + h beta0) x0 + h gamma0.
        first = 2 - h * beta0
        last = np.where(h * beta1 < 1, 1 - h * beta1, np.nan)
        both = h * (2 * beta1 + beta0)
        slopes = [
            beta0,
            beta1 + 2 * h * beta0**2,
            (2 * beta1 + both * beta0) / first,
            (1 + h * beta0) * beta1 / last,
        ]
        offsets = [
            gamma0,
            gamma1 + 2 * h * beta0 * gamma0,
            (2 * gamma1 + both * gamma0) / first,
            (gamma1 + h * beta1 * gamma0) / last,
        ]
    return np.where(first > 0, [slopes, offsets], np.nan)


def _quotient(rows, name, of_v, most):
    """Return both ends (2, rows, n) of a line: a times it is at least minus the part of this name
    and of_v (3, rows, n), what v leaves open times `most` included; nan where a may be 0.
    """
    a = rows.parts["a"]
    ends = np.minimum(a[0], a[2])
    least = np.minimum(ends, a[1] - rows.bend["a"] / 2) - rows.slack["a"]
    largest = a.max(axis=0)
    counts = (least > 1e-6 * largest) & (largest > 1e-9 * largest.max(axis=0))
    f = rows.parts[name] + of_v
    first = -f[0] / a[0]
    last = -f[2] / a[2]
    size = np.maximum(np.abs(first), np.abs(last))
    # Of the Bernstein coefficients of what is left, the outer ones are 0.
    inner = a[0] * last + 2 * a[1] * first + f[0] + 2 * f[1]
    inner = np.minimum(inner, a[2] * first + 2 * a[1] * last + f[2] + 2 * f[1])
    bend, slack = (
        table["a"] * size + table[name] + table["v"] * most for table in (rows.bend, rows.slack)
    )
    short = np.maximum(-inner / 4, 0.0) + bend / 4 + slack + MARGIN * (name == "c")
    return np.stack([first, last]) + short / np.where(counts, least, np.nan)


def _lowest(parabolas, x0, h):
    """Return (x0, u0, u1, x1) (4, n) of the rows' parabola that ends lowest from x0 (n,), inf where
    none bounds, and (slope, offset) of a line through x1 that is above its end from any lower x0.
    """
    start = np.where(np.isfinite(x0), x0, 0.0)
    with np.errstate(all="ignore"):
        values = parabolas[0] * start + parabolas[1]
        u1 = values[1:].max(axis=0)
        end = start + h * (values[0] + u1)
        k = np.where(np.isnan(end), np.inf, end).argmin(axis=0)
        columns = np.arange(len(k))
        end = end[k, columns]
        slopes, offsets = parabolas[:, :, k, columns]
        offset = h * (offsets[0] + offsets[1:].max(axis=0))
        steepest = 1 + h * (slopes[0] + slopes[1:].max(axis=0))
        slope = np.where(start > 0, (end - offset) / start, steepest)
        curve = np.stack([x0, values[0, k, columns], u1[k, columns], end])
    free = np.isnan(end) | np.isinf(x0)
    return np.where(free, np.inf, curve), np.where(
        np.isnan(end), [[0.0], [np.inf]], [slope, offset]
    )


def _recurrence(top, slope, offset):
    """Return x (n + 1,) at the ends of these lines (n,), from one to the next, from 0 to top."""
    x = [float(top[0])]
    for most, steep, value in zip(top[1:].tolist(), slope.tolist(), offset.tolist()):
        end = steep * x[-1] + value if x[-1] < np.inf else np.inf
        x.append(max(min(most, end), 0.0))
    return np.array(x)


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


def _least_time(ahead, behind, h):
    """Return the least times (n,) below either curve, from the start on or back from the end."""
    best = np.zeros(len(h))
    for start, u0, u1, end in (ahead, behind):
        with np.errstate(all="ignore"):
            least = np.minimum(np.minimum(start + h * u0, start), end)
            time = duration(h, start, end, (u1 - u0) / h)
        best = np.where((least >= 0) & (end < np.inf), np.maximum(best, time), best)
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
    # The root of the line from first to last is concave.
    return ((np.sqrt(first) + np.sqrt(last)) / 2 * length).max(axis=0)
