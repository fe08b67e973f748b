"""Poses and robots to ask about, drawn at random in the region that a check is for."""

from __future__ import annotations

import math

import numpy as np

from ..models.geometry import Pose, igm
from ..models.kinematics import ikm, ikm2
from ..models.robots import Biglide, FiveBar, Robot
from .columns import Columns, batch, joint_motion

# The largest height of a biglide's end-effector over the feet's zero, m: its guides have no ends.
HEIGHT = 0.5
MARGIN = 0.2  # |sine| between bars, or bar and guide, that is far from a singularity
TRIED = 200  # poses for each one that is kept beside Type 1


def unequal_robot(draw: np.random.Generator) -> FiveBar:
    """Return a robot whose four bars differ by at least 7 mm, rounded to tenths of a millimetre."""
    bars = draw.permutation([0.080, 0.095, 0.110, 0.130]) + draw.uniform(-0.004, 0.004, 4)
    lowest = (0.09, 0.001, 0.001, 0.3)  # d, zz1, zz2, m
    highest = (0.13, 0.004, 0.004, 0.9)
    rest = draw.uniform(lowest, highest)
    if abs(rest[2] - rest[1]) < 5e-4:
        rest[2] += 1e-3  # one inertia for both legs shall be seen
    parameters = np.round([*bars, *rest], 4)
    return FiveBar(*parameters.tolist())


def unequal_biglide(draw: np.random.Generator) -> Biglide:
    """Return a biglide of bars that differ by at least 3 cm and feet by 0.2 kg; rounded to 0.1 mm
    and 1 g.

    Its guides are so close that it closes even with twice their distance, a misconception that
    shall be seen.
    """
    bars = draw.permutation([0.26, 0.32]) + draw.uniform(-0.015, 0.015, 2)
    masses = draw.permutation([0.7, 1.3]) + draw.uniform(-0.2, 0.2, 2)
    d = draw.uniform(0.14, 0.22)
    m = draw.uniform(2, 4)
    lengths = np.round([*bars, d], 4)
    masses = np.round([*masses, m], 3)
    return Biglide(*lengths, *masses)


def poses(
    robot: Robot,
    draw: np.random.Generator,
    n: int,
    assembly: int | None = None,
    working: tuple[int, int] | None = None,
    margin: float = MARGIN,
) -> Pose:
    """Return n poses as one batch, of these modes (None: any), every |sin| between bars, or bar and
    guide, over `margin`.

    The end-effector is drawn uniformly. ValueError where the robot hardly has such poses.
    """
    low, high = _ends(robot)
    for count in (25 * n, 400 * n):  # the second draw is seldom needed, and dear
        xi = draw.uniform(low, high, (count, 2))
        if working is None:
            modes = draw.choice([-1, 1], (count, 2))
        else:
            modes = np.broadcast_to(working, xi.shape)
        pose = igm(robot, xi, modes, unreachable="nan")
        sines = np.abs([*pose.sines, pose.det_A])
        good = np.min(sines, axis=0) > margin
        if assembly is not None:
            good &= pose.assembly == assembly
        if np.count_nonzero(good) >= n:
            break
    return _take(robot, xi, modes, good, n)


def _ends(robot):
    """Return the lowest and the highest coordinates of the end-effector to be tried."""
    legs = list(zip(robot.drives, robot.distal))
    if robot.turns:
        longest = max(drive.length + bar for drive, bar in legs)
        reach = longest + robot.d / 2
        return -reach, reach
    left = max(drive.x - bar for drive, bar in legs)
    right = min(drive.x + bar for drive, bar in legs)
    return (left, -HEIGHT), (right, HEIGHT)


def beside_type_1(robot: Robot, draw: np.random.Generator, sines: np.ndarray, leg: int) -> Pose:
    """Return poses in which leg 0 or 1 is almost stretched, or across its guide: `sines` (n,) of
    its passive angle.

    The signs of the sines are free.
    """
    n = len(sines)
    count = TRIED * n
    drive = robot.drives[leg]
    bar = robot.distal[leg]
    sines = np.repeat(np.abs(sines), TRIED)
    cosines = np.sqrt(1 - sines**2)
    if robot.turns:
        # The law of cosines, from the base to the end-effector.
        squares = drive.length**2 + bar**2
        span = np.sqrt(squares + 2 * drive.length * bar * cosines)
        angle = draw.uniform(-np.pi, np.pi, count)
        along_x = span * np.cos(angle)
        along_y = span * np.sin(angle)
    else:
        inwards = 1 if leg == 0 else -1
        along_x = inwards * bar * cosines
        along_y = draw.uniform(-HEIGHT, HEIGHT, count)
    xi = np.stack([drive.x + along_x, drive.y + along_y], axis=-1)
    modes = draw.choice([-1, 1], (count, 2))
    pose = igm(robot, xi, modes, unreachable="nan")
    others = np.abs([pose.sines[1 - leg], pose.det_A])
    good = np.min(others, axis=0) > MARGIN
    of_each = good.reshape(n, TRIED)
    known = np.flatnonzero(of_each.any(axis=1))
    first = TRIED * known + of_each[known].argmax(axis=1)
    return _take(robot, xi, modes, first, n)


def beside_type_2(robot: Robot, draw: np.random.Generator, sines: np.ndarray) -> Pose:
    """Return poses with det A = `sines` (n,), signed, both legs regular; by bisection between poses
    on both sides.
    """
    n = len(sines)
    if robot.turns:
        modes = draw.choice([-1, 1], (16, 1, 2))
    else:
        # A biglide whose feet are both above or both below its end-effector has no Type 2.
        modes = draw.choice([(1, -1), (-1, 1)], (16, 1))
    below = _in_modes(robot, draw, 2 * n, 1, modes)
    above = _in_modes(robot, draw, 2 * n, -1, modes)
    modes = np.broadcast_to(modes, below.shape)
    target = np.broadcast_to(np.tile(sines, 2), below.shape[:2])
    for _ in range(60):
        middle = (below + above) / 2
        pose = igm(robot, middle, modes, unreachable="nan")
        under = (pose.det_A < target)[..., None]
        below = np.where(under, middle, below)
        above = np.where(under, above, middle)
    pose = igm(robot, above, modes, unreachable="nan")
    regular = np.min(np.abs(pose.sines), axis=0) > MARGIN
    exact = np.abs(pose.det_A - target) < 1e-12
    good = (regular & exact).reshape(-1, n)
    rows = np.argmax(good, axis=0)
    columns = np.arange(n)
    if not good[rows, columns].all():
        raise ValueError(f"{robot} hardly has poses beside Type 2")
    points = above.reshape(-1, n, 2)
    modes = modes.reshape(-1, n, 2)
    return igm(robot, points[rows, columns], modes[rows, columns])


def _in_modes(robot, draw, n, assembly, modes):
    """Return n end-effector positions for each working mode, (modes, n, 2)."""
    drawn = [poses(robot, draw, n, assembly=assembly, working=mode[0]) for mode in modes]
    return np.array([pose.xi for pose in drawn])


def moving(pose: Pose, draw: np.random.Generator, speed: float = 0.3) -> Columns:
    """Return the joint columns of poses in motion, the end-effector at most this fast along x and
    y, m/s.
    """
    xi_dot = draw.uniform(-speed, speed, (len(pose.q), 2))
    return joint_motion(ikm(pose, xi_dot))


def accelerated(
    pose: Pose, draw: np.random.Generator, speed: float = 0.3, most: float = 2.0
) -> Columns:
    """Return the columns that dkm2_passive asks for, the end-effector's acceleration at most `most`
    along x and y, m/s^2.
    """
    shape = (len(pose.q), 2)
    xi_dot = draw.uniform(-speed, speed, shape)
    rates = ikm(pose, xi_dot)
    xi_ddot = draw.uniform(-most, most, shape)
    acc = ikm2(rates, xi_ddot)
    return *joint_motion(rates), *acc.q_ddot.T, *acc.xi_ddot.T


def straight_paths(
    robot: Robot,
    draw: np.random.Generator,
    n: int,
    crossings: int,
    working: tuple[int, int] | None = None,
    margin: float = 0.05,
    longest: float = np.inf,
) -> Columns:
    """Return columns x0, y0, x1, y1, gamma1, gamma2 of straight paths with so many clear crossings
    of Type 2, far from Type 1.

    working: one pair of modes; None: all four, in turn. margin: smallest |sine| of a passive angle;
        longest: m.
    """
    modes = [working] if working else [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    found = []
    for mode in modes:
        lacking = math.ceil(n / len(modes))
        for _ in range(20):
            a = poses(robot, draw, 40, working=mode).xi
            b = poses(robot, draw, 40, working=mode).xi
            length = np.hypot(*(b - a).T)
            clear = _crosses(robot, a, b, mode, crossings, margin)
            rows = np.flatnonzero(clear & (length < longest))[:lacking]
            gammas = np.tile(mode, (len(rows), 1))
            found.append((*a[rows].T, *b[rows].T, *gammas.T))
            lacking -= len(rows)
            if not lacking:
                break
    return batch(*found)


def _crosses(robot, a, b, mode, crossings, margin):
    """Return whether the paths from a to b cross Type 2 so many times, clearly, far from Type 1."""
    s = np.linspace(0, 1, 161)[:, None, None]
    points = a + (b - a) * s
    pose = igm(robot, points, mode, unreachable="nan")
    det = pose.det_A
    with np.errstate(invalid="ignore"):
        smallest = np.min(np.abs(pose.sines), axis=(0, 1))
        regular = smallest > margin
        changes = det[1:] * det[:-1] < 0
        as_many = np.sum(changes, axis=0) == crossings
        if crossings:
            beyond = det * np.sign(det[0])
            clear = beyond.min(axis=0) < -0.1
        else:
            clear = np.abs(det).min(axis=0) > 0.1
    return regular & as_many & clear


def _take(robot, xi, modes, good, n):
    rows = np.flatnonzero(good)[:n] if good.dtype == bool else good
    if len(rows) < n:
        raise ValueError(f"{robot} hardly has the poses asked for: {len(rows)} of {n} found")
    return igm(robot, xi[rows], modes[rows])
