"""Whole closed loops as one compiled function, over many runs.

The function has the plant, a built-in controller and the zero-order hold.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import lru_cache
from typing import NamedTuple

import casadi
import numpy as np

from ..base.checks import a_callable, bounded, instance, optional, positive, shown, takes
from ..base.checks import robot as must_be_robot
from ..base.progress import progress
from ..control.laws import PD, ComputedTorque
from ..models.charts import CHARTS, BarAngles, StateChart, halves
from ..models.compiled import Buffered, compiled
from ..models.geometry import igm
from ..models.kinematics import Rates, ikm, some_rates
from ..models.parameters import count_of, names_of, parameters_of, with_parameters
from ..models.robots import Robot, nearest_equivalent_angle
from .events import may_cross
from .plant import check_start, refuse_losses, refuse_sticking
from .run import Control, Run
from .settings import Integrator, Measurement
from .simulate import Grid, begin_of, run_of
from .steps import COLUMNS, MARGIN_RATES, MARGINS, Q_DOT, Q, observation, runge_kutta_step

MOST_ROWS = 3 * 10**7  # of all runs
ROW_BYTES = 180  # memory of a row
MOST_BLOCK = 10**5  # steps in a control period
STEP_BYTES = 1200  # memory of a step during a call
AT_ONCE = 4 * 10**6  # rows in one call
TOGETHER = 128  # runs in one call: more would only take memory
INLINE = 10  # steps in a control period that are written out: beyond, a loop is as fast


class _Law(NamedTuple):
    """All that a compiled loop depends on, but for robots, gains, starts and the reference."""

    kind: type  # of the robots
    names: tuple[str, ...]  # of their parameters
    law: PD | ComputedTorque
    chart: StateChart
    method: str
    grid: Grid
    periods: int
    torque_limit: float | None
    measurement: Measurement

    @property
    def size(self) -> int:
        """Numbers in a state of the plant."""
        return 2 * self.chart.size

    @property
    def memory(self) -> int:
        """Numbers that go with the state: torques on their way, the last reading of encoders."""
        return 2 * self.measurement.delay + 2 * (self.measurement.encoder_resolution is not None)


@takes(
    reference=optional(a_callable),
    duration=optional(positive),
    control_period=positive,
    step=positive,
    torque_limit=optional(positive),
    measurement=optional(instance(Measurement)),
    integrator=optional(instance(Integrator)),
)
def simulate_many(
    robot: Robot | Sequence[Robot],
    controller: PD | ComputedTorque | Sequence,
    reference: Callable | None,
    starts: Rates | Sequence[Rates] | None = None,
    *,
    duration: float | None = None,
    control_period: float = 0.01,
    step: float = 0.001,
    torque_limit: float | None = None,
    measurement: Measurement | None = None,
    integrator: Integrator | None = None,
) -> list[Run]:
    """Simulate many closed loops by one compiled function, on all cores.

    The Runs equal those of `simulate` with the same chart and fixed steps, within rounding.

    Parameters
    ----------
    robot : Robot or sequence of Robot
        Of all runs, or one for each. Lengths and inertias are parameters of the function.
    controller : PD or ComputedTorque, or a sequence of these
        Of all runs, or one for each; they may differ in their gains alone.
    reference : callable, optional
        As in `simulate`.
    starts : Rates or sequence of Rates, optional
        Rates of a batch (n,), or one Rates for each run. None: each robot as the reference starts,
        in the controller's working modes.
    duration, control_period, step, torque_limit, measurement
        As in `simulate`.
    integrator : Integrator, optional
        Its steps are fixed; method None is "rk4".

    Returns
    -------
    list of Run

    Raises
    ------
    ValueError
        Where the arguments do not go together; it names the robots that do not reach the start.
    ArithmeticError, SingularityError
        As `simulate`, for the first run that does not go through; it has the run's number.

    Examples
    --------
    >>> import fivebar as fb
    >>> robots = [fb.FiveBar(m=m) for m in (0.4, 0.5, 0.6)]
    >>> controller = fb.ComputedTorque(fb.FiveBar(), kp=100, kd=20)
    >>> reference = fb.line((0.09, 0.068), (0.0, 0.1), duration=2.0)
    >>> [len(run.t) for run in fb.simulate_many(robots, controller, reference)]
    [2001, 2001, 2001]
    """
    measurement = measurement or Measurement()
    integrator = integrator or Integrator()
    if integrator.tolerance is not None:
        raise ValueError("simulate_many has fixed steps: an Integrator without tolerance")
    robots, controllers, starts = _runs_of(robot, controller, starts)
    law, gains = _one_law(controllers)
    grid = Grid.of(duration, reference, step, control_period)
    rows = len(robots) * grid.steps
    what = f"{len(robots)} runs of {grid.steps} steps are {rows:.3g} rows"
    bounded(rows, MOST_ROWS, what, ROW_BYTES)
    what = f"control_period = {control_period:g} s is {grid.block:.3g} steps"
    bounded(grid.block, MOST_BLOCK, what, STEP_BYTES)
    periods = -(-grid.steps // grid.block)
    loop = _Law(
        type(robots[0]),
        names_of(robots),
        law,
        CHARTS[integrator.chart],
        integrator.method or "rk4",
        grid,
        periods,
        torque_limit,
        replace(measurement, delay=min(measurement.delay, periods)),
    )
    parameters = np.array([parameters_of(each, loop.names) for each in robots])
    if starts is None:
        starts = _at_reference(robots, law, reference)
    states, modes = _at(loop, starts)
    times = np.arange(periods) * (grid.block * grid.step)
    target = law.target(times, reference)
    targets = np.hstack([target.rates.pose.q, target.rates.q_dot, target.q_ddot])
    t = np.arange(grid.steps + 1) * grid.step
    xi_ref = None if reference is None else reference(t)[0]
    runs = []
    together = max(1, min(TOGETHER, AT_ONCE // grid.steps))
    for first in progress(
        range(0, len(states), together),
        unit=f" x {together} runs",
        delay=1,
    ):
        part = slice(first, first + together)
        inputs = states[part], modes[part], parameters[part], gains[part]
        outputs = _called(loop, integrator.jit, targets, inputs)
        runs += _runs(loop, robots[part], t, outputs, xi_ref, first)
    return runs


def _runs_of(robot, controller, starts):
    """Return robots (n,), controllers (n,), and starts as they came, checked."""
    if isinstance(starts, str) or not isinstance(starts, (Rates, Sequence, type(None))):
        raise TypeError(
            f"starts must be the Rates of a batch, or one Rates for each run, not {shown(starts)}"
        )
    values = {"robots": robot, "controllers": controller, "starts": starts}
    lengths = {name: len(value) for name, value in values.items() if isinstance(value, Sequence)}
    if isinstance(starts, Rates):
        if starts.q_dot.ndim != 2:
            raise ValueError(
                f"starts must be the Rates of a batch (n,): q_dot (n, 2), not {starts.q_dot.shape}"
            )
        lengths["starts"] = len(starts.q_dot)
    if not lengths:
        raise ValueError("simulate_many needs several robots, controllers or starts")
    if len(set(lengths.values())) > 1 or 0 in lengths.values():
        counts = ", ".join(f"{count} {name}" for name, count in lengths.items())
        raise ValueError(f"one for each run: {counts} do not go together")
    count = max(lengths.values())
    robots = list(robot) if isinstance(robot, Sequence) else [robot] * count
    controllers = list(controller) if isinstance(controller, Sequence) else [controller] * count
    _check_robots(robots)
    for each in controllers:
        a_built_in_controller(each, "controller")
    if isinstance(starts, Rates) and any(each != starts.pose.robot for each in robots):
        raise ValueError(
            "starts is a batch of one robot's Rates: for several robots give a list, or None"
        )
    if isinstance(starts, Sequence):
        for each, start in zip(robots, starts):
            check_start(each, some_rates(start, "starts"))
    return robots, controllers, starts


def a_built_in_controller(value: object, name: str) -> PD | ComputedTorque:
    """Rule: a controller that a compiled loop can hold."""
    if not isinstance(value, (PD, ComputedTorque)):
        raise ValueError(
            f"a compiled loop needs a PD or ComputedTorque controller, not {type(value).__name__}"
        )
    return value


def _check_robots(robots):
    for k, robot in enumerate(robots):
        must_be_robot(robot, "robot")
        if type(robot) is not type(robots[0]):
            raise ValueError(
                f"robots of one kind go together: number {k} is a {type(robot).__name__}"
            )
        refuse_sticking(robot)


def _one_law(controllers):
    """Return the first controller, for all but the gains, and the gains (n, 4) of all."""
    first = controllers[0]
    same = [field.name for field in fields(first) if field.name not in ("kp", "kd")]
    gains = np.empty((len(controllers), 4))
    for k, controller in enumerate(controllers):
        alike = type(controller) is type(first) and all(
            getattr(controller, name) == getattr(first, name) for name in same
        )
        if not alike:
            raise ValueError(
                f"controllers of one loop differ in their gains alone: number {k} differs from"
                " number 0"
            )
        gains[k, :2], gains[k, 2:] = controller.kp, controller.kd
    return first, gains


def _at_reference(robots, law, reference):
    """Return the Rates with which each robot is at the reference's start."""
    if reference is None:
        raise ValueError("simulate_many needs starts, or a reference that says where all begin")
    xi, xi_dot, _ = begin_of(reference)
    starts = [ikm(igm(robot, xi, law.working, "nan"), xi_dot) for robot in robots]
    bad = [k for k, start in enumerate(starts) if not np.isfinite(start.q_dot).all()]
    if bad:
        first = ", ".join(map(str, bad[:5])) + " ..." * (len(bad) > 5)
        raise ValueError(
            f"{len(bad)} of {len(starts)} robots do not reach the reference's start ({xi[0]:.9g},"
            f" {xi[1]:.9g}) m: number {first}"
        )
    return starts


def _at(loop, starts):
    """Return the states with their memory (n, size + memory) and the modes (n, 2) of starts.

    No torque is on its way. The reading before the first is such that their difference gives the
    start's rate.
    """
    if isinstance(starts, Rates):
        rows = _columns(loop.chart, starts)
    else:
        rows = np.array([_columns(loop.chart, start) for start in starts])
    states, modes, q, q_dot = np.split(rows, np.cumsum([loop.size, 2, 2]), axis=1)
    memory = [np.zeros((len(rows), 2 * loop.measurement.delay))]
    resolution = loop.measurement.encoder_resolution
    if resolution is not None:
        reading = np.round(q / resolution) * resolution
        memory.append(reading - loop.grid.block * loop.grid.step * q_dot)
    return np.hstack([states, *memory]), modes


def _columns(chart, start):
    """Return state, modes, q and q' (*batch, size + 6) of a start."""
    c, c_dot, modes = chart.coordinates(start)
    q = [leg.q for leg in start.pose.legs]
    columns = np.broadcast_arrays(*c, *c_dot, *modes, *q, *start.components[0])
    return np.stack(columns, axis=-1).astype(float)


def _called(loop, jit, targets, inputs):
    """Return observations (n, steps + 1, columns) and the controllers' samples (n, periods, 8)."""
    states, modes, parameters, gains = inputs
    count = len(states)
    inputs = states, np.tile(targets, (count, 1)), modes, parameters, gains
    if count == 1:
        inputs = tuple(each.squeeze() for each in inputs)
    rows, last, samples = _compiled(count, jit, loop)(*inputs)
    rows = np.concatenate(
        [rows.reshape(count, -1, COLUMNS), last.reshape(count, 1, COLUMNS)],
        axis=1,
    )
    return rows[:, : loop.grid.steps + 1], samples.reshape(count, -1, 8)


def _runs(loop, robots, t, outputs, xi_ref, first):
    rows, samples = outputs
    grid = loop.grid
    times = np.arange(samples.shape[1]) * (grid.block * grid.step)
    torques = np.repeat(samples[:, :, 6:], grid.block, axis=1)[:, : grid.steps]
    crosses = may_cross(rows[:, :, MARGINS], rows[:, :, MARGIN_RATES])
    runs = []
    for k, robot in enumerate(robots):
        try:
            refuse_losses(robot, rows[k], torques[k], loop.chart, grid.step)
        except ArithmeticError as error:
            error.args = (f"run {first + k}: {error}",)
            raise
        control = Control(times, *np.split(samples[k], 4, axis=1))
        runs.append(
            run_of(
                robot,
                t,
                rows[k],
                torques[k],
                crosses=bool(crosses[k]),
                xi_ref=xi_ref,
                torque_limit=loop.torque_limit,
                control=control,
            )
        )
    return runs


@lru_cache(maxsize=4)
def _compiled(count, jit, loop):
    """Return `count` loops at once, on all cores, with their memory, which costs as some steps."""
    function = compiled(_function(loop), jit)
    return Buffered(function.map(count, "thread", os.cpu_count()) if count > 1 else function)


@lru_cache(maxsize=16)
def _function(loop):
    """Return (state, targets, modes, parameters, gains) -> observations, the last one, samples.

    The observations are those before each step; the samples what was measured, commanded, applied.
    """
    start, _, modes, p, gains = _symbols(loop, casadi.MX)
    targets = casadi.MX.sym("targets", 6, loop.periods)
    period, observe = _period(loop)
    held = (casadi.repmat(each, 1, loop.periods) for each in (modes, p, gains))
    states, rows, samples = period.mapaccum(loop.periods)(start, targets, *held)
    last = observe(states[: loop.size, -1], modes, p)
    inputs = [start, targets, modes, p, gains]
    return casadi.Function("loop", inputs, [rows, last, samples])


def _symbols(loop, kind):
    """Return the symbols of the state with its memory, a target, modes, parameters and gains."""
    lengths = {
        "state": loop.size + loop.memory,
        "target": 6,
        "modes": 2,
        "parameters": count_of(loop.kind, loop.names),
        "gains": 4,
    }
    return [kind.sym(name, length) for name, length in lengths.items()]


def _period(loop):
    """Return one control period, (state, target, modes, parameters, gains) -> state, rows, sample.

    And (state, modes, parameters) -> observation.
    """
    block = loop.grid.block
    state = casadi.SX.sym("state", loop.size)
    tau = casadi.SX.sym("tau", 2)
    _, _, modes, p, _ = _symbols(loop, casadi.SX)
    robot = with_parameters(loop.kind, p, loop.names)
    stepped, row = runge_kutta_step(
        robot,
        loop.chart,
        loop.method,
        loop.grid.step,
        state,
        tau,
        (modes[0], modes[1]),
    )
    observe = casadi.Function("observe", [state, modes, p], [row])
    advance = casadi.Function("advance", [state, tau, modes, p], [stepped, row])

    state, target, modes, p, gains = inputs = _symbols(loop, casadi.MX)
    applied, memory, sample = _sample(loop)(*inputs)
    held = (casadi.repmat(each, 1, block) for each in (applied, modes, p))
    states, rows = advance.mapaccum(block)(state[: loop.size], *held)
    after = casadi.vertcat(states[:, -1], memory)
    period = casadi.Function("period", inputs, [after, rows, sample])
    if block <= INLINE:
        # One flat list of instructions, in which the sample shares the first stage's.
        flat = _symbols(loop, casadi.SX)
        period = casadi.Function("period", flat, casadi.cse(period.expand()(*flat)))
    return period, observe


def law_of(
    robot: Robot,
    controller: PD | ComputedTorque,
    period: float,
    state: casadi.SX,
    target: casadi.SX,
) -> casadi.SX:
    """Return a controller's torques at a state of the four bars; target : q, q', q'' (6)."""
    law, gains = _one_law([controller])
    names = names_of([robot])
    grid = Grid(1, period, 1)
    loop = _Law(type(robot), names, law, BarAngles(), "dop8", grid, 1, None, Measurement())
    parameters = casadi.vertcat(*parameters_of(robot, names))
    return _sample(loop)(state, target, [0, 0], parameters, gains[0])[0]


def _sample(loop):
    """Return the controller: (state, ...) -> applied torques, memory after it, its sample (8)."""
    state, target, modes, p, gains = inputs = _symbols(loop, casadi.SX)
    chart = loop.chart
    resolution = loop.measurement.encoder_resolution
    robot = with_parameters(loop.kind, p, loop.names)
    row = observation(
        chart.rates(
            robot,
            *halves(state, chart),
            (modes[0], modes[1]),
        )
    )
    q = row[Q]
    q_dot = row[Q_DOT]
    reading = []
    if resolution is not None:
        before = state[loop.size + 2 * loop.measurement.delay :]
        q = nearest_equivalent_angle(robot, q, before) if chart.wraps else q
        q = casadi.floor(q / resolution + 0.5) * resolution
        q_dot = (q - before) / (loop.grid.block * loop.grid.step)
        reading = [q]
    law = replace(loop.law, kp=0.0, kd=0.0)
    object.__setattr__(law, "kp", gains[:2])  # symbols, which the controller's checks refuse
    object.__setattr__(law, "kd", gains[2:])
    commanded = law.law(
        q,
        q_dot,
        target[:2],
        target[2:4],
        target[4:],
    )
    pending = state[loop.size : loop.size + 2 * loop.measurement.delay]
    queue = casadi.vertcat(pending, commanded)
    applied = queue[:2]
    if loop.torque_limit is not None:
        applied = casadi.fmin(casadi.fmax(applied, -loop.torque_limit), loop.torque_limit)
    memory = casadi.vertcat(queue[2:], *reading)
    sample = casadi.vertcat(q, q_dot, commanded, applied)
    return casadi.Function("sample", inputs, casadi.cse([applied, memory, sample]))
