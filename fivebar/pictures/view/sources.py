"""What moves, read as it is asked for: a run, a reference or plan of a robot, a study of a linkage."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ...models.dyads import Crank
from ...models.dynamics import forward_dynamics, inverse_dynamics
from ...models.four_joints import four_joint_pose
from ...models.geometry import igm
from ...models.kinematics import dkm, ikm, ikm2
from .frames import choose, grid
from .machine import Event
from .robots import drawn
from .studies import OfStudy


def source(robot, motion):
    """The source of a motion: a Run, a Study, or a Plan or other reference that is called with the time.

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
        raise TypeError(f"a scene needs a Run, a Plan or other reference, or a Study, not {type(motion).__name__}")
    own = getattr(motion, "linkage", None) or getattr(motion, "robot", robot)
    if robot != own:
        raise ValueError(f"this motion is of another robot: {own}, not {robot}")
    return found


def scattered(values, rows):
    """Values (k, ...) at those rows (m,) bool that are true, nan at the others: (m, ...)."""
    full = np.full((len(rows), *values.shape[1:]), np.nan)
    full[rows] = values
    return full


class OfRobot:
    """A robot with two drives at the frames of a motion; q, xi (m, 2); everything else is computed when first read."""

    known = (
        "trace", "reference", "loci", "workspace", "elbow-circles", "velocity", "acceleration", "bar-forces",
        "torques", "ghost",
    )  # fmt: skip
    xi_ref = None

    @property
    def title(self):
        return self.robot.words.title

    @property
    def effort(self):
        return self.robot.words.effort

    @property
    def body(self):
        """The mechanism in words of Machine."""
        points, parts = drawn(self.robot, self.elbows, self.xi)
        return dict(points=points, **parts)

    @property
    def traced(self):
        """The end-effector's path, (m, 2) m."""
        return self.xi

    @cached_property
    def working(self):
        """Working modes (m, 2) without zeros: where a leg is in line, those before it."""
        modes = np.array(self.pose.working)
        for leg in modes.T:
            nonzero = np.flatnonzero(leg)
            first = nonzero[0] if len(nonzero) else 0
            leg[:] = leg[np.maximum.accumulate(np.where(leg != 0, np.arange(len(leg)), first))] if len(nonzero) else -1
        return modes

    @property
    def ghost(self):
        """The reference's positions in the modes of the motion, (m, k, 2) m, nan out of reach."""
        rows = np.isfinite(self.xi_ref).all(axis=1)
        pose = igm(self.robot, self.xi_ref[rows], self.working[rows], unreachable="nan")
        points = drawn(self.robot, pose.elbows, self.xi_ref[rows], frame=self.body["points"][rows])[0]
        points[np.isnan(points).any(axis=(1, 2))] = np.nan
        return scattered(points, rows)

    @property
    def bar_forces(self):
        """Forces of the distal bars on the end-effector, (m, 2 legs, 2) N, by least squares of m xi'' = A^T lambda and
        tau = Z q'' + B lambda, which together are regular at Type 1 and at Type 2."""
        acc, rows = self._accelerations, self._rows
        pose, scale = acc.rates.pose, sum(self.robot.distal) / 2
        both = np.concatenate([np.swapaxes(pose.A, 1, 2), pose.B / scale], axis=1)
        drives = (self.tau[rows] - self.robot.inertias * acc.q_ddot) / scale
        right = np.concatenate([self.robot.m * acc.xi_ddot, drives], axis=1)
        forces = np.linalg.pinv(both) @ right[..., None]
        return scattered(forces * pose.A, rows)

    @property
    def acceleration(self):
        return scattered(self._accelerations.xi_ddot, self._rows)

    @property
    def torques(self):
        """[(places (m, 2) m, direction (2,) of a force or None for a torque, values (m,))] of each drive."""
        found = []
        for k, drive in enumerate(self.robot.drives):
            if isinstance(drive, Crank):
                place = np.broadcast_to((drive.x, drive.y), self.xi.shape)
                found.append((place, None, self.tau[:, k]))
            else:
                found.append((self.elbows[:, k], np.array(drive.tangent(0.0)), self.tau[:, k]))
        return found


class OfRun(OfRobot):
    """A simulated run."""

    def __init__(self, run):
        self.robot = run.robot
        self.frames = choose(run.t, run.q, run.xi)
        thin = {name: getattr(run, name)[self.frames.index] for name in ("t", "q", "q_dot", "xi", "tau", "energy")}
        self.run = replace(run, **thin, xi_ref=None if run.xi_ref is None else run.xi_ref[self.frames.index])
        self.q, self.xi, self.tau, self.xi_ref = self.run.q, self.run.xi, self.run.tau, self.run.xi_ref

    @property
    def events(self):
        for event in self.run.events:
            t = event.t - self.frames.start
            place = tuple(float(np.interp(t, self.frames.t, column)) for column in self.xi.T)
            yield Event(t, f"Type {int(event.type)} singularity ({event.margin} = 0) at {event.t:.6g} s", place)

    @property
    def elbows(self):
        pivots = [drive.pivot(drive.direction(q)) for drive, q in zip(self.robot.drives, self.q.T)]
        return np.stack([np.stack(np.broadcast_arrays(*pivot), axis=-1) for pivot in pivots], axis=1)

    @cached_property
    def pose(self):
        return self._posed(slice(None))

    def _posed(self, rows):
        """The pose of joints and end-effector as they were simulated, singular or not."""
        q, spans = self.q[rows], np.moveaxis(self.xi[rows, None] - self.elbows[rows], -1, 0)
        phi = np.arctan2(spans[1], spans[0]).T
        passive = [drive.relative(*angles) for drive, *angles in zip(self.robot.drives, phi, q.T)]
        return four_joint_pose(self.robot, tuple(q.T), tuple(passive))

    @cached_property
    def _rows(self):
        """At which frames (m,) rates and torques are numbers."""
        return np.isfinite(self.run.q_dot).all(axis=1) & np.isfinite(self.tau).all(axis=1)

    @cached_property
    def _accelerations(self):
        rates = dkm(self._posed(self._rows), self.run.q_dot[self._rows])
        return forward_dynamics(rates, self.tau[self._rows])

    @property
    def velocity(self):
        rows = np.isfinite(self.run.q_dot).all(axis=1)
        return scattered(dkm(self._posed(rows), self.run.q_dot[rows]).xi_dot, rows)


class OfReference(OfRobot):
    """A plan, or a reference in the working modes (-1, -1)."""

    def __init__(self, robot, reference):
        self.robot, self.reference = robot, reference
        times = grid(reference.duration)
        modes = getattr(reference, "working", (-1, -1))
        xi = reference(reference.start + times)[0]
        found = igm(robot, xi, modes, unreachable="nan")
        reached = np.where(np.isfinite(found.elbows).all(axis=(1, 2))[:, None], xi, np.nan)
        self.frames = choose(reference.start + times, reached, lack="are out of reach")
        self.xi = xi[self.frames.index]
        self.pose = igm(robot, self.xi, modes)
        self.elbows = self.pose.elbows

    @property
    def times(self):
        return self.frames.start + self.frames.t

    @property
    def _rows(self):
        return np.ones(len(self.xi), dtype=bool)

    @property
    def events(self):
        sines = np.stack([*self.pose.sines, self.pose.det_A], axis=1)
        for k, margin in zip(*np.nonzero(sines[:-1] * sines[1:] < 0)):
            share = sines[k, margin] / (sines[k, margin] - sines[k + 1, margin])
            t = self.frames.t[k] + share * (self.frames.t[k + 1] - self.frames.t[k])
            place = self.xi[k] + share * (self.xi[k + 1] - self.xi[k])
            kind = 2 if margin == 2 else 1
            text = f"Type {kind} singularity ({self.robot.words.sines[margin]} = 0) at {self.frames.start + t:.4g} s"
            yield Event(float(t), text, tuple(place.tolist()))

    @property
    def velocity(self):
        return self.reference(self.times)[1]

    @property
    def acceleration(self):
        return self.reference(self.times)[2]

    @cached_property
    def _accelerations(self):
        return ikm2(ikm(self.pose, self.velocity), self.acceleration)

    @cached_property
    def tau(self):
        planned = getattr(self.reference, "tau", None)
        return planned(self.times) if planned else inverse_dynamics(self._accelerations)
