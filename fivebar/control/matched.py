"""A tracker's weights, horizon and period by the motion that it is to follow.

Of a motion k times as fast as another along the same path, accelerations and torques are k^2 times
as large. With the weights of a slow one the tracker would pay more for the torques' changes that a
fast one is made of than for leaving it, and of a horizon of a second its stages would be longer
than a letter takes. The word that `fivebar draw --example` draws, in the least time of 20 N m, is
missed by so much, in um, at a reserve of 0, 0.05 and 0.3 of the torque:

    tracker's own weights, 5 ms   -       34043   20370
    matched weights, 5 ms         -        6405     820
    matched, period_for: 0.5 ms   63         25      18

With 0.02 to 100 N m the last line is 55 to 121, 5 to 27 and 5 to 27: it no longer depends on how
strong the robot is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import SingularityError, UnreachableError
from ..constraints.constraints import Constraints
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from .tracker import ARM, RATE, Tracker, moved

if TYPE_CHECKING:
    from ..models.robots import Robot
    from .laws import Reference

HORIZON = 20  # periods
USUAL = 0.3  # m/s^2, up to which the tracker's own weights do
POSITION, ACCELERATION = (1e4, 10.0)  # 1/m, s^2/m, the tracker's own weights
SIZE = 0.09  # m, of the robot that they were chosen for
PERIODS = 5e-3, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4  # s
SHOWN = 2e-5  # m, by which an acceleration that changes within a period may be missed
FAST = 1.0  # m/s^2
# Of a bar, missed in a period: there only the far view of a Tracker's own horizon helps.
COARSE = 5e-3


def peak_acceleration(reference: Reference, start: float, duration: float) -> float:
    """Return the largest acceleration of a motion, m/s^2, at times as dense as short periods."""
    rows = int(np.clip(2 * duration / PERIODS[-1], 1000, 40_000))
    _, _, xi_ddot = reference(start + np.linspace(0.0, duration, rows))
    return float(np.hypot(*xi_ddot.T).max())


def missed(acceleration: float, period: float) -> float:
    """Return a h^2 / 8, m, the error of a torque held while the acceleration changes by a."""
    return acceleration * period**2 / 8


def period_for(robot: Robot, acceleration: float) -> float:
    """Return the longest of PERIODS, s, with an error of at most SHOWN; else the shortest."""
    shown = SHOWN / _smaller(robot)
    periods = [period for period in PERIODS if missed(acceleration, period) <= shown]
    return max(periods, default=PERIODS[-1])


def _smaller(robot):
    """Return how many times a robot is smaller than the weights' own one, at least 1."""
    return max(1.0, SIZE / min(*robot.distal, *(drive.length for drive in robot.drives)))


def asks_for_it(
    robot: Robot, motion: Any, period: float, torque_limit: float | None, working: tuple[int, int]
) -> float | None:
    """Return the peak acceleration of a motion if it is fast but feasible, else None.

    Feasible is what the torque limit and the control period allow.
    """
    peak = peak_acceleration(motion, motion.start, motion.duration)
    if not peak > FAST or missed(peak, period) > COARSE * min(robot.distal):
        return None
    try:
        xi, xi_dot, xi_ddot = motion(motion.start + np.linspace(0.0, motion.duration, 2000))
        tau = inverse_dynamics(ikm2(ikm(igm(robot, xi, working), xi_dot), xi_ddot))
    except (SingularityError, UnreachableError):
        return None  # without such torques, the far view matters
    if torque_limit is None or np.abs(tau).max() <= torque_limit:
        return peak
    return None


def matched(
    robot: Robot,
    acceleration: float,
    period: float,
    constraints: Constraints,
    assembly: int,
    delay: int = 0,
    encoder_resolution: float | None = None,
) -> Tracker:
    """Return a Tracker for feasible motions of this peak acceleration, m/s^2.

    delay, encoder_resolution: those of the simulation, which a Tracker knows.
    """
    share = min(1.0, USUAL / max(acceleration, 1e-9))
    rate = RATE / (ARM * moved(robot)) * share if moved(robot) else None
    return Tracker(
        robot,
        HORIZON,
        period,
        seconds=HORIZON * period,
        constraints=constraints,
        delay=delay,
        encoder_resolution=encoder_resolution,
        assembly=assembly,
        position=POSITION * _smaller(robot),
        acceleration=ACCELERATION * share,
        torque_rate=rate,
    )
