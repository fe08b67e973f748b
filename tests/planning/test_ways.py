"""Ways between poses: where they cross singularities, how they turn, and how long they are."""

from itertools import combinations

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.four_joints import bars_pose, loop_gap
from fivebar.planning.coordinates import bars
from fivebar.planning.problem import PlanError, timed
from fivebar.planning.search import _along, _in_their_modes, _stops, ways, ways_between
from fivebar.singularities.passages import known_aspects

from ..conftest import UNEQUAL

NONE = fb.Constraints()

ROBOT = fb.FiveBar()
BIGLIDE = fb.Biglide()


def inside(robot, number):
    aspect = known_aspects(robot)[number - 1]
    return fb.igm(robot, aspect.point, aspect.working)


@pytest.mark.parametrize(
    "robot, start, goal",
    [
        (UNEQUAL, ((0.05, 0.15), (-1, -1)), ((-0.05, 0.1), (-1, 1))),
        (ROBOT, ((0.05, 0.1), (-1, -1)), ((-0.03, 0.12), (-1, -1))),
        (BIGLIDE, ((0.02, 0.2), (-1, -1)), ((-0.03, 0.22), (-1, 1))),
    ],
)
def test_ways_close_the_loop_and_are_all_different(robot, start, goal):
    begin, end = fb.igm(robot, *start), fb.igm(robot, *goal)
    found = ways(robot, begin, end)
    assert 1 <= len(found) <= 6
    for path, length in found:
        assert path[0] == pytest.approx(bars(begin), abs=1e-9)
        turns = (path[-1] - bars(end)) / (2 * np.pi)
        assert turns == pytest.approx(np.round(turns), abs=1e-9)
        if not robot.turns:
            assert not np.round(turns)[[0, 2]].any()
        steps = np.diff(_along(path))
        assert length == pytest.approx(steps.sum())
        assert np.abs(np.diff(path, axis=0)).max() < 0.7
        assert np.hypot(*loop_gap(bars_pose(robot, tuple(path.T)))).max() < 1e-9
    for one, other in combinations(found, 2):
        assert np.abs(one.path - other.path).max() > 0.3


def test_ways_in_the_modes_of_both_poses_are_straight_and_bent_for_the_tip():
    """Least time under weight was 15 % longer without them."""
    begin, end = fb.igm(ROBOT, (0.05, 0.1), (-1, -1)), fb.igm(ROBOT, (-0.03, 0.12), (-1, -1))
    share = np.linspace(0.0, 1.0, 201)[:, None]
    straight = bars(fb.igm(ROBOT, begin.xi + share * (end.xi - begin.xi), (-1, -1)))
    paths = list(_in_their_modes(ROBOT, begin, end))
    assert len(paths) >= 3
    assert _along(paths[0])[-1] == pytest.approx(_along(straight)[-1], rel=1e-3)
    for path in paths:
        pose = bars_pose(ROBOT, tuple(path.T))
        assert np.hypot(*loop_gap(pose)).max() < 1e-9
        assert (-np.sign(pose.sines) == -1).all()
    other = fb.igm(ROBOT, (-0.03, 0.12), (-1, 1))
    assert not list(_in_their_modes(ROBOT, begin, other))


def test_ways_by_way_of_a_pose_follow_one_another_without_a_jump():
    places = [((0.02, 0.2), (-1, -1)), ((0.0, 0.22), (-1, 1)), ((-0.03, 0.21), (-1, -1))]
    points = [fb.igm(BIGLIDE, *each) for each in places]
    found = ways_between(BIGLIDE, timed(points[0], points[2], 3.0, [(1.2, points[1])]), NONE)
    assert found
    lengths = [length for *_, length in found]
    assert lengths == sorted(lengths)
    for stops, paths, length in found:
        assert [t for _, t in stops] == [0.0, 1.2, 3.0]
        assert len(paths) == 2
        assert paths[1][0] == pytest.approx(paths[0][-1], abs=1e-12)
        assert length == pytest.approx(sum(_along(path)[-1] for path in paths))
        ends = [paths[0][0], paths[0][-1], paths[1][-1]]
        for (conditions, _), end in zip(stops, ends):
            assert conditions[0] == pytest.approx(end, abs=1e-12)
        assert [set(conditions) for conditions, _ in stops] == [{0, 1}, {0}, {0, 1}]
        assert not stops[0][0][1].any() and not stops[-1][0][1].any()


def test_later_paths_are_turned_to_where_the_former_end():
    one = np.zeros((3, 4)) + np.arange(3)[:, None]
    two = one + 2 * np.pi * np.array([1, 0, -1, 0]) + 2.0
    stops, moved = _stops([one, two, two + 4.0], [0.0, 1.0, None, 3.0])
    assert moved[1] == pytest.approx(one + 2.0)
    assert moved[2] == pytest.approx(one + 4.0)
    assert [t for _, t in stops] == [0.0, 1.0, None, 3.0]


@pytest.mark.parametrize("first", [(-0.0789, -0.2324), (-0.0692, -0.1043), (0.0, 0.0)])
@pytest.mark.parametrize("modes", [(1, 1), (-1, -1)])
def test_a_biglide_changes_both_working_modes(first, modes):
    """Its aspects are strips without ends, of which no routes are known."""
    other = fb.igm(BIGLIDE, (-0.0765, 0.1483), modes)
    found = ways(BIGLIDE, fb.igm(BIGLIDE, first, tuple(-mode for mode in modes)), other)
    assert found
    for way in found:
        gap = np.hypot(*loop_gap(bars_pose(BIGLIDE, tuple(way.path.T))))
        assert gap.max() < 1e-9
        assert np.abs(np.diff(way.path, axis=0)).max() < 0.7
        off = way.path[-1] - bars(other)
        turns = np.round(off[1::2] / (2 * np.pi))
        np.testing.assert_allclose(
            off, [0.0, 2 * np.pi * turns[0], 0.0, 2 * np.pi * turns[1]], atol=1e-6
        )


def test_a_point_in_place_of_a_pose_is_reached_in_several_modes():
    found = ways_between(BIGLIDE, timed(fb.igm(BIGLIDE, (0.02, 0.2)), (0.0, 0.22), 2.0, []), NONE)
    modes = set()
    for stops, *_ in found:
        pose = bars_pose(BIGLIDE, tuple(stops[-1][0][0].tolist()))
        assert pose.point == pytest.approx((0.0, 0.22), abs=1e-9)
        modes.add(tuple(-np.sign(pose.sines)))
    assert len(modes) >= 3


def test_poses_that_no_way_joins_are_refused_whatever_the_other_ends():
    apart = fb.FiveBar(0.05, 0.2, 0.05, 0.2, 0.29)
    first = inside(apart, 1)
    other = next(
        pose
        for pose in (inside(apart, each.number) for each in known_aspects(apart))
        if fb.routes(apart, first, pose) == ()
    )
    with pytest.raises(PlanError, match="no motion joins start and goal"):
        ways_between(apart, timed(first, other, 1.0, []), NONE)
