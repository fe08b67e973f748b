"""What linkages refuse: lengths, branches and numbers that cannot be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import check_modes, finite_numbers, is_symbolic
from ..base.checks import LONGEST, instance, modes, not_too_different, number, shown, size

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .chain import Number
    from .motion import Linkage


def check_branch(
    linkage: Linkage, branch: int | ArrayLike | None
) -> int | tuple[int, int] | np.ndarray:
    """The branch, or the usual one for None; refused where it is not +1 or -1, or not a pair where
    it must be.
    """
    if branch is None:
        return linkage.usual_branch
    if isinstance(linkage.usual_branch, tuple):
        try:
            first, second = branch
        except (TypeError, ValueError):
            raise ValueError(
                f"the branch of this linkage must be a pair of +1 or -1, not {branch!r}"
            ) from None
        return modes(2)((first, second), "branch")
    branch = check_modes(branch, "branch")
    return int(branch) if branch.ndim == 0 else branch


def one_branch(linkage: Linkage, branch: int | ArrayLike | None) -> int | tuple[int, int]:
    """`check_branch`, and refused where it is a batch."""
    branch = check_branch(linkage, branch)
    if isinstance(branch, np.ndarray):
        raise ValueError(f"branch must be one branch of this linkage, not {shown(branch)}")
    return branch


def numbers(x: ArrayLike, name: str) -> Number:
    """A float, an array of finite floats, or a CasADi symbol as it is."""
    if is_symbolic(x):
        return x
    array = finite_numbers(x, name)
    return float(array) if array.ndim == 0 else array


def sizes(owner: object, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are no lengths of bars, or too different ones;
    ValueError.
    """
    lengths = {name: size(getattr(owner, name), name) for name in names}
    not_too_different(lengths)
    for name, value in lengths.items():
        object.__setattr__(owner, name, value)


def finite(owner: object, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are not numbers of at most LONGEST;
    ValueError.
    """
    for name in names:
        object.__setattr__(owner, name, number(getattr(owner, name), name, -LONGEST, LONGEST))


def pair(owner: object, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are not two such numbers; None is left as it is.
    ValueError.
    """
    for name in names:
        value = getattr(owner, name)
        if value is None:
            continue
        try:
            first, second = finite_numbers(value, name).tolist()
        except (TypeError, ValueError):
            raise ValueError(f"{name} must be finite, two numbers, not {shown(value)}") from None
        object.__setattr__(
            owner, name, tuple(number(each, name, -LONGEST, LONGEST) for each in (first, second))
        )


def loads(value: object, name: str) -> dict | None:
    """Rule: {point: (Fx, Fy)}, numbers or arrays of a batch, or None; ValueError for anything
    else.
    """
    if value is None:
        return None
    if not isinstance(value, dict) or not all(isinstance(point, str) for point in value):
        raise ValueError(f"{name} must be {{point: (Fx, Fy)}}, not {shown(value)}")
    return {point: _force(force, f"{name}[{point!r}]") for point, force in value.items()}


def _force(force, name):
    if isinstance(force, (str, bytes, dict)) or not hasattr(force, "__len__") or len(force) != 2:
        raise ValueError(f"{name} must be two numbers (Fx, Fy), or arrays, not {shown(force)}")
    return [numbers(each, name) for each in force]


def bodies(owner: object, kind: type, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are no bodies; TypeError."""
    for name in names:
        instance(kind)(getattr(owner, name), name)


def linkage(value: object, name: str) -> Linkage:
    """Rule: a linkage; TypeError for anything else."""
    if isinstance(value, type) or not all(
        hasattr(type(value), own) for own in ("title", "usual_branch", "start")
    ):
        raise TypeError(f"{name} must be a linkage, as FourBar or SliderCrank, not {shown(value)}")
    return value
