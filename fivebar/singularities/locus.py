"""What a singularity locus is, a labelled piece of an exact curve, and how curves are traced and
cut into pieces.

Points are complex numbers inside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import pairs
from .margins import Singularity

MODES = tuple(product((1, -1), repeat=2))
TRACED = "traced"  # the kind of a curve that is chords between its points
TURN = math.radians(0.8)  # of the tangent from point to point; what is promised is 1 degree
# Chords of a smaller share of the robot's size (of a full turn, in joint space) are not divided.
FINEST = 1e-8


@dataclass(frozen=True, eq=False)
class Vertex:
    """Where pieces of loci end or touch: the same object is the same place.

    z: m; circles: of the legs that are in line there, as (leg, side), side 1 where stretched, -1
        where folded.
    """

    z: complex
    circles: tuple = ()


@dataclass(frozen=True, eq=False)
class Locus:
    """A piece of a locus along which its labels do not change.

    type; kind: "left stretched" (bars of that leg in line), "left folded", "right stretched",
    "right folded" (Type 1), of a biglide "left inward" (that bar across its guide, towards the
    other one), "left outward" and so on, "stretched", "folded" (distal bars, Type 2), "self-motion"
    (elbows coincide, Type 2); working: the working modes and
    assembly: the assembly modes in which it is singular (empty in task space); points (n, 2), m or
    rad, between which the curve turns by less than 1 degree, but in corners of 1e-8 of its size;
    parameters (n,) of these points; closed: the last point is the first one (in joint space up to
    full turns). An isolated singular point is a piece of n = 1. Angles are continuous along a piece
    and may leave (-pi, pi]. The loci of a biglide are lines without ends, `unbounded`: points are
    two of theirs, any parameter may be asked for.
    """

    type: Singularity
    kind: str
    working: tuple
    assembly: tuple
    points: np.ndarray = field(repr=False)
    parameters: np.ndarray = field(repr=False)
    closed: bool
    _curve: Callable = field(repr=False)
    _angles: bool = field(default=False, repr=False)
    unbounded: bool = False
    vertices: tuple = field(default=(), repr=False)  # the first and the last one, in task space
    circle: tuple = field(default=(), repr=False)  # (leg, side) where it is a circle of that leg

    @property
    def interval(self) -> tuple[float, float]:
        """(s0, s1): the parameters of the first and last point, or infinite."""
        if self.unbounded:
            return -math.inf, math.inf
        return float(self.parameters[0]), float(self.parameters[-1])

    def at(self, s: ArrayLike) -> np.ndarray:
        """Exact points (*s.shape, 2) of parameters s in `interval`."""
        s = np.asarray(s)
        points = pairs(self._curve(np.atleast_1d(s))[0]).reshape(*s.shape, 2)
        if self._angles:
            near = np.stack([np.interp(s, self.parameters, q) for q in self.points.T], axis=-1)
            points = points + 2 * np.pi * np.round((near - points) / (2 * np.pi))
        return points

    def drawn(self, low: float, high: float) -> np.ndarray:
        """Return points (n, 2) to draw: all, or of an unbounded line those of two parameters."""
        if self.unbounded:
            return self.at(np.array([low, high]))
        return self.points

    def tangent(self, s: ArrayLike) -> np.ndarray:
        """Derivative (*s.shape, 2) of the points by the parameter."""
        s = np.asarray(s)
        return pairs(self._curve(np.atleast_1d(s))[1]).reshape(*s.shape, 2)


@dataclass(frozen=True, eq=False)
class TypeThree:
    """Points of Type 3: xi (n, 2) m, q (n, 2) rad, and working (n, 2), 0 for a leg that is in
    line.
    """

    xi: np.ndarray
    q: np.ndarray
    working: np.ndarray


def values_of(mode: int) -> tuple[int, ...]:
    """Return the modes that a sign stands for: both where it is 0."""
    if mode:
        return (int(mode),)
    return (1, -1)


def modes_of(signs: Sequence[int]) -> tuple:
    """Return the working modes that two signs stand for."""
    return tuple(product(*map(values_of, signs)))


def type_of(signs: Sequence[int], own: Singularity) -> Singularity:
    """Return the type of a piece: Type 3 where another pair of bars is in line all along."""
    if all(signs):
        return own
    return Singularity.SERIAL | Singularity.PARALLEL


def pieces_of(
    curve: Callable,
    edges: np.ndarray,
    labels: list,
    scale: float,
    corners: np.ndarray | None = None,
    angles: bool = False,
    vertices: list | None = None,
    circle: tuple = (),
    period: float = 0.0,
) -> list[Locus]:
    """Return the Locus of each label between its edges.

    curve: parameters (n,) -> points (n,) and their derivatives;
    edges: parameters (n + 1,) where the labels change;
    labels: n times the type, kind, working and assembly modes of a Locus;
    scale: a length, m (or angle, rad), of which 1e-13 is rounding error;
    corners: the points at the edges, where they are known better than by the curve;
    angles: whether points are angles, which may have jumps of full turns;
    vertices: n + 1 of them, at the edges; circle: as in Locus;
    period: of the whole curve's parameter, where the edges are a part of it.
    """
    t, z = trace(curve, edges, scale, angles, period)
    if len(t) == 1:
        type_, kind, working, assembly = labels[0]
        return [Locus(type_, kind, working, assembly, pairs(z), t, False, curve, circle=circle)]
    where = np.searchsorted(t, edges)
    if corners is not None:
        z[where] = corners
    points = pairs(z)
    gap = points[-1] - points[0]
    if angles:
        turns = np.round(gap / (2 * np.pi)) * (2 * np.pi)
    else:
        turns = 0.0
    closes = np.abs(gap - turns).max() <= 1e-12 * scale
    if closes:
        points[-1] = points[0] + turns
    if vertices:
        ends = list(zip(vertices, vertices[1:]))
    else:
        ends = [()] * len(labels)
    loci = []
    for (type_, kind, working, assembly), i, j, own in zip(labels, where, where[1:], ends):
        loci.append(
            Locus(
                type_,
                kind,
                working,
                assembly,
                points[i : j + 1],
                t[i : j + 1],
                bool(closes and len(labels) == 1),
                curve,
                angles,
                vertices=own,
                circle=circle,
            )
        )
    return loci


def trace(
    curve: Callable, edges: np.ndarray, scale: float, angles: bool = False, period: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return parameters t (n,), edges among them, and points z (n,) between which the curve turns
    by less than 1 degree.
    """
    if edges[-1] == edges[0]:
        return edges[:1], curve(edges[:1])[0]
    period = period or edges[-1] - edges[0]
    t = divided(edges, np.maximum(np.ceil(192 * np.diff(edges) / period), 4).astype(int))
    while True:
        z, dz = curve(t)
        speed = np.abs(dz)
        step = np.diff(t)
        if speed.max() <= 1e-13 * scale:
            return t[:1], z[:1]
        chord = np.diff(z)
        mean = step * (dz[1:] + dz[:-1]) / 2
        if angles:
            chord = chord - _full_turns(chord - mean)
        # A cusp, always an edge, has a direction on either side but no derivative to tell it.
        cusp = np.zeros(len(t), dtype=bool)
        at = np.searchsorted(t, edges)
        cusp[at] = speed[at] < 1e-5 * np.maximum(
            speed[np.maximum(at - 1, 0)], speed[np.minimum(at + 1, len(t) - 1)]
        )
        turn = np.where(cusp[1:] | cusp[:-1], 0.0, np.abs(np.angle(dz[1:] * dz[:-1].conj())))
        counts = np.minimum(np.ceil(turn / TURN), 64).astype(int)
        between_chords = np.angle(chord[1:] * chord[:-1].conj())
        bend = (np.abs(between_chords) > 1.2 * TURN) & ~cusp[1:-1]
        # A loop between two points would turn by 0 but shows in the chord.
        loop = np.abs(chord - mean) > 0.05 * np.abs(mean)
        counts = np.maximum(counts, 1 + (loop | np.append(bend, False)))
        counts[(np.abs(chord) < FINEST * scale) | (step < 1e-13 * period)] = 1
        if counts.max() == 1:
            break
        t = divided(t, counts)
    if angles:  # the sum of chords tells the turns, each point by itself is better known
        summed = np.cumsum(np.append(z[:1], chord))
        z = z + _full_turns(summed - z)
    return t, z


def _full_turns(angles):
    """Return the full turns, rad, that are nearest to pairs of angles q1 + i q2."""
    turns = angles / (2 * np.pi)
    return 2 * np.pi * (np.round(turns.real) + 1j * np.round(turns.imag))


def divided(t: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """t with its intervals divided evenly into counts parts; the old values are kept to the last
    bit.
    """
    part = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(
        np.repeat(t[:-1], counts) + part * np.repeat(np.diff(t) / counts, counts), t[-1]
    )
