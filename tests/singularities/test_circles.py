"""Circles of the legs against the annulus that the other leg reaches, and zeros of functions against closed forms."""

from itertools import product

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.base.backend import as_numbers
from fivebar.singularities.aspects import least_margin
from fivebar.singularities.leg_circles import LegCircles, turn_to
from fivebar.singularities.locus import MODES
from fivebar.singularities.margins import Singularity
from fivebar.singularities.roots import rising_zeros

ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "grashof": fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    "short right leg": fb.FiveBar(0.5, 0.4, 0.1, 0.05, 0.3),
    "short left leg": fb.FiveBar(0.1, 0.05, 0.5, 0.4, 0.3),
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.0),
    "coaxial and equal": fb.FiveBar(0.12, 0.1, 0.1, 0.12, 0.0),
    "nearly coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 1e-9),
    "reach that touches inside": fb.FiveBar(0.2, 0.1, 0.1, 0.1, 0.1),
    "reach that touches outside": fb.FiveBar(0.125, 0.125, 0.1875, 0.0625, 0.5),
    "hole that touches": fb.FiveBar(0.3, 0.1, 0.1, 0.1, 0.4),
    "holes that touch": fb.FiveBar(0.3, 0.1, 0.4, 0.2, 0.4),
    "beyond the other base joint": fb.FiveBar(0.0625, 0.0625, 0.5, 0.125, 0.25),
    "large": fb.FiveBar(30.0, 20.0, 25.0, 35.0, 50.0),
}


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("sin", [0.0, 0.3])
def test_arcs_are_what_the_other_leg_reaches_of_each_circle(name, sin):
    robot = ROBOTS[name]
    own = LegCircles(robot, sin)
    size, legs = own.scale, ((robot.l11, robot.l12), (robot.l21, robot.l22))
    ring = [[abs(a + side * b * np.exp(1j * np.arcsin(sin))) for side in (-1, 1)] for a, b in legs]
    assert np.allclose(
        ring,
        [[own.radius(leg, side) for side in (-1, 1)] for leg in (0, 1)],
        rtol=1e-14,
        atol=1e-17,
    )
    for leg, side in product((0, 1), (1, -1)):
        arcs = [arc for arc in own.pieces if arc.circle == (leg, side)]
        base, other = (-robot.d / 2, robot.d / 2)[:: (1, -1)[leg]]
        angle = np.random.default_rng(1).uniform(-np.pi, np.pi, 400)
        radius = ring[leg][side > 0]
        z = base + radius * np.exp(1j * angle)
        away = np.abs(z - other)
        inner, outer = ring[1 - leg]
        reached = (away > inner) & (away < outer)
        clear = np.minimum(np.abs(away - inner), np.abs(away - outer)) > 1e-9 * size
        s = np.angle((z - base) * (1, -1)[leg]) + 2 * np.pi * np.arange(-1, 2)[:, None]
        within = sum(
            ((arc.interval[0] < s) & (s < arc.interval[1])).sum(axis=0) for arc in arcs
        ) + np.zeros(400)
        if radius > 0:
            np.testing.assert_array_equal(within[clear], reached[clear])
        else:
            assert [arc.interval for arc in arcs] == [(0, 0)] * len(arcs)
            assert len(arcs) == reached.all() or not clear.any()
        for arc in arcs:
            assert (
                arc.type == (Singularity.NONE if sin else Singularity.SERIAL)
                and arc.working == MODES
            )
            assert (
                arc.kind == f"{('left', 'right')[leg]} {'stretched' if side > 0 else 'folded'}"
                and arc.assembly == ()
            )
            t = np.linspace(*arc.interval, 7)
            middle = base + (1, -1)[leg] * radius * np.exp(1j * t)
            np.testing.assert_allclose(arc.at(t) @ (1, 1j), middle, rtol=0, atol=4e-16 * size)
            np.testing.assert_allclose(
                arc.tangent(t) @ (1, 1j), 1j * (middle - base), rtol=0, atol=4e-16 * size
            )
            assert arc.closed == (abs(np.ptp(arc.interval) - 2 * np.pi) < 1e-12)
            assert (len(arc.points) == 1) == (t[0] == t[-1])
            assert bool(arc.vertices) != (arc.closed or len(arc.points) == 1)
            for vertex, t in zip(arc.vertices, arc.interval):
                assert (
                    abs(vertex.z - complex(*arc.at(t))) < 1e-14 * size and len(vertex.circles) == 2
                )
                for which, reach in vertex.circles:  # the end is on both circles
                    gap = abs(vertex.z - (-1, 1)[which] * robot.d / 2) - ring[which][reach > 0]
                    assert abs(gap) < 1e-14 * size
                assert {which for which, _ in vertex.circles} == {0, 1}
    for scale in (2.0**12, 2.0**-9):  # in another unit the same
        lengths = (scale * getattr(robot, side) for side in ("l11", "l12", "l21", "l22", "d"))
        again = LegCircles(fb.FiveBar(*lengths), sin)
        assert [arc.interval for arc in again.pieces] == [arc.interval for arc in own.pieces]
        assert [(v.z / scale, v.circles) for v in again.touches] == [
            (v.z, v.circles) for v in own.touches
        ]
    ends = [(vertex, arc.circle) for arc in own.pieces for vertex in arc.vertices]
    for (one, circle), (two, other) in product(ends, ends):
        if circle[0] != other[0] and abs(one.z - two.z) < 1e-9 * size:
            assert one is two  # what crosses there has one vertex
    assert all(sum(each is vertex for each, _ in ends) == 2 for vertex, _ in ends)


def test_what_only_touches_is_a_point():
    for name, wanted in {
        "reach that touches outside": {(0, 1): [[0, 0]], (1, 1): [[0, 0]]},
        "beyond the other base joint": {(0, 1): [[-0.25, 0]], (1, -1): [[-0.25, 0]]},
    }.items():
        found = {arc.circle: arc.points.tolist() for arc in LegCircles(ROBOTS[name]).pieces}
        assert found.keys() == wanted.keys() and all(
            found[k] == pytest.approx(np.array(wanted[k])) for k in found
        )


def test_a_circle_is_cut_where_it_is_as_far_from_the_other_base_joint():
    rng = np.random.default_rng(2)
    symbols = [casadi.SX.sym(name) for name in ("r", "d", "radius")]
    with as_numbers():
        of_symbols = casadi.Function("turn", symbols, [turn_to(*symbols)])
    for _ in range(50):
        d, radius, angle = rng.uniform(0.1, 2, 3)
        r = abs(radius * np.exp(1j * angle) - d)
        assert turn_to(r, d, radius) == pytest.approx(angle, rel=1e-13)
        assert float(of_symbols(r, d, radius)) == pytest.approx(angle, rel=1e-13)
    for turned in (turn_to, lambda *lengths: float(of_symbols(*lengths))):
        assert turned(0.1 - 1e-17, 0.3, 0.2) == pytest.approx(0, abs=1e-8)
        assert turned(0.5, 0.3, 0.2) == pytest.approx(np.pi, abs=1e-7)
        assert (turned(0.09, 0.3, 0.2), turned(0.6, 0.3, 0.2)) == (
            0.0,
            np.pi,
        )  # of what it does not reach, the nearest


def test_zeros_of_many_functions_are_bracketed_in_few_steps():
    calls = []

    def f(k, t):
        assert k.shape == t.shape
        calls.append(len(k))
        return np.array(
            [
                t - 0.3,
                t**3 - 0.001,
                np.tanh(1e3 * (t - 0.9)),
                np.expm1(20 * t) - 1e-6,
                1 - t + 1,
                t + 1,
                t - 2,
                -1e-12 + 0 * t,
                1e-6 - np.expm1(20 * (1 - t)),
                np.where(t < 0.7, -1.0, 1.0),
                t**9 - 1e-4,
                t - 1e-9,
            ]
        )[k, np.arange(len(k))]

    n = 12
    low, high = np.zeros(n), np.ones(n)
    found = rising_zeros(f, low, high, np.full(n, 1e-15))
    wanted = [
        0.3,
        0.1,
        0.9,
        np.log1p(1e-6) / 20,
        *[np.nan] * 4,
        1 - np.log1p(1e-6) / 20,
        0.7,
        1e-4 ** (1 / 9),
        1e-9,
    ]
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=0)
    assert low.tolist() == [0.0] * n and high.tolist() == [1.0] * n  # as they were given
    assert sum(calls) <= 160  # Illinois: no worse than it has been
    calls.clear()
    rough = rising_zeros(f, low, high, np.full(n, 1e-5))
    assert np.abs(f(np.arange(n), rough)[[0, 1, 2, 10]]).max() <= 1e-5
    assert sum(calls) <= 160
    assert np.isnan(rising_zeros(f, low, high, np.full(n, 2.0))).all()
    assert len(rising_zeros(f, low[:0], high[:0], low[:0])) == 0


def test_a_bend_is_compared_by_the_sine_of_its_difference():
    """|q2| from a stretched leg, pi - |q2| from a folded one, less the angle that is asked."""
    robot = fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)
    draw = np.random.default_rng(1)
    pose = fb.dgm(robot, draw.uniform(-3, 3, (60, 2)), unreachable="nan")
    bent = np.abs(pose.q_passive)
    bent = np.minimum(bent, 2 * np.pi - bent)
    for leg, side, angle in product((0, 1), (1, -1), (0.2, 0.7)):
        # The others keep far more.
        found = least_margin(pose, -2.0, -2.0, {(leg, side): (np.cos(angle), np.sin(angle))})
        from_line = bent[:, leg] if side > 0 else np.pi - bent[:, leg]
        np.testing.assert_allclose(found, np.sin(from_line - angle), atol=1e-12)


def test_a_circle_may_have_an_angle_of_its_own():
    """Its radius is the root of l1^2 + l2^2 +- 2 l1 l2 cos of that angle."""
    robot = fb.FiveBar(0.1, 0.14, 0.09, 0.13, 0.11)
    circles = LegCircles(robot, 0.6, {(1, -1): (0.28, 0.96)})
    for leg, (l1, l2) in enumerate(((0.1, 0.14), (0.09, 0.13))):
        for side in (-1, 1):
            cosine, sine = (0.28, 0.96) if (leg, side) == (1, -1) else (0.8, 0.6)
            assert circles.bend(leg, side) == pytest.approx((cosine, sine))
            radius = np.sqrt(l1**2 + l2**2 + side * 2 * l1 * l2 * cosine)
            assert circles.radius(leg, side) == pytest.approx(radius)
