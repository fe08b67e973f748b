"""Many robots at once, each thrown with its own rates: our steps in NumPy, JAX, PyTorch and compiled,
MuJoCo on all cores, MuJoCo Warp and Newton (pip install mujoco-warp newton).
"""

from __future__ import annotations

import os
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import fivebar as fb
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Failed, Method
from fivebar.study.speed_accuracy.charts.integrators import counts
from fivebar.study.speed_accuracy.machine import lacks_c_compiler, lacks_module

from .motions import ROBOT
from .mujoco_pinocchio import joints

STEPS, ROBOTS = "so many steps", "so many robots"
DURATION = 0.5  # s
USUAL_ROBOTS, USUAL_STEPS = 1024, 50
JUDGED = 5  # robots


@cache
def thrown(count):
    """Rates (count,) of robots at home: the fastest two passes half a turn."""
    scale = np.linspace(0.5, 2.0, count)[:, None]
    return fb.dkm(fb.dgm(ROBOT, np.zeros((count, 2))), scale * (1.0, -0.5))


@cache
def ends(count):
    """(numbers of the robots that are judged, their joint angles at the end), to 1e-12 a step."""
    judged = np.unique(np.linspace(0, count - 1, JUDGED).astype(int))
    starts = [fb.dkm(fb.dgm(ROBOT, (0.0, 0.0)), thrown(count).q_dot[k]) for k in judged]
    runs = [fb.simulate(ROBOT, duration=DURATION, start=start) for start in starts]
    return judged, np.stack([run.q[-1] for run in runs])


def sizes(problem, knob):
    """(robots, steps) of an attempt."""
    return (USUAL_ROBOTS, knob) if problem == STEPS else (knob, USUAL_STEPS)


def attempt(problem, call, count, steps):
    """call () -> active joints (count, 2) at the end; its time is that of one robot or of its step."""

    def judge(q):
        judged, expected = ends(count)
        error = np.abs(np.asarray(q, dtype=float)[judged] - expected).max()
        if not np.isfinite(error):
            raise Failed("nan")
        return {"error": float(error), "robots": count}

    return Attempt(call, judge, per=count if problem == STEPS else count * steps)


def bars(xp, count, dtype=np.float64):
    """States (count, 8) of the thrown robots."""
    begin = fb.compile(ROBOT, ["q", "q_dot"], ["state"], to=np)
    state = begin(np.zeros((count, 2)), np.ascontiguousarray(thrown(count).q_dot))
    return xp.asarray(state.astype(dtype))


def eager(library):
    """prepare of a loop in Python over steps of all robots."""

    def prepare(problem, knob):
        xp = __import__(library)
        count, steps = sizes(problem, knob)
        step = fb.stepper(ROBOT, DURATION / steps, to=xp)
        start, tau = bars(xp, count), xp.asarray(np.zeros((count, 2)))

        def call():
            state = start
            for _ in range(steps):
                state = step(state, tau)
            return np.asarray(state)[:, :4:2]

        return attempt(problem, call, count, steps)

    return prepare


def scanned(dtype):
    """prepare of JAX's loop, compiled before it is timed."""

    def prepare(problem, knob):
        import jax

        jax.config.update("jax_enable_x64", True)
        count, steps = sizes(problem, knob)
        step = fb.stepper(ROBOT, DURATION / steps, to=jax.numpy)
        start = bars(jax.numpy, count, dtype)
        tau = jax.numpy.zeros((count, 2), dtype=dtype)
        loop = jax.jit(lambda state: jax.lax.fori_loop(0, steps, lambda _, s: step(s, tau), state))
        loop(start)
        return attempt(problem, lambda: np.asarray(loop(start))[:, :4:2], count, steps)

    return prepare


def many(problem, knob):
    """simulate_many, whose runs hold every row."""
    count, steps = sizes(problem, knob)
    options = {"step": DURATION / steps, "control_period": DURATION / steps}
    integrator = fb.Integrator("dop8", jit=True)
    idle = fb.PD(ROBOT, 0.0, 0.0)
    still = fb.line((0.09, 0.068), (0.09, 0.0679), DURATION)

    def call():
        runs = fb.simulate_many(
            ROBOT, idle, still, thrown(count), duration=DURATION, integrator=integrator, **options
        )
        return np.stack([run.q[-1] for run in runs])

    return attempt(problem, call, count, steps)


def exported(steps, tuned):
    """MuJoCo's model; tuned: as `fivebar export` gives it, by RK4."""
    import mujoco

    start = fb.dgm(ROBOT, (0.0, 0.0))
    model = mujoco.MjModel.from_xml_string(
        fb.export(ROBOT, "mjcf", start=start, step=DURATION / steps)
    )
    if not tuned:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    return model


def starts_in(model, count):
    """qpos (count, nq) and qvel (count, nv)."""
    q, q_dot = joints(fb.dkm(fb.dgm(ROBOT, (0.0, 0.0)), (0.0, 0.0)))
    rates = thrown(count)
    turning = np.empty((count, 4))
    turning[:, ::2], turning[:, 1::2] = rates.q_dot, rates.q_passive_dot
    whole = np.hstack([turning, rates.xi_dot])
    return np.tile(q[: model.nq], (count, 1)), whole[:, : model.nv]


def rollout(problem, knob):
    """MuJoCo's own loop over robots and steps, on all cores."""
    import mujoco
    from mujoco.rollout import Rollout

    count, steps = sizes(problem, knob)
    model = exported(steps, True)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    qpos, qvel = starts_in(model, count)
    states = np.empty((count, mujoco.mj_stateSize(model, kind)))
    data = mujoco.MjData(model)
    for k in range(count):
        data.qpos[: qpos.shape[1]], data.qvel[:] = qpos[k], qvel[k]
        mujoco.mj_getState(model, data, states[k], kind)
    threads = [mujoco.MjData(model) for _ in range(os.cpu_count())]

    def call():
        with Rollout(nthread=len(threads)) as several:
            found, _ = several.rollout(model, threads, states, nstep=steps)
        return found[:, -1, 1 : 1 + model.nq][:, [0, 2]]

    return attempt(problem, call, count, steps)


def warp(problem, knob):
    """MuJoCo Warp by Euler's method, as it has no other for such a loop; on a GPU where there is one."""
    import mujoco
    import mujoco_warp
    import warp as wp

    wp.config.quiet = True
    count, steps = sizes(problem, knob)
    plain = exported(steps, False)
    data = mujoco.MjData(plain)
    mujoco.mj_forward(plain, data)
    model, worlds = mujoco_warp.put_model(plain), mujoco_warp.put_data(plain, data, nworld=count)
    qpos, qvel = starts_in(plain, count)

    def call():
        wp.copy(worlds.qpos, wp.array(qpos.astype(np.float32), dtype=wp.float32))
        wp.copy(worlds.qvel, wp.array(qvel.astype(np.float32), dtype=wp.float32))
        for _ in range(steps):
            mujoco_warp.step(model, worlds)
        return worlds.qpos.numpy()[:, [0, 2]]

    call()  # it compiles its kernels
    return attempt(problem, call, count, steps)


def kamino(problem, knob):
    """Newton's solver for closed loops, of order 1; on a GPU where there is one."""
    import newton
    import warp as wp

    wp.config.quiet = True
    count, steps = sizes(problem, knob)
    one, all_worlds = newton.ModelBuilder(), newton.ModelBuilder()
    text = fb.export(ROBOT, "mjcf", start=fb.dgm(ROBOT, (0.0, 0.0)), step=DURATION / steps)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "robot.xml")
        file.write_text(text, "utf-8")
        one.add_mjcf(str(file))
    all_worlds.replicate(one, count)
    model = all_worlds.finalize()
    rates = model.joint_qd.numpy().reshape(count, -1)
    rates[:, :4:2], rates[:, 1:4:2] = thrown(count).q_dot, thrown(count).q_passive_dot
    model.joint_qd.assign(rates.ravel())
    solver, control = newton.solvers.SolverKamino(model), model.control()

    def call():
        now, after = model.state(), model.state()
        newton.eval_fk(model, model.joint_q, model.joint_qd, now)
        for _ in range(steps):
            solver.step(now, after, control, None, DURATION / steps)
            now, after = after, now
        q, q_dot = wp.zeros_like(model.joint_q), wp.zeros_like(model.joint_qd)
        newton.eval_ik(model, now, q, q_dot)
        return q.numpy().reshape(count, -1)[:, [0, 2]]

    call()  # it compiles its kernels
    return attempt(problem, call, count, steps)


def methods():
    """Methods of the panels about many robots."""
    few = {STEPS: counts(5, 80), ROBOTS: (1, 16, 256, 4096, 65536)}
    fewer = {STEPS: counts(5, 80), ROBOTS: (1, 16, 256, 4096)}
    jax, torch = (lacks_module("jax"),), (lacks_module("torch"),)
    mujoco, mjwarp = (lacks_module("mujoco"),), (lacks_module("mujoco_warp", "mujoco-warp"),)
    newton = (lacks_module("newton"),)
    return (
        Method("fivebar: JAX, float64", OURS, scanned(np.float64), few, jax),
        Method("fivebar: JAX, float32", OURS, scanned(np.float32), few, jax),
        Method("fivebar: PyTorch", OURS, eager("torch"), few, torch),
        Method("fivebar: NumPy", OURS, eager("numpy"), few),
        Method("fivebar.simulate_many, compiled", OURS, many, fewer, (lacks_c_compiler,)),
        Method(
            "MuJoCo as exported, RK4, on all cores",
            "MuJoCo",
            rollout,
            {STEPS: counts(20, 640), ROBOTS: (1, 16, 256, 4096)},
            mujoco,
        ),
        Method("MuJoCo Warp, Euler", "MuJoCo", warp, {ROBOTS: (1, 16)}, mjwarp),
        Method("Newton's Kamino, Euler", "Newton", kamino, {ROBOTS: (1, 16)}, newton),
    )
