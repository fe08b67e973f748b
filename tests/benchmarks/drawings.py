"""Random drawings timed by `time_path`, beside toppra: `python -m tests.benchmarks.drawings [COUNT]`.

Strokes are polylines and curves with blends of 5 um to 1 mm, on four robots, with and without a tool, under limits of
all kinds. A gap is duration / lower bound - 1. toppra is measured in the same run where it has the limits: torques, joint
speeds and accelerations. It is given the exact q(s) with derivatives, a grid of so many intervals a piece, and
constraints as it suggests for accuracy (collocated at both ends of each interval, "Interpolation"). By how much its
motion exceeds its limits is looked for between its grid points. Times are of the processor: of ours all of the call, of
toppra's without q(s).

The chart `least-time` of `python -m tests.benchmarks.charts` shows gaps against times of some of them.
"""

import argparse
import time
import warnings
from functools import lru_cache
from importlib.util import find_spec

import numpy as np

import fivebar as fb
from fivebar.models.named_robots import ROBOTS as NAMED
from fivebar.paths.curve import Path
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Chart, Failed, Method, Panel

UNEQUAL = fb.FiveBar(l11=0.11, l12=0.14, l21=0.08, l22=0.12, d=0.09, zz1=0.003, zz2=0.0015, m=0.7)
TOOL = fb.Tool(1, 0.012, 0.006)


def _weighing(name):
    """A named robot, whose inertias nobody gave, with some."""
    robot = NAMED[name].robot
    return fb.FiveBar(robot.l11, robot.l12, robot.l21, robot.l22, robot.d, 1e-3, 1e-3, 0.2)


# name -> (robot, working modes, centre and half width of a square, m, usual torque, N m)
ROBOTS = {
    "AMORO": (fb.FiveBar(), (-1, -1), (0.0, 0.105), 0.025, 0.05),
    "unequal": (UNEQUAL, (1, -1), (0.0, 0.14), 0.025, 0.3),
    "plotclock": (_weighing("plotclock"), (1, -1), (0.0, 0.05), 0.012, 0.02),
    "reprapfirmware": (_weighing("reprapfirmware"), (1, -1), (0.0, 0.2), 0.05, 0.1),
}


def random_drawing(rng, centre, width):
    """A Path of 1 to 5 strokes of 2 to 12 points, blended by 5 um to 1 mm at most."""
    deviation = 10 ** rng.uniform(np.log10(5e-6), -3)
    pieces, pen = [], []
    for _ in range(rng.integers(1, 6)):
        points = np.array(centre) + rng.uniform(-width, width, (rng.integers(2, 13), 2))
        stroke = fb.path(points, deviation=deviation, curvature=bool(rng.integers(2)))
        if pieces:
            travel = fb.path([pieces[-1].end, stroke.pieces[0].start])
            pieces += travel.pieces
            pen += [False] * len(travel.pieces)
        pieces += stroke.pieces
        pen += [True] * len(stroke.pieces)
    return Path(tuple(pieces), pen=tuple(pen))


def random_limits(rng, torque):
    """Limits of one or several kinds, at random."""
    speed = float(10 ** rng.uniform(-1.3, -0.3))
    acceleration = float(10 ** rng.uniform(-0.5, 1.0))
    held = torque * float(rng.uniform(0.5, 3.0))
    motor = fb.Motor(2 * held, float(rng.uniform(4.0, 30.0)))
    kinds = [
        {"speed": speed, "acceleration": acceleration},
        {"speed": speed, "acceleration": acceleration, "torque": held},
        {"torque": held},
        {"torque": held, "joint_speed": float(rng.uniform(1.0, 8.0))},
        {
            "joint_speed": float(rng.uniform(1.0, 8.0)),
            "joint_acceleration": float(rng.uniform(5, 100)),
        },
        {"motors": motor, "speed": speed},
    ]
    return kinds[rng.integers(len(kinds))]


def cases(count):
    """Yield (name, robot, working modes, path, limits)."""
    names = list(ROBOTS)
    for seed in range(count):
        rng = np.random.default_rng([51, seed])
        name = names[seed % len(names)]
        robot, working, centre, width, torque = ROBOTS[name]
        drawn = random_drawing(rng, centre, width)
        limits = random_limits(rng, torque)
        if rng.random() < 0.3:
            name += " with a tool"
            drawn = TOOL.path(robot, drawn, working)
        yield seed, name, robot, working, drawn, limits


# The chart's drawings; toppra has the limits of all but the last, a star with 20 um blends
CHARTED = {"torque": 24, "torque, joint speed": 22, "joint speed, acceleration": 16, "star": None}
GAPS = 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4
INTERVALS = 5, 10, 20, 40, 80, 160, 320  # of toppra's grid, on a piece
STAR = [(40, 5), (50, 30), (75, 30), (55, 42), (62, 58), (40, 48), (18, 58), (25, 42), (5, 30), (30, 30), (40, 5)]  # fmt: skip
BY_JOINTS = {"torque", "joint_speed", "joint_acceleration"}  # limits that toppra has


def lacks_toppra():
    """None, or what a machine lacks."""
    return None if find_spec("toppra") else "toppra is not installed"


def joints(robot, working, path, s):
    """q, q_s, q_ss (n, 2) each, at places s (n,)."""
    xi, xi_s, xi_ss, _ = path(s)
    acc = fb.ikm2(fb.ikm(fb.igm(robot, xi, working), xi_s), xi_ss)
    return robot.continuous(acc.rates.pose.q), acc.rates.q_dot, acc.q_ddot


def shares(robot, working, path, limits, s, rate, push):
    """The largest share of a limit at places s (n,) of a motion, with s' and s'' there."""
    xi, xi_s, xi_ss, _ = path(s)
    rate, push = rate[:, None], push[:, None]
    rates = fb.ikm(fb.igm(robot, xi, working), xi_s * rate)
    acc = fb.ikm2(rates, xi_ss * rate**2 + xi_s * push)
    values = {"torque": fb.inverse_dynamics(acc)} if "torque" in limits else {}
    values |= {"joint_speed": rates.q_dot, "joint_acceleration": acc.q_ddot}
    return max(np.abs(values[name]).max() / limits[name] for name in limits)


def by_toppra(robot, working, path, limits, intervals):
    """(duration, s of a processor, largest share of a limit between the grid points)."""
    import toppra
    import toppra.algorithm
    import toppra.constraint
    from toppra.interpolator import AbstractGeometricPath

    toppra.setup_logging("ERROR")
    grid = np.unique(np.concatenate([
        np.linspace(low, high, intervals + 1) for low, high in zip(path.knots, path.knots[1:])
    ]))  # fmt: skip
    q, q_s, q_ss = joints(robot, working, path, grid)
    assembly = int(fb.igm(robot, path(0.0)[0], working).assembly)

    class Joints(AbstractGeometricPath):
        dof, path_interval, waypoints = 2, None, None

        def __init__(self, own):
            self.own = own

        def __call__(self, s, order=0):
            table = (q, q_s, q_ss)[order][self.own]
            return np.stack([np.interp(s, grid[self.own], column) for column in table.T], axis=-1)

    def inverse(q, q_dot, q_ddot):
        pose = fb.dgm(robot, q, assembly=assembly)
        return fb.inverse_dynamics(fb.dkm2(fb.dkm(pose, q_dot), q_ddot))

    def both(limit):
        return np.array([[-limit, limit]] * 2)

    scheme = toppra.constraint.DiscretizationType.Interpolation
    kept = []
    if "torque" in limits:
        torque = both(limits["torque"])
        kept.append(toppra.constraint.JointTorqueConstraint(inverse, torque, np.zeros(2), scheme))
    if "joint_speed" in limits:
        kept.append(toppra.constraint.JointVelocityConstraint(both(limits["joint_speed"])))
    if "joint_acceleration" in limits:
        push = both(limits["joint_acceleration"])
        kept.append(toppra.constraint.JointAccelerationConstraint(push, scheme))
    stops = np.searchsorted(grid, [stop.s - 1e-12 for stop in path.stops])
    duration, took, most = 0.0, 0.0, 0.0
    inside = (np.arange(10) + 0.5) / 10
    for first, last in zip(stops, stops[1:]):
        own = slice(first, last + 1)
        began = time.process_time()
        Joints.path_interval = grid[own][[0, -1]]
        solver = toppra.algorithm.TOPPRA(
            kept, Joints(own), gridpoints=grid[own], solver_wrapper="seidel"
        )
        _, pace, _ = solver.compute_parameterization(0.0, 0.0)
        took += time.process_time() - began
        if pace is None:
            raise Failed("finds no motion")
        x, h = pace**2, np.diff(grid[own])
        duration += float((2 * h / (pace[1:] + pace[:-1])).sum())
        s = (grid[own][:-1, None] + h[:, None] * inside).ravel()
        rate = np.sqrt((x[:-1, None] + np.diff(x)[:, None] * inside).ravel())
        push = np.repeat(np.diff(x) / h / 2, len(inside))
        most = max(most, shares(robot, working, path, limits, s, rate, push))
    return duration, took, most


def by_fivebar(robot, working, path, limits, gap=1e-3):
    """(motion, s of a processor)."""
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of motions far above their bound
        constraints = fb.Constraints(**limits)
        motion = fb.time_path(robot, path, constraints=constraints, working=working, gap=gap)
    return motion, time.process_time() - began


@lru_cache
def charted(problem):
    """((robot, working, path, limits), the best lower bound) of a drawing of the chart."""
    seed = CHARTED[problem]
    if seed is None:
        star = np.array(STAR) * [1e-3, -1e-3] + [-0.04, 0.095]
        given = fb.FiveBar(), (-1, -1), fb.path(star, deviation=2e-5), {"speed": 0.1, "acceleration": 0.5}  # fmt: skip
    else:
        given = next(case[2:] for case in cases(seed + 1) if case[0] == seed)
    return given, by_fivebar(*given, GAPS[-1] / 3)[0].lower_bound


def attempt(run):
    """Prepare a way to time a drawing; a result is off by its gap, or by how far it exceeds a limit."""

    def prepare(problem, knob):
        given, bound = charted(problem)
        times = []

        def call():
            duration, took, most = run(*given, knob)
            times.append(took)
            return duration, most

        def judge(result):
            duration, most = result
            return {"off": max(duration / bound - 1, most - 1)}

        return Attempt(call, judge, times=lambda: np.array(times))

    return prepare


def ours(*arguments):
    motion, took = by_fivebar(*arguments)
    return motion.duration, took, 0.0


def chart():
    """Return the chart of least times."""
    by_joints = {name: INTERVALS for name, seed in CHARTED.items() if seed is not None}
    methods = (
        Method("fivebar.time_path", OURS, attempt(ours), GAPS),
        Method("toppra, Seidel", "toppra", attempt(by_toppra), by_joints, (lacks_toppra,)),
    )  # fmt: skip
    words = "gap, or limits exceeded (share)"
    levels = (1e-2, 1e-3)
    panels = [
        Panel(name, name, "off", words, xlabel="processor's time (s)", levels=levels, floor=1e-6)
        for name in CHARTED
    ]
    return Chart(
        name="least-time",
        title="Least time along a drawing: how far above a proven bound, and in what time",
        reading=(
            "Each point is a drawing of 10 to 30 pieces, timed with a wanted gap (fivebar) or with"
            " 5 to 320 intervals on each piece (toppra). Up: duration over the best proven lower"
            " bound, less 1, or how far a limit is exceeded between grid points, if that is more."
            " fivebar's limits hold everywhere; toppra has none on the tip's acceleration."
        ),
        problems={name: f"limits: {name}" for name in CHARTED},
        methods=methods,
        panels=(tuple(panels[:2]), tuple(panels[2:])),
        step=lambda knob: 1 / knob,
    )


def main(count=100):
    """[(pieces, gap, s, toppra's s or nan)]; prints a line a drawing, and the distribution."""
    found = []
    for seed, name, *given in cases(count):
        robot, working, drawn, limits = given
        try:
            motion, took = by_fivebar(*given)
        except (ValueError, fb.UnreachableError, fb.SingularityError) as error:
            print(f"{seed:4} {name}: {str(error)[:90]}")
            continue
        theirs = np.nan
        words = ", ".join(limits)
        if set(limits) <= BY_JOINTS:
            for intervals in INTERVALS[3:6]:
                try:
                    duration, theirs, most = by_toppra(*given, intervals)
                except Failed:
                    continue
                off = max(duration / motion.lower_bound, most) - 1
                if off <= 1e-3:
                    break
            words += f"; toppra {theirs:.2f} s, {intervals} intervals a piece, off by {off:.1e}"
        found.append((len(drawn.pieces), motion.gap, took, theirs))
        print(
            f"{seed:4} {name:28}{len(drawn.pieces):4} pieces  gap {motion.gap:8.1e}  {took:6.2f} s  {words}",
            flush=True,
        )
    pieces, gaps, seconds, theirs = np.array(found).T
    print(f"{len(found)} drawings; gap > 1e-3: {(gaps > 1e-3).sum()}, largest {gaps.max():.2g}")
    print(
        f"seconds: median {np.median(seconds):.2f}, 95 % {np.quantile(seconds, 0.95):.2f}, largest {seconds.max():.2f}"
    )
    per_30 = seconds / pieces * 30
    print(f"for 30 pieces: median {np.median(per_30):.2f} s")
    ratios = (seconds / theirs)[np.isfinite(theirs)]
    if len(ratios):
        print(
            f"toppra's time: {np.median(ratios):.1f} times shorter in the median, {ratios.max():.1f} at most"
        )
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=100)
    main(parser.parse_args().count)
