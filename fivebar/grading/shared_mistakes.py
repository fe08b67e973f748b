"""A mistake in a helper of a student's own that spoils several functions: known by the values that
they all need there, also where no formula of these is found.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .following import reached, spread, with_right_called
from .formulas import CLOSE
from .judge import related
from .labs import Lab
from .mends import moving
from .needed import Need, Needs, Spot, spot_of
from .program import Program
from .questions import AskedRows
from .ten_models import TEN
from .worker.student import Tried

ROWS = 16  # in which values are looked for


class SharedMistakes:
    """What wrong functions of the lab need in the helpers that they call, along one motion."""

    def __init__(self, program: Program, lab: Lab, wrong: set[str]):
        self._program, self._lab, self._wrong = program, lab, wrong
        self._robot = program.robot_in(lab)
        self._payers: dict[str, dict[tuple[Spot, int], Need]] = {}
        self._named: set[str] = set()

    def let_pay(self, function: str, asked: list[AskedRows], is_named: bool) -> None:
        """Let a function pay for what is wrong in its helpers; is_named: whether all its answers
        are those of a known mistake.
        """
        if is_named:
            self._named.add(function)
        outline, exercises = self._program.student.outline, self._lab.exercises()
        if function in TEN and reached(outline, function) - exercises.keys():
            along = [self._along(asked)]
            [needed] = self._needed(function, along, lambda spot: spot[0] not in exercises)
            self._payers[function] = needed

    def payer(self, function: str, asked: list[AskedRows], is_named: bool) -> tuple[str, str]:
        """Return a function that pays and needs the same values in a helper as this one, which
        needs them in the wrong rows of what was asked, too, and the helper; "", "" where none is.
        """
        outline = self._program.student.outline
        own = reached(outline, function) - self._lab.exercises().keys()
        others = [name for name in self._payers if own & reached(outline, name)]
        if function not in TEN or not others:
            return "", ""
        spots = {spot for name in others for spot, _ in self._payers[name]}
        [mine] = self._needed(function, [self._along(asked)], spots.__contains__)
        for other in others:
            values = self._payers[other]
            # Where both give the answers of a known mistake, their helper has a meaning.
            model = is_named and other in self._named
            same = [
                key
                for key in mine
                if key in values
                and _alike(mine[key], values[key])
                and (model or _is_model(mine[key]))
            ]
            spots = {spot for spot, _ in same}
            for needed in self._needed(function, asked, spots.__contains__) if same else ():
                same = [key for key in same if key in needed]
            if same:
                (helper, *_), _ = same[0]
                return other, helper
        return "", ""

    def _along(self, asked):
        """Return rows along a motion, the same one for all functions."""
        return replace(moving(asked[0], self._robot), robot=self._robot, constants={})

    def _needed(self, function, several, where):
        """Return for each of these rows (spot, count of its numbers) -> what it needs so that
        a function is right.
        """
        tried = Tried(function, tuple(self._lab.exercises()))
        found = []
        with with_right_called(self._program, self._lab, function, self._wrong) as other:
            for rows in several:
                wrong = rows.wrong
                few = rows.part(wrong[spread(len(wrong), ROWS)])
                needs = Needs(other.student, tried, few)
                values = {}
                for need in needs.all(where=where):
                    if need.place.moved[needs.wrong].all():
                        count = need.wanted.shape[1]
                        values[spot_of(need.place.told), count] = need
                found.append(values)
        return found


def _alike(mine, other):
    """Return whether two functions need the same values in a place."""
    a, b = mine.wanted, other.wanted
    if a.shape != b.shape:
        return False
    most = CLOSE * np.abs(b).max()
    off = np.abs(a - b)
    return bool(np.all(off <= most))


def _is_model(need):
    """Return whether what stands in a place has to do with what is needed: from numbers of no
    meaning nothing follows.
    """
    return related(need.old, need.wanted, np.zeros(need.wanted.shape[1], bool))
