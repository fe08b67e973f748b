"""Where a path lies best: shifted, turned and scaled into an aspect, as far from its singularities
as it can be.

An aspect's exact boundary, and what else must be kept, make the test: a path that starts inside and
is nowhere nearer to a boundary than its clearance is inside all along.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import flag, instance, modes, number, optional, takes
from ...base.representation import one_line
from ...constraints.constraints import (
    OF_END_EFFECTOR,
    ON_POSES,
    PER_JOINT,
    Constraints,
    refuse_others,
)
from ...constraints.disc import bounded_by
from ...models.robots import Biglide, FiveBar
from ...singularities.aspects import Aspect
from ...singularities.dexterous import dexterous
from ..curve import Path
from ..placement import Placement
from ..strokes import cut
from ..timing.time_path import time_path
from .clearance import Clearance
from .search import Search

FASTEST = 3  # placements that are timed


@dataclass(frozen=True, eq=False)
class Placed:
    """A path in its place, from `place`.

    path: placed; placement; working, aspect: the modes and the aspect, or dexterous region, in
    which it lies, of strokes with modes of their own those of the first; clearance: m, its distance
    from the nearest boundary of what it may be in; nearest (2,) m: the point of the path where that
    is; scale: of the placement; largest: with which scale it would fit at most, None where that was
    not asked for; strokes: (Path, Aspect) of each part that has modes of its own, of a path in one
    aspect the whole.
    """

    path: Path = field(repr=False)
    placement: Placement
    aspect: Aspect
    clearance: float
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
            "Placed",
            repr(self.placement),
            modes,
            where,
            f"{self.clearance:.6g} m from its boundary",
        )


@takes(
    robot=instance(FiveBar, Biglide),
    path=instance(Path),
    constraints=optional(instance(Constraints)),
    working=optional(modes(2)),
    fastest=flag,
    strokes=flag,
)
def place(
    robot: FiveBar,
    path: Path,
    *,
    working: ArrayLike | None = None,
    turn: float | None = None,
    scale: float | None = 1.0,
    constraints: Constraints | None = None,
    fastest: bool = False,
    strokes: bool = False,
) -> Placed:
    """Return a path placed with the largest clearance from singularities and other constraints.

    The clearance is exact, to 1e-9 of its length: a distance from exact boundaries. That no other
    placement has a larger one is the result of a search from a grid of shifts and turns, not a
    proof.

    Parameters
    ----------
    robot : FiveBar
    path : Path
        A path that passes Type 2 with the pen down has no clearance there: place it by hand.
    working : (2,), optional
        Working modes; by default those of the largest clearance.
    turn : float, optional
        Angle, rad; free by default.
    scale : float, optional
        None: as large as it fits with the clearance of the constraints.
    constraints : Constraints, optional
        Constraints on poses, and the least clearance, m, of the whole path. det_A and sin replace
        aspects by dexterous regions. Limits on torques and rates count with `fastest`.
    fastest : bool
        Of the placements of largest clearance in at most 3 aspects, return the one in which
        `time_path` with these constraints takes the least time.
    strokes : bool
        Each stroke may lie in an aspect of its own, if no aspect holds all of them;
        `Placed.strokes` lists them. The ways with the pen up are then not placed: `plan` finds one
        from the end of a stroke to the start of the next.

    Returns
    -------
    Placed

    Raises
    ------
    ValueError
        The path does not fit; the message has the largest scale that does.

    Examples
    --------
    >>> import fivebar as fb
    >>> path = fb.path([(0, 0), (0.03, 0), (0.03, 0.02), (0, 0)])
    >>> placed = fb.place(fb.FiveBar(), path, turn=0.0)
    >>> placed.clearance > 0.05
    True
    """
    rates = (*PER_JOINT, *OF_END_EFFECTOR) if fastest else ()
    refuse_others(constraints, "place", (*ON_POSES, "clearance", *rates))
    constraints = Constraints() if constraints is None else constraints
    margin = constraints.clearance
    if not robot.turns:
        raise ValueError(
            "place: a biglide's aspects are strips without ends: place a path by hand between its"
            " loci"
        )
    if turn is None:
        turn = None
    else:
        turn = number(turn, "turn", -1e6, 1e6)
    scale = None if scale is None else number(scale, "scale", 1e-9, 1e9)
    regions = dexterous(robot, constraints.det_A, constraints.sin)
    bounds = replace(constraints, det_A=0.0, sin=0.0)  # the borders of the regions keep these
    clearances = []
    for part in regions:
        if working in (None, part.working):
            clearance = Clearance(bounded_by(part, bounds))
            clearances += [clearance] if clearance.most > margin else []
    if not clearances:
        raise ValueError(
            f"place: nothing of the workspace{' in these modes' * (working is not None)} keeps the"
            " clearance"
        )
    search = Search(
        cut(path) if strokes else [path],
        clearances,
        turn,
        margin,
    )
    best = None
    largest = None
    if scale:
        fits = search.fits(scale, FASTEST if fastest else 1)
        if fits and fastest:
            limits = {name: getattr(constraints, name) for name in rates}
            best = _fastest(robot, search, fits, Constraints(**limits))
        else:
            best = next(iter(fits), None)
    if best is None:
        best = search.largest()
        largest = best.scale
        if scale:
            raise ValueError(
                f"place: the path does not fit at scale {scale:g} with a clearance of {margin:g} m;"
                f" the largest scale found to fit is {largest:.6g}{_hint(path, strokes)}"
            )
    best = search.settled(best)
    parts = [clearances[k].part for k in best.which]
    placement = best.placement(search.middle)
    clearance, at = search.exactly(best)
    own = tuple((placement(each), part) for each, part in zip(search.paths, parts))
    return Placed(
        placement(path),
        placement,
        parts[0],
        clearance,
        np.array([at.real, at.imag]),
        largest,
        own,
    )


def _hint(path, strokes):
    if strokes or len(cut(path)) == 1:
        return ""
    return ", in one aspect; strokes=True gives each stroke modes of its own"


def _fastest(robot, search, fits, limits):
    """Return the placement of least time with the pen down, among the best of each aspect."""

    def duration(fit):
        placement = fit.placement(search.middle)
        total = 0.0
        for path, k in zip(search.paths, fit.which):
            working = search.clearances[k].part.working
            total += time_path(robot, placement(path), constraints=limits, working=working).duration
        return total

    return min(fits, key=duration)
