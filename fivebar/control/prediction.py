"""What the tracker knows of the robot: charts, prediction over the horizon, the state estimate, the safe torque.

The state is that of a chart, (c1, c2, c1', c2'): task coordinates, or where a leg is almost in line leg coordinates
of that leg. Both are regular at Type 2, and the forward dynamics is the bar-force form in both: a horizon may lie
across a crossing, where a model in joint coordinates ends.
"""

from functools import lru_cache

import numpy as np

from ..errors import SingularityError, UnreachableError
from ..models.charts import Leg, Task
from ..models.compiled import Buffered, compiled
from ..models.dynamics import forward_dynamics, inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from .laws import PD, ComputedTorque

CHARTS = Task(), Leg(0), Leg(1)
ENTER_TASK, LEAVE_TASK, LEAVE_LEG = 0.4, 0.25, 0.5  # the smaller sine over the larger; the chart's own over the other
FALLBACK_GAINS = 100.0, 20.0  # of computed torque, 1/s^2 and 1/s
NEAR_PARALLEL = 0.2  # |det A| below which the fallback is PD: computed torque divides by it


def choose_chart(margins, present=None):
    """The chart to be in, by the sines (q12, q22, ...): task coordinates, which are faster, where both are good."""
    left, right = abs(margins[0]), abs(margins[1])
    if min(left, right) >= (LEAVE_TASK if present is CHARTS[0] else ENTER_TASK) * max(left, right):
        return CHARTS[0]
    if present is CHARTS[1] and right >= LEAVE_LEG * left or present is CHARTS[2] and left >= LEAVE_LEG * right:
        return present
    return CHARTS[1] if right > left else CHARTS[2]


def _working(margins):
    return tuple(-1 if sine > 0 else 1 for sine in margins[:2])


def reference_torques(robot, margins, reference, times):
    """The torques (n, 2) of the reference itself at n times, N m (N); 0 where a part of it has none."""
    xi, xi_dot, xi_ddot = reference(times)
    try:
        return inverse_dynamics(ikm2(ikm(igm(robot, xi, _working(margins)), xi_dot), xi_ddot))
    except (SingularityError, UnreachableError):
        return np.zeros((len(times), 2))


def safe_torque(robot, inertia, margins, assembly, call):
    """Computed torque; near Type 2 PD of about the same gains; damping where the reference is out of reach: N m (N).

    call: (t, q, q_dot, reference), as to a controller; inertia: kg m^2 (kg), what a joint moves.
    """
    kp, kd = FALLBACK_GAINS
    if abs(margins[2]) > NEAR_PARALLEL:
        controller = ComputedTorque(robot, kp, kd, _working(margins), assembly)
    else:
        controller = PD(robot, kp * inertia, kd * inertia, _working(margins))
    try:
        return controller(*call)
    except (SingularityError, UnreachableError):
        return -kd * inertia * np.asarray(call[2])


class Model:
    """Compiled functions of one chart, called through buffers; arrays they return are overwritten by the next call."""

    def __init__(self, robot, chart, lengths, noise, speed, jit):
        step, rollout, estimate, look = _functions(robot, chart, lengths, noise, speed)
        self.chart, self.task = chart, isinstance(chart, Task)
        self.step, self.rollout, self.estimate, self.look = (
            Buffered(compiled(function, jit)) for function in (step, rollout, estimate, look)
        )


@lru_cache(maxsize=64)
def _functions(robot, chart, lengths, noise, speed):
    """(state, tau, modes) -> state; the same over the horizon with derivatives; the estimator; what a state shows."""
    import casadi as ca

    x, tau, modes, h = ca.SX.sym("x", 4), ca.SX.sym("tau", 2), ca.SX.sym("modes", 2), ca.SX.sym("h")

    def at(state):
        return chart.rates(robot, (state[0], state[1]), (state[2], state[3]), (modes[0], modes[1]))

    def slope(state):
        return ca.vertcat(state[2:], *chart.accelerations(forward_dynamics(at(state), tau)))

    # The midpoint rule, with the derivative of the slope taken once, at the midpoint: of second order, like the rule.
    middle = ca.SX.sym("middle", 4)
    slope_at = ca.Function("slope", [middle, tau, modes], ca.cse(_with_derivative(ca, slope(middle), middle, tau)))
    k, fx, fu = slope_at(x + h / 2 * slope(x), tau, modes)
    after, one = x + h * k, ca.SX.eye(4)
    A, B = one + h * fx @ (one + h / 2 * fx), h * (one + h / 2 * fx) @ fu
    sample = ca.Function("sample", [x, tau, modes, h], [after, A, B])(x, tau, modes, lengths[0])
    step = ca.Function("tracker_step", [x, tau, modes], ca.cse(sample[:1]))

    rates = at(x)
    y, measured = ca.vertcat(rates.pose.xi, rates.xi_dot), ca.vertcat(rates.pose.q, rates.q_dot)
    margins = ca.vertcat(*rates.pose.sines, rates.pose.det_A)
    look = ca.Function(
        "tracker_look", [x, modes], ca.cse([y, _rows(ca, y, x), measured, ca.densify(_rows(ca, measured, x)), margins])
    )

    outputs = [after, ca.densify(ca.horzcat(A, B).T)]
    y_after, C_after, measured_after, D_after, _ = look(after, modes)
    if not isinstance(chart, Task):
        outputs += [y_after, C_after]
    if speed:
        outputs += [measured_after[2:], D_after[:, 2:]]
    stage, N = ca.Function("stage", [x, tau, modes, h], ca.cse(outputs)), len(lengths)
    start, torques, signs = ca.MX.sym("x", 4), ca.MX.sym("tau", 2, N), ca.MX.sym("modes", 2)
    stages = stage.mapaccum(N)(start, torques, ca.repmat(signs, 1, N), ca.DM(lengths).T)
    rollout = ca.Function("tracker_rollout", [start, torques, signs], stages)
    wrapped = _wrapped if robot.turns else (lambda _, length: length)
    estimate = _estimator(ca, ca.Function("linear", [x, tau, modes], sample), look, noise, wrapped)
    return step, rollout, estimate, look


def _with_derivative(ca, slope, x, tau):
    return [slope, ca.jacobian(slope, x), ca.jacobian(slope, tau)]


def _rows(ca, f, x):
    """The transposed Jacobian: through a buffer, a row per component of f."""
    return ca.densify(ca.jacobian(f, x).T)


def _estimator(ca, linear, look, noise, wrapped):
    """Extended Kalman filter of the state and of a constant torque disturbance, measured by q and q'.

    It needs no assembly mode: h(x) = (q, q') is regular at Type 2, where the direction in which q says nothing of the
    end-effector is carried over by the prediction. Gives state, disturbance, covariance, and the sines with what q is
    still off by. noise: standard deviations (q, q', torque, its random walk); wrapped: of angles,
    the difference within a turn.
    """
    x, delta, P = ca.SX.sym("x", 4), ca.SX.sym("delta", 2), ca.SX.sym("P", 6, 6)
    tau, seen, modes = ca.SX.sym("tau", 2), ca.SX.sym("seen", 4), ca.SX.sym("modes", 2)
    predicted, A, B = linear(x, tau + delta, modes)
    F = ca.vertcat(ca.horzcat(A, B), ca.horzcat(ca.SX(2, 4), ca.SX.eye(2)))
    q_noise, rate_noise, torque_noise, walk = noise
    driven = ca.vertcat(B, ca.SX(2, 2))
    still = ca.diag(ca.SX([1e-18] * 2 + [1e-14] * 2 + [walk**2] * 2))  # never quite certain: P stays regular
    P_now = F @ P @ F.T + torque_noise**2 * driven @ driven.T + still
    y, _, expected, HT, _ = look(predicted, modes)
    innovation = seen - expected
    innovation = ca.vertcat(wrapped(ca, innovation[:2]), innovation[2:])
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
    misfit = ca.norm_inf(wrapped(ca, (seen - shown)[:2]))
    outputs = [state, found, ca.densify((P_now + P_now.T) / 2), ca.vertcat(margins, misfit)]
    return ca.Function("tracker_estimate", [x, delta, P, tau, seen, modes], ca.cse(outputs))


def _wrapped(ca, angle):
    return angle - 2 * ca.pi * ca.floor((angle + ca.pi) / (2 * ca.pi))
