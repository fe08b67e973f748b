"""Plans between any two configurations, through singularities of both types, and the ways that they begin from."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.four_joints import bars_rates, loop_gap
from fivebar.planning.coordinates import bars, tangent
from fivebar.planning.search import ways

ROBOT = fb.FiveBar()
ASPECTS = fb.aspects(ROBOT)
BIGLIDE = fb.Biglide()


def inside(number):
    return fb.igm(ROBOT, ASPECTS[number - 1].point, ASPECTS[number - 1].working)


# By Type 2; by both legs' Type 1 and Type 2; into the smallest aspect; through leg's folds or Type 2.
@pytest.mark.parametrize("one, other", [(1, 2), (1, 10), (1, 5), (4, 7)])
def test_from_anywhere_to_anywhere(one, other):
    goal = inside(other)
    plan = fb.plan(ROBOT, inside(one), goal, 2.0)
    assert plan.working is None and plan.tried >= 1 and plan.error <= 1e-3
    assert plan(0.0)[0] == pytest.approx(ASPECTS[one - 1].point, abs=1e-12)
    end = plan.accelerations(plan.duration).rates
    assert end.pose.xi == pytest.approx(goal.xi, abs=1e-6) and np.abs(end.q_dot).max() < 1e-5
    assert (end.pose.working == goal.working).all() and end.pose.assembly == goal.assembly
    t = np.linspace(0, 2, 401)
    gaps = np.hypot(*loop_gap(plan.accelerations(t).rates.pose))
    assert gaps.max() <= 1e-5 * ROBOT.l11
    run = fb.simulate(ROBOT, fb.FeedForward(ROBOT, 2.0, 0.2), plan)
    assert run.xi[-1] == pytest.approx(goal.xi, abs=2e-6)
    assert ROBOT.differ(run.q[-1] - goal.q) == pytest.approx(0, abs=2e-5)
    assert {int(event.type) for event in run.events} <= {1, 2} and run.events[-1].after[:2] == tuple(goal.working)


def test_feed_forward_ends_with_the_plan():
    """The torque that brakes at the goal is not held beyond it."""
    plan = fb.plan(ROBOT, inside(1), inside(2), 2.0)
    run = fb.simulate(ROBOT, fb.FeedForward(ROBOT, 10.0, 0.5), plan, duration=2.5)
    assert np.abs(plan.tau(2.0)).max() > 1e-3
    assert run.xi[-1] == pytest.approx(inside(2).xi, abs=1e-6)


def test_limits_hold_between_nodes_too():
    limits = dict(torque_limit=0.03, joint_speed_limit=4.0, workspace=((-0.2, 0.2), (-0.2, 0.2)))
    plan = fb.plan(ROBOT, inside(1), inside(3), 2.0, **limits)
    t = np.linspace(0, 2, 4001)
    assert np.abs(plan.tau(t)).max() <= 0.03 * (1 + 1e-3)
    assert np.abs(plan.joints(t)[1]).max() <= 4.0 * (1 + 1e-3)
    assert np.abs(plan(t)[0]).max() <= 0.2 * (1 + 1e-3)


def test_a_point_beside_a_pose_is_reached_in_any_mode():
    goal = (0.0, -0.1)
    plan = fb.plan(ROBOT, inside(9), goal, 2.0)
    assert plan(2.0)[0] == pytest.approx(goal, abs=1e-6)


def test_by_way_of_a_pose_and_in_least_time():
    through = inside(3)
    plan = fb.plan(ROBOT, inside(1), inside(4), 3.0, via=[(1.5, through)])
    assert plan(1.5)[0] == pytest.approx(through.xi, abs=1e-5)
    fast = fb.plan(ROBOT, inside(1), inside(3), objective="time", torque_limit=0.05)
    assert fast.duration < 2.0 and fast.saturated > 0.5


def test_a_biglide_changes_its_mode():
    start, goal = (fb.igm(BIGLIDE, (0.02, 0.2), modes) for modes in ((-1, -1), (-1, 1)))
    plan = fb.plan(BIGLIDE, start, goal, 3.0)
    end = plan.accelerations(3.0).rates.pose
    assert end.q == pytest.approx(goal.q, abs=1e-5) and (end.working == goal.working).all()


def test_ways_close_the_loop_and_end_in_the_pose():
    start, goal = inside(1), inside(10)
    found = list(ways(ROBOT, start, goal))
    assert found
    for path in found:
        rates = bars_rates(ROBOT, tuple(path.T), tuple(np.zeros_like(path).T))
        assert np.hypot(*loop_gap(rates.pose)).max() < 1e-12
        assert np.cos(path[-1] - bars(goal)) == pytest.approx(1)
    free = tangent(ROBOT, bars(goal))
    assert free @ free.T == pytest.approx(np.eye(2), abs=1e-14)


def test_what_cannot_be_asked():
    other = fb.FiveBar(d=0.1)
    stranger = fb.dgm(other, (0.1, 0.2))
    with pytest.raises(ValueError, match="goal is a Pose of another robot"):
        fb.plan(ROBOT, inside(1), stranger, 2.0)
    with pytest.raises(ValueError, match="goal must be one Pose that closes"):
        fb.plan(ROBOT, inside(1), fb.dgm(ROBOT, np.zeros((3, 2))), 2.0)
    with pytest.raises(ValueError, match=r"start is a Pose in working modes \(1, 1\), not in working = \(-1, -1\)"):
        fb.plan(ROBOT, inside(1), inside(9), 2.0, working=(-1, -1))
    with pytest.raises(ValueError, match="serial_margin keeps the working modes"):
        fb.plan(ROBOT, inside(1), inside(9), 2.0, serial_margin=0.1)
    with pytest.raises(fb.UnreachableError):
        fb.plan(ROBOT, inside(1), (0.5, 0.0), 2.0)


def test_where_no_motion_joins_two_poses_that_is_said():
    """A Grashof chain in two circuits: bars that cannot all turn leave two parts of the pose manifold apart."""
    apart = fb.FiveBar(0.05, 0.2, 0.05, 0.2, 0.29)
    found = [fb.igm(apart, each.point, each.working) for each in fb.aspects(apart)]
    for goal in found[1:]:
        if not fb.routes(apart, found[0], goal):
            with pytest.raises(fb.PlanError, match="no motion joins start and goal"):
                fb.plan(apart, found[0], goal, 2.0)
            return
    pytest.fail("all aspects of this robot are joined")
