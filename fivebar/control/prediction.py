"""The tracker's prediction: one sample of the motion, the horizon, and the end-effector of a state.

The state is that of the four bars, (a, a'). It has no mode and is regular at Type 1 and Type 2, so
a horizon may lie across both, where a model in joint or in task coordinates ends.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ..models.charts import BarAngles, halves
from ..models.compiled import Buffered, compiled
from ..models.dynamics import forward_dynamics
from ..models.four_joints import closed

if TYPE_CHECKING:
    from ..models.loaded_robot import JointTorques
    from ..models.robots import Robot

CHART = BarAngles()
SIZE = 2 * CHART.size  # of a state
JOINTS = [0, 2]  # places of the active joints in it
RATES = [4, 6]


class Model:
    """Compiled functions, called through buffers; arrays they return are overwritten by the next
    call.

    step: (state, tau, t) -> state a period later; rollout: (state, taus (N, 2), t) -> states
    (N, 8), their slopes [A B] (N, 8, 10) and, as look gives them of one state, (xi, xi') (N, 4) and
    its slope (N, 4, 8). t: s, at the state.
    """

    def __init__(
        self,
        robot: Robot,
        lengths: tuple[float, ...],
        jit: bool | str,
        torques: JointTorques | None = None,
    ) -> None:
        step, rollout, look = _functions(robot, lengths, torques)
        self.step = Buffered(compiled(step, jit))
        self.rollout = Buffered(compiled(rollout, jit))
        self.look = Buffered(compiled(look, jit))


@lru_cache(maxsize=64)
def sample(robot: Robot, torques: JointTorques | None = None) -> ca.Function:
    """Return (state, tau, t, length) -> the state a sample later, and its slopes A and B.

    The state is on the closed loop again, the slopes are those before.
    """
    x = ca.SX.sym("x", SIZE)
    tau = ca.SX.sym("tau", 2)
    t = ca.SX.sym("t")
    h = ca.SX.sym("h")

    def slope(state, t):
        rates = CHART.turned(robot, *halves(state, CHART), None)
        joint = tau
        if torques is not None:
            joint = torques.function(t, state[JOINTS], state[RATES], tau)
        accelerations = CHART.accelerations(forward_dynamics(rates, joint))
        return ca.vertcat(state[CHART.size :], *accelerations)

    # The midpoint rule, with the derivative of the slope taken once, at the midpoint: of second
    # order, like the rule.
    middle = ca.SX.sym("middle", SIZE)
    k = slope(middle, t)
    slopes = ca.cse([k, ca.jacobian(k, middle), ca.jacobian(k, tau)])
    slope_at = ca.Function("slope", [middle, tau, t], slopes)
    k, fx, fu = slope_at(x + h / 2 * slope(x, t), tau, t + h / 2)
    one = ca.SX.eye(SIZE)
    A = one + h * fx @ (one + h / 2 * fx)
    B = h * (one + h / 2 * fx) @ fu
    c, c_dot, _ = closed(robot, *halves(x + h * k, CHART))
    return ca.Function("sample", [x, tau, t, h], [ca.vertcat(*c, *c_dot), A, B])


@lru_cache(maxsize=64)
def _functions(robot, lengths, torques):
    x = ca.SX.sym("x", SIZE)
    tau = ca.SX.sym("tau", 2)
    t = ca.SX.sym("t")
    h = ca.SX.sym("h")
    after = sample(robot, torques)(x, tau, t, lengths[0])[0]
    step = ca.Function("tracker_step", [x, tau, t], ca.cse([after]))
    rates = CHART.rates(robot, *halves(x, CHART), None)
    y = ca.vertcat(*rates.pose.point, *rates.components[1])
    look = ca.Function("tracker_look", [x], ca.cse([y, _rows(ca.jacobian(y, x))]))
    after, A, B = sample(robot, torques)(x, tau, t, h)
    outputs = [after, _rows(ca.horzcat(A, B)), *look(after)]
    stage = ca.Function("stage", [x, tau, t, h], ca.cse(outputs))
    N = len(lengths)
    inputs = start, taus, now = ca.MX.sym("x", SIZE), ca.MX.sym("tau", 2, N), ca.MX.sym("t")
    times = now + ca.DM(np.cumsum((0.0, *lengths[:-1]))).T
    stages = stage.mapaccum(N)(start, taus, times, ca.DM(lengths).T)
    return step, ca.Function("tracker_rollout", inputs, stages), look


def _rows(matrix):
    """Transposed: through a buffer, row by row."""
    return ca.densify(matrix.T)
