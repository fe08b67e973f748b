"""Many closed loops by one compiled function: their Runs, or a summary of each."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import overload

import numpy as np

from ..base.checks import a_callable, bounded, instance, optional, positive, shown, takes
from ..base.progress import progress
from ..base.robot_uses import robot_for
from ..control.laws import PD, ComputedTorque, motion_at, warn_of_assembly
from ..models.charts import CHARTS
from ..models.geometry import igm
from ..models.kinematics import Rates, ikm, some_rates
from ..models.loaded_robot import LoadedRobot, refuse_numbers, robot_and_torques
from ..models.parameters import names_of, parameters_of
from ..models.robots import Robot
from .events import may_cross
from .fixed_plant import refuse_sticking
from .loops import ClosedLoops, LoopModel, a_built_in_controller, one_law
from .plant import check_start
from .run import Run
from .settings import Integrator, Measurement
from .simulate import Grid, refuse_other_kind
from .steps import MARGIN_RATES, MARGINS
from .summaries import Summaries, Summary, summarize

MOST_ROWS = 3 * 10**7  # of all runs
ROW_BYTES = 180  # memory of a row
MOST_BLOCK = 10**5  # steps in a control period
STEP_BYTES = 1200  # memory of a step during a call
AT_ONCE = 4 * 10**6  # rows in one call
TOGETHER = 128  # runs in one call: more would only take memory

BARE = robot_for("fb.simulate_many")


@overload
def simulate_many(
    robot: Robot | LoadedRobot | Sequence[Robot | LoadedRobot],
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
    summary: None = None,
) -> list[Run]: ...


@overload
def simulate_many(
    robot: Robot | LoadedRobot | Sequence[Robot | LoadedRobot],
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
    summary: Summary,
) -> Summaries: ...


@takes(
    reference=optional(a_callable),
    duration=optional(positive),
    control_period=positive,
    step=positive,
    torque_limit=optional(positive),
    measurement=optional(instance(Measurement)),
    integrator=optional(instance(Integrator)),
    summary=optional(instance(Summary)),
)
def simulate_many(
    robot: Robot | LoadedRobot | Sequence[Robot | LoadedRobot],
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
    summary: Summary | None = None,
) -> list[Run] | Summaries:
    """Simulate many closed loops by one compiled function, on all cores.

    The Runs equal those of `simulate` with the same chart and fixed steps, within rounding. With a
    `summary` only some figures of each run are kept.

    Parameters
    ----------
    robot : Robot or sequence of Robot
        Of all runs, or one for each. Lengths and inertias are parameters of the function. Also a
        LoadedRobot, or several with the same torques, which must be of CasADi's functions. Robots
        with dry friction go one by one through `simulate`.
    controller : PD or ComputedTorque, or a sequence of these
        Of all runs, or one for each; they may differ in their gains alone. A class of your own that
        derives from these may override law(q, q_dot, q_ref, q_ref_dot, q_ref_ddot) -> tau, which is
        compiled, and so is of arithmetic and CasADi's functions; kp and kd are (2).
    reference : callable, optional
        As in `simulate`.
    starts : Rates or sequence of Rates, optional
        Rates of a batch (n,), or one Rates for each run. None: each robot as the reference starts,
        in the controller's working modes.
    duration, control_period, step, measurement
        As in `simulate`.
    torque_limit : float, optional
        N m, the size at which either torque saturates.
    integrator : Integrator, optional
        Its steps are fixed; method None is "rk4".
    summary : Summary, optional
        Keep figures of each run in place of its rows; also executor, chunks, and a folder in which
        the same call goes on.

    Returns
    -------
    list of Run, or Summaries

    Raises
    ------
    ValueError
        Where the arguments do not go together; it names the robots that do not reach the start.
    ArithmeticError, SingularityError
        As `simulate`, for the first run that does not go through; it has the run's number. In a
        summary, that run's figures are nan and its error is in `.errors`.

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
    robots, torques, controllers, starts = _runs_of(robot, controller, starts)
    law, gains = one_law(controllers)
    grid = Grid.of(duration, reference, step, control_period)
    count = len(robots)
    rows = (grid.steps if summary else count * grid.steps) * 1.0
    what = f"{count} runs of {grid.steps} steps are {rows:.3g} rows"
    hint = "(summary= keeps none of them)"
    bounded(rows, MOST_ROWS, f"{what} {hint}", ROW_BYTES)
    what = f"control_period = {control_period:g} s is {grid.block:.3g} steps"
    bounded(grid.block, MOST_BLOCK, what, STEP_BYTES)
    periods = -(-grid.steps // grid.block)
    loop = LoopModel(
        type(robots[0]),
        names_of(robots),
        law,
        CHARTS[integrator.chart],
        integrator.method or "rk4",
        grid,
        periods,
        torque_limit,
        replace(measurement, delay=min(measurement.delay, periods)),
        torques,
    )
    parameters = np.array([parameters_of(each, loop.names) for each in robots], dtype=float)
    cases = np.hstack([parameters, gains, _starts(loop, robots, starts, reference)])
    loops = ClosedLoops(loop, integrator.jit, reference, os.cpu_count() or 1)
    if summary is not None:
        return summarize(loops, cases, summary)
    runs = []
    together = max(1, min(TOGETHER, AT_ONCE // grid.steps))
    parts = range(0, count, together)
    for first in progress(parts, unit=f" x {together} runs", delay=1):
        part = slice(first, first + together)
        runs += _runs(loops, robots[part], cases[part], first)
    return runs


def _runs(loops, robots, cases, first):
    """Return the Runs of rows, the first of which is number `first`."""
    observed, samples = loops(cases)
    crosses = may_cross(observed[:, :, MARGINS], observed[:, :, MARGIN_RATES])
    runs = []
    for k, robot in enumerate(robots):
        try:
            loops.check(robot, observed[k], loops.torques(samples[k]))
        except ArithmeticError as error:
            error.args = (f"run {first + k}: {error}",)
            raise
        crossed = bool(crosses[k])
        runs.append(loops.run(robot, observed[k], samples[k], crossed))
    return runs


def _runs_of(robot, controller, starts):
    """Return robots (n,), their torques, controllers (n,), and starts as they came, checked."""
    if isinstance(starts, str) or not isinstance(starts, (Rates, Sequence, type(None))):
        raise TypeError(
            f"starts must be the Rates of a batch, or one Rates for each run, not {shown(starts)}"
        )
    if isinstance(robot, str):
        robot = BARE(robot, "robot")
    values = {"robots": robot, "controllers": controller, "starts": starts}
    lengths = {}
    for name, value in values.items():
        if isinstance(value, Sequence):
            lengths[name] = len(value)
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
    robots, torques = _bare(robots)
    for each in controllers:
        a_built_in_controller(each, "controller")
        refuse_other_kind(robots[0], each)
    if isinstance(starts, Rates) and any(each != starts.pose.robot for each in robots):
        raise ValueError(
            "starts is a batch of one robot's Rates: for several robots give a list, or None"
        )
    if isinstance(starts, Sequence):
        for each, start in zip(robots, starts):
            check_start(each, some_rates(start, "starts"))
    return robots, torques, controllers, starts


def _bare(plants):
    """Return the robots, checked, and the torques of all of them."""
    robots = []
    loads = getattr(plants[0], "torques", None)
    for k, plant in enumerate(plants):
        robot = plant.robot if isinstance(plant, LoadedRobot) else BARE(plant, "robot")
        if type(robot) is not type(robots[0] if robots else robot):
            raise ValueError(
                f"robots of one kind go together: number {k} is a {type(robot).__name__}"
            )
        if getattr(plant, "torques", None) is not loads:
            raise ValueError(f"robots of one loop have the same torques: number {k} has others")
        refuse_sticking(robot)
        robots.append(robot)
    torques = robot_and_torques(plants[0])[1]
    refuse_numbers(torques, "a loop of simulate_many")
    return robots, torques


def _starts(loop, robots, starts, reference):
    """Return the states with their memory and the modes of starts, (n, size + memory + 2).

    No torque is on its way. The reading before the first is such that their difference gives the
    start's rate.
    """
    if isinstance(starts, Rates):
        each = [starts]
        columns = _columns(loop.chart, starts)
    else:
        each = starts or list(_at_reference(robots, loop.law, reference))
        columns = np.array([_columns(loop.chart, start) for start in each])
    for start in each:
        warn_of_assembly(loop.law, start.pose)
    bad = np.flatnonzero(~np.isfinite(columns).all(axis=1))
    if bad.size:
        more = " ..." if len(bad) > 5 else ""
        first = ", ".join(map(str, bad[:5])) + more
        x, y = motion_at(reference, 0.0)[0]
        raise ValueError(
            f"{len(bad)} of {len(robots)} robots do not reach the reference's start ({x:.9g},"
            f" {y:.9g}) m: number {first}"
        )
    ends = np.cumsum([loop.size, 2, 2])
    states, modes, q, q_dot = np.split(columns, ends, axis=1)
    memory = [np.zeros((len(columns), 2 * loop.measurement.delay))]
    resolution = loop.measurement.encoder_resolution
    if resolution is not None:
        reading = np.round(q / resolution) * resolution
        memory.append(reading - loop.grid.block * loop.grid.step * q_dot)
    return np.hstack([states, *memory, modes])


def _at_reference(robots, law, reference) -> Iterator[Rates]:
    """Yield the Rates with which each robot is at the reference's start; nan out of reach."""
    if reference is None:
        raise ValueError("simulate_many needs starts, or a reference that says where all begin")
    xi, xi_dot, _ = motion_at(reference, 0.0)
    for robot in robots:
        yield ikm(igm(robot, xi, law.working, "nan"), xi_dot)


def _columns(chart, start):
    """Return state, modes, q and q' (*batch, size + 6) of a start."""
    c, c_dot, modes = chart.coordinates(start)
    q = [leg.q for leg in start.pose.legs]
    q_dot, _ = start.components
    columns = np.broadcast_arrays(*c, *c_dot, *modes, *q, *q_dot)
    return np.stack(columns, axis=-1).astype(float)
