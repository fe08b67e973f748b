"""Closed loops as one compiled function: the plant, a built-in controller and the hold between
samples.
"""

from __future__ import annotations

import copy
from functools import lru_cache
from typing import Any, NamedTuple

import casadi
import numpy as np

from ..base.backend import numpy_on_symbols
from ..control.laws import PD, ComputedTorque, motion_at
from ..models.charts import BarAngles, StateChart, halves
from ..models.compiled import Buffered, compiled
from ..models.loaded_robot import JointTorques
from ..models.parameters import column_names, count_of, names_of, parameters_of, with_parameters
from ..models.robots import Robot, nearest_equivalent_angle
from .fixed_plant import refuse_losses
from .run import Control, Run
from .settings import Measurement
from .simulate import Grid, run_of
from .steps import COLUMNS, Q_DOT, Q, at_time, observation, runge_kutta_step

INLINE = 10  # steps in a control period that are written out: beyond, a loop is as fast
GAINS = "kp1", "kp2", "kd1", "kd2"


class LoopModel(NamedTuple):
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
    torques: JointTorques | None = None

    @property
    def size(self) -> int:
        """Numbers in a state of the plant."""
        return 2 * self.chart.size

    @property
    def memory(self) -> int:
        """Numbers that go with the state: torques on their way, the last reading of encoders."""
        return 2 * self.measurement.delay + 2 * (self.measurement.encoder_resolution is not None)

    @property
    def lengths(self) -> tuple[int, ...]:
        """How many numbers of a row are parameters, gains, state with its memory, and modes."""
        return count_of(self.kind, self.names), 4, self.size + self.memory, 2

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of a row's numbers."""
        states = (f"start{k + 1}" for k in range(self.size + self.memory))
        return *column_names(self.kind, self.names), *GAINS, *states, "mode1", "mode2"


class ClosedLoops:
    """Many closed loops of one model and reference: rows of parameters, gains, start and modes."""

    def __init__(self, loop: LoopModel, jit: bool | str, reference: Any, threads: int = 1) -> None:
        self.loop = loop
        self.jit = jit
        self.threads = threads
        grid = loop.grid
        self.t = np.arange(grid.steps + 1) * grid.step
        self.times = np.arange(loop.periods) * (grid.block * grid.step)
        target = loop.law.target(self.times, reference)
        q = target.rates.pose.q
        q_dot = target.rates.q_dot
        parts = q, q_dot, target.q_ddot, self.times[:, None]
        self.targets = np.hstack(parts)
        self.xi_ref = None if reference is None else motion_at(reference, self.t)[0]
        self.tool = getattr(reference, "tool", None)

    def __call__(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return observations (n, steps + 1, columns) and controllers' samples (n, periods, 8)."""
        count = len(rows)
        ends = np.cumsum(self.loop.lengths)[:-1]
        parameters, gains, states, modes = np.split(rows, ends, axis=1)
        inputs = states, np.tile(self.targets, (count, 1)), modes, parameters, gains
        if count == 1:
            inputs = tuple(each.squeeze() for each in inputs)
        observed, last, samples = _compiled(count, self.jit, self.loop, self.threads)(*inputs)
        observed = observed.reshape(count, -1, COLUMNS)
        whole = np.concatenate([observed, last.reshape(count, 1, COLUMNS)], axis=1)
        rows = self.loop.grid.steps + 1
        return whole[:, :rows], samples.reshape(count, -1, 8).copy()

    def robot(self, row: np.ndarray) -> Robot:
        """Return the robot of a row."""
        parameters = row[: self.loop.lengths[0]].tolist()
        return with_parameters(self.loop.kind, parameters, self.loop.names)

    def torques(self, samples: np.ndarray) -> np.ndarray:
        """Return the torques (..., steps, 2) that were held, by samples (..., periods, 8)."""
        grid = self.loop.grid
        held = np.repeat(samples[..., 6:], grid.block, axis=-2)
        return held[..., : grid.steps, :]

    def check(self, robot: Robot, observed: np.ndarray, torques: np.ndarray) -> None:
        """Raise ArithmeticError where a motion jumped."""
        loop = self.loop
        refuse_losses(robot, observed, torques, loop.chart, loop.grid.step, loop.torques)

    def run(self, robot: Robot, observed: np.ndarray, samples: np.ndarray, crosses: bool) -> Run:
        """Return the Run of one loop."""
        return run_of(
            robot,
            self.t,
            observed,
            self.torques(samples),
            joint_torques=self.loop.torques,
            crosses=crosses,
            xi_ref=self.xi_ref,
            tool=self.tool,
            torque_limit=self.loop.torque_limit,
            control=Control(self.times, *np.split(samples, 4, axis=1)),
        )


@lru_cache(maxsize=4)
def _compiled(count, jit, loop, threads):
    """Return `count` loops at once, with their memory, which costs as some steps."""
    function = compiled(_function(loop), jit)
    if count > 1 and threads > 1:
        return Buffered(function.map(count, "thread", threads))
    return Buffered(function.map(count) if count > 1 else function)


@lru_cache(maxsize=16)
def _function(loop):
    """Return (state, targets, modes, parameters, gains) -> observations, the last one, samples.

    The observations are those before each step; the samples what was measured, commanded, applied.
    """
    start, _, modes, p, gains = _symbols(loop, casadi.MX)
    targets = casadi.MX.sym("targets", 7, loop.periods)
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
        "target": 7,  # q, q', q'', t
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
    step = loop.grid.step
    state = casadi.SX.sym("state", loop.size)
    tau = casadi.SX.sym("tau", 2)
    t = casadi.SX.sym("t")
    _, _, modes, p, _ = _symbols(loop, casadi.SX)
    robot = with_parameters(loop.kind, p, loop.names)
    stepped, row = runge_kutta_step(
        robot,
        loop.chart,
        loop.method,
        step,
        state,
        tau,
        (modes[0], modes[1]),
        at_time(loop.torques, loop.chart, t, step),
    )
    observe = casadi.Function("observe", [state, modes, p], [row])
    advance = casadi.Function("advance", [state, tau, modes, p, t], [stepped, row])

    state, target, modes, p, gains = inputs = _symbols(loop, casadi.MX)
    applied, memory, sample = _sample(loop)(*inputs)
    held = (casadi.repmat(each, 1, block) for each in (applied, modes, p))
    began = target[6]
    times = began + step * casadi.DM(range(block)).T
    states, rows = advance.mapaccum(block)(state[: loop.size], *held, times)
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
    law, gains = one_law([controller])
    names = names_of([robot])
    grid = Grid(1, period, 1)
    exact = Measurement()
    loop = LoopModel(type(robot), names, law, BarAngles(), "dop8", grid, 1, None, exact)
    parameters = casadi.vertcat(*parameters_of(robot, names))
    target = casadi.vertcat(target, 0)
    sample = _sample(loop)
    applied, _, _ = sample(state, target, [0, 0], parameters, gains[0])
    return applied


def _sample(loop):
    """Return the controller: (state, ...) -> applied torques, memory after it, its sample (8)."""
    state, target, modes, p, gains = inputs = _symbols(loop, casadi.SX)
    chart = loop.chart
    resolution = loop.measurement.encoder_resolution
    robot = with_parameters(loop.kind, p, loop.names)
    row = observation(chart.rates(robot, *halves(state, chart), (modes[0], modes[1])))
    q = row[Q]
    q_dot = row[Q_DOT]
    reading = []
    if resolution is not None:
        before = state[loop.size + 2 * loop.measurement.delay :]
        q = nearest_equivalent_angle(robot, q, before) if chart.wraps else q
        q = casadi.floor(q / resolution + 0.5) * resolution
        q_dot = (q - before) / (loop.grid.block * loop.grid.step)
        reading = [q]
    law = copy.copy(loop.law)
    object.__setattr__(law, "kp", gains[:2])  # symbols, which the controller's checks refuse
    object.__setattr__(law, "kd", gains[2:])
    q_ref, q_ref_dot, q_ref_ddot, _ = casadi.vertsplit(target, [0, 2, 4, 6, 7])
    commanded = _commanded(law, q, q_dot, q_ref, q_ref_dot, q_ref_ddot)
    pending = state[loop.size : loop.size + 2 * loop.measurement.delay]
    queue = casadi.vertcat(pending, commanded)
    applied = queue[:2]
    if loop.torque_limit is not None:
        applied = casadi.fmin(casadi.fmax(applied, -loop.torque_limit), loop.torque_limit)
    memory = casadi.vertcat(queue[2:], *reading)
    sample = casadi.vertcat(q, q_dot, commanded, applied)
    return casadi.Function("sample", inputs, casadi.cse([applied, memory, sample]))


def _commanded(law, *arguments):
    """Return the torques of a law at symbols; ValueError where it is no function of these."""
    name = f"{type(law).__name__}.law"
    try:
        with numpy_on_symbols():
            value = law.law(*arguments)
        if isinstance(value, (tuple, list, np.ndarray)):
            value = casadi.vertcat(*value)
    except Exception as error:  # Whatever a law of numbers raises when it is given symbols.
        raise ValueError(
            f"{name} fails where it is compiled: {error}. Write it with arithmetic and CasADi's"
            " functions, as casadi.if_else in place of if"
        ) from error
    if value.numel() != 2:
        raise ValueError(f"{name} must return two torques, not {value.numel()}")
    return value


def one_law(controllers: list) -> tuple[PD | ComputedTorque, np.ndarray]:
    """Return the first controller, for all but the gains, and the gains (n, 4) of all."""
    first = controllers[0]
    gains = np.empty((len(controllers), 4))
    for k, controller in enumerate(controllers):
        if not _differ_in_gains_alone(controller, first):
            raise ValueError(
                f"controllers of one loop differ in their gains alone: number {k} differs from"
                " number 0"
            )
        gains[k, :2] = controller.kp
        gains[k, 2:] = controller.kd
    return first, gains


def _differ_in_gains_alone(controller, first):
    if type(controller) is not type(first):
        return False
    known = vars(first)
    if vars(controller).keys() != known.keys():
        return False
    others = known.keys() - {"kp", "kd"}
    own = vars(controller)
    return all(np.all(own[name] == known[name]) for name in others)


def a_built_in_controller(value: object, name: str) -> PD | ComputedTorque:
    """Rule: a controller that a compiled loop can hold; one of a class that overrides its law."""
    if not isinstance(value, (PD, ComputedTorque)):
        raise ValueError(
            f"a compiled loop needs a PD or ComputedTorque controller, not {type(value).__name__};"
            " a law of your own is a class made from one of these that overrides law()"
        )
    if type(value).__call__ is not PD.__call__:
        raise ValueError(
            f"a compiled loop calls law() of its controller: {type(value).__name__} overrides"
            " __call__, which would not be called"
        )
    return value
