"""When a G-code file's pen is down: by what a printer extrudes, by M3, M4 and M5, by a laser's fan
output, or by Z.
"""

from __future__ import annotations

import re
from typing import NamedTuple

SAME = 1e-7  # m, by which heights of one layer may differ
# E in a move
PRINTED = re.compile(
    r"(?m)^[ \t]*(?:N\s*\d+\s*)?G\s*0*[0-3](?!\d)(?=[^\n]*[XY]\s*[-+.\d])[^\n]*E\s*[-+.\d]"
)
PRINTERS = {  # M codes of a printer: temperatures, fans, limits, steps, messages
    42, 73, 74, 92, *range(104, 120), 140, 150, 155, 190, *range(201, 210), 211, 220, 221, 280,
    *range(300, 305), 400,
    412, 413, 420, 486, *range(500, 505), 555, 566, 569, 572, 593, 862, 900, 906, 907, 913, 914,
}  # fmt: skip
ANY = {
    *range(6),
    30,
    82,
    83,
}  # M codes that say something of the pen, or end the file, in a printer's file, too
OWN = {
    10,
    11,
    12,
    26,
    27,
    30,
    32,
    34,
    35,
    60,
    61,
    76,
    81,
}  # G codes of a printer: of its bed and its nozzle
MACRO = re.compile(
    r"[A-Z_]{3,}\w*(?:\s+\w+\s*=.*)?$", re.IGNORECASE
)  # of a printer's firmware, with a name


class State(NamedTuple):
    """Of a machine in a move: G0; M3 or M4 and S not 0; M106 and S not 0; Z m, None before the
    first; E grows.
    """

    rapid: bool
    on: bool
    fan: bool
    z: float | None
    extrudes: bool


def pens(states: list[State], spindle: bool, by_z: bool) -> tuple[list[bool], list[str]]:
    """Whether the pen is down in each move, and sentences on what was taken for the pen.

    Where E grows in some move, the file is a printer's: there the pen is down, whatever Z. Else it
    is down in G1, G2
    and G3: after M3 or M4 where the file has them (spindle), or after M106 where it has neither
    these nor Z; and at Z <= 0 where it has Z (by_z). Where no such move is at Z <= 0, Z is measured
    from elsewhere: `_lowest`.
    """
    if any(state.extrudes for state in states):
        down = [state.extrudes for state in states]
        return down, ["the pen is down where E grows", *_layers(states, down)]
    notes = []
    if not spindle and not by_z and any(state.fan and not state.rapid for state in states):
        down = [state.fan and not state.rapid for state in states]
        notes.append("M106 and M107 are taken for the pen")
    else:
        down = [not state.rapid and (state.on or not spindle) for state in states]
    if not by_z or not any(down):
        return down, notes
    low = [state.z <= 0 if state.z is not None else spindle for state in states]
    if not any(a and b for a, b in zip(down, low)):
        low, words = _lowest(states, down, spindle)
        notes.append(words)
    return [a and b for a, b in zip(down, low)], notes


def _lowest(states, down, spindle):
    """Whether each move is low enough where none is at Z <= 0, and in words why.

    Below all of G0 (a bed's zero is under the work); anywhere if M5 or S0 part the strokes (Z is a
    laser's focus); at the lower one of two heights. Of other heights nobody can tell which draw.
    """
    heights = [_rounded(state.z) for state in states]
    drawn = sorted({z for z, d in zip(heights, down) if d and z is not None})
    rapid = [z for z, state in zip(heights, states) if state.rapid and z is not None]
    none = "no move is at Z 0 or below"
    if spindle and (len(drawn) < 2 or any(not state.on and not state.rapid for state in states)):
        return [True] * len(states), f"{none}: the pen is down by M3, M4 and S, at any height"
    if rapid and drawn and drawn[-1] < min(rapid):
        return [True] * len(
            states
        ), f"{none}: it is down below Z {1e3 * min(rapid):.6g} mm, where G0 moves"
    if len(drawn) == 2:
        low = [z == drawn[0] for z in heights]
        return (
            low,
            f"{none}: of two heights the lower one, Z {1e3 * drawn[0]:.6g} mm, is taken for it",
        )
    listed = ", ".join(f"{1e3 * z:.6g}" for z in drawn[:5]) + ", ..." * (len(drawn) > 5)
    return [False] * len(
        states
    ), f"{none}, where the pen is down (Z is {listed or 'not known'} mm): shift its zero"


def _layers(states, down):
    heights = sorted(
        {_rounded(state.z) for state, d in zip(states, down) if d and state.z is not None}
    )
    if len(heights) < 2:
        return []
    ends = f"Z {1e3 * heights[0]:.6g} to {1e3 * heights[-1]:.6g} mm"
    return [
        f"{len(heights)} layers, {ends}, are drawn one over the other: leave in the file those that"
        " you want"
    ]


def _rounded(z):
    if z is None:
        return None
    return round(z / SAME) * SAME
