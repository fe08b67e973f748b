"""Lab 2 as the handout derives it, for four bar lengths."""

from math import cos, sin

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def u(angle):
    return cos(angle), sin(angle)


def v(angle):
    return -sin(angle), cos(angle)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1]


def A(q11, q12, q21, q22):
    u12, u22 = u(q11 + q12), u(q21 + q22)
    return [[u12[0], u12[1]], [u22[0], u22[1]]]


def B(q11, q12, q21, q22):
    u12, u22 = u(q11 + q12), u(q21 + q22)
    b1 = l11 * dot(u12, v(q11))
    b2 = l21 * dot(u22, v(q21))
    return [[b1, 0.0], [0.0, b2]]


def product(P, x):
    return dot(P[0], x), dot(P[1], x)


def solved(P, y):
    det = P[0][0] * P[1][1] - P[0][1] * P[1][0]
    if abs(det) < 1e-9 * (abs(P[0][0] * P[1][1]) + abs(P[0][1] * P[1][0]) + 1e-4):
        raise ValueError("singular")
    return (P[1][1] * y[0] - P[0][1] * y[1]) / det, (P[0][0] * y[1] - P[1][0] * y[0]) / det


def dkm(q11, q12, q21, q22, q11D, q21D):
    A_, B_ = A(q11, q12, q21, q22), B(q11, q12, q21, q22)
    return solved(A_, product(B_, (q11D, q21D)))


def ikm(q11, q12, q21, q22, xD, yD):
    A_, B_ = A(q11, q12, q21, q22), B(q11, q12, q21, q22)
    return solved(B_, product(A_, (xD, yD)))


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    v12, v22 = v(q11 + q12), v(q21 + q22)
    phi1D = (dot(v12, (xD, yD)) - l11 * q11D * dot(v12, v(q11))) / l12
    phi2D = (dot(v22, (xD, yD)) - l21 * q21D * dot(v22, v(q21))) / l22
    return phi1D - q11D, phi2D - q21D
