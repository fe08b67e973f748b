"""Checks of linkages: lengths, branches, bodies and loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.backend import check_modes, finite_numbers, is_symbolic
from ..base.checks import LONGEST, modes, not_too_different, number, shown, size

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .chain import Number
    from .motion import Linkage


def check_branch(
    linkage: Linkage, branch: int | ArrayLike | None
) -> int | tuple[int, int] | np.ndarray:
    """Return the branch, the usual one for None; ValueError where it is no branch."""
    if branch is None:
        return linkage.usual_branch
    if isinstance(linkage.usual_branch, tuple):
        if np.shape(branch) != (2,):
            raise ValueError(
                f"the branch of this linkage must be a pair of +1 or -1, not {branch!r}"
            )
        return modes(2)(branch, "branch")
    branch = check_modes(branch, "branch")
    return int(branch) if branch.ndim == 0 else branch


def one_branch(linkage: Linkage, branch: int | ArrayLike | None) -> int | tuple[int, int]:
    """Return the branch as `check_branch` does; ValueError where it is a batch."""
    branch = check_branch(linkage, branch)
    if isinstance(branch, np.ndarray):
        raise ValueError(
            f"branch must be one branch of this linkage, +1 or -1, not a batch of"
            f" {shown(branch.tolist())}"
        )
    return branch


def numbers(x: Any, name: str) -> Number:
    """Return a float, an array of finite floats, or a CasADi symbol as it is."""
    if is_symbolic(x):
        return x
    array = finite_numbers(x, name)
    return float(array) if array.ndim == 0 else array


def coordinate(value: object, name: str) -> float:
    """Rule: a number of at most LONGEST."""
    return number(value, name, -LONGEST, LONGEST)


def check_lengths(owner: object, *names: str) -> None:
    """Set parameters of a frozen dataclass to lengths of bars; ValueError where they are none."""
    check(owner, size, *names)
    not_too_different({name: getattr(owner, name) for name in names})


def check(owner: object, rule: Callable, *names: str) -> None:
    """Set parameters of a frozen dataclass to what a rule makes of them."""
    for name in names:
        object.__setattr__(owner, name, rule(getattr(owner, name), name))


def pair(value: object, name: str) -> tuple[float, float] | None:
    """Rule: two numbers of at most LONGEST, or None."""
    if value is None:
        return None
    try:
        first, second = finite_numbers(value, name).tolist()
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be finite, two numbers, not {shown(value)}") from None
    return coordinate(first, name), coordinate(second, name)


def loads(value: object, name: str) -> dict | None:
    """Rule: {point: (Fx, Fy)}, numbers or arrays of a batch, or None."""
    if value is None:
        return None
    if not isinstance(value, dict) or not all(isinstance(point, str) for point in value):
        raise ValueError(f"{name} must be {{point: (Fx, Fy)}}, not {shown(value)}")
    return {point: _force(force, f"{name}[{point!r}]") for point, force in value.items()}


def _force(force, name):
    if not isinstance(force, (tuple, list, np.ndarray)) or len(force) != 2:
        raise ValueError(f"{name} must be two numbers (Fx, Fy), or arrays, not {shown(force)}")
    return [numbers(component, name) for component in force]


def linkage(value: Any, name: str) -> Linkage:
    """Rule: a linkage; TypeError for anything else."""
    needed = ("title", "usual_branch", "start")
    if isinstance(value, type) or not all(hasattr(type(value), part) for part in needed):
        raise TypeError(f"{name} must be a linkage, as FourBar or SliderCrank, not {shown(value)}")
    return value
