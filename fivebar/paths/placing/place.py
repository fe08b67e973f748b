"""Place a path or a page as far from singularities as it can be: shifted, turned and scaled.

An aspect's exact boundary, and what else must be kept, make the test: a path that starts inside and
is nowhere nearer to a boundary than its clearance is inside all along.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import flag, instance, modes, number, optional, positive, two_numbers
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...constraints.constraints import Constraints, kept_by
from ...constraints.disc import bounded_by
from ...models.robots import FiveBar
from ...singularities.aspects import Aspect
from ...singularities.dexterous import dexterous
from ..curve import Path
from ..placement import Placement
from ..reading.read import path as path_of
from ..strokes import cut
from ..tool import Tool
from .clearance import Clearance
from .search import Search
from .tool_regions import tool_regions


@dataclass(frozen=True, eq=False)
class Placed:
    """A placed path, from `place`.

    Attributes
    ----------
    path : Path
        In its place; of a page its outline.
    placement : Placement
    aspect : Aspect, DexterousRegion or ToolRegion
        Where it lies; of strokes with modes of their own, where the first lies.
    clearance : float
        Distance, m, from the nearest boundary.
    nearest : (2,)
        The point of the path where that is, m.
    largest : float or None
        Largest scale found at which the path fits, if it was asked for.
    strokes : tuple of (Path, Aspect)
        Each part that has modes of its own.
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


@takes_robot(
    path=optional(instance(Path)),
    constraints=kept_by("fb.place"),
    working=optional(modes(2)),
    strokes=flag,
    tool=optional(instance(Tool)),
)
def place(
    robot: FiveBar,
    path: Path | None = None,
    *,
    page: ArrayLike | None = None,
    working: ArrayLike | None = None,
    turn: float | None = None,
    scale: float | None = 1.0,
    constraints: Constraints | None = None,
    strokes: bool = False,
    tool: Tool | None = None,
) -> Placed:
    """Return a path placed with the largest clearance from singularities and other constraints.

    The clearance is exact, to 1e-9 of the path's length: a distance from exact boundaries. That no
    other placement has more is the result of a search, from places and turns on a grid.

    Parameters
    ----------
    robot : FiveBar or Machine
        Of a Machine, or of the name or file of one, tool and constraints hold; the placement is in
        the robot's own frame.
    path : Path, optional
        A path that passes Type 2 with the pen down has no clearance there: place it by hand.
    page : (2,), optional
        Width and height, m, of a sheet of paper, in place of a path. All of the sheet keeps the
        clearance, not only its outline. `Placed.placement` takes its lower left corner, (0, 0), and
        all that is drawn on it, to their places.
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
        Then the path is the tool's, and `Placed.path` that of joint C which leads it, if one pair
        of working modes serves all of it. The clearance is that of the tool, from the exact
        boundaries that it sees; half-planes and the region of the constraints are those of joint C.

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
    >>> sheet = fb.place(fb.FiveBar(), page=(0.06, 0.04))
    >>> sheet.clearance > 0.05
    True
    """
    constraints = Constraints() if constraints is None else constraints
    margin = constraints.clearance
    if page is not None and path is None:
        width, height = two_numbers(page, "place: page")
        page = positive(width, "place: page's width"), positive(height, "place: page's height")
        path = path_of([(0, 0), (width, 0), (width, height), (0, height), (0, 0)])
    elif page is not None or path is None:
        raise ValueError("place: give either a path or a page=(width, height) in metres")
    turn = None if turn is None else number(turn, "turn", -1e6, 1e6)
    scale = None if scale is None else number(scale, "scale", 1e-9, 1e9)
    tool = path.tool.tool if tool is None and path.tool else tool
    path = path.drawn
    regions = map(Clearance, _regions(robot, tool, working, constraints))
    clearances = [clearance for clearance in regions if clearance.most > margin]
    if not clearances:
        raise ValueError(
            f"place: nothing of the workspace{' in these modes' * (working is not None)} keeps the"
            " clearance"
        )
    search = Search(cut(path) if strokes else [path], clearances, turn, margin, page)
    choices = (False, True)[: len(search.paths)]  # whether strokes lie in regions of their own
    best = None
    if scale is not None:
        for mixed in choices:
            best = best or search.best(search.starts(scale, mixed))
    if best is None:
        found = [each for each in map(search.largest, choices) if each]
        if not found:
            raise ValueError(
                "place: nothing larger than a point was found to keep a margin of"
                f" {search.margin:g} m"
            )
        best = max(found, key=lambda each: each.scale)
        if scale:
            grown = best
            best = search.best([grown._replace(scale=scale)]) if grown.scale >= scale else None
            if best is None:
                what = "path" if page is None else "page"
                raise ValueError(
                    f"place: the {what} does not fit at scale {scale:g} with a clearance of"
                    f" {margin:g} m: the largest scale found to fit is {grown.scale:.6g}"
                    f"{_hint(path, strokes)}"
                )
    best = search.settled(best)
    parts = [clearances[k].part for k in best.which]
    placement = best.placement(search.middle)
    clearance, at = search.exactly(best)

    def led(placed: Path, part: Aspect) -> Path:
        return placed if tool is None else tool.path(robot, placed, part.working)

    own = tuple((led(placement(each), part), part) for each, part in zip(search.paths, parts))
    whole = placement(path)
    return Placed(
        led(whole, parts[0]) if len({part.working for part in parts}) == 1 else whole,
        placement,
        parts[0],
        clearance,
        np.array([at.real, at.imag]),
        best.scale if scale is None else None,
        own,
    )


def _regions(robot, tool, working, constraints):
    """Return the regions in which the constraints on poses hold, of joint C or of a tool."""
    if tool is not None:
        return tool_regions(tool, robot, working, replace(constraints, clearance=0.0))
    bounds = replace(constraints, det_A=0.0, sin=0.0)  # the borders of the regions keep these
    regions = dexterous(robot, constraints.det_A, constraints.sin)
    return [bounded_by(part, bounds) for part in regions if working in (None, part.working)]


def _hint(path, strokes):
    if strokes or len(cut(path)) == 1:
        return ""
    return ", in one aspect; strokes=True gives each stroke modes of its own"
