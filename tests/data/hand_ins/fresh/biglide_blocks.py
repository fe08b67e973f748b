from math import *
import numpy as np

l = 0.2828427
d = 0.4
mp = 3.0
mf = 1.0


def dgm(q11, q21, assembly_mode):
    A12 = np.array([-d / 2, q11])
    A22 = np.array([d / 2, q21])
    A22H = (A12 - A22) / 2
    a = sqrt(A22H[0]**2 + A22H[1]**2)
    h = sqrt(l**2 - a**2)
    R = np.array([[0, -1], [1, 0]])
    OA13 = A22 + A22H + assembly_mode * h / a * R.dot(A22H)
    return OA13[0], OA13[1]


def igm(x, y, gamma1, gamma2):
    q11 = y + gamma1 * sqrt(l**2 - (x + d / 2)**2)
    q21 = y + gamma2 * sqrt(l**2 - (x - d / 2)**2)
    return q11, q21


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y - q11, x + d / 2)
    q22 = atan2(y - q21, x - d / 2)
    return q12, q22


def compute_A_B(q12, q22):
    A = np.array([[cos(q12), sin(q12)], [cos(q22), sin(q22)]])
    B = np.array([[sin(q12), 0], [0, sin(q22)]])
    return A, B


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = compute_A_B(q12, q22)
    xiD = np.linalg.inv(A).dot(B).dot(np.array([q11D, q21D]))
    return xiD[0], xiD[1]


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = compute_A_B(q12, q22)
    qD = np.linalg.inv(B).dot(A).dot(np.array([xD, yD]))
    return qD[0], qD[1]


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    q12D = (-sin(q12) * xD + cos(q12) * yD - cos(q12) * q11D) / l
    q22D = (-sin(q22) * xD + cos(q22) * yD - cos(q22) * q21D) / l
    return q12D, q22D


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = compute_A_B(q12, q22)
    b = np.array([-l * q12D**2, -l * q22D**2])
    xiDD = np.linalg.inv(A).dot(B.dot(np.array([q11DD, q21DD])) + b)
    return xiDD[0], xiDD[1]


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = compute_A_B(q12, q22)
    b = np.array([-l * q12D**2, -l * q22D**2])
    qDD = np.linalg.inv(B).dot(A.dot(np.array([xDD, yDD])) - b)
    return qDD[0], qDD[1]


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    q12DD = (-sin(q12) * xDD + cos(q12) * yDD - cos(q12) * q11DD) / l
    q22DD = (-sin(q22) * xDD + cos(q22) * yDD - cos(q22) * q21DD) / l
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = compute_A_B(q12, q22)
    b = np.array([-l * q12D**2, -l * q22D**2])
    J = np.linalg.inv(A).dot(B)
    M = mf * np.eye(2) + mp * J.T.dot(J)
    c = mp * J.T.dot(np.linalg.inv(A).dot(b))
    return M, c
