"""Sampled controllers: callables (t, q, q_dot, reference) -> tau (2,) in N m."""

from dataclasses import dataclass

import numpy as np

from .dynamics import dynamic_model
from .geometry import dgm, igm
from .kinematics import dkm, ikm, ikm2


def wrap(angle):
    """Angles (rad) modulo 2 pi, in (-pi, pi]."""
    return np.pi - np.mod(np.pi - np.asarray(angle), 2 * np.pi)


@dataclass(frozen=True, eq=False)
class _JointController:
    """Gains and modes of a controller on the active joints.

    kp, kd: one number or one per joint, >= 0. working: the legs in which the reference is reached.
    """

    robot: object
    kp: object
    kd: object
    working: tuple = (-1, -1)

    def __post_init__(self):
        for name in ("kp", "kd"):
            gain = np.asarray(getattr(self, name), dtype=float)
            if gain.shape not in ((), (2,)) or not np.isfinite(gain).all() or (gain < 0).any():
                raise ValueError(
                    f"{name} must be one number or one per joint, finite and >= 0, not {getattr(self, name)!r}"
                )
            object.__setattr__(self, name, gain)


@dataclass(frozen=True, eq=False)
class PD(_JointController):
    """tau = kp (q_ref - q) + kd (q_ref' - q'), kp in N m/rad, kd in N m s/rad."""

    def __call__(self, t, q, q_dot, reference):
        xi, xi_dot, _ = reference(t)
        target = ikm(igm(self.robot, xi, self.working), xi_dot)
        return self.kp * wrap(target.pose.q - q) + self.kd * (target.q_dot - q_dot)


@dataclass(frozen=True, eq=False)
class ComputedTorque(_JointController):
    """tau = M (q_ref'' + kd (q_ref' - q') + kp (q_ref - q)) + c, kp in 1/s^2, kd in 1/s; M, c at the measured state.

    assembly: the assembly mode that the measured joint angles are read in.
    """

    assembly: int = -1

    def __call__(self, t, q, q_dot, reference):
        xi, xi_dot, xi_ddot = reference(t)
        target = ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot)
        rates = dkm(dgm(self.robot, q, self.assembly), q_dot)
        M, c = dynamic_model(rates)
        error, error_dot = wrap(target.rates.pose.q - q), target.rates.q_dot - q_dot
        return M @ (target.q_ddot + self.kd * error_dot + self.kp * error) + c
