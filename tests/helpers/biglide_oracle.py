"""The biglide in redundant coordinates, as tests/oracle.py has the five-bar: on mpmath numbers and on complex floats.

A free point xi and two feet F_i = (-+d/2, q_i) under |r_i|^2 = l_i^2, r_i = xi - F_i. Differentiated, with b_i = r_iy:
    r_i . xi_dot  = b_i q_dot_i             r_i . xi_ddot = b_i q_ddot_i - |r_i_dot|^2
    m xi_ddot = sum_i mu_i r_i              f_i = mf_i q_ddot_i + b_i mu_i             (mu_i the multipliers)
"""

from collections import defaultdict
from itertools import product

import numpy as np

from tests.helpers.oracle import (
    ACCELERATIONS,
    GIVEN,
    OTHER,
    RATES,
    cross,
    dot,
    dyad,
    norm,
    of,
    turned,
)

LENGTHS, INERTIA = ("l1", "l2", "d"), ("mf1", "mf2", "m")
MODES = {"q": "assembly", "xi": "working"}


def models(p, start):
    """All of `keys(start)`, each (components, poses); angles as unit vectors."""
    bars, mf, m, out = np.stack([p["l1"], p["l2"]]), np.stack([p["mf1"], p["mf2"]]), p["m"], {}
    base = np.stack([-p["d"] / 2, p["d"] / 2])
    if start == "q":
        feet = np.stack([base, p["q"]], axis=1)
        xi = out["xi", start] = feet[0] + dyad(feet[1] - feet[0], *bars, p["assembly"])
    else:
        xi, off = p["xi"], p["xi"][0] - base
        q = out["q", start] = xi[1] + p["working"] * of(np.sqrt, bars**2 - off**2)
        feet = np.stack([base, q], axis=1)
    r = xi - feet
    b, det = r[:, 1], cross(*r)
    zero, one = 0 * det, 0 * det + 1
    out["q_passive", start] = (r / bars[:, None]).reshape(4, -1)
    out["A", start] = (r / bars[:, None]).reshape(4, -1)
    out["B", start] = np.stack([b[0] / bars[0], zero, zero, b[1] / bars[1]])

    def point(s):  # w with r_i . w = s_i
        return (s[1] * turned(r[0]) - s[0] * turned(r[1])) / det

    def effort(a, w):  # the multipliers from sum_i mu_i r_i = m w
        return mf * a + b * m / det * np.stack([cross(w, r[1]), cross(r[0], w)])

    M = np.stack([effort(a, point(b * a)) for a in np.array([[one, zero], [zero, one]])], axis=1)
    for rate in RATES:
        given, tau = p[rate], p["tau"]
        q_dot, xi_dot = (given, point(b * given)) if rate == "q_dot" else (dot(r, given) / b, given)
        if rate == "xi_dot":  # across the guide: -l sin(phi) phi_dot = x_dot
            swing = -xi_dot[0] / b
            r_dot = swing[:, None] * turned(r)
        else:
            r_dot = xi_dot - np.stack([0 * q_dot, q_dot], axis=1)
            swing = cross(r, r_dot) / bars**2
        g = -dot(r_dot, r_dot)
        out[OTHER[rate], start, rate] = xi_dot if rate == "q_dot" else q_dot
        out["q_passive_dot", start, rate] = swing
        out["d", start, rate] = g / bars
        out["M", start, rate] = M.reshape(4, -1)
        out["c", start, rate] = effort(zero, point(g))
        out["energy", start, rate] = (dot(mf * q_dot, q_dot) + m * dot(xi_dot, xi_dot))[None] / 2
        # r_i . xi_ddot - b_i q_ddot_i = g_i with both accelerations written in mu
        s, k, between = g + b * tau / mf, dot(r, r) / m + b**2 / mf, dot(*r) / m
        mu = (s * k[::-1] - s[::-1] * between) / (k[0] * k[1] - between**2)
        out["forward q_ddot", start, rate] = (tau - b * mu) / mf
        out["forward xi_ddot", start, rate] = (mu[:, None] * r).sum(axis=0) / m
        for name in ACCELERATIONS:
            a = p[name]
            q_ddot, xi_ddot = (
                (a, point(b * a + g)) if name == "q_ddot" else ((dot(r, a) - g) / b, a)
            )
            r_ddot = xi_ddot - np.stack([0 * q_ddot, q_ddot], axis=1)
            out[OTHER[name], start, rate, name] = xi_ddot if name == "q_ddot" else q_ddot
            out["q_passive_ddot", start, rate, name] = cross(r, r_ddot) / bars**2
            out["tau", start, rate, name] = effort(q_ddot, xi_ddot)
    return out


def condition(p, start, step=1e-30):
    """kappa |f| = sum_j |df/dp_j| |p_j| by key, by imaginary steps."""
    total = defaultdict(float)
    for name, k in [(name, ...) for name in LENGTHS + INERTIA] + list(
        product((start, *GIVEN), (0, 1))
    ):
        x = p[name] + 0j
        x[k] += 1j * step
        for key, f in models(p | {name: x}, start).items():
            total[key] = total[key] + np.abs(p[name][k]) * norm(f.imag / step)
    return total


def draw_all(count, n, seed):
    """`count` robots, n poses of each: half of them within 1e-6 to 1e-2 of Type 1 of a leg or of Type 2."""
    rng = np.random.default_rng(seed)
    robots, drawn = [], []
    while len(robots) < count:
        l1, l2, d = (
            np.exp(rng.uniform(-0.5, 0.5, 3)) * 10 ** rng.uniform(-1.5, 0.5) * (1.0, 1.0, 1.2)
        )
        l2 = l1 if len(robots) % 2 else l2
        if d < 0.95 * (l1 + l2):
            m = 10 ** rng.uniform(-1, 1)
            masses = *(m * 10 ** rng.uniform(-1, 1, 2)).tolist(), m
            robots.append(dict(zip(LENGTHS + INERTIA, (float(l1), float(l2), float(d), *masses))))
            drawn.append(_draw(robots[-1], n, rng))
    p = {name: np.concatenate([x[name] for x in drawn], axis=-1) for name in drawn[0]}
    p |= {name: np.repeat([robot[name] for robot in robots], n) for name in LENGTHS + INERTIA}
    return robots, p | {name: rng.normal(size=(2, count * n)) for name in GIVEN}


def _draw(robot, n, rng):
    l1, l2, d = (robot[name] for name in LENGTHS)
    size = 40 * n

    def near():
        return rng.choice([-1, 1], size) * 10 ** rng.uniform(-6, -2, size)

    x = rng.uniform(-d / 2 - l1, d / 2 + l2, size)
    kind = rng.integers(0, 6, size)  # three of six: anywhere
    x = np.where(kind == 3, -d / 2 + rng.choice([-1, 1], size) * l1 * (1 - np.abs(near())), x)
    x = np.where(kind == 4, d / 2 + rng.choice([-1, 1], size) * l2 * (1 - np.abs(near())), x)
    x = np.where(kind == 5, -d / 2 + l1 * d / (l1 + l2) * (1 + near()), x)
    off = np.stack([x + d / 2, x - d / 2])
    chosen = np.flatnonzero((np.abs(off) < np.array([[l1], [l2]])).all(axis=0))[:n]
    x, off, y = x[chosen], off[:, chosen], rng.normal(size=n) * d
    working = rng.choice([-1, 1], (2, n))
    height = -working * np.sqrt(np.array([[l1], [l2]]) ** 2 - off**2)
    det = off[0] * height[1] - off[1] * height[0]
    return {
        "q": y - height,
        "xi": np.stack([x, y]),
        "assembly": np.where(det < 0, 1, -1),
        "working": working,
    }
