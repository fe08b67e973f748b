"""A polynomial made to cross a Type-2 singularity: the baseline that plans are measured against."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import finite_numbers
from ..base.checks import modes, shown, two_numbers
from ..base.robot_uses import takes_robot
from ..models.geometry import igm
from ..models.kinematics import ikm
from ..singularities.criterion import crossing_acceleration
from .trajectory import Trajectory, polynomial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..models.robots import Robot


def three_times(value, name):
    """Rule: three times, increasing; ValueError for anything else."""
    times = finite_numbers(value, name)
    if times.shape != (3,) or not (times[0] < times[1] < times[2]):
        raise ValueError(f"{name} must be three numbers, increasing, s, not {shown(value)}")
    return tuple(times.tolist())


@takes_robot(
    start=two_numbers,
    goal=two_numbers,
    crossing=two_numbers,
    velocity=two_numbers,
    times=three_times,
    acceleration=two_numbers,
    working=modes(2),
)
def crossing_polynomial(
    robot: Robot,
    start: ArrayLike,
    goal: ArrayLike,
    crossing: ArrayLike,
    velocity: ArrayLike,
    times: Sequence[float],
    acceleration: Sequence[float] = (0.0, 0.0),
    working: tuple[int, int] = (-1, -1),
) -> Trajectory:
    """Return the degree-8 polynomial through a Type-2 singularity that keeps its criterion there.

    The criterion is t_s . (m xi'') = 0, t_s the free direction (A t_s = 0). Of a robot with gravity
    or heavy bars, m xi'' is what the motion asks the bars for.

    Parameters
    ----------
    robot : FiveBar or Biglide
    start, goal : (2,)
        m, at rest with no acceleration.
    crossing : (2,)
        m, on the singularity.
    velocity : (2,)
        m/s, there.
    times : (3,)
        Of start, crossing and goal, s.
    acceleration : (2,)
        m/s^2, there: the part of it that lies across t_s.
    working : (2,)
        Working modes.

    Returns
    -------
    Trajectory

    Raises
    ------
    ValueError
        det A is not 0 at the crossing, or is not passed through.

    References
    ----------
    Briot and Arakelian, Optimal force generation in parallel manipulators, 2008.

    Examples
    --------
    >>> import fivebar as fb
    >>> crossing = (0.0525327138758270, 0.00430328475849708)
    >>> motion = fb.crossing_polynomial(
    ...     fb.FiveBar(), (0.09, 0.068), (0.05, 0.0), crossing, (-0.025, -0.043), (0.0, 2.0, 4.0)
    ... )
    >>> motion.duration
    4.0
    """
    rates = ikm(igm(robot, crossing, working), velocity)
    pose = rates.pose
    slope = rates.margin_rates[2]
    if abs(pose.det_A) > 1e-6:
        at = f"det A = {pose.det_A:.3g} in working modes {working}"
        raise ValueError(f"crossing_polynomial: the crossing is not on Type 2: {at}")
    if abs(slope) < 1e-6:
        raise ValueError(
            "crossing_polynomial: this velocity does not cross the singularity: det A' ="
            f" {slope:.3g} 1/s"
        )
    x, y = pose.u2[0]  # across t_s
    passes = crossing_acceleration(
        pose, np.array(velocity), x * acceleration[0] + y * acceleration[1]
    )
    rest = {1: (0.0, 0.0), 2: (0.0, 0.0)}
    t0, ts, t1 = times
    middle = {0: crossing, 1: velocity, 2: passes}
    try:
        return polynomial([(t0, {0: start, **rest}), (ts, middle), (t1, {0: goal, **rest})])
    except ValueError as error:
        raise ValueError(
            f"crossing_polynomial: from start to goal at times {shown(times)}: {error}"
        ) from None
