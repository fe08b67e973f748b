"""The second-order models, right and wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ...models.kinematics import Accelerations
from ...models.robots import Robot
from ..columns import Array, Columns, inverse, motion, times
from ..exercise import Misconception
from .common import Kind, legs_exchanged, length_forgotten, passive_misread, words_for


def parts(robot: Robot, *row: Array) -> Columns:
    """A, B and d of a motion, arrays (n, 2, 2) and (n, 2)."""
    rates = motion(robot, *row)
    return rates.pose.A, rates.pose.B, rates.d


def dkm2(robot: Robot, *row: Array, parts: Callable = parts) -> Columns:
    A, B, d = parts(robot, *row[:8])
    return times(inverse(A), *(times(B, *row[8:]) + d.T))


def ikm2(robot: Robot, *row: Array, parts: Callable = parts) -> Columns:
    A, B, d = parts(robot, *row[:8])
    return times(inverse(B), *(times(A, *row[8:]) - d.T))


def with_parts(name: str, hint: str, parts: Callable) -> list[Misconception]:
    """The misconception of other A, B, d in both models, dkm2 and ikm2."""
    return [Misconception(name, hint, partial(model, parts=parts)) for model in (dkm2, ikm2)]


def with_d(name: str, hint: str, d: Callable) -> list[Misconception]:
    """The misconception of another d(robot, *row) -> (n, 2) in both models."""
    return with_parts(name, hint, lambda robot, *row: (*parts(robot, *row)[:2], d(robot, *row)))


def d_of(robot: Robot, *row: Array) -> Array:
    return parts(robot, *row)[2]


def wrong_bias(kind: Kind) -> list[list[Misconception]]:
    """Of dkm2 and ikm2, in pairs."""
    say = words_for(kind)
    return [
        [passive_misread(kind, model) for model in (dkm2, ikm2)],
        with_d(
            say("d forgotten", "centripetal term missing"),
            f"Let the {say('motors', 'feet')} run at constant speed: is the end-effector's"
            " acceleration 0?",
            lambda robot, *row: 0 * d_of(robot, *row),
        ),
        with_d(
            f"{say('d', 'centripetal term')} of the wrong sign",
            "The derivative of v is -u" + say("", " phi'") + ". To which side does that term go?",
            lambda robot, *row: -d_of(robot, *row),
        ),
    ]


def dkm2_passive(robot: Robot, *row: Array) -> Columns:
    return tuple(Accelerations(motion(robot, *row[:8]), row[8:10], row[10:]).q_passive_ddot.T)


def with_own_centripetal(robot: Robot, *row: Array) -> Columns:
    legs = zip(robot.drives, dkm2_passive(robot, *row), row[4:8:2], row[5:8:2])
    return tuple(value + drive.absolute(passive, own) ** 2 for drive, value, own, passive in legs)


def wrong_dkm2_passive(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    return (
        passive_misread(kind, dkm2_passive),
        Misconception(
            f"centripetal term {say('of the distal bar ', '')}kept",
            f"You multiply by v{say('12', '')}. What is left there of a vector along"
            f" u{say('12', '')}?",
            with_own_centripetal,
        ),
        length_forgotten(
            kind,
            dkm2_passive,
            "An acceleration in m/s² is not one in rad/s². Which length lies between them?",
        ),
        legs_exchanged(
            kind, dkm2_passive, "In which order does the signature ask for the two accelerations?"
        ),
    )
