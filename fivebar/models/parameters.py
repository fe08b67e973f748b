"""A robot's parameters as a list, from a list, and by name from a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from inspect import signature
from typing import Any

from ..base.checks import shown
from .links import Link, grouped, knowing_links
from .robots import KINDS, Biglide, FiveBar, Robot

GRAVITY = "gravity_x", "gravity_y"


def names_of(robots: Iterable[Robot]) -> tuple[str, ...]:
    """Return the parameters that any of these robots names beyond its kind's own, in the order of
    the class.
    """
    robots = list(robots)
    asked = set().union(*(robot.parameters for robot in robots))
    kind: Any = type(robots[0])
    return tuple(f.name for f in fields(kind)[kind.lab :] if f.name in asked)


def parameters_of(robot: Robot, names: Iterable[str] | None = None) -> list:
    """Return the robot's parameters: its kind's own in the order of the class, then those named;
    gravity is two.
    """
    names = names_of([robot]) if names is None else names
    own = [getattr(robot, f.name) for f in _own(type(robot))]
    for name in names:
        value = getattr(robot, name)
        own += value if name == "gravity" else [value]
    return own


def count_of(kind: type, names: Iterable[str] = ()) -> int:
    """Return how many numbers `parameters_of` gives."""
    return len(column_names(kind, names))


def column_names(kind: type, names: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the names of the numbers that `parameters_of` gives."""
    found = [f.name for f in _own(kind)]
    for name in names:
        found += GRAVITY if name == "gravity" else [name]
    return tuple(found)


def with_parameters(kind: type, p: Any, names: Iterable[str] = ()) -> FiveBar | Biglide:
    """Return the robot of a kind with these parameters in the order of `parameters_of`, a CasADi
    vector for instance.
    """
    columns = column_names(kind, names)
    given = {name: p[k] for k, name in enumerate(columns)}
    if GRAVITY[0] in given:
        given["gravity"] = tuple(given.pop(name) for name in GRAVITY)
    return kind(**given)


def with_values(robot: FiveBar | Biglide, values: Mapping[str, Any]) -> FiveBar | Biglide:
    """Return the robot with other values of parameters {name: value}; links that it knows are
    grouped anew at its new lengths.
    """
    changed = replace(robot, **values)
    if not robot.links:
        return changed
    before, after = (grouped(each.parameters, robot.links) for each in (robot, changed))
    own = {name: getattr(robot, name) + after[name] - before[name] for name in after}
    return knowing_links(replace(changed, **(own | dict(values))), robot.links)


def _own(kind):
    return fields(kind)[: kind.lab]


def robot_of(parameters: dict[str, Any], kind: Any = None) -> FiveBar | Biglide:
    """Return the robot with these parameters {name: value}, of the kind that knows them.

    With "links" it is a five-bar of bars as they are built, the arguments of `FiveBar.from_links`:
    each link its mass or a table of Link's arguments, with inertia_about_centre in place of inertia
    where it is that.
    """
    kind = kind or kind_that_knows(parameters)
    if "links" in parameters and kind is FiveBar:
        return _of_links(dict(parameters))
    refuse_unknown(f"a {kind.words.title}", parameters, [f.name for f in fields(kind)])
    return kind(**parameters)


def kind_that_knows(parameters: dict[str, Any]) -> Any:
    """Return the kind of robot that has most of these parameters."""
    if "links" in parameters:
        return FiveBar
    counts = []
    for kind in KINDS:
        counts.append(len(set(parameters) - {f.name for f in fields(kind)}))
    return KINDS[counts.index(min(counts))]


def _of_links(parameters):
    known = list(signature(FiveBar.from_links).parameters)
    refuse_unknown("a robot of links", parameters, known)
    refuse_missing("a robot of links", parameters, known[:6])
    links = parameters.pop("links")
    if isinstance(links, dict):
        links = {name: _link(f"links.{name}", link) for name, link in links.items()}
    return FiveBar.from_links(links=links, **parameters)


def _link(name, link):
    if not isinstance(link, dict):
        return link
    about_centre = "inertia_about_centre" in link
    inertia = "inertia_about_centre" if about_centre else "inertia"
    refuse_unknown(name, link, ("mass", "x", "y", inertia))
    refuse_missing(name, link, ("mass", "x") if about_centre else ("mass",))
    if not about_centre:
        return Link(**link)
    return Link.about_centre(link["mass"], link["x"], link.get("y", 0.0), link[inertia])


def refuse_unknown(what: str, given: Any, known: Iterable[str]) -> None:
    """Raise ValueError for a table with names that are not known."""
    if not isinstance(given, dict):
        raise ValueError(f"{what} must be a table of {', '.join(known)}, not {shown(given)}")
    if unknown := sorted(set(given) - set(known)):
        raise ValueError(
            f"no parameter {', '.join(unknown)} of {what}; the known ones are {', '.join(known)}"
        )


def refuse_missing(what: str, given: Any, needed: Iterable[str]) -> None:
    """Raise ValueError for a table without one of these names."""
    if missing := [name for name in needed if name not in given]:
        raise ValueError(f"{what} needs {', '.join(missing)} too")
