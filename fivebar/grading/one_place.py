"""A slip of the pen in a running program: the one place whose change makes all answers of a check
right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..models.robots import Robot
from .columns import Columns
from .exercise import Exercise, Misconception
from .judge import rows_right
from .program import Program
from .repair import repaired


@dataclass(frozen=True, eq=False)
class Rows:
    """What was asked: columns, tolerance and refuse (n,), and the constants that were set in the
    file.
    """

    exercise: Exercise
    robot: Robot
    columns: Columns
    tolerance: np.ndarray
    refuse: np.ndarray
    constants: dict


def one_place(program: Program, asked: Rows, others: set[str]) -> Misconception | None:
    """The place with its line, None where there is none. others: functions that are asked by
    themselves.
    """
    name = asked.exercise.name

    def right(student, ks, few):
        rows = np.flatnonzero(~asked.refuse)[:: max(1, len(asked.refuse) // 2) if few else 1]
        columns = [np.tile(np.asarray(column)[rows], len(ks)) for column in asked.columns]
        numbers = np.repeat(ks, len(rows)).tolist()
        calls = [(k, *row) for k, row in zip(numbers, zip(*(c.tolist() for c in columns)))]
        found = student.ask("changed__", calls, asked.constants or None)
        limits = np.tile(asked.tolerance[rows], len(ks))
        return (
            rows_right(asked.exercise, asked.robot, columns, found, limits)
            .reshape(len(ks), -1)
            .all(axis=1)
        )

    change = repaired(program.source, name, program.again, right, others - {name})
    if change is None:
        return None
    where = program.where(change.line)
    return Misconception(
        f"{change.what} in {where}, `{change.text[:60]}`: all else is right",
        f"Compare {where} with your derivation: with {change.what} changed there, all these answers"
        " would be right.",
        None,
    )
