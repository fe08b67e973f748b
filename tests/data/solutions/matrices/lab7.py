"""Lab 7 with NumPy column vectors, returning what such files return."""

import numpy as np

l1 = 0.2828427
l2 = 0.2828427
d = 0.4
mf1 = 1.0
mf2 = 1.0
m = 3.0
E = np.array([[0, -1], [1, 0]])
J_FOOT = np.array([[0], [1]])


def u(q):
    return np.array([[np.cos(q)], [np.sin(q)]])


def dgm(q11, q21, assembly_mode):
    F1, F2 = np.array([[-d / 2], [q11]]), np.array([[d / 2], [q21]])
    e = (F1 - F2) / np.linalg.norm(F1 - F2)
    along = (np.sum((F1 - F2) ** 2) + l2**2 - l1**2) / (2 * np.linalg.norm(F1 - F2))
    with np.errstate(invalid="ignore"):
        return F2 + along * e + assembly_mode * np.sqrt(l2**2 - along**2) * E @ e


def igm(x, y, gamma1, gamma2):
    q = np.zeros(2)
    for i, (guide, bar, gamma) in enumerate([(-d / 2, l1, gamma1), (d / 2, l2, gamma2)]):
        square = bar**2 - (x - guide) ** 2
        if square < 0:
            raise ValueError("out of reach")
        q[i] = y + gamma * np.sqrt(square)
    return q


def dgm_passive(q11, q21, assembly_mode):
    P = dgm(q11, q21, assembly_mode)
    w1, w2 = P - np.array([[-d / 2], [q11]]), P - np.array([[d / 2], [q21]])
    return np.arctan2(w1[1], w1[0]), np.arctan2(w2[1], w2[0])


def AB(q12, q22):
    A = np.hstack([u(q12), u(q22)]).T
    return A, np.diag((A @ J_FOOT).ravel())


def solve(P, w):
    if abs(np.linalg.det(P)) < 1e-9:
        raise np.linalg.LinAlgError("singular")
    return np.linalg.solve(P, w)


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = AB(q12, q22)
    return solve(A, B @ np.array([[q11D], [q21D]]))


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = AB(q12, q22)
    return solve(B, A @ np.array([[xD], [yD]]))


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    V = np.array([[xD], [yD]])
    return (E @ u(q12)).T @ (V - q11D * J_FOOT) / l1, (E @ u(q22)).T @ (V - q21D * J_FOOT) / l2


def bias(q12D, q22D):
    return np.array([[-l1 * q12D**2], [-l2 * q22D**2]])


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = AB(q12, q22)
    return solve(A, B @ np.array([[q11DD], [q21DD]]) + bias(q12D, q22D))


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = AB(q12, q22)
    return solve(B, A @ np.array([[xDD], [yDD]]) - bias(q12D, q22D))


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    return np.array(dkm_passive(q11, q12, q21, q22, q11DD, q21DD, xDD, yDD)).ravel()


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = AB(q12, q22)
    J, W = np.linalg.solve(A, B), np.diag([mf1, mf2])
    return W + m * J.T @ J, m * J.T @ np.linalg.solve(A, bias(q12D, q22D))


def efforts(x, y, xD, yD, xDD, yDD, gamma1, gamma2):
    q11, q21 = igm(x, y, gamma1, gamma2)
    q12, q22 = np.arctan2(y - q11, x + d / 2), np.arctan2(y - q21, x - d / 2)
    qD = ikm(q11, q12, q21, q22, xD, yD)
    q12D, q22D = (part.item() for part in dkm_passive(q11, q12, q21, q22, *qD.ravel(), xD, yD))
    qDD = ikm2(q11, q12, q21, q22, qD[0, 0], q12D, qD[1, 0], q22D, xDD, yDD)
    M, c = dynamic_model(q11, q12, q21, q22, qD[0, 0], q12D, qD[1, 0], q22D)
    return M @ qDD + c


def fit(rows):
    """Rows (t, order, (x, y)) of the polynomial's conditions -> coefficients of x and of y."""
    n = len(rows)
    P = np.array(
        [
            np.polynomial.polynomial.polyder(np.eye(n), order).T @ t ** np.arange(n - order)
            for t, order, _ in rows
        ]
    )
    c = np.linalg.solve(P, np.array([value for *_, value in rows]))
    return c[:, 0], c[:, 1]


def compliant_crossing(x0, y0, x1, y1, T):
    """Crosses with an acceleration along the bars only, at 45 % of the time."""
    zero, ts = (0.0, 0.0), 0.45 * T
    start = [(0.0, 0, (x0, y0)), (0.0, 1, zero), (0.0, 2, zero)]
    goal = [(T, 0, (x1, y1)), (T, 1, zero), (T, 2, zero)]
    q = igm(0.0, 0.0, 1, -1)
    bar = np.array([d / 2, -q[0]]) / l1
    across = [(ts, 0, (0.0, y0)), (ts, 1, ((x1 - x0) / T, 0.0)), (ts, 2, tuple(0.02 * bar))]
    return fit(start + across + goal)


def non_compliant_crossing(x0, y0, x1, y1, T):
    zero = (0.0, 0.0)
    start = [(0.0, 0, (x0, y0)), (0.0, 1, zero), (0.0, 2, zero)]
    return fit(start + [(T, 0, (x1, y1)), (T, 1, zero), (T, 2, zero)])
