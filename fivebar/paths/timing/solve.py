"""A lower bound and a feasible motion on stretches of a path, which are split until both agree."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...base.progress import progress
from .constraint_rows import DIRECTIONS, NEAR, Limits, rows_of
from .lower_bound import MARGIN, Ceiling, caps, ceiling, duration
from .polygons import polygons
from .reachability import profile
from .refusals import held

if TYPE_CHECKING:
    from .mesh import Mesh

LOOKS = 300_000  # at stretches, on all meshes: about 10 s
WORK = 200  # times as many as there are stretches at first, more than these
BESIDE = 3  # stretches on either side of Type 2
LAYER = 0.1  # of the layer beside it: stretches there are no longer,
SHORT = 1e-10  # but of the path no shorter
GROUP = 1000  # stretches, after which another group of parts begins
OFF = 1e-4, 1e-3, 1e-2  # of x, by which the motion is then below it
GROWTH = 1.0, 3.0, 1 / 3  # of that, from one crossing to the next


class TimingError(RuntimeError):
    """No motion along the path that keeps the limits was found near s, m.

    proved: there is none.
    """

    def __init__(self, message: str, s: float, proved: bool) -> None:
        super().__init__(message)
        self.s = s
        self.proved = proved


class Solved(NamedTuple):
    """The ceiling, the caps at the nodes and a motion on one mesh: x, bent, s on each stretch.

    time is inf from rest to rest where no motion was found; stuck: the nodes where one near the
    ceiling was not found, so that there is none or a slower one there. looks: how many stretches
    were looked at for it.
    """

    above: Ceiling
    top: np.ndarray
    x: np.ndarray
    bent: np.ndarray
    time: np.ndarray
    stuck: tuple[int, ...] = ()
    looks: int = 0

    @property
    def gap(self) -> float:
        return float(self.time.sum() / self.above.time.sum()) - 1


def refined(mesh: Mesh, limits: Limits, gap: float, until: float) -> tuple[Mesh, Solved]:
    """Return the mesh, split until both bounds are within `gap`, and the solution on it.

    Each part from rest to rest is split until its own bounds are, or all of them together. It ends
    before after a fixed count of work, or `until`, s, of the thread's processor time.
    """
    while (long := _across_layers(mesh)).any():
        mesh = mesh.split(1 + long)
    table = np.full((8, len(mesh)), np.inf)
    hints = np.zeros((3, len(mesh)))
    hints[2] = np.inf
    open_ = np.ones(len(mesh), dtype=bool)
    most = LOOKS + WORK * len(mesh)
    looks = 0
    left = len(np.unique(mesh.part))
    with progress(total=left, desc="least time", unit=" parts", delay=2, leave=False) as bar:
        while True:
            for at in _groups(mesh.part, open_):
                own = mesh.taken(at)
                found = solve(own, limits, hints[:, at])
                looks += found.looks
                above = found.above
                columns = above.x[:-1], above.time, above.high, above.size
                table[:, at] = *columns, found.top[:-1], found.x[:-1], found.bent, found.time
                if found.stuck:
                    place = own, found.stuck[0]
            # It ends at rest.
            highest, least, high, size, top, x, bent, time_ = table
            highest, top, x = (np.append(each, 0.0) for each in (highest, top, x))
            above = Ceiling(highest, least, high, size, None)
            found = Solved(above, top, x, bent, time_, (), looks)
            part = mesh.part
            times, bounds = (np.bincount(part, each) for each in (time_, least))
            done = times.sum() <= (1 + gap) * bounds.sum()
            open_ = (times > (1 + gap) * bounds)[part] & ~done
            before, left = left, len(np.unique(part[open_]))
            bar.update(before - left)
            late = time.thread_time() > until
            if done or late:
                break
            parts = np.where(open_, _parts(mesh, found, gap, open_), 1)
            if looks + 3 * parts[open_].sum() > most:
                break
            after = mesh.split(parts)
            middles = after.s[:-1] + after.stretches.length / 2
            parents = np.searchsorted(mesh.s, middles) - 1
            hints = hints_of(mesh, found)[:, parents]
            table = table[:, parents]
            open_ = open_[parents]
            mesh = after
    if np.isinf(times).any():
        own, node = place
        if late:
            raise TimingError(
                "time_path: max_time ran out before a motion along the whole path was found; give"
                " it more",
                float(own.s[node]),
                False,
            )
        raise _no_motion(own, limits, node, False)
    return mesh, found


def _groups(part, open_):
    """Yield open stretches in groups of whole parts, of about GROUP each: so they fit in memory."""
    at = np.flatnonzero(open_)
    ends = np.cumsum(np.bincount(part[at]))[part[at]]
    yield from np.split(at, np.flatnonzero(np.diff(ends // GROUP)) + 1)


def _across_layers(mesh):
    """Return which stretches (n,) beside Type 2 are long against the layer there, in which a
    torque's factor a of u changes by as much as it is on Type 2.

    Almost along the bars a is small, and the criterion's x = -(a / b) u holds in that layer alone.
    """
    length = mesh.stretches.length
    long = np.zeros(len(mesh), dtype=bool)
    for k in np.flatnonzero(mesh.criterion):
        a = max((mesh.found[name] for name in ("a1", "a2")), key=lambda each: abs(each.first[k]))
        change = 2 * abs(a.middle[k] - a.first[k]) / length[k]
        near = slice(max(k - BESIDE, 0), k + BESIDE)
        long[near] |= length[near] * change > LAYER * abs(a.first[k])
    return long & (length > SHORT * mesh.path.length)


def hints_of(mesh: Mesh, found: Solved) -> np.ndarray:
    """Return the hints (3, n) of `solve` from a motion on the mesh."""
    # Where no motion was found, none tells how it is bent.
    bent = np.where(np.isfinite(found.time), _bent(found.x, mesh.stretches.length), 0.0)
    return np.stack([_along(mesh, found), bent, found.above.high])


def _parts(mesh, found, gap, open_):
    """Return into how many parts (n,) each open stretch is to be divided."""
    moves = np.isfinite(found.time)
    # The gap of a stretch goes as the square of its length.
    part = np.where(moves & open_, found.time - found.above.time, 0.0)
    allowed = 0.7 * gap * found.above.time.sum() / len(mesh)
    wanted = np.sqrt(part / min(allowed, max(0.5 * part.max(), 1e-300)))
    parts = np.clip(np.ceil(wanted), 1, 4).astype(int)
    return np.where(moves, parts, 2)


def solve(mesh: Mesh, limits: Limits, hints: np.ndarray) -> Solved:
    """Return the ceiling and a motion on this mesh.

    hints (3, n): directions of the end-effector's acceleration, rad from the path's, near which its
    limit is looked at closely, x_ss / 2, and what x is not above, from a coarser mesh.
    """
    none = np.zeros(len(mesh))
    along, bent, high = hints
    length = mesh.stretches.length
    about = mesh.side, mesh.turns, _directions(along)
    speed = np.minimum(mesh.speed, limits.speed or np.inf)
    rows = rows_of(mesh.factors, limits, *about, speed, False)
    ends = caps(rows)
    top = np.minimum(np.append(ends[0], np.inf), np.insert(ends[1], 0, np.inf))
    top[mesh.crossing & ~mesh.criterion] = np.inf
    if (top < 0).any():
        raise _no_motion(mesh, limits, int(np.argmin(top)), True)
    rest = mesh.rest
    above = ceiling(rows, length, top, high, rest)
    if above.stuck is not None:
        raise _no_motion(mesh, limits, above.stuck, True)
    # The bounds take as long as two looks.
    looks = 2 * len(mesh)
    x = np.append(none, 0.0)
    time = none + np.inf
    found = Solved(above, top, x, none, time, (), looks)
    if not np.isfinite(above.size).all():
        return found._replace(stuck=(int(np.argmax(~np.isfinite(above.size))),))
    narrow = limits.times(1 - MARGIN).times(1 - MARGIN, speeds=True)
    rows = rows_of(mesh.factors, narrow, *about, speed * (1 - MARGIN), True)
    part = np.cumsum(rest[:-1]) - 1  # from rest to rest
    near = above.x
    if mesh.tied.any():
        # x on Type 2, where the criterion takes sqrt(x).
        table, _ = polygons(rows, length, above, bent, near, none, mesh)
        free, _ = profile(table, above.x, rest)
        near = np.where(free > 0, free, near)
        looks += len(mesh)
    own = none
    for off in _lowered(mesh, part) if mesh.tied.any() else (none,):
        lowered = near * (1 - np.append(off, 0.0))
        table, bends = polygons(rows, length, above, bent, lowered, off, mesh)
        now, stuck = profile(table, above.x, rest)
        curve = bends[:, 0] * now[:-1] + bends[:, 1] * now[1:] + bends[:, 2]
        taken = duration(length, now[:-1], now[1:], curve)
        never = np.isinf(np.bincount(part, taken))[part]
        # Each part has the first motion that is found for it.
        left = np.isinf(time)
        x[:-1], own, time = (
            np.where(left, new, old)
            for new, old in (
                (now[:-1], x[:-1]),
                (curve, own),
                (np.where(never, np.inf, taken), time),
            )
        )
        looks += len(mesh)
        left &= never
        if not left.any():
            break
    # Where none of the nodes is told, it rests between them.
    rests = np.flatnonzero(np.isinf(taken) & left)
    stuck = (*(i for i in stuck if left[i]), *rests.tolist())
    return found._replace(x=x, bent=own, time=time, stuck=stuck, looks=looks)


def _lowered(mesh, part):
    """Yield shares (n,) by which a motion may be below the x that was found for Type 2.

    Where friction slows it down between two crossings, x of the second one falls by more than that
    of the first one, and where gravity drives it by less.
    """
    tied = np.flatnonzero(mesh.tied)
    middle = (tied[1:] + tied[:-1]) // 2
    number = np.searchsorted(middle, np.arange(len(part)))
    number -= np.searchsorted(middle, np.searchsorted(part, part))
    last = np.zeros(len(part), dtype=int)
    np.maximum.at(last, part, number)
    for off in OFF:
        for growth in GROWTH if last.any() else (1.0,):
            order = number if growth >= 1 else last[part] - number
            yield off * max(growth, 1 / growth) ** order


def _bent(x, length):
    """Return x_ss / 2 by the neighbours, 0 where it changes its sign: there the motion switches."""
    slope = 2 * np.diff(np.diff(x) / (2 * length)) / (length[1:] + length[:-1])
    before = np.append(slope[0], slope)
    after = np.append(slope, slope[-1])
    smaller = np.where(np.abs(before) < np.abs(after), before, after)
    return np.where(before * after > 0, smaller, 0.0)


def _directions(along):
    even = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS) - np.pi
    even = np.broadcast_to(even[:, None], (DIRECTIONS, len(along)))
    near = (along + np.array(NEAR)[:, None] + np.pi) % (2 * np.pi) - np.pi
    return np.sort(np.concatenate([even, near]), axis=0)


def _along(mesh, found):
    """Return directions (n,) of the end-effector's acceleration, rad from the path's."""
    u = np.diff(found.x) / (2 * mesh.stretches.length)
    x = (found.x[1:] + found.x[:-1]) / 2
    g, m, k = (mesh.found[name].middle for name in "gmk")
    return np.arctan2(k * x, g * u + m * x)


def _no_motion(mesh, limits, node, proved):
    verb = "keeps" if proved else "was found that keeps"
    return TimingError(
        f"time_path: no motion along the path {verb} these limits near {mesh.place(node)}"
        f"{held(mesh, limits, node)}",
        float(mesh.s[node]),
        proved,
    )
