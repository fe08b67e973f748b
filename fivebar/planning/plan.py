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
from ..base.progress import progress
from ..base.robot_uses import takes_robot
from ..constraints.constraints import Constraints, kept_by
from ..constraints.load import too_heavy
from ..models.geometry import Pose, igm
from ..models.physics import loads_of
from ..singularities.degenerate import refuse_singular_everywhere
from .collocation import LIMITS, Scheme
from .functions import OwnFunctions
from .guess import GuessAgain, first_guess, in_bars
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
    timed,
    working_modes,
)
from .program import Interval, solve
from .search import ways_between
from .starts import Start, mesh_of, starts_between

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ..models.robots import Robot

LEAST_SIN = 0.05  # that a motion in one pair of working modes keeps by default
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
    constraints = Constraints() if constraints is None else constraints
    collocation = Collocation() if collocation is None else collocation
    clock = _Clock(collocation)
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
    if duration is not None and not (weights["effort"] or weights["jerk"] or (own and own.costs)):
        raise ValueError(
            'plan: with a duration all motions take as long: leave it out, or weigh "effort" too'
        )
    if free and not (weights["effort"] or constraints.torque or (own and own.costs)):
        raise ValueError(
            "plan: between Poses a motion may cross a Type-2 singularity, where without a torque"
            ' among the constraints or a weight on "effort" the torque has no bound; or keep the'
            " modes, by the constraint sin"
        )
    if free:
        ways = ways_between(robot, timed(start, goal, duration, via), constraints)
        if not ways:
            raise PlanError(
                "plan: no way from start to goal was found: give a Pose between them as via", {}
            )
        problems = [
            (Problem(robot, stops, None, weights, constraints, rule, own), paths)
            for stops, paths, _ in ways
        ]
        refuse_massless(problems[0][0])
        starts, swings = starts_between(problems, collocation.intervals, clock.is_over)
        return _best(starts, clock, len(ways), swings)
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
    return _best(*_along_points(problem, clock))


def _along_points(problem, clock):
    """Return starts, the clock, and how many ways and swings were tried.

    A robot with weight is improved in its four bars, as between Poses: motions that fall, swing up
    again or wait may cost a fifth of the straight one, which is the last resort there.
    """
    guess, durations = first_guess(problem)
    intervals = clock.collocation.intervals
    straight = Start(problem, mesh_of(intervals, durations), durations, guess)
    if not problem.fall or not problem.rests:
        return [straight], clock
    ways = in_bars(problem)
    starts, swings = starts_between(ways, intervals, clock.is_over)
    improved = [start for start in starts if start.cost < math.inf]
    return [*improved, straight], clock, len(ways), swings


def _best(starts, clock, ways=1, swings=0):
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
    dearer = [each.cost for each in (*begun, *rest) if each.cost > (1 + AGAIN) * least]
    is_cut = is_over() or min(lost) < least
    tried = Tried(ways, swings, min(dearer, default=None), is_cut)
    left = [search.again for search in begun if search.plan is not plans[0]] + rest
    others = tuple(partial(_refined, start, clock.collocation) for start in left[:ALTERNATIVES])
    return replace(plans[0], tried=tried, others=others, solve_time=clock.seconds)


def _refined(start, collocation):
    """Return the accurate plan that a start leads to; PlanError."""
    search = _PlanSearch(start, _Clock(collocation))
    search.begin()
    while not search.accurate:
        search.step()
    return search.plan


class _Clock:
    """The time since a search began, and what is left of it; a bar shows its steps."""

    def __init__(self, collocation):
        self.collocation = collocation
        self.began = time.perf_counter()
        self.worked = time.thread_time()
        self.bar = progress(desc="plan", unit=" steps", delay=2, leave=False)

    @property
    def seconds(self):
        """The time, s, that a user has waited."""
        return time.perf_counter() - self.began

    @property
    def left(self):
        """The processor time, s, that is left."""
        return self.collocation.max_time - (time.thread_time() - self.worked)

    def is_over(self):
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
