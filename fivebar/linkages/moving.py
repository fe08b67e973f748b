"""`move`: a linkage at given crank angles, and its errors where no pose closes."""

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
    """Return the motion of a linkage at crank angles q.

    Parameters
    ----------
    linkage : FourBar, SliderCrank, SixBarPress or FiveBarLinkage
    q : (*batch,) array_like or CasADi scalar
        Crank angles, rad; for two motors (*batch, 2).
    q_dot, q_ddot : array_like
        rad/s and rad/s^2, of the same shape or one number. With 1 and 0 all derivatives are by the
        crank angle.
    branch : int or array_like
        +1 or -1, for the press a pair; None: the linkage's usual one.
    unreachable : {"raise", "nan"}

    Returns
    -------
    Motion

    Raises
    ------
    UnreachableError
        A pose does not close; the message names the gap and the nearest allowed angle.

    Examples
    --------
    >>> from fivebar import linkages
    >>> motion = linkages.move(linkages.FourBar(0.2, 0.06, 0.16, 0.14), 0.5)
    >>> motion.position("C").round(4)
    array([0.1706, 0.1369])
    """
    raise_or_nan(unreachable)
    branch = check_branch(linkage, branch)
    q = numbers(q, "q")
    q_dot = numbers(q_dot, "q_dot")
    q_ddot = numbers(q_ddot, "q_ddot")
    _refuse_shapes(linkage, [q, q_dot, q_ddot], branch)
    motion = linkage.start(q, q_dot, q_ddot, branch)
    if unreachable == "raise":
        _refuse_open(motion)
    return motion


def _refuse_shapes(linkage, given, branch):
    """Raise ValueError for batches that do not fit, and for CasADi symbols that are no scalars."""
    motors = 2 if hasattr(linkage, "motors") else 1
    batch = isinstance(branch, np.ndarray)
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
    """Raise UnreachableError where a pose does not close, for the first such pose."""
    closures = (part.chain.found for _, part in motion.stretches())
    if all(is_symbolic(found) or not np.isnan(found).any() for found in closures):
        return
    found = motion.chain.found
    count, index = first_index(np.isnan(found))

    def at(values):
        return float(np.broadcast_to(values, np.shape(found))[index])

    # Behind an open dyad all gaps are nan, which max() passes over after a number.
    gap = max(at(-np.minimum.reduce(dyad.clearances)) for dyad in motion.chain.dyads)
    where = f"{count} of {np.size(found)} poses, the first at index {index}: " if index else ""
    angles = [math.degrees(at(q)) for q in motion._moving_in]
    degrees = ", ".join(f"{angle:.9g}" for angle in angles)
    if len(angles) > 1:
        reason = f"with the motors at {degrees} deg the bars cannot meet (gap {gap:.3g} m)"
    else:
        branch = int(at(motion.branch)) if isinstance(motion.branch, np.ndarray) else motion.branch
        reason = _reason(motion.linkage, branch, angles[0], f"(gap {gap:.3g} m)")
    raise UnreachableError(f"{where}unreachable: {reason}", gap, index or None)


def _reason(linkage, branch, degrees, gap):
    allowed = crank_range(linkage, branch)
    if not allowed.intervals:
        return f"on this branch no angle of the {linkage.driven} closes {gap}"
    nearest = math.degrees(allowed.nearest(math.radians(degrees)))
    return (
        f"the {linkage.driven} cannot stand at {degrees:.9g} deg {gap}; the nearest allowed angle"
        f" is {nearest:.9g} deg; it may turn {allowed}"
    )
