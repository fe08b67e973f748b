"""A motion of the robot in a table of setpoints that fivebar wrote."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.columns import Origin
from ..base.tables import Table, TextFile
from ..models.parameters import robot_of
from ..models.robots import Robot
from ..planning.samples import SLOPES, hermite
from ..planning.trajectory import Trajectory
from .placement import Placement
from .tool import MountedTool, Tool


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RecordedPath(Trajectory):
    """A motion of joint C from a table, from `TimedPath.from_csv`; a Trajectory with the robot, its
    working modes, and the rows of the pen.

    Attributes
    ----------
    robot : FiveBar or Biglide
    working : (2,) or None
        None where they change.
    rows : (n,)
        Times of the rows, s.
    pens : (n,)
        Whether the pen is down from each row on; True where the file has no pen.
    """

    robot: Robot
    working: tuple[int, int] | None
    rows: np.ndarray
    pens: np.ndarray

    def pen(self, t: ArrayLike) -> np.ndarray:
        """Return whether the pen is down at times t (*batch,)."""
        k = np.searchsorted(self.rows, np.asarray(t) + 1e-12 * self.duration, side="right") - 1
        return self.pens[np.maximum(k, 0)]


def recorded_path(path: TextFile) -> RecordedPath:
    """Return the motion in a file of setpoints, as `TimedPath.from_csv` says."""
    table = Table(path)
    robot, working, frame, tool = table.about("setpoints", "a file of setpoints", _known)
    has_pen = "pen" in table.header
    values = table.numbers(["t", "x", "y", *SLOPES, *["pen"] * has_pen])
    if len(values) < 2:
        raise ValueError(f"{table.name}: one row is no motion")
    t = values[:, 0]
    back = frame.inverse
    turned = replace(back, shift=(0.0, 0.0))
    xi, xi_dot, xi_ddot = np.split(values[:, 1:7], 3, axis=1)
    motion = np.stack([back(xi), turned(xi_dot), turned(xi_ddot)])
    if tool is not None:
        mounted = MountedTool(tool, robot, working)
        motion = mounted.carried(np.concatenate([motion, np.zeros((1, *xi.shape))]))[:3]
    pens = values[:, 7] > 0 if has_pen else np.ones(len(t), bool)
    return RecordedPath(
        float(t[0]),
        float(t[-1] - t[0]),
        hermite(t, *motion),
        origin=Origin(of_tool=False, measured=False),
        robot=robot,
        working=working,
        rows=t,
        pens=pens,
    )


def _known(about):
    """Return robot, working modes, frame and tool of a comment line."""
    working: Any = about["working"]
    return (
        robot_of(about["robot"]),
        None if working is None else tuple(map(int, working)),
        Placement(**about.get("frame", {})),
        Tool(**about["tool"]) if "tool" in about else None,
    )
