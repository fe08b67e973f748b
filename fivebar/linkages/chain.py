"""The core of all linkages: points, headings and closures that know their first and second
derivative.

A point has p, v, a (pairs of components), a heading u, rate, acceleration; v and a are derivatives
by whatever the
drives count in: the crank angle (analogs) or time. Each is computed when first read, so a picture
pays for positions only. A dyad closes by two constraints that are linear in v and in a, with the
same 2 x 2 matrix [first; second].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import (
    EPS,
    atan2,
    cos,
    first_index,
    is_symbolic,
    reciprocal_or_nan,
    sin,
    sqrt,
    sqrt_or_nan,
)
from ..base.errors import SingularityError
from ..models.dyads import RRP, RRR, SINGULAR, cross, dot

if TYPE_CHECKING:
    from typing import TypeAlias

    import casadi

    from .five_bar import Carried

    Number = float | np.ndarray | casadi.SX
    # A point has p, v and a; a heading has u, rate and acceleration.
    Point: TypeAlias = "Fixed | Reach | Closure"
    Heading: TypeAlias = "Still | Turned | Bar | Slot | Carried"


@dataclass(frozen=True, eq=False)
class Fixed:
    """A point of the base."""

    p: tuple
    v = a = (0.0, 0.0)


@dataclass(frozen=True)
class Still:
    """A heading of the base: a unit vector."""

    u: tuple = (1.0, 0.0)
    rate = acceleration = 0.0


EAST = Still()


@dataclass(frozen=True, eq=False)
class Turned:
    """The heading that makes the angle (q, q', q'') with another one."""

    heading: Heading
    q: Number
    q_dot: Number = 1.0
    q_ddot: Number = 0.0

    @cached_property
    def u(self) -> tuple:
        c = cos(self.q)
        s = sin(self.q)
        if self.heading == EAST:
            return c, s
        x, y = self.heading.u
        return x * c - y * s, x * s + y * c

    @cached_property
    def rate(self) -> Number:
        return self.heading.rate + self.q_dot

    @cached_property
    def acceleration(self) -> Number:
        return self.heading.acceleration + self.q_ddot


@dataclass(frozen=True, eq=False)
class Reach:
    """The point of a body at (along, across) from its origin, in the axes of its heading."""

    origin: Point
    heading: Heading
    along: float
    across: float = 0.0

    @cached_property
    def _arm(self):
        x, y = self.heading.u
        if isinstance(self.across, float) and self.across == 0:
            return self.along * x, self.along * y
        return self.along * x - self.across * y, self.along * y + self.across * x

    @cached_property
    def p(self) -> tuple:
        return self.origin.p[0] + self._arm[0], self.origin.p[1] + self._arm[1]

    @cached_property
    def v(self) -> tuple:
        (x, y), rate = self._arm, self.heading.rate
        return self.origin.v[0] - rate * y, self.origin.v[1] + rate * x

    @cached_property
    def a(self) -> tuple:
        (x, y), turn, inward = (
            self._arm,
            self.heading.acceleration,
            self.heading.rate * self.heading.rate,
        )
        return self.origin.a[0] - turn * y - inward * x, self.origin.a[1] + turn * x - inward * y


@dataclass(frozen=True, eq=False)
class Bar:
    """The heading of a bar of constant length from one point to another."""

    start: Point
    end: Point
    length: float
    u: tuple

    @cached_property
    def rate(self) -> Number:
        return cross(self.u, minus(self.end.v, self.start.v)) * (1 / self.length)

    @cached_property
    def acceleration(self) -> Number:
        # Of u'' only the transverse part is left: the centripetal one is along u.
        return cross(self.u, minus(self.end.a, self.start.a)) * (1 / self.length)


@dataclass(frozen=True, eq=False)
class Closure:
    """The joint of a dyad on two pivots; the second pivot of an RRP dyad is the origin of its fixed
    guide.
    """

    pivots: tuple[Point, Point]
    dyad: RRR | RRP
    bends: tuple  # 1 / length of each bar: 0 for a guide, the bar of infinite length
    name: str  # what is in line, or perpendicular, where the dyad is singular

    @cached_property
    def p(self) -> tuple:
        (x, y), (ux, uy) = self.pivots[0].p, self.dyad.first
        return x + self.dyad.r1 * ux, y + self.dyad.r1 * uy

    @cached_property
    def v(self) -> tuple:
        along = (
            dot(u, pivot.v) for u, pivot in zip((self.dyad.first, self.dyad.second), self.pivots)
        )
        return self._solve(*along)

    @cached_property
    def a(self) -> tuple:
        along = []
        for u, pivot, bend in zip((self.dyad.first, self.dyad.second), self.pivots, self.bends):
            swing = 0.0
            if is_symbolic(bend) or bend:
                relative = minus(self.v, pivot.v)
                swing = (relative[0] * relative[0] + relative[1] * relative[1]) * bend
            along.append(dot(u, pivot.a) - swing)
        return self._solve(*along)

    def _solve(self, first, second):
        """Return the vector with these components along the dyad's two directions."""
        (x1, y1), (x2, y2), inverse = self.dyad.first, self.dyad.second, self._inverse
        return (y2 * first - y1 * second) * inverse, (x1 * second - x2 * first) * inverse

    @cached_property
    def _inverse(self):
        return inverse_sine(self.dyad.sine, self.name)


@dataclass(frozen=True, eq=False)
class Slot:
    """RPR dyad as a heading: of the guide that turns about one point and, `offset` to its left,
    passes a second one.

    branch +1: the second point is ahead of the first along the guide. `slide` is its coordinate
    there.
    """

    pivot: Point
    pin: Point
    offset: float
    branch: Number

    @cached_property
    def _span(self):
        return minus(self.pin.p, self.pivot.p)

    @property
    def clearances(self) -> tuple:
        """How far the second point is beyond the offset, m."""
        return (sqrt(dot(self._span, self._span)) - abs(self.offset),)

    @cached_property
    def slide(self) -> Number:
        x, y = self._span
        square = x * x + y * y
        return (
            sqrt_or_nan(square - self.offset * self.offset, -8 * EPS * self.offset * self.offset)
            * self.branch
        )

    @cached_property
    def u(self) -> tuple:
        (x, y), s, e = self._span, self.slide, self.offset
        inverse = reciprocal_or_nan(s * s + e * e, 0.0)
        return (s * x + e * y) * inverse, (s * y - e * x) * inverse

    @cached_property
    def _inverse(self):
        inverse = 1 / sqrt(self.slide * self.slide + self.offset * self.offset)
        return (
            inverse_sine(
                self.slide * inverse, "the guide is perpendicular to the line of its pivots"
            )
            * inverse
        )

    @cached_property
    def rate(self) -> Number:
        return cross(self.u, minus(self.pin.v, self.pivot.v)) * self._inverse

    @cached_property
    def slide_rate(self) -> Number:
        return dot(self.u, minus(self.pin.v, self.pivot.v)) + self.offset * self.rate

    @cached_property
    def acceleration(self) -> Number:
        across = cross(self.u, minus(self.pin.a, self.pivot.a))
        return (
            across - 2.0 * self.slide_rate * self.rate + self.offset * self.rate * self.rate
        ) * self._inverse

    @cached_property
    def slide_acceleration(self) -> Number:
        along = dot(self.u, minus(self.pin.a, self.pivot.a))
        return along + self.offset * self.acceleration + self.slide * self.rate * self.rate


@dataclass(frozen=True, eq=False)
class Along:
    """Scalar coordinate of a point along a fixed unit vector: p, v, a."""

    point: Point
    origin: tuple
    direction: tuple
    constant: float = 0.0

    @cached_property
    def p(self) -> Number:
        return self.constant + dot(self.direction, minus(self.point.p, self.origin))

    @cached_property
    def v(self) -> Number:
        return dot(self.direction, self.point.v)

    @cached_property
    def a(self) -> Number:
        return dot(self.direction, self.point.a)


def meet(
    first: Point, second: Point, r1: float, r2: float, branch: Number
) -> tuple[Closure, Bar, Bar]:
    """Return (joint, coupler, rocker) of an RRR dyad; branch +1: the joint is on the left of
    first -> second.
    """
    dyad = RRR(minus(second.p, first.p), r1, r2, branch)
    joint = Closure((first, second), dyad, (1 / r1, 1 / r2), "coupler and rocker are in line")
    return joint, Bar(first, joint, r1, dyad.first), Bar(second, joint, r2, dyad.second)


def slide(
    first: Point, origin: tuple, guide: tuple, r1: float, branch: Number, name: str
) -> tuple[Closure, Bar]:
    """Return (slider, bar) of an RRP dyad on a fixed guide; branch +1: the slider is ahead of
    `first` along the guide.
    """
    dyad = RRP(minus(origin, first.p), r1, guide, branch)
    joint = Closure((first, Fixed(origin)), dyad, (1 / r1, 0), name)
    return joint, Bar(first, joint, r1, dyad.first)


def minus(p: tuple, q: tuple) -> tuple:
    return p[0] - q[0], p[1] - q[1]


def angle(heading: Heading) -> Number:
    """In (-pi, pi]."""
    return atan2(heading.u[1], heading.u[0])


def inverse_sine(sine: Number, name: str) -> Number:
    """1 / sine, refused where it is rounding error: velocities have no answer there."""
    if is_symbolic(sine) or (isinstance(sine, float) and not abs(sine) <= SINGULAR):
        return 1.0 / sine
    singular = np.abs(sine) <= SINGULAR
    if singular.any():
        count, index = first_index(singular)
        where = f" in {count} of {singular.size} poses, the first at index {index}" if index else ""
        value = float(np.asarray(sine)[index])
        raise SingularityError(
            f"no velocity{where}: {name} (sine {value:.3g})", value, index or None
        )
    return 1.0 / sine
