"""Pictures of sweeps and of designs: curves, coloured points, Liu's triangle, fronts with their
robots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from ...models.geometry import Pose, dgm, igm
from ...models.robots import FiveBar
from ...optimal_design.figures import FIGURES
from ...optimal_design.task import SAMPLES, Task
from ..skeleton import pose_body
from ..style import BLACK, BLUE, GREEN, ORANGE
from .maps import PALETTES
from .pose_panels import around, draw_robot

if TYPE_CHECKING:
    from ...optimal_design.results import Design, Front
    from ...optimal_design.sweeps import Sweep

LEVELS = 12  # of an atlas
MOST_POINTS = 200_000  # that a picture shows, evenly chosen


def label(name: str) -> str:
    """A figure with its unit."""
    return FIGURES[name].label if name in FIGURES else name


def sweep_picture(sweep: Sweep, figure: str | None = None) -> Figure:
    """A figure over what varies."""
    figure = figure or sweep.figures[0]
    values = sweep[figure]
    columns = {name: sweep[name] for name in sweep.names}
    if not np.isfinite(values).any():
        raise ValueError(
            f"there is nothing to draw: {figure} is finite in none of {len(values)} designs"
        )
    if set(columns) == {"r1", "r2", "r3"} and np.ptp(sum(columns.values())) < 1e-9:
        return _atlas(columns, values, figure)
    step = max(1, len(values) // MOST_POINTS)
    shown = np.flatnonzero(np.isfinite(values))[::step]
    varied = {
        name: column[shown] for name, column in columns.items() if np.ptp(column) > 0
    } or columns
    values = values[shown]
    if len(varied) == 2:
        return _coloured(varied, values, figure)
    picture = Figure(figsize=(min(3.4 * len(varied), 12) + 0.6, 3.4), layout="constrained")
    panels = picture.subplots(1, len(varied), sharey=True, squeeze=False)[0]
    for axes, (name, column) in zip(panels, varied.items()):
        order = np.argsort(column, kind="stable")
        alone = len(varied) == 1
        axes.plot(
            column[order],
            values[order],
            "-" if alone else ".",
            ms=2,
            color=BLUE,
            alpha=1 if alone else 0.5,
        )
        axes.set_xlabel(_with_unit(name))
        axes.grid(alpha=0.25)
    panels[0].set_ylabel(label(figure))
    return picture


def _with_unit(name):
    return name if name.startswith(("r", "f", "z")) or name == "m" else f"{name} (m)"


def _coloured(varied, values, figure):
    picture = Figure(figsize=(5.6, 4.4), layout="constrained")
    axes = picture.subplots()
    (first, x), (second, y) = varied.items()
    points = axes.scatter(x, y, c=values, s=12, cmap=PALETTES["lines"], lw=0)
    picture.colorbar(points, label=label(figure))
    axes.set(xlabel=_with_unit(first), ylabel=_with_unit(second))
    return picture


def _atlas(columns, values, figure):
    """Liu's plane of the design space r1 + r2 + r3 = 3: x = (2 r1 + r3) / sqrt 3, y = r3."""
    r1, r2, r3 = (columns[name] for name in ("r1", "r2", "r3"))
    x, y = (2 * r1 + r3) / np.sqrt(3), r3
    good = np.isfinite(values)
    picture = Figure(figsize=(6.6, 4.4), layout="constrained")
    axes = picture.subplots()
    filled = axes.tricontourf(x[good], y[good], values[good], LEVELS, cmap="viridis")
    lines = axes.tricontour(x[good], y[good], values[good], LEVELS, colors="k", linewidths=0.5)
    axes.clabel(lines, fontsize=7)
    picture.colorbar(filled, label=figure, shrink=0.75)
    corners = np.array([(3, 0, 0), (0, 3, 0), (0, 1.5, 1.5), (1.5, 0, 1.5), (3, 0, 0)])
    axes.plot((2 * corners[:, 0] + corners[:, 2]) / np.sqrt(3), corners[:, 2], color=BLACK, lw=1)
    for (a, b, c), side in zip(corners[:4], ("left", "right", "right", "left")):
        place = dict(
            xytext=(4 if side == "left" else -4, 3), textcoords="offset points", ha=side, fontsize=7
        )
        axes.annotate(f"({a:g}, {b:g}, {c:g})", ((2 * a + c) / np.sqrt(3), c), **place)
    axes.margins(0.16, 0.1)
    axes.set(xlabel=r"$(2 r_1 + r_3) / \sqrt{3}$", ylabel=r"$r_3$", title=r"$r_1 + r_2 + r_3 = 3$")
    axes.set_aspect("equal")
    return picture


def design_picture(design: Design) -> Figure:
    """A robot over its table."""
    picture = Figure(figsize=(4.6, 4.2), layout="constrained")
    _robots([picture.subplots()], [design])
    return picture


def drawn_line(task: Task) -> np.ndarray | None:
    """Points (n, 2) of the task's motion or path, None where there is none."""
    if task.motion is not None:
        return task.motion.xi
    return None if task.path is None else task.path(np.linspace(0, task.path.length, SAMPLES))[0]


def pose_of(design: Design) -> Pose:
    """The end-effector in the middle of the table, or where the motion begins; of no task
    anywhere.
    """
    task, robot = design.task, design.robot
    if task.table:
        xi = (task.table[0] + task.table[1]) / 2, (task.table[2] + task.table[3]) / 2
    elif task.disc:
        xi = task.disc[:2]
    elif (line := drawn_line(task)) is not None:
        xi = line[0]
    elif isinstance(robot, FiveBar):
        xi = 0.0, 0.6 * np.sqrt(max((robot.l11 + robot.l12) ** 2 - (robot.d / 2) ** 2, 0.0))
    else:
        return dgm(robot, (0.0, 0.0), unreachable="nan")
    return igm(robot, design.place + xi, task.working, unreachable="nan")


def _robots(panels, designs):
    """Robots, each in one pose over its task, all to one scale."""
    points = []
    for axes, design in zip(panels, designs):
        pose = pose_of(design)
        if np.isfinite(pose.q).all():
            body = pose_body([pose])
            draw_robot(axes, body)
            points.append(body.points[0])
        task, (x, y) = design.task, design.place
        if task.table:
            x0, x1, y0, y1 = task.table
            axes.add_patch(
                Rectangle(
                    (1e3 * (x + x0), 1e3 * (y + y0)),
                    1e3 * (x1 - x0),
                    1e3 * (y1 - y0),
                    fc=GREEN,
                    alpha=0.25,
                    ec=GREEN,
                    zorder=0,
                )
            )
            points.append(np.array([(x + x0, y + y0), (x + x1, y + y1)]))
        elif task.disc:
            cx, cy, r = task.disc
            axes.add_patch(
                Circle(
                    (1e3 * (x + cx), 1e3 * (y + cy)),
                    1e3 * r,
                    fc=GREEN,
                    alpha=0.25,
                    ec=GREEN,
                    zorder=0,
                )
            )
            points.append(np.array([(x + cx - r, y + cy - r), (x + cx + r, y + cy + r)]))
        elif (line := drawn_line(task)) is not None:
            axes.plot(*(1e3 * (line + design.place)).T, color=GREEN, lw=2)
            points.append(line + design.place)
        axes.set_aspect("equal")
        axes.grid(alpha=0.25)
        axes.set_xlabel("x (mm)")
    low, high = around(np.concatenate(points) if points else np.zeros((1, 2)))
    for axes in panels:
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    panels[0].set_ylabel("y (mm)")


def front_picture(front: Front, robots: int = 5) -> Figure:
    """A front, and robots along it in the order of the first goal, to one scale."""
    goals = list(front.goals)
    drawn = sorted(
        set(np.linspace(0, len(front) - 1, min(robots, len(front))).round().astype(int).tolist())
    )
    picture = Figure(figsize=(11, 7.2), layout="constrained")
    rows = picture.subfigures(2, 1, height_ratios=(1.35, 1))
    axes = rows[0].subplots()
    x, y = front[goals[0]], front[goals[1]]
    if len(goals) > 2:
        points = axes.scatter(x, y, c=front[goals[2]], cmap=PALETTES["lines"], s=36, zorder=2)
        rows[0].colorbar(points, label=_goal(front, goals[2]))
    else:
        axes.plot(x, y, "o-", color=BLUE, ms=5, lw=1)
    for number, k in enumerate(drawn, start=1):
        axes.plot(x[k], y[k], "o", ms=13, mfc="none", mec=ORANGE, mew=1.5, zorder=3)
        axes.annotate(
            str(number),
            (x[k], y[k]),
            (9, 7),
            textcoords="offset points",
            color=ORANGE,
            weight="bold",
        )
    axes.margins(0.06, 0.1)
    axes.set(xlabel=_goal(front, goals[0]), ylabel=_goal(front, goals[1]))
    axes.grid(alpha=0.25)
    panels = rows[1].subplots(1, len(drawn), sharey=True, squeeze=False)[0]
    _robots(panels, [front.designs[k] for k in drawn])
    for number, (panel, k) in enumerate(zip(panels, drawn), start=1):
        lengths = [
            f"{name} {1e3 * value:.4g}"
            for name, value in front.designs[k].parameters.items()
            if name[0] in "ld"
        ]
        panel.set_title(f"{number}: " + ", ".join(lengths) + (" mm" if lengths else ""), fontsize=8)
    return picture


def _goal(front, name):
    return f"{label(name)}, {front.goals[name]}"
