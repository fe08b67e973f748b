"""Read joint-space G-code back and replay it: where the tool is when a controller runs it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import UnreachableError
from ..base.representation import one_line
from ..paths.machine import Machine
from ..paths.timing.timed_path import TimedPath
from .gcode import FIRMWARES, INSIDE, Gcode, along_lines, tip_motion

WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
COMMENT = re.compile(r"\([^()]*\)|;.*")
USUAL = Gcode()


@dataclass(frozen=True, eq=False)
class JointProgram:
    """What a controller does with joint-space G-code: straight lines in the joints.

    Attributes
    ----------
    t : (n + 1,)
        Times, s, at which lines begin and, last, end; without the rapid moves.
    axes : (n + 1, 2)
        Values of both axes at these times.
    down : (n,)
        Whether the pen is down on each line.
    """

    t: np.ndarray
    axes: np.ndarray
    down: np.ndarray

    def __repr__(self) -> str:
        return one_line("JointProgram", f"{len(self.down)} lines", f"{self.t[-1]:.6g} s")


@dataclass(frozen=True, eq=False)
class Replay:
    """How a replayed program differs from its timed path, at equal times.

    Attributes
    ----------
    t : (n,)
        s, places on all lines.
    tip : (n, 2)
        Where the tool is then, m.
    off : (n,)
        Its distance from where it should be, m.
    down : (n,)
        Whether the pen is down.
    speed_error : float
        Of the tool, as a share of its largest speed.
    duration : float
        s.
    pen_errors : int
        Lines on which the pen is not as it should be.
    """

    t: np.ndarray
    tip: np.ndarray
    off: np.ndarray
    down: np.ndarray
    speed_error: float
    duration: float
    pen_errors: int

    @property
    def deviation(self) -> float:
        """Largest distance, m."""
        return float(self.off.max())

    def __repr__(self) -> str:
        return one_line(
            "Replay",
            f"{1e6 * self.deviation:.4g} µm off",
            f"speeds off by {100 * self.speed_error:.3g} %",
            f"{self.duration:.6g} s",
            f"pen wrong on {self.pen_errors} lines" if self.pen_errors else "",
        )


def read_joint_gcode(text: str, dialect: Gcode = USUAL) -> JointProgram:
    """Return the lines of joint-space G-code.

    Read are G0, G1, G4, G21, G90, G93, G94, F, the axes and the pen of `dialect`, M2 and M400.

    Raises
    ------
    ValueError
        A line with anything else, or a feed that is missing; the message names the line.
    """
    return _Reader(dialect).read(text)


class _Reader:
    def __init__(self, dialect):
        self.dialect = dialect
        self.at = dict.fromkeys(dialect.axes)
        self.inverse = False
        self.feed = 0.0
        self.is_down = False
        self.rows = []  # (seconds, first axis, second axis, pen)
        self.start = None

    def read(self, text):
        for number, line in enumerate(text.splitlines(), 1):
            plain = COMMENT.sub(" ", line).upper().strip()
            if plain and not self._pen(plain):
                self._block(plain, number)
        if self.start is None or not self.rows:
            raise ValueError("joint G-code: no move")
        seconds, first, second, down = map(np.array, zip(*self.rows))
        axes = np.vstack([self.start, np.stack([first, second], axis=1)])
        return JointProgram(np.append(0.0, np.cumsum(seconds)), axes, down.astype(bool))

    def _pen(self, plain):
        for is_down, command in zip((False, True), self.dialect.pen_commands):
            if plain == command:
                self.is_down = is_down
                return True
        return False

    def _block(self, plain, number):
        words = WORD.findall(plain)
        known = {*self.dialect.axes, "G", "M", "F", "P", "S"}
        unknown = [letter for letter, _ in words if letter not in known]
        if WORD.sub("", plain).strip() or unknown:
            raise ValueError(f"joint G-code, line {number}: {plain!r} is not read")
        codes = [letter + digits for letter, digits in words if letter in "GM"]
        values = {letter: float(digits) for letter, digits in words if letter not in "GM"}
        code = codes[0] if len(codes) == 1 else ""
        if code in ("G21", "G90", "M2", "M400"):
            return
        if code in ("G93", "G94"):
            self.inverse, self.feed = code == "G93", 0.0
        elif code == "G4":
            seconds = values.get(FIRMWARES[self.dialect.firmware].dwell)
            if seconds is None:
                raise ValueError(f"joint G-code, line {number}: G4 without its seconds")
            self._add(seconds)
        elif code in ("G0", "G1"):
            self._move(code, values, number)
        else:
            raise ValueError(f"joint G-code, line {number}: {plain!r} is not read")

    def _move(self, code, values, number):
        before = self._place()
        for axis in set(values) & set(self.at):
            self.at[axis] = values[axis]
        place = self._place()
        if code == "G0":
            if not self.rows:
                self.start = place
            return
        self._refuse_jump(before, number)
        if self.inverse:
            self.feed = 0.0  # G93 wants an F in each line
        self.feed = values.get("F", self.feed)
        if not self.feed or before is None or None in before:
            raise ValueError(
                f"joint G-code, line {number}: a move without F, or from no known place"
            )
        way = 1.0 if self.inverse else float(np.hypot(*np.subtract(place, before)))
        self._add(60 * way / self.feed)

    def _refuse_jump(self, before, number):
        """Refuse rapid moves on the way that do not come back, as their time is not known."""
        last = self.rows[-1][1:3] if self.rows else self.start
        if last is not None and last != before:
            raise ValueError(
                f"joint G-code, line {number}: rapid moves before it led from {last} to {before}"
            )

    def _place(self):
        return tuple(self.at[axis] for axis in self.dialect.axes)

    def _add(self, seconds):
        self.rows.append((seconds, *self._place(), self.is_down))


def replayed(
    program: JointProgram, motion: TimedPath, machine: Machine | None = None, dialect: Gcode = USUAL
) -> Replay:
    """Return how a program differs from the timed path that it was written from.

    Raises
    ------
    UnreachableError
        The joints of the program cannot be reached.
    """
    robot: Any = motion.robot
    machine = Machine(robot) if machine is None else machine
    scale = dialect.scale(machine)
    q = machine.angles(program.axes / scale)
    times, place, off, faster = along_lines(motion, program.t, q)
    if not np.isfinite(place).all():
        raise UnreachableError("joint G-code: its joints cannot be reached", np.nan)
    _, wanted = tip_motion(motion, times)
    speed = np.linalg.norm(wanted, axis=-1)
    middle = (program.t[:-1] + program.t[1:]) / 2
    return Replay(
        times,
        place,
        off,
        np.repeat(program.down, len(INSIDE)),
        float(faster.max() / speed.max()),
        float(program.t[-1]),
        int((program.down != motion.pen(middle)).sum()),
    )
