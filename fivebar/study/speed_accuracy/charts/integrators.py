"""Integrators on three motions without torque: regular, grazing Type 2, and through it twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from ....models.charts import CHARTS, JointChart, StateChart
from ....models.compiled import Buffered, compiled
from ....models.dynamics import energy
from ....simulation.settings import Integrator
from ....simulation.simulate import simulate
from ...pitfalls.integrators import adaptive, explicit_euler, march, rk4, semi_implicit_euler
from ...pitfalls.joint_space import joint_model, joint_slope
from ...pitfalls.redundant import closure, redundant_slope, redundant_state
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel
from ..machine import lacks_c_compiler
from .fixed_steps import propagate, slope_function
from .motions import DURATION, MOTIONS, ROBOT, FreeMotion

MOST_EVALUATIONS = 20_000  # evaluations of the model by a SciPy solver
LOST = 1e-2  # m: an end as far off is no approximation any more


def counts(first: float, last: float) -> tuple[int, ...]:
    """Return whole numbers of steps, each about sqrt 2 times the one before."""
    number = int(2 * np.log2(last / first) + 1.5)
    return tuple(round(first * 2 ** (k / 2)) for k in range(number))


def judged(problem: str) -> Callable[..., dict[str, float]]:
    """Return judge: (xi, q, energy) at the end -> errors in m, of the energy, of a bar's length."""
    motion = MOTIONS[problem]
    initial = float(energy(motion.begin()))

    def judge(end):
        xi, q, final = end
        return {
            "error": np.hypot(*np.subtract(xi, motion.end)),
            "energy": abs(final / initial - 1),
            "closure": closure(ROBOT, np.reshape(q, (1, 2)), np.reshape(xi, (1, 2)))[0],
        }

    return judge


def in_joints(problem: str) -> tuple:
    """Return slope, initial state and judge of states of the lab's model in joint coordinates."""
    start = MOTIONS[problem].begin()
    assembly = int(start.pose.assembly)
    judge = judged(problem)

    def judge_state(state):
        xi, _, _, final = joint_model(ROBOT, np.asarray(state), assembly)
        return judge((xi, state[:2], final))

    state = np.concatenate([start.pose.q, start.q_dot])
    return joint_slope(ROBOT, assembly), state, judge_state


def stepped(method: Callable) -> Callable[..., Attempt]:
    """Return prepare of a fixed-step method in Python; its knob is the number of steps."""

    def prepare(problem, count):
        slope, state, judge = in_joints(problem)
        step = DURATION / count
        return Attempt(lambda: march(method, slope, state, DURATION, step)[1][-1], judge)

    return prepare


def by_scipy(solver: str) -> Callable[..., Attempt]:
    """Return prepare of solve_ivp; its knob is rtol, atol a thousandth of it."""

    def prepare(problem, rtol):
        slope, state, judge = in_joints(problem)
        limits = rtol, 1e-3 * rtol, MOST_EVALUATIONS

        def judge_solution(solution):
            if not solution.success:
                ended = solution.evaluations < MOST_EVALUATIONS
                raise Failed("gives up" if ended else "comes to no end")
            return judge(solution.states[-1])

        times = np.array([0.0, DURATION])
        return Attempt(lambda: adaptive(slope, state, times, solver, *limits), judge_solution)

    return prepare


def by_casadi(plugin: str, options: Callable[[float], dict]) -> Callable[..., Attempt]:
    """Return prepare of casadi.integrator on our model in joint coordinates."""

    def prepare(problem, knob):
        start = MOTIONS[problem].begin()
        judge = judged(problem)
        c, c_dot, modes = JointChart().coordinates(start)
        x = ca.SX.sym("x", 4)
        slope = slope_function(ROBOT, JointChart())(
            x, ca.DM.zeros(2), [int(mode) for mode in modes]
        )
        dae = {"x": x, "ode": slope}
        integrator = ca.integrator("integrator", plugin, dae, 0.0, DURATION, options(knob))
        begin = np.array([*c, *c_dot])

        def judge_end(result):
            return judge(seen(JointChart(), result["xf"].full().ravel(), modes))

        return Attempt(lambda: integrator(x0=begin), judge_end)

    return prepare


def cvodes_options(reltol: float) -> dict:
    """Return options of CVODES."""
    tolerances = {"reltol": reltol, "abstol": 1e-3 * reltol}
    return tolerances | {"max_num_steps": 100_000, "show_eval_warnings": False}


def collocation_options(elements: float) -> dict:
    """Return options of collocation in so many finite elements."""
    return {
        "number_of_finite_elements": int(elements),
        "interpolation_order": 3,
        "rootfinder": "newton",
        "rootfinder_options": {"abstol": 1e-15, "abstolStep": 1e-16, "error_on_fail": False},
    }


def seen(chart: StateChart, state: np.ndarray, modes: tuple) -> tuple:
    """Return xi, q and energy of a state in a chart."""
    c, c_dot = (tuple(part.tolist()) for part in np.split(state, 2))
    rates = chart.rates(ROBOT, c, c_dot, tuple(int(mode) for mode in modes))
    return rates.pose.xi, rates.pose.q, float(energy(rates))


def fixed_steps(
    motion: FreeMotion, chart: StateChart, method: str, count: int, jit: bool
) -> tuple[Callable, list[int]]:
    """Return call () -> final state of our fixed steps in a chart, and the modes.

    Nothing is checked, and nothing is kept but the end.
    """
    c, c_dot, modes = chart.coordinates(motion.begin())
    modes = [int(mode) for mode in modes]
    function = propagate(ROBOT, chart, modes, method, DURATION / count, count, motion.torque)
    call = Buffered(compiled(function, jit))
    begin = np.array([*c, *c_dot], dtype=float)
    return lambda: call(begin)[0], modes


def ours(name: str, method: str, jit: bool) -> Callable[..., Attempt]:
    """Return prepare of our fixed steps in a chart."""
    chart = CHARTS[name]

    def prepare(problem, count):
        call, modes = fixed_steps(MOTIONS[problem], chart, method, count, jit)
        judge = judged(problem)
        return Attempt(call, lambda end: judge(seen(chart, end, modes)))

    return prepare


def ours_in_full(options: Callable[[float], dict]) -> Callable[..., Attempt]:
    """Return prepare of fivebar.simulate: every row of the Run, and its crossings."""

    def prepare(problem, knob):
        start = MOTIONS[problem].begin()
        judge = judged(problem)
        chosen = options(knob)
        return Attempt(
            lambda: simulate(ROBOT, duration=DURATION, start=start, **chosen),
            lambda run: judge((run.xi[-1], run.q[-1], run.energy[-1])),
        )

    return prepare


def in_steps(count: float) -> dict:
    """Return options of `simulate`: so many steps of order 8, and no other rows."""
    return {"step": DURATION / count, "integrator": Integrator("dop8")}


def to_tolerance(tolerance: float) -> dict:
    """Return options of `simulate`: 2000 rows, whose error is bounded."""
    return {"integrator": Integrator(tolerance=tolerance)}


def redundant(gain: Callable[[float], float]) -> Callable[..., Attempt]:
    """Return prepare of RK4 on the DAE in (x, y, q1, q2) with Baumgarte's gain(step)."""

    def prepare(problem, count):
        start = MOTIONS[problem].begin()
        judge = judged(problem)
        step = DURATION / count
        slope = redundant_slope(ROBOT, gain(step))
        state = redundant_state(start)
        weights = [ROBOT.m, ROBOT.m, ROBOT.zz1, ROBOT.zz2]

        def judge_end(end):
            return judge((end[:2], end[2:4], float(end[4:] ** 2 @ weights) / 2))

        return Attempt(lambda: march(rk4, slope, state, DURATION, step)[1][-1], judge_end)

    return prepare


def chart() -> Chart:
    """Return the chart of integrators."""
    tolerances = tuple(10.0**-k for k in range(2, 13))
    few = counts(8, 256)
    many = counts(25, 6400)
    slow = counts(50, 800)
    rough = counts(100, 3200)
    python = "fixed steps, Python"
    casadi = "CasADi's integrators"
    dae = "redundant DAE"
    cvodes = by_casadi("cvodes", cvodes_options)
    collocation = by_casadi("collocation", collocation_options)
    methods = []
    for name, family, prepare, knobs, order in (
        ("fivebar: order 8, four bars, compiled", OURS, ours("auto", "dop8", True), few, 8),
        ("fivebar: order 8, four bars, VM", OURS, ours("auto", "dop8", False), few, 8),
        ("fivebar: order 8, task chart, compiled", OURS, ours("task", "dop8", True), few, 8),
        ("fivebar: order 8, joint chart, compiled", OURS, ours("joint", "dop8", True), few, 8),
        ("fivebar: RK4, four bars, compiled", OURS, ours("auto", "rk4", True), many, 4),
        ("fivebar.simulate: steps of order 8", OURS, ours_in_full(in_steps), counts(16, 1024), 8),
        (
            "fivebar.simulate: tolerance, 2000 rows",
            OURS,
            ours_in_full(to_tolerance),
            tolerances[:-1],
            None,
        ),
        ("explicit Euler, Python", python, stepped(explicit_euler), rough, 1),
        ("semi-implicit Euler, Python", python, stepped(semi_implicit_euler), rough, 1),
        ("RK4, Python", python, stepped(rk4), slow, 4),
        ("SciPy DOP853, Python model", "SciPy", by_scipy("DOP853"), tolerances, None),
        # With a tighter tolerance it takes seconds.
        ("SciPy Radau, Python model", "SciPy", by_scipy("Radau"), tolerances[:7], None),
        ("SciPy LSODA, Python model", "SciPy", by_scipy("LSODA"), tolerances, None),
        ("CasADi CVODES", casadi, cvodes, tolerances, None),
        ("CasADi collocation, Radau of degree 3", casadi, collocation, counts(8, 128), 5),
        ("redundant DAE, RK4, Python", dae, redundant(lambda step: 0.0), slow, 4),
        ("redundant DAE, Baumgarte 10/s", dae, redundant(lambda step: 10.0), slow, 4),
        ("redundant DAE, Baumgarte 1/step", dae, redundant(lambda step: 1 / step), slow, 2),
    ):
        needs = (lacks_c_compiler,) if name.endswith("compiled") else ()
        methods.append(Method(name, family, prepare, knobs, needs, order))
    labels: dict[str, Any] = {
        "ylabel": "end-effector's error after 2 s (m)",
        "xlabel": "time for 2 s of motion (s)",
    }
    levels = 1e-3, 1e-6, 1e-9, 1e-12
    regular, grazing, through = (
        Panel(problem, motion.words, levels=levels, ceiling=LOST, **labels)
        for problem, motion in MOTIONS.items()
    )
    labels["ylabel"] = "largest error of a bar's length (m)"
    limits: dict[str, Any] = {"ceiling": 1e-3, "rounding": 1e-16, "floor": 1e-18}
    bars = Panel("through", "motion through Type 2: the bars", "closure", **labels, **limits)
    return Chart(
        name="integrators",
        title="Two seconds of free motion of the five-bar: error against computing time",
        reading=(
            "Each curve is a method, each point a number of steps or a tolerance. Three motions,"
            " farther and farther into a Type-2 singularity, where joint coordinates end: error at"
            " the end, against 40 digits; ways to fail stand in the strips above. Last: how far the"
            " bars are from their lengths, which can be wrong where more coordinates are kept than"
            " the robot has freedoms. Of these the four bars are closed again after each step, the"
            " redundant DAE is not. Lengths in the other motions, and the energy's change, are in"
            " the CSV file."
        ),
        problems={name: motion.words for name, motion in MOTIONS.items()},
        methods=tuple(methods),
        step=lambda count: DURATION / count,
        panels=((regular, grazing), (through, bars)),
    )
