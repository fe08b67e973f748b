"""Functions of a student's own that no lab asks for, such as `compute_A_B`: what they compute, and
whether that is right.

A helper is known by the names of its arguments and by its numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...models.robots import Biglide, FiveBar
from ..columns import joint_motion
from ..exercise import Exercise
from ..intake.program import Program
from ..labs import Lab
from ..models import HELPERS, exercises_on
from ..robots import has_models
from ..ten_models import motions
from ..worker.replies import Reply
from .judge import Verdict, judge
from .questions import rows_from

ROWS, RELATED, TOLERANCE = 64, 0.4, 1e-6
MOST = 5  # wrong helpers that are looked at
MOTION = "q11 q12 q21 q22 q11D q12D q21D q22D".split()


@dataclass(frozen=True)
class Helper:
    """A wrong helper: the exercise that it should solve, and the verdict on it."""

    exercise: Exercise
    verdict: Verdict


def wrong_helpers(program: Program, lab: Lab) -> dict[str, Helper]:
    """Return the wrong helpers of a program by name, where it can be told what they should give."""
    robot, student = program.robot_in(lab), program.student
    found: dict = {}
    moving = {}
    if has_models(robot):
        rates = motions(robot, np.random.default_rng(5), ROWS).rates
        moving = dict(zip(MOTION, joint_motion(rates)))
    for name, (arguments, _) in student.outline.items():
        if name in lab.exercises() or name not in student.names or not arguments:
            continue
        candidates = [*_candidates(lab, robot, name, arguments, moving)]
        if not candidates:
            continue
        replies = student.ask(name, rows_from(candidates[0][1]))
        judged = [
            Helper(exercise, judge(exercise, robot, tuple(columns), formed, TOLERANCE))
            for exercise, columns in candidates
            if (formed := _in_the_form_of(exercise, replies))
        ]
        models = [helper for helper in judged if _is_model(helper)]
        if len(found) < MOST and models and all(helper.verdict.share < 1 for helper in judged):
            found[name] = models[0]
    return found


def _is_model(helper):
    """Return whether a helper's numbers have to do with those that it should give."""
    verdict, answers = helper.verdict, helper.verdict.answers
    if answers is None or verdict.diagnosis is not None:
        return answers is None or not verdict.diagnosis.idle
    came = answers.came
    if came.shape[1] == 2 and np.allclose(np.hypot(*came.T), 1):
        return False  # a direction
    return _related(came, answers.expected, helper.exercise.is_angle())


def _related(came: np.ndarray, expected: np.ndarray, angles: np.ndarray) -> bool:
    """Return whether half of the numbers (n, k) that came vary from row to row as the right ones
    do, or more.

    Numbers that have nothing to do with 64 right ones correlate by 0.4 once in 1,000 times.
    """
    alike, most = 0, 0
    for a, b, turns in zip(came.T, expected.T, angles):
        rows = np.isfinite(a) & np.isfinite(b)
        a, b = (np.exp(1j * part[rows]) if turns else part[rows] for part in (a, b))
        a, b = a - a.mean(), b - b.mean()
        sizes = np.linalg.norm(a) * np.linalg.norm(b)
        alike += sizes > 0 and abs(np.vdot(a, b)) > RELATED * sizes
        most += np.linalg.norm(b) > 0
    return bool(most and alike >= most / 2)


@cache
def _roles(turns):
    return exercises_on(FiveBar if turns else Biglide, *HELPERS)


def _candidates(lab, robot, name, arguments, moving) -> Iterator[tuple[Exercise, list]]:
    """Yield exercises with these arguments that a helper may solve, and rows to ask."""
    for role, columns in lab.helpers():
        if len(role.arguments) == len(arguments) and not set(arguments) & moving.keys():
            yield _called(role, name, arguments, role.arguments), list(columns)
    if not set(arguments) <= moving.keys():
        return
    given = [moving[argument] for argument in arguments]
    for role in _roles(robot.turns):
        own = _called(role, name, arguments, arguments)
        right = role.outcome(role.answer, robot, [moving[key] for key in role.arguments])
        if np.allclose(own.outcome(own.answer, robot, given), right, rtol=1e-9, atol=1e-12):
            yield own, given


def _called(role, name, arguments, keys):
    """Return the exercise of a role under a helper's own name, with its arguments in their order;
    keys: what the role calls them. What is no argument of the helper's counts as 0.
    """

    def on_row(model):
        def with_own_arguments(robot, *columns):
            given = dict(zip(keys, columns))
            row = (given.get(key, 0.0 * columns[0]) for key in role.arguments)
            return model(robot, *row)

        return model and with_own_arguments

    return replace(
        role,
        signature=f"{name}({', '.join(arguments)}) -> {', '.join(role.returns)}",
        answer=on_row(role.answer),
        wrong=tuple(replace(each, model=on_row(each.model)) for each in role.wrong),
    )


def _in_the_form_of(exercise, replies):
    """Return the replies with their numbers in the form that an exercise asks for, or None where
    they are of another count.
    """
    formed = []
    for reply in replies:
        numbers = reply.kind == "value" and _numbers(reply.value)
        if not numbers or len(numbers) != len(exercise.is_angle()):
            return None
        parts = [part[0] for part in exercise.parts(np.array([numbers]))]
        formed.append(Reply("value", parts if len(parts) > 1 else parts[0]))
    return formed


def _numbers(value):
    """Return the numbers in a value, in order; None where it holds something else."""
    if isinstance(value, list):
        parts = [_numbers(part) for part in value]
        return None if None in parts else sum(parts, [])
    array = np.asarray(value)
    return array.astype(float).ravel().tolist() if array.dtype.kind in "bif" else None
