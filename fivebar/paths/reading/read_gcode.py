"""G-code: G0 to G3, G4, F, G17, G20, G21, G90, G91, G90.1, G91.1, M82, M83, and when its pen is
down: `gcode_pens`.
"""

from __future__ import annotations

import math
import re

from ..pieces import Arc, Line
from .draft import Draft, Move, listed
from .gcode_pens import ANY, MACRO, OWN, PRINTED, PRINTERS, State, pens

WORD = re.compile(r"([A-Za-z])\s*([-+]?\s*(?:\d+\.?\d*|\.\d+))")
COMMENT = re.compile(r"\([^()]*\)|;.*|\*\d+\s*$")
PASSED = {  # codes that say nothing of a path in the plane
    "G": {17, 28, 29, 40, 43, 49, 50, 54, 61, 64, 69, 80, 94, 97},
    "M": {0, 1, 17, 18, *range(6, 10), 84},
}
M_CODE = re.compile(r"(?:N\s*\d+\s*)?M\s*(\d+)", re.IGNORECASE)
ENDS = 2, 30
# Of its radius, or ROUGH: by which an arc's ends may differ in their distance from its centre.
RIGHT = 1e-3
WHOLE = 1e-9  # m, between the ends of a whole circle
ROUGH = 5e-6  # m, what files of three decimals in mm or four in inches leave
HOME = re.compile(
    r"G\s*0*28(?:\s*[A-FH-LN-Z]\s*[-+.\d]*)*", re.IGNORECASE
)  # also of axes without a number
INCH = 0.0254
MILLIMETRE = 1e-3


def read_gcode(text: str, name: str, units: str | None = None) -> Draft:
    """The Draft of a G-code file. units: "mm" or "in", where the file has neither G21 nor G20.

    The pen is down where a printer extrudes, or in G1, G2 and G3: after M3 or M4 where the file has
    them (and S is not 0), at Z <= 0 where it has Z, or where `gcode_pens` says.
    ValueError with file and line for a code that is not known, an arc whose centre does not fit,
    units that are missing or contradict.
    """
    if units not in (None, "mm", "in"):
        raise ValueError(f'{name}: units of G-code must be "mm" or "in", not {units!r}')
    return _Machine(text, name, units).run()


class _Machine:
    def __init__(self, text, name, units):
        self.name = name
        self.lines = text.splitlines()
        self.draft = Draft(name)
        self.asked = self.unit = {None: None, "mm": MILLIMETRE, "in": INCH}[units]
        self.absolute = True
        self.centres_absolute = False
        self.modal = None
        self.x = 0.0
        self.y = 0.0
        self.z = None
        self.known = False
        self.feed = math.inf
        self.spindle = False
        self.power = None
        self.line = 0
        self.e = 0.0
        self.grown = False
        self.relative_e = False
        self.fan = False
        self.states = []
        self.from_nowhere = False  # whether the first move begins nobody knows where
        self.passed = {}
        self.ended = False
        self.assumed = None  # assumed: the unit that the file has only later
        plain = COMMENT.sub("", text.upper().replace("\r", "\n"))
        self.by_z = re.search(r"Z\s*[-+.\d]", plain) is not None
        if self.unit is None and len(found := set(re.findall(r"G\s*(2[01])(?![.\d])", plain))) == 1:
            self.unit = INCH if found == {"20"} else MILLIMETRE
            self.assumed = f"G{found.pop()}"
        self.printed = PRINTED.search(plain) is not None
        if self.unit is None and self.printed:
            self.unit = MILLIMETRE
            self.draft.notes.append("neither G20 nor G21: read in mm, as printers do")
        self.by_spindle = re.search(r"M\s*0*[345](?!\d)", plain) is not None

    def run(self):
        for number, line in enumerate(self.lines, 1):
            if self.ended:
                break
            self.line = number
            self.block(line)
        down, notes = pens(self.states, self.by_spindle, self.by_z)
        if any(state.extrudes for state in self.states):
            self.passed.pop("E word", None)
        draft = self.draft
        draft.moves = [move._replace(pen=own) for move, own in zip(draft.moves, down)]
        if self.from_nowhere and down[0]:
            draft.notes.append("it begins at X0 Y0: the file names no place before it draws")
        elif self.from_nowhere:  # from wherever the machine was
            draft.moves = draft.moves[1:]
            draft.dwells = [(max(k - 1, 0), t) for k, t in draft.dwells]
        draft.notes += [
            f"{code}: passed over{listed(lines)}" for code, lines in sorted(self.passed.items())
        ] + notes
        return draft

    def error(self, message):
        return ValueError(f"{self.name}, line {self.line}: {message}")

    def block(self, line):
        text = COMMENT.sub(" ", line).strip()
        if text in ("", "%") or text.startswith("/"):
            if text.startswith("/"):
                self.pass_over("block with /")
            return
        code = M_CODE.match(text)
        if code and (int(code[1]) in PRINTERS or (self.printed and int(code[1]) not in ANY)):
            if int(code[1]) in (106, 107):  # a fan's output, which some lasers are switched by
                self.fan = int(code[1]) == 106 and not re.search(
                    r"S\s*0*\.?0*(?![\d.])", text.upper()
                )
            self.pass_over(
                f"M{int(code[1])}"
            )  # its X and Y are limits or steps of axes, its text a message
            return
        if text.startswith("$") or (self.printed and MACRO.match(text)):
            self.pass_over(text.split()[0][:24])
            return
        if HOME.fullmatch(text):
            self.pass_over("G28")
            return
        rest = WORD.sub(" ", text).strip()
        if rest:
            raise self.error(f"{rest[:40]!r} is no word of G-code, a letter with a number")
        words = [
            (letter.upper(), float("".join(value.split()))) for letter, value in WORD.findall(text)
        ]
        codes = [(letter, value) for letter, value in words if letter in "GM"]
        values = {}
        for letter, value in words:
            if letter in "GMNO":
                continue
            if letter in values:
                raise self.error(f"{letter} twice in one line")
            values[letter] = value
        motion = None
        for letter, value in codes:
            found = self.code(letter, value, values)
            if found is not None:
                if motion is not None:
                    raise self.error(f"G{motion} and G{found} in one line")
                motion = found
        if motion == 4:
            self.dwell(values)
            return
        if motion is not None:
            self.modal = motion
        if "S" in values:
            self.power = values["S"]
        if "F" in values:
            if not values["F"] > 0:
                raise self.error(f"F must be > 0, not {values['F']:g}")
            self.feed = values["F"] * self.scale() / 60
        if "E" in values:
            e = values["E"] + (self.e if self.relative_e or not self.absolute else 0.0)
            self.grown = e > self.e
            self.e = e
        else:
            self.grown = False
        if {"X", "Y", "Z"} & set(values) or (self.modal in (2, 3) and {"I", "J"} & set(values)):
            self.move(values)
        for letter in sorted(set(values) - set("XYZIJRFPSK")):
            self.pass_over(f"{letter} word")

    def code(self, letter, value, values):
        """Do what a G or M code says; gives the number of one that moves."""
        if letter == "G":
            if value in (0, 1, 2, 3, 4):
                return int(value)
            if value in (20, 21):
                self.set_unit(
                    INCH if value == 20 else MILLIMETRE,
                    f"G{value:g}",
                )
            elif value in (90, 91):
                self.absolute = value == 90
            elif value in (90.1, 91.1):
                self.centres_absolute = value == 90.1
            elif value == 28:
                self.pass_over("G28")
                for axis in "XYZ":
                    values.pop(axis, None)
            elif value == 92:
                self.e = values.pop("E", self.e)
                if not {"X", "Y", "Z"} & set(values):
                    return None
                if (
                    self.from_nowhere
                    and len(self.states) == 1
                    and not self.may_draw(self.states[0])
                ):
                    self.draft.moves, self.states, self.from_nowhere = [], [], False
                if self.draft.moves:
                    raise self.error(
                        "G92 after the first move: another origin on the way is not read"
                    )
                self.x, self.y, self.z = (
                    values.pop(axis) * self.scale() if axis in values else at
                    for axis, at in zip("XYZ", (self.x, self.y, self.z))
                )
                self.known = True
            elif value == 53 and not {"X", "Y"} & set(values):
                values.pop("Z", None)  # up, by the machine's own zero
                self.pass_over("G53")
            elif value in PASSED["G"] or (self.printed and value in OWN):
                if value != 17:
                    self.pass_over(f"G{value:g}")
            else:
                raise self.error(
                    f"G{value:g} is not known; known are G0 to G4, G17, G20, G21, G90, G91, G90.1,"
                    " G91.1, G92"
                )
        elif value in (3, 4, 5):
            self.spindle = value != 5
        elif value in (82, 83):
            self.relative_e = value == 83
        elif value in ENDS:
            self.ended = True
        elif value in PASSED["M"]:
            self.pass_over(f"M{value:g}")
        else:
            raise self.error(f"M{value:g} is not known; known are M3, M4, M5 (pen), M2, M30 (end)")
        return None

    def set_unit(self, unit, code):
        if self.asked not in (None, unit):
            raise self.error(
                f"{code}, but units are given as {'mm' if self.asked == MILLIMETRE else 'in'}"
            )
        self.unit = unit
        self.assumed = None

    def scale(self):
        if self.assumed:
            self.draft.notes.append(
                f"lengths before the first {self.assumed} are read as after it (line {self.line})"
            )
            self.assumed = None
        if self.unit is None:
            raise self.error(
                'neither G20 (inches) nor G21 (mm) before the first length: give units="mm" or'
                ' units="in"'
            )
        return self.unit

    def pass_over(self, what):
        self.passed.setdefault(what, []).append(self.line)

    def dwell(self, values):
        """P is in ms on some machines and in s on others: only what can be one of them is read."""
        seconds = values.get("S")
        if seconds is None and "P" in values:
            seconds = values["P"]
            if seconds >= 100:
                seconds /= 1000
                self.draft.notes.append(
                    f"G4 P{values['P']:g}: read as milliseconds (line {self.line})"
                )
            elif seconds >= 10:
                raise self.error(f"G4 P{seconds:g} could be in s or in ms: write S and seconds")
        if seconds is None or seconds < 0:
            raise self.error("G4 needs S or P, seconds >= 0")
        self.draft.dwells.append((len(self.draft.moves), seconds))

    def move(self, values):
        if self.modal is None:
            raise self.error("a place without G0, G1, G2 or G3 before it")
        start = self.x, self.y
        self.x, self.y, self.z = (
            self.to(axis, at, values) for axis, at in zip("XYZ", (self.x, self.y, self.z))
        )
        end = (self.x, self.y)
        known = self.known
        if not {"X", "Y", "I", "J"} & set(values):
            return
        self.known = True
        if not known and self.modal == 0:
            return  # from wherever the machine was
        if not known:
            self.from_nowhere = True
        if start == end and self.modal in (0, 1):
            self.pass_over("a move of no length")
            return
        feed = math.inf if self.modal == 0 else self.feed
        if self.modal in (0, 1):
            shape = Line(start, end)
        else:
            shape = self.arc(start, end, values)
        self.draft.moves.append(Move(shape, True, feed, self.line))
        on = self.spindle and self.power != 0
        self.states.append(State(self.modal == 0, on, self.fan, self.z, self.grown))

    def may_draw(self, state):
        if self.printed or self.by_spindle:
            return state.extrudes if self.printed else state.on
        return not self.by_z or (state.z is not None and state.z <= 0)

    def to(self, axis, at, values):
        if axis not in values:
            return at
        value = values[axis] * self.scale()
        return value if self.absolute else (at or 0.0) + value

    def arc(self, start, end, values):
        clockwise = self.modal == 2
        if values.get("P", 1) != 1:
            raise self.error(f"P{values['P']:g}: an arc of more than one turn is not read")
        a = complex(*start)
        b = complex(*end)
        if "R" in values:
            if {"I", "J"} & set(values):
                raise self.error("an arc with R and with I or J")
            centre = self.by_radius(
                a,
                b,
                values["R"] * self.scale(),
                clockwise,
            )
        elif {"I", "J"} & set(values):
            offset = complex(values.get("I", 0.0), values.get("J", 0.0)) * self.scale()
            centre = offset if self.centres_absolute else a + offset
        else:
            raise self.error(f"G{self.modal} needs I and J, or R")
        radius = abs(a - centre)
        other = abs(b - centre)
        if radius == 0:
            raise self.error("the centre of the arc is its start")
        if abs(radius - other) > max(ROUGH, RIGHT * radius):
            raise self.error(
                f"the arc's centre is {1e3 * radius:.6g} mm from its start, but {1e3 * other:.6g}"
                " mm from its end"
            )
        whole = abs(a - b) <= WHOLE
        if not whole:  # the centre that is as far from both, nearest to the one given
            chord = (b - a) / abs(b - a)
            centre = (a + b) / 2 + chord * 1j * ((centre - a) * (chord * 1j).conjugate()).real
            radius = abs(a - centre)
        first, last = (math.atan2((z - centre).imag, (z - centre).real) for z in (a, b))
        turn = (last - first) % (2 * math.pi)
        if clockwise:
            turn -= 2 * math.pi
        if whole:
            if clockwise:
                turn = -2 * math.pi
            else:
                turn = 2 * math.pi
        return Arc(
            (centre.real, centre.imag),
            radius,
            first,
            first + turn,
        )

    def by_radius(
        self,
        a,
        b,
        radius,
        clockwise,
    ):
        half = abs(b - a) / 2
        if half == 0:
            raise self.error(
                "an arc with R whose start is its end could be any circle: give I and J"
            )
        if abs(radius) < half - max(ROUGH, RIGHT * half):
            raise self.error(
                f"R = {1e3 * abs(radius):.6g} mm is less than half of the chord,"
                f" {1e3 * half:.6g} mm"
            )
        height = math.sqrt(max(radius * radius - half * half, 0.0))
        side = -1 if clockwise == (radius > 0) else 1
        return (a + b) / 2 + side * height * 1j * (b - a) / abs(b - a)
