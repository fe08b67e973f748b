"""The direct geometric models, right and wrong. Points of the plane are complex numbers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...models.dyads import RRR
from ...models.robots import Robot
from ..columns import Array, Columns
from ..exercise import Misconception
from .common import Kind, legs_exchanged, root_of_absolute, root_or_0, words_for


def pivots(robot: Robot, q11: Array, q21: Array) -> Columns:
    """Both elbows, or feet."""
    found = (drive.pivot(drive.direction(q)) for drive, q in zip(robot.drives, (q11, q21)))
    return tuple(x + 1j * y for x, y in found)


def meet(robot: Robot, left: Array, right: Array, assembly_mode: Array) -> Array:
    """The end-effector above these pivots."""
    span, (bar, other) = right - left, robot.distal
    x, y = RRR((span.real, span.imag), bar, other, -assembly_mode).first
    return left + bar * (x + 1j * y)


def xy(point: Array) -> Columns:
    return point.real, point.imag


def dgm(robot: Any, q11: Array, q21: Array, assembly_mode: Any, apart: float = 0.0) -> Columns:
    """apart: by how much each pivot is off, outwards, in distances d of the bases."""
    left, right = pivots(robot, q11, q21)
    return xy(meet(robot, left - apart * robot.d, right + apart * robot.d, assembly_mode))


def foot(robot: Robot, span: Array) -> Array:
    """Distance of H from the right pivot, the pivots being `span` apart."""
    bar, other = robot.distal
    return (span**2 + other**2 - bar**2) / (2 * span)


def half(robot: Robot, span: Array) -> Array:
    return span / 2


def over_h(
    robot: Robot,
    q11: Array,
    q21: Array,
    assembly_mode: Array,
    foot: Callable = foot,
    root: Callable = np.sqrt,
    normal: Callable = lambda along, to_h: 1j * along,
) -> Columns:
    """AMORO eq. 1-3, by way of H."""
    left, right = pivots(robot, q11, q21)
    span = np.abs(left - right)
    along = (left - right) / span
    to_h = foot(robot, span) * along
    return xy(
        right
        + to_h
        + assembly_mode * root(robot.distal[1] ** 2 - np.abs(to_h) ** 2) * normal(along, to_h)
    )


def wrong_dgm(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    feet, base, bars = kind.words.pivots, kind.words.base, say("distal bars", "bars")
    return (
        Misconception(
            "other assembly mode",
            f"Two points are at the right distance from both {feet}. Which one has assembly mode -1"
            " at q11 = q21 = 0?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            "Your answer does not change with assembly_mode. Where does the choice between the two"
            " points enter?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -1),
        ),
        Misconception(
            "legs exchanged",
            say(
                "Turn q11 alone: which elbow should move, and which one moves in your model?",
                "Slide the left foot alone: which one slides in your model?",
            ),
            lambda robot, q11, q21, mode: dgm(robot, q21, q11, mode),
        ),
        Misconception(
            f"origin {say('in', 'on')} the left {base}",
            f"Where is the origin of the frame? Look at the x of {say('A11', 'the left foot')} in"
            " the figure.",
            lambda robot, *row: (dgm(robot, *row)[0] + robot.d / 2, dgm(robot, *row)[1]),
        ),
        Misconception(
            f"{base}s at -d and d",
            f"How far apart are your two {base}s, and what is d?",
            partial(dgm, apart=0.5),
        ),
        Misconception(
            "stops at H",
            say(
                "Your point is in the middle of the elbows. How far is it from either of them, and"
                " how far should it be?",
                "Your point is on the line of the feet. How far is it from either of them, and how"
                " long are the bars?",
            ),
            partial(over_h, root=np.zeros_like),
        ),
        Misconception(
            "root of an absolute value",
            f"What does a negative number under the root say about the two {feet}? abs() only"
            " hides it.",
            partial(over_h, root=root_of_absolute),
        ),
        Misconception(
            "height 0 where the bars do not meet",
            f"Can the two {bars} really meet there? Measure them in the pose that you return.",
            partial(over_h, root=root_or_0),
        ),
        Misconception(
            f"H in the middle although the {bars} differ",
            "Only an isosceles triangle has the foot of its height in the middle. Which lengths"
            " decide where it is?",
            partial(over_h, foot=half),
        ),
    )


def bars(robot: Robot, q11: Array, q21: Array, assembly_mode: Array) -> Columns:
    """The distal bars, from pivot to end-effector."""
    left, right = pivots(robot, q11, q21)
    end = meet(robot, left, right, assembly_mode)
    return end - left, end - right


def dgm_passive(
    robot: Robot, *row: Any, read: Callable = np.angle, off: Callable | None = None
) -> Columns:
    """read: the angle of a bar; off(robot, *row): by how much both pivots are off."""
    found = bars(robot, *row)
    if off:
        found = tuple(bar - error for bar, error in zip(found, off(robot, *row)))
    return tuple(drive.relative(read(bar), q) for drive, bar, q in zip(robot.drives, found, row))


def wrong_dgm_passive(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    return (
        Misconception(
            "other assembly mode",
            say(
                "Check the end-effector first: is it the point that your dgm gives for this"
                " assembly mode?",
                "Does your dgm get the assembly mode as it came?",
            ),
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            say(
                "Your answer does not change with assembly_mode.",
                "Your answers do not change with assembly_mode. For which mode are they right?",
            ),
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -1),
        ),
        Misconception(
            "atan for atan2",
            "Some of your angles are off by half a turn. What does y / x forget?",
            partial(dgm_passive, read=lambda bar: np.arctan(bar.imag / bar.real)),
        ),
        Misconception(
            f"{say('distal bar', 'bar')} read from end-effector to {say('elbow', 'foot')}",
            say(
                "Your angles are off by half a turn everywhere: from which end to which do you read"
                " the bar?",
                "Which end of the bar is its beginning? At home both bars point up.",
            ),
            partial(dgm_passive, read=lambda bar: np.angle(-bar)),
        ),
        Misconception(
            say("base offset forgotten", "guides forgotten"),
            say(
                "The elbow is the base joint plus a bar. Where is the base joint in your"
                " difference?",
                "Where does a bar begin? The x of a foot is not 0.",
            ),
            partial(dgm_passive, off=lambda robot, *row: (robot.d / 2, -robot.d / 2)),
        ),
        legs_exchanged(
            kind, dgm_passive, "In which order does the signature ask for the two angles?"
        ),
        Misconception(
            "angles returned in degrees",
            say(
                "Which unit do the other functions of this lab use?",
                "Which unit do sin and cos expect in the next tasks?",
            ),
            lambda robot, *row: tuple(np.degrees(q) for q in dgm_passive(robot, *row)),
            turn=360.0,
        ),
    )
