"""Lab 8: how far the bars miss the measured points, its derivatives, what no point can tell; and robots as built."""

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception

NOMINAL = (
    0.09,
    0.09,
    0.09,
    0.09,
    0.118,
    0.0,
    0.0,
)  # what the drawing says: lengths, m, and offsets, rad
STEPS = 12  # of Newton: more change nothing from a robot as it may have been built
NOISE = 2e-5  # m, of a measured coordinate
ROWS = 24
LENGTHS = "l11, l12, l21, l22, d, offset1, offset2"
ROW = f"{LENGTHS}, q1, q2, x, y"


def legs(row):
    """(sign of the base joint, l_i1, l_i2, offset_i, q_i) of both legs."""
    l11, l12, l21, l22, _, o1, o2, q1, q2 = row[:9]
    return (-1, l11, l12, o1, q1), (1, l21, l22, o2, q2)


def from_elbow(row, base=0.5, turn=1):
    """Per leg the vector from the elbow to the measured point, complex."""
    d, point = row[4], row[9] + 1j * row[10]
    return [
        point - (side * base * d + l1 * np.exp(1j * (q + turn * o)))
        for side, l1, _, o, q in legs(row)
    ]


def misses(robot, *row, **how):
    return tuple(np.abs(bar) - leg[2] for bar, leg in zip(from_elbow(row, **how), legs(row)))


MISSES = Exercise(
    f"misses({ROW}) -> e1, e2",
    misses,
    (
        Misconception(
            "offset with the wrong sign",
            "The motor shows q. What is the true angle of the bar, by the first line of the statement?",
            lambda robot, *row: misses(robot, *row, turn=-1),
        ),
        Misconception(
            "offset forgotten",
            "A motor's zero is where somebody has put it. Where does offset enter?",
            lambda robot, *row: misses(robot, *row, turn=0),
        ),
        Misconception(
            "base joints d from the origin instead of d/2",
            "d is the distance of the two base joints. How far is each of them from the origin?",
            lambda robot, *row: misses(robot, *row, base=1.0),
        ),
        Misconception(
            "sign reversed",
            "A bar that is too short for the point: shall e be positive or negative?",
            lambda robot, *row: tuple(-e for e in misses(robot, *row)),
        ),
        Misconception(
            "squares instead of lengths",
            "In which unit is e? What is the difference of two squares of lengths measured in?",
            lambda robot, *row: tuple(
                np.abs(bar) ** 2 - leg[2] ** 2 for bar, leg in zip(from_elbow(row), legs(row))
            ),
        ),
    ),
)


def derivatives(robot, *row, base=(-0.5, 0.5), lever=True, distal=-1.0, cross=True, turn=1):
    """(n, 2, 7): e_i' = u_i2 . (-dP_i) - dl_i2."""
    found = np.zeros((len(row[0]), 2, 7))
    for i, (bar, (_, l1, _, o, q)) in enumerate(zip(from_elbow(row, turn=turn), legs(row))):
        u, crank = bar / np.abs(bar), np.exp(1j * (q + turn * o))
        found[:, i, 2 * i] = -(u * crank.conj()).real
        found[:, i, 2 * i + 1] = distal
        found[:, i, 4] = -base[i] * u.real
        found[:, i, 5 + i] = -(l1 if lever else 1.0) * (
            (u * (1j * crank).conj()).real if cross else (u * crank.conj()).real
        )
    return found


DERIVATIVES = Exercise(
    f"derivatives({ROW}) -> J",
    derivatives,
    (
        *(
            Misconception(
                name,
                "By the first line of the statement, what is the true angle of the bar?",
                lambda robot, *row, turn=turn: derivatives(robot, *row, turn=turn),
            )
            for name, turn in (("offset with the wrong sign", -1), ("offset forgotten", 0))
        ),
        Misconception(
            "both base joints on the same side",
            "If d grows by 1 mm, which way does the left base joint go, and which way the right one?",
            lambda robot, *row: derivatives(robot, *row, base=(0.5, 0.5)),
        ),
        Misconception(
            "both base joints on the left",
            "If d grows by 1 mm, which way does the left base joint go, and which way the right one?",
            lambda robot, *row: derivatives(robot, *row, base=(-0.5, -0.5)),
        ),
        Misconception(
            "offset's columns of the wrong sign",
            "Which way does an elbow go when its offset grows: farther from the point, or nearer?",
            lambda robot, *row: derivatives(robot, *row) * [1, 1, 1, 1, 1, -1, -1],
        ),
        Misconception(
            "base joints moved by all of d",
            "If d grows by 1 mm, how far does each of the two base joints go?",
            lambda robot, *row: derivatives(robot, *row, base=(-1.0, 1.0)),
        ),
        Misconception(
            "offset's column without the length of the crank",
            "By how much does an elbow move if its crank turns by 0.001 rad? Does a longer crank move it farther?",
            lambda robot, *row: derivatives(robot, *row, lever=False),
        ),
        Misconception(
            "offset's column along the crank instead of across",
            "Which way does an elbow go when its crank turns: along the crank, or at a right angle to it?",
            lambda robot, *row: derivatives(robot, *row, cross=False),
        ),
        Misconception(
            "distal bar's column positive",
            "A longer distal bar: does the point lie farther out of its reach, or less far?",
            lambda robot, *row: derivatives(robot, *row, distal=1.0),
        ),
    ),
    shapes={"J": (2, 7)},
)


def unseen(
    robot, l11, l12, l21, l22, d, offset1, offset2, scale, factor=-1.0, turning=0.0, unit=True
):
    """(n, 8): all lengths and the scale, so that their products stay; of length 1."""
    zero = turning + 0 * offset1
    v = np.stack([l11, l12, l21, l22, d, zero, zero, factor * scale], axis=-1)
    return v / np.linalg.norm(v, axis=-1, keepdims=True) if unit else v


def equal_steps(robot, *row):
    v = np.stack(
        [np.ones_like(row[0])] * 5 + [np.zeros_like(row[0])] * 2 + [-np.ones_like(row[0])], axis=-1
    )
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


UNSEEN = Exercise(
    f"unseen({LENGTHS}, scale) -> v",
    unseen,
    (
        Misconception(
            "scale grows with the lengths",
            "The picture shows scale times the lengths. If the robot grows, what must the scale do to show the same?",
            lambda robot, *row: unseen(robot, *row, factor=1.0),
        ),
        Misconception(
            "lengths shrink with the scale",
            "The picture shows scale times the lengths. If the scale falls, what must the robot do?",
            lambda robot, *row: -unseen(robot, *row, factor=1.0),
        ),
        Misconception(
            "every length by the same amount",
            "A robot twice as large: by how much does a bar of 60 mm grow, and by how much one of 120 mm?",
            equal_steps,
        ),
        Misconception(
            "not of length 1",
            "The direction is right. How long is your v?",
            lambda robot, *row: unseen(robot, *row, unit=False),
        ),
        Misconception(
            "angles change as well",
            "Look at the robot from twice as far. Which of its angles are different?",
            lambda robot, *row: unseen(robot, *row, turning=0.1),
        ),
    ),
    shapes={"v": (8,)},
)


def calibrate(robot, q, xi):
    """The seven numbers of the robot that was measured, by Newton's steps of least squares."""
    poses = np.hstack([np.reshape(q, (-1, 2)), np.reshape(xi, (-1, 2))]).T
    found = np.array(NOMINAL)
    for _ in range(STEPS):
        row = *np.broadcast_to(found[:, None], (7, poses.shape[1])), *poses
        e, J = np.transpose(misses(robot, *row)), derivatives(robot, *row)
        found = found - np.linalg.lstsq(J.reshape(-1, 7), e.ravel(), rcond=None)[0]
    return tuple(found)


CALIBRATE = Exercise(f"calibrate(q, xi) -> {LENGTHS}", calibrate, of_lists=True)
EXERCISES = [MISSES, DERIVATIVES, UNSEEN, CALIBRATE]
USES = {"calibrate": ("misses", "derivatives"), "own_robot": ("misses", "derivatives", "calibrate")}


def as_drawn(draw):
    """A robot as it may have been built, (7,): lengths and offsets near the drawing."""
    return np.array(NOMINAL) + np.array([1.5e-3] * 5 + [0.03] * 2) * draw.uniform(-1, 1, 7)


def as_built(robot):
    """What was really built, (7,): lengths and offsets near the drawing, drawn from all numbers of this robot."""
    draw = np.random.default_rng([round(1e6 * value) for value in robot.parameters.values()])
    return as_drawn(draw)


def rows_of(truth, draw, n, noise):
    """n measured rows (n, 4) of such a robot, q1, q2, x, y, in all its modes and off its singularities."""
    robot, rows = fb.FiveBar(*truth[:5]), []
    while len(rows) < n:
        xi, mode = draw.uniform(-0.17, 0.17, 2), draw.choice([-1, 1], 2)
        pose = fb.igm(robot, xi, mode, unreachable="nan")
        if np.isfinite(pose.q).all() and min(*np.abs(pose.sines), abs(pose.det_A)) > 0.3:
            rows.append([*(pose.q - truth[5:]), *(xi + noise * draw.standard_normal(2))])
    return np.array(rows)


def HAND_OUT(robot, draw):
    """What a student gets beside student.py: points measured on a robot of his own, whose lengths nobody tells him."""
    rows = rows_of(as_built(robot), draw, ROWS, NOISE)
    lines = [
        ",".join([*(f"{q:.6f}" for q in row[:2]), *(f"{x:.7f}" for x in row[2:])]) for row in rows
    ]
    return {"measured.csv": "\n".join(["q1,q2,x,y", *lines]) + "\n"}
