"""Test whether a rectangle along x and y lies in an aspect and keeps a clearance.

The clearance is kept if no point of the aspect's outline is nearer to the rectangle. The borders
v (4,) of a rectangle are x_min, x_max, y_min, y_max.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..base.backend import EPS, pairs
from ..singularities.locus import divided
from ..singularities.regions import LocusArc, inside
from ..singularities.roots import rising_zeros
from .boundaries import facing
from .disc import clearance_at, punctures

SAMPLES = 4000  # of the outline
SEEDS = 600  # points of the aspect, about, around which the largest rectangle is searched
RIM = 100  # points of each side at which constraints are evaluated
INWARDS = np.array([1, -1, 1, -1])
CORNERS = np.array([(0, 2), (0, 3), (1, 2), (1, 3)])


@dataclass(frozen=True, eq=False)
class Outline:
    """The obstacles of a rectangle: points, and arcs along which x and y rise or fall."""

    aspect: Any  # Aspect, or BoundedAspect
    margin: float

    @property
    def allowed(self) -> Callable | None:
        """Return the function of complex points (n,) that tells where constraints hold, if any."""
        return getattr(self.aspect, "allowed", None)

    @cached_property
    def arcs(self) -> list[LocusArc]:
        """Return the arcs of the boundary and of constraints, with allowed points on their left."""
        loops = [arc for loop in self.aspect.boundary for arc in loop]
        if not self.allowed:
            return loops
        outer = loops[0].z
        size = np.ptp(outer.real) + np.ptp(outer.imag)
        walls = facing(self.aspect.walls, self.within, size)
        return loops + walls

    def within(self, z: np.ndarray) -> np.ndarray:
        """Return whether points (n,) are in the aspect and keep all constraints."""
        result = inside(self.aspect.boundary, z)
        if self.allowed:
            result[result] = self.allowed(z[result])
        return result

    @cached_property
    def pieces(self) -> list[tuple[LocusArc, tuple[int, int]]]:
        """Return arcs, each with the corner that it limits.

        Any other part of a rectangle meets one of the arc's ends first.
        """
        pieces = []
        for arc in self.arcs:
            turns = _turns(arc, np.real)
            turns += _turns(arc, np.imag)
            turns.sort()
            if arc.end < arc.start:
                turns.reverse()
            cuts = [arc.start, *turns, arc.end]
            for start, end in zip(cuts, cuts[1:]):
                if start != end:
                    piece = LocusArc(arc.locus, start, end)
                    middle = (start + end) / 2
                    inwards = 1j * complex(piece.tangent(middle))
                    side = 0 if inwards.real > 0 else 1
                    level = 2 if inwards.imag > 0 else 3
                    pieces.append((piece, (side, level)))
        return pieces

    @cached_property
    def ends(self) -> np.ndarray:
        ends = [piece.z[[0, -1]] for piece, _ in self.pieces]
        ends.append(punctures(self.aspect))
        return np.unique(np.concatenate(ends))

    @cached_property
    def spacing(self) -> float:
        length = 0.0
        for piece, _ in self.pieces:
            length += np.abs(np.diff(piece.z)).sum()
        return length / SAMPLES

    @cached_property
    def samples(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return points (n,) of each piece, and where their clearance ends."""
        samples = []
        for piece, _ in self.pieces:
            chords = np.abs(np.diff(piece.z))
            counts = np.ceil(chords / self.spacing)
            counts = np.maximum(counts, 1).astype(int)
            s = divided(piece.s, counts)
            z, tangent = piece.curve(s[1:-1])
            normal = 1j * tangent / np.abs(tangent)
            samples.append((z, z + self.margin * normal))
        return samples

    @cached_property
    def points(self) -> np.ndarray:
        return np.concatenate([self.ends, *(z for z, _ in self.samples)])

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(pairs(self.points))

    @cached_property
    def obstacles(self) -> np.ndarray:
        """Return points (n,) of the border of all that keeps the clearance, by y."""
        count = 1 + int(min(7 * self.margin / self.spacing, 360))
        angles = 2 * np.pi * np.linspace(0, 1, count)
        circle = self.margin * np.exp(1j * angles)
        around_ends = self.ends[:, None] + circle
        beside = [z for _, z in self.samples]
        z = np.concatenate([around_ends.ravel(), *beside])
        distance, _ = self.tree.query(pairs(z))
        z = z[distance >= self.margin - self.spacing]
        return z[np.argsort(z.imag)]

    @cached_property
    def seeds(self) -> np.ndarray:
        """Return points (n,) that keep the clearance.

        They are so close that the largest rectangle has some of them inside.
        """
        corners = np.concatenate(self.aspect.polygons)
        step = np.sqrt(self.aspect.area / SEEDS)
        if not self.allowed:
            clearance = clearance_at(self.aspect, complex(*self.aspect.point))
            step = max(step, 0.6 * (clearance - self.margin))
        x_min, y_min = corners.min(axis=0) + step / 2
        x_max, y_max = corners.max(axis=0)
        x = np.arange(x_min, x_max, step)
        y = np.arange(y_min, y_max, step)
        lattice = np.stack(np.meshgrid(x, y), axis=-1)
        inner = lattice[self.aspect.contains(lattice)]
        points = np.concatenate([inner, [self.aspect.point]])
        distance, _ = self.tree.query(points)
        far = distance > self.margin + 2 * self.spacing
        z = points[far] @ (1, 1j)
        if self.allowed:
            return z[self.within(z)]
        return z

    def keeps(self, v: np.ndarray) -> bool:
        """Return whether a rectangle keeps the clearance.

        Ends and samples are compared with all of it, the exact arcs with its corners.
        """
        # Rounding error may add to the distance, however it is computed.
        least = self.margin
        if self.margin:
            farthest = np.abs(self.points).max()
            least = self.margin + 4 * EPS * farthest
        distance = rectangle_distance(self.points, v)
        if distance.min() < least:
            return False
        corners = v[CORNERS] @ (1, 1j)
        if not self.within(corners).all():
            return False
        if self.allowed:
            # Where links touch, traced arcs end short of the limit of reach: the rim is sampled.
            starts = corners[[0, 1, 3, 2]]
            ends = np.roll(starts, -1)
            rim = np.linspace(starts, ends, RIM)
            if not self.allowed(rim.ravel()).all():
                return False
        if least == 0:
            return True
        return not any(clearance_at(self.aspect, corner) < least for corner in corners)

    def shrunk(
        self, v: np.ndarray, least: float, inwards: np.ndarray = INWARDS
    ) -> np.ndarray | None:
        """Return the rectangle, its borders moved inwards until it keeps the clearance.

        They move by `least`, m, or that times a power of 2; None where that leaves nothing.
        inwards (4,): how the borders move, by 1 at most.
        """
        x_min, x_max, y_min, y_max = v
        half = min(x_max - x_min, y_max - y_min) / 2
        while least < half:
            smaller = v + least * inwards
            if self.keeps(smaller):
                return smaller
            least *= 2
        return None

    def broken(self, v: np.ndarray, slack: float) -> set:
        """Return what is nearer than the clearance, by more than slack: pieces k, ends -1 - k."""
        limit = self.margin - slack
        of_ends = rectangle_distance(self.ends, v)
        near = np.flatnonzero(of_ends < limit)
        result = set((-1 - near).tolist())
        for k, (z, _) in enumerate(self.samples):
            distance = rectangle_distance(z, v)
            if distance.min(initial=np.inf) < limit:
                result.add(k)
        corners = v[CORNERS] @ (1, 1j)
        are_inside = inside(self.aspect.boundary, corners)
        for sides, corner, is_inside in zip(CORNERS.tolist(), corners, are_inside):
            distance, k = self._nearest_piece(corner, tuple(sides))
            signed = distance if is_inside else -distance
            if k is not None and signed < limit:
                result.add(k)
        return result

    def _nearest_piece(self, corner, sides):
        """Return the distance and number of the nearest piece that limits a corner."""
        sampled = []
        for k, (arc, limited) in enumerate(self.pieces):
            if limited == sides:
                least = np.abs(arc.z - corner).min()
                sampled.append((least, k, arc))
        nearest = min((least for least, _, _ in sampled), default=np.inf)
        distances = []
        for least, k, arc in sampled:
            if least - 0.51 * arc.step <= nearest:
                _, distance = arc.nearest(corner[None])
                distances.append((distance[0], k))
        return min(distances, default=(np.inf, None))


def _turns(arc, part):
    """Return parameters at which an arc's tangent is upright (part np.real) or level (np.imag)."""
    slope = part(arc.tangent(arc.s))
    changes = slope[:-1] * slope[1:] < 0
    k = np.flatnonzero(changes)
    sign = -np.sign(slope[k])

    def rising(i, t):
        return sign[i] * part(arc.tangent(t))

    s = rising_zeros(rising, arc.s[k], arc.s[k + 1], np.zeros(len(k)))
    at_samples = slope[1:-1] == 0
    return [*s, *arc.s[1:-1][at_samples]]


def rectangle_distance(z: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the distance of points (n,) from a rectangle, negative inside."""
    x_min, x_max, y_min, y_max = v
    left = x_min - z.real
    right = z.real - x_max
    below = y_min - z.imag
    above = z.imag - y_max
    x = np.maximum(left, right)
    y = np.maximum(below, above)
    # In a corner's quadrant the corner is the nearest point.
    beyond_corner = (x > 0) & (y > 0)
    return np.where(beyond_corner, np.hypot(x, y), np.maximum(x, y))
