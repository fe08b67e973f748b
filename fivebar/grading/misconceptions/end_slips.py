"""What goes wrong in the last steps: solving A xi' = B q' and A xi'' = B q'' + d, and the dynamic
model of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...models.robots import FiveBar, Robot
from ..columns import Array, Columns, inverse, times
from ..exercise import Misconception, Slip
from .geometry_steps import in_step
from .motion_steps import turned
from .right import Kind, dynamic_model, forward_dynamics, inverse_dynamics

SPEED = "At constant motor speed the end-effector still accelerates. Which torque does that need?"
STAR = "* multiplies arrays element by element. How does one write the product of two matrices?"
DKM_ENDS = in_step(
    "solve",
    ("A and B exchanged", "Solve A xi' = B q' for xi'.", lambda A, B: inverse(B) @ A),
    (
        "A not inverted",
        "A stands beside xi'. What brings it to the other side?",
        lambda A, B: A @ B,
    ),
    (
        "matrices in the wrong order",
        "Which of them must act on q' first?",
        lambda A, B: B @ inverse(A),
    ),
    ("elementwise product of A^-1 and B", STAR, lambda A, B: inverse(A) * B),
    ("B forgotten", "Solve A xi' = B q' for xi'.", lambda A, B: inverse(A)),
    ("A forgotten", "Solve A xi' = B q' for xi'.", lambda A, B: B + 0 * A),
    ("the other sign", "Solve A xi' = B q' for xi'.", lambda A, B: -inverse(A) @ B),
)
IKM_ENDS = in_step(
    "solve",
    ("A and B exchanged", "Solve A xi' = B q' for q'.", lambda A, B: inverse(A) @ B),
    ("B not inverted", "B stands beside q'. What brings it to the other side?", lambda A, B: B @ A),
    (
        "matrices in the wrong order",
        "Which of them must act on xi' first?",
        lambda A, B: A @ inverse(B),
    ),
    ("A forgotten", "Solve A xi' = B q' for q'.", lambda A, B: inverse(B)),
    ("B forgotten", "Solve A xi' = B q' for q'.", lambda A, B: A),
)


SOLVE_DKM2 = "A xi'' = B q'' + d: solve it for xi''."
SOLVE_IKM2 = "A xi'' = B q'' + d: solve it for q''."
DKM2_ENDS = in_step(
    "finish",
    ("d not multiplied by the inverse of A", SOLVE_DKM2, lambda A, B, d, q: inverse(A) @ B @ q + d),
    ("A not inverted", SOLVE_DKM2, lambda A, B, d, q: A @ (B @ q + d)),
    ("A forgotten", SOLVE_DKM2, lambda A, B, d, q: B @ q + d),
    ("A and B exchanged", SOLVE_DKM2, lambda A, B, d, q: inverse(B) @ (A @ q + d)),
    (
        "the inverse model in place of the direct one",
        SOLVE_DKM2,
        lambda A, B, d, q: inverse(B) @ (A @ q - d),
    ),
    ("B forgotten", SOLVE_DKM2, lambda A, B, d, q: inverse(A) @ (q + d)),
    ("B q'' forgotten: only d", SOLVE_DKM2, lambda A, B, d, q: inverse(A) @ d),
    (
        "elementwise product of A^-1 and B",
        STAR,
        lambda A, B, d, q: (inverse(A) * B) @ q + inverse(A) @ d,
    ),
    (
        "matrices in the wrong order",
        SOLVE_DKM2,
        lambda A, B, d, q: B @ inverse(A) @ q + inverse(A) @ d,
    ),
)
IKM2_ENDS = in_step(
    "finish",
    ("d not divided by B", SOLVE_IKM2, lambda A, B, d, x: inverse(B) @ A @ x - d),
    ("B not inverted", SOLVE_IKM2, lambda A, B, d, x: B @ (A @ x - d)),
    ("B forgotten", SOLVE_IKM2, lambda A, B, d, x: A @ x - d),
    ("A and B exchanged", SOLVE_IKM2, lambda A, B, d, x: inverse(A) @ (B @ x - d)),
    (
        "the direct model in place of the inverse one",
        SOLVE_IKM2,
        lambda A, B, d, x: inverse(A) @ (B @ x + d),
    ),
    ("A forgotten", SOLVE_IKM2, lambda A, B, d, x: inverse(B) @ (x - d)),
)


def dynamic_slips(kind: Kind) -> tuple[Slip, ...]:
    jacobian = "J gives the end-effector's velocity from that of the drives. Solve A xi' = B q'."
    energy = "xi' = J q'. Write the kinetic energy with q'."
    power = "m (A^-1 d) is a force. Which efforts is it worth?"
    inertias = " and ".join(kind.words.inertias)
    Js = (
        ("J = B^-1 A", lambda A, B: inverse(B) @ A),
        ("J = A^-1", lambda A, B: inverse(A)),
        ("elementwise product of A^-1 and B in J", lambda A, B: inverse(A) * B),
        ("J transposed", lambda A, B: turned(inverse(A) @ B)),
    )
    Ms = (
        (f"{inertias} forgotten in M", lambda Z, m, J: m * turned(J) @ J),
        ("mass forgotten in M", lambda Z, m, J: Z + turned(J) @ J),
        ("only the inertias in M", lambda Z, m, J: Z + 0 * J),
        ("J J^T instead of J^T J in M", lambda Z, m, J: Z + m * J @ turned(J)),
        ("J in place of J^T J in M", lambda Z, m, J: Z + m * J),
        ("only the diagonal of M", lambda Z, m, J: (Z + m * turned(J) @ J) * np.eye(2)),
        (f"{inertias} in all four elements of M", lambda Z, m, J: Z.sum(0) + m * turned(J) @ J),
    )
    cs = (
        ("c of the wrong sign", lambda m, J, A, B, d, M: -m * turned(J) @ inverse(A) @ d),
        ("c without J^T A^-1", lambda m, J, A, B, d, M: m * d),
        ("c without A^-1", lambda m, J, A, B, d, M: m * turned(J) @ d),
        ("c without J^T", lambda m, J, A, B, d, M: m * inverse(A) @ d),
        ("c with J instead of its transpose", lambda m, J, A, B, d, M: m * J @ inverse(A) @ d),
        ("mass forgotten in c", lambda m, J, A, B, d, M: turned(J) @ inverse(A) @ d),
        ("c with J^T m J d", lambda m, J, A, B, d, M: m * turned(J) @ J @ d),
        ("c with J^T M J d", lambda m, J, A, B, d, M: turned(J) @ M @ J @ d),
    )
    own = "An inertia belongs to one drive. Which element of M is that?"
    Zs = [
        ("one inertia for both legs", lambda robot: robot.inertias[0] * np.eye(2)),
        ("both inertias on each drive", lambda robot: sum(robot.inertias) * np.eye(2)),
        ("both inertias added in all of M", lambda robot: sum(robot.inertias) * np.ones((2, 2))),
    ]
    masses: list[tuple[str, Callable]] = [
        ("end-effector's mass halved", lambda robot: replace(robot, m=robot.m / 2))
    ]
    if not kind.turns:
        masses += [
            (
                "masses of feet and end-effector exchanged",
                lambda robot: replace(robot, mf1=robot.m, mf2=robot.m, m=robot.mf1),
            ),
            (
                "feet's masses moved with the end-effector",
                lambda robot: replace(robot, mf1=0, mf2=0, m=robot.m + robot.mf1 + robot.mf2),
            ),
        ]
    which = "Which mass moves with which part?"

    def named(key, hint, cases):
        slips = []
        for name, wrong in cases:
            text = STAR if name.startswith("elementwise") else hint
            slips.append(Slip(name, text, {key: wrong}))
        return slips

    return (
        *named("Z", own, Zs),
        *named("robot_of", which, masses),
        *named("J", jacobian, Js),
        *named("M", energy, Ms),
        Slip("c forgotten", SPEED, {"c": lambda m, J, A, B, d, M: 0 * d}),
        *named("c", power, cs),
    )


def misused(name: str, hint: str, use: Callable) -> Misconception:
    """Return the misconception of who makes use(M, c, given) of a right M and c (2, n)."""

    def model(robot: Robot, *row: Array) -> Columns:
        M, c = dynamic_model(robot, *row[:8])
        given = np.stack(row[8:])
        return tuple(use(M, c.T, given))

    return Misconception(name, hint, model)


def misread(model: Callable) -> Misconception:
    """Return the misconception of who takes q12 and q22 for the directions of the distal bars."""

    def wrong(robot: Robot, q11: Array, q12: Array, q21: Array, q22: Array, *row: Array) -> Columns:
        passive_left = q12 - q11
        passive_right = q22 - q21
        return model(robot, q11, passive_left, q21, passive_right, *row)

    hint = "Which angle does the distal bar make with the x axis?"
    return Misconception("passive angles taken as absolute", hint, wrong)


DIAGONAL = "Does the left motor feel nothing of the right one's acceleration?"
SOLVE = "Solve tau = M q'' + c for q''."


def locked(
    robot: FiveBar, q11: Array, q12: Array, q21: Array, q22: Array, *rates: Array
) -> Columns:
    """Return the velocity of who moves the left leg as one rigid piece."""
    phi = q11 + q12
    x = robot.l11 * np.cos(q11) + robot.l12 * np.cos(phi)
    y = robot.l11 * np.sin(q11) + robot.l12 * np.sin(phi)
    return -rates[0] * y, rates[0] * x


LOCKED = Misconception(
    "passive joints taken as locked",
    "You move the left leg as one rigid piece. Do the passive joints stand still?",
    locked,
)
MISUSED = {
    "inverse_dynamics": (
        misread(inverse_dynamics),
        misused("c forgotten", SPEED, lambda M, c, q: times(M, *q)),
        misused("c subtracted", "tau = M q'' + c.", lambda M, c, q: times(M, *q) - c),
        misused("c multiplied by M", "tau = M q'' + c.", lambda M, c, q: times(M, *(q + c))),
        misused("only the diagonal of M", DIAGONAL, lambda M, c, q: times(M * np.eye(2), *q) + c),
    ),
    "forward_dynamics": (
        misread(forward_dynamics),
        misused("c forgotten", SPEED, lambda M, c, tau: times(inverse(M), *tau)),
        misused("c added", SOLVE, lambda M, c, tau: times(inverse(M), *(tau + c))),
        misused(
            "only the diagonal of M",
            DIAGONAL,
            lambda M, c, tau: (tau - c) / np.diagonal(M, axis1=1, axis2=2).T,
        ),
        misused(
            "M not inverted",
            "A larger inertia must accelerate less.",
            lambda M, c, tau: times(M, *(tau - c)),
        ),
    ),
}
