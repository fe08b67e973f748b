"""Lab 2: A xi' = B q' and the passive rates, right and wrong."""

import numpy as np

from fivebar.grading import Exercise, Misconception
from fivebar.grading.four_joints import QUARTER, inverse, passive_as_absolute, pose, times
from fivebar.models.kinematics import Rates


def A(robot, *q):
    return pose(robot, *q).A


def B(robot, *q):
    return pose(robot, *q).B


def lengths(robot):
    """The proximal bars on a diagonal: B = lengths sin."""
    return np.diag([robot.l11, robot.l21])


def dkm(robot, q11, q12, q21, q22, q11D, q21D):
    q = q11, q12, q21, q22
    return times(inverse(A(robot, *q)) @ B(robot, *q), q11D, q21D)


def ikm(robot, q11, q12, q21, q22, xD, yD):
    q = q11, q12, q21, q22
    return times(inverse(B(robot, *q)) @ A(robot, *q), xD, yD)


def dkm_passive(robot, q11, q12, q21, q22, q11D, q21D, xD, yD):
    return tuple(Rates(pose(robot, q11, q12, q21, q22), (q11D, q21D), (xD, yD)).q_passive_dot.T)


def across(robot, *row):
    """v12 . xi' / l12 and v22 . xi' / l22, each (n,)."""
    parts = times(A(robot, *row[:4]) @ QUARTER.T, *row[6:])
    return tuple(part / bar for part, bar in zip(parts, robot.distal))


def with_matrices(name, change, text):
    """A wrong model of dkm or ikm: change(A, B, robot) in place of its matrix."""

    def model(robot, *row):
        return times(change(A(robot, *row[:4]), B(robot, *row[:4]), robot), *row[4:])

    return Misconception(name, text, model)


FOUR = "(q11, q12, q21, q22)"

A_EXERCISE = Exercise(
    f"A{FOUR} -> A",
    A,
    (
        passive_as_absolute(A),
        Misconception(
            "unit vectors as columns",
            "Each scalar product with xi' is one row of A xi'.",
            lambda robot, *q: A(robot, *q).swapaxes(1, 2),
        ),
        Misconception(
            "proximal bars instead of distal bars",
            "Which bar's direction makes the passive rate disappear from its leg's equation?",
            lambda robot, q11, q12, q21, q22: A(robot, q11, 0 * q12, q21, 0 * q22),
        ),
        Misconception(
            "v instead of u",
            "Multiply with a vector that is perpendicular to what shall disappear. What multiplies the passive rate?",
            lambda robot, *q: A(robot, *q) @ QUARTER.T,
        ),
        Misconception(
            "legs exchanged", "The first row belongs to the left leg.", lambda robot, *q: A(robot, *q)[:, ::-1]
        ),
        Misconception(
            "sign of the right leg's row",
            "Both legs' equations have xi' alone on the left side. Which signs do the two rows get?",
            lambda robot, *q: A(robot, *q) * np.array([[1.0], [-1.0]]),
        ),
        Misconception(
            "rows as long as the distal bars",
            "A row of A and of B may be multiplied by any length and stays true. Which length of A's rows is asked?",
            lambda robot, *q: np.diag(robot.distal) @ A(robot, *q),
        ),
        Misconception(
            "sine and cosine exchanged",
            "A bar at angle 0 points along x: what does your row say?",
            lambda robot, *q: A(robot, *q)[:, :, ::-1],
        ),
    ),
    shapes={"A": (2, 2)},
)

B_EXERCISE = Exercise(
    f"B{FOUR} -> B",
    B,
    (
        passive_as_absolute(B),
        Misconception(
            "lengths forgotten in B",
            "A has no unit and xi' is in m/s. Which unit must B have?",
            lambda robot, *q: inverse(lengths(robot)) @ B(robot, *q),
        ),
        Misconception(
            "u instead of v for the proximal bar",
            "In which direction does the elbow move when only q11 turns?",
            lambda robot, q11, q12, q21, q22: B(robot, q11, q12 + np.pi / 2, q21, q22 + np.pi / 2),
        ),
        Misconception(
            "+90 degrees turned the other way",
            "Turn (1, 0) by +90 degrees, counter-clockwise. Is it (0, 1) or (0, -1)?",
            lambda robot, *q: -B(robot, *q),
        ),
        Misconception(
            "direction of the distal bar instead of the angle between the bars",
            "u12 . v11 depends on the angle between two bars only. Which one of the four joint angles is that?",
            lambda robot, q11, q12, q21, q22: B(robot, q11, q11 + q12, q21, q21 + q22),
        ),
        Misconception(
            "legs exchanged", "The first row belongs to the left leg.", lambda robot, *q: B(robot, *q)[:, ::-1, ::-1]
        ),
        Misconception(
            "multiplied by the distal bars",
            "B is in metres. Which length did the vectors have that you multiplied with?",
            lambda robot, *q: np.diag(robot.distal) @ B(robot, *q),
        ),
        Misconception(
            "length of the distal bar",
            "Which bar carries the elbow, and so decides how fast the elbow moves?",
            lambda robot, *q: np.diag(robot.distal) @ inverse(lengths(robot)) @ B(robot, *q),
        ),
    ),
    shapes={"B": (2, 2)},
)

DKM = Exercise(
    "dkm(q11, q12, q21, q22, q11D, q21D) -> xD, yD",
    dkm,
    (
        passive_as_absolute(dkm),
        with_matrices("A and B exchanged", lambda A, B, robot: inverse(B) @ A, "Solve A xi' = B q' for xi'."),
        with_matrices(
            "A transposed",
            lambda A, B, robot: inverse(A).swapaxes(1, 2) @ B,
            "Put A and B of one pose on paper: does your A xi' give u12 . xi' in its first row?",
        ),
        with_matrices(
            "A not inverted", lambda A, B, robot: A @ B, "A stands beside xi'. What brings it to the other side?"
        ),
        with_matrices(
            "matrices in the wrong order",
            lambda A, B, robot: B @ inverse(A),
            "Matrices do not commute: which of them must act on q' first?",
        ),
        with_matrices(
            "lengths forgotten in B",
            lambda A, B, robot: inverse(A) @ inverse(lengths(robot)) @ B,
            "xi' is in m/s and q' in rad/s. Where do the metres come from?",
        ),
        with_matrices(
            "+90 degrees turned the other way",
            lambda A, B, robot: -inverse(A) @ B,
            "Everything moves the other way. Which way does v11 point?",
        ),
        with_matrices(
            "sign of the right leg's row",
            lambda A, B, robot: inverse(np.diag([1.0, -1.0]) @ A) @ B,
            "In the right leg's equation, which sign does u22 get on either side?",
        ),
        Misconception(
            "passive joints taken as locked",
            "You move the left leg as one rigid piece. Do the passive joints stand still?",
            lambda robot, q11, q12, q21, q22, q11D, q21D: (
                -q11D * (robot.l11 * np.sin(q11) + robot.l12 * np.sin(q11 + q12)),
                q11D * (robot.l11 * np.cos(q11) + robot.l12 * np.cos(q11 + q12)),
            ),
        ),
    ),
)

IKM = Exercise(
    "ikm(q11, q12, q21, q22, xD, yD) -> q11D, q21D",
    ikm,
    (
        passive_as_absolute(ikm),
        with_matrices("A and B exchanged", lambda A, B, robot: inverse(A) @ B, "Solve A xi' = B q' for q'."),
        with_matrices(
            "A transposed",
            lambda A, B, robot: inverse(B) @ A.swapaxes(1, 2),
            "Does the first row of your A xi' give u12 . xi'?",
        ),
        with_matrices(
            "matrices in the wrong order",
            lambda A, B, robot: A @ inverse(B),
            "Matrices do not commute: which of them must act on xi' first?",
        ),
        with_matrices(
            "B not inverted", lambda A, B, robot: B @ A, "B stands beside q'. What brings it to the other side?"
        ),
        with_matrices(
            "lengths forgotten in B",
            lambda A, B, robot: lengths(robot) @ inverse(B) @ A,
            "A shorter proximal bar must turn faster. Does yours?",
        ),
        with_matrices(
            "+90 degrees turned the other way",
            lambda A, B, robot: -inverse(B) @ A,
            "Which way does an elbow move when its motor turns counter-clockwise, and which way does v11 point?",
        ),
        with_matrices(
            "sign of the right leg's row",
            lambda A, B, robot: inverse(B) @ np.diag([1.0, -1.0]) @ A,
            "In the right leg's equation, which sign does u22 get on either side?",
        ),
    ),
)

DKM_PASSIVE = Exercise(
    "dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD) -> q12D, q22D",
    dkm_passive,
    (
        passive_as_absolute(dkm_passive),
        Misconception(
            "absolute rate instead of relative",
            "You have the rate of the distal bar. Which part of it comes from the motor?",
            lambda robot, *row: tuple(own + q for own, q in zip(dkm_passive(robot, *row), row[4:6])),
        ),
        Misconception(
            "active rate added instead of subtracted",
            "The distal bar turns at q11' + q12'. Solve that for q12'.",
            lambda robot, *row: tuple(own + 2 * q for own, q in zip(dkm_passive(robot, *row), row[4:6])),
        ),
        Misconception(
            "elbow taken as standing still",
            "xi' is the elbow's velocity and the bar's rotation together. Did you take the elbow's part away?",
            lambda robot, *row: tuple(part - q for part, q in zip(across(robot, *row), row[4:6])),
        ),
        Misconception(
            "u instead of v for the distal bar",
            "u12 makes the rate of the distal bar disappear. Which vector keeps it best?",
            lambda robot, *row: tuple(
                (along - share) / bar - q
                for along, share, bar, q in zip(
                    times(A(robot, *row[:4]), *row[6:]), times(B(robot, *row[:4]), *row[4:6]), robot.distal, row[4:6]
                )
            ),
        ),
        Misconception(
            "length of the distal bar forgotten",
            "A velocity in m/s is not a rate in rad/s. Which length lies between them?",
            lambda robot, *row: tuple(
                (own + q) * bar - q for own, bar, q in zip(dkm_passive(robot, *row), robot.distal, row[4:6])
            ),
        ),
        Misconception(
            "+90 degrees turned the other way",
            "Turn (1, 0) by +90 degrees, counter-clockwise. Is it (0, 1) or (0, -1)?",
            lambda robot, *row: tuple(-own - 2 * q for own, q in zip(dkm_passive(robot, *row), row[4:6])),
        ),
        Misconception(
            "+90 degrees turned the other way for both bars",
            "Print your v at the angle 0. Is it (0, 1) or (0, -1)?",
            lambda robot, *row: tuple(
                own - 2 * part for own, part in zip(dkm_passive(robot, *row), across(robot, *row))
            ),
        ),
        Misconception(
            "legs exchanged",
            "In which order does the signature ask for the two rates?",
            lambda robot, *row: dkm_passive(robot, *row)[::-1],
        ),
    ),
)

EXERCISES = [A_EXERCISE, B_EXERCISE, DKM, IKM, DKM_PASSIVE]
