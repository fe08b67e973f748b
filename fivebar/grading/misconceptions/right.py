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
    x_left, y_left, x_right, y_right = elbows(robot, q11, q21)
    left = x_left + 1j * y_left
    right = x_right + 1j * y_right
    span = right - left
    bar, other = robot.distal
    dyad = RRR((span.real, span.imag), bar, other, -assembly_mode)
    x, y = dyad.first
    direction = x + 1j * y
    end = left + bar * direction
    return end.real, end.imag


def dgm_passive(robot: Robot, q11: Array, q21: Array, assembly_mode: Any) -> Columns:
    x, y = dgm(robot, q11, q21, assembly_mode)
    angles = []
    for drive, q in zip(robot.drives, (q11, q21)):
        pivot_x, pivot_y = drive.pivot(drive.direction(q))
        absolute = np.arctan2(y - pivot_y, x - pivot_x)
        angles.append(drive.relative(absolute, q))
    return tuple(angles)


def igm(robot: Robot, x: Array, y: Array, gamma1: Any, gamma2: Any) -> Columns:
    modes = (gamma1, gamma2)
    active = []
    for drive, bar, gamma in zip(robot.drives, robot.distal, modes):
        leg = reach(drive, (x, y), bar, gamma)
        active.append(leg.q)
    return tuple(active)


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
    left, right = robot.drives
    first = left.pivot(left.direction(q11))
    second = right.pivot(right.direction(q21))
    return *first, *second


def left_elbow(robot: Robot, q11: Array) -> Columns:
    return elbows(robot, q11, q11)[:2]


def right_elbow(robot: Robot, q21: Array) -> Columns:
    return elbows(robot, q21, q21)[2:]


def dkm(robot: Robot, *row: Array) -> Columns:
    J = jacobian(robot, *row[:4])
    return times(J, *row[4:])


def ikm(robot: Robot, *row: Array) -> Columns:
    at = pose(robot, *row[:4])
    J_inverse = inverse(at.B) @ at.A
    return times(J_inverse, *row[4:])


def dkm_passive(robot: Robot, *row: Array) -> Columns:
    at = pose(robot, *row[:4])
    rates = Rates(at, row[4:6], row[6:])
    return tuple(rates.q_passive_dot.T)


def dkm2(robot: Robot, *row: Array) -> Columns:
    rates = motion(robot, *row[:8])
    at = rates.pose
    B_q_ddot = times(at.B, *row[8:])
    right_side = B_q_ddot + rates.d.T
    return times(inverse(at.A), *right_side)


def ikm2(robot: Robot, *row: Array) -> Columns:
    rates = motion(robot, *row[:8])
    at = rates.pose
    A_xi_ddot = times(at.A, *row[8:])
    left_side = A_xi_ddot - rates.d.T
    return times(inverse(at.B), *left_side)


def dkm2_passive(robot: Robot, *row: Array) -> Columns:
    rates = motion(robot, *row[:8])
    accelerations = Accelerations(rates, row[8:10], row[10:])
    return tuple(accelerations.q_passive_ddot.T)


def dynamic_model(robot: Robot, *row: Array) -> Columns:
    return dynamics.dynamic_model(motion(robot, *row))


def inverse_dynamics(robot: Robot, *row: Array) -> Columns:
    M, c = dynamic_model(robot, *row[:8])
    inertial = times(M, *row[8:])
    return tuple(inertial + c.T)


def forward_dynamics(robot: Robot, *row: Array) -> Columns:
    M, c = dynamic_model(robot, *row[:8])
    remaining = row[8:] - c.T
    return times(inverse(M), *remaining)
