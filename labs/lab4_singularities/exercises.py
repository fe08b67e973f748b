"""Lab 4: types, margins, the Type-2 locus and paths that meet it, right and wrong."""

from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import pose
from fivebar.models.dyads import RRR

IN_LINE = 1e-6  # what the statement calls singular


def passive_misread(model):
    """The misconception of who reads q12 and q22 as the distal bars' directions."""
    return Misconception(
        "passive angles taken as absolute",
        "Which angle does the distal bar make with the x axis? q12 alone is measured from the proximal bar.",
        lambda robot, q11, q12, q21, q22, *row: model(robot, q11, q12 - q11, q21, q22 - q21, *row),
    )


def singularity_type(robot, *q):
    return fb.singularity(pose(robot, *q), IN_LINE)


def in_line(angle):
    return np.abs(np.sin(angle)) <= IN_LINE


def same_way(angle):
    return np.abs(np.sin(angle / 2)) <= IN_LINE


def kind(type_1, type_2):
    return type_1 + 2 * type_2


BETWEEN_DISTAL_BARS = (-1, -1, 1, 1)  # q21 + q22 - q11 - q12


def wrong_angles():
    """Coefficients of q11, q12, q21, q22 in sums and differences that are not the angle between the distal bars.

    Of an angle and its negative, whose sines vanish together, only one is here.
    """
    all_of_them = product((-1, 0, 1), repeat=4)
    one_of_two = [c for c in all_of_them if c > (0, 0, 0, 0)]
    return [c for c in one_of_two if c != tuple(-k for k in BETWEEN_DISTAL_BARS)]


def angle(coefficients, q):
    return sum(k * joint for k, joint in zip(coefficients, q))


def angle_in_words(coefficients):
    """q22 - q12: the positive terms first."""
    terms = sorted(zip(coefficients, ("q11", "q12", "q21", "q22")), key=lambda term: -term[0])
    signed = [(" + " if k > 0 else " - ") + name for k, name in terms if k]
    return "".join(signed).removeprefix(" + ")


def by_another_angle(coefficients):
    """The misconception of who finds Type 2 where the sine of this angle is 0."""
    return Misconception(
        f"Type 2 by the angle {angle_in_words(coefficients)}",
        "Which angle lies between the two distal bars? Write down the direction of each.",
        lambda robot, *q: kind(in_line(q[1]) | in_line(q[3]), in_line(angle(coefficients, q))),
    )


TYPE = Exercise(
    "singularity_type(q11, q12, q21, q22) -> type",
    singularity_type,
    (
        passive_misread(singularity_type),
        Misconception(
            "types 1 and 2 exchanged",
            "Which matrix is singular when a leg is straight, and which type is that?",
            lambda robot, *q: np.array([0, 2, 1, 3])[singularity_type(robot, *q)],
        ),
        Misconception(
            "angle compared with 0 instead of its sine",
            "Two bars are in line at more than one angle. At which ones is the sine 0?",
            lambda robot, q11, q12, q21, q22: kind(
                (np.abs(q12) <= IN_LINE) | (np.abs(q22) <= IN_LINE),
                np.abs(q21 + q22 - q11 - q12) <= IN_LINE,
            ),
        ),
        Misconception(
            "only straight legs, not folded ones",
            "A leg is in line in two ways. Which q12 is the other one?",
            lambda robot, q11, q12, q21, q22: kind(
                same_way(q12) | same_way(q22), in_line(q21 + q22 - q11 - q12)
            ),
        ),
        Misconception(
            "parallel distal bars only when they point the same way",
            "Bars that pull against each other in one line are parallel, too.",
            lambda robot, q11, q12, q21, q22: kind(
                in_line(q12) | in_line(q22), same_way(q21 + q22 - q11 - q12)
            ),
        ),
        Misconception(
            "Type 1 only when both legs are in line",
            "det B is a product. When is it 0?",
            lambda robot, q11, q12, q21, q22: kind(
                in_line(q12) & in_line(q22), in_line(q21 + q22 - q11 - q12)
            ),
        ),
        *(
            Misconception(
                f"only the {side} leg looked at",
                "A robot has two legs. Does yours notice when the other one is straight?",
                lambda robot, *q, k=k: kind(in_line(q[k]), in_line(q[2] + q[3] - q[0] - q[1])),
            )
            for side, k in (("left", 1), ("right", 3))
        ),
        *(
            Misconception(
                f"a tolerance {size} than 1e-6",
                "Which sines does the statement take for 0? Compare with yours.",
                lambda robot, *q, tolerance=tolerance: fb.singularity(pose(robot, *q), tolerance),
            )
            for size, tolerance in (("larger", 5e-3), ("smaller", 1e-8))
        ),
        Misconception(
            "Types 1 and 3 never named",
            "Stretch your arm. Which matrix of lab 2 is singular, and which angle of the leg says so?",
            lambda robot, *q: kind(False, in_line(angle(BETWEEN_DISTAL_BARS, q))),
        ),
        *(by_another_angle(coefficients) for coefficients in wrong_angles()),
        Misconception(
            "Types 2 and 3 never named",
            "Hold two rulers parallel, as distal bars. Which angle do you compare with which number?",
            lambda robot, *q: kind(in_line(q[1]) | in_line(q[3]), False),
        ),
        *(
            Misconception(
                name,
                "What if both conditions hold at once?",
                lambda robot, *q, notes=notes: np.array([0, 1, 2, notes])[
                    singularity_type(robot, *q)
                ],
            )
            for name, notes in (("Type 3 never named", 1), ("Type 3 taken as Type 2", 2))
        ),
        Misconception(
            "negative sines of the legs taken as small",
            "Is -0.5 at most 1e-6? Is it 0?",
            lambda robot, q11, q12, q21, q22: kind(
                (np.sin(q12) <= IN_LINE) | (np.sin(q22) <= IN_LINE), in_line(q21 + q22 - q11 - q12)
            ),
        ),
        Misconception(
            "a negative sine of the distal bars taken as small",
            "Is -0.5 at most 1e-6? Is it 0?",
            lambda robot, q11, q12, q21, q22: kind(
                in_line(q12) | in_line(q22), np.sin(q21 + q22 - q11 - q12) <= IN_LINE
            ),
        ),
        Misconception(
            "negative sines taken as small",
            "Is -0.5 at most 1e-6? Is it 0?",
            lambda robot, q11, q12, q21, q22: kind(
                (np.sin(q12) <= IN_LINE) | (np.sin(q22) <= IN_LINE),
                np.sin(q21 + q22 - q11 - q12) <= IN_LINE,
            ),
        ),
    ),
    guessable=True,
)


def margins(robot, q11, q12, q21, q22):
    return np.sin(q12), np.sin(q22), np.sin(q21 + q22 - q11 - q12)


MARGINS = Exercise(
    "margins(q11, q12, q21, q22) -> s1, s2, p",
    margins,
    (
        passive_misread(margins),
        Misconception(
            "passive angles only in the parallel margin",
            "Which angle lies between the two distal bars? Write down the direction of each.",
            lambda robot, q11, q12, q21, q22: (np.sin(q12), np.sin(q22), np.sin(q22 - q12)),
        ),
        Misconception(
            "order of the bars reversed",
            "p grows when the right distal bar turns counter-clockwise away from the left one. Does yours?",
            lambda robot, *q: (*margins(robot, *q)[:2], -margins(robot, *q)[2]),
        ),
        Misconception(
            "signs lost",
            "On the two sides of a singularity a margin has two signs: that is how a crossing is seen.",
            lambda robot, *q: tuple(np.abs(margin) for margin in margins(robot, *q)),
        ),
        Misconception(
            "cosines instead of sines",
            "A margin is 0 at the singularity. What is yours for a straight leg?",
            lambda robot, q11, q12, q21, q22: (
                np.cos(q12),
                np.cos(q22),
                np.cos(q21 + q22 - q11 - q12),
            ),
        ),
        Misconception(
            "directions of the distal bars in the serial margins",
            "Whether a leg is straight does not depend on where it points.",
            lambda robot, q11, q12, q21, q22: (
                np.sin(q11 + q12),
                np.sin(q21 + q22),
                margins(robot, q11, q12, q21, q22)[2],
            ),
        ),
    ),
)


def coupler(robot, q11, branch, reach=None):
    """Left elbow and unit vector from it to the right elbow, complex, the elbows being `reach` apart."""
    elbow = -robot.d / 2 + robot.l11 * np.exp(1j * q11)
    span = robot.d / 2 - elbow
    x, y = RRR((span.real, span.imag), reach or robot.l12 + robot.l22, robot.l21, branch).first
    return elbow, x + 1j * y


def type2_point(robot, q11, branch, at=lambda robot: robot.l12, reach=None):
    elbow, along = coupler(robot, q11, branch, reach)
    point = elbow + at(robot) * along
    return point.real, point.imag


TYPE2_POINT = Exercise(
    "type2_point(q11, branch) -> x, y",
    type2_point,
    (
        Misconception(
            "other branch",
            "Stand on A12 and look to A21. Is A22 on your left for branch +1?",
            lambda robot, q11, branch: type2_point(robot, q11, -branch),
        ),
        Misconception(
            "elbow instead of end-effector",
            "You have found A22. Where on the line from A12 to A22 is the end-effector?",
            lambda robot, *row: type2_point(robot, *row, at=lambda robot: robot.l12 + robot.l22),
        ),
        Misconception(
            "end-effector in the middle of the elbows",
            "The two distal bars differ. How far is the end-effector from A12?",
            lambda robot, *row: type2_point(
                robot, *row, at=lambda robot: (robot.l12 + robot.l22) / 2
            ),
        ),
        Misconception(
            "coupler of one bar",
            "Both distal bars lie in one line, one after the other. How far apart are the elbows?",
            lambda robot, *row: type2_point(robot, *row, reach=robot.l12),
        ),
        Misconception(
            "lengths of the right leg's bars exchanged",
            "Which bar of the right leg turns about A21, and which one belongs to the coupler?",
            lambda robot, *row: type2_point(replace(robot, l21=robot.l22, l22=robot.l21), *row),
        ),
    ),
)

FRACTIONS = np.linspace(0, 1, 2001)


def parallel(robot, x0, y0, x1, y1, gamma1, gamma2, s):
    """det A (n, k) at the fractions s (n, k) or (k,) of straight paths, nan out of reach."""
    x0, y0, x1, y1, gamma1, gamma2 = (
        np.asarray(v)[:, None] for v in (x0, y0, x1, y1, gamma1, gamma2)
    )
    xi = np.stack([x0 + (x1 - x0) * s, y0 + (y1 - y0) * s], axis=-1)
    working = np.broadcast_to(np.stack([gamma1, gamma2], axis=-1), xi.shape)
    return fb.singularity_margins(
        fb.igm(robot, xi, working.astype(int), unreachable="nan")
    ).parallel


def first_crossing(robot, *path, last=False, side=0):
    """By sampling and bisection; nan where there is none.

    side: the sign behind the crossings that count, 0 for both.
    """
    signs = np.sign(parallel(robot, *path, FRACTIONS))
    changes = (signs[:, 1:] * signs[:, :-1] < 0) & (signs[:, 1:] * side >= 0)
    k = (
        changes.shape[1] - 1 - np.argmax(changes[:, ::-1], axis=1)
        if last
        else np.argmax(changes, axis=1)
    )
    low, high, before = (
        FRACTIONS[k][:, None],
        FRACTIONS[k + 1][:, None],
        signs[np.arange(len(k)), k][:, None],
    )
    for _ in range(50):
        middle = (low + high) / 2
        same = np.sign(parallel(robot, *path, middle)) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.where(changes.any(axis=1), high[:, 0], np.nan)


def by_the_ends(robot, *path):
    """None where both ends have the same sign."""
    ends = np.sign(parallel(robot, *path, np.array([0.0, 1.0])))
    return np.where(ends[:, 0] == ends[:, 1], np.nan, first_crossing(robot, *path))


def on_grid(s, count, end):
    """The end, the middle or the beginning of the step of 1/count in which s lies."""
    return (
        np.floor(s * count) + {"the end": 1, "the middle": 0.5, "the beginning": 0}[end]
    ) / count


def length(x0, y0, x1, y1):
    return np.hypot(x1 - x0, y1 - y0)


CROSSING = Exercise(
    "first_crossing(x0, y0, x1, y1, gamma1, gamma2) -> s",
    first_crossing,
    (
        Misconception(
            "last crossing instead of the first",
            "The path meets the locus more than once. Which meeting comes first?",
            lambda robot, *path: first_crossing(robot, *path, last=True),
        ),
        *(
            Misconception(
                f"only crossings from {way}",
                "Which sign has the margin before the crossing, which one behind it? Is it always so?",
                partial(first_crossing, side=side),
            )
            for way, side in (("minus to plus", 1), ("plus to minus", -1))
        ),
        Misconception(
            "only the ends compared",
            "A path may cross the locus and come back. What do its two ends say then?",
            by_the_ends,
        ),
        Misconception(
            "working modes never used",
            "The same point is singular in one working mode and regular in another.",
            lambda robot, x0, y0, x1, y1, *modes: first_crossing(
                robot, x0, y0, x1, y1, -np.ones(len(x0)), -np.ones(len(x0))
            ),
        ),
        Misconception(
            "working modes swapped",
            "gamma1 belongs to the left leg.",
            lambda robot, x0, y0, x1, y1, gamma1, gamma2: first_crossing(
                robot, x0, y0, x1, y1, gamma2, gamma1
            ),
        ),
        Misconception(
            "measured from the end",
            "s is 0 at the path's beginning.",
            lambda robot, *path: 1 - first_crossing(robot, *path),
        ),
        *(
            Misconception(
                f"{cut}: {end} of a step of 1/{count}",
                "You know between which two values of s the sign changes. How do you come closer?",
                lambda robot, *path, count=count, end=end: on_grid(
                    first_crossing(robot, *path), count, end
                ),
            )
            for count in (50, 100, 200, 250, 300, 400, 500, 800, 1000, 2000, 5000, 10000)
            for end, cut in (
                ("the end", "no bisection"),
                ("the middle", "a bisection that ends too early, or none"),
                ("the beginning", "no bisection"),
            )
        ),
        Misconception(
            "distance instead of fraction",
            "s has no unit: it is 1 at the path's end.",
            lambda robot, *path: first_crossing(robot, *path) * length(*path[:4]),
        ),
    ),
)

EXERCISES = [TYPE, MARGINS, TYPE2_POINT, CROSSING]
USES = dict.fromkeys(("singularity_type", "first_crossing"), ("margins",))
