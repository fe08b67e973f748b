"""Lab 3: A xi'' = B q'' + d and the passive accelerations, right and wrong."""

from functools import partial

import numpy as np

from fivebar.grading import Exercise, Misconception
from fivebar.grading.four_joints import inverse, motion, passive_as_absolute, times
from fivebar.models.kinematics import Accelerations


def parts(robot, *row):
    """A, B and d of a motion, arrays (n, 2, 2) and (n, 2)."""
    rates = motion(robot, *row)
    return rates.pose.A, rates.pose.B, rates.d


def dkm2(robot, *row, parts=parts):
    A, B, d = parts(robot, *row[:8])
    along = times(B, *row[8:]) + d.T
    return times(inverse(A), *along)


def ikm2(robot, *row, parts=parts):
    A, B, d = parts(robot, *row[:8])
    along = times(A, *row[8:]) - d.T
    return times(inverse(B), *along)


def dkm2_passive(robot, *row):
    return tuple(Accelerations(motion(robot, *row[:8]), row[8:10], row[10:]).q_passive_ddot.T)


def proximal(robot, q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """The share of the proximal bars in d, (n, 2)."""
    return np.stack([-robot.l11 * np.cos(q12) * q11D**2, -robot.l21 * np.cos(q22) * q21D**2], -1)


def distal(robot, *row):
    return parts(robot, *row)[2] - proximal(robot, *row)


def with_d(name, d, hint):
    """The misconception of another d (robot, *row) -> (n, 2) in both models."""

    def other(robot, *row):
        A, B, _ = parts(robot, *row)
        return A, B, d(robot, *row)

    return [Misconception(name, hint, partial(model, parts=other)) for model in (dkm2, ikm2)]


def with_rates(name, change, hint):
    """The misconception of other joint rates, change(q11D, q12D, q21D, q22D), in both models."""

    def other(robot, *row):
        return parts(robot, *row[:4], *change(*row[4:]))

    return [Misconception(name, hint, partial(model, parts=other)) for model in (dkm2, ikm2)]


BIAS = [
    with_d(
        "d forgotten",
        lambda robot, *row: 0 * distal(robot, *row),
        "Let the motors run at constant speed: is the end-effector's acceleration 0?",
    ),
    with_d(
        "d of the wrong sign",
        lambda robot, *row: -proximal(robot, *row) - distal(robot, *row),
        "The derivative of v is -u. To which side does that term go?",
    ),
    with_d(
        "centripetal term of the proximal bar missing",
        distal,
        "Differentiate l11 q11' v11 once more: two factors depend on time.",
    ),
    with_d(
        "centripetal term of the distal bar missing",
        proximal,
        "Differentiate l12 (q11' + q12') v12 once more: what does u12 . u12 give?",
    ),
    with_d(
        "centripetal term of the proximal bar of the wrong sign",
        lambda robot, *row: distal(robot, *row) - proximal(robot, *row),
        "The derivative of v11 is -q11' u11. Both bars pull to their centres: which signs do the two terms get?",
    ),
    with_d(
        "centripetal term of the distal bar of the wrong sign",
        lambda robot, *row: proximal(robot, *row) - distal(robot, *row),
        "The derivative of v12 is minus its rate times u12. Which signs do the two terms get?",
    ),
    with_d(
        "proximal centripetal term not projected",
        lambda robot, *row: distal(robot, *row) + proximal(robot, row[0], 0 * row[1], row[2], 0 * row[3], *row[4:]),
        "The elbow's centripetal acceleration points along u11. Which part of it lies along u12?",
    ),
    with_d(
        "v in place of u in the proximal centripetal term",
        lambda robot, *row: (
            distal(robot, *row) + proximal(robot, row[0], row[1] - np.pi / 2, row[2], row[3] - np.pi / 2, *row[4:])
        ),
        "Which way does the elbow's acceleration point when q11' is constant?",
    ),
    with_rates(
        "q12' where q11' + q12' belongs",
        lambda q11D, q12D, q21D, q22D: (q11D, q12D - q11D, q21D, q22D - q21D),
        "How fast does the distal bar turn against the fixed frame?",
    ),
    with_rates(
        "sum of squares instead of square of the sum",
        lambda q11D, q12D, q21D, q22D: (
            q11D, np.hypot(q11D, q12D) - q11D, q21D, np.hypot(q21D, q22D) - q21D
        ),
        "(a + b)^2 has a third term.",
    ),
]  # fmt: skip

DKM2 = Exercise(
    "dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD) -> xDD, yDD",
    dkm2,
    (
        passive_as_absolute(dkm2),
        *(direct for direct, _ in BIAS),
        Misconception(
            "A transposed",
            "Does the first row of your A xi'' give u12 . xi''?",
            lambda robot, *row: times(
                inverse(parts(robot, *row[:8])[0]).swapaxes(1, 2) @ parts(robot, *row[:8])[0], *dkm2(robot, *row)
            ),
        ),
        Misconception(
            "d not multiplied by the inverse of A",
            "A xi'' = B q'' + d: what happens to d when you bring A to the other side?",
            lambda robot, *row: tuple(
                dkm2(robot, *row, parts=without_d) + parts(robot, *row[:8])[2].T
            ),
        ),
    ),
)  # fmt: skip


def without_d(robot, *row):
    A, B, d = parts(robot, *row)
    return A, B, 0 * d


IKM2 = Exercise(
    "ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD) -> q11DD, q21DD",
    ikm2,
    (
        passive_as_absolute(ikm2),
        *(inverse_one for _, inverse_one in BIAS),
        Misconception(
            "d not divided by B",
            "B q'' = A xi'' - d: what happens to d when you bring B to the other side?",
            lambda robot, *row: tuple(ikm2(robot, *row, parts=without_d) - parts(robot, *row[:8])[2].T),
        ),
    ),
)


def swung(robot, *row, centripetal=1.0, of_distal=0.0):
    """The passive accelerations with the elbows' centripetal terms times a factor, and the distal bars' own added."""
    q11, q12, q21, q22, q11D, q12D, q21D, q22D = row[:8]
    right = dkm2_passive(robot, *row)
    more = centripetal - 1
    return (
        right[0] - more * robot.l11 / robot.l12 * np.sin(q12) * q11D**2 + of_distal * (q11D + q12D) ** 2,
        right[1] - more * robot.l21 / robot.l22 * np.sin(q22) * q21D**2 + of_distal * (q21D + q22D) ** 2,
    )


DKM2_PASSIVE = Exercise(
    "dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD",
    dkm2_passive,
    (
        passive_as_absolute(dkm2_passive),
        Misconception(
            "absolute acceleration instead of relative",
            "You have the acceleration of the distal bar. Which part of it comes from the motor?",
            lambda robot, *row: tuple(own + q for own, q in zip(dkm2_passive(robot, *row), row[8:10])),
        ),
        Misconception(
            "active acceleration added instead of subtracted",
            "The distal bar accelerates at q11'' + q12''. Solve that for q12''.",
            lambda robot, *row: tuple(own + 2 * q for own, q in zip(dkm2_passive(robot, *row), row[8:10])),
        ),
        Misconception(
            "centripetal term missing",
            "v12 . u12 is 0, but v12 . u11 is not.",
            lambda robot, *row: swung(robot, *row, centripetal=0.0),
        ),
        Misconception(
            "centripetal term of the wrong sign",
            "The elbow's centripetal acceleration is -l11 q11'^2 u11. To which side did you bring it?",
            lambda robot, *row: swung(robot, *row, centripetal=-1.0),
        ),
        Misconception(
            "centripetal term of the distal bar kept",
            "You multiply by v12. What is left there of a vector along u12?",
            lambda robot, *row: swung(robot, *row, of_distal=1.0),
        ),
        Misconception(
            "length of the distal bar forgotten",
            "An acceleration in m/s^2 is not one in rad/s^2. Which length lies between them?",
            lambda robot, *row: tuple(
                (own + q) * bar - q for own, q, bar in zip(dkm2_passive(robot, *row), row[8:10], robot.distal)
            ),
        ),
        Misconception(
            "legs exchanged",
            "In which order does the signature ask for the two accelerations?",
            lambda robot, *row: dkm2_passive(robot, *row)[::-1],
        ),
    ),
)

EXERCISES = [DKM2, IKM2, DKM2_PASSIVE]
