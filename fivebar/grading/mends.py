"""The one change in a student's own formulas that makes a wrong function right: nothing is told
that was not tried.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from .following import Helped, helped, may_help, reached
from .judge import rows_right
from .labs import Lab
from .program import Program
from .questions import AskedRows, Questions, rows_from
from .worker.student import Tried
from .worker.wire import Change

NO_CHANGE = -1
MOST_SURE = 30  # changes right in a few rows that are asked all of them
FEW = 3  # rows that the others must have right first
MOST_KEPT = 8  # rows of a check of a right function that are asked again
MOST_FUNCTIONS = 8  # of a file that are looked at
HINTS = {
    "a sign": "Go through the signs of your formula: which terms add, and which subtract?",
    "a square": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a root": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a factor": "Write the unit of each term beside it, and ask where each factor comes from.",
    "an operator": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a number": "Where does each number in your formula come from?",
    "a term": "Derive the formula once more on paper: how many terms does it have?",
    "a bracket": "In which order does Python compute your formula? Where do brackets belong?",
    "a variable": "Read each name in your formula: which leg, which bar, which derivative is it?",
    "an index": "Read each index in your formula: which row, which column, which leg is it?",
    "a function": "Draw the angle: which side of the triangle is the cosine, which the sine?",
    "the order": "In which order are these two wanted?",
    "a transpose": "Write the shapes and the meaning of rows and columns beside each matrix.",
    "an inverse": "Solve the equation for what you look for: which matrix is on the other side?",
    "a matrix product": "What does * do with two arrays, and what does @ do?",
    "a call": "What does each function that you call do with its argument?",
}


@dataclass(frozen=True)
class Mend:
    """A change that makes a function right, in words: the name without the place, and the place."""

    change: Change
    function: str
    made: Tried

    @property
    def name(self) -> str:
        inside = self.change.function
        where = "" if inside == self.function else f", in your {inside}"
        return f"right but for one thing: {self.change.kind}{where}"

    @property
    def hint(self) -> str:
        return HINTS[self.change.kind]

    def spot(self, place: str) -> str:
        """Return where it is and what would be right; place: the line in its author's words."""
        return f"{place}: {self.change.old}: right answers come with {self.change.new}"


def find_mend(
    program: Program,
    lab: Lab,
    function: str,
    asked: dict[str, list[AskedRows]],
    wrong: set[str],
    known: list[Change],
) -> Mend | None:
    """Return the change that makes a function right, None where there is none.

    asked: what the checks asked of all functions: what is right stays right; wrong: the wrong
    functions of the lab, of which right ones stand in for those that are called; known: changes
    that are tried first.
    """
    called = may_help(program.student.outline, lab, {function}) & wrong
    given = {name: lab.exercises()[name] for name in called}
    with helped(program, given, program.robot_in(lab), lab.constants()) as other:
        search = _Search(other, lab, function, asked[function])
        for name in asked.keys() - wrong:
            search.keep(name, asked[name])
        number = search.number(known)
    if number is None:
        return None
    made = replace(search.tried, numbers=[number])
    return Mend(search.student.changes[number], function, made)


class _Search:
    """Search of a change for one function, in a process of its own."""

    def __init__(self, program: Program, lab: Lab, function: str, asked: list[AskedRows]):
        self.function, self.tried = function, Tried(function, tuple(lab.exercises()))
        self.student: Helped = program.student
        questions = Questions(program, lab, {}, np.random.default_rng(0))
        self.asked = [rows for each in asked for rows in _answerable(each, questions)]
        self.kept: list[tuple[set[str], AskedRows]] = []

    def keep(self, name: str, asked: list[AskedRows]) -> None:
        """Let a right function stay right where it calls the one that is changed."""
        called = reached(self.student.outline, name)
        for rows in asked:
            places = np.arange(len(rows.good))[:: max(1, len(rows.good) // MOST_KEPT)]
            answered = places[~rows.refuse[places]]
            if len(answered):
                self.kept.append((called, _part(rows, answered)))

    def number(self, known: list[Change]) -> int | None:
        """Return the first change after which all rows are right; known: tried before others."""
        first = self._wrong_rows()
        if first is None:
            return None
        self._right(first, [NO_CHANGE])
        changes = self.student.changes
        likely = [k for k, change in enumerate(changes) if change in known]
        for k in (*likely, *self._sieved(first, range(len(changes)))):
            inside = changes[k].function
            kept = [rows for called, rows in self.kept if inside in called]
            if all(self._right(rows, [k])[0] for rows in (*self.asked, *kept)):
                return k
        return None

    def _wrong_rows(self):
        """Return a few rows of which the first has a wrong answer, None where none has."""
        for rows in self.asked:
            places = np.flatnonzero(~rows.good)
            if len(places):
                picked = np.linspace(0, len(places) - 1, FEW).round().astype(int)
                return _part(rows, places[np.unique(picked)])
        return None

    def _sieved(self, few, candidates):
        for place in range(len(few.tolerance)):
            row = _part(few, [place])
            right = self._right(row, candidates)
            candidates = [k for k, good in zip(candidates, right) if good]
        return candidates[:MOST_SURE]

    def _right(self, rows: AskedRows, changes: Iterable[int]) -> list[bool]:
        """Return whether all rows are right, after each of the changes alone."""
        plain, changes = rows_from(rows.columns), [*changes]
        if not changes:
            return []
        many = plain * len(changes)
        tried = replace(self.tried, numbers=[k for k in changes for _ in plain])
        replies = self.student.ask(rows.exercise.name, many, rows.constants, tried=tried)
        columns = tuple(np.tile(column, len(changes)) for column in rows.columns)
        tolerance = np.tile(rows.tolerance, len(changes))
        right = rows_right(rows.exercise, rows.robot, columns, replies, tolerance)
        return np.all(right.reshape(len(changes), len(plain)), axis=1).tolist()


def _part(rows, places):
    return replace(
        rows,
        columns=tuple(np.asarray(column)[places] for column in rows.columns),
        tolerance=rows.tolerance[places],
        good=rows.good[places],
        refuse=rows.refuse[places],
    )


def _answerable(rows, questions):
    """Yield the rows that have an answer, and the same for other lengths and masses where the file
    lets them be set.
    """
    others = []
    if not rows.constants:
        others = [questions.with_others(longer) for longer in (False, True)]
    for robot, constants in ((rows.robot, rows.constants), *others):
        with np.errstate(all="ignore"):
            right = rows.exercise.outcome(rows.exercise.answer, robot, rows.columns)
        places = np.flatnonzero(np.isfinite(right).all(axis=1) & ~rows.refuse)
        if len(places):
            yield replace(_part(rows, places), robot=robot, constants=constants)
