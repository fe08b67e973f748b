"""Timed paths beside toppra's: times, limits exceeded between its grid points, seconds: `python -m
tests.benchmarks.time_paths [--quick]`.

Regular paths of the lab's robot under torque and joint speed limits. toppra is given the exact q(s), its derivatives
and the inverse dynamics, on an even grid, with constraints as it suggests for accuracy (collocated at both ends of each
interval, "Interpolation") and its trajectory of constant s'' between the grid points.
"""

import sys
import time

import numpy as np

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line, Polynomial

ROBOT, TORQUE, SPEED = fb.FiveBar(), 0.05, 6.0
WAVE = [(-0.05, 0.09), (-0.04, 0.16), (-0.01, 0.03), (0.02, 0.17), (0.04, 0.05), (0.05, 0.11)]
PATHS = {
    "line": Path((Line((0.09, 0.06796322), (0.0, 0.1)),)),
    "circle": Path((Arc((0.0, 0.11), 0.03, 0.0, 2 * np.pi),)),
    "wave": Path((Polynomial.from_bernstein(WAVE, 0.2),)),
    "long way up": Path((Line((-0.02, 0.05), (0.01, 0.158)),)),
}


def joints(path, s):
    """q, q_s, q_ss (n, 2) each."""
    xi, xi_s, xi_ss, _ = path(s)
    acc = fb.ikm2(fb.ikm(fb.igm(ROBOT, xi), xi_s), xi_ss)
    return ROBOT.continuous(acc.rates.pose.q), acc.rates.q_dot, acc.q_ddot


def by_toppra(path, count):
    """(duration, seconds it took, largest share of a torque's and a joint speed's limit at 100 x finer places)."""
    import toppra
    import toppra.algorithm
    import toppra.constraint
    from toppra.interpolator import AbstractGeometricPath

    class Joints(AbstractGeometricPath):
        dof, path_interval, waypoints = 2, np.array([0.0, path.length]), None

        def __call__(self, s, order=0):
            found = joints(path, np.atleast_1d(np.clip(s, 0.0, path.length)))[order]
            return found if np.ndim(s) else found[0]

    def inverse(q, q_dot, q_ddot):
        return fb.inverse_dynamics(fb.dkm2(fb.dkm(fb.dgm(ROBOT, q), q_dot), q_ddot))

    toppra.setup_logging("ERROR")
    scheme = toppra.constraint.DiscretizationType.Interpolation
    torque = toppra.constraint.JointTorqueConstraint(
        inverse, np.array([[-TORQUE, TORQUE]] * 2), np.zeros(2), scheme
    )
    speed = toppra.constraint.JointVelocityConstraint(np.array([[-SPEED, SPEED]] * 2))
    grid = np.linspace(0.0, path.length, count + 1)
    began = time.perf_counter()
    solver = toppra.algorithm.TOPPRA(
        [torque, speed], Joints(), gridpoints=grid, solver_wrapper="seidel"
    )
    push, pace, _ = solver.compute_parameterization(0.0, 0.0)
    took = time.perf_counter() - began
    x = pace**2
    duration = float((2 * np.diff(grid) / (pace[1:] + pace[:-1])).sum())
    inside = (np.arange(100) + 0.5) / 100
    s = (grid[:-1, None] + np.diff(grid)[:, None] * inside).ravel()
    u = np.repeat(np.diff(x) / np.diff(grid) / 2, 100)
    rate = np.sqrt((x[:-1, None] + np.diff(x)[:, None] * inside).ravel())[:, None]
    q, q_s, q_ss = joints(path, s)
    tau = inverse(q, q_s * rate, q_ss * rate**2 + q_s * u[:, None])
    return duration, took, np.abs(tau).max() / TORQUE, np.abs(q_s * rate).max() / SPEED


def by_fivebar(path):
    """The same, and the lower bound."""
    began = time.perf_counter()
    motion = fb.time_path(ROBOT, path, constraints=fb.Constraints(torque=TORQUE, joint_speed=SPEED))
    took = time.perf_counter() - began
    inside = (np.arange(100) + 0.5) / 100
    t = (motion.times[:-1, None] + np.diff(motion.times)[:, None] * inside).ravel()
    acc = motion.accelerations(t)
    shares = np.abs(fb.inverse_dynamics(acc)).max() / TORQUE, np.abs(acc.rates.q_dot).max() / SPEED
    return motion.duration, took, *shares, motion.lower_bound, len(motion.bent)


def _print(name, by, count, figures, bound):
    duration, took, torque, speed = figures
    over = duration / bound - 1
    print(
        f"{name:13} {by:8}{count:9d}   {duration:.6f}   {over:+13.3e}   {torque:.9f}      {speed:.9f}     {took:.2f}"
    )


def main(quick=False):
    """{path: (ours, toppra's, lower bound)}, (time, seconds it took, shares of the limits) each; prints a table."""
    print(
        "path          by       intervals  time (s)    over the bound   torque / limit   speed / limit   took (s)"
    )
    found = {}
    for name, path in list(PATHS.items())[: 2 if quick else None]:
        *ours, bound, count = by_fivebar(path)
        _print(name, "fivebar", count, ours, bound)
        for intervals in (200,) if quick else (200, 1000, 4000):
            theirs = by_toppra(path, intervals)
            _print("", "toppra", intervals, theirs, bound)
        found[name] = ours, theirs, bound
    return found


if __name__ == "__main__":
    main("--quick" in sys.argv)
