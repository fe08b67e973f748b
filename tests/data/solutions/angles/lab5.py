"""Lab 5 in closed form, with the angle between the distal bars."""

import math

l11 = l12 = l21 = l22 = 0.09
d = 0.118
zz1 = zz2 = 0.002
m = 0.5


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    angle = q21 + q22 - q11 - q12
    s, g = math.sin(angle), math.cos(angle)
    b1, b2 = l11 * math.sin(q12), l21 * math.sin(q22)
    d1 = -l11 * math.cos(q12) * q11D**2 - l12 * (q11D + q12D) ** 2
    d2 = -l21 * math.cos(q22) * q21D**2 - l22 * (q21D + q22D) ** 2
    w = m / s**2
    M = ((zz1 + w * b1 * b1, -w * g * b1 * b2), (-w * g * b1 * b2, zz2 + w * b2 * b2))
    return M, (w * b1 * (d1 - g * d2), w * b2 * (d2 - g * d1))


def inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    (M, c) = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    return [M[i][0] * q11DD + M[i][1] * q21DD + c[i] for i in range(2)]


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    (M, c) = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    det = M[0][0] * M[1][1] - M[0][1] * M[1][0]
    r, s = tau1 - c[0], tau2 - c[1]
    return (M[1][1] * r - M[0][1] * s) / det, (M[0][0] * s - M[1][0] * r) / det
