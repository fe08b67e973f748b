"""Figures of merit that are computed robot by robot: exact regions, published circles, what a
motion asks for.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ..base.errors import SingularityError
from ..constraints.constraints import Constraints
from ..constraints.disc import largest_disc
from ..constraints.rectangle import largest_rectangle
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from ..paths.placement import Placement
from ..paths.timing.time_path import TimingError, time_path
from ..singularities.aspects import aspects
from ..singularities.dexterous import dexterous
from ..singularities.distance import locus_distance
from ..singularities.margins import singularity_margins
from .closed_forms import workspace_bound
from .task import Task

RADII = 101  # of nodes in the circle
ANGLES = 180
GAP = 5e-3  # of a path's time: a fifth of the work of a gap of 1e-3
CENTRES = 400  # along the axis, among which the largest circle is searched


def _regions(robot, task):
    """Return the parts of the task's working mode without singularity, or those that keep det_A and
    sin.
    """
    if task.det_A or task.sin:
        found = dexterous(robot, det_A=task.det_A, sin=task.sin)
    else:
        found = aspects(robot)
    return [part for part in found if part.working == task.working]


def _dexterous_area(robot, task, place):
    return max((part.area for part in _regions(robot, task)), default=0.0)


def _of_parts(measure, most):
    """Return the largest over the parts, 0 where none has room for the margin; most: what a part of
    an area has at most.
    """

    def of(robot, task, place):
        best = 0.0
        for part in sorted(_regions(robot, task), key=lambda part: -part.area):
            if most(part.area) > best:
                with suppress(ValueError):  # it has no room for the margin
                    best = max(best, measure(part, task.margin))
        return best

    return of


_largest_disc = _of_parts(
    lambda part, margin: largest_disc(part, Constraints(clearance=margin)).radius,
    lambda area: np.sqrt(area / np.pi),
)
_largest_rectangle = _of_parts(
    lambda part, margin: largest_rectangle(part, Constraints(clearance=margin)).area,
    lambda area: area,
)


def _inscribed_circle(robot, task, place):
    return _circle(robot)[1]


def _inscribed_conditioning(robot, task, place):
    """1 / kappa(J) is 0 where the circle touches a locus, and beside by rounding."""
    y, radius = _circle(robot)
    if not radius:
        return 0.0
    points, _, polar = Task(disc=(0.0, y, radius), poses=(RADII, ANGLES)).nodes
    pose = igm(robot, points, (1, -1), unreachable="nan")
    return polar @ np.nan_to_num(1 / singularity_margins(pose).condition.J)


def _circle(robot):
    """Return (y, radius) of Liu's MIC, on a symmetric robot's axis, above its stretched locus, in
    the modes (1, -1).
    """
    if robot.l11 != robot.l21 or robot.l12 != robot.l22:
        raise ValueError(
            "the circle that Liu publishes is of symmetric robots: l11 = l21 and l12 = l22"
        )
    outer = robot.l11 + robot.l12
    half = robot.d / 2
    top = np.sqrt(max(outer * outer - half * half, 0.0))
    # Ever denser upwards: of short distal bars the locus is next to the top.
    y = top * (1 - (np.arange(CENTRES, 0, -1) / (CENTRES + 1)) ** 4)
    pose = igm(robot, np.stack([0 * y, y], axis=-1), (1, -1), unreachable="nan")
    below = np.flatnonzero(pose.assembly != pose.assembly[-1])
    low = y[below[-1] + 1 if len(below) else 0]
    high = top
    # The clearance has a kink where it is largest: the best of many heights is next to it.
    while True:
        heights = np.linspace(low, high, CENTRES + 1)
        points = np.stack([0 * heights, heights], axis=-1)
        room = locus_distance(robot, points, (1, -1))[0]
        best = int(np.argmax(room))
        low = heights[max(best - 1, 0)]
        high = heights[min(best + 1, CENTRES)]
        if high - low <= 1e-15 * top:
            return float(heights[best]), float(room[best])


def _moved(robot, task, place):
    """Return accelerations at the samples of the motion."""
    _, xi, xi_dot, xi_ddot = task.motion
    pose = igm(robot, xi + place, task.working)
    if not (pose.det_A.min() * pose.det_A.max() > 0):
        raise SingularityError("the motion goes through Type 2", 0.0)
    return ikm2(ikm(pose, xi_dot), xi_ddot)


def _worst_torque(robot, task, place):
    return np.abs(inverse_dynamics(_moved(robot, task, place))).max()


def _worst_speed(robot, task, place):
    return np.abs(_moved(robot, task, place).rates.q_dot).max()


def _time(robot, task, place):
    """Run s times as fast, tau = a s^2 + v s + c in each sample: the first s at which a motor is at
    its limit, |tau| = torque or |tau + s q' stall / speed| = stall.
    """
    moved = _moved(robot, task, place)
    _, xi, xi_dot, xi_ddot = task.motion
    s = 0.5, 1.0, 2.0
    at = [
        inverse_dynamics(ikm2(ikm(moved.rates.pose, k * xi_dot), k * k * xi_ddot)).ravel()
        for k in s
    ]
    a, v, c = np.linalg.solve(np.vander(s), at)
    if np.abs(c).max() >= task.motor.torque:
        return np.inf  # it cannot even be held
    motor = task.motor
    line = v + moved.rates.q_dot.ravel() * (motor.stall / motor.speed)
    fastest = np.inf
    for sign in (1, -1):
        fastest = min(fastest, _first_root(a, v, c - sign * motor.torque))
        fastest = min(fastest, _first_root(a, line, c - sign * motor.stall))
    return float(task.motion.duration / fastest)


def _path_time(robot, task, place):
    """Return the upper bound, within a share GAP of the lower one; inf where the motors cannot
    follow the path.
    """
    moved = Placement(tuple(place.tolist()))(task.path)
    limits = Constraints(motors=task.motor)
    try:
        motion = time_path(robot, moved, constraints=limits, working=task.working, gap=GAP)
        return motion.duration
    except TimingError as error:
        if error.proved:
            return np.inf
        raise  # it was not found in time


def _first_root(a, v, c):
    """Return the least s > 0 with a s^2 + v s + c = 0 in any row, inf where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(v * v - 4 * a * c)  # nan where there is none
        q = -(v + np.copysign(root, v)) / 2
        found = np.concatenate([q / a, c / q])
    found = found[np.isfinite(found) & (found > 0)]
    return float(found.min(initial=np.inf))


def _regions_bound(robots, task):
    """Return a disc in a ring of the width 2 min(l_i1, l_i2) that a leg sweeps."""
    return np.minimum(np.minimum(robots.l11, robots.l12), np.minimum(robots.l21, robots.l22))[:, 0]


def _square_bound(robots, task):
    """Return the square in the smaller of the two outer discs."""
    return workspace_bound(robots, task) * (2 / np.pi)


# Name, unit, better, words, of, needs, bound.
ONE_BY_ONE = (
    (
        "dexterous_area",
        "m²",
        "large",
        "the largest part of the working mode with |det A| >= det_A, |sin q_i2| >= sin",
        _dexterous_area,
        (),
        workspace_bound,
    ),
    (
        "largest_disc",
        "m",
        "large",
        "radius of the largest disc in such a part",
        _largest_disc,
        (),
        _regions_bound,
    ),
    (
        "largest_rectangle",
        "m²",
        "large",
        "the largest rectangle along x and y in such a part",
        _largest_rectangle,
        (),
        _square_bound,
    ),
    (
        "inscribed_circle",
        "m",
        "large",
        "radius of Liu's maximal inscribed circle, of a symmetric robot",
        _inscribed_circle,
        (),
        _regions_bound,
    ),
    (
        "inscribed_conditioning",
        "",
        "large",
        "the same mean as Liu's, of 1 / kappa(J), over that circle",
        _inscribed_conditioning,
        (),
    ),
    (
        "worst_torque",
        "N m",
        "small",
        "the largest torque of a motor in the motion",
        _worst_torque,
        ("motion",),
    ),
    (
        "worst_speed",
        "rad/s",
        "small",
        "the largest speed of a motor in the motion",
        _worst_speed,
        ("motion",),
    ),
    (
        "time",
        "s",
        "small",
        "of the motion run faster or slower as a whole, as fast as the motors can",
        _time,
        ("motion", "motor"),
    ),
    (
        "path_time",
        "s",
        "small",
        "the least in which the motors can follow the path at any speed; at most 0.5 % too long",
        _path_time,
        ("path", "motor"),
    ),
)
