"""Parts of the timing of paths, each against the same thing computed in another way."""

import io
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import linprog

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line
from fivebar.paths.timing import jerk, slower, solve
from fivebar.paths.timing.bounds import Bernstein, Stretches
from fivebar.paths.timing.clock import Clock, _stumpff
from fivebar.paths.timing.constraint_rows import ConstraintRows, Limits
from fivebar.paths.timing.lower_bound import (
    _cruise,
    _curves,
    _least_time,
    _parabolas,
    _polygons,
    ceiling,
    duration,
)
from fivebar.paths.timing.mesh import _over_distance, _sign
from fivebar.paths.timing.polygons import _add_friction, _root
from fivebar.paths.timing.reachability import _corners, profile
from fivebar.paths.timing.refusals import refuse_touching, where
from fivebar.paths.timing.slower import _mixture, _slower
from fivebar.paths.timing.solve import Solved, TimingError, _along, _directions, _lowered
from fivebar.paths.timing.timed_path import TimedPath
from tests.helpers.paths_to_time import used

# s by time


@pytest.mark.parametrize("z", [-900.0, -30.0, -0.26, -0.24, -1e-6, 0.0, 1e-6, 0.24, 0.26, 40.0])
def test_stumpffs_functions(z):
    with mpmath.workdps(30):
        terms = range(60 if abs(z) < 100 else 120)
        exact = [
            sum(mpmath.mpf(z) ** j / mpmath.factorial(2 * j + k) for j in terms) for k in range(4)
        ]
    found = _stumpff(np.array([z]))
    np.testing.assert_allclose([float(c[0]) for c in found], [float(c) for c in exact], rtol=1e-11)


def clock_of(smooth=0.0):
    rng = np.random.default_rng(2)
    x = np.array([0.0, 0.02, 0.03, 0.0, 0.01, 0.04, 0.02, 0.0])
    waits = np.array([0.1, 0, 0, 0.2, 0, 0, 0, 0.3])
    return Clock(rng.uniform(0.02, 0.05, 7), x, rng.uniform(-3, 3, 7), waits, smooth)


def place(clock, t):
    k, gone, speed, push = clock.along(t)
    return clock.s[k] + gone, speed, push


@pytest.mark.parametrize("smooth", [0.0, 0.07])
def test_speed_and_change_of_speed_are_derivatives_of_the_place(smooth):
    clock = clock_of(smooth)
    h = 1e-6
    t = np.linspace(0, clock.end, 3001)
    t = t[np.abs(t[:, None] - clock.breaks).min(axis=1) > 2 * h]
    s, speed, push = place(clock, t)
    before, after = place(clock, t - h), place(clock, t + h)
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), speed, atol=1e-8)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), push, atol=1e-5)
    if smooth:
        np.testing.assert_allclose((after[2] - before[2]) / (2 * h), clock.jerk(t), atol=1e-4)
    assert place(clock, clock.end)[0] == pytest.approx(clock.s[-1], abs=1e-12)
    assert place(clock, clock.end + 1.0)[0] == pytest.approx(clock.s[-1], abs=1e-12)
    assert place(clock, 0.0)[0] == 0 and (np.diff(s) > -1e-12).all()
    np.testing.assert_allclose(place(clock, clock.times)[0], clock.s, atol=1e-9)


def test_a_motion_rests_as_long_as_it_waits():
    clock = clock_of()
    assert clock.end == pytest.approx(clock.taken.sum() + clock.waits.sum(), rel=1e-12)
    middle = clock.waits[0] + clock.taken[:3].sum() + 0.1
    for t in (0.05, middle, clock.end - 0.15):
        assert place(clock, np.array(t))[1:] == (0.0, 0.0)
    assert place(clock, np.array(middle))[0] == pytest.approx(clock.s[3])
    k, gone, speed, push = clock.along(np.linspace(0.11, middle - 0.11, 50))
    square = clock.x[k] + 2 * clock.pushes[k] * gone + clock.bent[k] * gone**2
    np.testing.assert_allclose(speed**2, square, rtol=1e-9, atol=1e-12)
    begins = clock.times[:-1]
    edges = np.concatenate([begins, begins + clock.taken])
    assert np.abs(edges[:, None] - clock.breaks).min(axis=1).max() < 1e-12
    assert np.abs(edges - clock.breaks[:, None]).min(axis=1).max() < 1e-12


def test_an_averaged_motion_is_the_mean_of_the_plain_one():
    """Where it rests it does so longer, by the time over which it is averaged."""
    smooth = clock_of(0.07)
    longer = smooth.waits + 0.07 * (smooth.x == 0)
    longer[0] -= 0.07
    plain = Clock(smooth.length, smooth.x, smooth.bent, longer)
    assert smooth.end == pytest.approx(plain.end, rel=1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(400)
    for t in np.linspace(0.02, smooth.end, 23):
        within = t - 0.07 + 0.035 * (1 + nodes)
        mean = (weights * place(plain, within)[0]).sum() / 2
        assert place(smooth, np.array(t))[0] == pytest.approx(mean, abs=2e-8)


def test_times_of_an_averaged_motion_are_known_where_rounding_hides_the_movement():
    """It creeps for days, and the mean is of a moment: each node is passed within that moment."""
    length = np.array([0.05, 0.04, 0.04])
    x = np.array([0.0, 4e-14, 4e-14, 0.0])
    clock = Clock(length, x, np.zeros(3), np.zeros(4), 1e-5)
    begins = np.cumsum(2 * length / (np.sqrt(x[:-1]) + np.sqrt(x[1:])))
    assert (np.abs(clock.times[1:] - begins) < 3e-5).all()


# Stretches of a path


def test_stretches_are_parted_and_cut():
    stretches = Stretches(np.array([0, 0, 1]), np.array([0.0, 0.2, 0]), np.array([0.2, 0.5, 0.3]))
    parts = stretches.parted(np.array([1, 3, 2]))
    assert parts.piece.tolist() == [0, 0, 0, 0, 1, 1] and len(parts) == 6
    np.testing.assert_allclose(parts.first, [0, 0.2, 0.3, 0.4, 0, 0.15])
    np.testing.assert_allclose(parts.last, [0.2, 0.3, 0.4, 0.5, 0.15, 0.3])
    pieces = stretches.cut(np.array([2, 0, 2]), np.array([0.2, 0.05, 0.1]))
    assert pieces.piece.tolist() == [0, 0, 0, 1, 1, 1]
    np.testing.assert_allclose(pieces.first, [0, 0.05, 0.2, 0, 0.1, 0.2])
    np.testing.assert_allclose(pieces.last, [0.05, 0.2, 0.5, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(pieces.taken(np.array([4, 1])).length, [0.1, 0.15])


def test_bounds_of_functions_in_bernstein_form():
    value = Bernstein(*(np.array([each]) for each in (1.0, 0.0, 2.0, 0.5, 0.1)))
    assert (value.least(), value.largest(), value.size()) == (-0.35, 2.1, 2.1)
    lower = Bernstein(*(np.array([each]) for each in (-1.0, 0.0, -2.0, 0.5, 0.1)))
    assert (lower.least(), lower.largest(), lower.size()) == (-2.1, 0.35, 2.1)


def test_which_way_a_joint_turns():
    """What is 0 but for rounding at an end has the sign that it has within."""
    none = np.zeros(5)
    value = Bernstein(
        np.array([0.0, 1, -1, -1e-12, 1]),
        np.array([1.0, 1, -1, 1, 0]),
        np.array([2.0, 1, -1, 1, -1]),
        none,
        none,
    )
    assert _sign(value).tolist() == [1, 1, -1, 1, 0]


def test_a_function_over_the_distance_to_its_zero():
    p, q = 0.7, -0.4
    t = np.linspace(0, 1, 5)
    for after in (True, False):
        ends = (0.0, p + q) if after else (p + q, 0.0)
        value = Bernstein(*(np.array([v, 9.0]) for v in (ends[0], p / 2, ends[1], 0.03, 0.01)))
        flags = np.array([after, False]), np.array([not after, False])
        found = _over_distance(value, *flags)
        first, middle, last = (float(each[0]) for each in found[:3])
        here = first * (1 - t) ** 2 + 2 * middle * t * (1 - t) + last * t**2
        np.testing.assert_allclose(here, p + q * (t if after else 1 - t), atol=1e-15)
        assert (found.bend[0], found.slack[0]) == (0.0, pytest.approx(0.04))
        assert [each[1] for each in found] == [9.0] * 5


# Limits and searches


def test_limits_times_a_share():
    limits = Limits((1.0, 2.0), (3.0, 4.0), (5.0, 6.0), 7.0, 8.0, 9.0, (10.0, 11.0), (12.0, 13.0))
    assert limits.times(0.5) == Limits(
        (0.5, 1.0), (3.0, 4.0), (2.5, 3.0), 7.0, 4.0, 9.0, (5.0, 5.5), (12.0, 13.0)
    )
    assert limits.times(0.5, speeds=True) == Limits(
        (1.0, 2.0), (1.5, 2.0), (5.0, 6.0), 3.5, 8.0, 9.0, (10.0, 11.0), (6.0, 6.5)
    )
    assert Limits().times(0.5) == Limits() and not Limits(speed=1.0, jerk=2.0).forces
    for name in ("torque", "joint_acceleration", "acceleration"):
        assert Limits.of(fb.Constraints(**{name: 2.0})).forces
    motors = Limits.of(fb.Constraints(motors=fb.Motor(2.0, 5.0)))
    assert motors.stall == (2.0, 2.0) and motors.no_load == (5.0, 5.0)


@pytest.mark.parametrize("largest", [True, False])
def test_corners_of_polygons_are_those_of_linear_programs(largest):
    rng = np.random.default_rng(4)
    n, rows = 10, 9
    angle = rng.uniform(0, 2 * np.pi, (n, rows))
    p, q = np.cos(angle), np.sin(angle)
    inside = rng.uniform(0.3, 0.7, (n, 2))
    r = -(p * inside[:, :1] + q * inside[:, 1:]) - rng.uniform(0.01, 0.3, (n, rows))
    p = np.concatenate([p, np.full((n, 1), -1.0)], axis=1)
    q = np.concatenate([q, np.zeros((n, 1))], axis=1)
    r = np.concatenate([r, np.zeros((n, 1))], axis=1)
    x1 = _corners(-r / p, -q / p, p > 0, p < 0, np.ones(n), largest)
    for k in range(n):
        sign = -1.0 if largest else 1.0
        table = np.stack([p[k], q[k]], axis=1)
        best = linprog([sign, 0.0], table, -r[k], bounds=[(0, None), (0, 1)])
        x0 = -(r[k] + q[k] * x1[k]) / p[k]
        value = x0[p[k] > 0].min() if largest else x0[p[k] < 0].max()
        if best.status == 0:
            assert value == pytest.approx(best.x[0], abs=1e-8)


def test_a_mixture_takes_the_wanted_time():
    length = np.array([0.1, 0.2, 0.1])
    none = np.zeros(3)
    fast = SimpleNamespace(x=np.array([0, 0.4, 0.6, 0.0]), bent=none + 0.1)
    slow = SimpleNamespace(x=np.array([0, 0.1, 0.05, 0.0]), bent=none)
    x, bent, time = _mixture(length, fast, slow, 1.9)
    assert time.sum() == pytest.approx(1.9, rel=1e-9)
    np.testing.assert_allclose(time, duration(length, x[:-1], x[1:], bent), rtol=1e-12)
    w = bent[0] / 0.1
    np.testing.assert_allclose(x, w * fast.x + (1 - w) * slow.x, rtol=1e-12)


def test_directions_in_which_an_acceleration_is_limited():
    along = np.array([0.3, np.pi - 0.01])
    both = _directions(along)
    even = np.arange(16) * np.pi / 8 - np.pi
    assert (np.abs(both[:, None] - even[:, None]).min(axis=0) < 1e-12).all()
    assert (np.diff(both, axis=0) >= 0).all() and both.shape == (23, 2)
    assert (np.abs(both) <= np.pi).all()
    for k, angle in enumerate(along):
        for beside in (-0.15, -0.01, 0.0, 0.04):
            turn = (both[:, k] - angle - beside + np.pi) % (2 * np.pi) - np.pi
            assert np.abs(turn).min() < 1e-12
    g, m, k = np.array([2.0]), np.array([0.5]), np.array([3.0])
    mesh = SimpleNamespace(
        stretches=SimpleNamespace(length=np.array([0.5])),
        found={name: SimpleNamespace(middle=v) for name, v in zip("gmk", (g, m, k))},
    )
    angle = _along(mesh, SimpleNamespace(x=np.array([1.0, 3.0])))  # u = 2, x = 2
    assert angle == pytest.approx(np.arctan2(3 * 2, 2 * 2 + 0.5 * 2))


# The lower bound


@pytest.mark.parametrize(
    "x0, x1, bent",
    [
        (0.3, 0.7, 1.5),
        (0.2, 0.2, -3.0),
        (0, 0.5, -0.4),
        (0.1, 0.2, 1e-9),
        (0.1, 0.2, 2e-6),
        (0.1, 0.2, -2e-6),
    ],
)
def test_the_time_over_a_stretch(x0, x1, bent):
    h = 0.4
    slope = (x1 - x0) / h - bent * h

    def pace(root):  # s = root^2, so that a start from rest is no pole
        s = root * root
        return 2 * root / math.sqrt(x0 + slope * s + bent * s * s)

    exact = quad(pace, 0, math.sqrt(h), epsabs=1e-13, limit=200)[0]
    assert duration(h, x0, x1, bent) == pytest.approx(exact, rel=1e-9)


def test_a_stretch_that_takes_for_ever():
    assert duration(0.4, 0.0, 0.0, 0.0) == math.inf
    assert duration(0.4, 0.01, 0.01, 1.0) == math.inf  # it comes to rest within
    assert duration(0.4, 0.04001, 0.04001, 1.0) < math.inf
    assert duration(0.4, 0.0, 0.16, 1.0) == math.inf and duration(0.4, 0.0, 0.16, 0.5) < math.inf
    assert duration(0.4, 0.16, 0.16, 0.0) == pytest.approx(1.0)


def random_rows(rng, count, n, friction):
    """Rows with a > 0 on n stretches, each open by bend and slack."""
    parts = {
        "a": rng.uniform(1.0, 3.0, (3, count, n)),
        "b": rng.uniform(-2, 2, (3, count, n)),
        "v": friction * rng.uniform(-0.5, 0.5, (3, count, n)),
        "c": rng.uniform(-2, -1, (3, count, n)),
    }
    bend = {name: rng.uniform(0, 0.02, (count, n)) for name in parts}
    slack = {name: rng.uniform(0, 0.01, (count, n)) for name in parts}
    return ConstraintRows(parts, bend, slack, np.full(count, "joint"))


@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_no_motion_passes_a_parabola(friction):
    """Along it the row's left side is above 0, whatever is left open by bend and slack."""
    rng = np.random.default_rng(5)
    n = 300
    rows = random_rows(rng, 1, n, friction)
    x0, h = rng.uniform(0.05, 1.0, n), rng.uniform(0.01, 0.1, n)
    high = x0 + rng.uniform(0.5, 0.6, n)
    high[::3] = np.inf
    u0, u1, end = (each[0] for each in _curves(_parabolas(rows, h, high), x0, h))
    t = np.linspace(0, 1, 101)[:, None]
    powers = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2])
    x = x0 + h * (2 * u0 * t + (u1 - u0) * t**2)
    u = u0 + (u1 - u0) * t
    assert end == pytest.approx(x[-1], rel=1e-12) and (x < high).all()
    sizes = {"a": u, "b": x, "v": np.sqrt(x), "c": np.ones_like(x)}
    left, most = 0.0, 0.0
    for name, size in sizes.items():
        value = (rows.parts[name] * powers).sum(axis=0)
        left = left + value * size
        most = most + (rows.slack[name] + rows.bend[name] * t * (1 - t)) * np.abs(size)
    assert (left - most > 0).all()
    # It is hardly more above than it needs to be.
    assert np.median((left - most).min(axis=0)) < 0.2 + 0.2 * friction


def test_polygons_leave_out_no_end_of_a_parabola():
    """Forwards and backwards; where x grows faster than the stretch is long, they bound nothing."""
    rng = np.random.default_rng(7)
    n, h = 50, np.full(50, 0.05)
    rows = random_rows(rng, 6, n, 0.0)
    back = rng.random((6, n)) < 0.5
    parabolas = _parabolas(rows, h, np.full(n, np.inf))
    table = _polygons(parabolas, h, back, np.full(n + 1, 2.0))
    assert table.shape == (n, 8, 3)
    for start in np.linspace(0, 1.5, 7):
        end = _curves(parabolas, start, h)[2]
        ends = np.where(back, end, start), np.where(back, start, end), np.ones_like(end)
        left = (table[:, :6] * np.transpose(ends, (2, 1, 0))).sum(axis=-1)
        assert (left <= 1e-15).all() and np.median(left) > -0.01
    rows.parts["a"][:] = 1.0
    rows.parts["b"][:] = -30.0
    table = _polygons(_parabolas(rows, h, np.full(n, np.inf)), h, back, np.full(n + 1, 2.0))
    assert not table[:, :6].any()
    assert (table[:, 6:] == [[1.0, 0.0, -2.0], [-1.0, 0.0, 0.0]]).all()


def test_x_at_the_nodes_is_that_of_parabolas_from_node_to_node():
    """Nowhere below that one by one, and hardly above; in the same way backwards."""
    rng = np.random.default_rng(8)
    n = 40
    rows = random_rows(rng, 3, n, 0.0)
    rows.bend["v"][:] = rows.slack["v"][:] = 0.0
    top = rng.uniform(0.3, 2.0, n + 1)
    rest = np.isin(np.arange(n + 1), [0, 17])
    h = rng.uniform(0.01, 0.1, n)
    high = np.full(n, np.inf)
    found = ceiling(rows, h, top, high, rest)
    parabolas = _parabolas(rows, h, high)
    ends = np.maximum(found.x[:-1], found.x[1:])
    assert (found.high >= ends * (1 - 5e-3)).all() and (found.high < ends + 1.0).all()
    expected = [0.0]
    for k in range(n):
        end = _curves(parabolas[..., k], expected[-1], h[k])[2].min()
        expected.append(0.0 if rest[k + 1] else min(end, top[k + 1]))
    assert found.stuck is None and (found.x >= np.array(expected) * (1 - 1e-12)).all()
    np.testing.assert_allclose(found.x, expected, rtol=5e-3)
    assert (found.x < top).sum() > 5 and np.isfinite(found.size).all()
    turned = rows.turned(np.ones(n, dtype=bool))
    mirrored = turned._replace(
        **{
            name: {part: values[..., ::-1] for part, values in getattr(turned, name).items()}
            for name in ("parts", "bend", "slack")
        }
    )
    other = ceiling(mirrored, h[::-1], top[::-1], high, rest[::-1])
    np.testing.assert_allclose(other.x[::-1], found.x, rtol=1e-9)
    np.testing.assert_allclose(other.time[::-1], found.time, rtol=1e-9)


def test_the_least_time_below_two_curves():
    """One rises from the start, one to the end backwards: that of the slower one."""
    h, curves = 0.5, ((0.1, 1.0, 1.4), (0.2, 1.2, 0.9))
    s = np.linspace(0, h, 200_001)
    times = []
    for x, u0, u1 in curves:
        times.append(np.trapezoid(1 / np.sqrt(x + 2 * u0 * s + (u1 - u0) / h * s**2), s))
    start, u0, u1 = np.array(curves).T[..., None]
    h = np.array([h])
    end = start + h * (u0 + u1)
    assert _least_time(start, u0, u1, end, h) == pytest.approx(max(times), rel=1e-6)
    free = np.array([[1.0], [np.nan]])
    assert _least_time(start, u0 * free, u1 * free, end * free, h) == pytest.approx(
        times[0], rel=1e-6
    )
    assert _least_time(start, *np.full((3, 2, 1), np.nan), h) == 0.0


def test_the_least_time_of_cruising():
    """Not above the integral of sqrt(w / -c), and near it."""
    rng = np.random.default_rng(3)
    w = rng.uniform(1.0, 1.3, (3, 2, 20))
    c = np.full((3, 2, 20), -2.0)
    bend, slack = rng.uniform(0, 0.01, (2, 2, 20))
    alone = ConstraintRows(
        {"b": w, "c": c}, {"b": bend}, {"b": slack}, np.array(["speed", "speed"])
    )
    length = rng.uniform(0.1, 0.2, 20)
    t = np.linspace(0, 1, 501)
    powers = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2])
    least = np.tensordot(w, powers, (0, 0)) - slack[..., None] - bend[..., None] * t * (1 - t)
    exact = (np.trapezoid(np.sqrt(least / 2), t, axis=-1) * length).max(axis=0)
    found = _cruise(alone, length)
    assert (found <= exact * (1 + 1e-6)).all() and (found > 0.93 * exact).all()


# The search


def polygons_of(rng, n):
    """Rows p x0 + q x1 + r <= 0: growth and fall of x are limited, the more the faster it is."""
    table = np.zeros((n, 4, 3))
    table[:, 0] = np.stack([rng.uniform(-1.0, -0.8, n), np.ones(n), rng.uniform(-1, -0.2, n)], 1)
    table[:, 1] = np.stack([np.ones(n), rng.uniform(-1.0, -0.8, n), rng.uniform(-1, -0.2, n)], 1)
    table[:, 2] = np.stack([np.ones(n), np.zeros(n), rng.uniform(-4, -1, n)], 1)
    table[:, 3] = [-1.0, 0.0, 0.0]
    return table / np.abs(table[..., :2]).sum(axis=-1, keepdims=True)


def test_no_motion_within_polygons_is_faster():
    """Against the linear program, of which x is the largest at all nodes at once."""
    rng = np.random.default_rng(11)
    n = 30
    rest = np.isin(np.arange(n + 1), [0, 12, n])
    for _ in range(5):
        found = polygons_of(rng, n)
        top = rng.uniform(1.0, 3.0, n + 1)
        x, stuck = profile(found, top, rest)
        chain = np.zeros((n, 4, n + 1))
        at = np.arange(n)
        chain[at, :, at], chain[at, :, at + 1] = found[..., 0], found[..., 1]
        bounds = [(0.0, 0.0 if still else each) for each, still in zip(top, rest)]
        rows = chain.reshape(-1, n + 1)
        most = linprog(-np.ones(n + 1), rows, -found[..., 2].ravel(), bounds=bounds).x
        assert not stuck and (rows @ x + found[..., 2].ravel() <= 1e-9).all()
        np.testing.assert_allclose(x, most, atol=1e-6)


def test_where_a_motion_may_not_be_too_slow():
    """It must be fast enough here and there, also just after its start: against the linear program."""
    rng = np.random.default_rng(13)
    n = 12
    rest = np.isin(np.arange(n + 1), [0, n])
    feasible = 0
    for _ in range(30):
        found = polygons_of(rng, n)
        slow = rng.random(n) < 0.5
        least = np.stack([-np.ones(n), -rng.uniform(0.5, 2, n), rng.uniform(0.1, 1.0, n)], axis=1)
        found[slow, 3] = (least / np.abs(least[:, :2]).sum(axis=1, keepdims=True))[slow]
        top = rng.uniform(0.5, 2.0, n + 1)
        x, stuck = profile(found, top, rest)
        chain = np.zeros((n, 4, n + 1))
        at = np.arange(n)
        chain[at, :, at], chain[at, :, at + 1] = found[..., 0], found[..., 1]
        bounds = [(0.0, 0.0 if still else each) for each, still in zip(top, rest)]
        rows = chain.reshape(-1, n + 1)
        most = linprog(-np.ones(n + 1), rows, -found[..., 2].ravel(), bounds=bounds)
        assert (most.status == 0) == (not stuck)
        if not stuck:
            feasible += 1
            np.testing.assert_allclose(x, most.x, atol=1e-6)
    assert 5 < feasible < 25


def test_a_part_in_which_a_polygon_is_empty_is_told_by_a_node():
    rng = np.random.default_rng(12)
    found = polygons_of(rng, 30)
    rest = np.isin(np.arange(31), [0, 12, 20, 30])
    top = np.full(31, 2.0)
    whole, _ = profile(found, top, rest)
    found[15, 3] = [-1.0, 0.0, 1.9]  # it may not be slower than that
    x, stuck = profile(found, top, rest)
    assert len(stuck) == 1 and 12 <= stuck[0] <= 20
    flat = found.copy()
    flat[15, 3] = [0.0, -1.0, 1.9]  # nor where it leads to
    flat[25, 3] = [0.0, 0.0, 1.0]  # never
    nothing, two = profile(flat, top, rest)
    assert len(two) == 2 and 20 <= min(two[0], 25) and not nothing[12:].any()
    assert (x[:13] == whole[:13]).all() and (x[20:] == whole[20:]).all() and not x[12:21].any()


def test_slower_at_another_pace_or_not_at_all():
    time = np.array([0.5, 0.5])
    fast = SimpleNamespace(time=time, x=np.array([0.0, 4.0, 0]), bent=np.array([1.0, 2.0]))
    fast._replace = lambda **changes: SimpleNamespace(**changes)
    mesh = SimpleNamespace(found={}, crossing=np.array([False, True, False]), s=np.arange(3.0))
    mesh.place = lambda k: f"node {k}"
    slow = _slower(mesh, fast, 2.0)
    assert slow.time.sum() == pytest.approx(2.002) and slow.x[1] == pytest.approx(4 / 2.002**2)
    np.testing.assert_allclose(slow.bent, fast.bent / 2.002**2)
    mesh.found = {"c1": None}
    with pytest.raises(TimingError, match="takes 2 s of moving: .* Type 2 at node 1 at speed") as e:
        _slower(mesh, fast, 2.0)
    assert e.value.s == 1.0 and not e.value.proved
    mesh.crossing[:] = False
    assert _slower(mesh, fast, 2.0).time.sum() == pytest.approx(2.002)


@pytest.mark.parametrize("least", [0.0, 0.3])
def test_a_motion_in_a_given_time_has_the_least_share_of_the_limits(least, monkeypatch):
    """Of motions that go with the root of the share; none is found below `least`: then x as large as needed."""
    length, x = np.full(4, 0.1), np.array([0.0, 0.02, 0.03, 0.02, 0.0])
    above = SimpleNamespace(time=np.zeros(4))
    seen = []

    def solved(share):
        bent = share * np.array([0.0, -0.2, 0.1, 0.0])
        parts = zip(length, share * x[:-1], share * x[1:], bent)
        return Solved(above, x, share * x, bent, np.array([duration(*part) for part in parts]))

    def limited(mesh, limits, hints):
        seen.append(limits.speed)
        np.testing.assert_allclose(hints[:2], [np.zeros(4), np.full(4, 3 * limits.speed)])
        return solved(limits.speed) if limits.speed > least else None

    mesh = SimpleNamespace(stretches=SimpleNamespace(length=length), found={})
    limits = SimpleNamespace(times=lambda share: SimpleNamespace(speed=share))
    monkeypatch.setattr(slower, "_solved", limited)
    hints = np.zeros(4), np.full(4, 3.0), np.full(4, 0.1)
    monkeypatch.setattr(slower, "hints_of", lambda mesh, known: hints)
    wanted = 2.5 * solved(1.0).time.sum()
    found = slower.slowed(mesh, limits, solved(1.0), wanted)
    assert found.time.sum() == pytest.approx(wanted, rel=1e-9)
    np.testing.assert_allclose(found.x, x / 2.5**2, rtol=1e-9)
    assert seen[0] == pytest.approx(1 / 2.5**2) and len(seen) < 25
    assert min(abs(share - max(least, 1 / 2.5**2)) for share in seen) < 1e-3


def test_stretches_are_split_by_their_share_of_the_gap():
    """The root of it over 0.7 of what each may have, in 4 at most; in halves without a motion."""
    part = np.array([0.0, 1.0, 3.9, 8.9, 100.0, 0.0])
    above = SimpleNamespace(time=np.full(6, 100.0))
    found = SimpleNamespace(time=above.time + part, above=above, stuck=())
    open_ = np.ones(6, dtype=bool)
    assert solve._parts(range(6), found, 0.01 / 0.7, open_).tolist() == [1, 1, 2, 3, 4, 1]
    found.time[:2] = np.inf  # there is no motion yet
    assert solve._parts(range(6), found, 0.01 / 0.7, open_).tolist() == [2, 2, 2, 3, 4, 1]
    found.time[:] = np.inf
    assert solve._parts(range(6), found, 0.1, open_).tolist() == [2] * 6


def test_where_a_path_grazes_type_2_at_a_node():
    side = np.array([1, 1, -1, -1, -1, 1, 1])
    mesh = SimpleNamespace(
        found={"D": SimpleNamespace(first=side, last=side)},
        side=side,
        crossing=np.isin(np.arange(8), [2, 4, 5]),
        rest=np.zeros(8, dtype=bool),
        path=DRAWING,
        s=np.linspace(0, DRAWING.length, 8),
        place=lambda k: f"node {k}",
        share=lambda name, k: 1.0,
    )
    with pytest.raises(fb.SingularityError, match=re.escape(where(DRAWING, mesh.s[4]))):
        refuse_touching(mesh)
    mesh.crossing[4] = False
    refuse_touching(mesh)
    mesh.share = lambda name, k: 1.0 if name == "b" or k < 5 else 0.0
    with pytest.raises(fb.SingularityError, match="runs along the distal bars .* node 5, and"):
        refuse_touching(mesh)


def test_shares_below_the_speed_on_type_2():
    """The first of each part from rest to rest is lowered least, or with falling growth most."""
    tied = np.zeros(13, dtype=bool)
    tied[[2, 6, 9]] = True
    mesh = SimpleNamespace(tied=tied)
    part = np.array([0] * 8 + [1] * 4)
    shares = list(_lowered(mesh, part))
    assert len(shares) == 9 and {len(each) for each in shares} == {12}
    number = np.array([0] * 5 + [1] * 3 + [0] * 4)
    np.testing.assert_allclose(shares[0], 1e-4 * np.ones(12))
    np.testing.assert_allclose(shares[1], 1e-4 * 3.0**number)
    last = np.array([1] * 8 + [0] * 4)
    np.testing.assert_allclose(shares[2], 1e-4 * 3.0 ** (last - number))
    np.testing.assert_allclose(shares[6], 1e-2)
    mesh.tied = np.arange(13) == 5
    assert len(list(_lowered(mesh, part))) == 3


# A timed path


DRAWING = fb.Placement((-0.02, 0.1))(
    Path(
        (Line((0, 0), (0.02, 0)), Line((0.02, 0), (0.03, 0.01)), Line((0.03, 0.01), (0.01, 0.01))),
        pen=(True, False, True),
        dwells={0.0: 0.25, 0.02: 0.5},
    )
)


def timed(pace=1.0, smooth=0.0):
    """Each line in two halves, from rest to rest."""
    lengths = [piece.length for piece in DRAWING.pieces]
    first = np.array([share * length for length in lengths for share in (0, 0.5)])
    x = np.array([0, 0.01, 0, 0.02, 0, 0.01, 0])
    none = np.zeros(7, dtype=bool)
    piece = np.repeat(np.arange(3), 2)
    options = (np.zeros(6), 0.5, none, x, x, smooth, pace)
    return TimedPath(fb.FiveBar(), DRAWING, (-1, -1), Limits(speed=1.0), piece, first, x, *options)


@pytest.mark.parametrize("pace", [1.0, 2.0])
def test_a_timed_path_by_hand(pace):
    motion = timed(pace)
    lengths = np.array([0.02, 0.01 * np.sqrt(2), 0.02])
    moving = 2 * lengths / np.sqrt([0.01, 0.02, 0.01]) * pace
    begins = 0.25 + np.array([0, moving[0] + 0.5, moving[0] + 0.5 + moving[1]])
    assert motion.duration == pytest.approx(0.75 + moving.sum())
    assert motion.gap == pytest.approx(motion.duration / 0.5 - 1)
    middles = begins + moving / 2
    np.testing.assert_allclose(motion.times[[1, 3, 5]], middles)
    np.testing.assert_allclose(motion.times[[0, 2, 4]], begins)
    np.testing.assert_allclose(
        motion.s,
        np.repeat(np.cumsum([0, *lengths]), 2)[1:]
        - np.array([0, 1, 0, 1, 0, 1, 0]) * np.repeat(lengths, [2, 2, 3]) / 2,
    )
    xi, xi_dot, xi_ddot = motion(middles)
    for k, piece in enumerate(DRAWING.pieces):
        way = np.subtract(piece.end, piece.start) / lengths[k]
        np.testing.assert_allclose(xi[k], np.add(piece.start, piece.end) / 2, atol=1e-15)
        np.testing.assert_allclose(
            xi_dot[k], way * np.sqrt([0.01, 0.02, 0.01])[k] / pace, atol=1e-15
        )
    early = motion(middles - 1e-3)[2]
    push = np.array([0.01, 0.02, 0.01]) / lengths / pace**2
    np.testing.assert_allclose(np.linalg.norm(early, axis=1), push)
    rests = np.array([0.1, begins[1] - 0.2])
    assert (motion(rests)[1] == 0).all() and (motion(rests)[2] == 0).all()
    # A rest belongs to what comes after it.
    ends = begins[1] - 0.5, begins[2]
    t = np.array([0.0, ends[0] - 1e-6, ends[0] + 1e-6, ends[1] - 1e-6, ends[1] + 1e-6, 99.0])
    assert motion.pen(t).tolist() == [True, True, False, False, True, True]
    pose = fb.igm(motion.robot, xi, (-1, -1))
    rates = fb.ikm(pose, xi_dot)
    q, q_dot = motion.joints(middles)
    np.testing.assert_allclose(q, pose.q)
    np.testing.assert_allclose(q_dot, rates.q_dot)
    tau = fb.inverse_dynamics(fb.ikm2(rates, xi_ddot))
    np.testing.assert_allclose(motion.torques(middles), tau)
    assert motion.tool is None
    assert repr(motion) == (
        f"<TimedPath: {lengths.sum():.6g} m, {motion.duration:.6g} s, proved: no less than 0.5 s,"
        " working (-1, -1)>"
    )


@pytest.mark.parametrize("rate", [100.0, 7.0])
def test_rows_of_a_timed_path(rate):
    motion = timed()
    file = io.StringIO()
    motion.to_csv(file, rate)
    head, names, *lines = file.getvalue().splitlines()
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    t = rows[:, 0]
    assert t[-1] == motion.duration and (np.diff(t[:-1]) == pytest.approx(1 / rate))
    assert 0 < t[-1] - t[-2] <= 1 / rate * (1 + 1e-9)
    assert names.split(",")[:7] == ["t", "x", "y", "x_dot", "y_dot", "x_ddot", "y_ddot"]
    np.testing.assert_allclose(rows[:, 1:7], np.hstack(motion(t)), atol=1e-15)
    np.testing.assert_allclose(rows[:, 7:9], motion.joints(t)[0], atol=1e-14)
    np.testing.assert_allclose(rows[:, 9:11], motion.joints(t)[1], atol=1e-12)
    np.testing.assert_allclose(rows[:, 11:13], motion.torques(t), atol=1e-15)
    np.testing.assert_allclose(
        DRAWING(np.clip(rows[:, 13], 0, DRAWING.length))[0], rows[:, 1:3], atol=1e-12
    )
    assert (rows[:, 14] == motion.pen(t)).all()
    assert '"lower_bound": 0.5' in head and '"speed": 1.0' in head
    with pytest.raises(ValueError, match="to_csv: .* s at 1e.09 Hz"):
        motion.to_csv(io.StringIO(), 1e9)


def test_an_averaged_timed_path():
    """It rests longer by the time over which it is averaged, but not before its start."""
    motion, plain = timed(smooth=0.05), timed()
    assert motion.duration == pytest.approx(plain.duration + 3 * 0.05)
    xi, xi_dot, _ = motion(np.array([0.0, motion.duration]))
    np.testing.assert_allclose(xi, [DRAWING.pieces[0].start, DRAWING.pieces[-1].end], atol=1e-12)
    np.testing.assert_allclose(xi_dot, 0, atol=1e-7)
    assert motion.pen(np.array([0.0, motion.duration])).tolist() == [True, True]


def test_times_that_are_no_numbers():
    with pytest.raises(ValueError, match="nan"):
        timed()(np.array([0.1, np.nan]))


@pytest.mark.parametrize("pace", [1.0, 1.25])
def test_a_wanted_duration_with_a_limit_on_jerk(pace, monkeypatch):
    """Only the moving is slowed down: rests stay as long as the path asks for."""
    monkeypatch.setattr(jerk, "_paced", lambda motion: replace(motion, pace=pace))
    plain = replace(timed(), limits=Limits(jerk=10.0))
    fastest = jerk.smoothed(plain, lambda feeds: plain, np.inf)
    wanted = fastest.duration + 0.5
    motion = jerk.in_time(fastest, wanted)
    assert motion.duration == pytest.approx(wanted) and motion.smooth == fastest.smooth
    assert motion.pace / pace == pytest.approx((wanted - 0.75) / (fastest.duration - 0.75))
    with pytest.raises(
        TimingError, match="is less than .* s, the least that was found with this"
    ) as e:
        jerk.in_time(fastest, fastest.duration * 0.99)
    assert not e.value.proved and e.value.s == 0.0
    crossing = replace(timed(), crossing=np.arange(7) == 3)
    with pytest.raises(fb.SingularityError, match="is not known across Type 2, .* at s = 0.027"):
        jerk.smoothed(crossing, lambda feeds: crossing, np.inf)


def curved():
    """Part of a circle in three stretches, averaged."""
    path = Path((Arc((0.0, 0.1), 0.02, 0.3, 2.8),), feed=(0.3,))
    first = np.array([0.0, 0.3, 0.6]) * path.length
    x = np.array([0, 0.02, 0.03, 0])
    bent = np.array([0.0, -8.0, 6.0])
    options = bent, 0.5, np.zeros(4, dtype=bool), x, x, 0.05
    return TimedPath(
        fb.FiveBar(), path, (-1, -1), Limits(), np.zeros(3, dtype=int), first, x, *options
    )


def most_used(motion, name):
    """The largest torque, speed, ... of a motion, from samples; of the jerk by differences."""
    if name == "jerk":
        t = np.linspace(0, motion.duration, 20_001)
        rises = np.linalg.norm(np.diff(motion(t)[2], axis=0), axis=1)
        return float(np.sort(rises)[-20]) / t[1]  # but where it jumps
    if name != "stall":
        return used(motion, {name: 1.0}, 2000)
    acc = motion.accelerations(np.linspace(0, motion.duration, 5001))
    line = fb.inverse_dynamics(acc) / motion.limits.stall
    return np.abs(line + acc.rates.q_dot / motion.limits.no_load).max()


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "name", ["speed", "acceleration", "joint_speed", "joint_acceleration", "torque", "jerk"]
)
def test_a_smooth_motion_goes_at_the_pace_that_one_limit_allows(name):
    limit = 0.4 * most_used(curved(), name)
    pair = name.startswith("joint") or name == "torque"
    limits = {"jerk": 1e9, name: (limit, limit) if pair else limit}
    motion = jerk._paced(replace(curved(), limits=Limits(**limits)))
    above = 1.001 if name == "jerk" else 1  # that of differences
    assert motion.pace > 1.3 and 0.98 * limit < most_used(motion, name) <= above * limit


def test_a_smooth_motion_goes_at_the_pace_of_its_feed_and_of_motors():
    plain = replace(curved(), limits=Limits(jerk=1e9))
    assert most_used(jerk._paced(plain), "speed") == pytest.approx(0.3, rel=1e-3)
    for stall, no_load in ((1e-3, 1e3), (1.0, 2.0), (6e-3, 9.0)):
        both = {"stall": (stall, 2 * stall), "no_load": (no_load, no_load)}
        slow = jerk._paced(replace(plain, limits=Limits(jerk=1e9, torque=(1.0, 1.0), **both)))
        assert most_used(slow, "stall") == pytest.approx(1, rel=1e-3)


@pytest.mark.parametrize("off", [0.0, 0.01])
def test_lines_above_and_below_a_square_root(off):
    """Close to it where the torques are small beside friction: there a tangent, or narrow bounds."""
    n = 4
    v = np.zeros((3, 2, n))
    v[:, 0] = [0.01, 0.5, 0.5, 0.5]
    rows = SimpleNamespace(parts={"v": v}, kind=np.array(["torque", "joint"]))
    near = np.array([0.4, 0.5, 0.6, 0.0, 0.3])
    one = np.ones(n)
    mesh = SimpleNamespace(tied=np.array([True]), found={"D": SimpleNamespace(middle=one)})
    close = np.array([False, True, False, False])  # beside rest x is not close to anything
    lines, low, high = _root(rows, mesh, near, off * one, 2.0 * one)
    for k in range(n):
        (p, q), (p_below, q_below) = lines[:, :, k]
        if close[k] and not off:
            mean = 0.55
            assert p * mean + q == pytest.approx(np.sqrt(mean)) and p == p_below and q == q_below
            assert p == pytest.approx(0.5 / np.sqrt(mean)) and (low[k], high[k]) == (0, 2)
            continue
        x = np.linspace(low[k], high[k], 101)
        assert (p * x + q >= np.sqrt(x) - 1e-12).all()
        assert (p_below * x + q_below <= np.sqrt(x) + 1e-12).all()
        if close[k]:
            assert (low[k], high[k]) == pytest.approx((0.95 * 0.5, 1.05 * 0.6))
            assert (p * x + q - p_below * x - q_below).max() < 0.01
        else:
            assert (low[k], high[k]) == (0, 2)
            assert p * 2 + q == pytest.approx(np.sqrt(2))
    mesh.tied[:] = False
    plain, low, high = _root(rows, mesh, near, off * one, 2.0 * one)
    assert (plain[0, 0] == 0.5 / np.sqrt(2)).all() and not low.any() and (high == 2).all()


def test_viscous_friction_is_bounded_from_above():
    """v sqrt(x) by Bernstein coefficients that are linear in x at both ends."""
    rng = np.random.default_rng(4)
    n, rows = 5, 3
    x0, x1 = rng.uniform(0.2, 1.0, (2, n))
    bent = rng.uniform(-0.1, 0.1, n)
    first, last = np.zeros((2, n, 3))
    first[:, 0] = last[:, 1] = 1.0
    middle = (first + last) / 2
    middle[:, 2] = -bent / 2
    x = np.stack([first, middle, last])
    one = np.zeros((1, n, 3))
    one[..., 2] = 1.0
    high = np.full(n, 1.2)
    touch, wide = np.sqrt(0.6), np.sqrt(high)
    above = np.full(n, 0.5 / touch), np.full(n, touch / 2)
    root = np.array([above, (1 / wide, 0 * wide)])
    v = rng.uniform(-1, 1, (3, rows, n))
    v[:, 0], v[:, 1] = np.abs(v[:, 0]), -np.abs(v[:, 1])
    found = np.zeros((5, rows, n, 3))
    _add_friction(found, v, x, one, root, high)
    values = found @ np.ones(3) * 0 + (found * np.stack([x0, x1, 1 + 0 * x0], axis=1)).sum(axis=-1)
    t = np.linspace(0, 1, 51)
    weights = np.stack([math.comb(4, k) * t**k * (1 - t) ** (4 - k) for k in range(5)])
    bound = np.tensordot(values, weights, (0, 0))
    square = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2])
    place = np.stack([x0, (x0 + x1 - bent) / 2, x1]).T @ square
    exact = np.tensordot(v, square, (0, 0)) * np.sqrt(place)
    assert (bound >= exact - 1e-12).all() and (bound[:2] - exact[:2]).max() < 0.5
    none = np.zeros((5, rows, n, 3))
    _add_friction(none, 0 * v, x, one, root, high)
    assert not none.any()
