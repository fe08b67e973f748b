"""Robots of the families in which geometry degenerates: the kinds of rounding and of coincidence that occur."""

from itertools import product

import numpy as np

import fivebar as fb


def generic(rng):
    return rng.uniform(0.05, 0.5, 5)


def symmetric(rng):
    l1, l2, d = rng.uniform(0.05, 0.5, 3)
    return l1, l2, l1, l2, d


def integer_mm(rng):
    return rng.integers(40, 400, 5)


def integer_cm(rng):
    return rng.integers(4, 40, 5) / 100


def change_point(rng):
    """+-l11 +-l12 +-l21 +-l22 = d, in integers: all four bars can lie along the base."""
    bars = rng.integers(4, 40, 4)
    sums = [abs(int(np.dot(signs, bars))) for signs in product((1, -1), repeat=4)]
    return (*(bars / 100), rng.choice(sums) / 100)


def touching_circles(rng):
    """Two of the circles of Type 1 about the two bases touch, from outside or from inside."""
    l11, l12, l21, l22 = rng.integers(4, 40, 4)
    left, right = (
        rng.choice([l11 + l12, abs(int(l11 - l12))]),
        rng.choice([l21 + l22, abs(int(l21 - l22))]),
    )
    return (
        *(np.array([l11, l12, l21, l22]) / 100),
        rng.choice([left + right, abs(int(left - right))]) / 100,
    )


def coaxial(rng):
    return (*rng.uniform(0.05, 0.5, 4), 0.0)


def unequal(rng):
    """Ratios to 1 : 1000."""
    return 10 ** rng.uniform(-3, 0, 5)


FAMILIES = (
    generic,
    symmetric,
    integer_mm,
    integer_cm,
    change_point,
    touching_circles,
    coaxial,
    unequal,
)


def robots(family, count, seed):
    """So many robots of a family that close, with inertias that fit their size."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        l11, l12, l21, l22, d = (float(length) for length in family(rng))
        m = rng.uniform(0.2, 2.0)
        zz1, zz2 = m * l11**2 * rng.uniform(0.3, 2), m * l21**2 * rng.uniform(0.3, 2)
        try:
            found.append(fb.FiveBar(l11, l12, l21, l22, d, zz1, zz2, m))
        except ValueError as error:
            assert "never close" in str(error)
    return found


def poses(robot, count, rng, margin=0.05):
    """Up to so many poses of a robot, in random modes, with sines of at least `margin`."""
    found, size = [], max(robot.l11 + robot.l12, robot.l21 + robot.l22) + robot.d / 2
    for _ in range(40):
        q = rng.uniform(-np.pi, np.pi, (400, 2))
        assembly = rng.choice([-1, 1], 400)
        pose = fb.dgm(robot, q, assembly, unreachable="nan")
        good = (np.abs(np.stack([*pose.sines, pose.det_A])) > margin).all(axis=0)
        found += list(zip(q[good], assembly[good]))
        if len(found) >= count:
            break
    return found[:count], size
