"""What a rectangle along x and y has to keep off, and whether it does: the outline of an aspect and
a margin within it.

A margin is kept if no point of the outline is nearer to the rectangle, whose borders v (4,) are
numbered: 0 x_min, 1 x_max, 2 y_min, 3 y_max.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..base.backend import EPS
from ..singularities.aspects import Aspect
from ..singularities.locus import divided, pairs
from ..singularities.regions import Arc, inside
from ..singularities.roots import rising_zeros
from .boundaries import facing
from .disc import clearance_at, punctures

SAMPLES = 4000  # of the outline
SEEDS = 600  # points of the aspect, about, around each of which the largest rectangle is searched
RIM = 100  # points of each side at which it is asked whether all is kept
INWARDS = np.array([1, -1, 1, -1])
CORNERS = np.array([(0, 2), (0, 3), (1, 2), (1, 3)])


@dataclass(frozen=True, eq=False)
class Outline:
    """What a rectangle has to keep off: the aspect's arcs, cut so that x and y rise or fall all
    along, and points.
    """

    aspect: Aspect
    margin: float

    @property
    def allowed(self) -> Callable | None:
        """Complex points (n,) -> whether all is kept there; None where nothing more than the aspect
        is.
        """
        return getattr(self.aspect, "allowed", None)

    @cached_property
    def arcs(self) -> list[Arc]:
        """The boundary, and the parts of walls across which something is no longer kept: what is
        kept on the left.
        """
        loops = [arc for loop in self.aspect.boundary for arc in loop]
        walls = self.aspect.walls if self.allowed else ()
        return [
            *loops,
            *facing(walls, self.within, np.ptp(loops[0].z.real) + np.ptp(loops[0].z.imag)),
        ]

    def within(self, z: np.ndarray) -> np.ndarray:
        """Whether points (n,) are in the aspect, and all is kept there."""
        found = inside(self.aspect.boundary, z)
        if self.allowed:
            found[found] = self.allowed(z[found])
        return found

    @cached_property
    def pieces(self) -> list[tuple[Arc, tuple[int, int]]]:
        """Arcs, each with the corner that it limits: any other part of a rectangle meets one of its
        ends first.
        """
        found = []
        for arc in self.arcs:
            cuts = [
                arc.start,
                *sorted(
                    [*_turns(arc, np.real), *_turns(arc, np.imag)], key=lambda s: abs(s - arc.start)
                ),
            ]
            for piece in (
                Arc(arc.locus, *each)
                for each in zip(cuts, [*cuts[1:], arc.end])
                if each[0] != each[1]
            ):
                inwards = 1j * complex(piece.tangent((piece.start + piece.end) / 2))
                found.append((piece, (0 if inwards.real > 0 else 1, 2 if inwards.imag > 0 else 3)))
        return found

    @cached_property
    def ends(self) -> np.ndarray:
        return np.unique(
            np.concatenate(
                [*(piece.z[[0, -1]] for piece, _ in self.pieces), punctures(self.aspect)]
            )
        )

    @cached_property
    def spacing(self) -> float:
        return sum(np.abs(np.diff(piece.z)).sum() for piece, _ in self.pieces) / SAMPLES

    @cached_property
    def samples(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Points (n,) of each piece, and where its margin ends."""
        found = []
        for piece, _ in self.pieces:
            counts = np.maximum(np.ceil(np.abs(np.diff(piece.z)) / self.spacing), 1).astype(int)
            z, tangent = piece.curve(divided(piece.s, counts)[1:-1])
            found.append((z, z + self.margin * 1j * tangent / np.abs(tangent)))
        return found

    @cached_property
    def points(self) -> np.ndarray:
        return np.concatenate([self.ends, *(z for z, _ in self.samples)])

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(pairs(self.points))

    @cached_property
    def obstacles(self) -> np.ndarray:
        """Points (n,) of the border of all that keeps the margin, by y."""
        circle = np.exp(
            2j * np.pi * np.linspace(0, 1, 1 + int(min(7 * self.margin / self.spacing, 360)))
        )
        z = np.concatenate(
            [(self.ends[:, None] + self.margin * circle).ravel(), *(z for _, z in self.samples)]
        )
        z = z[self.tree.query(pairs(z))[0] >= self.margin - self.spacing]
        return z[np.argsort(z.imag)]

    @cached_property
    def seeds(self) -> np.ndarray:
        """Points (n,) all over what keeps the margin, so close that the largest rectangle has some
        of them inside.
        """
        low, high = (f(np.concatenate(self.aspect.polygons), axis=0) for f in (np.min, np.max))
        least = 0.0 if self.allowed else 0.6 * (self.aspect.clearance - self.margin)
        step = max(least, np.sqrt(self.aspect.area / SEEDS))
        lattice = np.stack(
            np.meshgrid(*(np.arange(a + step / 2, b, step) for a, b in zip(low, high))), axis=-1
        )
        points = np.concatenate([lattice[self.aspect.contains(lattice)], [self.aspect.point]])
        z = points[self.tree.query(points)[0] > self.margin + 2 * self.spacing] @ (1, 1j)
        return z[self.within(z)] if self.allowed else z

    def keeps(self, v: np.ndarray) -> bool:
        """Whether a rectangle keeps the margin, exactly: the ends and samples from all of it, the
        arcs from corners.
        """
        least = self.margin + (
            4 * EPS * np.abs(self.points).max() if self.margin else 0.0
        )  # however it is measured
        if apart(self.points, v).min() < least:
            return False
        corners = v[CORNERS] @ (1, 1j)
        if not self.within(corners).all():
            return False
        if self.allowed:  # where bars touch, walls end short of the limit of reach
            rim = np.concatenate(
                [
                    np.linspace(a, b, RIM)
                    for a, b in zip(corners[[0, 1, 3, 2]], corners[[1, 3, 2, 0]])
                ]
            )
            if not self.allowed(rim).all():
                return False
        return least == 0 or min(clearance_at(self.aspect, corner) for corner in corners) >= least

    def shrunk(self, v: np.ndarray, least: float) -> np.ndarray | None:
        """The rectangle, its borders moved in by `least`, m, or as much more as it takes to keep
        the margin.
        """
        while least < min(v[1] - v[0], v[3] - v[2]) / 2:
            if self.keeps(v + least * INWARDS):
                return v + least * INWARDS
            least *= 2
        return None

    def broken(self, v: np.ndarray, slack: float) -> set:
        """What is nearer to a rectangle than the margin, by more than slack: pieces from 0, and
        ends from -1 down.
        """
        found = {
            k
            for k, (z, _) in enumerate(self.samples)
            if apart(z, v).min(initial=np.inf) < self.margin - slack
        }
        found |= {
            -1 - k for k in np.flatnonzero(apart(self.ends, v) < self.margin - slack).tolist()
        }
        corners = v[CORNERS] @ (1, 1j)
        for own, corner, within in zip(
            CORNERS.tolist(), corners, inside(self.aspect.boundary, corners)
        ):
            facing = [
                (k, arc) for k, (arc, limited) in enumerate(self.pieces) if list(limited) == own
            ]
            least = [np.abs(arc.z - corner).min() for _, arc in facing]
            near = [
                each for each, own in zip(facing, least) if own - 0.51 * each[1].step <= min(least)
            ]
            away = [(arc.nearest(corner[None])[1][0], k) for k, arc in near]
            if away and min(away)[0] * (1 if within else -1) < self.margin - slack:
                found.add(min(away)[1])
        return found


def _turns(arc, part):
    """Parameters at which an arc's tangent is upright (part np.real) or level (np.imag)."""
    slope = part(arc.tangent(arc.s))
    k = np.flatnonzero(slope[:-1] * slope[1:] < 0)
    sign = -np.sign(slope[k])
    s = rising_zeros(
        lambda i, t: sign[i] * part(arc.tangent(t)), arc.s[k], arc.s[k + 1], np.zeros(len(k))
    )
    return [*s, *arc.s[1:-1][slope[1:-1] == 0]]


def apart(z: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Distance of points (n,) from a rectangle; inside, less than 0, from its nearest side."""
    x, y = np.maximum(v[0] - z.real, z.real - v[1]), np.maximum(v[2] - z.imag, z.imag - v[3])
    return np.where((x > 0) & (y > 0), np.hypot(x, y), np.maximum(x, y))
