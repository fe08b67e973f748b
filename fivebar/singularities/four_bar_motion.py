"""All motions of a closed chain of four bars, parametrised so that they pass their dead points
smoothly.

The chain is base + r2 e2 = r1 e1 + c u in unit vectors e1, e2 (cranks) and u (coupler), complex
numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.backend import EPS, cos, is_symbolic, sin, sqrt, where_zero

ROUNDS = 8  # of Newton's steps, at most; two do but where two solutions are nearly one
NEAR = 1e-3  # a sine: farther from 0 there is no solution


@dataclass(frozen=True, eq=False)
class Turning:
    """A closed chain with free joints: of its directions (e1, e2, u) some turn by t in [0, 2 pi],
    the others stay.
    """

    start: tuple
    turns: tuple
    period: float = 2 * math.pi

    def __call__(self, t: np.ndarray) -> tuple[tuple | list, tuple | list]:
        """Return directions (e1, e2, u) and their rates by t."""
        turn = np.exp(1j * t)
        directions = [
            e * turn if turns else _as_long(t, complex(e))
            for e, turns in zip(self.start, self.turns)
        ]
        return directions, [_as_long(t, float(turns)) for turns in self.turns]

    def meets(self, ways: list[tuple[int, complex]]) -> list[list[float]]:
        """For each (crank 0 or 1, unit vector) the t at which the coupler is turned by it against
        that crank.
        """
        found = []
        for crank, turn in ways:
            angle = np.angle(turn * self.start[crank] / self.start[2])
            once = self.turns[crank] != self.turns[2]
            found.append(
                [float((angle if self.turns[2] else -angle) % (2 * math.pi))] if once else []
            )
        return found

    @property
    def flat(self) -> list[float]:
        """Values of t at which all bars are in line, so that another motion can pass there."""
        if not 0 < sum(self.turns) < 3:
            return []
        flat = all(complex(e).imag == 0 for e in self.start)
        return [0.0, math.pi] if flat else []


@dataclass(frozen=True, eq=False)
class FourBarMotion:
    """One closed component of the motions of a four-bar; t in [0, period] passes all dead points
    smoothly.

    The diagonal from the base of crank 1 to the end of crank 2 splits it into two triangles. Its
    square w = lo^2 + (hi^2 - lo^2) sin^2 t runs between the limits of both; the limits of each are
    the squares of the sum and the difference of its sides, so that cos and sin of half of its angle
    are sqrt(w - low) and sqrt(high - w), up to scale. A triangle that sets a limit has there a
    factor sin t or cos t, with the sign that leads through it.
    """

    base: float
    r1: float
    c: float
    r2: float
    span: float  # hi^2 - lo^2
    slack: (
        tuple  # per triangle (lo^2 - its own low, its own high - hi^2), 0 where it sets the limit
    )
    signs: tuple
    period: float
    mirrored: bool  # the sides are those of the mirror image, with the cranks exchanged

    def __call__(self, t: np.ndarray) -> tuple[tuple | list, tuple | list]:
        """Return directions (e1, e2, u) and their rates by t."""
        (e1, e2, u), (rate1, rate2, rate) = self._of_sides(t)
        if self.mirrored:
            mirror_image = -e2.conjugate(), -e1.conjugate(), u.conjugate()
            return mirror_image, (-rate2, -rate1, -rate)
        return (e1, e2, u), (rate1, rate2, rate)

    def _of_sides(self, t):
        """Return the same of the chain whose sides are given, mirrored or not."""
        sides = self.base, self.r1, self.c, self.r2
        directions, rates = four_bar_directions(sides, self.span, self.slack, self.signs, t)
        rate1, rate2, rate = rates
        unit_vectors = [x + 1j * y for x, y in directions]
        return unit_vectors, (rate1, _as_long(t, rate2), rate)

    def meets(self, ways: list[tuple[int, complex]]) -> list[list[float]]:
        """For each (crank 0 or 1, unit vector) the t at which the coupler is turned by it against
        that crank.

        Crank and coupler are one bar there, which closes a triangle with the base and the other
        crank. A double value may come as two.
        """
        guesses = []
        owners = []
        if self.mirrored:
            ways = [(1 - crank, -complex(turn).conjugate()) for crank, turn in ways]
        for k, (crank, turn) in enumerate(ways):
            for w in self._diagonals(crank, turn):
                guesses += self._times(w)
                owners += [k] * 4
        if not guesses:
            return [[] for _ in ways]
        t = np.array(guesses)
        owners = np.array(owners)
        off, step = self._off(t, ways, owners)
        # Of the four t of a diagonal, those at which the bars are on its other side are no guesses.
        near = off < NEAR
        t, owners, off, step = t[near], owners[near], off[near], step[near]
        for _ in range(ROUNDS):
            moved = t - step
            less, further = self._off(moved, ways, owners)
            # Where two values are one the slope is 0, and Newton's steps lead away in the end.
            better = less < off
            if not better.any():
                break
            t = np.where(better, moved, t)
            off = np.where(better, less, off)
            step = np.where(better, further, 0.0)
        times: list[list[float]] = []
        for k in range(len(ways)):
            own = t[(off < 1e-12) & (owners == k)] % self.period
            times.append(sorted(set(own.tolist())))
        return times

    def _off(self, t, ways, owners):
        """Return |sin| of the angle that the coupler lacks at t, and Newton's step to there."""
        if not len(t):
            return np.empty(0), np.empty(0)
        cranks, turns = (np.array(each)[owners] for each in zip(*ways))
        (e1, e2, u), (rate1, rate2, rate) = self._of_sides(t)
        relative = u / (np.where(cranks == 0, e1, e2) * turns)
        off = np.where(relative.real > 0, np.abs(relative.imag), np.inf)
        slope = relative.real * (rate - np.where(cranks == 0, rate1, rate2))
        step = relative.imag / np.where(slope == 0, np.inf, slope)
        return off, np.clip(step, -0.02, 0.02)

    def _times(self, w):
        """Return values of t at which the diagonal's square is w, or nearest to it."""
        low = (self.base - self.r2) ** 2 + self.slack[0][0]
        t = math.asin(math.sqrt(min(max((w - low) / self.span, 0.0), 1.0)))
        return [t, math.pi - t, math.pi + t, 2 * math.pi - t]

    def _diagonals(self, crank, turn):
        """Squares of the diagonal at which crank and coupler, as one bar, close a triangle."""
        if crank == 0:
            return [abs(self.r1 + self.c * turn) ** 2]
        bar = self.r2 - self.c * turn
        if bar == 0:
            return []
        length = abs(bar)
        excess = self.r1**2 - self.base**2 - length**2
        cosine = excess / (2 * self.base * length)
        cosine = min(max(cosine, -1.0), 1.0)
        e = complex(cosine, math.sqrt((1 - cosine) * (1 + cosine)))
        unit = length / bar
        return [abs(self.base + self.r2 * way * unit) ** 2 for way in (e, e.conjugate())]

    @property
    def flat(self) -> list[float]:
        """Values of t at which all bars are in line, so that another motion can pass there."""
        first, second = self.slack
        flat = []
        if first[0] == second[0] == 0:
            flat += [0.0, math.pi]
        if first[1] == second[1] == 0:
            flat += [math.pi / 2, 1.5 * math.pi]
        return [t for t in flat if t < self.period]


def aligned(motion: FourBarMotion | Turning) -> list[float]:
    """Return the parameters of a motion at which a crank and the coupler are in line."""
    found = motion.meets([(0, 1), (0, -1), (1, 1), (1, -1)])
    return [t for times in found for t in times]


def _as_long(t, value):
    """Return a value at each of the parameters t (n,), or at one."""
    if isinstance(t, np.ndarray):
        return np.full(t.shape, value)
    return value


def four_bar_directions(
    sides: tuple, span: Any, slack: tuple, signs: tuple, t: Any
) -> tuple[tuple, tuple]:
    """Return unit vectors e1, e2, u and their rates by t, on components, of the closed component
    that `FourBarMotion` says.

    sides: base, r1, c, r2; the others as there, CasADi symbols too.
    """
    base, r1, c, r2 = sides
    root = sqrt(span)
    s = root * sin(t)
    co = root * cos(t)
    half2, rate2 = _half(s, co, slack[0], signs[0])
    half, passive_rate = _half(s, co, slack[1], signs[1])
    (e2, along2), (passive, along) = _doubled(half2), _doubled(half)
    # The diagonal base + r2 e2 = e1 (r1 + c passive), either side without the cancellation of a
    # short diagonal.
    dx = base - r2 + r2 * along2 * half2[0]
    dy = r2 * along2 * half2[1]
    ax = r1 - c + c * along * half[0]
    ay = c * along * half[1]
    x = dx * ax + dy * ay
    y = dy * ax - dx * ay
    scale = 1.0 / sqrt(x * x + y * y)
    e1 = x * scale, y * scale
    ux = e1[0] * passive[0] - e1[1] * passive[1]
    uy = e1[0] * passive[1] + e1[1] * passive[0]
    w = 2.0 * (dx * dx + dy * dy)
    rate1 = (0.5 + (r2 - base) * (r2 + base) / w) * rate2 - (
        0.5 + (c - r1) * (c + r1) / w
    ) * passive_rate
    return (e1, e2, (ux, uy)), (rate1, rate2, rate1 + passive_rate)


def _half(s, c, slack, sign):
    """cos and sin of half of a triangle's angle, times the root of 4 x the product of its sides,
    and its rate.
    """
    (x, slope), (y, fall) = _passed(s, slack[0]), _passed(c, slack[1])
    return (x, sign * y), -2.0 * sign * slope * fall


def _passed(s, slack):
    """Return the root of s^2 + slack, with the sign of s where there is no slack, and s over it."""
    if is_symbolic(slack):
        x = where_zero(slack, lambda: s, sqrt(s * s + slack))
        return x, where_zero(slack, lambda: 1.0, s / x)
    if slack == 0:
        return s, 1.0
    x = sqrt(s * s + slack)
    return x, s / x


def _doubled(half):
    """Return the unit vector at twice the angle of a vector (x, y), and 2 x / |(x, y)|^2."""
    x, y = half
    share = 2.0 * x / (x * x + y * y)
    return (x * share - 1.0, y * share), share


def _triangle(a, b, c, tolerance):
    """Return unit vectors e with |a + b e| = c: two, one where the triangle is flat, none where it
    does not close.
    """
    if a + b < c - tolerance or abs(a - b) > c + tolerance:
        return []
    if a + b <= c + tolerance:
        return [1.0]
    if abs(a - b) >= c - tolerance:
        return [-1.0]
    half = complex(math.sqrt((c - (a - b)) * (c + (a - b))), math.sqrt((a + b - c) * (a + b + c)))
    e = half / half.conjugate()
    return [e, e.conjugate()]


def closures(base: float, r1: float, c: float, r2: float) -> list[FourBarMotion | Turning]:
    """Return all motions of the closed chain base + r2 e2 = r1 e1 + c u, one for each closed
    component.

    Sides in m, any may be 0. Where two are 0 together, what remains free has two dimensions: no
    motion is given, but for base = c = 0, whose cranks turn together.
    """
    tolerance = 8 * EPS * (base + r1 + c + r2)
    zero = [side <= tolerance for side in (base, r1, c, r2)]
    if sum(zero) > 1:
        together = zero == [True, False, True, False] and abs(r1 - r2) <= tolerance
        if together:
            return [Turning((1, 1, 1), (1, 1, 0))]
        return []
    if base <= tolerance:
        return [
            Turning((1, _unit(r1 + c * u), u), (1, 1, 1)) for u in _triangle(r1, c, r2, tolerance)
        ]
    if c <= tolerance:
        return [
            Turning((_unit(base + r2 * e), e, 1), (0, 0, 1))
            for e in _triangle(base, r2, r1, tolerance)
        ]
    if r1 <= tolerance:
        return [
            Turning((1, e, _unit(base + r2 * e)), (1, 0, 0))
            for e in _triangle(base, r2, c, tolerance)
        ]
    if r2 <= tolerance:
        return [
            Turning((-e, 1, _unit(base + r1 * e)), (0, 1, 0))
            for e in _triangle(base, r1, c, tolerance)
        ]
    sides = [(base, r1, c, r2), (base, r2, c, r1)]
    shortest = [max(abs(s[0] - s[3]), abs(s[1] - s[2])) for s in sides]
    if (
        max(shortest) <= tolerance
    ):  # a rhombus: it folds about either diagonal, or turns as a parallelogram
        return [
            Turning((1, 1, 1), (1, 1, 0)),
            Turning((1, -1, -1), (1, 0, 1)),
            Turning((1, 1, 1), (0, 1, 1)),
        ]
    mirrored = (
        shortest[1] > shortest[0]
    )  # the longer a diagonal stays, the better its direction is known
    return _components(*sides[mirrored], mirrored, tolerance)


def _factor(x, limit, tolerance):
    """Return |x^2 - limit^2|, 0 where x is the limit."""
    if abs(x - limit) <= tolerance:
        return 0.0
    return abs(x - limit) * (x + limit)


def _components(base, r1, c, r2, mirrored, tolerance):
    lows = (abs(base - r2), abs(r1 - c))
    highs = (base + r2, r1 + c)
    low = max(lows)
    high = min(highs)
    if high < low - tolerance:
        return []
    if high - low <= tolerance:  # it closes in one flat pose
        # The triangle of the shorter sum is stretched, the other one folded.
        if highs[0] < highs[1]:
            e1 = math.copysign(1, r1 - c)
            e2 = 1
        else:
            e1 = math.copysign(1, base - r2)
            e2 = -1
        u = -e1 * e2
        if mirrored:
            return [Turning((-e2, -e1, u), (0, 0, 0))]
        return [Turning((e1, e2, u), (0, 0, 0))]
    below = [_factor(x, low, tolerance) for x in lows]
    above = [_factor(x, high, tolerance) for x in highs]
    # Where both factors of a triangle's angle change sign together, half a turn of t is a whole
    # motion.
    whole = all((b == 0) == (a == 0) for b, a in zip(below, above))
    signs = [(1, 1)]
    if whole:
        signs.append((1, -1) if below[0] == 0 else (-1, 1))
    span = (high - low) * (high + low)
    slack = tuple(zip(below, above))
    period = math.pi if whole else 2 * math.pi
    return [FourBarMotion(base, r1, c, r2, span, slack, s, period, mirrored) for s in signs]


def _unit(z):
    return z / abs(z)
