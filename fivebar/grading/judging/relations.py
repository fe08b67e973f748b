"""Plain relations of wrong answers to the right ones: the same, exchanged, a sign, a turn."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..exercise import Misconception

if TYPE_CHECKING:
    from .diagnosis import Answers

MODES = ("assembly_mode", "gamma1", "gamma2", "branch")
AFFINE = 1e-6  # of the largest answer
CLOSE = 0.01  # of the largest answer
FEWEST = 4  # rows; a relation that fewer rows confirm may be a coincidence


def constant(answers: Answers) -> Misconception | None:
    """Return the misconception of who gives the same answer to all rows."""
    known = _told(answers)
    if known is None:
        return None
    range_came = np.ptp(answers.came[known], axis=0)
    range_expected = np.ptp(answers.expected[known], axis=0)
    if range_came.max() > 0 or range_expected.max() == 0:
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
    known = _known(answers)
    clear = known | answers.none | answers.refused
    if known.sum() < FEWEST or not clear.all():
        return None
    return known


def _known(answers):
    finite = np.isfinite(answers.came).all(axis=1)
    return finite & ~answers.none


def exchanged(answers: Answers) -> Misconception | None:
    """Return which returned numbers stand in each other's place in all rows, None if none do."""
    exercise, known = answers.exercise, _told(answers)
    if known is None:
        return None
    names = exercise.returns
    if any(exercise.shape(name) for name in names):
        return None
    moved = []
    for k, name in enumerate(names):
        place = _place_of(answers, known, k)
        if place is None:
            return None
        if place != k:
            moved.append((name, names[place]))
    if not moved:
        return None
    first, other = moved[0]
    if moved[1:] == [(other, first)]:
        told = f"{first} and {other} exchanged"
    else:
        told = "; ".join(f"{name} is what {place} should be" for name, place in moved)
    hint = f"In which order does the task ask for {' and '.join(names)}?"
    return Misconception(told, hint, None)


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


def differences(answers: Answers) -> Iterator[str]:
    """Yield what differs in wrong answers of no known mistake: a sign, half a turn."""
    known = _known(answers)
    wrong = known & ~answers.good
    came = answers.came[wrong]
    expected = answers.expected[wrong]
    if len(came) < FEWEST:
        return
    count = f"in {len(came)} of {known.sum()} rows"
    scale = largest(expected)
    limits = AFFINE * scale
    of_sizes = np.abs(np.abs(came) - np.abs(expected))
    of_values = np.abs(came - expected)
    if np.all(of_sizes <= limits) and np.all(np.any(of_values > limits, axis=1)):
        yield f"the size is right and the sign is wrong {count}"
    elif _half_a_turn_off(answers, came, expected, limits):
        yield f"off by half a turn {count}"
    elif np.all(of_values <= CLOSE * scale):
        off = np.max(of_values / scale)
        yield f"close to the right value: off by at most {100 * off:.2g} %"


def _half_a_turn_off(answers, came, expected, limits):
    angles = answers.exercise.is_angle()
    if not angles.all():
        return False
    # Half a turn is a whole one of the doubled angle.
    of_doubled = answers.difference(2 * came, 2 * expected)
    return np.all(of_doubled <= 2 * limits)
