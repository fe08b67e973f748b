"""The cases that controllers are compared on: the lab's two tasks, and what a real machine adds to
the first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..constraints.constraints import Constraints
from ..control.laws import ComputedTorque
from ..control.tracker import Tracker
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from ..models.robots import FiveBar
from ..planning.plan import plan
from ..planning.plans import Plan
from ..planning.trajectory import Trajectory, line
from ..simulation.run import Run
from ..simulation.settings import Measurement
from ..simulation.simulate import simulate

HOME = (0.09, 0.06796322)  # m
TASK_1 = (0.0, 0.1)  # from home in 2 s
TASK_2 = (0.05, 0.0)  # from home in 4 s
SETTLING = 0.5  # s, simulated beyond the reference's end
ENCODER = 2 * math.pi / 4096  # rad


@dataclass(frozen=True)
class ControlCase:
    """A motion to be tracked.

    plant: the robot that moves; model: the one that its controller knows.
    """

    title: str
    reference: Trajectory | Plan
    plant: FiveBar = FiveBar()
    model: FiveBar = FiveBar()
    torque_limit: float | None = None
    measurement: Measurement = field(default_factory=Measurement)

    def simulate(self, controller: str | Callable) -> Run:
        """Return the Run of a controller, or of one of CONTROLLERS by its name."""
        if isinstance(controller, str):
            controller = CONTROLLERS[_known(controller, CONTROLLERS, "controller")](self)
        duration = self.reference.start + self.reference.duration + SETTLING
        return simulate(
            self.plant,
            controller,
            self.reference,
            duration=duration,
            torque_limit=self.torque_limit,
            measurement=self.measurement,
        )


def _task_1(title="task 1", **more):
    return ControlCase(title, line(HOME, TASK_1, 2.0), **more)


def _torque_limit():
    """60 % of the largest torque that the exact inverse model gives along task 1."""
    case = _task_1("task 1, torque limit 60 %")
    xi, xi_dot, xi_ddot = case.reference(np.linspace(0.0, 2.0, 2001))
    tau = inverse_dynamics(ikm2(ikm(igm(case.model, xi), xi_dot), xi_ddot))
    return replace(case, torque_limit=0.6 * float(np.abs(tau).max()))


def _crossing():
    """Task 2, planned with least effort; it passes the Type-2 singularity at t = 3 s."""
    reference = plan(FiveBar(), HOME, TASK_2, 4.0)
    return ControlCase("task 2, planned across Type 2", reference, torque_limit=0.05)


CASES = {
    "task-1": _task_1,
    "torque-limit": _torque_limit,
    "mass": lambda: _task_1("task 1, mass 20 % larger than known", plant=FiveBar(m=0.6)),
    "delay": lambda: _task_1("task 1, delay 10 ms", measurement=Measurement(delay=1)),
    "encoder": lambda: _task_1(
        "task 1, encoders of 4096 steps", measurement=Measurement(encoder_resolution=ENCODER)
    ),
    "crossing": _crossing,
}


def _mpc(case):
    return Tracker(
        case.model,
        constraints=Constraints(torque=case.torque_limit),
        delay=case.measurement.delay,
        encoder_resolution=case.measurement.encoder_resolution,
    )


# Computed torque at the lab's gains and with twice its bandwidth.
CONTROLLERS = {
    "ctc": lambda case: ComputedTorque(case.model, 100, 20),
    "ctc-stiff": lambda case: ComputedTorque(case.model, 400, 40),
    "mpc": _mpc,
}


def case(name: str) -> ControlCase:
    """Return one of CASES by its name: ControlCase."""
    return CASES[_known(name, CASES, "case")]()


def run_case(name: str, controllers: Sequence[str] = tuple(CONTROLLERS)) -> dict[str, Run]:
    """Runs of a case by the controllers' names: what `compare` takes."""
    chosen = case(name)
    return {controller: chosen.simulate(controller) for controller in controllers}


def _known(name, table, what):
    if name not in table:
        raise ValueError(f"no {what} {name!r}; the known ones are {', '.join(table)}")
    return name
