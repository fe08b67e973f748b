"""A mistake in a helper of a student's own that spoils several functions: known by the values that
they all need there, also where no formula of these is found.
"""

from __future__ import annotations

import numpy as np

from .following import helped, may_help, reached, spread
from .formulas import CLOSE
from .judge import related
from .labs import Lab
from .needed import Need, Needs, Spot, spot_of
from .program import Program
from .questions import AskedRows
from .ten_models import TEN, columns_of, motions
from .worker.student import Tried

ROWS = 16  # in which values are looked for


class SharedMistakes:
    """What wrong functions of the lab need in the helpers that they call, along one motion."""

    def __init__(self, program: Program, lab: Lab, wrong: set[str]):
        self._program, self._lab, self._wrong = program, lab, wrong
        self._robot = program.robot_in(lab)
        self._payers: dict[str, dict[tuple[Spot, int], Need]] = {}

    def let_pay(self, function: str) -> None:
        """Let a function pay for what is wrong in its helpers."""
        outline, exercises = self._program.student.outline, self._lab.exercises()
        if function in TEN and reached(outline, function) - exercises.keys():
            along = [self._along(function)]
            [needed] = self._needed(function, along, lambda spot: spot[0] not in exercises)
            self._payers[function] = needed

    def payer(self, function: str, asked: list[AskedRows]) -> tuple[str, str]:
        """Return a function that pays and needs the same values in a helper as this one, which
        needs them in the wrong rows of what was asked, too, and the helper; "", "" where none is.
        """
        outline = self._program.student.outline
        own = reached(outline, function) - self._lab.exercises().keys()
        others = [name for name in self._payers if own & reached(outline, name)]
        if function not in TEN or not others:
            return "", ""
        spots = {spot for name in others for spot, _ in self._payers[name]}
        [mine] = self._needed(function, [self._along(function)], spots.__contains__)
        for other in others:
            values = self._payers[other]
            same = set()
            for key in mine.keys() & values.keys():
                if _same_model(mine[key], values[key]):
                    same.add(key)
            spots = {spot for spot, _ in same}
            for needed in self._needed(function, asked, spots.__contains__) if same else ():
                same &= needed.keys()
            if same:
                (helper, *_), _ = same.pop()
                return other, helper
        return "", ""

    def _along(self, function):
        """Return rows along a motion, the same one for all functions."""
        motion = motions(self._robot, np.random.default_rng(0), ROWS)
        columns, no = columns_of(function, motion), np.zeros(ROWS, bool)
        exercise = self._lab.exercises()[function]
        return AskedRows(
            exercise,
            self._robot,
            columns,
            tolerance=np.zeros(ROWS),
            refuse=no,
            constants={},
            good=no,
        )

    def _needed(self, function, several, where):
        """Return for each of these rows (spot, count of its numbers) -> what it needs so that
        a function is right.
        """
        exercises = self._lab.exercises()
        outline = self._program.student.outline
        called = may_help(outline, self._lab, {function}) & self._wrong
        given = {name: exercises[name] for name in called}
        found = []
        with helped(self._program, given, self._robot, self._lab.constants()) as other:
            for rows in several:
                wrong = np.flatnonzero(~rows.good & ~rows.refuse)
                few = rows.part(wrong[spread(len(wrong), ROWS)])
                needs = Needs(other.student, Tried(function, tuple(exercises)), few)
                values = {}
                for need in needs.all(where=where):
                    if need.place.moved[needs.wrong].all():
                        count = need.wanted.shape[1]
                        values[spot_of(need.place.told), count] = need
                found.append(values)
        return found


def _same_model(mine, other):
    """Return whether two functions need the same values in a place, and what stands there has to
    do with them: from numbers of no meaning nothing follows.
    """
    a, b = mine.wanted, other.wanted
    if a.shape != b.shape:
        return False
    no_angles = np.zeros(b.shape[1], bool)
    if not related(mine.old, b, no_angles):
        return False
    most = CLOSE * np.abs(b).max()
    return bool(np.all(np.abs(a - b) <= most))
