"""Placements of paths in aspects: their clearances, and how placements are improved."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from ..curve import Path
from ..placement import Placement
from .clearance import SAMPLES, TIGHT, Clearance

FEW = 24  # points of the paths that bound the clearance in a cell
ROUNDS = 60  # of an improvement, at most
SEEN = 400  # points of the border that an improvement remembers
SHRUNK = 13  # times that what has grown too large is made smaller
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
        few = [_few(each - self.middle, max(FEW // len(paths), 4)) for each in samples]
        if page:
            few = [np.append(few[0], _lattice(page, 3) - self.middle)]
        self.few = np.concatenate(few)
        self.first = np.cumsum([0, *(len(each) for each in few[:-1])])

    def exactly(self, found: Found, least: float = -np.inf) -> tuple[float, complex]:
        """Return the exact clearance of a placement, and the point where it is least."""
        placement = found.placement(self.middle)
        z = found.shift + found.scale * np.exp(1j * found.turn) * self.z
        rough = np.minimum.reduceat(
            self.rough(found.which, z)[0], np.searchsorted(self.owner, range(len(self.paths)))
        )
        clearance = np.inf
        at = 0j
        for k in np.argsort(rough):
            own, where = self.clearances[found.which[k]].along(
                placement(self.paths[k]), least, clearance
            )
            if own < clearance:
                clearance, at = own, where
            if clearance <= least:
                break
        if self.page:
            holes = self.clearances[found.which[0]].holes
            shift = np.array([found.shift])
            depth = self.off_page(holes, shift, found.turn, found.scale).min(initial=np.inf)
            clearance = min(clearance, float(depth))
        return clearance, at

    def off_page(
        self,
        points: np.ndarray,
        shift: np.ndarray,
        turn: np.ndarray | float,
        scale: np.ndarray | float,
    ) -> np.ndarray:
        """Return how deep points (m,) are in pages, (n, m), below 0; inf where they are outside."""
        away = (points - shift[:, None]) * np.exp(-1j * np.reshape(turn, (-1, 1)))
        width, height = self.page or (0.0, 0.0)
        scale = np.reshape(scale, (-1, 1))
        x = np.abs(away.real) - scale * width / 2
        y = np.abs(away.imag) - scale * height / 2
        off = np.maximum(x, y)
        return np.where(off < 0, off, np.inf)

    def at_scale(self, found: Found, scale: float) -> Found | None:
        """Return a placement at a scale near one of another scale, None if it does not fit."""
        if found.scale < scale:
            return None
        best = self.improved(found._replace(scale=scale))
        return best if self.keeps(best) else None

    def settled(self, found: Found) -> Found:
        """Return the placement with as few changes of rooms as its clearance allows."""
        if len(set(found.which)) == 1:
            return found
        clearance, _ = self.exactly(found)
        placement = found.placement(self.middle)
        which = list(found.which)
        runs: list[tuple[set[int], int]] = []
        for n, path in enumerate(self.paths):
            placed = placement(path)
            rooms = {which[n]}
            for k, room in enumerate(self.clearances):
                if room.along(placed, most=clearance)[0] >= clearance:
                    rooms.add(k)
            if runs and runs[-1][0] & rooms:
                common, count = runs[-1]
                runs[-1] = common & rooms, count + 1
            else:
                runs.append((rooms, 1))
        settled: list[int] = []
        for rooms, count in runs:
            settled += [min(rooms)] * count
        return found._replace(which=tuple(settled))

    def least(self, found: Found) -> float:
        """Return what the clearance must be above, so that the margin is kept in spite of TIGHT."""
        return self.margin + 2 * TIGHT * found.scale * max(path.length for path in self.paths)

    def keeps(self, found: Found) -> bool:
        least = self.least(found)
        return self.exactly(found, least)[0] > least

    def rough(self, which: tuple[int, ...], z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signed distances of the paths' samples from their borders, and their gradients."""
        own = np.array(which)[self.owner]
        away = np.empty(len(z))
        normal = np.empty(len(z), dtype=complex)
        for k in set(which):
            away[own == k], normal[own == k] = self.clearances[k].rough(z[own == k])
        return away, normal

    def improved(self, start: Found, growing: bool = False) -> Found:
        """Return a better placement by linear programs on the distances from the borders.

        growing: of the largest scale that leaves the margin, in place of the largest clearance.
        """
        (_, which, shift, turn, scale), turning = start, self.turn is None
        step = max(0.3 * self.size * scale, 0.1 * min(self.clearances[k].most for k in which))
        seen = np.empty((0, 2), dtype=complex)
        now = self.rough(which, shift + scale * np.exp(1j * turn) * self.z)
        for _ in range(ROUNDS):
            z = scale * np.exp(1j * turn) * self.z
            least = float(now[0].min())
            near = now[0] < least + 4 * step
            away = now[0][near]
            normal = now[1][near]
            arm = z[near]
            if least > 0 and len(seen):
                # Where a point is as near to several borders, those met before are kept off too.
                own = z[seen[:, 0].real.astype(int)]
                border = seen[:, 1]
                other = shift + own - border
                close = np.abs(other) < least + 4 * step
                away = np.concatenate([away, np.abs(other[close])])
                normal = np.concatenate([normal, other[close] / np.abs(other[close])])
                arm = np.concatenate([arm, own[close]])
            normal = normal.conj()
            size = self.size * scale
            # Of dx, dy, the turn and the growth times the paths' size, and of the room, or the
            # growth alone.
            rates = np.stack(
                [normal.real, -normal.imag, (normal * 1j * arm).real, (normal * arm).real], axis=1
            )
            rates[:, 2:] /= size
            free = np.array([1, 1, turning, growing])
            if growing:
                cost = [0, 0, 0, -1, 0]
                rows = np.pad(-rates, ((0, 0), (0, 1)))
                right = away - self.margin
                right = np.maximum(right, 0.0) if least >= self.margin else right
            else:
                cost = [0, 0, 0, 0, -1]
                rows = np.column_stack([-rates, np.ones(len(away))])
                right = away
            bounds = [*((-step * f, step * f) for f in free), (None, None)]
            answer = linprog(cost, A_ub=rows, b_ub=right, bounds=bounds)
            if answer.x is None:
                step /= 4
                continue
            dx, dy, dturn, grown, clearance = answer.x
            if (grown if growing else clearance - least) < 1e-8 * size:
                break
            trial = shift + complex(dx, dy), turn + dturn / size, scale * (1 + grown / size)
            placed = trial[0] + trial[2] * np.exp(1j * trial[1]) * self.z
            then = self.rough(which, placed)
            met = np.flatnonzero(then[0] < then[0].min() + step)
            seen = np.concatenate(
                [seen, np.stack([met, placed[met] - then[0][met] * then[1][met]], axis=1)]
            )[-SEEN:]
            if growing:
                better = then[0].min() >= min(self.margin, least) and trial[2] > scale
            else:
                better = then[0].min() > least
            if better:
                (shift, turn, scale), now = trial, then
            else:
                step /= 3
            if step < 1e-7 * size:
                break
        return Found(float(now[0].min()), which, shift, turn, scale)

    def grown(self, start: Found, least_scale: float = 0.0) -> Found | None:
        """Return the largest placement grown from a start, None where that is not larger."""
        first = self.improved(start)
        if first.clearance <= self.margin:
            return None
        found = self.improved(first, growing=True)
        if found.scale <= least_scale:
            return None
        least = self.least(found)
        for k in range(SHRUNK):  # the search knows path and border from samples
            clearance, _ = self.exactly(found)
            if clearance > least:
                return found
            # Growth changes distances by no more than this: so much less is enough, but where the
            # samples are on both sides of a border.
            less = max(
                1.1 * (least - clearance) / self.size, 1e-9 * 8.0 ** max(k - 3, 0) * found.scale
            )
            if less >= 0.5 * found.scale:
                break
            found = found._replace(scale=found.scale - less)
        return first if self.keeps(first) else None


def _lattice(page, count):
    """Return count x count points on a page."""
    share = (np.arange(count) + 0.5) / count
    return (page[0] * share[:, None] + 1j * page[1] * share).ravel()


def _samples(path, count):
    """Return points of a path, its corners among them."""
    corners = np.array([stop.s for stop in path.stops])
    corners = corners[:: math.ceil(len(corners) / CORNERS)]
    return path(np.union1d(np.linspace(0, path.length, count), corners))[0] @ (1, 1j)


def _few(z, count):
    """Of points those that are farthest in some directions, and some between."""
    ways = np.exp(2j * np.pi * np.arange(count // 2) / (count // 2))
    far = (z[:, None] * ways.conj()).real.argmax(axis=0)
    between = np.linspace(0, len(z) - 1, count - count // 2)
    between = between.round().astype(int)
    chosen = np.union1d(far, between)
    return z[chosen]
