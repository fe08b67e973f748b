"""The steps to the largest disc on figures of which all is known, and where a trajectory breaks what is kept."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.constraints.disc import (
    _equidistant,
    _feet,
    _largest_kept_radius,
    _polished,
    clearance_at,
)
from fivebar.constraints.violations import broken
from tests.helpers.curves import backwards, ellipse, polygon

ROBOT = fb.FiveBar()


def figure(*loops, punctures=(), **own):
    points = np.array(punctures, dtype=complex)
    return SimpleNamespace(
        boundary=loops, punctures=np.stack([points.real, points.imag], axis=-1), **own
    )


def test_the_room_of_a_point_is_its_distance_from_all():
    """From an ellipse, a hole, walls and a puncture: of each the nearest point by a dense sampling."""
    loops = ellipse(0.3, 0.2, cuts=(0, 3, 2 * np.pi)), backwards(ellipse(0.02, 0.02, 0.1))
    wall = polygon(-0.1 + 0.1j, 0.1j)
    part = figure(*loops, punctures=[-0.1 - 0.05j], walls=wall[:1])
    t = np.linspace(0, 2 * np.pi, 40001)
    around = np.concatenate(
        [
            0.3 * np.cos(t) + 0.2j * np.sin(t),
            0.1 + 0.02 * np.exp(1j * t),
            [-0.1 - 0.05j],
            0.1j - 0.1 * np.linspace(0, 1, 20001),
        ]
    )
    z = np.random.default_rng(1).uniform(-0.2, 0.2, (25, 2)) @ (1, 0.6j)
    np.testing.assert_allclose(
        [clearance_at(part, each) for each in z],
        [np.abs(around - each).min() for each in z],
        atol=2e-9,
    )
    assert clearance_at(part, -0.1 - 0.04j) == pytest.approx(0.01, rel=1e-14)
    for each in (0.1, -0.1):  # off a corner, where it is a distance from an end, and beside an arc
        assert clearance_at(figure(polygon(0, 1, 1j)), each * 1j + 0.3) == pytest.approx(
            0.1, rel=1e-14
        )


def test_feet_are_what_is_within_and_ends_twice():
    """Of a square from a point near its lower left corner: two sides, their common end, and a puncture."""
    part = figure(polygon(0, 1, 1 + 1j, 1j), punctures=[0.3 + 0.3j])
    feet = _feet(part, 0.1 + 0.2j, 0.25)
    assert [(distance, None if arc is None else arc.z[0]) for distance, arc, _ in feet] == [
        (pytest.approx(0.1), 1j),
        (pytest.approx(0.2), 0),
        (pytest.approx(np.sqrt(0.05)), None),
    ]
    assert [where for *_, where in feet] == pytest.approx([0.8, 0.1, 0.3 + 0.3j])
    corner = _feet(part, -0.1 - 0.1j, 0.2)
    assert [arc is None for _, arc, _ in corner].count(True) == 2 and len(corner) == 4
    assert {where for *_, arc, where in ((d, a, w) for d, a, w in corner) if arc is None} == {0}
    many = figure(polygon(0, 1, 1 + 1j, 1j), polygon(0.1, 0.9, 0.9 + 0.9j, 0.1 + 0.9j))
    nearest = [distance for distance, *_ in _feet(many, 0.4 + 0.45j, 2.0)]
    assert nearest == pytest.approx([0.3, 0.4, 0.45, 0.45, 0.45, 0.5])  # of eight


def test_a_point_as_far_from_all_feet():
    """A triangle's incircle, its circumcircle by three points, one between a side and a point, two sides opposite."""
    a, b, c = 0, 4, 3j
    sides = [(arc, 0.5) for arc in polygon(a, b, c)]
    assert _equidistant(0.8 + 1.1j, 1.0, sides) == pytest.approx(1 + 1j, abs=1e-13)
    corners = [(None, complex(each)) for each in (a, b, c)]
    assert _equidistant(1.7 + 1.2j, 2.5, corners) == pytest.approx(2 + 1.5j, abs=1e-13)
    moved = [(None, 5 + complex(each)) for each in (a, b, c)]
    assert _equidistant(6.7 + 1.2j, 2.5, moved) == pytest.approx(7 + 1.5j, abs=1e-13)
    tiny = [(None, 1e-4 * complex(each)) for each in (a, b, c)]
    assert _equidistant(1.7e-4 + 1.2e-4j, 2.5e-4, tiny) == pytest.approx(2e-4 + 1.5e-4j, abs=1e-16)
    # Between parallel sides it goes across only.
    below, above = polygon(0, 1, 1 + 1j, 1j)[::2]
    assert _equidistant(0.3 + 0.4j, 0.6, [(below, 0.3), (above, 0.7)]) == pytest.approx(
        0.3 + 0.5j, abs=1e-9
    )
    assert _equidistant(0.02 + 0.4j, 0.6, [(sides[0][0], 0.01), (None, 1j)]) == pytest.approx(
        0.5j, abs=1e-12
    )
    assert _equidistant(0.3 + 0.4j, 0.5, [(None, 0j), (None, 1j)]) == pytest.approx(0.5j, abs=1e-12)
    small, large = ellipse(1, 1, 3), ellipse(4, 4)
    found = _equidistant(-1.1 + 0.05j, 3.0, [(large[0], 3.1), (small[0], 3.1)])
    assert found == pytest.approx(-1, abs=1e-12)
    # An arc is where its parameter says; a step farther than the room is none.
    (curved,) = ellipse(2, 1)
    both = [(curved, 1.4), (curved, -1.6)]
    assert _equidistant(0.1 + 0.05j, 1.0, both) == pytest.approx(0, abs=1e-10)
    assert _equidistant(0.8 + 1.1j, 0.1, sides) == 0.8 + 1.1j


def test_polished_centres():
    """The centre of a circle in a triangle; of an ellipse; between a border and a puncture."""
    triangle = figure(polygon(0, 4, 3j))
    for start in (0.95 + 0.97j, 1.04 + 1.02j, 1 + 0.93j):
        assert _polished(triangle, start) == pytest.approx(1 + 1j, abs=1e-12)
    whole = figure(ellipse(2, 1))
    assert _polished(whole, 0.02 + 0.01j) == pytest.approx(0, abs=1e-9)
    holed = figure(polygon(0, 4, 4 + 4j, 4j), punctures=[2 + 2j])
    # As far from two sides and the middle: r = 4 - 2 sqrt(2).
    assert clearance_at(holed, _polished(holed, 1.15 + 1.16j)) == pytest.approx(
        4 - 2 * np.sqrt(2), rel=1e-12
    )


def test_the_radius_up_to_which_all_is_kept():
    def kept(allowed, clearance=1.0, z=0.3 + 0.1j):
        return _largest_kept_radius(
            SimpleNamespace(allowed=lambda points: allowed(points - z)), z, clearance
        )

    for clearance in (1.0, 0.2):
        assert kept(lambda w, clearance=clearance: np.abs(w) <= clearance, clearance) == clearance
        for degrees in (0, 10, 90.5, 359.5):
            along = np.exp(1j * np.radians(degrees))
            for part in (0.3, 0.995, 0.002):
                found = kept(
                    lambda w, along=along, part=part, clearance=clearance: (
                        (w / along).real < part * clearance
                    ),
                    clearance,
                )
                assert found == pytest.approx(part * clearance, rel=1e-9)
        ring = kept(
            lambda w, clearance=clearance: (
                (np.abs(w) < 0.4 * clearance) | (np.abs(w) > 0.505 * clearance)
            ),
            clearance,
        )
        assert ring == pytest.approx(0.4 * clearance, rel=1e-9)
    assert kept(lambda w: np.abs(w) > 1) < 1e-9


def test_a_clearance_that_no_disc_keeps_is_named():
    with pytest.raises(ValueError, match="clearance of 0.25 m"):
        fb.largest_disc(fb.aspect(fb.FiveBar(), 7), fb.Constraints(clearance=0.25))


def path(*heights):
    """Up and down through heights at even times from 0 to 1, along a polynomial, at x = 0."""
    times = np.linspace(0, 1, len(heights))
    curve = np.polynomial.Polynomial.fit(
        times, heights, len(heights) - 1, domain=(-1, 1), window=(-1, 1)
    )
    return curve, lambda t: (np.stack([0 * t, curve(t)], axis=-1),)


def check(own, times, *planes):
    constraints = fb.Constraints(half_planes=planes)
    return broken(ROBOT, own, (-1, -1), constraints, np.asarray(times, dtype=float))


def test_what_a_path_breaks_first_and_worst():
    """y = 0.1 - 0.08 t (1 - t): lowest, 0.08, at t = 0.5."""
    curve, own = path(0.1, 0.08, 0.1)
    dense = np.linspace(0, 1, 201)
    (only,) = check(own, dense, (0, 1, 0.085))
    start = (1 - np.sqrt(1 - 4 * 0.015 / 0.08)) / 2
    assert (only.what, only.time) == ("0 x + 1 y >= 0.085 m", pytest.approx(start, abs=1e-13))
    assert (only.by, only.worst) == (pytest.approx(0.005, rel=1e-12), pytest.approx(0.5, abs=1e-6))
    # Two of them by the time they break first; what is kept is not named.
    found = check(own, dense, (0, 1, 0.085), (0, 1, 0.09), (0, 1, 0.0799))
    assert [each.what for each in found] == ["0 x + 1 y >= 0.09 m", "0 x + 1 y >= 0.085 m"]
    # Broken at the start: it begins there. Broken at the end only, and at the last time.
    assert check(own, dense, (0, 1, 0.11))[0][1:] == pytest.approx((0.0, 0.03, 0.5), abs=1e-6)
    (late,) = check(path(0.1, 0.09, 0.08)[1], dense, (0, 1, 0.085))
    assert late[1:] == pytest.approx((0.75, 0.005, 1.0), abs=1e-9)
    # No more than rounding is nothing.
    assert check(own, dense, (0, 1, 0.08)) == () == check(own, dense, (0, 1, 0.08 + 2e-16))


@pytest.mark.parametrize("count", (11, 12, 28))
@pytest.mark.parametrize("shift", (0.0, 0.3, 0.5, 0.98))
def test_a_graze_between_samples_is_found(count, shift):
    """Lower than is kept for a moment, at any place between samples, the first and the last two too."""
    times = np.linspace(0, 1, count)
    for at in (0, 1, count // 2, count - 2):
        middle = times[at] + shift * times[1]

        def own(t, middle=middle):
            return (np.stack([0 * t, 0.08 + 0.3 * (t - middle) ** 2], axis=-1),)

        (graze,) = check(own, times, (0, 1, 0.08 + 1e-8))
        assert graze.by == pytest.approx(1e-8, rel=1e-6) and graze.worst == pytest.approx(
            middle, abs=1e-5
        )
        assert graze.time == pytest.approx(max(middle - np.sqrt(1e-8 / 0.3), 0), abs=1e-9)
        assert check(own, times, (0, 1, 0.08 - 1e-9)) == ()


def test_two_grazes_and_what_is_out_of_reach():
    curve, own = path(
        0.09, 0.08, 0.09, 0.08, 0.09
    )  # two of them, symmetric, the first a little less deep
    times = np.linspace(0, 1, 24)

    def tilted(t):
        return (own(t)[0] - np.stack([0 * t, 1e-4 * t], axis=-1),)

    dense = np.linspace(0, 1, 200001)
    heights = tilted(dense)[0][:, 1]
    first, second = heights[:100000].min(), heights.min()
    (both,) = check(tilted, times, (0, 1, first + 1e-9))
    assert both.by == pytest.approx(first + 1e-9 - second, rel=1e-4) and 0.5 < both.worst < 1
    assert both.time < 0.5
    # Where the pose is nan nothing is said: from out of reach, at a height of 0.3, down to 0.
    times = np.linspace(0, 1, 101)
    (low,) = check(
        lambda t: (np.stack([0 * t, 0.3 - 0.3 * t], axis=-1),), times, (0, 1, -0.05), (0, 1, 0.03)
    )
    assert low[1:] == pytest.approx((0.9, 0.03, 1.0), abs=1e-9)
    # The first pose that there is breaks it already: it begins there.
    constraints, own = (
        fb.Constraints(det_A=0.9),
        lambda t: (np.stack([0 * t, 0.3 - 0.3 * t], axis=-1),),
    )
    (first,) = broken(ROBOT, own, (-1, -1), constraints, times)
    assert first.time == times[np.argmax(0.3 - 0.3 * times < np.sqrt(0.18**2 - 0.059**2))]


def test_along_a_thin_aspect_the_largest_disc_is_not_the_first_candidate():
    """Its 23rd candidate leads there; the distance from the loci at its center is found another way."""
    robot = fb.FiveBar(0.034, 0.115, 0.205, 0.04, 0.034)
    thin = [a for a in fb.aspects(robot) if a.working == (1, -1) and abs(a.area - 2.6539e-4) < 1e-7]
    for part in thin:
        disc = fb.largest_disc(part)
        assert abs(disc.radius - 8.26359923e-4) < 1e-12
        distance, *_ = fb.locus_distance(robot, disc.center)
        assert distance <= disc.radius * (1 + 1e-9)  # it may be that of another mode
    assert thin
