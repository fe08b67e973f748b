"""A submission opened: the student's program in a process of its own, and the robot that it is
judged for.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...models.robots import Robot
from ..labs import Lab
from ..worker.live import from_functions
from ..worker.replies import Reply
from ..worker.session import session_program
from ..worker.student import Student
from ..worker.submission import SubmissionError, read_submission
from .hand_in import ProgramFile, imported
from .lab_constants import robot_of_file
from .students_robots import PUBLIC_SEED, robot_from


class NoProgram:
    """Stands for a submission that cannot be read: whatever is asked, that is the answer."""

    output = ""
    notes = ()
    names = ()
    constants: dict = {}
    outline: dict = {}

    def __init__(self, text: str):
        self.trouble = Reply("import", text=text)

    def ask(
        self, function: str, rows: list, constants: dict | None = None, limit: float | None = None
    ) -> list[Reply]:
        return [self.trouble] * len(rows)

    def close(self) -> None:
        pass


@dataclass(frozen=True)
class Program:
    """A student's running program and the robot it is judged for, None: the lab's with the
    constants of its source.

    where: a line's number in its author's words; remark: how the file was read, where that is worth
    a sentence; again: opens the same file in another process; confined: of a session, gives the
    Program of its source.
    """

    student: Any  # Student, Live, NoProgram or Helped
    robot: Any = None  # Robot
    where: Callable[[int], str] = "line {}".format
    remark: str = ""
    again: Any = None  # gives a context with a Student
    confined: Any = None

    def robot_in(self, lab: Lab) -> Robot:
        if lab.constants():
            return self.robot_of_file(lab)[0]
        return self.robot or robot_from(lab.robot(), self.student.constants)

    def robot_of_file(self, lab: Lab) -> tuple[Robot, tuple[str, ...]]:
        """Return the robot of a file that has the lab's own names for its numbers, and what is to
        be said of them.
        """
        return robot_of_file(lab.robot(), lab.constants(), self.student.constants)


def session(functions: dict[str, Callable]) -> Program:
    """Return the Program of a session's functions."""
    live = from_functions(**functions)
    found = session_program(functions, live.constants) if sys.platform != "win32" else None
    if found is None:
        return Program(live)
    submission, where = found

    def again():
        return Student(submission, total=30.0)

    def confined():
        return Program(again(), where=where, again=again)

    return Program(live, confined=confined)


@dataclass(frozen=True)
class Job:
    """How one file is graded: seed of the inputs, the student's id and robot (None: as the file
    says).

    member: of a zip; siblings: files that it may import; trouble: why there is no file to grade, so
    that all its checks earn nothing; hints_from, packages: as in Report.
    """

    path: Path
    student: str = ""
    seed: str = PUBLIC_SEED
    robot: Any = None  # Robot
    isolate: str = "process"
    limit: float | None = None
    trouble: str = ""
    member: str = ""
    siblings: tuple[ProgramFile, ...] = ()
    hints_from: str = ""
    packages: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.path.name}/{self.member}" if self.member else self.path.name

    def open(self) -> Program:
        """Return the Program in a process of its own, or NoProgram where it cannot be read. Raises
        IsolationError.
        """
        if self.trouble:
            return Program(NoProgram(self.trouble), self.robot)
        try:
            submission = read_submission(self.path, self.member)
        except SubmissionError as error:
            return Program(NoProgram(str(error)), self.robot)
        limits: dict[str, Any] = {"packages": self.packages}
        if self.limit is not None:
            limits |= {"limit": self.limit, "total": max(20.0, 10 * self.limit)}
        modules = imported(submission.source, self.siblings)
        student = Student(submission, isolate=self.isolate, modules=modules, **limits)

        def again():
            known = {"modules": modules, "packages": self.packages}
            return Student(submission, isolate=self.isolate, total=30.0, **known)

        return Program(student, self.robot, submission.where, submission.remark, again=again)
