#!/usr/bin/env python3
from math import cos, sin, sqrt, atan2, acos, pi
import numpy as np
from numpy.linalg import inv, norm

# Geometric parameters
l = 0.09
d = 0.118
# Dynamic parameters
ZZ1R = 1.0 * 0.045 * 0.045
ZZ2R = 1.0 * 0.045 * 0.045
mR = 0.5

E = np.array([[0, -1], [1, 0]])


def get_u11(q11):
    return np.array([[cos(q11)], [sin(q11)]])


def get_u21(q21):
    return np.array([[cos(q21)], [sin(q21)]])


def get_u12(q11, q12):
    return np.array([[cos(q11 + q12)], [sin(q11 + q12)]])


def get_u22(q21, q22):
    return np.array([[cos(q21 + q22)], [sin(q21 + q22)]])


def compute_A_B(q11, q12, q21, q22):
    u12 = get_u12(q11, q12)
    u22 = get_u22(q21, q22)
    v11 = E @ get_u11(q11)
    v21 = E @ get_u21(q21)
    A = np.zeros((2, 2))
    A[0, :] = u12.T
    A[1, :] = u22.T
    B = np.zeros((2, 2))
    B[0, 0] = l * (u12.T @ v11)[0, 0]
    B[1, 1] = l * (u22.T @ v21)[0, 0]
    return A, B


def compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    u11 = get_u11(q11)
    u21 = get_u21(q21)
    u12 = get_u12(q11, q12)
    u22 = get_u22(q21, q22)
    dd = np.zeros((2, 1))
    dd[0] = -l * q11D**2 * (u12.T @ u11)[0, 0] - l * (q11D + q12D)**2
    dd[1] = -l * q21D**2 * (u22.T @ u21)[0, 0] - l * (q21D + q22D)**2
    return dd


def dgm(q11, q21, assembly_mode):
    OA12 = np.array([[-d / 2 + l * cos(q11)], [l * sin(q11)]])
    OA22 = np.array([[d / 2 + l * cos(q21)], [l * sin(q21)]])
    A22H = 0.5 * (OA12 - OA22)
    a = norm(A22H)
    h = sqrt(l**2 - a**2)
    HA13 = assembly_mode * h / a * (E @ A22H)
    OA13 = OA22 + A22H + HA13
    x = OA13[0, 0]
    y = OA13[1, 0]
    return x, y


def igm(x, y, gamma1, gamma2):
    # left leg
    A11M1 = 0.5 * np.array([[x + d / 2], [y]])
    c1 = norm(A11M1)
    b1 = sqrt(l**2 - c1**2)
    M1A12 = gamma1 * b1 / c1 * (E @ A11M1)
    A11A12 = A11M1 + M1A12
    q11 = atan2(A11A12[1, 0], A11A12[0, 0])
    # right leg
    A21M2 = 0.5 * np.array([[x - d / 2], [y]])
    c2 = norm(A21M2)
    b2 = sqrt(l**2 - c2**2)
    M2A22 = gamma2 * b2 / c2 * (E @ A21M2)
    A21A22 = A21M2 + M2A22
    q21 = atan2(A21A22[1, 0], A21A22[0, 0])
    return q11, q21


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y / l - sin(q11), x / l + d / (2 * l) - cos(q11)) - q11
    q22 = atan2(y / l - sin(q21), x / l - d / (2 * l) - cos(q21)) - q21
    return q12, q22


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = compute_A_B(q11, q12, q21, q22)
    qaD = np.array([[q11D], [q21D]])
    xiD = inv(A) @ B @ qaD
    return xiD[0, 0], xiD[1, 0]


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = compute_A_B(q11, q12, q21, q22)
    xiD = np.array([[xD], [yD]])
    qaD = inv(B) @ A @ xiD
    return qaD[0, 0], qaD[1, 0]


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    v11 = E @ get_u11(q11)
    v21 = E @ get_u21(q21)
    v12 = E @ get_u12(q11, q12)
    v22 = E @ get_u22(q21, q22)
    xiD = np.array([[xD], [yD]])
    q12D = (v12.T @ xiD)[0, 0] / l - q11D * ((v12.T @ v11)[0, 0] + 1)
    q22D = (v22.T @ xiD)[0, 0] / l - q21D * ((v22.T @ v21)[0, 0] + 1)
    return q12D, q22D


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = compute_A_B(q11, q12, q21, q22)
    b = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    qaDD = np.array([[q11DD], [q21DD]])
    xiDD = inv(A) @ (B @ qaDD + b)
    return xiDD[0, 0], xiDD[1, 0]


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = compute_A_B(q11, q12, q21, q22)
    b = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    xiDD = np.array([[xDD], [yDD]])
    qaDD = inv(B) @ (A @ xiDD - b)
    return qaDD[0, 0], qaDD[1, 0]


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    u11 = get_u11(q11)
    u21 = get_u21(q21)
    v11 = E @ u11
    v21 = E @ u21
    v12 = E @ get_u12(q11, q12)
    v22 = E @ get_u22(q21, q22)
    xiDD = np.array([[xDD], [yDD]])
    t1 = (v12.T @ xiDD)[0, 0] - l * q11DD * (v12.T @ v11)[0, 0] + l * q11D**2 * (v12.T @ u11)[0, 0]
    t2 = (v22.T @ xiDD)[0, 0] - l * q21DD * (v22.T @ v21)[0, 0] + l * q21D**2 * (v22.T @ u21)[0, 0]
    q12DD = t1 / l - q11DD
    q22DD = t2 / l - q21DD
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = compute_A_B(q11, q12, q21, q22)
    b = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    J = inv(A) @ B
    Mz = np.array([[ZZ1R, 0], [0, ZZ2R]])
    M = Mz + mR * J.T @ J
    c = mR * J.T @ inv(A) @ b
    return M, c
