"""Simulation: a sampled controller on the plant."""

import math

import numpy as np

from ._backend import sign
from .charts import CHARTS, MARGIN_NAMES
from .errors import SingularityError, UnreachableError
from .geometry import dgm, igm
from .kinematics import dkm, ikm
from .plant import ENERGY, MARGIN_RATES, MARGINS, Q_DOT, XI, Plant, Q
from .run import Control, Event, Run
from .singularity import Singularity

BLOCK = 50  # steps in one call where no controller asks for fewer


def simulate(
    robot, controller=None, reference=None, *, duration=None, start=None, control_period=0.01, step=0.001,
    torque_limit=None, delay=0, encoder_resolution=None, chart="auto",
):  # fmt: skip
    """Simulate the robot under a sampled controller with zero-order hold; gives a Run.

    controller: (t, q, q_dot, reference) -> tau (2,) N m, called every control_period s; None: no torque.
    reference: a trajectory, handed to the controller and kept in the Run; duration: s, default the reference's.
    start: Rates, default at rest or in motion with the reference in working modes (-1, -1), or at rest at q = (0, 0).
    step: s, of RK4; control_period a multiple of it. torque_limit: N m, saturates either torque.
    delay: samples between a measurement and the torque computed from it (0 until then).
    encoder_resolution: rad; the controller then gets rounded angles and their differences as velocities.
    chart: "auto" moves between joint and leg coordinates and passes through singularities; "joint" and "task" stay in
    theirs and raise SingularityError at its singularity. Raises SingularityError too where no chart is regular
    (both legs in line with parallel distal bars), ArithmeticError where the motion or the torque is not finite.
    """
    step, sampling = _positive(step, "step"), _positive(control_period, "control_period")
    if chart not in CHARTS:
        raise ValueError(f"chart must be one of {', '.join(CHARTS)}, not {chart!r}")
    if controller is not None and abs(sampling / step - round(sampling / step)) > 1e-6 * sampling / step:
        raise ValueError(f"control_period = {sampling:g} s must be a multiple of step = {step:g} s")
    if not (isinstance(delay, int) and delay >= 0):
        raise ValueError(f"delay must be a whole number of samples >= 0, not {delay!r}")
    for name, value in (("torque_limit", torque_limit), ("encoder_resolution", encoder_resolution)):
        if value is not None:
            _positive(value, name)
    if duration is None:
        if reference is None:
            raise ValueError("simulate needs a duration, or a reference that has one")
        duration = reference.start + reference.duration
    steps = math.ceil(_positive(duration, "duration") / step - 1e-6)
    block = BLOCK if controller is None else round(sampling / step)
    plant = Plant(robot, CHARTS[chart], step, block, _start(robot, reference) if start is None else start)
    loop = _Loop(controller, reference, torque_limit, delay, encoder_resolution, block * step)
    try:
        for k in range(0, steps, block):
            plant.advance(k, min(block, steps - k), loop.torque(k * step, plant.observation))
    finally:
        # Where a step has jumped, that is the cause of whatever came after it.
        plant.refuse_jumps()
    return _run(robot, reference, plant, loop, step, torque_limit)


def _start(robot, reference):
    if reference is None:
        return dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
    xi, xi_dot, _ = reference(0.0)
    return ikm(igm(robot, xi), xi_dot)


class _Loop:
    """The controller's side: what it measures, when its torque arrives, and how much of it."""

    def __init__(self, controller, reference, torque_limit, delay, encoder_resolution, period):
        self.controller, self.reference, self.limit = controller, reference, torque_limit
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
            raise ValueError(f"the controller must return two torques, not an array of shape {commanded.shape}")
        if not np.isfinite(commanded).all():
            raise ArithmeticError(f"the controller's torque is {commanded.tolist()} N m at t = {t:g} s")
        self.pending.append(commanded)
        applied = self.pending.pop(0)
        if self.limit is not None:
            applied = np.clip(applied, -self.limit, self.limit)
        self.log.append((t, q, q_dot, commanded, applied))
        return applied


def _run(robot, reference, plant, loop, step, torque_limit):
    rows, torques = plant.all_rows(), np.array(plant.torques)
    t = np.arange(len(rows)) * step
    control = None
    if loop.log:
        control = Control(*(np.array(column) for column in zip(*loop.log)))
    return Run(
        robot=robot, t=t, q=np.unwrap(rows[:, Q], axis=0), q_dot=rows[:, Q_DOT], xi=rows[:, XI], energy=rows[:, ENERGY],
        tau=np.vstack([torques, torques[-1]]), xi_ref=None if reference is None else reference(t)[0],
        torque_limit=torque_limit, control=control, events=_events(t, rows),
    )  # fmt: skip


def _events(t, rows):
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
            events.append(Event(float(when), kind, MARGIN_NAMES[column], before, after))
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
