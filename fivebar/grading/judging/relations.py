"""Plain relations of wrong answers to the right ones: always the same, exchanged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..exercise import Misconception

if TYPE_CHECKING:
    from .diagnosis import Answers

MODES = ("assembly_mode", "gamma1", "gamma2", "branch")
FEWEST = 4  # rows; a relation that fewer rows confirm may be a coincidence


def unwritten(answers: Answers) -> Misconception | None:
    """Return the misconception of who gives the same answer to all rows, or the same number in
    place of some of the returned ones, where the others are right.
    """
    known = _told(answers)
    if known is None:
        return None
    came, expected = answers.came[known], answers.expected[known]
    still, moves = np.ptp(came, axis=0) == 0, np.ptp(expected, axis=0) > 0
    told = ["always the same answer"] if still.all() and moves.any() else []
    if not told and not any(map(answers.exercise.shape, answers.exercise.returns)):
        right = (answers.difference(answers.came, answers.expected) <= answers.limits)[known]
        same = still & moves
        if np.all(same | right.all(axis=0)):
            names = np.array(answers.exercise.returns)[same]
            told = [f"{name} is {number:g}" for name, number in zip(names, came[0, same])]
    if not told:
        return None
    return Misconception(
        f"{' and '.join(told)}, whatever the arguments: is it still to be written?",
        "Does your function use its arguments?",
        None,
        idle=True,
    )


def _told(answers):
    """Return the rows (n,) with an answer, None where they are too few to tell a relation."""
    known = np.isfinite(answers.came).all(axis=1) & ~answers.none
    clear = known | answers.none | answers.refused
    if known.sum() < FEWEST or not clear.all():
        return None
    return known


def exchanged(answers: Answers) -> Misconception | None:
    """Return which returned numbers stand in each other's place in all rows, None if none do."""
    exercise, known = answers.exercise, _told(answers)
    if known is None:
        return None
    names = exercise.returns
    if any(exercise.shape(name) for name in names):
        return None
    places = [_place_of(answers, known, k) for k in range(len(names))]
    if None in places:
        return None
    moved = [(name, names[place]) for name, place in zip(names, places) if name != names[place]]
    if not moved:
        return None

    def model(robot, *row):
        right = exercise.answer(robot, *row)
        return tuple(right[place] for place in places)

    first, other = moved[0]
    if moved[1:] == [(other, first)]:
        told = f"{first} and {other} exchanged"
    else:
        told = "; ".join(f"{name} is what {place} should be" for name, place in moved)
    hint = f"In which order does the task ask for {' and '.join(names)}?"
    return Misconception(told, hint, model)


def _place_of(answers, known, k):
    """Return which expected number the returned number k equals; its own place goes first."""
    count = answers.expected.shape[1]
    others = [place for place in range(count) if place != k]
    for place in (k, *others):
        trial = answers.expected[:, [place] * count]
        if answers.alike(trial)[known, k].all():
            return place
    return None


def largest(answers: np.ndarray) -> np.ndarray:
    """Return per number the largest answer, (k,); 1 where all are 0 or none exists."""
    sizes = np.abs(answers)
    existing = np.where(np.isnan(answers), 0.0, sizes)
    most = np.max(existing, axis=0, initial=0.0)
    return np.where(most > 0, most, 1.0)
