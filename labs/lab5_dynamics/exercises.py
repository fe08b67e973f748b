"""Lab 5: tau = M q'' + c and both of its uses, right and wrong."""

from dataclasses import replace

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.four_joints import inverse, motion, passive_as_absolute, times


def parts(robot, *row):
    """Z (2, 2), m, A and B (n, 2, 2), d as columns (n, 2, 1)."""
    rates = motion(robot, *row)
    return np.diag(robot.inertias), robot.m, rates.pose.A, rates.pose.B, rates.d[..., None]


def turned(matrix):
    return matrix.swapaxes(-1, -2)


def dynamic_model(robot, *row):
    return fb.dynamic_model(motion(robot, *row))


def with_model(name, change, hint):
    """A wrong M and c: change(Z, m, A, B, d) -> M, c as a column."""

    def model(robot, *row):
        M, c = change(*parts(robot, *row))
        return np.broadcast_to(M, (len(row[0]), 2, 2)), c[..., 0]

    return Misconception(name, hint, model)


def M_of(Z, m, A, B, d):
    J = inverse(A) @ B
    return Z + m * turned(J) @ J


def c_of(Z, m, A, B, d):
    return m * turned(inverse(A) @ B) @ inverse(A) @ d


DYNAMIC_MODEL = Exercise(
    "dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D) -> M, c",
    dynamic_model,
    (
        passive_as_absolute(dynamic_model),
        with_model(
            "zz forgotten",
            lambda Z, *rest: (M_of(0 * Z, *rest), c_of(Z, *rest)),
            "Take the end-effector's mass away: does your robot still have inertia?",
        ),
        with_model(
            "mass forgotten in M",
            lambda Z, m, *rest: (Z, c_of(Z, m, *rest)),
            "Take the bars' inertia away: is there nothing left to accelerate?",
        ),
        with_model(
            "only the diagonal of M",
            lambda *all_: (M_of(*all_) * np.eye(2), c_of(*all_)),
            "Does the left motor feel nothing of the right one's acceleration?",
        ),
        with_model(
            "c forgotten",
            lambda *all_: (M_of(*all_), 0 * all_[-1]),
            "At constant motor speed the end-effector still accelerates. Which torque does that need?",
        ),
        with_model(
            "c of the wrong sign",
            lambda *all_: (M_of(*all_), -c_of(*all_)),
            "Insert xi'' = A^-1 (B q'' + d) once more, sign by sign.",
        ),
        with_model(
            "c without J^T A^-1",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * d),
            "d is not a torque. Which matrices bring an acceleration along the bars to the motors?",
        ),
        with_model(
            "c without A^-1",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * turned(inverse(A) @ B) @ d),
            "xi'' = A^-1 (B q'' + d): what stands before d?",
        ),
        with_model(
            "c without J^T",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * inverse(A) @ d),
            "m A^-1 d is a force on the end-effector. Which torques is it worth?",
        ),
        with_model(
            "c with J instead of its transpose",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * inverse(A) @ B @ inverse(A) @ d),
            "J brings motor rates to the end-effector. What brings a force there back to the motors?",
        ),
        with_model(
            "mass forgotten in c",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), c_of(Z, 1.0, A, B, d)),
            "c is in N m, J^T A^-1 d is in m^2/s^2. What is missing?",
        ),
        Misconception(
            "q12' where q11' + q12' belongs",
            "How fast does the distal bar turn against the fixed frame? Check your d with lab 3.",
            lambda robot, *row: dynamic_model(
                robot, *row[:4], row[4], row[5] - row[4], row[6], row[7] - row[6]
            ),
        ),
        with_model(
            "c with J^T M J d",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * turned(inverse(A) @ B) @ (inverse(A) @ B) @ d),
            "J acts on joint rates, d is an acceleration along the bars.",
        ),
        with_model(
            "J J^T instead of J^T J",
            lambda Z, m, A, B, d: (
                Z + m * (inverse(A) @ B) @ turned(inverse(A) @ B), c_of(Z, m, A, B, d)
            ),
            "xi' = J q'. Write the kinetic energy m |xi'|^2 / 2 with q'.",
        ),
        with_model(
            "J = B^-1 A",
            lambda Z, m, A, B, d: (
                Z + m * turned(inverse(B) @ A) @ (inverse(B) @ A), m * turned(inverse(B) @ A) @ inverse(A) @ d
            ),
            "J gives the end-effector's velocity from the motors'. Solve A xi' = B q' for the right one.",
        ),
        with_model(
            "mass halved",
            lambda Z, m, *rest: (M_of(Z, m / 2, *rest), c_of(Z, m / 2, *rest)),
            "The 1/2 of the kinetic energy meets the exponent when you differentiate.",
        ),
        Misconception(
            "one inertia for both legs",
            "zz1 and zz2 may differ. Where does each of them stand?",
            lambda robot, *row: dynamic_model(replace(robot, zz2=robot.zz1), *row),
        ),
    ),
    shapes={"M": (2, 2), "c": (2,)},
)  # fmt: skip


def apply(model, row):
    """M q'' + c with q'' the last two columns of the row."""
    M, c = model
    return tuple(tau + own for tau, own in zip(times(M, *row), c.T))


def inverse_dynamics(robot, *row):
    return apply(dynamic_model(robot, *row[:8]), row[8:])


def forward_dynamics(robot, *row, sign=-1):
    M, c = dynamic_model(robot, *row[:8])
    return times(inverse(M), *(tau + sign * own for tau, own in zip(row[8:], c.T)))


def J_for_its_transpose(robot, *row):
    """tau = Z q'' + J m xi''."""
    Z, m, A, B, d = parts(robot, *row[:8])
    J = inverse(A) @ B
    force = times(J, *row[8:]) + times(inverse(A), *d[..., 0].T)
    return tuple(np.asarray(times(Z, *row[8:])) + m * np.asarray(times(J, *(force[0] + force[2], force[1] + force[3]))))


INVERSE = Exercise(
    "inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD) -> tau1, tau2",
    inverse_dynamics,
    (
        passive_as_absolute(inverse_dynamics),
        Misconception(
            "c forgotten",
            "At constant motor speed the end-effector still accelerates. Which torque does that need?",
            lambda robot, *row: times(dynamic_model(robot, *row[:8])[0], *row[8:]),
        ),
        Misconception(
            "c subtracted",
            "tau = M q'' + c.",
            lambda robot, *row: tuple(
                2 * tau - own
                for tau, own in zip(times(dynamic_model(robot, *row[:8])[0], *row[8:]), inverse_dynamics(robot, *row))
            ),
        ),
        Misconception(
            "only the diagonal of M",
            "Does the left motor feel nothing of the right one's acceleration?",
            lambda robot, *row: apply(
                (dynamic_model(robot, *row[:8])[0] * np.eye(2), dynamic_model(robot, *row[:8])[1]), row[8:]
            ),
        ),
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
        passive_as_absolute(forward_dynamics),
        Misconception(
            "c forgotten",
            "Without torque and in motion: does your robot really keep its motor speeds?",
            lambda robot, *row: forward_dynamics(robot, *row, sign=0),
        ),
        Misconception(
            "c added", "Solve tau = M q'' + c for q''.", lambda robot, *row: forward_dynamics(robot, *row, sign=1)
        ),
        Misconception(
            "only the diagonal of M",
            "Does the left motor feel nothing of the right one's acceleration?",
            lambda robot, *row: tuple(
                (tau - own) / M
                for tau, own, M in zip(
                    row[8:],
                    dynamic_model(robot, *row[:8])[1].T,
                    np.einsum("nii->in", dynamic_model(robot, *row[:8])[0]),
                )
            ),
        ),
        Misconception(
            "M not inverted",
            "A larger inertia must accelerate less. Does yours?",
            lambda robot, *row: times(
                dynamic_model(robot, *row[:8])[0],
                *(tau - own for tau, own in zip(row[8:], dynamic_model(robot, *row[:8])[1].T)),
            ),
        ),
    ),
)

EXERCISES = [DYNAMIC_MODEL, INVERSE, FORWARD]
