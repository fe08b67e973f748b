"""The five-bar in redundant coordinates, to check the package by: one code on mpmath numbers and on complex floats.

A free point xi and two cranks under the constraints |r_i|^2 = l_i2^2, r_i = xi - E_i, E_i the elbows. Differentiated:
    r_i . xi_dot  = b_i q_dot_i             b_i = l_i1 r_i . v_i1
    r_i . xi_ddot = b_i q_ddot_i + g_i      g_i = -l_i1 q_dot_i^2 r_i . u_i1 - |r_i_dot|^2
    m xi_ddot = sum_i mu_i r_i              tau_i = zz_i q_ddot_i + b_i mu_i           (mu_i the multipliers)
Values are mpmath numbers in arrays of objects; for kappa one parameter at a time gets an imaginary step in float64.
A set of poses maps lengths, inertias and "assembly" to arrays (poses,), coordinates and "working" to (2, poses).
"""

from collections import defaultdict
from itertools import product

import mpmath
import numpy as np

EPS = np.finfo(float).eps
LENGTHS, INERTIA = ("l11", "l12", "l21", "l22", "d"), ("zz1", "zz2", "m")
RATES, ACCELERATIONS = ("q_dot", "xi_dot"), ("q_ddot", "xi_ddot")
GIVEN = (*RATES, *ACCELERATIONS, "tau")
MODES = {"q": "assembly", "xi": "working"}  # the signs that a start needs
ANGLES = ("q", "q_passive")  # here unit vectors: an error of a radian is a distance on the circle
OTHER = {a: b for pair in (("q", "xi"), RATES, ACCELERATIONS) for a, b in (pair, pair[::-1])}

exact = np.frompyfunc(mpmath.mpf, 1, 1)
_EXACT = {f: np.frompyfunc(getattr(mpmath, f.__name__), 1, 1) for f in (np.sqrt, np.cos, np.sin)}


def of(f, x):
    """NumPy's function or, for objects, mpmath's of the same name."""
    return _EXACT[f](x) if x.dtype == object else f(x)


def dot(a, b):
    return a[..., 0, :] * b[..., 0, :] + a[..., 1, :] * b[..., 1, :]


def cross(a, b):
    return a[..., 0, :] * b[..., 1, :] - a[..., 1, :] * b[..., 0, :]


def turned(a):  # by +90 degrees
    return np.stack([-a[..., 1, :], a[..., 0, :]], axis=-2)


def circle(angle):
    return np.stack([of(np.cos, angle), of(np.sin, angle)], axis=-2)


def norm(components):
    return np.sqrt((np.asarray(components, dtype=float) ** 2).sum(axis=0))


def keys(start):
    """What is compared when the pose comes from `start` (q or xi): (name, *given)."""
    rated = ("q_passive_dot", "d", "M", "c", "energy", "forward q_ddot", "forward xi_ddot")
    found = [(name, start) for name in (OTHER[start], "q_passive", "A", "B")]
    found += [(name, start, r) for r in RATES for name in (OTHER[r], *rated)]
    ways = product(RATES, ACCELERATIONS)
    return found + [
        (name, start, r, a) for r, a in ways for name in (OTHER[a], "q_passive_ddot", "tau")
    ]


def bars(p):
    """Proximal and distal lengths (2, poses), base joints (2, 2, poses)."""
    left, zero = -p["d"] / 2, 0 * p["d"]
    return (
        np.stack([p["l11"], p["l21"]]),
        np.stack([p["l12"], p["l22"]]),
        np.array([[left, zero], [-left, zero]]),
    )


def triangle(square, l1, l2, sign):
    """Where the corner between the sides l1 and l2 stands, along and across the third, given squared, in its length."""
    along = (1 + (l1**2 - l2**2) / square) / 2
    return along, sign * of(np.sqrt, l1**2 / square - along**2)


def dyad(reach, l1, l2, sign):
    """The point e with |e| = l1, |reach - e| = l2 and e x reach of the given sign."""
    along, across = triangle(dot(reach, reach), l1, l2, sign)
    return along[..., None, :] * reach - across[..., None, :] * turned(reach)


def models(p, start):
    """All of `keys(start)`, each (components, poses)."""
    (l1, l2, base), zz, m, out = bars(p), np.stack([p["zz1"], p["zz2"]]), p["m"], {}
    if start == "q":
        u = circle(p["q"])
        elbows = base + l1[:, None] * u
        xi = out["xi", start] = elbows[0] + dyad(elbows[1] - elbows[0], *l2, p["assembly"])
    else:
        xi = p["xi"]
        u = dyad(xi - base, l1, l2, -p["working"]) / l1[:, None]
        elbows = base + l1[:, None] * u
        out["q", start] = u.reshape(4, -1)
    r, v = xi - elbows, turned(u)
    b, det = l1 * dot(r, v), cross(*r)
    zero, one = 0 * det, 0 * det + 1
    out["q_passive", start] = np.stack([dot(u, r) / l2, cross(u, r) / l2], axis=1).reshape(4, -1)
    out["A", start] = (r / l2[:, None]).reshape(4, -1)
    out["B", start] = np.stack([b[0] / l2[0], zero, zero, b[1] / l2[1]])

    def point(s):  # w with r_i . w = s_i
        return (s[1] * turned(r[0]) - s[0] * turned(r[1])) / det

    def effort(a, w):  # the multipliers from sum_i mu_i r_i = m w
        return zz * a + b * m / det * np.stack([cross(w, r[1]), cross(r[0], w)])

    M = np.stack([effort(a, point(b * a)) for a in np.array([[one, zero], [zero, one]])], axis=1)
    for rate in RATES:
        given, tau = p[rate], p["tau"]
        q_dot, xi_dot = (given, point(b * given)) if rate == "q_dot" else (dot(r, given) / b, given)
        r_dot = xi_dot - (l1 * q_dot)[:, None] * v
        g = -l1 * q_dot**2 * dot(r, u) - dot(r_dot, r_dot)
        out[OTHER[rate], start, rate] = xi_dot if rate == "q_dot" else q_dot
        out["q_passive_dot", start, rate] = cross(r, r_dot) / l2**2 - q_dot
        out["d", start, rate] = g / l2
        out["M", start, rate] = M.reshape(4, -1)
        out["c", start, rate] = effort(zero, point(g))
        out["energy", start, rate] = (dot(zz * q_dot, q_dot) + m * dot(xi_dot, xi_dot))[None] / 2
        # r_i . xi_ddot - b_i q_ddot_i = g_i with both accelerations written in mu
        s, k, between = g + b * tau / zz, dot(r, r) / m + b**2 / zz, dot(*r) / m
        mu = (s * k[::-1] - s[::-1] * between) / (k[0] * k[1] - between**2)
        out["forward q_ddot", start, rate] = (tau - b * mu) / zz
        out["forward xi_ddot", start, rate] = (mu[:, None] * r).sum(axis=0) / m
        for name in ACCELERATIONS:
            a = p[name]
            q_ddot, xi_ddot = (
                (a, point(b * a + g)) if name == "q_ddot" else ((dot(r, a) - g) / b, a)
            )
            r_ddot = xi_ddot - (l1 * q_ddot)[:, None] * v + (l1 * q_dot**2)[:, None] * u
            out[OTHER[name], start, rate, name] = xi_ddot if name == "q_ddot" else q_ddot
            out["q_passive_ddot", start, rate, name] = cross(r, r_ddot) / l2**2 - q_ddot
            out["tau", start, rate, name] = effort(q_ddot, xi_ddot)
    return out


def perturbed(p, start, step):
    """For everything that the models depend on: its name, its value, and p with that value a step away."""
    for name, k in [(name, ...) for name in LENGTHS + INERTIA] + list(
        product((start, *GIVEN), (0, 1))
    ):
        x = p[name] + 0 * step
        x[k] += step
        yield name, p[name][k], p | {name: x}


def condition(p, start, step=1e-30):
    """kappa |f| = sum_j |df/dp_j| |p_j| by key."""
    total = defaultdict(float)
    for _, x, moved in perturbed(p, start, 1j * step):
        for key, f in models(moved, start).items():
            total[key] = total[key] + np.abs(x) * norm(f.imag / step)
    return total


def robots(count, rng):
    """The AMORO robot, others with equal bars, then unequal ones with ratios of up to 2.5, of any size."""
    sets = [(0.09, 0.09, 0.09, 0.09, d, 0.002, 0.002, 0.5) for d in (0.118, 0.05, 0.09, 0.15)]
    while len(sets) < count:
        lengths = np.exp(rng.uniform(-0.46, 0.46, 5)) * 10 ** rng.uniform(-1.5, 0.5)
        m, zz_share = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 1, 2)
        if lengths[4] < 0.8 * lengths[:4].sum():
            sets.append((*lengths.tolist(), *(m * lengths.max() ** 2 * zz_share).tolist(), m))
    return [dict(zip(LENGTHS + INERTIA, x)) for x in sets]


def draw(robot, n, rng):
    """n reachable poses, the last third close to a singularity: q, xi, assembly and working as the models take them."""
    (l11, l12, l21, l22, d), size = (robot[name] for name in LENGTHS), 40 * n
    l1, l2, base = (l11, l21), (l12, l22), (-d / 2, d / 2)

    def sign():
        return rng.choice([-1, 1], size)

    def slight_turn():  # by an angle of 1e-6 to 1e-2, or by its root: the end is that far from the stretched reach
        return np.exp(1j * sign() * 10 ** (rng.uniform(-6, -2, size) * rng.choice([0.5, 1], size)))

    def crank(i, then=0.0):
        return base[i] + (l1[i] + then) * np.exp(1j * rng.uniform(-np.pi, np.pi, size))

    def tip(reach, a, b):  # as `dyad`, on complex numbers
        return reach * (np.array([1, -1j]) @ triangle(np.abs(reach) ** 2, a, b, sign()))

    with np.errstate(all="ignore"):  # nan where unreachable
        inside = max(l11 + l12, l21 + l22) * (
            rng.uniform(-1.5, 1.5, size) + 1j * rng.uniform(-1.5, 1.5, size)
        )
        straight = [crank(i, l2[i] * slight_turn() * sign()) for i in (0, 1)]
        drawn = [
            (xi, *(base[i] + tip(xi - base[i], l1[i], l2[i]) for i in (0, 1)))
            for xi in (inside, *straight)
        ]
        left = crank(0)
        pairs = [
            (left, base[1] + tip(left - base[1], l21, np.abs(l12 - l22 * slight_turn() * sign())))
        ]
        if l12 == l22:  # both elbows near one point
            point = base[0] + tip(d + np.zeros(size), l11, l21)
            pairs += [[base[i] + (point - base[i]) * slight_turn() for i in (0, 1)]]
        drawn += [(left + tip(right - left, l12, l22), left, right) for left, right in pairs]
    some, *singular = (k[:, np.isfinite(k).all(axis=0)] for k in map(np.array, drawn))
    near = np.hstack([k[:, : n // 6] for k in singular])
    near = near[:, rng.permutation(near.shape[1])[: n // 3]]
    xi, left, right = np.hstack([some[:, : n - near.shape[1]], near])
    cranks, distal = np.stack([left - base[0], right - base[1]]), np.stack([xi - left, xi - right])
    assembly, working = (
        np.where((a.conj() * b).imag < 0, 1, -1) for a, b in (distal, (cranks, distal))
    )
    return {
        "q": np.angle(cranks),
        "xi": np.stack([xi.real, xi.imag]),
        "assembly": assembly,
        "working": working,
    }


def draw_all(count, n, seed):
    """`count` robots, and n poses of each as one set, with random rates, accelerations and torques."""
    rng = np.random.default_rng(seed)
    chosen = robots(count, rng)
    drawn = [draw(robot, n, rng) for robot in chosen]
    p = {name: np.concatenate([x[name] for x in drawn], axis=-1) for name in drawn[0]}
    p |= {name: np.repeat([robot[name] for robot in chosen], n) for name in LENGTHS + INERTIA}
    return chosen, p | {name: rng.normal(size=(2, count * n)) for name in GIVEN}
