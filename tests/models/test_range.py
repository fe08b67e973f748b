"""The range of sizes in which models are right, and outside of which robots and linkages are refused."""

import numpy as np
import pytest
from mpmath import mp, mpf

import fivebar as fb
from fivebar.base.checks import HEAVIEST, LIGHTEST, LONGEST, RATIO, SHORTEST


@pytest.mark.parametrize("size", [1e-100, 1e-10, 1e10, 1e80])
def test_robots_out_of_range_are_refused(size):
    lengths = {name: size for name in ("l11", "l12", "l21", "l22", "d")}
    with pytest.raises(
        ValueError, match="l11 = 1e.* m is outside 1e-09 to 1e.09 m: choose another unit of length"
    ):
        fb.FiveBar(**lengths)
    with pytest.raises(ValueError, match="l1 = .* is outside"):
        fb.Biglide(size, size, size)
    with pytest.raises(ValueError, match="ground = .* is outside"):
        fb.linkages.FourBar(size, size, size, size)


def test_ratios_and_inertias_out_of_range_are_refused():
    with pytest.raises(
        ValueError, match=r"l12 = 10000 m is more than 1e\+06 times l11 = 0.001 m: rounding"
    ):
        fb.FiveBar(1e-3, 1e4, 1e4, 1e4, 1e4)
    for values in (dict(zz1=1e-31), dict(m=1e31), dict(zz2=5e-324)):
        with pytest.raises(ValueError, match="outside 1e-30 to 1e.30, and not 0"):
            fb.FiveBar(**values)
    with pytest.raises(ValueError, match=r"d = 1e-14 m is less than 1e-12 of the longest bar"):
        fb.FiveBar(d=1e-14)
    assert fb.FiveBar(d=0.0, zz1=0.0, m=0.0).d == 0.0


@pytest.mark.parametrize("size", [SHORTEST / 0.8, 1e-3, 1.0, LONGEST / 1.2])
@pytest.mark.parametrize("inertia", [LIGHTEST / 0.2, 1.0, HEAVIEST])
def test_models_are_right_at_the_ends_of_the_range(size, inertia):
    """The five-bar of one size is that of another, magnified: dgm by 50 digits, forward dynamics by its scales."""
    unit = fb.FiveBar(1.0, 0.9, 0.8, 1.1, 1.2, 0.2, 0.3, 0.5)
    robot = fb.FiveBar(
        *(size * x for x in (1.0, 0.9, 0.8, 1.1, 1.2)),
        *(inertia * x for x in (0.2, 0.3)),
        min(max(inertia * 0.5 / size**2, LIGHTEST), HEAVIEST),
    )
    q = np.array([1.2, 0.9])
    pose = fb.dgm(robot, q)
    mp.dps = 50
    a, b = (
        [mpf(s) * mpf(robot.d) / 2 + mpf(l1) * mp.cos(mpf(x)), mpf(l1) * mp.sin(mpf(x))]
        for s, l1, x in ((-1, robot.l11, q[0]), (1, robot.l21, q[1]))
    )
    for elbow, bar in ((a, robot.l12), (b, robot.l22)):
        gap = mp.sqrt(sum((mpf(float(x)) - e) ** 2 for x, e in zip(pose.xi, elbow))) - mpf(bar)
        assert abs(float(gap)) < 1e-15 * size * 4
    assert pose.xi == pytest.approx(size * fb.dgm(unit, q).xi, rel=1e-14)
    if robot.m == inertia * 0.5 / size**2:
        tau = np.array([0.3, -0.2])
        one = fb.forward_dynamics(fb.dkm(fb.dgm(unit, q), (0.4, 0.5)), tau)
        own = fb.forward_dynamics(fb.dkm(pose, (0.4, 0.5)), inertia * tau)
        assert own.q_ddot == pytest.approx(one.q_ddot, rel=1e-11)


def test_the_longest_bar_may_be_a_million_times_the_shortest():
    robot = fb.FiveBar(1.0 / RATIO, 1.0, 1.0, 1.0, 1.0)
    pose = fb.dgm(robot, (0.3, 1.2))
    elbow = np.array([-0.5 + 1e-6 * np.cos(0.3), 1e-6 * np.sin(0.3)])
    assert np.linalg.norm(pose.xi - elbow) == pytest.approx(1.0, abs=1e-15)
    again = fb.igm(robot, pose.xi, pose.working)
    assert again.q[0] == pytest.approx(0.3, abs=1e-9)  # 1e-16 of rounding over 1e-6, over the sine


def test_coordinates_whose_squares_overflow_are_refused():
    pose = fb.dgm(fb.FiveBar(), (0.2, -0.1))
    assert np.isfinite(fb.forward_dynamics(fb.dkm(pose, (9e59, -9e59)), (9e59, 0.0)).q_ddot).all()
    with pytest.raises(ValueError, match=r"q_dot must be below 1e\+60 in size"):
        fb.dkm(pose, (1e61, 0.0))
