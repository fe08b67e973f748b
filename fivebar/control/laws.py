"""Sampled controllers: callables (t, q, q_dot, reference) -> tau (2,) in N m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import HUGE, real_numbers
from ..base.checks import flag, modes, not_negative, shown
from ..base.checks import robot as must_be_robot
from ..models.dynamics import dynamic_model, gravity_torques
from ..models.geometry import dgm, igm
from ..models.kinematics import Accelerations, Rates, dkm, ikm, ikm2
from ..models.loads import dry_friction
from ..models.physics import loads_of

if TYPE_CHECKING:
    import casadi

    from ..models.robots import Robot

    Vector = np.ndarray | casadi.SX


CHOICES = {
    "working": modes(2),
    "assembly": modes(1),
    "gravity": flag,
    "ahead": not_negative,
}  # their rules


class Reference(Protocol):
    """A motion to follow: at times (...) s the end-effector's position, velocity and acceleration,
    each (..., 2).
    """

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...


class Controller(Protocol):
    """Torques (2,) N m by time (s), measured joint coordinates and rates (2,), and the reference,
    if there is one.
    """

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference | None
    ) -> np.ndarray: ...


@dataclass(frozen=True, eq=False)
class _JointController:
    """Gains and modes of a controller on the active joints.

    kp, kd: one number or one per joint, >= 0. working: the legs in which the reference is reached.
    """

    robot: Robot
    kp: ArrayLike
    kd: ArrayLike
    working: tuple[int, int] = (-1, -1)

    def __post_init__(self) -> None:
        must_be_robot(self.robot, "robot")
        for name in ("kp", "kd"):
            gain = real_numbers(getattr(self, name), name)
            if gain.shape not in ((), (2,)) or not ((gain >= 0) & (gain < HUGE)).all():
                raise ValueError(
                    f"{name} must be one number or one per joint, finite and >= 0, not"
                    f" {shown(getattr(self, name))}"
                )
            object.__setattr__(self, name, gain)
        for name, rule in CHOICES.items():
            if hasattr(self, name):
                object.__setattr__(self, name, rule(getattr(self, name), name))

    def target(self, t: ArrayLike, reference: Reference | None) -> Accelerations:
        """The reference in joint coordinates, at one time or many."""
        if reference is None:
            raise ValueError(f"{type(self).__name__} needs a reference to track")
        xi, xi_dot, xi_ddot = reference(t)
        return ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot)

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference | None
    ) -> np.ndarray:
        target = self.target(t, reference)
        return self.law(q, q_dot, target.rates.pose.q, target.rates.q_dot, target.q_ddot)


@dataclass(frozen=True, eq=False)
class PD(_JointController):
    """tau = kp (q_ref - q) + kd (q_ref' - q'), kp in N m/rad, kd in N m s/rad.

    gravity: whether the torques that hold its robot at q are added (`gravity_torques`; Takegaki and
        Arimoto 1981); at
    Type 2 there are none: SingularityError. assembly: the mode that q is then read in.
    """

    gravity: bool = False
    assembly: int = -1

    def law(
        self, q: Vector, q_dot: Vector, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector
    ) -> Vector:
        """The torques, of numbers or of CasADi symbols."""
        tau = self.robot.joint_difference(q_ref - q) * self.kp + (q_ref_dot - q_dot) * self.kd
        return tau + gravity_torques(dgm(self.robot, q, self.assembly)) if self.gravity else tau


@dataclass(frozen=True, eq=False)
class ComputedTorque(_JointController):
    """tau = M (q_ref'' + kd (q_ref' - q') + kp (q_ref - q)) + c, kp in 1/s^2, kd in 1/s; M, c at
    the measured state.

    c holds the gravity and the friction of its robot; Coulomb friction is that of q_ref', as the
    sign of a measured rate that should be 0 changes from sample to sample.
    assembly: the assembly mode that the measured joint angles are read in.
    """

    assembly: int = -1

    def law(
        self, q: Vector, q_dot: Vector, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector
    ) -> Vector:
        """The torques, of numbers or of CasADi symbols."""
        rates = dkm(dgm(self.robot, q, self.assembly), q_dot)
        return computed_torque(rates, q_ref, q_ref_dot, q_ref_ddot, self.kp, self.kd)


def computed_torque(
    rates: Rates, q_ref: Vector, q_ref_dot: Vector, q_ref_ddot: Vector, kp: Vector, kd: Vector
) -> Vector:
    """`ComputedTorque.law` at the measured Rates; the gains may be symbols too."""
    robot, q, q_dot = rates.pose.robot, rates.pose.q, rates.q_dot
    M, c = dynamic_model(rates)
    if loads_of(robot).sticks:
        c = c + dry_friction(robot, q_ref_dot) - dry_friction(robot, q_dot)
    return M @ (q_ref_ddot + (q_ref_dot - q_dot) * kd + robot.joint_difference(q_ref - q) * kp) + c


@dataclass(frozen=True, eq=False)
class FeedForward(_JointController):
    """tau = tau_plan + kp (q_ref - q) + kd (q_ref' - q') about a Plan; kp, kd as in PD.

    It inverts no model, so that it holds a plan through any singularity. Beyond the plan's end it
    is a PD.
    ahead: s, half the control period, by which the held torque is read in advance.
    """

    ahead: float = 0.005

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference | None
    ) -> np.ndarray:
        if reference is None or not hasattr(reference, "tau"):
            raise ValueError(
                "FeedForward needs a Plan as the reference: another has no torque to feed forward"
            )
        q_ref, q_ref_dot = reference.joints(t)
        end = reference.start + reference.duration
        push = reference.tau(min(t + self.ahead, end)) if t < end - 1e-9 * end else np.zeros(2)
        return (
            push + self.robot.joint_difference(q_ref - q) * self.kp + (q_ref_dot - q_dot) * self.kd
        )
