"""Pictures of sweeps and of designs: curves, coloured points, Liu's triangle, fronts with their
robots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Circle, Rectangle

from ...models.geometry import Pose, dgm, igm
from ...models.robots import FiveBar
from ...optimal_design.figures import FIGURES
from ...optimal_design.task import SAMPLES, Task
from ..skeleton import pose_body
from ..style import BLACK, BLUE, RUST, largest_of, readable
from .panels import (
    PALETTES,
    STYLES,
    draw,
    draw_points,
    draw_robot,
    finish,
    new_figure,
    new_panels,
    plane,
    set_window,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...optimal_design.results import Design, Front
    from ...optimal_design.sweeps import Sweep

MOST_POINTS = 200_000  # that a picture shows, evenly chosen
UNITS = {"m²": (1e4, "cm²"), "rad": (180 / np.pi, "deg")}  # shown in place of these


def label(name: str) -> str:
    """Return a figure of merit or a parameter with its unit."""
    if name in FIGURES:
        return FIGURES[name].label
    if name[0] in "rfz" or name == "m":
        return name
    return f"{name} (m)"


def draw_sweep(sweep: Sweep, figure: str | None = None) -> Figure:
    """Draw the figures of merit, or one of them, over what varies, and mark the best design."""
    figures = [figure] if figure else list(sweep.figures)
    columns = {name: sweep[name] for name in sweep.names}
    values = {name: sweep[name] for name in figures}
    good = np.flatnonzero(np.isfinite(list(values.values())).any(axis=0))
    if not len(good):
        raise ValueError(
            f"there is nothing to draw: {' or '.join(figures)} is finite in none of {sweep.count}"
            " designs"
        )
    if set(columns) == {"r1", "r2", "r3"} and np.ptp(sum(columns.values())) < 1e-9:
        return _atlas(columns, values[figures[0]], good, figures[0])
    varied = {name: column for name, column in columns.items() if np.ptp(column[good]) > 0}
    scaled = {}
    for name, column in (varied or columns).items():
        words, factor = _words(name, column)
        scaled[words] = factor * column
    shown = {_words(name, column): (name, column) for name, column in values.items()}
    if len(scaled) == 2:
        drawing = _contours
        picture, panels = new_panels(None, len(shown), 2, 5.4, 4.2)
    else:
        size = min(3.4 * len(scaled), 12) + 0.6, 3.4 * len(shown)
        drawing = _curves
        picture = new_figure(*size)
        panels = picture.subplots(len(shown), len(scaled), sharey="row", squeeze=False)
    for axes, ((words, factor), (name, column)) in zip(panels, shown.items()):
        best = sweep.best(name)
        drawing(picture, axes, scaled, factor * column, words, best[0] if len(best) else None)
    return picture


def _words(name, column):
    """Return a column's name with the unit in which it reads well, and the unit's factor."""
    words = FIGURES[name].label if name in FIGURES else label(name)
    start, _, unit = words.removesuffix(")").rpartition(" (")
    if unit in UNITS:
        factor, unit = UNITS[unit]
    elif unit in ("m", "N", "N m", "m/s"):
        factor, unit = readable(largest_of(column), unit)
    else:
        return words, 1.0
    return (f"{start} ({unit})", factor) if factor else (words, 1.0)


def _contours(picture, axes, varied, values, words, best):
    """Fill a plane of two parameters by a figure of merit, with labelled levels."""
    (first, x), (second, y) = varied.items()
    good = np.flatnonzero(np.isfinite(values))
    good = good[:: max(1, len(good) // MOST_POINTS)]
    places = np.stack([x[good], y[good]])
    if len(good) and np.linalg.matrix_rank(places - places[:, :1]) == 2:
        filled = _filled(axes, *places, values[good], 10, PALETTES["lines"])
    else:  # too few designs, or all on one line: there are no triangles between them
        filled = axes.scatter(*places, c=values[good], s=12, cmap=PALETTES["lines"], lw=0)
    picture.colorbar(filled, ax=axes, label=words)
    if best is not None:
        mark = dict(clip_on=False, label=f"best: {values[best]:.4g}")
        draw(axes, "mark.chosen", [x[best]], [y[best]], **mark)
    finish(axes, 1, xlabel=first, ylabel=second)


def _filled(axes, x, y, values, levels, palette):
    """Fill a panel by values between points, with labelled levels; return what a bar explains."""
    axes.clabel(axes.tricontour(x, y, values, levels, colors="k", linewidths=0.5), fontsize=7)
    return axes.tricontourf(x, y, values, levels, cmap=palette)


def _curves(picture, row, varied, values, words, best):
    """Draw a figure of merit over each of some parameters."""
    chosen = np.arange(len(values))[:: max(1, len(values) // MOST_POINTS)]
    style = dict(marker=".", ls="none", ms=2, alpha=0.5) if len(varied) > 1 else {}
    for axes, (parameter, column) in zip(np.atleast_1d(row), varied.items()):
        order = chosen[np.argsort(column[chosen], kind="stable")]
        axes.plot(column[order], values[order], color=BLUE, **style)
        if best is not None:
            draw(axes, "mark.chosen", [column[best]], [values[best]])
        axes.set_xlabel(parameter)
        axes.grid(alpha=0.25)
    np.atleast_1d(row)[0].set_ylabel(words)


def _atlas(columns, values, good, name):
    """Liu's plane of the design space r1 + r2 + r3 = 3: x = (2 r1 + r3) / sqrt 3, y = r3."""
    x = (2 * columns["r1"] + columns["r3"]) / np.sqrt(3)
    y = columns["r3"]
    picture = new_figure(6.6, 4.4)
    axes = picture.subplots()
    filled = _filled(axes, x[good], y[good], values[good], 12, "viridis")
    picture.colorbar(filled, label=name, shrink=0.75)
    corners = np.array([(3, 0, 0), (0, 3, 0), (0, 1.5, 1.5), (1.5, 0, 1.5), (3, 0, 0)])
    places = np.column_stack([(2 * corners[:, 0] + corners[:, 2]) / np.sqrt(3), corners[:, 2]])
    axes.plot(*places.T, color=BLACK, lw=1)
    for (a, b, c), place, side in zip(corners, places, ("left", "right", "right", "left")):
        offset = dict(xytext=(4 if side == "left" else -4, 3), textcoords="offset points")
        axes.annotate(f"({a:g}, {b:g}, {c:g})", place, ha=side, fontsize=7, **offset)
    axes.margins(0.16, 0.1)
    axes.set(xlabel=r"$(2 r_1 + r_3) / \sqrt{3}$", ylabel=r"$r_3$", title=r"$r_1 + r_2 + r_3 = 3$")
    axes.set_aspect("equal")
    return picture


def draw_design(design: Design) -> Figure:
    """Draw a robot over its table."""
    picture = new_figure(4.6, 4.2)
    _robots([picture.subplots()], [design])
    return picture


def task_line(task: Task) -> np.ndarray | None:
    """Return points (n, 2) of the task's motion or path, None where there is none."""
    if task.motion is not None:
        return task.motion.xi
    if task.path is None:
        return None
    return task.path(np.linspace(0, task.path.length, SAMPLES))[0]


def pose_of(design: Design) -> Pose:
    """Return the pose in the middle of the table, or where the motion begins; without a task
    any.
    """
    task, robot = design.task, design.robot
    if task.table:
        xi = ((task.table[0] + task.table[1]) / 2, (task.table[2] + task.table[3]) / 2)
    elif task.disc:
        xi = task.disc[:2]
    elif (line := task_line(task)) is not None:
        xi = line[0]
    elif isinstance(robot, FiveBar):
        xi = (0.0, 0.6 * np.sqrt(max((robot.l11 + robot.l12) ** 2 - (robot.d / 2) ** 2, 0.0)))
    else:
        return dgm(robot, (0.0, 0.0), unreachable="nan")
    return igm(robot, design.place + xi, task.working, unreachable="nan")


def _robots(panels, designs):
    """Robots, each in one pose over its task, all to one scale."""
    points = [np.zeros((0, 2))]
    area = STYLES["area.task"]
    for axes, design in zip(panels, designs):
        pose = pose_of(design)
        task = design.task
        if np.isfinite(pose.q).all():
            body = pose_body([pose])
            draw_robot(axes, body)
            points.append(body.points[0])
        if task.table:
            ends = design.place + np.reshape(task.table, (2, 2)).T
            axes.add_patch(Rectangle(1e3 * ends[0], *(1e3 * (ends[1] - ends[0])), **area))
            points.append(ends)
        elif task.disc:
            centre = design.place + task.disc[:2]
            radius = task.disc[2]
            axes.add_patch(Circle(1e3 * centre, 1e3 * radius, **area))
            points.append(np.array([centre - radius, centre + radius]))
        elif (line := task_line(task)) is not None:
            draw_points(axes, "path.task", line + design.place)
            points.append(line + design.place)
    together = np.concatenate(points)
    for axes in panels:
        set_window(axes, together if len(together) else np.zeros((1, 2)))
        plane(axes)
        axes.label_outer()


def draw_front(front: Front, robots: int = 5) -> Figure:
    """Draw a front, and robots along it, to one scale, with their numbers in the front's order."""
    goals = [f"{label(name)}, {way}" for name, way in front.goals.items()]
    x, y, *more = (front[name] for name in front.goals)
    places = np.linspace(0, len(front) - 1, min(robots, len(front)))
    chosen = {int(k) + 1: k for k in np.unique(places.round().astype(int))}
    picture = new_figure(11, 7.2)
    halves: Any = picture.subfigures(2, 1, height_ratios=(1.35, 1))
    top, bottom = halves
    axes = top.subplots()
    if more:
        points = axes.scatter(x, y, c=more[0], cmap=PALETTES["lines"], s=36, zorder=2)
        top.colorbar(points, label=goals[2])
    else:
        draw(axes, "mark.front", x, y)
    text = dict(textcoords="offset points", color=RUST, weight="bold")
    for number, k in chosen.items():
        draw(axes, "mark.chosen", x[k], y[k])
        axes.annotate(str(number), (x[k], y[k]), (9, 7), **text)
    axes.margins(0.06, 0.1)
    axes.set(xlabel=goals[0], ylabel=goals[1])
    axes.grid(alpha=0.25)
    panels = bottom.subplots(1, len(chosen), sharey=True, squeeze=False)[0]
    _robots(panels, [front.designs[k] for k in chosen.values()])
    for panel, (number, k) in zip(panels, chosen.items()):
        parameters = front.designs[k].parameters.items()
        lengths = [f"{name} {1e3 * value:.4g}" for name, value in parameters if name[0] in "ld"]
        unit = " mm" if lengths else ""
        panel.set_title(f"robot {number}\n{', '.join(lengths)}{unit}", fontsize=8)
    return picture
