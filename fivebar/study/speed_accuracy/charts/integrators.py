"""Integrators on three motions without torque: regular, grazing a Type-2 singularity, and through
two of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ....models.charts import CHARTS, Joint
from ....models.compiled import Buffered, compiled
from ....models.dynamics import energy
from ....simulation.simulate import simulate
from ....simulation.steps import model_functions, propagate
from ...pitfalls.integrators import adaptive, explicit_euler, march, rk4, semi_implicit_euler
from ...pitfalls.joint_space import joint_model, joint_slope
from ...pitfalls.redundant import closure, redundant_slope, redundant_state
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel
from .motions import DURATION, MOTIONS, ROBOT

if TYPE_CHECKING:
    from collections.abc import Callable

    from ....models.charts import BarAngles, Task
    from .motions import DrivenMotion, FreeMotion

ALPHA = 10.0  # 1/s, Baumgarte's
MOST_EVALUATIONS = 20_000  # evaluations of the model
LOST = 1e-2  # m: an end as far off is no approximation any more
RUNNING = np.sqrt(2.0)  # from one number of steps to the next


def counts(first: float, last: float) -> tuple[int, ...]:
    """Whole numbers of steps, each about sqrt 2 times the one before."""
    return tuple(
        int(round(first * RUNNING**k))
        for k in range(int(np.log(last / first) / np.log(RUNNING) + 1.5))
    )


def judged(problem: str) -> Callable[..., dict[str, float]]:
    """(xi (2,), q (2,), energy) at the end -> how far off it is, in m, in parts of the energy, in
    bar length.
    """
    motion = MOTIONS[problem]
    before = float(energy(motion.begin()))

    def judge(end):
        xi, q, after = end
        return {
            "error": np.hypot(*np.subtract(xi, motion.end)),
            "energy": abs(after / before - 1),
            "closure": closure(ROBOT, np.reshape(q, (1, 2)), np.reshape(xi, (1, 2)))[0],
        }

    return judge


def _from_joints(problem):
    """Slope and initial state of the lab's model in joint coordinates, and what a final state
    says.
    """
    start = MOTIONS[problem].begin()
    assembly, judge = int(start.pose.assembly), judged(problem)

    def read(state):
        xi, _, _, after = joint_model(ROBOT, np.asarray(state), assembly)
        return judge((xi, state[:2], after))

    return joint_slope(ROBOT, assembly), np.concatenate([start.pose.q, start.q_dot]), read


def stepped(method: Callable) -> Callable[..., Attempt]:
    """prepare of a fixed-step method in Python on the lab's joint-space model; its knob is the
    number of steps.
    """

    def prepare(problem, count):
        slope, state, read = _from_joints(problem)
        return Attempt(lambda: march(method, slope, state, DURATION, DURATION / count)[1][-1], read)

    return prepare


def by_scipy(solver: str) -> Callable[..., Attempt]:
    """prepare of solve_ivp on the lab's joint-space model; its knob is rtol, atol a thousandth of
    it.
    """

    def prepare(problem, rtol):
        slope, state, read = _from_joints(problem)
        times = np.array([0.0, DURATION])

        def judge(found):
            if not found.success:
                raise Failed(
                    "gives up" if found.evaluations < MOST_EVALUATIONS else "comes to no end"
                )
            return read(found.states[-1])

        return Attempt(
            lambda: adaptive(slope, state, times, solver, rtol, 1e-3 * rtol, MOST_EVALUATIONS),
            judge,
        )

    return prepare


def by_casadi(plugin: str) -> Callable[..., Attempt]:
    """prepare of casadi.integrator on our model in joint coordinates; its knob: reltol, or the
    finite elements.
    """

    def prepare(problem, knob):
        start, judge = MOTIONS[problem].begin(), judged(problem)
        c, c_dot, modes = Joint().coordinates(start)
        x = ca.SX.sym("x", 4)
        slope = model_functions(ROBOT, Joint())[0](x, ca.DM.zeros(2), [int(mode) for mode in modes])
        options = (
            {
                "reltol": knob,
                "abstol": 1e-3 * knob,
                "max_num_steps": 100_000,
                "show_eval_warnings": False,
            }
            if plugin == "cvodes"
            else {
                "number_of_finite_elements": int(knob),
                "interpolation_order": 3,
                "rootfinder": "newton",
                "rootfinder_options": {
                    "abstol": 1e-15,
                    "abstolStep": 1e-16,
                    "error_on_fail": False,
                },
            }
        )
        integrator = ca.integrator(
            "integrator", plugin, {"x": x, "ode": slope}, 0.0, DURATION, options
        )
        begin = np.array([*c, *c_dot])

        def judge_end(found):
            return judge(_seen(Joint(), found["xf"].full().ravel(), modes))

        return Attempt(lambda: integrator(x0=begin), judge_end)

    return prepare


def _seen(chart, state, modes):
    """xi, q and energy of a state in a chart."""
    c, c_dot = state[: chart.size].tolist(), state[chart.size :].tolist()
    rates = chart.rates(ROBOT, tuple(c), tuple(c_dot), tuple(int(m) for m in modes))
    return rates.pose.xi, rates.pose.q, float(energy(rates))


def fixed_steps(
    motion: FreeMotion | DrivenMotion,
    chart: BarAngles | Joint | Task,
    method: str,
    count: int,
    jit: bool,
) -> tuple[Callable, list[int]]:
    """call () -> final state of our fixed steps in one chart, nothing checked and nothing kept but
    the end; modes.
    """
    c, c_dot, modes = chart.coordinates(motion.begin())
    modes = [int(mode) for mode in modes]
    function = propagate(ROBOT, chart, modes, method, DURATION / count, count, motion.torque)
    call, begin = Buffered(compiled(function, jit)), np.array([*c, *c_dot], dtype=float)
    return lambda: call(begin)[0], modes


def ours(name: str, method: str, jit: bool) -> Callable[..., Attempt]:
    """prepare of our fixed steps in a chart."""
    chart = CHARTS[name]

    def prepare(problem, count):
        call, modes = fixed_steps(MOTIONS[problem], chart, method, count, jit)
        judge = judged(problem)
        return Attempt(call, lambda end: judge(_seen(chart, end, modes)))

    return prepare


def ours_in_full(chosen: Callable[[float], dict]) -> Callable[..., Attempt]:
    """prepare of fivebar.simulate with the options that a knob chooses: every row of the Run, and
    its crossings.
    """

    def prepare(problem, knob):
        start, judge, options = MOTIONS[problem].begin(), judged(problem), chosen(knob)
        return Attempt(
            lambda: simulate(ROBOT, duration=DURATION, start=start, **options),
            lambda run: judge((run.xi[-1], run.q[-1], run.energy[-1])),
        )

    return prepare


def in_steps(count: float) -> dict:
    """Options of `simulate`: so many steps of order 8, and no other rows."""
    return {"step": DURATION / count, "method": "dop8"}


def to_tolerance(tolerance: float) -> dict:
    """Options of `simulate`: 2000 rows, whose error is bounded."""
    return {"tolerance": tolerance}


def redundant(gain: Callable[[float], float]) -> Callable[..., Attempt]:
    """prepare of RK4 on the DAE in (x, y, q1, q2) with Baumgarte's gain(step)."""

    def prepare(problem, count):
        start, judge, step = MOTIONS[problem].begin(), judged(problem), DURATION / count
        slope, state = redundant_slope(ROBOT, gain(step)), redundant_state(start)
        weights = [ROBOT.m, ROBOT.m, ROBOT.zz1, ROBOT.zz2]

        def judge_end(end):
            return judge((end[:2], end[2:4], float(end[4:] ** 2 @ weights) / 2))

        return Attempt(lambda: march(rk4, slope, state, DURATION, step)[1][-1], judge_end)

    return prepare


def chart() -> Chart:
    tolerances = tuple(10.0**-k for k in range(2, 13))
    compiler = ("C compiler",)
    by_hand, few, many = counts(100, 3200), counts(8, 256), counts(25, 6400)
    python, casadi, dae = "fixed steps, Python", "CasADi's integrators", "redundant DAE"
    methods = (
        Method(
            "fivebar: order 8, four bars, compiled",
            OURS,
            ours("auto", "dop8", True),
            few,
            compiler,
            8,
        ),
        Method("fivebar: order 8, four bars, VM", OURS, ours("auto", "dop8", False), few, (), 8),
        Method(
            "fivebar: order 8, task chart, compiled",
            OURS,
            ours("task", "dop8", True),
            few,
            compiler,
            8,
        ),
        Method(
            "fivebar: order 8, joint chart, compiled",
            OURS,
            ours("joint", "dop8", True),
            few,
            compiler,
            8,
        ),
        Method(
            "fivebar: RK4, four bars, compiled", OURS, ours("auto", "rk4", True), many, compiler, 4
        ),
        Method(
            "fivebar.simulate: steps of order 8",
            OURS,
            ours_in_full(in_steps),
            counts(16, 1024),
            (),
            8,
        ),
        Method(
            "fivebar.simulate: tolerance, 2000 rows",
            OURS,
            ours_in_full(to_tolerance),
            tolerances[:-1],
        ),
        Method("explicit Euler, Python", python, stepped(explicit_euler), by_hand, order=1),
        Method(
            "semi-implicit Euler, Python", python, stepped(semi_implicit_euler), by_hand, order=1
        ),
        Method("RK4, Python", python, stepped(rk4), counts(50, 800), order=4),
        Method("SciPy DOP853, Python model", "SciPy", by_scipy("DOP853"), tolerances),
        Method(
            "SciPy Radau, Python model", "SciPy", by_scipy("Radau"), tolerances[:7]
        ),  # tighter, it takes seconds
        Method("SciPy LSODA, Python model", "SciPy", by_scipy("LSODA"), tolerances),
        Method("CasADi CVODES", casadi, by_casadi("cvodes"), tolerances),
        Method(
            "CasADi collocation, Radau of degree 3",
            casadi,
            by_casadi("collocation"),
            counts(8, 128),
            order=5,
        ),
        Method(
            "redundant DAE, RK4, Python", dae, redundant(lambda step: 0.0), counts(50, 800), order=4
        ),
        Method(
            "redundant DAE, Baumgarte 10/s",
            dae,
            redundant(lambda step: ALPHA),
            counts(50, 800),
            order=4,
        ),
        Method(
            "redundant DAE, Baumgarte 1/step",
            dae,
            redundant(lambda step: 1 / step),
            counts(50, 800),
            order=2,
        ),
    )
    error, length = "end-effector's error after 2 s (m)", "largest error of a bar's length (m)"
    levels, time = (1e-3, 1e-6, 1e-9, 1e-12), "time for 2 s of motion (s)"
    regular, grazing, through = (
        Panel(p, motion.words, ylabel=error, xlabel=time, levels=levels, ceiling=LOST)
        for p, motion in MOTIONS.items()
    )
    bars = Panel(
        through.problem,
        "motion through Type 2: the bars",
        "closure",
        length,
        xlabel=time,
        ceiling=1e-3,
        rounding=1e-16,
        floor=1e-18,
    )
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
        methods=methods,
        step=lambda count: DURATION / count,
        panels=((regular, grazing), (through, bars)),
    )
