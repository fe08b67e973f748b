"""The stretches on which a path is timed: cut at its knots, at Type 2, until each is enclosed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize.elementwise import find_root

from ...models.physics import loads_of
from .bounds import Bernstein, Stretches, asked_on, enclosed
from .enclosures import TERMS
from .refusals import VOID, refuse_touching, refuse_undecided, refuse_unreachable, where

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path

FIRST = 96  # stretches of a whole path at first
OF_PIECE = 8  # of each piece at least: on fewer, often no motion is found
LONG = 1e-4  # of it: shorter ones are left where it is not known which way a joint turns
NONE = 1e-12  # of det A, or of a slope: it has no sign
ZERO = 1e-11  # of a joint's largest derivative: rounding of where it turns round
SHORTEST = 1e-9  # of the path's length: what is undecided on less is said to touch a singularity


@dataclass(frozen=True, eq=False)
class Mesh:
    """A path in stretches, and all that is asked for on them.

    s: of the nodes (n + 1,), m. found: {name: Bernstein}; side: the sign of det A (n,); turns (2,
    n): of both joints' slopes, 0 where not known;
    crossing (n + 1,): nodes on Type 2; rest (n + 1,): nodes at which the motion stops; speed (n,):
    the path's feed.
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
        return np.append(starts + self.stretches.first, starts[-1] + self.stretches.last[-1])

    @property
    def side(self) -> np.ndarray:
        D = self.factors["D"]
        return np.sign(np.where(np.abs(D.first) > np.abs(D.last), D.first, D.last))

    @property
    def turns(self) -> np.ndarray:
        return np.stack([_sign(self.found[name]) for name in ("q1", "q2")])

    @property
    def rest(self) -> np.ndarray:
        stops = np.array([stop.s for stop in self.path.stops])
        close = 1e-12 * self.path.length
        return np.searchsorted(stops, self.s + close) > np.searchsorted(stops, self.s - close)

    @property
    def part(self) -> np.ndarray:
        """Return which part of the path, from rest to rest, each stretch (n,) is on."""
        stops = np.array([stop.s for stop in self.path.stops])
        middles = self.s[:-1] + self.stretches.length / 2
        return np.searchsorted(stops, middles) - 1

    @property
    def speed(self) -> np.ndarray:
        return np.array(self.path.feed, dtype=float)[self.stretches.piece]

    def place(self, k: int) -> str:
        """Return where a node is, for a message."""
        return where(self.path, self.s[k])

    def share(self, name: str, k: int) -> float:
        """Return the size of a factor of the torques at node k over its largest on the path."""
        names = [each for each in (f"{name}1", f"{name}2") if each in self.found]
        sizes = np.abs([np.append(self.found[n].first, self.found[n].last[-1]) for n in names])
        return float(sizes[:, k].max() / (sizes.max() or 1.0)) if names else 0.0

    @cached_property
    def criterion(self) -> np.ndarray:
        """Nodes (n + 1,) on Type 2 where the crossing criterion ties u to x: not where the path
        runs along the bars.
        """
        return self._not_void("a", self.crossing)

    @cached_property
    def tied(self) -> np.ndarray:
        """Of these nodes (n + 1,) those where the elbows' viscous friction makes the criterion one
        of sqrt(x) too.
        """
        return self._not_void("v", self.criterion)

    def _not_void(self, name, nodes):
        """Of these nodes (n + 1,) those where this part of the torques is more than rounding."""
        found = nodes.copy()
        for k in np.flatnonzero(found):
            found[k] = self.share(name, k) > VOID
        return found

    @cached_property
    def factors(self) -> dict[str, Bernstein]:
        """`found`; beside nodes where the criterion is void, the torques' factors and det A over
        the distance to it.
        """
        nodes = self.crossing & ~self.criterion
        if not nodes.any():
            return self.found
        after = nodes[:-1]
        before = nodes[1:]
        names = [name for name in self.found if name == "D" or name[0] in "abvcfd"]
        return self.found | {
            name: _over_distance(self.found[name], after, before) for name in names
        }

    def split(self, parts: np.ndarray) -> Mesh:
        """With each stretch cut in so many parts (n,), 1 or more."""
        return _enclosed(
            self.robot,
            self.path,
            self.working,
            self.stretches.parted(parts),
            np.repeat(parts > 1, parts),
            {
                name: value.taken(np.repeat(np.arange(len(self)), parts))
                for name, value in self.found.items()
            },
        )

    def taken(self, at: np.ndarray) -> Mesh:
        """Return the mesh of these stretches alone, those of whole parts from rest to rest."""
        found = {name: value.taken(at) for name, value in self.found.items()}
        stretches = self.stretches.taken(at)
        crossing = np.append(self.crossing[at], self.crossing[at[-1] + 1])
        return replace(self, stretches=stretches, found=found, crossing=crossing)


def _sign(value):
    """Of a function on stretches at whose ends it may be 0; 0 where it may change within."""
    none = ZERO * value.size().max()
    return np.where(value.least() >= -none, 1.0, np.where(value.largest() <= none, -1.0, 0.0))


def _over_distance(value, after, before):
    """Return a function that is 0 at t = 0 (after) or t = 1 (before) over t or 1 - t."""
    near = np.where(before, value.last, value.first)
    steep = 2 * (value.middle - near)
    whole = np.where(before, value.first, value.last) - near
    first = np.where(before, whole, steep)
    last = np.where(before, steep, whole)
    at = after | before
    parts = [np.where(at, own, old) for own, old in zip((first, (first + last) / 2, last), value)]
    return Bernstein(
        *parts, np.where(at, 0.0, value.bend), np.where(at, value.slack + value.bend, value.slack)
    )


def mesh_of(robot: Robot, path: Path, working: tuple[int, int]) -> Mesh:
    """Return the first mesh. UnreachableError where the path leaves what the legs reach,
    SingularityError where it touches Type 1, or Type 2 without crossing it, with s and the
    place; or where all poses of the modes are singular.
    """
    stretches = _first(path)
    refuse_unreachable(robot, path, stretches, working)
    return _enclosed(robot, path, working, cut_at_signs(robot, path, stretches, working))


def _first(path):
    lengths = np.array([piece.length for piece in path.pieces])
    count = np.maximum(np.ceil(FIRST * lengths / path.length).astype(int), OF_PIECE)
    return Stretches(np.arange(len(lengths)), 0 * lengths, lengths).parted(count)


def cut_at_signs(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> Stretches:
    """Cut where det A has two signs at a stretch's ends, and with dry friction a joint's slope.

    Where it changes twice on a stretch, that is not decided, and is halved until this shows.
    """
    names = ["D", "q1", "q2"] if loads_of(robot).sticks else ["D"]

    def values(s, piece, name):
        return asked_on(robot, path, working, piece.astype(int), s, s, TERMS - 1)[name].m[0]

    rows = []
    places = []
    for name in names:
        ends = stretches.first, stretches.last
        first, last = (values(s, stretches.piece, name) for s in ends)
        row = np.flatnonzero((first * last < 0) & (np.minimum(abs(first), abs(last)) > NONE))
        rows.append(row)
        if len(row):
            at = stretches.taken(row)
            roots = find_root(partial(values, name=name), (at.first, at.last), args=(at.piece,))
            places.append(roots.x)
    return stretches.cut(np.concatenate(rows), np.concatenate([*places, []]))


def _enclosed(robot, path, working, stretches, new=None, found=None):
    """Return the Mesh on these stretches, split further where something is not decided.

    found: what is known on them but for those that are new (n,).
    """
    if new is None or new.all():
        found = enclosed(robot, path, stretches, working)
    elif new.any():
        for name, value in enclosed(robot, path, stretches.taken(new), working).items():
            for old, own in zip(found[name], value):
                old[new] = own
    D = found["D"]
    # A node on Type 2: det A is 0 to rounding there, and has other signs on both sides.
    low = np.abs(np.append(D.first, D.last[-1])) <= 1e-12
    open_ = ~np.isfinite(np.sum([b.middle + b.bend for b in found.values()], axis=0))
    decided = (D.least() > 0) | (D.largest() < 0)
    # Beside such a node it is t times a function of degree 1.
    for ends, here, there in ((low[:-1], D.first, D.last), (low[1:], D.last, D.first)):
        near = 2 * (D.middle - here)
        far = there - here
        decided |= ends & ~(low[:-1] & low[1:]) & (near * far > 0) & (np.abs(near) > D.bend)
    bad = open_ | ~decided
    if loads_of(robot).sticks:
        unknown = (_sign(found["q1"]) == 0) | (_sign(found["q2"]) == 0)
        bad |= unknown & (stretches.length > LONG * path.length)
    mesh = Mesh(robot, path, working, stretches, found, low)
    if not bad.any():
        refuse_touching(mesh)
        return mesh
    tiny = bad & (stretches.length < SHORTEST * path.length)
    if tiny.any():
        refuse_undecided(mesh, int(np.argmax(tiny)), bool(open_[np.argmax(tiny)]))
    halves = stretches.parted(1 + bad)
    cut = cut_at_signs(robot, path, halves, working)
    if len(cut) > len(halves):
        return _enclosed(robot, path, working, cut)
    return mesh.split(1 + bad)
