"""The parts every mechanism here is made of: drives that move a pivot, and dyads that close on two pivots.

Directions are held as unit vectors on components, so that what follows from them needs no trigonometry.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ._backend import EPS, atan2, cos, reciprocal_or_nan, sin, sqrt_or_nan

# Below this a sine is rounding error of a pose's unit vectors: it has no sign, and nothing is divided by it.
SINGULAR = 16 * EPS


def cross(u, v):
    return u[0] * v[1] - u[1] * v[0]


def dot(u, v):
    return u[0] * v[0] + u[1] * v[1]


@dataclass(frozen=True, eq=False)
class RRR:
    """RRR dyad: bars r1 and r2 on pivots P1 and P2 = P1 + span; branch +1: the joint is on the left of P1 -> P2.

    nan where the bars cannot meet and where equal bars find both pivots in one point.
    """

    span: tuple
    r1: float
    r2: float
    branch: object

    @cached_property
    def span_squared(self):
        x, y = self.span
        return x * x + y * y

    @cached_property
    def _moment(self):
        """Signed height of the joint over the span, times the span."""
        # Heron's product of differences, never the cancelling l^2 - a^2 of AMORO eq. 2 and 8. Its floor is a height
        # squared of -8 eps in units of the longer bar: one stretched leg in nine rounds to below zero.
        square, total, difference = self.span_squared, self.r1 + self.r2, self.r1 - self.r2
        heron = (total * total - square) * (square - difference * difference)
        return sqrt_or_nan(heron, -32 * EPS * max(self.r1, self.r2) ** 2 * square) * (0.5 * self.branch)

    @cached_property
    def _inverse(self):
        return reciprocal_or_nan(self.span_squared, (4 * EPS * (self.r1 + self.r2)) ** 2)

    def _unit(self, lead, bar):
        """The vector whose products with the span are `lead` (dot) and the moment (cross), over the bar's length."""
        (x, y), scale = self.span, self._inverse * (1 / bar)
        return (lead * x - self._moment * y) * scale, (lead * y + self._moment * x) * scale

    @cached_property
    def first(self):
        """Unit vector along r1, from P1 to the joint."""
        return self._unit(0.5 * (self.span_squared + (self.r1 + self.r2) * (self.r1 - self.r2)), self.r1)

    @cached_property
    def second(self):
        """Unit vector along r2, from P2 to the joint."""
        return self._unit(-0.5 * (self.span_squared - (self.r1 + self.r2) * (self.r1 - self.r2)), self.r2)

    @cached_property
    def sine(self):
        """first x second, with full relative accuracy where the bars are almost in line."""
        return self._moment * (1 / (self.r1 * self.r2))


class Crank(NamedTuple):
    """Revolute drive: P(q) = (x, y) + length (cos q, sin q); `direction` is that unit vector."""

    x: float
    y: float
    length: float

    def direction(self, q):
        return cos(q), sin(q)

    def coordinate(self, direction):
        return atan2(direction[1], direction[0])

    def pivot(self, direction):
        return self.x + self.length * direction[0], self.y + self.length * direction[1]

    def tangent(self, direction):
        """P'(q)."""
        return -self.length * direction[1], self.length * direction[0]

    def curvature(self, direction):
        """P''(q)."""
        return -self.length * direction[0], -self.length * direction[1]

    def close(self, xi, bar, working):
        """The dyad of the leg that reaches xi."""
        return RRR((xi[0] - self.x, xi[1] - self.y), self.length, bar, working)

    def relative(self, absolute, own):
        """Passive joint's angle, rate or acceleration from the distal bar's absolute one and the drive's."""
        return absolute - own

    def absolute(self, passive, own):
        """The inverse of `relative`."""
        return passive + own
