"""What `check_path` is made of: margins of a path with their rates, and the zeros of any margin, in closed form."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.constraints import path_check as module
from fivebar.constraints.path_check import (
    SAMPLES,
    _finite,
    _near,
    _root,
    _times,
    _Zero,
    _zero_between,
    _zeros,
)
from tests.conftest import UNEQUAL

T = np.linspace(0, 1, SAMPLES)
BIGLIDE = fb.Biglide(l1=0.25, l2=0.4, d=0.3)


def difference(f, t, h=1e-6):
    return (f(t + h)[0] - f(t - h)[0]) / (2 * h)


@pytest.mark.parametrize("robot", [UNEQUAL, BIGLIDE])
def test_margins_of_a_path_and_their_rates(robot):
    """The reach as a share of its largest square; rates against differences."""
    path, t = fb.line((0.02, 0.13), (-0.04, 0.1), 0.7), np.linspace(0.1, 0.6, 9)
    x, y = path(t)[0].T
    for drive, bar, sign in zip(robot.drives, robot.distal, (-1, 1)):
        away = x - sign * robot.d / 2, y if robot.turns else 0 * y
        square, most = away[0] ** 2 + away[1] ** 2, (drive.length * robot.turns + bar) ** 2
        for limit, outer in drive.limits(bar):
            margin = module._reach(path, drive, bar, limit, outer)
            expected = (most - square) if outer else square - (drive.length - bar) ** 2
            np.testing.assert_allclose(margin(t)[0], expected / most, rtol=1e-12)
            np.testing.assert_allclose(margin(t)[1], difference(margin, t), rtol=1e-6, atol=1e-8)
    parallel = module._parallel(robot, path, (1, -1))
    np.testing.assert_allclose(
        parallel(t)[0], fb.igm(robot, path(t)[0], (1, -1)).det_A, rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(parallel(t)[1], difference(parallel, t), rtol=1e-6, atol=1e-8)


def test_at_the_limit_of_reach_the_rate_has_a_sign():
    """A bar in line turns as fast as numbers allow, and none of them overflows."""
    path = fb.line((0.121, 0.0), (0.05, 0.06), 1.0)
    value, rate = module._parallel(
        fb.FiveBar(), lambda t: (path(t)[0], np.full((len(t), 2), 0.1), None), (-1, -1)
    )(T[:3])
    assert (
        np.isfinite(rate).all()
        and abs(rate[0]) > 1e100 * np.abs(rate[1:]).max()
        and np.isfinite(value).all()
    )


def test_between_samples_a_margin_may_change_as_fast_as_at_them():
    rng = np.random.default_rng(1)
    t, value, rate = np.cumsum(rng.uniform(size=60)), rng.normal(size=60), rng.normal(size=60)
    expected = [
        min(abs(value[k]), abs(value[k + 1]))
        < (t[k + 1] - t[k]) * max(abs(rate[k]), abs(rate[k + 1]))
        for k in range(59)
    ]
    assert 10 < sum(expected) < 50 and _near(t, value, rate).tolist() == expected


WAVE = 2 * np.pi * 2.3 * (SAMPLES - 1)  # more than two waves from sample to sample


@pytest.mark.parametrize(
    "f, rate, limit, expected",
    [
        (lambda t: t - 0.3, lambda t: 0 * t + 1, False, [(0.3, False)]),
        (lambda t: t + 0.3, lambda t: 0 * t + 1, False, []),
        (lambda t: (t - 0.3) * (0.6 - t), lambda t: 0.9 - 2 * t, False, [(0.3, False)]),
        (lambda t: (t - 0.3) ** 2, lambda t: 2 * (t - 0.3), False, [(0.3, True)]),
        (
            lambda t: (t - 0.3) ** 2 * (t - 0.7),
            lambda t: (t - 0.3) * (3 * t - 1.7),
            False,
            [(0.3, True), (0.7, False)],
        ),
        # At a sample, less than 0 by rounding.
        (lambda t: (t - 0.5) ** 2 - 1e-12, lambda t: 2 * (t - 0.5), False, [(0.5, True)]),
        # Arrives at its end, or starts there.
        (lambda t: 1 - t, lambda t: 0 * t - 1, True, [(1.0, True)]),
        (lambda t: t, lambda t: 0 * t + 1, True, [(0.0, True)]),
        (lambda t: t * (0.4 - t), lambda t: 0.4 - 2 * t, True, [(0.0, True), (0.4, False)]),
        (lambda t: -t, lambda t: 0 * t - 1, True, [(0.0, False)]),
        (lambda t: -t, lambda t: 0 * t - 1, False, [(0.0, True)]),
        (lambda t: t - 0.3, lambda t: 0 * t + 1, True, [(0.0, False)]),
        (lambda t: 1e-4 - t, lambda t: 0 * t - 1, True, [(1e-4, False)]),
        (lambda t: 0 * t, lambda t: 0 * t, True, [(0.0, True)]),
        (lambda t: 0 * t - 1e-10, lambda t: 0 * t, True, [(0.0, True)]),
        # Without a margin outside of reach; nowhere.
        (lambda t: np.where(t < 0.2, np.nan, t - 0.3), lambda t: 0 * t + 1, False, [(0.3, False)]),
        (lambda t: np.nan * t, lambda t: np.nan * t, True, []),
        # It jumps.
        (lambda t: np.where(t < 0.3, 0.5, -0.5), lambda t: 0 * t, False, []),
        (
            lambda t: 0.999 + np.cos(WAVE * t),
            lambda t: -WAVE * np.sin(WAVE * t),
            False,
            [(np.arccos(-0.999) / WAVE, False)],
        ),
        (lambda t: 1 + 1e-6 + np.cos(WAVE * t), lambda t: -WAVE * np.sin(WAVE * t), False, []),
    ],
)
def test_zeros_of_a_margin(f, rate, limit, expected):
    found = list(_zeros(lambda t: (f(t), rate(t)), T, 1e-9, limit))
    assert [zero.touching for zero in found] == [touching for _, touching in expected]
    assert [zero.time for zero in found] == pytest.approx(
        [time for time, _ in expected], rel=0, abs=1e-12
    )


def test_a_zero_all_along_the_end_is_where_the_margin_is_least():
    (zero,) = _zeros(lambda t: ((t - 0.99998) ** 2, 2 * (t - 0.99998)), T, 1e-9)
    assert zero.touching is True and zero.time == pytest.approx(0.99998, abs=1e-6)


def test_between_two_samples():
    def between(f, rate, sign=1):
        at_a, at_b = sign * f(np.array([0.0, 1.0]))
        return _zero_between(lambda t: (sign * f(t), sign * rate(t)), 0.0, 1.0, at_a, at_b, 1e-9)

    for sign in (1, -1):
        assert between(lambda t: (t - 0.3) ** 2 + 1e-3, lambda t: 2 * (t - 0.3), sign) is None
        assert between(lambda t: (t - 0.3) ** 2, lambda t: 2 * (t - 0.3), sign) == _Zero(0.3, True)
        zero = between(lambda t: (t - 0.3) ** 2 - 0.04, lambda t: 2 * (t - 0.3), sign)
        assert zero.touching is False and zero.time == pytest.approx(0.1, abs=1e-15)
    # Its rate is not known, as at the limit of reach: the middle is tried.
    assert between(lambda t: (t - 0.5) ** 2, lambda t: np.nan * t) == _Zero(0.5, True)
    assert between(lambda t: 0.2 - t, lambda t: 0 * t - 1) == _Zero(0.2, False)


def test_a_root_where_the_ends_alone_are_rounded_otherwise():
    assert _root(lambda s: np.where(s == 0, 1.0, s - 0.3), 0.0, 1.0, -0.3, 0.7) == pytest.approx(
        0.3, abs=1e-15
    )
    assert _root(lambda s: np.where(s == 1, -1.0, s - 0.3), 0.0, 1.0, -0.3, 0.7) == pytest.approx(
        0.3, abs=1e-15
    )
    assert _root(
        lambda s: np.where(abs(s - 0.3) < 1e-3, np.nan, s - 0.3), 0.0, 1.0, -0.3, 0.7
    ) == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize("start", [0.0, 30.0])
def test_the_pose_at_the_limit_of_reach_is_some_roundings_before(start):
    robot, base, speed = (
        fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
        np.array([-0.05, 0.0]),
        0.1 * np.exp(0.7j),
    )
    way = np.array([speed.real, speed.imag])

    def path(t):
        return base + np.outer(t - start, way), np.tile(way, (len(t), 1)), np.zeros((len(t), 2))

    path.duration = 3.0
    stretched = start + 2.2
    for steps in (0, 1, 4, 16):
        pose = module._pose_at(robot, path, (1, -1), stretched + steps * np.spacing(stretched))
        np.testing.assert_allclose(pose.xi, base + 2.2 * way, rtol=0, atol=1e-12)
    for time in start + np.linspace(1.1, 2, 20):
        pose = module._pose_at(robot, path, (1, -1), time)
        np.testing.assert_array_equal(pose.xi, path(np.array([time]))[0][0])
        assert pose.working.tolist() == [1, -1]


@pytest.mark.parametrize(
    "ends", [((0.0, 0.1), (0.05, 0.1)), ((0.05, 0.1), (0.0, 0.1)), ((-0.04, 0.11), (0.05, 0.16))]
)
def test_the_least_margin_on_a_path_and_when(ends):
    path = fb.line(*ends, 1.0)
    for start, end in ((0.0, 1.0), (0.2, 0.9)):
        t = np.linspace(start, end, 40001)
        pose = fb.igm(UNEQUAL, path(t)[0], (-1, 1))
        margins = np.abs([*pose.sines, pose.det_A]).min(axis=0)
        least, time = module._smallest(
            UNEQUAL, path, (-1, 1), np.linspace(start, end, module.SAMPLES)
        )
        assert margins.min() - 1e-7 <= least <= margins.min() and time == pytest.approx(
            t[margins.argmin()], abs=1e-4
        )


def test_what_is_no_path():
    def path(*shapes):
        def motion(t):
            return tuple(np.zeros((len(t), n)) for n in shapes)

        motion.duration = 1.0
        return motion

    for wrong in (path(2, 2), path(2, 2, 3), path(2, 2, 2, 2)):
        with pytest.raises(
            ValueError, match=r"for times \(n,\) it must give xi, xi_dot and xi_ddot, each \(n, 2\)"
        ):
            _finite(wrong)(T)
    still = _finite(path(2, 2, 2))
    assert (still.start, still.duration) == (0.0, 1.0) and _times(still) == (0.0, 1.0, 0.0)
    moving = _finite(
        fb.line((0.0, 0.1), (0.06, 0.02), 2.0)
    )  # a quintic's largest: 10 / sqrt(3) of the way over T^2
    assert _times(moving) == pytest.approx((0.0, 2.0, 10 / np.sqrt(3) * 0.1 / 4), rel=1e-5)
    for start, duration in (
        (np.inf, 1.0),
        (np.nan, 1.0),
        (0.0, np.inf),
        (0.0, np.nan),
        (0.0, 0.0),
        (0.0, -1.0),
    ):
        still.start, still.duration = start, duration
        with pytest.raises(ValueError, match=f"the duration > 0, not {start}, {duration}"):
            _times(still)
    with pytest.raises(ValueError, match="with a duration, not 3"):
        _finite(3)
