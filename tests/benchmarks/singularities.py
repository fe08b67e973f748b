"""Loci, maps and their picture, figures of one run: `python -m tests.benchmarks.singularities [--quick]`."""

import resource
import subprocess
import sys

import fivebar as fb
from tests.benchmarks.speed import seconds

MAP = "import fivebar as fb; fb.singularity_map(fb.FiveBar(), shape=({n}, {n}))"


def peak_memory(n):
    """MB that a process needs to make the map, all its imports included: the largest child of this process."""
    subprocess.run([sys.executable, "-c", MAP.format(n=n)], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def main(quick=False):
    """Print every figure with its bound."""
    from fivebar.visualization.plot.maps import singularity_map as picture

    robot, n, repeats = fb.FiveBar(), 50 if quick else 1000, 1 if quick else 9
    points = sum(len(piece.points) for piece in fb.singularity_loci(robot).task)
    loci = seconds(lambda: fb.singularity_loci(robot).task, 5 * repeats)
    print(
        f"exact loci, {points} points, ms for 2000           {1e3 * loci * 2000 / points:8.2f}   (bound 3)"
    )
    made = seconds(lambda: fb.singularity_map(robot, shape=(n, n)), repeats)
    print(f"map of {n} x {n} in four modes, s              {made:8.3f}   (bound 0.4)")
    print(f"  the whole process, MB                        {peak_memory(n):8.0f}   (bound 400)")
    data = fb.singularity_map(robot, shape=(n, n))
    drawn = seconds(lambda: picture(data).savefig("/dev/null", format="png"), min(repeats, 3))
    print(f"its picture, s                                 {drawn:8.2f}   (bound 3)")


if __name__ == "__main__":
    main("--quick" in sys.argv)
