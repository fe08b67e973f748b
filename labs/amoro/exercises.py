"""The five-bar of the AMORO lab: its ten functions, right and with the slips that are expected."""

import numpy as np

from fivebar import FiveBar
from fivebar.grading import ten_models
from fivebar.grading.derivation import product, turned
from fivebar.grading.models import exercises_on

FILE = "five_bar_models.py"
WITH = ("amoro-biglide",)  # whose file comes in the same hand-in
ROBOT = FiveBar(zz1=0.002025, zz2=0.002025)  # as the lab's files have it, 1.0 * 0.045**2
ALSO = (
    {"zz1": 0.002, "zz2": 0.002},
    {"zz1": 0.002025, "zz2": 0.002025},
)  # as its handout has it; right, too
CONSTANTS = {
    "l": ("l11", "l12", "l21", "l22"),
    "d": ("d",),
    "ZZ1R": ("zz1",),
    "ZZ2R": ("zz2",),
    "mR": ("m",),
}
SPEED = "Let the motors run at constant speed: is the end-effector's acceleration 0?"
POWER = "m (A^-1 d) is a force. Which efforts is it worth?"
ENERGY = "xi' = J q'. Write the kinetic energy with q'."
ORIGIN = "Write down the x of both base joints. Where is the origin of the frame?"
SLIPS = {
    "sign of the base joint's x, in the right leg": (
        ORIGIN,
        {"base": lambda s: np.full(2, -s.robot.d / 2)},
    ),
    "origin in the left base joint": (ORIGIN, {"base": lambda s: s.robot.d * np.array([0, 1])}),
    "origin in the right base joint": (ORIGIN, {"base": lambda s: -s.robot.d * np.array([1, 0])}),
    "d forgotten": (SPEED, {"d": lambda s: 0 * s.far}),
    "c forgotten": (SPEED, {"c": lambda s: 0 * s.d}),
    "c = J^T M J d": (POWER, {"c": lambda s: product(turned(s.J) @ s.M @ s.J, s.d)}),
    "J J^T in place of J^T J in M": (ENERGY, {"M": lambda s: s.Z + s.robot.m * s.J @ turned(s.J)}),
    "both inertias added in all of M": (
        ENERGY,
        {"Z": lambda s: np.full((2, 2), sum(s.robot.inertias))},
    ),
}
EXERCISES = exercises_on(FiveBar, *ten_models.TEN, slips=SLIPS)
USES = ten_models.USES
