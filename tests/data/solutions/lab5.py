"""Lab 5 as the handout develops it: M and c by components."""

from math import cos, sin

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def product(P, Q):
    return [[sum(P[i][k] * Q[k][j] for k in range(2)) for j in range(2)] for i in range(2)]


def transposed(P):
    return [[P[0][0], P[1][0]], [P[0][1], P[1][1]]]


def inverted(P):
    det = P[0][0] * P[1][1] - P[0][1] * P[1][0]
    return [[P[1][1] / det, -P[0][1] / det], [-P[1][0] / det, P[0][0] / det]]


def kinematics(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A = [[cos(q11 + q12), sin(q11 + q12)], [cos(q21 + q22), sin(q21 + q22)]]
    B = [[l11 * sin(q12), 0], [0, l21 * sin(q22)]]
    b1 = -l11 * cos(q12) * q11D**2 - l12 * (q11D + q12D) ** 2
    b2 = -l21 * cos(q22) * q21D**2 - l22 * (q21D + q22D) ** 2
    return A, B, [[b1], [b2]]


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B, b = kinematics(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    J = product(inverted(A), B)
    a = [row[0] * b[0][0] + row[1] * b[1][0] for row in inverted(A)]
    JJ = product(transposed(J), J)
    M = [[zz1 + m * JJ[0][0], m * JJ[0][1]], [m * JJ[1][0], zz2 + m * JJ[1][1]]]
    c = [m * (J[0][0] * a[0] + J[1][0] * a[1]), m * (J[0][1] * a[0] + J[1][1] * a[1])]
    return M, c


def inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    tau1 = M[0][0] * q11DD + M[0][1] * q21DD + c[0]
    tau2 = M[1][0] * q11DD + M[1][1] * q21DD + c[1]
    return tau1, tau2


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    W = inverted(M)
    r1, r2 = tau1 - c[0], tau2 - c[1]
    return W[0][0] * r1 + W[0][1] * r2, W[1][0] * r1 + W[1][1] * r2
