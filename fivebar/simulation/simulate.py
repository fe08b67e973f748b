"""Simulation: a sampled controller on the plant."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .._backend import sign
from ..errors import SingularityError, UnreachableError
from ..models.charts import CHARTS
from ..models.geometry import dgm, igm
from ..models.kinematics import dkm, ikm
from ..singularities.margins import Singularity
from .plant import Plant
from .run import Control, Event, Run
from .steps import ENERGY, MARGIN_RATES, MARGINS, METHODS, Q_DOT, XI, Q

HALVINGS = 10
MOST_STEPS = 10**7  # more than a GB of motion
ORDER = {"rk4": 4, "dop8": 8}
BLOCK = 50  # steps in one call where no controller asks for fewer


def simulate(
    robot, controller=None, reference=None, *, duration=None, start=None, control_period=0.01, step=0.001,
    torque_limit=None, delay=0, encoder_resolution=None, chart="auto", method="rk4", tolerance=None,
):  # fmt: skip
    """Simulate the robot under a sampled controller with zero-order hold; gives a Run.

    controller: (t, q, q_dot, reference) -> tau (2,) N m, called every control_period s; None: no torque. Of a biglide
    all that is in rad here is in m, and in N m, in N.
    reference: a trajectory, handed to the controller and kept in the Run; duration: s, default the reference's.
    start: Rates, default as the reference starts, in the working modes of a plan or of the controller, or (-1, -1), or
    at rest at q = (0, 0).
    step: s; control_period a multiple of it; the run ends with the first step at or after the duration.
    method: "rk4", or "dop8", Dormand and Prince's of order 8.
    tolerance: rad; halves the step until two runs say that no joint angle is farther off, which Run.step_error holds.
    torque_limit: N m, saturates either torque.
    delay: samples between a measurement and the torque computed from it (0 until then).
    encoder_resolution: rad; the controller then gets rounded angles and their differences as velocities.
    chart: "auto" moves between joint and leg coordinates and passes through singularities; "joint" and "task" stay in
    theirs and raise SingularityError at its singularity. Raises SingularityError too where no chart is regular
    (both legs in line with parallel distal bars), ArithmeticError where the motion or the torque is not finite.
    """
    if tolerance is not None:
        options = dict(duration=duration, start=start, control_period=control_period, torque_limit=torque_limit)
        options |= dict(delay=delay, encoder_resolution=encoder_resolution, chart=chart, method=method)
        return _refined(_positive(tolerance, "tolerance"), step, robot, controller, reference, **options)
    grid = Grid.of(duration, reference, step, control_period if controller is not None else None)
    check_options(chart=chart, method=method, delay=delay, torque_limit=torque_limit, resolution=encoder_resolution)
    start = start_with(robot, reference, controller) if start is None else start
    plant = Plant(robot, CHARTS[chart], method, grid.step, grid.block, start)
    period = grid.block * grid.step
    loop = _Loop(robot.words, controller, reference, torque_limit, delay, encoder_resolution, period)
    try:
        for k in range(0, grid.steps, grid.block):
            plant.advance(k, min(grid.block, grid.steps - k), loop.torque(k * grid.step, plant.observation))
    finally:
        # Where a step has jumped, that is the cause of whatever came after it.
        plant.refuse_jumps()
    control = Control(*(np.array(column) for column in zip(*loop.log))) if loop.log else None
    log = getattr(controller, "log", None)
    return assemble(robot, reference, grid.step, *plant.history(), control, torque_limit, log)


def _refined(tolerance, step, *loop, **options):
    """The run of the first halved step whose difference from the one before it is small enough."""
    coarse = simulate(*loop, step=step, **options)
    for _ in range(HALVINGS):
        step /= 2
        fine = simulate(*loop, step=step, **options)
        common = min(len(coarse.q), (len(fine.q) + 1) // 2)
        error = float(np.abs(fine.q[::2][:common] - coarse.q[:common]).max())
        error /= 2 ** ORDER[options["method"]] - 1  # of the finer run, as the method's order has it
        if error <= tolerance:
            return replace(fine, step_error=error)
        coarse = fine
    unit = coarse.robot.words.unit
    raise ArithmeticError(
        f"tolerance = {tolerance:g} {unit} is not reached by steps of {step:g} s: the error is {error:.2g} {unit}"
    )


class Grid(NamedTuple):
    """Steps in all, their length in s, and steps from one call of the controller to the next."""

    steps: int
    step: float
    block: int

    @classmethod
    def of(cls, duration, reference, step, control_period):
        """Checked; the default duration is the reference's, and without a controller blocks are as they please."""
        step = _positive(step, "step")
        block = BLOCK
        if control_period is not None:
            ratio = _positive(control_period, "control_period") / step
            block = round(ratio)
            if abs(ratio - block) > 1e-6 * ratio:
                raise ValueError(f"control_period = {control_period:g} s must be a multiple of step = {step:g} s")
        if duration is None:
            if reference is None:
                raise ValueError("simulate needs a duration, or a reference that has one")
            duration = reference.start + reference.duration
        count = _positive(duration, "duration") / step
        if count > MOST_STEPS:
            raise ValueError(f"duration = {duration:g} s is {count:.3g} steps of {step:g} s: at most {MOST_STEPS:g}")
        return cls(max(math.ceil(count - 1e-6), 1), step, block)


def check_options(chart, method, delay, torque_limit, resolution=None, charts=tuple(CHARTS)):
    """ValueError for an option that cannot be."""
    for name, value, known in (("chart", chart, charts), ("method", method, METHODS)):
        if value not in known:
            raise ValueError(f"{name} must be one of {', '.join(known)}, not {value!r}")
    if isinstance(delay, bool) or not (isinstance(delay, (int, np.integer)) and delay >= 0):
        raise ValueError(f"delay must be a whole number of samples >= 0, not {delay!r}")
    for name, value in (("torque_limit", torque_limit), ("encoder_resolution", resolution)):
        if value is not None:
            _positive(value, name)


def start_with(robot, reference, controller):
    """Rates of the reference's start in its working modes or the controller's; without a reference at rest at home.

    ValueError where both have working modes (a plan and a joint controller), and not the same.
    """
    if reference is None:
        return dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
    modes = [tuple(own.working) for own in (reference, controller) if getattr(own, "working", None) is not None]
    if len(set(modes)) > 1:
        raise ValueError(f"the plan has working modes {modes[0]}, its controller {modes[1]}: give both the same")
    xi, xi_dot, _ = reference(0.0)
    return ikm(igm(robot, xi, modes[0] if modes else (-1, -1)), xi_dot)


class _Loop:
    """The controller's side: what it measures, when its torque arrives, and how much of it."""

    def __init__(self, words, controller, reference, torque_limit, delay, encoder_resolution, period):
        self.words, self.controller, self.reference, self.limit = words, controller, reference, torque_limit
        self.resolution, self.period = encoder_resolution, period
        self.pending = [np.zeros(2)] * delay
        self.log = []

    def torque(self, t, observation):
        """Applied torque for the period that begins at t."""
        if self.controller is None:
            return np.zeros(2)
        q, q_dot = observation[Q], observation[Q_DOT]
        if self.resolution is not None:
            q = np.round(q / self.resolution) * self.resolution
            if self.log:
                q_dot = (q - self.log[-1][1]) / self.period
        else:
            q, q_dot = q.copy(), q_dot.copy()  # a controller must not reach the plant's own state
        try:
            commanded = np.array(self.controller(t, q, q_dot, self.reference), dtype=float)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"controller at t = {t:g} s: {error}",)
            raise
        if commanded.shape != (2,):
            raise ValueError(
                f"the controller must return two {self.words.effort}s, not an array of shape {commanded.shape}"
            )
        if not np.isfinite(commanded).all():
            raise ArithmeticError(
                f"the controller's {self.words.effort} is {commanded.tolist()} {self.words.effort_unit} at t = {t:g} s"
            )
        self.pending.append(commanded)
        applied = self.pending.pop(0)
        if self.limit is not None:
            applied = np.clip(applied, -self.limit, self.limit)
        self.log.append((t, q, q_dot, commanded, applied))
        return applied


def assemble(robot, reference, step, rows, torques, control, torque_limit, log=None):
    """The Run of observations (n + 1, columns) and the torques (n, 2) held between them."""
    t = np.arange(len(rows)) * step
    return Run(
        robot=robot, t=t, q=robot.continuous(rows[:, Q]), q_dot=rows[:, Q_DOT], xi=rows[:, XI], energy=rows[:, ENERGY],
        tau=np.vstack([torques, torques[-1]]), xi_ref=None if reference is None else reference(t)[0],
        torque_limit=torque_limit, control=control, events=_events(robot, t, rows), log=log,
    )  # fmt: skip


def _events(robot, t, rows):
    """Crossings of Type 1 and Type 2: the sines' changes of sign."""
    events = []
    modes = -sign(rows[:, MARGINS], 0.0)
    for k in np.flatnonzero((modes == 0).any(axis=1)):  # a step that ends on a singularity has not crossed it yet
        modes[k] = np.where(modes[k] == 0, modes[k - 1] if k else 0, modes[k])
    step = t[1] - t[0]
    for column, kind in enumerate((Singularity.SERIAL, Singularity.SERIAL, Singularity.PARALLEL)):
        for k in np.flatnonzero(modes[1:, column] * modes[:-1, column] < 0):
            sines, slopes = rows[k : k + 2, MARGINS][:, column], rows[k : k + 2, MARGIN_RATES][:, column]
            when = t[k] + step * _hermite_zero(*sines, *(step * slopes))
            before, after = (tuple(modes[k + i].tolist()) for i in (0, 1))
            events.append(Event(float(when), kind, robot.words.sines[column], before, after))
    return tuple(sorted(events, key=lambda event: event.t))


def _hermite_zero(y0, y1, d0, d1):
    """Where in [0, 1] the cubic with these end values (of opposite signs) and slopes is zero."""
    change = y1 - y0
    cubic = [d0 + d1 - 2 * change, 3 * change - 2 * d0 - d1, d0, y0]
    return min(np.clip(np.roots(cubic).real, 0, 1), key=lambda s: abs(np.polyval(cubic, s)))


def _positive(value, name):
    if not (np.ndim(value) == 0 and math.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be finite and > 0, not {value!r}")
    return float(value)
