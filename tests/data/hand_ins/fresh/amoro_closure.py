# AMORO five bar. Everything from the closure |X - E| = l and its time derivatives, no matrices.
from math import acos, atan2, cos, hypot, pi, sin

d = 0.118
l = 0.09
ZZ1R = 0.045 * 0.045
ZZ2R = 0.045 * 0.045
mR = 0.5


def principal(a):
    while a > pi:
        a -= 2 * pi
    while a <= -pi:
        a += 2 * pi
    return a


def elbow(side, q):
    return side * d / 2 + l * cos(q), l * sin(q)


def cramer(a11, a12, a21, a22, b1, b2):
    det = a11 * a22 - a12 * a21
    return (b1 * a22 - b2 * a12) / det, (a11 * b2 - a21 * b1) / det


def absolute_angles(q11, q21, assembly_mode):
    ex, ey = elbow(-1, q11)
    fx, fy = elbow(1, q21)
    base = hypot(fx - ex, fy - ey)
    slope = atan2(fy - ey, fx - ex)
    corner = acos(base / 2 / l)
    psi1 = slope - assembly_mode * corner
    psi2 = slope + pi + assembly_mode * corner
    return psi1, psi2


def dgm(q11, q21, assembly_mode):
    psi1, psi2 = absolute_angles(q11, q21, assembly_mode)
    ex, ey = elbow(-1, q11)
    x = ex + l * cos(psi1)
    y = ey + l * sin(psi1)
    return x, y


def dgm_passive(q11, q21, assembly_mode):
    psi1, psi2 = absolute_angles(q11, q21, assembly_mode)
    return principal(psi1 - q11), principal(psi2 - q21)


def igm(x, y, gamma1, gamma2):
    answers = []
    for side, gamma in ((-1, gamma1), (1, gamma2)):
        dx = x - side * d / 2
        r2 = dx**2 + y**2
        cos_knee = r2 / (2 * l**2) - 1
        knee = -gamma * acos(cos_knee)
        q = atan2(y, dx) - atan2(sin(knee), 1 + cos(knee))
        answers.append(principal(q))
    return answers[0], answers[1]


def arms(q11, q12, q21, q22):
    # distal bars as vectors, from the elbow to the end-effector
    ax, ay = l * cos(q11 + q12), l * sin(q11 + q12)
    bx, by = l * cos(q21 + q22), l * sin(q21 + q22)
    return ax, ay, bx, by


def dkm(q11, q12, q21, q22, q11D, q21D):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    exD, eyD = -l * sin(q11) * q11D, l * cos(q11) * q11D
    fxD, fyD = -l * sin(q21) * q21D, l * cos(q21) * q21D
    return cramer(ax, ay, bx, by, ax * exD + ay * eyD, bx * fxD + by * fyD)


def ikm(q11, q12, q21, q22, xD, yD):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    q11D = (ax * xD + ay * yD) / (l * (ay * cos(q11) - ax * sin(q11)))
    q21D = (bx * xD + by * yD) / (l * (by * cos(q21) - bx * sin(q21)))
    return q11D, q21D


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    sx, sy = xD + l * sin(q11) * q11D, yD - l * cos(q11) * q11D
    tx, ty = xD + l * sin(q21) * q21D, yD - l * cos(q21) * q21D
    turn1 = (ax * sy - ay * sx) / l**2
    turn2 = (bx * ty - by * tx) / l**2
    return turn1 - q11D, turn2 - q21D


def squares(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    # |XD - ED|^2 of both distal bars
    return (l * (q11D + q12D)) ** 2, (l * (q21D + q22D)) ** 2


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    s1, s2 = squares(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    exDD = -l * sin(q11) * q11DD - l * cos(q11) * q11D**2
    eyDD = l * cos(q11) * q11DD - l * sin(q11) * q11D**2
    fxDD = -l * sin(q21) * q21DD - l * cos(q21) * q21D**2
    fyDD = l * cos(q21) * q21DD - l * sin(q21) * q21D**2
    rhs1 = ax * exDD + ay * eyDD - s1
    rhs2 = bx * fxDD + by * fyDD - s2
    return cramer(ax, ay, bx, by, rhs1, rhs2)


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    s1, s2 = squares(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    pull1 = ax * (xDD + l * cos(q11) * q11D**2) + ay * (yDD + l * sin(q11) * q11D**2)
    pull2 = bx * (xDD + l * cos(q21) * q21D**2) + by * (yDD + l * sin(q21) * q21D**2)
    q11DD = (pull1 + s1) / (l * (ay * cos(q11) - ax * sin(q11)))
    q21DD = (pull2 + s2) / (l * (by * cos(q21) - bx * sin(q21)))
    return q11DD, q21DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    ax, ay, bx, by = arms(q11, q12, q21, q22)
    sx = xDD + l * sin(q11) * q11DD + l * cos(q11) * q11D**2
    sy = yDD - l * cos(q11) * q11DD + l * sin(q11) * q11D**2
    tx = xDD + l * sin(q21) * q21DD + l * cos(q21) * q21D**2
    ty = yDD - l * cos(q21) * q21DD + l * sin(q21) * q21D**2
    q12DD = (ax * sy - ay * sx) / l**2 - q11DD
    q22DD = (bx * ty - by * tx) / l**2 - q21DD
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    state = (q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    j11, j21 = dkm(q11, q12, q21, q22, 1, 0)
    j12, j22 = dkm(q11, q12, q21, q22, 0, 1)
    ax, ay = dkm2(*state, 0, 0)
    M = [
        [ZZ1R + mR * (j11**2 + j21**2), mR * (j11 * j12 + j21 * j22)],
        [mR * (j11 * j12 + j21 * j22), ZZ2R + mR * (j12**2 + j22**2)],
    ]
    c = [mR * (j11 * ax + j21 * ay), mR * (j12 * ax + j22 * ay)]
    return M, c
