"""Compiled steps of the plant: its right side in a chart, what a state observes, and Runge-Kutta.

The right side is a CasADi function made from the same equations as everything else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any

import casadi
import numpy as np
from scipy.integrate import DOP853

from ..base.backend import pack
from ..models.charts import BarAngles, StateChart, halves
from ..models.dynamics import energy, forward_dynamics, held_by, slipping_dynamics
from ..models.four_joints import bars_rates, closed, rates_from_joint_state
from ..models.kinematics import Rates
from ..models.loaded_robot import JointTorques
from ..models.parameters import count_of, with_parameters
from ..models.robots import Robot

# Columns of an observation.
Q = slice(0, 2)
Q_DOT = slice(2, 4)
XI = slice(4, 6)
XI_DOT = slice(6, 8)
MARGINS = slice(8, 11)
MARGIN_RATES = slice(11, 14)  # sin q12, sin q22, det A
ENERGY = 14
COLUMNS = 15
METHODS = ("rk4", "dop8")
# Of the active joints in a state of the four bars.
JOINTS = slice(0, 3, 2)
JOINT_RATES = slice(4, 7, 2)


@lru_cache(maxsize=64)
def observe_function(robot: Robot, chart: StateChart) -> casadi.Function:
    """Return (state, modes) -> observation."""
    state, _, modes = symbols_of(chart)
    rates = chart.rates(robot, *halves(state, chart), (modes[0], modes[1]))
    row = casadi.cse([observation(rates)])
    return casadi.Function("observe", [state, modes], row)


@lru_cache(maxsize=64)
def block_function(
    robot: Robot,
    chart: StateChart,
    method: str,
    step: float,
    count: int,
    torques: JointTorques | None = None,
) -> casadi.Function:
    """Return (state, tau, modes, t) -> states after each of `count` steps, observations, the last.

    The observations are those before each step; the last one is after them all. t: s, before the
    first.
    """
    state, tau, modes = symbols_of(chart)
    t = casadi.SX.sym("t")
    at_joints = at_time(torques, chart, t, step)
    signs = modes[0], modes[1]
    outputs = runge_kutta_step(robot, chart, method, step, state, tau, signs, at_joints)
    outputs = casadi.cse(list(outputs))
    one = casadi.Function("step", [state, tau, modes, t], outputs)
    observe = observe_function(robot, chart)
    state, tau, modes = symbols_of(chart, casadi.MX)
    t = casadi.MX.sym("t")
    held = casadi.repmat(tau, 1, count), casadi.repmat(modes, 1, count)
    times = t + step * casadi.DM(range(count)).T
    states, rows = one.mapaccum(count)(state, *held, times)
    last = observe(states[:, -1], modes)
    return casadi.Function("block", [state, tau, modes, t], [states, rows, last])


def at_time(torques: JointTorques | None, chart: StateChart, t: Any, step: Any) -> Callable | None:
    """Return (a stage's state, its Rates, tau, fraction of a step from t) -> torques at the joints.

    None: these are tau itself.
    """
    if torques is None:
        return None

    def at_joints(stage, rates, tau, fraction):
        c, _ = halves(stage, chart)
        q = pack(*chart.joints(c, rates))
        q_dot, _ = rates.components
        now = t + fraction * step
        return torques.function(now, q, pack(*q_dot), tau)

    return at_joints


def runge_kutta_step(
    robot: Robot,
    chart: StateChart,
    method: str,
    step: Any,
    state: Any,
    tau: Any,
    modes: Sequence,
    at_joints: Callable | None = None,
) -> tuple[Any, Any]:
    """Return symbols of the state after a step under held torques, of the observation before.

    at_joints: of `at_time`.
    """
    first = chart.rates(robot, *halves(state, chart), modes)

    def slope(stage, fraction):
        rates = first if stage is state else turned_rates(robot, chart, stage, modes)
        joint = tau if at_joints is None else at_joints(stage, rates, tau, fraction)
        return slope_of(chart, rates, stage, joint)

    after, _ = close_loop(robot, chart, runge_kutta(method, step, state, slope), modes)
    return after, observation(first)


@lru_cache(maxsize=8)
def free_step(kind: type, names: tuple = (), torques: JointTorques | None = None) -> Any:
    """Return a step of any length on the bars, by Dormand and Prince's method of order 8.

    Of any robot of a kind: (state (8), tau, length, tolerance, parameters) -> the state after it,
    its error over the tolerance, the polynomial in between (8, 7). Where dry friction is among the
    names there is one more input: how the drives slip. With torques the time comes last. Where
    these are a function of numbers, so is the step.

    References
    ----------
    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.10: the error is
    theirs, of order 5 and 3 together, in rad of the bars and, over 1 + |rate|, of rates.
    """
    chart = BarAngles()
    parameters = casadi.SX.sym("parameters", count_of(kind, names))
    state, tau, _ = symbols_of(chart)
    length = casadi.SX.sym("length")
    tolerance = casadi.SX.sym("tolerance")
    robot = with_parameters(kind, parameters, names)
    sticks = {"fs1", "fs2"} & set(names)
    known = [parameters, casadi.SX.sym("slip", 2)] if sticks else [parameters]
    slip = (known[1][0], known[1][1]) if sticks else None

    rates = chart.turned(robot, *halves(state, chart), None)
    slope = slope_of(chart, rates, state, tau, slip)
    model = casadi.Function("model", [state, tau, *known], [slope])
    end, _ = close_loop(robot, chart, state, None, slip)
    closing = casadi.Function("closing", [state, *known], [end])
    step = partial(_free_step, model, closing, torques)
    if torques is not None:
        known.append(casadi.SX.sym("t"))
        if torques.text is None:
            return lambda *given: step(*map(casadi.DM, given))
    inputs = [state, tau, length, tolerance, *known]
    return casadi.Function("free_step", inputs, casadi.cse(step(*inputs)))


def _free_step(model, closing, torques, state, tau, length, tolerance, *known):
    """Return the outputs of `free_step`, of symbols or CasADi's numbers."""
    if torques is not None:
        *known, t = known

    def slope(stage, fraction):
        joint = tau
        if torques is not None:
            now = t + fraction * length
            joint = torques.function(now, stage[JOINTS], stage[JOINT_RATES], tau)
        return model(stage, joint, *known)

    slopes: list = []
    after = runge_kutta("dop8", length, state, slope, slopes)
    end = closing(after, *known)
    error = _error(state, length, slopes) / tolerance
    slopes.append(slope(end, 1.0))
    for row, fraction in zip(DOP853.A_EXTRA, DOP853.C_EXTRA):
        slopes.append(slope(state + length * weighted_sum(row, slopes), fraction))
    change = end - state
    polynomial = [
        change,
        length * slopes[0] - change,
        2 * change - length * (slopes[DOP853.n_stages] + slopes[0]),
    ]
    polynomial += [length * weighted_sum(row, slopes) for row in DOP853.D]
    return [end, error, casadi.horzcat(*polynomial)]


def _error(state, length, slopes):
    """Return the error of a step of order 8, rad."""
    rates = casadi.fabs(state[4:])
    scale = casadi.vertcat(np.ones(4), 1 + rates)
    fifth = casadi.sumsqr(weighted_sum(DOP853.E5, slopes) / scale)
    third = casadi.sumsqr(weighted_sum(DOP853.E3, slopes) / scale)
    both = casadi.fmax(8 * (fifth + 0.01 * third), 1e-300)
    return length * fifth / casadi.sqrt(both)


def slope_and_closing(robot: Robot, state: Any, tau: Any) -> tuple[Any, Any]:
    """Return symbols of the slope of a state of the four bars, and of the state with its loop
    closed.
    """
    chart = BarAngles()
    slope = slope_of(chart, turned_rates(robot, chart, state, ()), state, tau)
    return slope, close_loop(robot, chart, state, ())[0]


@lru_cache(maxsize=8)
def holding(kind: type, names: tuple) -> casadi.Function:
    """Return (state (8), tau, parameters, slip) -> the friction that keeps what sticks, N m."""
    state, tau, _ = symbols_of(BarAngles())
    slip = casadi.SX.sym("slip", 2)
    parameters = casadi.SX.sym("parameters", count_of(kind, names))
    robot = with_parameters(kind, parameters, names)
    rates = bars_rates(robot, *halves(state, BarAngles()))
    _, held = held_by(rates, (tau[0], tau[1]), (slip[0], slip[1]))
    return casadi.Function("holding", [state, tau, parameters, slip], [casadi.vertcat(*held)])


def between(state: np.ndarray, polynomial: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the states (n, 8) at places (n,) in [0, 1] of steps.

    state : (n, 8), where the steps begin. polynomial : (n, 7, 8).
    """
    x = place[:, None]
    value = 0.0
    for k in range(6, -1, -1):
        factor = x if k % 2 == 0 else 1 - x
        value = (value + polynomial[:, k]) * factor
    return state + value


def runge_kutta(
    method: str, step: Any, state: Any, slope: Callable, slopes: list | None = None
) -> Any:
    """Return the state one explicit Runge-Kutta step later.

    Parameters
    ----------
    method : "rk4" or "dop8"
    step : s
    state : numbers or symbols
    slope : callable
        (a stage's state, its fraction of the step) -> its slope.
    slopes : list, optional
        Takes the stages' slopes.
    """
    a, b, c = tableau(method)
    slopes = [] if slopes is None else slopes
    for row, fraction in zip(a, c):
        stage = state
        for weight, k in zip(row, slopes):
            if weight:
                stage = stage + step * weight * k
        slopes.append(slope(stage, fraction))
    return state + step * weighted_sum(b, slopes)


def weighted_sum(weights: Sequence[float], slopes: Sequence) -> Any:
    """Return the sum of weight times slope; weights that are 0 cost no instruction."""
    return sum(weight * slope for weight, slope in zip(weights, slopes) if weight)


def tableau(method: str) -> tuple[list, list, list]:
    """Return Butcher's a, b, c: of the classical RK4, or Dormand and Prince's of order 8."""
    if method == "rk4":
        a = [[], [1 / 2], [0, 1 / 2], [0, 0, 1]]
        return (a, [1 / 6, 1 / 3, 1 / 3, 1 / 6], [0, 1 / 2, 1 / 2, 1])
    return DOP853.A.tolist(), DOP853.B.tolist(), DOP853.C.tolist()


def observation(rates: Rates) -> Any:
    """Return q, q', xi, xi', sines and det A, their rates, kinetic energy: the columns above."""
    pose = rates.pose
    q = (leg.q for leg in pose.legs)
    margins = *pose.sines, pose.det_A, *rates.margin_rates
    q_dot, xi_dot = rates.components
    return pack(*q, *q_dot, *pose.point, *xi_dot, *margins, energy(rates))


def motion_of(robot: Robot, rows: np.ndarray) -> Rates:
    """Return the motion of observations (n, columns)."""
    parts = Q, XI, Q_DOT, XI_DOT
    q, xi, q_dot, xi_dot = (rows[:, part].T for part in parts)
    return rates_from_joint_state(robot, q, xi, q_dot, xi_dot)


def symbols_of(chart: StateChart, kind: Any = casadi.SX) -> tuple[Any, Any, Any]:
    """Return the symbols of a state, the torques and the modes."""
    state = kind.sym("state", 2 * chart.size)
    return state, kind.sym("tau", 2), kind.sym("modes", 2)


def turned_rates(robot: Robot, chart: StateChart, stage: Any, modes: Sequence) -> Rates:
    """Return Rates of a stage that have the right accelerations: some charts turn the robot."""
    return chart.turned(robot, *halves(stage, chart), modes)


def slope_of(
    chart: StateChart, rates: Rates, state: Any, tau: Any, slip: tuple | None = None
) -> Any:
    """Return symbols of the slope of a state: its rates and accelerations under torques tau."""
    if slip is None:
        accelerations = forward_dynamics(rates, tau)
    else:
        accelerations = slipping_dynamics(rates, (tau[0], tau[1]), slip)
    return casadi.vertcat(state[chart.size :], *chart.accelerations(accelerations))


def close_loop(
    robot: Robot, chart: StateChart, state: Any, modes: Sequence | None, slip: tuple | None = None
) -> tuple[Any, Rates]:
    """Return the state with its loop closed, and its Rates; a drive that sticks stays."""
    if slip is None:
        c, c_dot, rates = chart.closed(robot, *halves(state, chart), modes)
    else:
        left, right = slip
        moves = left * left, right * right
        c, c_dot, rates = closed(robot, *halves(state, chart), moves)
    return casadi.vertcat(*c, *c_dot), rates
