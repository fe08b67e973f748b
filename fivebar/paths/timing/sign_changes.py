"""Where a path changes the sign of det A, or with dry friction turns a joint round."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

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
    ends = stretches.first, stretches.last
    values = [_values(robot, path, working, stretches.piece, s, names) for s in ends]
    rows = []
    places = []
    for name in names:
        first, last = (value[name][0] for value in values)
        row = np.flatnonzero((first * last < 0) & (np.minimum(abs(first), abs(last)) > ZERO))
        at = stretches.taken(row)
        roots = _roots(robot, path, working, at.piece, name, at.first, at.last, first[row])
        rows.append(row)
        places.append(roots)
    return stretches.cut(np.concatenate(rows), np.concatenate(places))


def _values(robot, path, working, piece, s, names):
    """Return {name: (values, derivatives)} at single places."""
    found = asked_on(robot, path, working, piece, s, s, TERMS - 1)
    return {name: (found[name].m[0], found[name].m[1]) for name in names}


def _roots(robot, path, working, piece, name, low, high, at_low):
    """Roots by Newton steps that stay between signs."""
    if not len(low):
        return low
    sign = np.sign(at_low)
    s = (low + high) / 2
    for _ in range(60):
        value, slope = _values(robot, path, working, piece, s, [name])[name]
        below = np.sign(value) == sign
        low = np.where(below, s, low)
        high = np.where(below, high, s)
        with np.errstate(all="ignore"):
            step = s - value / slope
        after = np.where((step > low) & (step < high), step, (low + high) / 2)
        done = (np.abs(after - s) <= 2e-16 * np.abs(s)) | (value == 0)
        s = np.where(value == 0, s, after)
        if done.all():
            break
    return s
