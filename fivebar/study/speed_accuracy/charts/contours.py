"""Type-2 loci by contouring a grid of det A, at growing resolution, and in closed form."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from contourpy import contour_generator
from scipy.spatial import cKDTree

from ....models.compiled import Buffered, compiled
from ....models.geometry import task_pose
from ....models.robots import FiveBar
from ....singularities.loci import singularity_loci
from ....singularities.locus import MODES
from ....singularities.maps import singularity_map, workspace_window
from ....singularities.margins import Singularity
from ..chart import OURS, Attempt, Chart, Method, Panel

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT = FiveBar()
NODES = (25, 35, 50, 71, 100, 141, 200, 283, 400, 566, 800, 1131)
NEIGHBOURS = 8
REGULAR = 0.3  # sines of both legs from which on a pose counts as away from Type 1


@lru_cache(maxsize=8)
def _field(mode, gradient=False):
    """xi -> det A, with its gradient and the legs' sines if wanted."""
    xi = ca.SX.sym("xi", 2)
    pose = task_pose(ROBOT, (xi[0], xi[1]), mode)
    sine = pose.det_A
    outputs = (
        [sine, ca.densify(ca.gradient(sine, xi)), ca.vertcat(*pose.sines)] if gradient else [sine]
    )
    return ca.Function("det_A", [xi], ca.cse(outputs))


def off_locus(lines: list[np.ndarray], mode: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """How far points of polylines are from det A = 0, to first order, m: |det A| over its gradient.

    Their corners away from Type 1, where the field is smooth, and all corners and middles of their
    segments.
    """
    corners = np.concatenate(lines)
    points = np.concatenate([corners, *((line[1:] + line[:-1]) / 2 for line in lines)])
    value, slope, serial = (part.full() for part in _field(mode, True).map(len(points))(points.T))
    off = np.abs(value[0]) / np.hypot(*slope)
    smooth = (np.abs(serial) > REGULAR).all(axis=0) & (np.arange(len(points)) < len(corners))
    return off[smooth], off[np.isfinite(off)]


@lru_cache(maxsize=1)
def _exact():
    """{mode: points (n, 2) m of its Type-2 loci}, closed form, in the middle between those that are
    drawn.
    """
    middles = [
        (piece.at((piece.parameters[1:] + piece.parameters[:-1]) / 2), piece.working)
        for piece in type_2()
    ]
    return {
        mode: np.concatenate([points for points, working in middles if mode in working])
        for mode in MODES
    }


def type_2() -> list:
    """The pieces of Type-2 loci in task space, traced now."""
    return [
        p
        for p in singularity_loci(ROBOT).task
        if p.type & Singularity.PARALLEL and len(p.points) > 1
    ]


def missing(lines: list[np.ndarray], points: np.ndarray) -> np.ndarray:
    """How far points are from the nearest of some polylines, (n,) m."""
    if not lines:
        return np.full(len(points), np.inf)
    a, b = (
        np.concatenate([line[part] for line in lines]) for part in (slice(None, -1), slice(1, None))
    )
    _, near = cKDTree((a + b) / 2).query(points, k=min(NEIGHBOURS, len(a)))
    near = near.reshape(len(points), -1)
    start, along = a[near], (b - a)[near]
    share = np.sum((points[:, None] - start) * along, axis=2) / np.maximum(
        np.sum(along**2, axis=2), 1e-300
    )
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)


def judge(drawn: dict) -> dict[str, float]:
    """{mode: polylines} -> how far what is drawn is off, and how far what should be drawn is from
    it.
    """
    smooth, every = zip(*(off_locus(lines, mode) for mode, lines in drawn.items() if lines))
    lost = max(missing(drawn[mode], points).max() for mode, points in _exact().items())
    smooth = np.concatenate(smooth)
    return {
        "rms": np.sqrt(np.mean(smooth**2)),
        "error": np.concatenate(every).max(),
        "missing": lost,
    }


def lines_of(x: np.ndarray, y: np.ndarray, values: np.ndarray) -> list[np.ndarray]:
    """The polylines of value 0 on a grid, by Matplotlib's contouring."""
    return [
        line
        for line in contour_generator(x, y, np.ma.masked_invalid(values)).lines(0.0)
        if len(line) > 1
    ]


def by_numpy(_: str, nodes: int) -> Attempt:
    def call():
        data = singularity_map(ROBOT, shape=(nodes, nodes))
        return {
            mode: lines_of(data.x, data.y, layer) for mode, layer in zip(data.modes, data.values)
        }

    return Attempt(call, judge)


def by_casadi(jit: bool) -> Callable[..., Attempt]:
    def prepare(_, nodes):
        x_min, x_max, y_min, y_max = workspace_window(ROBOT)
        x, y = np.linspace(x_min, x_max, nodes), np.linspace(y_min, y_max, nodes)
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        calls = {mode: Buffered(compiled(_field(mode), jit).map(len(grid))) for mode in MODES}

        def call():
            return {
                mode: lines_of(x, y, run(grid)[0].reshape(nodes, nodes))
                for mode, run in calls.items()
            }

        return Attempt(call, judge)

    return prepare


def closed_form(*_: object) -> Attempt:
    def call():
        mine = type_2()
        return {mode: [p.points for p in mine if mode in p.working] for mode in MODES}

    return Attempt(call, judge)


def chart() -> Chart:
    grid = "contours of a grid"
    methods = (
        Method("fivebar.singularity_loci: closed form", OURS, closed_form),
        Method("grid by NumPy, contoured", grid, by_numpy, NODES, order=2),
        Method("grid by CasADi VM, contoured", grid, by_casadi(False), NODES, order=2),
        Method("grid by compiled C, contoured", grid, by_casadi(True), NODES, ("C compiler",), 2),
    )
    common = dict(
        problem="task", xlabel="time for all four working modes (s)", rounding=1e-16, floor=1e-18
    )
    return Chart(
        name="singularity-map",
        title="Type-2 singularity loci: contours of a grid against the closed form",
        reading=(
            "Each point of a grid's curve is a resolution, from 25 x 25 to 1131 x 1131 nodes over"
            " the workspace. Left: distance of the points found from the true locus, away from Type"
            " 1; middle: of the drawn lines, everywhere, at worst. Right: how far the true locus is"
            " from anything drawn, at worst: what a plot leaves out."
        ),
        problems={"task": "task space, four working modes"},
        methods=methods,
        step=lambda nodes: 1 / nodes,
        panels=(
            (
                Panel(
                    y="rms",
                    title="points found, away from Type 1",
                    ylabel="RMS distance from the true locus (m)",
                    levels=(1e-4, 1e-6, 1e-9),
                    **common,
                ),
                Panel(
                    y="error",
                    title="lines drawn, at worst",
                    ylabel="largest distance from the true locus (m)",
                    levels=(1e-4, 1e-6, 1e-9),
                    **common,
                ),
                Panel(
                    y="missing",
                    title="what is left out, at worst",
                    ylabel="largest distance from true locus to drawing (m)",
                    levels=(1e-3, 1e-4, 1e-5),
                    **common,
                ),
            ),
        ),
    )
