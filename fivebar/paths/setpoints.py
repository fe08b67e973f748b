"""Joint angles at a steady rate, for a drive that takes a table."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import (
    a_callable,
    bounded,
    instance,
    modes,
    one_of,
    optional,
    positive,
    two_numbers,
)
from ..base.representation import one_line
from ..base.robot_uses import takes_robot
from ..base.tables import TextFile, write, written
from ..control.laws import motion_at
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from ..models.robots import Robot
from ..planning.samples import SLOPES
from .machine import Machine
from .placement import Placement
from .tool import Tool

MOST_ROWS = 10**7
COLUMNS = {"rad": "", "deg": "_deg", "counts": "_counts", "turns": "_turns"}  # endings of columns


class Drive(NamedTuple):
    """What a kind of drive takes: so many of its unit a turn, which of them is the zero of the
    readings, and the least and largest whole number, or None for fractions.
    """

    per_turn: float
    zero: float
    limits: tuple[int, int] | None


INT32 = -(2**31), 2**31 - 1
DRIVES = {
    # Goal Position (116) of position mode, and of extended position mode: 4096 a turn.
    "dynamixel": Drive(4096, 2048, (0, 4095)),
    "dynamixel-extended": Drive(4096, 0, (-1_048_575, 1_048_575)),
    "odrive": Drive(1, 0, None),  # input_pos, turns
    "moteus": Drive(1, 0, None),  # position, revolutions
}


@dataclass(frozen=True, eq=False)
class Setpoints:
    """Joint coordinates of a motion at a steady rate, from `setpoints`.

    Attributes
    ----------
    t : (n,)
        s, even steps from the first instant to the last or the first row after it.
    xi, xi_dot, xi_ddot : (n, 2)
        m, m/s, m/s^2, of the tool where there is one.
    q, q_dot : (n, 2)
        rad, rad/s (m, m/s where a foot slides), continuous.
    pen : (n,) or None
        True where it is down.
    working : (2,) or None
        None where they change.
    tool : Tool or None
        Whose points xi are; None: joint C.
    """

    robot: Robot
    t: np.ndarray
    xi: np.ndarray
    xi_dot: np.ndarray
    xi_ddot: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    pen: np.ndarray | None = None
    working: tuple[int, int] | None = None
    tool: Tool | None = None

    def __repr__(self) -> str:
        rows = f"{len(self.t)} rows, {self.t[1] - self.t[0]:g} s apart"
        return one_line("Setpoints", self.robot.words.title, rows)

    def to_csv(
        self,
        path: TextFile,
        angles: str = "rad",
        machine: Machine | None = None,
        counts_per_turn: float | None = None,
    ) -> None:
        """Write t, x, y, the joint coordinates and their rates, and pen where there is one; then
        velocities and accelerations of x, y, for `from_csv` and `TimedPath.from_csv`.

        Parameters
        ----------
        path : path or open file
        angles : "rad", "deg", "turns" or "counts"
            Unit of the joint coordinates.
        machine : Machine, optional
            Then they are what its drives read, and x, y are points of its frame.
        counts_per_turn : float, optional
            Of the encoders, for counts, which are rounded.

        Raises
        ------
        ValueError
            For a unit that these joints do not have.
        """
        one_of(*COLUMNS)(angles, "angles")
        factor = self._machine(machine).scale(angles, counts_per_turn)
        frame = self._machine(machine).frame
        turned = replace(frame, shift=(0.0, 0.0))
        q, q_dot = self.q, self.q_dot
        about: dict[str, Any] = {"robot": self.robot.parameters, "working": self.working}
        if frame != Placement():
            about["frame"] = asdict(frame)
        if self.tool is not None:
            about["tool"] = asdict(self.tool)
        if machine is not None and machine.reads_otherwise:
            q, q_dot = machine.readings(q), q_dot / machine.ratio
            about |= {"offset": machine.offset, "ratio": machine.ratio}
        if angles != "rad":
            about["angles"] = angles
        q = np.round(q * factor) if angles == "counts" else q * factor
        joints = ("q1", "q2", "q1_dot", "q2_dot")
        names = ["t", "x", "y", *(f"{name}{COLUMNS[angles]}" for name in joints)]
        columns = [self.t, frame(self.xi), q, q_dot * factor]
        if self.pen is not None:
            names.append("pen")
            columns.append(self.pen)
        names += SLOPES
        columns += [turned(self.xi_dot), turned(self.xi_ddot)]
        rows = np.column_stack(columns).tolist()
        if self.pen is not None:
            for row in rows:
                row[7] = int(row[7])
        write(path, "setpoints", about, names, rows)

    def _machine(self, machine):
        return Machine(self.robot) if machine is None else machine

    def for_drives(
        self,
        drive: str | float,
        machine: Machine | None = None,
        zero: tuple[float, float] | None = None,
        wrap: bool = False,
    ) -> np.ndarray:
        """Return what both drives are told (n, 2).

        Parameters
        ----------
        drive : str or float
            "dynamixel", "dynamixel-extended", "odrive" or "moteus"; or the counts of a turn, which
            are whole numbers of 32 bits.
        machine : Machine, optional
            Then they are of what its drives read.
        zero : (2,), optional
            What the drives are told where the readings are 0; by default the middle of a Dynamixel
            in position mode, else 0.
        wrap : bool
            By whole turns into the limits of the drive, where it has a turn alone.

        Returns
        -------
        (n, 2) array
            int32 where the drive takes whole numbers, else float32.

        Raises
        ------
        ValueError
            A number beyond what the drive takes; the message names it.
        """
        if isinstance(drive, str):
            kind = DRIVES[one_of(*DRIVES)(drive, "for_drives: drive")]
        else:
            kind = Drive(positive(drive, "for_drives: drive"), 0, INT32)
        machine = self._machine(machine)
        zeros = (kind.zero, kind.zero) if zero is None else two_numbers(zero, "for_drives: zero")
        values = machine.readings(self.q) * machine.scale("counts", kind.per_turn) + zeros
        if kind.limits is None:
            return values.astype(np.float32)
        values = np.round(values)
        low, high = kind.limits
        has_one_turn = high - low < kind.per_turn
        wrap = wrap and has_one_turn
        if wrap:
            values -= kind.per_turn * np.floor((values - low) / kind.per_turn)
        beyond = (values < low) | (values > high)
        if beyond.any():
            row, motor = np.argwhere(beyond)[0]
            way_out = "give another zero (--zero-counts)"
            if has_one_turn:
                way_out += ", or wrap=True (--wrap)"
            raise ValueError(
                f"for_drives: motor {motor + 1} is to go to {values[row, motor]:.0f} at t ="
                f" {self.t[row]:.4g} s, beyond {low} to {high}: {way_out}"
            )
        if wrap and (jump := np.abs(np.diff(values, axis=0)) > kind.per_turn / 2).any():
            row, motor = np.argwhere(jump)[0]
            raise ValueError(
                f"for_drives: motor {motor + 1} would turn back by a whole turn at t ="
                f" {self.t[row]:.4g} s, where it passes the end of its range: give another zero"
                " (--zero-counts)"
            )
        return values.astype(np.int32)

    def to_drives(
        self,
        path: Any,
        drive: str | float,
        machine: Machine | None = None,
        zero: tuple[float, float] | None = None,
        wrap: bool = False,
    ) -> None:
        """Write t, q1, q2 and pen for both drives, as `for_drives` returns them, to a file.

        A file that ends in .bin has rows q1, q2 alone, of little-endian 32-bit integers or floats,
        at the steps of t.
        """
        values = self.for_drives(drive, machine, zero, wrap)
        if str(getattr(path, "name", path)).endswith(".bin"):
            with written(path, binary=True) as file:
                file.write(values.astype(values.dtype.newbyteorder("<")).tobytes())
            return
        about: dict[str, Any] = {"robot": self.robot.parameters, "drive": drive}
        names = ["t", "q1", "q2"]
        columns = [self.t.tolist(), *values.T.tolist()]
        if self.pen is not None:
            names.append("pen")
            columns.append(self.pen.astype(int).tolist())
        write(path, "setpoints", about, names, zip(*columns))


@takes_robot(
    reference=a_callable, rate=positive, working=optional(modes(2)), tool=optional(instance(Tool))
)
def setpoints(
    robot: Robot,
    reference: Any,
    rate: float = 1000.0,
    working: tuple[int, int] | None = None,
    tool: Tool | None = None,
) -> Setpoints:
    """Return the joint coordinates of a motion at a steady rate.

    If the duration is no multiple of the step, the last row is the first after the end, at the
    motion's last point.

    Parameters
    ----------
    robot : FiveBar or Biglide
    reference : callable
        A motion with a duration: t -> (xi, xi_dot, xi_ddot).
    rate : float
        Rows a second, Hz.
    working : (2,), optional
        Working modes; by default those of the reference, or (-1, -1).
    tool : Tool, optional
        Whose points x, y are; by default that of the reference, or joint C.

    Returns
    -------
    Setpoints

    Raises
    ------
    UnreachableError, SingularityError
        The motion is out of reach or crosses Type 1.

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar.paths.setpoints import setpoints
    >>> motion = fb.line((0.05, 0.09), (0.04, 0.09), 1.0)
    >>> setpoints(fb.FiveBar(), motion, rate=100.0).q.shape
    (101, 2)
    """
    steps = math.ceil(reference.duration * rate * (1 - 1e-12))
    bounded(
        steps,
        MOST_ROWS,
        f"setpoints: {reference.duration:g} s at {rate:g} Hz are {steps:.3g} rows",
        40,
    )
    t = np.arange(steps + 1) / rate
    times = getattr(reference, "start", 0.0) + t
    modes_own = getattr(reference, "working", None)
    xi, xi_dot, xi_ddot = motion_at(reference, times)
    # A plan may be free of modes.
    if working is None and modes_own is None and hasattr(reference, "joints"):
        motion = reference.accelerations(times)
    else:
        working = working or modes_own or (-1, -1)
        motion = ikm2(ikm(igm(robot, xi, working), xi_dot), xi_ddot)
    if tool is None and getattr(reference, "tool", None):
        tool = Tool(*reference.tool)
    if tool is not None:
        xi, xi_dot, xi_ddot = tool.motion(motion)
    q = motion.rates.pose.q
    return Setpoints(
        robot,
        t,
        xi,
        xi_dot,
        xi_ddot,
        np.unwrap(q, axis=0) if robot.turns else q,
        motion.rates.q_dot,
        reference.pen(times) if hasattr(reference, "pen") else None,
        working,
        tool,
    )
