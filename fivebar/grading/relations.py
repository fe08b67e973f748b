"""Plain relations of wrong answers to the right ones: a sign, a factor, an offset, an exchange."""

from __future__ import annotations

from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from .exercise import Misconception

if TYPE_CHECKING:
    from .diagnosis import Answers

FEWEST = 4  # rows; a relation that fewer rows confirm may be a coincidence


def relation(answers: Answers) -> Misconception | None:
    """Return the relation that holds in all rows, None if there is none.

    It is a sign, a factor or an offset for each returned name, two names exchanged, or a constant.
    """
    known = np.isfinite(answers.came).all(axis=1) & ~answers.none
    if known.sum() < FEWEST or not (known | answers.none | answers.refused).all():
        return None
    came, expected = answers.came[known], answers.expected[known]
    if np.ptp(came, axis=0).max() == 0 and np.ptp(expected, axis=0).max() > 0:
        return Misconception(
            "always the same answer, whatever the arguments: unfinished?",
            "Does your function use its arguments?",
            None,
        )
    return _exchanged(answers, known) or _by_name(answers, known)


def _exchanged(answers, known):
    """Return which of two returned numbers stand in each other's place."""
    exercise = answers.exercise
    names = exercise.returns
    if any(exercise.shape(name) for name in names):
        return None
    for order in permutations(range(len(names))):
        moved = [names[k] for k, place in enumerate(order) if k != place]
        if len(moved) == 2 and answers.alike(answers.expected[:, list(order)])[known].all():
            return Misconception(
                f"{moved[0]} and {moved[1]} exchanged",
                f"In which order does the task ask for {' and '.join(moved)}?",
                None,
            )
    return None


def _by_name(answers, known):
    """Return the sign, factor or offset of each returned name that is wrong."""
    exercise, sentences, first = answers.exercise, [], 0
    exact = answers.alike(answers.expected)[known]
    for name in exercise.returns:
        part = slice(first, first + int(np.prod(exercise.shape(name))))
        first = part.stop
        if exact[:, part].all():
            continue
        words = _one_relation(answers, known, part, name in exercise.angles)
        if words is None:
            return None
        sentences.append(words.format(name))
    if not sentences:  # what is wrong is where no answer exists
        return None
    return Misconception(
        "; ".join(sentences), "All else is right: where does this come from?", None
    )


def _one_relation(answers, known, part, angle):
    came, expected = answers.came[known][:, part], answers.expected[known][:, part]

    def holds(outcome):
        trial = answers.expected.copy()
        trial[np.ix_(known, np.arange(trial.shape[1])[part])] = outcome
        return answers.alike(trial)[known][:, part].all()

    if holds(-expected):
        return "the sign of {} is wrong in every row"
    offset = (came - expected).ravel()[0]
    if holds(expected + offset):
        return "{} is off by " + f"{offset:.4g} in every row"
    largest = np.argmax(np.abs(expected))
    factor = came.ravel()[largest] / (expected.ravel()[largest] or np.nan)
    if not angle and holds(factor * expected):
        return "{} is " + f"{factor:.4g} times the right one in every row"
    return None
