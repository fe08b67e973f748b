"""Results of `design`: a design with its active bounds and limits, and fronts of designs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import number, strings, table_of, text
from ..base.folders import locked_folder
from ..base.presentation import Paged, Plotted
from ..base.representation import one_line
from ..base.tables import STRANGE, TextFile, write, written
from ..models.parameters import robot_of
from ..models.robots import Biglide, FiveBar
from .batch import PLACE
from .task import Task, task_of

AT_LIMIT = 1e-3  # of a bound's range, or of a limit: what is nearer is called active
FRONT = "front.json"
ROBOTS = "robots"
WHAT = "fivebar designs"


@dataclass(frozen=True, eq=False)
class Design(Plotted, Paged):
    """A robot from `design`, with its active bounds and limits.

    Parameters
    ----------
    parameters : mapping
        What varied.
    robot : FiveBar or Biglide
    values, units : mapping
        Of goals and limits, by figure.
    goals : mapping
        {figure: "min" or "max"}.
    binding : tuple of str
        A sentence on each active bound and limit.
    unreached_bounds : mapping
        {goal: what no robot within the bounds passes}, where it is known.
    task : Task
    """

    parameters: Mapping[str, float]
    robot: FiveBar | Biglide
    values: Mapping[str, float]
    goals: Mapping[str, str]
    units: Mapping[str, str] = field(repr=False)
    binding: tuple[str, ...] = field(repr=False)
    unreached_bounds: Mapping[str, float] = field(repr=False)
    task: Task = field(repr=False)

    def __repr__(self) -> str:
        goals = [self._value(name) for name in self.goals]
        parameters = ", ".join(f"{k} = {v:.6g}" for k, v in self.parameters.items())
        return one_line("Design", *goals, parameters)

    def _value(self, name):
        return f"{name} = {self.values[name]:.6g} {self.units[name]}".rstrip()

    @property
    def place(self) -> np.ndarray:
        """The task's origin, (2,) m."""
        return np.array([self.parameters.get(name, 0.0) for name in PLACE])

    @property
    def gaps(self) -> dict[str, float]:
        """{goal: distance from its unreached bound, as a share of that}."""
        return {
            name: abs(self.values[name] - best) / max(abs(best), 1e-300)
            for name, best in self.unreached_bounds.items()
        }

    @property
    def report(self) -> str:
        """The design, its active bounds and limits, and its gaps, line by line."""
        lines = [f"{name} = {value:.6g}" for name, value in self.parameters.items()]
        for name in self.values:
            goal = f" ({self.goals[name]})" if name in self.goals else ""
            lines.append(self._value(name) + goal)
        lines += self.binding or ("no bound and no limit binds",)
        for name, gap in self.gaps.items():
            bound = f"{name} = {self.unreached_bounds[name]:.6g}"
            lines.append(
                f"no robot within the bounds passes {bound}; this one is {100 * gap:.3g} % off"
            )
        for name in self.goals:
            if name not in self.unreached_bounds:
                lines.append(f"of {name} no bound is known: it is the best that was found")
        return "\n".join(lines)

    def to_robot_file(self, file: TextFile) -> None:
        """Write the robot's parameters as JSON, which every command takes as --robot FILE."""
        _write_json(file, plain_parameters(self.robot))

    def save(self, file: TextFile) -> None:
        """Write all of it as JSON, which `load` reads."""
        _save(file, (self,))

    @classmethod
    def load(cls, file: str | os.PathLike) -> Design:
        """Return the Design in a file, without the points of its motion or path."""
        return _load(Path(file))[0]

    def as_json(self) -> dict:
        """Return what `save` writes."""
        return {
            "parameters": dict(self.parameters),
            "robot": plain_parameters(self.robot),
            "values": dict(self.values),
            "goals": dict(self.goals),
            "units": dict(self.units),
            "binding": list(self.binding),
            "unreached_bounds": dict(self.unreached_bounds),
        }


@dataclass(frozen=True, eq=False)
class Front(Plotted, Paged):
    """A Pareto front, from `design`: designs of which none is better than another in all goals.

    Attributes
    ----------
    designs : tuple of Design
        In the order of the first goal.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.optimal_design.Front(()).designs
    ()
    """

    designs: tuple[Design, ...]

    def __repr__(self) -> str:
        ranges = []
        for name in self.goals:
            low = self[name].min()
            high = self[name].max()
            ranges.append(f"{name} from {low:.6g} to {high:.6g} {self.units[name]}".rstrip())
        return one_line("Front", f"{len(self.designs)} designs", *ranges)

    def __len__(self) -> int:
        return len(self.designs)

    @property
    def goals(self) -> Mapping[str, str]:
        return self.designs[0].goals

    @property
    def units(self) -> Mapping[str, str]:
        return self.designs[0].units

    @property
    def robots(self) -> tuple:
        return tuple(design.robot for design in self.designs)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column (n,): of a goal, a limit or what varied."""
        return np.array([{**one.parameters, **one.values}[name] for one in self.designs])

    @property
    def knee(self) -> Design:
        """The design nearest to the best of all goals, each measured by the front's range."""
        signs = [1 if sense == "min" else -1 for sense in self.goals.values()]
        f = np.stack([self[name] for name in self.goals], axis=1) * signs
        share = (f - f.min(axis=0)) / np.maximum(np.ptp(f, axis=0), 1e-300)
        return self.designs[int(np.argmin(np.linalg.norm(share, axis=1)))]

    def to_csv(self, file: TextFile) -> None:
        """Write a row per design: what varied, then goals and limits."""
        first = self.designs[0]
        about = {"goals": dict(self.goals), "choices": first.task.about}
        rows = [[*one.parameters.values(), *one.values.values()] for one in self.designs]
        write(file, "front", about, (*first.parameters, *first.values), rows)

    def save(self, folder: str | os.PathLike) -> None:
        """Write front.json, which `load` reads, front.csv, front.png, robots/*.json and a page.

        The page index.html has the picture and a table; each robot's link opens it on the live
        page, index_live.html in the same folder.
        """
        folder = Path(folder)
        robots = folder / ROBOTS
        with locked_folder(folder, parts=(ROBOTS,)):
            for file in robots.glob("[0-9][0-9]*.json"):  # of a front that was here before
                file.unlink()
            _save(folder / FRONT, self.designs)
            self.to_csv(folder / "front.csv")
            self.plot(folder / "front.png")
            for k, design in enumerate(self.designs, start=1):
                design.to_robot_file(robots / f"{k:02d}.json")
            self.page(folder / "index.html")

    @classmethod
    def load(cls, folder: str | os.PathLike) -> Front:
        """Return the Front in a folder, without the points of its motion or path."""
        return cls(_load(Path(folder) / FRONT))


def _save(file, designs):
    designs_json = [design.as_json() for design in designs]
    _write_json(file, {"what": WHAT, "choices": designs[0].task.about, "designs": designs_json})


def _write_json(file, value):
    with written(file) as out:
        out.write(json.dumps(value, indent=1) + "\n")


def _load(file):
    try:
        about = json.loads(file.read_text(encoding="utf-8"))
        if about["what"] != WHAT:
            raise ValueError(f"it is of {about['what']!r}")
        choices = dict(about["choices"])
        for name in ("motion", "path"):
            choices.pop(name, None)
        if not about["designs"]:
            raise ValueError("it has none")
        task = task_of(choices)
        return tuple(_design(values, task) for values in about["designs"])
    except FileNotFoundError:
        raise ValueError(f"{file} holds no designs: there is no such file") from None
    except STRANGE as error:
        raise ValueError(
            f"{file} is not what a design left there ({type(error).__name__}: {error})"
        ) from None


def _design(known, task):
    rules = {"parameters": number, "values": number, "unreached_bounds": number}
    rules |= {"goals": text, "units": text}
    parts = {name: table_of(rule)(known[name], name) for name, rule in rules.items()}
    named = parts["goals"].keys() | parts["unreached_bounds"].keys()
    if not named <= parts["values"].keys() <= parts["units"].keys():
        raise ValueError("its goals, values and units are not of the same figures")
    binding = tuple(strings(known["binding"], "binding"))
    return Design(robot=robot_of_plain(known["robot"]), binding=binding, task=task, **parts)


def plain_parameters(robot: FiveBar | Biglide) -> dict:
    """Return a robot's parameters as JSON has them, lists for tuples."""
    return json.loads(json.dumps(robot.parameters))


def robot_of_plain(parameters: Mapping[str, Any]) -> FiveBar | Biglide:
    """Return the robot of `plain_parameters`."""
    pairs = parameters.items()
    return robot_of({name: tuple(v) if isinstance(v, list) else v for name, v in pairs})
