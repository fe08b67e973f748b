"""Walls and what is kept beside them, against formulas, the inverse geometric model and rooms along random lines."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.constraints.boundaries import _put, boundaries, facing, polyline, satisfied_at
from fivebar.constraints.constraints import distance_inside
from fivebar.constraints.disc import bounded_by
from fivebar.singularities.leg_circles import size_of
from tests.helpers.curves import polygon

ROBOT, UNEQUAL = fb.FiveBar(), fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)
MODES = (1, 1), (1, -1), (-1, 1), (-1, -1)


def test_facing_parts_end_where_what_is_kept_does_and_have_it_on_their_left():
    """Along the real axis from 0 to 1: above all is kept but from 0.5 to 0.51, below from 0.7 to 0.8 and from 0.998."""
    size, (wall, *_) = 2.0, polygon(0, 1, 1j)

    def allowed(z):
        above = (z.real < 0.5) | (z.real > 0.51)
        below = ((z.real > 0.7) & (z.real < 0.8)) | (z.real > 0.998)
        return np.where(z.imag > 0, above, below)

    for arc in (wall, wall.reversed):
        found = facing([arc], allowed, size)
        ends = sorted(sorted((part.start, part.end)) for part in found)
        np.testing.assert_allclose(ends, [(0, 0.5), (0.51, 0.7), (0.8, 0.998)], rtol=0, atol=1e-12)
        for part in found:
            z, tangent = part.curve((part.start + part.end) / 2)
            across = 1e-3j * tangent / abs(tangent)
            assert allowed(z + across) and not allowed(z - across)
            assert part.locus is wall.locus
    below = facing([wall], lambda z: z.imag < 0, size)
    assert [(part.start, part.end) for part in below] == [(1.0, 0.0)]
    assert facing([wall], lambda z: np.full(z.shape, True), size) == facing([], None, size) == []


def test_how_far_off_a_wall_is_asked():
    """1e-8 of the size of an exact one; of chords of a traced one, as far as it is off them at most."""
    size, asked = 2.0, []

    def allowed(z):
        asked.append(np.abs(z.imag).max())
        return z.imag > 0

    facing(polygon(0, 1, 1j)[:1], allowed, size)
    assert np.ptp(asked) == 0 and asked[0] == pytest.approx(2e-8)
    traced = fb.singularities.regions.LocusArc(
        polyline(np.array([0, 0.1, 0.3, 0.4 + 0j])), 0.0, 3.0
    )
    asked.clear()
    facing([traced], allowed, size)
    assert asked[0] == pytest.approx(0.02 * 0.2)


def test_apolyline_passes_its_points_evenly():
    points = np.array([0, 1, 1 + 2j, 4 + 2j])
    curve = polyline(points)
    s = np.array([0, 0.25, 1, 1.5, 2.5, 3])
    np.testing.assert_allclose(
        curve.at(s) @ (1, 1j), [0, 0.25, 1, 1 + 1j, 2.5 + 2j, 4 + 2j], rtol=1e-15
    )
    np.testing.assert_allclose(curve.tangent(s) @ (1, 1j), [1, 1, 2j, 2j, 3, 3], rtol=1e-15)
    assert curve.interval == (0.0, 3.0)
    np.testing.assert_array_equal(curve.points @ (1, 1j), points)


def test_points_are_put_where_the_room_is_0():
    angle = np.linspace(0, 6, 50)
    for sign in (1, -1):
        z, sound = _put(
            lambda z, sign=sign: sign * (np.abs(z) - 1),
            (1 + 0.2 * np.sin(5 * angle)) * np.exp(1j * angle),
            0.15 * np.exp(1j * angle),
        )
        np.testing.assert_array_equal(sound, np.abs(0.2 * np.sin(5 * angle)) < 0.15)
        np.testing.assert_allclose(np.abs(z[sound]), 1, rtol=1e-11)
        np.testing.assert_allclose(np.angle(z * np.exp(-1j * angle)), 0, atol=1e-14)


@pytest.mark.parametrize("working", MODES)
def test_the_limits_of_joints_are_met_along_their_walls(working):
    joints = ((-1.0, 2.5), (0.5, 4.0))
    found = boundaries(UNEQUAL, working, fb.Constraints(joints=joints))
    assert len(found) == 4
    for arc, limit, leg in zip(found, (-1.0, 2.5, 0.5, 4.0), (0, 0, 1, 1)):
        xi = arc.locus.at(arc.start + np.linspace(0.01, 0.99, 50) * (arc.end - arc.start))
        q = fb.igm(UNEQUAL, xi, working, unreachable="nan").q[:, leg]
        known = np.isfinite(q)
        assert known.sum() > 10
        np.testing.assert_allclose(np.exp(1j * q[known]), np.exp(1j * limit), rtol=0, atol=1e-9)
        # From where the leg is stretched to where it is folded.
        base, l1, l2 = ((-0.05, 0.12, 0.1), (0.05, 0.08, 0.15))[leg]
        np.testing.assert_allclose(
            sorted(np.abs(arc.z[[0, -1]] - base)), (abs(l1 - l2), l1 + l2), rtol=1e-12
        )
    assert len(boundaries(UNEQUAL, working, fb.Constraints(joints=(None, (0.5, 4.0))))) == 2


def test_lines_cross_all_that_is_reached():
    reach = 0.22 + UNEQUAL.d / 2  # of the left leg, from the origin
    planes = [(np.cos(t), np.sin(t), c) for t in (0.3, 2.0, 4.0) for c in (0.0, 0.1)]
    for arc, (a, b, c) in zip(
        boundaries(UNEQUAL, (1, 1), fb.Constraints(half_planes=planes)), planes, strict=True
    ):
        np.testing.assert_allclose(arc.z.real * a + arc.z.imag * b, c, rtol=0, atol=1e-15)
        np.testing.assert_allclose(arc.tangent(arc.s), arc.z[-1] - arc.z[0], rtol=1e-12)
        along = arc.z.imag * a - arc.z.real * b
        assert min(along[0], along[-1]) < -reach and max(along[0], along[-1]) > reach
    far = fb.Constraints(half_planes=[(1, 0, -1e9)])
    assert boundaries(UNEQUAL, (1, 1), far) == ()
    assert (
        len(
            boundaries(
                UNEQUAL, (1, 1), fb.Constraints(half_planes=[(1, 0, 1.9 * size_of(UNEQUAL))])
            )
        )
        == 1
    )
    corners = [(-0.05, 0.05), (0.08, 0.05), (0.02, 0.09)]
    sides = boundaries(UNEQUAL, (1, 1), fb.Constraints(region=corners))
    np.testing.assert_allclose(
        [side.z[0] for side in sides], np.array(corners) @ (1, 1j), rtol=1e-15
    )
    np.testing.assert_allclose(
        [side.z[-1] for side in sides], np.roll(np.array(corners) @ (1, 1j), -1), rtol=1e-15
    )


def test_margins_end_along_walls_where_they_are_met():
    for constraints in (
        fb.Constraints(det_A=0.3),
        fb.Constraints(sin=0.2),
        fb.Constraints(det_A=0.3, sin=0.2),
    ):
        met = set()
        for arc in boundaries(UNEQUAL, (1, -1), constraints):
            xi = arc.locus.at(arc.start + np.linspace(0.1, 0.9, 9) * (arc.end - arc.start))
            pose = fb.igm(UNEQUAL, xi, (1, -1), unreachable="nan")
            rest = np.abs([np.abs(pose.det_A) - 0.3, *(np.abs(sine) - 0.2 for sine in pose.sines)])
            rest = rest[:, np.isfinite(pose.det_A)]
            if rest.size:
                assert rest.min(axis=0).max() < 1e-9
                met |= set(rest.argmin(axis=0).tolist())
        assert met == ({0} if constraints.det_A else set()) | ({1, 2} if constraints.sin else set())
    # A biglide's guides have no walls of sines; nothing kept has none.
    assert boundaries(UNEQUAL, (1, -1), fb.Constraints()) == ()


@pytest.mark.parametrize(
    "robot, working",
    [
        pytest.param(ROBOT, (1, -1), marks=pytest.mark.deep),
        (fb.FiveBar(0.06, 0.1, 0.1, 0.12, 0.05), (1, 1)),
    ],
)
def test_bars_begin_to_touch_at_their_walls_and_nowhere_else(robot, working, monkeypatch):
    monkeypatch.setattr("fivebar.constraints.boundaries.GRID", 121)
    constraints, reach = (
        fb.Constraints(collisions=fb.LinkCollisions(0.01, posts=0.01)),
        robot.l11 + robot.l12,
    )
    found = boundaries(robot, working, constraints)
    for arc in found:
        pose = fb.igm(robot, arc.locus.points, working, unreachable="nan")
        clearances = np.abs(
            np.nan_to_num(list(constraints.collisions.clearances(pose).values()), nan=1.0)
        )
        assert clearances.min(axis=0).max() < 1e-12 and len(arc.z) > 2
    # Along random lines, wherever a room changes its sign a wall is next to it.
    start, end = np.random.default_rng(1).uniform(-reach, reach, (2, 80, 2)) @ (1, 1j)
    z = start[:, None] + np.linspace(0, 1, 1000) * (end - start)[:, None]
    pose = fb.igm(robot, np.stack([z.real, z.imag], axis=-1), working, unreachable="nan")
    bent = np.min(np.abs(pose.sines), axis=0) > 0.3  # there walls are traced to the end of a cell
    points = np.concatenate([arc.z for arc in found])
    step = np.concatenate([np.abs(np.diff(arc.z)) for arc in found]).max()
    values = np.min(list(constraints.collisions.clearances(pose).values()), axis=0)
    row, k = np.nonzero((values[:, :-1] * values[:, 1:] < 0) & (np.abs(np.diff(values)) < 2e-3))
    at = z[row, k][bent[row, k]]
    assert (
        len(at) > 25 and np.abs(at[:, None] - points).min(axis=1).max() < 2 * step
    )  # a corner ends before a cell
    # One that is closed ends where it starts, not a cell of the grid before.
    gaps = np.array(
        [
            abs(arc.z[0] - arc.z[-1]) / np.abs(np.diff(arc.z)).max()
            for arc in found
            if len(arc.z) > 20
        ]
    )
    assert not ((gaps > 0.01) & (gaps < 1.5)).any() and (robot is ROBOT or gaps.min() < 0.01)


def test_an_aspect_with_walls_is_what_is_kept_of_it():
    part, corners = fb.aspect(ROBOT, 1), [(-0.05, 0.05), (0.08, 0.05), (0.02, 0.09)]
    assert bounded_by(part, None) is part
    own = bounded_by(part, fb.Constraints(region=corners))
    assert (own.area, own.boundary, len(own.walls)) == (part.area, part.boundary, 3)
    z = np.random.default_rng(1).uniform(-0.1, 0.15, (200, 2)) @ (1, 1j)
    expected = distance_inside(np.array(corners) @ (1, 1j), z) >= 0
    np.testing.assert_array_equal(
        own.allowed(z)[part.contains(np.stack([z.real, z.imag], -1))],
        expected[part.contains(np.stack([z.real, z.imag], -1))],
    )
    assert satisfied_at(part, fb.Constraints(region=corners))(np.array(0.02 + 0.06j)).tolist() == [
        True
    ]
