"""Lab 5: tau = M q'' + c and both of its uses, right and wrong."""

import numpy as np

from fivebar import FiveBar
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import inverse, motion, times
from fivebar.grading.misconceptions.common import c_forgotten, passive_misread
from fivebar.grading.misconceptions.dynamics import (
    M_of,
    c_of,
    dynamic_model,
    turned,
    with_model,
    wrong_dynamic_model,
)
from fivebar.grading.misconceptions.stepwise import stepwise

ONLY_DIAGONAL = (
    "only the diagonal of M",
    "Does the left motor feel nothing of the right one's acceleration?",
)

DYNAMIC_MODEL = Exercise(
    "dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D) -> M, c",
    dynamic_model,
    (
        *wrong_dynamic_model(FiveBar),
        with_model(
            *ONLY_DIAGONAL,
            lambda *all_: (M_of(*all_) * np.eye(2), c_of(*all_)),
        ),
        with_model(
            "c with J instead of its transpose",
            "J brings motor rates to the end-effector. What brings a force there back to the motors?",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * inverse(A) @ B @ inverse(A) @ d),
        ),
        with_model(
            "mass forgotten in c",
            "c is in N m, J^T A^-1 d is in m²/s². What is missing?",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), c_of(Z, 1.0, A, B, d)),
        ),
        Misconception(
            "q12' where q11' + q12' belongs",
            "How fast does the distal bar turn against the fixed frame? Check your d with lab 3.",
            lambda robot, *row: dynamic_model(
                robot, *row[:5], row[5] - row[4], row[6], row[7] - row[6]
            ),
        ),
        with_model(
            "c with J^T M J d",
            "J acts on joint rates, d is an acceleration along the bars.",
            lambda Z, m, A, B, d: (
                M_of(Z, m, A, B, d),
                m * turned(inverse(A) @ B) @ (inverse(A) @ B) @ d,
            ),
        ),
    ),
    shapes={"M": (2, 2), "c": (2,)},
)


def by_model(use):
    """The model that makes use(M, c, given) of M (n, 2, 2) and of c and the two columns given, each (2, n)."""

    def model(robot, *row):
        M, c = dynamic_model(robot, *row[:8])
        return tuple(use(M, c.T, np.stack(row[8:])))

    return model


def with_use(name, hint, use):
    return Misconception(name, hint, by_model(use))


inverse_dynamics = by_model(lambda M, c, q_ddot: times(M, *q_ddot) + c)
forward_dynamics = by_model(lambda M, c, tau: times(inverse(M), *(tau - c)))


def J_for_its_transpose(robot, *row):
    """tau = Z q'' + J m xi''."""
    rates = motion(robot, *row[:8])
    to_task = inverse(rates.pose.A)
    J = to_task @ rates.pose.B
    acceleration = np.add(times(J, *row[8:]), times(to_task, *rates.d.T))
    return tuple(
        np.add(
            times(np.diag(robot.inertias), *row[8:]), robot.m * np.array(times(J, *acceleration))
        )
    )


INVERSE = Exercise(
    "inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD) -> tau1, tau2",
    inverse_dynamics,
    (
        passive_misread(FiveBar, inverse_dynamics),
        c_forgotten(FiveBar, by_model(lambda M, c, q_ddot: times(M, *q_ddot))),
        with_use("c subtracted", "tau = M q'' + c.", lambda M, c, q_ddot: times(M, *q_ddot) - c),
        with_use(*ONLY_DIAGONAL, lambda M, c, q_ddot: times(M * np.eye(2), *q_ddot) + c),
        Misconception(
            "J instead of its transpose",
            "Virtual power: q'^T tau = xi'^T f. Insert xi' = J q'.",
            J_for_its_transpose,
        ),
    ),
)

FORWARD = Exercise(
    "forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2) -> q11DD, q21DD",
    forward_dynamics,
    (
        passive_misread(FiveBar, forward_dynamics),
        with_use(
            "c forgotten",
            "Without torque and in motion: does your robot really keep its motor speeds?",
            lambda M, c, tau: times(inverse(M), *tau),
        ),
        with_use(
            "c added",
            "Solve tau = M q'' + c for q''.",
            lambda M, c, tau: times(inverse(M), *(tau + c)),
        ),
        with_use(*ONLY_DIAGONAL, lambda M, c, tau: (tau - c) / np.diagonal(M, axis1=1, axis2=2).T),
        with_use(
            "M not inverted",
            "A larger inertia must accelerate less. Does yours?",
            lambda M, c, tau: times(M, *(tau - c)),
        ),
    ),
)

EXERCISES = stepwise(FiveBar, DYNAMIC_MODEL, INVERSE, FORWARD)
USES = dict.fromkeys(("inverse_dynamics", "forward_dynamics"), ("dynamic_model",))
