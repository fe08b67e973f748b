"""Optimal motions by direct collocation with the bar forces as controls: they may cross Type-2
singularities.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, number, optional, positive, whole
from ..base.robot_uses import takes_robot
from ..constraints.constraints import Constraints, kept_by
from ..models.geometry import Pose, igm
from ..singularities.degenerate import refuse_singular_everywhere
from .best_plan import MOST_INTERVALS, Clock, best_plan
from .collocation import Scheme
from .functions import OwnFunctions
from .guess import first_guess, in_bars
from .plans import Plan
from .problem import (
    PlanError,
    Problem,
    checked_stops,
    checked_weights,
    own_costs,
    point_of,
    refuse_massless,
    refuse_stops,
    timed,
    working_modes,
)
from .search import ways_between
from .starts import Start, mesh_of, starts_between

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ..models.robots import Robot

LEAST_SIN = 0.05  # that a motion in one pair of working modes keeps by default


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
    clock = Clock(collocation)
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
        return best_plan(starts, clock, len(ways), swings)
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
    return best_plan(*_along_points(problem, clock))


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
