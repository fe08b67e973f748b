"""Coordinates of planned motions: the end-effector's in one pair of working modes, or four angles.

Each has `size` coordinates c; a motion (..., 3 size + 2) is c, c', c'' and the torques. The
interval's controls are the bar forces or the torques, so nothing is divided by det A.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ..models.charts import BarAngles
from ..models.dynamics import bar_force_dynamics, drives_forces, forward_dynamics
from ..models.four_joints import bars_of, bars_pose, bars_rates, closed, closure_columns
from ..models.geometry import Pose, igm
from ..models.kinematics import Accelerations, Rates, ikm, ikm2
from ..models.physics import physics_of

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .problem import Problem
    from .program import Interval


@dataclass(frozen=True)
class TaskCoordinates:
    """(x, y), with both legs in given working modes; controls: the bar forces."""

    working: tuple[int, int]
    size = 2

    def units(self, problem: Problem) -> np.ndarray:
        return np.full(2, problem.length)

    def accelerations(self, robot: Robot, motion: np.ndarray) -> Accelerations:
        """Return the Accelerations of a motion (..., 6 or more); nan out of reach."""
        pose = igm(robot, motion[..., :2], self.working, unreachable="nan")
        return ikm2(ikm(pose, motion[..., 2:4]), motion[..., 4:6])

    def defect(self, motion: np.ndarray, acc: Accelerations) -> np.ndarray:
        """Return |m xi'' - A^T lambda|, N, with lambda = B^-1 (tau - Z q'')."""
        push, _ = bar_force_dynamics(acc, drives_forces(acc, (motion[..., -2], motion[..., -1])))
        return np.hypot(*push)

    def point(self, interval: Interval, c: list, control: ca.SX) -> tuple:
        """Return residual, tau, Accelerations at c, c', c'' (SI) and scaled controls."""
        acc = ikm2(ikm(igm(interval.problem.model, c[0], self.working), c[1]), c[2])
        forces = interval.force * control[0], interval.force * control[1]
        push, tau = bar_force_dynamics(acc, forces)
        return ca.vertcat(*push) / interval.force, ca.vertcat(*tau), acc

    def control(self, interval: Interval) -> float:
        """Return the unit of the controls."""
        return interval.force

    def at_knot(self, interval: Interval, c: ca.SX, c_dot: ca.SX) -> tuple:
        """Return where an interval that ends at c, c' (scaled) leaves the next one."""
        return c, c_dot

    def at(self, problem: Problem, conditions: dict) -> list:
        """Return [(order, rows, values)]: c (order 0) and c' (1) at a stop are the values.

        With rows, a matrix, it is their product with c that is.
        """
        orders = [order for order in (0, 1) if order in conditions]
        return [(order, None, np.array(conditions[order])) for order in orders]


@dataclass(frozen=True)
class BarCoordinates:
    """(q1, phi1, q2, phi2), with no mode; controls: the torques."""

    working = None
    size = 4

    def units(self, problem: Problem) -> np.ndarray:
        slides = 1.0 if problem.robot.turns else problem.length
        return np.array([slides, 1.0, slides, 1.0])

    def accelerations(self, robot: Robot, motion: np.ndarray) -> Accelerations:
        components = tuple(motion[..., k] for k in range(12))
        return bar_accelerations(robot, components[:4], components[4:8], components[8:])

    def defect(self, motion: np.ndarray, acc: Accelerations) -> np.ndarray:
        """Return mass x bar x the accelerations that the torques do not explain, N."""
        robot = acc.rates.pose.robot
        right = BarAngles().accelerations(forward_dynamics(acc.rates, motion[..., -2:]))
        error = motion[..., 8:12] - np.stack(right, axis=-1)
        mass = robot.m
        if physics_of(robot) is not None:
            # Grouped parameters may be 0 or negative.
            turning = sum(map(abs, robot.inertias))
            mass = abs(robot.m) + turning / robot.distal[0] ** 2
        return mass * max(robot.distal) * np.abs(error).max(axis=-1)

    def point(self, interval: Interval, c: list, control: ca.SX) -> tuple:
        robot = interval.problem.model
        acc = bar_accelerations(robot, *(tuple(ca.vertsplit(value)) for value in c))
        tau = interval.torque * control
        right = ca.vertcat(*BarAngles().accelerations(forward_dynamics(acc.rates, tau)))
        unit = interval.time**2 / ca.DM(self.units(interval.problem))
        return (c[2] - right) * unit, tau, acc

    def control(self, interval: Interval) -> float:
        return interval.torque

    def at_knot(self, interval: Interval, c: ca.SX, c_dot: ca.SX) -> tuple:
        """Return c, c' with the loop closed.

        The loop would open a little on each interval. Under its weight a robot costs less torque
        the more it opens, so that the optimum would be the motion that integrates worst.
        """
        problem = interval.problem
        if not problem.fall:
            return c, c_dot
        units = ca.DM(self.units(problem))
        rate = units / interval.time
        angles = tuple(ca.vertsplit(units * c))
        bars, rates, _ = closed(problem.model, angles, tuple(ca.vertsplit(rate * c_dot)))
        return ca.vertcat(*bars) / units, ca.vertcat(*rates) / rate

    def at(self, problem: Problem, conditions: dict) -> list:
        """Return [(order, rows, values)], as of `TaskCoordinates`.

        The loop of the first pose closes, and closure comes with the motion to all others.
        """
        rows = None
        if conditions is not problem.stops[0][0]:
            rows = tangent(problem.robot, np.array(conditions[0]))
        orders = [order for order in (0, 1) if order in conditions]
        return [(order, rows, np.array(conditions[order])) for order in orders]


def bar_accelerations(robot: Robot, a: tuple, a_dot: tuple, a_ddot: tuple) -> Accelerations:
    """Return the Accelerations of the four bars; the end-effector is the left leg's."""
    rates = bars_rates(robot, a, a_dot)
    pose = rates.pose
    drive = robot.drives[0]
    leg = pose.legs[0]
    bar = robot.distal[0]
    tx, ty = drive.tangent(leg.direction)
    ux, uy = leg.distal
    along, across = drive.acceleration_coefficients(
        leg.sine, leg.cosine
    )  # of P'', on the distal bar
    along = along * a_dot[0] ** 2 - bar * a_dot[1] ** 2
    across = across * a_dot[0] ** 2 + bar * a_ddot[1]
    x_ddot = tx * a_ddot[0] + along * ux - across * uy
    y_ddot = ty * a_ddot[0] + along * uy + across * ux
    return Accelerations(rates, (a_ddot[0], a_ddot[2]), (x_ddot, y_ddot))


def tangent(robot, bars: np.ndarray) -> np.ndarray:
    """Return orthonormal directions (2, 4) in which the bars of a closed pose can turn."""
    columns = closure_columns(bars_pose(robot, tuple(bars.tolist())))
    return np.linalg.svd(np.array(columns).T)[2][2:]


def bars(pose: Pose) -> np.ndarray:
    """Return (q1, phi1, q2, phi2) of poses, (*batch, 4)."""
    return np.stack(bars_of(Rates(pose, (0.0, 0.0), (0.0, 0.0)))[0], axis=-1)
