"""A mistake is not paid for twice: where a function calls a wrong one, it is judged with the right
one in its place.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..models.robots import Robot
from .diagnosis import MODES
from .exercise import Exercise
from .judge import Verdict
from .labs import Lab
from .program import Program
from .worker.live import Live
from .worker.replies import Reply
from .worker.student import LIMIT

MOST_ASKED, MOST_KEPT, ASKED = (
    30_000,
    2_000,
    16,
)  # rows of right functions in a check; kept; asked of the student's own
PATIENCE = 5  # a call that waits for right answers may take so many times as long
NEVER = (
    "missing",
    "import",
    "timeout",
    "memory",
    "killed",
    "flood",
    "exit",
    "garbled",
)  # no stand-in helps these


@dataclass
class Helped:
    """A student's program of which some functions are replaced by the right ones; asked like a
    Student.

    rows: what the program asked of each, and for which robot.
    """

    student: Any
    exercises: dict[str, Exercise]
    robot: Robot
    rows: dict[str, tuple[Robot, list]] = field(default_factory=dict)
    count: int = 0

    names = property(lambda self: self.student.names)
    constants = property(lambda self: self.student.constants)

    def ask(
        self, function: str, rows: list, constants: dict | None = None, limit: float | None = None
    ) -> list[Reply]:
        known = self.robot.parameters
        robot = replace(self.robot, **{k: v for k, v in (constants or {}).items() if k in known})
        given = {name: self._right(name, robot) for name in self.exercises}
        return self.student.ask(function, rows, constants, PATIENCE * (limit or LIMIT), given)

    def _right(self, name, robot):
        exercise = self.exercises[name]

        def right(row):
            row = row[: len(exercise.arguments)]
            self.count += 1
            answer = _answer(exercise, robot, row) if self.count <= MOST_ASKED else None
            kept = self.rows.setdefault(name, (robot, []))
            if answer is not None and kept[0] == robot and len(kept[1]) < MOST_KEPT:
                kept[1].append(row)
            return answer

        return right


def _answer(exercise, robot, row):
    """Return the right answer to one row as lists, None where there is none."""
    plain = len(row) == len(exercise.arguments) and all(
        type(v) in (int, float) and abs(v) < 1e6 for v in row
    )
    if not plain:
        return None
    columns = [
        np.array([int(v) if name in MODES else v]) for name, v in zip(exercise.arguments, row)
    ]
    try:
        with np.errstate(all="ignore"):
            numbers = exercise.outcome(exercise.answer, robot, columns)
    except (ArithmeticError, ValueError, LookupError, TypeError):
        return None
    return (
        [part[0].tolist() for part in exercise.parts(numbers)]
        if np.isfinite(numbers).all()
        else None
    )


@contextmanager
def helped(program: Program, exercises: dict[str, Exercise], robot: Robot) -> Iterator[Program]:
    """Yield the program in a process of its own, in which these functions are the right ones."""
    if isinstance(program.student, Live):
        yield replace(program, student=Helped(program.student, exercises, robot))
        return
    with program.again(program.source) as student:
        yield replace(program, student=Helped(student, exercises, robot), again=None)


def may_call(source: str, function: str, names: Iterable[str]) -> set[str]:
    """Return those of the names that the function mentions, or what it calls in the file; all where
    that cannot be seen.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return set(names)
    defined: dict = {}
    for node in tree.body:
        for name in (
            (node.name,)
            if hasattr(node, "name")
            else [t.id for t in getattr(node, "targets", ()) if isinstance(t, ast.Name)]
        ):
            defined.setdefault(name, []).append(node)
    if function not in defined:
        return set(names)
    waiting, seen = [function], set()
    while waiting:
        if (name := waiting.pop()) not in seen:
            seen.add(name)
            waiting += [
                n.id
                for node in defined.get(name, ())
                for n in ast.walk(node)
                if isinstance(n, ast.Name)
            ]
    return seen & set(names) - {function}


def may_help(source: str, lab: Lab, asked: set[str]) -> set[str]:
    """Return the functions of the lab that those which were asked may call, and whose mistakes they
    need not pay for.
    """
    uses = lab.uses()
    return (
        set().union(*(may_call(source, name, uses[name]) for name in asked & uses.keys())) - asked
    )


def modelled(verdict: Verdict) -> bool:
    """Return whether these wrong answers are a model with a mistake: one that can be named, or that
    goes with the right one.

    Nothing follows from numbers that anybody could write down.
    """
    if verdict.diagnosis is not None:
        return not verdict.diagnosis.idle
    return verdict.share > 0 or verdict.related


def remark(wrong: dict[str, str]) -> str:
    """Return what is said of who gets points in spite of these functions of his own."""
    names, known = (
        " and ".join(wrong),
        {name: mistake for name, mistake in wrong.items() if mistake},
    )
    told = "; ".join(
        known.values()
        if len(wrong) == 1
        else (f"{name}: {mistake}" for name, mistake in known.items())
    )
    are = "are" if len(wrong) > 1 else "is"
    return (
        f"judged with the right {names} in place of your own, which {are}"
        f" wrong{told and f' ({told})'}"
    )


def some(rows: list) -> list[np.ndarray]:
    """Return columns of a few of the rows, from the first to the last."""
    few = [rows[k] for k in np.unique(np.linspace(0, len(rows) - 1, ASKED).round().astype(int))]
    return [np.array(column) for column in zip(*few)]
