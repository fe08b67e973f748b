"""Figures of merit: what a robot is worth, by name; a user's own function of a robot is one too."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.backend import is_symbolic
from ..base.checks import shown
from ..models.robots import Biglide, FiveBar
from .batch import at_once, checked, place_of_design, robot_of_design
from .closed_forms import CLOSED
from .one_by_one import ONE_BY_ONE
from .over_poses import BLOCK, OVER_POSES, Poses
from .task import Task


@dataclass(frozen=True)
class Figure:
    """A named function of robots.

    of: of the kind "closed" (robots in columns (n, 1)) -> (n,), "poses" (Poses) -> (n,), "own"
    (robot) -> float, "single" (robot, Task) -> float; better: whether "large" or "small" ones are;
    needs: what a Task must have;
    bound: (robots, Task) -> a value that no robot of these or smaller (see `bounds`) lengths can
        pass.
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
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @property
    def about(self) -> dict[str, str]:
        """What a manifest says of it; of a user's function a hash of what it does."""
        return {"name": self.name, "kind": self.kind} | (
            {"code": _code(self.of)} if self.kind == "own" else {}
        )


FIGURES: dict[str, Figure] = {
    each[0]: Figure(each[0], each[1], each[2], each[3], kind, *each[4:])
    for kind, rows in (("closed", CLOSED), ("poses", OVER_POSES), ("single", ONE_BY_ONE))
    for each in rows
}


def figures_of(
    asked: Any, task: Task, robot: FiveBar | Biglide, what: str = "figure"
) -> tuple[Figure, ...]:
    """The Figures that are asked for: a name, a function, a Figure, a list of them, or {name:
    function}.
    """
    if isinstance(asked, Mapping):
        found = [_own(each, name, what) for name, each in asked.items()]
    elif isinstance(asked, (str, Figure)) or callable(asked):
        found = [_one(asked, what)]
    elif isinstance(asked, Iterable) and getattr(asked, "ndim", 1) and not is_symbolic(asked):
        found = [_one(each, what) for each in asked]
    else:
        found = [_one(asked, what)]
    if not found:
        raise ValueError(f"{what}: none is asked for; the known ones are {', '.join(FIGURES)}")
    names = [each.name for each in found]
    if len(set(names)) < len(names):
        raise ValueError(f"{what}: {max(names, key=names.count)} is asked for twice")
    for each in found:
        if each.kind != "own" and not isinstance(robot, FiveBar):
            raise ValueError(
                f"{what}: {each.name} is of five-bars; of a {robot.words.title} give your own"
                " function"
            )
        for need in each.needs:
            if not (task.table or task.disc if need == "table" else getattr(task, need)):
                also = " or disc=radius" if need == "table" else ""
                raise ValueError(f"{what}: {each.name} needs {need}=...{also}: {each.words}")
    return tuple(found)


def _one(asked, what):
    if isinstance(asked, Figure):
        return asked
    if isinstance(asked, str):
        if asked not in FIGURES:
            raise ValueError(
                f"{what}: no figure {shown(asked)}; the known ones are {', '.join(FIGURES)}"
            )
        return FIGURES[asked]
    return _own(asked, getattr(asked, "__name__", "own"), what)


def _own(of, name, what):
    if isinstance(of, Figure):
        return of
    if not callable(of) or isinstance(of, type):
        raise TypeError(
            f"{what} must be a name, a function of a robot or a list of these, not {shown(of)}"
        )
    if not isinstance(name, str) or not name:
        raise TypeError(f"{what}: a name must be a string, not {shown(name)}")
    return Figure(name, "", "large", "", "own", of)


def _code(function):
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        text = (
            repr((code.co_code, code.co_consts, code.co_names))
            if code
            else type(function).__qualname__
        )
    return hashlib.sha256(text.encode()).hexdigest()


def evaluate(
    figures: Sequence[Figure],
    names: tuple[str, ...],
    rows: np.ndarray,
    robot: FiveBar | Biglide,
    task: Task,
) -> tuple[np.ndarray, list[tuple[int, str]]]:
    """(values (n, len(figures)), [(row, what went wrong), ...]) of designs (n, len(names)); nan
    where it went wrong.
    """
    values = np.full((len(rows), len(figures)), np.nan)
    good, errors = checked(names, rows, robot)
    chosen = np.flatnonzero(good)
    at_columns = [k for k, figure in enumerate(figures) if figure.kind == "closed"]
    at_poses = [k for k, figure in enumerate(figures) if figure.kind == "poses"]
    if at_columns and len(chosen):
        robots = at_once(names, rows[chosen], robot)
        for k in at_columns:
            values[chosen, k] = figures[k].of(robots)
    if at_poses and len(chosen):
        np.empty(
            2**21
            # Once so much was freed, glibc keeps smaller things: a quarter of the time, else page
            # faults.
        )
        place = place_of_design(names, rows)
        step = max(1, BLOCK // len(task.nodes[0]))
        for start in range(0, len(chosen), step):
            part = chosen[start : start + step]
            poses = Poses(at_once(names, rows[part], robot), task, place[part])
            for k in at_poses:
                values[part, k] = figures[k].of(poses)
    one_by_one = [k for k, figure in enumerate(figures) if figure.kind in ("own", "single")]
    if one_by_one:
        place = place_of_design(names, rows)
        for n in chosen:
            one = robot_of_design(names, rows[n], robot)
            for k in one_by_one:
                try:
                    values[n, k] = _value(figures[k], one, task, place[n])
                except (
                    Exception
                ) as error:  # whatever somebody's own function raises: the other designs go on
                    errors.append(
                        (
                            int(n),
                            (
                                f"{figures[k].name}: {type(error).__name__}:"
                                f" {' '.join(str(error).split())}"
                            ),
                        )
                    )
    return values, sorted(errors)


def _value(figure, robot, task, place):
    value = figure.of(robot) if figure.kind == "own" else figure.of(robot, task, place)
    if np.ndim(value) or isinstance(value, (str, bytes)) or value is None:
        raise TypeError(f"it must give one number, not {shown(value)}")
    return float(value)
