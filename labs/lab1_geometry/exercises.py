"""Lab 1: the right models and the wrong ones that students fall for. Points of the plane are complex numbers."""

from dataclasses import replace
from functools import partial

import numpy as np

from fivebar.grading import Exercise, Misconception
from fivebar.models.dyads import RRR
from fivebar.models.geometry import reach


def elbows(robot, q11, q21):
    return -robot.d / 2 + robot.l11 * np.exp(1j * q11), robot.d / 2 + robot.l21 * np.exp(1j * q21)


def meet(robot, left, right, assembly_mode):
    """The end-effector above these elbows."""
    span = right - left
    x, y = RRR((span.real, span.imag), robot.l12, robot.l22, -assembly_mode).first
    return left + robot.l12 * (x + 1j * y)


def xy(point):
    return point.real, point.imag


def dgm(robot, q11, q21, assembly_mode):
    return xy(meet(robot, *elbows(robot, q11, q21), assembly_mode))


def igm(robot, x, y, gamma1, gamma2):
    left, right = robot.drives
    return reach(left, (x, y), robot.l12, gamma1).q, reach(right, (x, y), robot.l22, gamma2).q


def bars(robot, q11, q21, assembly_mode):
    """The distal bars as complex numbers, from elbow to end-effector."""
    left, right = elbows(robot, q11, q21)
    end = meet(robot, left, right, assembly_mode)
    return end - left, end - right


def dgm_passive(robot, q11, q21, assembly_mode):
    left, right = bars(robot, q11, q21, assembly_mode)
    return np.angle(left) - q11, np.angle(right) - q21


def equal_bars(robot):
    return replace(robot, l12=robot.l11, l21=robot.l11, l22=robot.l11)


def right_base_at_left(robot, q11, q21, assembly_mode):
    left, right = elbows(robot, q11, q21)
    return xy(meet(robot, left, right - robot.d, assembly_mode))


def bases_at_d(robot, q11, q21, assembly_mode):
    left, right = elbows(robot, q11, q21)
    return xy(meet(robot, left - robot.d / 2, right + robot.d / 2, assembly_mode))


def foot(robot, span):
    """Distance of H from the right elbow, the elbows being `span` apart."""
    return (span**2 + robot.l22**2 - robot.l12**2) / (2 * span)


def over_h(robot, q11, q21, assembly_mode, foot=foot, root=np.sqrt, normal=lambda along, to_h: 1j * along):
    """AMORO eq. 1-3, by way of H."""
    left, right = elbows(robot, q11, q21)
    span = np.abs(left - right)
    along = (left - right) / span
    to_h = foot(robot, span) * along
    return xy(right + to_h + assembly_mode * root(robot.l22**2 - np.abs(to_h) ** 2) * normal(along, to_h))


def half(robot, span):
    return span / 2


def root_of_absolute(square):
    return np.sqrt(np.abs(square))


def root_or_0(square):
    return np.sqrt(np.maximum(square, 0))


DGM = Exercise(
    "dgm(q11, q21, assembly_mode) -> x, y",
    dgm,
    (
        Misconception(
            "other assembly mode",
            "Two points are at the right distance from both elbows. Which one has assembly mode -1 at q11 = q21 = 0?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            "Your answer does not change with assembly_mode. Where does the choice between the two points enter?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -1),
        ),
        Misconception(
            "angles taken as degrees",
            "What is the unit of q11 here, and which one do sin and cos expect?",
            lambda robot, q11, q21, mode: dgm(robot, np.radians(q11), np.radians(q21), mode),
        ),
        Misconception(
            "legs exchanged",
            "Turn q11 alone: which elbow should move, and which one moves in your model?",
            lambda robot, q11, q21, mode: dgm(robot, q21, q11, mode),
        ),
        Misconception(
            "origin in the left base joint",
            "Where is the origin of the frame? Look at the x of A11 in the figure.",
            lambda robot, *row: (dgm(robot, *row)[0] + robot.d / 2, dgm(robot, *row)[1]),
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Print your elbow A22 at q21 = 0 and find it in the figure.",
            right_base_at_left,
        ),
        Misconception("base joints at -d and d", "How far apart are your two base joints, and what is d?", bases_at_d),
        Misconception(
            "stops at H",
            "Your point is in the middle of the elbows. How far is it from either of them, and how far should it be?",
            lambda robot, *row: over_h(robot, *row, root=np.zeros_like),
        ),
        Misconception(
            "direction not of unit length",
            "A direction times h has length h only if the direction has length 1.",
            lambda robot, *row: over_h(robot, *row, normal=lambda along, to_h: 1j * to_h),
        ),
        Misconception(
            "root of an absolute value",
            "What does a negative number under the root say about the two elbows? abs() only hides it.",
            lambda robot, *row: over_h(robot, *row, root=root_of_absolute),
        ),
        Misconception(
            "height 0 where the bars do not meet",
            "Can the two distal bars really meet there? Measure them in the pose that you return.",
            lambda robot, *row: over_h(robot, *row, root=root_or_0),
        ),
        Misconception(
            "H in the middle although the distal bars differ",
            "Only an isosceles triangle has the foot of its height in the middle. Which lengths decide where it is?",
            lambda robot, *row: over_h(robot, *row, foot=half),
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
            lambda robot, *row: over_h(robot, *row, foot=lambda robot, span: span - foot(robot, span)),
        ),
        Misconception(
            "one length for all bars",
            "This robot has bars of four lengths. Which of your l is which?",
            lambda robot, *row: dgm(equal_bars(robot), *row),
        ),
    ),
)


def shifted(robot, x, y, gamma1, gamma2, left, right):
    """The inverse model with the base joints moved by these distances."""
    return igm(robot, x - left, y, gamma1, gamma2)[0], igm(robot, x - right, y, gamma1, gamma2)[1]


def span_angle(robot, x, y):
    return np.arctan2(y, x + robot.d / 2), np.arctan2(y, x - robot.d / 2)


def over_m(robot, x, y, gamma1, gamma2, half_way=False, root=np.sqrt):
    """AMORO eq. 7-9, by way of M, the foot of the elbow on the line from base joint to end-effector."""
    found = []
    for drive, bar, gamma in zip(robot.drives, robot.distal, (gamma1, gamma2)):
        line = x + 1j * y - drive.x
        span = np.abs(line)
        along = span / 2 if half_way else (span**2 + drive.length**2 - bar**2) / (2 * span)
        found.append(np.angle((along + 1j * gamma * root(drive.length**2 - along**2)) * line))
    return tuple(found)


IGM = Exercise(
    "igm(x, y, gamma1, gamma2) -> q11, q21",
    igm,
    (
        Misconception(
            "other working modes",
            "Which elbow is on which side of the line from its base joint to the end-effector when gamma = -1?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -gamma1, -gamma2),
        ),
        Misconception(
            "working modes swapped",
            "gamma1 belongs to the left leg. Change it alone: which of your angles changes?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, gamma2, gamma1),
        ),
        Misconception(
            "working modes never used",
            "Your answers do not change with gamma1 and gamma2. A circle meets a circle in how many points?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -1, -1),
        ),
        Misconception(
            "legs exchanged",
            "Each leg has the other one's angle. Look at the order of the two, and at the signs of d / 2.",
            lambda robot, *row: igm(robot, *row)[::-1],
        ),
        Misconception(
            "angles returned in degrees",
            "Which unit do motors and sin use here?",
            lambda robot, *row: tuple(np.degrees(q) for q in igm(robot, *row)),
            turn=360.0,
        ),
        Misconception(
            "base offset forgotten",
            "From which point do you draw the vector to the end-effector, and where does the leg begin?",
            lambda robot, *row: shifted(robot, *row, robot.d / 2, -robot.d / 2),
        ),
        Misconception(
            "base offset subtracted twice",
            "Write down the x of A11 and of A21. Does each of them enter your vectors once?",
            lambda robot, *row: shifted(robot, *row, -robot.d / 2, robot.d / 2),
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Your left angle is right and your right one is not: what distinguishes the two legs?",
            lambda robot, *row: shifted(robot, *row, 0, -robot.d),
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
            "root of an absolute value",
            "What does a negative number under the root say about the distance? abs() only hides it.",
            lambda robot, *row: over_m(robot, *row, root=root_of_absolute),
        ),
        Misconception(
            "leg stretched towards what it cannot reach",
            "Can the leg really end there? Measure its bars in the pose that you return.",
            lambda robot, *row: over_m(robot, *row, root=root_or_0),
        ),
        Misconception(
            "M in the middle although the bars of the leg differ",
            "Only an isosceles triangle has the foot of its height in the middle. Which lengths decide where it is?",
            lambda robot, *row: over_m(robot, *row, half_way=True),
        ),
        Misconception(
            "one length for all bars",
            "This robot has bars of four lengths. Which of your l is which?",
            lambda robot, *row: igm(equal_bars(robot), *row),
        ),
    ),
    angles=("q11", "q21"),
)


def absolute(robot, *row):
    return tuple(np.angle(bar) for bar in bars(robot, *row))


def atan_passive(robot, q11, q21, assembly_mode):
    left, right = bars(robot, q11, q21, assembly_mode)
    return np.arctan(left.imag / left.real) - q11, np.arctan(right.imag / right.real) - q21


def bars_from(robot, q11, q21, assembly_mode, left, right):
    """Passive angles if the elbows were off by these complex numbers."""
    true = bars(robot, q11, q21, assembly_mode)
    return np.angle(true[0] - left) - q11, np.angle(true[1] - right) - q21


PASSIVE = Exercise(
    "dgm_passive(q11, q21, assembly_mode) -> q12, q22",
    dgm_passive,
    (
        Misconception(
            "passive angles absolute instead of relative",
            "From which line is q12 measured: from the x axis, or from the bar before it?",
            absolute,
        ),
        Misconception(
            "active angle added instead of subtracted",
            "The distal bar's direction is q11 + q12. Solve that for q12.",
            lambda robot, q11, q21, mode: tuple(phi + q for phi, q in zip(absolute(robot, q11, q21, mode), (q11, q21))),
        ),
        Misconception(
            "sense of rotation reversed",
            "All angles grow counter-clockwise. In which direction do you turn from the proximal to the distal bar?",
            lambda robot, *row: tuple(-q for q in dgm_passive(robot, *row)),
        ),
        Misconception(
            "other assembly mode",
            "Check the end-effector first: is it the point that your dgm gives for this assembly mode?",
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            "Your answer does not change with assembly_mode.",
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -1),
        ),
        Misconception(
            "atan for atan2",
            "Some of your angles are off by half a turn. What does y / x forget?",
            atan_passive,
        ),
        Misconception(
            "distal bar read from end-effector to elbow",
            "Your angles are off by half a turn everywhere: from which end to which do you read the bar?",
            lambda robot, *row: tuple(q + np.pi for q in dgm_passive(robot, *row)),
        ),
        Misconception(
            "base offset forgotten",
            "The elbow is the base joint plus a bar. Where is the base joint in your difference?",
            lambda robot, *row: bars_from(robot, *row, robot.d / 2, -robot.d / 2),
        ),
        Misconception(
            "the left arm's offset used for the right arm",
            "Your left angle is right and your right one is not: what distinguishes the two legs?",
            lambda robot, *row: bars_from(robot, *row, 0, -robot.d),
        ),
        Misconception(
            "lengths of the proximal bars forgotten",
            "You subtract a number without unit from a length in metres.",
            lambda robot, q11, q21, mode: bars_from(
                robot, q11, q21, mode, (1 - robot.l11) * np.exp(1j * q11), (1 - robot.l21) * np.exp(1j * q21)
            ),
        ),
        Misconception(
            "legs exchanged",
            "In which order does the signature ask for the two angles?",
            lambda robot, *row: dgm_passive(robot, *row)[::-1],
        ),
        Misconception(
            "angles returned in degrees",
            "Which unit do the other functions of this lab use?",
            lambda robot, *row: tuple(np.degrees(q) for q in dgm_passive(robot, *row)),
            turn=360.0,
        ),
        Misconception(
            "one length for all bars",
            "This robot has bars of four lengths. Which of your l is which?",
            lambda robot, *row: dgm_passive(equal_bars(robot), *row),
        ),
    ),
    angles=("q12", "q22"),
)

EXERCISES = [DGM, IGM, PASSIVE]
