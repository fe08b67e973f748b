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
BUMP = (
    0.0,
    0.25,
    1 / 3,
    0.25,
    0.0,
)  # Bernstein coefficients of t (1 - t)
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
    gaps: list[list] = [[] for _ in range(rows.parts["a"].shape[2] + 1)]
    with np.errstate(all="ignore"):
        for end, at in enumerate((0, 2)):
            a, b, v, c = (rows.parts[name][at] for name in PARTS)
            da, db, dv, dc = (rows.slack[name] for name in PARTS)
            da = da + 1e-13 * np.abs(a)
            db = db + 1e-13 * np.abs(b)
            dv = dv + 1e-13 * np.abs(v)
            dc = dc + 1e-13 * np.abs(c) + MARGIN * 4
            best = np.full(a.shape[1], np.inf)
            for k in range(len(a)):
                # Row k with a > 0 and others with a < 0: P x + V sqrt(x) <= Q, whatever u.
                up = a[k]
                down = -a
                P = _without_u(a, da, b, db, k)
                V = _without_u(a, da, v, dv, k)
                Q = -_without_u(a, da, c, dc, k)
                discriminant = V * V + 4 * P * Q
                root = (-V + np.sqrt(np.maximum(discriminant, 0.0))) / (2 * P)
                none = (P > 0) & (Q < 0) & ((V >= 0) | (discriminant < 0))
                none |= (P == 0) & (V >= 0) & (Q < 0)
                bound = np.where(
                    P > 0,
                    root * root,
                    np.inf,
                )
                bound = np.where(none, -1.0, bound)
                opposed = (up > 0) & (down > 0)
                if V.any():
                    gap = opposed & (P < 0) & (V > 0) & (Q > 0) & (discriminant > 0)
                    root = V + np.sqrt(np.maximum(discriminant, 0.0))
                    low = (2 * Q / root) ** 2 * (1 + MARGIN)
                    high = (root / (2 * P)) ** 2 * (1 - MARGIN)
                    gap &= low < high
                    nodes = np.nonzero(gap)[1] + end
                    for node, *limits in zip(nodes.tolist(), low[gap].tolist(), high[gap].tolist()):
                        gaps[node].append(limits)
                best = np.minimum(best, np.where(opposed, bound, np.inf).min(axis=0))
            if alone.parts["b"].shape[1]:
                w = alone.parts["b"][at]
                limit = MARGIN - alone.parts["c"][at]
                best = np.minimum(
                    best,
                    np.where(w > 0, limit / w, np.inf).min(axis=0),
                )
            result.append(best * (1 + MARGIN))
    return np.array(result), gaps


def _below_gaps(x, gaps):
    """Return the largest x of a motion that is not above x, where these gaps (low, high) are."""
    for low, high in sorted(gaps, reverse=True):
        if low < x < high:
            x = low
    return x


def _without_u(
    a,
    da,
    f,
    df,
    k,
):
    """Return the least f of row k, a > 0, and of each other row, weighted so that u drops out."""
    least = a[k] * (f - df) - a * (f[k] - df[k])
    by_slack = da[k] * np.abs(f)
    return least - by_slack - da * np.abs(f[k])


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
        ahead[i] = _above(
            x[i],
            forward[i],
            h[i],
        )
        x[i + 1] = _below_gaps(min(x[i + 1], ahead[i][2]), gaps[i + 1])
        if x[i + 1] < 0:
            return Ceiling(
                np.array(x),
                np.zeros(n),
                np.zeros(n),
                i,
            )
    for i in range(n - 1, -1, -1):
        behind[i] = _above(
            x[i + 1],
            backward[i],
            h[i],
        )
        x[i] = _below_gaps(min(x[i], behind[i][2]), gaps[i])
        if x[i] < 0:
            return Ceiling(
                np.array(x),
                np.zeros(n),
                np.zeros(n),
                i,
            )
    time = np.zeros(n)
    size = np.zeros(n)
    for i in range(n):
        ahead[i] = _above(
            x[i],
            forward[i],
            h[i],
        )
        time[i] = _least_time(
            x[i],
            ahead[i],
            x[i + 1],
            behind[i],
            h[i],
        )
        slopes = [abs(u) for u in (*ahead[i][:2], *behind[i][:2]) if math.isfinite(u)]
        size[i] = max(slopes, default=math.inf)
    if alone.parts["b"].shape[1]:
        time = np.maximum(time, _cruise(alone, length))
    return Ceiling(
        np.array(x),
        time,
        size,
        None,
    )


def _lists(rows, way):
    """Return each stretch's rows with a > 0 (way 1), or backwards those with a < 0, as numbers."""
    a, b, v, c = (rows.parts[name][::way] for name in PARTS)
    a = way * a
    least = (
        np.minimum(
            np.minimum(a[0], a[2]),
            a[1] - rows.bend["a"] / 2,
        )
        - rows.slack["a"]
    )
    largest = a.max(axis=0)
    fits = (least > 1e-6 * largest) & (largest > 1e-9 * largest.max(axis=0))
    bend = np.stack([rows.bend[name] for name in PARTS])
    slack = np.stack([rows.slack[name] for name in PARTS])
    table = np.concatenate([a, b, v, c, bend, slack])
    table = table.transpose(2, 1, 0)
    return [table[i, fits[:, i]].tolist() for i in range(table.shape[0])]


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
            u1 = -(b1 * y + v1 * math.sqrt(max(y + h * u1, 0.0)) + c1) / steep
        guesses.append((u0 + u1, row))
    best = FREE
    # A row's parabola ends above its guess, far above it where its a is nearly 0.
    for guess, row in sorted(guesses):
        if x0 + h * guess >= best[2]:
            break
        best = min(best, _parabola(x0, row, h, guess), key=_end)
    return best


def _end(parabola):
    return parabola[2]


def _parabola(x0, row, h, guess):
    """Return (u0, u1, x1) of one row, `guess` about u0 + u1; FREE where it bounds nothing."""
    a0, am, a1, b0, bm, b1, v0, vm, v1, c0, cm, c1 = row[:12]
    (
        a_bend,
        b_bend,
        v_bend,
        c_bend,
        a_slack,
        b_slack,
        v_slack,
        c_slack,
    ) = row[12:]
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
        if v0 > 0 and vm > 0 and v1 > 0:
            r0 = rm = r1 = r_low
        else:
            r0 = rm = r1 = r_high
            if not (v0 <= 0 and vm <= 0 and v1 <= 0):
                v0 = vm = v1 = min(v0, vm, v1)
        size = 1.5 * max(abs(guess), 1e-300) + loose * abs(guess)
        open_ = a_slack * size + b_slack * high + v_slack * r_high + c_slack + MARGIN
        bend = a_bend * size + b_bend * high + v_bend * r_high + c_bend
        u0 = -(b0 * x0 + v0 * r0 + c0 - open_) / a0
        y = x0 + h * u0
        # The row's Bernstein coefficients 1 to 4 are p + q u1.
        left1 = (a0 * u0 + 2 * am * u0) / 4
        left2 = (2 * am * u0 + a1 * u0) / 6
        left3 = a1 * u0 / 4
        speed1 = (b0 * y + bm * x0) / 2
        speed2 = (b0 * y + 4 * bm * y + b1 * x0) / 6
        speed3 = (bm + b1) * y / 2
        rest1 = (v0 * r0 + vm * rm + c0 + cm) / 2
        rest2 = (v0 * r0 + 4 * vm * rm + v1 * r1 + c0 + 4 * cm + c1) / 6
        rest3 = (vm * rm + v1 * r1 + cm + c1) / 2
        p = (
            left1 + speed1 + rest1,
            left2 + speed2 + rest2,
            left3 + speed3 + rest3,
            b1 * y + v1 * r1 + c1,
        )
        q = (
            a0 / 4,
            (a0 + 2 * am) / 6 + b0 * h / 6,
            (2 * am + a1) / 4 + bm * h / 2,
            a1 + b1 * h,
        )
        if min(q) <= 0:
            return FREE
        u1 = max((open_ + bend * bump - p_j) / q_j for bump, p_j, q_j in zip(BUMP[1:], p, q))
        end = x0 + h * (u0 + u1)
        fits = max(abs(u0), abs(u1)) <= size
        # No motion is below 0: a parabola that ends there is a bound if it counts roots from 0 on.
        fits = fits and (low == 0 or low <= min(x0, end, y)) and max(x0, end, y) <= high
        if fits:
            return u0, u1, end
        guess = math.copysign(
            max(abs(guess), abs(u0), abs(u1)),
            guess,
        )
        loose = loose * 2
        x1 = end
    return FREE


def duration(
    h: float,
    x0: float,
    x1: float,
    bent: float,
) -> float:
    """Return the time, s, over a stretch h on which x goes from x0 to x1 with x_ss = 2 bent."""
    total = math.sqrt(max(x0, 0.0)) + math.sqrt(max(x1, 0.0))
    if total == 0:
        return math.inf
    plain = h / total
    part = bent * (h / total) ** 2
    if abs(part) < 1e-6:
        return 2 * plain * (1 + part / 3)
    root = math.sqrt(abs(part))
    if part > 0:
        if root < 1:
            return 2 * plain * math.atanh(root) / root
        return math.inf
    return 2 * plain * math.atan(root) / root


def _least_time(
    x0,
    ahead,
    x1,
    behind,
    h,
):
    """Return the least time below both curves, from x0 on and back from x1."""
    curves = []
    for start, (u0, u1, end) in ((x0, ahead), (x1, behind)):
        if end < math.inf and min(start + h * u0, start, end) >= 0:
            curves.append((start, u0, (u1 - u0) / h, end))
    bounds = [duration(h, start, end, bent) for start, _, bent, end in curves]
    if len(curves) == 2 and curves[0][3] > x1 and curves[1][3] > x0:
        (f0, fu, fk, _), (g0, gu, gk, g1) = curves
        # Where they meet: any place is valid, as below both is below either.
        a = fk - gk
        b = 2 * (fu + gu + gk * h)
        c = f0 - g1
        root = b * b - 4 * a * c
        if root >= 0 and b > 0:
            s = -2 * c / (b + math.sqrt(root))
        else:
            s = 0.0
        if 0 < s < h:
            rest = h - s
            before = duration(
                s,
                f0,
                f0 + s * (2 * fu + s * fk),
                fk,
            )
            after = duration(
                rest,
                g0,
                g0 + rest * (2 * gu + rest * gk),
                gk,
            )
            bounds.append(before + after)
    return max(bounds, default=0.0) * (1 - 1e-12)


def _cruise(alone, length):
    """Return the least time (n,), s, by rows w x + c <= 0, c < 0 constant: of sqrt(w / -c)."""
    w = alone.parts["b"]
    c = -alone.parts["c"][0] + MARGIN
    chord = (w[0] + w[2]) / 2
    less = np.maximum(chord - w[1], 0.0) / 2 + alone.bend["b"] / 4 + alone.slack["b"]
    first = np.maximum(w[0] - less, 0.0) / c
    last = np.maximum(w[2] - less, 0.0) / c
    roots = np.sqrt(first) + np.sqrt(last)
    with np.errstate(all="ignore"):
        mean = np.where(
            roots > 0,
            2 / 3 * (first + np.sqrt(first * last) + last) / roots,
            0.0,
        )
    return (mean * length).max(axis=0)
