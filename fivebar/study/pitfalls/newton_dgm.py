"""The direct geometric model by Newton's method on the two loop-closure equations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...models.geometry import dgm

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...models.robots import Robot


@dataclass(frozen=True)
class NewtonPose:
    """What Newton's method found: xi (2,) m, assembly, iterations used, whether its residual met
    the tolerance.
    """

    xi: tuple
    assembly: int
    iterations: int
    converged: bool


def newton_dgm(
    robot: Robot,
    q: ArrayLike,
    start: tuple[float, float],
    tolerance: float = 1e-12,
    iterations: int = 50,
) -> NewtonPose:
    """Solve the vector loop of the five bars for the distal bars' angles by Newton's method.

    f(phi) = P_1 + l12 u(phi_1) - P_2 - l22 u(phi_2) = 0. Nothing in it says which assembly mode is
    meant.

    q: (2,) rad.
    start: (phi_1, phi_2) rad, which decides.
    tolerance: m, of the residual at which it stops.
    iterations: at most.
    """
    (p1x, p1y), (p2x, p2y) = (
        drive.pivot(drive.direction(float(angle))) for drive, angle in zip(robot.drives, q)
    )
    l1, l2 = robot.distal
    phi1, phi2 = start
    for k in range(iterations + 1):
        c1, s1, c2, s2 = math.cos(phi1), math.sin(phi1), math.cos(phi2), math.sin(phi2)
        fx, fy = p1x + l1 * c1 - p2x - l2 * c2, p1y + l1 * s1 - p2y - l2 * s2
        determinant = (
            l1 * l2 * (c1 * s2 - s1 * c2)
        )  # minus that of f's Jacobian; its sign is det A's
        converged = math.hypot(fx, fy) < tolerance
        if converged or determinant == 0 or k == iterations:
            break
        phi1 -= (l2 * c2 * fx + l2 * s2 * fy) / determinant
        phi2 -= (l1 * c1 * fx + l1 * s1 * fy) / determinant
        if not (math.isfinite(phi1) and math.isfinite(phi2)):
            break
    return NewtonPose((p1x + l1 * c1, p1y + l1 * s1), -int(np.sign(determinant)), k, converged)


@dataclass(frozen=True, eq=False)
class FarStart:
    """Newton from one start over many poses: shares of the poses found, in the other assembly, not
    found.
    """

    right: float
    other_assembly: float
    diverged: float


def far_start(
    robot: Robot, q: np.ndarray, start: tuple[float, float], assembly: int = -1
) -> FarStart:
    """Newton from the same start at all poses q (n, 2) rad, judged by the closed form to 1e-9 m."""
    exact = dgm(robot, q, assembly)
    found = [newton_dgm(robot, angles, start) for angles in q]
    converged = np.array([pose.converged for pose in found])
    near = np.linalg.norm(np.array([pose.xi for pose in found]) - exact.xi, axis=1) < 1e-9
    return FarStart(np.mean(converged & near), np.mean(converged & ~near), np.mean(~converged))


@dataclass(frozen=True, eq=False)
class NearSingular:
    """Newton beside Type 2: det A (n,), iterations (n,), positions by Newton and by the closed
    form, (n, 2) m.
    """

    sine: np.ndarray
    iterations: np.ndarray
    newton: np.ndarray
    closed: np.ndarray
    q: np.ndarray


def near_singular(
    robot: Robot, q_singular: ArrayLike, direction: ArrayLike, distances: ArrayLike, off: float
) -> NearSingular:
    """Both methods at q_singular + distance * direction; Newton starts with the bars turned by
    (off, -off) rad.
    """
    q = np.asarray(q_singular) + np.multiply.outer(np.asarray(distances), direction)
    pose = dgm(robot, q, -1)
    phi = pose.q + pose.q_passive
    found = [newton_dgm(robot, angles, bars + (off, -off)) for angles, bars in zip(q, phi)]
    return NearSingular(
        np.sin(phi[:, 1] - phi[:, 0]),
        np.array([pose.iterations for pose in found]),
        np.array([pose.xi for pose in found]),
        pose.xi,
        q,
    )
