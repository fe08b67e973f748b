"""Lab 8 with arrays of all poses at once."""

import numpy as np


def rows(p, q, xi):
    l11, l12, l21, l22, d, o1, o2 = p
    q = np.asarray(q, float).reshape(-1, 2)
    xi = np.asarray(xi, float).reshape(-1, 2)
    e, J = [], []
    for leg, (near, far, base, o) in enumerate([(l11, l12, -d / 2, o1), (l21, l22, d / 2, o2)]):
        t = q[:, leg] + o
        away = xi - np.stack([base + near * np.cos(t), near * np.sin(t)], axis=1)
        r = np.hypot(away[:, 0], away[:, 1])
        ux, uy = away[:, 0] / r, away[:, 1] / r
        block = np.zeros((len(q), 7))
        block[:, 2 * leg] = -(ux * np.cos(t) + uy * np.sin(t))
        block[:, 2 * leg + 1] = -1
        block[:, 4] = ux / 2 if leg == 0 else -ux / 2
        block[:, 5 + leg] = near * (ux * np.sin(t) - uy * np.cos(t))
        e.append(r - far)
        J.append(block)
    return np.stack(e, axis=1), np.stack(J, axis=1)


def misses(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    e, _ = rows((l11, l12, l21, l22, d, offset1, offset2), [(q1, q2)], [(x, y)])
    return e[0, 0], e[0, 1]


def derivatives(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    _, J = rows((l11, l12, l21, l22, d, offset1, offset2), [(q1, q2)], [(x, y)])
    return J[0]


def unseen(l11, l12, l21, l22, d, offset1, offset2, scale):
    v = np.array([l11, l12, l21, l22, d, 0, 0, -scale])
    return v / np.sqrt(np.sum(v**2))


def fit(q, xi):
    p = np.array([0.09, 0.09, 0.09, 0.09, 0.118, 0, 0])
    for _ in range(25):
        e, J = rows(p, q, xi)
        step = np.linalg.lstsq(J.reshape(-1, 7), -e.ravel(), rcond=None)[0]
        p = p + step
        if np.max(np.abs(step)) < 1e-14:
            break
    return p, np.sum(rows(p, q, xi)[0] ** 2)


def calibrate(q, xi):
    p, _ = fit(q, xi)
    return tuple(p)


def own_robot(q, xi):
    q, xi = np.asarray(q), np.asarray(xi)
    best = None
    for k in range(len(q)):
        keep = np.arange(len(q)) != k
        p, cost = fit(q[keep], xi[keep])
        if best is None or cost < best[1]:
            best = p, cost
    return tuple(best[0][:5])
