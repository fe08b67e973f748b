"""Degenerate robots, whose loci touch: which robots are so near to one that rounding decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ..base.backend import EPS
from ..base.errors import SingularityError
from ..models.robots import FiveBar
from .leg_circles import size_of

# Of the size, for a sum of lengths. Up to 1e-11 rounding decided which loci cross, and faces were
# lost, with 1 of 20 robots whose bars are almost equal.
NEAR = 3e-11
NAMES = "l11", "l12", "l21", "l22", "d"
# Lengths with signs, which sum to 0 where bars are equal, or close in line. Of two relations with
# opposite signs one is enough.
_SIGNS = np.array(list(product((-1.0, 0.0, 1.0), repeat=len(NAMES))))
RELATIONS = _SIGNS[len(_SIGNS) // 2 + 1 :]

EVERYWHERE = (
    "in these modes the robot is singular everywhere (det A = 0): its legs are equal and in one"
    " place, so the distal bars lie on each other, and no drive turns them: take working modes of"
    " different signs"
)


def singular_everywhere(robot: Any, working: Sequence[int]) -> bool:
    """Return whether det A is 0 in all poses of working modes (2,), to rounding: the legs are equal
    and in one place.
    """
    left, right = robot.distal
    differences = [robot.d, left - right]
    if robot.turns:
        differences.append(robot.l11 - robot.l21)
    size = NEAR * max(left, right)
    return working[0] == working[1] and max(map(abs, differences)) <= size


def refuse_singular_everywhere(robot: Any, working: Sequence[int], user: str) -> None:
    """Raise SingularityError where all poses of working modes are singular."""
    if singular_everywhere(robot, working):
        raise SingularityError(f"{user}: {EVERYWHERE}", 0.0)


def settled(robot: FiveBar) -> FiveBar:
    """Return the robot, or the nearest one in which lengths that almost sum to 0 do so.

    Its lengths differ by about 3e-11 of the robot's size. Boundaries of regions are computed for
    it, as rounding could not tell which loci of the other one meet.
    """
    lengths = np.array([getattr(robot, name) for name in NAMES])
    sums = np.abs(RELATIONS @ lengths) / size_of(robot)
    almost = RELATIONS[sums <= NEAR]
    if sums[sums <= NEAR].max(initial=0.0) <= EPS:
        return robot
    for _ in range(2):  # the second time for the rounding error of the first
        lengths = lengths - np.linalg.pinv(almost) @ (almost @ lengths)
    lengths[lengths < NEAR * size_of(robot)] = 0.0  # d alone: bars are longer
    return replace(robot, **dict(zip(NAMES, lengths.tolist())))
