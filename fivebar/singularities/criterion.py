"""What a path asks the bars for on the end-effector: where A is singular it must have no part along
t_s.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models.dyads import SINGULAR, cross
from ..models.geometry import Pose, igm
from ..models.kinematics import ikm, ikm2
from ..models.loads import forces_and_torques
from ..models.physics import loads_of, physics_of
from ..models.robots import Robot

SAMPLES = 2049
FAR = 0.01  # a sine: nearer to Type 1 the bars' own acceleration says nothing of the path's


def force_at(pose: Pose, xi_dot: np.ndarray, xi_ddot: np.ndarray) -> tuple:
    """m xi'', or with gravity and heavy bars all that the motion asks for, N, on components.

    Where one of them is singular of Type 1 too, the bars' rates are not known: then m (xi'' - g).
    """
    robot = pose.robot
    if physics_of(robot) is None or np.min(np.abs(pose.sines)) < SINGULAR:
        return tuple(robot.m * np.moveaxis(xi_ddot - np.array(loads_of(robot).gravity), -1, 0))
    return forces_and_torques(ikm2(ikm(pose, xi_dot), xi_ddot))[0]


def largest_force(robot: Robot, path: Any, working: tuple[int, int], acceleration: float) -> float:
    """Return the largest of these on a path with this largest acceleration (m/s^2), N."""
    if physics_of(robot) is None:
        return robot.m * acceleration
    motion = path(np.linspace(path.start, path.start + path.duration, SAMPLES))
    pose = igm(robot, motion[0], working, unreachable="nan")
    with np.errstate(invalid="ignore"):
        smallest = np.min(np.abs(pose.sines), axis=0)
        regular = np.isfinite(pose.q).all(axis=-1) & (smallest > FAR)
    if not regular.any():
        return abs(robot.m) * (acceleration + float(np.hypot(*loads_of(robot).gravity)))
    xi, xi_dot, xi_ddot = (each[regular] for each in motion)
    return float(np.hypot(*force_at(igm(robot, xi, working), xi_dot, xi_ddot)).max())


def crossing_acceleration(pose: Pose, xi_dot: np.ndarray, along: float) -> tuple[float, float]:
    """Return the acceleration on Type 2, m/s^2, with this part along u_12, that asks for nothing
    along t_s.
    """
    x, y = pose.u2[0]
    if physics_of(pose.robot) is None:
        return along * x, along * y
    none, one = (
        cross(
            pose.u2[0],
            force_at(pose, xi_dot, np.array([along * x - part * y, along * y + part * x])),
        )
        for part in (0.0, 1.0)
    )
    if one == none:
        raise ValueError("nothing at the end-effector weighs: any acceleration passes Type 2")
    part = -none / (one - none)  # what is asked for is affine in it
    return along * x - part * y, along * y + part * x
