import numpy as np
from math import acos, atan2, cos, sin, sqrt, pi, hypot

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def elbow_left(q11):
    return np.array([-d / 2 + l11 * np.cos(q11), l11 * np.sin(q11)])


def elbow_right(q21):
    return np.array([d / 2 + l21 * np.cos(q21), l21 * np.sin(q21)])


def dgm(q11, q21, assembly_mode):
    P = elbow_left(q11)
    Q = elbow_right(q21)
    PQ = P - Q
    D = np.linalg.norm(PQ)
    e = PQ / D
    n = np.array([-e[1], e[0]])
    s = (l22**2 - l12**2 + D**2) / (2 * D)
    h2 = l22**2 - s**2
    h = sqrt(h2)
    X = Q + s * e + assembly_mode * h * n
    return X[0], X[1]


def one_leg(dx, dy, la, lb, gamma):
    r = sqrt(dx**2 + dy**2)
    cosine = (la**2 + r**2 - lb**2) / (2 * la * r)
    return atan2(dy, dx) + gamma * acos(cosine)


def igm(x, y, gamma1, gamma2):
    q11 = one_leg(x + d / 2, y, l11, l12, gamma1)
    q21 = one_leg(x - d / 2, y, l21, l22, gamma2)
    return q11, q21


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    v1 = np.array([x, y]) - elbow_left(q11)
    v2 = np.array([x, y]) - elbow_right(q21)
    q12 = np.arctan2(v1[1], v1[0]) - q11
    q22 = np.arctan2(v2[1], v2[0]) - q21
    return q12, q22
