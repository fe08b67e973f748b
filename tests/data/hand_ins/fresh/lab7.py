from math import atan2, cos, sin, sqrt
import numpy as np

l1 = 0.2828427
l2 = 0.2828427
d = 0.4
mf1 = 1.0
mf2 = 1.0
m = 3.0


def dgm(q11, q21, assembly_mode):
    left = np.array([-d / 2, q11])
    right = np.array([d / 2, q21])
    w = left - right
    D = np.hypot(*w)
    k = (D**2 + l2**2 - l1**2) / (2 * D)
    h = sqrt(l2**2 - k**2)
    w = w / D
    n = np.array([-w[1], w[0]])
    p = right + k * w + assembly_mode * h * n
    return p[0], p[1]


def igm(x, y, gamma1, gamma2):
    return y + gamma1 * sqrt(l1**2 - (x + d / 2)**2), y + gamma2 * sqrt(l2**2 - (x - d / 2)**2)


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    return atan2(y - q11, x + d / 2), atan2(y - q21, x - d / 2)


def AB(q12, q22):
    return np.array([[cos(q12), sin(q12)], [cos(q22), sin(q22)]]), np.diag([sin(q12), sin(q22)])


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = AB(q12, q22)
    return np.linalg.solve(A, B @ [q11D, q21D])


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = AB(q12, q22)
    return np.linalg.solve(B, A @ [xD, yD])


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    q12D = (cos(q12) * (yD - q11D) - sin(q12) * xD) / l1
    q22D = (cos(q22) * (yD - q21D) - sin(q22) * xD) / l2
    return q12D, q22D


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = AB(q12, q22)
    b = np.array([-l1 * q12D**2, -l2 * q22D**2])
    return np.linalg.solve(A, B @ [q11DD, q21DD] + b)


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = AB(q12, q22)
    b = np.array([-l1 * q12D**2, -l2 * q22D**2])
    return np.linalg.solve(B, A @ [xDD, yDD] - b)


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    q12DD = (cos(q12) * (yDD - q11DD) - sin(q12) * xDD) / l1
    q22DD = (cos(q22) * (yDD - q21DD) - sin(q22) * xDD) / l2
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = AB(q12, q22)
    b = np.array([-l1 * q12D**2, -l2 * q22D**2])
    J = np.linalg.solve(A, B)
    M = np.diag([mf1, mf2]) + m * J.T @ J
    c = m * J.T @ np.linalg.solve(A, b)
    return M, c
