"""A singularity map on a page: the field of each mode, the exact loci, and what the robot's pose is
computed from.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...singularities.aspects import aspects
from ...singularities.loci import singularity_loci
from ...singularities.maps import turned_into
from ..functions import pose_functions, script
from ..skeleton import robot_body
from ..style import ALONG, DEXTEROUS, TYPE_3, field_scale, locus_words, robot_title
from .document import packed
from .samples import parts

if TYPE_CHECKING:
    from ...singularities.maps import Map

NODES = 700_000  # of all modes together at most: 3.7 MB of the page


def map_content(data: Map, along: np.ndarray | None = None, regions: tuple | None = None) -> dict:
    """What the page of a Map holds; along: a path (n, 2) m in task space; regions: of `dexterous`,
    for the aspects.
    """
    stride, notes = _stride(data)
    x, y, values = data.x[::stride], data.y[::stride], data.values[:, ::stride, ::stride]
    scale = field_scale(data)
    task, robot = data.space == "task", data.robot
    degrees = not task and robot.turns
    names = ("x", "y") if task else robot.words.joints
    return {
        "title": f"singularity map: {robot_title(robot)}",
        "notes": notes,
        "space": data.space,
        "axes": [[name, *(("deg", 180 / np.pi) if degrees else ("mm", 1e3))] for name in names],
        "robot": {
            "turns": robot.turns,
            "drives": [[drive.x, drive.y, drive.length] for drive in robot.drives],
            "distal": robot.distal,
            "joints": robot.words.joints,
            "sines": robot.words.sines[:2],
            "rail": None if robot.turns else _rail(data),
        },
        # What joins its points, which the page computes; where they are here is of no account.
        "body": parts(robot_body(robot, np.zeros((1, 2, 2)), np.zeros((1, 2)))),
        "field": {
            "name": data.field,
            "words": scale.words,
            "factor": scale.factor,
            "palette": scale.palette,
            "limits": [scale.low, scale.high],
            "logarithmic": scale.logarithmic,
        },
        "x": packed(x),
        "y": packed(y),
        "layers": [
            {"mode": np.atleast_1d(mode).tolist(), "values": packed(layer, "f4")}
            for mode, layer in zip(data.modes, values)
        ],
        "loci": (
            list((_task_loci if task else _joint_loci)(data)) + list(_more(data, along, regions))
        ),
        "numbers": [
            [region.number, *region.point.tolist(), _layers(data, [region.working])]
            for region in (
                (aspects(robot) if regions is None else regions) if task and robot.turns else ()
            )
        ],
        "columns": data.columns,
        "source": "Map.to_csv",
    }


def _more(data, along, regions):
    """A path, and the outlines of regions."""
    if along is not None:
        yield _locus(ALONG, _layers(data, data.modes), along)
    for region in regions or ():
        for loop in region.polygons:
            yield _locus(
                DEXTEROUS, _layers(data, [region.working]), np.concatenate([loop, loop[:1]])
            )


def map_models(data: Map) -> str:
    """The robot's igm and dgm in JavaScript, for the point pointed at."""
    return script(pose_functions(data.robot))


def _stride(data):
    stride = 1
    while data.values[:, ::stride, ::stride].size > NODES:
        stride += 1
    if stride == 1:
        return 1, []
    nodes = " x ".join(str(-(-len(axis) // stride)) for axis in (data.x, data.y))
    return stride, [
        f"This page, its CSV included, holds {nodes} of {len(data.x)} x {len(data.y)} nodes;"
        " Map.to_csv has all."
    ]


def _rail(data):
    """Least and largest coordinate, m, of the feet's guides as far as the map needs them."""
    along = data.y if data.space == "task" else np.concatenate([data.x, data.y])
    room = max(data.robot.distal)
    return [along.min() - room, along.max() + room]


def _layers(data, modes):
    return [k for k, mode in enumerate(data.modes) if mode in modes]


def _locus(kind, layers, points):
    return {
        "kind": kind,
        "layers": layers,
        "points": [packed(x) for x in np.reshape(points, (-1, 2)).T],
    }


def _task_loci(data):
    loci = singularity_loci(data.robot)
    for piece in loci.task:
        yield _locus(
            locus_words(piece), _layers(data, piece.working), piece.drawn(data.y[0], data.y[-1])
        )
    for xi, own in zip(loci.type3.xi, loci.type3.working):
        layers = [
            k for k, mode in enumerate(data.modes) if all(o in (0, m) for o, m in zip(own, mode))
        ]
        yield _locus(TYPE_3, layers, xi)


def _joint_loci(data):
    loci = singularity_loci(data.robot)
    if not data.robot.turns:
        for piece in loci.joint:
            yield _locus(
                locus_words(piece),
                _layers(data, piece.assembly),
                piece.drawn(data.x[0], data.x[-1]),
            )
        return
    pieces = [
        (locus_words(piece), _layers(data, piece.assembly), piece.points) for piece in loci.joint
    ]
    pieces += [(TYPE_3, [0, 1], q[None]) for q in loci.type3.q]
    for kind, layers, points in pieces:
        for turned in turned_into(data, points):
            yield _locus(kind, layers, turned)
