"""Poses and biglides to ask about, drawn at random in the region that a check is for."""

import numpy as np

from ..models.geometry import igm
from ..models.robots import Biglide

MODES = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
HEIGHT = 0.5  # of the end-effector over the feet's zero, at most, m


def unequal_biglide(draw):
    """A biglide of bars that differ by at least 3 cm and feet by 0.2 kg; rounded to 0.1 mm and 1 g.

    Its guides are so close that it closes even with twice their distance, a misconception that shall be seen.
    """
    bars = draw.permutation([0.26, 0.32]) + draw.uniform(-0.015, 0.015, 2)
    masses = draw.permutation([0.7, 1.3]) + draw.uniform(-0.2, 0.2, 2)
    return Biglide(*np.round([*bars, draw.uniform(0.14, 0.22)], 4), *np.round([*masses, draw.uniform(2, 4)], 3))


def poses(robot, draw, n, assembly=None, working=None, margin=0.2):
    """n poses as one batch, of these modes (None: any), every |sin| between bars or bar and guide at least `margin`."""
    xi = _points(robot, draw, 400 * n)
    modes = draw.choice([-1, 1], (400 * n, 2)) if working is None else np.broadcast_to(working, xi.shape)
    pose = igm(robot, xi, modes)
    good = np.min(np.abs([*pose.sines, pose.det_A]), axis=0) > margin
    if assembly is not None:
        good &= pose.assembly == assembly
    return _first(robot, xi, modes, good, n)


def beside_type_1(robot, draw, sines, leg, margin=0.2):
    """Poses in which the bar of leg 0 or 1 is almost across its guide: `sines` (n,) of its angle, their signs free."""
    n, drive, bar = len(sines), robot.drives[leg], robot.distal[leg]
    inwards = 1 if leg == 0 else -1
    x = drive.x + inwards * bar * np.sqrt(1 - np.asarray(sines) ** 2)
    xi = np.stack([x, draw.uniform(-HEIGHT, HEIGHT, n)], axis=-1)
    pose = igm(robot, xi, draw.choice(MODES, n))
    if np.min(np.abs([pose.sines[1 - leg], pose.det_A])) < margin:
        raise ValueError(f"{robot} hardly has poses beside Type 1")
    return pose


def beside_type_2(robot, draw, sines):
    """Poses with det A = `sines` (n,), signed, far from Type 1; by bisection over x, in unlike working modes."""
    sines = np.asarray(sines)
    modes = draw.choice([(1, -1), (-1, 1)], len(sines))
    low, high = (np.full(len(sines), x) for x in _limits(robot, 0.3))
    y = draw.uniform(-HEIGHT, HEIGHT, len(sines))

    def off(x):
        return igm(robot, np.stack([x, y], axis=-1), modes).det_A - sines

    rising = off(high) > 0
    if np.any(rising == (off(low) > 0)):
        raise ValueError(f"{robot} hardly has poses beside Type 2")
    for _ in range(60):
        middle = (low + high) / 2
        beyond = (off(middle) > 0) == rising
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return igm(robot, np.stack([high, y], axis=-1), modes)


def _limits(robot, sine):
    """Between these x of the end-effector both bars' angles have at least this |sin|."""
    reach = np.sqrt(1 - sine**2) * np.array(robot.distal)
    return max(-robot.d / 2 - reach[0], robot.d / 2 - reach[1]), min(-robot.d / 2 + reach[0], robot.d / 2 + reach[1])


def _points(robot, draw, n):
    return np.stack([draw.uniform(*_limits(robot, 0.0), n), draw.uniform(-HEIGHT, HEIGHT, n)], axis=-1)


def _first(robot, xi, modes, good, n):
    rows = np.flatnonzero(good)[:n]
    if len(rows) < n:
        raise ValueError(f"{robot} hardly has the poses asked for: {len(rows)} of {n} found")
    return igm(robot, xi[rows], modes[rows])
