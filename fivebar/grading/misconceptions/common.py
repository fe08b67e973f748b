"""What the catalogues share: words for cranks or sliders, and mistakes that can be made in more
than one function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...models.robots import Biglide, FiveBar, Robot
from ..columns import Array
from ..exercise import Misconception

Kind = type[FiveBar] | type[Biglide]


def words_for(kind: Kind) -> Callable[[str, str], str]:
    """Gives of each two texts, for cranks and for sliders, the one for this kind of robot."""
    return lambda cranks, sliders: cranks if kind.turns else sliders


def root_of_absolute(square: Array) -> Array:
    return np.sqrt(np.abs(square))


def root_or_0(square: Array) -> Array:
    return np.sqrt(np.maximum(square, 0))


def one_length(robot: Robot) -> Robot:
    """The robot with all its bars as long as the first."""
    bars = [name for name in vars(robot) if name[0] == "l"]
    return replace(robot, **dict.fromkeys(bars, getattr(robot, bars[0])))


def with_one_length(kind: Kind, model: Callable, hint: str = "") -> Misconception:
    """hint: where it is another than the usual one."""
    say = words_for(kind)
    usual = say(
        "This robot has bars of four lengths. Which of your l is which?",
        "This robot has two bars of different lengths. Which of them stands where?",
    )
    name = f"one length for {say('all', 'both')} bars"
    return Misconception(name, hint or usual, lambda robot, *row: model(one_length(robot), *row))


def legs_exchanged(kind: Kind, model: Callable, hint: str = "") -> Misconception:
    """hint: for cranks; that for sliders is always the same."""
    sliding = (
        "The left leg comes first, in the arguments and in what you return. Move one foot alone:"
        " what changes?"
    )
    return Misconception(
        "legs exchanged",
        words_for(kind)(hint, sliding),
        lambda robot, *row: model(robot, *row)[::-1],
    )


def passive_misread(kind: Kind, model: Callable) -> Misconception:
    """Who reads q12 and q22 as the distal bars' directions, or, of a biglide, adds the feet's
    coordinates to them.
    """
    say, sign = words_for(kind), -1 if kind.turns else 1
    return Misconception(
        f"passive angles taken as {say('absolute', 'relative')}",
        say(
            "Which angle does the distal bar make with the x axis? q12 alone is measured from the"
            " proximal bar.",
            "q11 is in metres here, q12 in radians. Which angle does the bar make with the x axis?",
        ),
        lambda robot, q11, q12, q21, q22, *row: model(
            robot, q11, q12 + sign * q11, q21, q22 + sign * q21, *row
        ),
    )


def of_bars(model: Callable, change: Callable) -> Callable:
    """A wrong model of the passive joints' rates or accelerations: the bars' own are change(value,
    bar) of the right.

    The row is that of dkm_passive, or that of dkm2_passive.
    """

    def wrong(robot, *row):
        own = row[4:6] if len(row) == 8 else row[8:10]
        legs = zip(robot.drives, robot.distal, model(robot, *row), own)
        return tuple(
            drive.relative(change(drive.absolute(value, q), bar), q)
            for drive, bar, value, q in legs
        )

    return wrong


def length_forgotten(kind: Kind, model: Callable, hint: str) -> Misconception:
    name = f"length of the {words_for(kind)('distal bar', 'bar')} forgotten"
    return Misconception(name, hint, of_bars(model, lambda value, bar: value * bar))


def c_forgotten(kind: Kind, model: Callable) -> Misconception:
    speed, effort = (
        words_for(kind)("motor speed", "speed of the feet"),
        words_for(kind)("torque", "effort"),
    )
    hint = f"At constant {speed} the end-effector still accelerates. Which {effort} does that need?"
    return Misconception("c forgotten", hint, model)
