"""A xi'' = B q'' + d and what is made of it, step by step, for cranks and for sliders."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from ...models.robots import Robot
from ..columns import QUARTER, Array, Columns, inverse, times
from ..exercise import Slip


class Joints:
    """u of both bars of both legs, (n, 2, 2) with the leg second; bars' lengths (2,); for sliders
    u11 is along y.
    """

    def __init__(self, robot: Robot, q11: Array, q12: Array, q21: Array, q22: Array):
        first, second = np.stack([q11, q21], -1), np.stack([q12, q22], -1)
        self.robot, self.q, self.passive, self.turns = robot, first, second, robot.turns
        self.phi = first + second if robot.turns else second
        self.distal = np.array(robot.distal)
        self.proximal = np.array([d.length for d in robot.drives]) if robot.turns else np.ones(2)
        self.u2 = unit(self.phi)
        self.u1 = (
            unit(first) if robot.turns else np.broadcast_to([1.0, 0.0], self.u2.shape)
        )  # v1 is then along y

    @property
    def v1(self) -> Array:
        return self.u1 @ QUARTER.T

    @property
    def v2(self) -> Array:
        return self.u2 @ QUARTER.T


def unit(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def same(thing: object, *_: object) -> object:
    return thing


def diagonal(b: Array) -> Array:
    return b[..., None] * np.eye(2)


def parts_of(
    robot: Robot,
    *q: Array,
    angles: Callable = same,
    A: Callable = lambda j: j.u2,
    B: Callable = lambda b, j: diagonal(b),
    b: Callable = lambda j: j.proximal * dot(j.u2, j.v1),
    of_A: Callable = same,
) -> tuple[Array, Array, Joints]:
    """Return A, B and the Joints."""
    joints = Joints(robot, *angles(q))
    return of_A(A(joints)), B(b(joints), joints), joints


def rest_of(steps: dict) -> tuple[dict, dict]:
    """Steps of A and B, and all others."""
    names = ("angles", "A", "B", "b", "of_A")
    mine = {key: steps[key] for key in names if key in steps}
    return mine, {key: value for key, value in steps.items() if key not in mine}


def bias(
    j: Joints,
    rates: Columns,
    turning: Callable = lambda own, passive, turns: own + passive if turns else passive,
    near: Callable = lambda j, rate: j.proximal * rate**2 * dot(j.u2, j.u1) if j.turns else 0.0,
    square: Callable = lambda rate, own, passive: rate**2,
    far: Callable = lambda j, square: j.distal * square,
    of_d: Callable = lambda near, far: -near - far,
) -> Array:
    """Return d, (n, 2)."""
    own, passive = np.stack(rates[0::2], -1), np.stack(rates[1::2], -1)
    squared = square(turning(own, passive, j.turns), own, passive)
    return of_d(near(j, own), far(j, squared))


def A_steps(robot: Robot, *q: Array, **steps: Any) -> Array:
    return parts_of(robot, *q, **steps)[0]


def B_steps(robot: Robot, *q: Array, **steps: Any) -> Array:
    return parts_of(robot, *q, **steps)[1]


def first_order(robot: Robot, *row: Array, solve: Callable, **steps: Any) -> Columns:
    A, B, _ = parts_of(robot, *row[:4], **steps)
    return times(solve(A, B), *row[4:])


dkm_steps = partial(first_order, solve=lambda A, B: inverse(A) @ B)
ikm_steps = partial(first_order, solve=lambda A, B: inverse(B) @ A)


def second_order(
    robot: Robot,
    *row: Array,
    finish: Callable,
    given: Callable = lambda row: row[8:],
    robot_of: Callable = same,
    **steps: Any,
) -> Columns:
    robot = robot_of(robot)
    mine, others = rest_of(steps)
    A, B, j = parts_of(robot, *row[:4], **mine)
    given = np.stack(given(row), -1)[..., None]
    return tuple(finish(A, B, bias(j, row[4:8], **others)[..., None], given)[..., 0].T)


dkm2_steps = partial(second_order, finish=lambda A, B, d, q: inverse(A) @ (B @ q + d))
ikm2_steps = partial(second_order, finish=lambda A, B, d, x: inverse(B) @ (A @ x - d))


def turned(matrix: Array) -> Array:
    return matrix.swapaxes(-1, -2)


def dynamic_steps(
    robot: Robot,
    *row: Array,
    J: Callable = lambda A, B: inverse(A) @ B,
    M: Callable = lambda Z, m, J: Z + m * turned(J) @ J,
    c: Callable = lambda m, J, A, B, d, M: m * turned(J) @ inverse(A) @ d,
    Z: Callable = lambda robot: np.diag(robot.inertias),
    robot_of: Callable = same,
    **steps: Any,
) -> Columns:
    robot = robot_of(robot)
    mine, others = rest_of(steps)
    A, B, j = parts_of(robot, *row[:4], **mine)
    jacobian, d = J(A, B), bias(j, row[4:8], **others)[..., None]
    mass = np.broadcast_to(M(Z(robot), robot.m, jacobian), A.shape)
    return mass, c(robot.m, jacobian, A, B, d, mass)[..., 0]


def passive_motion(
    robot: Robot,
    *row: Array,
    angles: Callable = same,
    v: Callable = lambda j: j.v2,
    drag: Callable = lambda j, v: j.proximal * dot(v, j.v1),
    own: Callable = lambda q, j: q if j.turns else 0 * q,
    per: Callable = lambda value, j: value / j.distal,
    take: Callable = lambda end, drag, j: end - drag,
    pull: Callable = lambda j, v, own, passive: (
        j.proximal * own**2 * dot(v, j.u1) if j.turns else 0.0
    ),
) -> Columns:
    """Return the rates (AMORO eq. 14) or, of rows with rates before them, accelerations (eq. 19).

    l12 (q11' + q12') = v12 . (xi' - l11 q11' v11).
    """
    j, rates = Joints(robot, *angles(row[:4])), row[4:-4]
    q, x = np.stack(row[-4:-2], -1), np.stack(row[-2:], -1)[:, None]
    end = take(dot(v(j), x), drag(j, v(j)) * q, j)
    if rates:
        end = end + pull(j, v(j), np.stack(rates[::2], -1), np.stack(rates[1::2], -1))
    return tuple((per(end, j) - own(q, j)).T)


def only(leg: int, wrong: Callable, usual: Callable) -> Callable:
    """Return a step that is wrong in one leg; it gives (n, 2), or (n, 2, 2) with the leg second."""

    def step(*arguments):
        bad, good = np.asarray(wrong(*arguments)), np.asarray(usual(*arguments))
        keep = np.arange(2) == leg
        return np.where(keep[:, None] if bad.ndim == 3 else keep, bad, good)

    return step


def per_leg(
    name: str, hint: str, key: str, wrong: Callable, usual: Callable, **beside: Callable
) -> tuple[Slip, ...]:
    """Return the slip in both legs, in the left one and in the right one; beside: more steps."""
    left, right = only(0, wrong, usual), only(1, wrong, usual)
    return (
        Slip(name, hint, {key: wrong} | beside),
        Slip(f"{name}, in the left leg", hint, {key: left} | beside),
        Slip(f"{name}, in the right leg", hint, {key: right} | beside),
    )


@cache
def usual(function: Callable, step: str) -> Callable:
    """Return the right step of a derivation."""
    return inspect.signature(function).parameters[step].default


def in_legs(function: Callable, *cases: tuple[str, str, str, Callable]) -> list[Slip]:
    """Return the slips of each case: its name, its hint, the step and the wrong step."""
    return [slip for case in cases for slip in per_leg(*case, usual(function, case[2]))]
