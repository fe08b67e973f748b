"""One way to all formats: `fb.export`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..base.checks import instance, one_of, optional, seconds, shown, strings, takes, text
from ..base.tables import TextFile, written
from ..models.geometry import Pose
from ..models.robots import KINDS, Biglide, FiveBar
from ..paths.machine import Machine
from ..paths.timing.timed_path import TimedPath
from .bodies import start_of
from .gcode import Gcode, gcode
from .header import header
from .mjcf import mjcf
from .sdf import CLOSURES, sdf
from .urdf import urdf

if TYPE_CHECKING:
    from collections.abc import Iterable

FORMATS = {  # endings of files
    "mjcf": ".xml",
    "urdf": ".urdf",
    "sdf": ".sdf",
    "c": ".h",
    "gcode": ".nc",
}
OPTIONS = {
    "gcode": ("machine", "dialect"),
    "mjcf": ("start", "step"),
    "urdf": ("start",),
    "sdf": ("start", "step", "closure"),
    "c": ("functions",),
}
WRITERS: dict[str, Callable[..., str]] = {"mjcf": mjcf, "urdf": urdf, "sdf": sdf, "c": header}


def _identifier(value, name):
    if not re.fullmatch(r"[A-Za-z]\w*", text(value, name), re.ASCII):
        raise ValueError(f"{name} must be a letter, then letters, digits and _, not {shown(value)}")
    return value


@takes(
    robot=instance(*KINDS, TimedPath),
    format=one_of(*FORMATS),
    machine=optional(instance(Machine)),
    dialect=optional(instance(Gcode)),
    start=optional(instance(Pose)),
    step=optional(seconds),
    closure=optional(one_of(*CLOSURES)),
    functions=optional(strings),
    name=optional(_identifier),
)
def export(
    robot: FiveBar | Biglide | TimedPath,
    format: str,
    out: TextFile | None = None,
    start: Pose | None = None,
    step: float | None = None,
    closure: str | None = None,
    functions: Iterable[str] | None = None,
    name: str | None = None,
    machine: Machine | None = None,
    dialect: Gcode | None = None,
) -> str:
    """Write the robot, or a motion, in the format of another program.

    Simulators get bodies that move exactly as the base parameters do; the coordinates of their
    joints are those of the robot. The head of each file says how its simulator closes the loop, and
    with what error.

    Parameters
    ----------
    robot : FiveBar or Biglide, or of gcode a TimedPath
    format : "mjcf" (MuJoCo), "urdf", "sdf" (Drake, Gazebo), "c" (one C99 header), or "gcode" (axes
        that are joints)
    out : path or open text file to write it to as well, whole or not at all
    start : the pose that the file shows; by default q = (0, 0), where that closes
    step : s, time step of the simulator; of mjcf and sdf, by default 1 ms
    closure : of sdf: "constraint" for Drake (default), or "joint" for Gazebo
    functions : of c: which of `header.NAMES`, by default all
    name : of the model, and of c what all names begin with; by default fivebar or biglide
    machine : of gcode: the Machine whose readings are the axes
    dialect : of gcode: the `Gcode` that the firmware reads

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
    )
    given = {key: value for key, value in options.items() if value is not None}
    if foreign := [key for key in given if key not in OPTIONS[format]]:
        raise ValueError(
            f"{foreign[0]} is no option of {format}, which has {', '.join(OPTIONS[format])}"
        )
    if (format == "gcode") != isinstance(robot, TimedPath):
        raise TypeError(
            "export: gcode is written of a TimedPath, other formats of a robot, but format ="
            f" {format!r} and {shown(robot)}"
        )
    if isinstance(robot, TimedPath):
        content = gcode(robot, machine, dialect or Gcode())
    else:
        if format != "c":
            given["start"] = start_of(robot, start)
        content = WRITERS[format](robot, name or type(robot).__name__.lower(), **given)
    if out is not None:
        with written(out) as file:
            file.write(content)
    return content
