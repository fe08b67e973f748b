"""tau = M q'' + c, right and wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...models import dynamics
from ...models.robots import Robot
from ..columns import Array, Columns, inverse, motion
from ..exercise import Misconception
from .common import Kind, c_forgotten, passive_misread, words_for


def dynamic_model(robot: Robot, *row: Array) -> Columns:
    return dynamics.dynamic_model(motion(robot, *row))


def with_model(name: str, hint: str, change: Callable) -> Misconception:
    """A wrong M and c: change(Z, m, A, B, d) -> M, c, where d and c are columns (n, 2, 1)."""

    def model(robot, *row):
        rates = motion(robot, *row)
        M, c = change(
            np.diag(robot.inertias), robot.m, rates.pose.A, rates.pose.B, rates.d[..., None]
        )
        return np.broadcast_to(M, (len(row[0]), 2, 2)), c[..., 0]

    return Misconception(name, hint, model)


def turned(matrix: Array) -> Array:
    return matrix.swapaxes(-1, -2)


def M_of(Z: Array, m: float, A: Array, B: Array, d: Array) -> Array:
    J = inverse(A) @ B
    return Z + m * turned(J) @ J


def c_of(Z: Array, m: float, A: Array, B: Array, d: Array) -> Array:
    return m * turned(inverse(A) @ B) @ inverse(A) @ d


def wrong_dynamic_model(kind: Kind) -> tuple[Misconception, ...]:
    say, (first, second) = words_for(kind), kind.words.inertias
    mass = say("mass", "end-effector's mass")
    return (
        passive_misread(kind, dynamic_model),
        with_model(
            say("zz forgotten", "feet's masses forgotten"),
            "Take the end-effector's mass away: "
            + say("does your robot still have inertia?", "is there nothing left to accelerate?"),
            lambda Z, *rest: (M_of(0 * Z, *rest), c_of(Z, *rest)),
        ),
        with_model(
            f"{mass} forgotten in M",
            "Take the "
            + say("bars' inertia", "feet's masses")
            + " away: is there nothing left to accelerate?",
            lambda Z, m, *rest: (Z, c_of(Z, m, *rest)),
        ),
        c_forgotten(
            kind, lambda robot, *row: (dynamic_model(robot, *row)[0], np.zeros((len(row[0]), 2)))
        ),
        with_model(
            "c of the wrong sign",
            "Insert xi'' = A^-1 (B q'' + d) once more, sign by sign.",
            lambda *all_: (M_of(*all_), -c_of(*all_)),
        ),
        with_model(
            "c without J^T A^-1",
            say(
                "d is not a torque. Which matrices bring an acceleration along the bars to the"
                " motors?",
                "d lies along the bars. Which matrices bring it to the drives?",
            ),
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * d),
        ),
        with_model(
            "c without A^-1",
            "xi'' = A^-1 (B q'' + d): what stands before d?",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * turned(inverse(A) @ B) @ d),
        ),
        with_model(
            "c without J^T",
            "m A^-1 d is a force on the end-effector. Which "
            + say("torques is it worth?", "efforts of the drives is it worth?"),
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * inverse(A) @ d),
        ),
        with_model(
            "J J^T instead of J^T J",
            "xi' = J q'. Write the kinetic energy m |xi'|^2 / 2 with q'.",
            lambda Z, m, A, B, d: (
                Z + m * (inverse(A) @ B) @ turned(inverse(A) @ B),
                c_of(Z, m, A, B, d),
            ),
        ),
        with_model(
            "J = B^-1 A",
            "J gives the end-effector's velocity from the "
            + say("motors'", "feet's")
            + ". Solve A xi' = B q' for the right one.",
            lambda Z, m, A, B, d: (
                Z + m * turned(inverse(B) @ A) @ (inverse(B) @ A),
                m * turned(inverse(B) @ A) @ inverse(A) @ d,
            ),
        ),
        with_model(
            f"{mass} halved",
            "The 1/2 of the kinetic energy meets the exponent when you differentiate.",
            lambda Z, m, *rest: (M_of(Z, m / 2, *rest), c_of(Z, m / 2, *rest)),
        ),
        Misconception(
            say("one inertia for both legs", "one mass for both feet"),
            say(f"{first} and {second}", "The feet's masses")
            + " may differ. Where does each of them stand?",
            lambda robot, *row: dynamic_model(
                replace(robot, **{second: getattr(robot, first)}), *row
            ),
        ),
    )
