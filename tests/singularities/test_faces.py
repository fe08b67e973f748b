"""Faces between arcs against areas of circles and polygons, and against the sides on which their points are."""

from itertools import permutations

import numpy as np
import pytest

from fivebar.singularities.faces import _around, _swept, faces
from fivebar.singularities.locus import Vertex, pieces_of
from fivebar.singularities.margins import Singularity
from fivebar.singularities.regions import LocusArc
from tests.helpers.curves import ellipse, polygon

LABEL = (Singularity.PARALLEL, "folded", ((1, 1),), ())


def arc(curve, low, high):
    (locus,) = pieces_of(curve, np.array([low, high]), [LABEL], 1.0)
    return LocusArc(locus, low, high)


def ring(center, radius):
    vertex = Vertex(center + radius)
    return [
        (
            arc(
                lambda t: (center + radius * np.exp(1j * t), 1j * radius * np.exp(1j * t)),
                0,
                2 * np.pi,
            ),
            vertex,
            vertex,
        )
    ]


def side(one, other):
    way = other.z - one.z
    return (arc(lambda t: (one.z + way * t, way + 0 * t), 0.0, 1.0), one, other)


def lens(low, high, bulge):
    """An arc of a parabola from one vertex to another."""
    way = high.z - low.z
    return (
        arc(
            lambda t: (
                low.z + way * (t + 4j * bulge * t * (1 - t)),
                way * (1 + 4j * bulge * (1 - 2 * t)),
            ),
            0.0,
            1.0,
        ),
        low,
        high,
    )


def areas(edges, size=10.0):
    found = faces(edges, size)
    for area, loops in found:
        whole = sum(each.moment for loop in loops for each in loop)
        assert area == pytest.approx(whole, rel=1e-12)
        for loop in loops:
            for before, after in zip(loop, loop[1:] + loop[:1]):
                assert before.z[-1] == pytest.approx(after.z[0], abs=1e-15)
        outlines = [sum((each.moment) for each in loop) for loop in loops]
        assert outlines[0] > 0 and all(own <= 1e-12 for own in outlines[1:])
    return sorted(area for area, _ in found)


def test_rings_in_rings():
    edges = [*ring(0, 3), *ring(1, 1.5), *ring(1, 0.5), *ring(-2, 0.5), *ring(7, 1)]
    wanted = np.pi * np.array([9 - 2.25 - 0.25, 2.25 - 0.25, 0.25, 0.25, 1])
    assert areas(edges) == pytest.approx(sorted(wanted), rel=1e-12)
    found = faces(edges, 10.0)
    assert sorted(len(loops) for _, loops in found) == [1, 1, 1, 2, 3]


def test_a_net_of_sides_with_branches():
    grid = {(i, k): Vertex(complex(i, k)) for i in range(4) for k in range(4)}
    edges = [side(v, grid[i + 1, k]) for (i, k), v in grid.items() if i < 3]
    edges += [side(v, grid[i, k + 1]) for (i, k), v in grid.items() if k < 3]
    assert areas(edges) == pytest.approx([1.0] * 9, rel=1e-12)
    ends = Vertex(0.5 + 0.5j), Vertex(0.3 + 0.6j)  # what hangs free in a face bounds nothing
    free = [*edges, side(*ends), side(grid[1, 1], Vertex(1.2 + 1.3j))]
    assert areas(free) == pytest.approx([1.0] * 9, rel=1e-12)
    assert areas([*edges, *ring(1.5 + 1.5j, 0.25)]) == pytest.approx(
        sorted([*[1.0] * 8, 1 - np.pi / 16, np.pi / 16]), rel=1e-12
    )


def test_arcs_with_one_tangent_at_a_vertex_are_told_apart():
    """Bulges of a chord of 2: 2 / 3 of their height times the chord lies between."""
    low, high = Vertex(-1 + 0j), Vertex(1 + 0j)
    edges = [lens(low, high, bulge) for bulge in (0.2, 0.1, 0.0, -0.05, -0.3)]
    assert areas(edges) == pytest.approx(
        sorted(np.array([0.1, 0.1, 0.05, 0.25]) * 2 * 2 * 2 / 3), rel=1e-12
    )
    touching = Vertex(0j)
    circles = []
    for radius in (1.0, 0.5, 0.8, -0.6):  # all touch the y axis in 0
        circles.append(
            (
                arc(
                    lambda t, r=radius: (r - r * np.exp(1j * t), -1j * r * np.exp(1j * t)),
                    0,
                    2 * np.pi,
                ),
                touching,
                touching,
            )
        )
    wanted = np.pi * np.array([1 - 0.64, 0.64 - 0.25, 0.25, 0.36])
    assert areas(circles) == pytest.approx(sorted(wanted), rel=1e-12)


def test_slivers_are_no_faces_and_a_small_part_is_a_hole():
    low, high = Vertex(-1 + 0j), Vertex(1 + 0j)
    sliver = [lens(low, high, bulge) for bulge in (1e-14, 0.0)]
    assert areas(sliver) == []
    for size in (0.1, 10.0):  # a face is more than 1e-12 of its square
        for share, count in ((3, 1), (1 / 3, 0)):
            assert (
                len(
                    areas(
                        [lens(low, high, share * 1e-12 * size**2 * 3 / 8), lens(low, high, 0.0)],
                        size,
                    )
                )
                == count
            )
    edges = [*ring(0, 3), *sliver, *ring(2j, 1e-9)]
    assert areas(edges) == pytest.approx([9 * np.pi], rel=1e-12)
    ((_, loops),) = faces(edges, 10.0)
    assert len(loops) == 3  # what is in it bounds it, however small: with the face on its left
    for center in (2j, 0.3 + 0.7j, -1.1 - 0.2j, -0.4 + 1.3j):
        ((_, (_, (around,))),) = faces([*ring(0, 3), *ring(center, 1e-9)], 10.0)
        assert np.angle(around.tangent(around.start)) == pytest.approx(-np.pi / 2)
    # Arcs meet to rounding only, which about the origin is more than a triangle of 1e-9 bounds.
    for center, seed in zip(1.3 * np.exp(1j * np.arange(12)), range(12)):
        draw = np.random.default_rng(seed)
        corners = [Vertex(complex(center + 1e-9 * (corner - 1 - 1j))) for corner in (0, 4, 3j)]
        small = []
        for one, other in zip(corners, corners[1:] + corners[:1]):
            ends = [
                Vertex(end.z + complex(*draw.normal(scale=1e-15, size=2))) for end in (one, other)
            ]
            small.append((side(*ends)[0], one, other))
        ((_, (_, (first, second, _))),) = faces([*ring(0, 3), *small], 10.0)
        one, two = first.z[-1] - first.z[0], second.z[-1] - second.z[0]
        assert (one.conjugate() * two).imag < 0  # clockwise


@pytest.mark.parametrize("size", [10.0, 0.1])
def test_a_sliver_whose_sides_rounding_exchanged_is_no_hole(size):
    """Two chords of a lens in a ring: at both ends the one is above, but on the whole below."""
    low, high = Vertex(-0.1 * size + 0j), Vertex(0.1 * size + 0j)
    way = high.z - low.z

    def dented(depth):
        """Between it and the chord lies -0.19 depth way^2."""

        def curve(t):
            s = t * (1 - t)
            y, slope = 0.72 * s - 9.3 * s * s, (0.72 - 18.6 * s) * (1 - 2 * t)
            return low.z + way * (t + 1j * depth * y), way * (1 + 1j * depth * slope)

        return arc(curve, 0.0, 1.0), low, high

    depth = 5e-13 * size**2 / (0.19 * abs(way) ** 2)
    edges = [
        *ring(0, 0.4 * size),
        lens(low, high, 0.3),
        lens(low, high, -0.3),
        lens(low, high, 0.0),
        dented(depth),
    ]
    found = faces(edges, size)
    half = 0.2 * abs(way) ** 2
    assert sorted(area for area, _ in found) == pytest.approx(
        [half, half, np.pi * 0.16 * size**2 - 2 * half], rel=1e-10
    )
    assert sorted(len(loops) for _, loops in found) == [1, 1, 2]


def cyclic(order, first):
    return order[order.index(first) :] + order[: order.index(first)]


@pytest.mark.parametrize("order", [*permutations(range(3))])
@pytest.mark.parametrize("reach", [1, -1])
def test_a_locus_that_ends_on_a_circle_does_so_on_the_side_that_its_leg_reaches(order, reach):
    """Inside of a stretched leg's, outside of a folded one's: at an angle, or so flatly that it is the circle."""
    tip = 2 * np.exp(0.7j)
    (circle,) = ellipse(2, 2, cuts=(0.7, 2.0), circle=(0, reach))
    (before,) = ellipse(2, 2, cuts=(0.1, 0.7), circle=(0, reach))
    (flat,), (back,) = ellipse(2, 2, cuts=(0.7, 1.5)), ellipse(2, 2, cuts=(0.3, 0.7))
    steep = polygon(tip, tip * (1 - 0.3 * reach + 0.2j), 0)[0]
    for curve in (steep, flat, back.reversed):
        sides = [(circle, curve, before.reversed)[k] for k in order]
        ahead, locus, behind = (order.index(k) for k in range(3))
        wanted = [ahead, locus, behind] if reach > 0 else [ahead, behind, locus]
        assert cyclic(_around(sides, [0, 1, 2], 1.0), ahead) == wanted
        if curve is steep:
            by_angle = sorted(range(3), key=lambda k: np.angle(sides[k].leaves(1e-3) - tip))
            assert cyclic(by_angle, ahead) == wanted
    # Two arcs of circles of both legs say nothing about it: by angles.
    (other,) = ellipse(2, 2, cuts=(0.1, 0.7), circle=(1, 1))
    sides = [
        (circle, polygon(tip, tip * (1 + 0.3 * reach + 0.2j), 0)[0], other.reversed)[k]
        for k in order
    ]
    wanted = [ahead, behind, locus] if reach > 0 else [ahead, locus, behind]
    assert cyclic(_around(sides, [0, 1, 2], 1.0), ahead) == wanted


def test_sides_are_told_apart_on_a_circle_of_a_thousandth_of_the_size_or_a_third_of_the_shortest():
    """One leaves above the real axis and is below it from 0.005 on."""
    crossing = arc(lambda t: (t + 1j * t * (0.005 - t), 1 + 1j * (0.005 - 2 * t)), 0.0, 1.0)
    for size, length, above in (
        (1.0, 1.0, True),
        (4.0, 1.0, True),
        (6.0, 1.0, False),
        (10.0, 1.0, False),
        (10.0, 0.014, True),
        (10.0, 0.019, False),
    ):
        sides = [crossing, polygon(0, length, 1j)[0], polygon(0, -1j, 1)[0], polygon(0, 1j, 1)[0]]
        assert cyclic(_around(sides, [0, 1, 2, 3], size), 2) == (
            [2, 1, 0, 3] if above else [2, 0, 1, 3]
        )
    assert _around(sides, [1, 0], 1.0) == [1, 0]


def test_the_area_that_a_small_loop_sweeps():
    """About its own points, twice what it bounds: of a triangle of 1e-9 far from the origin."""
    corners = 1e-9 * np.array([0, 4, 3j])
    assert _swept(polygon(*corners)) == pytest.approx(12e-18, rel=1e-12)
    assert _swept(polygon(*(corners + 1.0))) == pytest.approx(12e-18, rel=1e-6)
    assert _swept(polygon(*corners[::-1])) == pytest.approx(-12e-18, rel=1e-12)
