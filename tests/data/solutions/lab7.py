"""Lab 7 as the handout derives the five-bar, for the biglide: by components."""

from math import atan2, cos, hypot, sin, sqrt

l1 = 0.2828427
l2 = 0.2828427
d = 0.4
mf1 = 1.0
mf2 = 1.0
m = 3.0


def dgm(q11, q21, assembly_mode):
    xl, yl = -d / 2, q11
    xr, yr = d / 2, q21
    ux, uy = xl - xr, yl - yr
    D = hypot(ux, uy)
    ux, uy = ux / D, uy / D
    a = (D**2 + l2**2 - l1**2) / (2 * D)
    h = sqrt(l2**2 - a**2)
    x = xr + a * ux - assembly_mode * h * uy
    y = yr + a * uy + assembly_mode * h * ux
    return x, y


def igm(x, y, gamma1, gamma2):
    q11 = y + gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)
    q21 = y + gamma2 * sqrt(l2**2 - (x - d / 2) ** 2)
    return q11, q21


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y - q11, x + d / 2)
    q22 = atan2(y - q21, x - d / 2)
    return q12, q22


def matrices(q12, q22):
    A = [[cos(q12), sin(q12)], [cos(q22), sin(q22)]]
    B = [[sin(q12), 0], [0, sin(q22)]]
    return A, B


def product(P, w):
    return P[0][0] * w[0] + P[0][1] * w[1], P[1][0] * w[0] + P[1][1] * w[1]


def solved(P, w):
    det = P[0][0] * P[1][1] - P[0][1] * P[1][0]
    return (P[1][1] * w[0] - P[0][1] * w[1]) / det, (P[0][0] * w[1] - P[1][0] * w[0]) / det


def dkm(q11, q12, q21, q22, q11D, q21D):
    A, B = matrices(q12, q22)
    return solved(A, product(B, (q11D, q21D)))


def ikm(q11, q12, q21, q22, xD, yD):
    A, B = matrices(q12, q22)
    return solved(B, product(A, (xD, yD)))


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    q12D = (-sin(q12) * xD + cos(q12) * (yD - q11D)) / l1
    q22D = (-sin(q22) * xD + cos(q22) * (yD - q21D)) / l2
    return q12D, q22D


def bias(q12D, q22D):
    return -l1 * q12D**2, -l2 * q22D**2


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    A, B = matrices(q12, q22)
    b = bias(q12D, q22D)
    w = product(B, (q11DD, q21DD))
    return solved(A, (w[0] + b[0], w[1] + b[1]))


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    A, B = matrices(q12, q22)
    b = bias(q12D, q22D)
    w = product(A, (xDD, yDD))
    return solved(B, (w[0] - b[0], w[1] - b[1]))


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    q12DD = (-sin(q12) * xDD + cos(q12) * (yDD - q11DD)) / l1
    q22DD = (-sin(q22) * xDD + cos(q22) * (yDD - q21DD)) / l2
    return q12DD, q22DD


def inverted(P):
    det = P[0][0] * P[1][1] - P[0][1] * P[1][0]
    return [[P[1][1] / det, -P[0][1] / det], [-P[1][0] / det, P[0][0] / det]]


def times(P, Q):
    return [[sum(P[i][k] * Q[k][j] for k in range(2)) for j in range(2)] for i in range(2)]


def turned(P):
    return [[P[0][0], P[1][0]], [P[0][1], P[1][1]]]


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A, B = matrices(q12, q22)
    b = bias(q12D, q22D)
    J = times(inverted(A), B)
    JJ = times(turned(J), J)
    a = product(inverted(A), b)
    f = product(turned(J), a)
    M = [[mf1 + m * JJ[0][0], m * JJ[0][1]], [m * JJ[1][0], mf2 + m * JJ[1][1]]]
    c = [m * f[0], m * f[1]]
    return M, c


def efforts(x, y, xD, yD, xDD, yDD, gamma1, gamma2):
    q11, q21 = igm(x, y, gamma1, gamma2)
    q12, q22 = atan2(y - q11, x + d / 2), atan2(y - q21, x - d / 2)
    q11D, q21D = ikm(q11, q12, q21, q22, xD, yD)
    q12D, q22D = dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD)
    q11DD, q21DD = ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD)
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    tau = product(M, (q11DD, q21DD))
    return tau[0] + c[0], tau[1] + c[1]


def row(t, order, n):
    """The derivatives of 1, t, t^2 ... at t."""
    factor = [lambda k: 1, lambda k: k, lambda k: k * (k - 1)][order]
    return [factor(k) * t ** max(k - order, 0) for k in range(n)]


def through(conditions):
    """Coefficients of the polynomial with these (t, order, value), by Gauss elimination."""
    n = len(conditions)
    rows = [row(t, order, n) + [value] for t, order, value in conditions]
    for i in range(n):
        best = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        for k in range(n):
            if k != i:
                f = rows[k][i] / rows[i][i]
                rows[k] = [p - f * q for p, q in zip(rows[k], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def ends(start, goal, T):
    return [(0.0, 0, start), (0.0, 1, 0.0), (0.0, 2, 0.0), (T, 0, goal), (T, 1, 0.0), (T, 2, 0.0)]


def compliant_crossing(x0, y0, x1, y1, T):
    ts, ys = T * x0 / (x0 - x1), (y0 + y1) / 2
    vx, vy = 1.5 * (x1 - x0) / T, 0.0
    a = through(ends(x0, x1, T) + [(ts, 0, 0.0), (ts, 1, vx), (ts, 2, 0.0)])
    b = through(ends(y0, y1, T) + [(ts, 0, ys), (ts, 1, vy), (ts, 2, 0.0)])
    return a, b


def non_compliant_crossing(x0, y0, x1, y1, T):
    return through(ends(x0, x1, T)), through(ends(y0, y1, T))
