"""The stretches on which a path is timed: cut at its knots, exactly at Type 2, and until all on each is enclosed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import SingularityError, UnreachableError
from ..models.geometry import igm
from ..models.physics import physics_of
from .bounds import Bernstein, Stretches, asked, enclosed
from .enclosures import TERMS, place_series

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .curve import Path

FIRST = 96  # stretches of a whole path at first
SAMPLES = 8  # of each, where signs are looked for
SHORTEST = 1e-9  # of the path's length: what is undecided on less is said to touch a singularity
VOID = 1e-9  # of a factor's largest size, that counts as 0 where Type 2 is crossed
TOUCH = 1e-9  # of det A, as in `singularity`


@dataclass(frozen=True, eq=False)
class Mesh:
    """A path in stretches, and all that is asked for on them.

    s: of the nodes (n + 1,), m. found: {name: Bernstein}; side: the sign of det A (n,); turns (2, n): of both joints;
    crossing (n + 1,): nodes on Type 2; rest (n + 1,): nodes at which the motion stops; speed (n,): the path's feed.
    """

    robot: Robot
    path: Path
    working: tuple[int, int]
    stretches: Stretches
    found: dict[str, Bernstein]
    crossing: np.ndarray

    def __len__(self) -> int:
        return len(self.stretches)

    @property
    def s(self) -> np.ndarray:
        starts = self.path.knots[self.stretches.piece]
        return np.append(starts + self.stretches.first, self.path.length)

    @property
    def side(self) -> np.ndarray:
        D = self.factors["D"]
        return np.sign(np.where(np.abs(D.first) > np.abs(D.last), D.first, D.last))

    @property
    def turns(self) -> np.ndarray:
        return np.stack([np.sign(self.found[name].first + self.found[name].last) for name in ("q1", "q2")])

    @property
    def rest(self) -> np.ndarray:
        stops = np.array([stop.s for stop in self.path.stops])
        return np.abs(self.s[:, None] - stops).min(axis=1) <= 1e-12 * self.path.length

    @property
    def speed(self) -> np.ndarray:
        return np.array(self.path.feed, dtype=float)[self.stretches.piece]

    def place(self, k: int) -> str:
        """Where a node is, in words."""
        return where(self.path, self.s[k])

    def share(self, name: str, k: int) -> float:
        """How large a factor of the torques is at node k, of its largest size on the path."""
        found = [self.found[f"{name}{leg}"] for leg in (1, 2) if f"{name}{leg}" in self.found]
        largest = max((np.abs(each.first).max() for each in found), default=0.0)
        return max((float(abs(each.first[k])) for each in found), default=0.0) / (largest or 1.0)

    @cached_property
    def criterion(self) -> np.ndarray:
        """Nodes (n + 1,) on Type 2 where the crossing criterion ties u to x: not where the path runs along the bars."""
        found = self.crossing.copy()
        for k in np.flatnonzero(found):
            found[k] = self.share("a", k) > VOID
        return found

    @cached_property
    def factors(self) -> dict[str, Bernstein]:
        """`found`; beside nodes where the criterion is void, the torques' factors and det A over the distance to it."""
        nodes = self.crossing & ~self.criterion
        if not nodes.any():
            return self.found
        after, before = nodes[:-1], nodes[1:]
        names = [name for name in self.found if name == "D" or name[0] in "abvcf"]
        return self.found | {name: _over_distance(self.found[name], after, before) for name in names}

    def split(self, parts: np.ndarray) -> Mesh:
        """With each stretch cut in so many parts (n,), 1 or more."""
        return _enclosed(self.robot, self.path, self.working, _parted(self.stretches, parts), self)


def where(path: Path, s: float) -> str:
    x, y = path(s)[0]
    return f"s = {s:.9g} m of {path.length:.6g}, xi = ({x:.9g}, {y:.9g}) m"


def _over_distance(value, after, before):
    """A function that is 0 at t = 0 (after) or t = 1 (before) over t or 1 - t."""
    near = np.where(before, value.last, value.first)
    steep, whole = 2 * (value.middle - near), np.where(before, value.first, value.last) - near
    first, last = np.where(before, whole, steep), np.where(before, steep, whole)
    at = after | before
    parts = [np.where(at, own, old) for own, old in zip((first, (first + last) / 2, last), value)]
    return Bernstein(*parts, np.where(at, 0.0, value.bend), np.where(at, value.slack + value.bend, value.slack))


def mesh_of(robot: Robot, path: Path, working: tuple[int, int]) -> Mesh:
    """The first mesh. UnreachableError where the path leaves what the legs reach, SingularityError where it touches
    Type 1, or Type 2 without crossing it; all with s and the place."""
    stretches = _first(path)
    _refuse_unreachable(robot, path, stretches, working)
    return _enclosed(robot, path, working, _cut_at_signs(robot, path, stretches, working), None)


def _first(path):
    lengths = np.diff(path.knots)
    rests = np.isin(path.knots, [stop.s for stop in path.stops])
    least = np.where(rests[:-1] & rests[1:], 2, 1)  # from rest to rest it has to move in between
    count = np.maximum(np.ceil(FIRST * lengths / path.length).astype(int), least)
    piece = np.repeat(np.arange(len(lengths)), count)
    share = np.concatenate([np.arange(n + 1) / n for n in count])
    ends = np.repeat(np.array([p.length for p in path.pieces]), count + 1) * share
    last = np.cumsum(count + 1) - 1
    starts = np.delete(np.arange(len(ends)), last)
    return Stretches(piece, ends[starts], ends[starts + 1])


def _parted(stretches, parts):
    index = np.repeat(np.arange(len(parts)), parts - 1)
    k = np.arange(len(index)) - np.repeat(np.cumsum(parts - 1) - (parts - 1), parts - 1) + 1
    return _cut(stretches, index, stretches.first[index] + stretches.length[index] * k / parts[index])


def _cut(stretches, index, places):
    """With cuts at places inside stretches[index]."""
    order = np.lexsort((places, index))
    index, places = index[order], places[order]
    piece = np.insert(stretches.piece, index + 1, stretches.piece[index])
    first = np.insert(stretches.first, index + 1, places)
    last = np.append(np.where(piece[1:] == piece[:-1], first[1:], np.nan), np.nan)
    ends = np.flatnonzero(np.isnan(last))
    last[ends] = stretches.last[np.flatnonzero(np.append(np.diff(stretches.piece), 1) != 0)]
    return Stretches(piece, first, last)


def _refuse_unreachable(robot, path, stretches, working):
    s = stretches.first[:, None] + stretches.length[:, None] * np.linspace(0, 1, SAMPLES + 1)
    xi = path.on(np.broadcast_to(stretches.piece[:, None], s.shape), s)[0].reshape(-1, 2)
    bad = ~np.isfinite(igm(robot, xi, working, unreachable="nan").q).all(axis=1)
    if bad.any():
        k = int(np.argmax(bad))
        _refuse(robot, path, working, float(path.knots[stretches.piece[k // (SAMPLES + 1)]] + s.ravel()[k]), xi[k])


def _refuse(robot, path, working, s, xi):
    try:
        igm(robot, xi, working)
    except (UnreachableError, SingularityError) as error:
        amount = error.gap if isinstance(error, UnreachableError) else error.margin
        raise type(error)(f"time_path: the path leaves the workspace at s = {s:.9g} m: {error}", amount) from None


def _values(robot, path, working, piece, s, names):
    """{name: (values, derivatives)} at single places."""
    xi = place_series(path, piece, s, s, TERMS - 1)
    found = asked(robot, xi, working)
    return {name: (found[name].m[0], found[name].m[1]) for name in names}


def _cut_at_signs(robot, path, stretches, working):
    """Cut where det A changes its sign, and with friction where a joint turns round."""
    names = ["D"]
    if (physics := physics_of(robot)) is not None and physics.rubs:
        names += ["q1", "q2"]
    share = np.linspace(0, 1, SAMPLES + 1)
    s = stretches.first[:, None] + stretches.length[:, None] * share
    piece = np.broadcast_to(stretches.piece[:, None], s.shape)
    sampled = _values(robot, path, working, piece.ravel(), s.ravel(), names)
    index, places = [], []
    for name in names:
        value = sampled[name][0].reshape(s.shape)
        row, column = np.nonzero(value[:, :-1] * value[:, 1:] < 0)
        roots = _roots(
            lambda at, k, name=name: _values(robot, path, working, stretches.piece[k], at, [name])[name],
            s[row, column],
            s[row, column + 1],
            value[row, column],
            row,
        )
        inside = np.minimum(roots - stretches.first[row], stretches.last[row] - roots) > 1e-12 * path.length
        index.append(row[inside])
        places.append(roots[inside])
    return _cut(stretches, np.concatenate(index), np.concatenate(places))


def _roots(function, low, high, at_low, k):
    """Roots by Newton steps that stay between signs; function(s, k) -> (value, derivative)."""
    if not len(low):
        return low
    sign, s = np.sign(at_low), (low + high) / 2
    for _ in range(60):
        value, slope = function(s, k)
        below = np.sign(value) == sign
        low, high = np.where(below, s, low), np.where(below, high, s)
        with np.errstate(all="ignore"):
            step = s - value / slope
        after = np.where((step > low) & (step < high), step, (low + high) / 2)
        done = (np.abs(after - s) <= 2e-16 * np.abs(s)) | (value == 0)
        s = np.where(value == 0, s, after)
        if done.all():
            break
    return s


def _enclosed(robot, path, working, stretches, known):
    """The Mesh on these stretches, those split further on which something is not decided; known: one to take from."""
    while True:
        found = _found(robot, path, working, stretches, known)
        D = found["D"]
        # A node on Type 2: det A is 0 to rounding there, and has other signs on both sides.
        low = np.abs(np.append(D.first, D.last[-1])) <= 1e-12
        open_ = ~np.isfinite(np.sum([b.middle + b.bend for b in found.values()], axis=0))
        decided = (D.least() > 0) | (D.largest() < 0)
        # Beside such a node it is t times a function of degree 1.
        for ends, here, there in ((low[:-1], D.first, D.last), (low[1:], D.last, D.first)):
            near, far = 2 * (D.middle - here), there - here
            decided |= ends & ~(low[:-1] & low[1:]) & (near * far > 0) & (np.abs(near) > D.bend)
        bad = open_ | ~decided
        mesh = Mesh(robot, path, working, stretches, found, low)
        if not bad.any():
            _refuse_touching(mesh)
            return mesh
        tiny = bad & (stretches.length < SHORTEST * path.length)
        if tiny.any():
            _refuse_tiny(mesh, int(np.argmax(tiny)), bool(open_[np.argmax(tiny)]))
        known, stretches = mesh, _parted(stretches, 1 + bad)
        stretches = _cut_missed(robot, path, working, stretches)


def _cut_missed(robot, path, working, stretches):
    """Cut where det A has two signs that the first samples had not shown."""
    ends = _values(
        robot, path, working, np.tile(stretches.piece, 2), np.concatenate([stretches.first, stretches.last]), ["D"]
    )["D"][0].reshape(2, -1)
    row = np.flatnonzero((ends[0] * ends[1] < 0) & (np.abs(ends) > 1e-12).all(axis=0))
    roots = _roots(
        lambda at, k: _values(robot, path, working, stretches.piece[k], at, ["D"])["D"],
        stretches.first[row],
        stretches.last[row],
        ends[0][row],
        row,
    )
    return _cut(stretches, row, roots)


def _found(robot, path, working, stretches, known):
    """`enclosed`, of stretches that are known taken over."""
    if known is None:
        return enclosed(robot, path, stretches, working)
    old = {
        key: k
        for k, key in enumerate(
            zip(*map(np.ndarray.tolist, (known.stretches.piece, known.stretches.first, known.stretches.last)))
        )
    }
    keys = zip(*map(np.ndarray.tolist, (stretches.piece, stretches.first, stretches.last)))
    source = np.array([old.get(key, -1) for key in keys])
    new = source < 0
    fresh = enclosed(robot, path, stretches.taken(new), working) if new.any() else known.found
    found = {}
    for name, value in fresh.items():
        parts = []
        for mine, theirs in zip(value, known.found[name]):
            whole = theirs[source]
            if new.any():
                whole[new] = mine
            parts.append(whole)
        found[name] = Bernstein(*parts)
    return found


def _refuse_tiny(mesh, k, leg):
    s = mesh.s[k]
    at = where(mesh.path, s)
    if leg:
        raise SingularityError(
            f"time_path: the path touches Type 1 (a leg in line) in working modes {mesh.working} at {at}", 0.0
        )
    raise SingularityError(
        f"time_path: the path grazes Type 2 (det A = 0 without changing sign) at {at}: there the bars carry nothing "
        "across themselves, and no speed makes that right on both sides; move or turn the path", 0.0,
    )  # fmt: skip


def _refuse_touching(mesh):
    D, side = mesh.found["D"], mesh.side
    ends = np.append(D.first, D.last[-1])
    bad = (np.abs(ends) <= TOUCH) & mesh.rest
    if bad.any():
        raise SingularityError(
            f"time_path: the path rests on Type 2 at {mesh.place(int(np.argmax(bad)))}: no torque starts it there; let "
            "it pass, or rest elsewhere", 0.0,
        )  # fmt: skip
    graze = np.flatnonzero(mesh.crossing[1:-1] & (side[1:] == side[:-1]))
    if len(graze):
        _refuse_tiny(mesh, int(graze[0]) + 1, False)
    for k in np.flatnonzero(mesh.crossing):
        a, *others = (mesh.share(name, k) for name in "abvc")
        if a <= VOID < max(others):
            raise SingularityError(
                f"time_path: the path runs along the distal bars where it crosses Type 2, at {mesh.place(k)}, and bends "
                "or falls across them: nothing can push it there, so that no speed, or one alone, would cross it", 0.0,
            )  # fmt: skip
