"""Compares a student's replies with the right model, and with the wrong ones, in the grader's own
process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...models.robots import Robot
from ..columns import Columns, largest
from ..exercise import Exercise, Misconception
from ..values import Unfit, read
from ..worker.replies import KINDS, Reply
from .diagnosis import Answers, diagnose, difference

TOLERANCE = 1e-9  # of the largest right answer of the check
# Errors of unfinished or broken code; any other exception where no pose exists is taken as a
# refusal.
BROKEN = tuple(
    (
        "NotImplementedError NameError UnboundLocalError TypeError AttributeError ImportError"
        " ModuleNotFoundError SyntaxError IndexError KeyError RecursionError MemoryError"
    ).split()
)


@dataclass(frozen=True, eq=False)
class Verdict:
    """What one check found: share of its points earned in [0, 1] and, where something is wrong,
    why.

    reason: "" or one of value, nan, shape, type, accepted, or a Reply's kind; text: the reason in
    words; wrong, rows: how many of how many calls; asked, came: the first wrong call; off: by how
    much it is off, in the answer's unit;
    diagnosis: the Misconception that gives the student's answers; line, source: in the student's
    file; sample: the numbers of that call for a figure, never printed; remarks: what was let pass;
    beside: what the lab's own test says;
    varies: whether wrong answers change from row to row where the right ones do, as those of a
    function that is written to its end; answers: what was asked and came.
    """

    share: float
    reason: str = ""
    text: str = ""
    wrong: int = 0
    rows: int = 0
    asked: str = ""
    came: str = ""
    off: float | None = None
    diagnosis: Misconception | None = None
    line: int | None = None
    source: str = ""
    remarks: tuple[str, ...] = ()
    sample: dict | None = None
    beside: str = ""
    varies: bool = False
    answers: Answers | None = field(default=None, repr=False)


def judge(
    exercise: Exercise,
    robot: Robot,
    columns: Columns,
    replies: list[Reply],
    tolerance: ArrayLike = TOLERANCE,
    refuse: np.ndarray | None = None,
    threshold: tuple[float, Callable] | None = None,
) -> Verdict:
    """Return the verdict on the replies to one call per row of the columns, each (n,).

    tolerance: of the largest right answer, a number or (n,). refuse: (n,) bool, the rows in which
    no answer exists and the function shall raise or give nan; they earn only if some of the others
    are right. threshold: the mean error that the lab's own test lets pass, and what it compares,
    (n, 2), of all numbers (n, k).
    """
    n = len(columns[0])
    refuse = np.zeros(n, bool) if refuse is None else np.asarray(refuse)
    expected = exercise.outcome(exercise.answer, robot, columns)
    expected[refuse] = np.nan
    unanswered = ~np.all(np.isfinite(expected), axis=1) & ~refuse
    if np.any(unanswered):
        raise ValueError(f"the right {exercise.name} has no answer in row {np.argmax(unanswered)}")
    angles = exercise.is_angle()
    limits = limits_of(exercise, expected, tolerance)
    came, reasons, texts, remarks = _outcomes(exercise, replies, refuse)
    errors = difference(came, expected, exercise.turns)
    for i in np.flatnonzero([not reason for reason in reasons]):
        if refuse[i]:
            reasons[i], texts[i] = (
                "accepted",
                "gave an answer where none exists: raise an error, or return nan or None",
            )
        elif np.any(off := ~(errors[i] <= np.broadcast_to(limits, errors.shape)[i])):
            reasons[i], texts[i] = "value", f"wrong value{_where(exercise, off)}"
    refused = np.array([reason == "refused" for reason in reasons])
    good = refused | np.array([not reason for reason in reasons])
    forfeited = np.any(refuse) and not np.any(good & ~refuse)
    if forfeited:
        good[:] = False  # refusing everything is no answer
    share, beside = float(good.mean()), _beside(came, expected, angles, threshold)
    if exercise.guessable and share < 1:
        share = 0.0
    if share == 1:
        return Verdict(1.0, rows=n, remarks=remarks, beside=beside)
    with np.errstate(all="ignore"):
        changing = varies(_totals(exercise, came), _totals(exercise, expected))
    answers = Answers(exercise, robot, columns, came, expected, limits, good, refused)
    # A refusal that is only not counted tells less than a wrong answer.
    wrong = np.flatnonzero(~good).tolist()
    told = [i for i in wrong if reasons[i] not in ("", "refused")]
    asked = [i for i in told if reasons[i] != "unasked"] or told
    first = asked[0]
    reply, text = replies[first], texts[first]
    if left := len(told) - len(asked):
        text += f"; {left} more calls were not asked, as these took all of the time"
    if forfeited and np.any(refused):
        text += " (where no answer exists, refusing earns points only if another answer is right)"
    with np.errstate(all="ignore"):
        diagnosis = diagnose(answers)
    return Verdict(
        share,
        reasons[first],
        text,
        len(wrong) - left,
        n,
        call_text(exercise, columns, first),
        came_text(reply),
        _off(errors[first]),
        diagnosis,
        reply.line,
        reply.source,
        remarks,
        _sample(exercise, columns, first, expected[first], came[first]),
        beside,
        varies=changing,
        answers=answers,
    )


def varies(came: np.ndarray, expected: np.ndarray) -> bool:
    """Return whether most of the numbers (n, k) came, and each changes whose right one does."""
    finite = np.isfinite(came)
    spread = np.nan_to_num(came).max(axis=0) - np.nan_to_num(came).min(axis=0)
    wanted = np.nanmax(expected, axis=0) - np.nanmin(expected, axis=0)
    return bool(2 * finite.sum() > finite.size and np.all((spread > 0) | ~(wanted > 0)))


def _totals(exercise, numbers):
    """Return the sum (n, returned names) of what each returned name holds."""
    return np.stack([part.reshape(len(part), -1).sum(axis=1) for part in exercise.parts(numbers)]).T


def numbers_of(exercise: Exercise, replies: list[Reply]) -> np.ndarray:
    """Return the numbers (n, k) of replies, nan where there are none."""
    return _outcomes(exercise, replies, np.zeros(len(replies), bool))[0]


def limits_of(exercise: Exercise, expected: np.ndarray, tolerance: ArrayLike) -> np.ndarray:
    """Return the largest error allowed: of an angle in radians, else of the largest answer."""
    scale = np.where(exercise.is_angle(), 1.0, largest(expected))
    return np.asarray(tolerance)[..., None] * scale


def _beside(came, expected, angles, threshold):
    """Return the mean errors by the lab's own measure, in words."""
    if threshold is None:
        return ""
    most, measure = threshold
    if angles.any():
        came = expected + (came - expected + np.pi) % (2 * np.pi) - np.pi
    errors = np.mean(np.abs(measure(came) - measure(expected)), axis=0)
    if not np.all(np.isfinite(errors)):
        return ""
    word = "OK" if np.all(errors < most) else "error in model"
    return f"mean errors {errors[0]:.2g} and {errors[1]:.2g}: {word} (threshold {most:g})"


def _outcomes(exercise, replies, refuse):
    """Return numbers (n, k), nan where there are none; per row a reason ("" if to be compared) and
    its text; remarks.
    """
    came = np.full((len(replies), len(exercise.is_angle())), np.nan)
    reasons, texts, remarks = [], [], []
    for i, reply in enumerate(replies):
        reason, text = reply.kind, reply.words
        if reply.kind == "value":
            reason = text = ""
            try:
                came[i], notes = read(exercise, reply.value)
                remarks += [note for note in notes if note not in remarks]
                if not np.all(np.isfinite(came[i])):
                    reason, text = (
                        "nan",
                        "returned nan" if np.any(np.isnan(came[i])) else "returned infinity",
                    )
            except Unfit as unfit:
                reason, text = unfit.reason, str(unfit)
                if reply.value is None and np.any(refuse):
                    text = "returned None, as if there were no answer: is a return missing?"
        if refuse[i] and (
            reason == "nan"
            or (reply.kind == "value" and reply.value is None)
            or (reason == "exception" and not reply.text.startswith(BROKEN))
        ):
            reason = "refused"
        reasons.append(reason)
        texts.append(text)
    return came, reasons, texts, tuple(remarks)


def _where(exercise, off):
    """Return " of q12", or " of M[0, 1]", where only some of the returned numbers are wrong; off:
    which of them, (numbers,).
    """
    wrong: list = []
    for name, part in zip(exercise.returns, exercise.parts(off[None])):
        places = np.argwhere(part[0])
        whole = len(places) == part[0].size
        wrong += [name] if whole else [f"{name}{place.tolist()}" for place in places]
    return "" if wrong == list(exercise.returns) else f" of {', '.join(wrong)}"


def call_text(exercise: Exercise, columns: Columns, row: int) -> str:
    """Return the call of one row as the student would write it."""
    words = ", ".join(
        f"{name}={column[row]:.12g}" for name, column in zip(exercise.arguments, columns)
    )
    return f"{exercise.name}({words})"


def came_text(reply: Reply) -> str:
    """Return what came back, short enough for one line of a report."""
    if reply.kind != "value":
        return f"{reply.text or KINDS[reply.kind]}"[:200]
    value = reply.value
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=9, separator=", ", threshold=12).replace("\n", " ")[
            :200
        ]
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, dict) and value.get("~") == "other":
        return f"<{value.get('type', 'object')}>"
    if isinstance(value, list):
        parts = [came_text(Reply("value", part)) for part in value[:12]]
        return f"({', '.join(parts + ['...'] * (len(value) > 12))})"[:200]
    return repr(value)[:200]


def _off(errors):
    finite = errors[np.isfinite(errors)]
    return float(finite.max()) if finite.size else None


def _sample(exercise, columns, row, expected, came):
    return {
        "inputs": {name: float(column[row]) for name, column in zip(exercise.arguments, columns)},
        "expected": expected.tolist(),
        "came": came.tolist(),
    }
