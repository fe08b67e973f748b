"""Questions to a student's program beside those of a check: what is wrong in one of its functions,
and is it so?
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...models.robots import Robot
from ..columns import Columns
from ..exercise import Exercise, Misconception
from ..intake.program import Program
from ..labs import Lab
from ..robots import parameters_of, with_numbers
from ..values import Unfit, read
from ..worker.replies import Reply
from .judge import Verdict, judge
from .with_right_ones import modelled, some

CLOSE = (
    1e-6  # of the largest right answer: what is no further off spoils no function that builds on it
)
CALL_LIMIT = 10.0  # s, for a call that is asked about a list of measurements
# Kinds that cost a worker: not risked again for nothing.
LOST = "timeout memory killed flood exit".split()
CHANGES = Misconception(
    "another answer to the same question, asked again",
    "What does your function keep from call to call (a global, a list that grows, an argument that"
    " it changes), or draw at random?",
    None,
    idle=True,
)


@dataclass(frozen=True, eq=False)
class AskedRows:
    """Rows of questions: columns, tolerance and refuse (n,), and the constants set in the file;
    good: (n,), which were answered rightly.
    """

    exercise: Exercise
    robot: Robot
    columns: Columns
    tolerance: np.ndarray
    refuse: np.ndarray
    constants: dict
    good: np.ndarray

    @property
    def wrong(self) -> np.ndarray:
        """The numbers of the rows that have an answer and got a wrong one."""
        return np.flatnonzero(~self.good & ~self.refuse)

    @cached_property
    def expected(self) -> np.ndarray:
        """The right answers (n, numbers), nan where there is none."""
        with np.errstate(all="ignore"):
            return self.exercise.outcome(self.exercise.answer, self.robot, self.columns)

    def part(self, places: np.ndarray | list[int]) -> AskedRows:
        """Return some of the rows."""
        return replace(
            self,
            columns=tuple(np.asarray(column)[places] for column in self.columns),
            tolerance=self.tolerance[places],
            good=self.good[places],
            refuse=self.refuse[places],
        )


class Questions:
    """A student's program, the lab that asks it, and which functions cost too many workers."""

    def __init__(
        self, program: Program, lab: Lab, hopeless: dict[str, Reply], order: np.random.Generator
    ):
        self._program, self._hopeless, self._order = program, hopeless, order
        self._exercises, self._robot, self._standard = (
            lab.exercises(),
            program.robot_in(lab),
            lab.robot(),
        )
        also = (with_numbers(self._robot, numbers) for numbers in lab.also())
        given = {*program.student.constants.values()}
        # First the one that has the most of the file's numbers.
        self._own = sorted(
            (self._robot, *also),
            key=lambda robot: len(given.difference(parameters_of(robot).values())),
        )

    def _replies(self, name, rows, constants, limit):
        if name in self._hopeless:
            return [self._hopeless[name]] * len(rows)
        # In an order that no program can count on; a row keeps its place in the verdict.
        order = self._order.permutation(len(rows)).tolist()
        came = self._program.student.ask(
            name, [rows[i] for i in order], constants=constants or None, limit=limit
        )
        replies = [reply for _, reply in sorted(zip(order, came), key=lambda pair: pair[0])]
        kinds = {reply.kind for reply in replies} - {"unasked"}
        if len(kinds) <= 1 and kinds <= set(LOST):
            first = came[0]
            text = f"every call of an earlier check {first.words}"
            self._hopeless[name] = replace(first, kind="unasked", text=text)
        return replies

    def judged(self, name: str, robot: Robot, columns: Sequence, tolerance: ArrayLike) -> Verdict:
        """Return the verdict on a function for itself, in those rows to which there is an answer;
        nothing is recorded.
        """
        exercise, wanted = self._exercises[name], self._set_for(robot)
        rows = rows_of(exercise, robot, columns, np.max(tolerance), None, wanted)
        rows = rows.part(np.isfinite(rows.expected).all(axis=1))
        replies = self._replies(name, rows_from(rows.columns), wanted, None)
        verdict = judge(exercise, robot, rows.columns, replies, rows.tolerance)
        return self._settled(verdict, rows, replies, None)

    def _settled(self, verdict, rows, replies, limit):
        """Return the verdict, where it knows no mistake with what a second look tells."""
        if verdict.share == 1 or verdict.diagnosis is not None:
            return verdict
        came = [reply for reply, refused in zip(replies, rows.refuse) if not refused]
        plain = rows_from(rows.part(~rows.refuse).columns)
        again = self._replies(rows.exercise.name, plain, rows.constants, limit)
        return replace(verdict, diagnosis=CHANGES if changing(came, again) else None)

    def wrong_ones(self, rows: dict[str, tuple[Robot, list]]) -> list[str]:
        """Return those of these functions that answer the rows wrongly; none where one is no
        model.
        """
        rows = {name: given for name, given in rows.items() if given[1]}
        of_lists = {name for name in rows if self._exercises[name].of_lists}
        found = {
            name: self.judged(name, robot, some(asked), CLOSE)
            for name, (robot, asked) in rows.items()
            if name not in of_lists
        }
        for name in of_lists:
            found[name] = self._judged_by_calls(self._exercises[name], *rows[name])
        wrong = {name: verdict for name, verdict in found.items() if verdict.share < 1}
        return [*wrong] if all(map(modelled, wrong.values())) else []

    def _judged_by_calls(self, exercise, robot, rows):
        """Return the verdict on a function of lists; its wrong answers are a model if they change
        with what it is asked.
        """
        rows = [rows[0], rows[-1]]
        came, right = [], [exercise.answer(robot, *row) for row in rows]
        plain = [list(map(_as_lists, row)) for row in rows]
        for reply in self._replies(exercise.name, plain, {}, CALL_LIMIT):
            try:
                came.append(read(exercise, reply.value)[0])
            except Unfit:
                return Verdict(0.0, reply.kind, reply.words)
        good = np.allclose(came, right, rtol=CLOSE, atol=CLOSE)
        changes = bool(np.isfinite(came).all() and np.ptp(came, axis=0).any())
        return Verdict(float(good), rows=len(rows), varies=changes)

    def _set_for(self, robot):
        """Return the constants to be set for a robot that is not the student's own."""
        known = self._program.student.constants
        return (
            {}
            if robot is self._robot
            else {k: v for k, v in parameters_of(robot).items() if k in known}
        )


def _as_lists(part):
    return np.asarray(part).tolist()


def rows_from(columns: Sequence) -> list[tuple]:
    """Return the rows of columns as tuples of plain numbers."""
    return list(zip(*(np.asarray(column).tolist() for column in columns)))


def rows_of(exercise, robot, columns, tolerance, refuse, constants):
    """Return what was asked, with a tolerance and a refuse for each row."""
    n = len(columns[0])
    refuse = np.zeros(n, bool) if refuse is None else np.asarray(refuse)
    good = np.ones(n, bool)
    tolerance = np.broadcast_to(tolerance, n)
    return AskedRows(exercise, robot, columns, tolerance, refuse, constants, good)


def changing(first: list[Reply], again: list[Reply]) -> bool:
    """Return whether any of the values given to the same questions is another one the
    second time.
    """
    pairs = [(a.value, b.value) for a, b in zip(first, again) if a.kind == b.kind == "value"]
    return any(repr(a) != repr(b) for a, b in pairs)
