"""Figures of merit by name; a user's own function of a robot is one too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import shown
from ..base.errors import warn
from ..base.progress import progress
from ..base.shards import code_hash
from ..models.robots import Biglide, FiveBar
from .batch import (
    LENGTHS,
    PLACE,
    place_of_design,
    robot_of_design,
    robots_of_designs,
    valid_rows,
    varied_parameters,
)
from .closed_forms import CLOSED
from .one_by_one import ONE_BY_ONE
from .over_poses import BLOCK, OVER_POSES, TaskPoses
from .task import Task

OF_INERTIAS = "worst_torque", "time", "path_time"


@dataclass(frozen=True)
class Figure:
    """A figure of merit: a named function of robots.

    Parameters
    ----------
    name, unit : str
    better : {"large", "small"}
    words : str
        What it is.
    kind : {"closed", "poses", "own", "single"}
        What `of` takes and gives: "closed" (robots in columns (n, 1)) -> (n,), "poses"
        (TaskPoses) -> (n,), "own" (robot) -> float, "single" (robot, Task, place) -> float.
    of : callable
    needs : tuple of str
        What the task must name.
    bound : callable or None
        (robots, Task) -> a value that no robot of these, or shorter, lengths passes.
    """

    name: str
    unit: str
    better: str
    words: str
    kind: str
    of: Callable
    needs: tuple[str, ...] = ()
    bound: Callable | None = None

    @property
    def label(self) -> str:
        if self.unit:
            return f"{self.name} ({self.unit})"
        return self.name

    @property
    def about(self) -> dict[str, str]:
        """The name for a manifest; of a user's function also a hash of its source."""
        about = {"name": self.name, "kind": self.kind}
        if self.kind == "own":
            about["code"] = code_hash(self.of)
        return about


FIGURES: dict[str, Figure] = {}
for _kind, _rows in (("closed", CLOSED), ("poses", OVER_POSES), ("single", ONE_BY_ONE)):
    for _name, _unit, _better, _words, *_rest in _rows:
        FIGURES[_name] = Figure(_name, _unit, _better, _words, _kind, *_rest)


def figures_of(
    request: Any, task: Task, robot: FiveBar | Biglide, argument: str = "figure"
) -> tuple[Figure, ...]:
    """Return the Figures of a name, a function, a Figure, a list of them, or {name: function}."""
    if isinstance(request, Mapping):
        figures = [_of_function(function, name, argument) for name, function in request.items()]
    else:
        requests = request if isinstance(request, (list, tuple)) else [request]
        figures = [_figure(item, argument) for item in requests]
    if not figures:
        raise ValueError(f"{argument}: none is asked for; the known ones are {', '.join(FIGURES)}")
    names = [figure.name for figure in figures]
    if len(set(names)) < len(names):
        raise ValueError(
            f"{argument}: {max(names, key=names.count)} is asked for twice; give functions of one"
            " name as {name: function}"
        )
    for figure in figures:
        if figure.kind != "own" and not isinstance(robot, FiveBar):
            raise ValueError(
                f"{argument}: {figure.name} is of five-bars; of a {robot.words.title} give a"
                " function of your own"
            )
        for need in figure.needs:
            or_disc = " or disc=radius" if need == "table" else ""
            if not (getattr(task, need) or or_disc and task.disc):
                raise ValueError(
                    f"{argument}: {figure.name} needs {need}=...{or_disc}: {figure.words}"
                )
    return tuple(figures)


def warn_of_inertias(
    figures: Sequence[Figure], names: Sequence[str], robot: FiveBar | Biglide
) -> None:
    """Warn where lengths of bars vary, figures depend on inertias, and these do not follow."""
    varied = varied_parameters(names, robot)
    bars = [name for name in LENGTHS[:4] if name in varied]
    depend = [figure.name for figure in figures if figure.name in OF_INERTIAS]
    if bars and depend and not (robot.links or varied - {*LENGTHS, *PLACE}):
        warn(
            f"{', '.join(depend)}: the robot's masses and inertias stay as they are whatever"
            f" {', '.join(bars)} are; those of links, as FiveBar.from_links and [links] in a file"
            " have them, follow the lengths"
        )


def _figure(request, argument):
    if isinstance(request, Figure):
        return request
    if not isinstance(request, str):
        return _of_function(request, getattr(request, "__name__", "own"), argument)
    if request not in FIGURES:
        raise ValueError(
            f"{argument}: no figure {shown(request)}; the known ones are {', '.join(FIGURES)}"
        )
    return FIGURES[request]


def _of_function(function, name, argument):
    if isinstance(function, Figure):
        return function
    if not callable(function) or isinstance(function, type):
        raise TypeError(
            f"{argument} must be a name, a function of a robot or a list of these, not"
            f" {shown(function)}"
        )
    if not isinstance(name, str) or not name:
        raise TypeError(f"{argument}: a name must be a string, not {shown(name)}")
    return Figure(name, "", "large", "", "own", function)


def evaluate(
    figures: Sequence[Figure],
    names: tuple[str, ...],
    rows: np.ndarray,
    robot: FiveBar | Biglide,
    task: Task,
) -> tuple[np.ndarray, list[tuple[int, str]]]:
    """Return (values (n, len(figures)), [(row, error), ...]) of designs (n, len(names)).

    Values of what went wrong are nan.
    """
    values = np.full((len(rows), len(figures)), np.nan)
    valid, errors = valid_rows(names, rows, robot)
    chosen = np.flatnonzero(valid)
    place = place_of_design(names, rows)
    closed = [k for k, figure in enumerate(figures) if figure.kind == "closed"]
    over_poses = [k for k, figure in enumerate(figures) if figure.kind == "poses"]
    one_by_one = [k for k, figure in enumerate(figures) if figure.kind in ("single", "own")]
    if closed:
        robots = robots_of_designs(names, rows[chosen], robot)
        for k in closed:
            values[chosen, k] = figures[k].of(robots)
    if over_poses:
        # Once so much was freed, glibc keeps smaller arrays: it saves a quarter of the time.
        np.empty(2**21)
        step = max(1, BLOCK // len(task.nodes[0]))
        for start in range(0, len(chosen), step):
            part = chosen[start : start + step]
            poses = TaskPoses(robots_of_designs(names, rows[part], robot), task, place[part])
            for k in over_poses:
                values[part, k] = figures[k].of(poses)
    if one_by_one:
        for n in progress(chosen.tolist(), desc="designs", delay=2, leave=False):
            single = robot_of_design(names, rows[n], robot)
            for k in one_by_one:
                try:
                    values[n, k] = _value(figures[k], single, task, place[n])
                except Exception as error:  # A user's function may raise: other designs go on.
                    message = " ".join(str(error).split())
                    errors.append((n, f"{figures[k].name}: {type(error).__name__}: {message}"))
    return values, sorted(errors)


def _value(figure, robot, task, place):
    if figure.kind == "own":
        value = figure.of(robot)
    else:
        value = figure.of(robot, task, place)
    if np.ndim(value) or isinstance(value, (str, bytes)) or value is None:
        raise TypeError(f"it must give one number, not {shown(value)}")
    return float(value)
