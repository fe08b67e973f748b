"""Plans between any two configurations, through singularities of both types, and the ways that they begin from."""

import numpy as np
import pytest

import fivebar as fb
from fivebar import view
from fivebar.models.four_joints import bars_rates, loop_gap
from fivebar.planning.coordinates import bars, tangent
from fivebar.planning.search import ways

ROBOT = fb.FiveBar()
ASPECTS = fb.aspects(ROBOT)
BIGLIDE = fb.Biglide()


def inside(number):
    return fb.igm(ROBOT, ASPECTS[number - 1].point, ASPECTS[number - 1].working)


# By Type 2; by both legs' Type 1 and Type 2; into the smallest aspect; through leg's folds or Type 2.
@pytest.mark.every(4)
@pytest.mark.parametrize("one, other", [(1, 2), (1, 10), (1, 5), (4, 7)])
def test_from_anywhere_to_anywhere(one, other):
    goal = inside(other)
    plan = fb.plan(ROBOT, inside(one), goal, 2.0)
    assert plan.working is None and plan.tried.ways >= 1 and plan.error <= 1e-3
    assert plan(0.0)[0] == pytest.approx(ASPECTS[one - 1].point, abs=1e-12)
    end = plan.accelerations(plan.duration).rates
    assert end.pose.xi == pytest.approx(goal.xi, abs=1e-6) and np.abs(end.q_dot).max() < 1e-5
    assert (end.pose.working == goal.working).all() and end.pose.assembly == goal.assembly
    t = np.linspace(0, 2, 401)
    gaps = np.hypot(*loop_gap(plan.accelerations(t).rates.pose))
    assert gaps.max() <= 1e-5 * ROBOT.l11
    run = fb.simulate(ROBOT, fb.FeedForward(ROBOT, 2.0, 0.2), plan)
    assert run.xi[-1] == pytest.approx(goal.xi, abs=2e-6)
    assert ROBOT.joint_difference(run.q[-1] - goal.q) == pytest.approx(0, abs=2e-5)
    assert {int(event.type) for event in run.events} <= {1, 2} and run.events[-1].after[
        :2
    ] == tuple(goal.working)


@pytest.mark.deep
def test_feed_forward_ends_with_the_plan():
    """The torque that brakes at the goal is not held beyond it."""
    plan = fb.plan(ROBOT, inside(1), inside(2), 2.0)
    run = fb.simulate(ROBOT, fb.FeedForward(ROBOT, 10.0, 0.5), plan, duration=2.5)
    assert np.abs(plan.torques(2.0)).max() > 1e-3
    assert run.xi[-1] == pytest.approx(inside(2).xi, abs=1e-6)


@pytest.mark.deep
@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("free", [True, False])
def test_a_plan_is_its_own_derivative(degree, free):
    """Exactly, in each piece and from one to the next: a difference across a knot errs by the jump of xi'' alone."""
    ends = (inside(1), inside(10)) if free else ((0.09, 0.068), (0.0, -0.05))
    plan = fb.plan(ROBOT, *ends, 2.0, collocation=fb.Collocation(degree=degree))
    pieces, n = plan.pieces, plan.pieces.xi.shape[1]
    k = np.arange(len(pieces.xi) - 1)
    before, after = pieces.motion(k, np.ones(len(k))), pieces.motion(k + 1, np.zeros(len(k)))
    assert np.abs(before - after)[:, : 2 * n].max() < 1e-13 * np.abs(before).max()
    jump = np.abs(before - after)[:, 2 * n : 3 * n].max()
    assert jump > 1e-6  # The bound above would see an acceleration that jumps.
    k, sigma = (
        np.repeat(np.arange(len(pieces.xi)), 5),
        np.tile(np.linspace(0.1, 0.9, 5), len(pieces.xi)),
    )
    t, h = pieces.knots[k] + sigma * pieces.widths[k], 1e-3 * pieces.widths[k]
    for order in (0, 1):
        one, two = (plan(t + j * h)[order] - plan(t - j * h)[order] for j in (1, 2))
        slope = (8 * one - two) / (12 * h[:, None])
        assert slope == pytest.approx(plan(t)[order + 1], abs=1e-9)


def test_two_poses_of_one_aspect():
    """No passage lies between them."""
    start, goal = fb.igm(ROBOT, (0.05, 0.1), (-1, -1)), fb.igm(ROBOT, (-0.03, 0.12), (-1, -1))
    assert fb.routes(ROBOT, start, goal)[0].passages == ()
    plan = fb.plan(ROBOT, start, goal, 1.0)
    assert plan(1.0)[0] == pytest.approx(goal.xi, abs=1e-6)


@pytest.mark.deep
@pytest.mark.parametrize(("start", "goal"), [(3, 4), (1, 10), (2, 9), (5, 8)])
def test_a_tracker_follows_through_both_types(start, goal):
    """With a payload that the plan does not know of, and a limit; in the goal's own pose, elbows too."""
    plan = fb.plan(ROBOT, inside(start), inside(goal), 2.0)
    tracker = fb.Tracker(
        ROBOT, assembly=int(inside(start).assembly), constraints=fb.Constraints(torque=0.2)
    )
    run = fb.simulate(fb.FiveBar(m=0.51), tracker, plan, duration=2.5)
    assert not tracker.log.status.any()
    crossed = {int(event.type) for event in run.events}
    assert crossed == ({2} if (start, goal) == (3, 4) else {1, 2})
    assert np.linalg.norm(run.error[-1]) < 1e-6
    assert ROBOT.joint_difference(run.q[-1] - inside(goal).q) == pytest.approx(0, abs=1e-5)


@pytest.mark.deep
def test_pictures_of_a_plan_between_poses(tmp_path):
    plan = fb.plan(ROBOT, inside(1), inside(10), 2.0, via=[(1.0, inside(3))])
    figure = plan.plot(tmp_path / "plan.png")
    path, *_ = figure.axes
    marks = {
        line.get_label(): line.get_xydata()
        for line in path.get_lines()
        if "crossing" in str(line.get_label())
    }
    margins = dict(zip(("Type 1", "Type 2"), ([0, 1], [2])))
    for kind, own in margins.items():
        for x in marks[f"crossing of {kind}"] / 1e3:
            t = np.linspace(0, 2, 20001)
            acc = plan.accelerations(t)
            near = np.hypot(*(acc.rates.pose.xi - x).T).argmin()
            pose = acc.rates.pose
            assert np.min(np.abs([[*pose.sines, pose.det_A][k][near] for k in own])) < 0.1
    drawn = next(line for line in path.get_lines() if line.get_label() == "via point").get_xydata()
    assert drawn == pytest.approx(1e3 * inside(3).xi[None], abs=1e-6)
    (machine,) = view.scene(
        ROBOT, plan, ["trace", "loci", "torques", "bar-forces", "acceleration"]
    ).machines
    assert {int(event.text.split()[1]) for event in machine.events} == {1, 2}
    away = machine.body.points - plan(machine.frames.start + machine.frames.t)[0][:, None]
    assert (
        np.linalg.norm(away, axis=2).min(axis=1).max() < 1e-9
    )  # one of the joints is the end-effector


@pytest.mark.deep
@pytest.mark.parametrize("one, other", [(1, 3), (2, 6), (8, 5)])
def test_limits_hold_between_nodes_too(one, other):
    square = ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))
    limits = fb.Constraints(torque=0.03, joint_speed=4.0, region=square)
    plan = fb.plan(ROBOT, inside(one), inside(other), 2.0, constraints=limits)
    t = np.linspace(0, 2, 4001)
    assert np.abs(plan.torques(t)).max() <= 0.03 * (1 + 1e-3)
    assert np.abs(plan.joints(t)[1]).max() <= 4.0 * (1 + 1e-3)
    assert np.abs(plan(t)[0]).max() <= 0.2 * (1 + 1e-3)


@pytest.mark.deep
def test_a_point_beside_a_pose_is_reached_in_any_mode():
    goal = (0.0, -0.1)
    plan = fb.plan(ROBOT, inside(9), goal, 2.0)
    assert plan(2.0)[0] == pytest.approx(goal, abs=1e-6)


@pytest.mark.deep
def test_by_way_of_a_pose_and_in_least_time():
    through = inside(3)
    plan = fb.plan(ROBOT, inside(1), inside(4), 3.0, via=[(1.5, through)])
    assert plan(1.5)[0] == pytest.approx(through.xi, abs=1e-5)
    fast = fb.plan(
        ROBOT, inside(1), inside(3), objective="time", constraints=fb.Constraints(torque=0.05)
    )
    assert fast.duration < 2.0 and fast.saturated > 0.5


@pytest.mark.deep
def test_a_biglide_changes_its_mode():
    start, goal = (fb.igm(BIGLIDE, (0.02, 0.2), modes) for modes in ((-1, -1), (-1, 1)))
    plan = fb.plan(BIGLIDE, start, goal, 3.0)
    end = plan.accelerations(3.0).rates.pose
    assert end.q == pytest.approx(goal.q, abs=1e-5) and (end.working == goal.working).all()


def test_ways_close_the_loop_and_end_in_the_pose():
    start, goal = inside(1), inside(10)
    found = ways(ROBOT, start, goal)
    assert found and [way.length for way in found] == sorted(way.length for way in found)
    for path, _ in found:
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
    with pytest.raises(ValueError, match=r"start is a Pose in working modes \(1, 1\), goal in"):
        fb.plan(ROBOT, inside(1), inside(9), 2.0, constraints=fb.Constraints(sin=0.1))
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
