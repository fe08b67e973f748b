"""What pictures ask of what they show: a run, several, or a plan; all of these are made in rooms above."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np

    from ..models.kinematics import Accelerations
    from ..models.robots import Robot


class Run(Protocol):
    """A simulated motion: t (n,) s; q, q_dot, xi, tau (n, 2); energy (n,) J; its reference and torque limit or None."""

    robot: Robot
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    xi: np.ndarray
    tau: np.ndarray
    energy: np.ndarray
    xi_ref: np.ndarray | None
    torque_limit: float | None
    events: tuple
    error: np.ndarray
    q_error: np.ndarray
    saturated: np.ndarray


class Comparison(Protocol):
    """Runs and their figures by name."""

    runs: dict[str, Run]
    figures: dict[str, dict[str, float]]


class Plan(Protocol):
    """An optimal motion: its problem's limits and weights, the pieces of its polynomials, its share at the limit."""

    robot: Robot
    problem: object
    pieces: object
    saturated: float

    def accelerations(self, t: np.ndarray) -> Accelerations: ...
