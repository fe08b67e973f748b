"""Questions as columns (n,): the joints of batches of poses and motions, and 2 x 2 matrices on
them.
"""

from __future__ import annotations

import numpy as np

from ..models.four_joints import FourJointRates, four_joint_pose, four_joint_rates
from ..models.geometry import Pose
from ..models.kinematics import Rates
from ..models.robots import Robot

Array = np.ndarray
Columns = tuple[Array, ...]

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a turn by +90 degrees


def pose(robot: Robot, q11: Array, q12: Array, q21: Array, q22: Array) -> Pose:
    return four_joint_pose(robot, (q11, q21), (q12, q22))


def motion(robot: Robot, *row: Array) -> FourJointRates:
    """Return rates of which the four joints and their rates are known; its end-effector's velocity
    is not to be read.
    """
    q11D, q12D, q21D, q22D = row[4:]
    return four_joint_rates(pose(robot, *row[:4]), (q11D, q21D), (q12D, q22D))


def joints(pose: Pose) -> Columns:
    """Return the columns q11, q12, q21, q22 of a batch of poses."""
    return tuple(np.stack([pose.q, pose.q_passive], axis=-1).reshape(-1, 4).T)


def joint_motion(rates: Rates) -> Columns:
    """Return the columns q11, q12, q21, q22, q11D, q12D, q21D, q22D of a batch of Rates."""
    return (
        *joints(rates.pose),
        *np.stack([rates.q_dot, rates.q_passive_dot], axis=-1).reshape(-1, 4).T,
    )


def resting(pose: Pose) -> Columns:
    """Return the same columns, of poses at rest."""
    return *joints(pose), *np.zeros((4, len(pose.q)))


def batch(*parts: Columns) -> Columns:
    """Return the columns of several batches, one after the other."""
    return tuple(np.concatenate(columns) for columns in zip(*parts))


def times(matrix: Array, x: Array, y: Array) -> Columns:
    """Return a matrix (2, 2) or (n, 2, 2) on the vectors (x, y), as columns."""
    return tuple((matrix @ np.stack([x, y], axis=-1)[..., None])[..., 0].T)


def inverse(matrix: Array) -> Array:
    """Return the inverse of 2 x 2 matrices; nan where singular."""
    determinant = np.linalg.det(matrix)[..., None, None]
    adjugate = matrix[..., ::-1, ::-1].swapaxes(-1, -2) * np.array([[1, -1], [-1, 1]])
    return adjugate / np.where(determinant == 0, np.nan, determinant)
