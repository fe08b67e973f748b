"""In which coordinates a motion is planned: the end-effector's in one pair of working modes, or the
four bars' in none.

Each has `size` coordinates c; a motion (..., 3 size + 2) is c, c', c'' and the torques. What the
program varies beside them at its points, the controls, are the bar forces or the torques: nothing
is divided by det A.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ..models.charts import BarAngles
from ..models.dynamics import bar_force_dynamics, drives_forces, forward_dynamics
from ..models.four_joints import bars_of, bars_pose, bars_rates, closure_columns
from ..models.geometry import Pose, igm
from ..models.kinematics import Accelerations, Rates, ikm, ikm2
from ..models.physics import physics_of

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .problem import Problem
    from .program import Program


@dataclass(frozen=True)
class TaskCoordinates:
    """(x, y), with both legs in given working modes; controls: the bar forces."""

    working: tuple[int, int]
    size = 2

    def units(self, problem: Problem) -> np.ndarray:
        return np.full(2, problem.length)

    def accelerations(self, robot: Robot, motion: np.ndarray) -> Accelerations:
        """Of a motion (..., 6 or more); nan out of reach."""
        pose = igm(robot, motion[..., :2], self.working, unreachable="nan")
        return ikm2(ikm(pose, motion[..., 2:4]), motion[..., 4:6])

    def defect(self, motion: np.ndarray, acc: Accelerations) -> np.ndarray:
        """By what force (...) N the motion errs: m xi'' - A^T lambda with lambda = B^-1 (tau - Z
        q'').
        """
        push, _ = bar_force_dynamics(acc, drives_forces(acc, (motion[..., -2], motion[..., -1])))
        return np.hypot(*push)

    def point(self, program: Program, c: list, control: ca.SX) -> tuple:
        """Residual, tau, Accelerations at c, c', c'' and scaled controls, symbols in SI."""
        acc = ikm2(ikm(igm(program.problem.model, c[0], self.working), c[1]), c[2])
        push, tau = bar_force_dynamics(
            acc, (program.force * control[0], program.force * control[1])
        )
        return ca.vertcat(*push) / program.force, ca.vertcat(*tau), acc

    def control(self, program: Program) -> float:
        """The unit of the controls."""
        return program.force

    def at(self, problem: Problem, conditions: dict) -> list:
        """What a stop asks of c (order 0) and c' (1): [(order, rows of a matrix, None: each of
        them, values)].
        """
        return [
            (order, None, np.array(conditions[order])) for order in (0, 1) if order in conditions
        ]


@dataclass(frozen=True)
class BarCoordinates:
    """(q1, phi1, q2, phi2), with no mode; controls: the torques."""

    working = None
    size = 4

    def units(self, problem: Problem) -> np.ndarray:
        slides = 1.0 if problem.robot.turns else problem.length
        return np.array([slides, 1.0, slides, 1.0])

    def accelerations(self, robot: Robot, motion: np.ndarray) -> Accelerations:
        a, a_dot, a_ddot = (
            tuple(motion[..., k : k + 4][..., i] for i in range(4)) for k in (0, 4, 8)
        )
        return _accelerations(robot, a, a_dot, a_ddot)

    def defect(self, motion: np.ndarray, acc: Accelerations) -> np.ndarray:
        """By what force the motion errs: the mass times a bar and the accelerations that the
        torques do not explain.
        """
        robot = acc.rates.pose.robot
        right = BarAngles().accelerations(forward_dynamics(acc.rates, motion[..., -2:]))
        off = np.stack([motion[..., 8 + k] - each for k, each in enumerate(right)], axis=-1)
        mass = robot.m
        if physics_of(robot) is not None:  # what is grouped may be 0 or negative
            mass = abs(robot.m) + sum(map(abs, robot.inertias)) / robot.distal[0] ** 2
        return mass * max(robot.distal) * np.abs(off).max(axis=-1)

    def point(self, program: Program, c: list, control: ca.SX) -> tuple:
        robot = program.problem.model
        a, a_dot, a_ddot = (tuple(each[k] for k in range(4)) for each in c)
        acc = _accelerations(robot, a, a_dot, a_ddot)
        tau = program.torque * control
        right = ca.vertcat(*BarAngles().accelerations(forward_dynamics(acc.rates, tau)))
        return (c[2] - right) * (program.time**2 / ca.DM(self.units(program.problem))), tau, acc

    def control(self, program: Program) -> float:
        return program.torque

    def at(self, problem: Problem, conditions: dict) -> list:
        """Of a pose that is not the first, only what the loop leaves open: its closure comes with
        the motion.
        """
        rows = (
            None
            if conditions is problem.stops[0][0]
            else tangent(problem.robot, np.array(conditions[0]))
        )
        return [
            (order, rows, np.array(conditions[order])) for order in (0, 1) if order in conditions
        ]


def _accelerations(robot, a, a_dot, a_ddot):
    """Of the four bars, on components; the end-effector is the left leg's."""
    rates = bars_rates(robot, a, a_dot)
    pose = rates.pose
    (drive, _), (leg, _), bar = robot.drives, pose.legs, robot.distal[0]
    (tx, ty), (ux, uy) = drive.tangent(leg.direction), leg.distal
    along, across = drive.bends(leg.sine, leg.cosine)  # of P'', on the distal bar
    along, across = (
        along * a_dot[0] ** 2 - bar * a_dot[1] ** 2,
        across * a_dot[0] ** 2 + bar * a_ddot[1],
    )
    xi_ddot = tx * a_ddot[0] + along * ux - across * uy, ty * a_ddot[0] + along * uy + across * ux
    return Accelerations(rates, (a_ddot[0], a_ddot[2]), xi_ddot)


def tangent(robot, bars: np.ndarray) -> np.ndarray:
    """Orthonormal directions (2, 4) in which the bars of a pose that closes can turn."""
    columns = closure_columns(bars_pose(robot, tuple(bars.tolist())))
    return np.linalg.svd(np.array(columns).T)[2][2:]


def bars(pose: Pose) -> np.ndarray:
    """(q1, phi1, q2, phi2) of a pose, (4,)."""
    return np.array(bars_of(Rates(pose, (0.0, 0.0), (0.0, 0.0)))[0])
