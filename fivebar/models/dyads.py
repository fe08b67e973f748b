"""The parts every mechanism here is made of: drives that move a pivot, and dyads that close on two
pivots.

Directions are held as unit vectors on components, so that what follows from them needs no
trigonometry.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ..base.backend import (
    EPS,
    atan2,
    copysign,
    cos,
    reciprocal_or_nan,
    sin,
    sqrt,
    sqrt_or_nan,
    where_zero,
)

# Below this a sine is rounding error of a pose's unit vectors: it has no sign, and nothing is
# divided by it.
SINGULAR = 16 * EPS


def cross(u, v):
    return u[0] * v[1] - u[1] * v[0]


def dot(u, v):
    return u[0] * v[0] + u[1] * v[1]


@dataclass(frozen=True, eq=False)
class RRR:
    """RRR dyad: bars r1 and r2 on pivots P1 and P2 = P1 + span meet in a joint.

    The joint is where two circles cross (AMORO eq. 2 and 8). With s = |span|, a the part of bar r1
    along the span and h the joint's height over it,

        a = (s^2 + r1^2 - r2^2) / (2 s)                     h = branch sqrt(r1^2 - a^2)
        4 s^2 h^2 = ((r1 + r2)^2 - s^2) (s^2 - (r1 - r2)^2)                (Heron)

    branch +1: the joint is on the left of P1 -> P2. All is nan where the bars cannot meet, and
    where equal bars find both pivots in one point.
    extent: size of the coordinates whose difference is the span, m: their rounding is its error.
    """

    span: tuple
    r1: float
    r2: float
    branch: object
    extent: object = 0.0

    @cached_property
    def span_squared(self):
        x, y = self.span
        return x * x + y * y

    @cached_property
    def _moment(self):
        """s h, signed."""
        # Heron's product in place of r1^2 - a^2: what cancels there is measured against the bars'
        # product, not the longer bar's square.
        square = self.span_squared
        total = self.r1 + self.r2
        difference = self.r1 - self.r2
        heron = (total * total - square) * (square - difference * difference)
        return sqrt_or_nan(heron, self._floor) * (0.5 * self.branch)

    def _floor(self):
        """Return the lowest value of Heron's product that may be the rounding of 0.

        The rounding of the pivots and of their difference leaves a span s uncertain by up to 4 eps
        (s + extent), and at either limit the product's slope by s is 8 r1 r2 s in size. One
        stretched leg in nine rounds to below zero.
        """
        span = sqrt(self.span_squared)
        error = 4 * EPS * (span + self.extent)
        return -8 * self.r1 * self.r2 * (span + error) * error

    def _part_along_span(self, r, twice):
        """Return s times the part of bar r along the span, half of `twice` = s^2 +- (r1^2 - r2^2).

        Where the bars are in line it is s r, to the last digit.
        """
        return where_zero(
            self._moment, lambda: copysign(r * sqrt(self.span_squared), twice), 0.5 * twice
        )

    @property
    def clearances(self):
        """How far the span is inside each of its limits, m."""
        span = sqrt(self.span_squared)
        return self.r1 + self.r2 - span, span - abs(self.r1 - self.r2)

    @cached_property
    def _inverse(self):
        return reciprocal_or_nan(self.span_squared, (4 * EPS * (self.r1 + self.r2)) ** 2)

    # Both bars are written with a positive share of the span, so that equal bars share their
    # products.
    @cached_property
    def first(self):
        """Unit vector along r1, from P1 to the joint: a along the span and h across, over r1."""
        x, y = self.span
        height = self._moment
        scale = self._inverse * (1 / self.r1)
        difference_of_squares = (self.r1 + self.r2) * (self.r1 - self.r2)
        along = self._part_along_span(self.r1, self.span_squared + difference_of_squares)
        return (along * x - height * y) * scale, (along * y + height * x) * scale

    @cached_property
    def last(self):
        """Unit vector along r2, from the joint to P2."""
        x, y = self.span
        height = self._moment
        scale = self._inverse * (1 / self.r2)
        difference_of_squares = (self.r1 + self.r2) * (self.r1 - self.r2)
        along = self._part_along_span(self.r2, self.span_squared - difference_of_squares)
        return (along * x + height * y) * scale, (along * y - height * x) * scale

    @property
    def second(self):
        """Unit vector along r2, from P2 to the joint."""
        return -self.last[0], -self.last[1]

    @cached_property
    def sine(self):
        """first x second, with full relative accuracy where the bars are almost in line."""
        return self._moment * (1 / (self.r1 * self.r2))


@dataclass(frozen=True, eq=False)
class RRP:
    """RRP dyad: bar r1 from P1 to a slider on the line through P2 = P1 + span along `guide`.

    guide is a unit vector. With h the distance of P1 from the line, the slider is sqrt(r1^2 - h^2)
    from the foot of P1 on it; branch +1: ahead of the foot. All is nan where the bar does not reach
    the line. It is the RRR dyad whose second bar is infinite, its pivot far on the right of the
    guide: `second` is the guide's left normal.
    """

    span: tuple
    r1: float
    guide: tuple
    branch: object

    @cached_property
    def height(self):
        """Signed distance of P1 from the line, positive on its left."""
        return -cross(self.guide, self.span)

    @property
    def clearances(self):
        """How far the bar reaches beyond the line, m."""
        return (self.r1 - abs(self.height),)

    @cached_property
    def _reach(self):
        """Distance of the slider ahead of the foot of P1, m, by a product as in RRR."""
        square = (self.r1 - self.height) * (self.r1 + self.height)
        return sqrt_or_nan(square, -8 * EPS * self.r1 * self.r1) * self.branch

    @cached_property
    def slide(self):
        """Coordinate of the slider along the guide, from P2."""
        return self._reach - dot(self.guide, self.span)

    @cached_property
    def first(self):
        """Unit vector along the bar, from P1 to the slider."""
        x, y = self.guide
        along = self._reach * (1 / self.r1)
        across = self.height * (1 / self.r1)
        return along * x + across * y, along * y - across * x

    @property
    def second(self):
        """The guide's left normal."""
        return -self.guide[1], self.guide[0]

    @cached_property
    def sine(self):
        """first x second, 0 where the bar is perpendicular to the guide."""
        return self._reach * (1 / self.r1)


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

    def extent(self, direction):
        """Return the size of the coordinates from which `pivot` is computed, m."""
        return abs(self.x) + abs(self.y) + self.length

    def tangent(self, direction):
        """Return P'(q)."""
        return -self.length * direction[1], self.length * direction[0]

    def sine(self, direction, distal):
        """Return the sine of the angle between drive and distal bar: u2 . P' / |P'|."""
        return cross(direction, distal)

    def cosine(self, direction, distal):
        return dot(direction, distal)

    def velocity_coefficients(self, sine, cosine):
        """Return P'(q) along and across the distal bar; sine and cosine are of the angle between
        drive and bar.
        """
        return self.length * sine, self.length * cosine

    def acceleration_coefficients(self, sine, cosine):
        """Return P''(q) along and across the distal bar."""
        return -self.length * cosine, self.length * sine

    def close(self, xi, bar, working):
        """Return the dyad of the leg that reaches xi."""
        return RRR(
            (xi[0] - self.x, xi[1] - self.y), self.length, bar, working, abs(self.x) + abs(self.y)
        )

    def direction_in(self, dyad):
        """Return the drive's direction in the dyad that closes its leg."""
        return dyad.first

    def distal_in(self, dyad):
        """Return the unit vector along the distal bar in that dyad."""
        return dyad.last

    def limits(self, bar):
        """Return ((limit of the distance `apart`, whether it is the outer one), ...) of what the
        leg reaches, m.
        """
        return (self.length + bar, True), (self.length - bar, False)

    def apart(self, x, y):
        """Return the vector whose length `limits` limit."""
        return x - self.x, y - self.y

    def relative(self, absolute, own):
        """Passive joint's angle, rate or acceleration from the distal bar's absolute one and the
        drive's.
        """
        return absolute - own

    def absolute(self, passive, own):
        """Return the inverse of `relative`."""
        return passive + own


class Slider(NamedTuple):
    """Prismatic drive along y: P(q) = (x, y + q); in place of a `direction` it hands on q itself.

    The distal bar meets the guide with the sine and cosine of its own absolute angle.
    """

    x: float
    y: float

    @property
    def length(self) -> float:
        """|P'(q)|, which a crank's length is too."""
        return 1.0

    def direction(self, q):
        return q

    def coordinate(self, direction):
        return direction

    def pivot(self, direction):
        return self.x, self.y + direction

    def extent(self, direction):
        return abs(self.x) + abs(self.y) + abs(direction)

    def tangent(self, direction):
        return 0.0, 1.0

    def sine(self, direction, distal):
        return distal[1]

    def cosine(self, direction, distal):
        return distal[0]

    def velocity_coefficients(self, sine, cosine):
        return sine, cosine

    def acceleration_coefficients(self, sine, cosine):
        return 0.0, 0.0

    def close(self, xi, bar, working):
        return RRP((self.x - xi[0], self.y - xi[1]), bar, (0.0, 1.0), working)

    def direction_in(self, dyad):
        return dyad.slide

    def distal_in(self, dyad):
        x, y = dyad.first
        return -x, -y

    def limits(self, bar):
        return ((bar, True),)

    def apart(self, x, y):
        return x - self.x, 0.0 * y

    def relative(self, absolute, own):
        return absolute

    def absolute(self, passive, own):
        return passive
