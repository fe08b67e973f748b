"""One way to all formats: `fb.export`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..base.checks import (
    instance,
    modes,
    one_of,
    optional,
    positive,
    seconds,
    shown,
    strings,
    takes,
    text,
    two_numbers,
)
from ..base.robot_uses import AnyRobot, used
from ..base.tables import TextFile, written
from ..models.geometry import Pose
from ..paths.machine import Machine
from ..paths.timing.timed_path import TimedPath
from .bodies import start_of
from .gcode import Gcode, gcode
from .header import header
from .mjcf import mjcf
from .reprapfirmware import reprapfirmware
from .ros2_control import ros2_control
from .sdf import CLOSURES, sdf
from .urdf import urdf

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

OPTIONS = {  # of each format
    "mjcf": ("start", "step"),
    "urdf": ("start",),
    "sdf": ("start", "step", "closure"),
    "c": ("functions",),
    "reprapfirmware": ("working", "homing_deg", "steps_per_turn"),
    "ros2_control": ("start", "plugin"),
    "gcode": ("machine", "dialect"),
}
WRITERS: dict[str, Callable[..., str]] = {"mjcf": mjcf, "urdf": urdf, "sdf": sdf}


def _identifier(value, name):
    if not re.fullmatch(r"[A-Za-z]\w*", text(value, name), re.ASCII):
        raise ValueError(f"{name} must be a letter, then letters, digits and _, not {shown(value)}")
    return value


@takes(
    format=one_of(*OPTIONS),
    machine=optional(instance(Machine)),
    dialect=optional(instance(Gcode)),
    working=optional(modes(2)),
    homing_deg=optional(two_numbers),
    steps_per_turn=optional(positive),
    plugin=optional(text),
    start=optional(instance(Pose)),
    step=optional(seconds),
    closure=optional(one_of(*CLOSURES)),
    functions=optional(strings),
    name=optional(_identifier),
)
def export(
    robot: AnyRobot | TimedPath,
    format: str,
    out: TextFile | None = None,
    start: Pose | None = None,
    step: float | None = None,
    closure: str | None = None,
    functions: Iterable[str] | None = None,
    name: str | None = None,
    machine: Machine | None = None,
    dialect: Gcode | None = None,
    working: ArrayLike | None = None,
    homing_deg: tuple[float, float] | None = None,
    steps_per_turn: float | None = None,
    plugin: str | None = None,
) -> str:
    """Write the robot, or a motion, in the format of another program.

    Simulators get bodies that move exactly as the base parameters do; the coordinates of their
    joints are those of the robot. The head of each file says how its simulator closes the loop, and
    with what error.

    Parameters
    ----------
    robot : FiveBar, Biglide or Machine; of gcode a TimedPath
    format : "mjcf" (MuJoCo), "urdf", "sdf" (Drake, Gazebo), "c" (one C99 header), "reprapfirmware"
        (M669), "ros2_control" (URDF with its block), or "gcode" (axes that are joints)
    out : path or open text file to write it to as well, whole or not at all
    start : the pose that the file shows; by default q = (0, 0), where that closes
    step : s, time step of the simulator; of mjcf and sdf, by default 1 ms
    closure : of sdf: "constraint" for Drake (default), or "joint" for Gazebo
    functions : of c: which of `header.NAMES`, by default all
    name : of the model, and of c what all names begin with; by default fivebar or biglide
    machine : of gcode: the Machine whose readings are the axes
    dialect : of gcode: the `Gcode` that the firmware reads
    working : (2,) of reprapfirmware: working modes, by default (-1, -1)
    homing_deg : (2,) of reprapfirmware: angles of the proximal bars at their switches, degrees
    steps_per_turn : of reprapfirmware: steps of a turn of the motor
    plugin : of ros2_control: the hardware's, by default a mock

    Returns
    -------
    str
        The text of the file.

    Raises
    ------
    ValueError
        An option of another format, or a robot that no bodies of positive mass move as.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.export(fb.FiveBar(), "urdf").splitlines()[0]
    '<?xml version="1.0"?>'
    """
    options = dict(
        start=start,
        step=step,
        closure=closure,
        functions=functions,
        machine=machine,
        dialect=dialect,
        working=working,
        homing_deg=homing_deg,
        steps_per_turn=steps_per_turn,
        plugin=plugin,
    )
    given = {key: value for key, value in options.items() if value is not None}
    if foreign := [key for key in given if key not in OPTIONS[format]]:
        raise ValueError(
            f"{foreign[0]} is no option of {format}, which has {', '.join(OPTIONS[format])}"
        )
    content = _content(robot, format, name, given)
    if out is not None:
        with written(out) as file:
            file.write(content)
    return content


def _content(robot, format, name, given):
    if (format == "gcode") != isinstance(robot, TimedPath):
        raise TypeError(
            "export: gcode is written of a TimedPath, other formats of a robot, but format ="
            f" {format!r} and {shown(robot)}"
        )
    if format == "gcode":
        return gcode(robot, **given)
    machine = used(robot, f"export {format}")
    if not isinstance(machine, Machine):
        machine = Machine(machine)
    if format == "reprapfirmware":
        return reprapfirmware(machine, **given)
    name = name or type(machine.robot).__name__.lower()
    if format == "c":
        return header(machine.robot, name, **given)
    given["start"] = start_of(machine.robot, given.get("start"))
    if format == "ros2_control":
        return ros2_control(machine, name, **given)
    return WRITERS[format](machine.robot, name, **given)
