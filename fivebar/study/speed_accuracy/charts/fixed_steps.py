"""Our fixed steps and nothing else: what the charts of speed against accuracy measure."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi

from ....models.charts import StateChart
from ....models.robots import Robot
from ....simulation.steps import close_loop, runge_kutta, slope_of, symbols_of, turned_rates


def slope_function(robot: Robot, chart: StateChart) -> casadi.Function:
    """Return (state, tau, modes) -> slope of the state."""
    state, tau, modes = symbols_of(chart)
    rates = turned_rates(robot, chart, state, (modes[0], modes[1]))
    slope = casadi.cse([slope_of(chart, rates, state, tau)])
    return casadi.Function("model", [state, tau, modes], slope)


def propagate(
    robot: Robot,
    chart: StateChart,
    modes: Sequence,
    method: str,
    step: float,
    count: int,
    torque: Callable,
) -> casadi.Function:
    """Return (state) -> state after `count` steps from t = 0 under torques read at every stage.

    Nothing else is computed, for the shortest time to a given accuracy.

    Parameters
    ----------
    chart, modes
        As in models.charts.
    torque : callable
        t -> (tau1, tau2), N m, with CasADi's functions.
    """
    state = casadi.SX.sym("state", 2 * chart.size)
    t = casadi.SX.sym("t")
    # The loop is closed before a step, not after it: the first stage needs the same directions.
    begin, first = close_loop(robot, chart, state, modes)

    def slope(stage, fraction):
        rates = first if stage is begin else turned_rates(robot, chart, stage, modes)
        return slope_of(chart, rates, stage, casadi.vertcat(*torque(t + fraction * step)))

    after = runge_kutta(method, step, begin, slope)
    one = casadi.Function("step", [state, t], casadi.cse([after]))
    start = casadi.MX.sym("state", 2 * chart.size)
    times = step * casadi.DM(range(count)).T
    end = one.fold(count)(start, times)
    if chart.size > len(robot.drives):
        end = casadi.Function("close", [state], [begin])(end)
    return casadi.Function("propagate", [start], [end])
