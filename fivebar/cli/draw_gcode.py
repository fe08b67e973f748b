"""`fivebar draw --format gcode`: options, and the file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import positive
from ..base.errors import UsageError
from .options import option_of, usage_errors, used_options, write_files

GCODE = {
    "--format csv|gcode": ("csv", "what is written: set-points, or joint-space G-code"),
    "--firmware NAME": ("grbl", "grbl, fluidnc, linuxcnc, marlin or reprapfirmware"),
    "--axes LETTER LETTER": (
        ("X", "Y"),
        "of the left and the right joint, in degrees or mm, or as the drives of the robot's file"
        " read",
    ),
    "--steps-per-turn NUMBER": "axes in steps: so many, with microsteps, are a turn of the motor",
    "--mm-per-turn NUMBER": "axes in mm: so many are a turn of the motor for the firmware",
    "--gear NUMBER": (1.0, "turns of the motor for one of the joint"),
    "--sign -1|1 -1|1": "-1 where an axis turns to the right",
    "--zero-deg DEG DEG": "angles of the proximal bars from x to the left, where the axes are 0",
    "--feed inverse|units": "G93 or F in units a minute (default: as the firmware can)",
    "--max-feed NUMBER": "of an axis, units a minute: faster motions are refused",
    "--pen M3|servo|Z": "M3 and M5, M280, or heights (default: as the firmware can)",
    "--pen-values DOWN UP": "S of M3, angles of the servo, or heights, mm; without --format gcode"
    " those of a G-code file that is read",
    "--approach-deg DEG": "both joints come from so far below to where the pen goes down",
    "--line-deviation M": (2e-5, "of the tool between lines"),
    "--speed-error SHARE": (0.01, "of the tool between lines"),
}
ONLY_GCODE = "steps_per_turn mm_per_turn sign zero_deg feed max_feed pen approach_deg".split()


class Drawn(NamedTuple):
    """What is drawn: places (n, 2) m, how far they are off (n,) m, whether the pen is down (n,)."""

    tip: np.ndarray
    off: np.ndarray
    down: np.ndarray
    figures: dict[str, Any]


def dialect_of(arguments):
    """Return the Gcode of these arguments, None where none is asked for."""
    from ..exporters.gcode import Gcode

    used = used_options(arguments, *ONLY_GCODE)
    if arguments.format != "gcode":
        if used:
            raise UsageError(f"{option_of(next(iter(used)))} goes with --format gcode")
        return None
    turns = used_options(arguments, "steps_per_turn", "mm_per_turn")
    if len(turns) > 1:
        raise UsageError("--steps-per-turn and --mm-per-turn: the axes are in steps or in mm")
    values = used_options(arguments, "feed", "max_feed", "pen", "firmware", "gear", "speed_error")
    for name, count in turns.items():
        values |= {"unit": name.partition("_")[0], "per_turn": count}
    if arguments.pen_values:
        values["down"], values["up"] = arguments.pen_values
    if "approach_deg" in used:
        values["approach"] = float(np.deg2rad(used["approach_deg"]))
    with usage_errors(ValueError):
        deviation = positive(arguments.line_deviation, "line_deviation")
        return Gcode(axes=tuple(arguments.axes), deviation=deviation, **values)


def machine_of_axes(arguments, machine, dialect):
    """Return the machine with the zeros and directions of the axes, as its file or options say."""
    used = used_options(arguments, "sign", "zero_deg")
    angles = used_options(arguments, "zero_deg", "approach_deg", "mm_per_turn")
    if angles and not machine.robot.turns:
        option = option_of(next(iter(angles)))
        raise UsageError(f"{option}: the joints of a biglide slide; their axes are in mm")
    if dialect is None or not used:
        return machine
    if machine.reads_otherwise:
        option = option_of(next(iter(used)))
        raise UsageError(f"{option}: {arguments.robot} has a table readings, which says it")
    zeros = np.deg2rad(used.get("zero_deg", (0.0, 0.0))).tolist()
    return replace(machine, ratio=tuple(used.get("sign", (1.0, 1.0))), offset=tuple(zeros))


def written_gcode(arguments, machine, motion, dialect):
    """Write the G-code, replay it, and return what it draws and its file."""
    from ..exporters.export import export
    from ..exporters.gcode_replay import read_joint_gcode, replayed

    def write(path):
        export(motion, "gcode", path, machine=machine, dialect=dialect)

    with usage_errors(ValueError):
        (file,) = write_files(arguments.out, {"drawing.nc": write})
    program = read_joint_gcode(file.read_text(encoding="utf-8"), dialect)
    replay = replayed(program, motion, machine, dialect)
    figures = {
        "lines": len(program.down),
        "lines_per_s": float(1 / np.diff(program.t).min()),
        "max_error_m": replay.deviation,
        "speed_error": replay.speed_error,
    }
    return Drawn(replay.tip, replay.off, replay.down, figures), [file]
