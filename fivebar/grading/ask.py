"""What a lab's check asks through: the student's answer, the verdict on it, its record."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..models.robots import Robot
from .exercise import Exercise, Misconception
from .judge import TOLERANCE, Verdict, came_text, judge
from .labs import Lab
from .program import Program
from .variants import parameters
from .worker.replies import Reply

LOST = ("timeout", "memory", "killed", "flood", "exit")  # kinds that cost a worker: not risked again for nothing


class Wrong(AssertionError):
    """The student's answer is not all right; `verdict` says why."""

    def __init__(self, verdict: Verdict):
        super().__init__(verdict.text)
        self.verdict = verdict


@dataclass(frozen=True)
class Asked:
    """A verdict with the exercise and the robot that it is about; both None where the check judged by itself."""

    verdict: Verdict
    function: str = ""
    exercise: Exercise | None = None
    robot: Robot | None = None


class Ask:
    """The fixture `ask`: `ask(name, *columns)` judges one call per row, `ask.call` makes one, `ask.verdict` records."""

    def __init__(self, program: Program, lab: Lab, hopeless: dict[str, Reply], order: np.random.Generator):
        self._program, self._hopeless, self._order = program, hopeless, order
        self._exercises, self._robot, self._standard = lab.exercises(), program.robot_in(lab), lab.robot()
        self.record = []

    def __call__(
        self,
        name: str,
        *columns: ArrayLike,
        robot: Robot | None = None,
        constants: dict | None = None,
        tolerance: ArrayLike = TOLERANCE,
        refuse: np.ndarray | None = None,
        limit: float | None = None,
    ) -> None:
        """Ask the student's function `name` for every row of the columns, (n,) each, and judge it by the exercise.

        robot: another than the student's; its numbers are set where the student's file names them. constants: more
        names to set there, which it must hold. tolerance, refuse: of `judge`. limit: seconds for one call. Raises Wrong
        unless all is right.
        """
        __tracebackhide__ = True
        if name not in self._exercises:
            raise LookupError(f"exercises.py has no exercise {name!r}; it has {', '.join(self._exercises) or 'none'}")
        columns = [np.asarray(column) for column in columns]
        exercise, own = self._exercises[name], robot is None
        robot = robot or self._robot
        wanted = {} if own else {k: v for k, v in parameters(robot).items() if k in self._program.student.constants}
        replies = self._replies(name, list(zip(*(c.tolist() for c in columns))), wanted | (constants or {}), limit)
        if own and robot != self._standard:
            exercise = replace(exercise, wrong=(*exercise.wrong, _not_your_robot(exercise, self._standard)))
        self._keep(Asked(judge(exercise, robot, columns, replies, tolerance, refuse), name, exercise, robot))

    def call(self, name: str, *row: float, limit: float | None = None) -> object:
        """The value that one call gives, arrays and floats as they came; Wrong where it gives none."""
        __tracebackhide__ = True
        (reply,) = self._replies(name, [row], {}, limit)
        if reply.kind == "value" and reply.value is not None:
            return reply.value
        kind = "type" if reply.kind == "value" else reply.kind
        words = ", ".join(f"{value:.12g}" if isinstance(value, float) else str(value) for value in row)
        text = "returned None: is a return missing?" if kind == "type" else reply.words
        verdict = Verdict(
            0.0, kind, text, 1, 1, f"{name}({words})"[:200], came_text(reply), line=reply.line, source=reply.source
        )
        self._keep(Asked(verdict, name))

    def verdict(
        self, share: float, reason: str = "", asked: str = "", came: str = "", off: float | None = None
    ) -> None:
        """Record the check's own judgement: share of the points in [0, 1] and why it is not 1. Wrong unless it is."""
        __tracebackhide__ = True
        share = float(share)
        if not 0 <= share <= 1:
            raise ValueError(f"a verdict's share must lie in 0..1, not {share!r}")
        off = None if off is None else float(off)
        self._keep(Asked(Verdict(share, "" if share == 1 else "value", reason, asked=asked, came=came, off=off)))

    def _replies(self, name, rows, constants, limit):
        if name in self._hopeless:
            return [self._hopeless[name]] * len(rows)
        # In an order that no program can count on; a row keeps its place in the verdict.
        order = self._order.permutation(len(rows)).tolist()
        came = self._program.student.ask(name, [rows[i] for i in order], constants=constants or None, limit=limit)
        replies = [reply for _, reply in sorted(zip(order, came), key=lambda pair: pair[0])]
        kinds = {reply.kind for reply in replies}
        if len(kinds) == 1 and kinds <= set(LOST):
            last = came[-1]
            text = "so did every call of an earlier check"
            self._hopeless[name] = Reply(last.kind, text=text, line=last.line, source=last.source)
        return replies

    def _keep(self, asked):
        __tracebackhide__ = True
        self.record.append(asked)
        if asked.verdict.share < 1:
            raise Wrong(asked.verdict)


def _not_your_robot(exercise, standard):
    return Misconception(
        "not your robot",
        "These are the answers for the robot of the handout. Which lengths stand at the top of your own student.py?",
        lambda robot, *columns: exercise.answer(standard, *columns),
    )
