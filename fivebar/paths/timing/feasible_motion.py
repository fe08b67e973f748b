"""A motion along a path that keeps all limits between the nodes too, nearly as fast as the ceiling
lets it.

On each stretch x = s'^2 is a parabola through its values at both nodes, u = s'' goes linearly, and
each limit a u + b x + v sqrt(x) + c <= 0 is a polynomial of degree 4 whose Bernstein coefficients,
linear in the two values, are kept <= 0 with room for all that `bounds` leaves open: what is <= 0
there is so throughout. So each stretch allows a polygon of (x at its start, x at its end). A pass
backwards gives for each node the x from which the end can be reached; one forwards takes the
largest it can (Pham and Pham, A new approach to time-optimal path parameterization based on
reachability analysis, 2018).

At Type 2, a u + b x + c = 0 for both torques at once (the crossing criterion): it fixes u there,
and the limit's left side is t times a polynomial whose coefficients are kept instead: the bar
forces, finite at the node, are its quotient by det A.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...base.backend import EPS
from .constraint_rows import PARTS, Rows
from .lower_bound import BUMP, Ceiling

if TYPE_CHECKING:
    from .mesh import Mesh

ROOM = 1.02  # of the ceiling's x, and twice it of |u|: beyond it nothing is looked for
TINY = 1e-12  # a row's share, of both, that counts as 0
ROUNDING, NEAREST = 8 * EPS, 1e-2
TIGHT, WIDE = (
    0.1,
    5,
)  # of the torques, above which friction is bounded closely; for x so many times `off` away
FINE = 34  # halvings in which a polygon's corner is found


class Polygons(NamedTuple):
    """p x0 + q x1 + r <= 0, table (n, rows, 3), for the values x0, x1 of x at both ends of each of
    n stretches.

    bent (n, 3): x_ss / 2 as a form in (x0, x1, 1).
    """

    table: np.ndarray
    bent: np.ndarray

    def curvature(self, x: np.ndarray) -> np.ndarray:
        """x_ss / 2 (n,) of a motion with these x at the nodes (n + 1,)."""
        return self.bent[:, 0] * x[:-1] + self.bent[:, 1] * x[1:] + self.bent[:, 2]


def polygons(
    rows: Rows,
    alone: Rows,
    length: np.ndarray,
    above: Ceiling,
    bent: np.ndarray,
    lean: np.ndarray,
    near: np.ndarray,
    off: float,
    mesh: Mesh,
) -> Polygons:
    """The Polygons of a mesh's n stretches, from their rows.

    bent, lean (n,): x_ss / 2 = bent + lean (x0 + x1) / 2 where it may be chosen; beside a node on
    Type 2 the criterion gives it. near (n + 1,): x about which that is made linear at the nodes of
    `Mesh.tied`. off: 0, and x is free there, what is found not proved; or x is `near` there, and
    beside them not much more than so much of it away.
    """
    n, crossing, back = len(length), mesh.criterion, mesh.criterion[1:]
    if back.any():  # those that end on Type 2 are run backwards: u changes its sign
        rows, alone = _turned(rows, back), _turned(alone, back)
    first, last = (np.zeros((n, 3)) for _ in (0, 1))
    first[:, 0] = last[:, 1] = 1.0
    h = length[:, None]
    curve = (_const(bent) + lean[:, None] * (first + last) / 2) * h**2
    u0, u1 = (last - first - curve) / (2 * h), (last - first + curve) / (2 * h)
    middle = (first + last - curve) / 2
    special = np.flatnonzero(crossing[:-1] | back)
    at = np.where(back, near[1:], near[:-1])
    for i in special:
        u0[i] = _criterion(mesh, i, bool(back[i]), at[i])
        middle[i] = first[i] + length[i] * u0[i]
        u1[i] = (last[i] - first[i]) / length[i] - u0[i]
    size = 2 * ROOM * above.size + 1e-9 * above.x.max() / length
    high = ROOM * np.maximum(above.x[:-1], above.x[1:])
    high = np.maximum(high, (above.x[:-1] + above.x[1:]) / 2 + above.size * length)
    root, low, high = _root(rows, mesh, near, off, high)
    motion = np.stack([u0, u1]), np.stack([first, middle, last])
    rounding = ROUNDING * high / length  # of u, which is a difference of both x over the length
    found = [_left_sides(each, *motion, size, high, root, rounding) for each in (rows, alone)]
    for i in special if rows.torque.any() else ():
        at_i = size[i], high[i], root[..., i : i + 1], length[i], at[i], rounding[i]
        found[0][:, rows.torque, i] = _quotients(rows, i, motion[0][:, i], motion[1][:, i], *at_i)
    box = [
        -first,
        -last,
        -middle,
        middle - _const(high),
        u0 - _const(size),
        -u0 - _const(size),
        u1 - _const(size),
        -u1 - _const(size),
    ]
    if off:
        only = np.where(back, mesh.tied[1:], mesh.tied[:-1])[:, None] * (first - _const(at))
        box += [only, -only]
        box += [each for x in motion[1] for each in (_const(low) - x, x - _const(high))]
    found = np.concatenate([*(each.reshape(-1, n, 3) for each in found), np.stack(box)])
    curvature = (u1 - u0) / h
    found[:, back], curvature[back] = found[:, back][..., [1, 0, 2]], curvature[back][:, [1, 0, 2]]
    scale = np.abs(found[..., :2]).sum(axis=-1, keepdims=True)
    return Polygons((found / np.where(scale > 0, scale, 1.0)).transpose(1, 0, 2).copy(), curvature)


def _const(value):
    return np.stack([0 * value, 0 * value, value], axis=-1)


def _turned(rows, back):
    def table(values, sign):
        return {
            k: np.where(back, v[::-1] * (sign if k == "a" else 1.0), v) for k, v in values.items()
        }

    return Rows(table(rows.parts, -1.0), rows.bend, rows.slack, rows.torque)


@lru_cache
def _weights(m, n, degree):
    """(i, j, k, weight): Bernstein coefficients i and j of degrees m and n in coefficient k of the
    product's.
    """
    own = m + n
    found = []
    for i, j in np.ndindex(m + 1, n + 1):
        part = comb(m, i) * comb(n, j) / comb(own, i + j)
        for k in range(i + j, i + j + degree - own + 1):
            found.append(
                (i, j, k, part * comb(own, i + j) * comb(degree - own, k - i - j) / comb(degree, k))
            )
    return tuple(found)


def _product(f, form, degree=4):
    """(degree + 1, rows, n, 3): f (m + 1, rows, n) times a form (k + 1, n, 3)."""
    found = np.zeros((degree + 1, *f.shape[1:], 3))
    for i, j, k, weight in _weights(len(f) - 1, len(form) - 1, degree):
        found[k] += weight * f[i][..., None] * form[j]
    return found


def _left_sides(rows, u, x, size, high, root, rounding):
    """(5, rows, n, 3): Bernstein coefficients of the rows, as forms, with room for what is open."""
    one = _const(np.ones((1, u.shape[1])))
    found = (
        _product(rows.parts["a"], u) + _product(rows.parts["b"], x) + _product(rows.parts["c"], one)
    )
    _add_friction(found, rows.parts["v"], x, one, root, high)
    bend, slack = (_room(table, size, high) for table in (rows.bend, rows.slack))
    found[..., 2] += (
        slack
        + bend * np.array(BUMP)[:, None, None]
        + rounding * np.abs(rows.parts["a"]).max(axis=0)
    )
    return found


def _room(table, size, high):
    return table["a"] * size + table["b"] * high + table["v"] * np.sqrt(high) + table["c"]


def _root(rows, mesh, near, off, high):
    """((2, 2, n) sqrt(x) <= p x + q and sqrt(x) >= p x + q, [p, q] each; low, high (n,): for x
    between these).

    Beside a node where friction is part of the criterion it is looked for on both sides, so closely
    as the torques are
    small there: by the tangent at x = near, which is no bound, and then (off) by bounds for x close
        to that.
    """
    low, wide = np.zeros(len(high)), np.sqrt(high)
    found = np.array([[0.5 / wide, wide / 2], [1 / wide, low]])
    if not mesh.tied.any() or not rows.torque.any():
        return found, low, high
    least, most = np.minimum(near[:-1], near[1:]), np.maximum(near[:-1], near[1:])
    v = np.abs(rows.parts["v"][:, rows.torque]).max(axis=(0, 1))
    close = (v * np.sqrt(most) > TIGHT * np.abs(mesh.found["D"].middle)) & (least > 0)
    if not off:
        mean = np.sqrt((least + most) / 2)
        return np.where(close, np.array(2 * [[0.5 / mean, mean / 2]]), found), low, high
    low, high = (
        np.where(close, (1 - WIDE * off) * least, 0.0),
        np.where(close, (1 + WIDE * off) * most, high),
    )
    below, wide = np.sqrt(low), np.sqrt(high)
    slope, touch = 1 / (below + wide), np.where(close, np.sqrt(below * wide), wide)
    return np.array([[0.5 / touch, touch / 2], [slope, below - low * slope]]), low, high


def _add_friction(found, v, x, one, root, high):
    """Add v sqrt(x), from above."""
    if not v.any():
        return
    least, largest = v.min(axis=0), v.max(axis=0)
    slope, offset = (
        np.where(least >= 0, above, np.where(largest <= 0, below, 0.0))
        for above, below in zip(*root)
    )
    mixed = (least < 0) & (largest > 0)
    flat = np.where(mixed, 0.0, v)
    degree = len(found) - 1
    found += _product(flat * slope, x, degree) + _product(flat * offset, one, degree)
    found[..., 2] += np.where(mixed, largest * np.sqrt(high), 0.0)


def _criterion(mesh, i, back, near):
    """u as a form of x at a node on Type 2, where a u + b x + v sqrt(x) + c = 0; back: run
    backwards.

    With v, the elbows' friction, it is not linear in x: by the tangent at x = near.
    """
    end = 2 if back else 0
    at = {
        name: np.array(
            [
                mesh.found[f"{name}{k}"][end][i] if f"{name}{k}" in mesh.found else 0.0
                for k in (1, 2)
            ]
        )
        for name in PARTS
    }
    k = int(np.argmax(np.abs(at["a"])))
    sign, half, v = (
        -1.0 if back else 1.0,
        np.sqrt(near) / 2,
        at["v"][k] if mesh.tied[i + back] else 0.0,
    )
    return (
        -sign
        * np.array([at["b"][k] + (v / (4 * half) if v else 0.0), 0.0, at["c"][k] + v * half])
        / at["a"][k]
    )


def _quotients(rows, i, u, x, size, high, root, length, near, rounding):
    """(5, rows, 3): the torques' rows over t on a stretch that starts on Type 2; rounding, as seen
    from t = NEAREST.
    """
    f = {name: rows.parts[name][:, rows.torque, i] for name in PARTS}
    q = {
        name: np.stack([2 * (each[1] - each[0]), each[2] - each[0]])[..., None]
        for name, each in f.items()
    }
    start = {name: each[None, 0, :, None] for name, each in f.items()}
    u, x = u[:, None], x[:, None]
    one, x_q = _const(np.ones((1, 1))), np.stack([2 * (x[1] - x[0]), x[2] - x[0]])
    found = (
        _product(start["a"], (u[1] - u[0])[None]) + _product(q["a"], u) + _product(start["b"], x_q)
    )
    found += _product(q["b"], x) + _product(q["c"], one)
    _add_friction(found, q["v"], x, one, root, np.array([high]))
    if start["v"].any():  # (sqrt(x) - sqrt(x0)) / t by its value at x0; by so much it may differ:
        found += _product(start["v"] / (2 * np.sqrt(near)), x_q)
        found[..., 2] += np.abs(start["v"]) * (2 * length * size) ** 2 / (2 * near**1.5)
    bend, slack = (
        _room({name: each[rows.torque, i] for name, each in table.items()}, size, high)
        for table in (rows.bend, rows.slack)
    )
    found[..., 0, 2] += slack + bend * (np.arange(4, -1, -1) / 4)[:, None]
    found[..., 0, 2] += rounding / NEAREST * np.abs(f["a"]).max(axis=0)
    return found[:, :, 0]


def profile(found: Polygons, above: Ceiling, rest: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """(x at the nodes (n + 1,), as large as a pass forwards makes it; the nodes from which no
    motion leads on).

    From rest to rest (rest: (n + 1,) nodes) each part stands for itself: 0 where there is such a
    node on it.
    """
    table, n = found.table, len(found.table)
    top = np.where(rest, 0.0, above.x)
    p, q, r = (np.ascontiguousarray(table[..., k]) for k in range(3))
    up, down, flat = p > TINY, p < -TINY, np.abs(p) <= TINY
    with np.errstate(all="ignore"):
        reach = np.where(flat, 0.0, -1 / p)
        # Whether x0 = 0 is allowed, and with what x1.
        ends = -r / q
        first = np.where(q < -TINY, ends, 0.0).max(axis=1).tolist()
        last = np.where(q > TINY, ends, np.inf).min(axis=1).tolist()
    always = ~((np.abs(q) <= TINY) & (r > 0)).any(axis=1)
    corner = _corners(p, q, r, reach, top[1:], True).tolist()
    low, high, lowest, stuck = [0.0] * (n + 1), top.tolist(), None, []
    least = 1e-12 * above.x.max() + 1e-300
    begins = np.maximum.accumulate(np.where(rest[:-1], np.arange(n), 0)).tolist()
    i = n - 1
    while i >= 0:
        x1 = min(max(corner[i], low[i + 1]), high[i + 1])
        value = (r[i] + q[i] * x1) * reach[i]
        at_most = value[up[i]].min(initial=np.inf)
        if not (always[i] and max(first[i], low[i + 1]) <= min(last[i], high[i + 1])):
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
    """The largest x that can follow from node to node, and the nodes from which none does, with
    those stuck already.
    """
    n, x, closed = len(p), [high[0]], {begins[i] for i in stuck}
    up = q > TINY
    with np.errstate(all="ignore"):
        reach = np.where(up, -1 / q, 0.0)
    base, slope = r * reach, p * reach
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
    """For each polygon the x1 in [0, top] at which x0 is largest, or least, (n,)."""
    found, low, high = top.copy(), np.zeros(len(p)), top.copy()
    left, good = np.arange(len(p)), np.full(len(p), np.nan)
    for k in range(FINE):
        x1 = high[left] if k == 0 else (low[left] + high[left]) / 2
        p_, q_, reach_ = p[left], q[left], reach[left]
        value = r[left] + q_ * x1[:, None]
        x0, index = value * reach_, np.arange(len(left))
        most, least = np.where(p_ > TINY, x0, np.inf), np.where(p_ < -TINY, x0, -np.inf)
        wrong = np.where(np.abs(p_) <= TINY, value, -np.inf)
        i, j, m = most.argmin(axis=1), least.argmax(axis=1), wrong.argmax(axis=1)
        slope_i, slope_j = (q_[index, each] * reach_[index, each] for each in (i, j))
        closed, outside = most[index, i] < least[index, j], wrong[index, m] > 0
        slope = np.where(closed, slope_i - slope_j, slope_i if largest else -slope_j)
        slope = np.where(outside, -q_[index, m], slope)
        good[left] = np.where(closed | outside, good[left], x1)
        low[left], high[left] = (
            np.where(slope > 0, x1, low[left]),
            np.where(slope > 0, high[left], x1),
        )
        if k == 0:  # most are done: x0 grows up to the top
            left = left[(slope < 0) | closed | outside]
            if not len(left):
                break
    found = np.where(np.isnan(good), (low + high) / 2, good)
    return found
