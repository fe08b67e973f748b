"""Bound x = s'^2 at both ends of each stretch so that all limits hold between them too.

On each stretch x is a parabola through its values at both nodes, and u = s'' is linear. Each limit
a u + b x + v sqrt(x) + c <= 0 is a polynomial of degree 4. Its Bernstein coefficients are linear in
the two values and are kept <= 0, with all that `bounds` leaves open, so the limit holds throughout.
So each stretch allows a polygon of (x at its start, x at its end).

At Type 2, a u + b x + c = 0 for both torques at once (the crossing criterion), which fixes u there.
The limit's left side is t times a polynomial, whose coefficients are multiples of the others: the
bar forces, finite at the node, are its quotient by det A.
"""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ...base.backend import EPS
from .constraint_rows import PARTS, ConstraintRows
from .lower_bound import BUMP, Ceiling

if TYPE_CHECKING:
    from .mesh import Mesh

ROOM = 1.02  # of the ceiling's x, and twice it of |u|: beyond it no motion is searched
ROUNDING = 8 * EPS
NEAREST = 1e-2
TIGHT = 0.1  # of the torques, above which friction is bounded closely
WIDE = 5  # times `off`, up to which x then differs from `near`


def polygons(
    rows: ConstraintRows,
    length: np.ndarray,
    above: Ceiling,
    bent: np.ndarray,
    near: np.ndarray,
    off: np.ndarray,
    mesh: Mesh,
) -> tuple[np.ndarray, np.ndarray]:
    """Return polygons p x0 + q x1 + r <= 0 of x at both ends of n stretches, from their rows, and
    x_ss / 2 on them as a form in (x0, x1, 1): (n, rows, 3) and (n, 3).

    bent (n,): x_ss / 2 where it may be chosen; beside a node on Type 2 the criterion gives it.
    near (n + 1,): x about which that is made linear at the nodes of `Mesh.tied`. off (n,): with 0,
    x is free there and the result is no proof; else x is `near` there, and beside them not much
    more than so much of it away.
    """
    n = len(length)
    crossing = mesh.criterion
    back = mesh.criterion[1:]
    if back.any():
        # Stretches that end on Type 2 are run backwards.
        rows = rows.turned(back)
    first = np.zeros((n, 3))
    last = np.zeros((n, 3))
    first[:, 0] = last[:, 1] = 1.0
    h = length[:, None]
    curve = _const(bent) * h**2
    u0 = (last - first - curve) / (2 * h)
    u1 = (last - first + curve) / (2 * h)
    middle = (first + last - curve) / 2
    starts = crossing[:-1] | back
    at = np.where(back, near[1:], near[:-1])
    for i in np.flatnonzero(starts):
        u0[i] = _criterion(mesh, i, bool(back[i]), at[i])
        middle[i] = first[i] + length[i] * u0[i]
        u1[i] = (last[i] - first[i]) / length[i] - u0[i]
    size = 2 * ROOM * above.size + 1e-9 * above.x.max() / length
    root, low, high = _root(rows, mesh, near, off, ROOM * above.high)
    u = np.stack([u0, u1])
    x = np.stack([first, middle, last])
    rounding = ROUNDING * high / length  # of u, a difference of both x over the length
    # There the part v(0) sqrt(x) is taken by its slope at x = at, and by how much it may differ.
    slope = 0.5 / np.sqrt(np.where(starts, at, 1.0))
    bow = (2 * length * size) ** 2 * 4 * slope**3
    sides = _left_sides(rows, u, x, size, high, root, rounding, starts, slope, bow)
    # x on Type 2 is given where it is not free.
    fixed = ((off > 0) & np.where(back, mesh.tied[1:], mesh.tied[:-1]))[:, None]
    bounds = [fixed * (first - _const(at)), fixed * (_const(at) - first)]
    for value in x:
        bounds += [_const(low) - value, value - _const(high)]
    for value in u:
        bounds += [value - _const(size), -value - _const(size)]
    table = np.concatenate([sides.reshape(-1, n, 3), np.stack(bounds)])
    curvature = (u1 - u0) / h
    table[:, back] = table[:, back][..., [1, 0, 2]]
    curvature[back] = curvature[back][:, [1, 0, 2]]
    scale = np.abs(table[..., :2]).sum(axis=-1, keepdims=True)
    table = table / np.where(scale > 0, scale, 1.0)
    return table.transpose(1, 0, 2), curvature


def _const(value):
    return np.stack([0 * value, 0 * value, value], axis=-1)


def _product(f, form):
    """Return Bernstein polynomials f (m + 1, rows, n) times a form (k + 1, n, 3), of degree 4."""
    result = np.zeros((5, *f.shape[1:], 3))
    m, n = len(f) - 1, len(form) - 1
    more = 4 - m - n
    for i, j, k in np.ndindex(m + 1, n + 1, more + 1):
        weight = comb(m, i) * comb(n, j) * comb(more, k) / comb(4, i + j + k)
        result[i + j + k] += weight * f[i][..., None] * form[j]
    return result


def _left_sides(rows, u, x, size, high, root, rounding, starts, slope, bow):
    """Return Bernstein coefficients (5, rows, n, 3) of upper bounds of the rows.

    starts (n,): stretches that start on Type 2, where a row of a torque is 0 by the criterion: what
    is left open is so much times t. Rounding error is there that at t = NEAREST. slope, bow (n,):
    of v(0) sqrt(x).
    """
    zero = (rows.kind == "torque")[:, None] & starts
    parts, bend, slack = rows.parts, rows.bend, rows.slack
    one = _const(np.ones((1, u.shape[1])))
    v = np.where(zero, parts["v"][0], 0.0)
    sides = _product(parts["a"], u)
    sides = sides + _product(parts["b"] + v * slope, x)
    sides = sides + _product(parts["c"], one)
    sides -= np.where(zero[..., None], sides[0], 0.0)
    _add_friction(sides, parts["v"] - v, x, one, root, high)
    # x is linear in both its values, and so is what b leaves open times x.
    arch = np.stack([0 * bend["b"], bend["b"] / 2, 0 * bend["b"]])
    ramp = np.stack([np.where(zero, 0.0, slack["b"]), slack["b"]])
    sides = sides + _product(arch, x) + _product(ramp, x)
    loss = rounding * np.abs(parts["a"]).max(axis=0) * np.where(zero, 1 / NEAREST, 1.0)
    share = np.where(zero, np.arange(5)[:, None, None] / 4, 1.0)
    open_ = _width(slack, size, high) + loss + np.abs(v) * bow
    sides[..., 2] += share * open_ + _width(bend, size, high) * np.array(BUMP)[:, None, None]
    return sides


def _width(table, size, high):
    return table["a"] * size + table["v"] * np.sqrt(high) + table["c"]


def _root(rows, mesh, near, off, high):
    """Return ((2, 2, n) lines [p, q] above and below sqrt(x), low and high (n,) of x).

    Any tangent is above: it touches at the ceiling.

    Beside a node where friction is part of the criterion both are close, as close as the torques
    are small there: the tangent at x = near, which is no bound, or (off) bounds for x close to it.
    """
    low = np.zeros(len(high))
    wide = np.sqrt(high)
    lines = np.array([[0.5 / wide, wide / 2], [1 / wide, low]])
    torque = rows.kind == "torque"
    if not mesh.tied.any() or not torque.any():
        return lines, low, high
    least = np.minimum(near[:-1], near[1:])
    most = np.maximum(near[:-1], near[1:])
    v = np.abs(rows.parts["v"][:, torque]).max(axis=(0, 1))
    close = (v * np.sqrt(most) > TIGHT * np.abs(mesh.found["D"].middle)) & (least > 0)
    if not off.any():
        mean = np.sqrt((least + most) / 2)
        tangent = np.array([0.5 / mean, mean / 2])
        return (np.where(close, np.array([tangent, tangent]), lines), low, high)
    low = np.where(close, (1 - WIDE * off) * least, 0.0)
    high = np.where(close, (1 + WIDE * off) * most, high)
    below = np.sqrt(low)
    wide = np.sqrt(high)
    chord = 1 / (below + wide)
    touch = np.where(close, np.sqrt(below * wide), wide)
    lines = np.array([[0.5 / touch, touch / 2], [chord, below - low * chord]])
    return lines, low, high


def _add_friction(found, v, x, one, root, high):
    """Add an upper bound of v sqrt(x)."""
    if not v.any():
        return
    above, below = root
    signs = [v.min(axis=0) >= 0, v.max(axis=0) <= 0]
    slope = np.select(signs, [above[0], below[0]], 0.0)
    offset = np.select(signs, [above[1], below[1]], np.sqrt(high))
    v = np.where(signs[0] | signs[1], v, np.maximum(v, 0.0))
    found += _product(v * slope, x) + _product(v * offset, one)


def _criterion(mesh, i, back, near):
    """Return u as a form of x at a node on Type 2, where a u + b x + v sqrt(x) + c = 0.

    With v, the elbows' friction, it is made linear by the tangent at x = near. back: the stretch is
    run backwards.
    """
    end = 2 if back else 0
    parts = np.zeros((2, len(PARTS)))
    for joint, part in np.ndindex(parts.shape):
        if value := mesh.found.get(f"{PARTS[part]}{joint + 1}"):
            parts[joint, part] = value[end][i]
    a, b, v, c = parts[np.abs(parts[:, 0]).argmax()]
    sign = -1.0 if back else 1.0
    half = np.sqrt(near) / 2
    v = v * mesh.tied[i + back]
    by_x = b + v / (4 * half)
    constant = c + v * half
    return -sign * np.array([by_x, 0.0, constant]) / a
