"""What exercises on all four joint angles share: robots in motion and matrices on columns (n,)."""

import numpy as np

from ..models.four_joints import four_joint_pose, four_joint_rates
from .exercise import Misconception

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a turn by +90 degrees


def pose(robot, q11, q12, q21, q22):
    return four_joint_pose(robot, (q11, q21), (q12, q22))


def motion(robot, q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """Rates of which the four joint rates are known; its end-effector's velocity is not to be read."""
    return four_joint_rates(pose(robot, q11, q12, q21, q22), (q11D, q21D), (q12D, q22D))


def joints(pose):
    """The columns q11, q12, q21, q22 of a batch of poses."""
    return tuple(np.stack([pose.q, pose.q_passive], axis=-1).reshape(-1, 4).T)


def joint_rates(rates):
    """The columns q11D, q12D, q21D, q22D of a batch of Rates."""
    return tuple(np.stack([rates.q_dot, rates.q_passive_dot], axis=-1).reshape(-1, 4).T)


def batch(*parts):
    """The columns of several batches, one after the other."""
    return tuple(np.concatenate(columns) for columns in zip(*parts))


def times(matrix, x, y):
    """A matrix (2, 2) or (n, 2, 2) on the vectors (x, y), as columns."""
    return tuple((matrix @ np.stack([x, y], axis=-1)[..., None])[..., 0].T)


def inverse(matrix):
    """The inverse of 2 x 2 matrices; nan where singular."""
    determinant = np.linalg.det(matrix)[..., None, None]
    adjugate = matrix[..., ::-1, ::-1].swapaxes(-1, -2) * np.array([[1, -1], [-1, 1]])
    return adjugate / np.where(determinant == 0, np.nan, determinant)


def passive_as_absolute(model):
    """The misconception of who reads q12 and q22 as the distal bars' directions."""
    return Misconception(
        "passive angles taken as absolute",
        "Which angle does the distal bar make with the x axis? q12 alone is measured from the proximal bar.",
        lambda robot, q11, q12, q21, q22, *row: model(robot, q11, q12 - q11, q21, q22 - q21, *row),
    )
