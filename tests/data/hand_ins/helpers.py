import numpy as np
import math
from lab_amoro.plot_tools import *

class Params:
    l = 0.09
    d = 0.118

d = Params.d
l = Params.l
ZZ1R = 1.0 * 0.045 * 0.045
ZZ2R = ZZ1R
mR = 0.5

def rot90(vec):
    return np.array([-vec[1], vec[0]])

def unit(theta: float) -> np.ndarray:
    return np.array([np.cos(theta), np.sin(theta)])

def dgm(q11, q21, assembly_mode):
    A11, A21 = np.array([-d / 2, 0]), np.array([d / 2, 0])
    A12 = A11 + l * unit(q11)
    A22 = A21 + l * unit(q21)
    A22H = 0.5 * (A12 - A22)
    a = np.sqrt(A22H[0] ** 2 + A22H[1] ** 2)
    h = np.sqrt(l**2 - a**2)
    HA13 = assembly_mode * h / a * rot90(A22H)
    OA13 = A21 + l * unit(q21) + A22H + HA13
    return OA13[0], OA13[1]

def leg_igm(x, y, base_x, gamma):
    AM = 0.5 * np.array([x - base_x, y])
    c = np.linalg.norm(AM)
    b = np.sqrt(l**2 - c**2)
    AA = AM + gamma * b / c * rot90(AM)
    return math.atan2(AA[1], AA[0])

def igm(x, y, gamma1, gamma2):
    q11 = leg_igm(x, y, -d / 2, gamma1)
    q21 = leg_igm(x, y, d / 2, gamma2)
    return q11, q21

def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = math.atan2(y / l - np.sin(q11), x / l + d / (2 * l) - np.cos(q11)) - q11
    q22 = math.atan2(y / l - np.sin(q21), x / l - d / (2 * l) - np.cos(q21)) - q21
    # ramener dans [-pi, pi]
    q12 = (q12 + math.pi) % (2 * math.pi) - math.pi
    q22 = (q22 + math.pi) % (2 * math.pi) - math.pi
    return q12, q22

def vectors(q11, q12, q21, q22):
    u11, u21 = unit(q11), unit(q21)
    u12, u22 = unit(q11 + q12), unit(q21 + q22)
    return u11, u12, u21, u22, rot90(u11), rot90(u12), rot90(u21), rot90(u22)

def compute_A_B(q11, q12, q21, q22):
    u11, u12, u21, u22, v11, v12, v21, v22 = vectors(q11, q12, q21, q22)
    A = np.array([u12, u22])
    B = np.diag([l * u12 @ v11, l * u22 @ v21])
    return A, B

def compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    u11, u12, u21, u22, v11, v12, v21, v22 = vectors(q11, q12, q21, q22)
    return np.array([-l*q11D**2*u12.dot(u11) - l*(q11D + q12D)**2,
                     -l*q21D**2*u22.dot(u21) - l*(q21D + q22D)**2])

def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = compute_A_B(q11, q12, q21, q22)
    xiD = np.linalg.inv(A) @ B @ np.array([q11D, q21D])
    return xiD

def ikm(q11, q12, q21, q22, xD, yD):
    A, B = compute_A_B(q11, q12, q21, q22)
    qD = np.linalg.inv(B) @ A @ np.array([xD, yD])
    return qD

def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    u11, u12, u21, u22, v11, v12, v21, v22 = vectors(q11, q12, q21, q22)
    V = np.array([v12, v22])
    K = np.diag([l * v12 @ v11 + l, l * v22 @ v21 + l])
    return 1 / l * (V @ np.array([xD, yD]) - K @ np.array([q11D, q21D]))

def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = compute_A_B(q11, q12, q21, q22)
    delta = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    xiDD = np.linalg.inv(A) @ (B @ np.array([q11DD, q21DD]) + delta)
    return xiDD[0], xiDD[1]

def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = compute_A_B(q11, q12, q21, q22)
    delta = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    qDD = np.linalg.inv(B) @ (A @ np.array([xDD, yDD]) - delta)
    return qDD[0], qDD[1]

def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    u11, u12, u21, u22, v11, v12, v21, v22 = vectors(q11, q12, q21, q22)
    V = np.array([v12, v22])
    K = np.diag([l * v12 @ v11 + l, l * v22 @ v21 + l])
    e = np.array([-l * q11D**2 * v12 @ u11, -l * q21D**2 * v22 @ u21])
    qpDD = 1 / l * (V @ np.array([xDD, yDD]) - K @ np.array([q11DD, q21DD]) - e)
    return qpDD[0], qpDD[1]

def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = compute_A_B(q11, q12, q21, q22)
    delta = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    invA = np.linalg.inv(A)
    J = invA @ B
    M = np.diag([ZZ1R, ZZ2R]) + mR * J.T @ J
    c = mR * J.T @ invA @ delta
    return M, c
