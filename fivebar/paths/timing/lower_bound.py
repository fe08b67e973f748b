"""A curve that no motion along a path can pass: from it, a lower bound of the time.

Every limit is a row a u + b x + v sqrt(x) + c <= 0 with x = s'^2, u = x_s / 2. Let a > 0 on a
stretch, and X a function of s with a X_s / 2 + b X + v sqrt(X) + c > 0 throughout. A motion with x
<= X at the start of the stretch stays below: where it first met X it would have x_s <= -2 (b X + v
sqrt(X) + c) / a < X_s. So X bounds it, whatever else limits it; where a < 0 the same holds
backwards from the stretch's end. Here each row is u <= beta x + gamma for all x >= 0 that a motion
may have, with beta and gamma linear in t, from 0 to 1 along the stretch. X is a parabola with
X_s / 2 = u0 + (u1 - u0) t that has X_s / 2 >= beta X + gamma: the Bernstein coefficients of this
polynomial of degree 3 are linear in u0, u1 and X at the start. So each row bounds x at the far end
by a line of x at the near end: each stretch allows a polygon of both, which no motion leaves. Where
two rows leave no u at all, x is bounded at once (the maximum velocity curve). `profile` finds the
largest x at the nodes. A motion has sqrt(x) below the square root of the least of the parabolas
from there, and its time is at least the integral of one over it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .constraint_rows import PARTS, ConstraintRows
from .reachability import profile

# Of the limits, by which they are widened here and narrowed where a motion is made: rounding.
MARGIN = 1e-9
# Bernstein coefficients of t (1 - t).
BUMP = (0.0, 0.25, 1 / 3, 0.25, 0.0)
FASTEST = 9e16  # m^2/s^2: no motion is faster than light
STEPS = 4  # in which bounds follow from the last x where sqrt(x) is in them; else 2 do


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


def caps(rows: ConstraintRows) -> np.ndarray:
    """Return the largest x (2, n) with a feasible u at both ends of stretches, < 0 for none."""
    a, *others = (rows.parts[name][::2] for name in PARTS)
    da, *slack = (rows.slack[name] + 1e-13 * np.abs(rows.parts[name][::2]) for name in PARTS)
    slack[-1] = slack[-1] + MARGIN * 4
    alone = rows.kind == "speed"
    with np.errstate(all="ignore"):
        speeds = (MARGIN - rows.parts["c"][::2, alone]) / rows.parts["b"][::2, alone]
        best = np.where(speeds > 0, speeds, np.inf).min(axis=1, initial=np.inf)
        # The rows of the tip's acceleration, by themselves, leave a u up to the row of x alone.
        for k in np.flatnonzero(np.isin(rows.kind, ("torque", "joint"))):
            # Of two rows with unlike a, P x + V sqrt(x) + Q <= 0, whatever u.
            P, V, Q = (_without_u(a, da, f, df, k) for f, df in zip(others, slack))
            discriminant = V * V - 4 * P * Q
            root = (np.sqrt(np.maximum(discriminant, 0.0)) - V) / (2 * P)
            bound = np.where(P > 0, root * root, np.inf)
            none = (P >= 0) & (Q > 0) & ((V >= 0) | (discriminant < 0))
            bound = np.where(none, -1.0, bound)
            unlike = a[:, [k]] * a < 0
            best = np.minimum(best, np.where(unlike, bound, np.inf).min(axis=1))
    return best * (1 + MARGIN)


def _without_u(a, da, f, df, k):
    """Return the least f of row k and of each other row, weighted so that u drops out."""
    lowest = f - df
    least = np.abs(a[:, [k]]) * lowest + np.abs(a) * lowest[:, [k]]
    size = np.abs(f)
    return least - da[:, [k]] * size - da * size[:, [k]]


def ceiling(
    rows: ConstraintRows, length: np.ndarray, top: np.ndarray, high: np.ndarray, rest: np.ndarray
) -> Ceiling:
    """Return the Ceiling of n stretches of these lengths, m.

    At the nodes x <= top (n + 1,), and it is 0 at rest (n + 1,). Nowhere on a stretch is it above
    high (n,).
    """
    # A row with a < 0 bounds the motion that is run backwards.
    back = rows.parts["a"][1] < 0
    rows = rows.turned(back)
    x = np.minimum(top, FASTEST)
    for _ in range(STEPS if rows.parts["v"].any() else 2):
        parabolas = _parabolas(rows, length, high)
        x, stuck = profile(_polygons(parabolas, length, back, x), x, rest)
        start = np.where(back, x[1:], x[:-1])
        u0, u1, end = _curves(parabolas, start, length)
        most = np.maximum(np.maximum(start, start + length * u0), end)
        high = np.fmin(high, np.fmin.reduce(most))
        if stuck:
            break
    steep = np.maximum(np.abs(u0), np.abs(u1))
    steep = np.where(np.isnan(steep), np.inf, steep)
    sizes = [np.where(each, steep, np.inf).min(axis=0) for each in (back, ~back)]
    size = np.where(np.isinf(sizes), -np.inf, sizes).max(axis=0)
    time = np.maximum(_least_time(start, u0, u1, end, length), _cruise(rows, length))
    return Ceiling(x, time, high, np.where(size < 0, np.inf, size), (*stuck, None)[0])


def _polygons(parabolas, length, back, top):
    """Return the polygons (n, rows, 3) of `profile` from the rows' parabolas, and 0 <= x <= top.

    The end of a parabola is a convex function of where it starts, so up to top no motion is above
    the chord. back (rows, n): the stretch is run backwards.
    """
    near = np.where(back, top[1:], top[:-1])
    lowest, highest = (_curves(parabolas, start, length)[2] for start in (0.0, near))
    slope = np.maximum((highest - lowest) / np.maximum(near, 1e-300), 0.0)
    lines = np.stack([-slope, np.ones_like(slope), -lowest]) / (1 + slope)
    lines = np.where(np.isfinite(lines).all(axis=0), lines, 0.0)
    lines = np.where(back, lines[[1, 0, 2]], lines)
    one = np.ones(len(length))
    ends = [[one, 0 * one, -top[:-1]], [-one, 0 * one, 0 * one]]
    return np.concatenate([lines.transpose(2, 1, 0), np.transpose(ends, (2, 0, 1))], axis=1)


def _curves(parabolas, start, length):
    """Return (u0, u1, x at the end) of the parabolas (rows, n) from x = start."""
    u0, *ends = parabolas[0] * start + parabolas[1]
    u1 = np.max(ends, axis=0)
    return u0, u1, start + length * (u0 + u1)


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


def _least_time(start, u0, u1, end, h):
    """Return the least times (n,) below any curve from x = start (rows, n) on, or back from it."""
    with np.errstate(all="ignore"):
        least = np.minimum(np.minimum(start + h * u0, start), end)
        time = duration(h, start, end, (u1 - u0) / h)
    return np.where(least >= 0, time, 0.0).max(axis=0, initial=0.0) * (1 - 1e-12)


def _cruise(rows, length):
    """Return the least time (n,), s, by rows w x + c <= 0, c < 0 constant: of sqrt(w / -c)."""
    alone = rows.kind == "speed"
    w = rows.parts["b"][:, alone]
    c = MARGIN - rows.parts["c"][0, alone]
    chord = (w[0] + w[2]) / 2
    sag = np.maximum(chord - w[1], 0.0)
    less = sag / 2 + rows.bend["b"][alone] / 4 + rows.slack["b"][alone]
    first = np.maximum(w[0] - less, 0.0) / c
    last = np.maximum(w[2] - less, 0.0) / c
    # The root of the line from first to last is concave.
    return ((np.sqrt(first) + np.sqrt(last)) / 2 * length).max(axis=0, initial=0.0)
