"""Lab 4: sines of the angles between bars, the four-bar of the stretched coupler, sampling and bisection."""

from math import atan2, cos, hypot, sin, sqrt

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def margins(q11, q12, q21, q22):
    s1, s2 = sin(q12), sin(q22)
    p = sin(q21 + q22 - q11 - q12)
    return s1, s2, p


def singularity_type(q11, q12, q21, q22):
    s1, s2, p = sin(q12), sin(q22), sin(q21 + q22 - q11 - q12)
    serial = abs(s1) <= 1e-6 or abs(s2) <= 1e-6
    parallel = abs(p) <= 1e-6
    return 1 * serial + 2 * parallel


def type2_point(q11, branch):
    xe, ye = -d / 2 + l11 * cos(q11), l11 * sin(q11)
    X, Y = d / 2 - xe, -ye
    D = hypot(X, Y)
    coupler = l12 + l22
    a = (D**2 + coupler**2 - l21**2) / (2 * D)
    h = branch * sqrt(coupler**2 - a**2)
    x22, y22 = xe + (a * X - h * Y) / D, ye + (a * Y + h * X) / D
    share = l12 / coupler
    return xe + share * (x22 - xe), ye + share * (y22 - ye)


def elbow_angle(x, y, base, l1, l2, gamma):
    D = hypot(x - base, y)
    a = (D**2 + l1**2 - l2**2) / (2 * D)
    h = gamma * sqrt(l1**2 - a**2)
    ex, ey = (a * (x - base) - h * y) / D, (a * y + h * (x - base)) / D
    return atan2(y - ey, x - base - ex)


def det_a(x, y, gamma1, gamma2):
    phi1 = elbow_angle(x, y, -d / 2, l11, l12, gamma1)
    phi2 = elbow_angle(x, y, d / 2, l21, l22, gamma2)
    return sin(phi2 - phi1)


def first_crossing(x0, y0, x1, y1, gamma1, gamma2):
    def f(s):
        return det_a(x0 + s * (x1 - x0), y0 + s * (y1 - y0), gamma1, gamma2)

    n = 200
    for k in range(n):
        low, high = k / n, (k + 1) / n
        if f(low) * f(high) < 0:
            for _ in range(60):
                middle = (low + high) / 2
                if f(low) * f(middle) <= 0:
                    high = middle
                else:
                    low = middle
            return high
    return None
