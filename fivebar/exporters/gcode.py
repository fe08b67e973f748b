"""Joint-space G-code of a timed path, for controllers that know nothing of the robot.

A controller moves its axes on straight lines of the joint space. The lines are as long as the tool
stays within a deviation and a speed error of the timed path, both measured between the lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import not_negative, number, one_of, optional, positive, shown
from ..models.geometry import dgm, igm
from ..paths.machine import Machine
from ..paths.timing.timed_path import TimedPath

INSIDE = np.arange(1, 8) / 8  # of a line, where deviation and speed are measured
USED = 0.8  # of the deviation and the speed error, which lines use; rounding takes the rest
MOST_LINES = 10**6
AXES = list("XYZABCUVW")
STILL = 1e-12  # rad, by which joints that rest may seem to move


class Firmware(NamedTuple):
    """What a controller's G-code differs in."""

    dwell: str  # word of seconds in G4
    inverse_time: bool  # whether it knows G93
    pens: tuple[str, ...]  # commands for a pen that it knows, the usual one first


FIRMWARES = {
    "grbl": Firmware("P", True, ("M3", "Z")),
    "fluidnc": Firmware("P", True, ("M3", "Z")),
    "linuxcnc": Firmware("P", True, ("M3", "Z")),
    "marlin": Firmware("S", False, ("Z", "servo", "M3")),
    "reprapfirmware": Firmware("S", False, ("Z", "servo", "M3")),
}
PENS = {  # (pen down, pen up, usual values)
    "M3": ("M3 S{down:g}", "M5", (1000.0, 0.0)),
    "servo": ("M280 P0 S{down:g}", "M280 P0 S{up:g}", (math.nan, math.nan)),
    "Z": ("G0 Z{down:g}", "G0 Z{up:g}", (0.0, 5.0)),
}


@dataclass(frozen=True)
class Gcode:
    """The G-code that a controller of joints reads.

    Parameters
    ----------
    firmware : str
        "grbl", "fluidnc", "linuxcnc", "marlin" or "reprapfirmware".
    axes : (2,)
        Letters of the left and the right joint.
    unit : "deg", "steps", "mm" or "rad", optional
        Of the axes. They count from the zeros and in the directions of the machine's readings;
        "rad" takes these as they are. By default deg, or mm of joints that slide, or as they are
        where they are not in rad or m.
    per_turn : float, optional
        Steps, microsteps included, or mm of the firmware in a turn of the motor; of "steps", and
        of "mm" where joints turn.
    gear : float
        Turns of the motor for one that the machine reads.
    feed : "inverse" or "units", optional
        G93, the time of each line, or G94, units a minute. By default G93 where the firmware has
        it.
    deviation : float
        Of the tool between the lines, m.
    speed_error : float
        Of the tool between the lines, as a share of its largest speed.
    max_feed : float, optional
        What each axis can do, units a minute.
    pen : "M3", "servo" or "Z", optional
        M3 and M5; the angles of a servo, M280; or heights of an axis Z, mm.
    down, up : float, optional
        S of M3, angles of the servo, or heights.
    approach : float
        rad, from so far below both joints come to where the pen goes down, by rapid moves: a
        backlash is on one side then, as long as the joints turn on.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.Gcode(unit="steps", per_turn=3200).inverse_time
    True
    """

    firmware: str = "grbl"
    axes: tuple[str, str] = ("X", "Y")
    unit: str | None = None
    per_turn: float | None = None
    gear: float = 1.0
    feed: str | None = None
    deviation: float = 2e-5
    speed_error: float = 0.01
    max_feed: float | None = None
    pen: str | None = None
    down: float | None = None
    up: float | None = None
    approach: float = 0.0

    def __post_init__(self) -> None:
        one_of(*FIRMWARES)(self.firmware, "Gcode: firmware")
        optional(one_of("deg", "steps", "mm", "rad"))(self.unit, "Gcode: unit")
        positive(self.gear, "Gcode: gear")
        optional(one_of("inverse", "units"))(self.feed, "Gcode: feed")
        optional(one_of(*PENS))(self.pen, "Gcode: pen")
        optional(positive)(self.per_turn, "Gcode: per_turn")
        optional(positive)(self.max_feed, "Gcode: max_feed")
        positive(self.deviation, "Gcode: deviation")
        number(self.speed_error, "Gcode: speed_error", 1e-6, 1.0)
        letters = self.axes if isinstance(self.axes, list | tuple | str) else ()
        known = [letter for letter in AXES if letter in letters]
        if len(letters) != 2 or len(known) != 2:
            raise ValueError(
                f"Gcode: axes must be two letters of {', '.join(AXES)}, not {shown(self.axes)}"
            )
        object.__setattr__(self, "axes", tuple(letters))
        units = ("mm", "deg", "rad", None) if self.per_turn is None else ("steps", "mm")
        if self.unit not in units:
            raise ValueError(
                "Gcode: per_turn says how many steps or mm are a turn of the motor: unit='steps'"
                f" needs it, units other than steps and mm have none, but unit={self.unit!r} and"
                f" per_turn={self.per_turn}"
            )
        if self.feed == "inverse" and not FIRMWARES[self.firmware].inverse_time:
            raise ValueError(
                f"Gcode: {self.firmware} has no inverse time (G93): leave feed='units'"
            )
        if self._pen not in (pens := FIRMWARES[self.firmware].pens):
            raise ValueError(
                f"Gcode: {self.firmware} has no pen={self.pen!r}: take {' or '.join(pens)}"
            )
        if self._pen == "Z" and "Z" in self.axes:
            raise ValueError("Gcode: pen='Z' and a joint on the axis Z")
        for name in ("down", "up"):
            optional(number)(getattr(self, name), f"Gcode: {name}")
        down, up = self._pen_values
        if not abs(down - up) > 0:  # nan: a servo has no usual angles
            raise ValueError(
                f"Gcode: pen={self._pen!r} needs down and up that differ, as --pen-values DOWN UP:"
                f" with {down:g} and {up:g} it would not move"
            )
        not_negative(self.approach, "Gcode: approach")

    def unit_of(self, machine: Machine) -> str:
        """Return the unit of a machine's axes."""
        usual = "deg" if machine.robot.turns else "mm"
        return self.unit or (usual if machine.reads_si else "rad")

    def scale(self, machine: Machine) -> float:
        """Return how many units of the axes are 1 of a machine's readings."""
        return machine.scale(self.unit_of(machine), self.per_turn) * self.gear

    @property
    def _pen(self):
        return self.pen or FIRMWARES[self.firmware].pens[0]

    @property
    def _pen_values(self):
        _, _, usual = PENS[self._pen]
        return [known if own is None else own for own, known in zip((self.down, self.up), usual)]

    @property
    def inverse_time(self) -> bool:
        """Whether each line has its time, G93."""
        return (self.feed or "inverse") == "inverse" and FIRMWARES[self.firmware].inverse_time

    @property
    def pen_commands(self) -> tuple[str, str]:
        """What puts the pen up, and down."""
        down, up, _ = PENS[self._pen]
        values = dict(zip(("down", "up"), self._pen_values))
        return up.format(**values), down.format(**values)


def gcode(motion: TimedPath, machine: Machine | None = None, dialect: Gcode | None = None) -> str:
    """Return the joint-space G-code of a timed path.

    Parameters
    ----------
    motion : TimedPath
        In one assembly mode: across Type 2 the joints do not tell where the tool is.
    machine : Machine, optional
        Its readings are the axes, in `dialect.unit`.
    dialect : Gcode

    Returns
    -------
    str

    Raises
    ------
    ValueError
        A unit that could be two things, a speed beyond `dialect.max_feed`, or a path across Type 2.
    """
    robot: Any = motion.robot
    machine = Machine(robot) if machine is None else machine
    dialect = Gcode() if dialect is None else dialect
    if machine.robot != motion.robot:
        raise ValueError("gcode: the motion is of another robot than the machine")
    if motion.crossing.any():
        raise ValueError(
            "gcode: the path crosses Type 2, where the joints do not tell the place of the tool:"
            " draw it in one assembly mode"
        )
    scale = dialect.scale(machine)
    t = _line_ends(motion, dialect)
    q, _ = motion.joints(t)
    values = machine.readings(_in_range(machine, q)) * scale
    decimals = _decimals(motion, machine, dialect, t, scale)
    values = np.round(values, decimals) + 0.0  # without -0
    _refuse_fast(t, values, machine, dialect)
    head = _head(motion, machine, dialect, t)
    back = dialect.approach * scale / np.array(machine.ratio)
    lines = _lines(motion, dialect, t, values, decimals, back)
    return "\n".join([*head, *lines]) + "\n"


def _in_range(machine, q):
    """Return continuous joint coordinates in the turn in the middle of the joint limits; without
    limits a proximal bar is within half a turn of upwards.
    """
    q = machine.robot.continuous(q)
    if machine.robot.turns:
        for leg, limits in enumerate(machine.constraints.joints or (None, None)):
            wanted = math.pi / 2 if limits is None else sum(limits) / 2
            middle = (q[:, leg].min() + q[:, leg].max()) / 2
            q[:, leg] += 2 * math.pi * round((wanted - middle) / (2 * math.pi))
    return q


def _line_ends(motion, dialect):
    """Return the times (n,) at which lines end, in order, from 0 to the duration."""
    stops = motion.path.stops
    leaves = np.interp([stop.s for stop in stops], motion.s, motion.times)
    arrives = leaves - [stop.seconds for stop in stops]
    pen_changes, _ = motion.pen_changes
    edges = np.concatenate([[0.0, motion.duration], pen_changes, leaves, arrives])
    t = np.unique(np.clip(edges, 0.0, motion.duration))
    same = np.diff(t) <= STILL * motion.duration
    t = t[~np.append(False, same)]
    most_off = USED * dialect.deviation
    most_faster = USED * dialect.speed_error * _largest_speed(motion)
    while True:
        off, faster = _errors(motion, t)
        lacks = np.maximum(off / most_off, faster / most_faster)
        if lacks.max() <= 1:
            return t
        # Errors go with the first or the second power of the time: parts for the first are enough.
        parts = np.clip(np.ceil(lacks), 1, 8).astype(int)
        if parts.sum() > MOST_LINES:
            raise ValueError(
                f"gcode: more than {MOST_LINES} lines keep a deviation of {dialect.deviation:g} m"
                f" and a speed error of {dialect.speed_error:g}: allow more of them"
            )
        starts = np.repeat(t[:-1], parts)
        steps = np.repeat(np.diff(t) / parts, parts)
        firsts = np.repeat(np.cumsum(parts) - parts, parts)
        number_in_line = np.arange(len(steps)) - firsts
        t = np.append(starts + steps * number_in_line, t[-1])


def _largest_speed(motion):
    t = np.linspace(0.0, motion.duration, 4001)
    return float(np.linalg.norm(tip_motion(motion, t)[1], axis=-1).max())


def tip_motion(motion: TimedPath, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return place and velocity (n, 2), m, m/s, of the tool, or of C where there is none."""
    k, gone, speed, _ = motion.along(t)
    tip, tip_s, *_ = motion.path.drawn.on(motion.piece[k], motion.first[k] + gone)
    return tip, tip_s * speed[..., None]


def _errors(motion, t):
    """Return deviation, m, and speed error, m/s, on each line between times t: (2, n - 1)."""
    q = motion.robot.continuous(motion.joints(t)[0])
    _, _, off, faster = along_lines(motion, t, q)
    lacks = np.nan_to_num(np.stack([off, faster]), nan=np.inf)
    return lacks.reshape(2, -1, len(INSIDE)).max(axis=2)


def along_lines(
    motion: TimedPath, t: np.ndarray, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return times, places, m, and by how much these and the speeds are off, m and m/s.

    With the joints on straight lines from q (n, 2) to q at times t (n,); nan where they do not
    close.
    """
    since = np.diff(t)[:, None] * INSIDE
    rates = np.diff(q, axis=0) / np.diff(t)[:, None]
    times = (t[:-1, None] + since).ravel()
    lined = q[:-1, None] + rates[:, None] * since[..., None]
    own_rates = np.repeat(rates, len(INSIDE), axis=0)
    place, velocity = moved_tip(motion, lined.reshape(-1, 2), own_rates)
    tip, wanted = tip_motion(motion, times)
    off = np.linalg.norm(place - tip, axis=-1)
    speed = np.linalg.norm(velocity, axis=-1)
    faster = np.abs(speed - np.linalg.norm(wanted, axis=-1))
    return times, place, off, faster


def moved_tip(motion: TimedPath, q: np.ndarray, q_dot: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return place and velocity (n, 2) of the tool with the joints at q, nan where none closes."""
    start = igm(motion.robot, motion(0.0)[0], motion.working)
    pose = dgm(motion.robot, q, int(start.assembly), unreachable="nan")
    tool = motion.path.tool
    if tool is None:
        return pose.xi, np.einsum("nij,nj->ni", pose.J, q_dot)
    return tool.tool.point(pose), np.einsum("nij,nj->ni", tool.tool.jacobian(pose), q_dot)


def _decimals(motion, machine, dialect, t, scale):
    """Return so many decimals of the axes that rounding takes little of what is allowed."""
    q, _ = motion.joints(t)
    moved = 0.0  # m, by a unit of both axes
    for rates in np.diag(machine.ratio) / scale:
        _, velocity = moved_tip(motion, q, np.tile(rates, (len(q), 1)))
        moved += np.linalg.norm(velocity, axis=-1).max()
    # Rounding moves each end of a line by half a unit at most, so the way along it changes by one.
    shortest = np.diff(t).min()
    most_off = min(dialect.deviation, dialect.speed_error * _largest_speed(motion) * shortest)
    return max(0, math.ceil(-math.log10((1 - USED) * most_off / moved)))


def _refuse_fast(t, values, machine, dialect):
    if dialect.max_feed is None:
        return
    feed = 60 * np.abs(np.diff(values, axis=0)) / np.diff(t)[:, None]
    k, axis = np.unravel_index(feed.argmax(), feed.shape)
    if feed[k, axis] > dialect.max_feed:
        unit = dialect.unit_of(machine)
        unit = "readings" if unit == "rad" else unit
        raise ValueError(
            f"gcode: axis {dialect.axes[axis]} moves at {feed[k, axis]:.5g} {unit}/min at"
            f" t = {t[k]:.4g} s, beyond the {dialect.max_feed:g} of the firmware: limit the joint"
            f" speeds to {dialect.max_feed / feed[k, axis]:.3g} of what they are there"
        )


def _head(motion, machine, dialect, t):
    unit = dialect.unit_of(machine)
    unit = {"deg": "degrees", "rad": "readings"}.get(unit, unit)
    scale = dialect.scale(machine)
    angles = []
    for name, axis, ratio, offset in zip(
        motion.robot.words.joints, dialect.axes, machine.ratio, machine.offset
    ):
        angles.append(
            f"{name} = {ratio / scale:.9g} {axis} + {offset:.9g} {motion.robot.words.unit}"
        )
    per_turn = "" if dialect.per_turn is None else f", {dialect.per_turn:g} a turn of the motor"
    per_turn += "" if dialect.gear == 1 else f", gear {dialect.gear:g}"
    tip = "joint C" if motion.path.tool is None else "the tool"
    about = (
        f"fivebar: joint angles of a {motion.robot.words.title}, working modes {motion.working}",
        f"axes {dialect.axes[0]} left, {dialect.axes[1]} right, in {unit}{per_turn}",
        ", ".join(angles),
        f"{motion.duration:.6g} s, {len(t) - 1} lines, at most"
        f" {1 / np.diff(t).min():.4g} lines/s; {tip} within {1e6 * dialect.deviation:g} um",
        "the first move is straight in the joints: start near its end",
    )
    mark = "; {}" if FIRMWARES[dialect.firmware].dwell == "S" else "({})"
    if mark == "({})":
        about = [line.replace("(", "[").replace(")", "]") for line in about]
    return [*(mark.format(line) for line in about), "G21", "G90"]


def _lines(motion, dialect, t, values, decimals, back):
    up, down = dialect.pen_commands
    dwell = "G4 " + FIRMWARES[dialect.firmware].dwell
    x, y = dialect.axes

    def place(row):
        return f"{x}{row[0]:.{decimals}f} {y}{row[1]:.{decimals}f}"

    yield up
    yield f"G0 {place(values[0])}"
    if dialect.inverse_time:
        yield "G93"
    changes, states = motion.pen_changes
    pen = dict(zip(np.searchsorted(t, changes - STILL * motion.duration).tolist(), states.tolist()))
    is_down = False
    moves = np.diff(motion.robot.continuous(motion.joints(t)[0]), axis=0)
    rests = np.abs(moves).max(axis=1) < STILL
    for k, seconds in enumerate(np.diff(t).tolist()):
        if pen.get(k, is_down) != is_down:
            is_down = not is_down
            if is_down and dialect.approach:
                yield f"G0 {place(values[k] - back)}"
                yield f"G0 {place(values[k])}"
            yield down if is_down else up
        if rests[k]:
            yield f"{dwell}{seconds:.6g}"
        else:
            way = 1.0 if dialect.inverse_time else np.hypot(*(values[k + 1] - values[k]))
            yield f"G1 {place(values[k + 1])} F{60 * way / seconds:.7g}"
    if is_down:
        yield up
    if dialect.inverse_time:
        yield "G94"
    yield "M2" if FIRMWARES[dialect.firmware].dwell == "P" else "M400"
