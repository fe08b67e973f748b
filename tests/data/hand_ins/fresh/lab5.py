import numpy as np
from numpy import cos, sin

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def jacobian(q11, q12, q21, q22):
    A = np.array([[cos(q11 + q12), sin(q11 + q12)], [cos(q21 + q22), sin(q21 + q22)]])
    B = np.diag([l11 * sin(q12), l21 * sin(q22)])
    return A, np.linalg.solve(A, B)


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, J = jacobian(q11, q12, q21, q22)
    d1 = -l11 * q11D**2 * cos(q12) - l12 * (q11D + q12D)**2
    d2 = -l21 * q21D**2 * cos(q22) - l22 * (q21D + q22D)**2
    a = np.linalg.solve(A, np.array([d1, d2]))
    M = np.diag([zz1, zz2]) + m * J.T @ J
    c = m * J.T @ a
    return M, c


def inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    tau = M @ np.array([q11DD, q21DD]) + c
    return tau[0], tau[1]


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    qDD = np.linalg.solve(M, np.array([tau1, tau2]) - c)
    return qDD[0], qDD[1]
