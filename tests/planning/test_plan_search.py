"""The search of a plan: how it refines its mesh, what it tries after a failure, and what it says."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning import plan as planner
from fivebar.planning.collocation import LIMITS
from fivebar.planning.plan import _PlanSearch, _refined
from fivebar.planning.problem import PlanError
from fivebar.planning.starts import mesh_of

ROBOT = fb.FiveBar()
START, GOAL = (0.05, 0.12), (-0.03, 0.1)
COARSE = fb.Collocation(intervals=6)


@pytest.fixture
def tries(monkeypatch):
    """Every call of the solver: (mesh sizes, the guess's first point, elastic); some are made to
    fail.
    """
    calls = []
    fails = set()
    exact = planner.solve

    def solve(problem, mesh, durations, guess, left, elastic, iterations, near):
        calls.append((len(mesh[0]) - 1, guess, elastic))
        found = exact(problem, mesh, durations, guess, left, elastic, iterations, near)
        return replace(found, status="Failed") if len(calls) in fails else found

    monkeypatch.setattr(planner, "solve", solve)
    return calls, fails


def planned(**options):
    return fb.plan(ROBOT, START, GOAL, 1.0, collocation=COARSE, **options)


def test_after_a_first_failure_the_limits_are_met_as_well_as_can_be(tries):
    calls, fails = tries
    fails.add(1)
    plan = planned()
    assert plan.status == "Solve_Succeeded"
    assert [elastic for *_, elastic in calls[:3]] == [False, True, False]
    assert calls[1][1] is calls[0][1]
    assert calls[2][1] is not calls[0][1]
    assert len(plan.meshes) == len(calls)


def test_after_a_failure_on_a_finer_mesh_the_first_guess_is_tried_there(tries):
    calls, fails = tries
    fails.add(2)
    plan = planned(constraints=fb.Constraints(joint_speed=1.1))
    sizes = [size for size, *_ in calls]
    assert sizes[0] == 6 and sizes[1] > 6 and sizes[2] == sizes[1]
    assert calls[2][1] is calls[0][1] is not calls[1][1]
    assert not any(elastic for *_, elastic in calls)
    assert plan.status == "Solve_Succeeded"


@pytest.mark.parametrize(
    "failing, words",
    [
        ({1, 2}, r"IPOPT did not converge \(Failed, then Failed\)"),
        ({1, 3}, r"IPOPT did not converge \(Failed, then Failed\)"),
    ],
)
def test_what_fails_in_every_way_says_so(tries, failing, words):
    calls, fails = tries
    fails |= failing
    with pytest.raises(PlanError, match=words) as error:
        planned()
    assert error.value.status == "Failed"
    assert error.value.plan.duration == pytest.approx(1.0)
    assert len(calls) == max(failing)


def test_a_mesh_that_does_not_get_accurate_is_said_between_poses_too(monkeypatch):
    monkeypatch.setattr(planner, "REFINEMENTS", 1)
    ends = [fb.igm(ROBOT, point) for point in (START, GOAL)]
    exact = fb.Collocation(intervals=4, tolerance=1e-6)
    words = r"not accurate: error .* between nodes on 4 intervals, 1e-06 is allowed"
    with pytest.raises(PlanError, match=words) as error:
        fb.plan(ROBOT, *ends, 1.0, collocation=exact)
    assert error.value.plan.working is None


def test_intervals_are_divided_by_the_order_of_their_error(tries):
    """Into ceil((2 error / tolerance)^(1 / degree)) parts, from 2 to 8; a good one is left."""
    plan = planned()
    search = _PlanSearch(plan.problem, fb.Collocation(tolerance=1e-3), (0.0, 0.0))
    defects = np.array([5e-4, 1e-3, 2e-3, 0.0135, 0.5, 10.0, np.nan])
    found = replace(plan)
    found.__dict__["_relative_defects"] = defects
    found.__dict__["_exceeded"] = {}
    assert search.parts(found).tolist() == [1, 1, 2, 3, 8, 8, 8]
    excess = np.array([[0.0, -1.0], [2e-3, 0.0], *[[-1.0, np.nan]] * 5])
    found.__dict__["_exceeded"] = {"reach": excess * found.problem.length}
    assert search.parts(found).tolist() == [1, 2, 2, 3, 8, 8, 8]
    found.__dict__["_relative_defects"] = np.zeros(7)
    found.__dict__["_exceeded"] = {}
    assert search.parts(found) is None
    # An interval that is out of reach errs by the whole force.
    found.__dict__["_relative_defects"] = np.array([0.0, np.nan])
    rough = _PlanSearch(plan.problem, fb.Collocation(tolerance=0.1), (0.0, 0.0))
    assert rough.parts(found).tolist() == [1, 3]


def test_meshes():
    assert [each.tolist() for each in mesh_of(4, np.array([3.0, 1.0]))] == [
        pytest.approx([0.0, 1 / 3, 2 / 3, 1.0]),
        [0.0, 0.5, 1.0],
    ]
    fine = _refined([np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.2, 1.0])], np.array([1, 2, 3, 1]))
    assert fine[0] == pytest.approx([0.0, 0.5, 0.75, 1.0])
    assert fine[1] == pytest.approx([0.0, 0.2 / 3, 0.4 / 3, 0.2, 1.0])


def test_limits_that_cannot_be_kept_are_the_only_ones_named(tries, monkeypatch):
    _, fails = tries
    fails.add(1)
    exact = planner.solve

    def solve(*given):
        found = exact(*given)
        elastic = given[5]
        slack = np.array([0.01 * (elastic and name == "joint_speed") for name in LIMITS])
        return replace(found, slack=slack)

    monkeypatch.setattr(planner, "solve", solve)
    with pytest.raises(PlanError, match="plan: infeasible") as error:
        planned(constraints=fb.Constraints(joint_speed=1.1, torque=5.0))
    assert set(error.value.violations) == {"joint_speed"}
    assert error.value.status == "Failed"
