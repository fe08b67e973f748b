"""Rungs of a robot's physics: what each costs, and what a controller without it misses.

The plant has all of it. The controller is computed torque, and knows the rungs up to one; what it
misses are the torques of the others, for which it has to make up by an error.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...control.laws import ComputedTorque
from ...models.compiled import Buffered, compile
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import ikm, ikm2
from ...models.links import Link
from ...models.named_robots import ROBOTS
from ...models.parameters import names_of, parameters_of
from ...models.robots import Biglide, FiveBar
from ...planning.trajectory import Trajectory, circle
from ...simulation.simulate import simulate
from ...simulation.steps import free_step

RUNGS = {
    "masses": (),
    "gravity": ("gravity", "mx11", "my11", "mx21", "my21"),
    "viscous friction": ("fv1", "fv2", "fv12", "fv22"),
    "dry friction": ("fs1", "fs2"),
    "turning bars": ("zz12", "zz22", "my12", "my22"),
}
# 1/s^2, 1/s, s
KP = 400.0
KD = 40.0
PERIOD = 1e-3
SETTLED = 0.4  # of the task, after which errors count
CALLS = 300  # of which the fastest half gives the time of a step


@dataclass(frozen=True, eq=False)
class Case:
    """A robot with all that is known of it, its task, the source of its numbers, working modes."""

    robot: FiveBar | Biglide
    reference: Trajectory
    source: str
    working: tuple[int, int] = (-1, -1)


@dataclass(frozen=True)
class Rung:
    """Costs and benefits of a rung.

    named: whether the robot has it at all; instructions of the inverse model; step: time of a step
    of the plant, s; missed: rms of the missing torque, N m; rms and largest tracking error, m.
    """

    name: str
    named: bool
    instructions: int
    step: float
    missed: float
    rms: float
    largest: float


def _upright_lab():
    bar = Link(1.0, 0.045, 0.0, 0.002025)
    links = {}
    links["11"] = links["21"] = bar
    return FiveBar.from_links(
        0.09, 0.09, 0.09, 0.09, 0.118, links, payload=0.5, gravity=(0.0, -9.81)
    )


def _haptic():
    lengths = 0.07, 0.09, 0.07, 0.09
    masses = [2700 * 0.015 * 0.004 * length for length in lengths]
    links = dict(zip(("11", "12", "21", "22"), masses))
    motors = (1e-6, 1e-6)
    return FiveBar.from_links(
        *lengths, 0.0, links, payload=0.02, rotor=motors, coulomb=(1e-3, 1e-3)
    )


VERTICAL = ROBOTS["iri-vertical"]
CASES = {
    "lab": Case(
        _upright_lab(),
        circle((0.0, 0.11), 0.02, 1.0),
        "the AMORO lab's files (1 kg at 45 mm of each proximal bar, 0.5 kg at the end), stood"
        " upright",
    ),
    "vertical": Case(VERTICAL.robot, circle((0.0, 0.24), 0.04, 1.0), VERTICAL.source),
    "haptic": Case(
        _haptic(),
        circle((0.0, 0.12), 0.02, 1.0),
        "Haply's lengths; assumed: aluminium bars of 15 x 4 mm, 20 g in the hand, motors of 1e-6 kg"
        " m² and 1 mN m",
        (1, -1),
    ),
}


def climb(case: Case, progress: Callable[[], object] = lambda: None) -> list[Rung]:
    """Return the rungs of a case, each with those below it; call progress after each."""
    robot = case.robot
    rungs = []
    unknown = [name for names in RUNGS.values() for name in names]
    pose = igm(robot, case.reference(0.0)[0], case.working)
    expected = task_torques(robot, case)
    for name, fields in RUNGS.items():
        unknown = [field for field in unknown if field not in fields]
        zeros: dict[str, Any] = {
            field: (0.0, 0.0) if field == "gravity" else 0.0 for field in unknown
        }
        model = replace(robot, **zeros)
        law = ComputedTorque(model, KP, KD, case.working, int(pose.assembly))
        run = simulate(robot, law, case.reference, control_period=PERIOD)
        error = np.hypot(*run.error[run.t >= SETTLED * run.t[-1]].T)
        missed = expected - task_torques(model, case)
        inverse = compile(model, ["xi", "xi_dot", "xi_ddot"], ["tau"], working=case.working)
        marks = ("gravity",) if name == "gravity" else fields  # moments without it are no rung
        rungs.append(
            Rung(
                name,
                not fields or any(mark in robot.parameters for mark in marks),
                inverse.n_instructions(),
                step_time(model),
                float(np.sqrt(np.mean(np.sum(missed**2, axis=1)))),
                float(np.sqrt(np.mean(error**2))),
                float(error.max()),
            )
        )
        progress()
    return rungs


def task_torques(robot: FiveBar | Biglide, case: Case) -> np.ndarray:
    """Return the torques (n, 2) N m that a robot needs for the task of a case."""
    xi, xi_dot, xi_ddot = case.reference(np.linspace(0, case.reference.duration, 1001))
    return inverse_dynamics(ikm2(ikm(igm(robot, xi, case.working), xi_dot), xi_ddot))


def step_time(robot: FiveBar | Biglide) -> float:
    """Return the time of a step of the plant, s: the median of the faster half of many."""
    names = names_of([robot])
    kind: Any = type(robot)
    call = Buffered(free_step(kind, names))
    state = np.array([0.3, 1.2, 1.5, 2.2, 1.0, -0.5, 0.7, 0.2])
    inputs = [state, np.zeros(2), 1e-3, 1e-12, np.array(parameters_of(robot, names))]
    if {"fs1", "fs2"} & set(names):
        inputs.append(np.ones(2))
    times = timeit.repeat(lambda: call(*inputs), number=1, repeat=CALLS)
    return float(np.median(np.sort(times)[: CALLS // 2]))


def table(cases: dict[str, list[Rung]]) -> tuple[tuple[str, ...], list[list]]:
    """Return heading and rows of the rungs of all cases, for a CSV or a print."""
    header = "robot rung named instructions step_us missed_Nm rms_um largest_um".split()
    rows = []
    for case, rungs in cases.items():
        for rung in rungs:
            values = asdict(rung) | {"named": int(rung.named)}
            for name in ("step", "rms", "largest"):
                values[name] *= 1e6
            rows.append([case, *values.values()])
    return tuple(header), rows
