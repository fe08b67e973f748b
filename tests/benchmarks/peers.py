"""The constraint stiffness with which MuJoCo comes closest to the forced motion: `python -m tests.benchmarks.peers`.

What it prints is shipped as MUJOCO_STIFFNESS of fivebar.study.work_precision.peers.
"""

import numpy as np

from fivebar.study.work_precision.motions import DRIVEN
from fivebar.study.work_precision.peers import MUJOCO_STIFFNESS, mujoco_run, read


def error(count, stiffness):
    """Largest error of an active joint at the end, rad; inf where it does not hold."""
    motion = DRIVEN["forced"]
    off = np.abs(read(mujoco_run(motion, count, stiffness)[0]())[0] - motion.end).max()
    return off if np.isfinite(off) else np.inf


def main():
    for count in MUJOCO_STIFFNESS:
        found = {stiffness: error(count, stiffness) for stiffness in 10.0 ** np.arange(-2, 7)}
        best = min(found, key=found.get)
        print(f"{count:5d} steps: stiffness {best:g}, error {found[best]:.2g} rad")


if __name__ == "__main__":
    main()
