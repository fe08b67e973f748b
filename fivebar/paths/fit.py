"""Fit Bezier curves and ellipses by quintics whose parameter is nearly the length.

A quintic has the points, tangents and curvatures of both ends of its part of the curve. On a part
of length h its error is of order h^6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyder, polymul, polyroots

from ..base.backend import HUGE, pairs
from .pieces import Polynomial

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
SEEN = np.linspace(0, 1, 13)[1:-1]  # where a quintic is compared with its curve
HALVINGS = 40
STEADY = 0.1  # by which |xi_s| may be off 1


@dataclass(frozen=True, eq=False)
class Bezier:
    """A cubic: control points (4,), complex, m."""

    control: np.ndarray

    def __post_init__(self) -> None:
        _refuse_far("a curve", *self.control)

    def moved(self, by: complex, turned: complex) -> Bezier:
        return Bezier(by + turned * self.control)


@dataclass(frozen=True, eq=False)
class Ellipse:
    """centre + a cos t + b sin t, complex, m, for t from t0 to t1."""

    centre: complex
    a: complex
    b: complex
    t0: float
    t1: float

    def __post_init__(self) -> None:
        _refuse_far("an ellipse", self.centre, self.a, self.b)

    def moved(self, by: complex, turned: complex) -> Ellipse:
        return Ellipse(
            by + turned * self.centre, turned * self.a, turned * self.b, self.t0, self.t1
        )


def _refuse_far(what, *points):
    if not all(abs(point) < HUGE for point in points):
        raise ValueError(f"{what} reaches beyond {HUGE:g} m, or its numbers are not finite")


def fitted(curves: list[Bezier] | list[Ellipse], within: float) -> list[list[Polynomial]]:
    """Return for each curve, all of one kind, quintics within the distance `within`, m, of it."""
    if not curves:
        return []
    curve = (_Beziers if isinstance(curves[0], Bezier) else _Ellipses)(curves)
    rows, start, end = curve.parts()
    found = []
    for halving in range(HALVINGS + 1):
        coefficients, length = _quintics(curve, rows, start, end)
        good = (length > 0) & (_off(curve, rows, start, end, coefficients, length) <= within)
        if halving == HALVINGS:
            good[:] = True
        for k in np.flatnonzero(good & (length > 0)):
            found.append((rows[k], start[k], coefficients[k], length[k]))
        again = ~good & (length > 0)
        rows = np.tile(rows[again], 2)
        start = start[again]
        end = end[again]
        middle = (start + end) / 2
        start = np.concatenate([start, middle])
        end = np.concatenate([middle, end])
        if not len(rows):
            break
    pieces: list[list[Polynomial]] = [[] for _ in curves]
    for row, _, coefficients, length in sorted(found, key=lambda each: each[:2]):
        pieces[row].append(Polynomial(pairs(coefficients), float(length)))
    return pieces


def quintic(ends: tuple, length: np.ndarray) -> np.ndarray:
    """Return the quintics with these ends (xi, xi_s, xi_ss), (6, n) by powers of u = s / length."""
    (p0, d0, c0), (p1, d1, c1) = ends
    d0 = d0 * length
    d1 = d1 * length
    c0 = c0 * length**2
    c1 = c1 * length**2
    rise = p1 - p0 - d0 - c0 / 2
    first = d1 - d0 - c0
    last = c1 - c0
    return np.stack(
        [
            p0,
            d0,
            c0 / 2,
            10 * rise - 4 * first + last / 2,
            -15 * rise + 7 * first - last,
            6 * rise - 3 * first + last / 2,
        ]
    )


def quintic_as_long(ends: tuple, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the quintics (n, 6) with these ends that are as long as their curves, and that
    length (n,), m; `length` is a first guess.
    """
    powers = ((1 + NODES) / 2)[:, None] ** np.arange(5) * np.arange(1, 6)
    for _ in range(8):
        speed = np.abs(powers @ quintic(ends, length)[1:])
        length = speed.T @ WEIGHTS / 2
    return quintic(ends, length).T, length


def _quintics(curve, rows, start, end):
    half = (end - start)[:, None] / 2
    nodes = start[:, None] + half * (1 + NODES)
    derivative = curve(rows[:, None], nodes)[1]
    speed = np.abs(derivative)
    length = (speed * half) @ WEIGHTS
    first = curve.end(rows, start, 1)
    last = curve.end(rows, end, -1)
    return quintic((first, last), length).T, length


def _off(curve, rows, start, end, coefficients, length):
    """Return the largest distances from the curves; inf where the speed is not nearly 1."""
    powers = SEEN[:, None] ** np.arange(6)
    derivatives = powers[:, :5] * np.arange(1, 6)
    p = coefficients @ powers.T
    speed = np.abs(coefficients[:, 1:] @ derivatives.T)
    change = np.abs(speed - length[:, None])
    steady = change.max(axis=1) <= STEADY * length
    low = start[:, None]
    high = end[:, None]
    t = low + (high - low) * SEEN
    for _ in range(6):  # to the foot of each point
        z, dz, _ = curve(rows[:, None], t)
        square = np.abs(dz) ** 2
        t = np.clip(t + ((p - z) * dz.conj()).real / np.where(square > 0, square, 1.0), low, high)
    return np.where(steady, np.abs(curve(rows[:, None], t)[0] - p).max(axis=1), np.inf)


class _Curves:
    def parts(self):
        rows = np.arange(len(self.size))
        return rows, np.zeros(len(rows)), np.ones(len(rows))

    def end(self, rows, t, side):
        """(xi, xi_s, xi_ss) by the arc's length, where a part starts (side 1) or ends (-1)."""
        z, dz, ddz = self(rows, t)
        speed = np.abs(dz)
        lost = (
            speed <= 1e-9 * self.size[rows]
        )  # handles in one point: the direction is that of the next derivative
        toward = np.where(lost, side * ddz, dz)
        still = np.abs(toward) <= 1e-9 * self.size[rows]
        toward = np.where(still, self.third(rows), toward)
        size = np.abs(toward)
        tangent = np.where(size > 0, toward / np.where(size > 0, size, 1.0), 1.0)
        curvature = np.where(lost, 0.0, (dz.conj() * ddz).imag / np.where(lost, 1.0, speed) ** 3)
        return z, tangent, 1j * curvature * tangent


class _Beziers(_Curves):
    def __init__(self, curves):
        p = np.array([curve.control for curve in curves])
        self.powers = np.stack(
            [
                p[:, 0],
                3 * (p[:, 1] - p[:, 0]),
                3 * (p[:, 0] - 2 * p[:, 1] + p[:, 2]),
                p[:, 3] - p[:, 0] + 3 * (p[:, 1] - p[:, 2]),
            ]
        )
        self.size = np.abs(p - p[:, :1]).max(axis=1)

    def __call__(self, rows, t):
        a, b, c, d = self.powers[:, rows]
        return a + t * (b + t * (c + t * d)), b + t * (2 * c + 3 * t * d), 2 * c + 6 * t * d

    def third(self, rows):
        return 6 * self.powers[3, rows]

    def parts(self):
        """Cut at cusps, where the derivative is 0: it turns back there."""
        rows = []
        start = []
        end = []
        for row, (_, b, c, d) in enumerate(self.powers.T):
            # Where |xi'|^2 is least.
            derivative = np.array([b, 2 * c, 3 * d])
            square = polymul(derivative, derivative.conj()).real
            roots = polyroots(polyder(square))
            t = np.sort(roots[np.abs(roots.imag) < 1e-6].real)
            t = t[(t > 1e-9) & (t < 1 - 1e-9)]
            speed = np.abs(b + t * (2 * c + 3 * t * d))
            cuts = t[speed <= 1e-9 * self.size[row]]
            edges = [0.0, *cuts, 1.0]
            rows += [row] * (len(edges) - 1)
            start += edges[:-1]
            end += edges[1:]
        return np.array(rows), np.array(start), np.array(end)


class _Ellipses(_Curves):
    def __init__(self, curves):
        self.centre, self.a, self.b = np.array([[e.centre, e.a, e.b] for e in curves]).T
        self.t0, self.t1 = np.array([[e.t0, e.t1] for e in curves]).T
        self.size = np.abs(self.t1 - self.t0) * (np.abs(self.a) + np.abs(self.b))

    def __call__(self, rows, t):
        span = (self.t1 - self.t0)[rows]
        angle = self.t0[rows] + span * t
        cos = np.cos(angle)
        sin = np.sin(angle)
        a = self.a[rows]
        b = self.b[rows]
        return (
            self.centre[rows] + a * cos + b * sin,
            span * (b * cos - a * sin),
            -(span**2) * (a * cos + b * sin),
        )

    def third(self, rows):
        return np.zeros(np.shape(rows), dtype=complex)
