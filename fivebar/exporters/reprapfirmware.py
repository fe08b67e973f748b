"""The set-up of RepRapFirmware for a five-bar: M669 K9, with steps per degree.

Meanings and defaults are those of the firmware's page on five-bar parallel SCARAs and of its
FiveBarScaraKinematics: lengths in mm, angles in degrees from x to the left, left:right.
"""

from __future__ import annotations

import math
from typing import Any

from ..models.config_g import MODES
from ..paths.machine import Machine

SEAM = -90.0, 269.0  # a joint without limits: the firmware wants them less than a turn apart


def reprapfirmware(
    machine: Machine,
    working: tuple[int, int] = (-1, -1),
    homing_deg: tuple[float, float] | None = None,
    steps_per_turn: float | None = None,
) -> str:
    """Return the lines of config.g that tell RepRapFirmware the machine.

    Parameters
    ----------
    machine : Machine
        Its frame is the firmware's; a tool must be in line with its bar.
    working : (2,)
        Working modes; the assembly mode is -1, the only one of the firmware.
    homing_deg : (2,), optional
        Angles of the proximal bars at the homing switches, degrees.
    steps_per_turn : float, optional
        Steps, microsteps included, of a turn of the motor, for M92.
    """
    robot: Any = machine.robot
    frame = machine.frame
    if working not in MODES:
        known = ", ".join(map(str, MODES))
        raise ValueError(
            f"reprapfirmware: its five-bar has no working modes {working}, its L3: it has {known}"
        )
    if frame.turn or frame.scale != 1:
        raise ValueError(
            f"reprapfirmware: the frame is turned by {frame.turn:g} rad with scale {frame.scale:g},"
            " but M669 knows only where the motors are: take a frame with a shift alone"
        )
    numbers: dict[str, list] = {
        "X": [1e3 * (frame.shift[0] + side * robot.d / 2) for side in (-1, 1)],
        "Y": [1e3 * frame.shift[1]] * 2,
        "L": [MODES[working]],
        "P": [1e3 * robot.l11, 1e3 * robot.l21],
        "D": [1e3 * robot.l12, 1e3 * robot.l22, *_cantilevers(machine)],
    }
    if homing_deg is not None:
        numbers["B"] = list(homing_deg)
    numbers["A"] = _bar_angles(machine, working)
    numbers["C"] = _motor_angles(machine)
    words = [f"{letter}{':'.join(map(_plain, values))}" for letter, values in numbers.items()]
    lines = ["; by fivebar, for config.g before M671; assembly mode -1"]
    lines.append(f"M669 K9 {' '.join(words)}")
    if steps_per_turn is not None:
        # The readings are of the motors, so a ratio is the inverse of a gear.
        scale = machine.scale("steps", steps_per_turn) * math.pi / 180
        steps = [abs(scale / ratio) for ratio in machine.ratio]
        lines.append(f"M92 X{_plain(steps[0])} Y{_plain(steps[1])} ; steps per degree")
        for k, ratio in enumerate(machine.ratio):
            lines.append(f"M569 P{k} S{int(ratio > 0)} ; direction, as your wiring has it")
    return "\n".join(lines) + "\n"


def _plain(value):
    return f"{round(value, 6) + 0.0:.10g}"


def _cantilevers(machine):
    """Return cantL and cantR, mm; its page wants them in D also where they are 0."""
    tool = machine.tool
    if tool is None:
        return [0.0, 0.0]
    if tool.across or tool.along <= 0:
        raise ValueError(
            "reprapfirmware: its hotend is in the joint or beyond it in line with a distal bar, not"
            f" {1e3 * tool.across:g} mm beside it and {1e3 * tool.along:g} mm along it: draw such a"
            " tool by joint-space G-code, fivebar draw --format gcode --firmware reprapfirmware"
        )
    return [1e3 * tool.along * (tool.leg == leg) for leg in (1, 2)]


def _bar_angles(machine, working):
    """Return bounds of the angles between the distal bars, and at the left and right elbow."""
    head = math.degrees(math.asin(machine.constraints.det_A))
    elbow = math.degrees(math.asin(machine.constraints.sin))
    angles = [head, 180 - head]
    for mode in working:
        # q12 + 180 degrees: q12 is below 0 in mode +1.
        start = 0.0 if mode > 0 else 180.0
        angles += [start + elbow, start + 180 - elbow]
    return angles


def _motor_angles(machine):
    angles = []
    for limits in machine.constraints.joints or (None, None):
        if limits is None:
            angles += SEAM
            continue
        low, high = map(math.degrees, limits)
        if not (high - low < 360 and high <= 360 and low > -360):
            raise ValueError(
                f"reprapfirmware: joint limits from {low:g} to {high:g} degrees: it compares angles"
                " from 0 to 360, or below 0 where the first limit is: take less than a turn"
            )
        angles += [low, high]
    return angles
