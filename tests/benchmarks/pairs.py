"""Plans between all ordered pairs of a robot's aspects, each replayed: `python -m tests.benchmarks.pairs [--quick]`."""

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import permutations

import numpy as np

import fivebar as fb
from fivebar.models.four_joints import loop_gap

ROBOTS = {
    "AMORO": (fb.FiveBar(), 90),
    "unequal": (fb.FiveBar(0.11, 0.14, 0.08, 0.12, 0.09, zz1=0.003, zz2=0.0015, m=0.7), 90),
    "twelve aspects": (fb.FiveBar(0.126, 0.127, 0.163, 0.072, 0.173), 132),
    "two circuits": (fb.FiveBar(0.05, 0.2, 0.05, 0.2, 0.29), 56),
}
DURATION, SAMPLE, CLOSE, GAP = 2.0, 0.002, 1e-6, 1e-4  # s, s, m, of the bars
STIFFNESS = 400.0  # 1/s^2, of the feedback


def gains(robot):
    """Of a PD that answers in 1/20 s, by a leg's inertia about its base."""
    inertia = max(robot.inertias) + robot.m * max(robot.l11, robot.l21) ** 2
    return STIFFNESS * inertia, 2 * STIFFNESS**0.5 * inertia


def solved(robot, one, other):
    """(what came of one pair, s, largest torque, the replay's last error in m, gap of the loop over the bars)."""
    start, goal = (fb.igm(robot, aspect.point, aspect.working) for aspect in (one, other))
    began = time.process_time()
    try:
        plan = fb.plan(robot, start, goal, DURATION)
    except fb.PlanError as error:
        seconds = time.process_time() - began
        return (
            ("unreachable" if "no motion joins" in str(error) else f"failed: {error}"),
            seconds,
            0.0,
            0.0,
            0.0,
        )
    seconds, t = (
        time.process_time() - began,
        np.linspace(0, DURATION, 10 * 13 * len(plan.pieces.xi)),
    )
    gap = np.hypot(*loop_gap(plan.accelerations(t).rates.pose)).max() / max(robot.distal)
    controller = fb.FeedForward(robot, *gains(robot), ahead=SAMPLE / 2)
    run = fb.simulate(robot, controller, plan, control_period=SAMPLE)
    error = max(
        float(np.hypot(*(run.xi[-1] - goal.xi))),
        robot.l11 * np.abs(robot.joint_difference(run.q[-1] - goal.q)).max(),
    )
    words = (
        "solved"
        if error <= CLOSE and gap <= GAP
        else f"failed: ends {error:.2g} m off, gap {gap:.2g}"
    )
    return words, seconds, float(np.abs(plan.torques(t)).max()), error, gap


def main(quick=False):
    """Print what came of every robot's pairs."""
    with ProcessPoolExecutor(2) as pool:
        for name, (robot, count) in ROBOTS.items():
            pairs = list(permutations(fb.aspects(robot), 2))
            assert len(pairs) == count
            pairs = pairs[:: 30 if quick else 1]
            began = time.perf_counter()
            found = list(pool.map(solved, [robot] * len(pairs), *zip(*pairs)))
            took, words = time.perf_counter() - began, [each[0] for each in found]
            failed = [
                (pair, each) for pair, each in zip(pairs, found) if each[0].startswith("failed")
            ]
            _, seconds, torques, errors, gaps = zip(*found)
            print(
                f"{name}: {len(pairs)} pairs, {words.count('solved')} solved, {words.count('unreachable')} unreachable,"
                f" {len(failed)} failed in {took:.1f} s\n  processor time of plans {sum(seconds):.1f} s, the longest "
                f"{max(seconds):.2f} s; largest torque {max(torques):.3g} N m; replays end within {max(errors):.1g} m; "
                f"loop closed within {max(gaps):.1g} of a bar",
                flush=True,
            )
            for (one, other), (what, spent, *_) in failed:
                print(f"  {one.number} -> {other.number} after {spent:.1f} s: {what}", flush=True)


if __name__ == "__main__":
    main("--quick" in sys.argv)
