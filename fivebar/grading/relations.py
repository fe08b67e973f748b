"""Plain relations of wrong answers to the right ones: a sign, a factor, an offset, an exchange."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .exercise import Misconception

if TYPE_CHECKING:
    from .diagnosis import Answers

MODES = ("assembly_mode", "gamma1", "gamma2", "branch")
AFFINE = 1e-6  # of the largest answer
CLOSE = 0.01  # of the largest answer
FEWEST = 4  # rows; a relation that fewer rows confirm may be a coincidence


def relation(answers: Answers) -> Misconception | None:
    """Return the relation that holds in all rows, None if there is none.

    It is a sign, a factor or an offset for each returned name, or one name's number in the place
    of another's.
    """
    known = _told(answers)
    return None if known is None else _exchanged(answers, known) or _by_name(answers, known)


def constant(answers: Answers) -> Misconception | None:
    """Return the misconception of who gives the same answer to all rows."""
    known = _told(answers)
    if known is None or np.ptp(answers.came[known], axis=0).max() > 0:
        return None
    if np.ptp(answers.expected[known], axis=0).max() == 0:
        return None
    return _unwritten("always the same answer")


def constant_part(answers: Answers) -> Misconception | None:
    """Return the misconception of who gives the same number to all rows in place of some of the
    returned ones, where the others are right.
    """
    known = _told(answers)
    if known is None or any(map(answers.exercise.shape, answers.exercise.returns)):
        return None
    came, expected = answers.came[known], answers.expected[known]
    same = (np.ptp(came, axis=0) == 0) & (np.ptp(expected, axis=0) > 0)
    right = (answers.difference(answers.came, answers.expected) <= answers.limits)[known]
    if not np.all(same | right.all(axis=0)):
        return None
    names = [name for name, part in zip(answers.exercise.returns, same) if part]
    told = [f"{name} is {number:g}" for name, number in zip(names, came[0, same])]
    return _unwritten(" and ".join(told)) if told else None


def _unwritten(what):
    return Misconception(
        f"{what}, whatever the arguments: is it still to be written?",
        "Does your function use its arguments?",
        None,
        idle=True,
    )


def _told(answers):
    """Return the rows (n,) with an answer, None where they are too few to tell a relation."""
    known = np.isfinite(answers.came).all(axis=1) & ~answers.none
    whole = (known | answers.none | answers.refused).all()
    return known if known.sum() >= FEWEST and whole else None


def _exchanged(answers, known):
    """Return which returned numbers stand in each other's place."""
    exercise = answers.exercise
    names = exercise.returns
    if any(exercise.shape(name) for name in names):
        return None
    order = []
    for k in range(len(names)):
        places = [
            place
            for place in sorted(range(len(names)), key=lambda place: place != k)
            if answers.alike(answers.expected[:, [place] * len(names)])[known, k].all()
        ]
        order += places[:1]
    moved = [(names[k], names[place]) for k, place in enumerate(order) if k != place]
    if len(order) < len(names) or not moved:
        return None
    (first, other), *more = moved
    swapped = more == [(other, first)]
    told = "; ".join(f"{name} is what {place} should be" for name, place in moved)
    return Misconception(
        f"{first} and {other} exchanged" if swapped else told,
        f"In which order does the task ask for {' and '.join(names)}?",
        None,
    )


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


def largest(answers: np.ndarray) -> np.ndarray:
    """Return per number the largest answer, (k,); 1 where all are 0 or none exists."""
    most = np.max(np.abs(np.where(np.isnan(answers), 0.0, answers)), axis=0, initial=0.0)
    return np.where(most > 0, most, 1.0)


def differences(answers: Answers) -> Iterator[str]:
    """Yield what differs in wrong answers of no known mistake: a sign, half a turn, which rows."""
    known = np.isfinite(answers.came).all(axis=1) & ~answers.none
    wrong = known & ~answers.good
    came, expected = answers.came[wrong], answers.expected[wrong]
    if len(came) < FEWEST:
        return
    angles = answers.exercise.is_angle()
    limits = AFFINE * largest(expected)
    count = f"in {len(came)} of {known.sum()} rows"
    if np.all(np.abs(np.abs(came) - np.abs(expected)) <= limits):
        yield f"the size is right and the sign is wrong {count}"
    elif angles.all() and np.all(answers.difference(2 * came, 2 * expected) <= 2 * limits):
        yield f"off by half a turn {count}"
    elif np.all(np.abs(came - expected) <= CLOSE * largest(expected)):
        off = np.max(np.abs(came - expected) / largest(expected))
        yield f"close to the right value: off by at most {100 * off:.2g} %"
    yield from _which_rows(answers, known, wrong)


def _which_rows(answers, known, wrong):
    """Yield the sign that all wrong rows have and no right one has."""
    if not np.any(known & ~wrong):
        return
    row = dict(zip(answers.exercise.arguments, answers.columns))
    signs = {name: np.asarray(row[name]) for name in MODES if name in row}
    if {"q11", "q12", "q21", "q22"} <= row.keys() and answers.robot.turns:
        signs["sin q12"], signs["sin q22"] = np.sin(row["q12"]), np.sin(row["q22"])
        signs["det A"] = np.sin(row["q21"] + row["q22"] - row["q11"] - row["q12"])
    for name, value in signs.items():
        for sign, word in ((1, "> 0"), (-1, "< 0")):
            if np.array_equal(wrong[known], (sign * value > 0)[known]):
                yield f"wrong where {name} {word}, right elsewhere"
