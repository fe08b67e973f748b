"""Settings with which other simulators come closest to the motions: `python -m tests.benchmarks.peers`.

What it prints is shipped as DRAKE_BUSHINGS and EXUDYN_SPRINGS of tests.benchmarks.simulators.
"""

import numpy as np

from fivebar.base.backend import wrap
from tests.benchmarks.simulators.chart import FAR
from tests.benchmarks.simulators.drake import drake_bushing
from tests.benchmarks.simulators.exudyn import exudyn_springs
from tests.benchmarks.simulators.motions import DRIVEN
from tests.benchmarks.simulators.mujoco_pinocchio import read

RATIOS = 0.01, 0.02, 0.05, 0.1, 0.2, 0.4  # of damping
STEPS = (
    1.5,
    1.75,
    2.0,
    2.25,
    2.5,
    3.0,
    3.5,
    4.0,
    5.0,
    6.0,
    8.0,
)  # times the square root of the stiffness: a share of a period
NEAR = 1.25  # times the error of many steps
DRAKE = {"runge_kutta3": 3, "runge_kutta5": 6}  # evaluations a step
EXUDYN = {"RK33": 3, "RK44": 4, "RK67": 7}


def error(motion, q):
    """Largest error of an active joint at the end, rad; inf where it does not hold."""
    return np.abs(wrap(q - motion.end)).max() if np.abs(q).max() < FAR else np.inf


def drake(stiffness, settings):
    """Errors of all motions."""
    return np.array(
        [error(m, read(drake_bushing(m, stiffness, settings)[0]())[0]) for m in DRIVEN.values()]
    )


def exudyn(stiffness, settings):
    return np.array(
        [error(m, exudyn_springs(m, stiffness, settings)[0]()[0]) for m in DRIVEN.values()]
    )


def cheapest(run, stiffness, schemes):
    """(scheme, steps, damping ratio) of the fewest evaluations near the errors that the stiffness leaves; those."""
    aim = NEAR * run(stiffness, (list(schemes)[1], round(10 * stiffness**0.5), 0.4))
    every = [
        (name, round(k * stiffness**0.5), ratio)
        for name in schemes
        for k in STEPS
        for ratio in RATIOS
    ]
    for settings in sorted(every, key=lambda found: schemes[found[0]] * found[1]):
        found = run(stiffness, settings)
        if (found < aim).all():
            return settings, found
    raise RuntimeError(f"nothing near {aim} rad for {stiffness:g} N/m")


def main():
    for name, run, schemes, last in (("Drake", drake, DRAKE, 7.5), ("Exudyn", exudyn, EXUDYN, 10)):
        for stiffness in (float(f"{10**k:.0e}") for k in np.arange(3, last + 0.1, 0.5)):
            settings, found = cheapest(run, stiffness, schemes)
            print(f"{name}, {stiffness:.0e}: {settings}, errors {found} rad", flush=True)


if __name__ == "__main__":
    main()
