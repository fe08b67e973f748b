"""Simulation: a sampled controller on the plant."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..base.checks import a_callable, bounded, one_of, optional, positive, shown, takes, whole
from ..base.checks import jit as must_be_jit
from ..base.checks import robot as must_be_robot
from ..base.errors import SingularityError, UnreachableError
from ..models.charts import CHARTS
from ..models.geometry import dgm, igm
from ..models.kinematics import Rates, dkm, ikm, some_rates
from ..models.robots import Robot
from .balance import friction_loss, loss_by_rows
from .events import crossings
from .plant import FixedPlant, Plant, margins_after
from .run import Control, Run, has_friction
from .steps import ENERGY, METHODS, Q_DOT, XI, Q
from .stick_slip import plant_of

TOLERANCE = 1e-12  # rad, of a step where nothing is asked
COARSER, FINER = (
    10,
    1e5,
)  # than the tolerance: the error of a step, as these add up; and of the run that tells how far
LEAST_TOLERANCE, FINEST = 1e-12, 1e-14  # rad: below, a step's error is rounding
MOST_DELAY = 10_000  # samples
MOST_ROWS, BYTES = 10**7, 400  # of a run; what a row takes while it is made


@takes(
    robot=must_be_robot,
    controller=optional(a_callable),
    reference=optional(a_callable),
    start=optional(some_rates),
    duration=optional(positive),
    control_period=positive,
    step=positive,
    torque_limit=optional(positive),
    delay=whole(0, MOST_DELAY),
    encoder_resolution=optional(positive),
    chart=one_of(*CHARTS),
    method=one_of(None, *METHODS),
    tolerance=optional(positive),
    jit=must_be_jit,
)
def simulate(
    robot: Robot,
    controller: Callable | None = None,
    reference: Callable | None = None,
    *,
    duration: float | None = None,
    start: Rates | None = None,
    control_period: float = 0.01,
    step: float = 0.001,
    torque_limit: float | None = None,
    delay: int = 0,
    encoder_resolution: float | None = None,
    chart: str = "auto",
    method: str | None = None,
    tolerance: float | None = None,
    jit: bool | str = False,
) -> Run:
    """Simulate the robot under a sampled controller with zero-order hold; gives a Run.

    controller: (t, q, q_dot, reference) -> tau (2,) N m, called every control_period s; None: no
        torque.
    reference: a trajectory, handed to the controller and kept in the Run; duration: s, default the
        reference's.
    start: Rates, default as the reference starts, in the working modes of a plan or of the
    controller, or (-1, -1), or at rest at q = (0, 0).
    step: s, from row to row of the Run; control_period a multiple of it; the last row is the first
    at or after the duration.
    torque_limit: N m, saturates either torque.
    delay: samples between a measurement and the torque computed from it (0 until then).
    encoder_resolution: rad; the controller then gets rounded angles and their differences as
        velocities.
    method: None, steps as long as their error allows, of order 8; or fixed ones of length `step`:
        "rk4" or "dop8".
    tolerance: rad. A step's error is kept below a tenth of it, and the motion computed once more,
    finer: that is what you get, with the largest difference of q between both as Run.step_error, a
    bound on its own error (of a chaotic motion it grows to any size). If not given, a step's error
    is kept below 1e-12.
    chart: "auto", the four bars, which pass every singularity; or "task" and "joint", by fixed
    steps: faster and regular away from Type 1 and Type 2, where they raise SingularityError.
    jit: True, "auto": machine code, as `compile`.
    The robot may have more physics than the controller's own. Dry friction (fs1, fs2) sticks and
    slips exactly, by
    steps that end where that changes: without method= and chart=.
    ArithmeticError where the motion or the torque is not finite, or too fast; four parallel bars
    are, for every robot.
    """
    if tolerance is not None:
        if tolerance < LEAST_TOLERANCE:
            raise ValueError(
                f"tolerance = {tolerance:g} is below rounding: at least {LEAST_TOLERANCE:g}"
            )
        if method is not None or chart != "auto":
            raise ValueError(
                'tolerance chooses the steps: it goes with method=None and chart="auto"'
            )
    grid = Grid.of(duration, reference, step, control_period if controller is not None else None)
    start = start_with(robot, reference, controller) if start is None else start

    def run(tolerance):
        if chart == "auto" and method is None:
            plant = plant_of(robot, start, tolerance, jit)
        else:
            plant = FixedPlant(robot, start, CHARTS[chart], method or "rk4", grid.step, jit)
        return _closed_loop(
            plant, grid, controller, reference, torque_limit, delay, encoder_resolution
        )

    if tolerance is None:
        return run(TOLERANCE)
    coarse, fine = run(tolerance / COARSER), run(max(tolerance / FINER, FINEST))
    return replace(fine, step_error=float(np.abs(fine.q - coarse.q).max()))


def _closed_loop(plant, grid, controller, reference, torque_limit, delay, encoder_resolution):
    period = grid.block * grid.step
    loop = _Loop(
        plant.robot.words, controller, reference, torque_limit, delay, encoder_resolution, period
    )
    t, torques = np.arange(grid.steps + 1) * grid.step, []
    try:
        for k in range(0, grid.steps, grid.block):
            torques.append(loop.torque(k * grid.step, *plant.joints))
            plant.advance(float(t[min(k + grid.block, grid.steps)]), torques[-1])
    except ArithmeticError:
        if isinstance(plant, FixedPlant):
            plant.rows(t)  # where a step has jumped, that is the cause of whatever came after it
        raise
    rows, states = plant.rows(t)
    tau = np.repeat(torques, grid.block, axis=0)[: grid.steps]
    control = Control(*(np.array(column) for column in zip(*loop.log))) if loop.log else None
    after = lost = None
    if isinstance(plant, Plant):
        after, lost = partial(margins_after, plant, states, tau), partial(friction_loss, plant, t)
    xi_ref, log = None if reference is None else reference(t)[0], getattr(controller, "log", None)
    return assemble(plant.robot, t, rows, tau, xi_ref, control, torque_limit, log, after, lost=lost)


class Grid(NamedTuple):
    """Steps in all, their length in s, and steps from one call of the controller to the next."""

    steps: int
    step: float
    block: int

    @classmethod
    def of(cls, duration, reference, step, control_period):
        """Checked; the default duration is the reference's, and without a controller all is one
        block.
        """
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
        count = positive(duration, "duration") / step
        bounded(
            count, MOST_ROWS, f"duration = {duration:g} s is {count:.3g} steps of {step:g} s", BYTES
        )
        steps = max(math.ceil(count - 1e-6), 1)
        return cls(steps, step, min(block or steps, steps))


def start_with(robot, reference, controller):
    """Rates of the reference's start in its working modes or the controller's; without a reference
    at rest at home.

    A plan that is free of modes begins in its own pose; of another robot, with its joints in its
    assembly mode.

    ValueError where both have working modes (a plan and a joint controller), and not the same.
    """
    if reference is None:
        return dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
    if hasattr(reference, "accelerations") and reference.working is None:
        rates = reference.accelerations(0.0).rates
        if reference.robot == robot:
            return rates
        return dkm(dgm(robot, rates.pose.q, int(rates.pose.assembly)), rates.q_dot)
    modes = [
        tuple(own.working)
        for own in (reference, controller)
        if getattr(own, "working", None) is not None
    ]
    if len(set(modes)) > 1:
        raise ValueError(
            f"the plan has working modes {modes[0]}, its controller {modes[1]}: give both the same"
        )
    xi, xi_dot, _ = begin_of(reference)
    return ikm(igm(robot, xi, modes[0] if modes else (-1, -1)), xi_dot)


def begin_of(reference):
    """(xi, xi_dot, xi_ddot) of a reference at t = 0, each (2,); ValueError where it gives something
    else.
    """
    answer = reference(0.0)
    if (
        not isinstance(answer, (tuple, list))
        or len(answer) != 3
        or any(np.shape(each) != (2,) for each in answer)
    ):
        raise ValueError(
            f"reference must give xi, xi_dot and xi_ddot, each (2,), at a time, not {shown(answer)}"
        )
    return answer


class _Loop:
    """The controller's side: what it measures, when its torque arrives, and how much of it."""

    def __init__(
        self, words, controller, reference, torque_limit, delay, encoder_resolution, period
    ):
        self.words, self.controller, self.reference, self.limit = (
            words,
            controller,
            reference,
            torque_limit,
        )
        self.resolution, self.period = encoder_resolution, period
        self.pending = [np.zeros(2)] * delay
        self.log = []

    def torque(self, t, q, q_dot):
        """Applied torque for the period that begins at t."""
        if self.controller is None:
            return np.zeros(2)
        if self.resolution is not None:
            q = np.round(q / self.resolution) * self.resolution
            if self.log:
                q_dot = (q - self.log[-1][1]) / self.period
        try:
            commanded = np.array(self.controller(t, q, q_dot, self.reference), dtype=float)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"controller at t = {t:g} s: {error}",)
            raise
        if commanded.shape != (2,):
            raise ValueError(
                f"the controller must return two {self.words.effort}s, not an array of shape"
                f" {commanded.shape}"
            )
        if not np.isfinite(commanded).all():
            raise ArithmeticError(
                f"the controller's {self.words.effort} is {commanded.tolist()}"
                f" {self.words.effort_unit} at t = {t:g} s"
            )
        self.pending.append(commanded)
        applied = self.pending.pop(0)
        if self.limit is not None:
            applied = np.clip(applied, -self.limit, self.limit)
        self.log.append((t, q, q_dot, commanded, applied))
        return applied


def assemble(
    robot,
    t,
    rows,
    torques,
    xi_ref,
    control,
    torque_limit,
    log=None,
    after=None,
    crosses=True,
    lost=None,
):
    """The Run of observations (n + 1, columns) and torques (n, 2) held between them; after: as
    `crossings` has it.

    crosses: whether crossings are looked for. lost: () -> what friction has taken (n + 1,), None:
        by the rows.
    """
    lost = lost or partial(loss_by_rows, robot, t, rows)
    return Run(
        robot=robot,
        t=t,
        q=robot.continuous(rows[:, Q]),
        q_dot=rows[:, Q_DOT],
        xi=rows[:, XI],
        energy=rows[:, ENERGY],
        tau=np.vstack([torques, torques[-1]]),
        xi_ref=xi_ref,
        torque_limit=torque_limit,
        control=control,
        events=crossings(robot, t, rows, after) if crosses else (),
        log=log,
        friction_loss=lost() if has_friction(robot) else None,
    )
