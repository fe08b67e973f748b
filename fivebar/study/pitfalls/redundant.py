"""The robot in redundant coordinates (x, y, q1, q2) under two distance constraints, index 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...models.kinematics import Rates
from ...models.robots import FiveBar
from .integrators import Slope, march, rk4


def constraints(robot: FiveBar, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return g (2,) m^2, G (2, 4), gamma (2,) of a state (x, y, q1, q2 and their rates).

    g_i = (|xi - P_i(q_i)|^2 - l_i2^2) / 2 of the legs, G = dg/dz, g'' = G z'' + gamma.
    """
    x = state[0]
    y = state[1]
    q = state[2:4]
    rates = state[4:6]
    turns = state[6:]
    base, crank = np.array([(drive.x, drive.length) for drive in robot.drives]).T
    cos = np.cos(q)
    sin = np.sin(q)
    rx = x - base - crank * cos
    ry = y - crank * sin
    vx = rates[0] + crank * sin * turns
    vy = rates[1] - crank * cos * turns
    g = (rx * rx + ry * ry - np.square(robot.distal)) / 2
    along = crank * (ry * cos - rx * sin)  # r . P'
    jacobian = np.column_stack([rx, ry, np.diag(-along)])
    gamma = vx * vx + vy * vy + crank * (rx * cos + ry * sin) * turns**2
    return g, jacobian, gamma


def redundant_slope(robot: FiveBar, baumgarte: float = 0.0) -> Slope:
    """Return (t, state) -> slope, without torque, from [W G^T; G 0] (z'', -lambda) = (0, -gamma).

    baumgarte : alpha in 1/s; it adds 2 alpha g' + alpha^2 g to g'' = 0, so that errors of closure
        decay
    """
    matrix = np.zeros((6, 6))
    right = np.zeros(6)
    matrix[:4, :4] = np.diag([robot.m, robot.m, robot.zz1, robot.zz2])

    def slope(t, state):
        g, jacobian, gamma = constraints(robot, state)
        matrix[4:, :4] = jacobian
        matrix[:4, 4:] = jacobian.T
        right[4:] = -gamma - 2 * baumgarte * (jacobian @ state[4:]) - baumgarte**2 * g
        return np.concatenate([state[4:], np.linalg.solve(matrix, right)[:4]])

    return slope


def redundant_state(rates: Rates) -> np.ndarray:
    """Return the state (8,) of a robot's Rates."""
    return np.concatenate([rates.pose.xi, rates.pose.q, rates.xi_dot, rates.q_dot])


def closure(robot: FiveBar, q: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Return how far the distal bars are from their lengths, (n,) m: the larger of both legs."""
    gaps = []
    for i, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        px, py = drive.pivot(drive.direction(q[:, i]))
        gaps.append(np.abs(np.hypot(xi[:, 0] - px, xi[:, 1] - py) - bar))
    return np.max(gaps, axis=0)


@dataclass(frozen=True, eq=False)
class Redundant:
    """A motion in redundant coordinates: t (n,) s, states (n, 8) of a robot."""

    robot: FiveBar
    t: np.ndarray
    states: np.ndarray

    @property
    def xi(self) -> np.ndarray:
        """Positions (n, 2) m."""
        return self.states[:, :2]

    @property
    def closure(self) -> np.ndarray:
        """Errors of the distal bars' lengths (n,) m."""
        return closure(self.robot, self.states[:, 2:4], self.xi)


def redundant_motion(
    robot: FiveBar, start: Rates, duration: float, step: float, baumgarte: float = 0.0
) -> Redundant:
    """Return the free motion from `start` by RK4 with fixed step, s."""
    slope = redundant_slope(robot, baumgarte)
    return Redundant(robot, *march(rk4, slope, redundant_state(start), duration, step))
