"""Whole closed loops as one compiled function: plant, built-in controller and zero-order hold, over
many runs.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import lru_cache

import casadi
import numpy as np

from ..base.checks import a_callable, bounded, one_of, optional, positive, shown, takes, whole
from ..base.checks import jit as must_be_jit
from ..base.checks import robot as must_be_robot
from ..base.progress import progress
from ..control.laws import PD, ComputedTorque
from ..models.charts import CHARTS, Task, halves
from ..models.compiled import Buffered, compiled
from ..models.kinematics import Rates, some_rates
from ..models.parameters import count_of, names_of, parameters_of, with_parameters
from ..models.robots import Robot, nearest_equivalent_angle
from .events import meets
from .plant import check_start, refuse_losses, refuse_sticking
from .run import Control, Run
from .simulate import MOST_DELAY, Grid, assemble, begin_of
from .steps import COLUMNS, MARGIN_RATES, MARGINS, METHODS, Q_DOT, Q, observation, runge_kutta_step

MOST_ROWS, BYTES = 3 * 10**7, 180  # of all runs; what one takes
MOST_BLOCK, BLOCK_BYTES = (
    10**5,
    1200,
)  # steps in a control period; what one takes while a call lasts
AT_ONCE = 4 * 10**6  # rows in one call
TOGETHER = 128  # runs in one call: more would only take memory
INLINE = 10  # steps in a control period that are written out: beyond, a loop is as fast
GAINS = 4  # kp and kd of both joints


@takes(
    reference=optional(a_callable),
    duration=optional(positive),
    control_period=positive,
    step=positive,
    torque_limit=optional(positive),
    delay=whole(0, MOST_DELAY),
    encoder_resolution=optional(positive),
    chart=one_of(*CHARTS),
    method=one_of(*METHODS),
    jit=must_be_jit,
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
    delay: int = 0,
    encoder_resolution: float | None = None,
    chart: str = "auto",
    method: str = "rk4",
    jit: bool | str = False,
) -> list[Run]:
    """Simulate many closed loops by one compiled function, on all cores; gives a list of Run.

    robot: of all runs, or one for each: lengths and inertias are parameters of the function.
    controller: PD or ComputedTorque, or one for each run that differ in their gains alone.
    starts: Rates of a batch (n,), or one Rates for each run; None: each robot as the reference
    starts, in the controller's working modes.
    chart, method: fixed steps of length `step` in a chart, as in `simulate`: "auto" passes every
    singularity. The other options as in `simulate`, whose Runs with the same chart and method these
    equal within rounding. Raises as `simulate` does, for the first run that does not go through,
    and names it; ValueError names the robots that do not reach the start.
    """
    robots, controllers, begin = _runs_of(robot, controller, starts)
    law, gains = _one_law(controllers)
    grid, chart = Grid.of(duration, reference, step, control_period), CHARTS[chart]
    what = f"{len(robots)} runs of {grid.steps} steps are {len(robots) * grid.steps:.3g} rows"
    bounded(len(robots) * grid.steps, MOST_ROWS, what, BYTES)
    bounded(
        grid.block,
        MOST_BLOCK,
        f"control_period = {control_period:g} s is {grid.block:.3g} steps",
        BLOCK_BYTES,
    )
    periods, named = -(-grid.steps // grid.block), (type(robots[0]), names_of(robots))
    delay = min(delay, periods)
    parameters = np.array([parameters_of(each, named[1]) for each in robots])
    states, modes = (
        _at_reference(named, parameters, law, reference, chart)
        if begin is None
        else _at(begin, chart)
    )
    times = np.arange(periods) * (grid.block * grid.step)
    target = law.target(times, reference)
    targets = np.hstack([target.rates.pose.q, target.rates.q_dot, target.q_ddot])
    more = [np.zeros((len(states), 2 * delay))]
    if (
        encoder_resolution is not None
    ):  # the reading before the first, so that their difference gives the start's rate
        rates = _starts_rates(named, parameters, chart, states, modes)
        before = np.round(rates[:, :2] / encoder_resolution) * encoder_resolution
        more.append(before - grid.block * grid.step * rates[:, 2:])
    states = np.hstack([states, *more])
    options = (
        named,
        law,
        chart,
        method,
        grid.step,
        grid.block,
        periods,
        torque_limit,
        delay,
        encoder_resolution,
    )
    t = np.arange(grid.steps + 1) * grid.step
    shared = t, None if reference is None else reference(t)[0], grid, chart, torque_limit
    runs = []
    together = max(1, min(TOGETHER, AT_ONCE // grid.steps))
    for first in progress(range(0, len(states), together), unit=f" x {together} runs", delay=1):
        part = slice(first, first + together)
        count = len(states[part])
        inputs = (
            states[part],
            np.tile(targets, (count, 1)),
            modes[part],
            parameters[part],
            gains[part],
        )
        outputs = _call(count, jit, *options)(
            *(each.squeeze() if count == 1 else each for each in inputs)
        )
        rows, last, torques = (
            part.reshape(count, -1, columns)
            for part, columns in zip(outputs, (COLUMNS, COLUMNS, 8))
        )
        rows = np.concatenate([rows, last], axis=1)[:, : grid.steps + 1]
        runs += _runs(robots[part], rows, torques, shared, first)
    return runs


def _runs_of(robot, controller, starts):
    """Robots and controllers (n,) and, where given, starts: Rates of a batch, or (n,)."""
    given = {"robots": robot, "controllers": controller, "starts": starts}
    if not (starts is None or isinstance(starts, (Rates, Sequence))) or isinstance(starts, str):
        raise TypeError(
            f"starts must be the Rates of a batch, or one Rates for each run, not {shown(starts)}"
        )
    lengths = {name: len(each) for name, each in given.items() if isinstance(each, Sequence)}
    if isinstance(starts, Rates):
        if starts.q_dot.ndim != 2:
            raise ValueError(
                f"starts must be the Rates of a batch (n,): q_dot (n, 2), not {starts.q_dot.shape}"
            )
        lengths["starts"] = len(starts.q_dot)
    if not lengths:
        raise ValueError("simulate_many needs several robots, controllers or starts")
    count = max(lengths.values())
    if any(n != count for n in lengths.values()) or not count:
        raise ValueError(
            f"one for each run: {', '.join(f'{n} {name}' for name, n in lengths.items())} do not go"
            " together"
        )
    robots = list(robot) if isinstance(robot, Sequence) else [robot] * count
    for each in robots:
        must_be_robot(each, "robot")
    controllers = list(controller) if isinstance(controller, Sequence) else [controller] * count
    for k, each in enumerate(robots):
        if type(each) is not type(robots[0]):
            raise ValueError(
                f"robots of one kind go together: number {k} is a {type(each).__name__}"
            )
        refuse_sticking(each)
    for each in controllers:
        if not isinstance(each, (PD, ComputedTorque)):
            raise ValueError(
                "a compiled loop needs a PD or ComputedTorque controller, not"
                f" {type(each).__name__}"
            )
    if isinstance(starts, Rates) and any(each != starts.pose.robot for each in robots):
        raise ValueError(
            "starts is a batch of one robot's Rates: for several robots give a list, or None"
        )
    if isinstance(starts, Sequence):
        for each, start in zip(robots, starts):
            check_start(each, some_rates(start, "starts"))
    return robots, controllers, starts


def _one_law(controllers):
    """The controller whose gains are symbols, and the gains (n, 4)."""
    first = controllers[0]
    same = [f.name for f in fields(first) if f.name not in ("kp", "kd")]
    for k, each in enumerate(controllers):
        if type(each) is not type(first) or any(
            getattr(each, name) != getattr(first, name) for name in same
        ):
            raise ValueError(
                f"controllers of one loop differ in their gains alone: number {k} differs from"
                " number 0"
            )
    gains = [
        np.concatenate([np.broadcast_to(each.kp, 2), np.broadcast_to(each.kd, 2)])
        for each in controllers
    ]
    return first, np.array(gains)


def _at(starts, chart):
    """States (n, columns) and modes (n, 2) of given starts."""
    if isinstance(starts, Rates):
        c, c_dot, modes = chart.coordinates(starts)
        modes = np.stack([np.broadcast_to(mode, len(starts.q_dot)) for mode in modes], axis=-1)
        return np.stack(np.broadcast_arrays(*c, *c_dot), axis=-1), modes.astype(float)
    found = [chart.coordinates(start) for start in starts]
    return np.array([[*c, *c_dot] for c, c_dot, _ in found]), np.array(
        [modes for *_, modes in found], dtype=float
    )


def _at_reference(named, parameters, law, reference, chart):
    """States and modes in which each robot is at the reference's start."""
    if reference is None:
        raise ValueError("simulate_many needs starts, or a reference that says where all begin")
    xi, xi_dot, _ = begin_of(reference)
    at, p = casadi.SX.sym("at", 4), casadi.SX.sym("parameters", parameters.shape[1])
    rates = Task().rates(
        with_parameters(named[0], p, named[1]), (at[0], at[1]), (at[2], at[3]), law.working
    )
    c, c_dot, modes = chart.coordinates(rates)
    call = casadi.Function("begin", [at, p], [casadi.vertcat(*c, *c_dot), casadi.vertcat(*modes)])
    states, modes = call(np.concatenate([xi, xi_dot]), parameters.T)
    states, modes = states.full().T, np.broadcast_to(modes.full().T, (len(parameters), 2))
    bad = np.flatnonzero(~np.isfinite(states).all(axis=1))
    if len(bad):
        raise ValueError(
            f"{len(bad)} of {len(states)} robots do not reach the reference's start ({xi[0]:.9g},"
            f" {xi[1]:.9g}) m: number {', '.join(map(str, bad[:5]))}{' ...' * (len(bad) > 5)}"
        )
    return states, modes


def _starts_rates(named, parameters, chart, states, modes):
    """q, q' (n, 4) of states in a chart."""
    state, mode, p = (
        casadi.SX.sym(n, k)
        for n, k in (("s", 2 * chart.size), ("m", 2), ("p", parameters.shape[1]))
    )
    rates = chart.rates(
        with_parameters(named[0], p, named[1]), *halves(state, chart), (mode[0], mode[1])
    )
    return (
        casadi.Function("look", [state, mode, p], [observation(rates)[:4]])(
            states.T, modes.T, parameters.T
        )
        .full()
        .T
    )


def _runs(robots, rows, torques, shared, first):
    t, xi_ref, grid, chart, torque_limit = shared
    held = np.repeat(torques[:, :, 6:], grid.block, axis=1)[:, : grid.steps]
    met = meets(rows[:, :, MARGINS], (t[1] - t[0]) * rows[:, :, MARGIN_RATES])
    control = np.arange(torques.shape[1]) * (grid.block * grid.step)
    runs = []
    for k, robot in enumerate(robots):
        try:
            refuse_losses(robot, rows[k], held[k], chart, grid.step)
        except ArithmeticError as error:
            error.args = (f"run {first + k}: {error}",)
            raise
        log = Control(
            control, torques[k, :, :2], torques[k, :, 2:4], torques[k, :, 4:6], torques[k, :, 6:]
        )
        runs.append(
            assemble(robot, t, rows[k], held[k], xi_ref, log, torque_limit, crosses=bool(met[k]))
        )
    return runs


@lru_cache(maxsize=4)
def _call(count, jit, *options):
    """`count` loops at once, on all cores, with their memory, which costs as much as some steps."""
    function = compiled(_loop(*options), jit)
    return Buffered(function.map(count, "thread", os.cpu_count()) if count > 1 else function)


@lru_cache(maxsize=16)
def _loop(named, law, chart, method, step, block, periods, torque_limit, delay, resolution):
    """(state, targets (6, periods), modes, parameters, gains) -> (observations at each step, after
    the last, what was measured, commanded and applied).
    """
    n, size = count_of(*named), 2 * chart.size
    whole = (
        size + 2 * delay + (0 if resolution is None else 2)
    )  # the state, torques on their way, the last reading

    def symbols(one):
        lengths = {"state": whole, "target": 6, "modes": 2, "parameters": n, "gains": GAINS}
        return [one.sym(name, length) for name, length in lengths.items()]

    state, target, modes, p, gains = names = symbols(casadi.SX)
    robot = with_parameters(named[0], p, named[1])

    seen = observation(chart.rates(robot, *halves(state, chart), (modes[0], modes[1])))
    q, q_dot = seen[Q], seen[Q_DOT]
    after = []
    if resolution is not None:
        q = nearest_equivalent_angle(robot, q, state[whole - 2 :]) if chart.wraps else q
        q = casadi.floor(q / resolution + 0.5) * resolution
        q_dot, after = (q - state[whole - 2 :]) / (block * step), [q]
    own = replace(law, kp=0.0, kd=0.0)
    object.__setattr__(own, "kp", gains[:2])
    object.__setattr__(own, "kd", gains[2:])
    commanded = own.law(q, q_dot, target[:2], target[2:4], target[4:])
    queue = casadi.vertcat(state[size : size + 2 * delay], commanded)
    applied = queue[:2]
    if torque_limit is not None:
        applied = casadi.fmin(casadi.fmax(applied, -torque_limit), torque_limit)
    log = casadi.vertcat(q, q_dot, commanded, applied)
    sample = casadi.Function(
        "sample", names, casadi.cse([applied, casadi.vertcat(queue[2:], *after), log])
    )

    one, tau = casadi.SX.sym("state", size), casadi.SX.sym("tau", 2)
    stepped, looked = runge_kutta_step(robot, chart, method, step, one, tau, (modes[0], modes[1]))
    look = casadi.Function("look", [one, modes, p], [looked])
    advance = casadi.Function("advance", [one, tau, modes, p], [stepped, looked])

    state, target, modes, p, gains = names = symbols(casadi.MX)
    applied, rest, log = sample(*names)
    held = (casadi.repmat(each, 1, block) for each in (applied, modes, p))
    states, rows = advance.mapaccum(block)(state[:size], *held)
    period = casadi.Function("period", names, [casadi.vertcat(states[:, -1], rest), rows, log])
    if block <= INLINE:
        # One flat list of instructions, in which the sample shares the first stage's.
        flat = symbols(casadi.SX)
        period = casadi.Function("period", flat, casadi.cse(period.expand()(*flat)))

    start, _, modes, p, gains = symbols(casadi.MX)
    targets = casadi.MX.sym("targets", 6, periods)
    held = (casadi.repmat(each, 1, periods) for each in (modes, p, gains))
    states, rows, log = period.mapaccum(periods)(start, targets, *held)
    return casadi.Function(
        "loop", [start, targets, modes, p, gains], [rows, look(states[:size, -1], modes, p), log]
    )
