"""Lab 7: the ten models of the biglide and the efforts of a motion, right and wrong. Points are complex numbers."""

from dataclasses import replace
from functools import partial

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.four_joints import inverse, motion, pose, times
from fivebar.models.dyads import RRR
from fivebar.models.kinematics import Accelerations, Rates

ROBOT = fb.Biglide()  # the handout's

FOUR, RATES = "q11, q12, q21, q22", "q11D, q12D, q21D, q22D"


def legs_exchanged(model, returned):
    return Misconception(
        "legs exchanged",
        f"The left leg comes first, in the arguments and in {returned}. Move one foot alone: what changes?",
        lambda robot, *row: model(robot, *row)[::-1],
    )


def feet(robot, q11, q21):
    return -robot.d / 2 + 1j * q11, robot.d / 2 + 1j * q21


def meet(robot, left, right, assembly_mode):
    """The end-effector on these feet."""
    span = right - left
    x, y = RRR((span.real, span.imag), robot.l1, robot.l2, -assembly_mode).first
    return left + robot.l1 * (x + 1j * y)


def dgm(robot, q11, q21, assembly_mode):
    point = meet(robot, *feet(robot, q11, q21), assembly_mode)
    return point.real, point.imag


def over_h(robot, q11, q21, assembly_mode, in_middle=False, root=np.sqrt):
    """AMORO eq. 1-3 by way of H, the foot of the end-effector on the line of the robot's feet."""
    left, right = feet(robot, q11, q21)
    span = np.abs(left - right)
    along = span / 2 if in_middle else (span**2 + robot.l2**2 - robot.l1**2) / (2 * span)
    point = right + (along + 1j * assembly_mode * root(robot.l2**2 - along**2)) * (left - right) / span
    return point.real, point.imag


def lying(robot, q11, q21, assembly_mode):
    """Of who lets the feet slide along x, on guides one above the other."""
    return dgm(robot, q11, q21, assembly_mode)[::-1]


def root_of_absolute(square):
    return np.sqrt(np.abs(square))


def root_or_0(square):
    return np.sqrt(np.maximum(square, 0))


def one_bar(robot):
    return replace(robot, l2=robot.l1)


def guides_at_d(robot, q11, q21, assembly_mode):
    left, right = feet(robot, q11, q21)
    point = meet(robot, left - robot.d / 2, right + robot.d / 2, assembly_mode)
    return point.real, point.imag


def guides_at_0_and_d(robot, *row):
    x, y = dgm(robot, *row)
    return x + robot.d / 2, y


DGM = Exercise(
    "dgm(q11, q21, assembly_mode) -> x, y",
    dgm,
    (
        Misconception(
            "other assembly mode",
            "Two points are at the right distance from both feet. Which one has assembly mode -1 at q11 = q21 = 0?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            "Your answer does not change with assembly_mode. Where does the choice between the two points enter?",
            lambda robot, q11, q21, mode: dgm(robot, q11, q21, -1),
        ),
        Misconception(
            "legs exchanged",
            "Slide the left foot alone: which one slides in your model?",
            lambda robot, q11, q21, mode: dgm(robot, q21, q11, mode),
        ),
        Misconception(
            "feet slide the other way",
            "Which way does a foot move when its coordinate grows?",
            lambda robot, q11, q21, mode: dgm(robot, -q11, -q21, mode),
        ),
        Misconception(
            "horizontal guides instead of vertical ones",
            "Along which axis do the feet slide in the figure, and which of your feet's coordinates holds q?",
            lying,
        ),
        Misconception(
            "origin on the left guide",
            "Where is the origin of the frame? Look at the x of the left foot in the figure.",
            guides_at_0_and_d,
        ),
        Misconception("guides at -d and d", "How far apart are your two guides, and what is d?", guides_at_d),
        Misconception(
            "stops at H",
            "Your point is on the line of the feet. How far is it from either of them, and how long are the bars?",
            partial(over_h, root=np.zeros_like),
        ),
        Misconception(
            "root of an absolute value",
            "What does a negative number under the root say about the two feet? abs() only hides it.",
            partial(over_h, root=root_of_absolute),
        ),
        Misconception(
            "height 0 where the bars do not meet",
            "Can the two bars really meet there? Measure them in the pose that you return.",
            partial(over_h, root=root_or_0),
        ),
        Misconception(
            "H in the middle although the bars differ",
            "Only an isosceles triangle has the foot of its height in the middle. Which lengths decide where it is?",
            partial(over_h, in_middle=True),
        ),
        Misconception(
            "one length for both bars",
            "This robot has two bars of different lengths. Which of them stands where?",
            lambda robot, *row: dgm(one_bar(robot), *row),
        ),
    ),
)


def igm(robot, x, y, gamma1, gamma2, root=np.sqrt, at=0.5):
    with np.errstate(invalid="ignore"):
        rise1, rise2 = root(robot.l1**2 - (x + at * robot.d) ** 2), root(robot.l2**2 - (x - at * robot.d) ** 2)
    return y + gamma1 * rise1, y + gamma2 * rise2


IGM = Exercise(
    "igm(x, y, gamma1, gamma2) -> q11, q21",
    igm,
    (
        Misconception(
            "other working modes",
            "At home both working modes are -1. Is a foot below the end-effector there, or above it?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -gamma1, -gamma2),
        ),
        Misconception(
            "working modes swapped",
            "gamma1 belongs to the left leg. Change it alone: which of your feet moves?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, gamma2, gamma1),
        ),
        Misconception(
            "working modes never used",
            "Your answers do not change with gamma1 and gamma2. A circle meets a line in how many points?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, y, -1, -1),
        ),
        Misconception(
            "d instead of d/2",
            "How far from the y axis is a guide? Both together make d.",
            partial(igm, at=1.0),
        ),
        Misconception(
            "guide's x with the wrong sign",
            "The left guide is at x = -d/2. How far in x is it from the end-effector to that guide?",
            partial(igm, at=-0.5),
        ),
        Misconception(
            "guides forgotten",
            "From which point do you measure the end-effector's x, and where does the foot slide?",
            partial(igm, at=0.0),
        ),
        Misconception(
            "height of the end-effector forgotten",
            "Lift the robot by 0.1 m: how do the feet move, and what do your answers do?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, 0 * y, gamma1, gamma2),
        ),
        Misconception(
            "height of the end-effector with the wrong sign",
            "Lift the robot by 0.1 m: which way do the feet move, and which way do yours?",
            lambda robot, x, y, gamma1, gamma2: igm(robot, x, -y, gamma1, gamma2),
        ),
        Misconception(
            "horizontal guides instead of vertical ones",
            "Along which axis do the feet slide in the figure? The other coordinate of a foot never changes.",
            lambda robot, x, y, gamma1, gamma2: igm(robot, y, x, gamma1, gamma2),
        ),
        legs_exchanged(igm, "what you return"),
        Misconception(
            "root of an absolute value",
            "What does a negative number under the root say about the distance? abs() only hides it.",
            partial(igm, root=root_of_absolute),
        ),
        Misconception(
            "bar laid across towards a guide that it cannot reach",
            "Can the bar really end there? Measure it in the pose that you return.",
            partial(igm, root=root_or_0),
        ),
        Misconception(
            "one length for both bars",
            "This robot has two bars of different lengths. Which of them stands where?",
            lambda robot, *row: igm(one_bar(robot), *row),
        ),
    ),
)


def bars(robot, q11, q21, assembly_mode):
    """The bars as complex numbers, from foot to end-effector."""
    left, right = feet(robot, q11, q21)
    end = meet(robot, left, right, assembly_mode)
    return end - left, end - right


def dgm_passive(robot, *row, read=np.angle):
    return tuple(read(bar) for bar in bars(robot, *row))


def in_the_middle(robot, q11, q21, assembly_mode):
    left, right = feet(robot, q11, q21)
    x, y = over_h(robot, q11, q21, assembly_mode, in_middle=True)
    return np.angle(x + 1j * y - left), np.angle(x + 1j * y - right)


def from_origin(robot, q11, q21, assembly_mode):
    left, right = bars(robot, q11, q21, assembly_mode)
    return np.angle(left - robot.d / 2), np.angle(right + robot.d / 2)


DGM_PASSIVE = Exercise(
    "dgm_passive(q11, q21, assembly_mode) -> q12, q22",
    dgm_passive,
    (
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
            "atan for atan2",
            "Some of your angles are off by half a turn. What does y / x forget?",
            partial(dgm_passive, read=lambda bar: np.arctan(bar.imag / bar.real)),
        ),
        Misconception(
            "right bar's angle taken inwards",
            "Both angles grow counter-clockwise from the same direction. Is that so for your right bar at home?",
            lambda robot, *row: (dgm_passive(robot, *row)[0], np.pi - dgm_passive(robot, *row)[1]),
        ),
        Misconception(
            "bar read from end-effector to foot",
            "Which end of the bar is its beginning? At home both bars point up.",
            partial(dgm_passive, read=lambda bar: np.angle(-bar)),
        ),
        Misconception(
            "other assembly mode",
            "Does your dgm get the assembly mode as it came?",
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -mode),
        ),
        Misconception(
            "assembly mode never used",
            "Your answers do not change with assembly_mode. For which mode are they right?",
            lambda robot, q11, q21, mode: dgm_passive(robot, q11, q21, -1),
        ),
        Misconception(
            "guides forgotten",
            "Where does a bar begin? The x of a foot is not 0.",
            from_origin,
        ),
        Misconception(
            "H in the middle although the bars differ",
            "Your angles follow from your end-effector: first see to dgm with two different bars.",
            in_the_middle,
        ),
        legs_exchanged(dgm_passive, "what you return"),
        Misconception(
            "angles returned in degrees",
            "Which unit do sin and cos expect in the next tasks?",
            partial(dgm_passive, read=lambda bar: np.degrees(np.angle(bar))),
        ),
    ),
    angles=("q12", "q22"),
)


def relative_angles(model):
    """The misconception of who adds the feet's coordinates to the angles, as in the five-bar."""
    return Misconception(
        "passive angles taken as relative",
        "q11 is in metres here, q12 in radians. Which angle does the bar make with the x axis?",
        lambda robot, q11, q12, q21, q22, *row: model(robot, q11, q11 + q12, q21, q21 + q22, *row),
    )


def A(robot, *q):
    return pose(robot, *q).A


def B(robot, *q):
    return pose(robot, *q).B


def cosines(robot, *q):
    """B of who takes the bars' components along x."""
    return B(robot, q[0], q[1] + np.pi / 2, q[2], q[3] + np.pi / 2)


def dkm(robot, q11, q12, q21, q22, q11D, q21D):
    q = q11, q12, q21, q22
    return times(inverse(A(robot, *q)) @ B(robot, *q), q11D, q21D)


def ikm(robot, q11, q12, q21, q22, xD, yD):
    q = q11, q12, q21, q22
    return times(inverse(B(robot, *q)) @ A(robot, *q), xD, yD)


def with_matrices(name, change, text):
    """A wrong model of dkm or ikm: change(robot, A, B, q) in place of its matrix."""

    def model(robot, *row):
        q = row[:4]
        return times(change(robot, A(robot, *q), B(robot, *q), q), *row[4:])

    return Misconception(name, text, model)


def diagonal(robot):
    return np.diag(robot.distal)


DKM = Exercise(
    f"dkm({FOUR}, q11D, q21D) -> xD, yD",
    dkm,
    (
        relative_angles(dkm),
        with_matrices(
            "sine and cosine exchanged in B",
            lambda robot, A, B, q: inverse(A) @ cosines(robot, *q),
            "A foot moves along y. Which component of the bar's direction does u . (0, 1) pick?",
        ),
        with_matrices(
            "sine and cosine exchanged in A",
            lambda robot, A, B, q: inverse(A[:, :, ::-1]) @ B,
            "A bar at angle 0 points along x: what does your row of A say?",
        ),
        with_matrices(
            "length of the bars in B",
            lambda robot, A, B, q: inverse(A) @ diagonal(robot) @ B,
            "q' and xi' are both in m/s. Which unit must B have?",
        ),
        with_matrices("A and B exchanged", lambda robot, A, B, q: inverse(B) @ A, "Solve A xi' = B q' for xi'."),
        with_matrices(
            "A transposed",
            lambda robot, A, B, q: inverse(A).swapaxes(1, 2) @ B,
            "Each scalar product with xi' is one row of A xi'.",
        ),
        with_matrices(
            "A not inverted", lambda robot, A, B, q: A @ B, "A stands beside xi'. What brings it to the other side?"
        ),
        with_matrices(
            "matrices in the wrong order",
            lambda robot, A, B, q: B @ inverse(A),
            "Matrices do not commute: which of them must act on q' first?",
        ),
        with_matrices(
            "feet taken to move the other way",
            lambda robot, A, B, q: -inverse(A) @ B,
            "Both feet go up at 1 m/s: which way does the end-effector go?",
        ),
        with_matrices(
            "legs exchanged in B",
            lambda robot, A, B, q: inverse(A) @ B[:, ::-1, ::-1],
            "The first row of A belongs to the left leg, so that of B, too.",
        ),
    ),
)

IKM = Exercise(
    f"ikm({FOUR}, xD, yD) -> q11D, q21D",
    ikm,
    (
        relative_angles(ikm),
        with_matrices(
            "sine and cosine exchanged in B",
            lambda robot, A, B, q: inverse(cosines(robot, *q)) @ A,
            "A foot moves along y. Which component of the bar's direction does u . (0, 1) pick?",
        ),
        with_matrices(
            "sine and cosine exchanged in A",
            lambda robot, A, B, q: inverse(B) @ A[:, :, ::-1],
            "A bar at angle 0 points along x: what does your row of A say?",
        ),
        with_matrices(
            "length of the bars in B",
            lambda robot, A, B, q: inverse(diagonal(robot) @ B) @ A,
            "q' and xi' are both in m/s. Which unit must B have?",
        ),
        with_matrices("A and B exchanged", lambda robot, A, B, q: inverse(A) @ B, "Solve A xi' = B q' for q'."),
        with_matrices(
            "B not inverted", lambda robot, A, B, q: B @ A, "B stands beside q'. What brings it to the other side?"
        ),
        with_matrices(
            "A transposed",
            lambda robot, A, B, q: inverse(B) @ A.swapaxes(1, 2),
            "Each scalar product with xi' is one row of A xi'.",
        ),
        with_matrices(
            "feet taken to move the other way",
            lambda robot, A, B, q: -inverse(B) @ A,
            "Lift the end-effector straight up: which way do the feet go?",
        ),
        legs_exchanged(ikm, "what you return"),
    ),
)


def dkm_passive(robot, q11, q12, q21, q22, q11D, q21D, xD, yD):
    return tuple(Rates(pose(robot, q11, q12, q21, q22), (q11D, q21D), (xD, yD)).q_passive_dot.T)


def scaled(model, factor, own=0, signs=1):
    """A wrong model of rates or accelerations: the bars' own times factor(robot), `own` of the feet's added."""

    def other(robot, *row):
        q = row[8:10] if len(row) == 12 else row[4:6]
        parts = zip(model(robot, *row), factor(robot), q)
        return tuple(signs * phi * by + own * foot for phi, by, foot in parts)

    return other


def ones(robot):
    return 1.0, 1.0


def foot_standing(robot, *row):
    return dkm_passive(robot, *row[:4], 0 * row[4], 0 * row[5], *row[6:])


DKM_PASSIVE = Exercise(
    f"dkm_passive({FOUR}, q11D, q21D, xD, yD) -> q12D, q22D",
    dkm_passive,
    (
        relative_angles(dkm_passive),
        Misconception(
            "foot taken as standing still",
            "xi' is the foot's velocity and the bar's rotation together. Did you take the foot's part away?",
            foot_standing,
        ),
        Misconception(
            "foot's velocity added instead of subtracted",
            "xi' = foot's velocity + l phi' v. Solve that for phi'.",
            lambda robot, *row: dkm_passive(robot, *row[:4], -row[4], -row[5], *row[6:]),
        ),
        Misconception(
            "foot's velocity not projected",
            "A foot moves along y, the bar's end along v. Which part of the foot's velocity lies along v?",
            lambda robot, *row: tuple(
                part - q / bar for part, q, bar in zip(foot_standing(robot, *row), row[4:6], robot.distal)
            ),
        ),
        Misconception(
            "length of the bar forgotten",
            "A velocity in m/s is not a rate in rad/s. Which length lies between them?",
            scaled(dkm_passive, lambda robot: robot.distal),
        ),
        Misconception(
            "one length for both bars",
            "This robot has two bars of different lengths. Which of them turns how fast?",
            lambda robot, *row: dkm_passive(one_bar(robot), *row),
        ),
        Misconception(
            "foot's speed subtracted as in the five-bar",
            "A foot does not turn: is there anything between the bar's own rate and what is asked?",
            scaled(dkm_passive, ones, own=-1),
        ),
        Misconception(
            "+90 degrees turned the other way",
            "Turn (1, 0) by +90 degrees, counter-clockwise. Is it (0, 1) or (0, -1)?",
            scaled(dkm_passive, ones, signs=-1),
        ),
        legs_exchanged(dkm_passive, "what you return"),
    ),
)


def parts(robot, *row):
    """A, B and d of a motion, arrays (n, 2, 2) and (n, 2)."""
    rates = motion(robot, *row)
    return rates.pose.A, rates.pose.B, rates.d


def dkm2(robot, *row, parts=parts):
    A, B, d = parts(robot, *row[:8])
    return times(inverse(A), *(times(B, *row[8:]) + d.T))


def ikm2(robot, *row, parts=parts):
    A, B, d = parts(robot, *row[:8])
    return times(inverse(B), *(times(A, *row[8:]) - d.T))


def with_d(name, d, hint):
    """The misconception of another d(robot, *row) -> (n, 2) in both models, a pair."""

    def other(robot, *row):
        A, B, _ = parts(robot, *row)
        return A, B, d(robot, *row)

    return [Misconception(name, hint, partial(model, parts=other)) for model in (dkm2, ikm2)]


def d_of(robot, *row):
    return parts(robot, *row)[2]


def cosine_in_b(robot, *row):
    A, _, d = parts(robot, *row)
    return A, cosines(robot, *row[:4]), d


BIAS = [
    with_d(
        "centripetal term missing",
        lambda robot, *row: 0 * d_of(robot, *row),
        "Let the feet run at constant speed: is the end-effector's acceleration 0?",
    ),
    with_d(
        "centripetal term of the wrong sign",
        lambda robot, *row: -d_of(robot, *row),
        "The derivative of v is -u phi'. To which side does that term go?",
    ),
    with_d(
        "rate not squared",
        lambda robot, *row: np.stack([-robot.l1 * row[5], -robot.l2 * row[7]], -1),
        "d is an acceleration in m/s^2. Which unit does l phi' have?",
    ),
    with_d(
        "length forgotten in d",
        lambda robot, *row: d_of(robot, *row) / np.array(robot.distal),
        "d is an acceleration in m/s^2. Which unit does phi'^2 have?",
    ),
    with_d(
        "foot's speed in place of the bar's rate",
        lambda robot, *row: np.stack([-robot.l1 * row[4] ** 2, -robot.l2 * row[6] ** 2], -1),
        "A foot moves in a straight line. What is it that turns?",
    ),
    with_d(
        "sum of both rates as in the five-bar",
        lambda robot, *row: np.stack([-robot.l1 * (row[4] + row[5]) ** 2, -robot.l2 * (row[6] + row[7]) ** 2], -1),
        "q11' is in m/s, q12' in rad/s. How fast does the bar turn against the fixed frame?",
    ),
    with_d(
        "one length for both bars",
        lambda robot, *row: d_of(one_bar(robot), *row),
        "This robot has two bars of different lengths. Which of them stands in which row of d?",
    ),
    [
        Misconception(
            "sine and cosine exchanged in B",
            "A foot moves along y. Which component of the bar's direction does u . (0, 1) pick?",
            partial(model, parts=cosine_in_b),
        )
        for model in (dkm2, ikm2)
    ],
]

DKM2 = Exercise(
    f"dkm2({FOUR}, {RATES}, q11DD, q21DD) -> xDD, yDD",
    dkm2,
    (relative_angles(dkm2), *(direct for direct, _ in BIAS)),
)

IKM2 = Exercise(
    f"ikm2({FOUR}, {RATES}, xDD, yDD) -> q11DD, q21DD",
    ikm2,
    (relative_angles(ikm2), *(inverse_one for _, inverse_one in BIAS), legs_exchanged(ikm2, "what you return")),
)


def dkm2_passive(robot, *row):
    return tuple(Accelerations(motion(robot, *row[:8]), row[8:10], row[10:]).q_passive_ddot.T)


DKM2_PASSIVE = Exercise(
    f"dkm2_passive({FOUR}, {RATES}, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD",
    dkm2_passive,
    (
        relative_angles(dkm2_passive),
        Misconception(
            "centripetal term kept",
            "You multiply by v. What is left there of a vector along u?",
            lambda robot, *row: tuple(
                phi + rate**2 for phi, rate in zip(dkm2_passive(robot, *row), (row[5], row[7]))
            ),
        ),
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
        Misconception(
            "length of the bar forgotten",
            "An acceleration in m/s^2 is not one in rad/s^2. Which length lies between them?",
            scaled(dkm2_passive, lambda robot: robot.distal),
        ),
        Misconception(
            "one length for both bars",
            "This robot has two bars of different lengths. Which of them stands where?",
            lambda robot, *row: dkm2_passive(one_bar(robot), *row),
        ),
        Misconception(
            "foot's acceleration subtracted as in the five-bar",
            "A foot does not turn: is there anything between the bar's own acceleration and what is asked?",
            scaled(dkm2_passive, ones, own=-1),
        ),
        legs_exchanged(dkm2_passive, "what you return"),
    ),
)  # fmt: skip


def dynamic_model(robot, *row):
    return fb.dynamic_model(motion(robot, *row))


def with_model(name, change, hint):
    """A wrong M and c: change(Z, m, A, B, d) -> M, c as a column."""

    def model(robot, *row):
        A, B, d = parts(robot, *row)
        M, c = change(np.diag(robot.inertias), robot.m, A, B, d[..., None])
        return np.broadcast_to(M, (len(row[0]), 2, 2)), c[..., 0]

    return Misconception(name, hint, model)


def of_another(change):
    return lambda robot, *row: dynamic_model(change(robot), *row)


def turned(matrix):
    return matrix.swapaxes(-1, -2)


def M_of(Z, m, A, B, d):
    J = inverse(A) @ B
    return Z + m * turned(J) @ J


def c_of(Z, m, A, B, d):
    return m * turned(inverse(A) @ B) @ inverse(A) @ d


DYNAMIC_MODEL = Exercise(
    f"dynamic_model({FOUR}, {RATES}) -> M, c",
    dynamic_model,
    (
        relative_angles(dynamic_model),
        with_model(
            "feet's masses forgotten",
            lambda Z, *rest: (M_of(0 * Z, *rest), c_of(Z, *rest)),
            "Take the end-effector's mass away: is there nothing left to accelerate?",
        ),
        with_model(
            "end-effector's mass forgotten in M",
            lambda Z, m, *rest: (Z, c_of(Z, m, *rest)),
            "Take the feet's masses away: is there nothing left to accelerate?",
        ),
        Misconception(
            "masses of feet and end-effector exchanged",
            "Which mass slides on a guide, and which one do both bars carry?",
            lambda robot, *row: with_masses(robot.m, robot.m, robot.mf1)(robot, *row),
        ),
        with_model(
            "both feet added to M as a scalar",
            lambda Z, *rest: (M_of(np.trace(Z) * np.ones((2, 2)), *rest), c_of(Z, *rest)),
            "A foot is moved by its own drive only. Which element of M is that?",
        ),
        with_model(
            "both feet's masses on each drive",
            lambda Z, *rest: (M_of(np.trace(Z) * np.eye(2), *rest), c_of(Z, *rest)),
            "How many feet does the left drive push?",
        ),
        Misconception(
            "feet's masses moved with the end-effector",
            "At which velocity does a foot move, and at which one the end-effector?",
            lambda robot, *row: with_masses(0.0, 0.0, robot.m + robot.mf1 + robot.mf2)(robot, *row),
        ),
        Misconception(
            "one mass for both feet",
            "The feet's masses may differ. Where does each of them stand?",
            of_another(lambda robot: replace(robot, mf2=robot.mf1)),
        ),
        with_model(
            "c forgotten",
            lambda *all_: (M_of(*all_), 0 * all_[-1]),
            "At constant speed of the feet the end-effector still accelerates. Which effort does that need?",
        ),
        with_model(
            "c of the wrong sign",
            lambda *all_: (M_of(*all_), -c_of(*all_)),
            "Insert xi'' = A^-1 (B q'' + d) once more, sign by sign.",
        ),
        Misconception(
            "sum of both rates as in the five-bar",
            "q11' is in m/s, q12' in rad/s. How fast does the bar turn against the fixed frame?",
            lambda robot, *row: dynamic_model(robot, *row[:5], row[4] + row[5], row[6], row[6] + row[7]),
        ),
        with_model(
            "c without J^T A^-1",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * d),
            "d lies along the bars. Which matrices bring it to the drives?",
        ),
        with_model(
            "c without A^-1",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * turned(inverse(A) @ B) @ d),
            "xi'' = A^-1 (B q'' + d): what stands before d?",
        ),
        with_model(
            "c without J^T",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), m * inverse(A) @ d),
            "m A^-1 d is a force on the end-effector. Which efforts of the drives is it worth?",
        ),
        with_model(
            "c with the feet's masses",
            lambda Z, m, A, B, d: (M_of(Z, m, A, B, d), (Z + m * np.eye(2)) @ turned(inverse(A) @ B) @ inverse(A) @ d),
            "A foot moves in a straight line: does it need an effort at constant speed?",
        ),
        with_model(
            "J J^T instead of J^T J",
            lambda Z, m, A, B, d: (
                Z + m * (inverse(A) @ B) @ turned(inverse(A) @ B), c_of(Z, m, A, B, d)
            ),
            "xi' = J q'. Write the kinetic energy m |xi'|^2 / 2 with q'.",
        ),
        with_model(
            "J = B^-1 A",
            lambda Z, m, A, B, d: (
                Z + m * turned(inverse(B) @ A) @ (inverse(B) @ A), m * turned(inverse(B) @ A) @ inverse(A) @ d
            ),
            "J gives the end-effector's velocity from the feet's. Solve A xi' = B q' for the right one.",
        ),
        with_model(
            "end-effector's mass halved",
            lambda Z, m, *rest: (M_of(Z, m / 2, *rest), c_of(Z, m / 2, *rest)),
            "The 1/2 of the kinetic energy meets the exponent when you differentiate.",
        ),
    ),
    shapes={"M": (2, 2), "c": (2,)},
)  # fmt: skip


def with_masses(mf1, mf2, m):
    return of_another(lambda robot: replace(robot, mf1=mf1, mf2=mf2, m=m))


def moved(robot, x, y, xD, yD, xDD, yDD, gamma1, gamma2, speed=1.0):
    """M, c and q'' of a motion of the end-effector; speed: by which its velocity is multiplied for q''."""
    found = fb.igm(robot, np.stack([x, y], -1), np.stack([gamma1, gamma2], -1))
    xi_dot = np.stack([xD, yD], -1)
    acc = fb.ikm2(fb.ikm(found, speed * xi_dot), np.stack([xDD, yDD], -1))
    return *fb.dynamic_model(fb.ikm(found, xi_dot)), acc.q_ddot


def efforts(robot, *row, speed=1.0, bias=1.0):
    M, c, q_ddot = moved(robot, *row, speed=speed)
    return tuple(np.asarray(times(M, *q_ddot.T)) + bias * c.T)


def on_raw_accelerations(robot, *row):
    M, c, _ = moved(robot, *row)
    return tuple(np.asarray(times(M, *row[4:6])) + c.T)


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
            on_raw_accelerations,
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
        legs_exchanged(efforts, "what you return"),
    ),
)


EXERCISES = [DGM, IGM, DGM_PASSIVE, DKM, IKM, DKM_PASSIVE, DKM2, IKM2, DKM2_PASSIVE, DYNAMIC_MODEL, EFFORTS]
