"""Robots from config.g, the set-up of RepRapFirmware: its line M669 K9, a five-bar parallel SCARA.

Meanings and defaults are those of the firmware's page on five-bar parallel SCARAs and of its
FiveBarScaraKinematics: lengths in mm, angles in degrees from x to the left, left:right.
"""

from __future__ import annotations

import math
import re
from typing import Any

# The working mode L by the sides of the elbows, seen from motor to hotend. The firmware has none
# for (-1, +1), its mode 3.
MODES = {(-1, -1): 1, (1, -1): 2, (1, 1): 4}
DEFAULTS = {"L": [1.0], "A": [15, 165, 0, 360, 0, 360], "C": [10, 170, 10, 170]}
COUNTS = {"X": (2,), "Y": (2,), "P": (2,), "D": (2, 4), "L": (1,), "A": (6,), "C": (4,)}
# Comments, and the numbers and checksums of lines.
COMMENT = re.compile(r";.*|\([^)]*\)|^\s*[nN]\d+|\*\d+\s*$")
WORD = re.compile(r"([A-Z])\s*([-+.\d:]+)")
FREE = 359.0  # degrees of a joint without limits: the firmware wants them less than a turn apart


def config_table(text: str) -> dict[str, Any]:
    """Return what a config.g says of its machine, as a robot's TOML file would, in SI units.

    Of its bounds the safer one counts where fivebar has one number for several: no pose is allowed
    that the firmware refuses. The readings are degrees, as in its steps per degree.
    """
    words = _words(text)
    x, y, lengths, distal = (words[letter] for letter in "XYPD")
    base = complex(x[1] - x[0], y[1] - y[0])
    turn = math.atan2(base.imag, base.real)
    modes = [working for working, mode in MODES.items() if [mode] == words["L"]]
    if not modes:
        raise ValueError(f"M669: L{words['L'][0]:g} is no working mode of the firmware: 1, 2 or 4")
    (working,) = modes
    robot = {
        "l11": lengths[0] / 1000,
        "l12": distal[0] / 1000,
        "l21": lengths[1] / 1000,
        "l22": distal[1] / 1000,
        "d": abs(base) / 1000,
    }
    shift = [(x[0] + x[1]) / 2000, (y[0] + y[1]) / 2000]
    head = _margin(words["A"][:2], 0.0, "hotend")
    # q12 + 180 degrees is the angle at an elbow; q12 is below 0 in mode +1.
    elbows = [
        _margin(words["A"][k : k + 2], 0.0 if mode > 0 else 180.0, f"{side} elbow")
        for k, mode, side in zip((2, 4), working, ("left", "right"))
    ]
    joints = [_joint(words["C"][2 * leg : 2 * leg + 2], turn) for leg in (0, 1)]
    constraints = {
        "det_A": math.sin(math.radians(head)),
        "sin": math.sin(math.radians(max(elbows))),
    }
    return {
        **robot,
        **dict.fromkeys(("zz1", "zz2", "m"), 0.0),
        "readings": {"offset": [-turn, -turn], "ratio": [math.radians(1.0)] * 2},
        "frame": {"shift": shift, "turn": turn},
        "constraints": constraints | ({"joints": joints} if any(joints) else {}),
        **_tool(distal[2:]),
        "measured": {"modes": [[*working, -1]]},
    }


def _words(text):
    """Return {letter: numbers} of the last line M669 that names the geometry."""
    found = None
    for line in text.splitlines():
        line = COMMENT.sub("", line).upper().strip()
        command, _, rest = line.partition(" ")
        if command == "M669" and "P" in rest:
            found = rest
    if found is None:
        raise ValueError("it has no line M669 K9, which tells RepRapFirmware of a five-bar")
    if "{" in found:
        raise ValueError("M669: expressions in braces are not read: write their numbers")
    words: dict[str, list[float]] = {}
    for letter, numbers in WORD.findall(found):
        try:
            words[letter] = [float(number) for number in numbers.split(":")]
        except ValueError:
            raise ValueError(f"M669: {letter}{numbers} is no number") from None
    if words.get("K") != [9.0]:
        raise ValueError("M669: its K must be 9, the firmware's number of five-bar parallel SCARAs")
    if missing := [letter for letter in "XYPD" if letter not in words]:
        raise ValueError(f"M669: {', '.join(missing)} is missing: the firmware needs X, Y, P and D")
    words = DEFAULTS | words
    for letter, counts in COUNTS.items():
        if len(words[letter]) not in counts:
            known = " or ".join(map(str, counts))
            raise ValueError(f"M669: {letter} takes {known} numbers, not {len(words[letter])}")
    return words


def _margin(limits, start, place):
    """Return how far, degrees, a range keeps the angle at a place from both ends of its half turn,
    which begins at start.
    """
    low, high = limits
    nearest = max(low - start, start + 180.0 - high, 0.0)
    if nearest >= 90.0:
        raise ValueError(
            f"M669: A allows {low:g} to {high:g} degrees at the {place}, but in this working mode"
            f" the angle there is from {start:g} to {start + 180:g} degrees: no pose is left"
        )
    return nearest


def _joint(limits, turn):
    """Return a drive's range in rad from the line of the bases, [] where it has no limits."""
    low, high = limits
    if high - low >= FREE:
        return []
    return [math.radians(low) - turn, math.radians(high) - turn]


def _tool(cantilevers):
    """Return the tool of a distal bar that goes on beyond the joint, as a table; {} of none."""
    longer = [leg for leg, along in enumerate(cantilevers, start=1) if along]
    if not longer:
        return {}
    if len(longer) == 2:
        raise ValueError("M669: D has two cantilevers, but one hotend hangs on one of the bars")
    (leg,) = longer
    return {"tool": {"leg": leg, "along": cantilevers[leg - 1] / 1000}}
