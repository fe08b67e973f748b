"""The direct geometric model by Newton's method on the two loop-closure equations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...models.robots import Robot


class NewtonPose(NamedTuple):
    """The end of Newton's method: xi (2,) m, assembly mode, iterations, whether it converged."""

    xi: tuple[float, float]
    assembly: int
    iterations: int
    converged: bool


def newton_dgm(
    robot: Robot,
    q: Sequence[float],
    start: Sequence[float],
    tolerance: float = 1e-12,
    iterations: int = 50,
) -> NewtonPose:
    """Solve the vector loop of the five bars for the angles of the distal bars.

    f(phi) = P_1 + l12 u(phi_1) - P_2 - l22 u(phi_2) = 0. Nothing in it says which assembly mode is
    meant: the start decides.

    Parameters
    ----------
    q : (2,) rad
    start : (phi_1, phi_2) rad
    tolerance : m, of the residual at which it stops
    iterations : at most
    """
    pivots = [drive.pivot(drive.direction(float(angle))) for drive, angle in zip(robot.drives, q)]
    (p1x, p1y), (p2x, p2y) = pivots
    l1, l2 = robot.distal
    phi1, phi2 = start
    for k in range(iterations + 1):
        c1 = math.cos(phi1)
        s1 = math.sin(phi1)
        c2 = math.cos(phi2)
        s2 = math.sin(phi2)
        fx = p1x + l1 * c1 - p2x - l2 * c2
        fy = p1y + l1 * s1 - p2y - l2 * s2
        # Minus that of the Jacobian of f; its sign is that of det A.
        determinant = l1 * l2 * (c1 * s2 - s1 * c2)
        converged = math.hypot(fx, fy) < tolerance
        if converged or determinant == 0 or k == iterations:
            break
        phi1 -= (l2 * c2 * fx + l2 * s2 * fy) / determinant
        phi2 -= (l1 * c1 * fx + l1 * s1 * fy) / determinant
        if not (math.isfinite(phi1) and math.isfinite(phi2)):
            break
    return NewtonPose((p1x + l1 * c1, p1y + l1 * s1), -int(np.sign(determinant)), k, converged)
