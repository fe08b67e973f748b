import math as mt
import numpy as np

l = 0.09
d = 0.118
zz = 0.002
mass = 0.5

# Modele geometrique direct
def dgm(q11, q21, assembly_mode):
    xB = -d / 2 + l * mt.cos(q11)
    yB = l * mt.sin(q11)
    xD_ = d / 2 + l * mt.cos(q21)
    yD_ = l * mt.sin(q21)
    dist = mt.sqrt((xB - xD_) ** 2 + (yB - yD_) ** 2)
    psi = mt.atan2(yB - yD_, xB - xD_)
    alpha = mt.acos(dist / (2 * l))
    x = xD_ + l * mt.cos(psi + assembly_mode * alpha)
    y = yD_ + l * mt.sin(psi + assembly_mode * alpha)
    return x, y

# Modele geometrique inverse
def igm(x, y, gamma1, gamma2):
    r1 = mt.hypot(x + d / 2, y)
    r2 = mt.hypot(x - d / 2, y)
    phi1 = mt.atan2(y, x + d / 2)
    phi2 = mt.atan2(y, x - d / 2)
    q11 = phi1 + gamma1 * mt.acos(r1 / (2 * l))
    q21 = phi2 + gamma2 * mt.acos(r2 / (2 * l))
    return q11, q21

def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    theta1 = mt.atan2(y - l * mt.sin(q11), x + d / 2 - l * mt.cos(q11))
    theta2 = mt.atan2(y - l * mt.sin(q21), x - d / 2 - l * mt.cos(q21))
    return theta1 - q11, theta2 - q21

def matA(q11, q12, q21, q22):
    return np.array([[mt.cos(q11 + q12), mt.sin(q11 + q12)],
                     [mt.cos(q21 + q22), mt.sin(q21 + q22)]])

def matB(q11, q12, q21, q22):
    return np.array([[l * mt.sin(q12), 0],
                     [0, l * mt.sin(q22)]])

def vecb(q12, q22, q11D, q12D, q21D, q22D):
    b1 = -l * mt.cos(q12) * q11D ** 2 - l * (q11D + q12D) ** 2
    b2 = -l * mt.cos(q22) * q21D ** 2 - l * (q21D + q22D) ** 2
    return np.array([b1, b2])

def dkm(q11, q12, q21, q22, q11D, q21D):
    xD, yD = np.linalg.solve(matA(q11, q12, q21, q22), matB(q11, q12, q21, q22).dot([q11D, q21D]))
    return xD, yD

def ikm(q11, q12, q21, q22, xD, yD):
    q11D, q21D = np.linalg.solve(matB(q11, q12, q21, q22), matA(q11, q12, q21, q22).dot([xD, yD]))
    return q11D, q21D

def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    w1 = (-mt.sin(q11 + q12) * xD + mt.cos(q11 + q12) * yD - l * mt.cos(q12) * q11D) / l
    w2 = (-mt.sin(q21 + q22) * xD + mt.cos(q21 + q22) * yD - l * mt.cos(q22) * q21D) / l
    return w1 - q11D, w2 - q21D

def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A = matA(q11, q12, q21, q22)
    B = matB(q11, q12, q21, q22)
    b = vecb(q12, q22, q11D, q12D, q21D, q22D)
    xDD, yDD = np.linalg.solve(A, B.dot([q11DD, q21DD]) + b)
    return xDD, yDD

def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A = matA(q11, q12, q21, q22)
    B = matB(q11, q12, q21, q22)
    b = vecb(q12, q22, q11D, q12D, q21D, q22D)
    q11DD, q21DD = np.linalg.solve(B, A.dot([xDD, yDD]) - b)
    return q11DD, q21DD

def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    s1 = -mt.sin(q11 + q12) * xDD + mt.cos(q11 + q12) * yDD
    s2 = -mt.sin(q21 + q22) * xDD + mt.cos(q21 + q22) * yDD
    w1D = (s1 - l * mt.cos(q12) * q11DD - l * mt.sin(q12) * q11D ** 2) / l
    w2D = (s2 - l * mt.cos(q22) * q21DD - l * mt.sin(q22) * q21D ** 2) / l
    return w1D - q11DD, w2D - q21DD

def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A = matA(q11, q12, q21, q22)
    B = matB(q11, q12, q21, q22)
    b = vecb(q12, q22, q11D, q12D, q21D, q22D)
    J = np.linalg.solve(A, B)
    a0 = np.linalg.solve(A, b)
    M = zz * np.eye(2) + mass * J.T.dot(J)
    c = mass * J.T.dot(a0)
    return M, c
