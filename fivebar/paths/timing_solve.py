"""On stretches of a path what no motion passes, and a motion that keeps the limits; split until both agree."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..models.dynamics import gravity_torques
from ..models.geometry import igm
from ..models.physics import physics_of
from ..progress import progress
from .timing_lower import MARGIN, Ceiling, caps, ceiling, duration
from .timing_rows import DIRECTIONS, NEAR, Limits, rows_of
from .timing_upper import polygons, profile

if TYPE_CHECKING:
    from .timing_mesh import Mesh

MOST = 20000  # stretches
ROUNDS, FAILURES = 150, 100
BESIDE = 3  # stretches on either side of Type 2
LONG, SHORT = 1e-5, 1e-10  # of the path: how short these become at least, and at most
LAYER = 0.1  # of what `Mesh.layer` tells
CLEAR = 1e-8  # of det A on a stretch that may be cut beside Type 2
STEEP = 0.1  # at most of x_ss h^2 / x, that is taken to grow with x
PINNED_SHARES = (*np.geomspace(1.0, 0.1, 16).tolist(), 0.03, 0.003)  # where x is given on Type 2
PINS = 0.98, 0.9995  # of the ceiling's x, where it is given: at first, and tried on a mesh that a motion was found on
SHARES = 1.0, 0.3, 0.05, 0.003  # of the ceiling, below which a motion is looked for


class TimingError(RuntimeError):
    """No motion along the path was found that keeps the limits; proved: there is none."""

    def __init__(self, message: str, s: float, proved: bool) -> None:
        super().__init__(message)
        self.s, self.proved = s, proved


class Solved(NamedTuple):
    """On one mesh: what no motion passes, the caps at the nodes, and a motion: x, bent, seconds on each stretch.

    stuck: the node where a motion near the ceiling was not found, so that this is a slower one.
    """

    above: Ceiling
    top: np.ndarray
    x: np.ndarray
    bent: np.ndarray
    time: np.ndarray
    stuck: int | None = None

    @property
    def gap(self) -> float:
        return float(self.time.sum() / self.above.time.sum()) - 1


def refined(mesh: Mesh, limits: Limits, gap: float, until: float) -> tuple[Mesh, Solved]:
    """The mesh, split until both bounds are within `gap`, or until time is up, and what was found on it."""
    best, hints, stuck = None, None, 0
    while (thin := _beside_type_2(mesh, True)).any():
        mesh = mesh.split(1 + thin)
    for _ in progress(iter(range(ROUNDS)), desc="least time", unit=" rounds", delay=2, leave=False):
        found = solve(mesh, limits, hints)
        late = len(mesh) > MOST or time.perf_counter() > until
        if isinstance(found, Solved):
            lower = found.above.time.sum()
            if best is None or found.gap < best[1].gap:
                best = mesh, found
            if found.gap <= gap or late:
                break
            # The gap of a stretch goes as the square of its length.
            part = found.time - found.above.time
            part = _made(found, part)
            wanted = np.sqrt(part / min(0.7 * gap * lower / len(mesh), 0.5 * part.max()))
            parts = np.clip(np.ceil(wanted), 1, 4).astype(int)
            if found.stuck is not None:  # all of it is slower for what is missing in one place
                parts = 1 + (_about(mesh.stretches.length, found.stuck) | (part > 0.2 * part.max()))
            parts = np.maximum(parts, 1 + _beside_type_2(mesh, False))  # what is missing there shows elsewhere
            mean = (found.x[1:] + found.x[:-1]) / 2
            hints = np.stack([_along(mesh, found), _bent(found.x, mesh.stretches.length), mean])
        else:
            node, parts = found
            stuck += 1
            if best is None and (stuck > FAILURES or late):
                _refuse(mesh, limits, node, False)
            if late:
                break
        after = mesh.split(parts)
        if hints is not None:
            hints = hints[:, np.searchsorted(mesh.s, (after.s[1:] + after.s[:-1]) / 2) - 1]
        mesh = after
    if best is None:
        _refuse(mesh, limits, node, False)
    return best


def _beside_type_2(mesh, thin):
    """Stretches (n,) beside Type 2 that are longer than what is to be seen there; thin: of thin layers alone."""
    length, long = mesh.stretches.length, np.zeros(len(mesh), dtype=bool)
    D = mesh.found["D"]
    clear = np.maximum(np.abs(D.first), np.abs(D.last)) > CLEAR
    for k in np.flatnonzero(mesh.crossing):
        near = slice(max(k - BESIDE, 0), k + BESIDE)
        share = max(LAYER * mesh.layer(k) / mesh.path.length, SHORT)
        if share < LONG or not thin:
            long[near] |= clear[near] & (length[near] > min(share, LONG) * mesh.path.length)
    return long


def solve(mesh: Mesh, limits: Limits, hints: np.ndarray | None = None) -> Solved | tuple[int, np.ndarray]:
    """What is found on this mesh, or (node, how many parts of each stretch) where it is too coarse.

    hints (3, n): directions of the end-effector's acceleration, rad from the path's, near which its limit is looked at
    closely, x_ss / 2 and x, all from a coarser mesh.
    """
    along = None if hints is None else hints[0]
    length, about = mesh.stretches.length, (mesh.side, mesh.turns, _directions(len(mesh), along))
    speed = np.minimum(mesh.speed, limits.speed or np.inf)
    rows, alone = rows_of(mesh.factors, limits, *about, speed, False)
    ends = caps(rows, alone)
    top = np.minimum(np.append(ends[0], np.inf), np.insert(ends[1], 0, np.inf))
    top[mesh.crossing & ~mesh.criterion] = np.inf
    if (top < 0).any():
        _refuse(mesh, limits, int(np.argmin(top)), True)
    above = ceiling(rows, alone, length, np.where(mesh.rest, 0.0, top))
    if above.stuck is not None:
        _refuse(mesh, limits, above.stuck, True)
    if not np.isfinite(above.size).all():
        bad = ~np.isfinite(above.size)
        return int(np.argmax(bad)), 1 + bad
    narrow = limits.times(1 - MARGIN).times(1 - MARGIN, speeds=True)
    rows, alone = rows_of(mesh.factors, narrow, *about, speed * (1 - MARGIN), True)

    lean = _lean(mesh, rows, above)

    def tried(share, bent, x=None, pin=PINS[0]):
        # Slower motions need less room: where none is found on a coarse mesh, one of these is.
        below = above._replace(x=above.x * share, size=above.size * share)
        form = (bent, 0 * bent) if x is None else (bent - lean * x, lean)
        table = polygons(rows, alone, length, below, *form, pin, mesh)
        x = profile(table, below, mesh.rest)
        if isinstance(x, int):
            return x
        own = table.curvature(x)
        each = np.array([duration(*each) for each in zip(length, x[:-1], x[1:], own)])
        return Solved(above, top, x, own, each) if np.isfinite(each).all() else int(np.argmax(each))  # at rest there

    pinned = any(mesh.share("v", k) for k in np.flatnonzero(mesh.criterion))
    means = () if hints is None else (None, hints[2])[: 1 + mesh.crossing.any()]  # either may keep to a slow motion
    for pin in PINS[::-1] if pinned else PINS[:1]:
        good = [each for mean in means if isinstance(each := tried(1.0, hints[1], mean, pin), Solved)]
        if good:
            return min(good, key=lambda each: each.gap)
    stuck = None
    for share in PINNED_SHARES if pinned else SHARES:
        found = tried(share, np.zeros(len(mesh)))
        if isinstance(found, Solved):
            again = tried(share, _bent(found.x, length), (found.x[1:] + found.x[:-1]) / 2)
            if isinstance(again, Solved) and again.gap < found.gap:
                found = again
            return found._replace(stuck=stuck)
        stuck = found if stuck is None else stuck
    return found, 1 + (_about(length, stuck) | _about(length, found))


def _lean(mesh, rows, above):
    """By how much x_ss / 2 grows with x (n,), where Type 2 is so near that torques move u little: u = -(b / a) x."""
    if not mesh.crossing.any() or not rows.torque.any():
        return np.zeros(len(mesh))
    a, b, c = (rows.parts[name][:, np.flatnonzero(rows.torque)[::2]] for name in "abc")
    with np.errstate(all="ignore"):
        pull = b / a
        grows = 2 * pull[0] * pull[2] - (pull[2] - pull[0]) / mesh.stretches.length
    tied = (a[0] * a[2] > 0) & (np.abs(b[1]) * (above.x[1:] + above.x[:-1]) / 2 > np.abs(c[1]))
    tied &= np.abs(grows) * mesh.stretches.length**2 < STEEP
    best = np.where(tied, np.abs(a[1]), 0.0).argmax(axis=0)
    at = best, np.arange(len(mesh))
    return np.where(tied[at], grows[at], 0.0)


def _made(found, part):
    """By how much each stretch lets the bounds part (n,), s: half by the time on it, half by x against its ceiling.

    What is lost in one place shows on all stretches that follow, where nothing is lost any more.
    """
    with np.errstate(all="ignore"):
        behind = np.log(found.above.x / found.x)
    known = np.isfinite(behind)
    nodes = np.arange(len(behind))
    behind = np.interp(nodes, nodes[known], behind[known])
    grows = np.abs(np.diff(behind))
    whole = grows.sum()
    return (part + grows * (part.sum() / whole)) / 2 if whole > 0 else part


def _about(length, node):
    """The longest of the stretches near a node."""
    near = np.abs(np.arange(len(length)) - node) <= 12
    return near & (length >= 0.5 * length[near].max())


def _bent(x, length):
    """x_ss / 2 as the neighbours show it, 0 where it changes its sign: there the motion switches."""
    slope = 2 * np.diff(np.diff(x) / (2 * length)) / (length[1:] + length[:-1])
    before, after = np.append(slope[0], slope), np.append(slope, slope[-1])
    return np.where(before * after > 0, np.where(np.abs(before) < np.abs(after), before, after), 0.0)


def _directions(n, along):
    even = np.broadcast_to((np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS) - np.pi)[:, None], (DIRECTIONS, n))
    if along is None:
        return even
    near = (along + np.array(NEAR)[:, None] + np.pi) % (2 * np.pi) - np.pi
    return np.sort(np.concatenate([even, near]), axis=0)


def _along(mesh, found):
    """Direction (n,) of the end-effector's acceleration on each stretch, rad from the path's."""
    u, x = np.diff(found.x) / (2 * mesh.stretches.length), (found.x[1:] + found.x[:-1]) / 2
    g, m, k = (mesh.found[name].middle for name in "gmk")
    return np.arctan2(k * x, g * u + m * x)


def _refuse(mesh, limits, node, proved):
    raise TimingError(
        f"time_path: no motion along the path {'keeps' if proved else 'was found that keeps'} these limits near "
        f"{mesh.place(node)}{_why(mesh, limits, node)}", float(mesh.s[node]), proved,
    )  # fmt: skip


def _why(mesh, limits, node):
    """What is known of the reason."""
    if mesh.crossing.any():
        k = np.flatnonzero(mesh.crossing)
        nearest = int(k[np.abs(k - node).argmin()])
        return f"; it crosses Type 2 at {mesh.place(nearest)}, where the crossing criterion ties s'' to s'^2"
    physics = physics_of(mesh.robot)
    if limits.torque is not None and physics is not None and physics.weighs:
        tau = gravity_torques(igm(mesh.robot, mesh.path(mesh.s[node])[0], mesh.working))
        return f"; at rest there the torques are ({tau[0]:.4g}, {tau[1]:.4g}) {mesh.robot.words.effort_unit}"
    return ""
