"""Five bar with rotation matrices: each bar is a frame, each leg a chain of two frames."""
import numpy as np
import numpy.linalg as la

l = 0.09
d = 0.118
ZZ1R, ZZ2R = 0.002, 0.002
mR = 0.5

S = np.array([[0.0, -1.0], [1.0, 0.0]])
ex = np.array([1.0, 0.0])
base = {1: np.array([-d / 2, 0.0]), 2: np.array([d / 2, 0.0])}


def rot(a):
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


def elbow_of(leg, q):
    return base[leg] + rot(q) @ (l * ex)


def dgm(q11, q21, assembly_mode):
    E1 = elbow_of(1, q11)
    E2 = elbow_of(2, q21)
    r = E1 - E2
    n = la.norm(r)
    if n > 2 * l:
        return np.nan, np.nan
    alpha = np.arccos(n / (2 * l))
    P = E2 + rot(assembly_mode * alpha) @ r / n * l
    return P[0], P[1]


def igm(x, y, gamma1, gamma2):
    P = np.array([x, y])
    q = []
    for leg, gamma in [(1, gamma1), (2, gamma2)]:
        w = P - base[leg]
        h = la.norm(w) / 2
        if h > l:
            return np.nan, np.nan
        k = np.sqrt(l**2 - h**2)
        E = w / 2 + gamma * k * S @ w / (2 * h)
        q.append(np.arctan2(E[1], E[0]))
    return q[0], q[1]


def dgm_passive(q11, q21, assembly_mode):
    P = np.array(dgm(q11, q21, assembly_mode))
    b1 = rot(-q11) @ (P - elbow_of(1, q11))
    b2 = rot(-q21) @ (P - elbow_of(2, q21))
    return np.arctan2(b1[1], b1[0]), np.arctan2(b2[1], b2[0])


def leg_jacobian(qa, qp):
    """2 x 2: end-effector's velocity from the rates of the active and the passive joint."""
    c2 = rot(qa + qp) @ (l * ex)
    c1 = rot(qa) @ (l * ex)
    return np.column_stack((S @ (c1 + c2), S @ c2))


def leg_bias(qa, qp, qaD, qpD):
    """Acceleration of the end-effector without joint accelerations."""
    c2 = rot(qa + qp) @ (l * ex)
    c1 = rot(qa) @ (l * ex)
    return -c1 * qaD**2 - c2 * (qaD + qpD) ** 2


def rows(q11, q12, q21, q22):
    """Each leg without its passive joint: u . xiD = (u . first column) qD."""
    J1 = leg_jacobian(q11, q12)
    J2 = leg_jacobian(q21, q22)
    u1 = rot(q11 + q12) @ ex
    u2 = rot(q21 + q22) @ ex
    A = np.vstack((u1, u2))
    B = np.diag((u1 @ J1[:, 0], u2 @ J2[:, 0]))
    return A, B


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = rows(q11, q12, q21, q22)
    v = la.inv(A) @ B @ np.array([q11D, q21D])
    return v[0], v[1]


def ikm(q11, q12, q21, q22, xD, yD):
    J1 = leg_jacobian(q11, q12)
    J2 = leg_jacobian(q21, q22)
    v = np.array([xD, yD])
    return la.solve(J1, v)[0], la.solve(J2, v)[0]


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    v = np.array([xD, yD])
    J1 = leg_jacobian(q11, q12)
    J2 = leg_jacobian(q21, q22)
    t1 = rot(q11 + q12)[:, 1]
    t2 = rot(q21 + q22)[:, 1]
    q12D = t1 @ (v - J1[:, 0] * q11D) / l
    q22D = t2 @ (v - J2[:, 0] * q21D) / l
    return q12D, q22D


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = rows(q11, q12, q21, q22)
    a1 = leg_bias(q11, q12, q11D, q12D)
    a2 = leg_bias(q21, q22, q21D, q22D)
    right = np.array([A[0] @ a1 + B[0, 0] * q11DD, A[1] @ a2 + B[1, 1] * q21DD])
    a = la.solve(A, right)
    return a[0], a[1]


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    a = np.array([xDD, yDD])
    one = la.solve(leg_jacobian(q11, q12), a - leg_bias(q11, q12, q11D, q12D))
    two = la.solve(leg_jacobian(q21, q22), a - leg_bias(q21, q22, q21D, q22D))
    return one[0], two[0]


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    a = np.array([xDD, yDD])
    t1 = rot(q11 + q12)[:, 1]
    t2 = rot(q21 + q22)[:, 1]
    rest1 = a - leg_bias(q11, q12, q11D, q12D) - leg_jacobian(q11, q12)[:, 0] * q11DD
    rest2 = a - leg_bias(q21, q22, q21D, q22D) - leg_jacobian(q21, q22)[:, 0] * q21DD
    return t1 @ rest1 / l, t2 @ rest2 / l


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = rows(q11, q12, q21, q22)
    J = la.inv(A) @ B
    b = np.array(
        [
            A[0] @ leg_bias(q11, q12, q11D, q12D),
            A[1] @ leg_bias(q21, q22, q21D, q22D),
        ]
    )
    M = np.diag((ZZ1R, ZZ2R)) + mR * J.T @ J
    c = mR * J.T @ la.inv(A) @ b
    return M, c
