import numpy as np

DRAWING = (0.09, 0.09, 0.09, 0.09, 0.118, 0.0, 0.0)


def misses(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    a1 = q1 + offset1
    a2 = q2 + offset2
    p1 = np.array([-d / 2 + l11 * np.cos(a1), l11 * np.sin(a1)])
    p2 = np.array([d / 2 + l21 * np.cos(a2), l21 * np.sin(a2)])
    xi = np.array([x, y])
    return np.linalg.norm(xi - p1) - l12, np.linalg.norm(xi - p2) - l22


def derivatives(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    a1 = q1 + offset1
    a2 = q2 + offset2
    w1 = np.array([x + d / 2 - l11 * np.cos(a1), y - l11 * np.sin(a1)])
    w2 = np.array([x - d / 2 - l21 * np.cos(a2), y - l21 * np.sin(a2)])
    u1 = w1 / np.linalg.norm(w1)
    u2 = w2 / np.linalg.norm(w2)
    t1 = np.array([np.cos(a1), np.sin(a1)])
    t2 = np.array([np.cos(a2), np.sin(a2)])
    n1 = np.array([-np.sin(a1), np.cos(a1)])
    n2 = np.array([-np.sin(a2), np.cos(a2)])
    J = np.zeros((2, 7))
    J[0, 0] = -u1 @ t1
    J[0, 1] = -1
    J[0, 4] = u1[0] / 2
    J[0, 5] = -l11 * u1 @ n1
    J[1, 2] = -u2 @ t2
    J[1, 3] = -1
    J[1, 4] = -u2[0] / 2
    J[1, 6] = -l21 * u2 @ n2
    return J


def unseen(l11, l12, l21, l22, d, offset1, offset2, scale):
    v = np.array([l11, l12, l21, l22, d, 0.0, 0.0, -scale])
    return v / np.linalg.norm(v)


def calibrate(q, xi):
    p = np.array(DRAWING)
    for step in range(12):
        e = []
        J = []
        for (q1, q2), (x, y) in zip(q, xi):
            e.extend(misses(*p, q1, q2, x, y))
            J.append(derivatives(*p, q1, q2, x, y))
        delta = np.linalg.lstsq(np.vstack(J), -np.array(e), rcond=None)[0]
        p = p + delta
        if np.linalg.norm(delta) < 1e-13:
            break
    return tuple(p)


def sum_of_squares(p, q, xi):
    total = 0.0
    for (q1, q2), (x, y) in zip(q, xi):
        e1, e2 = misses(*p, q1, q2, x, y)
        total += e1**2 + e2**2
    return total


def own_robot(q, xi):
    best = None
    for k in range(len(q)):
        some_q = [pair for i, pair in enumerate(q) if i != k]
        some_xi = [pair for i, pair in enumerate(xi) if i != k]
        p = calibrate(some_q, some_xi)
        size = sum_of_squares(p, some_q, some_xi)
        if best is None or size < best[0]:
            best = (size, p)
    return best[1][:5]
