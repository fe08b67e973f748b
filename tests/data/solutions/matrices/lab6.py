"""Lab 6 with NumPy: polynomials by linear systems, Newton-Euler torques, two polynomials for the crossing."""

import numpy as np

l11 = 0.09
l12 = 0.09
l21 = 0.09
l22 = 0.09
d = 0.118
zz1 = 0.002
zz2 = 0.002
m = 0.5


def rows(t):
    k = np.arange(6)
    return np.array([t**k, k * t ** np.maximum(k - 1, 0), k * (k - 1) * t ** np.maximum(k - 2, 0)])


def quintic(T, start, end):
    """Coefficients with (s, s', s'') = start at 0 and end at T."""
    return np.linalg.solve(np.vstack([rows(0.0), rows(T)]), np.concatenate([start, end]))


def on_line(s, x0, y0, x1, y1):
    way = np.array([x1 - x0, y1 - y0])
    return np.concatenate([np.array([x0, y0]) + s[0] * way, s[1] * way, s[2] * way])


def trajectory(t, x0, y0, x1, y1, duration):
    if t <= 0 or t >= duration:
        return on_line((float(t > 0), 0.0, 0.0), x0, y0, x1, y1)
    return on_line(rows(t) @ quintic(duration, (0, 0, 0), (1, 0, 0)), x0, y0, x1, y1)


def computed_torque(
    q11t, q21t, q11tD, q21tD, q11tDD, q21tDD, q11, q12, q21, q22, q11D, q12D, q21D, q22D, kp, kd
):  # fmt: skip
    error = np.array([q11t - q11, q21t - q21])
    rate = np.array([q11tD - q11D, q21tD - q21D])
    qDD = np.array([q11tDD, q21tDD]) + kd * rate + kp * error
    a, b = q11 + q12, q21 + q22
    A = np.array([[np.cos(a), np.sin(a)], [np.cos(b), np.sin(b)]])
    arm = np.array([l11 * np.sin(q12), l21 * np.sin(q22)])
    pull = np.array([
        l11 * np.cos(q12) * q11D**2 + l12 * (q11D + q12D) ** 2,
        l21 * np.cos(q22) * q21D**2 + l22 * (q21D + q22D) ** 2,
    ])  # fmt: skip
    bars = np.linalg.solve(A.T, m * np.linalg.solve(A, arm * qDD - pull))
    return (np.array([zz1, zz2]) * qDD + arm * bars).reshape(2, 1)


def gains(period):
    return np.array([0.09, 0.6]) / np.array([period**2, period])


def elbows(p):
    found = []
    for base, l1, l2 in ((-d / 2, l11, l12), (d / 2, l21, l22)):
        r = p - base
        turn = np.arccos((np.abs(r) ** 2 + l1**2 - l2**2) / (2 * l1 * np.abs(r)))
        found.append(base + l1 * r / np.abs(r) * np.exp(-1j * turn))
    return found


def determinant(p):
    left, right = elbows(p)
    return np.imag(np.conj(p - left) * (p - right)) / (l12 * l22)


def bisect(before, low, high):
    while high - low > 1e-15:
        middle = (low + high) / 2
        if middle in (low, high):
            break
        low, high = (middle, high) if before(middle) else (low, middle)
    return low


def meeting(x0, y0, x1, y1):
    start, way = x0 + 1j * y0, x1 - x0 + 1j * (y1 - y0)
    s = np.linspace(0, 1, 1001)
    with np.errstate(invalid="ignore"):
        f = determinant(start + s * way)
        k = np.argmax(~(f * f[0] > 0)) - 1
        return bisect(
            lambda x: determinant(start + x * way) * f[0] > 0, s[k], s[k + 1]
        ), 1 if np.isnan(f[k + 1]) else 2


def meets(x0, y0, x1, y1, duration):
    s, kind = meeting(x0, y0, x1, y1)
    c = quintic(1.0, (0, 0, 0), (1, 0, 0))
    return bisect(lambda u: (rows(u) @ c)[0] < s, 0.0, 1.0) * duration, kind


def missing_force(x0, y0, x1, y1, duration):
    t, _ = meets(x0, y0, x1, y1, duration)
    x, y, _, _, xDD, yDD = trajectory(t, x0, y0, x1, y1, duration)
    bar = x + 1j * y - elbows(x + 1j * y)[0]
    return np.array([m * abs(np.imag(np.conj(bar) * (xDD + 1j * yDD))) / l12])


def crossing_trajectory(t, x0, y0, x1, y1, duration):
    s, _ = meeting(x0, y0, x1, y1)
    when, speed = s * duration, 2 / duration
    if t < when:
        motion = rows(t) @ quintic(when, (0, 0, 0), (s, speed, 0))
    else:
        motion = rows(t - when) @ quintic(duration - when, (s, speed, 0), (1, 0, 0))
    return on_line(motion, x0, y0, x1, y1)
