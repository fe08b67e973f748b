"""The geometric models step by step, and what goes wrong in a step. Points of the plane are complex
numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...models.robots import Robot
from ..columns import Array, Columns
from ..exercise import Slip
from .right import Kind


def steps_of_leg(right_steps: dict, steps: dict, leg: int) -> SimpleNamespace:
    """Return the steps of one leg; a pair of steps holds None where a leg's is right."""
    chosen = dict(right_steps)
    for key, step in steps.items():
        own = step[leg] if isinstance(step, tuple) else step
        if own:
            chosen[key] = own
    return SimpleNamespace(**chosen)


def each_leg(name: str, hint: str, **steps: Callable) -> tuple[Slip, ...]:
    """Return the slip in both legs, in the left one, in the right one."""
    left = {key: (value, None) for key, value in steps.items()}
    right = {key: (None, value) for key, value in steps.items()}
    return (
        Slip(name, hint, steps),
        Slip(f"{name}, in the left leg", hint, left),
        Slip(f"{name}, in the right leg", hint, right),
    )


def in_step(key: str, *cases: tuple[str, str, Callable]) -> tuple[Slip, ...]:
    """Return the slips of each case in one step: its name, its hint and the wrong step."""
    slips = []
    for name, hint, wrong in cases:
        slips.append(Slip(name, hint, {key: wrong}))
    return tuple(slips)


def right(thing: object, *_: object) -> object:
    return thing


def base_x(robot: Robot, leg: int) -> float:
    return robot.drives[leg].x


def proximal(robot: Robot, leg: int, q: Array) -> Array:
    """From the base to the pivot."""
    if not robot.turns:
        return 1j * q
    drive = robot.drives[leg]
    return drive.length * np.exp(1j * q)


PIVOT = {"base": base_x, "bars": proximal}


def foot(robot: Robot, leg: int, span: Array) -> Array:
    """Return distance of the height's foot from the pivot (dgm) in a triangle of this base."""
    near = robot.distal[leg]
    far = robot.distal[1 - leg]
    size = np.abs(span)
    return (size**2 + near**2 - far**2) / (2 * size)


# What is made of a wrong distance a from a pivot to the height's foot: AMORO's h/a times the right
# vector; h times the right direction; or another foot, too.
AHEAD: tuple[dict, ...] = (
    {},
    {"ahead": lambda half, a, e: (half, e)},
    {"ahead": lambda half, a, e: (a * e, e)},
)


def height(bar: float, along: Array) -> Array:
    return np.sqrt(bar**2 - along**2)


def pivots(robot: Robot, q11: Array, q21: Array, **pivot_steps: Any) -> list[Array]:
    """Return both elbows, or feet, as complex numbers."""
    points = []
    for leg, q in enumerate((q11, q21)):
        step = steps_of_leg(PIVOT, pivot_steps, leg)
        base = step.base(robot, leg)
        points.append(base + step.bars(robot, leg, q))
    return points


def dgm_steps(
    robot: Robot,
    q11: Array,
    q21: Array,
    mode: Array,
    robot_of: Callable = right,
    to_h: Callable = right,
    from_pivot: Callable = foot,
    ahead: Callable = lambda half, a, e: (half, half / a),
    height: Callable = height,
    scale: Callable = right,
    turn: Callable = lambda e: 1j * e,
    sign: Callable = right,
    end: Callable = lambda h, up: h + up,
    **pivot_steps: Any,
) -> Columns:
    """AMORO eq. 1 to 3: from A22 along the line of the pivots to H, and from there up."""
    robot = robot_of(robot)
    points = pivots(robot, q11, q21, **pivot_steps)
    left, right_pivot = points
    line = left - right_pivot
    size = np.abs(line)
    a = from_pivot(robot, 1, line)
    right_half = foot(robot, 1, line) * line / size
    half, direction = ahead(right_half, a, line / size)
    rise = scale(height(robot.distal[1], a), a, size)
    up = sign(mode) * rise * turn(direction)
    h = right_pivot + to_h(half, line)
    found = end(h, up)
    return found.real, found.imag


# (name, hint, root) of what becomes of sqrt(bar^2 - along^2).
SQUARES = (
    (
        "a factor 2 in place of the square in the root",
        "l**2 is the square of l. What is l*2?",
        lambda bar, along: np.sqrt(bar * 2 - along * 2),
    ),
    (
        "root of an absolute value",
        "What does a negative number under the root say? abs() only hides it.",
        lambda bar, along: np.sqrt(np.abs(bar**2 - along**2)),
    ),
    (
        "height 0 where the bars do not meet",
        "Can the bars really meet there? Measure them in the pose that you return.",
        lambda bar, along: np.sqrt(np.maximum(bar**2 - along**2, 0)),
    ),
)


def feet_of(word: str) -> tuple[tuple[str, str, Callable], ...]:
    """Return (name, hint, foot(robot, leg, line)) of what becomes of the distance from a pivot to
    the foot of the height.
    """
    pythagoras = "A distance in the plane has two components. What did Pythagoras say?"
    return (
        (
            f"distance of {word} taken along x only",
            pythagoras,
            lambda robot, leg, line: np.abs(line.real) / 2,
        ),
        (
            f"{word} not in the middle: the factor 1/2 forgotten in its distance",
            f"How far is {word} from either end?",
            lambda robot, leg, line: np.abs(line),
        ),
    )


TURNS = (
    (
        "rotation by 90 degrees forgotten",
        "Is your height perpendicular to the line that it stands on?",
        lambda e: e,
    ),
    (
        "rotation matrix without its minus sign",
        "Turn (1, 0) and (0, 1) by +90 degrees: where do they go?",
        lambda e: 1j * e.conj(),
    ),
    (
        "rotation matrix with two minus signs",
        "Turn (1, 0) and (0, 1) by +90 degrees: where do they go?",
        lambda e: -1j * e.conj(),
    ),
)


def lengths_changed(kind: Kind) -> tuple[Slip, ...]:
    """Of robots with bars of several lengths."""

    def like(name, hint, **names):
        def change(robot):
            changes = {new: getattr(robot, old) for new, old in names.items()}
            return replace(robot, **changes)

        return Slip(name, hint, {"robot_of": change})

    which = "This robot has bars of several lengths. Which of them is it here?"
    if not kind.turns:
        return (
            like("bars exchanged", which, l1="l2", l2="l1"),
            like("l1 for both bars", which, l2="l1"),
            like("l2 for both bars", which, l1="l2"),
        )
    return (
        like(
            "proximal and distal bars exchanged", which, l11="l12", l12="l11", l21="l22", l22="l21"
        ),
        like("distal bars exchanged", which, l12="l22", l22="l12"),
        like("l11 for l12 and l21 for l22", which, l12="l11", l22="l21"),
        *(
            like(f"{old} for {new}", which, **{new: old})
            for new in ("l11", "l12", "l21", "l22")
            for old in ("l11", "l12", "l21", "l22")
            if new != old
        ),
        like("one length for all bars", which, l12="l11", l21="l11", l22="l11"),
        like("one length for all bars", which, l11="l12", l21="l12", l22="l12"),
    )


def bases_moved(kind: Kind, key: str = "base") -> tuple[Slip, ...]:
    """Return wrong places of the bases, in both legs or in one."""
    word = kind.words.base
    where = f"Write down the x of both {word}s. Where is the origin of the frame?"

    def at(factor):
        return lambda robot, leg: factor * base_x(robot, leg)

    return (
        Slip(
            f"origin in the left {word}",
            where,
            {key: lambda robot, leg: base_x(robot, leg) + robot.d / 2},
        ),
        *each_leg(f"{word} forgotten", where, **{key: at(0)}),
        Slip(f"sign of the {word}'s x", where, {key: at(-1)}),
        Slip("the right arm's offset used for the left arm", where, {key: (at(-1), None)}),
        Slip("the left arm's offset used for the right arm", where, {key: (None, at(-1))}),
        *each_leg(
            "d instead of d/2",
            "Both bases together are d apart. How far is one of them from the middle?",
            **{key: at(2)},
        ),
    )


def dgm_slips(kind: Kind) -> tuple[Slip, ...]:
    word = kind.words.pivots
    slips = [
        Slip(
            "H forgotten in the sum",
            "The way leads over H: from A22 to H, from H to the end-effector.",
            {"to_h": lambda h, line: 0 * h},
        ),
        Slip(
            "stops at H",
            "How far is your point from either of the " + word + "?",
            {"end": lambda h, up: h},
        ),
        Slip(
            "height subtracted for the other assembly mode",
            "Which of the two points has assembly mode -1 at home?",
            {"end": lambda h, up: h - up},
        ),
        Slip(
            "assembly mode always +1",
            "Your answer does not change with assembly_mode.",
            {"sign": lambda mode: 1 + 0 * mode},
        ),
        Slip(
            "assembly mode never used",
            "Your answer does not change with assembly_mode.",
            {"sign": lambda mode: -1 + 0 * mode},
        ),
        Slip(
            "direction not of unit length",
            "A direction times h has length h only if the direction has length 1.",
            {"scale": lambda h, a, size: h * a},
        ),
        Slip(
            "direction not of unit length",
            "A direction times h has length h only if the direction has length 1.",
            {"scale": lambda h, a, size: h * size},
        ),
    ]
    middle = {"from_pivot": lambda robot, leg, line: np.abs(line) / 2, **AHEAD[2]}
    slips.append(
        Slip(
            "H taken in the middle, as with equal bars",
            "Which triangle has H in the middle?",
            middle,
        )
    )
    slips += [*bases_moved(kind), *lengths_changed(kind)]
    slips += [*in_step("turn", *TURNS), *in_step("height", *SQUARES)]
    for name, hint, find in feet_of("H"):
        for ahead in AHEAD:
            slips.append(Slip(name, hint, {"from_pivot": find, **ahead}))
    slips.append(
        Slip(
            "distance of H from the other pivot: the squares of the bars are exchanged",
            "Make l22 shorter in a drawing: does H come nearer to A22 or go away from it?",
            {
                "from_pivot": lambda robot, leg, line: np.abs(line) - foot(robot, leg, line),
                **AHEAD[2],
            },
        )
    )
    if kind.turns:
        swapped = "The bar at angle 0 points along x: what does yours?"
        slips += [
            *each_leg(
                "sine and cosine exchanged in the proximal bar",
                swapped,
                bars=lambda robot, leg, q: 1j * proximal(robot, leg, q).conj(),
            ),
            Slip(
                "angles taken as degrees",
                "What do sin and cos expect?",
                {"bars": lambda robot, leg, q: proximal(robot, leg, np.radians(q))},
            ),
        ]
    else:
        slips += each_leg(
            "feet slide the other way",
            "Which way does a foot move when its coordinate grows?",
            bars=lambda robot, leg, q: -1j * q,
        )[:1]
    return tuple(slips)
