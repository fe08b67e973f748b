"""Biglide; the bars' slopes, everything by hand."""

import numpy as np
from numpy import arctan2, array, cos, sin, sqrt, tan

d = 0.4
l = 0.2828427
mp = 3.0
mf = 1.0


def dgm(q11, q21, assembly_mode):
    rise = q21 - q11
    span2 = d**2 + rise**2
    w = sqrt(l**2 / span2 - 0.25)
    x = assembly_mode * w * rise
    y = (q11 + q21) / 2 - assembly_mode * w * d
    return x, y


def igm(x, y, gamma1, gamma2):
    drop1 = sqrt(l**2 - (x + d / 2) ** 2)
    drop2 = sqrt(l**2 - (d / 2 - x) ** 2)
    return y + gamma1 * drop1, y + gamma2 * drop2


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = arctan2(y - q11, x + d / 2)
    q22 = arctan2(y - q21, x - d / 2)
    return q12, q22


def dkm(q11, q12, q21, q22, q11D, q21D):
    # cos * xD + sin * (yD - qD) = 0 for both
    det = sin(q22 - q12)
    xD = (sin(q22) * sin(q12) * q11D - sin(q12) * sin(q22) * q21D) / det
    yD = (cos(q12) * sin(q22) * q21D - cos(q22) * sin(q12) * q11D) / det
    return xD, yD


def ikm(q11, q12, q21, q22, xD, yD):
    return yD + xD / tan(q12), yD + xD / tan(q22)


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    q12D = (cos(q12) * (yD - q11D) - sin(q12) * xD) / l
    q22D = (cos(q22) * (yD - q21D) - sin(q22) * xD) / l
    return q12D, q22D


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    r1 = sin(q12) * q11DD - l * q12D**2
    r2 = sin(q22) * q21DD - l * q22D**2
    det = sin(q22 - q12)
    xDD = (sin(q22) * r1 - sin(q12) * r2) / det
    yDD = (cos(q12) * r2 - cos(q22) * r1) / det
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    q11DD = yDD + (cos(q12) * xDD + l * q12D**2) / sin(q12)
    q21DD = yDD + (cos(q22) * xDD + l * q22D**2) / sin(q22)
    return q11DD, q21DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    q12DD = (cos(q12) * (yDD - q11DD) - sin(q12) * xDD) / l
    q22DD = (cos(q22) * (yDD - q21DD) - sin(q22) * xDD) / l
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    det = sin(q22 - q12)
    s1 = sin(q12)
    s2 = sin(q22)
    J = array([[s2 * s1, -s1 * s2], [-cos(q22) * s1, cos(q12) * s2]]) / det
    bias = array(dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, 0, 0))
    M = mf * np.eye(2) + mp * np.dot(J.T, J)
    c = mp * np.dot(J.T, bias)
    return M, c
