"""How much room a path has in an aspect: its distance from the exact boundary, and from the walls of what is kept."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..singularities.aspects import Aspect
from ..singularities.disc import arcs_of, punctures
from ..singularities.regions import crossings, inside
from .curve import Path

SAMPLES = 160  # of the path, in the search
BORDER = 6000  # samples of what bounds an aspect
GRID = 96  # nodes a side, at which the distance from it is known before the search
TIGHT = 1e-9  # of the path's length: to so much the room is known


class Room:
    """Signed distance from the boundary of an aspect and from the walls in it: rough from samples, and exact."""

    def __init__(self, part: Aspect) -> None:
        self.part, self.arcs, self.points = part, arcs_of(part), punctures(part)
        length = sum(np.abs(np.diff(arc.z)).sum() for arc in self.arcs)
        border = np.concatenate([*(arc.dense(length / BORDER) for arc in self.arcs), self.points])
        self.border, self.spacing = border, length / BORDER
        self.tree = cKDTree(np.stack([border.real, border.imag], axis=-1))
        outline = np.concatenate([arc.z for arc in part.boundary[0]])
        self.low, self.high = outline.real.min() + 1j * outline.imag.min(), outline.real.max() + 1j * outline.imag.max()
        grid = np.linspace(self.low.real, self.high.real, GRID), np.linspace(self.low.imag, self.high.imag, GRID)
        self.grid = grid
        z = grid[0][:, None] + 1j * grid[1]
        self.field = self.rough(z.ravel())[0].reshape(z.shape)
        self.most = float(self.field.max())

    def within(self, z: np.ndarray, exactly: bool = True) -> np.ndarray:
        found = (inside if exactly else crossings)(self.part.boundary, z)
        allowed = getattr(self.part, "allowed", None)
        if allowed is not None and found.any():
            found[found] = allowed(z[found])
        return found

    def rough(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of points (n,) from samples of the border, and its gradient."""
        distance, k = self.tree.query(np.stack([z.real, z.imag], axis=-1))
        sign = np.where(self.within(z, exactly=False), 1.0, -1.0)
        return sign * distance, sign * (z - self.border[k]) / np.maximum(distance, 1e-300)

    def on_grid(self, z: np.ndarray) -> np.ndarray:
        """The field at points, bilinear; outside of the grid less than anything inside."""
        x, y = ((part - g[0]) / (g[1] - g[0]) for part, g in zip((z.real, z.imag), self.grid))
        i, j = (np.clip(np.floor(each).astype(int), 0, GRID - 2) for each in (x, y))
        u, v = x - i, y - j
        f = self.field
        value = (f[i, j] * (1 - u) + f[i + 1, j] * u) * (1 - v) + (f[i, j + 1] * (1 - u) + f[i + 1, j + 1] * u) * v
        beyond = np.maximum(np.maximum(-x, x - GRID + 1), np.maximum(-y, y - GRID + 1))
        return np.where(beyond > 0, -np.abs(f).max() - beyond * (self.grid[0][1] - self.grid[0][0]), value)

    def exact(self, z: np.ndarray) -> np.ndarray:
        """Distance of points (n,) from all that bounds."""
        found = np.full(len(z), np.inf)
        for arc in self.arcs:
            found = np.minimum(found, arc.nearest(z)[1])
        for point in self.points:
            found = np.minimum(found, np.abs(z - point))
        return found

    def along(self, path: Path) -> tuple[float, complex]:
        """The room of a placed path, exactly, and the point where it is least; at most 0 where it leaves."""
        s = np.unique(np.concatenate([path.knots, np.linspace(0, path.length, SAMPLES)]))
        z = path(s)[0] @ (1, 1j)
        if not self.within(z).all():
            return -float(self.tree.query(np.stack([z.real, z.imag], axis=-1))[0][~self.within(z)].max()), z[0]
        room = self.exact(z)
        # The distance changes no faster than s does: between two samples it is at least this.
        for _ in range(60):
            best = room.min()
            floor = (room[:-1] + room[1:] - np.diff(s)) / 2
            open_ = np.flatnonzero(floor < best - TIGHT * path.length)
            if not len(open_):
                break
            more = (s[open_] + s[open_ + 1]) / 2
            own = self.exact(path(more)[0] @ (1, 1j))
            s, room = np.concatenate([s, more]), np.concatenate([room, own])
            order = np.argsort(s)
            s, room = s[order], room[order]
        k = int(room.argmin())
        return float(room[k]), complex(*path(s[k])[0])
