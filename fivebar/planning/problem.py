"""The problem of `plan`: stops, weights and constraints, their checks and their violations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ..base.backend import pack, unpack
from ..base.checks import not_negative, positive, shown, two_numbers
from ..base.errors import SingularityError, UnreachableError
from ..constraints.constraints import Constraints, at_joints
from ..models.dynamics import bar_forces, drives_forces
from ..models.geometry import Pose, igm
from ..models.kinematics import Accelerations, ikm
from ..models.physics import loads_of, smoothed
from .coordinates import BarCoordinates, TaskCoordinates
from .functions import OwnFunctions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ..models.robots import Robot
    from .collocation import Scheme
    from .plans import Plan

# rad/s, below which a plan smooths dry friction. The error of that friction, and of following the
# plan, goes as it does; four times as large, plans take half as long; a fifth of it, they take six
# times as long or are not found.
SLOW = 0.05
LOOKED_AT = 401  # times of a plan, for what may be wrong with it
OBJECTIVES = ("effort", "time", "jerk")


class PlanError(RuntimeError):
    """No plan was found.

    Attributes
    ----------
    plan : Plan or None
        The best motion, which is not optimal or not feasible.
    violations : dict
        By how much it exceeds each limit, SI.
    status : str
        IPOPT's return status where it did not solve.

    Examples
    --------
    >>> import fivebar as fb
    >>> try:
    ...     fb.plan(fb.FiveBar(), (0.09, 0.068), (9.0, 9.0), 1.0)
    ... except (fb.PlanError, fb.UnreachableError) as error:
    ...     "goal" in str(error)
    True
    """

    def __init__(
        self, message: str, violations: dict[str, float], plan: Plan | None = None, status: str = ""
    ) -> None:
        super().__init__(message)
        if plan is not None:
            # Tracebacks show it; who typed a command could not reach it.
            self.add_note("The best motion found is attached as .plan.")
        self.violations = violations
        self.plan = plan
        self.status = status


@dataclass(frozen=True, eq=False)
class Problem:
    """Stops, weights and constraints of a plan.

    stops: (conditions by order of derivative, time or None), as of `trajectory.polynomial`, of the
    end-effector or of the four bars.
    """

    robot: Robot
    stops: tuple
    working: Any  # (2,); None: free
    weights: dict[str, Any]
    constraints: Constraints
    scheme: Scheme
    own: OwnFunctions | None = None
    slow: float = SLOW

    @cached_property
    def timed(self) -> list[tuple[int, float]]:
        """Return (number, time) of the stops whose time is given."""
        return [(k, t) for k, (_, t) in enumerate(self.stops) if t is not None]

    @property
    def has_own_cost(self) -> bool:
        return self.own is not None and bool(self.own.costs)

    @property
    def rests(self) -> bool:
        """Whether nothing but places are given, and rest at both ends."""
        return not any(
            order and (np.any(value) or order > 1)
            for conditions, _ in self.stops
            for order, value in conditions.items()
        )

    @property
    def length(self) -> float:
        return sum(self.robot.distal) / 2

    @property
    def lever(self) -> float:
        """Return the length by which a joint's rate is a speed, m; 1 where it slides."""
        return self.length if self.robot.turns else 1.0

    @cached_property
    def model(self) -> Robot:
        """The robot that is planned with: its dry friction smoothed, as an optimisation needs
        slopes.
        """
        return smoothed(self.robot, self.slow * (1.0 if self.robot.turns else self.length))

    @property
    def mass(self) -> float:
        # Grouped parameters may be negative.
        turning = sum(map(abs, self.robot.inertias))
        return abs(self.robot.m) + turning / self.lever**2

    @property
    def fall(self) -> float:
        """Return the acceleration of gravity, m/s^2."""
        return math.hypot(*loads_of(self.robot).gravity)

    @property
    def fall_rate(self) -> float:
        """Return 1 over the time, s, in which a bar falls by half of its length; 0: no weight."""
        return math.sqrt(self.fall / self.length)

    @cached_property
    def side(self) -> float:
        """Return the sign of det A at the start, which a limit on it keeps."""
        at = np.array(self.stops[0][0][0])
        motion = np.append(at, np.zeros(2 * len(at)))
        return float(np.sign(self.accelerations(motion).rates.pose.det_A)) or 1.0

    def signed_sines(self, pose: Pose) -> tuple:
        """Return -w_i sin q_i2 of both legs and det A, all positive at the start."""
        modes = self.working or (1, 1)
        left, right = pose.sines
        return (-modes[0] * left, -modes[1] * right, self.side * pose.det_A)

    def violations(
        self,
        q_dot: np.ndarray | None = None,
        xi_ddot: np.ndarray | None = None,
        tau: np.ndarray | None = None,
        sines: tuple | None = None,
    ) -> dict[str, np.ndarray]:
        """Return by how much quantities (..., 2) exceed their limits, <= 0 where they hold."""
        limits = self.constraints
        excess = {}
        if tau is not None and limits.torque:
            excess["torque"] = (np.abs(tau) - limits.torque).max(axis=-1)
            if limits.motors:
                beyond = limits.torque_share(tau, q_dot) - 1
                excess["torque"] = np.maximum(excess["torque"], beyond * np.max(limits.torque))
        if q_dot is not None and limits.joint_speed:
            excess["joint_speed"] = (np.abs(q_dot) - limits.joint_speed).max(axis=-1)
        if xi_ddot is not None and limits.acceleration:
            excess["acceleration"] = np.linalg.norm(xi_ddot, axis=-1) - limits.acceleration
        if sines is not None:
            if limits.sin:
                excess["sin"] = limits.sin - np.minimum(sines[0], sines[1])
            if limits.det_A:
                excess["det_A"] = limits.det_A - sines[2]
        return excess

    def margins(self, acc: Accelerations, tau: Any) -> dict[str, Any]:
        """Return {limit: CasADi's symbols, >= 0 where it is kept} of a motion under torques."""
        limits = self.constraints
        pose = acc.rates.pose
        *sines, det_A = self.signed_sines(pose)
        q_dot = acc.rates.q_dot
        kept: dict[str, Any] = {}
        if limits.sin:
            kept["sin"] = ca.vertcat(*sines) - limits.sin
        if limits.det_A:
            kept["det_A"] = det_A - limits.det_A
        shares = {}
        if limits.torque is not None:
            shares["torque"] = tau / ca.DM(np.asarray(limits.torque))
        if limits.motors is not None:
            stall, speed = at_joints(limits.motors)
            shares["motors"] = tau / ca.DM(stall) + q_dot / ca.DM(speed)
        if limits.joint_speed is not None:
            shares["joint_speed"] = q_dot / ca.DM(np.asarray(limits.joint_speed))
        for name, share in shares.items():
            kept[name] = ca.vertcat(1 - share, 1 + share)
        if limits.acceleration is not None:
            kept["acceleration"] = 1 - ca.sumsqr(acc.xi_ddot) / limits.acceleration**2
        kept["poses"] = ca.vertcat(*limits.smooth(pose, self.length))
        return kept

    def unit(self, name: str) -> float:
        """Return what a violation is compared with: the limit, a bar's length, or a sine of 1."""
        if name in ("torque", "joint_speed", "acceleration"):
            return float(np.max(getattr(self.constraints, name)))
        return self.length if name in ("region", "reach") else 1.0

    @property
    def in_bars(self) -> bool:
        """Whether the stops are those of the four bars."""
        return len(self.stops[0][0][0]) == BarCoordinates.size

    @property
    def coordinates(self) -> TaskCoordinates | BarCoordinates:
        return BarCoordinates() if self.in_bars else TaskCoordinates(self.working)

    def accelerations(self, motion: np.ndarray, robot: Robot | None = None) -> Accelerations:
        """Return the Accelerations of a motion (..., 3 size or more); nan out of reach."""
        return self.coordinates.accelerations(robot or self.robot, motion)

    def bar_forces(self, acc: Accelerations, tau: Any) -> Any:
        """Return the forces (..., 2), N, in the distal bars of a motion under torques (..., 2).

        Of the end-effector's coordinates they are B^-1 (tau - Z q''), of the four bars those of
        `dynamics.bar_forces`, of numbers or symbols.
        """
        if self.in_bars:
            return bar_forces(acc.rates, tau)
        return pack(*drives_forces(acc, unpack(tau, "tau")))

    def listed(self, violations: dict[str, float]) -> str:
        """Return the violated limits as a part of a message."""
        own = self.robot.words
        units = {
            "torque": own.effort_unit,
            "joint_speed": f"{own.unit}/s",
            "acceleration": "m/s²",
            "reach": "m",
        }
        words = []
        for name, value in violations.items():
            if value > 1e-6 * self.unit(name):
                limit = getattr(self.constraints, name, None)
                bound = "" if limit is None else f" (limit {np.max(limit):.6g})"
                quantity = own.effort if name == "torque" else name
                excess = f"{quantity} by {value:.4g} {units.get(name, '')}"
                words.append(excess.rstrip() + bound)
        return f"; violated: {', '.join(words)}" if words else ""


def refuse_massless(problem: Problem) -> None:
    """Raise where no motion of the robot costs anything."""
    if not problem.mass:
        words = problem.robot.words
        names = ", ".join(("m", *words.inertias))
        raise ValueError(
            f"plan: this robot has no inertia ({names} are 0): no motion costs a {words.effort}"
        )


def working_modes(start: object, goal: object) -> tuple[int, int]:
    """Return the working modes of the Poses among start and goal; ValueError if they differ."""
    modes = [
        (int(point.working[0]), int(point.working[1]))
        for point in (start, goal)
        if isinstance(point, Pose)
    ]
    if modes[0] != modes[-1]:
        raise ValueError(
            f"plan: start is a Pose in working modes {modes[0]}, goal in {modes[-1]}: a motion that"
            " keeps |sin q_i2| > 0 cannot change them; leave out sin"
        )
    return modes[0]


def point_of(point: object) -> object:
    """Return a Pose as its point, and anything else as it is."""
    return tuple(point.xi.tolist()) if isinstance(point, Pose) else point


def refuse_pose(constraints: Constraints, name: str, pose: Pose) -> None:
    """Raise PlanError where the pose of a stop does not keep a constraint."""
    for what, clearance in constraints.clearances(pose).items():
        if clearance < -1e-12:
            raise PlanError(
                f"plan: infeasible: {name} itself does not keep {what}: by {-clearance:.3g}",
                {what: float(-clearance)},
            )


def refuse_stops(problem: Problem) -> None:
    """Raise where a stop is out of reach or breaks a limit by itself."""
    for name, (conditions, _) in zip(stop_names(len(problem.stops)), problem.stops):
        try:
            pose = igm(problem.robot, conditions[0], problem.working)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"plan: {name}: {error}",)
            raise
        refuse_pose(problem.constraints, name, pose)
        _refuse_other_side(problem, name, float(pose.det_A))
        q_dot = ikm(pose, conditions.get(1, (0.0, 0.0))).q_dot
        xi_ddot = np.array(conditions.get(2, (0.0, 0.0)))
        found = problem.violations(q_dot, xi_ddot, sines=problem.signed_sines(pose))
        found = {key: max(float(value), 0.0) for key, value in found.items()}
        if any(value > 1e-9 * problem.unit(key) for key, value in found.items()):
            raise PlanError(
                f"plan: infeasible: {name} itself breaks limits{problem.listed(found)}", found
            )


def _refuse_other_side(problem, name, det_A):
    """Raise where a limit on det A parts a stop from the start, whatever the path between them."""
    least = problem.constraints.det_A
    if least and problem.side * det_A < 0:
        sign = "positive" if problem.side > 0 else "negative"
        raise PlanError(
            f"plan: infeasible: {name} is on the other side of Type 2 than the start: det A ="
            f" {det_A:.3g} there, and it is {sign} at the start. With the constraint det_A ="
            f" {least:.3g} no motion may cross Type 2: leave it out, or change {name}",
            {"det_A": least - problem.side * det_A},
        )


def refuse_broken(plan: Plan, tolerance: float) -> Plan:
    """Return the plan; PlanError where it violates a constraint on poses.

    The tolerance is a share of a bar's length, or a number of radians.
    """
    constraints = plan.problem.constraints
    t = np.linspace(plan.start, plan.start + plan.duration, LOOKED_AT)
    with np.errstate(all="ignore"):
        clearances = constraints.clearances(plan.problem.accelerations(plan.motion(t)).rates.pose)
    violated = {}
    for name, clearance in clearances.items():
        k = int(np.argmin(clearance))
        unit = 1.0 if name.startswith(("|", "joint")) else plan.problem.length
        if -clearance[k] > tolerance * unit:
            violated[f"{name} (t = {t[k]:.4g} s)"] = float(-clearance[k])
    if violated:
        excesses = [f"{name}: by {by:.3g}" for name, by in violated.items()]
        words = ", ".join(excesses)
        message = f"plan: the best motion found does not keep {words}"
        raise PlanError(message, violated, plan)
    return plan


def stop_names(count: int) -> list[str]:
    """Return the names of so many stops."""
    between = [f"via[{k}]" for k in range(count - 2)]
    return ["start", *between, "goal"]


def timed(start: object, goal: object, duration: float | None, via: Iterable) -> list[tuple]:
    """Return [(name, time or None, point), ...] of all stops, in the order of their times."""
    try:
        via = [(t, point) for t, point in via]
        if any(isinstance(point, Real) for _, point in via):
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(
            f"plan: via must be [(time or None, point), ...], not {shown(via)}"
        ) from None
    stops: list[tuple] = [("start", 0.0, start)]
    last, of_last = 0.0, ""
    names = stop_names(len(via) + 2)[1:]
    for name, (t, point) in zip(names, [*via, (duration, goal)]):
        if t is not None:
            words = "plan: duration" if name == "goal" else f"plan: the time of {name}"
            t = positive(t, words)
            if t <= last:
                raise ValueError(f"{words} = {t:g} s is not after {of_last}, {last:g} s")
            last, of_last = t, words.removeprefix("plan: ")
        stops.append((name, t, point))
    return stops


def checked_stops(start: object, goal: object, duration: float | None, via: Iterable) -> tuple:
    """Return ((conditions, time or None), ...); ValueError for stops that are none."""
    stops = []
    for name, t, point in timed(start, goal, duration, via):
        if not isinstance(point, dict):
            point = {0: point} | ({} if name.startswith("via") else {1: (0.0, 0.0)})
        if 0 not in point or not set(point) <= {0, 1, 2}:
            raise ValueError(
                f"plan: {name} needs a position under order 0, and no other orders than 1 and 2"
            )
        conditions = {
            order: two_numbers(value, f"plan: {name}, order {order},")
            for order, value in point.items()
        }
        stops.append((conditions, t))
    points = {conditions[0] for conditions, _ in stops}
    if duration is None and len(points) == 1:
        raise ValueError("plan: start and goal are the same point: a free duration would be 0")
    return tuple(stops)


def checked_weights(objective: Any) -> dict[str, float]:
    """Return the weights of all OBJECTIVES; those of the user's own functions are left out."""
    given = _by_name(objective)
    names = {name for name, weight in given.items() if not callable(weight)}
    if not given or not names <= set(OBJECTIVES):
        raise ValueError(
            f"plan: objective must be of {', '.join(OBJECTIVES)}, or a function of your own, not"
            f" {shown(objective)}"
        )
    weights = {}
    for name in OBJECTIVES:
        weight = given[name] if name in names else 0.0
        weights[name] = not_negative(weight, f"plan: the weight of {name}")
    if len(names) == len(given) and not any(weights.values()):
        raise ValueError("plan: one weight of the objective must be > 0")
    return weights


def own_costs(objective: Any) -> list[tuple[str, Callable]]:
    """Return (name, function) of the user's own costs in an objective."""
    return [(name, each) for name, each in _by_name(objective).items() if callable(each)]


def _by_name(objective):
    if callable(objective):
        return {"cost": objective}
    if isinstance(objective, str):
        return {objective: 1.0}
    return objective if isinstance(objective, dict) else {}
