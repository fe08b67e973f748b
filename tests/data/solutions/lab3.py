"""Lab 3 as the handout derives it, for four bar lengths."""

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


def bias(u12, u11, l1, l2, q1D, q2D):
    elbow = -l1 * q1D**2 * dot(u12, u11)
    bar = -l2 * (q1D + q2D) ** 2
    return elbow + bar


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    u12, u22 = u(q11 + q12), u(q21 + q22)
    r1 = l11 * dot(u12, v(q11)) * q11DD + bias(u12, u(q11), l11, l12, q11D, q12D)
    r2 = l21 * dot(u22, v(q21)) * q21DD + bias(u22, u(q21), l21, l22, q21D, q22D)
    det = u12[0] * u22[1] - u12[1] * u22[0]
    xDD = (u22[1] * r1 - u12[1] * r2) / det
    yDD = (u12[0] * r2 - u22[0] * r1) / det
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    u12, u22 = u(q11 + q12), u(q21 + q22)
    r1 = dot(u12, (xDD, yDD)) - bias(u12, u(q11), l11, l12, q11D, q12D)
    r2 = dot(u22, (xDD, yDD)) - bias(u22, u(q21), l21, l22, q21D, q22D)
    return r1 / (l11 * dot(u12, v(q11))), r2 / (l21 * dot(u22, v(q21)))


def swing(phi, q1, l1, l2, q1D, q1DD, a):
    along = dot(v(phi), a) - l1 * q1DD * dot(v(phi), v(q1)) + l1 * q1D**2 * dot(v(phi), u(q1))
    return along / l2 - q1DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    q12DD = swing(q11 + q12, q11, l11, l12, q11D, q11DD, (xDD, yDD))
    q22DD = swing(q21 + q22, q21, l21, l22, q21D, q21DD, (xDD, yDD))
    return q12DD, q22DD
