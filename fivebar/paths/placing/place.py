"""Where a path lies best: shifted, turned and scaled into an aspect, as far from its singularities
as it can be.

An aspect's exact boundary, and what else must be kept, make the test: a path that starts inside and
is nowhere nearer to a boundary than its room is inside all along.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import flag, instance, modes, not_negative, number, optional, shown, takes
from ...base.representation import one_line
from ...constraints.constraints import Keep
from ...constraints.disc import walled
from ...models.robots import Biglide, FiveBar
from ...singularities.aspects import Aspect
from ...singularities.dexterous import dexterous
from ..curve import Path
from ..placement import Placement
from ..strokes import cut
from ..timing.time_path import time_path
from .clearance import Room
from .search import Search

FASTEST = 3  # placements that are timed


@dataclass(frozen=True, eq=False)
class Placed:
    """A path in its place, from `place`.

    path: placed; placement; working, aspect: the modes and the aspect, or dexterous region, in
    which it lies, of strokes with modes of their own those of the first; room: m, its distance from
    the nearest boundary of what it may be in; nearest (2,) m: the point of the path where that is;
    scale: of the placement; largest: with which scale it would fit at most, None where that was not
    asked for; strokes: (Path, Aspect) of each part that has modes of its own, of a path in one
    aspect the whole.
    """

    path: Path = field(repr=False)
    placement: Placement
    aspect: Aspect
    room: float
    nearest: np.ndarray
    largest: float | None = None
    strokes: tuple[tuple[Path, Aspect], ...] = ()

    @property
    def working(self) -> tuple[int, int]:
        return self.aspect.working

    @property
    def scale(self) -> float:
        return self.placement.scale

    def __repr__(self) -> str:
        parts = dict.fromkeys(part for _, part in self.strokes or [(self.path, self.aspect)])
        modes = "working " + ", ".join(
            dict.fromkeys("({:+d}, {:+d})".format(*part.working) for part in parts)
        )
        name = "region" if getattr(self.aspect, "det_A", 0) else "aspect"
        where = f"{name}{'s' * (len(parts) > 1)} {', '.join(str(part.number) for part in parts)}"
        return one_line(
            "Placed", repr(self.placement), modes, where, f"{self.room:.6g} m from its boundary"
        )


@takes(
    robot=instance(FiveBar, Biglide),
    path=instance(Path),
    keep=optional(instance(Keep)),
    margin=not_negative,
    working=optional(modes(2)),
    strokes=flag,
)
def place(
    robot: FiveBar,
    path: Path,
    *,
    working: ArrayLike | None = None,
    turn: float | None = None,
    scale: float | None = 1.0,
    margin: float = 0.0,
    keep: Keep | None = None,
    fastest: Mapping | None = None,
    strokes: bool = False,
) -> Placed:
    """Put a path where it can be followed with the largest room to singularities and to what must
    be kept: Placed.

    working: the modes to use, None: those that give most room. turn: rad, None: free. scale: None:
    as large as it fits with the margin. margin: m, least room of the whole path. keep: what else
    must be kept; its least det A and sine take dexterous regions in the place of aspects.
    fastest: limits as `time_path` takes them, {"torque_limit": ...}; of the roomiest place in each
    aspect, of at most FASTEST of them, the one in which the path takes least time.
    strokes: whether each stroke may have an aspect of its own, where no one aspect holds all of
    them: a sequence of modes with few changes, in Placed.strokes. The ways with the pen up are then
    no part of what is placed; from the end of a stroke to the next in other modes `plan` finds one,
    from `igm` of the end in the modes that it has to `igm` of the start in those of the next,
    through the singularities between. A stroke stays in one aspect. What passes Type 2 with the pen
    down has no room there: put it by hand, `time_path` says whether it can pass.
    Its room is exact, to 1e-9 of its length: distances from the exact boundaries. That no placement
    has more room is the result of a search from a grid of shifts and turns, not a proof.
    ValueError where it does not fit, with the largest scale that does.
    """
    if not robot.turns:
        raise ValueError(
            "place: a biglide's aspects are strips without ends: place a path by hand between its"
            " loci"
        )
    turn = None if turn is None else number(turn, "turn", -1e6, 1e6)
    scale = None if scale is None else number(scale, "scale", 1e-9, 1e9)
    if not (fastest is None or isinstance(fastest, Mapping)):
        raise TypeError(
            f"fastest must be a mapping of limits, as time_path takes them, not {shown(fastest)}"
        )
    known = [
        name
        for name in inspect.signature(time_path).parameters
        if name not in ("robot", "path", "working")
    ]
    if unknown := [name for name in fastest or () if name not in known]:
        raise ValueError(
            f"fastest: time_path has no limit {shown(unknown[0])}; it takes {', '.join(known)}"
        )
    det_A, sin = (keep.det_A, keep.sin) if keep else (0.0, 0.0)
    regions = [part for part in dexterous(robot, det_A, sin) if working in (None, part.working)]
    rooms = [each for part in regions if (each := Room(walled(part, _rest(keep)))).most > margin]
    if not rooms:
        raise ValueError(
            f"place: nothing of the workspace{' in these modes' * (working is not None)} keeps the"
            " margin"
        )
    search = Search(cut(path) if strokes else [path], rooms, turn, margin)
    best, largest = None, None
    if scale:
        fits = search.fits(scale, FASTEST if fastest else 1)
        best = (
            _fastest(robot, search, fits, fastest) if fits and fastest else next(iter(fits), None)
        )
    if best is None:
        best = search.largest()
        largest = best.scale
        if scale:
            raise ValueError(
                f"place: the path does not fit at scale {scale:g} with a margin of {margin:g} m;"
                f" the largest scale found to fit is {largest:.6g}{_hint(path, strokes)}"
            )
    best = search.settled(best)
    parts = [rooms[k].part for k in best.which]
    placement = best.placement(search.middle)
    room, at = search.exactly(best)
    own = tuple((placement(each), part) for each, part in zip(search.paths, parts))
    return Placed(
        placement(path), placement, parts[0], room, np.array([at.real, at.imag]), largest, own
    )


def _hint(path, strokes):
    return (
        ""
        if strokes or len(cut(path)) == 1
        else ", in one aspect; strokes=True gives each stroke modes of its own"
    )


def _fastest(robot, search, fits, limits):
    """Of placements, the best of each aspect, the one that takes least time with the pen down."""

    def duration(found):
        placement = found.placement(search.middle)
        return sum(
            time_path(
                robot, placement(path), working=search.rooms[k].part.working, **limits
            ).duration
            for path, k in zip(search.paths, found.which)
        )

    return min(fits, key=duration)


def _rest(keep):
    """What is left to keep in dexterous regions."""
    return (
        None if keep is None else Keep(keep.joints, keep.half_planes, keep.region, bars=keep.bars)
    )
