"""What lab 6 checks; its models are in exercises.py, and gains and crossings are judged by what they do."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.four_joints import batch, joint_rates, joints
from fivebar.grading.samples import poses, straight_paths

HOME, GOAL = (0.09, 0.06796322535018479), (0.05, 0.0)  # control task 2
MOST_TORQUE = 0.1  # N m
SETTLED, PERIODS, OVERSHOOT = 0.01, 40, 0.05


@pytest.mark.points(3)
def test_trajectory(ask, draw):
    """trajectory: between start and end"""
    duration = draw.uniform(0.5, 5, 16)
    ask("trajectory", duration * draw.uniform(0.05, 0.95, 16), *draw.uniform(-0.1, 0.1, (4, 16)), duration)


@pytest.mark.points(1)
def test_trajectory_held(ask, draw):
    """trajectory: before its start and after its end"""
    duration = draw.uniform(0.5, 5, 12)
    u = np.concatenate([draw.uniform(-0.5, -0.1, 4), draw.uniform(0.1, 0.9, 4), draw.uniform(1.1, 1.5, 4)])
    ask("trajectory", duration * u, *draw.uniform(-0.1, 0.1, (4, 12)), duration)


@pytest.mark.points(3)
def test_computed_torque(ask, robot, draw):
    """computed_torque: regular poses with tracking errors"""
    pose = poses(robot, draw, 16)
    rates = fb.ikm(pose, draw.uniform(-0.3, 0.3, (16, 2)))
    target = *(pose.q + draw.uniform(-0.05, 0.05, (16, 2))).T, *(rates.q_dot + draw.uniform(-0.5, 0.5, (16, 2))).T
    gains = draw.uniform(20, 200, 16), draw.uniform(5, 40, 16)
    ask("computed_torque", *target, *draw.uniform(-5, 5, (2, 16)), *joints(pose), *joint_rates(rates), *gains)


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
        tau = ask.call("computed_torque", *(float(row[k]) for k in order), 100.0, 20.0)
        return np.asarray(tau, float).ravel()

    try:
        run = fb.simulate(robot, controller, reference, start=start, control_period=0.02, step=0.004)
    except (ArithmeticError, ValueError) as error:
        ask.verdict(0.0, f"the simulated robot fails: {error}")
    error = float(np.abs(run.error[-1]).max())
    asked = f"from ({x0:.6g}, {y0:.6g}) to ({x1:.6g}, {y1:.6g}) m in 1.6 s, kp = 100, kd = 20, 0.02 rad beside the path"
    right = error < 2e-4
    ask.verdict(float(right), "" if right else "the robot does not reach its path", asked, f"{error:.3g} m off", error)


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
    for period in periods:
        kp, kd = np.asarray(ask.call("gains", float(period)), float).ravel()
        error = decay(kp, kd, period, delay)
        late, over = np.abs(error[PERIODS:]).max(), -error.min()
        reason = ""
        if not late <= SETTLED:
            grows = not late < 1
            reason = "the error grows" if grows else f"after {PERIODS} periods {late:.2g} of the error is left"
        elif over > OVERSHOOT:
            reason = f"the error overshoots by {over:.2g} of itself"
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
    clear = np.where(inside, p * np.sign(p[0]), 1).min(axis=0) > 0.1
    rows = np.flatnonzero(clear & ~inside[-1])[:n]
    return (*start[rows].T, *away[rows].T, np.full(len(rows), 3.0))


@pytest.mark.points(2)
def test_meets(ask, robot, draw):
    """meets: when and which type, task 2 among them"""
    ask("meets", *batch(crossing_tasks(robot, draw, 6), leaving_tasks(robot, draw, 4)), tolerance=1e-6)


@pytest.mark.points(2)
def test_missing_force(ask, robot, draw):
    """missing_force: what no motor can supply there"""
    ask("missing_force", *crossing_tasks(robot, draw, 8), tolerance=1e-6)


def refuse_motion(ask, task, motion, robot):
    """Verdict on everything but the torques."""
    asked = "from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g}) m in {:g} s".format(*task)
    t, xi, velocity, acceleration = motion
    h = np.diff(t)[:, None]
    step = xi[:-1] + h / 2 * (velocity[:-1] + velocity[1:]) + h**2 / 12 * (acceleration[:-1] - acceleration[1:])
    change = velocity[:-1] + h / 2 * (acceleration[:-1] + acceleration[1:])
    speed = np.abs(velocity).max() + 1e-3
    ends = max(np.abs(xi[0] - task[:2]).max(), np.abs(xi[-1] - task[2:4]).max())
    pose = fb.igm(robot, xi, unreachable="nan")
    problems = (
        (not np.isfinite(acceleration).all(), "nan or infinity in the trajectory"),
        (ends > 1e-9, f"it begins or ends {ends:.2g} m beside the task"),
        (np.abs([velocity[0], velocity[-1]]).max() > 1e-6, "it is not at rest at its ends"),
        (np.abs(step - xi[1:]).max() > 1e-5, "its velocity is not the derivative of its position"),
        (np.abs(change - velocity[1:]).max() > 0.05 * speed, "its acceleration is not the derivative of its velocity"),
        (np.isnan(pose.q).any(), "it leaves the reach of a leg"),
        (np.sum(np.diff(pose.assembly) != 0) != 1, "it does not cross the Type-2 locus exactly once"),
    )
    for wrong, reason in problems:
        if wrong:
            ask.verdict(0.0, reason, asked)
    return asked, pose


def torques(robot, xi, velocity, acceleration):
    return fb.inverse_dynamics(fb.ikm2(fb.ikm(fb.igm(robot, xi), velocity), acceleration))


def judge_crossing(ask, robot, task):
    def at(times):
        rows = [np.asarray(ask.call("crossing_trajectory", float(t), *task), float).ravel() for t in times]
        return np.array(rows).reshape(-1, 3, 2).swapaxes(0, 1)

    duration = task[4]
    t = np.linspace(0, duration, 101)
    xi, velocity, acceleration = at(t)
    asked, pose = refuse_motion(ask, task, (t, xi, velocity, acceleration), robot)
    k = int(np.flatnonzero(np.diff(pose.assembly))[0])
    low, high = t[k], t[k + 1]
    for _ in range(24):
        middle = (low + high) / 2
        same = fb.igm(robot, at([middle])[0][0]).assembly == pose.assembly[k]
        low, high = (middle, high) if same else (low, middle)
    near = high + np.array([-1e-2, -1e-3, -1e-4, 1e-4, 1e-3, 1e-2])
    far = np.abs(t - high) > 1e-2
    times = np.concatenate([t[far], near])
    motion = [np.concatenate([part[far], beside]) for part, beside in zip((xi, velocity, acceleration), at(near))]
    tau = np.abs(torques(robot, *motion)).max(axis=1)
    largest = int(np.argmax(tau))
    came = f"{tau[largest]:.3g} N m at t = {times[largest]:.6g} s, the crossing at {high:.6g} s"
    right = tau[largest] <= MOST_TORQUE
    ask.verdict(float(right), "" if right else f"more than {MOST_TORQUE:g} N m", asked, came, float(tau[largest]))


@pytest.mark.points(3)
def test_crossing(ask, robot, draw):
    """crossing_trajectory: task 2 with finite torques"""
    judge_crossing(ask, robot, [float(column[0]) for column in crossing_tasks(robot, draw, 1, gentle=True)])


@pytest.mark.points(1)
def test_crossing_elsewhere(ask, robot, draw):
    """crossing_trajectory: another task that crosses"""
    judge_crossing(ask, robot, [float(column[-1]) for column in crossing_tasks(robot, draw, 2, gentle=True)])
