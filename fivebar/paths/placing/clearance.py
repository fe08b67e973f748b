"""How much room a path has in an aspect: its distance from the exact boundary, and from the walls
of what is kept.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...constraints.disc import arcs_of, punctures
from ...singularities.aspects import Aspect
from ...singularities.regions import crossings, inside
from ..curve import Path
from ..pieces import Arc, Piece, Polynomial

SAMPLES = 160  # of the path, on which the search of its room begins
BORDER = 6000  # samples of what bounds an aspect
GRID = 64  # nodes a side, at which the distance from it is known before the search
TIGHT = 1e-9  # of the path's length: to so much the room is known


class Clearance:
    """Signed distance from the boundary of an aspect and from the walls in it: rough from chords,
    and exact.
    """

    def __init__(self, part: Aspect) -> None:
        self.part = part
        self.arcs = arcs_of(part)
        self.points = punctures(part)
        self.spacing = sum(np.abs(np.diff(arc.z)).sum() for arc in self.arcs) / BORDER
        loops = [self._dense(loop) for loop in part.boundary]
        boundaries = [
            np.append(wall.dense(self.spacing), wall.z[-1]) for wall in getattr(part, "walls", ())
        ]
        self.border = np.concatenate([*loops, *boundaries, self.points])
        self.before = self._neighbours(loops, boundaries, -1)
        self.after = self._neighbours(loops, boundaries, 1)
        self.trees = [_tree(np.append(arc.dense(self.spacing), arc.z[-1])) for arc in self.arcs]
        self.tree = _tree(self.border)
        self.low, self.high = (f(loops[0].real) + 1j * f(loops[0].imag) for f in (np.min, np.max))
        x = np.linspace(self.low.real, self.high.real, GRID)
        y = np.linspace(self.low.imag, self.high.imag, GRID)
        z = x[:, None] + 1j * y
        self.steps = x[1] - x[0], y[1] - y[0]
        away = self.tree.query(np.stack([z.real, z.imag], axis=-1))[0]
        self.field = np.where(
            self.within(z.ravel(), exactly=False).reshape(z.shape),
            away,
            -away,
        )
        self.most = float(self.field.max())

    def _dense(self, loop):
        return np.concatenate([arc.dense(self.spacing) for arc in loop])

    def _neighbours(self, loops, boundaries, way):
        """Points one further along the border, way = 1, or one back, way = -1."""
        neighbours = [np.roll(z, -way) for z in loops]
        for z in boundaries:
            at = np.clip(
                np.arange(len(z)) + way,
                0,
                len(z) - 1,
            )
            neighbours.append(z[at])
        return np.concatenate([*neighbours, self.points])

    def within(self, z: np.ndarray, exactly: bool = True) -> np.ndarray:
        found = (inside if exactly else crossings)(self.part.boundary, z)
        allowed = getattr(self.part, "allowed", None)
        if allowed is not None and found.any():
            found[found] = allowed(z[found])
        return found

    def rough(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of points (n,) from chords between samples of the border, and its
        gradient.
        """
        _, k = self.tree.query(np.stack([z.real, z.imag], axis=-1))
        on = self.border[k]
        for ends in (self.before[k], self.after[k]):
            chord = ends - self.border[k]
            square = np.abs(chord) ** 2
            part = ((z - self.border[k]) * chord.conj()).real / np.where(square, square, 1.0)
            foot = self.border[k] + np.clip(part, 0, 1) * chord
            on = np.where(
                np.abs(z - foot) < np.abs(z - on),
                foot,
                on,
            )
        distance = np.abs(z - on)
        # No border is between a point and a node of the grid that is nearer than it.
        (u, v), (i, j) = self._cells(z)
        i = np.clip(np.rint(u), 0, GRID - 1).astype(int)
        j = np.clip(np.rint(v), 0, GRID - 1).astype(int)
        node = np.hypot(
            (u - i) * self.steps[0],
            (v - j) * self.steps[1],
        )
        sign = np.where(
            self.field[i, j] > 0,
            1.0,
            -1.0,
        )
        near = node >= 0.99 * distance
        if near.any():
            sign[near] = np.where(
                self.within(z[near], exactly=False),
                1.0,
                -1.0,
            )
        return sign * distance, sign * (z - on) / np.maximum(distance, 1e-300)

    def _cells(self, z):
        """Where points are on the grid, in steps, and the cells that hold them."""
        at = (z.real - self.low.real) / self.steps[0], (z.imag - self.low.imag) / self.steps[1]
        return at, tuple(np.clip(np.floor(each).astype(int), 0, GRID - 2) for each in at)

    def on_grid(self, z: np.ndarray) -> np.ndarray:
        """The field at points, bilinear; outside of the grid less than anything inside."""
        (x, y), (i, j) = self._cells(z)
        u = x - i
        v = y - j
        f = self.field.ravel()
        k = i * GRID + j
        value = (f[k] * (1 - u) + f[k + GRID] * u) * (1 - v) + (
            f[k + 1] * (1 - u) + f[k + GRID + 1] * u
        ) * v
        beyond = np.maximum(
            np.maximum(-x, x - GRID + 1),
            np.maximum(-y, y - GRID + 1),
        )
        return np.where(
            beyond > 0,
            -np.abs(f).max() - beyond * self.steps[0],
            value,
        )

    def exact(self, z: np.ndarray) -> np.ndarray:
        """Distance of points (n,) from all that bounds."""
        found = np.full(len(z), np.inf)
        xy = np.stack([z.real, z.imag], axis=-1)
        rough = [tree.query(xy)[0] for tree in self.trees]
        near = np.min(rough, axis=0) + 0.51 * self.spacing
        for arc, own in zip(self.arcs, rough):
            at = own <= near
            found[at] = np.minimum(found[at], arc.nearest(z[at])[1])
        for point in self.points:
            found = np.minimum(found, np.abs(z - point))
        return found

    def along(
        self,
        path: Path,
        least: float = -np.inf,
        most: float = np.inf,
    ) -> tuple[float, complex | None]:
        """The room of a placed path, exactly, and the point where it is least; at most 0 where it
        leaves.

        least: where the room is found to be no more than that, some such distance is enough. most:
        where it is no less, that is enough, with None for the point.
        Of the border's points that are nearest anywhere between a and b, each is at distance f(s)
        with (f^2)'' <= 2 c, c = max |xi_s|^2 + max f |xi_ss|; so the square of the room there is at
        least that of the straight line between its values at a and b, less c (b - a)^2 / 4.
        """
        s = np.unique(np.concatenate([path.knots, np.linspace(0, path.length, SAMPLES)]))
        z = path(s)[0] @ (1, 1j)
        within = self.within(z)
        if not within.all():
            return (
                -float(self.tree.query(np.stack([z.real, z.imag], axis=-1))[0][~within].max()),
                z[0],
            )
        steep = np.array([_steepest(piece) for piece in path.pieces])
        # Samples of the border are nowhere farther apart than `spacing`.
        clearance = self.tree.query(np.stack([z.real, z.imag], axis=-1))[0] - 0.51 * self.spacing
        sure = np.zeros(len(s), dtype=bool)
        best = most
        at = None
        for _ in range(60):
            ask = np.flatnonzero(~sure & (clearance < best))
            if best == np.inf:
                ask = ask[np.argsort(clearance[ask])[:8]]
            clearance[ask], sure[ask] = self.exact(z[ask]), True
            k = int(np.where(sure, clearance, np.inf).argmin())
            if sure[k] and clearance[k] < best:
                best = float(clearance[k])
                at = complex(z[k])
            if best <= least:
                break
            k = np.clip(
                np.searchsorted(
                    path.knots,
                    (s[:-1] + s[1:]) / 2,
                    side="right",
                )
                - 1,
                0,
                len(steep) - 1,
            )
            h = np.diff(s)
            a = np.maximum(clearance[:-1], 0)
            b = np.maximum(clearance[1:], 0)
            c = (
                steep[k, 0] ** 2
                + (np.maximum(a, b) + self.spacing + 2 * h * steep[k, 0]) * steep[k, 1]
            )
            floor = np.minimum(a, b) ** 2 - c * h**2 / 4
            open_ = np.flatnonzero(np.sqrt(np.maximum(floor, 0)) < best - TIGHT * path.length)
            if not len(open_) and not (~sure & (clearance < best)).any():
                break
            more = (s[open_] + s[open_ + 1]) / 2
            new = path(more)[0] @ (1, 1j)
            rough = (
                self.tree.query(np.stack([new.real, new.imag], axis=-1))[0] - 0.51 * self.spacing
            )
            s = np.concatenate([s, more])
            z = np.concatenate([z, new])
            clearance = np.concatenate([clearance, rough])
            order = np.argsort(s)
            s = s[order]
            z = z[order]
            clearance = clearance[order]
            sure = np.append(sure, np.zeros(len(more), dtype=bool))[order]
        return best, at


def _tree(z):
    return cKDTree(np.stack([z.real, z.imag], axis=-1))


def _steepest(piece: Piece) -> tuple[float, float]:
    """Bounds of |xi_s| and |xi_ss| along a piece."""
    if isinstance(piece, Arc):
        return 1.0, 1 / piece.radius
    if not isinstance(piece, Polynomial):
        return 1.0, 0.0
    n = len(piece.coefficients) - 1
    control = piece.bernstein
    first, second = (
        np.linalg.norm(np.diff(control, order, axis=0), axis=1).max(initial=0.0) for order in (1, 2)
    )
    return n * first / piece.length, n * (n - 1) * second / piece.length**2
