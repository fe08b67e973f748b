"""One way to all formats: `fb.export`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ..base.checks import instance, one_of, optional, seconds, shown, strings, takes, text
from ..base.tables import TextFile, written
from ..models.geometry import Pose
from ..models.robots import KINDS, Biglide, FiveBar
from .bodies import start_of
from .header import header
from .mjcf import mjcf
from .sdf import CLOSURES, sdf
from .urdf import urdf

if TYPE_CHECKING:
    from collections.abc import Iterable

FORMATS = {
    "mjcf": ".xml",
    "urdf": ".urdf",
    "sdf": ".sdf",
    "c": ".h",
}  # and how their files' names end
OPTIONS = {
    "mjcf": ("start", "step"),
    "urdf": ("start",),
    "sdf": ("start", "step", "closure"),
    "c": ("functions",),
}
WRITERS = {"mjcf": mjcf, "urdf": urdf, "sdf": sdf, "c": header}


def _identifier(value, name):
    if not re.fullmatch(r"[A-Za-z]\w*", text(value, name), re.ASCII):
        raise ValueError(f"{name} must be a letter, then letters, digits and _, not {shown(value)}")
    return value


@takes(
    robot=instance(*KINDS),
    format=one_of(*FORMATS),
    start=optional(instance(Pose)),
    step=optional(seconds),
    closure=optional(one_of(*CLOSURES)),
    functions=optional(strings),
    name=optional(_identifier),
)
def export(
    robot: FiveBar | Biglide,
    format: str,
    out: TextFile | None = None,
    start: Pose | None = None,
    step: float | None = None,
    closure: str | None = None,
    functions: Iterable[str] | None = None,
    name: str | None = None,
) -> str:
    """The robot in another program's format, as a text: "mjcf", "urdf", "sdf", or "c", one C99
    header.

    Simulators get bodies that move exactly as the base parameters do (`bodies.legs_of`); their
    joints' coordinates are ours. Each file says in its head how its simulator closes the loop, and
    with what error.

    out: path or open text file to write it to as well, whole or not at all. name: of the model, and
    what all names in C begin with (None: fivebar or biglide).
    start: the pose shown, (None: q = (0, 0) where it closes). step: s, the simulator's (None: 1
    ms). closure: of SDF, "constraint" for Drake (None), "joint" for Gazebo. functions: of C, which
    of `header.NAMES` (None: all). ValueError for an option of another format, and for a robot that
    no bodies of positive mass move as.
    """
    options = dict(start=start, step=step, closure=closure, functions=functions)
    given = {key: value for key, value in options.items() if value is not None}
    if foreign := [key for key in given if key not in OPTIONS[format]]:
        raise ValueError(
            f"{foreign[0]} is no option of {format}, which has {', '.join(OPTIONS[format])}"
        )
    if format != "c":
        given["start"] = start_of(robot, start)
    found = WRITERS[format](robot, name or type(robot).__name__.lower(), **given)
    if out is not None:
        with written(out) as file:
            file.write(found)
    return found
