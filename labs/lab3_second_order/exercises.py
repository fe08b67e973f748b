"""Lab 3: A xi'' = B q'' + d and the passive accelerations, right and wrong."""

from functools import partial

import numpy as np

from fivebar import FiveBar
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import inverse, times
from fivebar.grading.misconceptions.second_order import (
    dkm2,
    dkm2_passive,
    ikm2,
    parts,
    with_d,
    with_parts,
    wrong_bias,
    wrong_dkm2_passive,
)
from fivebar.grading.misconceptions.stepwise import stepwise


def proximal(robot, q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """The share of the proximal bars in d, (n, 2)."""
    return np.stack([-robot.l11 * np.cos(q12) * q11D**2, -robot.l21 * np.cos(q22) * q21D**2], -1)


def distal(robot, *row):
    return parts(robot, *row)[2] - proximal(robot, *row)


def with_rates(name, hint, change):
    """The misconception of other joint rates, change(q11D, q12D, q21D, q22D), in both models."""
    return with_parts(name, hint, lambda robot, *row: parts(robot, *row[:4], *change(*row[4:])))


BIAS = [
    *wrong_bias(FiveBar),
    with_d(
        "centripetal term of the proximal bar missing",
        "Differentiate l11 q11' v11 once more: two factors depend on time.",
        distal,
    ),
    with_d(
        "centripetal term of the distal bar missing",
        "Differentiate l12 (q11' + q12') v12 once more: what does u12 . u12 give?",
        proximal,
    ),
    with_d(
        "centripetal term of the proximal bar of the wrong sign",
        "The derivative of v11 is -q11' u11. Both bars pull to their centres: which signs do the two terms get?",
        lambda robot, *row: distal(robot, *row) - proximal(robot, *row),
    ),
    with_d(
        "centripetal term of the distal bar of the wrong sign",
        "The derivative of v12 is minus its rate times u12. Which signs do the two terms get?",
        lambda robot, *row: proximal(robot, *row) - distal(robot, *row),
    ),
    with_d(
        "proximal centripetal term not projected",
        "The elbow's centripetal acceleration points along u11. Which part of it lies along u12?",
        lambda robot, *row: (
            distal(robot, *row) + proximal(robot, row[0], 0 * row[1], row[2], 0 * row[3], *row[4:])
        ),
    ),
    with_d(
        "v in place of u in the proximal centripetal term",
        "Which way does the elbow's acceleration point when q11' is constant?",
        lambda robot, *row: (
            distal(robot, *row)
            + proximal(robot, row[0], row[1] - np.pi / 2, row[2], row[3] - np.pi / 2, *row[4:])
        ),
    ),
    with_rates(
        "q12' where q11' + q12' belongs",
        "How fast does the distal bar turn against the fixed frame?",
        lambda q11D, q12D, q21D, q22D: (q11D, q12D - q11D, q21D, q22D - q21D),
    ),
    with_rates(
        "sum of squares instead of square of the sum",
        "(a + b)^2 has a third term.",
        lambda q11D, q12D, q21D, q22D: (
            q11D,
            np.hypot(q11D, q12D) - q11D,
            q21D,
            np.hypot(q21D, q22D) - q21D,
        ),
    ),
]


def without_d(robot, *row):
    A, B, d = parts(robot, *row)
    return A, B, 0 * d


DKM2 = Exercise(
    "dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD) -> xDD, yDD",
    dkm2,
    (
        *(direct for direct, _ in BIAS),
        Misconception(
            "A transposed",
            "Does the first row of your A xi'' give u12 . xi''?",
            lambda robot, *row: times(
                inverse(parts(robot, *row[:8])[0]).swapaxes(1, 2) @ parts(robot, *row[:8])[0],
                *dkm2(robot, *row),
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
)

IKM2 = Exercise(
    "ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD) -> q11DD, q21DD",
    ikm2,
    (
        *(inverse_one for _, inverse_one in BIAS),
        Misconception(
            "d not divided by B",
            "B q'' = A xi'' - d: what happens to d when you bring B to the other side?",
            lambda robot, *row: tuple(
                ikm2(robot, *row, parts=without_d) - parts(robot, *row[:8])[2].T
            ),
        ),
    ),
)


def swung(robot, *row, centripetal):
    """The passive accelerations with the elbows' centripetal terms times this factor."""
    right, bars = dkm2_passive(robot, *row), ((robot.l11, robot.l12), (robot.l21, robot.l22))
    legs = zip(right, bars, row[1:4:2], row[4:8:2])
    return tuple(
        own - (centripetal - 1) * l1 / l2 * np.sin(q) * rate**2 for own, (l1, l2), q, rate in legs
    )


DKM2_PASSIVE = Exercise(
    "dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD",
    dkm2_passive,
    (
        *wrong_dkm2_passive(FiveBar),
        Misconception(
            "absolute acceleration instead of relative",
            "You have the acceleration of the distal bar. Which part of it comes from the motor?",
            lambda robot, *row: tuple(
                own + q for own, q in zip(dkm2_passive(robot, *row), row[8:10])
            ),
        ),
        Misconception(
            "active acceleration added instead of subtracted",
            "The distal bar accelerates at q11'' + q12''. Solve that for q12''.",
            lambda robot, *row: tuple(
                own + 2 * q for own, q in zip(dkm2_passive(robot, *row), row[8:10])
            ),
        ),
        Misconception(
            "centripetal term missing",
            "v12 . u12 is 0, but v12 . u11 is not.",
            partial(swung, centripetal=0.0),
        ),
        Misconception(
            "centripetal term of the wrong sign",
            "The elbow's centripetal acceleration is -l11 q11'^2 u11. To which side did you bring it?",
            partial(swung, centripetal=-1.0),
        ),
    ),
)

EXERCISES = stepwise(FiveBar, DKM2, IKM2, DKM2_PASSIVE)
