"""Where a path changes the sign of det A, or with dry friction turns a joint round."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize.elementwise import find_root

from ...models.physics import loads_of
from .bounds import Stretches, asked_on
from .enclosures import TERMS

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path

ZERO = 1e-12  # of det A, or of a slope: it has no sign


def cut_at_signs(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> Stretches:
    """Cut where det A has two signs at a stretch's ends, and with dry friction a joint's slope.

    Where it changes twice on a stretch, that is not decided, and is halved until this shows.
    """
    names = ["D", "q1", "q2"] if loads_of(robot).sticks else ["D"]

    def values(s, piece, name):
        return asked_on(robot, path, working, piece.astype(int), s, s, TERMS - 1)[name].m[0]

    rows = []
    places = []
    for name in names:
        ends = stretches.first, stretches.last
        first, last = (values(s, stretches.piece, name) for s in ends)
        row = np.flatnonzero((first * last < 0) & (np.minimum(abs(first), abs(last)) > ZERO))
        rows.append(row)
        if len(row):
            at = stretches.taken(row)
            roots = find_root(partial(values, name=name), (at.first, at.last), args=(at.piece,))
            places.append(roots.x)
    return stretches.cut(np.concatenate(rows), np.concatenate([*places, []]))
