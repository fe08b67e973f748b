"""The inverse model and the passive angles step by step, leg by leg, and what goes wrong in a
step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...models.robots import Robot
from ..columns import Array, Columns
from ..exercise import Slip
from .geometry_steps import (
    AHEAD,
    PIVOT,
    SQUARES,
    TURNS,
    base_x,
    bases_moved,
    each_leg,
    feet_of,
    height,
    in_step,
    lengths_changed,
    proximal,
    right,
    steps_of_leg,
)
from .right import Kind, dgm


def leg_foot(robot: Robot, leg: int, line: Array) -> Array:
    """Return distance of M, the foot of the elbow's height, from the base joint."""
    near = robot.drives[leg].length
    far = robot.distal[leg]
    size = np.abs(line)
    return (size**2 + near**2 - far**2) / (2 * size)


def own_mode(leg: int, gamma1: Array, gamma2: Array) -> Array:
    return (gamma1, gamma2)[leg]


IGM = {
    "base": base_x,
    "foot": leg_foot,
    "ahead": lambda half, a, e: (half, half / a),
    "height": height,
    "sign": own_mode,
    "elbow": lambda m, up, robot, leg: m + up,
    "read": np.angle,
}


def igm_steps(
    robot: Robot,
    x: Array,
    y: Array,
    gamma1: Array,
    gamma2: Array,
    robot_of: Callable = right,
    scale: Callable = right,
    turn: Callable = lambda e: 1j * e,
    to_m: Callable = right,
    lift: Callable = right,
    **leg_steps: Any,
) -> Columns:
    """AMORO eq. 7 to 9: by way of M, then up or down to the elbow; a foot is straight above or
    below.
    """
    robot = robot_of(robot)
    found = []
    for leg in range(2):
        step = steps_of_leg(IGM, leg_steps, leg)
        line = x - step.base(robot, leg) + 1j * y
        mode = step.sign(leg, gamma1, gamma2)
        if not robot.turns:
            rise = step.height(robot.distal[leg], line.real)
            found.append(lift(y) + mode * rise)
            continue
        size = np.abs(line)
        a = step.foot(robot, leg, line)
        middle = leg_foot(robot, leg, line) * line / size
        half, direction = step.ahead(middle, a, line / size)
        height_of_elbow = step.height(robot.drives[leg].length, a)
        rise = scale(height_of_elbow, a, size)
        up = mode * rise * turn(direction)
        elbow = step.elbow(to_m(half, line), up, robot, leg)
        found.append(step.read(elbow))
    return tuple(found)


# (name, hint, reading) of what becomes of the angle of a vector.
READINGS = (
    (
        "atan for atan2",
        "Some of your angles are off by half a turn. What does y / x forget?",
        lambda z: np.arctan(z.imag / z.real),
    ),
    (
        "atan2 with x before y",
        "atan2 of a point on the x axis is 0. Try yours on (1, 0).",
        lambda z: np.pi / 2 - np.angle(z),
    ),
    (
        "as for the other sign of x",
        "Which way does your vector point?",
        lambda z: np.angle(-z.conj()),
    ),
)


def _read_slips():
    for name, hint, reading in READINGS:
        yield from each_leg(name, hint, read=reading)


def igm_slips(kind: Kind) -> tuple[Slip, ...]:
    gamma = (
        "gamma1 belongs to the left leg, gamma2 to the right one. Change one alone: what changes?"
    )
    slips = [*bases_moved(kind), *lengths_changed(kind)]
    for name, hint, root in SQUARES:
        slips += each_leg(name, hint, height=root)
    slips += [
        Slip(
            "the left leg's mode, gamma1, used for both legs",
            gamma,
            {"sign": lambda leg, g1, g2: g1},
        ),
        Slip("working modes swapped", gamma, {"sign": lambda leg, g1, g2: (g2, g1)[leg]}),
        *each_leg(
            "other working mode",
            "On which side of the line is the elbow when gamma = -1?",
            sign=lambda leg, g1, g2: -own_mode(leg, g1, g2),
        ),
        *each_leg("working mode always -1", gamma, sign=lambda leg, g1, g2: -1 + 0 * g1),
    ]
    if not kind.turns:
        up = "Lift the robot by 0.1 m: how do the feet move, and what do your answers do?"
        return (
            *slips,
            Slip("height of the end-effector forgotten", up, {"lift": lambda y: 0 * y}),
            Slip("height of the end-effector with the wrong sign", up, {"lift": lambda y: -y}),
        )
    for name, hint, find in feet_of("M"):
        for ahead in AHEAD:
            slips += each_leg(name, hint, foot=find, **ahead)
    slips += in_step("turn", *TURNS)
    length = "A direction times b has length b only if the direction has length 1."
    once = (
        "A11A12 begins in A11 already. What is the angle of that vector, and what do you put into"
        " atan2?"
    )
    slips += [
        Slip("direction not of unit length", length, {"scale": lambda b, c, size: b * c}),
        Slip("direction not of unit length", length, {"scale": lambda b, c, size: b * size}),
    ]
    slips += each_leg(
        "M forgotten in the sum",
        "The way to the elbow leads over M.",
        elbow=lambda m, up, robot, leg: up,
    )
    slips += each_leg(
        "squares of the bars exchanged in the law of cosines",
        "Write down the law of cosines: which side is opposite to the angle that you look for?",
        foot=lambda robot, leg, line: np.abs(line) - leg_foot(robot, leg, line),
        **AHEAD[2],
    )
    slips += each_leg(
        "base offset counted again in the elbow (subtracted once more)",
        once,
        elbow=lambda m, up, robot, leg: m + up - base_x(robot, leg),
    )
    slips += [
        Slip(
            "direction of the end-effector instead of the elbow",
            "Your angle points from the base joint to the end-effector. Which bar does the motor"
            " turn?",
            {"to_m": lambda m, line: line, "elbow": lambda m, up, robot, leg: m},
        ),
        *_read_slips(),
    ]
    return tuple(slips)


PASSIVE = {
    **PIVOT,
    "read": np.angle,
    "off": lambda robot, angle, q, other: angle - q if robot.turns else angle,
}


def passive_steps(
    robot: Robot,
    q11: Array,
    q21: Array,
    mode: Array,
    robot_of: Callable = right,
    sign: Callable = right,
    **leg_steps: Any,
) -> Columns:
    """AMORO eq. 5 and 6."""
    robot = robot_of(robot)
    x, y = dgm(robot, q11, q21, sign(mode))
    angles = []
    active = (q11, q21)
    for leg, q in enumerate(active):
        other = active[1 - leg]
        step = steps_of_leg(PASSIVE, leg_steps, leg)
        pivot = step.base(robot, leg) + step.bars(robot, leg, q)
        bar = x + 1j * y - pivot
        angle = step.read(bar)
        angles.append(step.off(robot, angle, q, other))
    return tuple(angles)


def passive_slips(kind: Kind) -> tuple[Slip, ...]:
    ends = "From which end to which do you read the bar? At home both bars point up."
    slips = [*bases_moved(kind), *lengths_changed(kind)]
    slips += [
        Slip(
            "other assembly mode",
            "Does your dgm get the assembly mode as it came?",
            {"sign": lambda mode: -mode},
        ),
        Slip(
            "assembly mode never used",
            "Does your dgm get the assembly mode?",
            {"sign": lambda mode: -1 + 0 * mode},
        ),
        Slip(
            "assembly mode always +1",
            "Does your dgm get the assembly mode?",
            {"sign": lambda mode: 1 + 0 * mode},
        ),
        *each_leg("bar read from its end to its beginning", ends, read=lambda z: np.angle(-z)),
        *_read_slips(),
    ]
    if not kind.turns:
        hint = "A foot slides and does not turn. From which direction is its bar's angle measured?"
        slips += each_leg(
            "passive angle relative instead of absolute",
            hint,
            off=lambda robot, angle, q, other: angle - q,
        )
        return tuple(slips)
    turn = "The distal bar's direction is q11 + q12. Solve that for q12."
    slips += [
        *each_leg(
            "passive angle absolute instead of relative",
            turn,
            off=lambda robot, angle, q, other: angle,
        ),
        *each_leg(
            "active angle added instead of subtracted",
            turn,
            off=lambda robot, angle, q, other: angle + q,
        ),
        *each_leg(
            "sense of rotation reversed",
            "All angles grow counter-clockwise.",
            off=lambda robot, angle, q, other: q - angle,
        ),
        *each_leg(
            "sine and cosine exchanged in the proximal bar",
            "The bar at angle 0 points along x.",
            bars=lambda robot, leg, q: 1j * proximal(robot, leg, q).conj(),
        ),
        *each_leg(
            "length of the proximal bar forgotten",
            "You subtract a number without unit from a length in metres.",
            bars=lambda robot, leg, q: np.exp(1j * q),
        ),
    ]
    return tuple(slips)
