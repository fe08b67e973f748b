"""The robot in redundant coordinates (x, y, q1, q2) under two distance constraints, reduced to
index 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .integrators import adaptive, march, rk4

if TYPE_CHECKING:
    from ...models.kinematics import Rates
    from ...models.robots import FiveBar
    from .integrators import Slope

# Constraints g_i = (|xi - P_i(q_i)|^2 - l_i2^2) / 2 of the legs, G = dg/dz, g'' = G z'' + gamma.


def constraints(robot: FiveBar, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """g (2,) m^2, G (2, 4), gamma (2,) of a state (x, y, q1, q2 and their rates)."""
    x, y, *angles = state[:4]
    xd, yd, *turns = state[4:]
    g, gamma, jacobian = np.empty(2), np.empty(2), np.zeros((2, 4))
    for i, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        cos, sin = np.cos(angles[i]), np.sin(angles[i])
        rx, ry = x - drive.x - drive.length * cos, y - drive.y - drive.length * sin
        along = drive.length * (ry * cos - rx * sin)  # r . P'
        vx, vy = xd + drive.length * sin * turns[i], yd - drive.length * cos * turns[i]
        g[i] = (rx * rx + ry * ry - bar * bar) / 2
        jacobian[i, :2], jacobian[i, 2 + i] = (rx, ry), -along
        gamma[i] = vx * vx + vy * vy + drive.length * (rx * cos + ry * sin) * turns[i] ** 2
    return g, jacobian, gamma


def redundant_slope(robot: FiveBar, baumgarte: float = 0.0) -> Slope:
    """(t, state) -> slope, without torque, from the 6 x 6 KKT system [W G^T; G 0] (z'', -lambda) =
    (0, -gamma - ...).

    baumgarte: alpha in 1/s; it adds 2 alpha g' + alpha^2 g to g'' = 0, so that errors of closure
        decay.
    """
    matrix = np.zeros((6, 6))
    matrix[:4, :4] = np.diag([robot.m, robot.m, robot.zz1, robot.zz2])
    right = np.zeros(6)

    def slope(t, state):
        g, jacobian, gamma = constraints(robot, state)
        matrix[4:, :4], matrix[:4, 4:] = jacobian, jacobian.T
        right[4:] = -gamma - 2 * baumgarte * (jacobian @ state[4:]) - baumgarte**2 * g
        return np.concatenate([state[4:], np.linalg.solve(matrix, right)[:4]])

    return slope


def redundant_state(rates: Rates) -> np.ndarray:
    return np.concatenate([rates.pose.xi, rates.pose.q, rates.xi_dot, rates.q_dot])


def closure(robot: FiveBar, q: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """How far the bars are from their lengths, (n,) m: the larger of both legs' ||xi - P_i| -
    l_i2|.
    """
    gaps = []
    for i, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        px, py = drive.pivot(drive.direction(q[:, i]))
        gaps.append(np.abs(np.hypot(xi[:, 0] - px, xi[:, 1] - py) - bar))
    return np.max(gaps, axis=0)


@dataclass(frozen=True, eq=False)
class Redundant:
    """A motion in redundant coordinates: t (n,) s, xi, q (n, 2), closure (n,) m, relative error of
    the energy (n,).
    """

    t: np.ndarray
    xi: np.ndarray
    q: np.ndarray
    closure: np.ndarray
    energy_error: np.ndarray


def redundant_motion(
    robot: FiveBar, start: Rates, duration: float, step: float, baumgarte: float = 0.0
) -> Redundant:
    """Free motion from `start` (Rates) by RK4 with fixed step, s."""
    return _result(
        robot,
        *march(rk4, redundant_slope(robot, baumgarte), redundant_state(start), duration, step),
    )


def redundant_reference(
    robot: FiveBar, start: Rates, duration: float, tolerance: float = 1e-13
) -> Redundant:
    """The same by DOP853 at a tolerance where its drift does not matter: a check that shares no
    formula with ours.
    """
    t = np.linspace(0, duration, 101)
    found = adaptive(
        redundant_slope(robot), redundant_state(start), t, "DOP853", tolerance, 1e-3 * tolerance
    )
    return _result(robot, found.t, found.states)


def _result(robot, t, states):
    energy = states[:, 4:] ** 2 @ [robot.m, robot.m, robot.zz1, robot.zz2]
    xi, q = states[:, :2], states[:, 2:4]
    return Redundant(t, xi, q, closure(robot, q, xi), energy / energy[0] - 1)
