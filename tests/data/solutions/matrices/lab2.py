"""Lab 2 with NumPy matrices, returning column arrays; the passive rates by least squares on all four equations."""

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


def A(q11, q12, q21, q22):
    return np.hstack([u(q11 + q12), u(q21 + q22)]).T


def B(q11, q12, q21, q22):
    b1 = l11 * u(q11 + q12).T @ E @ u(q11)
    b2 = l21 * u(q21 + q22).T @ E @ u(q21)
    return np.diag([b1.item(), b2.item()])


def dkm(q11, q12, q21, q22, q11D, q21D):
    q = q11, q12, q21, q22
    if np.linalg.cond(A(*q)) > 1e10:
        raise np.linalg.LinAlgError("A is singular")
    return np.linalg.inv(A(*q)) @ B(*q) @ np.array([[q11D], [q21D]])


def ikm(q11, q12, q21, q22, xD, yD):
    q = q11, q12, q21, q22
    if np.linalg.cond(B(*q)) > 1e10:
        raise np.linalg.LinAlgError("B is singular")
    return np.linalg.solve(B(*q), A(*q) @ np.array([[xD], [yD]]))


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    xi = np.array([[xD], [yD]])
    rate1 = np.linalg.lstsq(l12 * E @ u(q11 + q12), xi - l11 * q11D * E @ u(q11), rcond=None)[0]
    rate2 = np.linalg.lstsq(l22 * E @ u(q21 + q22), xi - l21 * q21D * E @ u(q21), rcond=None)[0]
    return rate1.ravel() - q11D, rate2.ravel() - q21D
