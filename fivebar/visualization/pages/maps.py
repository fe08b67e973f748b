"""A singularity map on a page: the field of each mode, the exact loci, and what the robot's pose is
computed from.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING, Any

import numpy as np

from ...paths.placing.tool_regions import tool_regions
from ...paths.tool import MountedTool
from ...singularities.passages import known_aspects
from ..loci import map_loci
from ..skeleton import robot_body
from ..style import ALONG, DEXTEROUS, SIGNED_COLOURS, field_scale, length_unit, robot_title
from .document import packed
from .samples import parts

if TYPE_CHECKING:
    from ...singularities.maps import Map

NODES = 700_000  # of all modes together at most: 3.7 MB of the page


def map_content(data: Map, along: np.ndarray | None = None, regions: tuple | None = None) -> dict:
    """Return what the page of a Map holds.

    along: a path (n, 2) m in task space; regions: of `dexterous`, for the aspects.
    """
    stride, notes = 1, []
    while data.values[:, ::stride, ::stride].size > NODES:
        stride += 1
    x = data.x[::stride]
    y = data.y[::stride]
    values = data.values[:, ::stride, ::stride]
    if stride > 1:
        nodes = f"{len(x)} x {len(y)} of {len(data.x)} x {len(data.y)} nodes"
        notes.append(f"This page, its CSV included, holds {nodes}; Map.to_csv has all.")
    scale = field_scale(data)
    robot: Any = data.robot
    task = data.space == "task"
    words, drives = robot.words, robot.drives
    if task or not robot.turns:
        factor, unit = length_unit(robot)
    else:
        factor, unit = 180 / np.pi, "deg"
    # As far as the map needs the guides of the feet.
    feet = data.y if task else np.append(data.x, data.y)
    bar = max(robot.distal)
    modes: list[Any] = list(data.modes)
    loci = list(map_loci(data))
    if along is not None:
        loci.append((ALONG, range(len(modes)), along))
    for region in regions or ():
        layers = [modes.index(region.working)]
        loci += [(DEXTEROUS, layers, np.concatenate([p, p[:1]])) for p in region.polygons]
    numbered: tuple = regions or ()
    if regions is None and task and robot.turns:
        numbered = known_aspects(robot) if data.tool is None else tool_regions(data.tool, robot)
    return {
        "title": f"singularity map: {robot_title(robot)}",
        "notes": notes,
        "space": data.space,
        "axes": [[name, unit, factor] for name in ("xy" if task else words.joints)],
        "robot": {
            "turns": robot.turns,
            "drives": [[drive.x, drive.y, drive.length] for drive in drives],
            "distal": robot.distal,
            "joints": words.joints,
            "sines": words.sines[:2],
            "tool": _tool(data),
            "rail": None if robot.turns else [feet.min() - bar, feet.max() + bar],
        },
        # What joins its points, which the page computes; where they are here is of no account.
        "body": parts(
            robot_body(
                robot,
                np.zeros((1, 2, 2)),
                np.ones((1, 2)),
                None if data.tool is None else astuple(data.tool),
            )
        ),
        "field": {
            "name": data.field,
            "words": scale.words,
            "factor": scale.factor,
            "palette": scale.palette,
            "signed": SIGNED_COLOURS,
            "limits": [scale.low, scale.high],
            "logarithmic": scale.logarithmic,
        },
        "x": packed(x),
        "y": packed(y),
        "layers": [
            {"mode": np.atleast_1d(mode).tolist(), "values": packed(layer, "f4")}
            for mode, layer in zip(modes, values)
        ],
        "loci": [
            {"kind": kind, "layers": list(layers), "points": [*map(packed, np.transpose(points))]}
            for kind, layers, points in loci
        ],
        "numbers": [
            [region.number, *region.point.tolist(), [modes.index(region.working)]]
            for region in numbered
        ],
        "columns": data.columns,
        "source": "Map.to_csv",
    }


def _tool(data):
    """Return what the page computes joint C from, with the tool at a point; None without a tool.

    Names are those of `MountedTool`.
    """
    if data.tool is None:
        return None
    mounted = [MountedTool(data.tool, data.robot, mode) for mode in data.modes]
    factor = mounted[0].factor
    return {
        "leg": data.tool.leg - 1,
        "reach": mounted[0].reach,
        "factor": [factor.real, factor.imag],
        "branches": [each.branch for each in mounted],
    }
