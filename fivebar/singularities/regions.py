"""Regions of the plane bounded by exact curves: arcs, and what lies inside of them.

Points are complex numbers, x + i y, m.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import QhullError, Voronoi

from ..base.backend import EPS, pairs
from .locus import TRACED, Locus
from .roots import rising_zeros

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
TAIL = (np.polynomial.legendre.legvander(NODES, 11) * WEIGHTS[:, None] * (np.arange(12) + 0.5))[
    :, 10:
]
HALVINGS = 60  # of a panel where speed and direction change in a small part of it, at most
SHORT = 1e-6  # of the robot's size: arcs beside which nothing is asked
PANEL = 12  # steps of a polyline, of at most 1 degree each, that are integrated together


@dataclass(frozen=True, eq=False)
class LocusArc:
    """A part of a locus, run through from parameter `start` to `end`, which may be the lower
    one.
    """

    locus: Locus
    start: float
    end: float

    @cached_property
    def _samples(self):
        low, high = sorted((self.start, self.end))
        own = self.locus.parameters
        inner = (own > low) & (own < high)
        first, last = self.locus._curve(np.array([low, high]))[0]
        s = np.concatenate([[low], own[inner], [high]])
        z = np.concatenate([[first], self.locus.points[inner] @ (1, 1j), [last]])
        if self.start <= self.end:
            return (s, z)
        return (s[::-1], z[::-1])

    @property
    def s(self) -> np.ndarray:
        """Parameters (n,) in running order between which the direction turns by less than 1
        degree.
        """
        return self._samples[0]

    @property
    def z(self) -> np.ndarray:
        """Points (n,) of these parameters."""
        return self._samples[1]

    @property
    def reversed(self) -> LocusArc:
        twin = LocusArc(self.locus, self.end, self.start)
        twin.__dict__.update(
            _samples=tuple(each[::-1] for each in self._samples), moment=-self.moment
        )
        return twin

    def curve(self, s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points and their derivative by the parameter, in the arc's direction."""
        s = np.asarray(s, dtype=float)
        z, dz = self.locus._curve(
            s.item() if s.size == 1 else s
        )  # of a float in a fifth of the time
        return np.reshape(z, s.shape), np.reshape(dz if self.start <= self.end else -dz, s.shape)

    def at(self, s: float | np.ndarray) -> np.ndarray:
        return self.curve(s)[0]

    def tangent(self, s: float | np.ndarray) -> np.ndarray:
        return self.curve(s)[1]

    @cached_property
    def step(self) -> float:
        """The longest chord between samples, m."""
        return float(np.abs(np.diff(self.z)).max())

    @cached_property
    def moment(self) -> float:
        """Line integral of (x dy - y dx) / 2: the area swept from the origin."""
        if self.locus.kind == TRACED:
            return float((self.z[:-1].conj() * self.z[1:]).imag.sum()) / 2
        edges = self.s[np.unique(np.append(np.arange(0, len(self.s), PANEL), len(self.s) - 1))]
        low = edges[:-1]
        high = edges[1:]
        total = 0.0
        least = 4 * EPS * np.abs(self.z).max() ** 2
        most = 2 * len(edges) + 16
        for _ in range(HALVINGS):
            half = (high - low)[:, None] / 2
            nodes = low[:, None] + half * (1 + NODES)
            z, dz = self.curve(nodes.ravel())
            swept = (z.conj() * dz).imag.reshape(nodes.shape) * np.abs(half) / 2
            # The last Legendre coefficients say how far the polynomial through the nodes is off.
            rough = np.abs(swept @ TAIL).sum(axis=1) > least
            # A corner is in one half of a panel; what is in both halves is rounding error.
            rough &= rough.sum() <= most
            total += float((swept @ WEIGHTS)[~rough].sum())
            if not rough.any():
                break
            low = low[rough]
            high = high[rough]
            middle = (low + high) / 2
            low = np.concatenate([low, middle])
            high = np.concatenate([middle, high])
        return total

    def dense(self, spacing: float) -> np.ndarray:
        """Return points on the arc about this far apart, its start but not its end among them."""
        along = np.append(0.0, np.cumsum(np.abs(np.diff(self.z))))
        even = np.linspace(0, along[-1], int(np.ceil(along[-1] / spacing)) + 1)[:-1]
        return self.at(np.interp(even, along, self.s))

    def feet(self, z: complex, within: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Return parameters and distances of the arc's points that are locally nearest to z and not
        farther than `within`.
        """
        distance = np.abs(self.z - z)
        left = np.append(np.inf, distance[:-1])
        right = np.append(distance[1:], np.inf)
        s, distance = self._feet(z, np.flatnonzero((distance <= left) & (distance <= right)))
        s, first = np.unique(s, return_index=True)
        distance = distance[first]
        return s[distance <= within], distance[distance <= within]

    def nearest(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return parameters (n,) and distances (n,) of the points of the arc that are nearest to
        points z (n,).
        """
        s, distance = zip(*map(self._nearest, _batches(z)))
        return np.concatenate(s), np.concatenate(distance)

    def _nearest(self, z):
        part, distance = self._on_chords(z)
        # All chords that can be nearest: an arc of 1 degree stays within a two-hundredth of its
        # chord.
        slack = 0.005 * np.abs(np.diff(self.z))
        rows, k = np.nonzero(distance - slack <= (distance + slack).min(axis=1)[:, None])
        s, distance = self._feet(z[rows], k + (part[rows, k] > 0.5))
        order = np.lexsort((distance, rows))
        first = order[np.searchsorted(rows[order], np.arange(len(z)))]
        return s[first], distance[first]

    def _on_chords(self, z):
        """For points (n,) and each chord between samples, the part of it up to the nearest point,
        and the distance.
        """
        start = self.z[:-1]
        chord = np.diff(self.z)
        away = z[:, None] - start
        square = np.abs(chord) ** 2
        square = np.where(square, square, 1.0)  # 0 where two samples are in one place
        part = np.clip((away * chord.conj()).real / square, 0, 1)
        return part, np.abs(away - part * chord)

    def _feet(self, z, index):
        """Return where the tangent is across the way from z, between the neighbours of sample
        points of these indices.
        """
        s = self.s[index]
        on, tangent = self.curve(s)
        ahead = ((on - z) * tangent.conj()).real < 0
        low = np.where(ahead, s, self.s[np.maximum(index - 1, 0)])
        high = np.where(ahead, self.s[np.minimum(index + 1, len(self.s) - 1)], s)
        z = np.broadcast_to(z, s.shape)
        rounding = 4 * EPS * np.abs(self.z).max() * np.abs(tangent)
        foot = rising_zeros(lambda i, t: self._slope(t, z[i]), low, high, rounding)
        s = np.where(np.isnan(foot), s, foot)
        return s, np.abs(self.at(s) - z)

    def _slope(self, s, z):
        on, tangent = self.curve(s)
        return ((on - z) * tangent.conj()).real

    @property
    def extent(self) -> float:
        """As far as `leaves` goes: from the start to the farthest point, of a circle beyond the
        arc's end.
        """
        if self.locus.circle:
            return 2 * float(np.abs(self.tangent(self.start)))
        return float(np.abs(self.z - self.z[0]).max())

    def leaves(self, radius: float) -> complex:
        """Return the first point of the arc, of a circle also beyond its end, at this distance from
        its start.
        """
        if self.locus.circle:
            step = 2 * np.arcsin(radius / self.extent)
            return complex(self.at(self.start + (step if self.start < self.end else -step)))
        outside = int(np.argmax(np.abs(self.z - self.z[0]) >= radius))
        low = self.s[outside - 1]
        high = self.s[outside]
        for _ in range(3):
            s = np.linspace(low, high, 33)
            distance = np.abs(self.at(s) - self.z[0])
            k = max(int(np.argmax(distance >= radius)), 1)
            low, high = s[k - 1 : k + 1]
        # A curve may be so near to a circle that it must be compared at the same distance.
        return complex(self.at(np.interp(radius, distance[k - 1 : k + 1], [low, high])))


def crossings(loops: Sequence, z: np.ndarray) -> np.ndarray:
    """Return whether points z (n,) are inside the loops' polylines: whether a ray from them crosses
    an odd number of times.
    """
    found = np.zeros(len(z), dtype=bool)
    for loop in loops:
        polygon = np.concatenate([arc.z[:-1] for arc in loop])
        found ^= _crosses(polygon, np.roll(polygon, -1), z)
    return found


def _crosses(a, b, z):
    """Return whether rays from points z (n,) along x cross an odd number of chords a to b."""
    order = np.argsort(z.imag)
    first, last = (
        np.searchsorted(z.imag[order], ends(a.imag, b.imag)) for ends in (np.minimum, np.maximum)
    )
    k = np.repeat(
        np.arange(len(a)), last - first
    )  # each chord as often as there are points beside it
    rows = order[np.arange(len(k)) - np.repeat(np.cumsum(last - first) - last, last - first)]
    start = a[k]
    share = (z.imag[rows] - start.imag) / (b.imag[k] - start.imag)
    x = start.real + share * (b.real[k] - start.real)
    return np.bincount(rows[x > z.real[rows]], minlength=len(z)) % 2 == 1


def _batches(z, most=1024):
    """Return parts of points (n,), so few that the way from each of them to each chord of an arc
    fits into memory.
    """
    if len(z) <= most:
        return [z]
    return np.array_split(z, len(z) // most + 1)


def inside(loops: Sequence, z: np.ndarray) -> np.ndarray:
    """Return whether points z (n,) are inside the loops, exactly."""
    found, near = roughly_inside(loops, z)
    if near.any():
        found[near] = _left_of_nearest([arc for loop in loops for arc in loop], z[near])
    return found


def roughly_inside(loops: Sequence, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return whether points z (n,) are inside the loops' polylines, and whether they are so near
    that the arcs may differ.
    """
    arcs = [arc for loop in loops for arc in loop]
    found = crossings(loops, z)
    # A polyline that turns by 1 degree is nearer to its arc than a hundredth of its longest step.
    doubtful = 0.02 * max(arc.step for arc in arcs)
    near = np.zeros(len(z), dtype=bool)
    for arc in arcs:
        distance = np.concatenate(
            [np.abs(arc.z - part[:, None]).min(axis=1) for part in _batches(z)]
        )
        near |= distance <= doubtful + 0.51 * arc.step
    return found, near


def _left_of_nearest(arcs, z):
    """Return whether points are on the left of the arc that is nearest, of all of them where the
    nearest point is a corner.
    """
    places = [arc.nearest(z) for arc in arcs]
    s = np.array([own for own, _ in places])
    distance = np.array([length for _, length in places])
    nearest = distance.min(axis=0)
    left = np.ones(len(z), dtype=bool)
    for arc, own, length in zip(arcs, s, distance):
        away = z - arc.at(own)
        right = (arc.tangent(own).conj() * away).imag <= 0
        left &= ~((length <= nearest * (1 + 1e-9) + 1e-15) & right)
    return left


def points_of_largest_clearance(
    loops: tuple,
    obstacles: np.ndarray,
    area: float,
    count: int = 1,
    samples: int = 500,
    walls: Sequence = (),
    allowed: Callable | None = None,
) -> list[tuple[complex, float]]:
    """Return points inside the loops that are locally farthest from them and from the points
    `obstacles`: (point, distance).

    At most `count`, the best first, each a Voronoi vertex of about so many samples of the boundary,
    of a thin face
    more: good to their spacing. walls: arcs that are kept off too; allowed: points (n,) -> where
        one may be, bool (n,).
    """
    arcs = [arc for loop in loops for arc in loop]
    length = sum(np.abs(np.diff(arc.z)).sum() for arc in arcs)
    spacing = max(min(length / samples, area / length), length / (8 * samples))
    border = np.concatenate([*(arc.dense(spacing) for arc in (*arcs, *walls)), obstacles])
    try:
        diagram = Voronoi(pairs(border))
    except QhullError:  # a face so flat that it has no inside
        return []
    # Any ridge names two samples and the vertices equally far from them.
    vertices = np.array(diagram.ridge_vertices)
    points = np.repeat(diagram.ridge_points[:, :1], 2, axis=1)
    points = points[vertices >= 0]
    vertices = vertices[vertices >= 0]
    z = diagram.vertices @ (1, 1j)
    distance = np.zeros(len(z))
    distance[vertices] = np.abs(z[vertices] - border[points])
    order = np.argsort(-distance)
    found: list = []
    for chunk in _batches(order, 256):  # mostly the first one has them all
        chunk = chunk[crossings(loops, z[chunk])]
        for k in chunk if allowed is None else chunk[allowed(z[chunk])]:
            if all(abs(z[k] - other) > 0.5 * room for other, room in found):
                found.append((complex(z[k]), float(distance[k])))
                if len(found) == count:
                    return found
    return found


def beside(loops: tuple, size: float) -> np.ndarray:
    """Return points (n,) inside the loops, off places on each arc; at least one, however thin they
    are.
    """
    found = [np.empty(0, dtype=complex)]
    for loop in loops:
        for arc in loop:
            length = np.abs(np.diff(arc.z)).sum()
            if (
                length > SHORT * size
            ):  # at a corner where circles touch, rounding is as large as what is between them
                on, tangent = arc.curve(
                    arc.start + np.array([0.2, 0.5, 0.8]) * (arc.end - arc.start)
                )
                found.append(on + 0.05j * length * tangent / np.abs(tangent))
    z = np.concatenate(found)
    within, near = roughly_inside(loops, z)
    if (within & ~near).any():
        z = z[within & ~near]
    else:
        z = z[inside(loops, z)]
    if len(z):
        return z
    return np.array([off_border(loops, size)])


def off_border(loops: tuple, size: float) -> complex:
    """Return a point inside the loops, off one of the longest arcs: of a face however thin."""
    arcs = sorted(
        (arc for loop in loops for arc in loop), key=lambda arc: -np.abs(np.diff(arc.z)).sum()
    )
    for arc in arcs:
        # A curve may turn back in its middle, where the face has no width.
        on, tangent = arc.curve(
            arc.start + np.array([0.2, 0.35, 0.5, 0.65, 0.8]) * (arc.end - arc.start)
        )
        offsets = size * 0.25 ** np.arange(1, 24)
        z = (on + 1j * tangent / np.abs(tangent) * offsets[:, None]).ravel()
        z = z[inside(loops, z)]
        if len(z):
            distance = np.min([each.nearest(z)[1] for each in arcs], axis=0)
            return complex(z[distance.argmax()])
    raise ArithmeticError(f"no point was found inside a face whose border is {len(arcs)} arcs")
