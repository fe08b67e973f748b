# lab 5 by the principle of virtual power
import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def jacobian(q11, q12, q21, q22):
    f1, f2 = q11 + q12, q21 + q22
    b1 = l11 * np.sin(q12)
    b2 = l21 * np.sin(q22)
    s = np.sin(f2 - f1)
    return np.array([[np.sin(f2) * b1, -np.sin(f1) * b2], [-np.cos(f2) * b1, np.cos(f1) * b2]]) / s


def drift(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    f1, f2 = q11 + q12, q21 + q22
    f1D, f2D = q11D + q12D, q21D + q22D
    h1 = -l11 * np.cos(q12) * q11D**2 - l12 * f1D**2
    h2 = -l21 * np.cos(q22) * q21D**2 - l22 * f2D**2
    s = np.sin(f2 - f1)
    ax = (np.sin(f2) * h1 - np.sin(f1) * h2) / s
    ay = (np.cos(f1) * h2 - np.cos(f2) * h1) / s
    return np.array([ax, ay])


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    J = jacobian(q11, q12, q21, q22)
    bias = drift(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    M = np.array([[zz1, 0], [0, zz2]]) + m * (J.T @ J)
    c = J.T @ (m * bias)
    return M, c


def inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    J = jacobian(q11, q12, q21, q22)
    acc = J @ [q11DD, q21DD] + drift(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    tau1 = zz1 * q11DD + m * (J[0, 0] * acc[0] + J[1, 0] * acc[1])
    tau2 = zz2 * q21DD + m * (J[0, 1] * acc[0] + J[1, 1] * acc[1])
    return tau1, tau2


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    q11DD, q21DD = np.linalg.inv(M) @ (np.array([tau1, tau2]) - c)
    return q11DD, q21DD
