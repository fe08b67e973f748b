"""The best plan of those that first motions lead to, each on finer and finer meshes."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..base.progress import progress
from ..constraints.load import too_heavy
from ..models.physics import loads_of
from .collocation import LIMITS
from .guess import GuessAgain
from .plans import AGAIN, Plan, PlanMesh, Tried
from .problem import PlanError, refuse_broken
from .program import Interval, solve
from .starts import Start

if TYPE_CHECKING:
    from .plan import Collocation

REFINEMENTS = 12
MOST_INTERVALS = 600
MOST_PARTS = 3
ALTERNATIVES = 3  # motions, at most, that are refined when asked for
LOOKED = 4  # starts that are solved on the first meshes of their plans
WORTH = 2.0  # of the least cost on the coarse mesh: that of starts which are
CLOSE = 1.1  # of the least cost on the first mesh: that of motions that are refined once
GAIN = 0.02  # that another plan may bring: less is not worth its time
NEAR = 0.1  # of a distal bar: motions that are nowhere farther apart are one
SMOOTHINGS = 1.0, 0.2  # rad/s, of dry friction, on the first meshes
FAILURES = 8  # of starts, after which the search ends
CHANCES = 2  # of them from the coarse mesh
# Of the time: at most, on the first mesh and on a finer one of a start that is not insisted on, and
# half of what is left.
PART, MORE = 0.1, 0.25


def best_plan(starts: list[Start], clock: Clock, ways: int = 1, swings: int = 0) -> Plan:
    """Return the best plan of those that the starts lead to.

    What a motion costs on the coarse mesh says little, on the first mesh of its plan much. So the
    first starts are solved there; those near the best once more, on finer meshes; and then the one
    that costs least, until it is accurate. Where two starts fail, the ways that were not improved
    on the coarse mesh are tried; where all do, the shortest one is insisted on.
    """
    is_over = clock.is_over
    alone = len(starts) == 1
    rest = list(starts)
    begun: list[_PlanSearch] = []
    failures: list[PlanError] = []
    intervals: dict[tuple, Interval] = {}
    lost = [math.inf]  # costs of what led to no plan

    def attempt(search, step):
        try:
            step()
        except PlanError as error:
            failures.append(error)
            lost.append(search.cost)
            return False
        return True

    def begin(start, insists):
        search = _PlanSearch(start, clock, insists, intervals)
        if attempt(search, search.begin) and not any(map(search.is_like, begun)):
            begun.append(search)

    def is_worth_while(search):
        others = (each for each in begun if each is not search)
        costs = [each.cost / (1 + GAIN * each.accurate) for each in others]
        return search.cost <= min(costs, default=math.inf) * (1.0 if search.refinements else CLOSE)

    while rest and not begun and len(failures) < FAILURES and not is_over():
        dearest = math.inf
        while rest and len(begun) < LOOKED and rest[0].cost <= dearest and not is_over():
            if len(failures) >= CHANCES:
                rest.sort(key=lambda start: start.cost < math.inf)
            begin(rest.pop(0), alone)
            if begun:
                dearest = WORTH * starts[0].cost
            elif len(failures) == FAILURES:
                break
        if not (begun or alone or is_over()):
            begin(max(starts, key=lambda start: start.cost), True)
        while not is_over():
            left = [each for each in begun if not each.accurate and is_worth_while(each)]
            if not left:
                break
            search = min(left, key=lambda search: (search.refinements, search.cost))
            if not attempt(search, search.step):
                begun.remove(search)
    if not failures and not any(search.accurate for search in begun):
        # The time is over, as a further step says.
        attempt(begun[0], begun[0].step) if begun else begin(starts[0], alone)
    begun.sort(key=lambda search: search.cost)
    plans = [search.plan for search in begun if search.accurate]
    if not plans:
        raise failures[-1]
    least = plans[0].objective
    rest = [start for start in rest if start.cost < math.inf]
    costs = [search.cost for search in begun] + [start.cost for start in rest]
    dearer = [cost for cost in costs if cost > (1 + AGAIN) * least]
    is_cut = is_over() or min(lost) < least
    tried = Tried(ways, swings, min(dearer, default=None), is_cut)
    again = [search.again for search in begun if search.plan is not plans[0]] + rest
    others = tuple(partial(refined, start, clock.collocation) for start in again[:ALTERNATIVES])
    return replace(plans[0], tried=tried, others=others, solve_time=clock.seconds)


def refined(start: Start, collocation: Collocation) -> Plan:
    """Return the accurate plan that a start leads to; PlanError."""
    search = _PlanSearch(start, Clock(collocation))
    search.begin()
    while not search.accurate:
        search.step()
    return search.plan


class Clock:
    """The time since a search began, and what is left of it; a bar shows its steps."""

    def __init__(self, collocation: Collocation) -> None:
        self.collocation = collocation
        self.began = time.perf_counter()
        self.worked = time.thread_time()
        self.bar = progress(desc="plan", unit=" steps", delay=2, leave=False)

    @property
    def seconds(self) -> float:
        """The time, s, that a user has waited."""
        return time.perf_counter() - self.began

    @property
    def left(self) -> float:
        """The processor time, s, that is left."""
        return self.collocation.max_time - (time.thread_time() - self.worked)

    def is_over(self) -> bool:
        """Return whether no time is left, and show a step."""
        self.bar.update()
        return self.left < 0


class _PlanSearch:
    """The search for a plan from one start, on finer and finer meshes; it names what is wrong.

    insists: try again where IPOPT does not converge, and find out which limits cannot be met.
    intervals: those that are built.
    """

    def __init__(self, start, clock, insists=True, intervals=None):
        self.start = start
        self.problem = start.problem
        self.smoothings = []
        if loads_of(self.problem.robot).sticks:
            first, *rest = SMOOTHINGS
            self.problem = replace(self.problem, slow=first)
            self.smoothings = [*rest, start.problem.slow][::-1]
        self.cost = start.cost
        self.clock = clock
        self.insists = insists
        self.tolerance = clock.collocation.tolerance
        self.intervals = {} if intervals is None else intervals
        self.meshes = []
        self.best = None  # the last plan that converged
        self.refinements = 0
        self.accurate = False

    def begin(self):
        """Solve on the first mesh."""
        _, self.mesh, *self.first, _ = self.start
        self.found, self.plan = self.solved(self.mesh, *self.first)
        self.cost = self.found.objective

    def is_like(self, other):
        """Whether the motion costs about as much as that of another search, and is as near."""
        if abs(self.cost - other.cost) > GAIN * other.cost:
            return False
        share = np.linspace(0.0, 1.0, 41)
        places = [search.plan(share * search.plan.duration)[0] for search in (self, other)]
        return np.abs(places[0] - places[1]).max() < NEAR * self.problem.length

    def step(self):
        """Refine the mesh where the plan is not accurate, and smooth friction less."""
        parts = self.parts()
        if parts is None and not self.smoothings:
            self.plan = refuse_broken(self.plan, self.tolerance)
            self.accurate = True
            return
        if self.smoothings:
            self.problem = replace(self.problem, slow=self.smoothings.pop())
        self.refine(parts)
        self.cost = self.found.objective

    @property
    def again(self):
        """Return the motion so far as a start."""
        guess = GuessAgain(self.plan, self.found.controls)
        return Start(self.start.problem, self.mesh, self.found.durations, guess, self.cost)

    def parts(self):
        """Return into how many parts to divide each interval; None where the plan is accurate."""
        excess = np.nan_to_num(self.plan._relative_defects, nan=1.0)  # out of reach between nodes
        for name, value in self.plan._exceeded.items():
            excess = np.fmax(excess, value.max(axis=1) / self.problem.unit(name))
        order = len(self.problem.scheme.c)  # of the defect between nodes
        needed = np.ceil((2 * excess / self.tolerance) ** (1 / order))
        parts = np.clip(needed, 2, MOST_PARTS).astype(int)
        parts[excess <= self.tolerance] = 1
        return parts if parts.max() > 1 else None

    def refine(self, parts):
        """Solve again, on the mesh divided into parts; None: on the same one."""
        self.refinements += 1
        found, plan = self.found, self.plan
        if parts is not None:
            if parts.sum() > MOST_INTERVALS or self.refinements == REFINEMENTS:
                reason = (
                    f"not accurate: error {plan.error:.3g} between nodes on {len(parts)} intervals,"
                    f" {self.tolerance:g} is allowed"
                )
                raise self.failure(plan, reason, plan.status)
            self.mesh = _divided(self.mesh, parts)
        guess = GuessAgain(plan, found.controls)
        self.found, self.plan = self.solved(self.mesh, found.durations, guess)

    def solved(self, mesh, durations, guess):
        found, plan = self.solve(mesh, durations, guess)
        # Begun afresh near its end, it converges.
        is_near = self.insists or (self.best and found.objective < WORTH * self.cost)
        if found.status == "Maximum_Iterations_Exceeded" and is_near:
            found, plan = self.solve(mesh, found.durations, GuessAgain(plan, found.controls))
        if not (found.solved or self.insists):
            reason = f"IPOPT did not converge ({found.status})"
            raise self.failure(self.best or plan, reason, found.status)
        return (found, plan) if found.solved else self.recover(mesh, found, plan)

    def solve(self, mesh, durations, guess, elastic=False):
        most = self.clock.collocation.max_time
        left = self.clock.left
        if not self.insists:
            left = min(left / 2, (PART, MORE)[self.best is not None] * most)
        problem = self.problem
        key = problem.slow, elastic, problem.in_bars
        if key not in self.intervals:
            self.intervals[key] = Interval(problem, mesh, durations, guess, elastic)
        found = solve(self.intervals[key].to(problem.stops), mesh, durations, guess, left)
        plan = Plan(self.problem, found.pieces, found.objective, found.status)
        done = len(plan.pieces.xi), found.iterations, found.objective, plan.error
        seconds = self.clock.seconds
        self.meshes.append(PlanMesh(*done, seconds))
        plan = replace(plan, meshes=tuple(self.meshes), solve_time=seconds)
        if found.solved and not elastic:
            self.best = plan
        if self.clock.is_over():
            reason = f"no solution within max_time = {most:g} s"
            raise self.failure(self.best or plan, reason, found.status)
        return found, plan

    def recover(self, mesh, failed, plan):
        """Begin afresh; else meet the limits as well as can be, and try again from there."""
        if len(self.meshes) > 1:
            found, plan = self.solve(mesh, *self.first)
            if found.solved:
                return found, plan
        best, nearest = self.solve(mesh, *self.first, elastic=True)
        if not best.solved:
            reason = f"IPOPT did not converge ({failed.status}, then {best.status})"
            raise self.failure(self.best or plan, reason, failed.status)
        if best.slack.max() > self.tolerance:
            names = [name for name, slack in zip(LIMITS, best.slack) if slack > 1e-6]
            # Speeds are limited at the points only, and the nearest motion leaps between them.
            least = {}
            if "joint_speed" in names:
                share = float(best.slack[LIMITS.index("joint_speed")])
                least["joint_speed"] = share * self.problem.unit("joint_speed")
            raise self.failure(nearest, "infeasible", failed.status, names, least)
        found, plan = self.solve(mesh, best.durations, GuessAgain(nearest, best.controls))
        if not found.solved:
            reason = f"IPOPT did not converge ({failed.status}, then {found.status})"
            raise self.failure(self.best or plan, reason, found.status)
        return found, plan

    def failure(self, plan, reason, status, names=(*LIMITS, "reach"), least=()):
        problem = self.problem
        fails = reason.startswith("IPOPT")
        if problem.own is not None and "functions" in names:
            names = *names, *problem.own.constraints
            if fails:
                reason += " (functions of your own need slopes that do not jump, as at a root of 0)"
        limits = problem.constraints.torque, problem.constraints.motors
        is_bounded = problem.weights["effort"] or any(limits)
        is_lost = fails or reason.startswith("not accurate")
        if problem.has_own_cost and not is_bounded and is_lost:
            reason += " (nothing bounds the torque: a constraint would, or a weight on effort)"
        for name, stop in zip(("start", "goal"), (problem.stops[0], problem.stops[-1])):
            motion = np.append(stop[0][0], np.zeros(2 * problem.coordinates.size))
            weight = limits[0] and too_heavy(problem.accelerations(motion).rates.pose, limits[0])
            reason += f" ({name}: {weight})" if weight else ""
        broken = {name: value for name, value in plan.violations.items() if name in names}
        broken.update(least)
        why = f"{reason}{problem.listed(broken)}"
        return PlanError(f"plan: {why}", broken, plan, status)


def _divided(mesh, parts):
    """Divide each interval into so many parts."""
    ends = np.cumsum([len(knots) - 1 for knots in mesh])
    finer = []
    for knots, own in zip(mesh, np.split(parts, ends)):
        place = np.append(0, np.cumsum(own))
        finer.append(np.interp(np.arange(place[-1] + 1), place, knots))
    return finer
