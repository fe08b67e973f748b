"""Lab 5: tau = M q'' + c and both of its uses, right and with the slips that are expected."""

import numpy as np

from fivebar import FiveBar
from fivebar.grading.derivation import STEPS, product, solved, turned
from fivebar.grading.models import exercises_on

SPEED = "Let the motors run at constant speed: is the end-effector's acceleration 0?"
ENERGY = "xi' = J q'. Write the kinetic energy with q'."
POWER = "m (A^-1 d) is a force. Which efforts is it worth?"


def c_with_J(s):
    return s.robot.m * product(s.J, solved(s.A, s.d))


SLIPS = {
    "c forgotten": (SPEED, {"c": lambda s: 0 * s.d}),
    "c of the wrong sign": ("tau = M q'' + c.", {"c": lambda s: -STEPS["c"](s)}),
    "c without J^T A^-1": (POWER, {"c": lambda s: s.robot.m * s.d}),
    "c without A^-1": (POWER, {"c": lambda s: s.robot.m * product(turned(s.J), s.d)}),
    "c without J^T": (POWER, {"c": lambda s: s.robot.m * solved(s.A, s.d)}),
    "mass forgotten in c": (POWER, {"c": lambda s: STEPS["c"](s) / s.robot.m}),
    "J instead of its transpose": (
        ENERGY,
        {"M": lambda s: s.Z + s.robot.m * s.J @ s.J, "c": c_with_J},
    ),
    "J J^T in place of J^T J in M": (ENERGY, {"M": lambda s: s.Z + s.robot.m * s.J @ turned(s.J)}),
    "only the inertias in M": (ENERGY, {"M": lambda s: s.Z + 0 * s.J}),
    "only the diagonal of M": (ENERGY, {"M": lambda s: STEPS["M"](s) * np.eye(2)}),
    "M not inverted": (
        "tau = M q'' + c: solve it for q''.",
        {"free_accelerations": lambda s: product(s.M, s.tau - s.c)},
    ),
}
EXERCISES = exercises_on(
    FiveBar, "dynamic_model", "inverse_dynamics", "forward_dynamics", slips=SLIPS
)
USES = dict.fromkeys(("inverse_dynamics", "forward_dynamics"), ("dynamic_model",))
