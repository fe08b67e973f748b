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
        steps = np.array(self.clearance.shape) - 1
        high = self.low + self.step * steps
        return np.stack([self.low, high])

    @property
    def point(self) -> np.ndarray:
        """(2,) m: the node that is farthest from the boundary."""
        node = np.unravel_index(self.clearance.argmax(), self.clearance.shape)
        return self.low + self.step * np.array(node)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the clearance (*batch,), m, at points (*batch, 2)."""
        steps = (points - self.low) / self.step
        index = np.moveaxis(steps, -1, 0)
        return map_coordinates(
            self.clearance,
            index,
            order=1,
            mode="nearest",
        )


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
        size = high - low
        step = float(size.max() / NODES)
        axes = [np.arange(a, b + step, step) for a, b in zip(low, high)]
        pose = tool.pose(
            robot,
            _grid(*axes),
            mode,
            unreachable="nan",
        )
        kept = np.isfinite(pose.det_A)
        if constraints:
            for value in constraints.clearances(pose).values():
                kept &= value >= 0
        sign = np.sign(pose.det_A)
        for assembly in (-1, 1):
            here = kept & (sign == -assembly)
            for clearance, area in _connected(here, step):
                region = ToolRegion(
                    0,
                    mounted,
                    assembly,
                    area,
                    low,
                    step,
                    clearance,
                )
                found.append(region)
    found.sort(key=lambda region: -region.area)
    return [replace(region, number=k) for k, region in enumerate(found, 1)]


def _grid(x, y):
    """Return the points (nx, ny, 2) of a grid."""
    return np.stack(
        np.meshgrid(x, y, indexing="ij"),
        axis=-1,
    )


def _connected(here, step):
    """Yield the clearance, m, on the grid and the area, m^2, of each connected part."""
    parts, count = label(here)
    for part in range(1, count + 1):
        inside = parts == part
        nodes = int(inside.sum())
        if nodes < LEAST:
            continue
        depth = distance_transform_edt(inside)
        depth = depth - distance_transform_edt(~inside)
        clearance = (depth - DIAGONAL) * step
        yield clearance, nodes * step**2


def _box(mounted):
    """Return two corners (2,) m of a box around all that the tool reaches, with a margin."""
    robot = mounted.robot
    leg = mounted.tool.leg - 1
    offset = np.hypot(mounted.tool.along, mounted.tool.across)
    drives = robot.drives
    ways = [drive.length + bar + offset for drive, bar in zip(drives, robot.distal)]
    ways[leg] = drives[leg].length + mounted.reach
    left = max(drive.x - way for drive, way in zip(drives, ways))
    right = min(drive.x + way for drive, way in zip(drives, ways))
    top = min(ways)
    margin = 0.01 * top
    return (
        np.array([left - margin, -top - margin]),
        np.array([right + margin, top + margin]),
    )


def largest_upright(
    region: ToolRegion,
    size: np.ndarray,
    margin: float,
) -> tuple[float, np.ndarray]:
    """Return the largest scale at which a box of this size (2,) is in a region, and its middle."""
    free = region.clearance >= margin
    sums = np.cumsum(~free, axis=0)
    sums = np.cumsum(sums, axis=1)
    sums = np.pad(sums, ((1, 0), (1, 0)))

    def corners(scale):
        """Return the first corners (n, 2), as indices, of boxes that are free, and their sides."""
        steps = np.ceil(scale * size / region.step)
        sides = steps.astype(int) + 1
        if (sides >= free.shape).any():
            return np.empty((0, 2), int), sides
        w, h = sides
        taken = sums[w:, h:] - sums[:-w, h:] - sums[w:, :-h] + sums[:-w, :-h]
        return np.argwhere(taken == 0), sides

    low = 0.0
    high = float(np.max(np.array(free.shape) * region.step / size))
    for _ in range(40):
        middle = (low + high) / 2
        found, _ = corners(middle)
        if len(found):
            low = middle
        else:
            high = middle
    found, sides = corners(low)
    if not len(found):
        return 0.0, region.low
    middles = region.low + (found + (sides - 1) / 2) * region.step
    best = region.at(middles).argmax()
    return low, middles[best]


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
    regions = tool_regions(
        tool,
        robot,
        working,
        replace(constraints, clearance=0.0),
    )
    samples = np.linspace(0.0, path.length, SAMPLES)
    s = np.unique(np.concatenate([path.knots, samples]))
    points = path(s)[0]
    low = points.min(axis=0)
    high = points.max(axis=0)
    middle = (low + high) / 2
    about = points - middle
    chosen = np.linspace(0, len(about) - 1, FEW)
    few = about[chosen.astype(int)]
    turns = 2 * np.pi * np.arange(TURNS) / TURNS
    if turn is not None:
        turns = np.array([turn])

    def improved(wanted):
        starts: list[_Lie] = []
        for region in regions:
            starts += _coarse(
                region,
                few,
                turns,
                wanted,
            )
        starts.sort(key=lambda lie: -lie.clearance)
        lies = [_improved(lie, about, turn is None) for lie in starts[:BEST]]
        return max(
            lies,
            key=lambda lie: lie.clearance,
            default=None,
        )

    if scale is not None:
        best = improved(scale)
        if best is not None and best.clearance >= margin:
            return (*_placement(best, about, middle), None)
    smallest = 0.0
    room = max(_extent(region.grid) for region in regions)
    largest = room / _extent(about)
    best = None
    for _ in range(HALVINGS):
        wanted = (smallest + largest) / 2
        tried = improved(wanted)
        if tried is not None and tried.clearance >= margin:
            smallest = tried.scale
            best = tried
        else:
            largest = wanted
    if scale is not None or best is None:
        at_scale = "" if scale is None else f" at scale {scale:g}"
        raise ValueError(
            f"place: the path does not fit{at_scale} with a clearance of {margin:g} m for the tool;"
            f" the largest scale found to fit is {smallest:.4g}"
        )
    return (*_placement(best, about, middle), best.scale)


def _extent(points):
    """Return the longer side, m, of the box around points (n, 2)."""
    sides = np.ptp(points, axis=0)
    return float(sides.max())


def _coarse(region, few, turns, scale):
    """Return the best place on a grid of shifts for each turn."""
    x, y = np.linspace(*region.grid, SHIFTS).T
    centres = _grid(x, y).reshape(-1, 1, 2)
    found = []
    for angle in turns.tolist():
        points = centres + scale * _turned(few, angle)
        clearance = region.at(points).min(axis=1)
        at = int(clearance.argmax())
        lie = _Lie(
            float(clearance[at]),
            region,
            centres[at, 0],
            angle,
            scale,
        )
        found.append(lie)
    return found


def _improved(lie, about, free):
    """Return a place with a clearance that small changes do not make larger."""

    def lacks(values):
        angle = values[2] if free else lie.turn
        points = values[:2] + lie.scale * _turned(about, angle)
        clearance = lie.region.at(points)
        return -float(clearance.min())

    step = lie.region.step
    start = np.array([*lie.middle] + [lie.turn] * free)
    changes = np.diag([20 * step] * 2 + [0.2] * free)
    simplex = np.vstack([np.zeros(len(start)), changes])
    options = {
        "initial_simplex": start + simplex,
        "xatol": 1e-3 * step,
        "fatol": 1e-12,
    }
    found = minimize(
        lacks,
        start,
        method="Nelder-Mead",
        options=options,
    )
    angle = float(found.x[2]) if free else lie.turn
    return replace(
        lie,
        clearance=-float(found.fun),
        middle=found.x[:2],
        turn=angle,
    )


def _turned(points, angle):
    c = np.cos(angle)
    s = np.sin(angle)
    rows = [
        [c, s],
        [-s, c],
    ]
    return points @ np.array(rows)


def _placement(lie, about, middle):
    points = lie.middle + lie.scale * _turned(about, lie.turn)
    nearest = points[lie.region.at(points).argmin()]
    shift = lie.middle - lie.scale * _turned(middle, lie.turn)
    turn = math.remainder(lie.turn, 2 * math.pi)
    placement = Placement(
        tuple(shift.tolist()),
        turn,
        lie.scale,
    )
    return (
        placement,
        lie.region,
        lie.clearance,
        nearest,
    )
