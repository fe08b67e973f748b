"""Sampled controllers: callables (t, q, q_dot, reference) -> tau (2,) in N m."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import HUGE, real_numbers
from ..base.checks import flag, modes, not_negative, shown
from ..base.errors import warn
from ..base.robot_uses import robot_for, uses
from ..models.dynamics import dynamic_model, gravity_torques
from ..models.geometry import Pose, dgm, igm
from ..models.kinematics import Accelerations, Rates, dkm, ikm, ikm2
from ..models.loads import dry_friction
from ..models.physics import loads_of

if TYPE_CHECKING:
    from ..models.robots import Robot

Vector = Any  # (2,) numbers or CasADi symbols


# Checks of what controllers have besides their gains.
CHECKS: dict[str, Callable] = {
    "working": modes(2),
    "assembly": modes(1),
    "gravity": flag,
    "ahead": not_negative,
}


class Reference(Protocol):
    """A motion to follow: times (...) s -> position, velocity and acceleration, each (..., 2)."""

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...


def motion_at(reference: Callable, t: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return xi, xi_dot and xi_ddot of a reference at times t (...) s, each (..., 2).

    One of this package is called with all times at once, one of your own with each alone.

    Raises
    ------
    ValueError
        Where it gives no such three pairs.
    """
    package = type(reference).__module__.partition(".")[0]
    if package == __name__.partition(".")[0]:
        return reference(t)
    if np.ndim(t):
        rows = [motion_at(reference, time) for time in np.asarray(t).tolist()]
        xi, xi_dot, xi_ddot = np.swapaxes(rows, 0, 1)
        return xi, xi_dot, xi_ddot
    answer = reference(t)
    if isinstance(answer, (tuple, list, np.ndarray)):
        shapes = [np.shape(part) for part in answer]
        if shapes == 3 * [(2,)]:
            xi, xi_dot, xi_ddot = np.array(answer, dtype=float)
            return xi, xi_dot, xi_ddot
    raise ValueError(
        f"reference must give xi, xi_dot and xi_ddot, each (2,), at t = {t:g} s, not"
        f" {shown(answer)}"
    )


@dataclass(frozen=True, eq=False)
class _JointController:
    """Gains and working modes of a controller on the active joints."""

    robot: Robot
    kp: Vector
    kd: Vector
    working: tuple[int, int] = (-1, -1)
    law: ClassVar[Callable[..., Vector]]
    inertial: ClassVar[bool] = False  # whether the law multiplies the gains by M

    def __post_init__(self) -> None:
        kinds = (f"fb.{kind.__name__}" for kind in type(self).__mro__)
        user = next(kind for kind in kinds if kind in uses()[1])  # also of a class of one's own
        own = robot_for(user)(self.robot, "robot")
        object.__setattr__(self, "robot", own)
        for name in ("kp", "kd"):
            gain = real_numbers(getattr(self, name), name)
            if gain.shape not in ((), (2,)) or not ((gain >= 0) & (gain < HUGE)).all():
                raise ValueError(
                    f"{name} must be one number or one per joint, finite and >= 0, not"
                    f" {shown(getattr(self, name))}"
                )
            object.__setattr__(self, name, gain)
        for name, rule in CHECKS.items():
            if hasattr(self, name):
                object.__setattr__(self, name, rule(getattr(self, name), name))

    def target(self, t: ArrayLike, reference: Reference | None) -> Accelerations:
        """Return the reference in joint coordinates, at one time or many."""
        if reference is None:
            raise ValueError(f"{type(self).__name__} needs a reference to track")
        xi, xi_dot, xi_ddot = motion_at(reference, t)
        return ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot)

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference | None
    ) -> np.ndarray:
        target = self.target(t, reference)
        return self.law(q, q_dot, target.rates.pose.q, target.rates.q_dot, target.q_ddot)


@dataclass(frozen=True, eq=False)
class PD(_JointController):
    """Proportional-derivative control of the joints.

    tau = kp (q_ref - q) + kd (q_ref' - q')

    Sampled with the period h it is stable where kp h / 2 < kd < 2 lambda / h, with lambda the least
    eigenvalue of the inertia matrix M at the pose.

    Parameters
    ----------
    robot : FiveBar or Biglide
    kp, kd : float or (2,)
        Gains, >= 0, N m/rad and N m s/rad (of a biglide N/m and N s/m).
    working : (2,)
        Working modes in which the reference is reached.
    gravity : bool
        Add the torques that hold the robot at q. At Type 2 there are none: SingularityError.
    assembly : int
        Assembly mode in which q is then read.

    References
    ----------
    Takegaki, Arimoto: A new feedback method for dynamic control of manipulators, 1981.

    Examples
    --------
    >>> import fivebar as fb
    >>> controller = fb.PD(fb.FiveBar(), kp=10, kd=1)
    >>> reference = fb.line((0.09, 0.068), (0.08, 0.075), 1.0)
    >>> controller(0.0, [0.0, 0.0], [0.0, 0.0], reference).round(4).tolist()
    [0.0041, 0.0041]
    """

    gravity: bool = False
    assembly: int = -1

    def law(
        self, q: Vector, q_dot: Vector, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector
    ) -> Vector:
        """Return the torques, of numbers or of CasADi symbols."""
        tau = self.robot.joint_difference(q_ref - q) * self.kp + (q_ref_dot - q_dot) * self.kd
        return tau + gravity_torques(dgm(self.robot, q, self.assembly)) if self.gravity else tau


@dataclass(frozen=True, eq=False)
class ComputedTorque(_JointController):
    """Computed-torque control.

    tau = M (q_ref'' + kd (q_ref' - q') + kp (q_ref - q)) + c, with M and c at the measured state.
    c holds the robot's gravity and friction. Coulomb friction is that of q_ref', as the sign of a
    measured rate that should be 0 changes from sample to sample.

    Parameters
    ----------
    robot : FiveBar or Biglide
    kp, kd : float or (2,)
        Gains, >= 0, 1/s^2 and 1/s.
    working : (2,)
        Working modes in which the reference is reached.
    assembly : int
        Assembly mode in which the measured joint angles are read.

    Examples
    --------
    >>> import fivebar as fb
    >>> controller = fb.ComputedTorque(fb.FiveBar(), kp=100, kd=20)
    >>> reference = fb.line((0.09, 0.068), (0.08, 0.075), 1.0)
    >>> run = fb.simulate(fb.FiveBar(), controller, reference)
    >>> bool(abs(run.error[-1]).max() < 1e-4)
    True
    """

    assembly: int = -1
    inertial: ClassVar[bool] = True

    def law(
        self, q: Vector, q_dot: Vector, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector
    ) -> Vector:
        """Return the torques, of numbers or of CasADi symbols."""
        rates = dkm(dgm(self.robot, q, self.assembly), q_dot)
        return computed_torque(rates, q_ref, q_ref_dot, q_ref_ddot, self.kp, self.kd)


def computed_torque(
    rates: Rates, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector, kp: Vector, kd: Vector
) -> Vector:
    """Return the torques of `ComputedTorque.law` at the measured Rates; gains may be symbols."""
    robot = rates.pose.robot
    q = rates.pose.q
    q_dot = rates.q_dot
    M, c = dynamic_model(rates)
    if loads_of(robot).sticks:
        c = c + dry_friction(robot, q_ref_dot) - dry_friction(robot, q_dot)
    error = robot.joint_difference(q_ref - q)
    return M @ (q_ref_ddot + (q_ref_dot - q_dot) * kd + error * kp) + c


@dataclass(frozen=True, eq=False)
class FeedForward(_JointController):
    """Feed-forward of a plan's torques, with PD about it.

    tau = tau_plan + kp (q_ref - q) + kd (q_ref' - q'). It inverts no model, so it follows a plan
    through any singularity. After the plan's end it is a PD.

    Parameters
    ----------
    robot : FiveBar or Biglide
    kp, kd : float or (2,)
        Gains, >= 0, as of `PD`.
    working : (2,)
        Not used: a plan knows its joints.
    ahead : float
        Time, s, by which the held torque is read in advance: half the control period.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.FeedForward(fb.FiveBar(), kp=10, kd=1).ahead
    0.005
    """

    ahead: float = 0.005

    def __call__(self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Any) -> np.ndarray:
        if reference is None or not hasattr(reference, "torques"):
            raise ValueError(
                "FeedForward needs a Plan as the reference: another has no torque to feed forward"
            )
        q_ref, q_ref_dot = reference.joints(t)
        end = reference.start + reference.duration
        if t < end - 1e-9 * end:
            tau = reference.torques(min(t + self.ahead, end))
        else:
            tau = np.zeros(2)
        error = self.robot.joint_difference(q_ref - q)
        return tau + error * self.kp + (q_ref_dot - q_dot) * self.kd


def warn_of_assembly(controller: Any, pose: Pose) -> None:
    """Warn where a controller reads the joints in another assembly mode than motions begin in."""
    mode = getattr(controller, "assembly", None)
    if mode in (-1, 1) and getattr(controller, "gravity", True) and np.any(pose.assembly == -mode):
        warn(
            f"the motion begins in assembly mode {-mode:+d}, and the controller reads the joints in"
            f" mode {mode:+d}: give it assembly={-mode}",
            RuntimeWarning,
        )


def why_unstable(controller: Any, pose: Pose, period: float, delay: int) -> str:
    """Return a sentence where a controller is unstable under sampling and delay, else "": gains at
    this pose, or a tracker that counts on another delay.

    A joint under PD, held from sample to sample, is stable where p / 2 < q < 2 with p = kp h^2 and
    q = kd h of a unit inertia; with one sample of delay where p < r (1 - r), r = q - p / 2.
    """
    if (counted := getattr(controller, "delay", delay)) != delay:
        return f"the controller counts on a delay of {counted} periods, the measurement has {delay}"
    if not isinstance(controller, _JointController) or not pose.assembly:
        return ""  # at Type 2 M is infinite
    inertia = np.eye(2)
    if not controller.inertial:
        inertia, _ = dynamic_model(dkm(pose, (0.0, 0.0)))
    kp, kd = (
        np.linalg.eigvals(np.linalg.solve(inertia, np.eye(2) * gain)).real.max()
        for gain in (controller.kp, controller.kd)
    )
    p, q = kp * period**2, kd * period
    r = q - p / 2
    if p < r * (1 - r) if delay else p / 2 < q < 2:
        return ""
    rule = "p < r (1 - r), r = q - p / 2" if delay else "p / 2 < q < 2"
    return (
        f"the gains are unstable with the control period h = {period:g} s: for each unit of the"
        f" inertia at the start p = kp h^2 = {p:.3g} and q = kd h = {q:.3g}, and it must be {rule}"
    )
