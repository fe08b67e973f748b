"""A xi'' = B q'' + d and what is made of it, step by step, for cranks and for sliders."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial, wraps
from typing import Any

import numpy as np

from ...models.robots import Robot
from ..columns import QUARTER, Array, Columns, inverse, times


def of_legs(derivation: Callable) -> Callable:
    """Let a step of a derivation be a pair of steps, one for each leg, None for the right one.

    A step gives (n, 2), or (n, 2, 2) with the leg second.
    """
    defaults = {name: p.default for name, p in inspect.signature(derivation).parameters.items()}

    @wraps(derivation)
    def with_pairs(*row, **steps):
        for key, step in steps.items():
            if isinstance(step, tuple):
                steps[key] = _joined(*(own or defaults[key] for own in step))
        return derivation(*row, **steps)

    return with_pairs


def _joined(left, right):
    """Return a step that is one step in the left leg and another one in the right leg."""

    def step(*arguments):
        of_left, of_right = (np.asarray(own(*arguments)) for own in (left, right))
        is_left = np.array([True, False])
        return np.where(is_left if of_left.ndim < 3 else is_left[:, None], of_left, of_right)

    return step


class Joints:
    """u of both bars of both legs, (n, 2, 2) with the leg second; bars' lengths (2,); for sliders
    u11 is along y.
    """

    def __init__(self, robot: Robot, q11: Array, q12: Array, q21: Array, q22: Array):
        self.robot = robot
        self.q = np.stack([q11, q21], -1)
        self.passive = np.stack([q12, q22], -1)
        self.turns = robot.turns
        self.distal = np.array(robot.distal)
        if robot.turns:
            self.phi = self.q + self.passive
            self.proximal = np.array([drive.length for drive in robot.drives])
            self.u1 = unit(self.q)
        else:
            self.phi = self.passive
            self.proximal = np.ones(2)
            self.u1 = np.broadcast_to([1.0, 0.0], (*self.q.shape, 2))  # so v1 is along y
        self.u2 = unit(self.phi)

    @property
    def v1(self) -> Array:
        return self.u1 @ QUARTER.T

    @property
    def v2(self) -> Array:
        return self.u2 @ QUARTER.T


def unit(angle: Array) -> Array:
    x = np.cos(angle)
    y = np.sin(angle)
    return np.stack([x, y], -1)


def dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def same(thing: object, *_: object) -> object:
    return thing


def diagonal(b: Array) -> Array:
    return b[..., None] * np.eye(2)


def distal_directions(j: Joints) -> Array:
    return j.u2


def crank_projection(j: Joints) -> Array:
    cosine = dot(j.u2, j.v1)
    return j.proximal * cosine


def diagonal_B(b: Array, j: Joints) -> Array:
    return diagonal(b)


@of_legs
def parts_of(
    robot: Robot,
    *q: Array,
    angles: Callable = same,
    A: Callable = distal_directions,
    B: Callable = diagonal_B,
    b: Callable = crank_projection,
    of_A: Callable = same,
) -> tuple[Array, Array, Joints]:
    """Return A, B and the Joints."""
    joints = Joints(robot, *angles(q))
    matrix_A = of_A(A(joints))
    matrix_B = B(b(joints), joints)
    return matrix_A, matrix_B, joints


def rest_of(steps: dict) -> tuple[dict, dict]:
    """Steps of A and B, and all others."""
    names = ("angles", "A", "B", "b", "of_A")
    mine = {}
    others = {}
    for key, step in steps.items():
        if key in names:
            mine[key] = step
        else:
            others[key] = step
    return mine, others


def distal_rate(own: Array, passive: Array, turns: bool) -> Array:
    if turns:
        return own + passive
    return passive


def proximal_term(j: Joints, rate: Array) -> Array | float:
    """Return the centripetal acceleration of the elbow along the distal bar."""
    if not j.turns:
        return 0.0
    cosine = dot(j.u2, j.u1)
    return j.proximal * rate**2 * cosine


def squared_rate(rate: Array, own: Array, passive: Array) -> Array:
    return rate**2


def distal_term(j: Joints, square: Array) -> Array:
    return j.distal * square


def minus_both(near: Array, far: Array) -> Array:
    return -near - far


@of_legs
def bias(
    j: Joints,
    rates: Columns,
    turning: Callable = distal_rate,
    near: Callable = proximal_term,
    square: Callable = squared_rate,
    far: Callable = distal_term,
    of_d: Callable = minus_both,
) -> Array:
    """Return d, (n, 2)."""
    own = np.stack(rates[0::2], -1)
    passive = np.stack(rates[1::2], -1)
    rate = turning(own, passive, j.turns)
    squared = square(rate, own, passive)
    of_proximal = near(j, own)
    of_distal = far(j, squared)
    return of_d(of_proximal, of_distal)


def A_steps(robot: Robot, *q: Array, **steps: Any) -> Array:
    A, _, _ = parts_of(robot, *q, **steps)
    return A


def B_steps(robot: Robot, *q: Array, **steps: Any) -> Array:
    _, B, _ = parts_of(robot, *q, **steps)
    return B


def first_order(robot: Robot, *row: Array, solve: Callable, **steps: Any) -> Columns:
    A, B, _ = parts_of(robot, *row[:4], **steps)
    J = solve(A, B)
    return times(J, *row[4:])


dkm_steps = partial(first_order, solve=lambda A, B: inverse(A) @ B)
ikm_steps = partial(first_order, solve=lambda A, B: inverse(B) @ A)


def last_columns(row: Columns) -> Columns:
    return row[8:]


def second_order(
    robot: Robot,
    *row: Array,
    finish: Callable,
    given: Callable = last_columns,
    robot_of: Callable = same,
    **steps: Any,
) -> Columns:
    robot = robot_of(robot)
    mine, others = rest_of(steps)
    A, B, j = parts_of(robot, *row[:4], **mine)
    d = bias(j, row[4:8], **others)
    vector = np.stack(given(row), -1)
    solved = finish(A, B, d[..., None], vector[..., None])
    return tuple(solved[..., 0].T)


def solve_for_x(A: Array, B: Array, d: Array, q: Array) -> Array:
    right_side = B @ q + d
    return inverse(A) @ right_side


def solve_for_q(A: Array, B: Array, d: Array, x: Array) -> Array:
    left_side = A @ x - d
    return inverse(B) @ left_side


dkm2_steps = partial(second_order, finish=solve_for_x)
ikm2_steps = partial(second_order, finish=solve_for_q)


def turned(matrix: Array) -> Array:
    return matrix.swapaxes(-1, -2)


def jacobian_of(A: Array, B: Array) -> Array:
    return inverse(A) @ B


def inertia_matrix(Z: Array, m: float, J: Array) -> Array:
    of_end_effector = m * turned(J) @ J
    return Z + of_end_effector


def velocity_torques(m: float, J: Array, A: Array, B: Array, d: Array, M: Array) -> Array:
    return m * turned(J) @ inverse(A) @ d


def drive_inertias(robot: Any) -> Array:
    return np.diag(robot.inertias)


def dynamic_steps(
    robot: Robot,
    *row: Array,
    J: Callable = jacobian_of,
    M: Callable = inertia_matrix,
    c: Callable = velocity_torques,
    Z: Callable = drive_inertias,
    robot_of: Callable = same,
    **steps: Any,
) -> Columns:
    robot = robot_of(robot)
    mine, others = rest_of(steps)
    A, B, j = parts_of(robot, *row[:4], **mine)
    jacobian = J(A, B)
    d = bias(j, row[4:8], **others)[..., None]
    mass = M(Z(robot), robot.m, jacobian)
    mass = np.broadcast_to(mass, A.shape)
    torques = c(robot.m, jacobian, A, B, d, mass)
    return mass, torques[..., 0]


def distal_normal(j: Joints) -> Array:
    return j.v2


def elbow_velocity(j: Joints, v: Array) -> Array:
    cosine = dot(v, j.v1)
    return j.proximal * cosine


def elbow_centripetal(j: Joints, v: Array, own: Array, passive: Array) -> Array | float:
    if not j.turns:
        return 0.0
    return j.proximal * own**2 * dot(v, j.u1)


def turning_drive(q: Array, j: Joints) -> Array:
    if j.turns:
        return q
    return 0 * q


def per_distal_length(value: Array, j: Joints) -> Array:
    return value / j.distal


def relative_to_elbow(end: Array, drag: Array, j: Joints) -> Array:
    return end - drag


@of_legs
def passive_motion(
    robot: Robot,
    *row: Array,
    angles: Callable = same,
    v: Callable = distal_normal,
    drag: Callable = elbow_velocity,
    own: Callable = turning_drive,
    per: Callable = per_distal_length,
    take: Callable = relative_to_elbow,
    pull: Callable = elbow_centripetal,
) -> Columns:
    """Return the rates (AMORO eq. 14) or, of rows with rates before them, accelerations (eq. 19).

    l12 (q11' + q12') = v12 . (xi' - l11 q11' v11).
    """
    j = Joints(robot, *angles(row[:4]))
    rates = row[4:-4]
    q = np.stack(row[-4:-2], -1)
    x = np.stack(row[-2:], -1)[:, None]
    normal = v(j)
    of_end = dot(normal, x)
    of_elbow = drag(j, normal) * q
    along_normal = take(of_end, of_elbow, j)
    if rates:
        active = np.stack(rates[::2], -1)
        passive = np.stack(rates[1::2], -1)
        along_normal = along_normal + pull(j, normal, active, passive)
    distal = per(along_normal, j)
    relative = distal - own(q, j)
    return tuple(relative.T)
