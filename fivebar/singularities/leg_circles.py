"""Circles about the base joints on which a leg is in line, or its two bars make a given angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from ..base.backend import atan2, is_symbolic, sqrt
from ..models.robots import FiveBar
from .locus import MODES, Locus, Vertex, pieces_of
from .margins import Singularity

# Lengths whose sum is a smaller share of the robot's size are one length: circles touch then.
TOUCH = 1e-14


def size_of(robot: FiveBar) -> float:
    """Of the whole robot, m: tolerances are shares of it."""
    return robot.l11 + robot.l12 + robot.l21 + robot.l22 + robot.d


@dataclass(frozen=True, eq=False)
class Circle:
    """Circle that the end-effector follows: `task` as that of a CouplerCurve."""

    center: float
    radius: float

    @property
    def on_line(self) -> tuple[float, float]:
        """Where it crosses the line of the bases, m."""
        return self.center - self.radius, self.center + self.radius

    def task(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        radius = self.radius * np.exp(1j * t)
        return self.center + radius, 1j * radius


@dataclass(frozen=True, eq=False)
class LegCircles:
    """The circles of |sin q_i2| = sin: of each leg (0, 1) the outer one, side 1, and the inner one,
    side -1.

    l2 turned by q_i2 against l1 reaches the root of l1^2 + l2^2 + 2 l1 l2 cos q_i2 far; at sin = 0
    this is Type 1. bends: (cosine, sine) of the angle between the bars' lines, by (leg, side), for
    circles on which it is another one.
    """

    robot: FiveBar
    sin: float = 0.0
    bends: Mapping[tuple[int, int], tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def cosine(self) -> float:
        return math.sqrt((1 - self.sin) * (1 + self.sin))

    @cached_property
    def scale(self) -> float:
        return size_of(self.robot)

    def bend(self, leg: int, side: int) -> tuple[float, float]:
        """Return (cosine, sine) of the angle between the bars' lines on a circle."""
        return self.bends.get((leg, side), (self.cosine, self.sin))

    def radius(self, leg: int, side: int) -> float:
        """m; 0 where equal bars fold."""
        proximal = self.robot.drives[leg].length
        distal = self.robot.distal[leg]
        cosine, sine = self.bend(leg, side)
        return math.hypot(proximal + side * distal * cosine, distal * sine)

    def circle(self, leg: int, side: int) -> Circle:
        # Its parameter counts from the direction to the other base joint.
        return Circle(self.robot.drives[leg].x, (1, -1)[leg] * self.radius(leg, side))

    @cached_property
    def touches(self) -> tuple[Vertex, ...]:
        """Where circles of both legs touch, on the line of the bases, and those of no radius."""
        tolerance = TOUCH * self.scale
        found: dict[tuple, float] = {}
        left = [(side, self.circle(0, side)) for side in (1, -1)]
        right = [(side, self.circle(1, side)) for side in (1, -1)]
        for leg, circles in enumerate((left, right)):
            found |= {((leg, side),): c.center for side, c in circles if abs(c.radius) <= tolerance}
        if self.robot.d > tolerance:
            for (one, a), (other, b) in product(left, right):
                for x, y in product(a.on_line, b.on_line):
                    if abs(x - y) <= tolerance:
                        found[(0, one), (1, other)] = x
        vertices = []
        for own, x in found.items():
            if not any(set(own) < set(more) for more in found):
                vertices.append(Vertex(complex(x), own))
        return tuple(vertices)

    @cached_property
    def pieces(self) -> tuple[Locus, ...]:
        """The arcs that both legs reach, and, where they cross, one Vertex for both."""
        corners: dict = {}
        return tuple(
            arc for leg, side in product((0, 1), (1, -1)) for arc in self._arcs(leg, side, corners)
        )

    def _arcs(self, leg, side, corners):
        """Return the arcs of a leg's circle that the other leg reaches.

        corners: {on which circles, above or below the bases: Vertex} of circles that cross, which
            this adds to.
        """
        circle = self.circle(leg, side)
        d = self.robot.d
        radius = abs(circle.radius)
        tolerance = TOUCH * self.scale
        inner = self.radius(1 - leg, -1)
        outer = self.radius(1 - leg, 1)
        low = max(inner, abs(d - radius))
        high = min(outer, d + radius)
        if high < low - tolerance:
            return []
        kind = f"{('left', 'right')[leg]} {'stretched' if side > 0 else 'folded'}"
        _, sine = self.bend(leg, side)
        label = Singularity.NONE if sine else Singularity.SERIAL, kind, MODES, ()

        def arc(span, reaches=()):
            """Between two parameters, at which the other leg is on its stretched (1) or folded (-1)
            circle.
            """
            vertices = []
            for t, reach in zip(span, reaches):
                z = complex(circle.task(np.array([t]))[0][0])
                circles = tuple(sorted(((leg, side), (1 - leg, reach))))
                vertices.append(corners.setdefault((circles, z.imag > 0), Vertex(z, circles)))
            return pieces_of(
                circle.task,
                np.array(span),
                [label],
                self.scale,
                vertices=vertices,
                circle=(leg, side),
            )

        if radius <= tolerance:
            return arc((0.0, 0.0))
        if d <= tolerance:
            return arc((0, 2 * np.pi))
        if (
            high - low <= tolerance
        ):  # the other leg's reach only touches it, in a point on the line of the bases
            if low > abs(d - radius) + tolerance:
                angle = math.pi
            else:
                angle = 0.0
            return arc((angle, angle))
        first, last = (turn_to(r, d, radius) for r in (low, min(high, d + radius)))
        whole_in = low <= abs(d - radius) + tolerance
        whole_out = high >= d + radius - tolerance
        if whole_in and whole_out:
            return arc((0, 2 * np.pi))
        if whole_in:
            return arc((-last, last), (1, 1))
        if whole_out:
            return arc((first, 2 * np.pi - first), (-1, -1))
        return [*arc((first, last), (-1, 1)), *arc((-last, -first), (1, -1))]


def turn_to(r: Any, d: Any, radius: Any) -> Any:
    """Angle, from the direction of the other base joint d away, at which a circle's point is r from
    that joint.

    By its half: sin^2 = (r^2 - (d - radius)^2) / (4 d radius). Floats or CasADi symbols.
    """
    near = (r - d + radius) * (r + d - radius)
    far = (d + radius - r) * (d + radius + r)
    return 2.0 * atan2(_root(near), _root(far))


def _root(square):
    return sqrt(square.fmax(0.0) if is_symbolic(square) else max(square, 0.0))
