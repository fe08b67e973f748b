"""Questions as columns (n,): the joints of batches of poses and motions, 2 x 2 matrices on
them, and the sizes of answers.
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
    active = (q11, q21)
    passive = (q12, q22)
    return four_joint_pose(robot, active, passive)


def motion(robot: Robot, *row: Array) -> FourJointRates:
    """Return rates of which the four joints and their rates are known; its end-effector's velocity
    is not to be read.
    """
    q11D, q12D, q21D, q22D = row[4:]
    active_rates = (q11D, q21D)
    passive_rates = (q12D, q22D)
    return four_joint_rates(pose(robot, *row[:4]), active_rates, passive_rates)


def joints(pose: Pose) -> Columns:
    """Return the columns q11, q12, q21, q22 of a batch of poses."""
    return _leg_by_leg(pose.q, pose.q_passive)


def joint_motion(rates: Rates) -> Columns:
    """Return the columns q11, q12, q21, q22, q11D, q12D, q21D, q22D of a batch of Rates."""
    angles = joints(rates.pose)
    velocities = _leg_by_leg(rates.q_dot, rates.q_passive_dot)
    return angles + velocities


def _leg_by_leg(active, passive):
    """Return the columns active 1, passive 1, active 2, passive 2 of two arrays (..., 2)."""
    both = np.stack([active, passive], axis=-1)
    rows = both.reshape(-1, 4)
    return tuple(rows.T)


def resting(pose: Pose) -> Columns:
    """Return the same columns, of poses at rest."""
    zeros = np.zeros((4, len(pose.q)))
    return *joints(pose), *zeros


def batch(*parts: Columns) -> Columns:
    """Return the columns of several batches, one after the other."""
    joined = []
    for columns in zip(*parts):
        joined.append(np.concatenate(columns))
    return tuple(joined)


def times(matrix: Array, x: Array, y: Array) -> Columns:
    """Return a matrix (2, 2) or (n, 2, 2) on the vectors (x, y), as columns."""
    vectors = np.stack([x, y], axis=-1)[..., None]
    products = (matrix @ vectors)[..., 0]
    return tuple(products.T)


def inverse(matrix: Array) -> Array:
    """Return the inverse of 2 x 2 matrices; nan where singular."""
    signs = np.array([[1, -1], [-1, 1]])
    exchanged = matrix[..., ::-1, ::-1]
    adjugate = exchanged.swapaxes(-1, -2) * signs
    determinant = np.linalg.det(matrix)[..., None, None]
    singular = determinant == 0
    return adjugate / np.where(singular, np.nan, determinant)


def largest(answers: np.ndarray) -> np.ndarray:
    """Return per number the largest answer, (k,); 1 where all are 0 or none exists."""
    sizes = np.abs(answers)
    existing = np.where(np.isnan(answers), 0.0, sizes)
    most = np.max(existing, axis=0, initial=0.0)
    return np.where(most > 0, most, 1.0)
