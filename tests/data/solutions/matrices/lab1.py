"""Lab 1 with NumPy column vectors, returning what such files return."""

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


def dgm(q11, q21, assembly_mode):
    A12 = np.array([[-d / 2], [0]]) + l11 * u(q11)
    A22 = np.array([[d / 2], [0]]) + l21 * u(q21)
    e = (A12 - A22) / np.linalg.norm(A12 - A22)
    along = (np.sum((A12 - A22) ** 2) + l22**2 - l12**2) / (2 * np.linalg.norm(A12 - A22))
    with np.errstate(invalid="ignore"):
        return A22 + along * e + assembly_mode * np.sqrt(l22**2 - along**2) * E @ e


def igm(x, y, gamma1, gamma2):
    q = np.zeros(2)
    for i, (base, l1, l2, gamma) in enumerate(
        [(-d / 2, l11, l12, gamma1), (d / 2, l21, l22, gamma2)]
    ):
        s = np.array([[x - base], [y]])
        n = np.linalg.norm(s)
        along = (n**2 + l1**2 - l2**2) / (2 * n)
        if abs(along) > l1:
            raise ValueError("out of reach")
        P = along * s / n + gamma * np.sqrt(l1**2 - along**2) * E @ s / n
        q[i] = np.arctan2(P[1, 0], P[0, 0])
    return q


def dgm_passive(q11, q21, assembly_mode):
    P = dgm(q11, q21, assembly_mode)
    w1 = P - np.array([[-d / 2], [0]]) - l11 * u(q11)
    w2 = P - np.array([[d / 2], [0]]) - l21 * u(q21)
    return np.arctan2(w1[1], w1[0]) - q11, np.arctan2(w2[1], w2[0]) - q21
