"""Plans that cannot be asked or found say why, and by how much."""

import time

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning import best_plan
from fivebar.planning import plan as planner
from fivebar.planning import program as transcription
from fivebar.planning.plan import plan
from fivebar.planning.problem import PlanError

from .conftest import HOME, ROBOT, TASK_1, TASK_2, fine


@pytest.mark.deep
def test_too_little_torque_is_named_with_its_amount(fastest):
    with pytest.raises(
        PlanError, match=r"infeasible; violated: torque by 0\.06\d+ N m \(limit 0\.02\)"
    ) as caught:
        plan(ROBOT, HOME, TASK_1, 0.5, constraints=fb.Constraints(torque=0.02))
    needed = (
        0.02 * (fastest.duration / 0.5) ** 2
    )  # exact: without gravity torque goes as 1 / time^2
    assert set(caught.value.violations) == {"torque"}
    assert 0.02 + caught.value.violations["torque"] == pytest.approx(needed, rel=5e-3)
    best = caught.value.plan
    assert best.duration == pytest.approx(0.5) and np.abs(
        best.torques(fine(best))
    ).max() == pytest.approx(needed, rel=5e-3)
    np.testing.assert_allclose(best(0.5)[0], TASK_1, atol=1e-7)


@pytest.mark.deep
def test_too_little_acceleration_is_named_with_its_amount():
    with pytest.raises(PlanError, match=r"infeasible; violated: acceleration by") as caught:
        plan(ROBOT, (0, 0.1), (0, 0.15), 0.3, constraints=fb.Constraints(acceleration=0.1))
    needed = 4 * 0.05 / 0.3**2  # half the way up at full, half down
    assert 0.1 + caught.value.violations["acceleration"] == pytest.approx(needed, rel=0.02)


def test_points_out_of_reach_and_beyond_limits():
    with pytest.raises(
        fb.UnreachableError, match=r"plan: goal: unreachable.*gap 0\.126 m"
    ) as caught:
        plan(ROBOT, HOME, (0, 0.3), 2.0)
    assert caught.value.gap == pytest.approx(np.hypot(0.059, 0.3) - 0.18)
    with pytest.raises(fb.UnreachableError, match=r"via\[0\]"):
        plan(ROBOT, HOME, TASK_1, 2.0, via=[(None, (0.5, 0.1))])
    with pytest.raises(
        PlanError, match=r"goal is on the other side of Type 2 .* det A = -0\.565 there"
    ) as caught:
        plan(ROBOT, HOME, TASK_2, 4.0, constraints=fb.Constraints(det_A=0.1))
    assert caught.value.plan is None and caught.value.violations["det_A"] == pytest.approx(
        0.665, abs=1e-3
    )
    with pytest.raises(PlanError, match="goal itself does not keep region: by 0.01"):
        square = ((-0.1, 0.0), (0.1, 0.0), (0.1, 0.09), (-0.1, 0.09))
        plan(ROBOT, HOME, TASK_1, 2.0, constraints=fb.Constraints(region=square))
    narrow = fb.FiveBar(l11=0.05, l12=0.2, l21=0.05, l22=0.2, d=0.1)
    with pytest.raises(
        PlanError, match=r"not connected in working modes \(-1, -1\).*by 0\.\d+ m near"
    ) as caught:
        plan(narrow, (0, 0.2), (0, -0.2), 2.0)
    assert caught.value.violations["reach"] > 0


def test_no_answer_after_max_time():
    began = time.process_time()
    with pytest.raises(PlanError, match="no solution within max_time = 0.05 s") as caught:
        plan(ROBOT, HOME, TASK_2, 4.0, collocation=fb.Collocation(max_time=0.05))
    assert time.process_time() - began <= 1.0
    np.testing.assert_allclose(caught.value.plan(0.0)[0], HOME, atol=1e-6)


def test_what_did_not_converge_is_not_returned(monkeypatch):
    monkeypatch.setattr(transcription, "MOST_ITERATIONS", 3)
    with pytest.raises(
        PlanError, match="IPOPT did not converge .*Maximum_Iterations_Exceeded"
    ) as caught:
        plan(ROBOT, HOME, TASK_2, 4.0)
    assert (
        caught.value.status == "Maximum_Iterations_Exceeded" and caught.value.plan.duration == 4.0
    )
    monkeypatch.undo()
    monkeypatch.setattr(best_plan, "REFINEMENTS", 1)
    with pytest.raises(
        PlanError,
        match=r"not accurate: error 0\.0\d+ between nodes on 20 intervals, 0\.001 is allowed",
    ):
        plan(ROBOT, HOME, TASK_2, 4.0)


@pytest.mark.parametrize(
    "options, words",
    [
        (dict(duration=0.0), "duration must be finite and > 0"),
        (dict(duration=float("nan")), "duration must be finite"),
        (dict(duration=None), 'needs a weight on "time"'),
        (dict(duration=None, objective="time"), "minimum time needs a torque"),
        (
            dict(
                duration=None, goal=HOME, objective="time", constraints=fb.Constraints(torque=1.0)
            ),
            "start and goal are the same",
        ),
        (dict(objective="speed"), "objective must be of effort, time, jerk"),
        (dict(objective={}), "objective must be of"),
        (dict(objective={"effort": -1.0}), "weight of effort must be finite and >= 0"),
        (dict(objective={"effort": 0.0}), "one weight of the objective must be > 0"),
        (dict(goal=TASK_2, objective="jerk"), "must cross a Type-2 singularity"),
        (dict(goal=(0.0, float("inf"))), "goal, order 0, must be two finite numbers"),
        (dict(goal={1: (0, 0)}), "goal needs a position under order 0"),
        (dict(start={0: HOME, 3: (0, 0)}), "no other orders than 1 and 2"),
        (dict(via=[(3.0, TASK_1)]), r"duration = 2 s is not after the time of via\[0\], 3 s"),
        (
            dict(via=[(1.0, HOME), (0.5, TASK_1)]),
            r"the time of via\[1\] = 0.5 s is not after the time of via\[0\], 1 s",
        ),
        (dict(via=[(1.0,)]), r"via must be \[\(time or None"),
        (dict(via=[TASK_1]), r"via must be \[\(time or None, point\), ...\], not \[\(0"),
        (dict(objective=3), "objective must be of"),
        (dict(goal="ab"), "goal, order 0, must be two finite numbers"),
        (dict(robot=fb.ROBOTS["liu-2006-a"].robot), "no inertia"),
        (dict(constraints=fb.Constraints(jerk=1.0)), "plan: the constraint jerk is not kept here"),
        (dict(constraints=fb.Constraints(clearance=0.01)), "the constraint clearance is not kept"),
    ],
)
def test_bad_input(options, words):
    given = dict(robot=ROBOT, start=HOME, goal=TASK_1, duration=2.0) | options
    with pytest.raises(ValueError, match=words):
        plan(given.pop("robot"), given.pop("start"), given.pop("goal"), **given)


@pytest.mark.parametrize(
    "settings, words",
    [
        (dict(degree=1), "degree must be a whole number >= 2"),
        (dict(intervals=2.5), "intervals must be a whole number"),
        (dict(tolerance=0), "tolerance must be"),
        (dict(max_time=0), "max_time must be"),
    ],
)
def test_bad_collocation(settings, words):
    with pytest.raises(ValueError, match=f"Collocation: {words}"):
        fb.Collocation(**settings)


@pytest.mark.parametrize(
    "limits, name", [({"joint_speed": 1.2}, "joint_speed"), ({"torque": 0.02}, "torque")]
)
def test_what_cannot_be_kept_is_told_with_the_least_excess_and_the_effort(limits, name):
    """q2 turns by 1.2335 rad within a second, so that a speed of 1.2336 rad/s must do."""
    with pytest.raises(PlanError, match="infeasible") as error:
        fb.plan(fb.FiveBar(), (0.09, 0.068), (0.0, 0.1), 1.0, constraints=fb.Constraints(**limits))
    (limit,) = limits.values()
    assert 0 < error.value.violations[name] < 0.06 * limit
    plan = error.value.plan
    tau = plan.torques(np.linspace(0.0, 1.0, 20001))
    assert plan.objective == pytest.approx(np.mean((tau**2).sum(axis=1)), rel=1e-2)


def test_modes_that_no_way_joins_are_refused(monkeypatch):
    robot = fb.Biglide()
    ends = fb.igm(robot, (0.0, 0.2)), fb.igm(robot, (0.05, 0.35), (1, 1))
    plan = fb.plan(robot, *ends, 1.0)
    assert plan.accelerations(0.0).rates.pose.working.tolist() == [-1, -1]
    assert plan.accelerations(1.0).rates.pose.working.tolist() == [1, 1]
    monkeypatch.setattr(planner, "ways_between", lambda *_: [])
    with pytest.raises(PlanError, match="give a Pose between them as via"):
        fb.plan(robot, *ends, 1.0)


def test_a_pose_that_breaks_a_constraint_is_named_at_once():
    pose, other = fb.igm(ROBOT, HOME, (-1, -1)), fb.igm(ROBOT, TASK_1, (1, -1))
    below = fb.Constraints(half_planes=((0.0, -1.0, -0.09),))  # y <= 0.09
    words = r"goal itself does not keep .*: by 0\.01$"
    with pytest.raises(PlanError, match=words):
        plan(ROBOT, pose, other, 1.0, constraints=below)
    with pytest.raises(PlanError, match=words.replace("goal", "start")):
        plan(ROBOT, other, pose, 1.0, constraints=below)
    with pytest.raises(PlanError, match=words.replace("goal", r"via\[0\]")):
        plan(ROBOT, pose, pose, 1.0, via=[(None, other)], constraints=below)
    both = fb.igm(ROBOT, [HOME, TASK_1], (1, -1))
    with pytest.raises(ValueError, match="goal must be one Pose that closes, not a batch"):
        plan(ROBOT, pose, both, 1.0, constraints=below)


def test_what_the_motors_cannot_hold_is_said_where_no_plan_is_found():
    heavy = fb.FiveBar(0.2, 0.26, 0.2, 0.26, 0.1, m=1.2, gravity=(0.0, -9.81))
    ends = (-0.246, 0.325), (-0.069, -0.143)
    weak = fb.Constraints(torque=1.36)
    with pytest.raises(PlanError) as error:
        plan(heavy, *ends, 1.5, constraints=weak, collocation=fb.Collocation(max_time=0.2))
    for name, point in zip(("start", "goal"), ends):
        needed = np.abs(fb.gravity_torques(fb.igm(heavy, point)))
        words = f"({name}: to hold it there against gravity takes {needed[0]:.4g}, {needed[1]:.4g}"
        assert f"{words} N m, and the limit is 1.36, 1.36 N m)" in str(error.value)


@pytest.mark.deep
def test_a_coarse_motion_whose_ends_diverge_spoils_no_others():
    """A step of one of them has a matrix that is singular by rounding."""
    heavy = fb.FiveBar(0.2, 0.26, 0.2, 0.26, 0.1, m=1.2, gravity=(0.0, -9.81))
    ends = (0.172416, 0.321357), (-0.189128, 0.0474418)
    found = plan(heavy, *ends, 1.60038, constraints=fb.Constraints(torque=1.3037981))
    t = np.linspace(0.0, found.duration, 4001)
    assert found.error <= 1e-3 and np.abs(found.torques(t)).max() <= 1.3037981 * (1 + 1e-3)


@pytest.mark.parametrize(
    "objective, limits",
    [("jerk", fb.Constraints()), ({"time": 1.0, "jerk": 1e-3}, fb.Constraints(acceleration=5.0))],
)
def test_between_poses_something_must_bound_the_torque(objective, limits):
    """Least jerk failed in 11 of 12 pairs, after 10 s each."""
    ends = fb.igm(ROBOT, HOME, (-1, -1)), fb.igm(ROBOT, TASK_2, (-1, -1))
    with pytest.raises(ValueError, match='a weight on "effort" the torque has no bound'):
        plan(ROBOT, *ends, 2.0, objective=objective, constraints=limits)
