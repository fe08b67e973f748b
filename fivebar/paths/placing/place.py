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
from ...constraints.constraints import ON_POSES, Constraints, refuse_others
from ...constraints.disc import bounded_by
from ...models.robots import Biglide, FiveBar
from ...singularities.aspects import Aspect
from ...singularities.dexterous import dexterous
from ..curve import Path
from ..placement import Placement
from ..strokes import cut
from ..tool import Tool
from .clearance import Clearance
from .search import Search
from .with_tool import ToolRegion, placed_with_tool


@dataclass(frozen=True, eq=False)
class Placed:
    """A placed path, from `place`.

    Attributes
    ----------
    path : Path
        In its place.
    placement : Placement
    aspect : Aspect, DexterousRegion or ToolRegion
        Where it lies; of strokes with modes of their own, where the first lies.
    clearance : float
        Distance, m, from the nearest boundary.
    nearest : (2,)
        The point of the path where that is, m.
    largest : float or None
        Largest scale at which the path fits, if it was asked for.
    strokes : tuple of (Path, Aspect)
        Each part that has modes of its own.
    """

    path: Path = field(repr=False)
    placement: Placement
    aspect: Aspect | ToolRegion
    clearance: float
    nearest: np.ndarray
    largest: float | None = None
    strokes: tuple[tuple[Path, Aspect | ToolRegion], ...] = ()

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
    strokes=flag,
    tool=optional(instance(Tool)),
)
def place(
    robot: FiveBar,
    path: Path,
    *,
    working: ArrayLike | None = None,
    turn: float | None = None,
    scale: float | None = 1.0,
    constraints: Constraints | None = None,
    strokes: bool = False,
    tool: Tool | None = None,
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
        aspects by dexterous regions.
    strokes : bool
        Each stroke may lie in an aspect of its own, if no aspect holds all of them;
        `Placed.strokes` lists them. The ways with the pen up are then not placed: `plan` finds one
        from the end of a stroke to the start of the next.
    tool : Tool, optional
        Then the path is the tool's, and `Placed.path` that of joint C which leads it. The clearance
        is that of the tool in the aspects it sees, known to a step of a grid.

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
    refuse_others(constraints, "place", (*ON_POSES, "clearance"))
    constraints = Constraints() if constraints is None else constraints
    margin = constraints.clearance
    if not robot.turns:
        raise ValueError(
            "place: a biglide's aspects are strips without ends: place a path by hand between its"
            " loci"
        )
    turn = None if turn is None else number(turn, "turn", -1e6, 1e6)
    scale = None if scale is None else number(scale, "scale", 1e-9, 1e9)
    tool = path.tool.tool if tool is None and path.tool else tool
    if tool is not None:
        if strokes:
            raise ValueError("place: strokes=True and a tool do not go together")
        return _placed_with(tool, robot, path.drawn, working, turn, scale, constraints)
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
        best = search.fit(scale)
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


def _placed_with(tool, robot, path, working, turn, scale, constraints):
    placement, region, clearance, nearest, largest = placed_with_tool(
        tool, robot, path, working, turn, scale, constraints
    )
    led = tool.path(robot, placement(path), region.working)
    return Placed(led, placement, region, clearance, nearest, largest, ((led, region),))


def _hint(path, strokes):
    if strokes or len(cut(path)) == 1:
        return ""
    return ", in one aspect; strokes=True gives each stroke modes of its own"
