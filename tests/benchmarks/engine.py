"""Compiled models against C written by hand, ratios of one run: `python -m tests.benchmarks.engine [--quick]`."""

import ctypes
import sys

import casadi
import numpy as np

import fivebar as fb
from fivebar.models.charts import CHARTS
from fivebar.models.compiled import Buffered, compiled
from fivebar.models.machine_code import library
from fivebar.study.speed_accuracy.charts.fixed_steps import propagate
from fivebar.study.speed_accuracy.machine import lacks_module
from tests.benchmarks.simulators import chart as simulators
from tests.benchmarks.simulators.heyoka import heyoka_run
from tests.benchmarks.simulators.mujoco_pinocchio import pinocchio_native
from tests.benchmarks.simulators.native import lacks_cxx_compiler, lacks_headers
from tests.benchmarks.speed import seconds

RIGHT_SIDE = """
#include <math.h>
static const double l1 = 0.09, l2 = 0.09, half = 0.059, z = 0.002, m = 0.5;
static void leg(double x, double y, double w, double *u, double *v) {
    double s = x * x + y * y, t = l1 + l2, h = 0.5 * w * sqrt((t * t - s) * s), k = 1 / (s * l1);
    u[0] = (0.5 * s * x - h * y) * k;
    u[1] = (0.5 * s * y + h * x) * k;
    k = 1 / (s * l2);
    v[0] = (0.5 * s * x + h * y) * k;
    v[1] = (0.5 * s * y - h * x) * k;
}
/* n small Euler steps of the end-effector in task coordinates, working modes (-1, -1), no torque: each waits for the
   one before, as in an integration. */
void chain(long n, double *s) {
    for (long i = 0; i < n; i++) {
        double u1[2], v1[2], u2[2], v2[2];
        leg(s[0] + half, s[1], -1, u1, v1);
        leg(s[0] - half, s[1], -1, u2, v2);
        double s1 = u1[0] * v1[1] - u1[1] * v1[0], s2 = u2[0] * v2[1] - u2[1] * v2[0];
        double b1 = l1 * s1, b2 = l1 * s2;
        double q1 = (v1[0] * s[2] + v1[1] * s[3]) / b1, q2 = (v2[0] * s[2] + v2[1] * s[3]) / b2;
        double w1 = v1[0] * (s[3] - l1 * u1[0] * q1) - v1[1] * (s[2] + l1 * u1[1] * q1);
        double w2 = v2[0] * (s[3] - l1 * u2[0] * q2) - v2[1] * (s[2] + l1 * u2[1] * q2);
        double r1 = -l1 * (u1[0] * v1[0] + u1[1] * v1[1]) * q1 * q1 - w1 * w1 / l2;
        double r2 = -l1 * (u2[0] * v2[0] + u2[1] * v2[1]) * q2 * q2 - w2 * w2 / l2;
        double k1 = m / z * b1 * b1, k2 = m / z * b2 * b2;
        double g = v1[0] * v2[0] + v1[1] * v2[1], d = v1[0] * v2[1] - v1[1] * v2[0];
        double det = 1 / (d * d + k1 + k2 + k1 * k2);
        double mu1 = ((1 + k2) * r1 - g * r2) * det, mu2 = ((1 + k1) * r2 - g * r1) * det;
        double ax = v1[0] * mu1 + v2[0] * mu2, ay = v1[1] * mu1 + v2[1] * mu2;
        s[0] += 1e-6 * s[2];
        s[1] += 1e-6 * s[3];
        s[2] += 1e-6 * ax;
        s[3] += 1e-6 * ay;
    }
}
"""


def right_side(n, repeats):
    """(VM : C, compiled : C, largest difference) of the right side in the task chart, n times in a chain."""
    robot, begin = fb.FiveBar(), np.array([0.05, 0.085, 0.2, -0.1])
    state = casadi.SX.sym("state", 4)
    rates = CHARTS["task"].rates(robot, (state[0], state[1]), (state[2], state[3]), (-1, -1))
    acc = fb.forward_dynamics(rates, casadi.SX.zeros(2)).xi_ddot
    (after,) = casadi.cse([state + 1e-6 * casadi.vertcat(state[2], state[3], acc)])
    function = casadi.Function("right", [state], [after]).fold(n)
    end, loop = begin.copy(), ctypes.CDLL(str(library(RIGHT_SIDE))).chain
    pointer = end.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def by_hand():
        end[:] = begin
        loop(ctypes.c_long(n), pointer)

    limit, times = seconds(by_hand, repeats), []
    for jit in (False, True):
        call = Buffered(compiled(function, jit))
        times.append(seconds(lambda call=call: call(begin), repeats) / limit)
        difference = np.abs(call(begin)[0] - end).max()
    return *times, float(difference)


def forced_motion(repeats, tolerance=1e-9):
    """(steps, VM in s, compiled in s) for the 2 s forced motion to `tolerance` rad, order 8, joint chart."""
    robot, chart = fb.FiveBar(), CHARTS["joint"]
    c, c_dot, modes = chart.coordinates(fb.dkm(fb.dgm(robot, (0.0, 0.0)), (0.0, 0.0)))
    modes, start, end = (
        [int(mode) for mode in modes],
        np.array([*c, *c_dot]),
        (-0.441256357912, 0.423177464191),
    )

    def torque(t):
        return 0.02 * casadi.cos(2 * np.pi * t), -0.016 * casadi.cos(2 * np.pi * t)

    for count in range(20, 80, 2):
        function = propagate(robot, chart, modes, "dop8", 2 / count, count, torque)
        call = Buffered(function)
        if np.abs(call(start)[0][:2] - end).max() <= tolerance:
            break
    fast = Buffered(compiled(function, True))
    return count, *(seconds(lambda run=run: run(start), repeats) for run in (call, fast))


def through_type_2(repeats, levels=(1e-5, 1e-6, 1e-7, 1e-8, 1e-9)):
    """{method: shortest times in s to errors of the end, rad, at these levels} of the free motion of 2 s."""
    counts, finer = (
        (range(12, 72, 2), range(12, 72, 4)) if repeats > 1 else (range(12, 90, 14),) * 2
    )
    ways = {
        "four bars, compiled": (simulators.ours(True), counts),
        "four bars, VM": (simulators.ours(False), finer),
        "constrained equations, compiled": (simulators.redundant_compiled(True), counts),
    }
    if not lacks_module("heyoka")():
        prepare = simulators.simulator(heyoka_run, read=simulators.read_bars)
        ways["heyoka"] = prepare, 10.0 ** -np.arange(3, 13, 0.5)
    needs = lacks_module("pinocchio"), lacks_headers, lacks_cxx_compiler
    if repeats > 1 and not any(need() for need in needs):  # compiled half a minute
        ways["Pinocchio, C++ loop"] = (
            simulators.simulator(simulators.pinocchio_by("dop8", pinocchio_native)),
            finer,
        )
    attempts = {
        name: [prepare("through", knob) for knob in knobs]
        for name, (prepare, knobs) in ways.items()
    }
    found = {}
    for name, several in attempts.items():
        errors = np.array([attempt.judge(attempt.call())["error"] for attempt in several])
        times = np.array([seconds(attempt.call, repeats) for attempt in several])
        found[name] = [times[errors <= level].min() for level in levels]
    return found


def closed_loop(repeats):
    """Seconds for 10 s of computed torque at 1 kHz, one RK4 step to a sample, in CasADi's virtual machine."""
    robot, path = fb.FiveBar(), fb.line((0.09, 0.06796322), (0, 0.1), 10.0)
    starts = fb.ikm(fb.igm(robot, [path(0.0)[0]]), (0.0, 0.0))
    controller = fb.ComputedTorque(robot, 100, 20)
    return seconds(
        lambda: fb.simulate_many(robot, controller, path, starts, control_period=1e-3, step=1e-3),
        repeats,
    )


def main(quick=False):
    """Print every figure with its bound."""
    n, repeats = (1000, 1) if quick else (10**5, 15)
    vm, fast, difference = right_side(n, repeats)
    print(f"right side, task chart (largest difference {difference:.1e}):")
    print(f"  CasADi's virtual machine : C by hand          {vm:8.2f}   (bound 6)")
    print(f"  compiled : C by hand                          {fast:8.2f}   (bound 1.3)")
    count, vm, fast = forced_motion(1 if quick else 200)
    print(f"forced motion of 2 s to 1e-9 rad, {count} steps of order 8:")
    print(f"  virtual machine, us                           {1e6 * vm:8.1f}   (bound 250)")
    print(f"  compiled, us                                  {1e6 * fast:8.1f}   (bound 40)")
    print("free motion of 2 s through Type 2, us to 1e-5, 1e-6, 1e-7, 1e-8, 1e-9 rad:")
    for name, times in through_type_2(1 if quick else 60).items():
        print(f"  {name:<44}", *(f"{1e6 * time:8.1f}" for time in times))
    print(
        f"closed loop of 10 s at 1 kHz, VM, ms            {1e3 * closed_loop(repeats):8.1f}   (bound 30)"
    )


if __name__ == "__main__":
    main("--quick" in sys.argv)
