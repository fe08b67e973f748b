"""Lab 3 with NumPy: all four equations of the two legs at once, unknowns by solve; column arrays come back."""

import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5
E = np.array([[0, -1], [1, 0]])


def u(q):
    return np.array([[np.cos(q)], [np.sin(q)]])


def legs(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """xi'' = P1 q11'' + R1 (q11'' + q12'') + c1, and so for the right leg."""
    P1, R1 = l11 * E @ u(q11), l12 * E @ u(q11 + q12)
    P2, R2 = l21 * E @ u(q21), l22 * E @ u(q21 + q22)
    c1 = -l11 * q11D**2 * u(q11) - l12 * (q11D + q12D) ** 2 * u(q11 + q12)
    c2 = -l21 * q21D**2 * u(q21) - l22 * (q21D + q22D) ** 2 * u(q21 + q22)
    return P1, R1, c1, P2, R2, c2


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    P1, R1, c1, P2, R2, c2 = legs(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    left, right = P1 * q11DD + c1, P2 * q21DD + c2
    swings = np.linalg.solve(np.hstack([R1, -R2]), right - left)
    return left + R1 * swings[0]


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    P1, R1, c1, P2, R2, c2 = legs(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    a = np.array([[xDD], [yDD]])
    left = np.linalg.solve(np.hstack([P1, R1]), a - c1)
    right = np.linalg.solve(np.hstack([P2, R2]), a - c2)
    return np.array([left[0], right[0]])


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    P1, R1, c1, P2, R2, c2 = legs(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    a = np.array([[xDD], [yDD]])
    left = R1.T @ (a - c1 - P1 * q11DD) / l12**2
    right = R2.T @ (a - c2 - P2 * q21DD) / l22**2
    return left - q11DD, right - q21DD
