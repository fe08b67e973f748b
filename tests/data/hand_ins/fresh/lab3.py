import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def matrices(q11, q12, q21, q22):
    p1, p2 = q11 + q12, q21 + q22
    A = np.array([[np.cos(p1), np.sin(p1)], [np.cos(p2), np.sin(p2)]])
    B = np.array([[l11 * np.sin(q12), 0], [0, l21 * np.sin(q22)]])
    return A, B


def coriolis(q12, q22, q11D, q12D, q21D, q22D):
    d1 = -l11 * np.cos(q12) * q11D**2 - l12 * (q11D + q12D)**2
    d2 = -l21 * np.cos(q22) * q21D**2 - l22 * (q21D + q22D)**2
    return np.array([d1, d2])


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = matrices(q11, q12, q21, q22)
    rhs = B @ [q11DD, q21DD] + coriolis(q12, q22, q11D, q12D, q21D, q22D)
    xDD, yDD = np.linalg.inv(A) @ rhs
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = matrices(q11, q12, q21, q22)
    rhs = A @ [xDD, yDD] - coriolis(q12, q22, q11D, q12D, q21D, q22D)
    q11DD, q21DD = np.linalg.inv(B) @ rhs
    return q11DD, q21DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    p1, p2 = q11 + q12, q21 + q22
    n1 = -np.sin(p1) * xDD + np.cos(p1) * yDD
    n2 = -np.sin(p2) * xDD + np.cos(p2) * yDD
    f1 = n1 - l11 * np.cos(q12) * q11DD - l11 * np.sin(q12) * q11D**2
    f2 = n2 - l21 * np.cos(q22) * q21DD - l21 * np.sin(q22) * q21D**2
    return f1 / l12 - q11DD, f2 / l22 - q21DD
