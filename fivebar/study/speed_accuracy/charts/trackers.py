"""Controllers on the lab's task 1: tracking error against the time of a control step."""

from __future__ import annotations

import time
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ....control.laws import PD, ComputedTorque
from ....control.qp import QP
from ....control.tracker import Tracker
from ....simulation.cases import case
from ....simulation.comparison import compare
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel

if TYPE_CHECKING:
    from collections.abc import Callable

    from ....simulation.cases import Case

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
BANDWIDTHS = (
    5.0,
    10.0,
    20.0,
    40.0,
    80.0,
)  # 1/s: kp is its square, kd twice it, per unit of inertia
HORIZONS = (5, 10, 20, 40)  # stages
WARM_UP = 5  # steps that are not counted
FALLBACKS = 0.01  # of the steps: with more of them it is not the tracker that tracks
ASTRAY = 0.1  # m

the_case = lru_cache(maxsize=None)(case)


def tracked(controller_of: Callable) -> Callable[..., Attempt]:
    """prepare of controller_of(case, knob): one run, in which every control step is timed."""

    def prepare(problem, knob):
        chosen = the_case(problem)
        controller, times = controller_of(chosen, knob), []

        def timed(*arguments):
            before = time.perf_counter()
            tau = controller(*arguments)
            times.append(time.perf_counter() - before)
            return tau

        def call():
            run = chosen.simulate(timed)
            return run, getattr(controller, "log", None)

        def judge(result):
            run, log = result
            figures = compare({"run": run}).figures["run"]
            if log is not None and np.count_nonzero(log.status) > FALLBACKS * len(log.status):
                raise Failed(
                    f"QP fails in {np.count_nonzero(log.status) / len(log.status):.0%} of the steps"
                )
            return {"error": figures["rms_error_m"], "largest": figures["max_error_m"]}

        return Attempt(call, judge, times=lambda: np.array(times[WARM_UP:]))

    return prepare


def computed_torque(chosen: Case, bandwidth: float) -> ComputedTorque:
    return ComputedTorque(chosen.model, bandwidth**2, 2 * bandwidth)


def pd(chosen: Case, bandwidth: float) -> PD:
    """About the same bandwidth, by the inertia that a joint moves: no model beside it."""
    robot = chosen.model
    inertia = robot.zz1 + robot.m * robot.l11**2
    return PD(robot, inertia * bandwidth**2, 2 * inertia * bandwidth)


def predictive(solver: str) -> Callable:
    def controller_of(chosen, horizon):
        tracker = Tracker(
            chosen.model, int(horizon), torque_limit=chosen.options.get("torque_limit")
        )
        tracker.qp = QP(2 * int(horizon), 0, solver, SOLVERS[solver])
        return tracker

    return controller_of


def chart() -> Chart:
    mpc = "MPC by another QP solver"
    methods = (
        Method("fivebar.Tracker: MPC, QP by DAQP", OURS, tracked(predictive("daqp")), HORIZONS),
        Method(
            "computed torque, clipped at the limit",
            "no horizon",
            tracked(computed_torque),
            BANDWIDTHS,
        ),
        Method("PD", "no horizon", tracked(pd), BANDWIDTHS),
        *(
            Method(f"MPC, QP by {name}", mpc, tracked(predictive(name)), HORIZONS)
            for name in SOLVERS
            if name != "daqp"
        ),
    )
    problems = {
        "task-1": "no limit, exact model",
        "torque-limit": "torques limited to 60 % of what the motion needs",
        "mass": "mass 20 % larger than the controller knows",
    }
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
        problems=problems,
        methods=methods,
        panels=(
            tuple(
                Panel(
                    p,
                    words,
                    ylabel="RMS error of the end-effector (m)",
                    xlabel="time of a control step (s)",
                    levels=(2e-2, 5e-3) if p == "torque-limit" else (1e-3, 1e-4, 1e-5, 1e-6),
                    ceiling=ASTRAY,
                )
                for p, words in problems.items()
            ),
        ),
    )
