"""Lab 5 with NumPy: the torques of unit accelerations are the columns of M; column arrays come back."""

import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def torques(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """Newton and Euler: bar forces that accelerate the end-effector, and their moments about the base joints."""
    a, b = q11 + q12, q21 + q22
    A = np.array([[np.cos(a), np.sin(a)], [np.cos(b), np.sin(b)]])
    along = np.array(
        [
            [l11 * np.sin(q12) * q11DD - l11 * np.cos(q12) * q11D**2 - l12 * (q11D + q12D) ** 2],
            [l21 * np.sin(q22) * q21DD - l21 * np.cos(q22) * q21D**2 - l22 * (q21D + q22D) ** 2],
        ]
    )
    force = np.linalg.solve(A.T, m * np.linalg.solve(A, along))
    arms = np.array([[l11 * np.sin(q12)], [l21 * np.sin(q22)]])
    return np.array([[zz1 * q11DD], [zz2 * q21DD]]) + arms * force


def dynamic_model(*motion):
    c = torques(*motion, 0, 0)
    return np.hstack([torques(*motion, 1, 0) - c, torques(*motion, 0, 1) - c]), c


def inverse_dynamics(*motion_and_accelerations):
    return torques(*motion_and_accelerations)


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    return np.linalg.solve(M, np.array([[tau1], [tau2]]) - c)
