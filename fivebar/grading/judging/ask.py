"""What a lab's check asks through: the student's answer, the verdict on it, its record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...models.robots import Robot
from ..exercise import Exercise, Misconception
from .judge import TOLERANCE, Verdict, came_text, judge
from .questions import AskedRows, Questions, rows_from, rows_of


class Wrong(AssertionError):
    """The student's answer is not all right; `verdict` says why."""

    def __init__(self, verdict: Verdict):
        super().__init__(verdict.text)
        self.verdict = verdict


@dataclass(frozen=True)
class Asked:
    """A verdict with the exercise and the robot that it is about; both None where the check judged
    by itself.
    """

    verdict: Verdict
    function: str = ""
    exercise: Exercise | None = None
    robot: Robot | None = None


class Ask(Questions):
    """The fixture `ask`: `ask(name, *columns)` judges one call per row, `ask.call` makes one,
    `ask.verdict` records.
    """

    def __init__(self, *questions: Any):
        super().__init__(*questions)
        self.record: list = []
        self.asked: set = set()
        self.rows_asked: list[AskedRows] = []

    def __call__(
        self,
        name: str,
        *columns: Any,
        robot: Robot | None = None,
        tolerance: ArrayLike = TOLERANCE,
        refuse: np.ndarray | None = None,
        limit: float | None = None,
        threshold: tuple[float, Callable] | None = None,
    ) -> None:
        """Ask the student's function `name` for every row of the columns, (n,) each, and judge it
        by the exercise.

        robot: another than the student's; its numbers are set where the student's file names them.
        tolerance, refuse, threshold: of `judge`. limit: seconds for one call.
        Raises Wrong unless all is right.
        """
        __tracebackhide__ = True
        if name not in self._exercises:
            raise LookupError(
                f"exercises.py has no exercise {name!r}; it has"
                f" {', '.join(self._exercises) or 'none'}"
            )
        self.asked.add(name)
        columns = tuple(np.asarray(column) for column in columns)
        exercise, own = self._exercises[name], robot is None
        robot = robot or self._robot
        wanted = self._set_for(robot)
        replies = self._replies(name, rows_from(columns), wanted, limit)
        if own and robot != self._standard:
            exercise = replace(
                exercise, wrong=(*exercise.wrong, _not_your_robot(exercise, self._standard))
            )
        best: Any = None
        for also in self._own if own else (robot,):
            verdict = judge(exercise, also, columns, replies, tolerance, refuse, threshold)
            if best is None or verdict.share > best.share:
                best, best_robot = verdict, also
            if best.share == 1:
                break
        rows = rows_of(exercise, best_robot, columns, tolerance, refuse, wanted)
        good = rows.good if best.answers is None else best.answers.good
        self.rows_asked.append(replace(rows, good=good))
        if best.reason in ("value", "nan", "exception", "shape"):
            best = self._settled(best, replace(rows, robot=robot), replies, limit)
        self._keep(Asked(best, name, exercise, robot))

    def remark(self, text: str) -> None:
        """Add a remark to what was recorded last."""
        last = self.record.pop() if self.record else Asked(Verdict(1.0))
        self.record.append(
            replace(last, verdict=replace(last.verdict, remarks=(*last.verdict.remarks, text)))
        )

    def call(self, name: str, *row: float, limit: float | None = None) -> Any:
        """Return the value that one call gives, arrays and floats as they came; Wrong where it
        gives none.
        """
        __tracebackhide__ = True
        self.asked.add(name)
        (reply,) = self._replies(name, [row], {}, limit)
        if reply.kind == "value" and reply.value is not None:
            return reply.value
        kind = "type" if reply.kind == "value" else reply.kind
        words = ", ".join(
            f"{value:.12g}" if isinstance(value, float) else str(value) for value in row
        )
        text = "returned None: is a return missing?" if kind == "type" else reply.words
        verdict = Verdict(
            0.0,
            kind,
            text,
            1,
            1,
            f"{name}({words})"[:200],
            came_text(reply),
            line=reply.line,
            source=reply.source,
        )
        self._keep(Asked(verdict, name))

    def verdict(
        self,
        share: float,
        reason: str = "",
        asked: str = "",
        came: str = "",
        off: float | None = None,
    ) -> None:
        """Record the check's own judgement: share of the points in [0, 1] and why it is not 1.
        Wrong unless it is.
        """
        __tracebackhide__ = True
        share = float(share)
        if not 0 <= share <= 1:
            raise ValueError(f"a verdict's share must lie in 0..1, not {share!r}")
        off = None if off is None else float(off)
        kind = "" if share == 1 else "value"
        name = next(iter(self.asked)) if len(self.asked) == 1 else ""
        self._keep(Asked(Verdict(share, kind, reason, asked=asked, came=came, off=off), name))

    def _keep(self, asked):
        __tracebackhide__ = True
        self.record.append(asked)
        if asked.verdict.share < 1:
            raise Wrong(asked.verdict)


def _not_your_robot(exercise, standard):
    return Misconception(
        "not your robot",
        "These are the answers for the robot of the handout. Which lengths stand at the top of your"
        " own student.py?",
        lambda robot, *columns: exercise.answer(standard, *columns),
    )
