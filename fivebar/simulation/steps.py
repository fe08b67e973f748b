"""Compiled steps of the plant: its right side in a chart, what it says of itself, and Runge-Kutta
on it.

The right side is a CasADi function made from the same equations as everything else. Beside the
slope it gives what the state says of itself (angles, end-effector, singular margins and their
rates, energy).
"""

from __future__ import annotations

from functools import lru_cache

import casadi
import numpy as np
from scipy.integrate import DOP853

from ..base.backend import pack
from ..models.charts import BarAngles, halves
from ..models.dynamics import energy, forward_dynamics, held_by, slipping_dynamics
from ..models.four_joints import bars_rates, closed, rates_from_joint_state
from ..models.parameters import count_of, with_parameters

# Columns of an observation.
Q, Q_DOT, XI, XI_DOT, MARGINS, MARGIN_RATES, ENERGY = (
    slice(0, 2),
    slice(2, 4),
    slice(4, 6),
    slice(6, 8),
    slice(8, 11),
    slice(11, 14),
    14,
)
COLUMNS = 15
METHODS = ("rk4", "dop8")


@lru_cache(maxsize=64)
def model_functions(robot, chart):
    """(state, tau, modes) -> slope, and (state, modes) -> observation."""
    state, tau, modes = _symbols(chart)
    parts = robot, *halves(state, chart), (modes[0], modes[1])
    slope, seen = _slope(chart, chart.turned(*parts), state, tau), observation(chart.rates(*parts))
    model = casadi.Function("model", [state, tau, modes], casadi.cse([slope]))
    return model, casadi.Function("look", [state, modes], casadi.cse([seen]))


@lru_cache(maxsize=64)
def block_function(robot, chart, method, step, count):
    """(state, tau, modes) -> (states after each of `count` steps, what is seen before each, and
    after the last).
    """
    one, look = step_function(robot, chart, method, step), model_functions(robot, chart)[1]
    state, tau, modes = _symbols(chart, casadi.MX)
    held = casadi.repmat(tau, 1, count), casadi.repmat(modes, 1, count)
    states, rows = one.mapaccum(count)(state, *held)
    return casadi.Function("block", [state, tau, modes], [states, rows, look(states[:, -1], modes)])


@lru_cache(maxsize=64)
def step_function(robot, chart, method, step):
    """(state, tau, modes) -> (state after one step under a held torque, what is seen before it)."""
    state, tau, modes = _symbols(chart)
    found = runge_kutta_step(robot, chart, method, step, state, tau, (modes[0], modes[1]))
    return casadi.Function("step", [state, tau, modes], casadi.cse(list(found)))


def runge_kutta_step(robot, chart, method, step, state, tau, modes):
    """Symbols of the state after one step under a held torque, and of what is seen before it."""
    first = chart.rates(robot, *halves(state, chart), modes)

    def slope(stage, _):
        rates = first if stage is state else chart.turned(robot, *halves(stage, chart), modes)
        return _slope(chart, rates, stage, tau)

    after, _ = _closed(robot, chart, runge_kutta(method, step, state, slope), modes)
    return after, observation(first)


def propagate(robot, chart, modes, method, step, count, torque):
    """(state) -> state after `count` steps from t = 0 under torque(t), read at every stage: the
    plant alone.

    torque: t -> (tau1, tau2), with CasADi's functions. chart, modes: as in models.charts. For the
        shortest time to a
    given accuracy: nothing else is computed.
    """
    state, t = casadi.SX.sym("state", 2 * chart.size), casadi.SX.sym("t")
    begin, first = _closed(
        robot, chart, state, modes
    )  # here, as the first stage needs the same directions

    def slope(stage, fraction):
        rates = first if stage is begin else chart.turned(robot, *halves(stage, chart), modes)
        return _slope(chart, rates, stage, casadi.vertcat(*torque(t + fraction * step)))

    one = casadi.Function("step", [state, t], casadi.cse([runge_kutta(method, step, begin, slope)]))
    start = casadi.MX.sym("state", 2 * chart.size)
    end = one.fold(count)(start, step * casadi.DM(range(count)).T)
    if chart.size > len(robot.drives):
        end = casadi.Function("close", [state], [begin])(end)
    return casadi.Function("propagate", [start], [end])


@lru_cache(maxsize=8)
def free_step(kind, names=()):
    """A step of any length in the bars of any robot of a kind, by Dormand and Prince's method of
    order 8:

    (state (8), tau, length, tolerance, parameters) -> (state after it, its error over the
    tolerance, the polynomial in between (8, 7)). The error is theirs, of order 5 and 3 together, in
    rad of the bars and, over 1 + |rate|, of rates. Where dry friction is among the names there is
    one more input: how the drives slip (`loads.asked_for`).
    """
    chart, parameters = BarAngles(), casadi.SX.sym("parameters", count_of(kind, names))
    state, tau, _ = _symbols(chart)
    length, tolerance = casadi.SX.sym("length"), casadi.SX.sym("tolerance")
    robot = with_parameters(kind, parameters, names)
    sticks = [casadi.SX.sym("slip", 2)] if {"fs1", "fs2"} & set(names) else []
    slip = (sticks[0][0], sticks[0][1]) if sticks else None

    whole = casadi.SX.sym("state", 8)
    model = casadi.Function(
        "model",
        [whole, tau, parameters, *sticks],
        [_slope(chart, chart.turned(robot, *halves(whole, chart), None), whole, tau, slip)],
    )
    slopes = []
    after = runge_kutta(
        "dop8", length, state, lambda stage, _: model(stage, tau, parameters, *sticks), slopes
    )
    end, _ = _closed(robot, chart, after, None, slip)
    scale = casadi.vertcat(np.ones(4), 1 + casadi.fabs(state[4:]))
    fifth, third = (weighted_sum(row, slopes) / scale for row in (DOP853.E5, DOP853.E3))
    fifth, third = casadi.sumsqr(fifth), casadi.sumsqr(third)
    error = (
        length * fifth / casadi.sqrt(casadi.fmax(8 * (fifth + 0.01 * third), 1e-300)) / tolerance
    )
    slopes.append(model(end, tau, parameters, *sticks))
    for row in DOP853.A_EXTRA:
        stage = state + length * weighted_sum(row, slopes)
        slopes.append(model(stage, tau, parameters, *sticks))
    change = end - state
    polynomial = [
        change,
        length * slopes[0] - change,
        2 * change - length * (slopes[DOP853.n_stages] + slopes[0]),
    ]
    polynomial += [length * weighted_sum(row, slopes) for row in DOP853.D]
    inputs = [state, tau, length, tolerance, parameters, *sticks]
    return casadi.Function(
        "free_step", inputs, casadi.cse([end, error, casadi.horzcat(*polynomial)])
    )


@lru_cache(maxsize=8)
def holding(kind, names):
    """(state (8), tau, parameters, slip) -> the friction that drives which stick need to stay, N
    m.
    """
    state, tau, slip = (
        casadi.SX.sym(name, n) for name, n in (("state", 8), ("tau", 2), ("slip", 2))
    )
    parameters = casadi.SX.sym("parameters", count_of(kind, names))
    rates = bars_rates(with_parameters(kind, parameters, names), *halves(state, BarAngles()))
    _, held = held_by(rates, (tau[0], tau[1]), (slip[0], slip[1]))
    return casadi.Function("holding", [state, tau, parameters, slip], [casadi.vertcat(*held)])


def between(state, polynomial, place):
    """States (n, 8) at places (n,) in [0, 1] of steps that begin at state (n, 8) with polynomials
    (n, 7, 8).
    """
    x = place[:, None]
    value = 0.0
    for k in range(6, -1, -1):
        value = (value + polynomial[:, k]) * (x if k % 2 == 0 else 1 - x)
    return state + value


def runge_kutta(method, step, state, slope, slopes=None):
    """The state one explicit Runge-Kutta step later; slope(stage's state, its fraction of the
    step).

    slopes: a list that takes the stages' slopes.
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


def weighted_sum(weights, slopes):
    """Return the sum of weight times slope; weights that are 0 cost no instruction."""
    return sum(weight * slope for weight, slope in zip(weights, slopes) if weight)


def tableau(method):
    """Butcher's a, b, c as lists of floats: the classical RK4, or Dormand and Prince's of order 8
    (from SciPy).
    """
    if method == "rk4":
        a = [[], [1 / 2], [0, 1 / 2], [0, 0, 1]]
        return a, [1 / 6, 1 / 3, 1 / 3, 1 / 6], [0, 1 / 2, 1 / 2, 1]
    return DOP853.A.tolist(), DOP853.B.tolist(), DOP853.C.tolist()


def observation(rates):
    """q, q', xi, xi', the sines (q12, q22, det A), their rates, kinetic energy: in the order of the
    columns above.
    """
    pose = rates.pose
    q = (leg.q for leg in pose.legs)
    margins = *pose.sines, pose.det_A, *rates.margin_rates
    q_dot, xi_dot = rates.components
    return pack(*q, *q_dot, *pose.point, *xi_dot, *margins, energy(rates))


def motion_of(robot, rows):
    """The motion of which observations (n, columns) are, as Rates."""
    return rates_from_joint_state(robot, *(rows[:, part].T for part in (Q, XI, Q_DOT, XI_DOT)))


def _symbols(chart, kind=casadi.SX):
    return kind.sym("state", 2 * chart.size), kind.sym("tau", 2), kind.sym("modes", 2)


def _slope(chart, rates, state, tau, slip=None):
    acc = (
        forward_dynamics(rates, tau)
        if slip is None
        else slipping_dynamics(rates, (tau[0], tau[1]), slip)
    )
    return casadi.vertcat(state[chart.size :], *chart.accelerations(acc))


def _closed(robot, chart, state, modes, slip=None):
    """The state with its loop closed, and its Rates; a drive that sticks stays where it is."""
    if slip is None:
        c, c_dot, rates = chart.closed(robot, *halves(state, chart), modes)
    else:
        c, c_dot, rates = closed(robot, *halves(state, chart), tuple(each * each for each in slip))
    return casadi.vertcat(*c, *c_dot), rates
