"""Arcs and regions bounded by them, on curves of which all is known: closed forms, roots of polynomials, formulas."""

import numpy as np
import pytest

from fivebar.singularities import regions
from fivebar.singularities.regions import (
    LocusArc,
    beside,
    crossings,
    inside,
    off_border,
    points_of_largest_clearance,
    roughly_inside,
)
from tests.helpers.curves import TURN, backwards, ellipse, petals, polygon, uneven_circle

SIZES = 1.0, 1e-3


def test_curves_have_the_shape_of_the_parameters_and_run_forwards():
    (arc,) = ellipse(0.3, 0.2)
    for s in (np.linspace(0, 6, 6).reshape(2, 3), 1.0):
        z, tangent = arc.curve(s)
        np.testing.assert_allclose(z, 0.3 * np.cos(s) + 0.2j * np.sin(s), rtol=1e-15)
        np.testing.assert_allclose(tangent, -0.3 * np.sin(s) + 0.2j * np.cos(s), rtol=1e-15)
        assert z.shape == tangent.shape == np.shape(s)
        for found, expected in zip(arc.reversed.curve(s), (z, -tangent)):
            np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(arc.at(s), z)
        np.testing.assert_array_equal(arc.reversed.tangent(s), -tangent)


def test_dense_points_are_evenly_apart():
    (arc,) = ellipse(2, 2, cuts=(0.3, 2.3))
    for own, first in ((arc, 0.3), (arc.reversed, 2.3)):
        z = own.dense(np.abs(np.diff(own.z)).sum() / 6.001)
        assert len(z) == 7 and z[0] == pytest.approx(2 * np.exp(1j * first), rel=1e-15)
        np.testing.assert_allclose(np.angle(z[1:] / z[:-1]), np.sign(1 - first) * 2 / 7, rtol=1e-4)


def stationary(a, b, z):
    """Angles at which the distance from z has a least value on an ellipse: roots of a polynomial in exp(i t)."""
    x, y = z.real, z.imag
    w = np.roots(
        [b * b - a * a, 2 * (a * x - 1j * b * y), 0, -2 * (a * x + 1j * b * y), a * a - b * b]
    )
    t = np.angle(w[np.abs(np.abs(w) - 1) < 1e-9]) % TURN
    bend = (b * b - a * a) * np.cos(2 * t) + a * x * np.cos(t) + b * y * np.sin(t)
    return t[bend > 0]


def test_feet_are_the_roots_of_a_polynomial():
    rng = np.random.default_rng(1)
    for size in SIZES:
        a, b = size, 0.6 * size
        (arc,) = ellipse(a, b, cuts=(0.3, 5.1))
        near = arc.s[[0, -1]] + 0.7 * (
            arc.s[[1, -2]] - arc.s[[0, -1]]
        )  # nearer to the second and last but one sample
        around = [a * np.cos(t) + 1.3j * b * np.sin(t) for t in [*near, 0.3005, 5.0995]]
        for z in [*(rng.uniform(-1.3, 1.3, (40, 2)) @ (a, 1j * b)), *around]:
            own = stationary(a, b, z)
            slope = (
                (arc.at(np.array([0.3, 5.1])) - z) * arc.tangent(np.array([0.3, 5.1])).conj()
            ).real
            ends = [end for end, leaves in ((0.3, slope[0] >= 0), (5.1, slope[1] <= 0)) if leaves]
            expected = np.sort([*own[(own > 0.3) & (own < 5.1)], *ends])
            for run in (arc, arc.reversed):
                s, distance = run.feet(z)
                np.testing.assert_allclose(s, expected, rtol=0, atol=1e-11)
                np.testing.assert_allclose(distance, np.abs(arc.at(s) - z), rtol=1e-12)
            least, nearest = distance.min(), s[distance.argmin()]
            assert arc.feet(z, least)[0].tolist() == [nearest] == s[distance <= least].tolist()
            (only,), (length,) = arc.nearest(np.array([z]))
            assert (only, length) == pytest.approx((nearest, least), rel=1e-12)


def test_feet_near_a_centre_of_curvature():
    """One on either side of a vertex, hardly nearer than what is between them."""
    (arc,) = ellipse(2, 1, cuts=(-1, 1))
    step = np.diff(arc.s)[len(arc.s) // 2]
    for t in np.linspace(1.05, 3, 14) * step:
        s, _ = arc.feet(complex(1.5 * np.cos(t)), 2.0)
        np.testing.assert_allclose(s, [-t, t], rtol=1e-6)


def test_nearest_on_a_circle_of_uneven_samples():
    arc, rng = uneven_circle(1), np.random.default_rng(2)
    for r, count in ((1 + 1e-12, 100), (0.5, 1500), (1e-5, 40), (3.0, 100)):
        angle = rng.uniform(0, TURN, count)
        s, distance = arc.nearest(r * np.exp(1j * angle))
        np.testing.assert_allclose(distance, abs(1 - r), rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(
            np.angle(np.exp(1j * (s - angle))), 0, rtol=0, atol=1e-9 if r < 0.1 else 1e-14
        )
    assert [each.shape for each in arc.nearest(np.empty(0, dtype=complex))] == [(0,), (0,)]


@pytest.mark.parametrize("turned", [False, True])
def test_an_arc_leaves_a_small_circle_around_its_start(turned):
    (whole,), (circle,) = (
        ellipse(0.3, 0.2, cuts=(1, 4)),
        ellipse(0.2, 0.2, cuts=(1, 1.4), circle=(1, 1)),
    )
    for arc in (whole, circle):
        arc = arc.reversed if turned else arc
        assert arc.extent == pytest.approx(
            0.4 if arc.locus.circle else np.abs(arc.z - arc.z[0]).max(), rel=1e-12
        )
        forwards = 1 if arc.start < arc.end else -1
        for radius in 0.3 * arc.extent * 10.0 ** np.arange(0, -5, -0.25):
            z = arc.leaves(radius)
            s = arc.start + forwards * np.linspace(0, 1.5, 30001)  # a circle's also beyond its end
            first = s[np.argmax(np.abs(arc.at(s) - arc.z[0]) >= radius)]
            assert (
                abs(z - arc.z[0]) == pytest.approx(radius, abs=1e-9)
                and abs(z - arc.at(first)) < 2e-5
            )


def disc(z, center, radius):
    return np.abs(z - center) < radius


HALF = np.pi / 3  # where unit circles around -0.5 and 0.5 meet
REGIONS = {  # size, loops, what is inside
    "petals with a hole": lambda: (
        0.2,
        (petals(0.2, (0, 1, 2.5, TURN)), backwards(ellipse(0.03, 0.03, 0.15, circle=(1, 1)))),
        lambda z: (np.abs(z) < 0.2 * (1 + 0.6 * np.cos(3 * np.angle(z)))) & ~disc(z, 0.15, 0.03),
    ),
    "a lens": lambda: (
        1,
        ((*ellipse(1, 1, -0.5, (-HALF, HALF)), *ellipse(1, 1, 0.5, (np.pi - HALF, np.pi + HALF))),),
        lambda z: disc(z, -0.5, 1) & disc(z, 0.5, 1),
    ),
    "two discs in one": lambda: (
        1,
        (
            (
                *ellipse(1, 1, -0.5, (HALF, TURN - HALF)),
                *ellipse(1, 1, 0.5, (HALF - np.pi, np.pi - HALF)),
            ),
        ),
        lambda z: disc(z, -0.5, 1) | disc(z, 0.5, 1),
    ),
}


@pytest.mark.parametrize("name", REGIONS)
def test_inside_is_what_a_formula_says(name):
    size, loops, formula = REGIONS[name]()
    arcs, rng = [arc for loop in loops for arc in loop], np.random.default_rng(3)
    z = rng.uniform(-1.7, 1.7, (2500, 2)) @ (size, 1j * size)
    found, near = roughly_inside(loops, z)
    np.testing.assert_array_equal(found, crossings(loops, z))
    np.testing.assert_array_equal(found[~near], formula(z[~near]))
    assert near.mean() < 0.05  # of few it takes distances to tell
    np.testing.assert_array_equal(inside(loops, z), formula(z))
    # At the very height of samples, beside the border and corners, on them.
    z = (
        rng.uniform(-1.7, 1.7, 400) * size
        + 1j * rng.choice(np.concatenate([arc.z for arc in arcs]), 400).imag
    )
    np.testing.assert_array_equal(inside(loops, z), formula(z))
    for arc in arcs:
        s = np.sort([arc.start, arc.end, *rng.uniform(*sorted((arc.start, arc.end)), 20)])
        on, tangent = arc.curve(s[1:-1])
        for off in (1e-9, 1e-5, 3e-4, 3e-3):
            z = np.concatenate(
                [on + side * off * 1j * size * tangent / np.abs(tangent) for side in (1, -1)]
            )
            np.testing.assert_array_equal(inside(loops, z), formula(z))
        corner = arc.z[0] + size * (10.0 ** -np.arange(1.5, 9))[:, None] * np.exp(
            1j * (0.05 + np.arange(0, TURN, 0.3))
        )
        np.testing.assert_array_equal(inside(loops, corner.ravel()), formula(corner.ravel()))
        assert not inside(loops, arc.z[[0, len(arc.z) // 2, -1]]).any()


def test_roomiest_points():
    """Of an ellipse its centre, of a thin one too; of petals one in each, and one between walls, where it may be."""
    for a, b, samples in ((0.3, 0.2, 500), (0.3, 6e-4, 500), (0.3, 0.2, 40)):
        ((z, room),) = points_of_largest_clearance(
            (ellipse(a, b, 0.1),), np.empty(0), np.pi * a * b, samples=samples
        )
        assert abs(z - 0.1) < 0.4 * a and b * (1 - 1e-9) < room < b * (
            1.001 if samples == 500 and b > 0.1 else 1.15
        )
    loops, area = (petals(0.2),), 1.18 * np.pi * 0.04
    found = points_of_largest_clearance(loops, np.empty(0), area, 4, samples=2000)
    rooms = [room for _, room in found]
    for z, room in found:
        assert room == pytest.approx(loops[0][0].nearest(np.array([z]))[1][0], rel=1e-3)
    assert sorted(rooms, reverse=True) == rooms and len(rooms) == 4
    angles = np.sort([np.angle(z) % TURN for z, _ in found[:3]])
    np.testing.assert_allclose(np.sin(1.5 * angles), 0, atol=0.05)
    one, _ = points_of_largest_clearance(loops, np.array([found[0][0]]), area)[0]
    assert abs(one - found[0][0]) > 0.05
    # A disc cut by a wall, of which the lower side is allowed only.
    circle, (wall, *_) = ellipse(0.3, 0.3), polygon(-0.3, 0.3, 0.3j)
    ((z, room),) = points_of_largest_clearance(
        (circle,), np.empty(0), np.pi * 0.09, walls=[wall], allowed=lambda z: z.imag < 0
    )
    assert z == pytest.approx(-0.15j, abs=2e-3) and room == pytest.approx(0.15, rel=2e-3)
    # Samples of a circle have one Voronoi vertex; a line there and back has no inside.
    ((z, room),) = points_of_largest_clearance((circle,), np.empty(0), np.pi * 0.09, samples=20)
    assert abs(z) < 1e-12 and room == pytest.approx(0.3, rel=1e-12)
    assert points_of_largest_clearance(((wall, wall.reversed),), np.empty(0), 1e-9) == []


def test_points_beside_a_border(monkeypatch):
    size = 10.0
    loop = ellipse(0.3, 0.3, cuts=(0, 2e-6, 0.2, 2.5, TURN))
    z = beside((loop,), size)
    owner = np.array([arc.nearest(z)[1] for arc in loop]).argmin(axis=0)
    assert owner.tolist() == [1] * 3 + [2] * 3 + [3] * 3  # off all but the shortest
    for k in (1, 2, 3):
        arc = loop[k]
        s, distance = arc.nearest(z[owner == k])
        np.testing.assert_allclose(
            (s - arc.start) / (arc.end - arc.start), (0.2, 0.5, 0.8), rtol=1e-9
        )
        np.testing.assert_allclose(distance, 0.05 * 0.3 * (arc.end - arc.start), rtol=1e-3)
    # Of a crescent 1e-7 thick only halves of its corners are as far from the border: one point is found within.
    thin = 1e-7
    (outer,), (inner,) = ellipse(0.3, 0.3, cuts=(-1.5, 1.5)), ellipse(0.3, 0.3, -thin, (-1.5, 1.5))
    lids = [polygon(a, b)[0] for a, b in ((outer.z[-1], inner.z[-1]), (inner.z[0], outer.z[0]))]
    crescent = ((outer, lids[0], inner.reversed, lids[1]),)
    for z in (beside(crescent, size)[0], off_border(crescent, size)):
        assert abs(z) < 0.3 < abs(z + thin)
    asked = []
    monkeypatch.setattr(regions, "inside", lambda loops, z: asked.append(z) or inside(loops, z))
    beside((ellipse(0.3, 0.3),), size)
    assert not asked


def test_a_point_off_the_border():
    loop = ellipse(0.3, 0.3, 0.2, cuts=(0.3, 1, TURN + 0.3))
    assert off_border((loop,), 1.2) == pytest.approx(0.2, abs=1e-12)
    # From places on the longest arc; past what is on the way, to one that has most room there.
    z = off_border((loop, backwards(ellipse(0.1, 0.1, 0.2))), 1.2)
    assert abs(z - 0.2) == pytest.approx(0.225, abs=1e-9)
    line = polygon(0, 1, 1j)[0]
    with pytest.raises(ArithmeticError, match="inside a face whose border is 2 arcs"):
        off_border(((line, LocusArc(line.locus, 1.0, 0.0)),), 1.0)
