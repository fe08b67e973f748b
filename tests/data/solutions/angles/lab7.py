"""Lab 7 by angles: the law of cosines, closed forms with the angle between the bars, Newton's law for the efforts."""

import math

l1 = l2 = 0.2828427
d = 0.4
mf1 = mf2 = 1.0
m = 3.0


def dgm(q11, q21, assembly_mode):
    phi = dgm_passive(q11, q21, assembly_mode)[0]
    return -d / 2 + l1 * math.cos(phi), q11 + l1 * math.sin(phi)


def igm(x, y, gamma1, gamma2):
    # phi from its cosine; gamma = +1 is a bar that points down
    phi1, phi2 = -gamma1 * math.acos((x + d / 2) / l1), -gamma2 * math.acos((x - d / 2) / l2)
    return [y - l1 * math.sin(phi1), y - l2 * math.sin(phi2)]


def dgm_passive(q11, q21, assembly_mode):
    span, slope = math.hypot(d, q21 - q11), math.atan2(q21 - q11, d)
    left = math.acos((l1**2 + span**2 - l2**2) / (2 * l1 * span))
    right = math.acos((l2**2 + span**2 - l1**2) / (2 * l2 * span))
    return slope - assembly_mode * left, slope + math.pi + assembly_mode * right


def dkm(q11, q12, q21, q22, q11D, q21D):
    s = math.sin(q22 - q12)
    e1, e2 = math.sin(q12) * q11D / s, math.sin(q22) * q21D / s
    return e1 * math.sin(q22) - e2 * math.sin(q12), e2 * math.cos(q12) - e1 * math.cos(q22)


def ikm(q11, q12, q21, q22, xD, yD):
    return yD + xD / math.tan(q12), yD + xD / math.tan(q22)


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    return (
        ((yD - q11D) * math.cos(q12) - xD * math.sin(q12)) / l1,
        ((yD - q21D) * math.cos(q22) - xD * math.sin(q22)) / l2,
    )


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    s = math.sin(q22 - q12)
    e1 = (math.sin(q12) * q11DD - l1 * q12D**2) / s
    e2 = (math.sin(q22) * q21DD - l2 * q22D**2) / s
    return e1 * math.sin(q22) - e2 * math.sin(q12), e2 * math.cos(q12) - e1 * math.cos(q22)


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    return (
        yDD + xDD / math.tan(q12) + l1 * q12D**2 / math.sin(q12),
        yDD + xDD / math.tan(q22) + l2 * q22D**2 / math.sin(q22),
    )


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    return dkm_passive(q11, q12, q21, q22, q11DD, q21DD, xDD, yDD)


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    s, g = math.sin(q22 - q12), math.cos(q22 - q12)
    b1, b2 = math.sin(q12), math.sin(q22)
    d1, d2 = -l1 * q12D**2, -l2 * q22D**2
    w = m / s**2
    M = ((mf1 + w * b1 * b1, -w * g * b1 * b2), (-w * g * b1 * b2, mf2 + w * b2 * b2))
    return M, (w * b1 * (d1 - g * d2), w * b2 * (d2 - g * d1))


def efforts(x, y, xD, yD, xDD, yDD, gamma1, gamma2):
    phi1, phi2 = -gamma1 * math.acos((x + d / 2) / l1), -gamma2 * math.acos((x - d / 2) / l2)
    total = []
    s = math.sin(phi2 - phi1)
    forces = (
        m * (xDD * math.sin(phi2) - yDD * math.cos(phi2)) / s,
        m * (yDD * math.cos(phi1) - xDD * math.sin(phi1)) / s,
    )
    for phi, bar, foot, force in zip((phi1, phi2), (l1, l2), (mf1, mf2), forces):
        rate = -xD / (bar * math.sin(phi))
        acceleration = yDD + xDD / math.tan(phi) + bar * rate**2 / math.sin(phi)
        total.append(foot * acceleration + force * math.sin(phi))
    return total


def rest_to_rest(start, goal, T):
    rise = goal - start
    return [start, 0.0, 0.0, 10 * rise / T**3, -15 * rise / T**4, 6 * rise / T**5]


def compliant_crossing(x0, y0, x1, y1, T):
    """x as always; y gets a bump b t^3 (T - t)^3 that makes y'' = -x'' tan(phi) at the crossing."""
    a, b = rest_to_rest(x0, x1, T), rest_to_rest(y0, y1, T)
    low, high = 0.0, T
    for _ in range(200):
        t = (low + high) / 2
        x = sum(k * t**i for i, k in enumerate(a))
        low, high = (t, high) if x * x0 > 0 else (low, t)
    second = [sum(i * (i - 1) * k * t ** (i - 2) for i, k in enumerate(c) if i > 1) for c in (a, b)]
    bump = [0.0, 0.0, 0.0, T**3, -3 * T**2, 3 * T, -1.0]
    phi1 = -math.acos(d / 2 / l1)  # the left bar at the crossing
    wanted = second[0] * math.tan(phi1)
    curvature = sum(i * (i - 1) * k * t ** (i - 2) for i, k in enumerate(bump) if i > 1)
    size = (wanted - second[1]) / curvature
    return a, [p + size * q for p, q in zip(b + [0.0], bump)]


def non_compliant_crossing(x0, y0, x1, y1, T):
    return rest_to_rest(x0, x1, T), rest_to_rest(y0, y1, T)
