"""Optimal motions by direct collocation with the bar forces as controls: they may cross Type-2
singularities.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, modes, number, one_of, optional, positive, takes, whole
from ..base.checks import robot as must_be_robot
from ..constraints.constraints import Keep
from ..models.geometry import Pose, igm
from .collocation import LIMITS, METHODS, scheme
from .guess import first_guess, guess_again
from .plans import Mesh, Plan
from .problem import (
    LOOKED_AT,
    Limits,
    PlanError,
    Problem,
    box,
    checked_stops,
    checked_weights,
    per_joint,
    point_of,
    refuse_broken,
    refuse_massless,
    refuse_stops,
)
from .program import solve
from .search import ways_between

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..models.robots import Robot

REFINEMENTS, MOST_INTERVALS, MOST_PARTS = 12, 600, 8
GUESSING = 60  # iterations of IPOPT from one of several first guesses
LIFTS = 0.03, 0.1, 0.3, 0.6  # of gravity, under which motions of the four bars are sought first
BETTER = 0.01  # of the objective
WORK = 6000  # points times iterations of IPOPT, about what a processor does in 1 s
# Times the shortest way from which a plan was found: effort goes as the square of a way's length.
LONGEST = 1.6


@takes(
    robot=must_be_robot,
    torque_limit=optional(per_joint),
    joint_speed_limit=optional(per_joint),
    acceleration_limit=optional(positive),
    workspace=optional(box),
    working=optional(modes(2)),
    method=one_of(*METHODS),
    degree=whole(2, 7),
    intervals=whole(2, MOST_INTERVALS),
    tolerance=lambda value, name: number(value, name, 1e-9, 1.0),
    max_time=positive,
    keep=optional(instance(Keep)),
)
def plan(
    robot: Robot,
    start: ArrayLike | dict | Pose,
    goal: ArrayLike | dict | Pose,
    duration: float | None = None,
    *,
    via: Iterable = (),
    objective: str | dict[str, float] = "effort",
    torque_limit: ArrayLike | None = None,
    joint_speed_limit: ArrayLike | None = None,
    acceleration_limit: float | None = None,
    workspace: ArrayLike | None = None,
    serial_margin: float | None = None,
    parallel_margin: float | None = None,
    working: tuple[int, int] | None = None,
    method: str = "legendre-gauss",
    degree: int = 3,
    intervals: int = 20,
    tolerance: float = 1e-3,
    max_time: float = 30.0,
    keep: Keep | None = None,
) -> Plan:
    """Plan an optimal motion, through singularities where that is better or the only way: Plan.

    start, goal: points (2,) m, at rest there, or {order: (x, y)} as in `polynomial`: the motion
        keeps its working modes and may cross Type 2. Or Poses, at rest: modes are free on the way,
        Type 1 and Type 2 are crossed as often as needed; a point beside a Pose may be reached in
        any mode.
    duration: s, None: free.
    via: points to pass, [(time or None, (2,) or {order: ...}), ...], in this order; between Poses,
        Poses.
    objective: "effort" (integral of tau^2), "time", "jerk" (integral of |xi'''|^2), or {name:
        weight >= 0} on their SI values.
    torque_limit, joint_speed_limit: N m and rad/s, one number or one per joint.
    acceleration_limit: m/s^2, of the end-effector.
    workspace: ((x low, x high), (y low, y high)) m.
    serial_margin: least |sin q_i2|; None: 0.05 between points, none between Poses.
    parallel_margin: least |det A|, None: may cross, which wants some effort in the objective, or
        else a torque_limit.
    working: the modes to keep, None: (-1, -1) between points, free between Poses.
    method: "legendre-gauss" with `degree` points in each interval, or "hermite-simpson".
    intervals: of the mesh at first.
    tolerance: to which it is refined: largest defect over the largest force, and what may be missed
        of a limit between nodes (torque and acceleration never are).
    max_time: s of the processor, first guesses by a count of work (`WORK`): a busy machine finds
        the same.
    keep: what else must be kept. Its least sines, joint limits, half-planes, convex region and the
        distances of bars are limits of the program; between nodes, and a region that is not convex,
        the plan is asked: PlanError where it is broken.
    ValueError for what cannot be asked, UnreachableError for points out of reach, PlanError where
    no plan was found.
    """
    began = time.perf_counter(), time.thread_time()
    free = working is None and (isinstance(start, Pose) or isinstance(goal, Pose))
    if serial_margin is None and not free:
        serial_margin = 0.05
    if keep is not None:
        serial_margin = max(serial_margin or 0.0, keep.sin) or None
        parallel_margin = max(parallel_margin or 0.0, keep.det_A) or None
    limits = Limits(
        torque_limit,
        joint_speed_limit,
        acceleration_limit,
        workspace,
        None if serial_margin is None else number(serial_margin, "plan: serial_margin", 1e-3, 1),
        (
            None
            if parallel_margin is None
            else number(parallel_margin, "plan: parallel_margin", 1e-9, 1)
        ),
    )
    weights = checked_weights(objective)
    if duration is None and not weights["time"]:
        raise ValueError(
            'plan: a free duration needs a weight on "time": the longer, the less effort and jerk'
        )
    if duration is None and not (
        weights["effort"] or weights["jerk"] or limits.torque or limits.acceleration
    ):
        raise ValueError(
            "plan: minimum time needs a torque_limit or an acceleration_limit: without, it is 0"
        )
    rule = scheme(method, degree)
    if free:
        if limits.serial is not None:
            raise ValueError("plan: serial_margin keeps the working modes: give them as working=")
        ways = ways_between(robot, start, goal, duration, via)
        problems = [
            (Problem(robot, stops, None, weights, limits, rule, keep), paths, length)
            for stops, paths, length in ways
        ]
        return refuse_broken(_best(problems, intervals, tolerance, max_time, began), tolerance)
    working = working or (-1, -1)
    start, goal = (
        point_of(point, working, name) for point, name in ((start, "start"), (goal, "goal"))
    )
    problem = Problem(
        robot, checked_stops(start, goal, duration, via), working, weights, limits, rule, keep
    )
    refuse_massless(problem)
    refuse_stops(problem)
    sides = {np.sign(igm(robot, conditions[0], working).det_A) for conditions, _ in problem.stops}
    if sides >= {-1.0, 1.0} and not weights["effort"] and limits.torque is None:
        raise ValueError(
            "plan: this motion must cross a Type-2 singularity, where without torque_limit or a"
            ' weight on "effort" the torque has no bound'
        )
    guess, durations = first_guess(problem)
    found = _Search(problem, tolerance, max_time, began).run(
        _mesh(intervals, durations), durations, guess
    )
    return refuse_broken(found, tolerance)


def _mesh(intervals, durations):
    share = np.maximum(np.round(intervals * durations / durations.sum()).astype(int), 2)
    return [np.linspace(0, 1, n + 1) for n in share]


def _best(problems, intervals, tolerance, max_time, began):
    """The plan refined from the best of what first guesses lead to, of (problem, paths, length),
    the shortest first.
    """
    found, tried, last, work = [], 0, None, 0
    for problem, paths, length in problems:
        refuse_massless(problem)
        if found and (length > LONGEST * found[0][-1] or work > WORK * max_time / 3):
            break
        guess, durations = first_guess(problem, paths)
        search, mesh = _Search(problem, tolerance, max_time, began), _mesh(intervals, durations)
        tried += 1
        try:
            durations, guess = search.first = search.lifted(mesh, durations, guess)
            solution, plan = search.solve(mesh, durations, guess, iterations=GUESSING)
        except PlanError as error:
            last = error
            break
        work += sum(each.intervals * each.iterations for each in search.meshes) * len(
            problem.scheme.c
        )
        if solution.solved:
            found.append((plan.objective, tried, search, mesh, solution, plan, length))
        last = last or search.failure(
            plan, f"IPOPT did not converge ({solution.status})", solution.status
        )
    # A coarse mesh flatters: the one that looks best is refined, until another looks better by more
    # than BETTER.
    now = None
    while found:
        now = min(found, key=lambda each: (each[0] * (1 - BETTER * (each[1] == now)), each[1]))[1]
        k = next(k for k, each in enumerate(found) if each[1] == now)
        _, _, search, mesh, solution, plan, length = found[k]
        parts = search.parts(plan)
        if parts is None:
            return replace(plan, tried=tried)
        try:
            mesh, solution, plan = search.refine(mesh, solution, plan, parts)
            found[k] = plan.objective, now, search, mesh, solution, plan, length
        except PlanError as error:
            last = error
            del found[k]
    raise last or PlanError("plan: no first guess leads from start to goal", {})


class _Search:
    """Solve, refine the mesh where the plan errs, solve again; or find out what is wrong."""

    def __init__(self, problem, tolerance, max_time, began):
        self.problem, self.tolerance, self.max_time, self.began = (
            problem,
            tolerance,
            max_time,
            began,
        )
        self.meshes, self.best, self.refinements = [], None, 0  # best: the last converged plan

    def lifted(self, mesh, durations, guess):
        """(durations, guess), from the motions under less gravity where there is some: it grows by
        and by.
        """
        for share in LIFTS if self.problem.fall else ():
            robot = self.problem.robot
            lighter = replace(robot, gravity=tuple(share * g for g in robot.gravity))
            search = _Search(
                replace(self.problem, robot=lighter), self.tolerance, self.max_time, self.began
            )
            found, plan = search.solve(mesh, durations, guess, iterations=GUESSING)
            self.meshes += search.meshes
            if found.solved:
                durations, guess = found.durations, guess_again(plan, found)
        return durations, guess

    def run(self, mesh, durations, guess):
        self.first = durations, guess
        found, plan = self.solved(mesh, durations, guess)
        while (parts := self.parts(plan)) is not None:
            mesh, found, plan = self.refine(mesh, found, plan, parts)
        return plan

    def parts(self, plan):
        """Into how many parts each interval is to be divided; None where the plan is accurate."""
        excess = np.nan_to_num(plan._relative_defects, nan=1.0)  # nan: out of reach between nodes
        for name, value in plan._exceeded.items():
            excess = np.fmax(excess, value.max(axis=1) / self.problem.unit(name))
        order = len(self.problem.scheme.c)  # of the defect between nodes
        parts = np.clip(
            np.ceil((2 * excess / self.tolerance) ** (1 / order)), 2, MOST_PARTS
        ).astype(int)
        parts[excess <= self.tolerance] = 1
        return parts if parts.max() > 1 else None

    def refine(self, mesh, found, plan, parts):
        """(mesh, Solution, Plan) on the divided mesh."""
        self.refinements += 1
        if parts.sum() > MOST_INTERVALS or self.refinements == REFINEMENTS:
            raise self.failure(
                plan,
                f"not accurate: error {plan.error:.3g} between nodes on {len(parts)} intervals, "
                f"{self.tolerance:g} is allowed",
                plan.status,
            )
        mesh = _refined(mesh, parts)
        return mesh, *self.solved(mesh, found.durations, guess_again(plan, found))

    def solved(self, mesh, durations, guess):
        found, plan = self.solve(mesh, durations, guess)
        return (found, plan) if found.solved else self.recover(mesh, found, plan)

    def solve(self, mesh, durations, guess, elastic=False, iterations=None):
        left = self.max_time - self.worked
        found = solve(self.problem, mesh, durations, guess, left, elastic, iterations)
        plan = Plan(self.problem, found.pieces, found.objective, found.status)
        self.meshes.append(
            Mesh(len(plan.pieces.xi), found.iterations, found.objective, plan.error, self.elapsed)
        )
        plan = replace(plan, meshes=tuple(self.meshes), solve_time=self.elapsed)
        if found.solved and not elastic:
            self.best = plan
        if self.worked > self.max_time:
            raise self.failure(
                self.best or plan,
                f"no solution within max_time = {self.max_time:g} s",
                found.status,
            )
        return found, plan

    elapsed = property(lambda self: time.perf_counter() - self.began[0])  # what a user waits
    worked = property(lambda self: time.thread_time() - self.began[1])

    def recover(self, mesh, failed, plan):
        """Begin afresh; else meet the limits as well as can be, and where that meets them, try
        again from there.
        """
        if len(self.meshes) > 1:
            found, plan = self.solve(mesh, *self.first)
            if found.solved:
                return found, plan
        best, nearest = self.solve(mesh, *self.first, elastic=True)
        if not best.solved:
            raise self.failure(
                self.best or plan,
                f"IPOPT did not converge ({failed.status}, then {best.status})",
                failed.status,
            )
        if best.slack.max() > self.tolerance:
            names = [name for name, slack in zip(LIMITS, best.slack) if slack > 1e-6]
            raise self.failure(nearest, "infeasible", failed.status, names)
        found, plan = self.solve(mesh, best.durations, guess_again(nearest, best))
        if not found.solved:
            raise self.failure(
                self.best or plan,
                f"IPOPT did not converge ({failed.status}, then {found.status})",
                found.status,
            )
        return found, plan

    def failure(self, plan, reason, status, names=(*LIMITS, "reach")):
        broken = {name: value for name, value in plan.violations.items() if name in names}
        why = f"{reason}{self.problem.listed(broken)}{self.unbounded(plan)}"
        if self.problem.keep and self.problem.keep.bars:
            why += (
                "; bars that must not meet may leave no way between the ends, or one that points of"
                " via have to show"
            )
        words = f"plan: {why}; the best motion found is attached as .plan"
        return PlanError(words, broken, plan, status)

    def unbounded(self, plan):
        """That the motion crosses Type 2 and nothing bounds its torque there, in words; empty where
        it is not so.
        """
        if self.problem.weights["effort"] or self.problem.limits.torque is not None:
            return ""
        t = np.linspace(plan.start, plan.start + plan.duration, LOOKED_AT)
        with np.errstate(all="ignore"):
            det_a = self.problem.accelerations(plan.motion(t)).rates.pose.det_A
        count = np.count_nonzero(np.diff(np.sign(det_a[np.isfinite(det_a)])))
        if not count:
            return ""
        return (
            f"; it crosses Type 2 ({count} times), where without a torque_limit or a weight on"
            ' "effort" the torque has no bound: give one of them, or a parallel_margin that'
            " keeps off"
        )


def _refined(mesh, parts):
    """Divide each interval into so many parts."""
    finer, k = [], 0
    for knots in mesh:
        own = parts[k : k + len(knots) - 1]
        k += len(own)
        place = np.concatenate([[0], np.cumsum(own)])
        finer.append(np.interp(np.arange(place[-1] + 1), place, knots))
    return finer
