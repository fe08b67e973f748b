"""Controllers on the lab's task 1: tracking error against the time of a control step."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ....constraints.constraints import Constraints
from ....control.laws import PD, ComputedTorque
from ....control.qp import QP
from ....control.tracker import Tracker
from ....simulation.comparison import compare
from ...control_cases import ControlCase, case
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel

QUIET = {"print_iter": False, "print_header": False, "print_info": False}
TIGHT = {"eps_abs": 1e-9, "eps_rel": 1e-9}
SOLVERS = {  # CasADi's names, and the options that they need to be quiet and exact
    "daqp": {},
    "qrqp": QUIET,
    "qpoases": {"printLevel": "none"},
    "osqp": {"osqp": {"verbose": False, **TIGHT}},
    "proxqp": {"proxqp": {"eps_abs": 1e-9}},
    "piqp": {},
    "ipqp": QUIET,
    "highs": {"highs": {"output_flag": False}},
}
BANDWIDTHS = (5.0, 10.0, 20.0, 40.0, 80.0)  # 1/s: kp is its square, kd twice it, by inertia
HORIZONS = (5, 10, 20, 40)  # stages
WARM_UP = 5  # steps that are not counted
FALLBACKS = 0.01  # of the steps: with more of them it is not the tracker that tracks
PROBLEMS = {
    "task-1": "no limit, exact model",
    "torque-limit": "torques limited to 60 % of what the motion needs",
    "mass": "mass 20 % larger than the controller knows",
}


def tracked(make: Callable[[ControlCase, float], Callable]) -> Callable[..., Attempt]:
    """Return prepare of a controller make(case, knob): one run, every control step timed."""

    def prepare(problem, knob):
        chosen = case(problem)
        times = []
        controller = make(chosen, knob)

        def timed(*arguments):
            before = time.perf_counter()
            tau = controller(*arguments)
            times.append(time.perf_counter() - before)
            return tau

        def judge(run):
            if isinstance(controller, Tracker):
                failed = np.mean(controller.log.status != 0)
                if failed > FALLBACKS:
                    raise Failed(f"QP fails in {failed:.0%} of the steps")
            figures = compare({"run": run}).figures["run"]
            return {"error": figures["rms_error_m"], "largest": figures["max_error_m"]}

        return Attempt(
            lambda: chosen.simulate(timed), judge, times=lambda: np.array(times[WARM_UP:])
        )

    return prepare


def computed_torque(chosen: ControlCase, bandwidth: float) -> ComputedTorque:
    """Return critically damped computed torque."""
    return ComputedTorque(chosen.model, bandwidth**2, 2 * bandwidth)


def pd(chosen: ControlCase, bandwidth: float) -> PD:
    """Return PD of about the same bandwidth, by the inertia that a joint moves."""
    robot = chosen.model
    inertia = robot.zz1 + robot.m * robot.l11**2
    return PD(robot, inertia * bandwidth**2, 2 * inertia * bandwidth)


def predictive(solver: str) -> Callable[[ControlCase, float], Tracker]:
    """Return a maker of the tracker with this QP solver; its knob is the horizon."""

    def make(chosen, horizon):
        constraints = Constraints(torque=chosen.torque_limit)
        tracker = Tracker(chosen.model, int(horizon), constraints=constraints)
        tracker.qp = QP(2 * int(horizon), 0, solver, SOLVERS[solver])
        return tracker

    return make


def chart() -> Chart:
    """Return the chart of controllers."""
    methods = [
        Method("fivebar.Tracker: MPC, QP by DAQP", OURS, tracked(predictive("daqp")), HORIZONS)
    ]
    for name, law in (("computed torque, clipped at the limit", computed_torque), ("PD", pd)):
        methods.append(Method(name, "no horizon", tracked(law), BANDWIDTHS))
    for name in list(SOLVERS)[1:]:
        prepare = tracked(predictive(name))
        methods.append(Method(f"MPC, QP by {name}", "MPC by another QP solver", prepare, HORIZONS))
    labels: dict[str, Any] = {
        "ylabel": "RMS error of the end-effector (m)",
        "xlabel": "time of a control step (s)",
        "ceiling": 0.1,
    }
    panels = []
    for problem, words in PROBLEMS.items():
        levels = (2e-2, 5e-3) if problem == "torque-limit" else (1e-3, 1e-4, 1e-5, 1e-6)
        panels.append(Panel(problem, words, levels=levels, **labels))
    return Chart(
        name="trackers",
        title="Tracking the lab's task 1 at 100 Hz: error against the time of a control step",
        reading=(
            "Each point is one run: of the model-predictive tracker with 5, 10, 20, 40 stages of"
            " horizon, of the other controllers with bandwidths from 5 to 80 1/s. Time is the"
            " median of a run's control steps, bars reach from their lower to their upper quartile;"
            " a step has 10 ms. A tracker whose QP fails in more than 1 % of the steps counts as"
            " failed."
        ),
        problems=PROBLEMS,
        methods=tuple(methods),
        panels=(tuple(panels),),
    )
