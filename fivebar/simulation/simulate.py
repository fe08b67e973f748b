"""Simulation: a sampled controller on the plant."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson

from ..base.checks import a_callable, bounded, instance, optional, positive, returned_pair
from ..base.errors import SingularityError, UnreachableError, warn
from ..base.progress import progress
from ..base.robot_uses import takes_robot
from ..control.laws import motion_at, warn_of_assembly, why_unstable
from ..models.charts import CHARTS
from ..models.geometry import dgm, igm
from ..models.kinematics import Rates, dkm, ikm, some_rates
from ..models.loaded_robot import JointTorques, LoadedRobot, robot_and_torques
from ..models.loads import lost_power
from ..models.motors import torque_bounds
from ..models.robots import Robot
from .events import crossings
from .fixed_plant import FixedPlant, lost_in_steps
from .plant import Plant
from .run import Control, Run, has_friction, torque_limits
from .settings import Integrator, Measurement
from .steps import ENERGY, MARGIN_RATES, MARGINS, Q_DOT, XI, Q, motion_of
from .stick_slip import plant_of

TOLERANCE = 1e-12  # rad, of a step where no tolerance is asked for
COARSER = 10  # the errors of steps add up: each may be a tenth of the tolerance
FINER = 1e5  # of the steps of the second run, against which the error of the first is seen
FINEST = 1e-14  # rad, of a step
MOST_ROWS = 10**7  # of a run
ROW_BYTES = 400  # memory of a row while the run is made


@takes_robot(
    LoadedRobot,
    controller=optional(a_callable),
    reference=optional(a_callable),
    start=optional(some_rates),
    duration=optional(positive),
    control_period=positive,
    step=positive,
    torque_limit=optional(torque_limits),
    measurement=optional(instance(Measurement)),
    integrator=optional(instance(Integrator)),
)
def simulate(
    robot: Robot | LoadedRobot,
    controller: Callable | None = None,
    reference: Callable | None = None,
    *,
    duration: float | None = None,
    start: Rates | None = None,
    control_period: float = 0.01,
    step: float = 0.001,
    torque_limit: Any = None,
    measurement: Measurement | None = None,
    integrator: Integrator | None = None,
) -> Run:
    """Simulate the robot under a sampled controller, whose torques are held from sample to sample.

    The direct dynamic model q'' = M^-1 (tau - c) is integrated on the angles of the four bars,
    which pass every singularity. Dry friction (fs1, fs2) sticks and slips exactly: steps end where
    that changes.

    Parameters
    ----------
    robot : FiveBar, Biglide or LoadedRobot
        It may have more physics than the robot that the controller knows; a LoadedRobot has a
        drive, friction or a disturbance of your own.
    controller : callable, optional
        (t, q (2,), q_dot (2,), reference) -> tau (2,), N m; called every control_period. None: no
        torque.
    reference : callable, optional
        t -> (xi, xi_dot, xi_ddot), each (2,), as `line` or `plan` give it. The controller gets it,
        and the Run its positions, and its tool where it leads one.
    duration : float, optional
        s, from t = 0 on. None: until the reference ends.
    start : Rates, optional
        None: as the reference starts, in the working modes of the plan or the controller, else
        (-1, -1). Without a reference: at rest at q = (0, 0).
    control_period : float
        s, a multiple of step.
    step : float
        s, from row to row of the Run. The last row is the first at or after the duration.
    torque_limit : float, or motors as of `Constraints`, optional
        N m, the size at which either torque saturates. Of motors it is that of the joint's speed at
        each row, held until the next: smaller steps follow the motors' lines more closely.
    measurement : Measurement, optional
        Delay and encoders. None: exact measurements without delay.
    integrator : Integrator, optional
        Method, chart and tolerance. None: steps as long as their error allows, on the four bars.

    Returns
    -------
    Run
        The motion, torques and crossings of singularities.

    Raises
    ------
    ValueError
        Where the arguments do not go together.
    ArithmeticError
        Where a torque is not finite, or the motion becomes too fast. It does where all four bars
        are parallel.
    RuntimeWarning
        Where the gains of a controller of this package are unstable with the control period, or it
        counts on another delay, and the robot crosses singularities; where it reads the joints in
        another assembly mode than the start's.
    SingularityError
        Where a chart of `Integrator` ends.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> reference = fb.line((0.09, 0.068), (0.0, 0.1), duration=2.0)
    >>> run = fb.simulate(robot, fb.ComputedTorque(robot, kp=100, kd=20), reference)
    >>> len(run.t), bool(abs(run.error).max() < 1e-4)
    (2001, True)
    """
    measurement = measurement or Measurement()
    integrator = integrator or Integrator()
    grid = Grid.of(duration, reference, step, control_period if controller is not None else None)
    robot, torques = robot_and_torques(robot)
    refuse_other_kind(robot, controller)
    start = start_with(robot, reference, controller) if start is None else start
    warn_of_assembly(controller, start.pose)

    def unstable() -> str:
        period = grid.block * grid.step
        return why_unstable(controller, start.pose, period, measurement.delay)

    def run(tolerance: float) -> Run:
        plant: Plant | FixedPlant
        if integrator.fixed:
            chart = CHARTS[integrator.chart]
            method = integrator.method or "rk4"
            options = chart, method, grid.step, integrator.jit, torques
            plant = FixedPlant(robot, start, *options)
        else:
            plant = plant_of(robot, start, tolerance, integrator.jit, torques)
        period = grid.block * grid.step
        loop = _Loop(robot.words, controller, reference, torque_limit, measurement, period)
        try:
            return _closed_loop(plant, grid, loop)
        except ArithmeticError as error:
            if type(error) is ArithmeticError and (why := unstable()):
                error.args = (f"{why}; {error}",)
            raise

    if integrator.tolerance is None:
        found = run(TOLERANCE)
    else:
        coarse = run(integrator.tolerance / COARSER)
        finest = max(integrator.tolerance / FINER, FINEST)
        fine = run(finest)
        difference = np.abs(fine.q - coarse.q)
        # Where both take the controller's periods as their steps, they are one motion.
        found = replace(fine, step_error=max(float(difference.max()), finest))
    if found.events and (why := unstable()):
        words = f"the robot crosses {len(found.events)} singularities: {why}"
        warn(words, RuntimeWarning)
    return found


def _closed_loop(plant: Plant | FixedPlant, grid: Grid, loop: _Loop) -> Run:
    t = np.arange(grid.steps + 1) * grid.step
    reference = loop.reference
    xi_ref = None if reference is None else motion_at(reference, t)[0]
    torques: list[np.ndarray] = []
    periods = range(0, grid.steps, grid.block)
    try:
        for k in progress(periods, desc="simulate", unit=" periods", delay=2, leave=False):
            torque = loop.torque(k * grid.step, *plant.joints)
            end = min(k + grid.block, grid.steps)
            # Back EMF limits a motor at all times, not only when the controller is called.
            stride = 1 if isinstance(loop.torque_limit, tuple) else end - k
            for first in range(k, end, stride):
                torques += stride * [loop.limited(torque, plant.joints[1])]
                plant.advance(float(t[first + stride]), torques[-1])
    except ArithmeticError:
        if isinstance(plant, FixedPlant):
            plant.rows(t)  # a step that jumped is the cause of all that came after it
        raise
    control = None
    if loop.samples:
        control = Control(*(np.array(column) for column in zip(*loop.samples)))
    return run_of(
        plant.robot,
        t,
        plant.rows(t),
        np.array(torques),
        plant=plant if isinstance(plant, Plant) else None,
        joint_torques=plant.torques,
        xi_ref=xi_ref,
        torque_limit=loop.torque_limit,
        control=control,
        log=getattr(loop.controller, "log", None),
        tool=getattr(reference, "tool", None),
    )


def run_of(
    robot: Robot,
    t: np.ndarray,
    rows: np.ndarray,
    torques: np.ndarray,
    *,
    plant: Plant | None = None,
    joint_torques: JointTorques | None = None,
    crosses: bool = True,
    **fields: Any,
) -> Run:
    """Return the Run of observations (n + 1, columns), between which torques (n, 2) were held.

    plant: what moved, if it knows its motion between the rows. joint_torques: of a LoadedRobot.
    crosses: whether the motion may have crossed a singularity, where there is no plant. fields:
    further ones of the Run.
    """
    tau = np.vstack([torques, torques[-1]])
    events: tuple = ()
    if plant is not None:
        # Of its own steps, so that no crossing depends on how far apart the rows are.
        events = crossings(robot, *plant.ends, plant.margins)
    elif crosses:
        events = crossings(robot, t, rows[:, MARGINS], rows[:, MARGIN_RATES])
    friction_loss = None
    if joint_torques is not None or has_friction(robot):
        if plant is not None:
            friction_loss = plant.friction_loss(t)
        else:
            friction_loss = _friction_loss(robot, t, rows, torques, joint_torques)
    return Run(
        robot=robot,
        t=t,
        q=rows[:, Q] if plant is not None else robot.continuous(rows[:, Q]),
        q_dot=rows[:, Q_DOT],
        xi=rows[:, XI],
        energy=rows[:, ENERGY],
        tau=tau,
        events=events,
        friction_loss=friction_loss,
        **fields,
    )


def _friction_loss(robot, t, rows, tau, joint_torques):
    """Return what friction has taken until each row, (n,) J, by Simpson's rule."""
    power = lost_power(motion_of(robot, rows)) + np.zeros(len(t))
    lost = cumulative_simpson(power, x=t, initial=0.0)
    if joint_torques is not None:
        in_steps, _ = lost_in_steps(robot, joint_torques, rows, tau, t[1])
        lost[1:] += np.cumsum(in_steps)
    return lost


class Grid(NamedTuple):
    """steps: in all; step: s, of each; block: steps from one call of the controller to the next."""

    steps: int
    step: float
    block: int

    @classmethod
    def of(
        cls, duration: float | None, reference: Any, step: float, control_period: float | None
    ) -> Grid:
        """Check the arguments of `simulate`; control_period None: one block."""
        block = None
        if control_period is not None:
            ratio = control_period / step
            block = max(round(min(ratio, 1e18)), 1)
            if abs(ratio - block) > 1e-6 * ratio:
                raise ValueError(
                    f"control_period = {control_period:g} s must be a multiple of step = {step:g} s"
                )
        if duration is None:
            if not (hasattr(reference, "start") and hasattr(reference, "duration")):
                raise ValueError("simulate needs a duration, or a reference that has one")
            duration = reference.start + reference.duration
            if duration <= 0:
                raise ValueError(
                    f"the reference ends at t = {duration:g} s, and a run begins at 0: give it"
                    " times that end later"
                )
        count = positive(duration, "duration") / step
        what = f"duration = {duration:g} s is {count:.3g} steps of {step:g} s"
        bounded(count, MOST_ROWS, what, ROW_BYTES)
        steps = max(math.ceil(count - 1e-6), 1)
        block = min(block or steps, steps)
        return cls(steps, step, block)


def start_with(robot: Robot, reference: Any, controller: Any) -> Rates:
    """Return the Rates with which a simulation begins where none are given.

    Of a plan that is free of modes the pose is known; for another robot, by its joints.

    Raises
    ------
    ValueError
        Where a plan and a joint controller have different working modes.
    """
    if reference is None:
        return dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
    if hasattr(reference, "accelerations") and reference.working is None:
        rates = reference.accelerations(0.0).rates
        if reference.robot == robot:
            return rates
        return dkm(dgm(robot, rates.pose.q, int(rates.pose.assembly)), rates.q_dot)
    planned = getattr(reference, "working", None)
    controlled = getattr(controller, "working", None)
    if planned and controlled and tuple(planned) != tuple(controlled):
        raise ValueError(
            f"the plan has working modes {tuple(planned)}, its controller {tuple(controlled)}: give"
            " both the same"
        )
    xi, xi_dot, _ = motion_at(reference, 0.0)
    return ikm(igm(robot, xi, planned or controlled or (-1, -1)), xi_dot)


def refuse_other_kind(robot: Robot, controller: Any) -> None:
    """Refuse a controller that is made for another kind of robot."""
    own = getattr(controller, "robot", robot)
    words = getattr(own, "words", robot.words)
    if words != robot.words:
        raise ValueError(
            f"the controller is of a {words.title}, the robot is a {robot.words.title}"
        )


class _Loop:
    """The controller's side: what it measures, when its torque arrives, and how much of it.

    samples: (t, q, q_dot, commanded, applied) of each call.
    """

    def __init__(self, words, controller, reference, torque_limit, measurement, period):
        self.words = words
        self.controller = controller
        self.reference = reference
        self.torque_limit = torque_limit
        self.period = period
        self.resolution = measurement.encoder_resolution
        self.pending = [np.zeros(2)] * measurement.delay
        self.samples = []

    def torque(self, t, q, q_dot):
        """Return the torque that arrives for the period that begins at t, not yet limited."""
        if self.controller is None:
            return np.zeros(2)
        rates = q_dot
        if self.resolution is not None:
            q = np.round(q / self.resolution) * self.resolution
            if self.samples:
                q_dot = (q - self.samples[-1][1]) / self.period
        commanded = self._commanded(t, q, q_dot)
        self.pending.append(commanded)
        arriving = self.pending.pop(0)
        self.samples.append((t, q, q_dot, commanded, self.limited(arriving, rates)))
        return arriving

    def limited(self, torque, q_dot):
        """Return the torque that is applied at joint speeds (2,)."""
        if self.torque_limit is None:
            return torque
        return np.clip(torque, *torque_bounds(self.torque_limit, q_dot))

    def _commanded(self, t, q, q_dot):
        try:
            answer = self.controller(t, q, q_dot, self.reference)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"controller at t = {t:g} s: {error}",)
            raise
        commanded = returned_pair(answer, "the controller", f"{self.words.effort}s")
        if not np.isfinite(commanded).all():
            raise ArithmeticError(
                f"the controller's {self.words.effort} is {commanded.tolist()}"
                f" {self.words.effort_unit} at t = {t:g} s"
            )
        return commanded
