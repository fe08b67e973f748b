"""Singularities as pictures mark them: exact loci on a map, and crossings along a motion."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.backend import pairs
from ..singularities.loci import singularity_loci
from ..singularities.locus import Locus
from ..singularities.maps import turned_into
from .style import TYPE_3, locus_words

if TYPE_CHECKING:
    from ..models.geometry import Pose
    from ..models.robots import FiveBar
    from ..paths.tool import Tool
    from ..singularities.maps import Map


def map_loci(data: Map) -> Iterator[tuple]:
    """Yield (words, layers of the map, points (n, 2)) of each piece of the exact loci.

    As angles they repeat with every turn.
    """
    robot: Any = data.robot
    if data.tool is not None:
        modes: Any = data.modes
        for layer, mode in enumerate(modes):
            for piece, points in tool_loci(data.tool, robot, mode):
                yield locus_words(piece), [layer], points
        return
    loci = singularity_loci(robot)
    task = data.space == "task"
    ends = (data.y if task else data.x)[[0, -1]]
    pieces: list[tuple] = [
        (locus_words(piece), piece.working if task else piece.assembly, piece.drawn(*ends))
        for piece in (loci.task if task else loci.joint)
    ]
    if task:
        for xi, mode in zip(loci.type3.xi, loci.type3.working):
            same = (np.equal(mode, data.modes) | np.equal(mode, 0)).all(axis=1)
            modes = [data.modes[k] for k in np.flatnonzero(same)]
            pieces.append((TYPE_3, modes, xi[None]))
    else:
        pieces += [(TYPE_3, data.modes, q[None]) for q in loci.type3.q]
    for words, modes, points in pieces:
        layers = [k for k, mode in enumerate(data.modes) if mode in modes]
        repeats = turned_into(data, points) if not task and data.robot.turns else [points]
        for repeat in repeats:
            yield words, layers, repeat


def tool_loci(
    tool: Tool, robot: FiveBar, working: tuple[int, int]
) -> Iterator[tuple[Locus, np.ndarray]]:
    """Yield the borders (locus, points (n, 2)) of the regions that a tool sees in these modes.

    Where the tool folds over its bar is Type 1, too. A border of two regions comes once, so that
    its dashes stay apart.
    """
    from ..paths.placing.tool_regions import tool_regions  # brings SciPy, which scenes do without

    known = set()
    for region in tool_regions(tool, robot, working):
        for arc in chain.from_iterable(region.boundary):
            ends = arc.locus.kind, frozenset(np.round(1e7 * arc.z[[0, -1]]).tolist())
            if ends not in known:
                known.add(ends)
                yield arc.locus, pairs(arc.z)


def crossings(t: np.ndarray, pose: Pose) -> Iterator[tuple[float, int, int, int, float]]:
    """Yield (s, type, vanished sine, sample before, share of the way to the next) of each
    singularity between poses at t; once, too, where a pose is on it.
    """
    sines = np.stack([*pose.sines, pose.det_A], axis=1)
    known = np.isfinite(sines[:-1]) & np.isfinite(sines[1:])
    for k, margin in np.argwhere(known & np.diff(sines >= 0, axis=0)).tolist():
        share = float(sines[k, margin] / (sines[k, margin] - sines[k + 1, margin]))
        time = float(t[k] + share * (t[k + 1] - t[k]))
        yield time, 2 if margin == 2 else 1, margin, k, share
