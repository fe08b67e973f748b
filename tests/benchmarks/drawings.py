"""Gap and processor time of random drawings timed by `time_path`:
`python -m tests.benchmarks.drawings [COUNT]`.

Strokes are polylines and curves with blends of 5 um to 1 mm, on four robots, with and without a tool, under limits of all
kinds. Times are of the processor, of the call alone. A gap is duration / lower bound - 1.
"""

import argparse
import time
import warnings

import numpy as np

import fivebar as fb
from fivebar.models.named_robots import ROBOTS as NAMED
from fivebar.paths.curve import Path

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


def main(count=100):
    """[(pieces, gap, s of a processor)]; prints a line a drawing, and the distribution."""
    found = []
    for seed, name, robot, working, drawn, limits in cases(count):
        began = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            try:
                motion = fb.time_path(
                    robot, drawn, constraints=fb.Constraints(**limits), working=working
                )
            except (ValueError, fb.UnreachableError, fb.SingularityError) as error:
                print(f"{seed:4} {name}: {str(error)[:90]}")
                continue
        took = time.process_time() - began
        found.append((len(drawn.pieces), motion.gap, took))
        words = ", ".join(limits)
        print(
            f"{seed:4} {name:28}{len(drawn.pieces):4} pieces  gap {motion.gap:8.1e}  {took:6.2f} s  {words}",
            flush=True,
        )
    pieces, gaps, seconds = np.array(found).T
    print(f"{len(found)} drawings; gap > 1e-3: {(gaps > 1e-3).sum()}, largest {gaps.max():.2g}")
    print(
        f"seconds: median {np.median(seconds):.2f}, 95 % {np.quantile(seconds, 0.95):.2f}, largest {seconds.max():.2f}"
    )
    per_30 = seconds / pieces * 30
    print(f"for 30 pieces: median {np.median(per_30):.2f} s")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=100)
    main(parser.parse_args().count)
