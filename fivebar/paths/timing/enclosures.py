"""Enclosures along a path: truncated Taylor series with intervals as coefficients.

A `Series` holds f, f', f''/2, ... at a point to its rounding, or over a stretch as intervals; sums,
products, quotients and roots of series enclose those of the functions (Moore, Kearfott and Cloud,
Introduction to Interval Analysis, 2009, ch. 9). The models' equations, written on components, take
them as they take arrays.
"""

from __future__ import annotations

from math import comb, factorial
from typing import TYPE_CHECKING

import numpy as np

from ...base.backend import EPS

if TYPE_CHECKING:
    from ..curve import Path

ROUND = 4 * EPS  # of the sum of the terms' sizes: more than what a sum of up to five products loses
TERMS = 5  # of the place: torques take two of its derivatives, and two of their own are needed


class Series:
    """Taylor coefficients (k, n) of n functions: middles m and radii r, nan where undefined."""

    __slots__ = ("m", "r")
    __array_ufunc__ = None  # NumPy's numbers leave the operators to this class

    def __init__(self, m: np.ndarray, r: np.ndarray) -> None:
        self.m = m
        self.r = r

    def _like(self, other):
        if isinstance(other, Series):
            return other
        m = np.zeros_like(self.m)
        m[0] = other
        return Series(m, np.zeros_like(m))

    def __neg__(self):
        return Series(-self.m, self.r)

    def __add__(self, other):
        other = self._like(other)
        k = min(len(self.m), len(other.m))
        m = self.m[:k] + other.m[:k]
        return Series(m, self.r[:k] + other.r[:k] + EPS * np.abs(m))

    __radd__ = __add__

    def __sub__(self, other):
        return self + (-other)

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if not isinstance(other, Series):
            m = self.m * other
            return Series(m, self.r * np.abs(other) + EPS * np.abs(m))
        count = min(len(self.m), len(other.m))
        m, r = np.empty((2, count, max(self.m.shape[1], other.m.shape[1])))
        size = np.abs(self.m)
        wide = np.abs(other.m) * (1 + ROUND) + other.r
        slack = other.r + ROUND * np.abs(other.m)
        for k in range(count):
            m[k] = (self.m[: k + 1] * other.m[k::-1]).sum(axis=0)
            errors = size[: k + 1] * slack[k::-1] + self.r[: k + 1] * wide[k::-1]
            r[k] = errors.sum(axis=0)
        return Series(m, r * (1 + ROUND))

    __rmul__ = __mul__

    def __truediv__(self, other):
        if isinstance(other, Series):
            return self * other.inverse()
        return self * (1 / other)

    def inverse(self) -> Series:
        """Return 1 / f, nan where f may be 0."""
        first = _monotone(lambda v: 1 / v, self.m[0], self.r[0], lambda low, high: low * high > 0)
        return _term_by_term(self, first, inverse=True)

    def sqrt(self) -> Series:
        """Return the root of f, nan where f may be 0 or less."""
        first = _monotone(np.sqrt, self.m[0], self.r[0], lambda low, high: low > 0)
        return _term_by_term(self, first, inverse=False)

    def slope(self) -> Series:
        """Return f', with a coefficient less."""
        orders = np.arange(1, len(self.m))[:, None]
        rounding = EPS * np.abs(self.m[1:]) * orders
        return Series(self.m[1:] * orders, self.r[1:] * orders * (1 + EPS) + rounding)

    def cut(self, terms: int) -> Series:
        return Series(self.m[:terms], self.r[:terms])


def _monotone(function, m, r, fits):
    """Return (middle, radius) of a monotone function of an interval; nan where it does not fit."""
    low = m - r
    high = m + r
    with np.errstate(all="ignore"):
        good = fits(low, high)
        a = function(np.where(good, low, np.nan))
        b = function(np.where(good, high, np.nan))
    middle = (a + b) / 2
    return middle, np.abs(b - a) / 2 + 4 * EPS * (np.abs(a) + np.abs(b))


def _one(m, r):
    return Series(m[None], r[None])


def _term_by_term(given, first, inverse):
    """Return 1 / f or the root of f, coefficient by coefficient: from f g = 1 or g g = f."""
    terms = [_one(*first)]
    if inverse:
        scale = terms[0]
    else:
        scale = (terms[0] * 2.0).inverse()
    for k in range(1, len(given.m)):
        total = None
        for i in range(1, k + 1):
            if inverse:
                term = _one(given.m[i], given.r[i]) * terms[k - i]
            elif i < k:
                term = terms[i] * terms[k - i]
            else:
                term = -_one(given.m[k], given.r[k])
            total = term if total is None else total + term
        terms.append(-total * scale)
    middles = np.concatenate([term.m for term in terms])
    return Series(middles, np.concatenate([term.r for term in terms]))


def dyad_series(
    x: Series, y: Series, first: float, last: float, branch: int
) -> tuple[tuple[Series, Series], Series, Series]:
    """Return the way along the first bar of the dyad that spans (x, y), as `dyads.RRR`, and that
    bar's products with the span: dot and cross product.
    """
    square = x * x + y * y
    along = (square + (first + last) * (first - last)) * 0.5
    heron = ((first + last) ** 2 - square) * (square - (first - last) ** 2)
    across = heron.sqrt() * (0.5 * branch)
    scale = square.inverse()
    elbow = (along * x - across * y) * scale, (along * y + across * x) * scale
    return elbow, along, across


def place_series(
    path: Path, piece: np.ndarray, first: np.ndarray, last: np.ndarray, terms: int
) -> tuple[Series, Series]:
    """Return (x, y) of the path that is drawn on stretches [first, last] (n,) of pieces (n,).

    s, m, is from each piece's own beginning.
    """
    arcs, tables, lengths, is_arc, own = path._packed
    m, r = np.zeros((2, 2, terms, len(piece)))
    middle = (first + last) / 2
    radius = (last - first) / 2 * (1 + ROUND)
    on_arc = is_arc[piece]
    if on_arc.any():
        k = own[piece[on_arc]]
        series = _on_arcs(arcs[k].T, middle[on_arc], radius[on_arc], terms)
        m[..., on_arc], r[..., on_arc] = series
    if not on_arc.all():
        k = own[piece[~on_arc]]
        series = _on_polynomials(tables[k, 0], lengths[k], middle[~on_arc], radius[~on_arc], terms)
        m[..., ~on_arc], r[..., ~on_arc] = series
    r += ROUND * np.abs(m)
    return Series(m[0], r[0]), Series(m[1], r[1])


def _on_arcs(arcs, middle, radius, terms):
    *centre, size, start, side = arcs
    angle = start + side * middle / size
    turn = radius / size
    m, r = np.zeros((2, 2, terms, len(middle)))
    for k in range(terms):
        scale = size * (side / size) ** k / factorial(k)
        m[0, k] = scale * np.cos(angle + k * np.pi / 2)
        m[1, k] = scale * np.sin(angle + k * np.pi / 2)
        # Sine and cosine have slopes of at most 1.
        r[:, k] = np.abs(scale) * (np.minimum(turn, 1.0) + ROUND * (1 + np.abs(angle)))
    m[:, 0] += centre
    r[:, 0] += ROUND * np.abs(centre)
    return m, r


def _on_polynomials(table, length, middle, radius, terms):
    u = middle / length
    rho = radius / length
    n = table.shape[1]
    c = table.transpose(1, 2, 0)
    m, r = np.zeros((2, 2, terms, len(middle)))
    # Coefficients about the middle, and the sizes of their terms.
    shifted, size = np.zeros((2, n, 2, len(middle)))
    for k in range(n):
        for j in range(k, n):
            part = comb(j, k) * c[j] * u ** (j - k)
            shifted[k] += part
            size[k] += np.abs(part)
    for k in range(min(terms, n)):
        spread = np.zeros_like(u)
        for j in range(k + 1, n):
            spread = spread + comb(j, k) * np.abs(shifted[j]) * rho ** (j - k)
        m[:, k] = shifted[k] / length**k
        r[:, k] = (spread + 2 * n * EPS * size[k]) / length**k
    return m, r
