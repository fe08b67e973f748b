"""The steps to the largest rectangle on figures of which all is known: closed forms, dense samples, differences."""

from types import SimpleNamespace

import numpy as np
import pytest

from fivebar.base.backend import pairs
from fivebar.constraints.outline import CORNERS, INWARDS, Outline, _turns, rectangle_distance
from fivebar.constraints.rectangle import (
    _area,
    _around,
    _fitted,
    _grown,
    _off_end,
    _off_piece,
    _point_of_largest_clearance,
    _starts,
)
from fivebar.singularities.locus import Locus
from fivebar.singularities.regions import LocusArc, inside
from tests.helpers.curves import LABEL, TURN, backwards, ellipse, polygon

A, B = 0.3, 0.2


def figure(*loops, area=np.pi * A * B, point=(0.0, 0.0), clearance=B, punctures=(), **own):
    """What an outline asks of an aspect."""
    points = np.array(punctures, dtype=complex)
    return SimpleNamespace(
        boundary=loops,
        area=area,
        point=np.array(point),
        clearance=clearance,
        punctures=pairs(points),
        number=1,
        polygons=tuple(pairs(np.concatenate([arc.z[:-1] for arc in loop])) for loop in loops),
        contains=lambda xi: inside(loops, (xi @ (1, 1j)).ravel()).reshape(xi.shape[:-1]),
        **own,
    )


def oval(margin=0.0, **own):
    return Outline(figure(ellipse(A, B, cuts=(0.1, 2, TURN + 0.1)), **own), margin)


def inscribed(angle, factor=1.0):
    """The borders of the rectangle whose corners have these eccentric angles on the oval."""
    x, y = factor * A * np.cos(angle), factor * B * np.sin(angle)
    return np.array([-x, x, -y, y])


def test_distances_from_a_rectangle():
    v, z = (
        np.array([-1.0, 2.0, 0.5, 1.5]),
        np.random.default_rng(1).uniform(-3, 3, (300, 2)) @ (1, 1j),
    )
    t = np.linspace(0, 1, 3001)
    rim = np.concatenate(
        [-1 + 3 * t + 0.5j, -1 + 3 * t + 1.5j, -1 + 0.5j + 1j * t, 2 + 0.5j + 1j * t]
    )
    within = (z.real > -1) & (z.real < 2) & (z.imag > 0.5) & (z.imag < 1.5)
    brute = np.abs(z[:, None] - rim).min(axis=1) * np.where(within, -1, 1)
    np.testing.assert_allclose(rectangle_distance(z, v), brute, rtol=0, atol=1e-3)
    assert rectangle_distance(np.array([-1 + 1j, -4 - 3.5j]), v).tolist() == [0, 5]


def test_where_an_arc_is_upright_or_level():
    """Of an ellipse turned by 0.4, and of a parabola of three samples that is level at the one between."""
    turn = np.exp(0.4j)

    def curve(t):
        return turn * (A * np.cos(t) + 1j * B * np.sin(t)), turn * (
            -A * np.sin(t) + 1j * B * np.cos(t)
        )

    t = np.linspace(0, TURN, 400)
    arc = LocusArc(Locus(*LABEL, pairs(curve(t)[0]), t, True, curve), 0.0, TURN)
    upright = np.arctan(-B / A * np.tan(0.4)) % np.pi
    level = np.arctan(B / A / np.tan(0.4)) % np.pi
    for own in (arc, arc.reversed):
        np.testing.assert_allclose(
            sorted(_turns(own, np.real)), [upright, upright + np.pi], rtol=1e-14
        )
        np.testing.assert_allclose(sorted(_turns(own, np.imag)), [level, level + np.pi], rtol=1e-14)
    s = np.array([-1.0, 0.0, 1.0])
    parabola = Locus(
        *LABEL, pairs(s + 1j * s * s), s, False, lambda t: (t + 1j * t * t, 1 + 2j * t)
    )
    assert (
        _turns(LocusArc(parabola, -1.0, 1.0), np.imag) == [0.0]
        and _turns(LocusArc(parabola, 0.0, 1.0), np.imag) == []
    )
    assert _turns(LocusArc(parabola, -1.0, 1.0), np.real) == []


def test_pieces_limit_the_corner_that_they_are_beyond():
    for piece, corner in oval().pieces:
        middle = piece.at((piece.start + piece.end) / 2)
        assert corner == (0 if middle.real < 0 else 1, 2 if middle.imag < 0 else 3)
    assert len(oval().pieces) == 6  # two more where arcs meet


def test_what_keeps_a_margin_exactly():
    """Corners on the oval, sides at a margin from a puncture, a side across a place that is not allowed."""
    for angle in (0.3, np.pi / 4, 1.3):
        assert oval().keeps(inscribed(angle, 1 - 1e-12)) and not oval().keeps(
            inscribed(angle, 1 + 1e-12)
        )
    # A point at a margin of a circle; the rounding of what is far from the origin counts too.
    circle, v = (
        Outline(figure(ellipse(B, B, 3.0, cuts=(0, 2, TURN))), 0.05),
        0.15 * np.sqrt(0.5) * -INWARDS,
    )
    for factor, kept in ((1 - 5e-14, True), (1 - 1e-14, False), (1, False), (1 + 1e-11, False)):
        assert circle.keeps(factor * v + [3, 3, 0, 0]) == kept
    # One side may come as near to a puncture as the margin, not nearer.
    near = oval(0.02, punctures=[0.1 + 0.02j])
    box = np.array([-0.1, 0.08, -0.05, 0.05])
    assert near.keeps(box + 1e-12 * INWARDS) and not near.keeps(box - 1e-12 * INWARDS)
    assert not near.keeps(np.array([0.05, 0.15, 0.0, 0.05]))
    assert oval(punctures=[0.08 + 0.02j]).keeps(box)
    outside = np.array([0.35, 0.4, 0.0, 0.05])  # as far off as may be, but not in it
    assert not oval(0.02).keeps(outside)
    box = inscribed(0.8, 0.8)
    places = {
        box[0] + 0j: False,
        box[1] + 0j: False,
        1j * box[2]: False,
        1j * box[3]: False,
        0j: True,
        0.28 + 0j: True,
    }
    for place, kept in places.items():
        walled = oval(walls=(), allowed=lambda z, place=place: np.abs(z - place) > 0.01)
        assert bool(walled.keeps(box)) is kept
        np.testing.assert_array_equal(
            walled.within(np.array([place, 0.1j, 1.0])), [kept and abs(place) > 0.3, True, False]
        )
        assert walled.within(np.array([5.0])).tolist() == [False]


def test_rectangles_are_shrunk_until_they_keep_it():
    outline, best = oval(), inscribed(0.8)
    np.testing.assert_array_equal(outline.shrunk(0.9 * best, 0.01), 0.9 * best + 0.01 * INWARDS)
    grown = outline.shrunk(best - 0.05 * INWARDS, 0.02)
    np.testing.assert_allclose(grown, best - 0.05 * INWARDS + 0.08 * INWARDS, rtol=1e-14)
    assert outline.shrunk(np.array([0.35, 0.45, 0.0, 0.05]), 0.001) is None
    assert outline.shrunk(np.array([-0.01, 0.01, -0.05, 0.05]), 0.0100001) is None
    assert outline.shrunk(np.array([-0.05, 0.05, -0.01, 0.01]), 0.0100001) is None


@pytest.mark.parametrize("margin", [0.0, 0.03])
def test_what_breaks_the_margin_is_named(margin):
    outline = oval(margin, punctures=[0.05 + 0.06j])
    kept = Outline(figure(ellipse(A - margin, B - margin)), 0.0)
    assert (
        kept.aspect.area
        and outline.broken(inscribed(0.8, 0.4) + [0, 0, -0.02, -0.06], 0.0) == set()
    )
    for k, (piece, corner) in enumerate(outline.pieces):
        z, tangent = piece.curve((piece.start + piece.end) / 2)
        touching = z + margin * 1j * tangent / abs(tangent)  # as near as may be
        v = np.zeros(4)
        v[list(corner)] = touching.real, touching.imag
        opposite = [1 - corner[0], 5 - corner[1]]
        v[opposite] = 0.9 * v[list(corner)]
        for off, slack, found in (
            (1e-7, 0.0, {k}),
            (-1e-7, 0.0, set()),
            (1e-7, 1e-6, set()),
            (2e-2, 1e-3, {k}),
        ):
            moved = v.copy()
            moved[list(corner)] -= off * INWARDS[list(corner)]
            assert outline.broken(moved, slack) & {k} == found, (k, off, slack)
            if abs(off) < 1e-3:
                assert outline.broken(moved, slack) == found
    # Ends are named from -1 down; those that come nearer by the slack only are not.
    at = int(np.abs(outline.ends - (0.05 + 0.06j)).argmin())
    beside = np.array([-0.05, 0.05 - margin, 0.05, 0.07])
    for off, slack, found in ((1e-6, 0.0, {-1 - at}), (-1e-6, 0.0, set()), (1e-6, 1e-5, set())):
        assert outline.broken(beside + [0, off, 0, 0], slack) == found


def largest_around(z, points, levels):
    """The largest rectangle around a point of those between levels of y without any of the points in it."""
    best = 0.0
    for top in levels[levels > z.imag]:
        for bottom in levels[levels < z.imag]:
            x = points.real[(points.imag < top) & (points.imag > bottom)]
            left, right = x[x < z.real].max(initial=-1), x[x >= z.real].min(initial=1)
            best = max(best, (right - left) * (top - bottom))
    return best


@pytest.mark.parametrize("seed", range(6))
def test_the_largest_rectangle_around_a_point_is_empty_and_none_is_larger(seed):
    rng = np.random.default_rng(seed)
    frame = np.linspace(-1, 1, 2001)
    points = rng.uniform(-1, 1, (25, 2)) @ (1, 1j)
    points = np.concatenate([points, frame + 1j, frame - 1j, 1 + 1j * frame, -1 + 1j * frame])
    outline = SimpleNamespace(obstacles=points[np.argsort(points.imag)], spacing=1e-3)
    for z in rng.uniform(-0.8, 0.8, (3, 2)) @ (1, 1j):
        best = largest_around(z, points, np.array([-1, *points.imag[:25], 1]))
        for rounds in ({}, {"rounds": 4}):
            v = _around(outline, z, **rounds)
            assert v[0] <= z.real <= v[1] and v[2] <= z.imag <= v[3]
            assert (
                not (rectangle_distance(points, v + 1e-3 * INWARDS) < 0).any()
                and 0.8 * best < _area(v) < best + 8e-3
            )
        # Each of its sides has come to a point.
        assert all(
            (rectangle_distance(points, v - 1.1e-3 * (np.arange(4) == k) * INWARDS) < 0).any()
            for k in range(4)
        )


def test_the_largest_rectangle_between_a_few_points():
    """Beside the level of the point both sides end."""
    beside = np.array([0.1 - 1j, -0.2 - 1e-4j, 0.3 + 1e-4j, 0.1 + 1j])
    v = _around(SimpleNamespace(obstacles=beside, spacing=1e-3), 0.0, rounds=4)
    np.testing.assert_allclose(v, [-0.2, 0.3, -1, 1], rtol=0, atol=1e-3)
    # Exactly at the point's y and x: on the right of it, and above.
    v = _around(
        SimpleNamespace(
            obstacles=np.array([-0.2 - 1j, -0.3 + 0j, 0.0 + 0.5j, 0.25 + 1j]), spacing=1e-3
        ),
        0.0,
        4,
    )
    assert v[0] == pytest.approx(-0.3) and v[1] in (0.0, 0.25) and v[3] <= 1


def test_starts_are_the_largest_and_unlike_one_another():
    starts = _starts(oval(clearance=0.05))
    best = 2 * A * B
    assert 0.99 * best < _area(starts[0]) < 1.03 * best and len(starts) >= 2
    *found, square = starts
    assert np.diff(square)[[0, 2]] == pytest.approx(np.sqrt(2) * B, rel=1e-3)
    np.testing.assert_allclose(square, np.sqrt(0.5) * B * -INWARDS, rtol=1e-12)
    assert all(_area(each) > 0.98 * max(map(_area, found)) for each in found) and len(found) <= 4
    # No square where the roomiest place has no more room than the margin; a smaller one where it has.
    square = _starts(oval(0.05))[-1]
    np.testing.assert_allclose(square, np.sqrt(0.5) * (B - 0.05) * -INWARDS, rtol=1e-12)
    assert _starts(oval(0.2)) == [] or all(np.ptp(each[:2]) > 0 for each in _starts(oval(0.2)))


def test_the_point_of_largest_clearance_of_what_is_kept():
    others = [np.zeros(4)]
    assert _point_of_largest_clearance(oval(point=(0.05, 0.0)), others)[0] == 0.05
    half = oval(walls=polygon(-0.3, 0.3, 1j)[:1], allowed=lambda z: z.imag > 0)
    z, room = _point_of_largest_clearance(half, others)
    assert z.imag == pytest.approx(0.1, abs=0.02) and room == pytest.approx(0.1, abs=0.015)
    # Where the search on samples found nothing, the exact one decides.
    z, room = _point_of_largest_clearance(oval(point=(0.05, 0.0)), [])
    assert abs(z) < 1e-9 and room == pytest.approx(B, rel=1e-12)


@pytest.mark.every(2)
@pytest.mark.parametrize("margin", [0.0, 0.02])
def test_fitted_rectangles_touch_exactly(margin):
    """In the oval 2 a b; with a margin, corners on its parallel curve; in a half of it; off a hole and a puncture."""
    outline = oval(margin)
    v = _fitted(outline, inscribed(0.6, 0.85))
    t = np.linspace(0.5, 1.1, 200_001)
    normal = np.hypot(B * np.cos(t), A * np.sin(t))
    x, y = (
        A * np.cos(t) - margin * B * np.cos(t) / normal,
        B * np.sin(t) - margin * A * np.sin(t) / normal,
    )
    assert _area(v) == pytest.approx((4 * x * y).max(), rel=1e-10) and outline.keeps(v)
    assert _area(v) <= (4 * x * y).max() * (1 + 1e-10)
    holed = oval(margin, punctures=[0.1])
    w = _fitted(holed, np.array([-0.2, 0.08, -0.1, 0.1]) * 0.8)
    assert w[1] == pytest.approx(0.1 - margin, abs=1e-9) and holed.keeps(w)
    assert _fitted(outline, np.array([0.5, 0.6, 0.0, 0.1])) is None
    ring = Outline(figure(ellipse(A, A), backwards(ellipse(0.1, 0.1))), margin)
    w = _fitted(ring, np.array([-0.1, 0.1, 0.13, 0.25]))
    assert w[2] == pytest.approx(0.1 + margin, abs=1e-9)
    height = np.linspace(0.1 + margin, A, 200_001)[:-1]
    best = (
        2 * np.sqrt(np.maximum((A - margin) ** 2 - height**2, 0)) * (height - 0.1 - margin)
    ).max()
    assert _area(w) == pytest.approx(best, rel=1e-10)


def test_growing_goes_no_farther_than_it_may():
    outline, v = oval(), inscribed(0.7, 0.5)
    scale = np.repeat([v[1] - v[0], v[3] - v[2]], 2)
    np.testing.assert_allclose(
        _grown(outline, v, scale, 0.05, []), v - 0.05 * scale * INWARDS, rtol=1e-9
    )
    grown = _grown(outline, v, scale, 2.0, list(range(len(outline.pieces))))
    np.testing.assert_allclose(grown, inscribed(np.pi / 4), rtol=0, atol=1e-6)


def differences(rule, v):
    return [(rule(v + h)[0] - rule(v - h)[0]) / 2e-6 for h in 1e-6 * np.eye(4)]


def test_rules_are_distances_and_their_gradients():
    outline, v = oval(), inscribed(0.7, 0.6)
    for piece, corner in outline.pieces:
        rule = _off_piece(piece, corner)
        middle = piece.at((piece.start + piece.end) / 2)
        own = v.copy()
        own[list(corner)] = 0.95 * middle.real, 0.95 * middle.imag
        distance, gradient = rule(own)
        assert distance == pytest.approx(piece.nearest(np.array([0.95 * middle]))[1][0], rel=1e-12)
        np.testing.assert_allclose(gradient, differences(rule, own), atol=1e-6)
        own[list(corner)] = 1.01 * middle.real, 1.01 * middle.imag
        assert rule(own)[0] == pytest.approx(
            -piece.nearest(np.array([1.01 * middle]))[1][0], rel=1e-12
        )


def test_rules_of_points():
    """The distance from the side that a point is off at the start; with a margin, from a corner where it is off two."""
    start = np.array([-1.0, 2.0, 0.5, 1.5])
    for z in (
        2.3 + 1j,
        -1.2 + 0.7j,
        1 + 1.9j,
        1 + 0.2j,
        2.3 + 1.9j,
        -1.2 + 0.1j,
        2.5 + 0.1j,
        -1.4 + 1.6j,
    ):
        for margin in (0.0, 0.4):
            rule = _off_end(SimpleNamespace(margin=margin), z, start)
            sides = [
                max(start[0] - z.real, z.real - start[1]),
                max(start[2] - z.imag, z.imag - start[3]),
            ]
            corner = margin > 0 and min(sides) > 0
            expected = np.hypot(*sides) if corner else max(sides)
            distance, gradient = rule(start)
            assert distance == pytest.approx(expected, rel=1e-14)
            np.testing.assert_allclose(gradient, differences(rule, start), atol=1e-5)
            for over in (
                0.2,
                3.0,
            ):  # grown over the point: less than 0, by the nearest of the sides
                grown = start - over * INWARDS
                inner = np.array(sides) - over
                distance, gradient = rule(grown)
                if corner and max(inner) > 0:
                    assert distance == pytest.approx(np.hypot(*np.maximum(inner, 0)), rel=1e-13)
                else:
                    assert distance == pytest.approx(
                        max(inner) if corner else max(sides) - over, rel=1e-13
                    )
                np.testing.assert_allclose(gradient, differences(rule, grown), atol=1e-5)
    # At the point itself there is a slope too.
    distance, gradient = _off_end(SimpleNamespace(margin=0.4), 2.5 + 2j, start)(
        start + [0, 0.5, 0, 0.5]
    )
    assert distance == 0 and gradient.tolist() == [0, -0.5, 0, -0.5]
    assert sorted(map(tuple, CORNERS.tolist())) == [(0, 2), (0, 3), (1, 2), (1, 3)]
