"""Lab 7: the ten models of the biglide, and the efforts of a motion, right and wrong."""

from dataclasses import replace
from functools import partial

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import times
from fivebar.grading.models import exercises_on
from fivebar.grading.ten_models import TEN

ROBOT = fb.Biglide()  # the handout's


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
        Misconception(
            "c forgotten",
            "At constant speed of the feet the end-effector still accelerates. Which effort does that need?",
            partial(efforts, bias=0.0),
        ),
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
        Misconception(
            "legs exchanged",
            "The left leg comes first, in the arguments and in what you return.",
            lambda robot, *row: efforts(robot, *row)[::-1],
        ),
    ),
)

EXERCISES = [*exercises_on(fb.Biglide, *TEN), EFFORTS]
USES = {
    "dgm_passive": ("dgm",),
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
    ),
}
