"""Rungs of a robot's physics: what each costs in a model and in a step, and what a controller
without it misses.

The plant has all of it. The controller is computed torque, and knows the rungs up to one; what it
misses are the torques of the others, and these it has to make up for by an error.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...control.laws import ComputedTorque
from ...models.compiled import Buffered, compile
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import ikm, ikm2
from ...models.links import Link
from ...models.named_robots import ROBOTS
from ...models.parameters import names_of, parameters_of
from ...models.robots import FiveBar
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
KP, KD, PERIOD = 400.0, 40.0, 1e-3  # 1/s^2, 1/s, s
SETTLED = 0.4  # of the task, after which errors count
CALLS = 300  # of which the fastest half gives a step's time


@dataclass(frozen=True, eq=False)
class Case:
    """A robot with all that is known of it, what of that is assumed, and its task."""

    robot: FiveBar
    reference: Trajectory
    source: str
    working: tuple[int, int] = (-1, -1)


@dataclass(frozen=True)
class Rung:
    """What a rung costs: instructions of the inverse model, time of a step of any length (s); and
    what it brings: rms of the torque that is missed (N m), rms and largest tracking error (m).
        named: whether the robot has it at all.
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
    return FiveBar.from_links(
        0.09, 0.09, 0.09, 0.09, 0.118, {"11": bar, "21": bar}, payload=0.5, gravity=(0.0, -9.81)
    )


def _haptic():
    lengths = 0.07, 0.09, 0.07, 0.09, 0.0
    links = {
        name: 2700 * 0.015 * 0.004 * length
        for name, length in zip(("11", "12", "21", "22"), lengths)
    }
    return FiveBar.from_links(
        *lengths, links, payload=0.02, rotor=(1e-6, 1e-6), coulomb=(1e-3, 1e-3)
    )


CASES = {
    "lab": Case(
        _upright_lab(),
        circle((0.0, 0.11), 0.02, 1.0),
        "the AMORO lab's files (1 kg at 45 mm of each proximal bar, 0.5 kg at the end), stood"
        " upright",
    ),
    "vertical": Case(
        ROBOTS["iri-vertical"].robot, circle((0.0, 0.24), 0.04, 1.0), ROBOTS["iri-vertical"].source
    ),
    "haptic": Case(
        _haptic(),
        circle((0.0, 0.12), 0.02, 1.0),
        "Haply's lengths; assumed: aluminium bars of 15 x 4 mm, 20 g in the hand, motors of 1e-6 kg"
        " m² and 1 mN m",
        (1, -1),
    ),
}


def climb(case: Case, tick: Callable[[], object] = lambda: None) -> list[Rung]:
    """A case's rungs, each with those below it. tick: called after each."""
    robot, known, rungs = case.robot, [], []
    away = {
        name: (0.0, 0.0) if name == "gravity" else 0.0 for names in RUNGS.values() for name in names
    }
    wanted = _torques(robot, case)
    for name, fields in RUNGS.items():
        known += fields
        model = replace(
            robot, **{field: zero for field, zero in away.items() if field not in known}
        )
        law = ComputedTorque(model, KP, KD, case.working, -int(np.sign(_start(case).det_A)))
        run = simulate(robot, law, case.reference, control_period=PERIOD)
        error = np.hypot(*run.error[run.t >= SETTLED * run.t[-1]].T)
        missed = wanted - _torques(model, case)
        inverse = compile(model, ["xi", "xi_dot", "xi_ddot"], ["tau"], working=case.working)
        named = not fields or (
            "gravity" in robot.parameters
            if name == "gravity"
            else any(field in robot.parameters for field in fields)
        )
        rms = float(np.sqrt(np.mean(error**2))), float(error.max())
        missed = float(np.sqrt(np.mean(np.sum(missed**2, axis=1))))
        rungs.append(Rung(name, named, inverse.n_instructions(), step_time(model), missed, *rms))
        tick()
    return rungs


def _start(case):
    return igm(case.robot, case.reference(0.0)[0], case.working)


def _torques(robot, case):
    xi, xi_dot, xi_ddot = case.reference(np.linspace(0, case.reference.duration, 1001))
    return inverse_dynamics(ikm2(ikm(igm(robot, xi, case.working), xi_dot), xi_ddot))


def step_time(robot: FiveBar) -> float:
    """Time of one step of any length of this robot's plant, s: the median of the faster half of
    many.
    """
    names = names_of([robot])
    call, parameters = (
        Buffered(free_step(type(robot), names)),
        np.array(parameters_of(robot, names)),
    )
    state = np.array([0.3, 1.2, 1.5, 2.2, 1.0, -0.5, 0.7, 0.2])
    inputs = [state, np.zeros(2), 1e-3, 1e-12, parameters] + [np.ones(2)] * bool(
        {"fs1", "fs2"} & set(names)
    )
    spent = []
    for _ in range(CALLS):
        before = time.perf_counter()
        call(*inputs)
        spent.append(time.perf_counter() - before)
    return float(np.median(np.sort(spent)[: CALLS // 2]))


def table(found: dict[str, list[Rung]]) -> tuple[tuple[str, ...], list[list]]:
    """Header and rows of all cases' rungs, for a CSV or a print."""
    header = (
        "robot",
        "rung",
        "named",
        "instructions",
        "step_us",
        "missed_Nm",
        "rms_um",
        "largest_um",
    )
    rows = [
        [
            case,
            r.name,
            int(r.named),
            r.instructions,
            1e6 * r.step,
            r.missed,
            1e6 * r.rms,
            1e6 * r.largest,
        ]
        for case, rungs in found.items()
        for r in rungs
    ]
    return header, rows
