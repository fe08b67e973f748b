"""What paths are made of: straight lines, circular arcs and polynomials, each xi(s) with its
derivatives by s.

Each has a `length`, m, and piece(s), s from 0 to it, gives (xi, xi_s, xi_ss, xi_sss), each
(*s.shape, 2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import finite_numbers, pairs
from ..base.checks import number, positive, shown, two_numbers
from ..base.representation import one_line, vector

ORDERS = 4  # xi and its first three derivatives
MOST_TERMS = 24  # of a polynomial


@dataclass(frozen=True)
class Line:
    """A straight line at unit speed.

    Attributes
    ----------
    start, end : (2,)
        m; two different points.

    Examples
    --------
    >>> from fivebar.paths.pieces import Line
    >>> Line((0.0, 0.0), (0.03, 0.04)).length
    0.05
    """

    start: tuple[float, float]
    end: tuple[float, float]

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            object.__setattr__(self, name, two_numbers(getattr(self, name), f"Line: {name}"))
        if self.start == self.end:
            raise ValueError(f"Line: start and end are one point, {self.start}")
        positive(self.length, "Line: its length, m,")

    def __repr__(self) -> str:
        return one_line("Line", vector("from", self.start, "m"), vector("to", self.end, "m"))

    @cached_property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """(2, 2) m, by powers of u = s / length."""
        return np.array([self.start, np.subtract(self.end, self.start)])

    def __call__(self, s: ArrayLike) -> tuple[np.ndarray, ...]:
        return _values(
            derivatives(self.coefficients, self.length), np.asarray(s, float) / self.length
        )

    def part(self, first: float, last: float) -> Line:
        """Return the part from s = first to s = last, m."""
        start = self.start if first == 0 else tuple(self(first)[0])
        end = self.end if last == self.length else tuple(self(last)[0])
        return Line(start, end)

    def moved(self, by: complex, turned: complex) -> Line:
        """Return the piece with each point z = x + i y moved to by + turned z."""
        start = by + turned * complex(*self.start)
        end = by + turned * complex(*self.end)
        return Line(_xy(start), _xy(end))


@dataclass(frozen=True)
class Arc:
    """An arc of a circle at unit speed.

    Attributes
    ----------
    centre : (2,)
        m.
    radius : float
        m.
    angle0, angle1 : float
        Directions of its start and end from the centre, rad; it turns left if angle1 > angle0.

    Examples
    --------
    >>> from fivebar.paths.pieces import Arc
    >>> Arc((0.0, 0.0), 0.02, 0.0, 1.5).length
    0.03
    """

    centre: tuple[float, float]
    radius: float
    angle0: float
    angle1: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", two_numbers(self.centre, "Arc: centre"))
        object.__setattr__(self, "radius", positive(self.radius, "Arc: radius"))
        for name in ("angle0", "angle1"):
            object.__setattr__(self, name, number(getattr(self, name), f"Arc: {name}"))
        if self.angle0 == self.angle1:
            raise ValueError(
                f"Arc: angle0 and angle1 are both {self.angle0:g} rad: it has no length"
            )

    def __repr__(self) -> str:
        turned = f"from {self.angle0:.6g} to {self.angle1:.6g} rad"
        return one_line(
            "Arc", vector("about", self.centre, "m"), f"radius {self.radius:.6g} m", turned
        )

    @property
    def length(self) -> float:
        return self.radius * abs(self.angle1 - self.angle0)

    @property
    def start(self) -> np.ndarray:
        return self(0.0)[0]

    @property
    def end(self) -> np.ndarray:
        return self(self.length)[0]

    @property
    def side(self) -> float:
        """+1 where it turns left, else -1."""
        return math.copysign(1.0, self.angle1 - self.angle0)

    def __call__(self, s: ArrayLike) -> tuple[np.ndarray, ...]:
        return on_arcs(
            np.array([*self.centre, self.radius, self.angle0, self.side]), np.asarray(s, float)
        )

    def part(self, first: float, last: float) -> Arc:
        """Return the part from s = first to s = last, m."""
        span = self.angle1 - self.angle0
        length = self.length
        return Arc(
            self.centre, self.radius, *(self.angle0 + span * (s / length) for s in (first, last))
        )

    def moved(self, by: complex, turned: complex) -> Arc:
        """Return the piece with each point z = x + i y moved to by + turned z."""
        turn = math.atan2(turned.imag, turned.real)
        centre = _xy(by + turned * complex(*self.centre))
        return Arc(centre, self.radius * abs(turned), self.angle0 + turn, self.angle1 + turn)


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial curve xi = sum of coefficients[k] u^k with u = s / length in [0, 1].

    Attributes
    ----------
    coefficients : (degree + 1, 2)
        m.
    length : float
        Range of s, m. |xi_s| need not be 1.

    Examples
    --------
    >>> from fivebar.paths.pieces import Polynomial
    >>> Polynomial([(0.0, 0.0), (0.1, 0.0), (0.0, 0.02)], 0.1).end
    array([0.1 , 0.02])
    """

    coefficients: np.ndarray
    length: float

    def __post_init__(self) -> None:
        table = finite_numbers(self.coefficients, "Polynomial: coefficients")
        if table.ndim != 2 or table.shape[1] != 2 or not 2 <= len(table) <= MOST_TERMS:
            raise ValueError(
                f"Polynomial: coefficients must be (degree + 1, 2), not {shown(table.shape)}"
            )
        object.__setattr__(self, "coefficients", table)
        object.__setattr__(self, "length", positive(self.length, "Polynomial: length"))

    def __repr__(self) -> str:
        ends = vector("from", tuple(self.start), "m"), vector("to", tuple(self.end), "m")
        return one_line("Polynomial", f"degree {len(self.coefficients) - 1}", *ends)

    @property
    def start(self) -> np.ndarray:
        return self(0.0)[0]

    @property
    def end(self) -> np.ndarray:
        return self(self.length)[0]

    @property
    def bernstein(self) -> np.ndarray:
        """Control points (degree + 1, 2), m, whose convex hull holds the piece."""
        return _to_bernstein(len(self.coefficients)) @ self.coefficients

    @cached_property
    def _derivatives(self):
        return derivatives(self.coefficients, self.length)

    def __call__(self, s: ArrayLike) -> tuple[np.ndarray, ...]:
        return _values(self._derivatives, np.asarray(s, float) / self.length)

    def part(self, first: float, last: float) -> Polynomial:
        """Return the part from s = first to s = last, m."""
        a = first / self.length
        b = (last - first) / self.length
        n = len(self.coefficients)
        shift = np.zeros((n, n))
        for k in range(n):
            for j in range(k + 1):
                shift[j, k] = comb(k, j) * a ** (k - j) * b**j
        return Polynomial(shift @ self.coefficients, last - first)

    def moved(self, by: complex, turned: complex) -> Polynomial:
        """Return the piece with each point z = x + i y moved to by + turned z."""
        z = turned * (self.coefficients @ (1, 1j))
        z[0] += by
        return Polynomial(pairs(z), self.length * abs(turned))


Piece = Line | Arc | Polynomial


def derivatives(coefficients: np.ndarray, length: float) -> np.ndarray:
    """The table (4, n, 2) of xi and its derivatives by s, by powers of u."""
    n = len(coefficients)
    table = np.zeros((ORDERS, n, 2))
    table[0] = coefficients
    for order in range(1, ORDERS):
        table[order, :-1] = table[order - 1, 1:] * np.arange(1, n)[:, None] / length
    return table


def on_arcs(arcs: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, ...]:
    """(xi, xi_s, xi_ss, xi_sss) at s (*batch), of arcs (*batch, 5): centre, radius, first angle,
    side.
    """
    x, y, radius, angle, side = np.moveaxis(arcs, -1, 0)
    angle = angle + side * s / radius
    u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    v = np.stack([-u[..., 1], u[..., 0]], axis=-1) * np.asarray(side)[..., None]
    radius = np.asarray(radius)[..., None]
    return np.stack([x, y], axis=-1) + radius * u, v, -u / radius, -v / radius**2


def _values(table, u):
    powers = u[..., None] ** np.arange(table.shape[1])
    return tuple(powers @ each for each in table)


def _to_bernstein(n):
    """(n, n): control points from coefficients of powers of u."""
    matrix = np.zeros((n, n))
    for k in range(n):
        for j in range(k + 1):
            matrix[k, j] = comb(k, j) / comb(n - 1, j)
    return matrix


def _xy(z):
    return z.real, z.imag
