"""Lab 4 with NumPy: ranks of A and B, complex points, secant steps on det A."""

import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def u(q):
    return np.array([np.cos(q), np.sin(q)])


def margins(q11, q12, q21, q22):
    A = np.array([u(q11 + q12), u(q21 + q22)])
    return np.array(
        [
            u(q11)[0] * A[0, 1] - u(q11)[1] * A[0, 0],
            np.linalg.det(np.array([u(q21), A[1]])),
            np.linalg.det(A),
        ]
    )


def singularity_type(q11, q12, q21, q22):
    s1, s2, p = margins(q11, q12, q21, q22)
    return int(min(abs(s1), abs(s2)) <= 1e-6) | int(abs(p) <= 1e-6) << 1


def type2_point(q11, branch):
    elbow = -d / 2 + l11 * np.exp(1j * q11)
    to = d / 2 - elbow
    reach = l12 + l22
    cosine = (abs(to) ** 2 + reach**2 - l21**2) / (2 * reach * abs(to))
    if abs(cosine) > 1:
        return None
    point = elbow + l12 * to / abs(to) * np.exp(1j * branch * np.arccos(cosine))
    return [[point.real], [point.imag]]


def first_crossing(x0, y0, x1, y1, gamma1, gamma2):
    def f(s):
        p = x0 + 1j * y0 + s * (x1 - x0 + 1j * (y1 - y0))
        phi = []
        for base, l1, l2, gamma in ((-d / 2, l11, l12, gamma1), (d / 2, l21, l22, gamma2)):
            r = p - base
            turn = np.arccos((np.abs(r) ** 2 + l2**2 - l1**2) / (2 * l2 * np.abs(r)))
            phi.append(np.angle(r) - gamma * turn)
        return np.sin(phi[1] - phi[0])

    s = np.linspace(0, 1, 2001)
    changes = np.flatnonzero(np.diff(np.sign(f(s))))
    if len(changes) == 0:
        return np.nan
    a, b = s[changes[0]], s[changes[0] + 1]
    for _ in range(8):
        a, b = b, b - f(b) * (b - a) / (f(b) - f(a)) if f(b) != f(a) else b
    return b
