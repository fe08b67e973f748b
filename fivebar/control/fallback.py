"""The tracker without a solution: a safe torque, and torques to begin anew from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import SingularityError, UnreachableError
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from .laws import PD, ComputedTorque, FeedForward, motion_at

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..models.robots import Robot

FALLBACK_GAINS = 100.0, 20.0  # of computed torque, 1/s^2 and 1/s
NEAR_PARALLEL = 0.2  # |det A| below which the fallback is PD: computed torque divides by it


def _working(margins):
    return tuple(-1 if sine > 0 else 1 for sine in margins[:2])


def free_of_modes(reference: Any) -> bool:
    """Return whether a plan's legs may change their working modes on the way."""
    return getattr(reference, "working", ()) is None


def reference_torques(
    robot: Robot, margins: Sequence[float], reference: Any, times: np.ndarray
) -> np.ndarray:
    """Return the torques (n, 2), N m, of the reference at n times; 0 where it has none."""
    if free_of_modes(reference):
        return reference.torques(times)
    xi, xi_dot, xi_ddot = motion_at(reference, times)
    try:
        return inverse_dynamics(ikm2(ikm(igm(robot, xi, _working(margins)), xi_dot), xi_ddot))
    except (SingularityError, UnreachableError):
        return np.zeros((len(times), 2))


def safe_torque(
    robot: Robot, inertia: float, margins: Sequence[float], assembly: int, call: tuple
) -> np.ndarray:
    """Return the torque, N m, of a controller without a horizon.

    It is computed torque, near Type 2 a PD of about the same gains, and along a plan that is free
    of modes feed-forward. It is damping where the reference is out of reach.

    call: (t, q, q_dot, reference), as to a controller. inertia: kg m^2, that a joint moves.
    """
    kp, kd = FALLBACK_GAINS
    if free_of_modes(call[3]):
        controller = FeedForward(robot, kp * inertia, kd * inertia)
    elif abs(margins[2]) > NEAR_PARALLEL:
        controller = ComputedTorque(robot, kp, kd, _working(margins), assembly)
    else:
        controller = PD(robot, kp * inertia, kd * inertia, _working(margins))
    try:
        return controller(*call)
    except (SingularityError, UnreachableError):
        return -kd * inertia * np.asarray(call[2])
