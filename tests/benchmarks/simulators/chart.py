"""The forced motion, one through Type 2, and turning cranks in other simulators and here: errors
against time.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from fivebar.base.backend import wrap
from fivebar.models.charts import BarAngles, JointChart
from fivebar.models.compiled import Buffered, compiled
from fivebar.models.geometry import dgm
from fivebar.simulation.simulate import simulate
from fivebar.simulation.steps import runge_kutta
from fivebar.study.pitfalls.integrators import adaptive
from fivebar.study.pitfalls.redundant import closure, redundant_state
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Chart, Failed, Method, Panel
from fivebar.study.speed_accuracy.charts.fixed_steps import slope_function
from fivebar.study.speed_accuracy.charts.integrators import counts, fixed_steps, to_tolerance
from fivebar.study.speed_accuracy.machine import lacks_c_compiler, lacks_module

from . import at_once, branches
from .constrained import multipliers
from .drake import DRAKE_BUSHINGS, drake_as_it_comes, drake_bushing, drake_by_hand
from .exudyn import EXUDYN_SPRINGS, exudyn_as_it_comes, exudyn_springs
from .heyoka import heyoka_run
from .motions import DRIVEN, DURATION, ROBOT
from .mujoco_pinocchio import mujoco_run, pinocchio_native, pinocchio_run, read
from .native import lacks_cxx_compiler, lacks_headers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


SAME = "constrained equations, fivebar's compiler"
REPEATS = 5  # of what is timed alone
LOST, FAR = 0.3, 100.0  # rad
POSITIONS, TURNING = "positions", "cranks that turn, 90° apart"
AT_ONCE = f"{at_once.USUAL_ROBOTS} robots at once, each thrown at its own rates"
NUMBER = f"robots at once, {at_once.USUAL_STEPS} steps of 10 ms"
ROUNDING = {"forced": 1e-15, "through": 1e-13}  # rad at the end, which grows at each crossing


def judged(problem: str) -> Callable[..., dict[str, float]]:
    """(active joints (2,), gap m) -> largest error of a joint, rad, and the gap."""
    end = DRIVEN[problem].end

    def judge(found):
        q, gap = found
        if not np.isfinite(q).all():
            raise Failed("nan")
        if np.abs(q).max() > FAR:
            raise Failed("diverges")
        return {"error": max(abs(wrap(float(a - b))) for a, b in zip(q, end)), "gap": gap}

    return judge


def _gap(q, xi):
    return closure(ROBOT, np.reshape(q, (1, 2)), np.reshape(xi, (1, 2)))[0]


def ours(jit: bool) -> Callable[..., Attempt]:
    """prepare of our fixed steps of the four bars, the torque read at every stage."""

    def prepare(problem, count):
        judge = judged(problem)
        call, _ = fixed_steps(DRIVEN[problem], BarAngles(), "dop8", count, jit)
        return Attempt(call, lambda end: judge(read_bars(end[:4])))

    return prepare


def in_joints(problem: str, count: int) -> Attempt:
    """The same in the joint chart, which has half as many coordinates, and an end at Type 2."""
    judge = judged(problem)
    call, modes = fixed_steps(DRIVEN[problem], JointChart(), "dop8", count, True)

    def judge_end(end):
        return judge(
            (
                end[:2],
                _gap(end[:2], dgm(ROBOT, np.nan_to_num(end[:2]), modes[0], unreachable="nan").xi),
            )
        )

    return Attempt(call, judge_end)


def ours_in_full(chosen: Callable[[float], dict]) -> Callable[..., Attempt]:
    """prepare of fivebar.simulate; for a motion without torque, which it would hold over a step."""

    def prepare(problem, knob):
        start, judge, options = DRIVEN[problem].begin(), judged(problem), chosen(knob)
        return Attempt(
            lambda: simulate(ROBOT, duration=DURATION, start=start, **options),
            lambda run: judge((run.q[-1], _gap(run.q[-1], run.xi[-1]))),
        )

    return prepare


def redundant_compiled(jit: bool) -> Callable[..., Attempt]:
    """prepare of order 8 on the constrained equations in (x, y, q1, q2), through the same compiler
    as ours.
    """

    def prepare(problem, count):
        motion, judge, step = DRIVEN[problem], judged(problem), DURATION / count
        state, t = ca.SX.sym("state", 8), ca.SX.sym("t")

        def slope(stage, fraction):
            return multipliers(stage, motion.torque(t + fraction * step))

        one = ca.Function("step", [state, t], ca.cse([runge_kutta("dop8", step, state, slope)]))
        start = ca.MX.sym("start", 8)
        whole = ca.Function(
            "redundant", [start], [one.fold(count)(start, step * ca.DM(range(count)).T)]
        )
        call, begin = Buffered(compiled(whole, jit)), redundant_state(motion.begin())
        return Attempt(
            lambda: call(begin)[0], lambda end: judge((end[2:4].copy(), _gap(end[2:4], end[:2])))
        )

    return prepare


def lsoda(problem: str, rtol: float) -> Attempt:
    """SciPy's LSODA, called with our closed form, which is compiled: what SciPy itself costs."""
    motion, judge = DRIVEN[problem], judged(problem)
    c, c_dot, modes = JointChart().coordinates(motion.begin())
    model = Buffered(slope_function(ROBOT, JointChart()))
    modes, times = np.array(modes, dtype=float), np.array([0.0, DURATION])

    def slope(t, state):
        return model(state, motion.torque(t), modes)[0].copy()

    def judge_end(found):
        if not found.success:
            raise Failed("gives up")
        end = found.states[-1][:2]
        return judge(
            (end, _gap(end, dgm(ROBOT, np.nan_to_num(end), int(modes[0]), unreachable="nan").xi))
        )

    return Attempt(
        lambda: adaptive(slope, np.array([*c, *c_dot]), times, "LSODA", rtol, 1e-3 * rtol),
        judge_end,
    )


def simulator(make: Callable, alone: bool = False, read: Callable = read) -> Callable[..., Attempt]:
    """prepare of a run of `peers`: make (motion, knob) -> (run, step only); alone: timed is only
    the latter.

    read: what run returns -> active joints, gap.
    """

    def prepare(problem, count):
        run, step_only = make(DRIVEN[problem], count)
        judge = judged(problem)
        if not alone:
            return Attempt(run, lambda q: judge(read(q)))
        spent = []

        def call():
            found = run()
            for _ in range(REPEATS):
                before = time.perf_counter()
                step_only()
                spent.append(time.perf_counter() - before)
            return found

        return Attempt(call, lambda q: judge(read(q)), times=lambda: np.array(spent))

    return prepare


def read_springs(found: tuple) -> tuple:
    return found[0], _gap(*found)


def read_bars(a: np.ndarray) -> tuple:
    pose = BarAngles().rates(ROBOT, tuple(a.tolist()), (0.0,) * 4, (0, 0)).pose
    return pose.q, _gap(pose.q, pose.xi)


def in_mujoco(**how: bool) -> Callable[..., Attempt]:
    return simulator(partial(mujoco_run, **how))


def pinocchio_by(method: str, loop: Callable = pinocchio_run) -> Callable:
    return lambda motion, count: loop(motion, count, method)


def simulated() -> tuple[Method, ...]:
    """Methods of the motions: ours, the same equations otherwise, the simulators."""
    few, tuned, tolerances = (
        counts(6, 128),
        tuple(25 * 2**k for k in range(9)),
        tuple(10.0**-k for k in range(3, 13)),
    )
    dense = tuple(sorted({*few, *counts(7, 108)}))  # where curves lie close to each other
    compiler, pin, mj, drake, exu = (
        (lacks_c_compiler,),
        (lacks_module("pinocchio", "pin"),),
        (lacks_module("mujoco"),),
        (lacks_module("pydrake", "drake"),),
        (lacks_module("exudyn"),),
    )
    in_c, in_cxx = (*mj, *compiler), (*pin, lacks_headers, lacks_cxx_compiler)
    trap, through = {"forced": tuned}, {"through": tolerances[:-1]}
    return (
        Method("fivebar: four bars, order 8, compiled", OURS, ours(True), dense, compiler, 8),
        Method("fivebar: four bars, order 8, VM", OURS, ours(False), few, (), 8),
        Method("fivebar: joint chart, order 8, compiled", OURS, in_joints, dense, compiler, 8),
        Method("fivebar.simulate as it comes", OURS, ours_in_full(lambda _: {}), {"through": (0,)}),
        Method("fivebar.simulate with a tolerance", OURS, ours_in_full(to_tolerance), through),
        Method(
            "redundant KKT, order 8, compiled", SAME, redundant_compiled(True), dense, compiler, 8
        ),
        Method("redundant KKT, order 8, VM", SAME, redundant_compiled(False), few, (), 8),
        Method(
            "heyoka, Taylor series, C++ loop",
            "heyoka",
            simulator(heyoka_run, read=read_bars),
            tuple(10.0**-k for k in range(2, 17)),
            (lacks_module("heyoka"),),
        ),
        Method("SciPy LSODA on the closed form", "SciPy", lsoda, tolerances),
        Method(
            "Pinocchio, semi-implicit Euler, Python",
            "Pinocchio",
            simulator(pinocchio_by("semi-implicit Euler")),
            counts(200, 6400),
            pin,
            1,
        ),
        Method(
            "Pinocchio, order 8, Python", "Pinocchio", simulator(pinocchio_by("dop8")), few, pin, 8
        ),
        Method(
            "Pinocchio, order 8, C++ loop",
            "Pinocchio",
            simulator(pinocchio_by("dop8", pinocchio_native)),
            few,
            in_cxx,
            8,
        ),
        Method(
            "Pinocchio, RK4, C++ loop",
            "Pinocchio",
            simulator(pinocchio_by("rk4", pinocchio_native)),
            counts(25, 3200),
            in_cxx,
            4,
        ),
        Method(
            "MuJoCo as it comes, torque held, Python", "MuJoCo", in_mujoco(), counts(200, 6400), mj
        ),
        Method(
            "MuJoCo as it comes, torque held, C loop",
            "MuJoCo",
            in_mujoco(in_c=True),
            counts(200, 6400),
            in_c,
        ),
        Method(
            "MuJoCo tuned, RK4, torque by callback, Python",
            "MuJoCo",
            in_mujoco(tuned=True),
            tuned,
            mj,
        ),
        Method(
            "MuJoCo tuned, RK4, C loop and torque",
            "MuJoCo",
            in_mujoco(tuned=True, in_c=True),
            tuned,
            in_c,
        ),
        Method(
            "MuJoCo tuned, but the torque held over a step",
            "MuJoCo",
            in_mujoco(tuned=True, held=True),
            trap,
            mj,
        ),
        Method(
            "MuJoCo tuned, but tied by a body of 1 mg",
            "MuJoCo",
            in_mujoco(tuned=True, light=True),
            trap,
            mj,
        ),
        Method(
            "Drake as it comes, C++ loop",
            "Drake",
            simulator(drake_as_it_comes),
            counts(100, 3200),
            drake,
            1,
        ),
        Method(
            "Drake tuned, bushing, C++ loop",
            "Drake",
            simulator(drake_bushing),
            tuple(DRAKE_BUSHINGS),
            drake,
        ),
        Method(
            "Drake's matrices, order 8, Python", "Drake", simulator(drake_by_hand), few, drake, 8
        ),
        Method(
            "Drake's matrices, without the Python loop",
            "Drake",
            simulator(drake_by_hand, alone=True),
            few,
            drake,
            8,
        ),
        Method(
            "Exudyn as it comes, C++ loop",
            "Exudyn",
            simulator(exudyn_as_it_comes, read=tuple),
            counts(50, 6400),
            exu,
            2,
        ),
        Method(
            "Exudyn tuned, stiff springs, C++ loop",
            "Exudyn",
            simulator(exudyn_springs, read=read_springs),
            tuple(EXUDYN_SPRINGS),
            exu,
        ),
    )


def on(problems: Iterable[str], methods: Iterable[Method]) -> tuple[Method, ...]:
    """The methods, tried on these problems only."""
    return tuple(
        m if isinstance(m.knobs, dict) else replace(m, knobs=dict.fromkeys(problems, m.knobs))
        for m in methods
    )


def chart() -> Chart:
    rows = (
        dict(y="error", ylabel="largest error of an active joint after 2 s (rad)", ceiling=LOST),
        dict(y="gap", ylabel="gap of the loop (m)", ceiling=1e-2, floor=1e-18),
    )
    levels = {"error": (1e-3, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12)}
    return Chart(
        name="simulators",
        title=(
            "The five-bar in heyoka, MuJoCo, Pinocchio, Drake, Exudyn, SciPy and fivebar, positions"
            " in pylinkage"
        ),
        reading=(
            "Each point is a number of steps, a tolerance or a stiffness. Of the peers, one way as"
            " their Python users run them, one tuned: an integrator of high order, torques at every"
            " stage, MuJoCo as `fivebar export` ties its loop, in Drake and Exudyn what ties it"
            " searched for each point. Names say where the loop runs: of MuJoCo and Pinocchio also"
            " in C and C++, compiled against their wheels, so that no Python is in those times;"
            " Drake's wheel has no headers: what its calls from Python take without the loop around"
            " them. heyoka integrates the very equations of our four bars. Drake's continuous"
            " plants know no constraints: a stiff bushing, or multipliers by hand on its matrices."
            " Exudyn's explicit integrators neither: stiff springs as distal bars. Traps, set on"
            " purpose: the torque held over a step, and a tiny body in the loop, both for MuJoCo as"
            " exported otherwise; Baumgarte gains of 1/step are on the chart integrators; pylinkage"
            " takes the branch nearest to the last pose, at any turn between them. The constrained"
            " equations through fivebar's compiler tell what compiling gains from what the choice"
            " of coordinates gains. Robots at once: the same steps in array libraries on this"
            " machine's processor; nothing here ran on a GPU."
        ),
        problems={name: motion.words for name, motion in DRIVEN.items()}
        | {POSITIONS: TURNING, at_once.STEPS: AT_ONCE, at_once.ROBOTS: NUMBER},
        methods=on(DRIVEN, simulated()) + on((POSITIONS,), branches.methods()) + at_once.methods(),
        step=lambda count: DURATION / count,
        excluded=(SAME,),
        panels=(
            *(
                tuple(
                    Panel(
                        p,
                        motion.words,
                        xlabel="time for 2 s of motion (s)",
                        levels=levels.get(row["y"], ()),
                        rounding=ROUNDING[p],
                        **row,
                    )
                    for p, motion in DRIVEN.items()
                )
                for row in rows
            ),
            (
                Panel(
                    POSITIONS,
                    TURNING,
                    ylabel="largest error of a position (m)",
                    xlabel="time of a pose (s)",
                    levels=(1e-9,),
                    ceiling=1e-3,
                ),
                Panel(
                    POSITIONS,
                    "branches, by the turn between poses",
                    y="wrong",
                    ylabel="share of wrong branches (none: 0.001)",
                    x="knob",
                    xlabel="turn of the cranks from pose to pose (°)",
                    floor=1e-3,
                ),
            ),
            (
                Panel(
                    at_once.STEPS,
                    AT_ONCE,
                    ylabel="largest error of an active joint after 0.5 s (rad)",
                    xlabel="time for 0.5 s of one robot (s)",
                    levels=(1e-4, 1e-8),
                    ceiling=LOST,
                    rounding=1e-15,
                ),
                Panel(
                    at_once.ROBOTS,
                    NUMBER,
                    y="seconds",
                    ylabel="time of a step of one robot (s)",
                    x="robots",
                    xlabel="robots at once",
                ),
            ),
        ),
        limit=300.0,  # the loop around Pinocchio is compiled once, half a minute of a free core
    )
