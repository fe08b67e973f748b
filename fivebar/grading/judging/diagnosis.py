"""Which mistake gives the student's numbers: a known one, or a plain relation.

Nothing is guessed: a mistake is named only if it gives all answers, right and wrong ones, within
    the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...models.robots import Robot
from ..columns import Columns, largest
from ..exercise import Exercise, Misconception

EXACT = 1e-9  # of a wrong model's largest answer
FEWEST = 4  # rows; a relation that fewer rows confirm may be a coincidence


@dataclass(frozen=True, eq=False)
class Answers:
    """What was asked and came, (n, k): expected nan where no answer exists; good, refused: (n,)
    bool.

    """

    exercise: Exercise
    robot: Robot
    columns: Columns
    came: np.ndarray
    expected: np.ndarray
    limits: np.ndarray
    good: np.ndarray
    refused: np.ndarray

    @property
    def none(self) -> np.ndarray:
        return np.isnan(self.expected[:, 0])

    def outcome(self, model: Callable) -> np.ndarray:
        found = self.exercise.outcome(model, self.robot, self.columns)
        found[~np.all(np.isfinite(found), axis=1)] = np.nan
        return found

    @cached_property
    def unmasked(self) -> np.ndarray:
        """What the right model gives, also where its answer is none."""
        return self.outcome(self.exercise.answer)

    def fits(self, model: Callable) -> bool:
        """Return whether all rows are as this model has them, and a wrong one unlike the right
        answer.
        """
        outcome, turns = self.outcome(model), self.exercise.turns
        known, nothing = np.all(np.isfinite(self.came), axis=1), np.isnan(outcome[:, 0])
        # What is huge at a singularity says nothing about scale.
        close = np.maximum(self.limits, EXACT * largest(outcome[~self.none]))
        same = np.all(difference(self.came, outcome, turns) <= close, axis=1)
        # Where no answer exists, rounding makes one of the right model as well.
        away = difference(outcome, self.unmasked, turns) > EXACT * largest(self.unmasked)
        away |= np.isnan(outcome) != np.isnan(self.unmasked)
        fits = same | (~known & nothing) | self.refused
        wrong = fits & ~self.good & ~(nothing & self.none) & (away.any(axis=1) | nothing)
        return bool(fits.all() and same.any() and wrong.any())


def difference(a: np.ndarray, b: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return how far numbers (n, k) are apart, modulo turns (k,), infinite where none counts."""
    with np.errstate(invalid="ignore"):
        raw = np.abs(a - b)
        modulo = np.where(np.isfinite(turns), turns, 1.0)
        return np.where(np.isfinite(turns), np.abs((raw + modulo / 2) % modulo - modulo / 2), raw)


def diagnose(answers: Answers) -> Misconception | None:
    """Return the mistake that gives the student's answers, None where none is known that does."""
    if not np.any(np.all(np.isfinite(answers.came), axis=1)):  # nothing a mistake could fit
        return None
    still = unwritten(answers)
    if still and not np.nan_to_num(answers.came).any():
        return still
    # One answer to all rows is a stored one, unless it is 0.
    return next((known for known in answers.exercise.wrong if answers.fits(known.model)), still)


def unwritten(answers: Answers) -> Misconception | None:
    """Return the misconception of who gives the same answer to all rows, None where he does not."""
    known = np.isfinite(answers.came).all(axis=1) & ~answers.none
    clear = known | answers.none | answers.refused
    if known.sum() < FEWEST or not clear.all() or np.ptp(answers.came[known], axis=0).any():
        return None
    if not np.ptp(answers.expected[known], axis=0).any():
        return None
    return Misconception(
        "always the same answer, whatever the arguments: is it still to be written?",
        "Does your function use its arguments?",
        None,
        idle=True,
    )


def consistent(names: str) -> Misconception:
    """Return what is said of who does the right thing with what wrong functions of his own give."""
    return Misconception(
        f"consistent with your {names}, which is wrong",
        f"This function does the right thing with what {names} gives: see to {names} first.",
        None,
    )
