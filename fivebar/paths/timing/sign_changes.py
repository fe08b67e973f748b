"""Where a path changes the sign of det A, or with friction turns a joint round."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...models.physics import physics_of
from .bounds import Stretches, asked_on
from .enclosures import TERMS

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path

SAMPLES = 8  # of each stretch


def cut_at_signs(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> Stretches:
    """Cut where det A changes its sign, and with friction where a joint turns round."""
    names = ["D"]
    if (physics := physics_of(robot)) is not None and physics.has_friction:
        names += ["q1", "q2"]
    share = np.linspace(0, 1, SAMPLES + 1)
    s = stretches.first[:, None] + stretches.length[:, None] * share
    piece = np.broadcast_to(stretches.piece[:, None], s.shape)
    sampled = _values(robot, path, working, piece.ravel(), s.ravel(), names)
    index = []
    places = []
    for name in names:
        value = sampled[name][0].reshape(s.shape)
        row, column = np.nonzero(value[:, :-1] * value[:, 1:] < 0)
        ends = s[row, column], s[row, column + 1]
        roots = _roots(robot, path, working, stretches.piece[row], name, *ends, value[row, column])
        inside = (
            np.minimum(roots - stretches.first[row], stretches.last[row] - roots)
            > 1e-12 * path.length
        )
        index.append(row[inside])
        places.append(roots[inside])
    return stretches.cut(np.concatenate(index), np.concatenate(places))


def cut_where_missed(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> Stretches:
    """Cut where det A has two signs that the first samples had not shown."""
    first, last = (
        _values(robot, path, working, stretches.piece, s, ["D"])["D"][0]
        for s in (stretches.first, stretches.last)
    )
    row = np.flatnonzero((first * last < 0) & (np.abs(first) > 1e-12) & (np.abs(last) > 1e-12))
    at = stretches.taken(row)
    return stretches.cut(
        row, _roots(robot, path, working, at.piece, "D", at.first, at.last, first[row])
    )


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
