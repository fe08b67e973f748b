"""The tangent half-angle formula on the inverse geometric model of a leg."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...models.geometry import igm
from ...models.robots import FiveBar


def half_angle(a: np.ndarray, b: np.ndarray, c: np.ndarray, branch: int) -> np.ndarray:
    """Return a root of a sin(theta) + b cos(theta) + c = 0.

    theta = 2 arctan((a + branch sqrt(a^2 + b^2 - c^2)) / (b - c)): Wang, Chen, Deng 2019, eq. 5-9.
    nan or lost digits where b - c vanishes: one of the two roots is then theta = pi, and the other
    one, at which nothing happens, is computed as 0 / 0.
    """
    return 2 * np.arctan((a + branch * np.sqrt(a * a + b * b - c * c)) / (b - c))


def half_angle_igm(robot: FiveBar, xi: ArrayLike, working: int = -1) -> np.ndarray:
    """Return q11 (n,) rad of the left leg that reaches xi (n, 2) m, by the half-angle formula."""
    (x, y) = np.moveaxis(np.asarray(xi, dtype=float), -1, 0)
    l1 = robot.l11
    l2 = robot.l12
    x = x + robot.d / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        return half_angle(-2 * l1 * y, -2 * l1 * x, x * x + y * y + l1 * l1 - l2 * l2, -working)


@dataclass(frozen=True, eq=False)
class HalfAngle:
    """Poses that approach b = c: distance from it (n,) m, xi (n, 2) m, q11 (n,) rad by the formula
    and by the RRR dyad.
    """

    distance: np.ndarray
    xi: np.ndarray
    formula: np.ndarray
    dyad: np.ndarray


def approach(robot: FiveBar, distances: ArrayLike, angle: float, working: int = -1) -> HalfAngle:
    """Move the end-effector along +x towards a place that the left leg also reaches with q11 = pi.

    Parameters
    ----------
    distances : (n,) m from that place
    angle : rad, of the distal bar in that other posture
    working : +1 or -1, the posture of the leg that is wanted
    """
    distances = np.asarray(distances, dtype=float)
    x = -robot.d / 2 - robot.l11 + robot.l12 * np.cos(angle)
    xi = np.stack([x + distances, np.full_like(distances, robot.l12 * np.sin(angle))], axis=-1)
    dyad = igm(robot, xi, (working, -1), unreachable="nan").q[:, 0]
    return HalfAngle(distances, xi, half_angle_igm(robot, xi, working), dyad)
