from math import acos, atan2, cos, hypot, pi, sin, sqrt

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def dgm(q11, q21, assembly_mode):
    xa = -d / 2 + l11 * cos(q11)
    ya = l11 * sin(q11)
    xb = d / 2 + l21 * cos(q21)
    yb = l21 * sin(q21)
    D = hypot(xb - xa, yb - ya)
    if D > l12 + l22 or D < abs(l12 - l22):
        raise ValueError("no pose")
    theta = atan2(yb - ya, xb - xa)
    cos_beta = (l12**2 + D**2 - l22**2) / (2 * l12 * D)
    beta = acos(cos_beta)
    phi = theta - assembly_mode * beta
    return xa + l12 * cos(phi), ya + l12 * sin(phi)


def igm(x, y, gamma1, gamma2):
    r1 = sqrt((x + d / 2) ** 2 + y**2)
    r2 = sqrt((x - d / 2) ** 2 + y**2)
    psi1 = atan2(y, x + d / 2)
    psi2 = atan2(y, x - d / 2)
    alpha1 = acos((l11**2 + r1**2 - l12**2) / (2 * l11 * r1))
    alpha2 = acos((l21**2 + r2**2 - l22**2) / (2 * l21 * r2))
    return psi1 + gamma1 * alpha1, psi2 + gamma2 * alpha2


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y - l11 * sin(q11), x + d / 2 - l11 * cos(q11)) - q11
    q22 = atan2(y - l21 * sin(q21), x - d / 2 - l21 * cos(q21)) - q21
    return q12, q22
