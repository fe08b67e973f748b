from math import *

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def margins(q11, q12, q21, q22):
    a = q11 + q12
    b = q21 + q22
    s1 = sin(q12)
    s2 = sin(q22)
    p = cos(a) * sin(b) - sin(a) * cos(b)
    return s1, s2, p


def singularity_type(q11, q12, q21, q22):
    s1, s2, p = margins(q11, q12, q21, q22)
    eps = 1e-6
    res = 0
    if abs(s1) <= eps or abs(s2) <= eps:
        res = res + 1
    if abs(p) <= eps:
        res = res + 2
    return res


def type2_point(q11, branch):
    xa = -d / 2 + l11 * cos(q11)
    ya = l11 * sin(q11)
    L = l12 + l22
    r = sqrt((d / 2 - xa)**2 + ya**2)
    base = atan2(0 - ya, d / 2 - xa)
    ca = (r**2 + L**2 - l21**2) / (2 * r * L)
    phi = base + branch * acos(ca)
    return xa + l12 * cos(phi), ya + l12 * sin(phi)


def leg(x, y, x_base, la, lb, gamma):
    r = hypot(x - x_base, y)
    q = atan2(y, x - x_base) + gamma * acos((la**2 + r**2 - lb**2) / (2 * la * r))
    xe = x_base + la * cos(q)
    ye = la * sin(q)
    return atan2(y - ye, x - xe)


def f(s, x0, y0, x1, y1, gamma1, gamma2):
    x = x0 + s * (x1 - x0)
    y = y0 + s * (y1 - y0)
    phi1 = leg(x, y, -d / 2, l11, l12, gamma1)
    phi2 = leg(x, y, d / 2, l21, l22, gamma2)
    return sin(phi2 - phi1)


def first_crossing(x0, y0, x1, y1, gamma1, gamma2):
    N = 500
    args = (x0, y0, x1, y1, gamma1, gamma2)
    before = f(0, *args)
    for i in range(1, N + 1):
        now = f(i / N, *args)
        if before * now <= 0:
            lo, hi = (i - 1) / N, i / N
            while hi - lo > 1e-12:
                mid = 0.5 * (lo + hi)
                if f(lo, *args) * f(mid, *args) <= 0:
                    hi = mid
                else:
                    lo = mid
            return 0.5 * (lo + hi)
        before = now
    return None
