"""The numbers of a lab's robot: one of the package's, or any dataclass or NamedTuple of numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from ..models.values import Named


def has_models(robot: Any) -> bool:
    """Return whether the package has models of a robot: of a five-bar or a biglide."""
    return isinstance(robot, Named)


def parameters_of(robot: Any) -> dict[str, float]:
    """Return {name: value} of a robot's lengths and masses, none where it is no dataclass and no
    NamedTuple.
    """
    if has_models(robot):
        values = robot.parameters
    else:
        names = getattr(robot, "_fields", getattr(robot, "__dataclass_fields__", ()))
        values = {name: getattr(robot, name) for name in names}
    return {name: value for name, value in values.items() if isinstance(value, (int, float))}


def with_numbers(robot: Any, numbers: dict[str, Any]) -> Any:
    """Return a robot of which some numbers are other ones."""
    change = getattr(robot, "_replace", partial(replace, robot))  # a NamedTuple's own
    return change(**numbers)
