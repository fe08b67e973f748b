"""The first-order models, right and wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...models.kinematics import Rates
from ...models.robots import Robot
from ..columns import Columns, inverse, pose, times
from ..exercise import Misconception
from .common import Kind, legs_exchanged, length_forgotten, of_bars, passive_misread, words_for


def by_matrix(matrix: Callable) -> Callable:
    """The model that multiplies the given velocity with matrix(A, B, robot)."""

    def model(robot, q11, q12, q21, q22, *velocity):
        at = pose(robot, q11, q12, q21, q22)
        return times(matrix(at.A, at.B, robot), *velocity)

    return model


def with_matrix(name: str, hint: str, matrix: Callable) -> Misconception:
    return Misconception(name, hint, by_matrix(matrix))


dkm = by_matrix(lambda A, B, robot: inverse(A) @ B)
ikm = by_matrix(lambda A, B, robot: inverse(B) @ A)


def wrong_dkm(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    return (
        passive_misread(kind, dkm),
        with_matrix(
            "A and B exchanged", "Solve A xi' = B q' for xi'.", lambda A, B, robot: inverse(B) @ A
        ),
        with_matrix(
            "A transposed",
            say(
                "Put A and B of one pose on paper: does your A xi' give u12 . xi' in its first"
                " row?",
                "Each scalar product with xi' is one row of A xi'.",
            ),
            lambda A, B, robot: inverse(A).swapaxes(1, 2) @ B,
        ),
        with_matrix(
            "A not inverted",
            "A stands beside xi'. What brings it to the other side?",
            lambda A, B, robot: A @ B,
        ),
        with_matrix(
            "matrices in the wrong order",
            "Matrices do not commute: which of them must act on q' first?",
            lambda A, B, robot: B @ inverse(A),
        ),
        with_matrix(
            say("+90 degrees turned the other way", "feet taken to move the other way"),
            say(
                "Everything moves the other way. Which way does v11 point?",
                "Both feet go up at 1 m/s: which way does the end-effector go?",
            ),
            lambda A, B, robot: -inverse(A) @ B,
        ),
    )


def wrong_ikm(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    return (
        passive_misread(kind, ikm),
        with_matrix(
            "A and B exchanged", "Solve A xi' = B q' for q'.", lambda A, B, robot: inverse(A) @ B
        ),
        with_matrix(
            "A transposed",
            say(
                "Does the first row of your A xi' give u12 . xi'?",
                "Each scalar product with xi' is one row of A xi'.",
            ),
            lambda A, B, robot: inverse(B) @ A.swapaxes(1, 2),
        ),
        with_matrix(
            "B not inverted",
            "B stands beside q'. What brings it to the other side?",
            lambda A, B, robot: B @ A,
        ),
        with_matrix(
            say("+90 degrees turned the other way", "feet taken to move the other way"),
            say(
                "Which way does an elbow move when its motor turns counter-clockwise, and which way"
                " does v11 point?",
                "Lift the end-effector straight up: which way do the feet go?",
            ),
            lambda A, B, robot: -inverse(B) @ A,
        ),
    )


def dkm_passive(robot: Robot, *row: np.ndarray) -> Columns:
    return tuple(Rates(pose(robot, *row[:4]), row[4:6], row[6:]).q_passive_dot.T)


def with_standing_pivots(robot: Robot, *row: np.ndarray) -> Columns:
    """The bars' own rates, v12 . xi' / l12 and v22 . xi' / l22, if the drives stood still."""
    return dkm_passive(robot, *row[:4], 0 * row[4], 0 * row[5], *row[6:])


def wrong_dkm_passive(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    pivot = say("elbow", "foot")
    return (
        passive_misread(kind, dkm_passive),
        Misconception(
            f"{pivot} taken as standing still",
            f"xi' is the {pivot}'s velocity and the bar's rotation together. Did you take the"
            f" {pivot}'s part away?",
            lambda robot, *row: tuple(
                drive.relative(rate, q)
                for drive, rate, q in zip(robot.drives, with_standing_pivots(robot, *row), row[4:6])
            ),
        ),
        length_forgotten(
            kind,
            dkm_passive,
            "A velocity in m/s is not a rate in rad/s. Which length lies between them?",
        ),
        Misconception(
            "+90 degrees turned the other way",
            "Turn (1, 0) by +90 degrees, counter-clockwise. Is it (0, 1) or (0, -1)?",
            of_bars(dkm_passive, lambda rate, bar: -rate),
        ),
        legs_exchanged(
            kind, dkm_passive, "In which order does the signature ask for the two rates?"
        ),
    )
