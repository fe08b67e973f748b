"""Lab 6: quintic lines, computed torque, and a crossing on the line with no acceleration at the singularity."""

from functools import lru_cache
from math import atan2, cos, hypot, sin, sqrt

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def profile(u):
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    sD = 30 * u**2 - 60 * u**3 + 30 * u**4
    sDD = 60 * u - 180 * u**2 + 120 * u**3
    return s, sD, sDD


def trajectory(t, x0, y0, x1, y1, duration):
    u = min(max(t / duration, 0), 1)
    s, sD, sDD = profile(u)
    sD, sDD = sD / duration, sDD / duration**2
    X, Y = x1 - x0, y1 - y0
    return x0 + s * X, y0 + s * Y, sD * X, sD * Y, sDD * X, sDD * Y


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    angle = q21 + q22 - q11 - q12
    b1, b2 = l11 * sin(q12), l21 * sin(q22)
    d1 = -l11 * cos(q12) * q11D**2 - l12 * (q11D + q12D) ** 2
    d2 = -l21 * cos(q22) * q21D**2 - l22 * (q21D + q22D) ** 2
    w, g = m / sin(angle) ** 2, cos(angle)
    M = [[zz1 + w * b1 * b1, -w * g * b1 * b2], [-w * g * b1 * b2, zz2 + w * b2 * b2]]
    return M, [w * b1 * (d1 - g * d2), w * b2 * (d2 - g * d1)]


def computed_torque(
    q11t, q21t, q11tD, q21tD, q11tDD, q21tDD, q11, q12, q21, q22, q11D, q12D, q21D, q22D, kp, kd
):  # fmt: skip
    M, c = dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    a1 = q11tDD + kd * (q11tD - q11D) + kp * (q11t - q11)
    a2 = q21tDD + kd * (q21tD - q21D) + kp * (q21t - q21)
    return M[0][0] * a1 + M[0][1] * a2 + c[0], M[1][0] * a1 + M[1][1] * a2 + c[1]


def gains(period):
    omega = 0.25 / period
    return omega**2, 2 * omega


def distal(x, y, base, l1, l2, gamma):
    D = hypot(x - base, y)
    a = (D**2 + l1**2 - l2**2) / (2 * D)
    h = gamma * sqrt(l1**2 - a**2)
    ex, ey = (a * (x - base) - h * y) / D, (a * y + h * (x - base)) / D
    return atan2(y - ey, x - base - ex)


def det_a(x, y):
    return sin(distal(x, y, d / 2, l21, l22, -1) - distal(x, y, -d / 2, l11, l12, -1))


def bisect(ahead, low, high):
    for _ in range(70):
        middle = (low + high) / 2
        if ahead(middle):
            high = middle
        else:
            low = middle
    return high


@lru_cache
def singular(x0, y0, x1, y1):
    """Part of the line up to the first singularity, and its type."""

    def det(s):
        try:
            return det_a(x0 + s * (x1 - x0), y0 + s * (y1 - y0))
        except ValueError:
            return None

    first = det(0)
    n = 400
    for k in range(1, n + 1):
        here = det(k / n)
        if here is None:
            return bisect(lambda s: det(s) is None, (k - 1) / n, k / n), 1
        if here * first < 0:
            return bisect(lambda s: det(s) * first < 0, (k - 1) / n, k / n), 2


def meets(x0, y0, x1, y1, duration):
    s, kind = singular(x0, y0, x1, y1)
    u = bisect(lambda u: profile(u)[0] > s, 0, 1)
    return u * duration, kind


def missing_force(x0, y0, x1, y1, duration):
    t, kind = meets(x0, y0, x1, y1, duration)
    x, y, xD, yD, xDD, yDD = trajectory(t, x0, y0, x1, y1, duration)
    phi = distal(x, y, -d / 2, l11, l12, -1)
    return m * abs(-sin(phi) * xDD + cos(phi) * yDD)


def crossing_trajectory(t, x0, y0, x1, y1, duration):
    s, kind = singular(x0, y0, x1, y1)
    # both halves as long as their part of the line; speed 2 / duration and no acceleration where they meet
    half = s * duration
    if t < half:
        u, T = t / half, half
        p, pD, pDD = (
            s * (2 * u**3 - u**4),
            s * (6 * u**2 - 4 * u**3) / T,
            s * (12 * u - 12 * u**2) / T**2,
        )
    else:
        u, T = (duration - t) / (duration - half), duration - half
        rest = 1 - s
        p, pD = 1 - rest * (2 * u**3 - u**4), rest * (6 * u**2 - 4 * u**3) / T
        pDD = -rest * (12 * u - 12 * u**2) / T**2
    X, Y = x1 - x0, y1 - y0
    return x0 + p * X, y0 + p * Y, pD * X, pD * Y, pDD * X, pDD * Y
