"""What a change that makes a function right is called, in the words of the labs' papers.

Two tables say it, for a teacher to read and to extend: QUANTITIES, what an expression is worth in
the right model, and KINDS, what was wrong with it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...base.backend import pairs
from ..columns import QUARTER, Array, inverse
from ..derivation import Derivation, product, solved, turned
from ..judging.questions import AskedRows, rows_from
from ..judging.with_right_ones import MODES
from ..robots import has_models, parameters_of
from ..worker.student import Tried
from ..worker.wire import Change

ALL = -1  # in place of a place's number: all are told
ROWS = 6  # in which values are compared
CLOSE = 1e-7  # of the largest value
_WORD = re.compile(r"[A-Za-z_]\w*")
_PART = re.compile(r"\b(left|right|a part of) ")
_BARE = re.compile(r"__import__\('\w+'\)\.(linalg\.)?|[()\s]")

# What an expression is worth, of a step of the derivation. {leg}: a leg's value may stand alone.
QUANTITIES: dict[str, str | Callable[[Derivation], Array]] = {
    "the direction of the {leg}distal bar": "phi",
    "A": "A",
    "the inverse of A": lambda s: inverse(s.A),
    "B": "B",
    "the {leg}diagonal element of B": "b_ii",
    "the inverse of B": lambda s: inverse(s.B),
    "J": "J",
    "the inverse of J": "J_inverse",
    "det A": lambda s: np.linalg.det(s.A),
    "u of the {leg}distal bar": "u2",
    "v of the {leg}distal bar": "v2",
    "u of the {leg}proximal bar": "u1",
    "v of the {leg}proximal bar": "v1",
    "d": "d",
    "the centripetal term of the {leg}proximal bar": "near",
    "the centripetal term of the {leg}distal bar": "far",
    "the rate of the {leg}distal bar": "rate",
    "the squared rate of the {leg}distal bar": "square",
    "M": "M",
    "c": "c",
    "A^-1 d": lambda s: solved(s.A, s.d),
    "the share of the end-effector along {leg}v": "of_tip",
    "the share of the {leg}pivot along v": "of_pivot",
    "the centripetal share of the {leg}pivot": "pull",
    "the {leg}distal bar's turning": "turning",
    "the {leg}passive joint's answer": "passive_found",
    "B q'' + d": lambda s: product(s.B, s.accelerations) + s.d,
    "A xi'' - d": lambda s: product(s.A, s.xi_ddot) - s.d,
    "the {leg}pivot": "pivot",
    "the vector of the {leg}proximal bar": "crank",
    "the line between the pivots": "line",
    "the distance of the pivots": lambda s: np.abs(s.line),
    "half the line between the pivots": lambda s: s.line / 2,
    "the distance of H": "a",
    "the height over H": "h",
    "the end-effector": "tip",
    "the line from the {leg}base to the end-effector": "reach",
    "the distance of the end-effector from the {leg}base": lambda s: np.abs(s.reach),
    "the distance of M from the {leg}base": "b",
    "the height over the {leg}M": "rise",
    "the vector of the {leg}proximal bar from its base": "elbow",
    "the {leg}active joint": "active",
    "the vector of the {leg}distal bar": "bar",
    "the absolute angle of the {leg}distal bar": "absolute",
    "the {leg}passive joint": "relative",
}
UNITS = "Write the unit of each term beside it: all terms of a sum have the same."
ATAN = "Some of your angles are off by half a turn. What does y / x forget?"
FLIPPED = "Flip the mode alone: which of your answers change, and which must?"
SIGNS = "Go through the signs of your formula: which terms add, and which subtract?"
TERMS = "Derive the formula once more on paper: how many terms does it have?"
NAMES = "Read each name in your formula: which quantity of your derivation is it?"
MATRICES = "Solve the equation for what you look for: which matrix is on the other side?"
SHAPES = "Write the shapes and the meaning of rows and columns beside each matrix."
PARALLEL = "Which product is 0 for parallel vectors, and which for perpendicular ones?"
PRODUCTS = "What does * do with two arrays, and what does @ do?"
ANGLE = "Draw the angle: which side of the triangle is the cosine, which the sine?"
ARC = "An arc has no sign of its own. Which two numbers tell atan2 the quadrant?"
DEGREES = "In which unit are angles here, and which one do sin and cos expect?"
ROUNDED = "How many digits does a number need that others build on?"
WHOLE = "What does an array of whole numbers do with a fraction that is put into it?"
BRACKETS = "In which order does Python compute your formula? Where do brackets belong?"
ORDER = "In which order are these wanted?"
CALLED = "What does each function that you call give?"
DRAWN = "Draw the vector: which way does it point, and which way should it?"
# Kind of the change; what stands there => what would be right; what it is called; its hint, where a
# name in braces is a hint above.
KINDS = r"""
a function; ^\S*(deg|rad)\w*\(; an angle converted from or to degrees; {DEGREES}
a function; ^(np\.)?f?abs\w*\(; an absolute value too much; What does a negative number mean here?
a function; ^\S*round\(; a rounded number; {ROUNDED}
a function; ^([\w.]+\.)?(max|min|clip)(imum)?\(; a limit too much; Is there an answer beyond it?
a function; tan\(.*=>.*tan2\(; atan for atan2; {ATAN}
a function; (cos|sin)\(.*=>.*tan2\(; an arc in place of a direction; {ARC}
a function; \ba(rc)?(cos|sin)\b; arcsine and arccosine exchanged; {ANGLE}
a function; \b(sin|cos)\b; sine and cosine exchanged; {ANGLE}
a conjugate; ; a conjugate forgotten; What is the scalar product of vectors as complex numbers?
a function; ^(?P<a>[\w.]+)(\(.*\)) => (?P<b>[\w.]+)\2$; {a} in place of {b}; {CALLED}
a function; ; another function; {CALLED}
a sign; ; a wrong sign; {SIGNS}
a square; \*\*.*=>.*\*; a square in place of a product; {UNITS}
a square; ; a square forgotten; {UNITS}
a root; ; a root too much or forgotten; {UNITS}
a factor; ^((?!gamma|assembly|branch).)* => .*(gamma|assembly|branch); the mode forgotten; {FLIPPED}
a factor; ^(?P<rest>.+) => (?P=rest) \* (?P<by>[\w.]+)$; factor {by} forgotten; {UNITS}
a factor; ^\(?(.+?)\)? => \(?\1\)? / \((?P<by>.+)\)$; division by {by} forgotten; {UNITS}
a factor; ^\(?(.+?)\)? => \(?\1\)? / (?P<by>[\w.]+(\(\w+\))?)$; division by {by} forgotten; {UNITS}
a factor; ^(?P<rest>.+) => 2 \* \(?(?P=rest)\)?$; factor 2 forgotten; {UNITS}
a factor; ; a wrong factor; {UNITS} Where does each factor come from?
a mode; ; the mode forgotten; {FLIPPED}
a hypotenuse; ; a side in place of a hypotenuse; How long is a vector that has an x and a y?
an operator; ; a wrong operator; {UNITS}
a number; ^-?([\d.]+?)(\.0)? => -?\1$; a wrong sign; {SIGNS}
a number; ^(0\.0*1|\S*e-\d+) =>; a wrong threshold; What is the largest value that counts as 0?
a number; ; a wrong number; Where does each number in your formula come from?
a typed number; ; {old} typed in place of {new}; What if the robot has other lengths or masses?
steps; ; too few steps; How close to the solution are you after each step?
a product; [+] .*=>; a scalar product in place of a cross product; {PARALLEL}
a product; ; a cross product in place of a scalar product; {PARALLEL}
a whole number; ; an array of whole numbers; {WHOLE}
a term; ^(?P<rest>.+) [+-] (?P<term>[^+-]+) => (?P=rest)$; {term} too much; {TERMS}
a term; ^(?P<rest>.+) => (?P=rest) [+-] (?P<term>[^+-]+)$; {term} forgotten; {TERMS}
a term; ^(?P<term>[^+-]+) [+] (?P<rest>.+) => (?P=rest)$; {term} too much; {TERMS}
a term; ; a wrong term; {TERMS}
a formula; ; a wrong formula; {TERMS} Which lengths and angles does it hold?
a bracket; \*\* 2 [+] .*\*\* 2 =>; a sum of squares in place of the square of a sum; {BRACKETS}
a bracket; ; a bracket in the wrong place; {BRACKETS}
a variable; 180 / ([\w.]+\.)?pi =>; an angle converted from or to degrees; {DEGREES}
a variable; ^[\w.]+ => [\w.]+$; {old} in place of {new}; {NAMES}
a variable; ^\S*(sin|cos)\(.* => \S*(sin|cos)\(; sine and cosine exchanged; {ANGLE}
a variable; => .*(inv|solve)\(; the wrong matrix inverted; {MATRICES}
a variable; (multiply|diag)\(.*=> .* @ ; element by element in place of a matrix product; {PRODUCTS}
a variable; => .* @ ; a matrix forgotten in a product; {SHAPES}
a variable; ^(.*)\b(?P<a>\w+)\b(.*)\b(?P<b>\w+)\b(.*) => \1\4\3\2\5$; {a} and {b} exchanged; {NAMES}
a variable; ; a wrong name; {NAMES}
an index; ; a wrong index; Read each index in your formula: which row is it, which column?
the order; ^.?(?P<a>[\w.]+), (?P<b>[\w.]+).? => .?(?P=b), (?P=a).?$; {a} and {b} exchanged; {ORDER}
the order; tan2\(; atan2 with x before y; atan2(1, 0) is 90 degrees: what is yours?
the order; ^[^(\[].* @ ; matrices in the wrong order; Which of them must act first?
the order; ; the wrong order; {ORDER}
a transpose; ; a transpose forgotten or too much; {SHAPES}
an inverse; =>.*(inv|solve)\(; an inverse forgotten; {MATRICES}
an inverse; ; a wrong inverse; {MATRICES}
a matrix product; => .* @ ; element by element in place of a matrix product; {PRODUCTS}
a matrix product; ; a matrix product in place of element by element; {PRODUCTS}
a comparison; ; a wrong condition; Go through your conditions: which case do they choose, and when?
a direction; ^.-(.+), -(.+). => .\1, \2.$; a vector of the wrong sign; {DRAWN}
a direction; ; a turn missing or the wrong way; {DRAWN}
a line; ; {old} too much; What does this line change in all that comes after it?
"""


def _matrices(numbers):
    return numbers.reshape(-1, 2, 2) if numbers.shape[1] == 4 else np.full((1, 2, 2), np.nan)


def _quarter(numbers):
    return (numbers.reshape(-1, 2) @ QUARTER.T).reshape(numbers.shape)


# How a wrong value goes with the right one: the name, of {Q}, the right value, and {P}, another
# one; the hint; what is then alike, all (rows, numbers); True where it may be so but for the sign.
ALONE: tuple[tuple, ...] = (
    ("the sign of {Q}", SIGNS, lambda old, new: (old, -new)),
    ("{Q} transposed", SHAPES, lambda old, new: (turned(_matrices(old)), _matrices(new))),
    (
        "a quarter turn missing in {Q}",
        DRAWN,
        lambda old, new: (_quarter(old), new) if old.shape[1] % 2 == 0 else (old, new + np.nan),
        True,
    ),
)
WITH_ANOTHER: tuple[tuple, ...] = (
    ("{P} too much in {Q}", TERMS, lambda old, new, p: (old, p if not new.any() else p + np.nan)),
    ("{P} forgotten in {Q}", TERMS, lambda old, new, p: (new - old, p), True),
    ("the sign of {P} in {Q}", SIGNS, lambda old, new, p: (new - old, 2 * p), True),
    ("factor {P} forgotten in {Q}", UNITS, lambda old, new, p: (new, old * p)),
    ("factor {P} too much in {Q}", UNITS, lambda old, new, p: (old, new * p)),
    ("{P} in place of {Q}", NAMES, lambda old, new, p: (old, p)),
)
ADDED = WITH_ANOTHER[:-1]  # what can be told of a value without a name


class Quantities:
    """What is known by name in some rows of questions: values (rows, numbers)."""

    def __init__(self, rows: AskedRows):
        given = dict(zip(rows.exercise.arguments, rows.columns))
        count = len(rows.columns[0])
        self.named: list[tuple[str, Array]] = []
        if has_models(rows.robot):
            self._name_steps(rows.robot, given, count)
        self.plain = [(name, np.asarray(column, float)[:, None]) for name, column in given.items()]
        self.lengths_and_masses = [
            (name, np.full((count, 1), value))
            for name, value in parameters_of(rows.robot).items()
            if value
        ]

    def _name_steps(self, robot, given, count):
        s = Derivation(robot, given)
        places = {"base": robot.words.base, "pivot": "elbow" if robot.turns else "foot"}
        places["pivots"] = "elbows" if robot.turns else "feet"
        places["turning"] = "angular acceleration" if s.has("xDD") else "rate"
        for name, step in QUANTITIES.items():
            try:
                with np.errstate(all="ignore"):
                    value = getattr(s, step) if isinstance(step, str) else step(s)
            except KeyError:  # the function has not got what this needs
                continue
            value = np.broadcast_to(value, (count, *np.shape(value)[1:]))
            if np.iscomplexobj(value):
                value = pairs(value)
            name = re.sub(r"\b(base|pivots?|turning)\b", lambda m: places[m[0]], name)
            parts = _with_parts(name, value)
            # Plain numbers are what many other things are, too.
            self.named += [
                (text, one) for text, one in parts if one.shape[1] > 2 or np.ptp(one, axis=0).any()
            ]

    def name_of(self, values: Array) -> str:
        """Return what values are called, "" where they have no name."""
        return next((name for name, known in self.named if _alike(known, values)), "")

    def others(self, change: Change) -> Iterator[tuple[str, Array]]:
        """Yield what may be forgotten, or stand in the place of something else: a length or a mass
        only where the change has its name more, or less.
        """
        new = change.new.split(", in ")[0]
        # Of equal lengths, the one that the change speaks of.
        changed = {*_WORD.findall(change.old)} ^ {*_WORD.findall(new)}
        yield from (pair for pair in self.lengths_and_masses if pair[0] in changed)
        yield from self.plain
        yield from self.named


def _with_parts(name, value):
    """Yield a quantity of both legs, of either leg, and each of their numbers."""
    if "{leg}" not in name:
        flat = value.reshape(len(value), -1)
        yield name, flat
        if value.ndim == 2:
            for number in flat.T:
                yield f"a part of {name}", number[:, None]
        return
    yield name.format(leg=""), value.reshape(len(value), -1)
    for leg, side in enumerate(("left ", "right ")):
        own = value[:, leg].reshape(len(value), -1)
        yield name.format(leg=side), own
        for number in own.T if own.shape[1] > 1 else ():
            yield f"a part of {name.format(leg=side)}", number[:, None]


def _alike(a, b):
    """Return whether two arrays are the same in all rows."""
    if a.shape != b.shape or not np.isfinite(a).all() or not np.isfinite(b).all():
        return False
    scale = np.abs(b).max()
    return bool(scale and np.all(np.abs(a - b) <= CLOSE * scale))


def named(
    student: object, tried: Tried, made: tuple, changes: Mapping | tuple, rows: AskedRows
) -> tuple[tuple[str, str], ...]:
    """Return the name and the hint of each of the changes that make a function right.

    student: who is asked; tried: how; made: with what it is right; rows: which it is asked.
    """
    some = rows.part(np.arange(min(ROWS, len(rows.columns[0]))))
    before, after = (
        _values(student, replace(tried, made=each), some) for each in (tried.made, made)
    )
    known = Quantities(some)
    return tuple(named_change(change, _around(change, before, after), known) for change in changes)


def _values(student, tried, rows):
    """Return (function, line, what stands there) -> its values (rows, numbers)."""
    plain = rows_from(rows.columns)
    asked = replace(tried, watched=True, numbers=[[ALL] for _ in plain])
    replies = student.ask(rows.exercise.name, plain, rows.constants, tried=asked)
    found: dict = {}
    for number, place in enumerate(student.changes):
        visits = [reply.visits.get(number, []) for reply in replies]
        parts = [sum(visit, []) for visit in visits]
        if len({*map(len, parts)}) == 1 and parts[0]:
            # Places that are told together with others come after them alone.
            found.setdefault((place.function, place.line, _bare(place.old)), np.array(parts))
    return found


def _bare(text):
    """Return a text without brackets, which Python adds and leaves out."""
    return _BARE.sub("", text)


def _around(change, before, after):
    """Yield the values before and after of what was changed, and of what it stands in."""
    old, new = _bare(change.old), _bare(change.new.split(", in ")[0])
    for (function, line, text), values in sorted(before.items(), key=lambda item: len(item[0][2])):
        if (function, line) == (change.function, change.line) and old in text:
            now = after.get((function, line, text.replace(old, new)))
            if now is not None and now.shape == values.shape:
                yield values, now


def named_change(
    change: Change, around: Iterable[tuple[Array, Array]], known: Quantities
) -> tuple[str, str]:
    """Return the name and the hint of one change; around: what it was worth before and after, and
    what it stands in, from inside to outside.
    """
    name, hint = _named(change, around, known)
    # What is so in several formulas is so in both legs, or in both coordinates.
    return (_PART.sub("", name) if change.new.endswith("formulas") else name), hint


def _named(change, around, known):
    kind, hint = _kind(change)
    # The name of these tells more than their value.
    told = (
        change.kind in ("a function", "a square", "a mode")
        or re.search(" in place of |^division", kind)
        or {*_WORD.findall(kind)} & dict(known.plain + known.lengths_and_masses).keys()
    )
    where = ""
    for old, new in around:
        quantity = known.name_of(new)
        where = where or quantity
        relations = WITH_ANOTHER if quantity else ADDED
        if change.kind == "a sign":
            relations = tuple(one for one in relations if one[1] == SIGNS)
        found = _related(old, new, quantity, known.others(change), relations)
        if found and not told:
            return found
    return (f"{kind} in {where}" if where else kind), hint


def _related(old, new, quantity, others, relations):
    """Return the name and the hint of what relates a wrong value to the right one, None where
    nothing does, or where they are the same but for rounding.
    """
    if _alike(old, new) or np.all(np.abs(old) <= CLOSE * np.abs(new).max()):
        return None
    with np.errstate(all="ignore"):
        for name, hint, holds, *but_for_sign in ALONE if quantity else ():
            a, b = holds(old, new)
            if _alike(a, b) or but_for_sign and _alike(a, -b):
                return name.format(Q=quantity), hint
        for other, value in others:
            for name, hint, holds, *but_for_sign in relations:
                if other != quantity and value.shape[1] in (1, old.shape[1]):
                    a, b = np.broadcast_arrays(*holds(old, new, value))
                    moves = np.ptp(a, axis=0).max() > CLOSE * np.abs(a).max()
                    if moves and (_alike(a, b) or but_for_sign and _alike(a, -b)):
                        hint = FLIPPED if other in MODES else hint
                        told = name.format(P=other, Q=quantity).removesuffix(" in ")
                        return told.replace("a part of ", ""), hint
    return None


def _kind(change):
    """Return what a kind of change is called, and its hint."""
    new = change.new.split(", in ")[0]
    text = f"{change.old} => {new}"
    for line in KINDS.strip().splitlines():
        kind, pattern, name, hint = line.split("; ")
        found = re.search(pattern, text, re.DOTALL)
        if kind == change.kind and found:
            told = name.format(old=change.old, new=new, **found.groupdict())
            return told, hint.format(**globals())
    raise LookupError(f"a change of no known kind: {change.kind}")
