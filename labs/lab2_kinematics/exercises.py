"""Lab 2: A xi' = B q' and the passive rates, right and wrong."""

import numpy as np

from fivebar import FiveBar
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import QUARTER, inverse, pose, times
from fivebar.grading.misconceptions.common import passive_misread
from fivebar.grading.misconceptions.kinematics import (
    dkm,
    dkm_passive,
    ikm,
    with_matrix,
    with_standing_pivots,
    wrong_dkm,
    wrong_dkm_passive,
    wrong_ikm,
)
from fivebar.grading.misconceptions.stepwise import stepwise


def A(robot, *q):
    return pose(robot, *q).A


def B(robot, *q):
    return pose(robot, *q).B


def lengths(robot):
    """The proximal bars on a diagonal: B = lengths sin."""
    return np.diag([robot.l11, robot.l21])


FOUR = "(q11, q12, q21, q22)"

A_EXERCISE = Exercise(
    f"A{FOUR} -> A",
    A,
    (
        passive_misread(FiveBar, A),
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
            "legs exchanged",
            "The first row belongs to the left leg.",
            lambda robot, *q: A(robot, *q)[:, ::-1],
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
        passive_misread(FiveBar, B),
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
            "legs exchanged",
            "The first row belongs to the left leg.",
            lambda robot, *q: B(robot, *q)[:, ::-1, ::-1],
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
        *wrong_dkm(FiveBar),
        with_matrix(
            "lengths forgotten in B",
            "xi' is in m/s and q' in rad/s. Where do the metres come from?",
            lambda A, B, robot: inverse(A) @ inverse(lengths(robot)) @ B,
        ),
        with_matrix(
            "sign of the right leg's row",
            "In the right leg's equation, which sign does u22 get on either side?",
            lambda A, B, robot: inverse(np.diag([1.0, -1.0]) @ A) @ B,
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
        *wrong_ikm(FiveBar),
        with_matrix(
            "matrices in the wrong order",
            "Matrices do not commute: which of them must act on xi' first?",
            lambda A, B, robot: A @ inverse(B),
        ),
        with_matrix(
            "lengths forgotten in B",
            "A shorter proximal bar must turn faster. Does yours?",
            lambda A, B, robot: lengths(robot) @ inverse(B) @ A,
        ),
        with_matrix(
            "sign of the right leg's row",
            "In the right leg's equation, which sign does u22 get on either side?",
            lambda A, B, robot: inverse(B) @ np.diag([1.0, -1.0]) @ A,
        ),
    ),
)

DKM_PASSIVE = Exercise(
    "dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD) -> q12D, q22D",
    dkm_passive,
    (
        *wrong_dkm_passive(FiveBar),
        Misconception(
            "absolute rate instead of relative",
            "You have the rate of the distal bar. Which part of it comes from the motor?",
            lambda robot, *row: tuple(
                own + q for own, q in zip(dkm_passive(robot, *row), row[4:6])
            ),
        ),
        Misconception(
            "active rate added instead of subtracted",
            "The distal bar turns at q11' + q12'. Solve that for q12'.",
            lambda robot, *row: tuple(
                own + 2 * q for own, q in zip(dkm_passive(robot, *row), row[4:6])
            ),
        ),
        Misconception(
            "u instead of v for the distal bar",
            "u12 makes the rate of the distal bar disappear. Which vector keeps it best?",
            lambda robot, *row: tuple(
                (along - share) / bar - q
                for along, share, bar, q in zip(
                    times(A(robot, *row[:4]), *row[6:]),
                    times(B(robot, *row[:4]), *row[4:6]),
                    robot.distal,
                    row[4:6],
                )
            ),
        ),
        Misconception(
            "+90 degrees turned the other way for both bars",
            "Print your v at the angle 0. Is it (0, 1) or (0, -1)?",
            lambda robot, *row: tuple(
                own - 2 * part
                for own, part in zip(dkm_passive(robot, *row), with_standing_pivots(robot, *row))
            ),
        ),
    ),
)

EXERCISES = stepwise(FiveBar, A_EXERCISE, B_EXERCISE, DKM, IKM, DKM_PASSIVE)
USES = dict.fromkeys(("dkm", "ikm"), ("A", "B"))
