"""What the tracker knows of the motion: an extended Kalman filter in the chart that fits, from chart to chart."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ..errors import SingularityError, UnreachableError
from ..models.compiled import Buffered, compiled
from ..models.geometry import dgm
from ..models.kinematics import dkm
from .prediction import choose_chart, sample_and_look

if TYPE_CHECKING:
    from ..models.charts import Leg, Task
    from ..models.robots import Robot

LOST = 0.1  # rad between measured and estimated joints: more is no error of an estimate, but another motion
EXACT = 1e-6, 1e-4  # standard deviations of joints (rad) and rates (rad/s) that are not rounded


class Estimator:
    """The motion, by what was measured and applied: a state in a chart, a torque disturbance, how certain both are.

    models: {chart: Model}, of which `model` is that of the state; noise: standard deviations (q, q', torque, its random
    walk); scale: the torque's unit. state, modes: as `model` takes them; disturbance (2,) N m; covariance (6, 6) of
    both; margins: sin q12, sin q22, det A; assembly: the mode, followed by prediction from the given one on.
    """

    def __init__(
        self, robot: Robot, models: dict, period: float, noise: tuple[float, ...], scale: float, assembly: int,
        jit: bool | str,
    ) -> None:  # fmt: skip
        self.robot, self.models, self.noise, self.scale, self.first = robot, models, noise, scale, assembly
        self.filters = {chart: Buffered(compiled(_filter(robot, chart, period, noise), jit)) for chart in models}
        self.reset()

    def reset(self) -> None:
        """Forget the motion and the disturbance."""
        self.assembly, self.disturbance, self.covariance = self.first, np.zeros(2), None

    def follow(self, tau: np.ndarray, q: np.ndarray, q_dot: np.ndarray) -> bool:
        """Take a sample in which tau was applied, and after which q, q_dot are measured; whether there is an estimate.

        What is lost is begun anew from the measurement; there is no estimate where that gives no motion.
        """
        state, disturbance, covariance, margins = self.filters[self.model.chart](
            self.state, self.disturbance, self.covariance, tau, (*q, *q_dot), self.modes
        )
        if not (np.isfinite(state).all() and margins[3] < LOST):
            self.disturbance = np.zeros(2)
            try:
                self.locate(q, q_dot)
            except (SingularityError, UnreachableError):
                return False
            return True
        self.state, self.disturbance, self.covariance = state.copy(), disturbance.copy(), covariance.copy()
        self.margins = margins.tolist()
        self.assembly = -1 if self.margins[2] > 0 else 1
        chart = choose_chart(self.margins, self.model.chart)
        if chart is not self.model.chart:
            self.change(chart)
        return True

    def locate(self, q: np.ndarray, q_dot: np.ndarray) -> None:
        """Take the state from a measurement alone, in the assembly mode known last."""
        rates = dkm(dgm(self.robot, q, self.assembly), q_dot)
        self.margins = [*rates.pose.sines, rates.pose.det_A]
        self._enter(choose_chart(self.margins), rates)
        slope = self.model.look(self.state, self.modes)[3]
        spread = np.linalg.solve(slope, np.diag([max(self.noise[0], EXACT[0])] * 2 + [EXACT[1]] * 2))
        self.covariance = np.diag([0.0] * 4 + [self.scale**2] * 2)
        self.covariance[:4, :4] = spread @ spread.T

    def _enter(self, chart, rates):
        self.model = self.models[chart]
        c, c_dot, modes = chart.coordinates(rates)
        self.state, self.modes = np.array([*c, *c_dot]), np.array(modes, dtype=float)

    def change(self, chart: Task | Leg) -> None:
        """Go over to another chart, the estimate's uncertainty with it."""
        slope = self.model.look(self.state, self.modes)[1].copy()
        c, c_dot, modes = (tuple(v.tolist()) for v in (self.state[:2], self.state[2:], self.modes.astype(int)))
        self._enter(chart, self.model.chart.rates(self.robot, c, c_dot, modes))
        T = np.eye(6)
        T[:4, :4] = np.linalg.solve(self.model.look(self.state, self.modes)[1], slope)
        self.covariance = T @ self.covariance @ T.T


@lru_cache(maxsize=64)
def _filter(robot, chart, period, noise):
    """Extended Kalman filter of the state and of a constant torque disturbance, measured by q and q'.

    It needs no assembly mode: h(x) = (q, q') is regular at Type 2, where the direction in which q says nothing of the
    end-effector is carried over by the prediction. Gives state, disturbance, covariance, and the sines with what q is
    still off by.
    """
    sample, look = sample_and_look(robot, chart)
    x, delta, P = ca.SX.sym("x", 4), ca.SX.sym("delta", 2), ca.SX.sym("P", 6, 6)
    tau, seen, modes = ca.SX.sym("tau", 2), ca.SX.sym("seen", 4), ca.SX.sym("modes", 2)
    predicted, A, B = sample(x, tau + delta, modes, period)
    F = ca.vertcat(ca.horzcat(A, B), ca.horzcat(ca.SX(2, 4), ca.SX.eye(2)))
    q_noise, rate_noise, torque_noise, walk = noise
    driven = ca.vertcat(B, ca.SX(2, 2))
    still = ca.diag(ca.SX([1e-18] * 2 + [1e-14] * 2 + [walk**2] * 2))  # never quite certain: P stays regular
    P_now = F @ P @ F.T + torque_noise**2 * driven @ driven.T + still
    y, _, expected, HT, _ = look(predicted, modes)
    innovation = seen - expected
    innovation = ca.vertcat(robot.differ(innovation[:2]), innovation[2:])
    correction = ca.SX(6, 1)
    for k, variance in enumerate([q_noise**2] * 2 + [rate_noise**2] * 2):
        # One scalar at a time: no matrix to invert.
        h = ca.vertcat(HT[:, k], ca.SX(2, 1))
        Ph = P_now @ h
        gain = Ph / (ca.dot(h, Ph) + variance)
        correction += gain * (innovation[k] - ca.dot(h, correction))
        P_now -= gain @ Ph.T
    state, found = predicted + correction[:4], delta + correction[4:]
    _, _, shown, _, margins = look(state, modes)
    misfit = ca.norm_inf(robot.differ((seen - shown)[:2]))
    outputs = [state, found, ca.densify((P_now + P_now.T) / 2), ca.vertcat(margins, misfit)]
    return ca.Function("tracker_estimate", [x, delta, P, tau, seen, modes], ca.cse(outputs))
