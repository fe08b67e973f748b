"""The RRP dyad is the RRR dyad in the limit, and keeps its digits."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fivebar.models.dyads import RRP, RRR


@given(
    st.floats(-3, 3),
    st.floats(-3, 3),
    st.floats(0.5, 2),
    st.sampled_from([1, -1]),
    st.floats(0, 6.28),
)
def test_rrp_is_rrr_in_the_limit_of_an_infinite_bar(x, y, r, branch, turn):
    """The vector method paper's remark: the error falls with the bar's length until rounding takes over."""
    guide = math.cos(turn), math.sin(turn)
    rrp = RRP((x, y), r, guide, branch)
    if not abs(rrp.height) < 0.9 * r:
        return
    errors = []
    for length in (1e2, 1e4, 1e6):
        pivot = x + length * guide[1], y - length * guide[0]  # far on the guide's right
        rrr = RRR(pivot, r, length, branch)
        errors.append(
            math.dist(rrr.first, rrp.first)
            + math.dist(rrr.second, rrp.second)
            + abs(rrr.sine - rrp.sine)
        )
    assert errors[1] < 0.03 * errors[0] + 1e-9 and errors[2] < 0.03 * errors[1] + 1e-9
    assert errors[2] < 1e-3


def test_rrp_reaches_its_guide_and_nothing_beyond():
    rrp = RRP((0.3, 0.1), 0.5, (0.6, 0.8), np.array([1, -1]))
    ux, uy = rrp.first
    on_guide = (0.5 * ux - 0.3) * 0.8 - (0.5 * uy - 0.1) * 0.6
    assert ux**2 + uy**2 == pytest.approx(1, rel=1e-15) and on_guide == pytest.approx(0, abs=1e-16)
    assert (0.5 * ux - 0.3) * 0.6 + (0.5 * uy - 0.1) * 0.8 == pytest.approx(rrp.slide, rel=1e-15)
    assert rrp.sine[0] > 0 > rrp.sine[1]
    assert math.isnan(RRP((0.0, 1.0), 0.5, (1.0, 0.0), 1).slide)
    for turn in np.linspace(
        0, 6.28, 500
    ):  # perpendicular to the guide: reachable in spite of rounding, and singular
        c, s = math.cos(turn), math.sin(turn)
        rrp = RRP((-0.7 * s, 0.7 * c), 0.7, (c, s), 1)
        assert abs(rrp.sine) < 1e-7 and abs(rrp.slide) < 1e-7


def test_rrp_keeps_its_digits_close_to_its_singularity():
    """|error| <= 16 eps (|f| + sum_j |df/dp_j| |p_j|), as for the robot's own models; measured 0.7."""
    rng, worst = np.random.default_rng(5), 0.0

    def exact(x, y, r, gx, gy, branch):
        height = gy * x - gx * y
        reach = branch * mpmath.sqrt(r * r - height * height)
        return (
            (reach * gx + height * gy) / r,
            (reach * gy - height * gx) / r,
            reach / r,
            reach - gx * x - gy * y,
        )

    def condition(p, branch, i):
        """Of output i, the number itself included: the sine is all but constant where it is 1."""
        total = abs(exact(*p, branch)[i])
        for j, own in enumerate(p):
            total += abs(own * mpmath.diff(lambda x: exact(*p[:j], x, *p[j + 1 :], branch)[i], own))  # noqa: B023
        return total

    with mpmath.workdps(50):
        for k in range(100):
            turn, r, branch = rng.uniform(0, 6.28), rng.uniform(0.2, 2), int(rng.choice([1, -1]))
            share = 1 - 10.0 ** rng.uniform(-12, -2) if k % 3 == 0 else rng.uniform(-0.99, 0.99)
            (gx, gy), along = (math.cos(turn), math.sin(turn)), rng.uniform(-2, 2)
            x, y = along * gx + share * r * gy, along * gy - share * r * gx
            rrp, given = (
                RRP((x, y), r, (gx, gy), branch),
                [mpmath.mpf(value) for value in (x, y, r, gx, gy)],
            )
            for i, got in enumerate((*rrp.first, rrp.sine, rrp.slide)):
                error = abs(got - exact(*given, branch)[i])
                worst = max(worst, float(error / (2.0**-52 * condition(given, branch, i))))
    assert worst < 16, worst
