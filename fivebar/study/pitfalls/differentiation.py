"""Velocities and accelerations as differences of positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...models.geometry import dgm
from ...models.kinematics import dkm, dkm2
from ...models.robots import Robot

OURS = 2e-15  # bound of the relative error of our rates, which the tests check against 50 digits


def swing(t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return q, q', q'' (n, 2) at t (n,) s of a smooth motion within the robot's regular region."""
    t = np.asarray(t, dtype=float)[..., None]
    size = np.array([0.3, 0.25])
    rate = np.array([3.0, 4.0])
    phase = np.array([0.4, 1.1])
    angle = rate * t + phase
    return size * np.sin(angle), size * rate * np.cos(angle), -size * rate**2 * np.sin(angle)


def analytic(robot: Robot, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return xi', xi'' (n, 2) at t by the first- and second-order models."""
    q, q_dot, q_ddot = swing(t)
    rates = dkm(dgm(robot, q), q_dot)
    return rates.xi_dot, dkm2(rates, q_ddot).xi_ddot


def differences(robot: Robot, t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return them as MechAnalyzer's eq. 23 and 25: V2 = (P2 - P1) / dt, A2 = (V2 - V1) / dt."""
    p0, p1, p2 = (dgm(robot, swing(t - k * step)[0]).xi for k in (2, 1, 0))
    v1 = (p1 - p0) / step
    v2 = (p2 - p1) / step
    return v2, (v2 - v1) / step


@dataclass(frozen=True, eq=False)
class Differentiation:
    """Relative errors (n,) of the differences for each step (n,) s: the largest over 50 times in 2
    s.
    """

    step: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def error_curve(robot: Robot, steps: Sequence[float]) -> Differentiation:
    """Return how far differences are from the analytic rates, in parts of the largest rate."""
    t = np.linspace(0, 2, 50)
    errors = []
    exact = np.array(analytic(robot, t))
    largest = np.abs(exact).max(axis=(1, 2))
    for step in steps:
        error = np.abs(np.array(differences(robot, t, step)) - exact)
        errors.append(error.max(axis=(1, 2)) / largest)
    return Differentiation(np.asarray(steps, dtype=float), *np.array(errors).T)
