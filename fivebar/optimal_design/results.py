"""What `design` gives: a robot with what holds it, and fronts of them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import number, strings, table_of, text
from ..base.presentation import Paged, Plotted
from ..base.representation import one_line
from ..base.tables import STRANGE, TextFile, write, written
from ..models.parameters import robot_of
from ..models.robots import Biglide, FiveBar
from .batch import PLACE
from .task import Task, task_of

if TYPE_CHECKING:
    pass


AT_LIMIT = 1e-3  # of a bound's range, or of a limit, within which it is said to bind
FRONT, ROBOTS, PAGE = "front.json", "robots", "index.html"
WHAT = "fivebar designs"


@dataclass(frozen=True, eq=False)
class Design(Plotted, Paged):
    """A robot found by `design`.

    parameters: what varied; values: of goals and limits, goals: each "min" or "max"; binding:
    sentences on the bounds and limits that hold it; unpassed: {goal: what no robot within the
    bounds can pass}, where that is known; task.
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
        notes = [
            f"{name} = {self.values[name]:.6g} {self.units[name]}".rstrip() for name in self.goals
        ]
        return one_line(
            "Design", *notes, ", ".join(f"{k} = {v:.6g}" for k, v in self.parameters.items())
        )

    @property
    def place(self) -> np.ndarray:
        """Where the task's origin is, (2,) m."""
        return np.array([self.parameters.get(name, 0.0) for name in PLACE])

    @property
    def gaps(self) -> dict[str, float]:
        """{goal: how far it is from what no robot can pass, as a share of that}."""
        return {
            name: abs(self.values[name] - best) / max(abs(best), 1e-300)
            for name, best in self.unreached_bounds.items()
        }

    @property
    def report(self) -> str:
        """What it is and what holds it, line by line."""
        lines = [f"{name} = {value:.6g}" for name, value in self.parameters.items()]
        for name, value in self.values.items():
            goal = f" ({self.goals[name]})" if name in self.goals else ""
            lines.append(f"{name} = {value:.6g} {self.units[name]}".rstrip() + goal)
        held = "its goals hold one another" if len(self.goals) > 1 else "the optimum is inside"
        lines += self.binding or (f"no bound and no limit binds: {held}",)
        for name, gap in self.gaps.items():
            best = f"no robot within the bounds passes {name} = {self.unreached_bounds[name]:.6g}"
            lines.append(f"{best}; this one is {100 * gap:.3g} % off")
        for name in self.goals:
            if name not in self.unreached_bounds:
                lines.append(f"of {name} no bound is known: it is the best that was found")
        return "\n".join(lines)

    def to_robot_file(self, file: TextFile) -> None:
        """The robot's parameters as JSON, which every command takes as --robot FILE."""
        with written(file) as out:
            out.write(json.dumps(_plain(self.robot), indent=1) + "\n")

    def save(self, file: TextFile) -> None:
        """All of it as JSON, which `load` reads."""
        _save(file, (self,))

    @classmethod
    def load(cls, file: str | os.PathLike) -> Design:
        """The Design in a file. Of a motion or a path not the points were kept."""
        return _load(Path(file))[0]

    def as_json(self) -> dict:
        return {
            "parameters": dict(self.parameters),
            "robot": _plain(self.robot),
            "kind": type(self.robot).__name__,
            "values": dict(self.values),
            "goals": dict(self.goals),
            "units": dict(self.units),
            "binding": list(self.binding),
            "unreached_bounds": dict(self.unreached_bounds),
        }


@dataclass(frozen=True, eq=False)
class Front(Plotted, Paged):
    """Designs of which none is better than another in all goals, in the order of the first goal;
    from `design`.
    """

    designs: tuple[Design, ...]

    def __repr__(self) -> str:
        ranges = [
            f"{name} from {self[name].min():.6g} to {self[name].max():.6g} {self.units[name]}".rstrip()
            for name in self.goals
        ]
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
        return tuple(each.robot for each in self.designs)

    def __getitem__(self, name: str) -> np.ndarray:
        """A column (n,): of a goal, a limit or what varied."""
        return np.array(
            [
                (each.values if name in each.values else each.parameters)[name]
                for each in self.designs
            ]
        )

    @property
    def knee(self) -> Design:
        """The design nearest to the best of all goals, each goal measured by the front's range."""
        f = np.stack(
            [
                self[name] * (1 if way in ("min", "small") else -1)
                for name, way in self.goals.items()
            ],
            axis=1,
        )
        share = (f - f.min(axis=0)) / np.maximum(np.ptp(f, axis=0), 1e-300)
        return self.designs[int(np.argmin(np.linalg.norm(share, axis=1)))]

    def to_csv(self, file: TextFile) -> None:
        """A row per design: what varied, then goals and limits."""
        first = self.designs[0]
        header = (*first.parameters, *first.values)
        rows = [[*each.parameters.values(), *each.values.values()] for each in self.designs]
        write(file, "front", {"goals": dict(self.goals), "choices": first.task.about}, header, rows)

    def save(self, folder: str | os.PathLike) -> None:
        """front.json, which `load` reads, front.csv, front.png, robots/01.json ... for --robot, and
        index.html.

        That page has the picture and a table; each robot's link opens it on the live page,
        play.html beside it.
        """
        folder = Path(folder)
        (folder / ROBOTS).mkdir(parents=True, exist_ok=True)
        _save(folder / FRONT, self.designs)
        self.to_csv(folder / "front.csv")
        self.plot(folder / "front.png")
        for k, each in enumerate(self.designs, start=1):
            each.to_robot_file(folder / ROBOTS / f"{k:02d}.json")
        k = len(self.designs) + 1
        while (
            old := folder / ROBOTS / f"{k:02d}.json"
        ).exists():  # of a longer front that was here before
            old.unlink()
            k += 1
        self.page(folder / PAGE)

    @classmethod
    def load(cls, folder: str | os.PathLike) -> Front:
        """The Front in a folder. Of a motion or a path not the points were kept."""
        return cls(_load(Path(folder) / FRONT))


def _save(file, designs):
    about = {
        "what": WHAT,
        "choices": designs[0].task.about,
        "designs": [each.as_json() for each in designs],
    }
    with written(file) as out:
        out.write(json.dumps(about, indent=1) + "\n")


def _load(file):
    try:
        about = json.loads(file.read_text(encoding="utf-8"))
        if about["what"] != WHAT:
            raise ValueError(f"it is of {about['what']!r}")
        choices = {
            name: value
            for name, value in about["choices"].items()
            if name not in ("motion", "path")
        }
        if "motor" in choices:
            choices["motor"] = tuple(choices["motor"].values())
        task = task_of(choices)
        if not about["designs"]:
            raise ValueError("it has none")
        return tuple(_design(each, task) for each in about["designs"])
    except FileNotFoundError:
        raise ValueError(f"{file} holds no designs: there is no such file") from None
    except STRANGE as error:
        raise ValueError(
            f"{file} is not what a design left there ({type(error).__name__}: {error})"
        ) from None


def _design(known, task):
    robot = robot_of(
        {name: tuple(v) if isinstance(v, list) else v for name, v in known["robot"].items()}
    )
    rules = dict.fromkeys(("parameters", "values", "unreached_bounds"), number) | dict.fromkeys(
        ("goals", "units"), text
    )
    parts = {name: table_of(rule)(known[name], name) for name, rule in rules.items()}
    if not (
        parts["goals"].keys() | parts["unreached_bounds"].keys()
        <= parts["values"].keys()
        <= parts["units"].keys()
    ):
        raise ValueError("its goals, values and units are not of the same figures")
    return Design(
        robot=robot, binding=tuple(strings(known["binding"], "binding")), task=task, **parts
    )


def _plain(robot):
    return {name: list(v) if isinstance(v, tuple) else v for name, v in robot.parameters.items()}
