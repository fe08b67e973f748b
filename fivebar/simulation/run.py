"""What a simulation leaves: a Run, with its errors and events, saved to CSV and read back."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import chain
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import positive, shown
from ..base.presentation import Animated
from ..base.representation import one_line
from ..base.tables import FilePath, Table, TextFile, write
from ..models.four_joints import rates_from_joint_state
from ..models.geometry import igm
from ..models.joint_positions import beside_joint, elbows, joints
from ..models.loads import potential
from ..models.motors import Motor, both_motors, torque_bounds
from ..models.parameters import robot_of
from ..models.physics import loads_of
from ..models.robots import Robot
from ..singularities.margins import Singularity

# Columns of a tool, for those who read the file.
DRAWN = {"drawn": ["x_tip", "y_tip"], "drawn_ref": ["x_tip_ref", "y_tip_ref"]}


class Event(NamedTuple):
    """A crossing of a singularity.

    t: s; type; margin: the name of the sine that vanished; before, after: the modes (left, right,
    assembly).
    """

    t: float
    type: Singularity
    margin: str
    before: tuple
    after: tuple


class Control(NamedTuple):
    """The controller's samples.

    t (k,) s; q, q_dot (k, 2): what it measured; commanded (k, 2) N m: its torques; applied (k, 2):
    these after delay and limit.
    """

    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    commanded: np.ndarray
    applied: np.ndarray


class Measured(NamedTuple):
    """What is known of a run from a log.

    gaps: (from, to, why) s, each with a row of nan; notes: what was done to its rows; rates:
    whether q_dot was logged, and not differentiated; held: whether each torque is held until the
    next, and not that of its time.
    """

    gaps: tuple = ()
    notes: tuple = ()
    rates: bool = False
    held: bool = False


def torque_limits(value: object, name: str) -> Any:
    """Rule: a number > 0, or both motors; ValueError or TypeError for anything else."""
    if isinstance(value, tuple | list) and any(isinstance(each, Real) for each in value):
        raise TypeError(f"{name} is one number for both joints, or motors, not {shown(value)}")
    if isinstance(value, Motor | tuple | list | str):
        return both_motors(value, name)
    return positive(value, name)


def has_friction(robot: Robot) -> bool:
    """Return whether friction takes energy from the robot's motion."""
    return loads_of(robot).has_friction


OPTIONAL = "xi_ref", "friction_loss", "control"  # fields that not every run has


def columns(robot: Robot) -> dict[str, list[str]]:
    """Return the names of the columns of a run's CSV file, by the fields of the Run."""
    joints = robot.words.joints
    rates = [f"{name}_dot" for name in joints]
    measured = [f"{name}_measured" for name in (*joints, *rates)]
    return {
        "t": ["t"],
        "q": [*joints],
        "q_dot": rates,
        "xi": ["x", "y"],
        "tau": ["tau1", "tau2"],
        "energy": ["energy"],
        "xi_ref": ["x_ref", "y_ref"],
        "friction_loss": ["friction_loss"],
        "control": [*measured, "tau1_commanded", "tau2_commanded"],
    }


@dataclass(frozen=True, eq=False)
class Run(Animated):
    """A motion, from `simulate` or a log, row by row; of a biglide, q is in m and tau in N.

    Parameters
    ----------
    robot : FiveBar or Biglide
    t : (n,), s
    q, q_dot : (n, 2), rad, rad/s
        q is continuous.
    xi : (n, 2), m
    tau : (n, 2), N m
        Each row is held until the next.
    energy : (n,), J
        Kinetic energy; `potential` is the other.
    xi_ref : (n, 2), m, optional
        The reference.
    torque_limit : float or (2,) of Motor, optional
        N m.
    control : Control, optional
        The controller's own samples.
    events : tuple of Event
        The crossings of singularities.
    step_error : float, optional
        rad, a bound on the error of q, where `simulate` was given a tolerance.
    log : object, optional
        What the controller kept in its own `log`, as a Tracker does.
    friction_loss : (n,), J, optional
        What friction, and the torques of a LoadedRobot, have taken from the drives' work; by
        Simpson's rule after fixed steps. None without them.
    measured : Measured, optional
        What is known of a run from a log.
    tool : (leg, along, across), optional
        Of a `Tool` on a distal bar, m; `error` is then the tool's.

    Examples
    --------
    >>> import fivebar as fb
    >>> run = fb.simulate(fb.FiveBar(), duration=0.1)
    >>> run.q.shape, float(run.energy_error.max())
    ((101, 2), 0.0)
    """

    robot: Robot
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    xi: np.ndarray
    tau: np.ndarray
    energy: np.ndarray
    xi_ref: np.ndarray | None = None
    torque_limit: float | tuple[Motor, Motor] | None = None
    control: Control | None = None
    events: tuple = ()
    step_error: float | None = None
    log: object | None = None
    friction_loss: np.ndarray | None = None
    measured: Measured | None = None
    tool: tuple[int, float, float] | None = None

    def __repr__(self) -> str:
        parts = [self.robot.words.title, f"{self.t[-1]:g} s in {len(self.t)} rows"]
        if self.xi_ref is not None:
            largest = np.nanmax(np.linalg.norm(self.error, axis=1))
            micrometres = 1e6 * largest
            parts.append(f"error at most {micrometres:.4g} um")
        if self.events:
            parts.append(f"{len(self.events)} crossings")
        return one_line("Run", *parts)

    @cached_property
    def error(self) -> np.ndarray:
        """drawn - drawn_ref (n, 2), m: without a tool xi - xi_ref."""
        self._reference()
        return self.drawn - self.drawn_ref

    @cached_property
    def drawn(self) -> np.ndarray:
        """Where the tool is (n, 2), m; without one xi."""
        return self._at_tool(elbows(self.robot, self.q), self.xi)

    @cached_property
    def drawn_ref(self) -> np.ndarray | None:
        """Where the tool is to be (n, 2), m, in the modes of the start; without a tool xi_ref."""
        if self.tool is None or self.xi_ref is None:
            return self.xi_ref
        pose = igm(self.robot, self.xi_ref, self._working_at_start(), unreachable="nan")
        return self._at_tool(pose.elbows, self.xi_ref)

    def _at_tool(self, pivots, xi):
        if self.tool is None:
            return xi
        leg, along, across = self.tool
        return beside_joint(pivots[:, leg - 1], xi, along, across)

    @cached_property
    def q_error(self) -> np.ndarray:
        """q - q_ref (n, 2), rad (m), in the working modes in which the run begins.

        nan where xi_ref is out of reach.
        """
        working = self._working_at_start()
        xi_ref = self._reference()
        reference = igm(self.robot, xi_ref, working, unreachable="nan")
        return self.robot.joint_difference(self.q - reference.q)

    def _working_at_start(self):
        at_rest = (0.0, 0.0)
        start = rates_from_joint_state(self.robot, self.q[0], self.xi[0], at_rest, at_rest)
        return tuple(-1 if sine > 0 else 1 for sine in start.pose.sines)

    def _reference(self) -> np.ndarray:
        if self.xi_ref is None:
            raise ValueError("this run has no reference, so no error")
        return self.xi_ref

    @property
    def largest_torque(self) -> float | None:
        """Largest torque that the limit allows, N m; None without a limit."""
        if isinstance(self.torque_limit, tuple):
            return max(motor.torque for motor in self.torque_limit)
        return self.torque_limit

    @property
    def saturated(self) -> np.ndarray:
        """Where each torque is at its limit: (n, 2) bool; nowhere without a limit."""
        if self.torque_limit is None:
            return np.zeros(self.tau.shape, dtype=bool)
        # Motors are limited by their speed at each row.
        low, high = torque_bounds(self.torque_limit, self.q_dot)
        rounding = 1e-12 * np.max(np.abs([low, high]))
        at_limit = (self.tau <= low + rounding) | (self.tau >= high - rounding)
        at_limit[-1] = at_limit[-2:][0]  # the last row repeats the torque before it
        return at_limit

    @cached_property
    def energy_error(self) -> np.ndarray:
        """Energy less what the drives put in since the start, (n,) J: 0 but for the steps' errors.

        Potential energy counts too, and what friction took.
        """
        work = np.sum(np.diff(self.q, axis=0) * self.tau[:-1], axis=1)
        whole = self.energy + self.potential
        if self.friction_loss is not None:
            whole = whole + self.friction_loss
        put_in = np.concatenate([[0.0], np.cumsum(work)])
        return whole - whole[0] - put_in

    @cached_property
    def potential(self) -> np.ndarray:
        """Potential energy (n,) J, 0 without gravity."""
        rest = (0.0, 0.0)
        motion = rates_from_joint_state(self.robot, self.q.T, self.xi.T, rest, rest)
        return potential(motion.pose) + np.zeros(len(self.t))

    @cached_property
    def loop_gap(self) -> np.ndarray:
        """Distance from elbow to end-effector less the distal bar's length, per leg: (n, 2) m."""
        distal = self.xi[:, None] - elbows(self.robot, self.q)
        lengths = np.hypot(*np.moveaxis(distal, -1, 0))
        return lengths - self.robot.distal

    @property
    def points(self) -> np.ndarray:
        """Base joint, elbow, end-effector, elbow, base joint: (n, 5, 2) m.

        Of a biglide foot, end-effector, foot.
        """
        return joints(self.robot, elbows(self.robot, self.q), self.xi)

    def to_bag(self, folder: FilePath) -> None:
        """Write a bag of ROS 2 that PlotJuggler and Foxglove open, to a new folder.

        Its topics are /joint_states, /end_effector and /end_effector_reference. It needs the
        package rosbags (`pip install fivebar[ros]`).
        """
        from .bags import write_bag

        write_bag(self, folder)

    def to_csv(self, path: TextFile) -> None:
        """Write the run in SI units; what is not in its rows, but the log, is in a comment line.

        What the controller measured and commanded is nan in rows between its samples.
        """
        limit = self.torque_limit
        if isinstance(limit, tuple):
            limit = [asdict(motor) for motor in limit]
        about: dict[str, Any] = {
            "robot": self.robot.parameters,
            "torque_limit": limit,
            "events": [list(e) for e in self.events],
        }
        if self.tool is not None:
            about["tool"] = list(self.tool)
        if self.step_error is not None:
            about["step_error"] = self.step_error
        if self.measured is not None:
            about["measured"] = self.measured._asdict()
        known = columns(self.robot)
        values = {name: getattr(self, name) for name in known}
        if self.friction_loss is None and has_friction(self.robot):
            values["friction_loss"] = np.full(len(self.t), np.nan)
        if self.control is not None:
            values["control"] = np.full((len(self.t), 6), np.nan)
            at = np.searchsorted(self.t, self.control.t)
            values["control"][at] = np.column_stack(self.control[1:4])
        if self.tool is not None:
            known |= DRAWN
            values |= {name: getattr(self, name) for name in DRAWN}
        used = {name: value for name, value in values.items() if value is not None}
        header = list(chain.from_iterable(known[name] for name in used))
        rows = np.column_stack([*used.values()])
        write(path, "run", about, header, rows.tolist())

    @classmethod
    def from_csv(cls, path: TextFile) -> Run:
        """Read what `to_csv` wrote.

        Raises
        ------
        ValueError
            With file and line, for what is not such a file.
        """
        table = Table(path)
        about = table.about("run", "a file written by Run.to_csv", _known)
        known = columns(about["robot"])
        used = []
        for name, (first, *_) in known.items():
            if name not in OPTIONAL or first in table.header:
                used.append(name)
        header = list(chain.from_iterable(known[name] for name in used))
        ends = np.cumsum([len(known[name]) for name in used])
        values = table.numbers(header, finite=False)
        parts = np.split(values, ends[:-1], axis=1)
        fields: dict[str, Any] = {}
        for name, part in zip(used, parts):
            fields[name] = part[:, 0] if part.shape[1] == 1 else part
        if "control" in fields:
            at = np.isfinite(fields["control"]).all(axis=1)
            q, q_dot, commanded = np.split(fields["control"][at], 3, axis=1)
            fields["control"] = Control(
                fields["t"][at], q, q_dot, commanded, applied=fields["tau"][at]
            )
        return cls(**fields, **about)


def _known(about):
    """Return the fields of a Run that are in the comment line of its file."""
    limit = about["torque_limit"]
    if isinstance(limit, list):
        limit = torque_limits(limit, "torque_limit")
    elif limit is not None:
        limit = float(limit)
    error = about.get("step_error")
    measured = about.get("measured")
    tool = about.get("tool")
    return {
        "robot": robot_of(about["robot"]),
        "torque_limit": limit,
        "step_error": None if error is None else float(error),
        "events": tuple(_event(*event) for event in about["events"]),
        "measured": None if measured is None else _measured(**measured),
        "tool": None if tool is None else _tool(*tool),
    }


def _event(t, kind, margin, before, after):
    return Event(float(t), Singularity(kind), str(margin), tuple(before), tuple(after))


def _tool(leg, along, across):
    return int(leg), float(along), float(across)


def _measured(gaps, notes, rates, held=False):
    read = []
    for low, high, why in gaps:
        read.append((float(low), float(high), str(why)))
    return Measured(tuple(read), tuple(map(str, notes)), bool(rates), bool(held))
