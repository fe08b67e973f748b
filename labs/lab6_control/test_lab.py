"""What lab 6 checks; its models are in exercises.py, and gains and crossings are judged by what they do."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise
from fivebar.grading.columns import batch, joint_motion
from fivebar.grading.samples import poses, straight_paths
from fivebar.grading.values import Unfit, read

HOME, GOAL = (0.09, 0.06796322535018479), (0.05, 0.0)  # control task 2
MOST_TORQUE = 0.1  # N m
MOST = 1e9  # of any number returned
SHORTLY = 1e-5  # s
SETTLED, PERIODS, OVERSHOOT = 0.01, 40, 0.05

# What the functions return that have no single right answer.
LAW = Exercise("computed_torque() -> tau1, tau2", None)
GAINS = Exercise("gains(period) -> kp, kd", None)
CROSSING = Exercise("crossing_trajectory() -> x, y, xD, yD, xDD, yDD", None)


def numbers(ask, exercise, *row):
    """The numbers that one call gives, as an array; a verdict where it gives others."""
    value = ask.call(exercise.name, *row)
    try:
        found = read(exercise, value)[0]
    except Unfit as unfit:
        ask.verdict(0.0, str(unfit))
    if not np.isfinite(found).all():
        ask.verdict(0.0, "returned nan or infinity")
    if np.abs(found).max() > MOST:
        ask.verdict(0.0, f"returned a number beyond {MOST:g}")
    return found


@pytest.mark.points(3)
def test_trajectory(ask, draw):
    """trajectory: between start and end"""
    duration = draw.uniform(0.5, 5, 16)
    ask(
        "trajectory",
        duration * draw.uniform(0.05, 0.95, 16),
        *draw.uniform(-0.1, 0.1, (4, 16)),
        duration,
    )


@pytest.mark.points(1)
def test_trajectory_held(ask, draw):
    """trajectory: before its start and after its end"""
    duration = draw.uniform(0.5, 5, 12)
    u = np.concatenate(
        [draw.uniform(-0.5, -0.1, 4), draw.uniform(0.1, 0.9, 4), draw.uniform(1.1, 1.5, 4)]
    )
    ask("trajectory", duration * u, *draw.uniform(-0.1, 0.1, (4, 12)), duration)


@pytest.mark.points(3)
def test_computed_torque(ask, robot, draw):
    """computed_torque: regular poses with tracking errors"""
    pose = poses(robot, draw, 16)
    rates = fb.ikm(pose, draw.uniform(-0.3, 0.3, (16, 2)))
    target = (
        *(pose.q + draw.uniform(-0.05, 0.05, (16, 2))).T,
        *(rates.q_dot + draw.uniform(-0.5, 0.5, (16, 2))).T,
    )
    gains = draw.uniform(20, 200, 16), draw.uniform(5, 40, 16)
    ask("computed_torque", *target, *draw.uniform(-5, 5, (2, 16)), *joint_motion(rates), *gains)


@pytest.mark.points(2)
def test_closed_loop(ask, robot, draw):
    """computed_torque: a simulated robot that starts beside its path"""
    x0, y0, x1, y1, *_ = (column[0] for column in straight_paths(robot, draw, 1, 0, (-1, -1)))
    reference = fb.line((x0, y0), (x1, y1), 1.6)
    first = fb.igm(robot, (x0, y0))
    assembly = int(first.assembly)
    start = fb.dkm(fb.dgm(robot, first.q + (0.02, -0.02), assembly), (0.0, 0.0))
    target = fb.ComputedTorque(robot, 0, 0).target

    def controller(t, q, q_dot, reference):
        rates, wanted = fb.dkm(fb.dgm(robot, q, assembly), q_dot), target(t, reference)
        turns = 2 * np.pi * np.round((wanted.rates.pose.q - q) / (2 * np.pi))
        wanted_q = wanted.rates.pose.q - turns
        row = *wanted_q, *wanted.rates.q_dot, *wanted.q_ddot
        row += *q, *rates.pose.q_passive, *q_dot, *rates.q_passive_dot
        order = [*range(6), 6, 8, 7, 9, 10, 12, 11, 13]
        return numbers(ask, LAW, *(float(row[k]) for k in order), 100.0, 20.0)

    try:
        run = fb.simulate(
            robot, controller, reference, start=start, control_period=0.02, step=0.004
        )
    except (ArithmeticError, ValueError) as error:
        where = re.search(r"at t = [\d.e-]+ s", str(error))
        ask.verdict(
            0.0,
            f"the simulated robot runs away under these torques{where and ', ' + where[0] or ''}",
        )
    error = float(np.abs(run.error[-1]).max())
    asked = f"from ({x0:.6g}, {y0:.6g}) to ({x1:.6g}, {y1:.6g}) m in 1.6 s, kp = 100, kd = 20, 0.02 rad beside the path"
    right = error < 2e-4
    ask.verdict(
        float(right),
        "" if right else "the robot does not reach its path",
        asked,
        f"{error:.3g} m off",
        error,
    )


def decay(kp, kd, period, delay):
    """The joint's error from 1 rad at rest, one value a period, under the acceleration -kp e - kd e' held for one."""
    e, rate, pending, history = 1.0, 0.0, [0.0] * delay, [1.0]
    for _ in range(2 * PERIODS):
        pending.append(-kp * e - kd * rate)
        push = pending.pop(0)
        e, rate = e + rate * period + push * period**2 / 2, rate + push * period
        history.append(e if abs(e) < 1e6 else 1e6)
        e = history[-1]
    return np.array(history)


def judge_gains(ask, draw, delay):
    periods = np.round(10 ** draw.uniform(-3, -1.3, 6), 5)
    wrong, first = 0, None
    for period in periods.tolist():
        kp, kd = numbers(ask, GAINS, float(period)).tolist()
        error = decay(kp, kd, period, delay)
        late, over = np.abs(error[PERIODS:]).max(), -error.min()
        reason = ""
        if not late <= SETTLED:
            grows = not late < 1
            reason = (
                "the error grows"
                if grows
                else f"after {PERIODS} periods {late:.2g} of the error is left"
            )
        elif over > OVERSHOOT:
            reason = f"the error overshoots by {over:.2g} of itself"
        if reason and kp > 0 and 0 < kd < 1.8 * kp**0.5:
            damping = kd / (2 * kp**0.5)
            reason += f"; the damping kd / (2 sqrt(kp)) is {damping:.2g}, and 1 is enough"
        elif reason and kd * period > 1:
            reason += f"; kd times the period is {kd * period:.2g}, and more than 1 is too much"
        if reason:
            wrong += 1
            first = first or (reason, f"gains(period={period:g})", f"kp = {kp:.6g}, kd = {kd:.6g}")
    ask.verdict(1 - wrong / len(periods), *(first or ()))


@pytest.mark.points(2)
def test_gains(ask, draw):
    """gains: the error is gone after 40 periods"""
    judge_gains(ask, draw, delay=0)


@pytest.mark.points(1)
def test_gains_delay(ask, draw):
    """gains: and still so if each torque comes one period late"""
    judge_gains(ask, draw, delay=1)


def crossing_tasks(robot, draw, n, gentle=False):
    """Columns of lines that meet Type 2; the first is task 2 where this robot goes well beyond one there.

    gentle: short, slow and far from Type 1, so that a plain crossing stays below half of MOST_TORQUE.
    """
    options = dict(margin=0.2, longest=0.14) if gentle else {}
    rows = [column[:n] for column in straight_paths(robot, draw, n, 1, (-1, -1), **options)[:4]]
    rows.append(np.round(draw.uniform(*((4, 6) if gentle else (2, 5)), len(rows[0])), 2))
    found = fb.check_path(robot, fb.line(HOME, GOAL, 4.0))
    goal = fb.singularity_margins(fb.igm(robot, GOAL, unreachable="nan"))
    room = (
        found.reachable
        and not found.singularity_free
        and found.time < 3.3
        and np.abs(goal.serial).min() > 0.09
        and abs(goal.parallel) > 0.12
    )
    if found.type == fb.Singularity.PARALLEL and room:
        for column, value in zip(rows, (*HOME, *GOAL, 4.0)):
            column[0] = value
    return tuple(rows)


def leaving_tasks(robot, draw, n):
    """Columns of lines that leave the reach of a leg and meet no Type 2 before."""
    start = poses(robot, draw, 60, working=(-1, -1)).xi
    angle = draw.uniform(-np.pi, np.pi, 60)
    away = start + 0.3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    s = np.linspace(0, 1, 161)[:, None, None]
    pose = fb.igm(robot, start + (away - start) * s, unreachable="nan")
    p = fb.singularity_margins(pose).parallel
    inside = np.logical_and.accumulate(np.isfinite(p), axis=0)
    clear = (
        np.where(inside, p * np.sign(p[0]), 1).min(axis=0) > 0.4
    )  # it falls like a root towards the limit
    rows = np.flatnonzero(clear & ~inside[-1])[:n]
    return (*start[rows].T, *away[rows].T, np.full(len(rows), 3.0))


@pytest.mark.points(2)
def test_meets(ask, robot, draw):
    """meets: when and which type, task 2 among them"""
    ask(
        "meets",
        *batch(crossing_tasks(robot, draw, 6), leaving_tasks(robot, draw, 4)),
        tolerance=1e-6,
    )


@pytest.mark.points(2)
def test_missing_force(ask, robot, draw):
    """missing_force: what no motor can supply there"""
    ask("missing_force", *crossing_tasks(robot, draw, 8), tolerance=1e-6)


def crossings(assembly):
    """Pairs of neighbouring samples with a crossing between them; a sample on the locus itself, 0, is on no side."""
    regular = np.flatnonzero(assembly)
    k = np.flatnonzero(np.diff(assembly[regular]))
    return list(zip(regular[k].tolist(), regular[k + 1].tolist()))


def wrong_motion(task, motion, beside, pose):
    """Why this motion (position, velocity, acceleration) is none that robot and task allow, or "".

    beside: the same at some times shortly before and shortly after.
    """
    xi, velocity, _ = motion
    ends = max(np.abs(xi[0] - task[:2]).max(), np.abs(xi[-1] - task[2:4]).max())
    problems = (
        (ends > 1e-9, f"it begins or ends {ends:.2g} m beside the task"),
        (np.abs([velocity[0], velocity[-1]]).max() > 1e-6, "it is not at rest at its ends"),
        (reason := wrong_derivative(*beside), reason),
        (np.isnan(pose.q).any(), "it leaves the reach of a leg"),
        (len(crossings(pose.assembly)) != 1, "it does not cross the Type-2 locus exactly once"),
    )
    return next((reason for wrong, reason in problems if wrong), "")


def wrong_derivative(early, late):
    """Which derivative a motion, shortly before and shortly after some times, is not the derivative of, or ""."""
    slope, mean = (late - early) / (2 * SHORTLY), (late + early) / 2
    off = [
        np.abs(slope[k] - mean[k + 1]).max() > 1e-3 * (1e-3 + np.abs(mean[k + 1]).max())
        for k in (0, 1)
    ]
    names = "position", "velocity", "acceleration"
    return next(
        (f"its {names[k + 1]} is not the derivative of its {names[k]}" for k in (0, 1) if off[k]),
        "",
    )


def jump(times, motion):
    """Where the motion moves on by more than its own velocity and acceleration account for, or ""."""
    xi, velocity, acceleration = motion
    h, most = np.diff(times)[:, None], 2 * np.abs(acceleration).max() + 1e-3
    beyond = (
        np.abs(np.diff(xi, axis=0) - h * (velocity[1:] + velocity[:-1]) / 2)
        > h**2 * most / 4 + 1e-9
    )
    beyond |= np.abs(np.diff(velocity, axis=0)) > h * most + 1e-9
    rows = np.flatnonzero(beyond.any(axis=1))
    return (
        f"it jumps between t = {times[rows[0]]:.6g} and {times[rows[0] + 1]:.6g} s: what is the time of each part counted from?"
        if len(rows)
        else ""
    )


def torques(robot, xi, velocity, acceleration):
    return fb.inverse_dynamics(fb.ikm2(fb.ikm(fb.igm(robot, xi), velocity), acceleration))


def judge_crossing(ask, robot, draw, task):
    def at(times):
        rows = [numbers(ask, CROSSING, float(t), *task) for t in times]
        return np.array(rows).reshape(-1, 3, 2).swapaxes(0, 1)

    duration = task[4]
    asked = "from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g}) m in {:g} s".format(*task)
    t, some = np.linspace(0, duration, 101), duration * draw.uniform(0.05, 0.95, 12)
    motion = at(t)
    pose = fb.igm(robot, motion[0], unreachable="nan")
    beside = [at(some + shift) for shift in (-SHORTLY, SHORTLY)]
    reason = wrong_motion(task, motion, beside, pose)
    if reason:
        jumps = "" if wrong_derivative(*beside) else jump(t, motion)
        ask.verdict(0.0, jumps or reason, asked)
    ((k, beyond),) = crossings(pose.assembly)
    low, high = t[k], t[beyond]
    for _ in range(24):
        middle = (low + high) / 2
        same = fb.igm(robot, at([middle])[0][0], unreachable="nan").assembly == pose.assembly[k]
        low, high = (middle, high) if same else (low, middle)
    near = high + np.array([-1e-2, -1e-3, -1e-4, 1e-4, 1e-3, 1e-2])
    far = np.abs(t - high) > 1e-2
    times = np.concatenate([t[far], near])
    order = np.argsort(times)
    times = times[order]
    motion = [np.concatenate([part[far], beside])[order] for part, beside in zip(motion, at(near))]
    try:
        tau = np.abs(torques(robot, *motion)).max(axis=1)
    except (ArithmeticError, ValueError) as error:
        ask.verdict(0.0, f"no torques for it: {error}", asked)
    largest = int(np.argmax(tau))
    came = f"{tau[largest]:.3g} N m at t = {times[largest]:.6g} s, the crossing at {high:.6g} s"
    right = tau[largest] <= MOST_TORQUE
    if right and (
        reason := jump(times, motion)
        or wrong_derivative(*(at(near + shift) for shift in (-SHORTLY, SHORTLY)))
    ):
        ask.verdict(0.0, reason, asked)
    ask.verdict(
        float(right),
        "" if right else f"more than {MOST_TORQUE:g} N m",
        asked,
        came,
        float(tau[largest]) - MOST_TORQUE,
    )


@pytest.mark.points(3)
def test_crossing(ask, robot, draw):
    """crossing_trajectory: task 2 with finite torques"""
    judge_crossing(
        ask,
        robot,
        draw,
        [float(column[0]) for column in crossing_tasks(robot, draw, 1, gentle=True)],
    )


@pytest.mark.points(1)
def test_crossing_elsewhere(ask, robot, draw):
    """crossing_trajectory: another task that crosses"""
    judge_crossing(
        ask,
        robot,
        draw,
        [float(column[-1]) for column in crossing_tasks(robot, draw, 2, gentle=True)],
    )
