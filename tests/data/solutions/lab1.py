"""Lab 1 as the handout derives it, for four bar lengths."""

from math import atan2, cos, hypot, sin, sqrt

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def dgm(q11, q21, assembly_mode):
    xl, yl = -d / 2 + l11 * cos(q11), l11 * sin(q11)
    xr, yr = d / 2 + l21 * cos(q21), l21 * sin(q21)
    ux, uy = xl - xr, yl - yr
    D = hypot(ux, uy)
    ux, uy = ux / D, uy / D
    a = (D**2 + l22**2 - l12**2) / (2 * D)
    h = sqrt(l22**2 - a**2)
    x = xr + a * ux - assembly_mode * h * uy
    y = yr + a * uy + assembly_mode * h * ux
    return x, y


def arm(x, y, base, l1, l2, gamma):
    X, Y = x - base, y
    D = hypot(X, Y)
    c = (D**2 + l1**2 - l2**2) / (2 * D)
    b = sqrt(l1**2 - c**2)
    ex = (c * X - gamma * b * Y) / D
    ey = (c * Y + gamma * b * X) / D
    return atan2(ey, ex)


def igm(x, y, gamma1, gamma2):
    q11 = arm(x, y, -d / 2, l11, l12, gamma1)
    q21 = arm(x, y, d / 2, l21, l22, gamma2)
    return q11, q21


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y - l11 * sin(q11), x + d / 2 - l11 * cos(q11)) - q11
    q22 = atan2(y - l21 * sin(q21), x - d / 2 - l21 * cos(q21)) - q21
    return q12, q22
