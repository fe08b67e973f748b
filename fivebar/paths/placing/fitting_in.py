"""Where a drawing fits into the aspects, by their largest rectangles: a simple answer, and a safe
one.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ...constraints.constraints import Constraints
from ...constraints.link_collisions import segment_distance
from ...constraints.rectangle import Rectangle, largest_rectangle
from ...models.geometry import igm
from ...models.robots import FiveBar
from ...singularities.aspects import Aspect, aspects
from ..curve import Path
from ..pieces import Arc
from ..placement import Placement
from ..tool import Tool
from .tool_regions import tool_regions

KEPT = Constraints(clearance=0.005)  # m
RATIOS = 0.05, 20.0  # of rectangles: long ones take much longer to be found


@dataclass(frozen=True, eq=False)
class RectangleFit:
    """A placement in a rectangle of an aspect; scale: the largest with which the drawing would lie
    in it.
    """

    placement: Placement
    aspect: Aspect
    rectangle: Rectangle
    scale: float


def bounds(path: Path) -> np.ndarray:
    """Return ((x low, y low), (x high, y high)), m: the box that holds a path, of polynomials by
    control points.
    """
    corners = []
    for piece in path.pieces:
        if isinstance(piece, Arc):
            first, last = sorted((piece.angle0, piece.angle1))
            quarters = (
                np.arange(np.ceil(first / (np.pi / 2)), np.floor(last / (np.pi / 2)) + 1)
                * np.pi
                / 2
            )
            angles = np.concatenate([[first, last], quarters])
            corners.append(
                np.array(piece.centre)
                + piece.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
            )
        elif hasattr(piece, "bernstein"):
            corners.append(piece.bernstein)
        else:
            corners.append(piece.coefficients.cumsum(axis=0))
    corners = np.concatenate(corners)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def fitted_in(
    robot: FiveBar,
    path: Path,
    turn: float = 0.0,
    scale: float | None = 1.0,
    working: tuple[int, int] | None = None,
    constraints: Constraints = KEPT,
    tool: Tool | None = None,
    measured: Collection[tuple[int, int, int]] = (),
) -> RectangleFit:
    """Return the drawing in the middle of the largest upright rectangle of its shape: Fit.

    scale: of the drawing; None: as large as it fits. working: in these modes alone. constraints: on
        poses, and a clearance from them and from all singularities, m.
    Aspects are taken in this order: those of measured modes (`Machine.measured`), those where the
    legs do not cross, above the motors, in the lab's modes, large; the first that holds the
    drawing. Without a scale, the one that holds it largest of those in measured modes where the
    legs do not cross. The rectangle is in the aspect and the drawing in the rectangle: so it keeps
    off all singularities, but a larger one may fit, elsewhere or turned.
        ValueError with the largest scale where it does not.
    tool: then the drawing is the tool's, and the rectangle is in a region that it sees.
    """
    if working is not None:
        working = (working[0], working[1])
    box = bounds(path.moved(0j, Placement(turn=turn).turned))
    size = np.maximum(box[1] - box[0], 1e-9)
    parts: list[Any]
    if tool is None:
        parts = [each for each in aspects(robot) if working in (None, each.working)]
    else:
        parts = list(tool_regions(tool, robot, working, replace(constraints, clearance=0.0)))
        constraints = Constraints(clearance=constraints.clearance)
    ratio = float(np.clip(size[0] / size[1], *RATIOS))
    rank = {}
    for part in parts:
        place = igm if tool is None else tool.pose
        crossed = _legs_cross(robot, place(robot, part.point, part.working))
        rank[part.number] = (*part.working, part.assembly) not in measured, crossed
    parts.sort(
        key=lambda part: (
            *rank[part.number],
            part.point[1] <= 0,
            part.working != (-1, -1),
            -part.area,
        )
    )
    largest = 0.0
    aspect: Any = None
    refused = f"no aspect in working modes {working}"
    for part in parts:
        if largest and scale is None and rank[part.number] > rank[aspect.number]:
            break
        # The rectangle's area is none larger than the aspect's.
        if part.area <= largest**2 * size.prod():
            continue
        try:
            found = largest_rectangle(part, constraints, ratio)
        except ValueError as error:
            refused = str(error)
            continue
        sides = np.array([found.x_max - found.x_min, found.y_max - found.y_min])
        share = float((sides / size).min())
        if share > 1.0001 * largest:
            largest, aspect, rectangle = share, part, found
        if scale is not None and share >= scale:
            break
    if not largest:
        raise ValueError(refused)
    if scale is not None and scale > largest:
        asked, found = (
            f"{wide:.4g} x {high:.4g} mm"
            for wide, high in (1e3 * size * scale, 1e3 * size * largest)
        )
        raise ValueError(
            f"{asked} is larger than any upright rectangle of this shape"
            f"{'' if working is None else f' in working modes {working}'}: the largest is"
            f" {found}, with scale {np.floor(1e4 * largest) / 1e4:.6g}"
        )
    scale = largest * (1 - 1e-9) if scale is None else scale
    middle = np.array([rectangle.x_min + rectangle.x_max, rectangle.y_min + rectangle.y_max]) / 2
    shift = middle - scale * box.mean(axis=0)
    placement = Placement((float(shift[0]), float(shift[1])), turn, scale)
    return RectangleFit(placement, aspect, rectangle, largest)


def _legs_cross(robot, pose):
    """Return whether bars of both legs cross in a pose."""
    base = np.array([-0.5, 0.5]) * robot.d
    elbow = pose.elbows @ (1, 1j)
    tip = complex(*pose.xi)
    bars = [((base[leg], elbow[leg]), (elbow[leg], tip)) for leg in (0, 1)]
    return any(
        segment_distance(*one, *other) < 0 for one, other in product(*bars) if one[1] != other[1]
    )
