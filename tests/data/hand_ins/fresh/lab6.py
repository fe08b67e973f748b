import numpy as np
from math import *

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def s_of(u):
    return 10 * u**3 - 15 * u**4 + 6 * u**5


def trajectory(t, x0, y0, x1, y1, duration):
    if t < 0:
        t = 0
    if t > duration:
        t = duration
    T = duration
    s = 10 * (t / T)**3 - 15 * (t / T)**4 + 6 * (t / T)**5
    sD = 30 * t**2 / T**3 - 60 * t**3 / T**4 + 30 * t**4 / T**5
    sDD = 60 * t / T**3 - 180 * t**2 / T**4 + 120 * t**3 / T**5
    x = x0 + s * (x1 - x0)
    y = y0 + s * (y1 - y0)
    return x, y, sD * (x1 - x0), sD * (y1 - y0), sDD * (x1 - x0), sDD * (y1 - y0)


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    A = np.array([[cos(q11 + q12), sin(q11 + q12)], [cos(q21 + q22), sin(q21 + q22)]])
    B = np.diag([l11 * sin(q12), l21 * sin(q22)])
    J = np.linalg.inv(A) @ B
    d1 = -l11 * q11D**2 * cos(q12) - l12 * (q11D + q12D)**2
    d2 = -l21 * q21D**2 * cos(q22) - l22 * (q21D + q22D)**2
    M = np.diag([zz1, zz2]) + m * J.T @ J
    c = m * J.T @ np.linalg.inv(A) @ np.array([d1, d2])
    return M, c


def computed_torque(
    q11t, q21t, q11tD, q21tD, q11tDD, q21tDD, q11, q12, q21, q22, q11D, q12D, q21D, q22D, kp, kd
):
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    e = np.array([q11t - q11, q21t - q21])
    eD = np.array([q11tD - q11D, q21tD - q21D])
    v = np.array([q11tDD, q21tDD]) + kd * eD + kp * e
    tau = M @ v + c
    return tau[0], tau[1]


def gains(period):
    w = 0.2 / period
    kp = w**2
    kd = 2 * w
    return kp, kd


def leg(x, y, xb, la, lb):
    r = hypot(x - xb, y)
    q = atan2(y, x - xb) - acos((la**2 + r**2 - lb**2) / (2 * la * r))
    return atan2(y - la * sin(q), x - xb - la * cos(q))


def det(x, y):
    return sin(leg(x, y, d / 2, l21, l22) - leg(x, y, -d / 2, l11, l12))


def search(x0, y0, x1, y1):
    def good(s):
        try:
            return det(x0 + s * (x1 - x0), y0 + s * (y1 - y0)) > 0
        except ValueError:
            return None
    start = good(0)
    for k in range(1, 501):
        now = good(k / 500)
        if now != start:
            lo, hi = (k - 1) / 500, k / 500
            for _ in range(50):
                mid = (lo + hi) / 2
                if good(mid) == start:
                    lo = mid
                else:
                    hi = mid
            return hi, 1 if now is None else 2


def meets(x0, y0, x1, y1, duration):
    s, kind = search(x0, y0, x1, y1)
    lo, hi = 0, 1
    for _ in range(60):
        mid = (lo + hi) / 2
        if s_of(mid) < s:
            lo = mid
        else:
            hi = mid
    return lo * duration, kind


def missing_force(x0, y0, x1, y1, duration):
    t, kind = meets(x0, y0, x1, y1, duration)
    x, y, xD, yD, xDD, yDD = trajectory(t, x0, y0, x1, y1, duration)
    phi = leg(x, y, -d / 2, l11, l12)
    return abs(m * (-sin(phi) * xDD + cos(phi) * yDD))
