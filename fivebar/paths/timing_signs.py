"""Where a path changes the sign of det A, or with friction turns a joint round."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..models.physics import physics_of
from .bounds import Stretches, asked
from .enclosures import TERMS, place_series

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .curve import Path

SAMPLES = 8  # of each stretch


def cut_at_signs(robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]) -> Stretches:
    """Cut where det A changes its sign, and with friction where a joint turns round."""
    names = ["D"]
    if (physics := physics_of(robot)) is not None and physics.rubs:
        names += ["q1", "q2"]
    share = np.linspace(0, 1, SAMPLES + 1)
    s = stretches.first[:, None] + stretches.length[:, None] * share
    piece = np.broadcast_to(stretches.piece[:, None], s.shape)
    sampled = _values(robot, path, working, piece.ravel(), s.ravel(), names)
    index, places = [], []
    for name in names:
        value = sampled[name][0].reshape(s.shape)
        row, column = np.nonzero(value[:, :-1] * value[:, 1:] < 0)
        roots = _roots(
            lambda at, k, name=name: _values(robot, path, working, stretches.piece[k], at, [name])[name],
            s[row, column],
            s[row, column + 1],
            value[row, column],
            row,
        )
        inside = np.minimum(roots - stretches.first[row], stretches.last[row] - roots) > 1e-12 * path.length
        index.append(row[inside])
        places.append(roots[inside])
    return stretches.cut(np.concatenate(index), np.concatenate(places))


def cut_where_missed(robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]) -> Stretches:
    """Cut where det A has two signs that the first samples had not shown."""
    ends = _values(
        robot, path, working, np.tile(stretches.piece, 2), np.concatenate([stretches.first, stretches.last]), ["D"]
    )["D"][0].reshape(2, -1)
    row = np.flatnonzero((ends[0] * ends[1] < 0) & (np.abs(ends) > 1e-12).all(axis=0))
    roots = _roots(
        lambda at, k: _values(robot, path, working, stretches.piece[k], at, ["D"])["D"],
        stretches.first[row],
        stretches.last[row],
        ends[0][row],
        row,
    )
    return stretches.cut(row, roots)


def _values(robot, path, working, piece, s, names):
    """{name: (values, derivatives)} at single places."""
    xi = place_series(path, piece, s, s, TERMS - 1)
    found = asked(robot, xi, working)
    return {name: (found[name].m[0], found[name].m[1]) for name in names}


def _roots(function, low, high, at_low, k):
    """Roots by Newton steps that stay between signs; function(s, k) -> (value, derivative)."""
    if not len(low):
        return low
    sign, s = np.sign(at_low), (low + high) / 2
    for _ in range(60):
        value, slope = function(s, k)
        below = np.sign(value) == sign
        low, high = np.where(below, s, low), np.where(below, high, s)
        with np.errstate(all="ignore"):
            step = s - value / slope
        after = np.where((step > low) & (step < high), step, (low + high) / 2)
        done = (np.abs(after - s) <= 2e-16 * np.abs(s)) | (value == 0)
        s = np.where(value == 0, s, after)
        if done.all():
            break
    return s
