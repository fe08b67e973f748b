"""Lab 6: trajectories, computed torque, and what happens at a Type-2 singularity; right and wrong."""

from functools import lru_cache

import numpy as np

import fivebar as fb
from fivebar.grading import Exercise, Misconception
from fivebar.grading.columns import motion, times


def quintic(u):
    """s(u) and its first two derivatives by u."""
    return u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


def cubic(u):
    return u**2 * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def constant(u):
    return u, 1 + 0 * u, 0 * u


def trajectory(robot, t, x0, y0, x1, y1, duration, profile=quintic, held=(0, 1), rate=1, bend=2):
    """held: the parts of the duration outside of which it rests; rate, bend: the powers of the
    duration by which the derivatives are divided.
    """
    u = np.clip(t / duration, *held)
    s, sD, sDD = profile(u)
    inside = u == t / duration
    sD, sDD = inside * sD / duration**rate, inside * sDD / duration**bend
    X, Y = x1 - x0, y1 - y0
    return x0 + s * X, y0 + s * Y, sD * X, sD * Y, sDD * X, sDD * Y


def changed(name, hint, **change):
    return Misconception(name, hint, lambda robot, *row: trajectory(robot, *row, **change))


TRAJECTORY = Exercise(
    "trajectory(t, x0, y0, x1, y1, duration) -> x, y, xD, yD, xDD, yDD",
    trajectory,
    (
        changed(
            "cubic instead of quintic", "Is the acceleration 0 at both ends, too?", profile=cubic
        ),
        changed(
            "constant speed",
            "Which speed shall the end-effector have at both ends?",
            profile=constant,
        ),
        *(
            changed(
                f"{wrong} for {right} in the quintic's position",
                "At u = 1 the position is the last point: what must the three numbers add up to?",
                profile=lambda u, change=change: (quintic(u)[0] + change(u), *quintic(u)[1:]),
            )
            for power, right in ((3, 10), (4, 15), (5, 6))
            for wrong, change in (
                (right - 1, lambda u, p=power: -((-1) ** (p + 1)) * u**p),
                (right + 1, lambda u, p=power: (-1) ** (p + 1) * u**p),
            )
        ),
        changed(
            "duration forgotten in the derivatives",
            "You differentiate by t / T. By what shall it be?",
            rate=0,
            bend=0,
        ),
        changed(
            "duration only once in the acceleration",
            "Each derivative brings its own factor.",
            bend=1,
        ),
        *(
            changed(f"not held {when}", "What does a polynomial do beyond its two ends?", held=held)
            for when, held in (
                ("before the start and after the end", (-np.inf, np.inf)),
                ("after the end", (0, np.inf)),
                ("before the start", (-np.inf, 1)),
            )
        ),
        Misconception(
            "end point instead of displacement",
            "s grows from 0 to 1. What must it be multiplied with to end in x1?",
            lambda robot, t, x0, y0, x1, y1, duration: trajectory(
                robot, t, x0, y0, x0 + x1, y0 + y1, duration
            ),
        ),
    ),
)


def law(
    robot, target, measured, kp, kd, velocity=1, position=1, acceleration=1, bias=1, outside=False
):
    """M (q_t'' + kd e' + kp e) + c, its terms times these factors; outside: the feedback is not multiplied by M."""
    q, qD, qDD = (np.stack(pair) for pair in (target[:2], target[2:4], target[4:]))
    measured_q, measured_qD = np.stack(measured[0:4:2]), np.stack(measured[4::2])
    M, c = fb.dynamic_model(motion(robot, *measured))
    feedback = kd * (velocity * qD - measured_qD) + kp * position * (q - measured_q)
    inner = acceleration * qDD + (0 if outside else feedback)
    return tuple(np.stack(times(M, *inner)) + bias * c.T + (feedback if outside else 0))


def computed_torque(robot, *row, **change):
    return law(robot, row[:6], row[6:14], *row[14:], **change)


def c_in_the_bracket(robot, *row):
    M, c = fb.dynamic_model(motion(robot, *row[6:14]))
    inner = np.stack(computed_torque(robot, *row, bias=0))
    return tuple(inner + np.stack(times(M, *c.T)))


def other_law(name, hint, **change):
    return Misconception(name, hint, lambda robot, *row: computed_torque(robot, *row, **change))


COMPUTED_TORQUE = Exercise(
    "computed_torque(q11t, q21t, q11tD, q21tD, q11tDD, q21tDD, q11, q12, q21, q22, q11D, q12D, q21D, q22D, kp, kd)"
    " -> tau1, tau2",
    computed_torque,
    (
        Misconception(
            "gains exchanged",
            "Which gain has the unit 1/s²?",
            lambda robot, *row: computed_torque(robot, *row[:14], row[15], row[14]),
        ),
        Misconception(
            "feedback of the wrong sign",
            "The joint is behind its target. Which way must the motor push?",
            lambda robot, *row: computed_torque(robot, *row[:14], -row[14], -row[15]),
        ),
        Misconception(
            "velocity feedback of the wrong sign",
            "The joint is slower than its target. Which way must the motor push?",
            lambda robot, *row: computed_torque(robot, *row[:15], -row[15]),
        ),
        Misconception(
            "position feedback of the wrong sign",
            "The joint stands behind its target. Which way must the motor push?",
            lambda robot, *row: computed_torque(robot, *row[:14], -row[14], row[15]),
        ),
        Misconception(
            "velocity feedback missing",
            "A spring without a damper: what does the error do?",
            lambda robot, *row: computed_torque(robot, *row[:15], 0 * row[15]),
        ),
        other_law(
            "position feedback missing",
            "What brings the joint back that stands beside its target?",
            position=0,
        ),
        other_law(
            "target velocity missing", "Do you damp the error, or the motion itself?", velocity=0
        ),
        other_law(
            "target acceleration missing",
            "Without any error, which acceleration do you ask for?",
            acceleration=0,
        ),
        Misconception(
            "mass matrix missing",
            "kp e, kd e' and the target's acceleration are in rad/s². What makes a torque of them?",
            lambda robot, *row: tuple(
                tau + q
                for tau, q in zip(
                    computed_torque(robot, *row, acceleration=0, outside=True), row[4:6]
                )
            ),
        ),
        other_law("c missing", "tau = M q'' + c.", bias=0),
        other_law("c subtracted", "tau = M q'' + c.", bias=-1),
        Misconception("c multiplied by M", "tau = M q'' + c.", c_in_the_bracket),
        other_law(
            "feedback outside the mass matrix",
            "kp times an error is an acceleration. What makes a torque of it?",
            outside=True,
        ),
    ),
)


@lru_cache(maxsize=256)  # the right answer and all wrong ones begin with it
def check_line(robot, x0, y0, x1, y1, duration):
    return fb.check_path(robot, fb.line((x0, y0), (x1, y1), duration))


def check(robot, *row):
    """fb.check_path of each quintic line."""
    return [check_line(robot, *(float(value) for value in values)) for values in zip(*row)]


def meets(robot, *row):
    found = [
        (one.time, int(one.type)) if one.time is not None else (np.nan, 0)
        for one in check(robot, *row)
    ]
    return tuple(np.array(found, float).T)


def share_of_path(robot, *row):
    return quintic(meets(robot, *row)[0] / row[4])[0]


MEETS = Exercise(
    "meets(x0, y0, x1, y1, duration) -> t, type",
    meets,
    (
        Misconception(
            "types 1 and 2 exchanged",
            "Which bars are in line in the pose that you found: those of one leg, or the two distal ones?",
            lambda robot, *row: (meets(robot, *row)[0], 3 - meets(robot, *row)[1]),
        ),
        Misconception(
            "constant speed",
            "The end-effector starts and stops gently: it is not where it would be at constant speed.",
            lambda robot, *row: (share_of_path(robot, *row) * row[4], meets(robot, *row)[1]),
        ),
        Misconception(
            "part of the duration instead of time",
            "t is in seconds.",
            lambda robot, *row: (meets(robot, *row)[0] / row[4], meets(robot, *row)[1]),
        ),
        Misconception(
            "part of the path instead of time",
            "You found where it happens. When is it?",
            lambda robot, *row: (share_of_path(robot, *row), meets(robot, *row)[1]),
        ),
    ),
)


def at_crossing(robot, *row, derivative=2):
    """Unit vector along the left distal bar and acceleration, complex (n,), where each path meets Type 2."""
    found = check(robot, *row)
    bars = [one.pose.A[0] @ (1, 1j) if one.time is not None else np.nan for one in found]
    t = np.array([one.time if one.time is not None else np.nan for one in found])
    x, y = trajectory(robot, t, *row)[2 * derivative :][:2]
    return np.array(bars), x + 1j * y


def signed_force(robot, *row, **how):
    bar, acceleration = at_crossing(robot, *row, **how)
    return robot.m * (acceleration * bar.conj()).imag


def missing_force(robot, *row):
    return np.abs(signed_force(robot, *row))


FORCE = Exercise(
    "missing_force(x0, y0, x1, y1, duration) -> force",
    missing_force,
    (
        Misconception(
            "acceleration instead of force",
            "What is the unit of your answer?",
            lambda robot, *row: missing_force(robot, *row) / robot.m,
        ),
        Misconception(
            "velocity in place of acceleration",
            "Which derivative of the motion is m multiplied with in a force?",
            lambda robot, *row: np.abs(signed_force(robot, *row, derivative=1)),
        ),
        Misconception(
            "along the distal bars instead of across",
            "Bars push and pull along themselves. In which direction can they not, when both point the same way?",
            lambda robot, *row: (
                robot.m
                * np.abs((at_crossing(robot, *row)[1] * at_crossing(robot, *row)[0].conj()).real)
            ),
        ),
        *(
            Misconception(
                f"the sign is kept{across}: its size is asked",
                "Can a size be negative?",
                lambda robot, *row, side=side: side * signed_force(robot, *row),
            )
            for side, across in ((1, ""), (-1, ", against v12"))
        ),
        Misconception(
            "the whole inertial force",
            "The bars supply one part of it. Which part is left?",
            lambda robot, *row: robot.m * np.abs(at_crossing(robot, *row)[1]),
        ),
    ),
)


# The next two are judged by what they do: test_lab.py.
EXERCISES = [TRAJECTORY, COMPUTED_TORQUE, MEETS, FORCE]
USES = dict.fromkeys(("meets", "missing_force", "crossing_trajectory"), ("trajectory", "meets"))
