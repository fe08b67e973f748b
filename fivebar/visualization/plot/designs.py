"""Pictures of sweeps and of designs: curves, coloured points, Liu's triangle, fronts with their
robots.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from numbers import Integral
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from ...base import checks
from ...models.geometry import Pose, dgm, igm
from ...models.parameter_units import units_of
from ...models.robots import Biglide, FiveBar
from ...optimal_design.task import SAMPLES, Task
from ..skeleton import pose_body
from ..style import BLACK, BLUE, NO_VALUE, RUST, largest_of, readable
from .panels import (
    PALETTES,
    STYLES,
    draw,
    draw_points,
    draw_robot,
    figure_legend,
    plane,
    set_window,
)
from .sheets import Sheet, small_letters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...optimal_design.results import Design, Front
    from ...optimal_design.sweeps import Sweep

MOST_POINTS = 200_000  # that a picture shows, evenly chosen
MOST_PANELS = 9  # of a figure of merit; 3 where there are several
LEVELS = 10  # of contours, about
UNITS = {"m²": (1e4, "cm²"), "rad": (180 / np.pi, "deg")}  # shown in place of these


class Quantity(NamedTuple):
    """A figure of merit or a parameter, its unit, and the factor from SI units to that."""

    words: str
    unit: str
    factor: float = 1.0

    def __str__(self) -> str:
        return f"{self.words} ({self.unit})" if self.unit else self.words

    def value(self, x: float) -> str:
        """Return a number in SI units as it is written here, with its name."""
        return f"{self.words} = {self.factor * x:.4g} {self.unit}".rstrip()


def parameter_unit(name: str, robot: FiveBar | Biglide) -> str:
    """Return the SI unit of what designs name, "" of Liu's lengths, which have none."""
    return next(iter(units_of(name, robot.turns))).strip("1")


def quantity(name: str, column: np.ndarray, unit: str) -> Quantity:
    """Return a figure of merit or a parameter in the unit in which a column of it, in SI units,
    reads well.
    """
    words = re.sub(r"^([lr])([0-9]+)$", r"$\1_{\2}$", name.replace("_", " "))
    if unit in UNITS:
        factor, unit = UNITS[unit]
    elif unit in ("m", "N", "N m", "m/s"):
        factor, unit = readable(largest_of(column) or 1.0, unit, 0.0)
    else:
        factor = 1.0
    return Quantity(words, unit, factor)


def draw_sweep(sweep: Sweep, sheet: Sheet, figure: str | None = None, mark: Any = None) -> Figure:
    """Draw the figures of merit, or one of them, over what varies, and mark the best design.

    Over two parameters they are filled contours. Over more there is a panel of the first two for
    each combination of the others, of nine at most; of three where there are several figures,
    of two in a given width.
    mark: a chosen design, as {name: value}, by its number, or from `fb.design`.
    """
    names = list(sweep.figures)
    if figure is not None:
        names = [checks.one_of(*names)(figure, "figure")]
    columns = {name: sweep[name] for name in sweep.names}
    values = {name: sweep[name] for name in names}
    if not np.isfinite(list(values.values())).any():
        raise ValueError(f"there is nothing to draw: {sweep.why_not_finite(*names)}")
    quantities = {}
    for name, column in values.items():
        unit = sweep.known[name].unit if name in sweep.known else ""
        quantities[name] = quantity(name, column, unit)
    if set(columns) == {"r1", "r2", "r3"} and np.ptp(sum(columns.values())) < 1e-9:
        return _atlas(sheet, columns, values, quantities)
    varied = [name for name, column in columns.items() if np.ptp(column) > 0] or list(columns)
    over = [quantity(name, columns[name], parameter_unit(name, sweep.robot)) for name in varied]
    factors = np.array([each.factor for each in over])
    table = factors * np.stack([columns[name] for name in varied], axis=1)
    chosen = [] if mark is None else [("chosen", "D", factors * _values_of(sweep, mark, varied))]
    side_by_side = 3 if sheet.width is None else 2
    cells = _cells(table, MOST_PANELS if len(names) == 1 else side_by_side)
    merits = []
    for name, column in values.items():
        of = quantities[name]
        best = [(f"best: {of.value(column[k])}", "o", table[k]) for k in sweep.best(name)[:1]]
        merits.append((of, of.factor * column, best + chosen))
    if cells:
        return _contours(sheet, table, over, merits, cells)
    return _curves(sheet, table, over, merits)


def _values_of(sweep, mark, names):
    """Return what a chosen design has of these parameters, (n,)."""
    if isinstance(mark, Integral):
        mark = sweep.design(mark)
    parameters = getattr(mark, "parameters", mark)
    if not isinstance(parameters, Mapping) or set(names) - set(parameters):
        example = ", ".join(f"{name!r}: ..." for name in names)
        raise ValueError(
            f"mark must be {{{example}}}, a design's number or a Design, not {checks.shown(mark)}"
        )
    return np.array([checks.number(parameters[name], f"mark: {name}") for name in names])


def _cells(table, most):
    """Return the numbers of the designs in each panel over the first two of what varies; none for
    designs that are no grid of the others.
    """
    if table.shape[1] < 2:
        return []
    _, cell = np.unique(table[:, 2:].round(12), axis=0, return_inverse=True)
    count = cell.max() + 1
    if len(table) < 4 * count > 4:
        return []
    picked = np.unique(np.linspace(0, count - 1, most).round())
    return [np.flatnonzero(cell.ravel() == k) for k in picked]


def _contours(sheet, table, over, merits, cells):
    """Fill planes of two parameters by figures of merit, with labelled levels."""
    titles = []
    for inside in cells:
        held = zip(over[2:], table[inside[0], 2:] / [each.factor for each in over[2:]])
        titles.append(", ".join(each.value(x) for each, x in held))
    names = [", ".join(filter(None, (of.words, title))) for of, *_ in merits for title in titles]
    # The panels of one figure stand in a row of their own, which its bar of colours explains.
    columns = 2 if len(cells) == 1 else min(len(cells), 3)
    picture, panels = sheet.grid(names, columns, 4.4, 3.6)
    for axes, name in zip(panels, names):
        axes.set(xlabel=str(over[0]), ylabel=str(over[1]))
        axes.set_title(name, fontsize=small_letters())
    for here, (of, column, marks) in zip(np.reshape(panels, (-1, len(cells))), merits):
        levels = _levels(column)
        for axes, inside in zip(here, cells):
            filled = _filled(axes, *table[inside, :2].T, column[inside], levels)
        for words, marker, row in marks:
            away = [np.abs(table[inside[0], 2:] - row[2:]).sum() for inside in cells]
            axes = here[np.argmin(away)]
            draw(axes, "mark.chosen", *row[:2, None], marker=marker, clip_on=False, label=words)
        here[0].figure.colorbar(filled, ax=list(here), label=str(of))
    ground = []
    if not np.isfinite([column for _, column, _ in merits]).all():
        ground = [
            Patch(fc=NO_VALUE, ec="0.7", label="no value: out of reach, across Type 2 or failed")
        ]
    return _explained(picture, panels, sheet, ground)


def _levels(column):
    known = column[np.isfinite(column)]
    ends = (known.min(), known.max()) if len(known) else (0, 1)
    locator = MaxNLocator(LEVELS)
    return locator.tick_values(*locator.nonsingular(*ends))


def _filled(axes, x, y, values, levels):
    """Fill a panel by values at points, with labelled levels, where all corners of a cell have one;
    return what a bar explains.
    """
    known = np.flatnonzero(np.isfinite(values))
    known = known[:: max(1, len(known) // MOST_POINTS)]
    colours = dict(cmap=PALETTES["lines"], vmin=levels[0], vmax=levels[-1])
    filled = axes.scatter(x[known], y[known], c=values[known], s=6, lw=0, zorder=0, **colours)
    axes.set_facecolor(NO_VALUE)
    for limits, column in ((axes.set_xlim, x), (axes.set_ylim, y)):
        if np.ptp(column):
            limits(column.min(), column.max())
    columns, i = np.unique(x, return_inverse=True)
    rows, j = np.unique(y, return_inverse=True)
    field: tuple
    cut: dict
    if len(columns) * len(rows) <= 2 * len(x):
        table = np.full((len(rows), len(columns)), np.nan)
        table[j, i] = values
        corners = np.stack([table[1:, 1:], table[:-1, 1:], table[1:, :-1], table[:-1, :-1]])
        whole = np.isfinite(corners).all(axis=0)
        field, cut = (columns, rows, np.ma.masked_invalid(table)), dict(corner_mask=False)
        fill, lines = axes.contourf, axes.contour
    elif np.linalg.matrix_rank(np.stack([x - x[0], y - y[0]])) == 2:
        # In squares, so that the triangles are those of neighbours.
        corners = Triangulation(x / np.ptp(x), y / np.ptp(y)).triangles
        whole = np.isfinite(values[corners]).all(axis=1)
        field = Triangulation(x, y, corners, ~whole), np.nan_to_num(values, posinf=0, neginf=0)
        cut = {}
        fill, lines = axes.tricontourf, axes.tricontour
    else:
        return filled
    if whole.any():
        filled = fill(*field, levels, **colours, **cut)
        low, high = values[known].min(), values[known].max()
        if len(inner := levels[(levels > low) & (levels < high)]):
            drawn = lines(*field, inner, colors="k", linewidths=0.5, **cut)
            axes.clabel(drawn, fontsize=small_letters() - 1)
    return filled


def _explained(picture, panels, sheet, more=()):
    """Return a picture; a new one with the names of marks under it."""
    if sheet.axes is None:
        handles = [handle for axes in panels for handle in axes.get_legend_handles_labels()[0]]
        by_label = {handle.get_label(): handle for handle in [*handles, *more]}
        columns = max(1, int(picture.get_figwidth() / 2.6))
        figure_legend(picture, list(by_label.values()), columns, markerscale=0.6)
        for panel in panels:
            panel.label_outer()
    return picture


def _curves(sheet, table, over, merits):
    """Draw figures of merit over each of some parameters."""
    rows = [[f"{of.words} over {each.words}" for each in over] for of, *_ in merits]
    picture, panels = sheet.mosaic(rows, (min(3.4 * len(over), 12) + 0.6, 3.4 * len(rows)))
    points = np.arange(len(table))[:: max(1, len(table) // MOST_POINTS)]
    style = dict(marker=".", ls="none", ms=2, alpha=0.5) if len(over) > 1 else {}
    for row, (of, column, marks) in zip(np.reshape(panels, (len(rows), -1)), merits):
        for k, axes in enumerate(row):
            order = points[np.argsort(table[points, k], kind="stable")]
            axes.plot(table[order, k], column[order], color=BLUE, **style)
            for words, marker, place in marks:
                nearest = np.nanargmin(np.abs(table - place).sum(axis=1))
                value = column[nearest]
                draw(axes, "mark.chosen", place[k], value, marker=marker, label=words)
            axes.set(xlabel=str(over[k]), ylabel="" if k else str(of))
            axes.grid(alpha=0.25)
    return _explained(picture, panels, sheet)


def _atlas(sheet, columns, values, quantities):
    """Liu's plane of the design space r1 + r2 + r3 = 3: x = (2 r1 + r3) / sqrt 3, y = r3."""
    x = (2 * columns["r1"] + columns["r3"]) / np.sqrt(3)
    y = columns["r3"]
    corners = np.array([(3, 0, 0), (0, 3, 0), (0, 1.5, 1.5), (1.5, 0, 1.5), (3, 0, 0)])
    places = np.column_stack([(2 * corners[:, 0] + corners[:, 2]) / np.sqrt(3), corners[:, 2]])
    picture, panels = sheet.grid(list(values), 2, 6.1, 3.9)
    for axes, (name, column) in zip(panels, values.items()):
        of = quantities[name]
        filled = _filled(axes, x, y, of.factor * column, _levels(of.factor * column))
        axes.figure.colorbar(filled, ax=axes, label=str(of), shrink=0.75)
        axes.plot(*places.T, color=BLACK, lw=1)
        for (a, b, c), place, side in zip(corners, places, ("left", "right", "right", "left")):
            offset = dict(xytext=(4 if side == "left" else -4, 3), textcoords="offset points")
            axes.annotate(f"({a:g}, {b:g}, {c:g})", place, ha=side, fontsize=7, **offset)
        axes.set(facecolor="none", xlim=(-0.6, 4.1), ylim=(-0.15, 1.65), aspect="equal")
        axes.set(xlabel=r"$(2 r_1 + r_3) / \sqrt{3}$", ylabel=r"$r_3$")
        axes.set_title(r"$r_1 + r_2 + r_3 = 3$")
    return picture


def draw_design(design: Design, sheet: Sheet) -> Figure:
    """Draw a robot over its table."""
    picture, panels = sheet.mosaic([["robot"]], (4.6, 4.2))
    _robots(panels, [design])
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


def draw_front(front: Front, sheet: Sheet, robots: int = 5) -> Figure:
    """Draw a front, and robots along it, to one scale, with their numbers in the front's order."""
    goals = [quantity(name, front[name], front.units[name]) for name in front.goals]
    x, y, *more = (goal.factor * front[name] for goal, name in zip(goals, front.goals))
    titles = [f"{goal}, {way}" for goal, way in zip(goals, front.goals.values())]
    places = np.linspace(0, len(front) - 1, min(robots, len(front)))
    chosen = {int(k) + 1: k for k in np.unique(places.round().astype(int))}
    names = [f"robot {number}" for number in chosen]
    rows = [["front"] * len(names), names]
    picture, (axes, *panels) = sheet.mosaic(rows, (11, 7.2), height_ratios=(1.35, 1))
    if more:
        points = axes.scatter(x, y, c=more[0], cmap=PALETTES["lines"], s=36, zorder=2)
        axes.figure.colorbar(points, ax=axes, label=titles[2])
    else:
        draw(axes, "mark.front", x, y)
    text = dict(textcoords="offset points", color=RUST, weight="bold")
    for number, k in chosen.items():
        draw(axes, "mark.chosen", x[k], y[k])
        axes.annotate(str(number), (x[k], y[k]), (9, 7), **text)
    axes.margins(0.06, 0.1)
    axes.set(xlabel=titles[0], ylabel=titles[1])
    axes.grid(alpha=0.25)
    _robots(panels, [front.designs[k] for k in chosen.values()])
    for panel, (number, k) in zip(panels, chosen.items()):
        parameters = front.designs[k].parameters.items()
        lengths = [f"{name} {1e3 * value:.4g}" for name, value in parameters if name[0] in "ld"]
        unit = " mm" if lengths else ""
        panel.set_title(f"robot {number}\n{', '.join(lengths)}{unit}", fontsize=small_letters())
    return picture
