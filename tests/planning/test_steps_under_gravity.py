"""The search under gravity: which ways and steps it solves, and which plan it takes, with a solver of known answers."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning import plan as planner
from fivebar.planning.problem import PlanError

SETTINGS = fb.Collocation(intervals=4, tolerance=0.1, max_time=2.5)
LIMIT = 600  # points times iterations that max_time allows for


@dataclass(frozen=True, eq=False)
class Step:
    """What the solver answers to one step: a plan of its own."""

    objective: float = 1.0
    work: int = 100
    solved: bool = True
    accurate: bool = True
    parts: tuple | None = None
    too_late: bool = False
    tried: int = 1
    status: str = "Solve_Succeeded"


def way(name, *steps):
    return SimpleNamespace(name=name, steps=steps, fall=0.0, length=1.0), f"paths of {name}", 1.0


@pytest.fixture
def calls(monkeypatch):
    """Every step that the solver is asked for: (way, knots, durations, guess, iterations, weight)."""
    found = []

    class Search:
        def __init__(self, problem, collocation, began):
            assert collocation is SETTINGS and began == "now"
            self.name, self.steps, self.work = problem.name, iter(problem.steps), 0

        def solve(self, mesh, durations, guess, iterations, near):
            found.append((self.name, mesh, durations.tolist(), guess, iterations, near))
            step = next(self.steps)
            if step.too_late:
                raise PlanError("no solution within max_time", {})
            self.work += step.work
            return SimpleNamespace(solved=step.solved, durations=durations + 1.0), step

        def parts(self, plan, allowed):
            assert allowed == 0.03
            return None if plan.parts is None else np.array(plan.parts)

        def accurate(self, step):
            weight, mesh, solution, plan = step
            assert solution.solved
            assert any(mesh is call[1] and weight == call[-1] for call in found)
            return plan if plan.accurate else None

    monkeypatch.setattr(planner, "_PlanSearch", Search)
    monkeypatch.setattr(planner, "WORK", LIMIT / 2.5 * 25)
    monkeypatch.setattr(planner, "refuse_massless", lambda problem: None)
    monkeypatch.setattr(planner, "first_guess", lambda _, paths: (paths, np.array([3.0])))
    monkeypatch.setattr(planner, "guess_again", lambda plan, found: (plan, found.durations[0]))
    return found


def best_of(*ways):
    return planner._under_gravity(ways, SETTINGS, "now")


def test_each_step_is_nearer_to_the_optimum_and_starts_from_the_last(calls):
    steps = [Step(work=1) for _ in range(6)]
    plan = best_of(way("one", *steps))
    assert [weight for *_, weight in calls] == [100.0, 10.0, 1.0, 0.1, 0.01, 0.0]
    assert {iterations for *_, iterations, _ in calls} == {40}
    assert [durations for _, _, durations, *_ in calls] == [[3.0 + k] for k in range(6)]
    assert calls[0][3] == "paths of one"
    for k, (*_, guess, _, _) in enumerate(calls[1:], start=1):
        assert guess == (steps[k - 1], 3.0 + k)
    assert all(mesh[0] == pytest.approx(np.linspace(0, 1, 5)) for _, mesh, *_ in calls)
    assert plan.tried == 1


def test_poor_intervals_are_divided_if_the_mesh_does_not_get_too_fine(calls):
    most = planner.MOST_INTERVALS
    fine = Step(parts=(most // 4,) * 4)
    best_of(way("one", Step(parts=(1, 2, 1, 1)), Step(parts=None), Step(solved=False)))
    assert [len(mesh[0]) - 1 for _, mesh, *_ in calls] == [4, 5, 5]
    assert calls[1][1][0] == pytest.approx([0.0, 0.25, 0.375, 0.5, 0.75, 1.0])
    calls.clear()
    best_of(way("one", fine, Step(solved=False)))
    assert len(calls[1][1][0]) - 1 == most
    calls.clear()
    best_of(way("one", Step(parts=(most // 4 + 1,) * 4), Step(solved=False)))
    assert len(calls[1][1][0]) - 1 == 4


def test_the_last_step_that_gets_accurate_is_taken(calls):
    steps = Step(3.0), Step(2.0), Step(1.0, accurate=False), Step(0.5, solved=False)
    assert best_of(way("one", *steps)).objective == 2.0
    assert len(calls) == 4
    assert best_of(way("one", Step(accurate=False), Step(solved=False))) is None
    assert best_of(way("one", Step(solved=False), Step(solved=False))) is None


def test_a_way_that_ends_in_its_first_step_goes_on_after_all_others(calls):
    ways = way(0, Step(solved=False), Step(1.0), Step(solved=False)), way(1, Step(solved=False))
    with pytest.raises(StopIteration):  # the other way goes on, too
        best_of(*ways)
    assert [name for name, *_ in calls] == [0, 1, 0, 0, 1]
    first, *_, again, _, _ = calls
    assert again[3] == (ways[0][0].steps[0], 4.0) and again[2] == [4.0] and again[-1] == first[-1]


def test_the_best_of_all_ways_is_taken_and_all_are_counted(calls):
    last = Step(solved=False, work=1)
    costs = 3.0, 1.0, 2.0
    ways = [way(k, Step(cost, work=50), last) for k, cost in enumerate(costs)]
    plan = best_of(*ways, way("no plan", last, last))
    assert plan.objective == 1.0 and plan.tried == 4
    one, other = Step(1.0), Step(1.0)
    plan = best_of(way(0, one, last), way(1, other, last))
    assert plan.tried == 2 and plan.objective == 1.0


def test_steps_and_ways_end_with_the_work(calls):
    """A way may go on while its work and that of the ways before is at most the limit."""
    best_of(way("one", *[Step(work=LIMIT // 2)] * 6))
    assert len(calls) == 3
    calls.clear()
    short = [Step(work=LIMIT // 3), Step(work=0, solved=False)]
    plan = best_of(*(way(k, *short) for k in range(6)))
    assert [name for name, *_ in calls] == [0, 0, 1, 1, 2, 2, 3]
    assert plan.tried == 4
    calls.clear()
    exact = [Step(work=LIMIT // 2), Step(work=0, solved=False)]
    assert best_of(*(way(k, *exact) for k in range(3))).tried == 3
    calls.clear()
    # Without a plan the other ways are tried however long it takes.
    none = Step(work=2 * LIMIT, solved=False)
    plan = best_of(way("one", none), way("two", none), way("three", *short))
    assert plan.tried == 3 and [name for name, *_ in calls] == ["one", "two", "three"]


def test_when_the_time_is_over_the_best_until_then_is_returned(calls):
    last = Step(solved=False)
    plan = best_of(way("one", Step(2.0), last), way("two", Step(1.0), Step(too_late=True)))
    assert plan.objective == 2.0 and plan.tried == 2
    assert best_of(way("one", Step(too_late=True)), way("two", Step(), last)) is None
    assert calls[-1][0] == "one"


class Accurate(planner._PlanSearch):
    """A search whose solver and errors are given."""

    def __init__(self, answers, parts):
        self.answers, self.needed, self.asked = iter(answers), iter(parts), []

    def parts(self, plan, allowed=None):
        needed = next(self.needed)
        return None if needed is None else np.array(needed)

    def solve(self, mesh, durations, guess, elastic=False, iterations=None, near=0.0):
        self.asked.append((mesh[0].tolist(), durations, guess, iterations, near))
        solved, step = next(self.answers)
        return SimpleNamespace(solved=solved, durations=durations), step


def test_a_step_is_refined_until_it_is_accurate(calls):
    mesh = [np.array([0.0, 0.5, 1.0])]
    found = SimpleNamespace(durations=np.array([2.0]))
    first, finer = Step(3.0), Step(2.0)
    search = Accurate([(True, finer)], [(1, 2), None])
    plan = search.accurate((10.0, mesh, found, first))
    assert plan.objective == 2.0 and plan.status == "Feasible_Point_Found"
    # A step that is held is held to its own motion on the finer mesh.
    assert search.asked == [([0.0, 0.5, 0.75, 1.0], [2.0], (first, 2.0), 60, 100.0)]
    search = Accurate([(True, finer)], [(1, 2), None])
    assert search.accurate((0.0, mesh, found, first)).status == "Solve_Succeeded"
    assert search.asked[0][-1] == 0.0
    assert Accurate([], [None]).accurate((0.0, mesh, found, first)) is first
    assert Accurate([(False, finer)], [(1, 2)]).accurate((0.0, mesh, found, first)) is None
    most = planner.MOST_INTERVALS
    assert Accurate([], [(1, most)]).accurate((0.0, mesh, found, first)) is None
    search = Accurate([(True, finer)], [(1, most - 1), None])
    assert search.accurate((0.0, mesh, found, first)) is finer
