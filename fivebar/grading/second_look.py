"""What a second question tells of wrong answers: numbers typed for names, answers that change from
call to call.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..models.robots import Robot
from .columns import Columns
from .exercise import Exercise, Misconception
from .judge import rows_right
from .worker.replies import Reply

CHANGES = Misconception(
    "another answer to the same question, asked again",
    "What does your function keep from call to call (a global, a list that grows, an argument that"
    " it changes), or draw at random?",
    None,
    idle=True,
)


def changing(first: list[Reply], again: list[Reply]) -> bool:
    """Return whether any of the values given to the same questions is another one the
    second time.
    """
    pairs = [(a.value, b.value) for a, b in zip(first, again) if a.kind == b.kind == "value"]
    return any(repr(a) != repr(b) for a, b in pairs)


def typed(
    exercise: Exercise,
    robot: Robot,
    own: Robot,
    columns: Columns,
    replies: list[Reply],
    tolerance: np.ndarray,
) -> Misconception | None:
    """Return who has typed numbers of his own robot where the names stand that a check sets to
    another one's.

    The rows are those that have an answer; tolerance (n,).
    """
    for names in _groups(exercise, robot, own, columns):
        mixed = replace(robot, **{name: getattr(own, name) for name in names})
        if rows_right(exercise, mixed, columns, replies, tolerance).all():
            told = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
            return Misconception(
                f"{told} of your own robot, whatever the file's names hold",
                "This check sets the names at the top of your file to another robot's numbers. In"
                " which line does a number stand, or a name that was given its value before?",
                None,
            )
    return None


def _groups(exercise, robot, own, columns) -> Iterator[tuple[str, ...]]:
    """Yield names of which the answers depend and in which the two robots differ, first alone, then
    together.
    """
    mine, names = own.parameters, []
    right = exercise.outcome(exercise.answer, robot, columns)
    for name, value in robot.parameters.items():
        if value != mine[name]:
            changed = exercise.outcome(
                exercise.answer, replace(robot, **{name: mine[name]}), columns
            )
            if not np.array_equal(changed, right, equal_nan=True):
                names.append(name)
    for count in range(1, len(names) + 1):
        yield from combinations(names, count)
