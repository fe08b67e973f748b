"""Free motions of random robots: energy over a minute, the way back over ten seconds, what is refused.

`python -m tests.benchmarks.free_motions [COUNT]`
"""

import sys
from multiprocessing import Pool

import numpy as np

import fivebar as fb
from fivebar.simulation.plant import Plant

CHANGE_POINT = 1e-3  # of the bars: nearer to one, four parallel bars are almost reached
NUDGE = (
    1e-10  # rad/s, of all four rates at the start: what becomes of it says how chaotic a motion is
)
TOLERANCE = (
    1e-13  # rad, of a step: finer ones come back no better, as rounding errors grow as a nudge does
)


def random_motion(seed, fastest=3.0):
    """A robot with unequal bars that closes somewhere, and Rates of a regular pose of it."""
    rng = np.random.default_rng(seed)
    while True:
        l11, l12, l21, l22, d = rng.uniform(0.05, 0.2, 5)
        try:
            robot = fb.FiveBar(
                l11, l12, l21, l22, d, *rng.uniform(5e-4, 5e-3, 2), rng.uniform(0.1, 1.0)
            )
        except ValueError:
            continue
        pose = fb.dgm(
            robot, rng.uniform(-np.pi, np.pi, (50, 2)), int(rng.choice([-1, 1])), unreachable="nan"
        )
        good = np.flatnonzero(np.abs(pose.det_A) > 0.1)
        if len(good):
            pose = fb.dgm(robot, pose.q[good[0]], int(pose.assembly[good[0]]))
            return robot, fb.dkm(pose, rng.uniform(-fastest, fastest, 2))


def from_change_point(robot):
    """How far the bars are from lying along the base, over the longest: the least |+-l11 +-l12 +-l21 +-l22 - d|."""
    bars = robot.l11, robot.l12, robot.l21, robot.l22
    signs = np.array(np.meshgrid(*[(-1, 1)] * 4)).reshape(4, -1).T
    return np.abs(signs @ bars - robot.d).min() / max(bars)


def judge(seed):
    """(seed, energy error over 60 s, miss after 10 s and back in m, growth of a nudge in these, distance from a change
    point, or the refusal)."""
    robot, start = random_motion(seed)
    try:
        run = fb.simulate(
            robot, duration=60.0, start=start, step=0.01, integrator=fb.Integrator(tolerance=1e-10)
        )
        plant = Plant(robot, start, TOLERANCE)
        plant.advance(10.0, np.zeros(2))
        back = Plant(robot, start, TOLERANCE)
        back.state = plant.state * np.repeat([1, -1], 4)
        back.advance(10.0, np.zeros(2))
        nudged = Plant(robot, start, TOLERANCE)
        a, a_dot = nudged.state[:4], nudged.state[4:]
        nudged.state = np.array([*a, *(a_dot * (1 + NUDGE / np.abs(a_dot).max()))])
        nudged.advance(10.0, np.zeros(2))
        growth = np.linalg.norm(nudged.rates.pose.xi - plant.rates.pose.xi) / NUDGE
    except ArithmeticError as error:
        return seed, np.nan, np.nan, np.nan, from_change_point(robot), str(error)
    drift = np.abs(run.energy / run.energy[0] - 1).max()
    return (
        seed,
        drift,
        np.linalg.norm(back.rates.pose.xi - start.pose.xi),
        growth,
        from_change_point(robot),
        "",
    )


def main(count=1000):
    with Pool() as pool:
        rows = pool.map(judge, range(count), chunksize=4)
    drift, miss, growth, apart = (np.array([row[k] for row in rows]) for k in (1, 2, 3, 4))
    refused = [row for row in rows if row[5]]
    print(f"{count} robots, {len(refused)} refused")
    for seed, *_, near, why in refused[:20]:
        print(f"  {seed}: {near:.2g} of the bars from a change point: {why}")
    for what, values in (("energy over 60 s", drift), ("10 s and back, m", miss)):
        median, most, worst = np.nanpercentile(values, (50, 99, 100))
        print(f"{what}: median {median:.2g}, 99 % {most:.2g}, worst {worst:.2g}")
    print(
        f"{np.sum(miss > 1e-6)} miss by more than 1e-6 m; a nudge of theirs grows to (m per rad/s), of others:"
    )
    for own in (miss > 1e-6, miss <= 1e-6):
        print(f"  {np.nanpercentile(growth[own], (0, 10, 50, 90, 100))}")
    for k in np.flatnonzero((drift > 1e-9) | (miss > 1e-6)):
        what = f"energy {drift[k]:.2g}, miss {miss[k]:.2g} m, a nudge grows to {growth[k]:.2g}"
        print(f"  {k}: {what}, {apart[k]:.2g} of the bars from a change point")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
