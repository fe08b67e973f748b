"""A calibrated robot in use: what is commanded for which angle, and what is where in the measuring
frame.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .measured_robot import frame, seen, unframe


class Used:
    """What the values p (13,) of a calibration are good for."""

    p: np.ndarray

    def predict(self, q: Any, assembly: Any = -1) -> np.ndarray:
        """Points (*batch, 2) in the measuring frame at readings q (*batch, 2); nan where the robot
        does not close.
        """
        q = np.asarray(q, float)
        modes = np.broadcast_to(np.asarray(assembly), q.shape[:-1]).ravel()
        return seen(self.p, q.reshape(-1, 2), modes, derive=False)[0].reshape(q.shape)

    def angles(self, q: Any) -> np.ndarray:
        """True angles, rad, of readings q (*batch, 2)."""
        return np.asarray(q, float) * self.p[7:9] + self.p[5:7]

    def readings(self, angles: Any) -> np.ndarray:
        """Readings (*batch, 2) at true angles, rad: what to command for q of `igm` with the robot
        found.
        """
        return (np.asarray(angles, float) - self.p[5:7]) / self.p[7:9]

    def to_frame(self, xi: Any) -> np.ndarray:
        """Points of the robot's frame (*batch, 2) in the measuring one."""
        xi = np.asarray(xi, float)
        return frame(self.p, (xi[..., 0], xi[..., 1]))

    def to_robot(self, points: Any) -> np.ndarray:
        """Points of the measuring frame (*batch, 2) in the robot's."""
        return np.stack(unframe(self.p, np.asarray(points, float)), axis=-1)
