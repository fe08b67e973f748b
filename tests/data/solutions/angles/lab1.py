"""Lab 1 by angles and the law of cosines."""

import math

l11 = l12 = l21 = l22 = 0.09
d = 0.118
zz1 = zz2 = 0.002
m = 0.5


def corner(side1, side2, opposite):
    return math.acos((side1**2 + side2**2 - opposite**2) / (2 * side1 * side2))


def dgm(q11, q21, assembly_mode):
    x12, y12 = -d / 2 + l11 * math.cos(q11), l11 * math.sin(q11)
    x22, y22 = d / 2 + l21 * math.cos(q21), l21 * math.sin(q21)
    span = math.dist((x12, y12), (x22, y22))
    phi = math.atan2(y22 - y12, x22 - x12) - assembly_mode * corner(l12, span, l22)
    return x12 + l12 * math.cos(phi), y12 + l12 * math.sin(phi)


def igm(x, y, gamma1, gamma2):
    angles = []
    for base, l1, l2, gamma in ((-d / 2, l11, l12, gamma1), (d / 2, l21, l22, gamma2)):
        span = math.hypot(x - base, y)
        angles.append(math.atan2(y, x - base) + gamma * corner(l1, span, l2))
    return angles


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    angles = []
    for base, l1, q in ((-d / 2, l11, q11), (d / 2, l21, q21)):
        X, Y = x - base, y
        # the end-effector in the frame of the proximal bar
        angles.append(
            math.atan2(-X * math.sin(q) + Y * math.cos(q), X * math.cos(q) + Y * math.sin(q) - l1)
        )
    return tuple(angles)
