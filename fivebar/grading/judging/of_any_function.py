"""Mistakes that can be made in any function, whatever it models."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ...models.robots import Robot
from ..exercise import Exercise, Misconception
from ..robots import has_models


def in_degrees(exercise: Exercise, robot: Robot) -> list[Misconception]:
    """Return sines and cosines of angles that are taken for degrees; rates stay what they are."""
    turning = {"q12", "q22"} | ({"q11", "q21"} if has_models(robot) and robot.turns else set())
    at = [name in turning for name in exercise.arguments]
    if not any(at):
        return []

    def model(robot, *columns):
        return exercise.answer(
            robot, *(np.radians(column) if turns else column for column, turns in zip(columns, at))
        )

    hint = (
        "What is the unit of the angles that come as arguments, and which one do sin and cos"
        " expect?"
    )
    return [Misconception("angles taken as degrees", hint, model)]


def returned_in_degrees(exercise: Exercise) -> list[Misconception]:
    """Return the misconception of angles in degrees, where the exercise asks for angles."""

    def model(robot, *columns):
        return tuple(np.degrees(angle) for angle in exercise.answer(robot, *columns))

    hint = "Which unit do motors, sin and cos use here?"
    wrong = Misconception("angles returned in degrees", hint, model, turn=360.0)
    return [wrong] if exercise.angles else []


def arguments_exchanged(exercise: Exercise) -> Iterator[Misconception]:
    """Yield two arguments of the same kind, each taken for the other."""
    hint = "In which order do they come in, and which of them does each of your formulas need?"
    kinds = [re.sub(r"\d", "", name).replace("y", "x") for name in exercise.arguments]
    for i, j in combinations(range(len(kinds)), 2):
        if kinds[i] == kinds[j]:

            def model(robot, *row, i=i, j=j):
                row = list(row)
                row[i], row[j] = row[j], row[i]
                return exercise.answer(robot, *row)

            yield Misconception(
                f"{exercise.arguments[i]} and {exercise.arguments[j]} exchanged", hint, model
            )
