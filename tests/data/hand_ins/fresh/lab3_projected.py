from math import cos, sin

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    f1 = q11 + q12
    f2 = q21 + q22
    f1D = q11D + q12D
    f2D = q21D + q22D
    # the distal bar's length is constant: project the acceleration of the elbow on the bar
    r1 = l11 * sin(f1 - q11) * q11DD - l11 * cos(f1 - q11) * q11D**2 - l12 * f1D**2
    r2 = l21 * sin(f2 - q21) * q21DD - l21 * cos(f2 - q21) * q21D**2 - l22 * f2D**2
    det = cos(f1) * sin(f2) - sin(f1) * cos(f2)
    xDD = (r1 * sin(f2) - r2 * sin(f1)) / det
    yDD = (r2 * cos(f1) - r1 * cos(f2)) / det
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    f1 = q11 + q12
    f2 = q21 + q22
    p1 = cos(f1) * xDD + sin(f1) * yDD + l12 * (q11D + q12D) ** 2 + l11 * cos(q12) * q11D**2
    p2 = cos(f2) * xDD + sin(f2) * yDD + l22 * (q21D + q22D) ** 2 + l21 * cos(q22) * q21D**2
    return p1 / (l11 * sin(q12)), p2 / (l21 * sin(q22))


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    n1 = cos(q11 + q12) * yDD - sin(q11 + q12) * xDD
    n2 = cos(q21 + q22) * yDD - sin(q21 + q22) * xDD
    a1 = n1 - l11 * q11DD * cos(q12) - l11 * q11D**2 * sin(q12)
    a2 = n2 - l21 * q21DD * cos(q22) - l21 * q21D**2 * sin(q22)
    return a1 / l12 - q11DD, a2 / l22 - q21DD
