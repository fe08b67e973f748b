"""Poses on a grid over the workspace, in all working modes: where a robot could be measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...models.geometry import Pose, igm, task_pose
from ...models.robots import FiveBar

MODES = ((-1, -1), (-1, 1), (1, -1), (1, 1))
SIDE = 27  # poses along the workspace, in each working mode


def candidates(
    robot: FiveBar, margin: float, modes: Sequence, window: Sequence[float] | None
) -> Pose:
    """Return poses on a grid over the workspace in these working modes, off singularities."""
    reach = [robot.l11 + robot.l12, robot.l21 + robot.l22]
    low = max(-robot.d / 2 - reach[0], robot.d / 2 - reach[1])
    high = min(robot.d / 2 + reach[1], reach[0] - robot.d / 2)
    whole = low, high, -min(reach), min(reach)
    x_min, x_max, y_min, y_max = whole if window is None else window
    x, y = np.meshgrid(np.linspace(x_min, x_max, SIDE), np.linspace(y_min, y_max, SIDE))
    points = np.stack([x.ravel(), y.ravel()], axis=-1)
    kept = []
    for mode in modes:
        with np.errstate(invalid="ignore", divide="ignore"):
            pose = task_pose(robot, (points[:, 0], points[:, 1]), mode)
            sines = np.abs(np.stack([*pose.sines, pose.det_A]))
            kept.append(np.flatnonzero((sines > margin).all(axis=0)))
    xi = np.concatenate([points[k] for k in kept])
    working = [np.tile(mode, (len(k), 1)) for mode, k in zip(modes, kept)]
    return igm(robot, xi, np.concatenate(working))
