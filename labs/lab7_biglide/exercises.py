"""Lab 7: the ten models of the biglide and the efforts of a motion; here the wrong ones that only a biglide has."""

from dataclasses import replace
from functools import partial

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import inverse, times
from fivebar.grading.misconceptions.common import (
    c_forgotten,
    legs_exchanged,
    one_length,
    with_one_length,
)
from fivebar.grading.misconceptions.direct import (
    dgm,
    dgm_passive,
    over_h,
    pivots,
    wrong_dgm,
    wrong_dgm_passive,
)
from fivebar.grading.misconceptions.dynamics import (
    M_of,
    c_of,
    dynamic_model,
    with_model,
    wrong_dynamic_model,
)
from fivebar.grading.misconceptions.inverse import igm, igm_with_bases, wrong_igm
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
from fivebar.grading.misconceptions.second_order import (
    d_of,
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

KIND = fb.Biglide
ROBOT = KIND()  # the handout's

FOUR, RATES = "q11, q12, q21, q22", "q11D, q12D, q21D, q22D"

DGM = Exercise(
    "dgm(q11, q21, assembly_mode) -> x, y",
    dgm,
    (
        *wrong_dgm(KIND),
        Misconception(
            "feet slide the other way",
            "Which way does a foot move when its coordinate grows?",
            lambda robot, q11, q21, mode: dgm(robot, -q11, -q21, mode),
        ),
        Misconception(
            "horizontal guides instead of vertical ones",
            "Along which axis do the feet slide in the figure, and which of your feet's coordinates holds q?",
            lambda robot, *row: dgm(robot, *row)[::-1],
        ),
        with_one_length(KIND, dgm),
    ),
)

IGM = Exercise(
    "igm(x, y, gamma1, gamma2) -> q11, q21",
    igm,
    (
        *wrong_igm(KIND),
        Misconception(
            "guide's x with the wrong sign",
            "The left guide is at x = -d/2. How far in x is it from the end-effector to that guide?",
            igm_with_bases(1, -1),
        ),
        Misconception(
            "height of the end-effector forgotten",
            "Lift the robot by 0.1 m: how do the feet move, and what do your answers do?",
            lambda robot, x, y, *modes: igm(robot, x, 0 * y, *modes),
        ),
        Misconception(
            "height of the end-effector with the wrong sign",
            "Lift the robot by 0.1 m: which way do the feet move, and which way do yours?",
            lambda robot, x, y, *modes: igm(robot, x, -y, *modes),
        ),
        Misconception(
            "horizontal guides instead of vertical ones",
            "Along which axis do the feet slide in the figure? The other coordinate of a foot never changes.",
            lambda robot, x, y, *modes: igm(robot, y, x, *modes),
        ),
        with_one_length(KIND, igm),
    ),
)


def in_the_middle(robot, *row):
    x, y = over_h(robot, *row, foot=lambda robot, span: span / 2)
    return tuple(np.angle(x + 1j * y - foot) for foot in pivots(robot, *row[:2]))


DGM_PASSIVE = Exercise(
    "dgm_passive(q11, q21, assembly_mode) -> q12, q22",
    dgm_passive,
    (
        *wrong_dgm_passive(KIND),
        Misconception(
            "passive angles relative instead of absolute",
            "A foot slides and does not turn. From which fixed direction is its bar's angle measured?",
            lambda robot, *row: tuple(phi - q for phi, q in zip(dgm_passive(robot, *row), row)),
        ),
        Misconception(
            "angles measured from the guide",
            "At home the angles are pi/4 and 3 pi/4. From which axis are these measured?",
            partial(dgm_passive, read=lambda bar: np.angle(bar) - np.pi / 2),
        ),
        Misconception(
            "atan2 with x before y",
            "atan2 of a point on the x axis is 0. Try yours on (1, 0).",
            partial(dgm_passive, read=lambda bar: np.pi / 2 - np.angle(bar)),
        ),
        Misconception(
            "right bar's angle taken inwards",
            "Both angles grow counter-clockwise from the same direction. Is that so for your right bar at home?",
            lambda robot, *row: (dgm_passive(robot, *row)[0], np.pi - dgm_passive(robot, *row)[1]),
        ),
        Misconception(
            "H in the middle although the bars differ",
            "Your angles follow from your end-effector: first see to dgm with two different bars.",
            in_the_middle,
        ),
    ),
    angles=("q12", "q22"),
)


def cosines(A):
    """B of who takes the bars' components along x."""
    return A[:, :, :1] * np.eye(2)


COSINES = (
    "sine and cosine exchanged in B",
    "A foot moves along y. Which component of the bar's direction does u . (0, 1) pick?",
)
COLUMNS = (
    "sine and cosine exchanged in A",
    "A bar at angle 0 points along x: what does your row of A say?",
)
LENGTH = "length of the bars in B", "q' and xi' are both in m/s. Which unit must B have?"

DKM = Exercise(
    f"dkm({FOUR}, q11D, q21D) -> xD, yD",
    dkm,
    (
        *wrong_dkm(KIND),
        with_matrix(*COSINES, lambda A, B, robot: inverse(A) @ cosines(A)),
        with_matrix(*COLUMNS, lambda A, B, robot: inverse(A[:, :, ::-1]) @ B),
        with_matrix(*LENGTH, lambda A, B, robot: inverse(A) @ np.diag(robot.distal) @ B),
        with_matrix(
            "legs exchanged in B",
            "The first row of A belongs to the left leg, so that of B, too.",
            lambda A, B, robot: inverse(A) @ B[:, ::-1, ::-1],
        ),
    ),
)

IKM = Exercise(
    f"ikm({FOUR}, xD, yD) -> q11D, q21D",
    ikm,
    (
        *wrong_ikm(KIND),
        with_matrix(*COSINES, lambda A, B, robot: inverse(cosines(A)) @ A),
        with_matrix(*COLUMNS, lambda A, B, robot: inverse(B) @ A[:, :, ::-1]),
        with_matrix(*LENGTH, lambda A, B, robot: inverse(np.diag(robot.distal) @ B) @ A),
        legs_exchanged(KIND, ikm),
    ),
)

DKM_PASSIVE = Exercise(
    f"dkm_passive({FOUR}, q11D, q21D, xD, yD) -> q12D, q22D",
    dkm_passive,
    (
        *wrong_dkm_passive(KIND),
        Misconception(
            "foot's velocity added instead of subtracted",
            "xi' = foot's velocity + l phi' v. Solve that for phi'.",
            lambda robot, *row: dkm_passive(robot, *row[:4], -row[4], -row[5], *row[6:]),
        ),
        Misconception(
            "foot's velocity not projected",
            "A foot moves along y, the bar's end along v. Which part of the foot's velocity lies along v?",
            lambda robot, *row: tuple(
                part - q / bar
                for part, q, bar in zip(with_standing_pivots(robot, *row), row[4:6], robot.distal)
            ),
        ),
        with_one_length(
            KIND,
            dkm_passive,
            "This robot has two bars of different lengths. Which of them turns how fast?",
        ),
        Misconception(
            "foot's speed subtracted as in the five-bar",
            "A foot does not turn: is there anything between the bar's own rate and what is asked?",
            lambda robot, *row: tuple(
                rate - q for rate, q in zip(dkm_passive(robot, *row), row[4:6])
            ),
        ),
    ),
)


def swinging(robot, *rates):
    """d of bars that turn at these rates."""
    return np.stack([-bar * rate**2 for bar, rate in zip(robot.distal, rates)], -1)


BIAS = [
    *wrong_bias(KIND),
    with_d(
        "rate not squared",
        "d is an acceleration in m/s². Which unit does l phi' have?",
        lambda robot, *row: np.stack([-robot.l1 * row[5], -robot.l2 * row[7]], -1),
    ),
    with_d(
        "length forgotten in d",
        "d is an acceleration in m/s². Which unit does phi'^2 have?",
        lambda robot, *row: d_of(robot, *row) / np.array(robot.distal),
    ),
    with_d(
        "foot's speed in place of the bar's rate",
        "A foot moves in a straight line. What is it that turns?",
        lambda robot, *row: swinging(robot, row[4], row[6]),
    ),
    with_d(
        "sum of both rates as in the five-bar",
        "q11' is in m/s, q12' in rad/s. How fast does the bar turn against the fixed frame?",
        lambda robot, *row: swinging(robot, row[4] + row[5], row[6] + row[7]),
    ),
    with_d(
        "one length for both bars",
        "This robot has two bars of different lengths. Which of them stands in which row of d?",
        lambda robot, *row: d_of(one_length(robot), *row),
    ),
    with_parts(
        *COSINES,
        lambda robot, *row: (
            parts(robot, *row)[0],
            cosines(parts(robot, *row)[0]),
            d_of(robot, *row),
        ),
    ),
]

DKM2 = Exercise(
    f"dkm2({FOUR}, {RATES}, q11DD, q21DD) -> xDD, yDD", dkm2, tuple(direct for direct, _ in BIAS)
)

IKM2 = Exercise(
    f"ikm2({FOUR}, {RATES}, xDD, yDD) -> q11DD, q21DD",
    ikm2,
    (*(inverse_one for _, inverse_one in BIAS), legs_exchanged(KIND, ikm2)),
)

DKM2_PASSIVE = Exercise(
    f"dkm2_passive({FOUR}, {RATES}, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD",
    dkm2_passive,
    (
        *wrong_dkm2_passive(KIND),
        Misconception(
            "foot's acceleration forgotten",
            "xi'' is the foot's acceleration and the bar's together. Did you take the foot's part away?",
            lambda robot, *row: dkm2_passive(robot, *row[:8], 0 * row[8], 0 * row[9], *row[10:]),
        ),
        Misconception(
            "foot's acceleration added instead of subtracted",
            "Where does the foot's acceleration stand when you solve for phi''?",
            lambda robot, *row: dkm2_passive(robot, *row[:8], -row[8], -row[9], *row[10:]),
        ),
        with_one_length(KIND, dkm2_passive),
        Misconception(
            "foot's acceleration subtracted as in the five-bar",
            "A foot does not turn: is there anything between the bar's own acceleration and what is asked?",
            lambda robot, *row: tuple(
                phi - q for phi, q in zip(dkm2_passive(robot, *row), row[8:10])
            ),
        ),
    ),
)


DYNAMIC_MODEL = Exercise(
    f"dynamic_model({FOUR}, {RATES}) -> M, c",
    dynamic_model,
    (
        *wrong_dynamic_model(KIND),
        Misconception(
            "masses of feet and end-effector exchanged",
            "Which mass slides on a guide, and which one do both bars carry?",
            lambda robot, *row: dynamic_model(
                replace(robot, mf1=robot.m, mf2=robot.m, m=robot.mf1), *row
            ),
        ),
        with_model(
            "both feet added to M as a scalar",
            "A foot is moved by its own drive only. Which element of M is that?",
            lambda Z, *rest: (M_of(np.trace(Z) * np.ones((2, 2)), *rest), c_of(Z, *rest)),
        ),
        with_model(
            "both feet's masses on each drive",
            "How many feet does the left drive push?",
            lambda Z, *rest: (M_of(np.trace(Z) * np.eye(2), *rest), c_of(Z, *rest)),
        ),
        Misconception(
            "feet's masses moved with the end-effector",
            "At which velocity does a foot move, and at which one the end-effector?",
            lambda robot, *row: dynamic_model(
                replace(robot, mf1=0, mf2=0, m=robot.m + robot.mf1 + robot.mf2), *row
            ),
        ),
        Misconception(
            "sum of both rates as in the five-bar",
            "q11' is in m/s, q12' in rad/s. How fast does the bar turn against the fixed frame?",
            lambda robot, *row: dynamic_model(
                robot, *row[:5], row[4] + row[5], row[6], row[6] + row[7]
            ),
        ),
        with_model(
            "c with the feet's masses",
            "A foot moves in a straight line: does it need an effort at constant speed?",
            lambda Z, m, *rest: (M_of(Z, m, *rest), c_of(Z, m, *rest) + Z @ c_of(Z, 1.0, *rest)),
        ),
    ),
    shapes={"M": (2, 2), "c": (2,)},
)


def efforts(robot, x, y, xD, yD, xDD, yDD, gamma1, gamma2, speed=1.0, bias=1.0, raw=False):
    """speed: by which the velocity is multiplied for q''; bias: of c; raw: xi'' in place of q''."""
    pose = fb.igm(robot, np.stack([x, y], -1), np.stack([gamma1, gamma2], -1))
    xi_dot, xi_ddot = np.stack([xD, yD], -1), np.stack([xDD, yDD], -1)
    M, c = fb.dynamic_model(fb.ikm(pose, xi_dot))
    q_ddot = xi_ddot if raw else fb.ikm2(fb.ikm(pose, speed * xi_dot), xi_ddot).q_ddot
    return tuple(times(M, *q_ddot.T) + bias * c.T)


EFFORTS = Exercise(
    "efforts(x, y, xD, yD, xDD, yDD, gamma1, gamma2) -> tau1, tau2",
    efforts,
    (
        c_forgotten(KIND, partial(efforts, bias=0.0)),
        Misconception(
            "bias of the second-order model forgotten",
            "With xi'' = 0 and xi' not 0: do the feet keep their speeds?",
            partial(efforts, speed=0.0),
        ),
        Misconception(
            "accelerations of the end-effector taken for the feet's",
            "M belongs to q''. Which of your models gives q'' for an xi''?",
            partial(efforts, raw=True),
        ),
        Misconception(
            "working modes never used",
            "The crossing is in the working modes +1, -1. Do gamma1 and gamma2 reach your igm?",
            lambda robot, *row: efforts(robot, *row[:6], *-np.ones((2, len(row[0])), int)),
        ),
        Misconception(
            "only the end-effector's mass",
            "What do the drives push besides the end-effector?",
            lambda robot, *row: efforts(replace(robot, mf1=0.0, mf2=0.0), *row),
        ),
        legs_exchanged(KIND, efforts),
    ),
)

EXERCISES = stepwise(
    KIND,
    DGM,
    IGM,
    DGM_PASSIVE,
    DKM,
    IKM,
    DKM_PASSIVE,
    DKM2,
    IKM2,
    DKM2_PASSIVE,
    DYNAMIC_MODEL,
    EFFORTS,
)
USES = {
    "efforts": (
        "dgm",
        "igm",
        "dgm_passive",
        "dkm",
        "ikm",
        "dkm_passive",
        "dkm2",
        "ikm2",
        "dynamic_model",
    )
}
