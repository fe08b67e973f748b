"""Poses and robots to ask about, drawn at random in the region that a check is for."""

import numpy as np

from ..models.geometry import igm
from ..models.robots import FiveBar


def unequal_robot(draw):
    """A robot whose four bars differ by at least 7 mm, rounded to tenths of a millimetre."""
    bars = draw.permutation([0.080, 0.095, 0.110, 0.130]) + draw.uniform(-0.004, 0.004, 4)
    rest = draw.uniform((0.09, 0.001, 0.001, 0.3), (0.13, 0.004, 0.004, 0.9))
    return FiveBar(*np.round([*bars, *rest], 4).tolist())


def poses(robot, draw, n, assembly=None, working=None, margin=0.2):
    """n poses as one batch, of these modes (None: any), every |sin| between bars at least `margin`.

    The end-effector is drawn uniformly. ValueError where the robot hardly has such poses.
    """
    reach = max(robot.l11 + robot.l12, robot.l21 + robot.l22) + robot.d / 2
    for count in (25 * n, 400 * n):  # the second draw is seldom needed, and dear
        xi = draw.uniform(-reach, reach, (count, 2))
        modes = draw.choice([-1, 1], (count, 2)) if working is None else np.broadcast_to(working, xi.shape)
        pose = igm(robot, xi, modes, unreachable="nan")
        good = np.min(np.abs([*pose.sines, pose.det_A]), axis=0) > margin
        if assembly is not None:
            good &= pose.assembly == assembly
        if np.count_nonzero(good) >= n:
            break
    return _take(robot, xi, modes, good, n)


def beside_type_1(robot, draw, sines, leg, margin=0.2):
    """Poses in which leg 0 or 1 is almost stretched: `sines` (n,) of its passive angle, their signs free."""
    n, drive, bar = len(sines), robot.drives[leg], robot.distal[leg]
    sines = np.repeat(np.abs(sines), 200)
    span = np.sqrt(drive.length**2 + bar**2 + 2 * drive.length * bar * np.sqrt(1 - sines**2))
    angle = draw.uniform(-np.pi, np.pi, 200 * n)
    xi = np.stack([drive.x + span * np.cos(angle), drive.y + span * np.sin(angle)], axis=-1)
    modes = draw.choice([-1, 1], (200 * n, 2))
    pose = igm(robot, xi, modes, unreachable="nan")
    good = np.min(np.abs([pose.sines[1 - leg], pose.det_A]), axis=0) > margin
    first = [np.flatnonzero(part)[:1] + 200 * k for k, part in enumerate(good.reshape(n, 200))]
    return _take(robot, xi, modes, np.concatenate(first), n)


def beside_type_2(robot, draw, sines, margin=0.2):
    """Poses with det A = `sines` (n,), signed, both legs regular; by bisection between poses on both sides."""
    n = len(sines)
    ends = []
    modes = draw.choice([-1, 1], (16, 1, 2))
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
    return igm(robot, above.reshape(-1, n, 2)[rows, np.arange(n)], modes.reshape(-1, n, 2)[rows, np.arange(n)])


def straight_paths(robot, draw, n, crossings, working=None, margin=0.05, longest=np.inf):
    """Columns x0, y0, x1, y1, gamma1, gamma2 of straight paths with so many clear crossings of Type 2, far from Type 1.

    working: one pair of modes; None: all four, in turn. margin: smallest |sine| of a passive angle; longest: m.
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
                clear &= (p * np.sign(p[0])).min(axis=0) < -0.1 if crossings else np.abs(p).min(axis=0) > 0.1
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
