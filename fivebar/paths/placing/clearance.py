"""How much room a path has in an aspect: its distance from the exact boundary, and from the walls
of what is kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ...base.backend import pairs
from ...constraints.disc import arcs_of, punctures
from ...singularities.aspects import Aspect
from ...singularities.regions import crossings, inside
from ..curve import Path
from ..pieces import Arc, Piece, Polynomial

SAMPLES = 160  # of the path, on which the search of its room begins
BORDER = 10_000  # samples of what bounds an aspect
GRID = 64  # nodes a side, at which the distance from it is known before the search
TIGHT = 1e-9  # of the path's length: to so much the room is known


class Clearance:
    """Signed distance from the boundary of an aspect and from the walls in it: rough from samples,
    and exact.
    """

    def __init__(self, part: Aspect) -> None:
        self.part = part
        self.arcs = arcs_of(part)
        self.points = punctures(part)
        lengths = [np.abs(np.diff(arc.z)).sum() for arc in self.arcs]
        self.spacing = sum(lengths) / BORDER
        samples = [np.append(arc.dense(self.spacing), arc.z[-1]) for arc in self.arcs]
        self.trees = [_tree(z) for z in samples]
        self.border = np.concatenate([*samples, self.points])
        self.tree = _tree(self.border)
        # One point of each border beside the outer one: a page must not lie around it.
        firsts = [arcs[0].z[0] for arcs in part.boundary[1:]]
        firsts += [wall.z[0] for wall in getattr(part, "walls", ())]
        self.holes = np.concatenate([self.points, firsts])
        self._lay_grid()

    def _lay_grid(self):
        """Set the grid over the border, and what is known at its nodes."""
        sides = self.border.real, self.border.imag
        low, high = ([side(z) for z in sides] for side in (np.min, np.max))
        self.low = complex(*low) - (1 + 1j) * self.spacing
        self.high = complex(*high) + (1 + 1j) * self.spacing
        size = self.high - self.low
        self.steps = size.real / (GRID - 1), size.imag / (GRID - 1)
        i, j = np.divmod(np.arange(GRID * GRID), GRID)
        self.nodes = self.low + self.steps[0] * i + 1j * self.steps[1] * j
        distance, _ = self.tree.query(pairs(self.nodes))
        self.is_inner = self.within(self.nodes, exactly=False)
        self.at_nodes = np.where(self.is_inner, distance, -distance)
        self.most = float(distance[self.is_inner].max(initial=0.0) + np.hypot(*self.steps) / 2)

    def within(self, z: np.ndarray, exactly: bool = True) -> np.ndarray:
        test = inside if exactly else crossings
        result = test(self.part.boundary, z)
        allowed = getattr(self.part, "allowed", None)
        if allowed is not None and result.any():
            result[result] = allowed(z[result])
        return result

    def rough(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signed distances of points (n,) from the border's samples, and their gradients."""
        distance, k = self.tree.query(pairs(z))
        sign = np.where(self._are_within(z, distance), 1.0, -1.0)
        gradient = sign * (z - self.border[k]) / np.maximum(distance, 1e-300)
        return sign * distance, gradient

    def _are_within(self, z, distance):
        """Return whether points (n,) at distances (n,) from the border are within.

        No border is between a point and a node of the grid that is nearer than it.
        """
        node = self._nearest_node(z)
        within = self.is_inner[node]
        way = np.abs(z - self.nodes[node])
        unknown = way >= 0.99 * distance
        if unknown.any():
            within[unknown] = self.within(z[unknown], exactly=False)
        return within

    def _nearest_node(self, z):
        """Return the numbers of the nodes nearest to points."""
        away = z - self.low
        x_step, y_step = self.steps
        return _node_number(away.real / x_step) * GRID + _node_number(away.imag / y_step)

    def coarse(self, z: np.ndarray) -> np.ndarray:
        """Return the signed distances of the nodes nearest to points."""
        return self.at_nodes[self._nearest_node(z)]

    def exact(self, z: np.ndarray) -> np.ndarray:
        """Return the distances of points (n,) from all that bounds."""
        result = np.full(len(z), np.inf)
        rough = [tree.query(pairs(z))[0] for tree in self.trees]
        near = np.min(rough, axis=0) + 0.51 * self.spacing
        for arc, distance in zip(self.arcs, rough):
            at = distance <= near
            exact = arc.nearest(z[at])[1]
            result[at] = np.minimum(result[at], exact)
        for point in self.points:
            distance = np.abs(z - point)
            result = np.minimum(result, distance)
        return result

    def _least(self, z):
        """Return distances of points (n,) that the exact ones are not below."""
        # Samples of the border are nowhere farther apart than `spacing`.
        distance, _ = self.tree.query(pairs(z))
        return distance - 0.51 * self.spacing

    def along(self, path: Path, most: float = np.inf) -> tuple[float, Any]:
        """Return the clearance of a placed path, and the point where it is least.

        It is at most 0 where the path leaves. most: where the clearance is no less, that is
        returned, and None.

        The distance f(s) from a point of the border has (f^2)'' <= 2 c with c = max |xi_s|^2 + max
        f |xi_ss|. So between a and b the square of the clearance is at least the least of its
        values there, less c (b - a)^2 / 4.
        """
        even = np.linspace(0, path.length, SAMPLES)
        s = np.unique(np.concatenate([path.knots, even]))
        z = path(s)[0] @ (1, 1j)
        within = self.within(z)
        if not within.all():
            outside, _ = self.tree.query(pairs(z[~within]))
            return -float(outside.max()), z[0]
        bounds = np.array([_steepest(piece) for piece in path.pieces])
        clearance = self._least(z)
        sure = np.zeros(len(s), dtype=bool)
        best = most
        at = None
        for _ in range(60):
            ask = np.flatnonzero(~sure & (clearance < best))
            if best == np.inf:
                order = np.argsort(clearance[ask])
                ask = ask[order[:8]]
            clearance[ask] = self.exact(z[ask])
            sure[ask] = True
            known = np.where(sure, clearance, np.inf)
            k = int(known.argmin())
            if known[k] < best:
                best = float(known[k])
                at = complex(z[k])
            middle = (s[:-1] + s[1:]) / 2
            piece = np.searchsorted(path.knots, middle, side="right")
            piece = np.clip(piece - 1, 0, len(bounds) - 1)
            speed, bend = bounds[piece].T
            h = np.diff(s)
            a = np.maximum(clearance[:-1], 0)
            b = np.maximum(clearance[1:], 0)
            farthest = np.maximum(a, b) + self.spacing + 2 * h * speed
            c = speed**2 + farthest * bend
            nearest = np.minimum(a, b)
            square = nearest**2 - c * h**2 / 4
            floor = np.sqrt(np.maximum(square, 0))
            open_ = floor < best - TIGHT * path.length
            unsure = ~sure & (clearance < best)
            if not open_.any() and not unsure.any():
                break
            more = middle[open_]
            new = path(more)[0] @ (1, 1j)
            s = np.concatenate([s, more])
            z = np.concatenate([z, new])
            clearance = np.concatenate([clearance, self._least(new)])
            sure = np.concatenate([sure, np.zeros(len(more), dtype=bool)])
            order = np.argsort(s)
            s = s[order]
            z = z[order]
            clearance = clearance[order]
            sure = sure[order]
        return best, at


def _node_number(steps):
    """Return the number of the nearest node on a side of the grid."""
    number = np.clip(np.rint(steps), 0, GRID - 1)
    return number.astype(int)


def _tree(z):
    return cKDTree(pairs(z))


def _steepest(piece: Piece) -> tuple[float, float]:
    """Return bounds of |xi_s| and |xi_ss| along a piece."""
    if isinstance(piece, Arc):
        return 1.0, 1 / piece.radius
    if not isinstance(piece, Polynomial):
        return 1.0, 0.0
    n = len(piece.coefficients) - 1
    first = np.diff(piece.bernstein, axis=0)
    second = np.diff(first, axis=0)
    speed = n * _largest(first) / piece.length
    bend = n * (n - 1) * _largest(second) / piece.length**2
    return speed, bend


def _largest(vectors):
    """Return the largest norm of vectors (n, 2); 0 where there is none."""
    norms = np.linalg.norm(vectors, axis=1)
    return norms.max(initial=0.0)
