"""Array libraries in one run: `python -m tests.benchmarks.arrays [--quick]`.

Forward dynamics of 10⁶ states in NumPy, JAX, PyTorch and compiled C; 10⁵ closed loops of 2 s at 1 kHz in JAX, whole,
and in NumPy and PyTorch a hundredth of their steps, which all cost the same.
"""

import sys
import time

import casadi
import numpy as np

import fivebar as fb
from fivebar.models.machine_code import machine_code
from tests.benchmarks.speed import seconds

ROBOT = fb.FiveBar()
MODEL = ROBOT, ["q", "q_dot", "tau"], ["xi", "q_ddot", "xi_ddot"]
PERIOD, DURATION = 1e-3, 2.0
CONTROLLER = fb.ComputedTorque(ROBOT, 100, 20)
REFERENCE = fb.line((0.09, 0.068), (0.0, 0.1), DURATION)


def jax():
    """JAX with float64."""
    import jax

    jax.config.update("jax_enable_x64", True)
    return jax


def dynamics(count, repeats):
    """{library: s for so many states}, and the largest difference from the models in NumPy."""
    import torch

    rng = np.random.default_rng(0)
    arrays = [rng.uniform(-1, 1, (count, 2)) * (0.4, 0.4) + 0.2 for _ in range(3)]
    q, q_dot, tau = arrays
    library = jax()
    in_jax = library.jit(fb.compile(*MODEL, to=library.numpy))
    in_torch = torch.compile(fb.compile(*MODEL, to=torch))
    in_numpy = fb.compile(*MODEL, to=np)
    in_c = machine_code(fb.compile(*MODEL).map(count, "thread", 2))
    ours = [library.numpy.asarray(each) for each in arrays]
    tensors = [torch.asarray(each) for each in arrays]
    columns = [casadi.DM(each.T) for each in arrays]
    calls = {
        "the models in NumPy": lambda: (
            fb.forward_dynamics(fb.dkm(fb.dgm(ROBOT, q), q_dot), tau).xi_ddot
        ),
        "to=numpy": lambda: in_numpy(*arrays),
        "to=jax.numpy, jit": lambda: library.block_until_ready(in_jax(*ours)),
        "to=torch, compiled": lambda: in_torch(*tensors),
        "C": lambda: in_c(*columns),
    }
    expected = calls["the models in NumPy"]()
    differences = []
    for name in list(calls)[1:]:
        found = np.asarray(calls[name]()[2])  # once, so that nothing is compiled when it is timed
        found = found.T if found.shape != expected.shape else found
        differences.append(float(np.abs(found - expected).max()))
    return {name: seconds(call, repeats) for name, call in calls.items()}, max(differences)


def loops(count):
    """{library: s for so many closed loops}, and the largest error at their end, m."""
    import torch

    times = np.arange(round(DURATION / PERIOD)) * PERIOD
    target = CONTROLLER.target(times, REFERENCE)
    rows = target.rates.pose.q, target.rates.q_dot, target.q_ddot
    begin = fb.compile(ROBOT, ["q", "q_dot"], ["state"], to=np)
    pushed = np.random.default_rng(1).uniform(-0.3, 0.3, (count, 2))  # rad/s, at the start
    state = begin(np.tile(rows[0][0], (count, 1)), pushed)
    library = jax()
    step = fb.stepper(ROBOT, PERIOD, to=library.numpy, controller=CONTROLLER)
    whole = library.jit(
        lambda state, rows: library.lax.scan(lambda s, row: (step(s, *row)[0], None), state, rows)[
            0
        ]
    )
    ours = library.numpy.asarray(state), tuple(map(library.numpy.asarray, rows))
    whole = whole.lower(*ours).compile()
    before = time.perf_counter()
    end = np.asarray(whole(*ours))
    taken = {"to=jax.numpy": time.perf_counter() - before}
    for xp in (np, torch):
        one = fb.stepper(ROBOT, PERIOD, to=xp, controller=CONTROLLER)
        some, part = xp.asarray(state), max(len(times) // 100, 1)
        before = time.perf_counter()
        for row in zip(*(each[:part] for each in rows)):
            some, _ = one(some, *map(xp.asarray, row))
        taken[f"to={xp.__name__}"] = (time.perf_counter() - before) * len(times) / part
    read = fb.compile(ROBOT, ["state"], ["xi"], to=np)
    return taken, float(np.abs(read(end) - REFERENCE(DURATION)[0]).max())


def main(quick=False):
    states, robots = (10**4, 20) if quick else (10**6, 10**5)
    taken, difference = dynamics(states, 3 if quick else 7)
    fastest = taken["to=jax.numpy, jit"]
    print(f"forward dynamics of {states} states; the same to {difference:.1e}")
    for name, value in taken.items():
        print(f"  {name:22} {value:9.4g} s, {value / fastest:5.2f} of JAX's")
    taken, error = loops(robots)
    fastest = taken["to=jax.numpy"]
    print(
        f"{robots} closed loops of {DURATION:g} s at {1 / PERIOD:g} Hz; error at the end {error:.1e} m"
    )
    for name, value in taken.items():
        print(f"  {name:22} {value:9.4g} s, {value / fastest:5.2f} of JAX's")


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
