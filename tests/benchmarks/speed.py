"""Ratios of one run on one machine: `python -m tests.benchmarks.speed [--quick]`.

Needs a C compiler: the limit for `dgm` is a compiled loop that does the same.
"""

import ctypes
import statistics
import subprocess
import sys
import time

import numpy as np

import fivebar as fb
from fivebar.models.machine_code import library
from fivebar.models.parameters import parameters_of
from fivebar.study.speed_accuracy.charts.dgm_routes import C_LOOP
from fivebar.study.speed_accuracy.charts.motions import MOTIONS


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
    """Time until the models are there over that of `import numpy`, in fresh interpreters: medians."""
    models = "from fivebar import FiveBar, dgm, igm, dkm2, inverse_dynamics, singularity"
    times = {"import numpy": [], models: []}
    for _ in range(repeats):
        for statement, taken in times.items():
            began = time.perf_counter()
            subprocess.run([sys.executable, "-c", statement], check=True)
            taken.append(time.perf_counter() - began)
    return statistics.median(times[models]) / statistics.median(times["import numpy"])


def task_1(repeats):
    """Seconds for the lab's task 1, 2 s: control 10 ms in Python, step 1 ms."""
    robot = fb.FiveBar()
    controller, reference = (
        fb.ComputedTorque(robot, 100, 20),
        fb.line((0.09, 0.06796322), (0, 0.1), 2.0),
    )
    fb.simulate(robot, controller, reference)
    return seconds(lambda: fb.simulate(robot, controller, reference), repeats)


def bars_against_joint(repeats):
    """Cost of an RK4 step of the four bars over one of chart="joint", and of a free motion through singularities."""
    robot = fb.FiveBar()
    calm = fb.dkm(fb.dgm(robot, (0.0, 0.0)), (0.05, 0.05))
    wild = fb.ikm(fb.igm(robot, (0.01, 0.12), working=(1, -1)), (0.02, -0.30))

    def run(start, chart):
        return lambda: fb.simulate(
            robot,
            duration=2.0,
            start=start,
            step=1e-4,
            integrator=fb.Integrator(method="rk4", chart=chart),
        )

    joint = seconds(run(calm, "joint"), repeats)
    return seconds(run(calm, "auto"), repeats) / joint, seconds(run(wild, "auto"), repeats) / joint


def free_motion(repeats):
    """(s, error in m) of the free motion of 2 s through Type 2 by `simulate` with its defaults."""
    motion = MOTIONS["through"]
    start, robot = motion.begin(), fb.FiveBar()
    run = fb.simulate(robot, duration=2.0, start=start)
    spent = seconds(lambda: fb.simulate(robot, duration=2.0, start=start), 10 * repeats)
    return spent, float(np.linalg.norm(run.xi[-1] - motion.end))


def many_robots(count):
    """Time of `simulate` over that of `simulate_many`, for task 1 with random lengths and masses, in equal steps.

    A loop over `simulate` is timed on some of the robots; compiling is not: it is done once for all numbers of runs.
    """
    rng = np.random.default_rng(0)
    nominal = np.array(parameters_of(fb.FiveBar()))
    robots = [
        fb.FiveBar(*(nominal * rng.uniform(0.97, 1.03, len(nominal))).tolist())
        for _ in range(count)
    ]
    controller, reference = (
        fb.ComputedTorque(fb.FiveBar(), 100, 20),
        fb.line((0.09, 0.066), (0, 0.1), 2.0),
    )
    options = dict(step=0.01, integrator=fb.Integrator("dop8", jit=True))
    fb.simulate_many(robots[:128], controller, reference, **options)
    fb.simulate_many(robots[: count % 128 or 128], controller, reference, **options)
    together = seconds(lambda: fb.simulate_many(robots, controller, reference, **options), 1)
    some = robots[: max(count // 50, 1)]
    fb.simulate(robots[0], controller, reference)
    one_by_one = seconds(
        lambda: [fb.simulate(robot, controller, reference) for robot in some], 1
    ) / len(some)
    return one_by_one * count / together, together


def press(n, repeats):
    """Seconds for n crank angles of the six-bar press, positions to driving torque."""
    from fivebar.linkages import GRAVITY, REPAIRED, driving_torque, move
    from fivebar.linkages.six_bar_press import SPEED

    angles = np.linspace(0, 20, n)
    return seconds(
        lambda: driving_torque(move(REPAIRED, angles, SPEED), {"E": (0.0, 1e5)}, GRAVITY), repeats
    )


def main(quick=False):
    """Print every ratio with its bound."""
    n, repeats = (10**4, 1) if quick else (10**6, 9)
    ratio, difference = dgm_against_c(n, repeats)
    calm, wild = bars_against_joint(repeats)
    free, error = free_motion(repeats)
    robots = 256 if quick else 10**4
    ratio_many, together = many_robots(robots)
    for what, value, bound in (
        (f"dgm of {n} poses, NumPy : C -O3 (they differ by {difference:.1e} m)", ratio, 2.5),
        ("the models : import numpy", import_ratio(1 if quick else 4 * repeats), 1.3),
        ("task 1 of 2 s simulated, ms", 1e3 * task_1(repeats), 50),
        (f"press torque at {n // 10} crank angles, ms", 1e3 * press(n // 10, repeats), 60),
        ('step of RK4 in the four bars : chart="joint", regular motion', calm, 2),
        ("the same through singularities", wild, 2),
        (
            f"free motion of 2 s through Type 2 by simulate, ms (error {error:.1e} m)",
            1e3 * free,
            1.5,
        ),
        (
            f"{robots} robots one by one : by simulate_many, in {together:.1f} s (at least)",
            ratio_many,
            50,
        ),
    ):
        print(f"{what:<75} {value:8.2f}   (bound {bound:g})")


if __name__ == "__main__":
    main("--quick" in sys.argv)
