from math import acos, atan2, cos, hypot, sin, sqrt

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def is_zero(value):
    return -1e-6 <= value <= 1e-6


def singularity_type(q11, q12, q21, q22):
    det_b = is_zero(sin(q12)) or is_zero(sin(q22))
    det_a = is_zero(sin(q21 + q22 - q11 - q12))
    return 1 * det_b + 2 * det_a


def margins(q11, q12, q21, q22):
    c1, s1 = cos(q11 + q12), sin(q11 + q12)
    c2, s2 = cos(q21 + q22), sin(q21 + q22)
    return sin(q12), sin(q22), c1 * s2 - s1 * c2


def type2_point(q11, branch):
    xe = -d / 2 + l11 * cos(q11)
    ye = l11 * sin(q11)
    dx = d / 2 - xe
    dy = -ye
    D = hypot(dx, dy)
    L = l12 + l22
    if D > L + l21 or D < abs(L - l21):
        return None
    theta = atan2(dy, dx)
    beta = acos((L**2 + D**2 - l21**2) / (2 * L * D))
    angle = theta + branch * beta
    return xe + l12 * cos(angle), ye + l12 * sin(angle)


def distal(x, y, bx, prox, dist, gamma):
    r2 = (x - bx) ** 2 + y**2
    r = sqrt(r2)
    a = (prox**2 - dist**2 + r2) / (2 * r)
    h = sqrt(prox**2 - a**2)
    ex = bx + a * (x - bx) / r - gamma * h * y / r
    ey = a * y / r + gamma * h * (x - bx) / r
    return (x - ex) / dist, (y - ey) / dist


def det_A(x, y, gamma1, gamma2):
    ux, uy = distal(x, y, -d / 2, l11, l12, gamma1)
    vx, vy = distal(x, y, d / 2, l21, l22, gamma2)
    return ux * vy - uy * vx


def first_crossing(x0, y0, x1, y1, gamma1, gamma2):
    N = 400
    before = det_A(x0, y0, gamma1, gamma2)
    for k in range(1, N + 1):
        s = k / N
        now = det_A(x0 + s * (x1 - x0), y0 + s * (y1 - y0), gamma1, gamma2)
        if (before < 0) != (now < 0):
            low, high = s - 1 / N, s
            for _ in range(40):
                s = 0.5 * (low + high)
                value = det_A(x0 + s * (x1 - x0), y0 + s * (y1 - y0), gamma1, gamma2)
                if (value < 0) == (before < 0):
                    low = s
                else:
                    high = s
            return high
        before = now
    return None
