"""A load that the motors hold at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..models.dyads import SINGULAR
from ..models.dynamics import gravity_torques, torques_of
from ..models.geometry import Pose
from ..models.kinematics import Rates
from ..models.loads import at_rest
from ..models.physics import loads_of


def too_heavy(pose: Pose, torque: np.ndarray) -> str:
    """Return in words that motors of these torques do not hold the robot at rest; "" where they
    do, or at Type 2.
    """
    if not loads_of(pose.robot).has_gravity or abs(pose.det_A) < SINGULAR:
        return ""
    needed = np.abs(gravity_torques(pose))
    if (needed <= torque).all():
        return ""
    unit = pose.robot.words.effort_unit
    needs, limit = (f"{left:.4g}, {right:.4g} {unit}" for left, right in (needed, torque))
    return f"to hold it there against gravity takes {needs}, and the limit is {limit}"


@dataclass(frozen=True)
class Load:
    """A force on the end-effector that the motors hold at rest, with the weight of the robot.

    Attributes
    ----------
    force : (2,)
        N.
    torque : (2,)
        What the motors have, N m.
    jacobian : callable
        Pose -> (*batch, 2, 2) of the point that the force is at; by default that of joint C.
    """

    force: tuple[float, float]
    torque: tuple[float, float]
    jacobian: Callable[[Any], np.ndarray] = lambda pose: pose.J

    def torques(self, pose: Pose) -> np.ndarray:
        """Return the motors' torques (*batch, 2), N m, at rest; nan at Type 2."""
        held = -np.einsum("...ji,j->...i", self.jacobian(pose), self.force)
        if not loads_of(pose.robot).has_gravity:
            return held
        zeros = (np.zeros_like(pose.point[0]),) * 2
        with np.errstate(all="ignore"):
            return held + np.stack(torques_of(at_rest(Rates(pose, zeros, zeros))), axis=-1)

    def satisfied(self, pose: Pose) -> np.ndarray:
        """Return whether the motors hold it, bool (*batch,)."""
        return (np.abs(self.torques(pose)) <= self.torque).all(axis=-1)

    def margin(self, pose: Pose, assembly: int) -> np.ndarray:
        """Return a function (*batch,) that is 0 where a motor has just the torque in an assembly
        mode, and below 0 where it has less, or in the other mode.

        The torque diverges at Type 2, but its product with det A goes smoothly through it.
        """
        scale = -assembly * np.asarray(pose.det_A)
        needed = np.abs(self.torques(pose) * scale[..., None])
        return (scale[..., None] * self.torque - needed).min(axis=-1)
