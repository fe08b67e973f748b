"""What is said of poses that do not close: by how much, of which leg, or which joint is left
free.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import first_index
from ..base.errors import SingularityError, UnreachableError
from .dyads import RRP

if TYPE_CHECKING:
    from .pose import Pose


def raise_or_nan(unreachable: object) -> str:
    """Return what a model does where a pose does not close, checked."""
    if not isinstance(unreachable, str) or unreachable not in ("raise", "nan"):
        raise ValueError(f'unreachable must be "raise" or "nan", not {unreachable!r}')
    return unreachable


def refuse_open(open_: np.ndarray, pose: Pose) -> None:
    """Raise for the first pose of a batch that does not close, where `open_` is true."""
    count, index = first_index(open_)
    if index:
        where = f"{count} of {open_.size} poses, the first at index {index}: "
    else:
        where = ""
    gaps = []
    for dyad in pose._dyads:
        clearances = [np.broadcast_to(each, open_.shape)[index] for each in dyad.clearances]
        gaps.append(-float(min(clearances)))
    gap = max(gaps)
    leg = gaps.index(gap)
    dyad = pose._dyads[leg]
    side = ("left", "right")[leg]
    words = pose.robot.words
    name, given, unit = ("q", pose.q, words.unit) if pose._from_dgm else ("xi", pose.xi, "m")
    x, y = np.broadcast_to(given, (*open_.shape, 2))[index]
    at = f"at {name} = ({x:.9g}, {y:.9g}) {unit}"
    if pose._from_dgm:
        distance_words = f"the {words.pivots} are"
        free_words = f"the {words.pivots} coincide: {' and '.join(words.passive)} are"
    else:
        distance_words = f"{side} leg: the end-effector and the {words.base} are"
        free_words = f"the {side} leg is folded on its base joint: {words.joints[leg]} is"
    r1 = dyad.r1
    if isinstance(dyad, RRP):
        distance = r1 + gap
        limit, end, bars = r1, "farthest", f"a bar of {r1:g} m allows"
    else:
        r2 = dyad.r2
        distance = float(np.broadcast_to(dyad.span_squared, open_.shape)[index]) ** 0.5
        if r1 == r2 and distance < r1:
            raise SingularityError(
                f"{where}{free_words} left free (pivots {distance:.3g} m apart), {at}",
                distance,
                index or None,
            )
        longest = distance > r1 + r2
        limit, end = (r1 + r2, "longest") if longest else (abs(r1 - r2), "shortest")
        bars = f"bars of {r1:g} and {r2:g} m allow"
    raise UnreachableError(
        f"{where}unreachable: {distance_words} {distance:.9g} m apart, the {end} that {bars} is"
        f" {limit:.9g} m (gap {gap:.3g} m), {at}",
        gap,
        index or None,
    )
