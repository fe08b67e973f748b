"""Poses and robots to ask about, drawn at random in the region that a check is for."""

from __future__ import annotations

import numpy as np

from ..models.geometry import Pose, igm
from ..models.kinematics import ikm, ikm2
from ..models.robots import Biglide, FiveBar, Robot
from .columns import Columns, joint_motion

HEIGHT = (
    0.5  # of a biglide's end-effector over the feet's zero, at most, m: its guides have no ends
)
TRIED = 200  # poses for each one that is kept beside Type 1


def unequal_robot(draw: np.random.Generator) -> FiveBar:
    """Return a robot whose four bars differ by at least 7 mm, rounded to tenths of a millimetre."""
    bars = draw.permutation([0.080, 0.095, 0.110, 0.130]) + draw.uniform(-0.004, 0.004, 4)
    rest = draw.uniform((0.09, 0.001, 0.001, 0.3), (0.13, 0.004, 0.004, 0.9))
    if abs(rest[2] - rest[1]) < 5e-4:
        rest[2] += 1e-3  # one inertia for both legs shall be seen
    return FiveBar(*np.round([*bars, *rest], 4).tolist())


def unequal_biglide(draw: np.random.Generator) -> Biglide:
    """Return a biglide of bars that differ by at least 3 cm and feet by 0.2 kg; rounded to 0.1 mm
    and 1 g.

    Its guides are so close that it closes even with twice their distance, a misconception that
    shall be seen.
    """
    bars = draw.permutation([0.26, 0.32]) + draw.uniform(-0.015, 0.015, 2)
    masses = draw.permutation([0.7, 1.3]) + draw.uniform(-0.2, 0.2, 2)
    return Biglide(
        *np.round([*bars, draw.uniform(0.14, 0.22)], 4), *np.round([*masses, draw.uniform(2, 4)], 3)
    )


def poses(
    robot: Robot,
    draw: np.random.Generator,
    n: int,
    assembly: int | None = None,
    working: tuple[int, int] | None = None,
    margin: float = 0.2,
) -> Pose:
    """Return n poses as one batch, of these modes (None: any), every |sin| between bars, or bar and
    guide, over `margin`.

    The end-effector is drawn uniformly. ValueError where the robot hardly has such poses.
    """
    low, high = _ends(robot)
    for count in (25 * n, 400 * n):  # the second draw is seldom needed, and dear
        xi = draw.uniform(low, high, (count, 2))
        modes = (
            draw.choice([-1, 1], (count, 2))
            if working is None
            else np.broadcast_to(working, xi.shape)
        )
        pose = igm(robot, xi, modes, unreachable="nan")
        good = np.min(np.abs([*pose.sines, pose.det_A]), axis=0) > margin
        if assembly is not None:
            good &= pose.assembly == assembly
        if np.count_nonzero(good) >= n:
            break
    return _take(robot, xi, modes, good, n)


def _ends(robot):
    """Return the lowest and the highest coordinates of the end-effector to be tried."""
    legs = list(zip(robot.drives, robot.distal))
    if robot.turns:
        reach = max(drive.length + bar for drive, bar in legs) + robot.d / 2
        return -reach, reach
    return (max(drive.x - bar for drive, bar in legs), -HEIGHT), (
        min(drive.x + bar for drive, bar in legs),
        HEIGHT,
    )


def beside_type_1(
    robot: Robot, draw: np.random.Generator, sines: np.ndarray, leg: int, margin: float = 0.2
) -> Pose:
    """Return poses in which leg 0 or 1 is almost stretched, or across its guide: `sines` (n,) of
    its passive angle.

    The signs of the sines are free.
    """
    n, drive, bar = len(sines), robot.drives[leg], robot.distal[leg]
    sines = np.repeat(np.abs(sines), TRIED)
    if robot.turns:
        span = np.sqrt(drive.length**2 + bar**2 + 2 * drive.length * bar * np.sqrt(1 - sines**2))
        angle = draw.uniform(-np.pi, np.pi, TRIED * n)
        away = span * np.cos(angle), span * np.sin(angle)
    else:
        inwards = 1 if leg == 0 else -1
        away = inwards * bar * np.sqrt(1 - sines**2), draw.uniform(-HEIGHT, HEIGHT, TRIED * n)
    xi = np.stack([drive.x + away[0], drive.y + away[1]], axis=-1)
    modes = draw.choice([-1, 1], (TRIED * n, 2))
    pose = igm(robot, xi, modes, unreachable="nan")
    good = np.min(np.abs([pose.sines[1 - leg], pose.det_A]), axis=0) > margin
    first = [np.flatnonzero(part)[:1] + TRIED * k for k, part in enumerate(good.reshape(n, TRIED))]
    return _take(robot, xi, modes, np.concatenate(first), n)


def beside_type_2(
    robot: Robot, draw: np.random.Generator, sines: np.ndarray, margin: float = 0.2
) -> Pose:
    """Return poses with det A = `sines` (n,), signed, both legs regular; by bisection between poses
    on both sides.
    """
    n = len(sines)
    ends = []
    # A biglide whose feet are both above or both below its end-effector has no Type 2.
    modes = (
        draw.choice([-1, 1], (16, 1, 2))
        if robot.turns
        else draw.choice([(1, -1), (-1, 1)], (16, 1))
    )
    for sign in (-1, 1):
        parts = [poses(robot, draw, 2 * n, assembly=-sign, working=mode[0]).xi for mode in modes]
        ends.append(np.array(parts))
    below, above = ends
    modes = np.broadcast_to(modes, below.shape)
    target = np.broadcast_to(np.tile(sines, 2), below.shape[:2])
    for _ in range(60):
        middle = (below + above) / 2
        under = (igm(robot, middle, modes, unreachable="nan").det_A < target)[..., None]
        below, above = np.where(under, middle, below), np.where(under, above, middle)
    pose = igm(robot, above, modes, unreachable="nan")
    good = np.min(np.abs(pose.sines), axis=0) > margin
    good &= np.abs(pose.det_A - target) < 1e-12
    good = good.reshape(len(modes), 2, n).reshape(-1, n)
    rows = np.argmax(good, axis=0)
    if not good[rows, np.arange(n)].all():
        raise ValueError(f"{robot} hardly has poses beside Type 2")
    return igm(
        robot,
        above.reshape(-1, n, 2)[rows, np.arange(n)],
        modes.reshape(-1, n, 2)[rows, np.arange(n)],
    )


def moving(pose: Pose, draw: np.random.Generator, speed: float = 0.3) -> Columns:
    """Return the joint columns of poses in motion, the end-effector at most this fast along x and
    y, m/s.
    """
    return joint_motion(ikm(pose, draw.uniform(-speed, speed, (len(pose.q), 2))))


def accelerated(
    pose: Pose, draw: np.random.Generator, speed: float = 0.3, most: float = 2.0
) -> Columns:
    """Return the columns that dkm2_passive asks for, the end-effector's acceleration at most `most`
    along x and y, m/s^2.
    """
    rates = ikm(pose, draw.uniform(-speed, speed, (len(pose.q), 2)))
    acc = ikm2(rates, draw.uniform(-most, most, (len(pose.q), 2)))
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
    s = np.linspace(0, 1, 161)[:, None, None]
    found = []
    for mode in modes:
        lacking = -(-n // len(modes))
        for _ in range(20):
            a, b = (poses(robot, draw, 40, working=mode).xi for _ in range(2))
            pose = igm(robot, a + (b - a) * s, mode, unreachable="nan")
            p, serial = pose.det_A, np.min(np.abs(pose.sines), axis=(0, 1))
            with np.errstate(invalid="ignore"):
                clear = (serial > margin) & (np.sum(p[1:] * p[:-1] < 0, axis=0) == crossings)
                clear &= (
                    (p * np.sign(p[0])).min(axis=0) < -0.1
                    if crossings
                    else np.abs(p).min(axis=0) > 0.1
                )
            rows = np.flatnonzero(clear & (np.hypot(*(b - a).T) < longest))[:lacking]
            found.append((*a[rows].T, *b[rows].T, *np.tile(mode, (len(rows), 1)).T))
            lacking -= len(rows)
            if not lacking:
                break
    return tuple(np.concatenate(columns) for columns in zip(*found))


def _take(robot, xi, modes, good, n):
    rows = np.flatnonzero(good)[:n] if good.dtype == bool else good
    if len(rows) < n:
        raise ValueError(f"{robot} hardly has the poses asked for: {len(rows)} of {n} found")
    return igm(robot, xi[rows], modes[rows])
