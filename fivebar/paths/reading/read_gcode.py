"""Read G-code of plotters, lasers and mills: lines, arcs, dwells and the state of the pen.

Read are G0 to G4, G20, G21, G90, G91, G90.1, G91.1, G92 before the first move, F, and for the pen
M3, M4, M5, M106, M107 and S, a servo's M280 or M300, and Z.
"""

from __future__ import annotations

import cmath
import math
import re
from collections import defaultdict
from typing import Any

from ...base.units import METRES
from ..pieces import Arc, Line
from .draft import Draft, Move, listed

WORD = re.compile(r"([A-Z])\s*([-+]?\s*(?:\d+\.?\d*|\.\d+))")
AXES_ALONE = re.compile(r".*(G0*28|M0*1[78]|M0*84)\b[^GM]*")  # may name axes without numbers
PEN = re.compile(r"pen.?.?(up|down)", re.IGNORECASE)  # in a comment beside a servo's angle
BY_FIVEBAR = re.compile(r"[(;] ?fivebar: joint angles")
COMMENT = re.compile(r"\([^()]*\)|;.*|\*\d+\s*$")
PASSED = {  # codes that say nothing of a path in the plane
    "G": {17, 28, 40, 43, 49, 50, 53, 54, 61, 64, 69, 80, 94, 97},
    "M": {0, 1, 6, 7, 8, 9, 17, 18, 84, 400},
}
RIGHT = 1e-3  # of its radius: by which an arc's ends may differ in their distance from the centre
ROUGH = 5e-6  # m, the same: what files of three decimals in mm or four in inches leave
WHOLE = 1e-9  # m, between the ends of a whole circle


def read_gcode(
    text: str, name: str, units: str | None = None, pen_values: tuple[float, float] | None = None
) -> Draft:
    """Return the moves of a G-code file; units: "mm" or "in" where it has neither G20 nor G21.

    The pen is down in G1, G2 and G3: after M3, M4 or M106 (and S is not 0) where the file has them,
    and at the height Z or the angle of its servo where it has these. pen_values are Z or the angle
    where the pen is down, and up. By default it is down at Z <= 0, or where the file's G0 never is,
    or where the comments say.
    """
    if BY_FIVEBAR.match(text):
        raise ValueError(
            f"{name}: this is joint-space G-code that fivebar wrote: its axes are angles of the"
            " joints, not places. Give the drawing that it was written from"
        )
    if units not in (None, "mm", "in"):
        raise ValueError(f'{name}: units of G-code must be "mm" or "in", not {units!r}')
    return _Machine(text, name, units, pen_values).run()


class _Machine:
    """The state of a machine, line by line."""

    def __init__(self, text: str, name: str, units: str | None, pen_values: Any) -> None:
        self.draft = Draft(name)
        self.pen_values = pen_values
        self.lines = text.splitlines()
        self.units = units  # as the caller gives them
        self.unit = None if units is None else METRES[units]
        self.absolute = True
        self.absolute_centres = False
        self.motion: int | None = None
        self.position = {"X": 0.0, "Y": 0.0, "Z": math.inf}  # Z: not known yet
        self.known = False  # whether X and Y were given
        self.from_unknown = False  # whether the first move comes from where the machine was
        self.angle = math.nan  # of the pen's servo
        self.levels: list[float] = []  # of the pen in each move, as the file writes them
        self.travels: set[float] = set()  # those in G0
        self.said: dict[str, set] = {"up": set(), "down": set()}  # angles, in comments
        self.feed = math.inf
        self.spindle = False
        self.power = math.inf
        self.ended = False
        self.passed: defaultdict[str, list] = defaultdict(list)
        plain = "\n".join(COMMENT.sub("", line) for line in self.lines).upper()
        self.has_servo = re.search(r"M(280|300)\b", plain) is not None
        self.has_spindle = re.search(r"M\s*(0*[345]|10[67])(?!\d)", plain) is not None

    def run(self) -> Draft:
        for number, line in enumerate(self.lines, 1):
            self.line = number
            self.block(COMMENT.sub(" ", line).strip().upper())
            if self.ended:
                break
        draft = self.draft
        for what, lines in sorted(self.passed.items()):
            draft.notes.append(f"{what}: passed over{listed(lines)}")
        if self.has_servo or any(map(math.isfinite, self.levels)):
            down = self.levels_down()
            pens = [move.pen and level in down for move, level in zip(draft.moves, self.levels)]
            draft.moves = [move._replace(pen=pen) for move, pen in zip(draft.moves, pens)]
        drawn = [move.line or 0 for move in draft.moves if move.pen]
        for line in self.passed["M6"]:
            if drawn and drawn[0] < line <= drawn[-1]:
                self.line = line
                raise self.error(
                    "M6 changes the tool between strokes, and a path has one pen: give the strokes"
                    " of each tool as a file of their own"
                )
        if self.from_unknown and draft.moves[0].pen:
            draft.notes.append("it begins at X0 Y0: the file names no place before it draws")
        elif self.from_unknown:
            draft.moves = draft.moves[1:]
            draft.dwells = [(max(k - 1, 0), seconds) for k, seconds in draft.dwells]
        return draft

    def levels_down(self) -> set[float]:
        """Return the heights or servo angles at which the pen is down."""
        what = "angles of the servo" if self.has_servo else "heights Z"
        levels = set(self.levels)
        if self.pen_values:
            down, up = self.pen_values
            return {level for level in levels if abs(level - down) < abs(level - up)}
        if not self.has_servo and min(levels) <= 0:
            return {level for level in levels if level <= 0}
        down = levels - self.travels
        if not (self.travels and down):
            down = self.said["down"] - self.said["up"]
        if not down & levels:
            known = ", ".join(f"{level:g}" for level in sorted(levels))
            raise ValueError(
                f"{self.draft.name}: the pen moves at the {what} {known}: which is down? Say"
                " pen_values=(down, up), as --pen-values DOWN UP"
            )
        known = ", ".join(f"{level:g}" for level in sorted(down & levels))
        self.draft.notes.append(f"the pen is taken to be down at the {what} {known}")
        return down

    def error(self, message: str) -> ValueError:
        return ValueError(f"{self.draft.name}, line {self.line}: {message}")

    def pass_over(self, what: str) -> None:
        self.passed[what].append(self.line)

    def block(self, text: str) -> None:
        """Run one line without its comments."""
        if text in ("", "%"):
            return
        if text[0] in "/$":  # $: GRBL's own, as $H for homing
            self.pass_over(f"block with {text[0]}")
            return
        rest = WORD.sub(" ", text).strip()
        if rest and not (set(rest) <= set("XYZE ") and AXES_ALONE.fullmatch(text)):
            raise self.error(f"{rest[:40]!r} is no word of G-code, a letter with a number")
        codes = []
        values: dict[str, float] = {}
        for letter, digits in WORD.findall(text):
            value = float("".join(digits.split()))
            if letter in "GM":
                codes.append((letter, value))
            elif letter in values:
                raise self.error(f"{letter} twice in one line")
            elif letter not in "NO":
                values[letter] = value
        motions = [int(value) for letter, value in codes if letter == "G" and value in range(5)]
        if len(motions) > 1:
            raise self.error(f"G{motions[0]} and G{motions[1]} in one line")
        for letter, value in codes:
            self.set_mode(letter, value, values)
        if motions != [4]:
            self.power = values.get("S", self.power)
        if "F" in values:
            if not values["F"] > 0:
                raise self.error(f"F must be > 0, not {values['F']:g}")
            self.feed = self.metres(values["F"]) / 60
        if motions == [4]:
            self.dwell(values)
            return
        if motions:
            self.motion = motions[0]
        turning = self.motion in (2, 3) and {"I", "J"} & set(values)
        if turning or {"X", "Y", "Z"} & set(values):
            self.move(values)
        for letter in sorted(set(values) - set("XYZIJRFPSK")):
            self.pass_over(f"{letter} word")

    def set_mode(self, letter: str, value: float, values: dict[str, float]) -> None:
        """Do what a G or M code asks for that is no motion."""
        if letter == "G" and value in range(5):
            return
        if letter == "G" and value in (20, 21):
            units = "in" if value == 20 else "mm"
            if self.units not in (None, units):
                raise self.error(f"G{value:g}, but units are given as {self.units}")
            self.unit = METRES[units]
        elif letter == "G" and value in (90, 91):
            self.absolute = value == 90
        elif letter == "G" and value in (90.1, 91.1):
            self.absolute_centres = value == 90.1
        elif letter == "G" and value == 92:
            if self.draft.moves:
                raise self.error("G92 after the first move: another origin on the way is not read")
            for axis in set(values) & set(self.position):
                self.position[axis] = self.metres(values.pop(axis))
            self.known = True
        elif letter == "M" and value in (3, 4, 5, 106, 107):
            self.spindle = value not in (5, 107)
            if value == 106:  # a fan's output, which is full without S
                values.setdefault("S", math.inf)
        elif letter == "M" and value in (280, 300):
            self.angle = values.pop("S", self.angle)
            for side in PEN.findall(self.lines[self.line - 1]):
                self.said[side.lower()].add(self.angle)
        elif letter == "M" and value in (2, 30):
            self.ended = True
        elif value in PASSED[letter]:
            self.pass_over(f"{letter}{value:g}")
            if letter == "M":
                values.pop("S", None)
            if letter == "G" and value in (28, 53):  # to the machine's own places
                for axis in self.position:
                    values.pop(axis, None)
        else:
            raise self.error(
                f"{letter}{value:g} is not known; known are G0 to G4, G20, G21, G90, G91, G90.1,"
                " G91.1, G92, M3, M4, M5, M106, M107, M280, M300 (pen), M2 and M30 (end)"
            )

    def metres(self, value: float) -> float:
        if self.unit is None:
            raise self.error(
                'neither G20 (inches) nor G21 (mm) before the first length: give units="mm" or'
                ' units="in"'
            )
        return value * self.unit

    def dwell(self, values: dict[str, float]) -> None:
        """Rest for S s or P; P is in ms on some machines and in s on others."""
        seconds = values.get("S", values.get("P", -1.0))
        if "S" not in values and seconds >= 100:
            self.draft.notes.append(f"G4 P{seconds:g}: read as milliseconds (line {self.line})")
            seconds /= 1000
        elif "S" not in values and seconds >= 10:
            raise self.error(f"G4 P{seconds:g} could be in s or in ms: write S and seconds")
        if seconds < 0:
            raise self.error("G4 needs S or P, seconds >= 0")
        self.draft.dwells.append((len(self.draft.moves), seconds))

    def move(self, values: dict[str, float]) -> None:
        if self.motion is None:
            raise self.error("a place without G0, G1, G2 or G3 before it")
        start = complex(self.position["X"], self.position["Y"])
        for axis in set(values) & set(self.position):
            value = self.metres(values[axis])
            at = self.position[axis]
            relative = not self.absolute and math.isfinite(at)
            self.position[axis] = at + value if relative else value
        end = complex(self.position["X"], self.position["Y"])
        if not {"X", "Y", "I", "J"} & set(values):
            return
        down = self.motion > 0
        if self.has_spindle:
            down &= self.spindle and self.power != 0
        is_first, self.known = not self.known, True
        if start == end and self.motion < 2:
            if not is_first:
                self.pass_over("a move of no length")
            return
        self.from_unknown |= is_first
        if self.motion < 2:
            shape: Line | Arc = Line((start.real, start.imag), (end.real, end.imag))
        else:
            shape = self.arc(start, end, values)
        feed = math.inf if self.motion == 0 else self.feed
        self.draft.moves.append(Move(shape, down, feed, self.line))
        height = self.position["Z"] / self.metres(1.0)
        self.levels.append(self.angle if self.has_servo else height)
        if self.motion == 0:
            self.travels.add(self.levels[-1])

    def arc(self, start: complex, end: complex, values: dict[str, float]) -> Arc:
        if values.get("P", 1) != 1:
            raise self.error(f"P{values['P']:g}: an arc of more than one turn is not read")
        by_centre = bool({"I", "J"} & set(values))
        if by_centre == ("R" in values):
            raise self.error(f"G{self.motion} needs I and J, or R")
        whole = abs(end - start) <= WHOLE
        if by_centre:
            i = self.metres(values.get("I", 0.0))
            j = self.metres(values.get("J", 0.0))
            offset = complex(i, j)
            centre = offset if self.absolute_centres else start + offset
        elif whole:
            raise self.error("an arc with R whose start is its end: give I and J")
        else:
            centre = self.centre_by_radius(start, end, self.metres(values["R"]))
        radius = abs(start - centre)
        radius_at_end = abs(end - centre)
        tolerance = max(ROUGH, RIGHT * radius)
        if radius == 0 or abs(radius - radius_at_end) > tolerance:
            raise self.error(
                f"the arc's centre is {1e3 * radius:.6g} mm from its start, but"
                f" {1e3 * radius_at_end:.6g} mm from its end"
            )
        turn = 0.0
        if not whole:
            # The centre at equal distance from both ends, nearest to the one in the file.
            normal = 1j * (end - start) / abs(end - start)
            middle = (start + end) / 2
            offset = (centre - middle) * normal.conjugate()
            centre = middle + normal * offset.real
            turn = cmath.phase(end - centre) - cmath.phase(start - centre)
            turn %= 2 * math.pi
        if self.motion == 2:  # clockwise
            turn -= 2 * math.pi
        elif whole:
            turn = 2 * math.pi
        first = cmath.phase(start - centre)
        radius = abs(start - centre)
        return Arc((centre.real, centre.imag), radius, first, first + turn)

    def centre_by_radius(self, start: complex, end: complex, radius: float) -> complex:
        """Return the centre of the shorter arc with this radius; of the longer one for R < 0."""
        half = abs(end - start) / 2
        if abs(radius) < half - max(ROUGH, RIGHT * half):
            raise self.error(
                f"R = {1e3 * abs(radius):.6g} mm is less than half of the chord,"
                f" {1e3 * half:.6g} mm"
            )
        height = math.sqrt(max(radius * radius - half * half, 0.0))
        clockwise = self.motion == 2
        side = -1 if clockwise == (radius > 0) else 1
        normal = 1j * (end - start) / abs(end - start)
        return (start + end) / 2 + side * height * normal
