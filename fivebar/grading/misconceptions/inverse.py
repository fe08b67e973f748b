"""The inverse geometric model, right and wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...models.geometry import reach
from ...models.robots import Robot
from ..columns import Array, Columns
from ..exercise import Misconception
from .common import Kind, legs_exchanged, root_of_absolute, root_or_0, words_for


def igm(robot: Robot, x: Array, y: Array, gamma1: Any, gamma2: Any) -> Columns:
    legs = zip(robot.drives, robot.distal, (gamma1, gamma2))
    return tuple(reach(drive, (x, y), bar, gamma).q for drive, bar, gamma in legs)


def igm_with_bases(left: float, right: float) -> Callable:
    """The inverse model with the bases moved by so many distances d."""

    def model(robot, x, y, *modes):
        return (
            igm(robot, x - left * robot.d, y, *modes)[0],
            igm(robot, x - right * robot.d, y, *modes)[1],
        )

    return model


def igm_by_root(
    robot: Robot,
    x: Array,
    y: Array,
    gamma1: Array,
    gamma2: Array,
    root: Callable = np.sqrt,
    half_way: bool = False,
) -> Columns:
    """AMORO eq. 7-9, by way of M, the foot of the elbow on the line from base joint to
    end-effector; or of its foot.
    """
    found = []
    for drive, bar, gamma in zip(robot.drives, robot.distal, (gamma1, gamma2)):
        if not robot.turns:
            found.append(y + gamma * root(bar**2 - (x - drive.x) ** 2))
            continue
        line = x + 1j * y - drive.x
        span = np.abs(line)
        along = span / 2 if half_way else (span**2 + drive.length**2 - bar**2) / (2 * span)
        found.append(np.angle((along + 1j * gamma * root(drive.length**2 - along**2)) * line))
    return tuple(found)


def wrong_igm(kind: Kind) -> tuple[Misconception, ...]:
    say = words_for(kind)
    return (
        Misconception(
            "other working modes",
            say(
                "Which elbow is on which side of the line from its base joint to the end-effector"
                " when gamma = -1?",
                "At home both working modes are -1. Is a foot below the end-effector there, or"
                " above it?",
            ),
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -gamma1, -gamma2),
        ),
        Misconception(
            "working modes swapped",
            "gamma1 belongs to the left leg. Change it alone: which of your "
            + say("angles changes?", "feet moves?"),
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, gamma2, gamma1),
        ),
        Misconception(
            "working modes never used",
            "Your answers do not change with gamma1 and gamma2. "
            f"A circle meets a {say('circle', 'line')} in how many points?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -1, -1),
        ),
        legs_exchanged(
            kind,
            igm,
            "Each leg has the other one's angle. Look at the order of the two, and at the signs of"
            " d / 2.",
        ),
        Misconception(
            say("base offset forgotten", "guides forgotten"),
            say(
                "From which point do you draw the vector to the end-effector, and where does the"
                " leg begin?",
                "From which point do you measure the end-effector's x, and where does the foot"
                " slide?",
            ),
            igm_with_bases(0.5, -0.5),
        ),
        Misconception(
            say("base offset subtracted twice", "d instead of d/2"),
            say(
                "Write down the x of A11 and of A21. Does each of them enter your vectors once?",
                "How far from the y axis is a guide? Both together make d.",
            ),
            igm_with_bases(-0.5, 0.5),
        ),
        Misconception(
            "root of an absolute value",
            "What does a negative number under the root say about the distance? abs() only"
            " hides it.",
            partial(igm_by_root, root=root_of_absolute),
        ),
        Misconception(
            say(
                "leg stretched towards what it cannot reach",
                "bar laid across towards a guide that it cannot reach",
            ),
            say(
                "Can the leg really end there? Measure its bars in the pose that you return.",
                "Can the bar really end there? Measure it in the pose that you return.",
            ),
            partial(igm_by_root, root=root_or_0),
        ),
    )
