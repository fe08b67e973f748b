"""Lab 2 with sines and cosines of the joint angles only."""

import math

l11 = l12 = l21 = l22 = 0.09
d = 0.118
zz1 = zz2 = 0.002
m = 0.5


def A(q11, q12, q21, q22):
    a, b = q11 + q12, q21 + q22
    return ((math.cos(a), math.sin(a)), (math.cos(b), math.sin(b)))


def B(q11, q12, q21, q22):
    return ((l11 * math.sin(q12), 0), (0, l21 * math.sin(q22)))


def dkm(q11, q12, q21, q22, q11D, q21D):
    a, b = q11 + q12, q21 + q22
    s = math.sin(b - a)
    assert abs(s) > 1e-9, "Type 2"
    r1, r2 = l11 * math.sin(q12) * q11D, l21 * math.sin(q22) * q21D
    return (r1 * math.sin(b) - r2 * math.sin(a)) / s, (r2 * math.cos(a) - r1 * math.cos(b)) / s


def ikm(q11, q12, q21, q22, xD, yD):
    if min(abs(math.sin(q12)), abs(math.sin(q22))) < 1e-9:
        return float("nan"), float("nan")
    a, b = q11 + q12, q21 + q22
    return (
        (math.cos(a) * xD + math.sin(a) * yD) / (l11 * math.sin(q12)),
        (math.cos(b) * xD + math.sin(b) * yD) / (l21 * math.sin(q22)),
    )


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    a, b = q11 + q12, q21 + q22
    wa = (-math.sin(a) * xD + math.cos(a) * yD - l11 * math.cos(q12) * q11D) / l12
    wb = (-math.sin(b) * xD + math.cos(b) * yD - l21 * math.cos(q22) * q21D) / l22
    return [wa - q11D, wb - q21D]
