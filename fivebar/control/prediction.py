"""What the tracker predicts by: charts, one sample of the motion in them, the horizon, and what a state shows.

The state is that of a chart, (c1, c2, c1', c2'): task coordinates, or where a leg is almost in line leg coordinates
of that leg. Both are regular at Type 2, and the forward dynamics is the bar-force form in both: a horizon may lie
across a crossing, where a model in joint coordinates ends.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca

from ..models.charts import Leg, Task
from ..models.compiled import Buffered, compiled
from ..models.dynamics import forward_dynamics

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..models.robots import Robot

CHARTS = Task(), Leg(0), Leg(1)
ENTER_TASK, LEAVE_TASK, LEAVE_LEG = 0.4, 0.25, 0.5  # the smaller sine over the larger; the chart's own over the other


def choose_chart(margins: Sequence[float], present: Task | Leg | None = None) -> Task | Leg:
    """The chart to be in, by the sines (q12, q22, ...): task coordinates, which are faster, where both are good."""
    left, right = abs(margins[0]), abs(margins[1])
    if min(left, right) >= (LEAVE_TASK if present is CHARTS[0] else ENTER_TASK) * max(left, right):
        return CHARTS[0]
    if present is CHARTS[1] and right >= LEAVE_LEG * left or present is CHARTS[2] and left >= LEAVE_LEG * right:
        return present
    return CHARTS[1] if right > left else CHARTS[2]


class Model:
    """Compiled functions of one chart, called through buffers; arrays they return are overwritten by the next call."""

    def __init__(
        self, robot: Robot, chart: Task | Leg, lengths: tuple[float, ...], speed: bool, jit: bool | str
    ) -> None:
        step, rollout, look = _functions(robot, chart, lengths, speed)
        self.chart, self.task = chart, isinstance(chart, Task)
        self.step, self.rollout, self.look = (Buffered(compiled(function, jit)) for function in (step, rollout, look))


@lru_cache(maxsize=64)
def sample_and_look(robot: Robot, chart: Task | Leg) -> tuple[ca.Function, ca.Function]:
    """(state, tau, modes, its length) -> the state a sample later with its slopes; what a state shows, with slopes."""
    x, tau, modes, h = ca.SX.sym("x", 4), ca.SX.sym("tau", 2), ca.SX.sym("modes", 2), ca.SX.sym("h")

    def at(state):
        return chart.rates(robot, (state[0], state[1]), (state[2], state[3]), (modes[0], modes[1]))

    def slope(state):
        return ca.vertcat(state[2:], *chart.accelerations(forward_dynamics(at(state), tau)))

    # The midpoint rule, with the derivative of the slope taken once, at the midpoint: of second order, like the rule.
    middle = ca.SX.sym("middle", 4)
    k = slope(middle)
    slope_at = ca.Function("slope", [middle, tau, modes], ca.cse([k, ca.jacobian(k, middle), ca.jacobian(k, tau)]))
    k, fx, fu = slope_at(x + h / 2 * slope(x), tau, modes)
    after, one = x + h * k, ca.SX.eye(4)
    A, B = one + h * fx @ (one + h / 2 * fx), h * (one + h / 2 * fx) @ fu
    sample = ca.Function("sample", [x, tau, modes, h], [after, A, B])

    rates = at(x)
    y, measured = ca.vertcat(rates.pose.xi, rates.xi_dot), ca.vertcat(rates.pose.q, rates.q_dot)
    margins = ca.vertcat(*rates.pose.sines, rates.pose.det_A)
    shown = [y, _rows(y, x), measured, ca.densify(_rows(measured, x)), margins]
    return sample, ca.Function("tracker_look", [x, modes], ca.cse(shown))


@lru_cache(maxsize=64)
def _functions(robot, chart, lengths, speed):
    """(state, tau, modes) -> state; the same over the horizon with derivatives; what a state shows."""
    sample, look = sample_and_look(robot, chart)
    x, tau, modes, h = ca.SX.sym("x", 4), ca.SX.sym("tau", 2), ca.SX.sym("modes", 2), ca.SX.sym("h")
    step = ca.Function("tracker_step", [x, tau, modes], ca.cse([sample(x, tau, modes, lengths[0])[0]]))
    after, A, B = sample(x, tau, modes, h)
    outputs = [after, ca.densify(ca.horzcat(A, B).T)]
    y_after, C_after, measured_after, D_after, _ = look(after, modes)
    if not isinstance(chart, Task):
        outputs += [y_after, C_after]
    if speed:
        outputs += [measured_after[2:], D_after[:, 2:]]
    stage, N = ca.Function("stage", [x, tau, modes, h], ca.cse(outputs)), len(lengths)
    start, torques, signs = ca.MX.sym("x", 4), ca.MX.sym("tau", 2, N), ca.MX.sym("modes", 2)
    stages = stage.mapaccum(N)(start, torques, ca.repmat(signs, 1, N), ca.DM(lengths).T)
    return step, ca.Function("tracker_rollout", [start, torques, signs], stages), look


def _rows(f, x):
    """The transposed Jacobian: through a buffer, a row per component of f."""
    return ca.densify(ca.jacobian(f, x).T)
