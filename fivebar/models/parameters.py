"""A robot's parameters as a list, from a list, and by name from a file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from .robots import KINDS, Biglide, FiveBar


def names_of(robots: Iterable[FiveBar | Biglide]) -> tuple[str, ...]:
    """The parameters that any of these robots names beyond its kind's own, in the order of the class."""
    robots = list(robots)
    asked = set().union(*(robot.parameters for robot in robots))
    return tuple(f.name for f in _beyond(type(robots[0])) if f.name in asked)


def parameters_of(robot: FiveBar | Biglide, names: Iterable[str] | None = None) -> list:
    """The robot's parameters: its kind's own in the order of the class, then those named; gravity is two."""
    names = names_of([robot]) if names is None else names
    found = []
    for name in (*(f.name for f in _own(type(robot))), *names):
        value = getattr(robot, name)
        found += value if name == "gravity" else [value]
    return found


def count_of(kind: type, names: Iterable[str] = ()) -> int:
    """How many numbers `parameters_of` gives."""
    return len(_own(kind)) + sum(2 if name == "gravity" else 1 for name in names)


def with_parameters(kind: type, p: Any, names: Iterable[str] = ()) -> FiveBar | Biglide:
    """The robot of a kind with these parameters in the order of `parameters_of`, a CasADi vector for instance."""
    given, k = {}, 0
    for name in (*(f.name for f in _own(kind)), *names):
        given[name] = (p[k], p[k + 1]) if name == "gravity" else p[k]
        k += 2 if name == "gravity" else 1
    return kind(**given)


def _own(kind):
    return fields(kind)[: kind.lab]


def _beyond(kind):
    return fields(kind)[kind.lab :]


def robot_of(parameters: dict[str, Any]) -> FiveBar | Biglide:
    """The robot with these parameters {name: value}: of the first kind that has them all, ValueError if none has."""
    for kind in KINDS:
        if set(parameters) <= {f.name for f in fields(kind)}:
            return kind(**parameters)
    known = [f"{', '.join(f.name for f in _own(kind))} ({kind.words.title})" for kind in KINDS]
    unknown = min((sorted(set(parameters) - {f.name for f in fields(kind)}) for kind in KINDS), key=len)
    more = dict.fromkeys(f.name for kind in KINDS for f in _beyond(kind))
    raise ValueError(
        f"no parameter {', '.join(unknown)}; the known ones are {' or '.join(known)}; and beyond these "
        + ", ".join(more)
    )
