import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def A(q11, q12, q21, q22):
    a1 = q11 + q12
    a2 = q21 + q22
    return np.array([[np.cos(a1), np.sin(a1)], [np.cos(a2), np.sin(a2)]])


def B(q11, q12, q21, q22):
    return np.array([[l11 * np.sin(q12), 0.0], [0.0, l21 * np.sin(q22)]])


def dkm(q11, q12, q21, q22, q11D, q21D):
    qD = np.array([q11D, q21D])
    xiD = np.linalg.inv(A(q11, q12, q21, q22)) @ B(q11, q12, q21, q22) @ qD
    return xiD[0], xiD[1]


def ikm(q11, q12, q21, q22, xD, yD):
    xiD = np.array([xD, yD])
    qD = np.linalg.inv(B(q11, q12, q21, q22)) @ A(q11, q12, q21, q22) @ xiD
    return qD[0], qD[1]


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    a1 = q11 + q12
    a2 = q21 + q22
    n1 = -np.sin(a1) * xD + np.cos(a1) * yD
    n2 = -np.sin(a2) * xD + np.cos(a2) * yD
    q12D = (n1 - l11 * np.cos(q12) * q11D) / l12 - q11D
    q22D = (n2 - l21 * np.cos(q22) * q21D) / l22 - q21D
    return q12D, q22D
