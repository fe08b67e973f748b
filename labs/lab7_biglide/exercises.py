"""Lab 7: the ten models of the biglide, and the efforts of a motion, right and wrong."""

from dataclasses import replace
from functools import partial

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import times
from fivebar.grading.derivation import STEPS, inverse, product, turned
from fivebar.grading.models import exercises_on
from fivebar.grading.ten_models import TEN

ROBOT = fb.Biglide()  # the handout's


def efforts(
    robot, x, y, xD, yD, xDD, yDD, gamma1, gamma2, speed=1.0, bias=1.0, mass=1.0, raw=False
):
    """Factors: speed, of xi' for q''; bias, of c; mass, of M; raw: xi'' in place of q''."""
    pose = fb.igm(robot, np.stack([x, y], -1), np.stack([gamma1, gamma2], -1))
    xi_dot, xi_ddot = np.stack([xD, yD], -1), np.stack([xDD, yDD], -1)
    M, c = fb.dynamic_model(fb.ikm(pose, xi_dot))
    q_ddot = xi_ddot if raw else fb.ikm2(fb.ikm(pose, speed * xi_dot), xi_ddot).q_ddot
    return tuple(mass * np.array(times(M, *q_ddot.T)) + bias * c.T)


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
            "M q'' forgotten",
            "Which efforts does a motion need whose feet accelerate?",
            partial(efforts, mass=0.0),
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

ENERGY = "xi' = J q'. Write the kinetic energy with q'."
ROOT = "Can the bars really meet there? Measure them in the pose that you return."
SLIPS = {
    "x and y exchanged": (
        "In which order does the task ask for x and y?",
        {"tip": lambda s: 1j * np.conj(STEPS["tip"](s))},
    ),
    "stops at H": ("How far is your point from either of the feet?", {"h": lambda s: 0 * s.a}),
    "share of the feet forgotten": (
        "Let the end-effector rest: do the bars turn?",
        {"of_pivot": lambda s: 0 * s.rates},
    ),
    "root of an absolute value": (ROOT, {"root": lambda s: lambda x: np.sqrt(np.abs(x))}),
    "height 0 where the bars do not meet": (
        ROOT,
        {"root": lambda s: lambda x: np.sqrt(np.maximum(x, 0))},
    ),
    "matrices in the wrong order": (
        "Solve A xi' = B q' for what you look for: which matrix is on the other side?",
        {"J": lambda s: s.B @ inverse(s.A), "J_inverse": lambda s: s.A @ inverse(s.B)},
    ),
    "only the inertias in M": (ENERGY, {"M": lambda s: s.Z + 0 * s.J}),
    "both inertias added in all of M": (
        ENERGY,
        {"Z": lambda s: np.full((2, 2), sum(s.robot.inertias))},
    ),
    "feet's masses moved with the end-effector": (
        "Which of these masses move along x, too?",
        {"robot": lambda robot: replace(robot, m=robot.m + sum(robot.inertias), mf1=0.0, mf2=0.0)},
    ),
    "masses of feet and end-effector exchanged": (
        ENERGY,
        {"robot": lambda robot: replace(robot, mf1=robot.m, mf2=robot.m, m=robot.mf1)},
    ),
    "c without A^-1": (
        "m (A^-1 d) is a force. Which efforts is it worth?",
        {"c": lambda s: s.robot.m * product(turned(s.J), s.d)},
    ),
}
EXERCISES = [*exercises_on(fb.Biglide, *TEN, slips=SLIPS), EFFORTS]
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
