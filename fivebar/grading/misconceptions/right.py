"""The right models of the labs' functions, on columns, for both kinds of robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...models import dynamics
from ...models.dyads import RRR
from ...models.geometry import reach
from ...models.kinematics import Accelerations, Rates
from ...models.robots import Biglide, FiveBar, Robot
from ..columns import Array, Columns, inverse, motion, pose, times

Kind = type[FiveBar] | type[Biglide]


def dgm(robot: Any, q11: Array, q21: Array, assembly_mode: Any) -> Columns:
    points = [drive.pivot(drive.direction(q)) for drive, q in zip(robot.drives, (q11, q21))]
    left, right = (x + 1j * y for x, y in points)
    span, (bar, other) = right - left, robot.distal
    x, y = RRR((span.real, span.imag), bar, other, -assembly_mode).first
    end = left + bar * (x + 1j * y)
    return end.real, end.imag


def dgm_passive(robot: Robot, q11: Array, q21: Array, assembly_mode: Any) -> Columns:
    x, y = dgm(robot, q11, q21, assembly_mode)
    angles = []
    for drive, q in zip(robot.drives, (q11, q21)):
        pivot_x, pivot_y = drive.pivot(drive.direction(q))
        angles.append(drive.relative(np.arctan2(y - pivot_y, x - pivot_x), q))
    return tuple(angles)


def igm(robot: Robot, x: Array, y: Array, gamma1: Any, gamma2: Any) -> Columns:
    legs = zip(robot.drives, robot.distal, (gamma1, gamma2))
    return tuple(reach(drive, (x, y), bar, gamma).q for drive, bar, gamma in legs)


def A(robot: Robot, *q: Array) -> Array:
    return pose(robot, *q).A


def B(robot: Robot, *q: Array) -> Array:
    return pose(robot, *q).B


def compute_A_B(robot: Robot, *q: Array) -> Columns:
    return A(robot, *q), B(robot, *q)


def B_A(robot: Robot, *q: Array) -> Columns:
    return B(robot, *q), A(robot, *q)


def jacobian(robot: Robot, *q: Array) -> Array:
    return inverse(A(robot, *q)) @ B(robot, *q)


def velocity_terms(robot: Robot, *row: Array) -> Array:
    return motion(robot, *row).d


def elbows(robot: Robot, q11: Array, q21: Array) -> Columns:
    pivots = [drive.pivot(drive.direction(q)) for drive, q in zip(robot.drives, (q11, q21))]
    return *pivots[0], *pivots[1]


def left_elbow(robot: Robot, q11: Array) -> Columns:
    return elbows(robot, q11, q11)[:2]


def right_elbow(robot: Robot, q21: Array) -> Columns:
    return elbows(robot, q21, q21)[2:]


def dkm(robot: Robot, *row: Array) -> Columns:
    at = pose(robot, *row[:4])
    return times(inverse(at.A) @ at.B, *row[4:])


def ikm(robot: Robot, *row: Array) -> Columns:
    at = pose(robot, *row[:4])
    return times(inverse(at.B) @ at.A, *row[4:])


def dkm_passive(robot: Robot, *row: Array) -> Columns:
    return tuple(Rates(pose(robot, *row[:4]), row[4:6], row[6:]).q_passive_dot.T)


def dkm2(robot: Robot, *row: Array) -> Columns:
    rates = motion(robot, *row[:8])
    return times(inverse(rates.pose.A), *(times(rates.pose.B, *row[8:]) + rates.d.T))


def ikm2(robot: Robot, *row: Array) -> Columns:
    rates = motion(robot, *row[:8])
    return times(inverse(rates.pose.B), *(times(rates.pose.A, *row[8:]) - rates.d.T))


def dkm2_passive(robot: Robot, *row: Array) -> Columns:
    return tuple(Accelerations(motion(robot, *row[:8]), row[8:10], row[10:]).q_passive_ddot.T)


def dynamic_model(robot: Robot, *row: Array) -> Columns:
    return dynamics.dynamic_model(motion(robot, *row))


def inverse_dynamics(robot: Robot, *row: Array) -> Columns:
    M, c = dynamic_model(robot, *row[:8])
    return tuple(times(M, *row[8:]) + c.T)


def forward_dynamics(robot: Robot, *row: Array) -> Columns:
    M, c = dynamic_model(robot, *row[:8])
    return times(inverse(M), *(row[8:] - c.T))
