"""Where a path lies best: shifted, turned and scaled into an aspect, as far from its singularities as it can be.

An aspect's exact boundary, and what else must be kept, make the test: a path that starts inside and is nowhere nearer
to a boundary than its room is inside all along.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog

from ..checks import instance, modes, not_negative, number, optional, shown, takes
from ..described import one_line
from ..models.robots import Biglide, FiveBar
from ..singularities.aspects import Aspect
from ..singularities.dexterous import dexterous
from ..singularities.disc import walled
from ..singularities.keep import Keep
from .curve import Path
from .placement import Placement
from .room import SAMPLES, TIGHT, Room
from .timing import time_path

SHIFTS, FEW = 28, 24  # a side of the grid of shifts on which the search begins, and points of the path that it tries
TURNS = 16  # of a full turn, where the search begins
ROUNDS, SEEN = 60, 400  # of a search, at most, and points of the border that it remembers
SCALES, GROWN = 24, 20  # at which a path is tried, and placements of them that are improved and grown
FASTEST = 3  # placements that are timed
STARTS = 8  # placements, the best of the search, that are improved


@dataclass(frozen=True, eq=False)
class Placed:
    """A path in its place, from `place`.

    path: placed; placement; working, aspect: the modes and the aspect, or dexterous region, in which it lies; room: m,
    its distance from the nearest boundary of what it may be in; nearest (2,) m: the point of the path where that is;
    scale: of the placement; largest: with which scale it would fit at most, None where that was not asked for.
    """

    path: Path = field(repr=False)
    placement: Placement
    aspect: Aspect
    room: float
    nearest: np.ndarray
    largest: float | None = None

    @property
    def working(self) -> tuple[int, int]:
        return self.aspect.working

    @property
    def scale(self) -> float:
        return self.placement.scale

    def __repr__(self) -> str:
        modes = "working ({:+d}, {:+d})".format(*self.working)
        where = (
            f"aspect {self.aspect.number}" if not getattr(self.aspect, "det_A", 0) else f"region {self.aspect.number}"
        )
        return one_line("Placed", repr(self.placement), modes, where, f"{self.room:.6g} m from its boundary")


@takes(
    robot=instance(FiveBar, Biglide), path=instance(Path), keep=optional(instance(Keep)), margin=not_negative,
    working=optional(modes(2)),
)  # fmt: skip
def place(
    robot: FiveBar, path: Path, *, working: ArrayLike | None = None, turn: float | None = None,
    scale: float | None = 1.0, margin: float = 0.0, keep: Keep | None = None, fastest: Mapping | None = None,
) -> Placed:  # fmt: skip
    """Put a path where it can be followed with the largest room to singularities and to what must be kept: Placed.

    working: the modes to use, None: those that give most room. turn: rad, None: free. scale: None: as large as it fits
    with the margin. margin: m, least room of the whole path. keep: what else must be kept; its least det A and sine
    take dexterous regions in the place of aspects.
    fastest: limits as `time_path` takes them, {"torque_limit": ...}; of the roomiest place in each aspect, of at most
    FASTEST of them, the one in which the path takes least time.
    The path stays in one aspect. Its room is exact, to 1e-9 of its length: distances from the exact boundaries, which
    along the path change no faster than its length. That no placement has more room is the result of a search from a
    grid of shifts and turns, not a proof.
    ValueError where it does not fit, with the largest scale that does.
    """
    if not robot.turns:
        raise ValueError("place: a biglide's aspects are strips without ends: place a path by hand between its loci")
    turn = None if turn is None else number(turn, "turn", -1e6, 1e6)
    scale = None if scale is None else number(scale, "scale", 1e-9, 1e9)
    if not (fastest is None or isinstance(fastest, Mapping)):
        raise TypeError(f"fastest must be a mapping of limits, as time_path takes them, not {shown(fastest)}")
    det_A, sin = (keep.det_A, keep.sin) if keep else (0.0, 0.0)
    regions = [part for part in dexterous(robot, det_A, sin) if working in (None, part.working)]
    rooms = [each for part in regions if (each := Room(walled(part, _rest(keep)))).most > margin]
    if not rooms:
        raise ValueError(f"place: nothing of the workspace{' in these modes' * (working is not None)} keeps the margin")
    search = _Search(path, rooms, turn, margin)
    fits = search.fits(scale) if scale else []
    best = None
    if fits:
        best = fits[0] if fastest is None else _fastest(robot, search, fits, fastest)
    if best is None:
        largest, at = search.largest()
        if scale:
            raise ValueError(
                f"place: the path does not fit at scale {scale:g} with a margin of {margin:g} m; the largest scale "
                f"found to fit is {largest:.6g}"
            )
        return search.placed(*at, largest)
    return search.placed(*best, None)


def _fastest(robot, search, fits, limits):
    """Of placements, the best of each aspect, the one that takes least time."""
    own = {each[1]: each for each in reversed(fits)}
    timed = []
    for each in sorted(own.values(), key=lambda each: -each[0])[:FASTEST]:
        working = search.rooms[each[1]].part.working
        timed.append((time_path(robot, search.put(*each[2:]), working=working, **limits).duration, each))
    return min(timed, key=lambda each: each[0])[1]


def _rest(keep):
    """What is left to keep in dexterous regions."""
    return None if keep is None else Keep(keep.joints, keep.half_planes, keep.region, bars=keep.bars)


class _Search:
    """The best placements of a path in some aspects: from a coarse grid of shifts and turns, then improved."""

    def __init__(self, path, rooms, turn, margin):
        self.path, self.rooms, self.turn, self.margin = path, rooms, turn, margin
        z = path(np.linspace(0, path.length, SAMPLES))[0] @ (1, 1j)
        self.middle = complex((z.real.min() + z.real.max()) / 2, (z.imag.min() + z.imag.max()) / 2)
        self.z = z - self.middle
        self.size = float(np.abs(self.z).max())
        self.turns = [turn] if turn is not None else [2 * math.pi * k / TURNS for k in range(TURNS)]

    def coarse(self, scale):
        """(room, which, shift, turn), the best first, one for each turn and aspect."""
        found = []
        for k, room in enumerate(self.rooms):
            x, y = (np.linspace(*ends, SHIFTS) for ends in zip(*((p.real, p.imag) for p in (room.low, room.high))))
            centres = (x[:, None] + 1j * y).ravel()
            centres = centres[room.on_grid(centres) > -scale * self.size]
            few = self.z[:: max(len(self.z) // FEW, 1)]
            for turn in self.turns:
                values = room.on_grid(centres[:, None] + scale * np.exp(1j * turn) * few).min(axis=1)
                best = int(values.argmax())
                found.append((float(values[best]), k, complex(centres[best]), turn))
        return sorted(found, key=lambda each: -each[0])

    def starts(self, scale):
        chosen = []
        for each in self.coarse(scale):
            if sum(each[1] == other[1] for other in chosen) < 3 and len(chosen) < STARTS:
                chosen.append(each)
        return chosen

    def fits(self, scale):
        """[(room, which, shift, turn, scale), ...] that keep the margin, with most room first."""
        found = [self.improved(k, shift, turn, scale) for _, k, shift, turn in self.starts(scale)]
        found.sort(key=lambda each: -each[0])
        found = [*(self.improved(*each[1:]) for each in found[:3]), *found[3:]]
        kept = [each for each in sorted(found, key=lambda each: -each[0]) if each[0] > 0.5 * self.margin]
        return [each for each in kept if self.keeps(each)]

    def keeps(self, found):
        room, _ = self.rooms[found[1]].along(self.put(*found[2:]))
        return room > self.margin + 2 * TIGHT * found[-1] * self.path.length

    def improved(self, k, shift, turn, scale, growing=False):
        """(room, which, shift, turn, scale) from a start: by linear programs, as the distances from the nearest points
        of the border change; growing: the largest scale that leaves the margin, in place of the most room."""
        room, turning = self.rooms[k], self.turn is None
        step, now, seen = max(0.3 * self.size * scale, 0.1 * room.most), None, np.empty((0, 2), dtype=complex)
        for _ in range(ROUNDS):
            z = scale * np.exp(1j * turn) * self.z
            now = room.rough(shift + z) if now is None else now
            least = float(now[0].min())
            near = now[0] < least + 4 * step
            away, normal, arm = now[0][near], now[1][near], z[near]
            if least > 0 and len(seen):
                # Where a point is as near to several borders, those met before are kept off too.
                own, border = z[seen[:, 0].real.astype(int)], seen[:, 1]
                other = shift + own - border
                close = np.abs(other) < least + 4 * step
                away = np.concatenate([away, np.abs(other[close])])
                normal = np.concatenate([normal, other[close] / np.abs(other[close])])
                arm = np.concatenate([arm, own[close]])
            normal = normal.conj()
            # Of dx, dy, the turn and the growth times the path's size, and of the room, or the growth alone.
            rates = np.stack([normal.real, -normal.imag, (normal * 1j * arm).real, (normal * arm).real], axis=1)
            rates[:, 2:] /= self.size * scale
            free = np.array([1, 1, turning, growing])
            if growing:
                cost, rows, right = [0, 0, 0, -1, 0], np.pad(-rates, ((0, 0), (0, 1))), away - self.margin
                right = np.maximum(right, 0.0) if least >= self.margin else right
            else:
                cost, rows = [0, 0, 0, 0, -1], np.column_stack([-rates, np.ones(len(away))])
                right = away
            bounds = [*((-step * f, step * f) for f in free), (None, None)]
            answer = linprog(cost, A_ub=rows, b_ub=right, bounds=bounds)
            if answer.x is None:
                step /= 4
                continue
            dx, dy, dturn, grown, _ = answer.x
            size = self.size * scale
            trial = shift + complex(dx, dy), turn + dturn / size, scale * (1 + grown / size)
            placed = trial[0] + trial[2] * np.exp(1j * trial[1]) * self.z
            then = room.rough(placed)
            met = np.flatnonzero(then[0] < then[0].min() + step)
            seen = np.concatenate([seen, np.stack([met, placed[met] - then[0][met] * then[1][met]], axis=1)])[-SEEN:]
            better = (
                (then[0].min() >= min(self.margin, least) and trial[2] > scale) if growing else then[0].min() > least
            )
            if better:
                (shift, turn, scale), now = trial, then
            else:
                step /= 3
            if step < 1e-7 * self.size * scale:
                break
        return float(now[0].min()), k, shift, turn, scale

    def largest(self):
        """The largest scale found, and its placement: grown from where the path nearly fits, at many scales."""
        most = max(abs(room.high - room.low) for room in self.rooms) / self.size
        near = [
            (*each[1:], scale)
            for scale in np.geomspace(most, 0.01 * most, SCALES)
            for each in self.coarse(scale)[:2]
            if each[0] > self.margin - 0.15 * self.size * scale
        ]
        found = []
        for start in near[:GROWN]:
            if found and start[-1] < 0.5 * found[0][-1]:
                break
            found += self.grown(start)
        if not found:
            raise ValueError(f"place: nothing larger than a point was found to keep a margin of {self.margin:g} m")
        best = max(found, key=lambda each: each[-1])
        for _ in range(3):
            best = max([best, *self.grown(best[1:])], key=lambda each: each[-1])
        return best[-1], best

    def grown(self, start):
        """[the largest that a placement can be improved and grown to], or [] where it does not fit."""
        start = self.improved(*start)
        if start[0] <= self.margin:
            return []
        now = self.improved(*start[1:], growing=True)
        for shrunk in 1e-6 * 2.0 ** np.arange(17):  # the search knows the border from samples, `keeps` exactly
            if self.keeps(now):
                return [now]
            now = (*now[:-1], now[-1] * (1 - shrunk))
        return []

    def put(self, shift, turn, scale):
        return self.placement(shift, turn, scale)(self.path)

    def placement(self, shift, turn, scale):
        shift = shift - scale * np.exp(1j * turn) * self.middle
        return Placement((shift.real, shift.imag), math.remainder(turn, 2 * math.pi), scale)

    def placed(self, _, k, shift, turn, scale, largest):
        placement = self.placement(shift, turn, scale)
        path = placement(self.path)
        room, at = self.rooms[k].along(path)
        return Placed(path, placement, self.rooms[k].part, room, np.array([at.real, at.imag]), largest)
