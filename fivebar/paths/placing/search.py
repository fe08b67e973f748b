"""Placements of paths in aspects: first ones on a grid, their clearances, how they are improved."""

from __future__ import annotations

import math
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import maximum_filter
from scipy.optimize import linprog

from ...base.progress import progress
from ..curve import Path
from ..placement import Placement
from .clearance import SAMPLES, TIGHT, Clearance

SIDE = 24  # places on a side of the grid on which the search begins, in each region
TURNS = 16  # in a full turn, there
THIN = 6  # of so many samples of the paths one is looked at, there
STARTS = 12  # of its placements that are improved
ROUNDS = 60  # of an improvement, at most
SEEN = 400  # points of the border that an improvement remembers
SMALL = 1e-3  # of what surely is too large: the scale from which paths grow
FINE = 1e-8  # of a scale: where it grows by less it is the largest
GROWN = 1 + 1e-4  # times as large, at least, is worth to look again
INNER = 12  # points on a side of a page that are looked at beside those of its outline
CORNERS = 240  # of a path, at most, that are looked at beside its samples


class Found(NamedTuple):
    """A placement of paths about their middle: its room, m, the room in which each path is, shift,
    turn and scale.
    """

    clearance: float
    which: tuple[int, ...]
    shift: complex
    turn: float
    scale: float

    def placement(self, middle: complex) -> Placement:
        shift = self.shift - self.scale * np.exp(1j * self.turn) * middle
        return Placement(
            (shift.real, shift.imag), math.remainder(self.turn, 2 * math.pi), self.scale
        )


class Search:
    """Placements of paths, all by one shift, turn and scale, each in one of the rooms.

    turn: rad, None: free; margin: m, that all keep; page: the path is the outline of a page of this
    width and height, m, which keeps the margin all over.
    """

    def __init__(
        self,
        paths: list[Path],
        clearances: list[Clearance],
        turn: float | None,
        margin: float,
        page: tuple[float, float] | None = None,
    ) -> None:
        self.paths = paths
        self.page = page
        self.clearances = clearances
        self.turn = turn
        self.margin = margin
        samples = [_samples(path, max(SAMPLES // len(paths), 12)) for path in paths]
        if page:
            samples = [np.append(samples[0], _lattice(page, INNER))]
        z = np.concatenate(samples)
        self.owner = np.repeat(np.arange(len(paths)), [len(each) for each in samples])
        self.middle = complex((z.real.min() + z.real.max()) / 2, (z.imag.min() + z.imag.max()) / 2)
        self.z = z - self.middle
        self.size = float(np.abs(self.z).max())
        self.first = np.searchsorted(self.owner[::THIN], range(len(paths)))

    def starts(self, scale: float, mixed: bool) -> list[Found]:
        """Return placements of large clearance, the best first, by the nodes of the rooms' grids.

        mixed: each path may lie in a room of its own.
        """
        turns = np.array([self.turn])
        if self.turn is None:
            turns = np.arange(TURNS) * 2 * math.pi / TURNS
        share = (np.arange(SIDE) + 0.5) / SIDE
        rotation = scale * np.exp(1j * turns)
        arm = rotation[:, None] * self.z[::THIN]
        found = []
        for k, room in enumerate(self.clearances):
            size = room.high - room.low
            shift = room.low + size.real * share[:, None] + 1j * size.imag * share
            z = shift[..., None, None] + arm
            rooms = self.clearances if mixed else [room]
            tables = [np.minimum.reduceat(own.coarse(z), self.first, axis=-1) for own in rooms]
            # Each path lies in the room that has most clearance for it.
            clearance = np.max(tables, axis=0).min(axis=-1)
            depth = self.depth(room, shift[..., None], turns, scale)
            clearance = np.minimum(clearance, depth)
            modes = ["constant", "constant", "wrap"]  # of turns the last one is beside the first
            around = maximum_filter(clearance, 3, mode=modes, cval=-np.inf)
            for i, j, n in np.argwhere(clearance == around):
                which = np.argmax(tables, axis=0)[i, j, n] if mixed else [k] * len(self.paths)
                own = tuple(map(int, which))
                at = complex(shift[i, j])
                found.append(Found(float(clearance[i, j, n]), own, at, float(turns[n]), scale))
        found.sort(key=lambda each: -each.clearance)
        return found[:STARTS]

    def best(self, starts: list[Found]) -> Found | None:
        """Return the best placement that comes of some, with its exact clearance; None where none
        keeps the margin.
        """
        best = None
        value = self.margin
        found = map(self.improved, progress(starts, desc="place", delay=2, leave=False))
        for each in sorted(found, key=lambda each: -each.clearance):
            if each.clearance <= value:
                break
            clearance, _ = self.exactly(each)
            if clearance > max(value, self.least(each)):
                best = each._replace(clearance=clearance)
                value = clearance
        return best

    def largest(self, mixed: bool) -> Found | None:
        """Return the largest placement: grown again from where its scale has most clearance."""
        sides = [abs(room.high - room.low) for room in self.clearances]
        best = None
        found = self.best(self.starts(SMALL * max(sides) / self.size, mixed))
        while found:
            best = self.grown(found)
            found = self.best(self.starts(GROWN * best.scale, mixed))
        return best

    def grown(self, found: Found) -> Found:
        """Return the placement as large as it keeps the margin.

        No point moves farther than the paths' size times the growth of the scale, and where the
        placement is improved, there is clearance to grow on.
        """
        steps = 2.0
        for _ in progress(count(), desc="place", unit=" steps", delay=2, leave=False):
            spare = found.clearance - self.least(found)
            growth = steps * spare / self.size
            if growth < FINE * found.scale:
                break
            larger = self.best([found._replace(scale=found.scale + growth)])
            if larger:
                found = larger
            else:
                steps /= 2
        return found

    def exactly(self, found: Found) -> tuple[float, complex]:
        """Return the exact clearance of a placement, and the point where it is least."""
        placement = found.placement(self.middle)
        clearance = np.inf
        at = 0j
        for path, k in zip(self.paths, found.which):
            own, where = self.clearances[k].along(placement(path), clearance)
            if own < clearance:
                clearance, at = own, where
        depth = self.depth(self.clearances[found.which[0]], found.shift, found.turn, found.scale)
        return min(clearance, float(depth)), at

    def depth(self, room: Clearance, shift: ArrayLike, turn: ArrayLike, scale: float) -> np.ndarray:
        """Return how deep holes of a room are in pages (*batch,), below 0; inf where none is."""
        if not self.page:
            return np.array(np.inf)
        away = (room.holes - np.expand_dims(shift, -1)) * np.exp(-1j * np.expand_dims(turn, -1))
        width, height = self.page
        x = np.abs(away.real) - scale * width / 2
        y = np.abs(away.imag) - scale * height / 2
        off = np.maximum(x, y)
        return np.where(off < 0, off, np.inf).min(axis=-1, initial=np.inf)

    def settled(self, found: Found) -> Found:
        """Return the placement with as few changes of rooms as its clearance allows."""
        if len(set(found.which)) == 1:
            return found
        clearance, _ = self.exactly(found)
        placement = found.placement(self.middle)
        runs: list[set[int]] = []  # for each path the rooms that hold it and those before it
        for path, own in zip(self.paths, found.which):
            placed = placement(path)
            rooms = {own}
            for k, room in enumerate(self.clearances):
                if room.along(placed, clearance)[0] >= clearance:
                    rooms.add(k)
            runs.append(runs[-1] & rooms or rooms if runs else rooms)
        which: list[int] = []
        for rooms in reversed(runs):
            which.append(which[-1] if {*which[-1:]} & rooms else min(rooms))
        return found._replace(which=tuple(reversed(which)))

    def least(self, found: Found) -> float:
        """Return what the clearance must be above, so that the margin is kept in spite of TIGHT."""
        return self.margin + 2 * TIGHT * found.scale * max(path.length for path in self.paths)

    def rough(self, which: tuple[int, ...], z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signed distances of the paths' samples from their borders, and their gradients."""
        own = np.array(which)[self.owner]
        away = np.empty(len(z))
        normal = np.empty(len(z), dtype=complex)
        for k in set(which):
            away[own == k], normal[own == k] = self.clearances[k].rough(z[own == k])
        return away, normal

    def improved(self, start: Found) -> Found:
        """Return a better placement by linear programs on the distances from the borders."""
        _, which, shift, turn, scale = start
        size = self.size * scale
        step = max(0.3 * size, 0.1 * min(self.clearances[k].most for k in which))
        seen = np.empty((0, 2), dtype=complex)
        arms = scale * np.exp(1j * turn) * self.z
        away, normal = self.rough(which, shift + arms)
        for _ in range(ROUNDS):
            least = float(away.min())
            near = away < least + 4 * step
            distance = away[near]
            direction = normal[near]
            arm = arms[near]
            if least > 0 and len(seen):
                # Where a point is as near to several borders, those met before are kept off too.
                own = arms[seen[:, 0].real.astype(int)]
                other = shift + own - seen[:, 1]
                close = np.abs(other) < least + 4 * step
                distance = np.concatenate([distance, np.abs(other[close])])
                direction = np.concatenate([direction, other[close] / np.abs(other[close])])
                arm = np.concatenate([arm, own[close]])
            # Of dx, dy and the turn times the paths' size, and of the clearance.
            turned = (direction.conj() * 1j * arm).real / size
            rows = np.stack([-direction.real, -direction.imag, -turned, np.ones(len(arm))], axis=1)
            sides = [(-step, step), (-step, step), (-step, step), (None, None)]
            if self.turn is not None:
                sides[2] = 0.0, 0.0
            answer = linprog([0, 0, 0, -1], A_ub=rows, b_ub=distance, bounds=sides)
            dx, dy, dturn, clearance = answer.x
            if clearance - least < 1e-8 * size:
                break
            trial = shift + complex(dx, dy), turn + dturn / size
            placed = scale * np.exp(1j * trial[1]) * self.z
            then = self.rough(which, trial[0] + placed)
            met = np.flatnonzero(then[0] < then[0].min() + step)
            feet = trial[0] + placed[met] - then[0][met] * then[1][met]
            seen = np.concatenate([seen, np.stack([met, feet], axis=1)])[-SEEN:]
            if then[0].min() > least:
                shift, turn = trial
                arms = placed
                away, normal = then
            else:
                step /= 3
            if step < 1e-7 * size:
                break
        return Found(float(away.min()), which, shift, turn, scale)


def _lattice(page, count):
    """Return count x count points on a page."""
    share = (np.arange(count) + 0.5) / count
    return (page[0] * share[:, None] + 1j * page[1] * share).ravel()


def _samples(path, count):
    """Return points of a path, its corners among them."""
    corners = np.array([stop.s for stop in path.stops])
    corners = corners[:: math.ceil(len(corners) / CORNERS)]
    return path(np.union1d(np.linspace(0, path.length, count), corners))[0] @ (1, 1j)
