"""Whole closed loops as one compiled function: plant, built-in controller and zero-order hold, from many starts."""

from functools import lru_cache

import numpy as np

from ..control.laws import PD, ComputedTorque
from ..models.charts import CHARTS
from ..models.compiled import Buffered, compiled
from .plant import refuse_jumps
from .run import Control
from .simulate import Grid, assemble, check_options
from .steps import COLUMNS, Q_DOT, Q, model_functions, step_function

TOGETHER = 64  # runs in one call: more would only take memory
INLINE = 10  # steps in a control period that are written out: beyond, a loop is as fast


def simulate_many(
    robot, controller, reference, starts, *, duration=None, control_period=0.01, step=0.001, torque_limit=None, delay=0,
    chart="joint", method="rk4", jit=False,
):  # fmt: skip
    """Simulate one closed loop from many starts by one compiled function; gives a list of Run.

    controller: PD or ComputedTorque. starts: Rates of a batch (n,), e.g. scattered about the reference's start. chart:
    "joint" or "task", held fast. The other options as in `simulate`, whose Runs these equal within rounding; jit as in
    `compile`. Raises as `simulate` does, for the first run that does not go through, and names it.
    """
    if not isinstance(controller, (PD, ComputedTorque)):
        raise ValueError(f"a compiled loop needs a PD or ComputedTorque controller, not {type(controller).__name__}")
    check_options(chart, method, delay, torque_limit, charts=("joint", "task"))
    grid, (chart,) = Grid.of(duration, reference, step, control_period), CHARTS[chart]
    if starts.q_dot.ndim != 2:
        raise ValueError(f"starts must be the Rates of a batch (n,): q_dot (n, 2), not {starts.q_dot.shape}")
    periods = -(-grid.steps // grid.block)
    loop = robot, controller, chart, method, grid.step, grid.block, periods, torque_limit, delay
    times = np.arange(periods) * (grid.block * grid.step)
    target = controller.target(times, reference)
    targets = np.hstack([target.rates.pose.q, target.rates.q_dot, target.q_ddot])
    from tqdm import tqdm

    states, modes = _initial(chart, starts)
    runs = []
    for first in tqdm(range(0, len(states), TOGETHER), unit=f" x {TOGETHER} runs", disable=len(states) <= TOGETHER):
        state, mode = states[first : first + TOGETHER], modes[first : first + TOGETHER]
        count = len(state)
        outputs = _call(count, jit, *loop)(state.squeeze(), np.tile(targets, (count, 1)), mode.squeeze())
        parts = [part.reshape(count, -1, columns) for part, columns in zip(outputs, (COLUMNS, COLUMNS, 4))]
        for k, (rows, last, torques) in enumerate(zip(*parts)):
            rows = np.vstack([rows, last])[: grid.steps + 1]
            runs.append(_one_run(robot, reference, grid, rows, torques, chart, torque_limit, first + k))
    return runs


def _one_run(robot, reference, grid, rows, torques, chart, torque_limit, number):
    held = np.repeat(torques[:, 2:], grid.block, axis=0)[: grid.steps]
    try:
        refuse_jumps(robot, rows, held, (chart,), chart, grid.step)
    except ArithmeticError as error:
        error.args = (f"run {number}: {error}",)
        raise
    sampled = rows[: grid.steps : grid.block]
    t = np.arange(len(sampled)) * (grid.block * grid.step)
    control = Control(t, sampled[:, Q], sampled[:, Q_DOT], torques[:, :2], torques[:, 2:])
    return assemble(robot, reference, grid.step, rows, held, control, torque_limit)


def _initial(chart, starts):
    """States (n, 4) and modes (n, 2) of a batch in a chart."""
    c, c_dot, modes = chart.coordinates(starts)
    return np.stack(np.broadcast_arrays(*c, *c_dot), axis=-1), np.stack(np.broadcast_arrays(*modes), axis=-1)


@lru_cache(maxsize=4)
def _call(count, jit, *loop):
    """`count` loops at once, with their memory, which costs as much as some steps."""
    function = _loop(*loop)
    return Buffered(compiled(function.map(count) if count > 1 else function, jit))


@lru_cache(maxsize=16)
def _loop(robot, controller, chart, method, step, block, periods, torque_limit, delay):
    """(state, targets (6, periods), modes) -> (observations at each step, after the last, both torques)."""
    import casadi

    size = 4 + 2 * delay  # the state and the torques on their way
    state, target, modes = casadi.SX.sym("state", size), casadi.SX.sym("target", 6), casadi.SX.sym("modes", 2)
    model, look = model_functions(robot, chart)
    seen = look(state[:4], modes)
    commanded = controller.law(seen[:2], seen[2:4], target[:2], target[2:4], target[4:])
    queue = casadi.vertcat(state[4:], commanded)
    applied = queue[:2]
    if torque_limit is not None:
        applied = casadi.fmin(casadi.fmax(applied, -torque_limit), torque_limit)
    names = [state, target, modes]
    sample = casadi.Function("sample", names, casadi.cse([applied, queue[2:], casadi.vertcat(commanded, applied)]))

    state, target, modes = casadi.MX.sym("state", size), casadi.MX.sym("target", 6), casadi.MX.sym("modes", 2)
    applied, queue, log = sample(state, target, modes)
    held = casadi.repmat(applied, 1, block), casadi.repmat(modes, 1, block)
    states, rows = step_function(robot, chart, method, step).mapaccum(block)(state[:4], *held)
    period = casadi.Function("period", [state, target, modes], [casadi.vertcat(states[:, -1], queue), rows, log])
    if block <= INLINE:
        # One flat list of instructions, in which the sample shares the first stage's.
        flat = [casadi.SX.sym("state", size), casadi.SX.sym("target", 6), casadi.SX.sym("modes", 2)]
        period = casadi.Function("period", flat, casadi.cse(period.expand()(*flat)))

    start, targets = casadi.MX.sym("start", 4), casadi.MX.sym("targets", 6, periods)
    begin = casadi.vertcat(start, casadi.DM.zeros(2 * delay))
    states, rows, log = period.mapaccum(periods)(begin, targets, casadi.repmat(modes, 1, periods))
    return casadi.Function("loop", [start, targets, modes], [rows, look(states[:4, -1], modes), log])
