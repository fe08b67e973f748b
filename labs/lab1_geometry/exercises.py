"""Lab 1: the right models and the wrong ones that students fall for. Points of the plane are complex numbers."""

from dataclasses import replace
from functools import partial

import numpy as np

from fivebar import FiveBar
from fivebar.grading import Exercise, Misconception
from fivebar.grading.misconceptions.common import with_one_length
from fivebar.grading.misconceptions.direct import (
    bars,
    dgm,
    dgm_passive,
    foot,
    half,
    meet,
    over_h,
    pivots,
    wrong_dgm,
    wrong_dgm_passive,
    xy,
)
from fivebar.grading.misconceptions.inverse import igm, igm_by_root, igm_with_bases, wrong_igm
from fivebar.grading.misconceptions.stepwise import stepwise


def right_base_at_left(robot, q11, q21, assembly_mode):
    left, right = pivots(robot, q11, q21)
    return xy(meet(robot, left, right - robot.d, assembly_mode))


DGM = Exercise(
    "dgm(q11, q21, assembly_mode) -> x, y",
    dgm,
    (
        *wrong_dgm(FiveBar),
        Misconception(
            "angles taken as degrees",
            "What is the unit of q11 here, and which one do sin and cos expect?",
            lambda robot, q11, q21, mode: dgm(robot, np.radians(q11), np.radians(q21), mode),
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Print your elbow A22 at q21 = 0 and find it in the figure.",
            right_base_at_left,
        ),
        Misconception(
            "direction not of unit length",
            "A direction times h has length h only if the direction has length 1.",
            partial(over_h, normal=lambda along, to_h: 1j * to_h),
        ),
        *(
            Misconception(
                f"quarter turn with the wrong sign of {name}",
                "Is your height perpendicular to the line of the elbows? Multiply the two directions as vectors.",
                partial(over_h, normal=lambda along, to_h, sign=sign: sign * 1j * along.conj()),
            )
            for name, sign in (("x", 1), ("y", -1))
        ),
        Misconception(
            "H in the middle, at the height over the left distal bar",
            "Is your end-effector as far from A22 as l22 says? Only an isosceles triangle has H in the middle.",
            lambda robot, *row: over_h(replace(robot, l22=robot.l12), *row, foot=half),
        ),
        Misconception(
            "distal bars exchanged",
            "Which distal bar hangs on A12, and which one on A22? Measure both in the pose that you return.",
            lambda robot, *row: dgm(replace(robot, l12=robot.l22, l22=robot.l12), *row),
        ),
        Misconception(
            "distance of H from the other elbow",
            "Make l22 shorter in a drawing: does H come nearer to A22 or go away from it? And yours?",
            partial(over_h, foot=lambda robot, span: span - foot(robot, span)),
        ),
        with_one_length(FiveBar, dgm),
    ),
)


def span_angle(robot, x, y):
    return np.arctan2(y, x + robot.d / 2), np.arctan2(y, x - robot.d / 2)


IGM = Exercise(
    "igm(x, y, gamma1, gamma2) -> q11, q21",
    igm,
    (
        *wrong_igm(FiveBar),
        Misconception(
            "angles returned in degrees",
            "Which unit do motors and sin use here?",
            lambda robot, *row: tuple(np.degrees(q) for q in igm(robot, *row)),
            turn=360.0,
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Your left angle is right and your right one is not: what distinguishes the two legs?",
            igm_with_bases(0, -1),
        ),
        Misconception(
            "atan for atan2",
            "Some of your angles are off by half a turn. What does y / x forget?",
            lambda robot, *row: tuple(np.arctan(np.tan(q)) for q in igm(robot, *row)),
        ),
        Misconception(
            "atan for atan2 on the line to the end-effector",
            "Put the end-effector to the left of a base joint: what does y / x forget?",
            lambda robot, x, y, *modes: tuple(
                q - to_end + np.arctan(np.tan(to_end))
                for q, to_end in zip(igm(robot, x, y, *modes), span_angle(robot, x, y))
            ),
        ),
        Misconception(
            "atan2 with x before y",
            "atan2 of a point on the x axis is 0. Try yours on (1, 0).",
            lambda robot, *row: tuple(np.pi / 2 - q for q in igm(robot, *row)),
        ),
        Misconception(
            "direction of the end-effector instead of the elbow",
            "Your angle points from the base joint to the end-effector. Which bar does the motor turn?",
            lambda robot, x, y, gamma1, gamma2: span_angle(robot, x, y),
        ),
        Misconception(
            "M in the middle although the bars of the leg differ",
            "Only an isosceles triangle has the foot of its height in the middle. Which lengths decide where it is?",
            partial(igm_by_root, half_way=True),
        ),
        with_one_length(FiveBar, igm),
    ),
    angles=("q11", "q21"),
)


PASSIVE = Exercise(
    "dgm_passive(q11, q21, assembly_mode) -> q12, q22",
    dgm_passive,
    (
        *wrong_dgm_passive(FiveBar),
        with_one_length(FiveBar, dgm_passive),
        Misconception(
            "passive angles absolute instead of relative",
            "From which line is q12 measured: from the x axis, or from the bar before it?",
            lambda robot, *row: tuple(np.angle(bar) for bar in bars(robot, *row)),
        ),
        Misconception(
            "active angle added instead of subtracted",
            "The distal bar's direction is q11 + q12. Solve that for q12.",
            lambda robot, *row: tuple(np.angle(bar) + q for bar, q in zip(bars(robot, *row), row)),
        ),
        Misconception(
            "sense of rotation reversed",
            "All angles grow counter-clockwise. In which direction do you turn from the proximal to the distal bar?",
            lambda robot, *row: tuple(-q for q in dgm_passive(robot, *row)),
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Your left angle is right and your right one is not: what distinguishes the two legs?",
            partial(dgm_passive, off=lambda robot, *row: (0, -robot.d)),
        ),
        Misconception(
            "lengths of the proximal bars forgotten",
            "You subtract a number without unit from a length in metres.",
            partial(
                dgm_passive,
                off=lambda robot, q11, q21, mode: (
                    (1 - robot.l11) * np.exp(1j * q11),
                    (1 - robot.l21) * np.exp(1j * q21),
                ),
            ),
        ),
    ),
    angles=("q12", "q22"),
)

EXERCISES = stepwise(FiveBar, DGM, IGM, PASSIVE)
USES = {"dgm_passive": ("dgm",)}
