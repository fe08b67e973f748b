"""Type-2 loci by contouring a grid of det A, at growing resolution, and in closed form."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

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
from ..machine import lacks_c_compiler

ROBOT = FiveBar()
NODES = (25, 35, 50, 71, 100, 141, 200, 283, 400, 566, 800, 1131)
REGULAR = 0.3  # sines of both legs from which on a pose counts as away from Type 1


@lru_cache(maxsize=8)
def _field(mode):
    """Return functions xi -> det A, and xi -> det A, its gradient and the legs' sines."""
    xi = ca.SX.sym("xi", 2)
    pose = task_pose(ROBOT, (xi[0], xi[1]), mode)
    gradient = ca.densify(ca.gradient(pose.det_A, xi))
    more = ca.cse([pose.det_A, gradient, ca.vertcat(*pose.sines)])
    value = ca.Function("det_A", [xi], ca.cse([pose.det_A]))
    return value, ca.Function("gradient", [xi], more)


def locus_error(lines: list[np.ndarray], mode: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return how far polylines are from det A = 0 to first order, m: |det A| over its gradient.

    First at their corners away from Type 1, where the field is smooth; then at all corners and
    middles of segments.
    """
    corners = np.concatenate(lines)
    points = np.concatenate([corners, *((line[1:] + line[:-1]) / 2 for line in lines)])
    value, slope, sines = (part.full() for part in _field(mode)[1].map(len(points))(points.T))
    error = np.abs(value[0]) / np.hypot(*slope)
    smooth = (np.abs(sines) > REGULAR).all(axis=0)[: len(corners)]
    return error[: len(corners)][smooth], error[np.isfinite(error)]


def type_2() -> list:
    """Return the pieces of Type-2 loci in task space, traced now."""
    pieces = singularity_loci(ROBOT).task
    return [p for p in pieces if p.type & Singularity.PARALLEL]


@lru_cache(maxsize=1)
def _exact():
    """Return {mode: points (n, 2) m of its loci}, in the middle between those that are drawn."""
    points = {mode: [] for mode in MODES}
    for piece in type_2():
        middles = piece.at((piece.parameters[1:] + piece.parameters[:-1]) / 2)
        for mode in piece.working:
            points[mode].append(middles)
    return {mode: np.concatenate(parts) for mode, parts in points.items()}


def missing(lines: list[np.ndarray], points: np.ndarray) -> np.ndarray:
    """Return how far points are from the nearest of some polylines, (n,) m."""
    if not lines:
        return np.full(len(points), np.inf)
    a = np.concatenate([line[:-1] for line in lines])
    b = np.concatenate([line[1:] for line in lines])
    _, near = cKDTree((a + b) / 2).query(points, k=min(8, len(a)))
    near = near.reshape(len(points), -1)
    start = a[near]
    along = (b - a)[near]
    square = np.maximum(np.sum(along**2, axis=2), 1e-300)
    share = np.sum((points[:, None] - start) * along, axis=2) / square
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)


def judge(drawn: dict) -> dict[str, float]:
    """Return errors of {mode: polylines}: of what is drawn, and of what is missing, m."""
    smooth, every = zip(*(locus_error(lines, mode) for mode, lines in drawn.items() if lines))
    return {
        "rms": np.sqrt(np.mean(np.concatenate(smooth) ** 2)),
        "error": np.concatenate(every).max(),
        "missing": max(missing(drawn[mode], points).max() for mode, points in _exact().items()),
    }


def lines_of(x: np.ndarray, y: np.ndarray, values: np.ndarray) -> list[np.ndarray]:
    """Return the polylines of value 0 on a grid, by Matplotlib's contouring."""
    lines: Any = contour_generator(x, y, np.ma.masked_invalid(values)).lines(0.0)
    return [line for line in lines if len(line) > 1]


def by_numpy(_: str, nodes: int) -> Attempt:
    """Prepare the grid of `fivebar.singularity_map`."""

    def call():
        data = singularity_map(ROBOT, shape=(nodes, nodes))
        layers = zip(data.modes, data.values)
        return {mode: lines_of(data.x, data.y, layer) for mode, layer in layers}

    return Attempt(call, judge)


def by_casadi(jit: bool) -> Callable[..., Attempt]:
    """Return prepare of the same grid through CasADi."""

    def prepare(_, nodes):
        window = workspace_window(ROBOT)
        x = np.linspace(*window[:2], nodes)
        y = np.linspace(*window[2:], nodes)
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        calls = {mode: Buffered(compiled(_field(mode)[0], jit).map(len(grid))) for mode in MODES}

        def lines(call):
            return lines_of(x, y, call(grid)[0].reshape(nodes, nodes))

        return Attempt(lambda: {mode: lines(call) for mode, call in calls.items()}, judge)

    return prepare


def closed_form(*_: object) -> Attempt:
    """Prepare our loci."""

    def call():
        pieces = type_2()
        lines = {mode: [] for mode in MODES}
        for piece in pieces:
            for mode in piece.working:
                lines[mode].append(piece.points)
        return lines

    return Attempt(call, judge)


def chart() -> Chart:
    """Return the chart of singularity loci."""
    grid = "contours of a grid"
    compiler = (lacks_c_compiler,)
    methods = (
        Method("fivebar.singularity_loci: closed form", OURS, closed_form),
        Method("grid by NumPy, contoured", grid, by_numpy, NODES, order=2),
        Method("grid by CasADi VM, contoured", grid, by_casadi(False), NODES, order=2),
        Method("grid by compiled C, contoured", grid, by_casadi(True), NODES, compiler, 2),
    )
    panels = []
    fine = (1e-4, 1e-6, 1e-9)
    coarse = (1e-3, 1e-4, 1e-5)
    for y, title, label, levels in (
        ("rms", "points, away from Type 1", "RMS distance from the true locus (m)", fine),
        ("error", "lines drawn, at worst", "largest distance from the true locus (m)", fine),
        ("missing", "what is left out, at worst", "largest distance to the drawing (m)", coarse),
    ):
        time = "time for all four working modes (s)"
        panels.append(Panel("task", title, y, label, "seconds", time, levels, 1e-16, 1e-18))
    return Chart(
        name="singularity-map",
        title="Type-2 singularity loci: contours of a grid against the closed form",
        reading=(
            "Each point of a grid's curve is a resolution, from 25 x 25 to 1131 x 1131 nodes over"
            " the workspace. Left: distance of the points from the true locus, away from Type 1;"
            " middle: of the drawn lines, everywhere, at worst. Right: how far the true locus is"
            " from anything drawn, at worst: what a plot leaves out."
        ),
        problems={"task": "task space, four working modes"},
        methods=methods,
        step=lambda nodes: 1 / nodes,
        panels=(tuple(panels),),
    )
