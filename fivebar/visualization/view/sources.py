"""What moves, read as it is asked for: a run, a reference or plan of a robot, a study of a
linkage.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...models.dynamics import bar_forces, drives_forces, forward_dynamics, inverse_dynamics
from ...models.geometry import Pose, igm
from ...models.joint_positions import elbows, joints
from ...models.kinematics import dkm, ikm, ikm2
from ..crossings import crossings
from ..skeleton import Skeleton, measured_pose, robot_body
from ..style import robot_title
from .frames import choose, grid
from .machine import Notice
from .studies import OfStudy

if TYPE_CHECKING:
    from ...linkages import Study
    from ...models.robots import Robot
    from ...simulation.run import Run


def source(robot: object, motion: Run | Study | Callable) -> OfRobot | OfStudy:
    """The source of a motion: a Run, a Study, or a Plan or other reference that is called with the
    time.

    ValueError for a motion of another robot, TypeError for what does not move, or by no robot.
    """
    if hasattr(motion, "motion") and hasattr(motion, "linkage"):
        found = OfStudy(motion)
    elif hasattr(motion, "xi_ref"):
        found = OfRun(motion)
    elif callable(motion) and hasattr(motion, "duration"):
        if not hasattr(robot, "drives"):
            raise TypeError(f"a reference needs the robot that follows it, not {robot!r}")
        found = OfReference(robot, motion)
    else:
        raise TypeError(
            "a scene needs a Run, a Plan or other reference, or a Study, not"
            f" {type(motion).__name__}"
        )
    own = getattr(motion, "linkage", None) or getattr(motion, "robot", robot)
    if robot != own:
        raise ValueError(f"this motion is of another robot: {own}, not {robot}")
    return found


def scattered(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Values (k, ...) at those rows (m,) bool that are true, nan at the others: (m, ...)."""
    full = np.full((len(rows), *values.shape[1:]), np.nan)
    full[rows] = values
    return full


class OfRobot:
    """A robot with two drives at the frames of a motion; q, xi (m, 2); everything else is computed
    when first read.
    """

    known = (
        "trace",
        "reference",
        "loci",
        "workspace",
        "elbow-circles",
        "velocity",
        "acceleration",
        "bar-forces",
        "torques",
        "ghost",
    )
    xi_ref = None

    def __init__(self, robot: Robot):
        self.robot, self.title, self.effort = robot, robot.words.title, robot.words.effort

    @property
    def heading(self) -> str:
        return robot_title(self.robot)

    @cached_property
    def body(self) -> Skeleton:
        return robot_body(self.robot, self.elbows, self.xi)

    @property
    def traced(self) -> np.ndarray:
        """The end-effector's path, (m, 2) m."""
        return self.xi

    @cached_property
    def working(self) -> np.ndarray:
        """Working modes (m, 2) without zeros: where a leg is in line, those before it."""
        modes = np.array(self.pose.working)
        for leg in modes.T:
            nonzero = np.flatnonzero(leg)
            first = nonzero[0] if len(nonzero) else 0
            leg[:] = (
                leg[np.maximum.accumulate(np.where(leg != 0, np.arange(len(leg)), first))]
                if len(nonzero)
                else -1
            )
        return modes

    @property
    def ghost(self) -> np.ndarray:
        """The reference's positions in the modes of the motion, (m, k, 2) m, nan out of reach."""
        rows = np.isfinite(self.xi_ref).all(axis=1)
        pose = igm(self.robot, self.xi_ref[rows], self.working[rows], unreachable="nan")
        points = joints(self.robot, pose.elbows, self.xi_ref[rows])
        points[np.isnan(points).any(axis=(1, 2))] = np.nan
        return scattered(points, rows)

    @property
    def bar_forces(self) -> np.ndarray:
        """Forces of the distal bars on the end-effector, (m, 2 legs, 2) N."""
        rates, rows = self._rates, self._rows
        if all(self.robot.inertias):
            forces = bar_forces(rates, self.tau[rows])
        else:  # a reference: without inertia of a drive, what all drives say determines both
            forces = np.stack(
                drives_forces(ikm2(rates, self.acceleration), tuple(self.tau.T)), axis=-1
            )
        return scattered(forces[..., None] * rates.pose.A, rows)

    @property
    def torques(self) -> list[tuple]:
        """[(places (m, 2) m, direction (2,) of a force or None for a torque, values (m,))] of each
        drive.
        """
        points = self.body.points
        return [
            (points[:, joint], None if self.robot.turns else np.array(drive.tangent(0.0)), tau)
            for joint, drive, tau in zip(self.body.actuated, self.robot.drives, self.tau.T)
        ]


class OfRun(OfRobot):
    """A simulated run."""

    def __init__(self, run: Run):
        super().__init__(run.robot)
        self.frames = choose(run.t, run.q, run.xi)
        thin = {
            name: getattr(run, name)[self.frames.index]
            for name in ("t", "q", "q_dot", "xi", "tau", "energy")
        }
        thin["friction_loss"] = None  # not shown
        self.run = replace(
            run, **thin, xi_ref=None if run.xi_ref is None else run.xi_ref[self.frames.index]
        )
        self.q, self.xi, self.tau, self.xi_ref = (
            self.run.q,
            self.run.xi,
            self.run.tau,
            self.run.xi_ref,
        )

    @property
    def events(self) -> Iterator[Notice]:
        for event in self.run.events:
            t = event.t - self.frames.start
            place = tuple(float(np.interp(t, self.frames.t, column)) for column in self.xi.T)
            yield Notice(
                t,
                f"Type {int(event.type)} singularity ({event.margin} = 0) at {event.t:.6g} s",
                place,
            )

    @cached_property
    def elbows(self) -> np.ndarray:
        return elbows(self.robot, self.q)

    @cached_property
    def pose(self) -> Pose:
        return self._posed(slice(None))

    def _posed(self, rows):
        return measured_pose(self.robot, self.q[rows], self.xi[rows])

    @cached_property
    def _rows(self):
        """At which frames (m,) rates and torques are numbers."""
        return np.isfinite(self.run.q_dot).all(axis=1) & np.isfinite(self.tau).all(axis=1)

    @cached_property
    def _rates(self):
        return dkm(self._posed(self._rows), self.run.q_dot[self._rows])

    @property
    def acceleration(self) -> np.ndarray:
        return scattered(forward_dynamics(self._rates, self.tau[self._rows]).xi_ddot, self._rows)

    @property
    def velocity(self) -> np.ndarray:
        rows = np.isfinite(self.run.q_dot).all(axis=1)
        return scattered(dkm(self._posed(rows), self.run.q_dot[rows]).xi_dot, rows)


class OfReference(OfRobot):
    """A plan, or a reference in the working modes (-1, -1)."""

    def __init__(self, robot: Robot, reference: Callable):
        super().__init__(robot)
        self.reference = reference
        times = grid(reference.duration)
        xi = reference(reference.start + times)[0]
        found = self._posed(reference.start + times, xi, "nan")
        reached = np.where(np.isfinite(found.elbows).all(axis=(1, 2))[:, None], xi, np.nan)
        self.frames = choose(reference.start + times, reached, lack="are out of reach")
        self.xi = xi[self.frames.index]
        self.pose = self._posed(self.times, self.xi, "raise")
        self.elbows = self.pose.elbows

    def _posed(self, times, xi, unreachable):
        """Where modes change on the way, the plan knows the bars."""
        modes = getattr(self.reference, "working", (-1, -1))
        if modes is None:
            return self.reference.accelerations(times).rates.pose
        return igm(self.robot, xi, modes, unreachable=unreachable)

    @property
    def times(self) -> np.ndarray:
        return self.frames.start + self.frames.t

    @property
    def _rows(self):
        return np.ones(len(self.xi), dtype=bool)

    @property
    def events(self) -> Iterator[Notice]:
        for t, kind, margin, k, share in crossings(self.frames.t, self.pose):
            place = self.xi[k] + share * (self.xi[k + 1] - self.xi[k])
            text = (
                f"Type {kind} singularity ({self.robot.words.sines[margin]} = 0) at"
                f" {self.frames.start + t:.4g} s"
            )
            yield Notice(t, text, tuple(place.tolist()))

    @property
    def velocity(self) -> np.ndarray:
        return self.reference(self.times)[1]

    @property
    def acceleration(self) -> np.ndarray:
        return self.reference(self.times)[2]

    @cached_property
    def _rates(self):
        if getattr(self.reference, "working", ()) is None:
            return self.reference.accelerations(self.times).rates
        return ikm(self.pose, self.velocity)

    @cached_property
    def tau(self) -> np.ndarray:
        planned = getattr(self.reference, "tau", None)
        return (
            planned(self.times)
            if planned
            else inverse_dynamics(ikm2(self._rates, self.acceleration))
        )
