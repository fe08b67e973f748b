"""Plans that keep what is named: checked by `check_path`, which knows nothing of the program."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.geometry import task_pose

from .conftest import poses

ROBOT, HOME, GOAL = fb.FiveBar(), (0.09, 0.0680), (-0.05, 0.09)


def test_a_plan_keeps_half_planes_a_region_joints_and_margins():
    free = fb.plan(ROBOT, HOME, GOAL, 0.6)
    xi = free(np.linspace(0, 0.6, 301))[0]
    q = fb.igm(ROBOT, xi, (-1, -1)).q
    chord = np.subtract(GOAL, HOME)
    across = (xi - HOME) @ (-chord[1], chord[0]) / np.linalg.norm(chord)
    side = np.sign(
        across[np.abs(across).argmax()]
    )  # to which the free motion goes, half as far as it may
    a, b = -side * np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)
    planes = [(a, b, a * HOME[0] + b * HOME[1] - np.abs(across).max() / 2)]
    region = [(-0.1, 0.05), (0.12, 0.05), (0.12, 0.12), (-0.1, 0.12)]
    for constraints in (
        fb.Constraints(half_planes=planes, region=region, det_A=0.1),
        fb.Constraints(joints=((q[:, 0].min() / 2, 1.3), None), region=region),
    ):
        assert len(fb.check_path(ROBOT, free, constraints=constraints).broken) == 1
        plan = fb.plan(ROBOT, HOME, GOAL, 0.6, constraints=constraints)
        assert all(
            each.by < 1e-4 for each in fb.check_path(ROBOT, plan, constraints=constraints).broken
        )
        assert plan.objective > free.objective
    with pytest.raises(fb.PlanError, match="goal itself does not keep 0 x"):
        fb.plan(
            ROBOT, HOME, (0.0, 0.05), 0.6, constraints=fb.Constraints(half_planes=[(0, 1, 0.06)])
        )
    with pytest.raises(TypeError, match="constraints must be a Constraints"):
        fb.plan(ROBOT, HOME, GOAL, 0.6, constraints={"det_A": 0.1})


@pytest.mark.deep
def test_a_plan_leads_around_where_bars_and_posts_would_meet():
    constraints, start, goal = (
        fb.Constraints(collisions=fb.LinkCollisions(0.02, posts=0.012)),
        (-0.031, 0.002),
        (0.107, 0.062),
    )
    options = dict(duration=1.2, collocation=fb.Collocation(intervals=16))
    free = fb.plan(ROBOT, start, goal, **options)
    assert fb.check_path(ROBOT, free, constraints=constraints).broken
    plan = fb.plan(ROBOT, start, goal, **options, constraints=constraints)
    assert (
        all(each.by < 1e-4 for each in fb.check_path(ROBOT, plan, constraints=constraints).broken)
        and plan.objective > free.objective
    )


def test_rooms_of_bars_as_symbols_are_those_as_numbers():
    bars, x = (
        fb.LinkCollisions((0.01, 0.02, 0.03, 0.0), (1, 1, 1, 2), 0.01, (1, 2)),
        ca.SX.sym("x", 2),
    )
    rng = np.random.default_rng(2)
    for working in ((-1, -1), (1, -1)):
        symbols = bars.smooth(task_pose(ROBOT, (x[0], x[1]), working))
        pose = fb.igm(
            ROBOT, rng.uniform((-0.1, -0.15), (0.1, 0.15), (300, 2)), working, unreachable="nan"
        )
        closes = np.isfinite(pose.det_A)
        ours = ca.Function("rooms", [x], [ca.vertcat(*symbols)])(pose.xi[closes].T)
        clearances = np.array(list(bars.clearances(pose).values()))[:, closes]
        assert (clearances < -0.02).any() and (clearances > 0.02).any()
        np.testing.assert_allclose(ours, clearances, atol=2e-9)


def test_a_plan_whose_bars_meet_is_refused():
    constraints = fb.Constraints(collisions=fb.LinkCollisions(0.01))
    with pytest.raises(fb.PlanError, match="start itself does not keep bars 11 and 21"):
        fb.plan(
            ROBOT,
            *poses(ROBOT, ((0.0, -0.06), (0.01, -0.1)), (1, -1)),
            0.5,
            constraints=replace(constraints, sin=0.05),
        )
    assert fb.plan(ROBOT, HOME, (0.08, 0.075), 0.5, constraints=constraints).duration == 0.5
