import numpy as np
from math import *
d, l, mp, mf = 0.4, 0.2828427, 3., 1.

def feet(q11, q21):
    return np.array([-d/2, q11]), np.array([d/2, q21])

def dgm(q11, q21, assembly_mode):
    A, B = feet(q11, q21)
    mid = (A+B)/2
    half = np.linalg.norm(B-A)/2
    n = np.array([-(B-A)[1], (B-A)[0]])/(2*half)
    x, y = mid - assembly_mode*sqrt(l**2-half**2)*n
    return x, y

def igm(x, y, gamma1, gamma2):
    dx1 = x+d/2
    dx2 = d/2-x
    return y+gamma1*sqrt(l*l-dx1*dx1), y+gamma2*sqrt(l*l-dx2*dx2)

def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    A, B = feet(q11, q21)
    return atan2(y-A[1], x-A[0]), atan2(y-B[1], x-B[0])

def dkm(q11, q12, q21, q22, q11D, q21D):
    s = sin(q22-q12)
    xD = (sin(q12)*sin(q22)*(q11D-q21D))/s
    yD = (cos(q12)*sin(q22)*q21D-sin(q12)*cos(q22)*q11D)/s
    return xD, yD

def ikm(q11, q12, q21, q22, xD, yD):
    return yD+xD/tan(q12), yD+xD/tan(q22)

def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    res = []
    for phi, v in ((q12, q11D), (q22, q21D)):
        res.append(((yD-v)*cos(phi)-xD*sin(phi))/l)
    return res

def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    r1 = sin(q12)*q11DD-l*q12D**2
    r2 = sin(q22)*q21DD-l*q22D**2
    s = sin(q22-q12)
    return (sin(q22)*r1-sin(q12)*r2)/s, (cos(q12)*r2-cos(q22)*r1)/s

def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    res = []
    for phi, w in ((q12, q12D), (q22, q22D)):
        res.append((cos(phi)*xDD+sin(phi)*yDD+l*w**2)/sin(phi))
    return res[0], res[1]

def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    res = []
    for phi, a in ((q12, q11DD), (q22, q21DD)):
        res.append(((yDD-a)*cos(phi)-xDD*sin(phi))/l)
    return res

def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    col1 = dkm(q11, q12, q21, q22, 1, 0)
    col2 = dkm(q11, q12, q21, q22, 0, 1)
    J = np.array([col1, col2]).T
    acc = np.array(dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, 0, 0))
    M = mf*np.identity(2) + mp*J.T@J
    c = mp*J.T@acc
    return M, c
