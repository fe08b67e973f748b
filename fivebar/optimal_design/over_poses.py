"""Figures of merit over a table or a disc, in closed form in each pose, for many robots at once.

What is worst over the nodes; nan where a robot does not reach all of the table or disc, or meets a
singularity between two nodes: 0 is a figure of a robot that does the task. All follow from the
legs' sines s_i and the distal bars' sine det A and cosine g: with b_i = l_i1 s_i, J = A^-1 B has
columns of lengths |b_i / det A| and an angle whose cosine is -+ g.
"""

from __future__ import annotations

from functools import cached_property, reduce

import numpy as np

from ..models.dyads import dot
from ..models.geometry import task_pose
from .batch import Robots
from .task import Task

ROUNDING = 1e-15  # of a leg, by which a table that is as large as its reach may be larger
BLOCK = 16384  # poses at once: what they take stays in the processor's cache


class TaskPoses:
    """Robots in columns (n, 1) at the nodes of a task, (n, p) poses; place: (n, 2) m, the origin of
    each one's task.
    """

    def __init__(self, robots: Robots, task: Task, place: np.ndarray):
        self.robots = robots
        self.task = task
        self.place = place
        nodes, self.area, self.polar = task.nodes
        self.point = tuple(
            nodes[:, k] + place[:, k, None] if place[:, k].any() else nodes[None, :, k]
            for k in (0, 1)
        )
        self.pose = task_pose(robots, self.point, task.working)
        self.sines = self.pose.sines
        self.det_A = self.pose.det_A

    @cached_property
    def b(self):
        """|l_i1 sin q_i2|."""
        return tuple(
            np.abs(length * s) for length, s in zip((self.robots.l11, self.robots.l21), self.sines)
        )

    @cached_property
    def g(self):
        return dot(*self.pose.u2)

    @cached_property
    def reach(self):
        """(n,): how far the whole table or disc is inside the rings of both legs, m."""
        x, y = self.place.T
        clearances = []
        for drive, distal in zip(self.robots.drives, self.robots.distal):
            near, far = _distances(self.task, x - drive.x[:, 0], y - drive.y)
            outer = (drive.length + distal)[:, 0]
            inner = np.abs(drive.length - distal)[:, 0]
            clearances += [outer - far, near - inner]
        return np.min(clearances, axis=0)

    @cached_property
    def reaches(self):
        """(n,): all of it, without a change of sign of det A between its nodes."""
        with np.errstate(invalid="ignore"):
            low = self.det_A.min(axis=1)
            high = self.det_A.max(axis=1)  # nan where one is not reached
            allowed = ROUNDING * (self.robots.l11 + self.robots.l12)[:, 0]
            return (low * high > 0) & (self.reach >= -allowed)

    def where_done(self, figure):
        """Return a figure (n,), nan of the robots that do not do the task."""
        return np.where(self.reaches, figure, np.nan)

    def least(self, values):
        """Return (n,) the least over the nodes."""
        with np.errstate(invalid="ignore"):
            return self.where_done(values.min(axis=1))

    @cached_property
    def stretch(self):
        """2 sigma_max(J)^2 det A^2 = b1^2 + b2^2 + sqrt((b1^2 - b2^2)^2 + (2 g b1 b2)^2)."""
        b1, b2 = self.b
        apart = (b1 - b2) * (b1 + b2)
        across = 2 * self.g * b1 * b2
        return b1 * b1 + b2 * b2 + np.sqrt(apart * apart + across * across)

    @cached_property
    def conditioning(self):
        """1 / kappa(J): sigma_min / sigma_max = |b1 b2 det A| / (sigma_max det A)^2."""
        b1, b2 = self.b
        with np.errstate(invalid="ignore"):
            return (
                2 * b1 * b2 * np.abs(self.det_A) / np.maximum(self.stretch, 1e-300)
            )  # 0 where both are 0

    def mean(self, values, weights):
        return self.where_done((values * weights).sum(axis=1))


def _distances(task, x, y):
    """Return the least and the largest distance, (n,) m, of a task from points, where its origin is
    at (x, y) from them; the least is negative where the point is in it, by how deep.
    """
    # A disc is a point with a radius.
    cx, cy, radius = task.disc or (0.0, 0.0, 0.0)
    x0, x1, y0, y1 = task.table or (cx, cx, cy, cy)
    left, right, below, above = x + x0, x + x1, y + y0, y + y1
    dx = np.maximum(left, -right)
    dy = np.maximum(below, -above)
    near = np.hypot(np.maximum(dx, 0), np.maximum(dy, 0)) + np.minimum(np.maximum(dx, dy), 0)
    far = np.hypot(np.maximum(right, -left), np.maximum(above, -below))
    return near - radius, far + radius


def _det_a(poses):
    return poses.least(np.abs(poses.det_A))


def _sine(poses):
    return poses.least(np.minimum(*map(np.abs, poses.sines)))


def _transmission(poses):
    return np.arcsin(np.clip(_det_a(poses), 0, 1))


def _stiffness(poses):
    """Compliance J J^T / k is largest along sigma_max."""
    with np.errstate(divide="ignore"):
        return poses.least(2 * poses.task.stiffness * poses.det_A**2 / poses.stretch)


def _tip_speed(poses):
    """q_i' = u_i2 . xi' / b_i: the fastest turn for a speed is along the distal bar."""
    return poses.task.motor.speed * poses.least(np.minimum(*poses.b))


def _tip_force(poses):
    """tau_i = f . (column i of J), whose length is |b_i / det A|."""
    with np.errstate(divide="ignore"):
        return poses.task.motor.torque * poses.least(np.abs(poses.det_A) / np.maximum(*poses.b))


def _tip_error(poses):
    """Return a dxi = b_i dq_i + cos q_i2 dl_i1 + dl_i2 -+ x_i2 dd / 2 to first order; the worst is
    at a corner of the box.
    """
    t = {"q": 0.0, "l": 0.0, "d": 0.0} | poses.task.tolerances
    own = [
        b * t["q"] + (np.abs(leg.cosine) + 1) * t["l"] for b, leg in zip(poses.b, poses.pose.legs)
    ]
    base = [side * u[0] * t["d"] / 2 for side, u in zip((-1, 1), poses.pose.u2)]
    worst = 0.0
    for other in (1, -1):
        for turn in (1, -1):
            r1 = own[0] + turn * base[0]
            r2 = other * own[1] + turn * base[1]
            worst = np.maximum(worst, r1 * r1 + r2 * r2 - 2 * poses.g * r1 * r2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return poses.where_done((np.sqrt(worst) / np.abs(poses.det_A)).max(axis=1))


def _footprint(poses):
    """Return the area of the box around base joints, elbows and end-effector."""
    half = poses.robots.d / 2
    points = [poses.point, (half, 0 * half), (-half, 0 * half)]
    for drive, leg in zip(poses.robots.drives, poses.pose.legs):
        points.append(drive.pivot(leg.direction))
    area = 1.0
    for parts in zip(*points):
        high = reduce(np.maximum, [part.max(axis=1) for part in parts])
        low = reduce(np.minimum, [part.min(axis=1) for part in parts])
        area = area * (high - low)
    return poses.where_done(area)


def _one(robots, task):
    return np.ones(len(robots.d))


def _right_angle(robots, task):
    return np.full(len(robots.d), np.pi / 2)


def _speed_bound(robots, task):
    return task.motor.speed * np.minimum(robots.l11, robots.l21)[:, 0]


def _footprint_bound(robots, task):
    nodes = task.nodes[0]
    return np.full(len(robots.d), np.prod(np.ptp(nodes, axis=0)))


# Name, unit, better, words, of, needs, bound.
OVER_POSES = (
    (
        "reach",
        "m",
        "large",
        (
            "how far the whole table is inside what each leg reaches; < 0: out of reach, or a base"
            " joint is in it"
        ),
        lambda poses: poses.reach,
        ("table",),
    ),
    (
        "det_A",
        "",
        "large",
        "the least |det A| = |sin(phi2 - phi1)|: 0 at Type 2",
        _det_a,
        ("table",),
        _one,
    ),
    ("sin", "", "large", "the least |sin q_i2| of both legs: 0 at Type 1", _sine, ("table",), _one),
    (
        "transmission_angle",
        "rad",
        "large",
        "the least acute angle between the distal bars",
        _transmission,
        ("table",),
        _right_angle,
    ),
    (
        "conditioning",
        "",
        "large",
        "the least 1 / kappa(J)",
        lambda poses: poses.least(poses.conditioning),
        ("table",),
        _one,
    ),
    (
        "global_conditioning",
        "",
        "large",
        "mean of 1 / kappa(J) over the area",
        lambda poses: poses.mean(poses.conditioning, poses.area),
        ("table",),
        _one,
    ),
    (
        "global_conditioning_polar",
        "",
        "large",
        (
            "mean of 1 / kappa(J) over radius and angle of a disc, unweighted: the measure of Liu's"
            " published indices"
        ),
        lambda poses: poses.mean(poses.conditioning, poses.polar),
        ("disc",),
        _one,
    ),
    (
        "stiffness",
        "N/m",
        "large",
        "the least, over directions too, of the motors' stiffness at the end-effector",
        _stiffness,
        ("table", "stiffness"),
    ),
    (
        "tip_speed",
        "m/s",
        "large",
        "speed that the motors have in every direction everywhere",
        _tip_speed,
        ("table", "motor"),
        _speed_bound,
    ),
    (
        "tip_force",
        "N",
        "large",
        "force that the motors hold in every direction everywhere",
        _tip_force,
        ("table", "motor"),
    ),
    (
        "worst_tip_error",
        "m",
        "small",
        "the largest error of the end-effector under the tolerances, to first order",
        _tip_error,
        ("table", "tolerances"),
    ),
    (
        "footprint",
        "m²",
        "small",
        "box around base joints, elbows and end-effector while it works",
        _footprint,
        ("table",),
        _footprint_bound,
    ),
)
