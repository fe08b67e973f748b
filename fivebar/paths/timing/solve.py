"""A lower bound and a feasible motion on stretches of a path, which are split until both agree."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...base.progress import progress
from .constraint_rows import DIRECTIONS, NEAR, Limits, rows_of
from .lower_bound import MARGIN, Ceiling, caps, ceiling, duration
from .mesh import joined
from .polygons import polygons
from .reachability import profile
from .refusals import held

if TYPE_CHECKING:
    from .mesh import Mesh

MOST = 20000  # stretches
LOOKS = 300_000  # at stretches, on all meshes: about 10 s
GROWN = 10  # times as many stretches as at first, more than these
WORK = 200  # times as many looks, more than these
ROUNDS = 60  # meshes, each split from the one before
BESIDE = 3  # stretches on either side of Type 2
LAYER = 0.1  # of the layer beside it: stretches there are no longer,
SHORT = 1e-10  # but of the path no shorter
GROUP = 1000  # stretches at first, after which another group of parts begins
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

    It ends before after a fixed count of work, or `until`, s, of the thread's processor time. The
    parts from rest to rest are taken in groups of some, which share the time that is left.
    """
    while (long := _across_layers(mesh)).any():
        mesh = mesh.split(1 + long)
    part = mesh.part
    # A new group begins with the part in which another GROUP of stretches ends.
    ends = np.cumsum(np.bincount(part))[part]
    group = ends // GROUP
    meshes = []
    tables = []
    looks = 0
    count = len(np.unique(part))
    with progress(total=count, desc="least time", unit=" parts", delay=2, leave=False) as bar:
        for k in np.unique(group):
            own = group == k
            now = time.thread_time()
            share = own.sum() / (group >= k).sum()
            ends_at = now + share * (until - now)
            chosen, own_looks = _refined(mesh.taken(own), limits, gap, ends_at, bar)
            looks += own_looks
            for each, found, at in chosen:
                meshes.append(each.taken(at))
                above = found.above
                columns = above.x[:-1], above.time, above.high, above.size
                columns = *columns, found.top[:-1], found.x[:-1], found.bent, found.time
                tables.append(np.stack(columns)[:, at])
    mesh, order = joined(meshes)
    highest, least, high, size, top, x, bent, taken = np.concatenate(tables, axis=1)[:, order]
    highest, top, x = (np.append(each, 0.0) for each in (highest, top, x))  # it ends at rest
    return mesh, Solved(Ceiling(highest, least, high, size, None), top, x, bent, taken, (), looks)


def _refined(mesh, limits, gap, until, bar):
    """Return ([(mesh, solution, at), ...], looks): stretches `at` (n,) of whole parts from rest to
    rest, each split until its own bounds are within `gap`, or all of them together; the bar counts
    the parts that are.
    """
    part = mesh.part
    count = part[-1] + 1
    taken = np.where(np.bincount(part), np.inf, 0.0)  # the least time of each part
    bound = np.zeros(count)  # and its lower bound
    best = np.full(count, -1)  # in this round
    rounds = []
    hints = None
    looks = 0
    left = len(np.unique(part))
    most = MOST + GROWN * len(mesh)
    most_looks = LOOKS + WORK * len(mesh)
    while True:
        found = solve(mesh, limits, hints)
        looks += found.looks
        part = mesh.part
        times, bounds = (np.bincount(part, each, count) for each in (found.time, found.above.time))
        with np.errstate(invalid="ignore"):
            better = times * bound < taken * bounds
        taken[better] = times[better]
        bound[better] = bounds[better]
        best[better] = len(rounds)
        rounds.append((mesh, found))
        open_ = (taken > (1 + gap) * bound)[part]
        done = taken.sum() <= (1 + gap) * bound.sum()
        late = time.thread_time() > until
        before, left = left, 0 if done else len(np.unique(part[open_]))
        bar.update(before - left)
        if done or late or len(mesh) > most or looks > most_looks or len(rounds) > ROUNDS:
            break
        after = mesh.taken(open_).split(_parts(mesh, found, gap)[open_])
        middles = after.s[:-1] + after.stretches.length / 2
        hints = hints_of(mesh, found)[:, np.searchsorted(mesh.s, middles) - 1]
        mesh = after
    if np.isinf(taken).any():
        node = (*found.stuck, 0)[0]
        if late:
            raise TimingError(
                "time_path: max_time ran out before a motion along the whole path was found; give"
                " it more",
                float(mesh.s[node]),
                False,
            )
        raise _no_motion(mesh, limits, node, False)
    ends = [(*rounds[k], best[rounds[k][0].part] == k) for k in np.unique(best[best >= 0])]
    return ends, looks


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


def _parts(mesh, found, gap):
    """Return into how many parts (n,) each stretch is to be divided."""
    moves = np.isfinite(found.time)
    # The gap of a stretch goes as the square of its length.
    part = np.where(moves, found.time - found.above.time, 0.0)
    allowed = 0.7 * gap * found.above.time.sum() / len(mesh)
    wanted = np.sqrt(part / min(allowed, max(0.5 * part.max(), 1e-300)))
    parts = np.clip(np.ceil(wanted), 1, 4).astype(int)
    return np.where(moves, parts, 2)


def solve(mesh: Mesh, limits: Limits, hints: np.ndarray | None = None) -> Solved:
    """Return the ceiling and a motion on this mesh.

    hints (3, n): directions of the end-effector's acceleration, rad from the path's, near which its
    limit is looked at closely, x_ss / 2, and what x is not above, from a coarser mesh.
    """
    none = np.zeros(len(mesh))
    along, bent, high = (None, none, none + np.inf) if hints is None else hints
    length = mesh.stretches.length
    about = mesh.side, mesh.turns, _directions(len(mesh), along)
    speed = np.minimum(mesh.speed, limits.speed or np.inf)
    rows, alone = rows_of(mesh.factors, limits, *about, speed, False)
    ends = caps(rows, alone)
    top = np.minimum(np.append(ends[0], np.inf), np.insert(ends[1], 0, np.inf))
    top[mesh.crossing & ~mesh.criterion] = np.inf
    if (top < 0).any():
        raise _no_motion(mesh, limits, int(np.argmin(top)), True)
    rest = mesh.rest
    above = ceiling(rows, alone, length, top, high, rest)
    if above.stuck is not None:
        raise _no_motion(mesh, limits, above.stuck, True)
    # The bounds take as long as two looks.
    best = Solved(above, top, np.append(none, 0.0), none, none + np.inf, (), 2 * len(mesh))
    if not np.isfinite(above.size).all():
        return best._replace(stuck=(int(np.argmax(~np.isfinite(above.size))),))
    narrow = limits.times(1 - MARGIN).times(1 - MARGIN, speeds=True)
    rows, alone = rows_of(mesh.factors, narrow, *about, speed * (1 - MARGIN), True)
    part = np.cumsum(rest[:-1]) - 1  # from rest to rest
    near = above.x
    found = best
    closed: list[int] = []
    if mesh.tied.any():
        # x on Type 2, where the criterion takes sqrt(x).
        table, _ = polygons(rows, alone, length, above, bent, near, none, mesh)
        x, closed = profile(table, above.x, rest)
        near = np.where(x > 0, x, near)
        found = found._replace(looks=found.looks + len(mesh))
    for off in _lowered(mesh, part) if mesh.tied.any() else (none,):
        lowered = near * (1 - np.append(off, 0.0))
        table, bends = polygons(rows, alone, length, above, bent, lowered, off, mesh)
        x, stuck = profile(table, above.x, rest)
        own = bends[:, 0] * x[:-1] + bends[:, 1] * x[1:] + bends[:, 2]
        time = duration(length, x[:-1], x[1:], own)
        never = np.isinf(np.bincount(part, time))[part]
        for k in np.setdiff1d(part[never], part[stuck]):
            # It rests there.
            stuck.append(int(np.argmax(np.isinf(time) & (part == k))))
        time = np.where(never, np.inf, time)
        found = _faster(found, Solved(above, top, x, own, time, (), len(mesh)), part)
        left = np.isinf(found.time)
        if not (left & ~np.isin(part, part[closed])).any():
            break
    return found._replace(stuck=(*closed, *(i for i in stuck if left[i])))


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


def _faster(one, other, part):
    """Return the faster of two motions, for each part (n,) from rest to rest."""
    better = (np.bincount(part, other.time) < np.bincount(part, one.time))[part]
    x = np.where(np.append(better, False), other.x, one.x)
    bent = np.where(better, other.bent, one.bent)
    time = np.where(better, other.time, one.time)
    return one._replace(x=x, bent=bent, time=time, looks=one.looks + other.looks)


def _bent(x, length):
    """Return x_ss / 2 by the neighbours, 0 where it changes its sign: there the motion switches."""
    slope = 2 * np.diff(np.diff(x) / (2 * length)) / (length[1:] + length[:-1])
    before = np.append(slope[0], slope)
    after = np.append(slope, slope[-1])
    smaller = np.where(np.abs(before) < np.abs(after), before, after)
    return np.where(before * after > 0, smaller, 0.0)


def _directions(n, along):
    even = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS) - np.pi
    even = np.broadcast_to(even[:, None], (DIRECTIONS, n))
    if along is None:
        return even
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
