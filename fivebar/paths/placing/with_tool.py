"""Where a drawing fits for a tool beside the joint: on a grid of the places of the tool.

The aspects that the tool sees are the images of the robot's. They are found on a grid, so that a
clearance is known to a step of it; whether the placed path is free of singularities, `check_path`
then says exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.ndimage import distance_transform_edt, label, map_coordinates
from scipy.optimize import minimize

from ...base.representation import one_line
from ...constraints.constraints import ON_POSES, Constraints, refuse_others
from ...models.robots import FiveBar
from ..curve import Path
from ..placement import Placement
from ..tool import MountedTool, Tool

NODES = 480  # on the longer side of the grid
LEAST = 40  # cells: a smaller region is the rounding of the grid
DIAGONAL = 2**0.5  # of a cell: by so much a boundary may be nearer than its first node
SAMPLES = 160  # of a path that is placed
FEW = 24  # of them, with which the search begins
SHIFTS = 16  # a side, tried for each turn
TURNS = 12
BEST = 4  # of these, from which the search goes on
HALVINGS = 12  # of the way to the largest scale


@dataclass(frozen=True, eq=False)
class ToolRegion:
    """A part of the plane in which the tool moves without a singularity, on a grid.

    Attributes
    ----------
    number : int
        From 1, by area.
    tool, robot, working
        Of the path that is led there.
    assembly : int
    area : float
        m^2.
    low : (2,)
        First node of the grid, m.
    step : float
        Of the grid, m.
    clearance : (nx, ny)
        Distance of each node from the region's boundary, m, less a step; below 0 outside.
    """

    number: int
    mounted: MountedTool
    assembly: int
    area: float
    low: np.ndarray
    step: float
    clearance: np.ndarray

    @property
    def working(self) -> tuple[int, int]:
        return self.mounted.working

    def __repr__(self) -> str:
        modes_ = "working ({:+d}, {:+d}), assembly {:+d}".format(*self.working, self.assembly)
        return one_line("ToolRegion", f"{self.number}", modes_, f"{self.area:.6g} m²")

    @property
    def grid(self) -> np.ndarray:
        """Its first and last node (2, 2), m."""
        return np.stack([self.low, self.low + self.step * (np.array(self.clearance.shape) - 1)])

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the clearance (*batch,), m, at points (*batch, 2)."""
        index = np.moveaxis((points - self.low) / self.step, -1, 0)
        return map_coordinates(self.clearance, index, order=1, mode="nearest")


def tool_regions(
    tool: Tool,
    robot: FiveBar,
    working: tuple[int, int] | None = None,
    constraints: Constraints | None = None,
) -> list[ToolRegion]:
    """Return the regions of a tool, the largest first: as `aspects` are those of joint C."""
    refuse_others(constraints, "tool_regions", ON_POSES)
    signs = [working] if working else list(product((-1, 1), (-1, 1)))
    found = []
    for mode in signs:
        mounted = MountedTool(tool, robot, mode)
        low, high = _box(mounted)
        step = float((high - low).max() / NODES)
        x, y = (np.arange(a, b + step, step) for a, b in zip(low, high))
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        pose = tool.pose(robot, points, mode, unreachable="nan")
        kept = np.isfinite(pose.det_A)
        if constraints:
            for value in constraints.clearances(pose).values():
                kept &= value >= 0
        for assembly in (-1, 1):
            here = kept & (np.sign(pose.det_A) == -assembly)
            for clearance, area in _connected(here, step):
                region = ToolRegion(0, mounted, assembly, area, low, step, clearance)
                found.append(region)
    found.sort(key=lambda region: -region.area)
    return [replace(region, number=k) for k, region in enumerate(found, 1)]


def _connected(here, step):
    """Yield the clearance, m, on the grid and the area, m^2, of each connected part."""
    parts, count = label(here)
    for part in range(1, count + 1):
        inside = parts == part
        nodes = int(inside.sum())
        if nodes < LEAST:
            continue
        depth = distance_transform_edt(inside) - distance_transform_edt(~inside)
        yield (depth - DIAGONAL) * step, nodes * step**2


def _box(mounted):
    """Return two corners (2,) m of a box around all that the tool reaches, with a margin."""
    robot = mounted.robot
    leg = mounted.tool.leg - 1
    offset = np.hypot(mounted.tool.along, mounted.tool.across)
    ways = [drive.length + bar + offset for drive, bar in zip(robot.drives, robot.distal)]
    ways[leg] = robot.drives[leg].length + mounted.reach
    low = max(drive.x - way for drive, way in zip(robot.drives, ways))
    high = min(drive.x + way for drive, way in zip(robot.drives, ways))
    margin = 0.01 * min(ways)
    return (
        np.array([low - margin, -min(ways) - margin]),
        np.array([high + margin, min(ways) + margin]),
    )


def largest_upright(
    region: ToolRegion, size: np.ndarray, margin: float
) -> tuple[float, np.ndarray]:
    """Return the largest scale at which a box of this size (2,) is in a region, and its middle."""
    free = region.clearance >= margin
    sums = np.pad(np.cumsum(np.cumsum(~free, axis=0), axis=1), ((1, 0), (1, 0)))

    def corners(scale):
        """Return the first corners (n, 2), as indices, of boxes that are free, and their sides."""
        w, h = np.ceil(scale * size / region.step).astype(int) + 1
        if w >= len(free) or h >= free.shape[1]:
            return np.empty((0, 2), int), (w, h)
        taken = sums[w:, h:] - sums[:-w, h:] - sums[w:, :-h] + sums[:-w, :-h]
        return np.argwhere(taken == 0), (w, h)

    low, high = 0.0, float(np.max(np.array(free.shape) * region.step / size))
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if len(corners(middle)[0]) else (low, middle)
    found, sides = corners(low)
    if not len(found):
        return 0.0, region.low
    middles = region.low + (found + (np.array(sides) - 1) / 2) * region.step
    return low, middles[region.at(middles).argmax()]


@dataclass(frozen=True)
class _Lie:
    """Where a drawing lies: clearance, m, region, its middle (2,) m, turn and scale."""

    clearance: float
    region: ToolRegion
    middle: np.ndarray
    turn: float
    scale: float


def placed_with_tool(
    tool: Tool,
    robot: FiveBar,
    path: Path,
    working: tuple[int, int] | None,
    turn: float | None,
    scale: float | None,
    constraints: Constraints,
) -> tuple[Placement, ToolRegion, float, np.ndarray, float | None]:
    """Return (placement, region, clearance, nearest point, largest scale or None): of `place`."""
    margin = constraints.clearance
    regions = tool_regions(tool, robot, working, replace(constraints, clearance=0.0))
    s = np.unique(np.concatenate([path.knots, np.linspace(0.0, path.length, SAMPLES)]))
    points = path(s)[0]
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    about = points - middle
    few = about[np.linspace(0, len(about) - 1, FEW).astype(int)]
    turns = np.array([turn]) if turn is not None else 2 * np.pi * np.arange(TURNS) / TURNS

    def improved(wanted):
        starts: list[_Lie] = []
        for region in regions:
            starts += _coarse(region, few, turns, wanted)
        starts.sort(key=lambda lie: -lie.clearance)
        lies = [_improved(lie, about, turn is None) for lie in starts[:BEST]]
        return max(lies, key=lambda lie: lie.clearance, default=None)

    if scale is not None:
        best = improved(scale)
        if best is not None and best.clearance >= margin:
            return (*_placement(best, about, middle), None)
    low, high = 0.0, max(float(np.ptp(region.grid, axis=0).max()) for region in regions)
    high /= float(np.ptp(about, axis=0).max())
    best = None
    for _ in range(HALVINGS):
        tried = improved((low + high) / 2)
        if tried is not None and tried.clearance >= margin:
            low, best = tried.scale, tried
        else:
            high = (low + high) / 2
    if scale is not None or best is None:
        raise ValueError(
            f"place: the path does not fit{'' if scale is None else f' at scale {scale:g}'} with a"
            f" clearance of {margin:g} m for the tool; the largest scale found to fit is {low:.4g}"
        )
    return (*_placement(best, about, middle), best.scale)


def _coarse(region, few, turns, scale):
    """Return the best place on a grid of shifts for each turn."""
    low, high = region.grid
    x, y = (np.linspace(a, b, SHIFTS) for a, b in zip(low, high))
    centres = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    found = []
    for angle in turns.tolist():
        clearance = region.at(centres + scale * _turned(few, angle)).min(axis=1)
        at = int(clearance.argmax())
        found.append(_Lie(float(clearance[at]), region, centres[at, 0], angle, scale))
    return found


def _improved(lie, about, free):
    """Return a place with a clearance that small changes do not make larger."""

    def lacks(values):
        points = values[:2] + lie.scale * _turned(about, values[2] if free else lie.turn)
        return -float(lie.region.at(points).min())

    start = np.array([*lie.middle, lie.turn][: 3 if free else 2])
    spread = np.vstack([np.zeros(len(start)), np.diag([20 * lie.region.step] * 2 + [0.2] * free)])
    options = {"initial_simplex": start + spread, "xatol": 1e-3 * lie.region.step, "fatol": 1e-12}
    found = minimize(lacks, start, method="Nelder-Mead", options=options)
    angle = float(found.x[2]) if free else lie.turn
    return replace(lie, clearance=-float(found.fun), middle=found.x[:2], turn=angle)


def _turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _placement(lie, about, middle):
    points = lie.middle + lie.scale * _turned(about, lie.turn)
    nearest = points[lie.region.at(points).argmin()]
    shift = lie.middle - lie.scale * _turned(middle, lie.turn)
    turn = math.remainder(lie.turn, 2 * math.pi)
    placement = Placement((float(shift[0]), float(shift[1])), turn, lie.scale)
    return placement, lie.region, lie.clearance, nearest
