"""What a singularity locus is: a labelled piece of an exact curve. Points are complex numbers inside."""

import math
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from .margins import Singularity

MODES = tuple(product((1, -1), repeat=2))


@dataclass(frozen=True, eq=False)
class Locus:
    """A piece of a locus along which its labels do not change.

    type; kind: "left stretched" (bars of that leg in line), "left folded", "right stretched", "right folded" (Type 1),
    of a biglide "left inward" (that bar across its guide, towards the other one), "left outward" and so on,
    "stretched", "folded" (distal bars, Type 2), "self-motion" (elbows coincide, Type 2); working: the working modes and
    assembly: the assembly modes in which it is singular (empty in task space); points (n, 2), m or rad, between which
    the curve turns by less than 1 degree, but in corners of 1e-8 of its size; parameters (n,) of these points; closed:
    the last point is the first one (in joint space up to full turns). An isolated singular point is a piece of n = 1.
    Angles are continuous along a piece and may leave (-pi, pi].
    The loci of a biglide are lines without ends, `unbounded`: points are two of theirs, any parameter may be asked for.
    """

    type: Singularity
    kind: str
    working: tuple
    assembly: tuple
    points: np.ndarray = field(repr=False)
    parameters: np.ndarray = field(repr=False)
    closed: bool
    _curve: object = field(repr=False)
    _angles: bool = field(default=False, repr=False)
    unbounded: bool = False

    @property
    def interval(self):
        """(s0, s1): the parameters of the first and last point, or infinite."""
        if self.unbounded:
            return -math.inf, math.inf
        return float(self.parameters[0]), float(self.parameters[-1])

    def at(self, s):
        """Exact points (*s.shape, 2) of parameters s in `interval`."""
        s = np.asarray(s, dtype=float)
        points = pairs(self._curve(np.atleast_1d(s))[0]).reshape(*s.shape, 2)
        if self._angles:
            near = np.stack([np.interp(s, self.parameters, q) for q in self.points.T], axis=-1)
            points = points + 2 * np.pi * np.round((near - points) / (2 * np.pi))
        return points

    def drawn(self, low, high):
        """Points (n, 2) to draw: all, or of an unbounded line those of two parameters."""
        return self.at(np.array([low, high])) if self.unbounded else self.points

    def tangent(self, s):
        """Derivative (*s.shape, 2) of the points by the parameter."""
        s = np.asarray(s, dtype=float)
        return pairs(self._curve(np.atleast_1d(s))[1]).reshape(*s.shape, 2)


@dataclass(frozen=True, eq=False)
class TypeThree:
    """Points of Type 3: xi (n, 2) m, q (n, 2) rad, and working (n, 2), 0 for a leg that is in line."""

    xi: np.ndarray
    q: np.ndarray
    working: np.ndarray


def values_of(mode):
    return (int(mode),) if mode else (1, -1)


def modes_of(signs):
    return tuple(product(*map(values_of, signs)))


def type_of(signs, own):
    """The type of a piece: Type 3 where another pair of bars is in line all along."""
    return own if all(signs) else Singularity.SERIAL | Singularity.PARALLEL


def pairs(z):
    return np.stack([z.real, z.imag], axis=-1)
