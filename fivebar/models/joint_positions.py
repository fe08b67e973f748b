"""Positions of the joints of a robot in many poses, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .robots import Robot


def elbows(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Elbows (feet) of a robot with its active joints at q (m, 2): (m, 2 legs, 2) m."""
    pivots = [drive.pivot(drive.direction(own)) for drive, own in zip(robot.drives, q.T)]
    return np.stack([np.stack(np.broadcast_arrays(*pivot), axis=-1) for pivot in pivots], axis=1)


def joints(robot: Robot, pivots: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Return base joint, elbow, end-effector, elbow, base joint, (m, 5, 2) m; with sliders foot,
    end-effector, foot.

    pivots (m, 2, 2) m: elbows or feet; xi (m, 2) m.
    """
    left, right = np.moveaxis(pivots, 1, 0)
    if not robot.turns:
        return np.stack([left, xi, right], axis=1)
    first, last = (np.broadcast_to((drive.x, drive.y), xi.shape) for drive in robot.drives)
    return np.stack([first, left, xi, right, last], axis=1)


def beside_joint(elbow: np.ndarray, xi: np.ndarray, along: float, across: float) -> np.ndarray:
    """Return points (m, 2) m that are rigid on the distal bars from elbows to joints xi (m, 2) m.

    along, across: m, from the joint: along the bar, and to its left.
    """
    x, y = (xi - elbow).T / np.linalg.norm(xi - elbow, axis=1)
    offset = [along * x - across * y, along * y + across * x]
    return xi + np.stack(offset, axis=1)
