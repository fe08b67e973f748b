"""Five-bar, each point of the plane as one complex number."""

import cmath
import math

import numpy as np

l = 0.09
d = 0.118
ZZ1R = 0.002025
ZZ2R = 0.002025
mR = 0.5


def ray(angle):
    return cmath.exp(1j * angle)


def along(a, b):
    return a.real * b.real + a.imag * b.imag


def norm_angle(angle):
    return cmath.phase(ray(angle))


def knees(q11, q21):
    left = -d / 2 + l * ray(q11)
    right = d / 2 + l * ray(q21)
    return left, right


def tip(q11, q21, assembly_mode):
    left, right = knees(q11, q21)
    chord = right - left
    half = abs(chord) / 2
    if half > l:
        raise ValueError("too far apart")
    rise = math.sqrt(l**2 - half**2)
    normal = 1j * chord / abs(chord)
    return (left + right) / 2 - assembly_mode * rise * normal


def dgm(q11, q21, assembly_mode):
    p = tip(q11, q21, assembly_mode)
    return p.real, p.imag


def shoulder_angle(reach, gamma):
    r = abs(reach)
    if r > 2 * l:
        raise ValueError("out of reach")
    return cmath.phase(reach) + gamma * math.acos(r / (2 * l))


def igm(x, y, gamma1, gamma2):
    p = complex(x, y)
    q11 = shoulder_angle(p + d / 2, gamma1)
    q21 = shoulder_angle(p - d / 2, gamma2)
    return norm_angle(q11), norm_angle(q21)


def dgm_passive(q11, q21, assembly_mode):
    p = tip(q11, q21, assembly_mode)
    left, right = knees(q11, q21)
    q12 = norm_angle(cmath.phase(p - left) - q11)
    q22 = norm_angle(cmath.phase(p - right) - q21)
    return q12, q22


def bars(q11, q12, q21, q22):
    near = [ray(q11), ray(q21)]
    far = [ray(q11 + q12), ray(q21 + q22)]
    return near, far


def matrices(q11, q12, q21, q22):
    near, far = bars(q11, q12, q21, q22)
    A = np.array([[f.real, f.imag] for f in far])
    B = np.diag([l * along(f, 1j * n) for n, f in zip(near, far)])
    return A, B


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = matrices(q11, q12, q21, q22)
    xD, yD = np.linalg.solve(A, B @ [q11D, q21D])
    return xD, yD


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = matrices(q11, q12, q21, q22)
    rates = A @ [xD, yD] / np.diag(B)
    return rates[0], rates[1]


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    near, far = bars(q11, q12, q21, q22)
    v = complex(xD, yD)
    w1 = along(v - l * q11D * 1j * near[0], 1j * far[0]) / l
    w2 = along(v - l * q21D * 1j * near[1], 1j * far[1]) / l
    return w1 - q11D, w2 - q21D


def bend(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    near, far = bars(q11, q12, q21, q22)
    d1 = -l * q11D**2 * along(near[0], far[0]) - l * (q11D + q12D) ** 2
    d2 = -l * q21D**2 * along(near[1], far[1]) - l * (q21D + q22D) ** 2
    return np.array([d1, d2])


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = matrices(q11, q12, q21, q22)
    b = bend(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    xDD, yDD = np.linalg.solve(A, B @ [q11DD, q21DD] + b)
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = matrices(q11, q12, q21, q22)
    b = bend(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    acc = np.linalg.solve(B, A @ [xDD, yDD] - b)
    return acc[0], acc[1]


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    near, far = bars(q11, q12, q21, q22)
    a = complex(xDD, yDD)
    left = l * q11DD * 1j * near[0] - l * q11D**2 * near[0]
    right = l * q21DD * 1j * near[1] - l * q21D**2 * near[1]
    w1D = along(a - left, 1j * far[0]) / l
    w2D = along(a - right, 1j * far[1]) / l
    return w1D - q11DD, w2D - q21DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = matrices(q11, q12, q21, q22)
    b = bend(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    J = np.linalg.solve(A, B)
    drift = np.linalg.solve(A, b)
    M = np.diag([ZZ1R, ZZ2R]) + mR * J.T @ J
    c = mR * J.T @ drift
    return M, c
