"""A reference for free motions that shares no formula with fivebar."""

import numpy as np

from fivebar.study.pitfalls.integrators import adaptive
from fivebar.study.pitfalls.redundant import Redundant, redundant_slope, redundant_state


def redundant_reference(robot, start, duration, tolerance=1e-13):
    """The free motion from `start` by DOP853 at a tolerance where its drift does not matter."""
    t, limits = np.linspace(0, duration, 101), (tolerance, 1e-3 * tolerance)
    result = adaptive(redundant_slope(robot), redundant_state(start), t, "DOP853", *limits)
    return Redundant(robot, result.t, result.states)
