"""Paths drawn at random, limits drawn at random, and how much of its limits a motion uses."""

import numpy as np
from scipy.interpolate import BPoly, PPoly
from scipy.optimize import brentq

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line, Polynomial

BARS = {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08}


def _heavy(**more):
    return fb.FiveBar.from_links(
        0.09, 0.1, 0.08, 0.09, 0.12, BARS, payload=0.2, rotor=(1e-4, 2e-4), **more
    )


DOWN = (0.0, -9.81)
# name -> (robot, torque that is usual for it, centre and half width of a regular square, m)
ROBOTS = {
    "lab": (fb.FiveBar(), 0.1, (0.0, 0.1), 0.04),
    "heavy": (_heavy(), 0.1, (0.0, 0.1), 0.03),
    "vertical": (_heavy(gravity=DOWN), 0.8, (0.0, 0.1), 0.03),
    "rubbing": (_heavy(viscous=(0.003, 0.003), coulomb=(0.01, 0.02)), 0.15, (0.0, 0.1), 0.03),
    "all": (
        _heavy(gravity=DOWN, viscous=(3e-3, 3e-3), coulomb=(0.01, 0.02), elbows=(1e-3, 2e-3)),
        0.8,
        (0, 0.1),
        0.03,
    ),
    "biglide": (fb.Biglide(fv1=1.0, fs2=2.0, gravity=(0.0, -1.0)), 20.0, (0.0, 0.2), 0.06),
}
ELBOWS = _heavy(viscous=(0.003, 0.003), coulomb=(0.01, 0.02), elbows=(1e-3, 2e-3))


def bezier(control, length):
    """The piece of a path with these control points (degree + 1, 2)."""
    curve = BPoly(np.asarray(control, float)[:, None], [0, 1])
    return Polynomial(PPoly.from_bernstein_basis(curve).c[::-1, 0], length)


def random_path(rng, centre, width):
    """A Bezier curve, a polyline that stops at its corners, or an arc, in a square."""
    points = np.array(centre) + rng.uniform(-width, width, (rng.integers(4, 9), 2))
    kind = rng.integers(3)
    if kind == 0:
        return Path((bezier(points, np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),))
    if kind == 1:
        return Path(tuple(Line(tuple(a), tuple(b)) for a, b in zip(points[:-1], points[1:])))
    middle = np.array(centre) + rng.uniform(-width, width, 2) / 2
    return Path((Arc(tuple(middle), width * rng.uniform(0.05, 0.5), *rng.uniform(-7, 7, 2)),))


def almost_along_the_bars(angle, bend=0.004):
    """A curve of 40 mm through a place on Type 2 of the lab's robot, there at this angle, rad, to its bars."""
    robot = fb.FiveBar()
    place = np.array(
        [brentq(lambda x: fb.igm(robot, (x, 0.05)).det_A, -0.09, -0.085, xtol=1e-16), 0.05]
    )
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    bar = np.array(fb.igm(robot, place).u2[0])
    along = turn.T @ bar
    across = np.array([-along[1], along[0]])
    points = place + np.outer([-0.02, 0.0, 0.02], along) + np.outer([bend, -bend, bend], across)
    return Path((bezier(points, 0.04),))


def random_limits(rng, robot, torque):
    limits = {"torque": torque * rng.uniform(0.5, 2)}
    if rng.random() < 0.3:
        limits["joint_speed"] = rng.uniform(1, 6) * (1.0 if robot.turns else 0.2)
    if rng.random() < 0.3:
        limits["acceleration"] = rng.uniform(1, 6)
    if rng.random() < 0.3:
        limits["joint_acceleration"] = rng.uniform(10, 60)
    if rng.random() < 0.2:
        limits["speed"] = rng.uniform(0.1, 0.5)
    return limits


def used(motion, limits, finer=100):
    """The largest share of any limit that a motion uses, at `finer` times as many places as it has stretches.

    By `inverse_dynamics` alone; so near Type 2 that it has no digits left, not at all.
    """
    inside = (np.arange(finer) + 0.5) / finer
    begins, ends = motion.times[:-1, None], motion.times[1:, None]
    t = (begins + (ends - begins) * inside).ravel()
    acc = motion.accelerations(t)
    clear = np.abs(acc.rates.pose.det_A) > 1e-6
    values = {
        "torque": np.abs(fb.inverse_dynamics(motion.accelerations(t[clear]))),
        "joint_speed": np.abs(acc.rates.q_dot),
        "joint_acceleration": np.abs(acc.q_ddot),
        "acceleration": np.linalg.norm(motion(t)[2], axis=-1),
        "speed": np.linalg.norm(acc.rates.xi_dot, axis=-1),
    }
    return max(float((values[name] / limit).max()) for name, limit in limits.items())
