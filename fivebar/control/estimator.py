"""The tracker's estimator: an extended Kalman filter in the four bars."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..base.errors import SingularityError, UnreachableError
from ..models.charts import halves
from ..models.compiled import Buffered, compiled
from ..models.four_joints import bars_of, bars_pose, closed, closure_columns, gap_rate, loop_gap
from ..models.geometry import dgm
from ..models.kinematics import dkm
from ..models.loaded_robot import JointTorques
from ..models.robots import Robot
from .prediction import CHART, JOINTS, RATES, SIZE, sample

# rad between measured and estimated joints: more is no error of an estimate, but another motion.
LOST = 0.1
EXACT = (1e-6, 1e-4)  # standard deviations of joints (rad) and rates (rad/s) that are not rounded
MEASURED = JOINTS + RATES


class Estimator:
    """Estimate of the motion: a state, a torque disturbance and their covariance.

    noise: standard deviations (q, q', torque, its random walk); scale: the torque's unit. state
    (8,): the four bars and their rates; disturbance (2,) N m; covariance (10, 10) of both; margins:
    sin q12, sin q22, det A; assembly: the mode, followed by prediction from the given one on.
    """

    def __init__(
        self,
        robot: Robot,
        period: float,
        noise: tuple[float, ...],
        scale: float,
        assembly: int,
        jit: bool | str,
        torques: JointTorques | None = None,
    ) -> None:
        self.robot = robot
        self.noise = noise
        self.scale = scale
        self.first = assembly
        self.margins = [0.0] * 3
        self.filter = Buffered(compiled(_filter(robot, period, noise, torques), jit))
        self.reset()

    def reset(self) -> None:
        """Forget the motion and the disturbance."""
        self.assembly = self.first
        self.disturbance = np.zeros(2)
        self.covariance = np.zeros((SIZE + 2, SIZE + 2))
        self.state = np.zeros(SIZE)

    def follow(self, t: float, tau: np.ndarray, q: np.ndarray, q_dot: np.ndarray) -> bool:
        """Take a sample from time t on in which tau was applied, and after which q, q_dot are
        measured; whether there is an estimate.

        What is lost is begun anew from the measurement; there is no estimate where that gives no
        motion.
        """
        state, disturbance, covariance, margins = self.filter(
            self.state, self.disturbance, self.covariance, tau, (*q, *q_dot), t
        )
        if not (np.isfinite(state).all() and margins[3] < LOST):
            self.disturbance = np.zeros(2)
            try:
                self.locate(q, q_dot)
            except (SingularityError, UnreachableError):
                return False
            return True
        self.state = state.copy()
        self.disturbance = disturbance.copy()
        self.covariance = covariance.copy()
        self.margins = margins.tolist()
        self.assembly = -1 if self.margins[2] > 0 else 1
        return True

    def locate(self, q: np.ndarray, q_dot: np.ndarray) -> None:
        """Take the state from a measurement alone, in the assembly mode known last."""
        rates = dkm(dgm(self.robot, q, self.assembly), q_dot)
        self.margins = [*rates.pose.sines, rates.pose.det_A]
        a, a_dot = bars_of(rates)
        self.state = np.array([*a, *a_dot])
        # What is measured and that the loop is closed, by the state: together they determine it.
        slope = np.vstack([np.eye(SIZE)[MEASURED], _closure(self.robot)(self.state).full()])
        q_noise = max(self.noise[0], EXACT[0])
        spread = np.linalg.inv(slope)[:, :4] * [q_noise, q_noise, EXACT[1], EXACT[1]]
        self.covariance = np.diag([0.0] * SIZE + [self.scale**2] * 2)
        self.covariance[:SIZE, :SIZE] = spread @ spread.T


@lru_cache(maxsize=64)
def _closure(robot):
    """State -> slopes (4, 8) of the loop's gap and of its rate."""
    x = ca.SX.sym("x", SIZE)
    a, a_dot = halves(x, CHART)
    pose = bars_pose(robot, a)
    gaps = *loop_gap(pose), *gap_rate(closure_columns(pose), a_dot)
    return ca.Function("closure", [x], [ca.jacobian(ca.vertcat(*gaps), x)])


@lru_cache(maxsize=64)
def _filter(robot, period, noise, torques):
    """Extended Kalman filter of the state and of a constant torque disturbance, measured by q and
    q'.

    It needs no mode: at Type 2, where the joints do not tell the end-effector, the prediction
    carries it over. Gives state, disturbance, covariance, and the sines with what q is still off
    by.
    """
    x = ca.SX.sym("x", SIZE)
    delta = ca.SX.sym("delta", 2)
    P = ca.SX.sym("P", SIZE + 2, SIZE + 2)
    tau = ca.SX.sym("tau", 2)
    seen = ca.SX.sym("seen", 4)
    t = ca.SX.sym("t")
    predicted, A, B = sample(robot, torques)(x, tau + delta, t, period)
    F = ca.vertcat(ca.horzcat(A, B), ca.horzcat(ca.SX(2, SIZE), ca.SX.eye(2)))
    q_noise, rate_noise, torque_noise, walk = noise
    driven = ca.vertcat(B, ca.SX(2, 2))
    # P stays regular where nothing is ever quite certain.
    still = ca.diag(ca.SX([1e-18] * 4 + [1e-14] * 4 + [walk**2] * 2))
    P_now = F @ P @ F.T + torque_noise**2 * driven @ driven.T + still
    innovation = seen - predicted[MEASURED]
    innovation = ca.vertcat(robot.joint_difference(innovation[:2]), innovation[2:])
    variances = [q_noise**2] * 2 + [rate_noise**2] * 2
    # The loop is closed, which the slopes A do not know: without this, the distal bars' variances
    # grow for ever. It is linear to what the joints are known to: a tighter one misleads.
    slope = ca.vertcat(ca.SX.eye(SIZE)[MEASURED, :], _closure(robot)(predicted))
    slope = ca.horzcat(slope, ca.SX(8, 2))
    innovation = ca.vertcat(innovation, ca.SX(4, 1))
    variances += [(q_noise * min(robot.distal)) ** 2] * 4
    correction = ca.SX(SIZE + 2, 1)
    for k, variance in enumerate(variances):
        # One scalar at a time: no matrix to invert.
        spread = P_now @ slope[k, :].T
        gain = spread / (slope[k, :] @ spread + variance)
        correction += gain * (innovation[k] - slope[k, :] @ correction)
        P_now -= gain @ spread.T
    c, c_dot, rates = closed(robot, *halves(predicted + correction[:SIZE], CHART))
    state = ca.vertcat(*c, *c_dot)
    misfit = ca.norm_inf(robot.joint_difference((seen - state[MEASURED])[:2]))
    margins = ca.vertcat(*rates.pose.sines, rates.pose.det_A, misfit)
    outputs = [state, delta + correction[SIZE:], ca.densify((P_now + P_now.T) / 2), margins]
    return ca.Function("tracker_estimate", [x, delta, P, tau, seen, t], ca.cse(outputs))
