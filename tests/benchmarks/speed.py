"""Ratios of one run on one machine: `python -m tests.benchmarks.speed [--quick]`.

Needs a C compiler: the limit for `dgm` is a compiled loop that does the same.
"""

import ctypes
import subprocess
import sys
import time

import numpy as np

import fivebar as fb
from fivebar.models.machine_code import library
from fivebar.study.speed_accuracy.charts.dgm_routes import C_LOOP


def seconds(call, repeats):
    """Median time of a call."""
    times = []
    for _ in range(repeats):
        before = time.perf_counter()
        call()
        times.append(time.perf_counter() - before)
    return float(np.median(times))


def dgm_against_c(n, repeats):
    """(ratio NumPy : C, largest difference) for dgm of n poses."""
    rng = np.random.default_rng(0)
    q = rng.uniform(-0.4, 0.4, (n, 2)) + (0.6, 0.4)
    robot, xi = fb.FiveBar(), np.empty_like(q)
    loop = ctypes.CDLL(str(library(C_LOOP))).dgm
    pointer = ctypes.POINTER(ctypes.c_double)
    arguments = ctypes.c_long(n), q.ctypes.data_as(pointer), xi.ctypes.data_as(pointer)
    in_c = seconds(lambda: loop(*arguments), repeats)
    in_numpy = seconds(lambda: fb.dgm(robot, q).xi, repeats)
    return in_numpy / in_c, float(np.abs(xi - fb.dgm(robot, q).xi).max())


def import_ratio(repeats):
    """Time of `import fivebar` over that of `import numpy`, in fresh interpreters."""
    times = {}
    for module in ("numpy", "fivebar") * 2:
        times[module] = seconds(
            lambda m=module: subprocess.run([sys.executable, "-c", f"import {m}"], check=True), repeats
        )
    return times["fivebar"] / times["numpy"]


def task_1(repeats):
    """Seconds for the lab's task 1, 2 s: control 10 ms in Python, step 1 ms."""
    robot = fb.FiveBar()
    controller, reference = fb.ComputedTorque(robot, 100, 20), fb.line((0.09, 0.06796322), (0, 0.1), 2.0)
    fb.simulate(robot, controller, reference)
    return seconds(lambda: fb.simulate(robot, controller, reference), repeats)


def auto_against_joint(repeats):
    """Cost of a step of chart="auto" over one of chart="joint", and over it on the free motion that keeps switching."""
    robot = fb.FiveBar()
    calm = fb.dkm(fb.dgm(robot, (0.0, 0.0)), (0.05, 0.05))
    wild = fb.ikm(fb.igm(robot, (0.01, 0.12), working=(1, -1)), (0.02, -0.30))

    def run(start, chart):
        return lambda: fb.simulate(robot, duration=2.0, start=start, step=1e-4, chart=chart)

    joint = seconds(run(calm, "joint"), repeats)
    return seconds(run(calm, "auto"), repeats) / joint, seconds(run(wild, "auto"), repeats) / joint


def press(n, repeats):
    """Seconds for n crank angles of the six-bar press, positions to driving torque."""
    from fivebar.linkages import GRAVITY, REPAIRED, driving_torque, move
    from fivebar.linkages.six_bar_press import SPEED

    angles = np.linspace(0, 20, n)
    return seconds(lambda: driving_torque(move(REPAIRED, angles, SPEED), {"E": (0.0, 1e5)}, GRAVITY), repeats)


def main(quick=False):
    """Print every ratio with its bound."""
    n, repeats = (10**4, 1) if quick else (10**6, 9)
    ratio, difference = dgm_against_c(n, repeats)
    calm, wild = auto_against_joint(repeats)
    for what, value, bound in (
        (f"dgm of {n} poses, NumPy : C -O3 (they differ by {difference:.1e} m)", ratio, 2.5),
        ("import fivebar : import numpy", import_ratio(repeats), 1.3),
        ("task 1 of 2 s simulated, ms", 1e3 * task_1(repeats), 50),
        (f"press torque at {n // 10} crank angles, ms", 1e3 * press(n // 10, repeats), 60),
        ('step in chart "auto" : "joint", regular motion', calm, 1.5),
        ('step in chart "auto" : "joint", free motion through singularities', wild, 1.5),
    ):
        print(f"{what:<75} {value:8.2f}   (bound {bound:g})")


if __name__ == "__main__":
    main("--quick" in sys.argv)
