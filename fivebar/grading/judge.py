"""Compares a student's replies with the right model, and with the wrong ones, in the grader's own process."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..models.robots import Robot
from .columns import Columns
from .exercise import Exercise, Misconception
from .values import Unfit, read
from .worker.replies import KINDS, Reply

TOLERANCE = 1e-9  # of the largest right answer of the check
# Errors of unfinished or broken code; any other exception where no pose exists is taken as a refusal.
BROKEN = (
    "NotImplementedError", "NameError", "UnboundLocalError", "TypeError", "AttributeError", "ImportError",
    "ModuleNotFoundError", "SyntaxError", "IndexError", "KeyError", "RecursionError", "MemoryError",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Verdict:
    """What one check found: share of its points earned in [0, 1] and, where something is wrong, why.

    reason: "" or one of value, nan, shape, type, accepted, or a Reply's kind; text: the reason in words; wrong, rows:
    how many of how many calls; asked, came: the first wrong call; off: by how much it is off, in the answer's unit;
    diagnosis: the Misconception that gives the student's answers; line, source: in the student's file; sample: the
    numbers of that call for a figure, never printed; remarks: what was let pass.
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


def judge(
    exercise: Exercise,
    robot: Robot,
    columns: Columns,
    replies: list[Reply],
    tolerance: ArrayLike = TOLERANCE,
    refuse: np.ndarray | None = None,
) -> Verdict:
    """Verdict on the replies to one call per row of the columns, each (n,).

    tolerance: of the largest right answer, a number or (n,). refuse: (n,) bool, the rows in which no answer exists and
    the function shall raise or give nan; they earn only if some of the others are right.
    """
    n = len(columns[0])
    refuse = np.zeros(n, bool) if refuse is None else np.asarray(refuse)
    expected = exercise.outcome(exercise.answer, robot, columns)
    expected[refuse] = np.nan
    unanswered = ~np.all(np.isfinite(expected), axis=1) & ~refuse
    if np.any(unanswered):
        raise ValueError(f"the right {exercise.name} has no answer in row {np.argmax(unanswered)}")
    angles = exercise.is_angle()
    limits = np.asarray(tolerance)[..., None] * np.where(angles, 1.0, _scale(expected))
    came, reasons, texts, remarks = _outcomes(exercise, replies, refuse)
    errors = _difference(came, expected, angles)
    for i in np.flatnonzero([not reason for reason in reasons]):
        if refuse[i]:
            reasons[i], texts[i] = "accepted", "gave an answer where none exists: raise an error, or return nan or None"
        elif np.any(off := ~(errors[i] <= np.broadcast_to(limits, errors.shape)[i])):
            reasons[i], texts[i] = "value", f"wrong value{_where(exercise, off)}"
    refused = np.array([reason == "refused" for reason in reasons])
    good = refused | np.array([not reason for reason in reasons])
    forfeited = np.any(refuse) and not np.any(good & ~refuse)
    if forfeited:
        good[:] = False  # refusing everything is no answer
    share = float(good.mean())
    if exercise.guessable and share < 1:
        share = 0.0
    if share == 1:
        return Verdict(1.0, rows=n, remarks=remarks)
    first = _first_wrong(good, reasons, refuse)
    reply, text = replies[first], texts[first]
    if forfeited and np.any(refused):
        text += " (refusing counts only beside a right answer in the same check)"
    with np.errstate(all="ignore"):
        diagnosis = _diagnose(exercise, robot, columns, came, expected, limits, good, refused, angles)
    return Verdict(
        share, reasons[first], text, int(n - good.sum()), n, call_text(exercise, columns, first),
        came_text(reply), _off(errors[first]), diagnosis, reply.line, reply.source, remarks,
        _sample(exercise, columns, first, expected[first], came[first]),
    )  # fmt: skip


def _scale(expected):
    """Per number the largest right answer, (numbers,); 1 where all are 0 or none exists."""
    largest = np.max(np.abs(np.where(np.isnan(expected), 0.0, expected)), axis=0, initial=0.0)
    return np.where(largest > 0, largest, 1.0)


def _difference(a, b, angles, turn=2 * np.pi):
    with np.errstate(invalid="ignore"):
        raw = np.abs(a - b)
        return np.where(angles, np.abs((raw + turn / 2) % turn - turn / 2), raw)


def _outcomes(exercise, replies, refuse):
    """Numbers (n, k), nan where there are none; per row a reason ("" if to be compared) and its text; remarks."""
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
                    reason, text = "nan", "returned nan" if np.any(np.isnan(came[i])) else "returned infinity"
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


def _first_wrong(good, reasons, refuse):
    """A refusal that is only not counted tells less than a wrong answer."""
    wrong = [i for i in np.flatnonzero(~good) if reasons[i] not in ("", "refused")]
    return wrong[0]


def _where(exercise, off):
    """ " of q12" where only some of the returned names are wrong; off: which of the numbers, (numbers,)."""
    owners = np.concatenate([np.full(int(np.prod(exercise.shape(name))), name) for name in exercise.returns])
    wrong = [name for name in exercise.returns if np.any(off[owners == name])]
    return "" if len(wrong) == len(exercise.returns) else f" of {', '.join(wrong)}"


def _diagnose(exercise, robot, columns, came, expected, limits, good, refused, angles):
    """The first misconception whose outcomes are the student's in all rows, in a wrong one unlike the right answer.

    A row rightly refused says nothing about the model behind it, nor does a huge outcome at a singularity about scale.
    Failing that, the first one that the student has for some parts of the answer, the others being right: a mistake in
    one leg.
    """
    none = np.isnan(expected[:, 0])
    known = np.all(np.isfinite(came), axis=1)
    starts = _starts(exercise)
    right = _by_parts((_difference(came, expected, angles) <= limits) | refused[:, None], starts)
    in_part = None
    for misconception in exercise.wrong:
        outcome = exercise.outcome(misconception.model, robot, columns)
        outcome[~np.all(np.isfinite(outcome), axis=1)] = np.nan
        nothing = np.isnan(outcome[:, 0])
        close = np.maximum(limits, TOLERANCE * _scale(outcome[~none]))
        alike = _difference(came, outcome, angles, misconception.turn) <= close
        same = np.all(alike, axis=1)
        fits = same | (~known & nothing) | refused
        if np.all(fits) and np.any(same) and np.any(fits & ~good & ~(nothing & none)):
            return misconception
        taken = ~right & _by_parts(alike | refused[:, None], starts)
        if in_part is None and np.any(taken) and np.all(right | taken):
            in_part = misconception
    return in_part


def _starts(exercise):
    """The first number of each part of the answer that can be wrong alone: a matrix's row, else each number."""
    shapes = [exercise.shape(name) for name in exercise.returns]
    widths = [width for shape in shapes for width in [shape[-1] if len(shape) > 1 else 1] * int(np.prod(shape[:1]))]
    return np.cumsum([0, *widths[:-1]])


def _by_parts(true, starts):
    """Per part whether all its numbers (n, numbers) are true in all rows."""
    return np.logical_and.reduceat(np.all(true, axis=0), starts)


def call_text(exercise: Exercise, columns: Columns, row: int) -> str:
    """The call of one row as the student would write it."""
    words = ", ".join(f"{name}={column[row]:.12g}" for name, column in zip(exercise.arguments, columns))
    return f"{exercise.name}({words})"


def came_text(reply: Reply) -> str:
    """What came back, short enough for one line of a report."""
    if reply.kind != "value":
        return f"{reply.text or KINDS[reply.kind]}"[:200]
    value = reply.value
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=9, separator=", ", threshold=12).replace("\n", " ")[:200]
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, list):
        return ("(" + ", ".join(came_text(type(reply)("value", part)) for part in value[:12]) + ")")[:200]
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
