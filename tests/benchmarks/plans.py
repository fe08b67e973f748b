"""Plans between random poses beside the best of a long search: `python -m tests.benchmarks.plans [PAIRS] [STARTS]`.

For each of five robots, PAIRS random pairs of poses and durations; the long search is STARTS times IPOPT from a random
motion and the plan's own. `--seconds S` ends it after S s of the processor. The chart `plans` of
`tests.benchmarks.charts` shows quality against time.
"""

import argparse
import time

import casadi as ca
import numpy as np

import fivebar as fb
from fivebar.models.charts import BarAngles
from fivebar.models.dynamics import forward_dynamics
from fivebar.models.four_joints import bars_pose, bars_rates, closed, loop_gap
from fivebar.planning.best_plan import refined
from fivebar.planning.collocation import Scheme
from fivebar.planning.coordinates import bars
from fivebar.planning.problem import Problem, checked_weights
from fivebar.planning.search import POINTS, ways
from fivebar.planning.starts import Start, first_guess, mesh_of
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Chart, Method, Panel

DOWN = (0.0, -9.81)
LINKS = {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08}
HEAVY = fb.FiveBar.from_links(
    0.09, 0.1, 0.08, 0.09, 0.12, LINKS, payload=0.2, gravity=DOWN, rotor=(1e-4, 2e-4)
)
UPRIGHT = fb.FiveBar(gravity=DOWN)
# Robot, and its torque limit over what holding needs.
ROBOTS = {
    "AMORO flat": (fb.FiveBar(), None),
    "AMORO upright": (UPRIGHT, None),
    "heavy upright": (HEAVY, None),
    "unequal": (fb.FiveBar(0.11, 0.14, 0.08, 0.12, 0.09, zz1=0.003, zz2=0.0015, m=0.7), None),
    "limited torque": (UPRIGHT, 1.5),
}
REGULAR = 0.15  # least sine of a random pose


def random_pairs(name, count):
    """Yield (robot, start, goal, duration, constraints) of random pairs, always the same ones."""
    robot, share = ROBOTS[name]
    rng = np.random.default_rng(53)
    reach = max(robot.l11 + robot.l12, robot.l21 + robot.l22)
    for _ in range(count):
        poses = []
        while len(poses) < 2:
            working = tuple(map(int, rng.choice([-1, 1], 2)))
            pose = fb.igm(robot, rng.uniform(-reach, reach, 2), working, unreachable="nan")
            regular = np.abs([*pose.sines, pose.det_A]).min() > REGULAR  # False for NaN
            if regular:
                poses.append(pose)
        limits = fb.Constraints()
        if share:
            held = np.abs([fb.gravity_torques(pose) for pose in poses]).max()
            limits = fb.Constraints(torque=share * float(held))
        yield robot, *poses, float(rng.uniform(0.5, 1.5)), limits


def problem_of(robot, start, goal, duration, limits):
    stops = ({0: start, 1: np.zeros(4)}, 0.0), ({0: goal, 1: np.zeros(4)}, duration)
    return Problem(robot, stops, None, checked_weights("effort"), limits, Scheme(3))


def solved(problem, path, intervals, seconds):
    """Return the plan by IPOPT from rest to rest along a path; None where there is none."""
    guess, durations = first_guess(problem, [path])
    settings = fb.Collocation(intervals=intervals, max_time=seconds)
    try:
        return refined(Start(problem, mesh_of(intervals, durations), durations, guess), settings)
    except fb.PlanError:
        return None


def by_ways(robot, start, goal, duration, limits, most):
    """Return the least objective of IPOPT's plans along the `most` shortest ways."""
    best = np.inf
    for way in ways(robot, start, goal)[:most]:
        problem = problem_of(robot, way.path[0], way.path[-1], duration, limits)
        plan = solved(problem, way.path, 40, 20.0)
        best = min(best, plan.objective if plan else np.inf)
    return best


def random_path(robot, start, goal, rng):
    """Return a path of the bars, a random way with a smooth random bend and other speeds."""
    found = ways(robot, start, goal)
    path = found[rng.integers(len(found))].path
    share = np.linspace(0, 1, POINTS) ** rng.uniform(0.6, 1.7)
    even = np.linspace(0, 1, POINTS)
    path = np.stack([np.interp(share, even, column) for column in path.T], axis=1)
    for k in (1, 2, 3):
        path = (
            path + rng.uniform(0, 1.5) / k * rng.normal(size=4) * np.sin(np.pi * k * even)[:, None]
        )
    ends = path[[0, -1]]
    for _ in range(12):
        path = np.stack(closed(robot, tuple(path.T), (np.zeros(POINTS),) * 4)[0], axis=1)
    path[[0, -1]] = ends
    return path


def long_search(robot, start, goal, duration, limits, starts):
    """Return the least objective of IPOPT's plans from random motions."""
    rng = np.random.default_rng(40)
    best = np.inf
    for _ in range(starts):
        path = random_path(robot, start, goal, rng)
        if np.abs(np.diff(path, axis=0)).max() > 0.7 or not np.isfinite(path).all():
            continue
        problem = problem_of(robot, path[0], path[-1], duration, limits)
        plan = solved(problem, path, 40, 20.0)
        best = min(best, plan.objective if plan else np.inf)
    return best


def by_opti(robot, start, goal, duration, limits, starts, count=40):
    """Return the least objective of a multi-start written by hand with CasADi's Opti.

    Multiple shooting with Runge and Kutta's steps, from straight lines of the bars with noise.
    """
    x, u = ca.SX.sym("x", 8), ca.SX.sym("u", 2)
    rates = bars_rates(robot, ca.vertsplit(x[:4]), ca.vertsplit(x[4:]))
    bends = BarAngles().accelerations(forward_dynamics(rates, u))
    rate = ca.Function("rate", [x, u], [ca.vertcat(x[4:], *bends)])
    h = duration / count
    one = rate(x, u)
    two = rate(x + h / 2 * one, u)
    three = rate(x + h / 2 * two, u)
    after = x + h / 6 * (one + 2 * two + 2 * three + rate(x + h * three, u))
    step = ca.Function("step", [x, u], [after])
    gap = ca.Function("gap", [x], [ca.vertcat(*loop_gap(bars_pose(robot, ca.vertsplit(x[:4]))))])
    rng = np.random.default_rng(7)
    best = np.inf
    begin, end = bars(start), bars(goal)
    for _ in range(starts):
        opti = ca.Opti()
        states, torques = opti.variable(8, count + 1), opti.variable(2, count)
        opti.minimize(h * ca.sumsqr(torques))
        for k in range(count):
            opti.subject_to(states[:, k + 1] == step(states[:, k], torques[:, k]))
        turned = end + 2 * np.pi * rng.integers(-1, 2, 4) * (rng.random() < 0.5)
        opti.subject_to(states[:, 0] == np.append(begin, np.zeros(4)))
        opti.subject_to(opti.bounded(-0.3, states[:4, -1] - turned, 0.3))
        opti.subject_to(states[[0, 2], -1] == turned[[0, 2]])
        opti.subject_to(states[[4, 6], -1] == 0)
        if limits.torque:
            opti.subject_to(opti.bounded(-min(limits.torque), ca.vec(torques), min(limits.torque)))
        line = begin[:, None] + (turned - begin)[:, None] * np.linspace(0, 1, count + 1)
        opti.set_initial(states[:4, :], line + 0.3 * rng.normal(size=line.shape))
        opti.solver("ipopt", {"print_time": False, "show_eval_warnings": False},
                    {"print_level": 0, "sb": "yes", "max_iter": 300})  # fmt: skip
        try:
            found = opti.solve()
        except RuntimeError:
            continue
        closes = np.abs(gap(found.value(states)).full()).max() < 0.02 * robot.l11
        if closes:
            best = min(best, float(found.value(opti.f)))
    return best


METHODS = {
    "fivebar.plan": lambda *given: fb.plan(*given[:4], constraints=given[4]).objective,
    "one start": lambda *given: by_ways(*given, 1),
    "all ways": lambda *given: by_ways(*given, 6),
    "Opti by hand": lambda *given: by_opti(*given, 5),
}


def chart():
    """Return the chart of the objective over the best one, against the processor's time."""

    def prepared(run):
        def prepare(name, knob):
            given = list(random_pairs(name, int(knob) + 1))[-1]
            times = []

            def call():
                began = time.process_time()
                objective = run(*given)
                times.append(time.process_time() - began)
                return objective

            best = min(call(), fb.plan(*given[:4], constraints=given[4]).objective)
            return Attempt(
                call, lambda found: {"off": found / best - 1}, times=lambda: np.array(times)
            )

        return prepare

    methods = [
        Method(name, OURS if name == "fivebar.plan" else name, prepared(run), (0, 1, 2))
        for name, run in METHODS.items()
    ]
    panels = [
        Panel(name, name, "off", "objective over the best, less 1", xlabel="processor's time (s)",
              levels=(0.02, 0.2), floor=1e-3)
        for name in ROBOTS
    ]  # fmt: skip
    return Chart(
        name="plans",
        title="Plans between random poses: how far above the best found, and in what time",
        reading="Each point is a pair of poses. Up: objective over the best of all methods, less 1.",
        problems={name: name for name in ROBOTS},
        methods=tuple(methods),
        panels=(tuple(panels[:3]), tuple(panels[3:])),
        step=lambda knob: 1 / (1 + knob),
    )


def main(count=12, starts=10, seconds=np.inf, names=tuple(ROBOTS)):
    """Print a line a pair, and the distribution; return [(name, objective over the best, s)]."""
    found = []
    began = time.process_time()
    for name in names:
        for k, given in enumerate(random_pairs(name, count)):
            if time.process_time() - began > seconds:
                break
            started = time.process_time()
            try:
                plan = fb.plan(*given[:4], constraints=given[4])
                objective, tried = plan.objective, plan.tried
            except fb.PlanError as error:
                objective, tried = np.inf, str(error)[:60]
            took = time.process_time() - started
            best = min(objective, long_search(*given, starts))
            found.append((name, objective / best if np.isfinite(best) else np.inf, took))
            print(
                f"{name:15}{k:3}  {objective:9.4g}  long search {best:9.4g}  {took:5.1f} s  {tried}",
                flush=True,
            )
    over = np.array([each[1] for each in found])
    took = np.array([each[2] for each in found])
    for share in (0.02, 0.2):
        print(f"within {100 * share:.0f} %: {np.mean(over <= 1 + share):.0%} of {len(over)} pairs")
    print(f"processor time: median {np.median(took):.1f} s, 95 % {np.quantile(took, 0.95):.1f} s")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=12)
    parser.add_argument("starts", nargs="?", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=np.inf)
    options = parser.parse_args()
    main(options.count, options.starts, options.seconds)
