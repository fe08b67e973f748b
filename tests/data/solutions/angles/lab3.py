"""Lab 3 with sines and cosines of the joint angles only."""

import math

l11 = l12 = l21 = l22 = 0.09
d = 0.118
zz1 = zz2 = 0.002
m = 0.5


def along(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    return (
        l11 * math.cos(q12) * q11D * q11D + l12 * math.pow(q11D + q12D, 2),
        l21 * math.cos(q22) * q21D * q21D + l22 * math.pow(q21D + q22D, 2),
    )


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    pull = along(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    r, s = l11 * math.sin(q12) * q11DD - pull[0], l21 * math.sin(q22) * q21DD - pull[1]
    a, b = q11 + q12, q21 + q22
    sine = math.sin(b - a)
    return (r * math.sin(b) - s * math.sin(a)) / sine, (s * math.cos(a) - r * math.cos(b)) / sine


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    pull = along(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    a, b = q11 + q12, q21 + q22
    return (
        (xDD * math.cos(a) + yDD * math.sin(a) + pull[0]) / l11 / math.sin(q12),
        (xDD * math.cos(b) + yDD * math.sin(b) + pull[1]) / l21 / math.sin(q22),
    )


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    found = []
    for q1, q2, q1D, q1DD, l1, l2 in (
        (q11, q12, q11D, q11DD, l11, l12),
        (q21, q22, q21D, q21DD, l21, l22),
    ):
        # the acceleration of the end-effector across the distal bar, less the elbow's
        across = -xDD * math.sin(q1 + q2) + yDD * math.cos(q1 + q2)
        elbow = l1 * (math.cos(q2) * q1DD + math.sin(q2) * q1D * q1D)
        found.append((across - elbow) / l2 - q1DD)
    return found
