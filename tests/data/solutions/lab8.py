"""Lab 8: Gauss-Newton on the bars' misses, which needs no modes; a wrong point is found by leaving out each."""

from math import cos, hypot, sin, sqrt

import numpy as np


def legs(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    found = []
    for base, l1, angle in ((-d / 2, l11, q1 + offset1), (d / 2, l21, q2 + offset2)):
        c, s = cos(angle), sin(angle)
        X, Y = x - base - l1 * c, y - l1 * s
        found.append((X, Y, hypot(X, Y), c, s, l1))
    return found


def misses(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    left, right = legs(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y)
    return left[2] - l12, right[2] - l22


def derivatives(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    both = legs(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y)
    J = np.zeros((2, 7))
    for i, (X, Y, length, c, s, l1) in enumerate(both):
        ux, uy = X / length, Y / length
        J[i, 2 * i] = -(ux * c + uy * s)
        J[i, 2 * i + 1] = -1
        J[i, 4] = ux / 2 if i == 0 else -ux / 2
        J[i, 5 + i] = l1 * (ux * s - uy * c)
    return J


def unseen(l11, l12, l21, l22, d, offset1, offset2, scale):
    size = sqrt(l11**2 + l12**2 + l21**2 + l22**2 + d**2 + scale**2)
    return [l11 / size, l12 / size, l21 / size, l22 / size, d / size, 0.0, 0.0, -scale / size]


def calibrate(q, xi):
    p = np.array([0.09, 0.09, 0.09, 0.09, 0.118, 0.0, 0.0])
    for _ in range(12):
        rows = [(*p, *a, *b) for a, b in zip(q, xi)]
        J = np.concatenate([derivatives(*row) for row in rows])
        e = np.concatenate([misses(*row) for row in rows])
        p = p - np.linalg.lstsq(J, e, rcond=None)[0]
    return tuple(p)


def own_robot(q, xi):
    best = None
    for k in range(len(q)):
        a, b = q[:k] + q[k + 1 :], xi[:k] + xi[k + 1 :]
        p = calibrate(a, b)
        size = sum(e**2 for row in zip(a, b) for e in misses(*p, *row[0], *row[1]))
        if best is None or size < best[0]:
            best = size, p
    return best[1][:5]
