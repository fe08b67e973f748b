"""The verb `move`: a linkage at given crank angles, and what it says where no pose closes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import first_index, is_symbolic
from ..base.checks import takes
from ..base.errors import UnreachableError
from ..models.unreachable import raise_or_nan
from .checks import check_branch, linkage, numbers
from .limits import crank_range

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .motion import Linkage, Motion


@takes(linkage=linkage)
def move(
    linkage: Linkage,
    q: ArrayLike,
    q_dot: ArrayLike = 1.0,
    q_ddot: ArrayLike = 0.0,
    branch: int | ArrayLike | None = None,
    unreachable: str = "raise",
) -> Motion:
    """The motion of a linkage at crank angles q: Motion.

    q: (*batch,) rad, or a CasADi scalar; for two motors (*batch, 2).
    q_dot, q_ddot: rad/s, rad/s^2, of the same shape or one number.
    branch: +1 or -1, for the press a pair; None is the linkage's usual one.
    unreachable: "raise" an UnreachableError that names the nearest allowed angle, or give "nan"
        there.
    """
    raise_or_nan(unreachable)
    branch = check_branch(linkage, branch)
    given = [numbers(x, name) for x, name in ((q, "q"), (q_dot, "q_dot"), (q_ddot, "q_ddot"))]
    _refuse_shapes(linkage, given, branch)
    motion = linkage.start(*given, branch)
    if unreachable == "raise":
        _refuse_open(motion)
    return motion


def _refuse_shapes(linkage, given, branch):
    """ValueError for batches that do not go together, and for CasADi symbols that are no
    scalars.
    """
    motors, batch = 2 if hasattr(linkage, "motors") else 1, isinstance(branch, np.ndarray)
    for x, name in zip(given, ("q", "q_dot", "q_ddot")):
        if is_symbolic(x) and (x.numel() != motors or batch):
            raise ValueError(
                f"{name} must be {'two' * (motors - 1) or 'one'} CasADi scalar, with one branch,"
                f" not {x.shape}"
            )
    shapes = [
        np.shape(x)[: -1 if motors == 2 and np.ndim(x) else None]
        for x in given
        if not is_symbolic(x)
    ]
    shapes += [branch.shape] if batch else []
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(
            f"q, q_dot, q_ddot and branch of shapes {shapes} do not go together"
        ) from None


def _refuse_open(motion):
    founds = (own.chain.found for _, own in motion.stretches())
    if all(is_symbolic(found) or not np.any(found != found) for found in founds):
        return
    found = motion.chain.found
    count, index = first_index(np.isnan(found))
    where = f"{count} of {np.size(found)} poses, the first at index {index}: " if index else ""
    gap = max(
        float(np.broadcast_to(_gap(dyad), np.shape(found))[index]) for dyad in motion.chain.dyads
    )
    at = [
        math.degrees(float(np.broadcast_to(q, np.shape(found))[index])) for q in motion._moving_in
    ]
    words = ", ".join(f"{angle:.9g}" for angle in at)
    if len(at) > 1:
        raise UnreachableError(
            f"{where}unreachable: with the motors at {words} deg the bars cannot meet (gap"
            f" {gap:.3g} m)",
            gap,
            index or None,
        )
    branch = motion.branch
    if np.ndim(branch) == 1 and not isinstance(branch, tuple):
        branch = int(np.broadcast_to(branch, np.shape(found))[index])
    allowed = crank_range(motion.linkage, branch)
    if not allowed.intervals:
        raise UnreachableError(
            f"{where}unreachable: on this branch no angle of the {motion.linkage.driven} closes"
            f" (gap {gap:.3g} m)",
            gap,
            index or None,
        )
    nearest = allowed.nearest(math.radians(at[0]))
    raise UnreachableError(
        f"{where}unreachable: the {motion.linkage.driven} cannot stand at {words} deg (gap"
        f" {gap:.3g} m); the nearest allowed angle is {math.degrees(nearest):.9g} deg; it may turn"
        f" {allowed}",
        gap,
        index or None,
    )


def _gap(dyad):
    """By how many metres a dyad's bars are too short or too long: negative where they meet, -inf
    behind an open one.
    """
    gap = -np.minimum.reduce(dyad.clearances)
    return np.where(np.isnan(gap), -np.inf, gap)
