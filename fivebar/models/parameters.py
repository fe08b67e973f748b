"""A robot's parameters as a list, from a list, and by name from a file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from inspect import signature
from typing import Any

from .links import Link
from .robots import KINDS, Biglide, FiveBar, Robot


def names_of(robots: Iterable[Robot]) -> tuple[str, ...]:
    """The parameters that any of these robots names beyond its kind's own, in the order of the
    class.
    """
    robots = list(robots)
    asked = set().union(*(robot.parameters for robot in robots))
    return tuple(f.name for f in _beyond(type(robots[0])) if f.name in asked)


def parameters_of(robot: Robot, names: Iterable[str] | None = None) -> list:
    """The robot's parameters: its kind's own in the order of the class, then those named; gravity
    is two.
    """
    names = names_of([robot]) if names is None else names
    found: list = []
    for name in (*(f.name for f in _own(type(robot))), *names):
        value = getattr(robot, name)
        found += value if name == "gravity" else [value]
    return found


def count_of(kind: type, names: Iterable[str] = ()) -> int:
    """How many numbers `parameters_of` gives."""
    return len(_own(kind)) + sum(2 if name == "gravity" else 1 for name in names)


def with_parameters(kind: type, p: Any, names: Iterable[str] = ()) -> FiveBar | Biglide:
    """The robot of a kind with these parameters in the order of `parameters_of`, a CasADi vector
    for instance.
    """
    given = {}
    k = 0
    for name in (*(f.name for f in _own(kind)), *names):
        given[name] = (p[k], p[k + 1]) if name == "gravity" else p[k]
        k += 2 if name == "gravity" else 1
    return kind(**given)


def _own(kind):
    return fields(kind)[: kind.lab]


def _beyond(kind):
    return fields(kind)[kind.lab :]


def robot_of(parameters: dict[str, Any]) -> FiveBar | Biglide:
    """The robot with these parameters {name: value}: of the first kind that has them all,
    ValueError if none has.

    With "links" it is a five-bar of bars as they are built, the arguments of `FiveBar.from_links`:
    each link its mass or a table of Link's arguments, with inertia_about_centre in place of inertia
    where it is that.
    """
    if "links" in parameters:
        return _of_links(dict(parameters))
    for kind in KINDS:
        if set(parameters) <= {f.name for f in fields(kind)}:
            return kind(**parameters)
    known = []
    strange = []
    for kind in KINDS:
        names = ", ".join(f.name for f in _own(kind))
        known.append(f"{names} ({kind.words.title})")
        strange.append(sorted(set(parameters) - {f.name for f in fields(kind)}))
    unknown = min(strange, key=len)
    more = dict.fromkeys(f.name for kind in KINDS for f in _beyond(kind))
    raise ValueError(
        f"no parameter {', '.join(unknown)}; the known ones are {' or '.join(known)}; and beyond"
        " these " + ", ".join(more)
    )


def _of_links(parameters):
    known = list(signature(FiveBar.from_links).parameters)
    if unknown := sorted(set(parameters) - set(known)):
        raise ValueError(
            f"no parameter {', '.join(unknown)} of a robot of links; the known ones are"
            f" {', '.join(known)}"
        )
    if missing := [name for name in known[:6] if name not in parameters]:
        raise ValueError(f"a robot of links needs {', '.join(missing)} too")
    links = parameters.pop("links")
    if isinstance(links, dict):
        links = {name: _link(name, link) for name, link in links.items()}
    return FiveBar.from_links(links=links, **parameters)


def _link(name, link):
    if not isinstance(link, dict):
        return link
    about = "inertia_about_centre"
    known = ("mass", "x", "y", "inertia")
    if unknown := sorted(set(link) - {*known, about}):
        raise ValueError(
            f"links.{name}: no {', '.join(unknown)}; the known ones are"
            f" {', '.join((*known, about))}"
        )
    needs = ("mass", "x") if about in link else ("mass",)
    if missing := [each for each in needs if each not in link]:
        raise ValueError(f"links.{name} needs {', '.join(missing)} too")
    if about not in link:
        return Link(**link)
    if "inertia" in link:
        raise ValueError(f"links.{name} has inertia and {about}: give one")
    return Link.about_centre(
        link["mass"],
        link["x"],
        link.get("y", 0.0),
        link[about],
    )
