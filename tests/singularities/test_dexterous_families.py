"""Dexterous regions of robots in round numbers and of odd ones, against a flood fill on a grid.

Margins are drawn, and set to where boundaries pass themselves, touch a circle or meet a corner of two. A few robots of
each family; with FIVEBAR_NIGHTLY=1 four hundred.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import fivebar as fb
from fivebar.singularities.dexterous import LEAST
from fivebar.singularities.locus import MODES
from tests.singularities.test_aspect_families import (
    FAMILIES,
    agree,
    det_a,
    grid,
    parallel_touch,
    robots,
)


def drawn(robot, rng):
    several = 0, 0.001, 0.1, 0.3, 0.5, 0.6, 0.8, 0.95, rng.uniform(), 10 ** rng.uniform(-4, 0)
    return rng.choice(several), rng.choice(several)


def sine_of_elbows(robot, apart):
    """|det A| where the elbows are so far apart."""
    if not 0 < apart < robot.l12 + robot.l22:
        return 0.0
    cosine = (robot.l12**2 + robot.l22**2 - apart**2) / (2 * robot.l12 * robot.l22)
    return math.sqrt(max(1 - cosine * cosine, 0.0))


def crossing(robot, rng):
    """A curve passes itself: proximal bars and elbows are in line."""
    signs = rng.choice([-1, 1], 2)
    return sine_of_elbows(robot, abs(robot.d + signs @ (robot.l11, robot.l21))), rng.choice(
        [0, 0.1, 0.4]
    )


def touching_circle(robot, rng):
    """A curve touches a circle: crank and elbows as one bar, in line with the base and the other crank."""
    k, side, cut = rng.uniform(0.05, 0.9), rng.choice([-1, 1]), rng.choice([-1, 1])
    turn = complex(rng.choice([-1, 1]) * math.sqrt(1 - k * k), rng.choice([-1, 1]) * k)
    elbows = robot.l12 - robot.l22 * turn

    def gap(s):
        bar = robot.l11 + elbows.conjugate() * complex(side * math.sqrt(1 - s * s), s)
        return abs(bar) - abs(robot.d + cut * robot.l21)

    s = brentq(gap, 0.0, 1.0, xtol=1e-16) if gap(0.0) * gap(1.0) < 0 else 0.3
    return k, s


def corner(robot, rng):
    """A curve passes where two circles meet."""
    s = rng.uniform(0.02, 0.9)
    lefts, rights = (
        [math.sqrt(a * a + b * b + 2 * side * a * b * math.sqrt(1 - s * s)) for side in (1, -1)]
        for a, b in ((robot.l11, robot.l12), (robot.l21, robot.l22))
    )
    left, right = rng.choice(lefts), rng.choice(rights)
    if robot.d == 0 or not abs(left - right) < robot.d < left + right:
        return 0.2, s
    x = (left**2 - right**2) / (2 * robot.d)
    y = math.sqrt(left**2 - (x + robot.d / 2) ** 2)
    k = abs(float(det_a(robot, np.array(x), np.array(y * (1 - 1e-15)), MODES[rng.integers(4)])))
    return (k if 0 <= k <= 1 else 0.2), s


@pytest.mark.every(11)
@pytest.mark.parametrize(
    "margins", [drawn, crossing, touching_circle, corner], ids=lambda each: each.__name__
)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_regions_are_those_of_a_flood_fill(family, margins):
    rng = np.random.default_rng(sum(map(ord, family.__name__ + margins.__name__)))
    for robot in robots(family)[:: 1 if margins is drawn else 3]:
        k, s = (float(each) * (each >= LEAST) for each in margins(robot, rng))
        found = fb.dexterous(robot, det_A=k, sin=s)
        x, y, step = grid(robot)
        kept = np.ones((len(x), len(y)), dtype=bool)
        for side, l1, l2 in ((-1, robot.l11, robot.l12), (1, robot.l21, robot.l22)):
            square = (x[:, None] - side * robot.d / 2) ** 2 + y**2
            kept &= 1 - ((square - l1 * l1 - l2 * l2) / (2 * l1 * l2)) ** 2 >= s * s
        for working in MODES:
            values = det_a(robot, x[:, None], y, working)
            for assembly in (1, -1):
                own = [
                    part for part in found if (part.working, part.assembly) == (working, assembly)
                ]
                inside, what = (
                    kept & (-assembly * values >= max(k, 1e-9)),
                    (robot, k, s, working, assembly),
                )
                agree(own, inside, x, y, step, what, not parallel_touch(robot))
