"""A mistake in a helper of a student's own that spoils several functions: known by the values that
they all need there, also where no formula of these is found.
"""

from __future__ import annotations

import numpy as np

from .following import helped, may_help, reached, spread
from .formulas import CLOSE
from .labs import Lab
from .mends import MOST_NEEDED
from .needed import Needs
from .program import Program
from .questions import AskedRows
from .ten_models import TEN, columns_of, motions
from .worker.student import Tried

Spot = tuple[str, int, str]  # a place in a helper: its function, its line, what stands there


class SharedMistakes:
    """What wrong functions of the lab need in the helpers that they call, along one motion."""

    def __init__(self, program: Program, lab: Lab, wrong: set[str]):
        self._program, self._lab, self._wrong = program, lab, wrong
        self._robot = program.robot_in(lab)
        self._payers: dict[str, dict[Spot, np.ndarray]] = {}

    def let_pay(self, function: str) -> None:
        """Let a function pay for what is wrong in its helpers."""
        outline, exercises = self._program.student.outline, self._lab.exercises()
        if function in TEN and reached(outline, function) - exercises.keys():
            [self._payers[function]] = self._needed(function, [self._along(function)])

    def payer(self, function: str, asked: list[AskedRows]) -> tuple[str, str]:
        """Return a function that pays and needs the same values in a helper as this one, which
        needs them in the wrong rows of what was asked, too, and the helper; "", "" where none is.
        """
        outline = self._program.student.outline
        own = reached(outline, function) - self._lab.exercises().keys()
        others = [name for name in self._payers if own & reached(outline, name)]
        if function not in TEN or not others:
            return "", ""
        [mine] = self._needed(function, [self._along(function)])
        for other in others:
            values = self._payers[other]
            both = mine.keys() & values.keys()
            same = [spot for spot in both if _alike(mine[spot], values[spot])]
            for needed in self._needed(function, asked) if same else ():
                same = [spot for spot in same if spot in needed]
            if same:
                return other, same[0][0]
        return "", ""

    def _along(self, function):
        """Return rows along a motion, the same one for all functions."""
        motion = motions(self._robot, np.random.default_rng(0), MOST_NEEDED)
        columns, no = columns_of(function, motion), np.zeros(MOST_NEEDED, bool)
        exercise = self._lab.exercises()[function]
        return AskedRows(exercise, self._robot, columns, 0.0 * no, no, {}, no)

    def _needed(self, function, several):
        """Return for each of these rows what places of helpers need so that a function is right."""
        exercises = self._lab.exercises()
        called = may_help(self._program.student.outline, self._lab, {function}) & self._wrong
        given = {name: exercises[name] for name in called}
        found = []
        with helped(self._program, given, self._robot, self._lab.constants()) as other:
            for rows in several:
                wrong = np.flatnonzero(~rows.good & ~rows.refuse)
                few = rows.part(wrong[spread(len(wrong), MOST_NEEDED)])
                needs = Needs(other.student, Tried(function, tuple(exercises)), few)
                found.append({})
                for need in needs.all(apart=exercises):
                    place = need.place
                    if place.moved[needs.wrong].all():
                        found[-1][place.function, place.line, place.text] = need.wanted
        return found


def _alike(a, b):
    """Return whether two functions need the same values."""
    return a.shape == b.shape and bool(np.all(np.abs(a - b) <= CLOSE * np.abs(b).max()))
