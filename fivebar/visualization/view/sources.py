"""What moves, read as it is asked for: a run, a reference or plan of a robot, a study of a
linkage.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models.dynamics import bar_forces, drives_forces, forward_dynamics, inverse_dynamics
from ...models.geometry import Pose, igm
from ...models.joint_positions import elbows
from ...models.kinematics import dkm, ikm, ikm2
from ..loci import crossings
from ..skeleton import Skeleton, measured_pose, robot_body, study_body
from ..style import robot_title
from .frames import Frames, choose, grid, last_true
from .machine import Notice

if TYPE_CHECKING:
    from ...linkages import Study
    from ...models.kinematics import Rates
    from ...models.robots import Robot
    from ...simulation.run import Run


def source(robot: Any, motion: Any) -> RobotSource | StudySource:
    """Return the source of a motion: a Run, a Study, or a Plan or other reference.

    Raises ValueError for a motion of another robot, TypeError for what does not move.
    """
    subject = getattr(motion, "linkage", None) or getattr(motion, "robot", robot)
    if robot != subject:
        raise ValueError(f"this motion is of another robot: {subject}, not {robot}")
    if hasattr(motion, "linkage"):
        return StudySource(motion)
    if hasattr(motion, "xi_ref"):
        return RunSource(motion)
    if not hasattr(motion, "duration"):
        kind = type(motion).__name__
        raise TypeError(f"a scene needs a Run, a Plan or other reference, or a Study, not {kind}")
    if not hasattr(robot, "drives"):
        raise TypeError(f"a reference needs the robot that follows it, not {robot!r}")
    return ReferenceSource(robot, motion)


def scatter(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return values (k, ...) at those rows (m,) that are true, nan at the others: (m, ...)."""
    full = np.full((len(rows), *values.shape[1:]), np.nan)
    full[rows] = values
    return full


class StudySource:
    """A study of a linkage."""

    items = "trace", "velocity", "acceleration", "torques"
    effort = "torque"
    events = ()
    xi_ref = None

    def __init__(self, study: Study):
        self.study = study
        self.title = study.linkage.title
        self.heading = self.title
        body = study_body(study)
        self.frames = choose(study.t, body.points)
        self.body = body.at(self.frames.index)
        self.traced = self.body.points[:, self.body.traced]

    @property
    def velocity(self) -> np.ndarray:
        return self.study.motion.velocity(self.study.motion.chain.traced)[self.frames.index]

    @property
    def acceleration(self) -> np.ndarray:
        return self.study.motion.acceleration(self.study.motion.chain.traced)[self.frames.index]

    @property
    def torques(self) -> list[tuple]:
        crank = self.body.points[:, self.body.actuated[0]]
        return [(crank, None, self.study["torque"][self.frames.index])]


class RobotSource:
    """A robot with two drives at the frames of a motion; q, xi (m, 2).

    Everything else is computed when first read.
    """

    items = ("trace reference loci elbow-circles velocity acceleration bar-forces torques").split()
    items_of_tool = "trace reference elbow-circles torques".split()  # others are of joint C
    xi_ref: np.ndarray | None = None
    tool: tuple[int, float, float] | None = None  # leg, along, across, m

    frames: Frames
    xi: np.ndarray
    elbows: np.ndarray
    pose: Any  # Pose; computed when first read
    _rows: Any
    if TYPE_CHECKING:  # what the two kinds of motion add

        @property
        def tau(self) -> np.ndarray: ...

        @property
        def velocity(self) -> np.ndarray: ...

        @property
        def acceleration(self) -> np.ndarray: ...

        @property
        def events(self) -> Iterator[Notice]: ...

        @property
        def _rates(self) -> Rates: ...

    def __init__(self, robot: Robot):
        self.robot = robot
        if self.tool is not None:
            self.items = self.items_of_tool
        self.title = robot.words.title
        self.effort = robot.words.effort
        self.heading = robot_title(robot)

    @cached_property
    def body(self) -> Skeleton:
        return robot_body(self.robot, self.elbows, self.xi, self.tool)

    @property
    def traced(self) -> np.ndarray:
        """The path of the end-effector, or of the tool beside it, (m, 2) m."""
        return self.xi if self.tool is None else self.body.points[:, self.body.traced]

    @cached_property
    def working(self) -> np.ndarray:
        """Working modes (m, 2) without zeros: where a leg is in line, those before it."""
        modes = [leg[last_true(leg != 0)] for leg in self.pose.working.T]
        return np.where(np.array(modes) == 0, -1, modes).T

    @property
    def bar_forces(self) -> np.ndarray:
        """Forces of the distal bars on the end-effector, (m, 2 legs, 2) N."""
        rates, rows = self._rates, self._rows
        if all(self.robot.inertias):
            forces = bar_forces(rates, self.tau[rows])
        else:  # a reference: without inertia of a drive, what all drives say determines both
            acc = ikm2(rates, self.acceleration)
            forces = np.stack(drives_forces(acc, tuple(self.tau.T)), axis=-1)
        return scatter(forces[..., None] * rates.pose.A, rows)

    @property
    def torques(self) -> list[tuple]:
        """[(places (m, 2) m, direction (2,) of a force or None for a torque, values (m,))] of each
        drive.
        """
        return [
            (
                self.body.points[:, joint],
                None if self.robot.turns else np.array(drive.tangent(0.0)),
                tau,
            )
            for joint, drive, tau in zip(self.body.actuated, self.robot.drives, self.tau.T)
        ]


class RunSource(RobotSource):
    """A simulated run."""

    def __init__(self, run: Run):
        self.tool = run.tool
        super().__init__(run.robot)
        self.run = run
        self.frames = choose(run.t, run.q, run.xi)
        index = self.frames.index
        self.q = run.q[index]
        self.q_dot = run.q_dot[index]
        self.xi = run.xi[index]
        self.xi_ref = None if run.drawn_ref is None else run.drawn_ref[index]
        self.elbows = elbows(run.robot, self.q)

    @property
    def tau(self) -> np.ndarray:
        return self.run.tau[self.frames.index]

    @property
    def events(self) -> Iterator[Notice]:
        for event in self.run.events:
            t = event.t - self.frames.start
            place = tuple(float(np.interp(t, self.frames.t, column)) for column in self.xi.T)
            kind = f"Type {int(event.type)} singularity ({event.margin} = 0)"
            yield Notice(t, f"{kind} at {event.t:.6g} s", place)

    @cached_property
    def pose(self) -> Pose:
        return measured_pose(self.robot, self.q, self.xi)

    def _rates_at(self, rows):
        return dkm(measured_pose(self.robot, self.q[rows], self.xi[rows]), self.q_dot[rows])

    @cached_property
    def _rows(self):
        """At which frames (m,) rates and torques are numbers."""
        return np.isfinite([self.q_dot, self.tau]).all(axis=(0, 2))

    @cached_property
    def _rates(self):
        return self._rates_at(self._rows)

    @property
    def velocity(self) -> np.ndarray:
        rows = np.isfinite(self.q_dot).all(axis=1)
        return scatter(self._rates_at(rows).xi_dot, rows)

    @property
    def acceleration(self) -> np.ndarray:
        return scatter(forward_dynamics(self._rates, self.tau[self._rows]).xi_ddot, self._rows)


class ReferenceSource(RobotSource):
    """A plan, or a reference in the working modes (-1, -1)."""

    def __init__(self, robot: Robot, reference: Any):
        self.tool = getattr(reference, "tool", None)
        super().__init__(robot)
        self.reference = reference
        self.modes = getattr(reference, "working", (-1, -1))
        times = reference.start + grid(reference.duration)
        xi = reference(times)[0]
        reached = np.isfinite(self._pose_at(times, xi, "nan").elbows).all(axis=(1, 2))
        self.frames = choose(times, np.where(reached[:, None], xi, np.nan), lack="are out of reach")
        self.times = self.frames.start + self.frames.t
        self.xi = xi[self.frames.index]
        self.pose = self._pose_at(self.times, self.xi, "raise")
        self.elbows = self.pose.elbows
        self._rows = np.ones(len(self.xi), dtype=bool)

    def _pose_at(self, times, xi, unreachable):
        """Return where modes change on the way, the plan knows the bars."""
        if self.modes is None:
            return self.reference.accelerations(times).rates.pose
        return igm(self.robot, xi, self.modes, unreachable=unreachable)

    @property
    def events(self) -> Iterator[Notice]:
        for t, kind, margin, k, share in crossings(self.frames.t, self.pose):
            place = self.xi[k] + share * (self.xi[k + 1] - self.xi[k])
            margin = f"{self.robot.words.sines[margin]} = 0"
            text = f"Type {kind} singularity ({margin}) at {self.frames.start + t:.4g} s"
            yield Notice(t, text, tuple(place.tolist()))

    @property
    def velocity(self) -> np.ndarray:
        return self.reference(self.times)[1]

    @property
    def acceleration(self) -> np.ndarray:
        return self.reference(self.times)[2]

    @cached_property
    def _rates(self):
        if self.modes is None:
            return self.reference.accelerations(self.times).rates
        return ikm(self.pose, self.velocity)

    @cached_property
    def tau(self) -> np.ndarray:
        if hasattr(self.reference, "torques"):
            return self.reference.torques(self.times)
        return inverse_dynamics(ikm2(self._rates, self.acceleration))
