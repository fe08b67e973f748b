"""What `plan` is asked: arguments and their checks, limits and by how much a motion breaks them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import finite_numbers, real_numbers
from ..base.checks import not_negative, number, positive, shown, two_numbers
from ..base.errors import SingularityError, UnreachableError
from ..constraints.constraints import Keep
from ..models.geometry import Pose, igm
from ..models.kinematics import Accelerations, ikm
from ..models.physics import loads_of, smoothed
from .coordinates import BarCoordinates, TaskCoordinates

if TYPE_CHECKING:
    from collections.abc import Iterable

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
    """No plan was found; `plan` is the best one found (None where there is none), never converged
    or never feasible.

    violations: dict, by how much it exceeds each limit (SI); status: how IPOPT ended where it did
        not solve.
    """

    def __init__(
        self, message: str, violations: dict[str, float], plan: Plan | None = None, status: str = ""
    ) -> None:
        super().__init__(message)
        self.violations, self.plan, self.status = violations, plan, status


@dataclass(frozen=True)
class Limits:
    """What a plan must keep, SI: torque, joint_speed one number per joint, acceleration of the
    end-effector, workspace ((x low, x high), (y low, y high)), serial and parallel: least |sin
    q_i2| and |det A|; None: no limit.
    """

    torque: tuple[float, float] | None = None
    joint_speed: tuple[float, float] | None = None
    acceleration: float | None = None
    workspace: tuple | None = None
    serial: float | None = 0.05
    parallel: float | None = None


@dataclass(frozen=True, eq=False)
class Problem:
    """What is asked: stops are (conditions by order of derivative, time or None), as in
    `trajectory.polynomial`.
    """

    robot: Robot
    stops: tuple
    working: tuple[int, int] | None  # None: free, and the four bars are planned
    weights: dict[str, float]
    limits: Limits
    scheme: Scheme
    keep: Keep | None = None

    @property
    def length(self) -> float:
        return sum(self.robot.distal) / 2

    @property
    def lever(self) -> float:
        """What makes a speed of a joint's: a length where it turns, 1 where it slides."""
        return self.length if self.robot.turns else 1.0

    @cached_property
    def model(self) -> Robot:
        """The robot that is planned with: its dry friction smoothed, as an optimisation needs
        slopes.
        """
        return smoothed(self.robot, SLOW * (1.0 if self.robot.turns else self.length))

    @property
    def mass(self) -> float:
        return (
            abs(self.robot.m) + sum(map(abs, self.robot.inertias)) / self.lever**2
        )  # what is grouped may be negative

    @property
    def fall(self) -> float:
        """Of gravity, m/s^2."""
        return math.hypot(*loads_of(self.robot).gravity)

    @cached_property
    def side(self) -> float:
        """Sign of det A at the start, which a limit on it keeps."""
        at = np.array(self.stops[0][0][0])
        motion = np.concatenate([at, np.zeros(2 * len(at))])
        return float(np.sign(self.accelerations(motion).rates.pose.det_A)) or 1.0

    def signed_sines(self, pose: Pose) -> tuple:
        """-w_i sin q_i2 of both legs (positive in these working modes), det A with the sign it has
        at the start.
        """
        return (
            *(-w * sine for w, sine in zip(self.working or (1, 1), pose.sines)),
            self.side * pose.det_A,
        )

    def violations(
        self,
        xi: np.ndarray | None = None,
        q_dot: np.ndarray | None = None,
        xi_ddot: np.ndarray | None = None,
        tau: np.ndarray | None = None,
        sines: tuple | None = None,
    ) -> dict[str, np.ndarray]:
        """By how much the limits on what is given, (..., 2), are exceeded: {name: array}, <= 0
        where they are kept.
        """
        limits, found = self.limits, {}
        if tau is not None and limits.torque is not None:
            found["torque"] = (np.abs(tau) - limits.torque).max(axis=-1)
        if q_dot is not None and limits.joint_speed is not None:
            found["joint_speed"] = (np.abs(q_dot) - limits.joint_speed).max(axis=-1)
        if xi_ddot is not None and limits.acceleration is not None:
            found["acceleration"] = np.linalg.norm(xi_ddot, axis=-1) - limits.acceleration
        if xi is not None and limits.workspace is not None:
            low, high = np.array(limits.workspace).T
            found["workspace"] = np.maximum(low - xi, xi - high).max(axis=-1)
        if sines is not None:
            if limits.serial is not None:
                found["serial"] = limits.serial - np.minimum(sines[0], sines[1])
            if limits.parallel is not None:
                found["parallel"] = limits.parallel - sines[2]
        return found

    def unit(self, name: str) -> float:
        """What a violation is compared with: the limit itself, a bar's length, a sine of 1."""
        if name in ("torque", "joint_speed", "acceleration"):
            return float(np.max(getattr(self.limits, name)))
        return self.length if name in ("workspace", "reach") else 1.0

    @property
    def coordinates(self) -> TaskCoordinates | BarCoordinates:
        return BarCoordinates() if self.working is None else TaskCoordinates(self.working)

    def accelerations(self, motion: np.ndarray, robot: Robot | None = None) -> Accelerations:
        """Of a motion (..., 3 size or more) in the problem's coordinates; nan out of reach. robot:
        of `model`, too.
        """
        return self.coordinates.accelerations(robot or self.robot, motion)

    def listed(self, violations: dict[str, float]) -> str:
        """The violated limits in words."""
        words, own = [], self.robot.words
        units = {
            "torque": own.effort_unit,
            "joint_speed": f"{own.unit}/s",
            "acceleration": "m/s²",
            "workspace": "m",
        }
        for name, value in violations.items():
            if value > 1e-6 * self.unit(name):
                limit = getattr(self.limits, name, None)
                limit = max(limit) if name in ("torque", "joint_speed") else limit
                against = "" if name in ("workspace", "reach") else f" (limit {limit:.6g})"
                called = own.effort if name == "torque" else name
                words.append(
                    f"{called} by {value:.4g} {units.get(name, 'm' * (name == 'reach'))}".rstrip()
                    + against
                )
        return f"; violated: {', '.join(words)}" if words else ""


def refuse_massless(problem: Problem) -> None:
    """Raise where no motion of the robot costs anything."""
    if not problem.mass:
        words = problem.robot.words
        names = ", ".join(("m", *words.inertias))
        raise ValueError(
            f"plan: this robot has no inertia ({names} are 0): no motion costs a {words.effort}"
        )


def point_of(point: object, modes: tuple[int, int], name: str) -> object:
    """A Pose as its point, where the working modes that are to be kept are its own; anything else
    as it is.
    """
    if not isinstance(point, Pose):
        return point
    own = tuple(int(mode) for mode in point.working)
    if own != modes:
        raise ValueError(f"plan: {name} is a Pose in working modes {own}, not in working = {modes}")
    return tuple(point.xi.tolist())


def refuse_stops(problem: Problem) -> None:
    """Raise where a stop is out of reach or breaks a limit by itself."""
    for name, (conditions, _) in zip(stop_names(len(problem.stops)), problem.stops):
        try:
            pose = igm(problem.robot, conditions[0], problem.working)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"plan: {name}: {error}",)
            raise
        for what, room in (problem.keep.rooms(pose) if problem.keep else {}).items():
            if room < -1e-12:
                raise PlanError(
                    f"plan: infeasible: {name} itself does not keep {what}: by {-room:.3g}",
                    {what: -room},
                )
        found = problem.violations(pose.xi, sines=problem.signed_sines(pose))
        if found["serial"] <= 0:
            q_dot = ikm(pose, conditions.get(1, (0.0, 0.0))).q_dot
            found |= problem.violations(
                q_dot=q_dot, xi_ddot=np.array(conditions.get(2, (0.0, 0.0)))
            )
        found = {key: max(float(value), 0.0) for key, value in found.items()}
        if any(value > 1e-9 * problem.unit(key) for key, value in found.items()):
            raise PlanError(
                f"plan: infeasible: {name} itself breaks limits{problem.listed(found)}", found
            )


def refuse_broken(plan: Plan, tolerance: float) -> Plan:
    """The plan; PlanError where it breaks what is to be kept by more than the tolerance of a bar's
    length, or rad.
    """
    keep = plan.problem.keep
    if keep is None:
        return plan
    t = np.linspace(plan.start, plan.start + plan.duration, LOOKED_AT)
    with np.errstate(all="ignore"):
        rooms = keep.rooms(plan.problem.accelerations(plan.motion(t)).rates.pose)
    found = {}
    for name, room in rooms.items():
        k = int(np.argmin(room))
        if -room[k] > tolerance * (1.0 if name.startswith(("|", "joint")) else plan.problem.length):
            found[f"{name} (t = {t[k]:.4g} s)"] = float(-room[k])
    if found:
        broken = ", ".join(f"{name}: by {by:.3g}" for name, by in found.items())
        raise PlanError(
            f"plan: the best motion found does not keep {broken}; it is attached as .plan",
            found,
            plan,
        )
    return plan


def stop_names(count: int) -> list[str]:
    """What so many stops are called."""
    return ["start", *(f"via[{k}]" for k in range(count - 2)), "goal"]


def timed(start: object, goal: object, duration: float | None, via: Iterable) -> list[tuple]:
    """[(what it is called, time or None, point), ...] of all stops, in the order of their times."""
    try:
        via = [(t, point) for t, point in via]
    except (TypeError, ValueError):
        raise ValueError(
            f"plan: via must be [(time or None, point), ...], not {shown(via)}"
        ) from None
    found, last = [("start", 0.0, start)], 0.0
    for name, (t, point) in zip(stop_names(len(via) + 2)[1:], [*via, (duration, goal)]):
        if t is not None:
            words = (
                f"plan: the time of {name}"
                if name != "goal"
                else f"plan: duration{', after via,' if last else ''}"
            )
            t = last = number(positive(t, words), words, last, above=True)
        found.append((name, t, point))
    return found


def checked_stops(start: object, goal: object, duration: float | None, via: Iterable) -> tuple:
    """((conditions, time or None), ...), checked."""
    stops = []
    for name, t, point in timed(start, goal, duration, via):
        if not isinstance(point, dict):
            point = {0: point} if name.startswith("via") else {0: point, 1: (0.0, 0.0)}
        if 0 not in point or not set(point) <= {0, 1, 2}:
            raise ValueError(
                f"plan: {name} needs a position under order 0, and no other orders than 1 and 2"
            )
        stops.append(
            ({k: two_numbers(value, f"plan: {name}, order {k},") for k, value in point.items()}, t)
        )
    if duration is None and all(conditions[0] == stops[0][0][0] for conditions, _ in stops):
        raise ValueError("plan: start and goal are the same point: a free duration would be 0")
    return tuple(stops)


def checked_weights(objective: str | dict[str, float]) -> dict[str, float]:
    weights = {objective: 1.0} if isinstance(objective, str) else objective
    if not isinstance(weights, dict) or not weights or not set(weights) <= set(OBJECTIVES):
        raise ValueError(
            f"plan: objective must be of {', '.join(OBJECTIVES)}, not {shown(objective)}"
        )
    weights = {
        name: not_negative(weights.get(name, 0.0), f"plan: the weight of {name}")
        for name in OBJECTIVES
    }
    if not any(weights.values()):
        raise ValueError("plan: one weight of the objective must be > 0")
    return weights


def per_joint(value: object, name: str) -> tuple[float, float]:
    """Rule: one number > 0 for both joints, or two; ValueError for anything else."""
    values = [positive(each, name) for each in real_numbers(value, name).ravel().tolist()]
    if len(values) not in (1, 2):
        raise ValueError(f"{name} must be one number or one per joint, not {value!r}")
    return tuple(values * (3 - len(values)))


def box(value: object, name: str) -> tuple:
    """Rule: ((x low, x high), (y low, y high)); ValueError for anything else."""
    found = finite_numbers(value, name)
    if found.shape != (2, 2) or (found[:, 0] >= found[:, 1]).any():
        raise ValueError(
            f"{name} must be ((x low, x high), (y low, y high)), finite, not {shown(value)}"
        )
    return tuple(map(tuple, found.tolist()))
