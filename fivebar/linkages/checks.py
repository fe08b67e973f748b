"""What linkages refuse: lengths, branches and numbers that cannot be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .._backend import check_modes, is_symbolic

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .chain import Number
    from .motion import Linkage


def check_branch(linkage: Linkage, branch: int | ArrayLike | None) -> int | tuple[int, int] | np.ndarray:
    """The branch, or the usual one for None; refused where it is not +1 or -1, or not a pair where it must be."""
    if branch is None:
        return linkage.usual_branch
    if isinstance(linkage.usual_branch, tuple):
        try:
            first, second = branch
        except TypeError:
            raise ValueError(f"the branch of this linkage must be a pair of +1 or -1, not {branch!r}") from None
        return int(check_modes(first, "branch")), int(check_modes(second, "branch"))
    branch = check_modes(branch, "branch")
    return int(branch) if branch.ndim == 0 else branch


def numbers(x: ArrayLike, name: str) -> Number:
    """A float, an array of finite floats, or a CasADi symbol as it is."""
    if is_symbolic(x):
        return x
    array = np.asarray(x, dtype=float)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, not {array[~np.isfinite(array)].flat[0]}")
    return float(array) if array.ndim == 0 else array


def positive(instance: object, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are not finite numbers > 0."""
    for name in names:
        value = _number(name, getattr(instance, name))
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be finite and > 0, not {value:g}")
        object.__setattr__(instance, name, value)


def finite(instance: object, *names: str) -> None:
    """Refuse parameters of a frozen dataclass that are not finite numbers, or pairs of them; None is left as it is."""
    for name in names:
        value = getattr(instance, name)
        if value is None:
            continue
        pair = isinstance(value, (tuple, list, np.ndarray))
        parts = tuple(_number(name, x) for x in (value if pair else (value,)))
        if not all(map(math.isfinite, parts)) or (pair and len(parts) != 2):
            raise ValueError(f"{name} must be finite{', two numbers' if pair else ''}, not {value}")
        object.__setattr__(instance, name, parts if pair else parts[0])


def _number(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        raise ValueError(f"{name} must be a number, not {value!r}")
    return float(value)
