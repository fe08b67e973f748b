"""A mistake is not paid for twice: where a function calls a wrong one, it is judged with the right
one in its place.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...models.robots import Robot
from ..exercise import Exercise
from ..intake.program import Program
from ..labs import Lab
from ..robots import parameters_of, with_numbers
from ..worker.live import Live
from ..worker.replies import Reply
from ..worker.student import LIMIT, Tried
from .judge import Verdict

MODES = "assembly_mode gamma1 gamma2 branch".split()
MOST_ASKED = 30_000  # rows of right functions in a check
MOST_KEPT = 2_000
ASKED = 16  # of them, of the student's own
A_CALL = 1.2e-4  # s of the grader's own processor time
PATIENCE = 5  # a call that waits for right answers may take so many times as long
# No stand-in helps these.
NEVER = "missing import timeout unasked memory killed flood exit garbled".split()


class BudgetSpentError(Exception):
    """What a search may ask has been asked."""


@dataclass
class Budget:
    """Processor time in seconds that calls may take from now on."""

    left: float

    def pay(self, replies: list[Reply]) -> None:
        """Take away what these calls took. Raises BudgetSpentError where nothing is left."""
        self.left -= sum(reply.seconds for reply in replies) + A_CALL * len(replies)
        if self.left < 0:
            raise BudgetSpentError


@dataclass
class Helped:
    """A student's program of which some functions are replaced by the right ones; asked like a
    Student.

    rows: what the program asked of each, and for which robot; constants_of: the file's name for a
    number -> the robot's, where they differ; change: one that is made in the program, too;
    budget: of its calls.
    """

    student: Any
    exercises: dict[str, Exercise]
    robot: Robot
    constants_of: dict[str, tuple[str, ...]] = field(default_factory=dict)
    rows: dict[str, tuple[Robot, list]] = field(default_factory=dict)
    asked: int = 0
    change: Tried | None = None
    budget: Budget | None = None

    def __getattr__(self, name):
        return getattr(self.student, name)

    def ask(
        self,
        function: str,
        rows: list,
        constants: dict | None = None,
        limit: float | None = None,
        tried: Tried | None = None,
    ) -> list[Reply]:
        known = parameters_of(self.robot)
        lengths_and_masses: dict = {}
        for name, value in (constants or {}).items():
            owners = self.constants_of.get(name, (name,))
            lengths_and_masses |= {owner: value for owner in owners if owner in known}
        robot = with_numbers(self.robot, lengths_and_masses)
        given = {name: self._right(name, robot) for name in self.exercises}
        patience, tried = PATIENCE * (limit or LIMIT), tried or self._tried(rows)
        options = {"tried": tried} if tried else {}  # a session's functions cannot be changed
        replies = self.student.ask(function, rows, constants, patience, given, **options)
        if self.budget:
            self.budget.pay(replies)
        return replies

    def _tried(self, rows):
        """Return the change, if any, with which all rows are asked."""
        change = self.change
        return change and replace(change, numbers=change.numbers * len(rows))

    def _right(self, name, robot):
        exercise = self.exercises[name]

        def right(row):
            row = row[: len(exercise.arguments)]
            self.asked += 1
            answer = _answer(exercise, robot, row) if self.asked <= MOST_ASKED else None
            kept = self.rows.setdefault(name, (robot, []))
            if exercise.of_lists:
                kept[1].append(row)
            elif answer is not None and kept[0] == robot and len(kept[1]) < MOST_KEPT:
                columns = np.broadcast_arrays(*row, [0])[:-1]
                kept[1].extend(zip(*(column.tolist() for column in columns)))
            return answer

        return right


def _answer(exercise, robot, row):
    """Return the right answer to one row as lists, None where there is none.

    Some arguments may be lists of numbers, as of a function that is called with arrays: so are the
    answers then.
    """
    if exercise.of_lists:
        return _answer_to_lists(exercise, robot, row)
    if len(row) != len(exercise.arguments):
        return None
    try:
        with np.errstate(all="ignore"):
            given = np.broadcast_arrays(*(np.asarray(value) for value in row), [0.0])[:-1]
            if any(each.ndim > 1 or each.dtype.kind not in "if" for each in given):
                return None
            if not (np.abs(given) < 1e6).all():  # false for NaN
                return None
            names = zip(exercise.arguments, given)
            columns = [each.astype(int) if name in MODES else each for name, each in names]
            numbers = exercise.outcome(exercise.answer, robot, columns)
    except (ArithmeticError, ValueError, LookupError, TypeError):
        return None
    if not np.isfinite(numbers).all():
        return None
    parts = exercise.parts(numbers)
    if all(np.ndim(value) == 0 for value in row):
        return [part[0].tolist() for part in parts]
    return [np.moveaxis(part, 0, -1).tolist() for part in parts]


def _answer_to_lists(exercise, robot, row):
    """Return the right answer to lists of numbers, None where there is none."""
    try:
        with np.errstate(all="ignore"):
            given = [np.asarray(part, float) for part in row]
            numbers = exercise.answer(robot, *given)
    except (ValueError, TypeError, np.linalg.LinAlgError):
        return None
    return [float(number) for number in numbers] if np.isfinite(numbers).all() else None


@contextmanager
def helped(
    program: Program,
    exercises: dict[str, Exercise],
    robot: Robot,
    constants_of: dict[str, tuple[str, ...]],
    change: Tried | None = None,
) -> Iterator[Program]:
    """Yield the program in a process of its own, in which these functions are the right ones;
    change: the number of one that is made in it, too.
    """
    live = isinstance(program.student, Live)
    with nullcontext(program.student) if live else program.again() as student:
        student.form = program.student.form
        other = Helped(student, exercises, robot, constants_of, change=change)
        yield replace(program, student=other, again=None)


@contextmanager
def with_right_called(
    program: Program, lab: Lab, function: str, wrong: set[str]
) -> Iterator[Program]:
    """Yield the program with the right ones of those wrong functions that a function may call."""
    called = may_help(program.student.outline, lab, {function}) & wrong
    given = {name: lab.exercises()[name] for name in called}
    with helped(program, given, program.robot_in(lab), lab.constants()) as other:
        yield other


def reached(outline: dict, function: str) -> set[str]:
    """Return the functions of a program's outline that one mentions, or what it calls does."""
    waiting, seen = [function], set()
    while waiting:
        name = waiting.pop()
        if name in outline and name not in seen:
            seen.add(name)
            waiting += outline[name][1]
    return seen - {function}


def builds_on(outline: dict, function: str, changed: set[str]) -> bool:
    """Return whether a function calls one of these, or may: a method may be called by any, as the
    outline holds its class alone.
    """
    return not changed <= outline.keys() or bool(changed & reached(outline, function))


def may_help(outline: dict, lab: Lab, asked: set[str]) -> set[str]:
    """Return the functions of the lab that those which were asked may call, and whose mistakes they
    need not pay for: all of them where the program's outline does not hold one asked.
    """
    uses, found = lab.uses(), set()
    for name in asked & uses.keys():
        found |= set(uses[name]) & (reached(outline, name) if name in outline else set(uses[name]))
    return found - asked


def modelled(verdict: Verdict) -> bool:
    """Return whether these wrong answers are a model with a mistake: one that can be named, that
    changes with what is asked, or that raises. From what is still to be written nothing follows.
    """
    if verdict.diagnosis is not None:
        return not verdict.diagnosis.idle
    raises = verdict.reason == "exception" and "NotImplementedError" not in verdict.text
    return verdict.share > 0 or verdict.varies or raises


def remark(wrong: list[str]) -> str:
    """Return what is said of who gets points in spite of these functions of his own."""
    are = "are" if len(wrong) > 1 else "is"
    return f"judged with the right {' and '.join(wrong)} in place of your own, which {are} wrong"


def some(rows: list) -> list[np.ndarray]:
    """Return columns of a few of the rows, from the first to the last."""
    few = [rows[k] for k in spread(len(rows), ASKED)]
    return [np.array(column) for column in zip(*few)]


def spread(count: int, most: int) -> np.ndarray:
    """Return the numbers of so many rows out of `count`, from the first to the last."""
    return np.unique(np.linspace(0, count - 1, most).round().astype(int))
