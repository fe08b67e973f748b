"""The lab's control task 2 meets a Type-2 singularity, and a motion that is made to cross it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...constraints.path_check import check_path
from ...control.laws import Reference
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import ikm, ikm2
from ...models.robots import Biglide, FiveBar, Robot
from ...planning.trajectory import Trajectory, line, polynomial

START = (0.09, 0.06796322)
GOAL = (0.05, 0.0)
DURATION = 4.0


def straight() -> Trajectory:
    """Return the lab's quintic from START to GOAL."""
    return line(START, GOAL, DURATION)


def compliant(robot: FiveBar | Biglide, speed: float = 0.05) -> Trajectory:
    """Return a polynomial of degree 8 that is on the singularity at half time without acceleration.

    There it passes with `speed`, m/s, along the line. Its inertial force then has no component
    along the direction that the bars leave free, which is the criterion of Briot and Arakelian
    2008: the torque stays finite.
    """
    rest = {1: (0.0, 0.0), 2: (0.0, 0.0)}
    met: Any = check_path(robot, straight())
    along = np.subtract(GOAL, START)
    velocity = speed * along / np.linalg.norm(along)
    middle: dict = {0: tuple(met.pose.xi), 1: tuple(velocity), 2: (0.0, 0.0)}
    return polynomial(
        [(0.0, {0: START, **rest}), (DURATION / 2, middle), (DURATION, {0: GOAL, **rest})]
    )


def torque(robot: Robot, reference: Reference, t: ArrayLike) -> np.ndarray:
    """Return the exact torque along a reference, (n, 2) N m at t (n,) s, modes (-1, -1)."""
    xi, xi_dot, xi_ddot = reference(t)
    return inverse_dynamics(ikm2(ikm(igm(robot, xi), xi_dot), xi_ddot))


@dataclass(frozen=True)
class OpenLoop:
    """A controller that applies the torque of the reference in the middle of each period (s)."""

    robot: Robot
    period: float

    def __call__(
        self, t: float, q: np.ndarray, q_dot: np.ndarray, reference: Reference
    ) -> np.ndarray:
        return torque(self.robot, reference, t + self.period / 2)


@dataclass(frozen=True, eq=False)
class Crossing:
    """Torque (n, 2) N m of a reference at t - t_crossing (n,) s, without 0."""

    crossing: float
    offset: np.ndarray
    torque: np.ndarray


def beside_crossing(
    robot: FiveBar | Biglide, reference: Trajectory, closest: float = 1e-6, count: int = 400
) -> Crossing:
    """Return the exact torque up to `closest` (s) to the crossing on both sides."""
    met: Any = check_path(robot, reference)
    crossing = met.time
    before = -np.geomspace(crossing, closest, count)
    after = np.geomspace(closest, reference.duration - crossing, count)
    offset = np.concatenate([before, after])
    return Crossing(crossing, offset, torque(robot, reference, crossing + offset))
