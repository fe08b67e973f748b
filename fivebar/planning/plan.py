"""Optimal motions by direct collocation with the bar forces as controls: they may cross Type-2
singularities.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, number, optional, positive, whole
from ..base.robot_uses import takes_robot
from ..constraints.constraints import Constraints, kept_by
from ..models.geometry import Pose, igm
from ..singularities.degenerate import refuse_singular_everywhere
from .collocation import LIMITS, Scheme
from .functions import OwnFunctions
from .guess import bent_paths, first_guess, guess_again
from .plans import AGAIN, Plan, PlanMesh, Tried
from .problem import (
    PlanError,
    Problem,
    checked_stops,
    checked_weights,
    own_costs,
    point_of,
    refuse_broken,
    refuse_massless,
    refuse_stops,
    working_modes,
)
from .program import Interval, solve
from .search import ways_between
from .starts import Start, mesh_of, starts_between

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ..models.robots import Robot

# Limits on torques and rates that are limits of the program.
RATES = "motors", "torque", "joint_speed", "acceleration"
LEAST_SIN = 0.05  # that a motion in one pair of working modes keeps by default
REFINEMENTS = 12
MOST_INTERVALS = 600
MOST_PARTS = 3
PLANS = 3  # at most, of which the best is taken, and that are refined when asked for
FAILURES = 8  # of starts, after which the search ends
CHANCES = 2  # of them from the coarse mesh
PART = 1 / 10  # of the time: at most, on a mesh of a start that is not insisted on
# Of the best plan's objective: the cost of a start on the coarse mesh that may still beat it.
CLOSE = 1.05
SAME = 1e-3  # of an objective, by which two motions on the coarse mesh are told apart


@dataclass(frozen=True)
class Collocation:
    """Settings of the direct collocation of `plan`.

    Parameters
    ----------
    degree : int
        Points of Legendre and Gauss in an interval, 2 to 7.
    intervals : int
        Intervals of the first mesh, 2 to 600.
    tolerance : float
        Largest relative defect of the force between nodes, and largest relative violation of a
        limit there. The mesh is refined until both hold. Torque and acceleration are never
        exceeded.
    max_time : float
        Processor time, s, after which the search ends: `Plan.tried` says whether it was cut.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.Collocation(intervals=10).tolerance
    0.001
    """

    degree: int = 3
    intervals: int = 20
    tolerance: float = 1e-3
    max_time: float = 30.0

    def __post_init__(self) -> None:
        whole(2, 7)(self.degree, "Collocation: degree")
        whole(2, MOST_INTERVALS)(self.intervals, "Collocation: intervals")
        number(self.tolerance, "Collocation: tolerance", 1e-9, 1.0)
        positive(self.max_time, "Collocation: max_time")


@takes_robot(constraints=kept_by("fb.plan"), collocation=optional(instance(Collocation)))
def plan(
    robot: Robot,
    start: ArrayLike | dict | Pose,
    goal: ArrayLike | dict | Pose,
    duration: float | None = None,
    *,
    via: Iterable = (),
    objective: str | Callable | dict[str, float | Callable] = "effort",
    constraints: Constraints | None = None,
    collocation: Collocation | None = None,
) -> Plan:
    """Return an optimal motion. It crosses singularities where that is better or the only way.

    Direct collocation with the two bar forces as controls, m xi'' = A^T lambda and
    tau = Z q'' + B^T lambda: nothing is divided by det A, so the motion may cross Type 2 with
    finite torque.

    Parameters
    ----------
    robot : FiveBar or Biglide
    start, goal : (2,), dict or Pose
        A point, m, at rest; or {order: (x, y)}, its position and derivatives, as in `polynomial`.
        Then the motion is in working modes (-1, -1) and keeps at least |sin q_i2| = 0.05. Or a
        Pose, at rest: then the motion may pass Type 1 and Type 2 as often as needed, through all
        modes. With `constraints.sin` it keeps the working modes of its Poses.
    duration : float, optional
        Duration, s. By default it is free.
    via : iterable of (time or None, point)
        Points to pass, in this order; between Poses, Poses.
    objective : "effort", "time", "jerk", callable or dict
        Integral of tau^2, duration, integral of the squared third derivative of xi; or the integral
        of a function of your own. Or {name: weight >= 0} on their SI values, and {name: function}:
        all are added. A function gets one argument, which has t, q, q_dot, q_ddot, xi, xi_dot,
        xi_ddot, tau and bar_forces (N, of both distal bars), CasADi's symbols in SI units, and
        returns one number: `lambda m: m.bar_forces[0] ** 2`.
    constraints : Constraints, optional
        motors, torque, joint_speed, acceleration, joints, half_planes, region, det_A, sin,
        collisions and functions. Those on poses, and functions, are limits of the program at the
        nodes, and checked between them. A region that is not convex is only checked.
    collocation : Collocation, optional
        Mesh and accuracy.

    Returns
    -------
    Plan
        Call it with t (n,) s for (xi, xi_dot, xi_ddot), each (n, 2).

    Raises
    ------
    ValueError
        The problem makes no sense.
    UnreachableError
        A point is out of reach.
    SingularityError
        All poses of the working modes are singular.
    PlanError
        No plan was found. It holds the best motion found, as `plan`, and its violations.

    References
    ----------
    Moreno-Martin, Ros, Celaya: Collocation methods for second order systems, RSS 2022.

    Examples
    --------
    >>> import fivebar as fb
    >>> plan = fb.plan(fb.FiveBar(), (0.09, 0.068), (0.08, 0.075), 0.5)
    >>> plan(0.5)[0].round(6).tolist()
    [0.08, 0.075]
    """
    began = _now()
    constraints = Constraints() if constraints is None else constraints
    collocation = Collocation() if collocation is None else collocation
    own = OwnFunctions.of(own_costs(objective), constraints.functions)
    constraints = replace(constraints, functions=())
    free = isinstance(start, Pose) or isinstance(goal, Pose)
    working = (-1, -1)
    if free and constraints.sin:
        free = False
        working = working_modes(start, goal)
    if not free:
        constraints = replace(constraints, sin=constraints.sin or LEAST_SIN)
    weights = checked_weights(objective)
    if duration is None and not weights["time"]:
        raise ValueError(
            'plan: a free duration needs a weight on "time": the longer, the less effort and jerk'
        )
    bounded = weights["effort"] or weights["jerk"] or constraints.torque or constraints.acceleration
    if duration is None and not bounded:
        raise ValueError(
            "plan: minimum time needs a torque or an acceleration among the constraints: without,"
            " it is 0"
        )
    rule = Scheme(collocation.degree)
    if free:
        ways = ways_between(robot, start, goal, duration, via)
        if not ways:
            raise PlanError(
                "plan: no way from start to goal was found: give a Pose between them as via", {}
            )
        problems = [
            (Problem(robot, stops, None, weights, constraints, rule, own), paths)
            for stops, paths, _ in ways
        ]
        refuse_massless(problems[0][0])
        is_over = partial(_is_over, collocation, began)
        starts, swings = starts_between(problems, collocation.intervals, is_over)
        return _best(starts, collocation, began, len(ways), swings)
    refuse_singular_everywhere(robot, working, "plan")
    stops = checked_stops(point_of(start), point_of(goal), duration, via)
    problem = Problem(robot, stops, working, weights, constraints, rule, own)
    refuse_massless(problem)
    refuse_stops(problem)
    poses = [igm(robot, conditions[0], working) for conditions, _ in problem.stops]
    sides = {np.sign(pose.det_A) for pose in poses}
    if sides >= {-1.0, 1.0} and not weights["effort"] and constraints.torque is None:
        raise ValueError(
            "plan: this motion must cross a Type-2 singularity, where without a torque among the"
            ' constraints or a weight on "effort" the torque has no bound'
        )
    starts, ways = _straight_and_bent(problem, collocation, began)
    return _best(starts, collocation, began, ways)


def _straight_and_bent(problem, collocation, began):
    """Return starts, that of least cost on the coarse mesh first, and how many ways were tried.

    Where the robot has weight, a motion that falls to a side and swings up again may cost half: of
    16 random motions the straight way alone led to the best of all seven in 10.
    """
    guess, durations = first_guess(problem)
    mesh = mesh_of(collocation.intervals, durations)
    straight = Start(problem, mesh, durations, guess)
    if not problem.fall or len(problem.stops) > 2:
        return [straight], 1
    search = _PlanSearch(problem, collocation, began)
    known: dict[float, Start] = {}
    tried = [(guess, durations), *(first_guess(problem, paths) for paths in bent_paths(problem))]
    for guess, durations in tried:
        try:
            found, plan = search.solve(mesh, durations, guess)
        except PlanError:  # the time is over
            break
        cost = found.objective
        if found.solved and all(abs(cost - other) > SAME * cost for other in known):
            again = guess_again(plan, found)
            known[cost] = Start(problem, mesh, found.durations, again, cost)
    return [*(known[cost] for cost in sorted(known)), straight], len(tried)


def _best(starts, collocation, began, ways=1, swings=0):
    """Return the best plan of those that the first starts lead to.

    Starts are left out whose cost on the coarse mesh is larger than that of a plan. Where two
    fail, the ways that were not improved there are tried first; where all do, the shortest one is
    insisted on.
    """
    plans: list[Plan] = []
    failures: list[PlanError] = []
    rest = list(starts)
    alone = len(starts) == 1
    # A coarse motion takes the time that it began with, however fast it could be.
    free = starts[0].problem.stops[-1][1] is None

    def attempt(start, insists):
        try:
            plans.append(refined(start, collocation, began, insists))
        except PlanError as error:
            failures.append(error)

    while rest and len(failures) < FAILURES:
        if plans:
            least = min(plan.objective for plan in plans)
            dear = rest[0].cost == math.inf if free else rest[0].cost > CLOSE * least
            if dear or len(plans) == PLANS:
                break
        attempt(rest.pop(0), alone)
        if len(failures) == CHANCES and not plans:
            rest.sort(key=lambda start: start.cost < math.inf)
        if _is_over(collocation, began):
            break
    if not (plans or alone or _is_over(collocation, began)):
        attempt(max(starts, key=lambda start: start.cost), True)
    if not plans:
        raise failures[-1]
    plans.sort(key=lambda plan: plan.objective)
    rest = [start for start in rest if start.cost < math.inf]
    least = plans[0].objective
    costs = [plan.objective for plan in plans[1:]] + [start.cost for start in rest]
    dearer = [cost for cost in costs if cost > (1 + AGAIN) * least]
    # A coarse motion that cost less, but led to no plan in its part of the time.
    is_cut = _is_over(collocation, began) or min(start.cost for start in starts) * CLOSE < least
    tried = Tried(ways, swings, min(dearer, default=None), is_cut)
    seconds = time.perf_counter() - began[0]
    others = *plans[1:], *(partial(refined, start, collocation) for start in rest[:PLANS])
    return replace(plans[0], tried=tried, others=others, solve_time=seconds)


def refined(
    start: Start,
    collocation: Collocation,
    began: tuple[float, float] | None = None,
    insists: bool = True,
) -> Plan:
    """Return the accurate plan that a start leads to; PlanError.

    began: when the search did, s by the clock and of this thread; by default now. insists: try
    again where IPOPT does not converge, and find out which limits cannot be met.
    """
    search = _PlanSearch(start.problem, collocation, began or _now(), insists)
    plan = search.run(start.mesh, start.durations, start.guess)
    return refuse_broken(plan, collocation.tolerance)


def _now():
    return time.perf_counter(), time.thread_time()


def _is_over(collocation, began):
    return time.thread_time() - began[1] > collocation.max_time


class _PlanSearch:
    """Solve, refine the mesh where the plan is inaccurate, solve again; or name what is wrong."""

    def __init__(self, problem, collocation, began, insists=True):
        self.problem = problem
        self.collocation = collocation
        self.began = began
        self.insists = insists
        self.tolerance = collocation.tolerance
        self.intervals = {}
        self.meshes = []
        self.best = None
        self.refinements = 0  # best: the last converged plan

    def run(self, mesh, durations, guess):
        self.first = durations, guess
        found, plan = self.solved(mesh, durations, guess)
        while (parts := self.parts(plan)) is not None:
            mesh, found, plan = self.refine(mesh, found, plan, parts)
        return plan

    def parts(self, plan):
        """Return into how many parts to divide each interval; None where the plan is accurate."""
        excess = np.nan_to_num(plan._relative_defects, nan=1.0)  # nan: out of reach between nodes
        for name, value in plan._exceeded.items():
            excess = np.fmax(excess, value.max(axis=1) / self.problem.unit(name))
        order = len(self.problem.scheme.c)  # of the defect between nodes
        needed = np.ceil((2 * excess / self.tolerance) ** (1 / order))
        parts = np.clip(needed, 2, MOST_PARTS).astype(int)
        parts[excess <= self.tolerance] = 1
        return parts if parts.max() > 1 else None

    def refine(self, mesh, found, plan, parts):
        """Return (mesh, PlanSolution, Plan) on the divided mesh."""
        self.refinements += 1
        if parts.sum() > MOST_INTERVALS or self.refinements == REFINEMENTS:
            reason = (
                f"not accurate: error {plan.error:.3g} between nodes on {len(parts)} intervals, "
                f"{self.tolerance:g} is allowed"
            )
            raise self.failure(plan, reason, plan.status)
        mesh = _refined(mesh, parts)
        return mesh, *self.solved(mesh, found.durations, guess_again(plan, found))

    def solved(self, mesh, durations, guess):
        found, plan = self.solve(mesh, durations, guess)
        if not (found.solved or self.insists):
            reason = f"IPOPT did not converge ({found.status})"
            raise self.failure(self.best or plan, reason, found.status)
        if found.status == "Maximum_Iterations_Exceeded":  # begun afresh near its end, it converges
            found, plan = self.solve(mesh, found.durations, guess_again(plan, found))
        return (found, plan) if found.solved else self.recover(mesh, found, plan)

    def solve(self, mesh, durations, guess, elastic=False):
        most = self.collocation.max_time
        left = most - (time.thread_time() - self.began[1])
        if not self.insists:
            left = min(left, PART * most)
        if elastic not in self.intervals:
            self.intervals[elastic] = Interval(self.problem, mesh, durations, guess, elastic)
        found = solve(self.intervals[elastic], mesh, durations, guess, left)
        plan = Plan(self.problem, found.pieces, found.objective, found.status)
        done = len(plan.pieces.xi), found.iterations, found.objective, plan.error
        seconds = time.perf_counter() - self.began[0]  # what a user waits
        self.meshes.append(PlanMesh(*done, seconds))
        plan = replace(plan, meshes=tuple(self.meshes), solve_time=seconds)
        if found.solved and not elastic:
            self.best = plan
        if _is_over(self.collocation, self.began):
            reason = f"no solution within max_time = {self.collocation.max_time:g} s"
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
        found, plan = self.solve(mesh, best.durations, guess_again(nearest, best))
        if not found.solved:
            reason = f"IPOPT did not converge ({failed.status}, then {found.status})"
            raise self.failure(self.best or plan, reason, found.status)
        return found, plan

    def failure(self, plan, reason, status, names=(*LIMITS, "reach"), least=()):
        if self.problem.own is not None and "functions" in names:
            names = *names, *self.problem.own.constraints
            if reason.startswith("IPOPT"):
                reason += " (functions of your own need slopes that do not jump, as at a root of 0)"
        broken = {name: value for name, value in plan.violations.items() if name in names}
        broken.update(least)
        why = f"{reason}{self.problem.listed(broken)}"
        return PlanError(f"plan: {why}", broken, plan, status)


def _refined(mesh, parts):
    """Divide each interval into so many parts."""
    ends = np.cumsum([len(knots) - 1 for knots in mesh])
    finer = []
    for knots, own in zip(mesh, np.split(parts, ends)):
        place = np.append(0, np.cumsum(own))
        finer.append(np.interp(np.arange(place[-1] + 1), place, knots))
    return finer
