"""Lab 1: the geometric models of the five-bar, right and with the slips that are expected."""

from dataclasses import replace

import numpy as np

from fivebar import FiveBar
from fivebar.grading.models import exercises_on

ROOT = "Can the bars really meet there? Measure them in the pose that you return."
ORIGIN = "Write down the x of both base joints. Where is the origin of the frame?"
UNITS = "Write the unit of each term beside it: all terms of a sum have the same."
LENGTH = "This robot has bars of several lengths. Which of them is it here?"


LEFT, RIGHT = np.eye(2)


def line_by_arctan(s):
    line = s.tip[:, None] - s.base
    return np.abs(line) * np.exp(1j * np.arctan(line.imag / line.real))


SLIPS = {
    "assembly mode never used": (
        "Does your answer change with the assembly mode?",
        {"mode": lambda s: -1},
    ),
    "stops at H": ("How far is your point from either of the elbows?", {"h": lambda s: 0 * s.a}),
    "H taken in the middle, as with equal bars": (
        "Which triangle has H in the middle?",
        {"a": lambda s: np.abs(s.line) / 2},
    ),
    "root of an absolute value": (ROOT, {"root": lambda s: lambda x: np.sqrt(np.abs(x))}),
    "height 0 where the bars do not meet": (
        ROOT,
        {"root": lambda s: lambda x: np.sqrt(np.maximum(x, 0))},
    ),
    "base joint forgotten": (ORIGIN, {"base": lambda s: np.zeros(2)}),
    "origin in the left base joint": (ORIGIN, {"base": lambda s: s.robot.d * RIGHT}),
    "origin in the right base joint": (ORIGIN, {"base": lambda s: -s.robot.d * LEFT}),
    "base joint of the left leg forgotten": (ORIGIN, {"base": lambda s: s.robot.d / 2 * RIGHT}),
    "base joint of the right leg forgotten": (ORIGIN, {"base": lambda s: -s.robot.d / 2 * LEFT}),
    "direction of the end-effector instead of the elbow": (
        "Your angle points from the base joint to the end-effector. Which bar does the motor turn?",
        {"elbow": lambda s: s.reach},
    ),
    "passive angles from the base joints": (
        "Where does the distal bar begin? Draw the vector from there to the end-effector.",
        {"bar": lambda s: s.reach},
    ),
    "length of the proximal bar forgotten": (
        UNITS,
        {"bar": lambda s: s.tip[:, None] - s.base - np.exp(1j * s.q)},
    ),
    "atan for atan2 on the line to the end-effector": (
        "Some of your angles are off by half a turn. What does y / x forget?",
        {"reach": line_by_arctan},
    ),
    "one length for all bars": (
        LENGTH,
        {"robot": lambda robot: replace(robot, l12=robot.l11, l21=robot.l11, l22=robot.l11)},
    ),
    "l12 for l22": (LENGTH, {"robot": lambda robot: replace(robot, l22=robot.l12)}),
}
EXERCISES = exercises_on(FiveBar, "dgm", "igm", "dgm_passive", slips=SLIPS)
USES = {"dgm_passive": ("dgm",)}
