"""The forced motion, one through Type 2, and turning cranks in other simulators and here: errors against time."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ...._backend import wrap
from ....models.charts import Joint
from ....models.compiled import Buffered, compiled
from ....models.geometry import dgm
from ....simulation.steps import model_functions, runge_kutta
from ...pitfalls.integrators import adaptive
from ...pitfalls.redundant import closure, redundant_state
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel
from ..rivals.drake import DRAKE_BUSHINGS, drake_as_it_comes, drake_bushing, drake_by_hand
from ..rivals.exudyn import EXUDYN_SPRINGS, exudyn_as_it_comes, exudyn_springs
from ..rivals.mujoco_pinocchio import MUJOCO_STIFFNESS, mujoco_run, pinocchio_run, read
from . import branches
from .constrained import multipliers
from .integrators import counts, fixed_steps, kept
from .motions import DRIVEN, DURATION, ROBOT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from .motions import DrivenMotion

SAME = "constrained equations, fivebar's compiler"
REPEATS = 5  # of what is timed alone
LOST, FAR = 0.3, 100.0  # rad
POSITIONS, TURNING = "positions", "cranks that turn, 90° apart"
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


def ours(method: str, jit: bool) -> Callable[..., Attempt]:
    """prepare of our fixed steps in the joint chart, the torque read at every stage."""

    def prepare(problem, count):
        judge = judged(problem)
        call, modes = fixed_steps(DRIVEN[problem], Joint(), method, count, jit)

        def judge_end(end):
            return judge((end[:2], _gap(end[:2], dgm(ROBOT, np.nan_to_num(end[:2]), modes[0], unreachable="nan").xi)))

        return Attempt(call, judge_end)

    return prepare


def ours_auto(problem: str, count: int) -> Attempt:
    """fivebar.simulate; for a motion without torque, which it would hold over a step."""
    judge = judged(problem)
    return Attempt(kept(DRIVEN[problem], count), lambda run: judge((run.q[-1], _gap(run.q[-1], run.xi[-1]))))


def redundant_compiled(jit: bool) -> Callable[..., Attempt]:
    """prepare of order 8 on the constrained equations in (x, y, q1, q2), through the same compiler as ours."""

    def prepare(problem, count):
        motion, judge, step = DRIVEN[problem], judged(problem), DURATION / count
        state, t = ca.SX.sym("state", 8), ca.SX.sym("t")

        def slope(stage, fraction):
            return multipliers(stage, motion.torque(t + fraction * step))

        one = ca.Function("step", [state, t], ca.cse([runge_kutta("dop8", step, state, slope)]))
        start = ca.MX.sym("start", 8)
        whole = ca.Function("redundant", [start], [one.fold(count)(start, step * ca.DM(range(count)).T)])
        call, begin = Buffered(compiled(whole, jit)), redundant_state(motion.begin())
        return Attempt(lambda: call(begin)[0], lambda end: judge((end[2:4].copy(), _gap(end[2:4], end[:2]))))

    return prepare


def lsoda(problem: str, rtol: float) -> Attempt:
    """SciPy's LSODA, called with our closed form, which is compiled: what SciPy itself costs."""
    motion, judge = DRIVEN[problem], judged(problem)
    c, c_dot, modes = Joint().coordinates(motion.begin())
    model = Buffered(model_functions(ROBOT, Joint())[0])
    modes, times = np.array(modes, dtype=float), np.array([0.0, DURATION])

    def slope(t, state):
        return model(state, motion.torque(t), modes)[0].copy()

    def judge_end(found):
        if not found.success:
            raise Failed("gives up")
        end = found.states[-1][:2]
        return judge((end, _gap(end, dgm(ROBOT, np.nan_to_num(end), int(modes[0]), unreachable="nan").xi)))

    return Attempt(lambda: adaptive(slope, np.array([*c, *c_dot]), times, "LSODA", rtol, 1e-3 * rtol), judge_end)


def simulator(make: Callable, alone: bool = False, read: Callable = read) -> Callable[..., Attempt]:
    """prepare of a run of `peers`: make (motion, knob) -> (run, step only); alone: timed is only the latter.

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


def mujoco_tuned(motion: DrivenMotion, count: int, **trap: bool) -> tuple:
    return mujoco_run(motion, count, MUJOCO_STIFFNESS[count], **trap)


def pinocchio_by(method: str) -> Callable:
    return lambda motion, count: pinocchio_run(motion, count, method)


def simulated() -> tuple[Method, ...]:
    """Methods of the motions: ours, the same equations otherwise, the simulators."""
    few, tuned, tolerances = counts(6, 128), tuple(MUJOCO_STIFFNESS), tuple(10.0**-k for k in range(3, 13))
    compiler, pin, mj, drake, exu = ("C compiler",), ("pinocchio",), ("mujoco",), ("pydrake",), ("exudyn",)
    trap = {"forced": tuned}
    return (
        Method("fivebar: order 8, compiled", OURS, ours("dop8", True), few, compiler, 8),
        Method("fivebar: order 8, VM", OURS, ours("dop8", False), few, (), 8),
        Method("fivebar.simulate: order 8, auto chart", OURS, ours_auto, {"through": counts(32, 512)}, (), 8),
        Method("redundant KKT, order 8, compiled", SAME, redundant_compiled(True), few, compiler, 8),
        Method("redundant KKT, order 8, VM", SAME, redundant_compiled(False), few, (), 8),
        Method("SciPy LSODA on the closed form", "SciPy", lsoda, tolerances),
        Method("Pinocchio, semi-implicit Euler, Python", "Pinocchio",
               simulator(pinocchio_by("semi-implicit Euler")), counts(200, 6400), pin, 1),
        Method("Pinocchio, order 8, Python", "Pinocchio", simulator(pinocchio_by("dop8")), few, pin, 8),
        Method("Pinocchio, order 8, without the Python loop", "Pinocchio", simulator(pinocchio_by("dop8"), alone=True),
               few, pin, 8),
        Method("Pinocchio, RK4, without the Python loop", "Pinocchio", simulator(pinocchio_by("rk4"), alone=True),
               counts(25, 3200), pin, 4),
        Method("MuJoCo as it comes, torque held", "MuJoCo", simulator(mujoco_run), counts(200, 6400), mj),
        Method("MuJoCo tuned, RK4, torque by callback", "MuJoCo", simulator(mujoco_tuned), tuned, mj),
        Method("MuJoCo tuned, without the Python calls", "MuJoCo", simulator(mujoco_tuned, alone=True), tuned, mj),
        Method("MuJoCo tuned, but the torque held over a step", "MuJoCo", simulator(partial(mujoco_tuned, held=True)),
               trap, mj),
        Method("MuJoCo tuned, but tied by a body of 1 mg", "MuJoCo", simulator(partial(mujoco_tuned, light=True)),
               trap, mj),
        Method("Drake as it comes, ball constraint", "Drake", simulator(drake_as_it_comes), counts(100, 3200),
               drake, 1),
        Method("Drake tuned, bushing, loop in C++", "Drake", simulator(drake_bushing), tuple(DRAKE_BUSHINGS), drake),
        Method("Drake's matrices, order 8, Python", "Drake", simulator(drake_by_hand), few, drake, 8),
        Method("Drake's matrices, without the Python loop", "Drake", simulator(drake_by_hand, alone=True),
               few, drake, 8),
        Method("Exudyn as it comes, generalized alpha", "Exudyn", simulator(exudyn_as_it_comes, read=tuple),
               counts(50, 6400), exu, 2),
        Method("Exudyn tuned, stiff springs, loop in C++", "Exudyn", simulator(exudyn_springs, read=read_springs),
               tuple(EXUDYN_SPRINGS), exu),
    )  # fmt: skip


def on(problems: Iterable[str], methods: Iterable[Method]) -> tuple[Method, ...]:
    """The methods, tried on these problems only."""
    return tuple(
        m if isinstance(m.knobs, dict) else replace(m, knobs=dict.fromkeys(problems, m.knobs)) for m in methods
    )


def chart() -> Chart:
    rows = (
        dict(y="error", ylabel="largest error of an active joint after 2 s (rad)", ceiling=LOST),
        dict(y="gap", ylabel="gap of the loop (m)", ceiling=1e-2, floor=1e-18),
    )
    levels = {"error": (1e-3, 1e-5, 1e-7, 1e-9)}
    return Chart(
        name="simulators",
        title="The five-bar in MuJoCo, Pinocchio, Drake, Exudyn, SciPy and fivebar, its positions in pylinkage",
        reading="Each point is a number of steps, a tolerance or a stiffness. Of the peers, one way as their Python "
        "users run them, "
        "one tuned: an integrator of high order, torques at every stage, and what ties the loop searched for "
        "each point; and that without the Python loop or callback around it, as well as it can be timed from Python. "
        "Drake's continuous plants know no constraints: a stiff bushing, or multipliers by hand on its matrices. "
        "Exudyn's explicit integrators neither: stiff springs as distal bars. Traps, set on purpose: the torque held "
        "over a step, and a tiny body in the loop, both for MuJoCo at the settings that are best without; Baumgarte "
        "gains of 1/step are on the chart integrators; pylinkage takes the branch nearest to the last pose, at any "
        "turn between them. The constrained equations through fivebar's compiler tell what compiling gains from what "
        "the closed form gains.",
        problems={name: motion.words for name, motion in DRIVEN.items()} | {POSITIONS: TURNING},
        methods=on(DRIVEN, simulated()) + on((POSITIONS,), branches.methods()),
        step=lambda count: DURATION / count,
        apart=(SAME,),
        panels=(*(
            tuple(
                Panel(
                    p, motion.words, xlabel="time for 2 s of motion (s)", levels=levels.get(row["y"], ()), each=True,
                    rounding=ROUNDING[p], **row,
                )
                for p, motion in DRIVEN.items()
            )
            for row in rows
        ), (
            Panel(POSITIONS, TURNING, ylabel="largest error of a position (m)", xlabel="time of a pose (s)",
                  levels=(1e-9,), ceiling=1e-3, each=True),
            Panel(POSITIONS, "branches, by the turn between poses", y="wrong",
                  ylabel="share of wrong branches (none: 0.001)", x="knob",
                  xlabel="turn of the cranks from pose to pose (°)", floor=1e-3),
        )),
    )  # fmt: skip
