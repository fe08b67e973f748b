"""Which mistake gives the student's numbers: a known one, or a plain relation.

Nothing is guessed: a mistake is named only if it gives all answers, right and wrong ones, within
    the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..models.robots import Robot
from .columns import Columns
from .exercise import Exercise, Misconception
from .misconceptions.of_any import arguments_exchanged, in_degrees, returned_in_degrees
from .relations import constant, constant_part, largest, relation

EXACT = 1e-9  # of a wrong model's largest answer


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

    def difference(self, a: np.ndarray, b: np.ndarray, turn: float = 2 * np.pi) -> np.ndarray:
        return difference(a, b, self.exercise.is_angle(), turn)

    def alike(self, outcome: np.ndarray, turn: float = 2 * np.pi) -> np.ndarray:
        """Return which numbers (n, k) are an outcome's. What is huge at a singularity says nothing
        about scale.
        """
        close = np.maximum(self.limits, EXACT * largest(outcome[~self.none]))
        return self.difference(self.came, outcome, turn) <= close

    def outcome(self, model: Callable) -> np.ndarray:
        found = self.exercise.outcome(model, self.robot, self.columns)
        found[~np.all(np.isfinite(found), axis=1)] = np.nan
        return found

    def fits(self, outcome: np.ndarray, alike: np.ndarray) -> bool:
        """Return whether all rows are as this outcome has them, and a wrong one unlike the right
        answer.
        """
        known, nothing = np.all(np.isfinite(self.came), axis=1), np.isnan(outcome[:, 0])
        same = np.all(alike, axis=1)
        fits = same | (~known & nothing) | self.refused
        wrong = fits & ~self.good & ~(nothing & self.none)
        wrong &= self.differs(outcome) | nothing
        return bool(fits.all() and same.any() and wrong.any())

    def differs(self, outcome: np.ndarray) -> np.ndarray:
        """Return in which rows (n,) an outcome is another one than the right model's."""
        # Where no answer exists, rounding makes one of the right model as well.
        away = self.difference(outcome, self.unmasked) > EXACT * largest(self.unmasked)
        return np.any(away, axis=1) | (np.isnan(outcome) != np.isnan(self.unmasked)).any(axis=1)

    @cached_property
    def unmasked(self) -> np.ndarray:
        """What the right model gives, also where its answer is none."""
        return self.outcome(self.exercise.answer)


def difference(
    a: np.ndarray, b: np.ndarray, angles: np.ndarray, turn: float = 2 * np.pi
) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        raw = np.abs(a - b)
        return np.where(angles, np.abs((raw + turn / 2) % turn - turn / 2), raw)


def diagnose(answers: Answers) -> Misconception | None:
    """Return the mistake that gives the student's answers, None where none is known that does."""
    exercise = answers.exercise
    if not np.any(np.all(np.isfinite(answers.came), axis=1)):  # nothing a mistake could fit
        return None
    return (
        _same_everywhere(answers)
        or constant_part(answers)
        or _single(answers, _stored(exercise))
        or _single(answers, in_degrees(exercise, answers.robot))
        or _single(answers, returned_in_degrees(exercise))
        or relation(answers)
        or _single(answers, arguments_exchanged(exercise))
        or _in_parts(answers)
    )


def _same_everywhere(answers):
    """Return the mistake of who gives one answer to all rows: a stored one, unless it is 0."""
    same = constant(answers)
    if same and np.nan_to_num(answers.came).any():
        return _single(answers, _stored(answers.exercise)) or same
    return same


def _stored(exercise):
    """Return the mistakes that are known by name: models, and derivations with a slip."""
    return [*exercise.wrong, *(slip.of(exercise.derivation) for slip in exercise.slips)]


def _single(answers, misconceptions):
    return next((known for known in misconceptions if explains(known, answers)), None)


def explains(misconception: Misconception, answers: Answers | None) -> bool:
    """Return whether a mistake gives the student's answers."""
    if misconception.model is None or answers is None:
        return False
    outcome = answers.outcome(misconception.model)
    return answers.fits(outcome, answers.alike(outcome, misconception.turn))


def denied(misconception: Misconception, answers: Answers | None) -> bool:
    """Return whether answers where there is one are others than those of a mistake, in rows in
    which the mistake tells: where it gives the right answers, another mistake may be made, too.
    """
    if answers is None:
        return False
    outcome = answers.outcome(misconception.model)
    same = np.all(answers.alike(outcome, misconception.turn), axis=1)
    neither = np.isnan(answers.came).any(axis=1) & np.isnan(outcome).any(axis=1)
    untold = neither | answers.none | answers.refused | ~answers.differs(outcome)
    return not np.all(same | untold)


def consistent(names: str) -> Misconception:
    """Return what is said of who does the right thing with what wrong functions of his own give."""
    return Misconception(
        f"consistent with your {names}, which is wrong",
        f"This function does the right thing with what {names} gives: see to {names} first.",
        None,
    )


def _in_parts(answers):
    """Return a known mistake in some parts of the answer, where the others are right."""
    exercise = answers.exercise
    starts = _starts(answers)
    right = _right_parts(answers, starts)
    owners = []
    for name in exercise.returns:
        owners += [name] * int(np.prod(exercise.shape(name)))
    for misconception in exercise.wrong:
        alike = answers.alike(answers.outcome(misconception.model), misconception.turn)
        taken = ~right & _by_parts(alike | answers.refused[:, None], starts)
        if np.any(taken) and np.all(right | taken):
            names = dict.fromkeys(owners[start] for start in starts[taken])
            told = misconception.name
            if len(names) < len(exercise.returns):
                told += f", in {' and '.join(names)} alone"
            return replace(misconception, name=told)
    return None


def _starts(answers):
    """Return the first number of each part of the answer that can be wrong alone: a matrix's row,
    else each number.

    A row of a symmetric matrix cannot: both its rows come from the same product.
    """
    exercise, widths = answers.exercise, []
    with np.errstate(invalid="ignore"):
        for name, part in zip(exercise.returns, exercise.parts(answers.expected[~answers.none])):
            shape = exercise.shape(name)
            count = int(np.prod(shape[:1]))
            size = shape[-1] if len(shape) > 1 else 1
            symmetric = False
            if len(shape) == 2 and count == size:
                beside_diagonal = part * (1 - np.eye(size))
                same = np.allclose(part, part.swapaxes(1, 2))
                symmetric = same and np.any(beside_diagonal)
            widths += [count * size] if symmetric else [size] * count
    return np.cumsum([0, *widths[:-1]])


def _right_parts(answers, starts):
    exact = answers.difference(answers.came, answers.expected) <= answers.limits
    return _by_parts(exact | answers.refused[:, None], starts)


def _by_parts(true, starts):
    """Return per part whether all its numbers (n, numbers) are true in all rows."""
    return np.logical_and.reduceat(np.all(true, axis=0), starts)
