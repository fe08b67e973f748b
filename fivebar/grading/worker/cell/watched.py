"""What each formula of a program is worth in a call, and what comes back if a formula is worth
something else; standard library only.

Nothing here knows the right answers: the grader looks for the values that lead to them.
"""

from __future__ import annotations

import ast
import sys
from functools import cached_property, partial
from itertools import chain
from typing import Any

from alternatives import Place, places
from scopes import compiled, exchanged, names_in, other_leg, put_in, rebuilt, scopes, short

WATCH = "__watch__"  # name of the watch in the student's module
OLD = "__old__"  # what stands in a place, in what is written there
ARGUMENT = "an argument"
ALL = -1  # in place of a place's number
MOST_PLACES = 800
MOST_NUMBERS = 9  # of a matrix
MOST_VISITS = 8  # of a place in one call that are told
MOST_ATOMS = 150  # values beside a place that are told
LONGEST = 60  # characters of a formula whose value is told beside a place
Group = list[tuple[int, bool]]  # places with the same formula; whether for the other leg


class Watch:
    """Sees the values of all places during a call; puts others in some of them."""

    def __init__(self, texts: list[str]):
        self._texts = texts
        self.begin({}, None)

    def begin(self, put: dict[int, list], told: list[int] | None) -> None:
        """Begin a call; put: place -> the numbers of each visit; told: the places whose visits are
        told with all values that are known then; [] for the visits of all places, None for none.
        """
        self._put, self._told = put, told
        self._visits: dict[int, list] = {}
        self._beside: dict[int, list] = {}
        self._frames: dict = {}

    def __call__(self, place: int, value: Any) -> Any:
        wanted = self._put.get(place)
        if wanted is None and self._told is None:
            return value
        numbers = flat(value)
        if numbers is None:
            return value
        visits = self._visits.setdefault(place, [])
        visits.append(numbers)
        if self._told:
            self._tell(place, numbers, sys._getframe(1))
        if wanted is None or len(visits) > len(wanted):
            return value
        return _like(value, wanted[len(visits) - 1])

    def _tell(self, place, numbers, frame):
        known = self._frames.setdefault(frame, {})
        if place in self._told:
            beside = {**_named(frame), **known, OLD: numbers}
            self._beside.setdefault(place, []).append(beside)
        known[self._texts[place]] = numbers

    def visits(self, group: Group) -> list:
        """Return the numbers of all visits of a group's places, none where one has more."""
        visits = [self._visits.get(place, []) for place, _ in group]
        same = len({*map(len, visits)}) == 1 and len(visits[0]) <= MOST_VISITS
        return [*chain.from_iterable(visits)] if same else []

    def beside(self, group: Group) -> list:
        """Return what was known at each visit of a group's places, in the names of the first."""
        told = []
        for place, is_other in group:
            for known in self._beside.get(place, [])[:MOST_VISITS]:
                name_of = other_leg if is_other else str
                pairs = [[name_of(name), numbers] for name, numbers in known.items() if name]
                own = pairs[-1:]
                others = pairs[: MOST_ATOMS - 1]
                told.append(own + others)
        return told


def flat(value: Any) -> list[float] | None:
    """Return the numbers of a value, None where it has none or too many."""
    numpy = sys.modules.get("numpy")
    if isinstance(value, int | float | complex):
        if isinstance(value, bool) or not abs(value) < 1e12:  # false for NaN
            return None
        return [value.real, value.imag] if isinstance(value, complex) else [float(value)]
    if numpy is not None and isinstance(value, numpy.ndarray | numpy.number):
        if value.size > MOST_NUMBERS or value.dtype.kind not in "iufc":
            return None
        value = numpy.asarray(value).ravel().tolist()  # a matrix stays one in ravel
    if not isinstance(value, list | tuple):
        return None
    numbers: list[float] = []
    for part in value[: MOST_NUMBERS + 1]:
        inside = flat(part)
        if inside is None:
            return None
        numbers += inside
    return numbers if 0 < len(numbers) <= MOST_NUMBERS else None


def _like(value, numbers):
    """Return these numbers as a value of the same kind."""
    numpy = sys.modules.get("numpy")
    if isinstance(value, list | tuple):
        left, parts = iter(numbers), []
        for part in value:
            parts.append(_like(part, [next(left) for _ in flat(part)]))
        return type(value)(parts)
    if isinstance(value, complex):
        return complex(*numbers)
    if numpy is None or not isinstance(value, numpy.ndarray):
        return numbers[0]
    if value.dtype.kind == "c":
        numbers = [complex(*pair) for pair in zip(numbers[::2], numbers[1::2])]
    return numpy.array(numbers).reshape(value.shape).view(type(value))


def _named(frame):
    """Return the numbers that names have in a frame, those of an object's parts among them."""
    named = {name: flat(value) for name, value in frame.f_locals.items()}
    own = getattr(frame.f_locals.get("self"), "__dict__", {})
    named |= {f"self.{part}": flat(value) for part, value in own.items()}
    for name, value in frame.f_globals.items():
        if type(value) in (int, float) and not name.startswith("_"):
            named[f"globals()['{name}']" if name in named else name] = flat(value)
    return {name: numbers for name, numbers in named.items() if numbers is not None}


class Watched:
    """A program whose functions show the values of their formulas.

    groups: each place alone, and two that are the same for either leg.
    """

    def __init__(self, body: list[ast.stmt], function: str, apart: list[str]):
        self._body = body
        self._scopes = [*scopes(body, function, apart)]
        self._places: list[Place] = []
        for scope in self._scopes:
            self._places += [place for place in places(scope) if _may_differ(place)]
        del self._places[MOST_PLACES:]
        self._texts = [ast.unparse(place.node) for place in self._places]
        self.groups: list[Group] = [[(k, False)] for k in range(len(self._places))]
        self.groups += _twins(self._places, self._texts)

    def install(self, space: dict, apart: list[str]) -> bool:
        """Put the functions that show their values into a module, as `Variants` does."""
        space[WATCH] = Watch([text if len(text) <= LONGEST else "" for text in self._texts])
        return put_in(space, self._code, apart)

    @cached_property
    def _code(self):
        numbers = {id(place.node): number for number, place in enumerate(self._places)}
        return compiled(self._body, self._scopes, partial(_shown, numbers))

    def told(self, numbers: list) -> dict:
        """Return how many groups there are; all in words where their visits are asked for, as
        changes have them: line, whether the first place is an argument, function, what stands
        there, and the names that the function gives a value and never reads.
        """
        words = []
        unread = {scope.name: " ".join(_unread(scope)) for scope in self._scopes}
        is_asked = any(row[0] == ALL for row in numbers)
        for group in self.groups if is_asked else ():
            place, text = self._places[group[0][0]], self._texts[group[0][0]]
            kind = ARGUMENT if text in place.scope.arguments else ""
            inside = place.scope.name
            line = place.node.lineno
            words.append([line, kind, inside, text, unread[inside]])
        return {"count": len(self.groups), "changes": words}

    def switch(self, space: dict, numbers: list) -> None:
        """Begin a call; numbers: the group that is told, ALL or None, and (group, the numbers of
        its visits) for those in which others are put.
        """
        self._asked, *pairs = numbers
        put = {}
        for group, visits in pairs:
            places = self.groups[group]
            each = len(visits) // len(places)
            for k, (place, _) in enumerate(places):
                put[place] = visits[k * each : (k + 1) * each]
        told: list[int] | None = None
        if self._asked == ALL:
            told = []
        elif self._asked is not None:
            told = [place for place, _ in self.groups[self._asked]]
        space[WATCH].begin(put, told)

    def seen(self, space: dict) -> dict:
        """Return what the last call showed."""
        watch = space[WATCH]
        if self._asked is None:
            return {}
        if self._asked != ALL:
            return {"beside": watch.beside(self.groups[self._asked])}
        return {"visits": [[k, watch.visits(group)] for k, group in enumerate(self.groups)]}

    def changed(self, written: list) -> tuple[list[ast.stmt], list[list]]:
        """Return the program's statements with formulas written in some places, and each of these
        changes in words: line, kind, function, what stands there, and what is written.
        """
        swaps, told = {}, []
        for number, kind, text in written:
            group = self.groups[number]
            for k, is_other in group:
                new = ast.parse(other_leg(text) if is_other else text, mode="eval").body
                node = self._places[k].node
                swaps[id(node)] = rebuilt(new, partial(_with_old, node))
            place = self._places[group[0][0]]
            new = ast.fix_missing_locations(swaps[id(place.node)])
            shown = short(ast.unparse(new))
            if len(group) > 1:
                shown += f", in {len(group)} formulas"
            old = short(self._texts[group[0][0]])
            told.append([place.node.lineno, kind, place.scope.name, old, shown])
        return exchanged(self._body, swaps), told


def _unread(scope):
    """Return the names to which a function gives a value that it does not use."""
    read = names_in([scope.function], ast.Load)
    return [name for name in scope.stored if name not in read]


def _target(line):
    return ast.unparse(line.targets[0]) if isinstance(line, ast.Assign) else ""


def _read_line(line):
    if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Subscript):
        line = line.value  # B[0, 0] and B[1, 1] are one for either leg
    return ast.unparse(getattr(line, "test", line))


def _may_differ(place):
    """Return whether another number may stand in a place: not in that of an index."""
    indexed = isinstance(place.parent, ast.Subscript) and place.node is place.parent.slice
    return not indexed and not isinstance(place.node, ast.Tuple | ast.List | ast.Compare)


def _twins(places: list[Place], texts: list[str]) -> list[Group]:
    """Return pairs of places that are the same for either leg: at the same position in two lines
    that are so, or by themselves.
    """
    lines: dict = {}
    for k, place in enumerate(places):
        lines.setdefault((place.scope.name, place.line), []).append(k)
    by_text = {(name, _read_line(line)): numbers for (name, line), numbers in lines.items()}
    twins: list[Group] = []
    alone: dict = {}
    for (name, line), numbers in lines.items():
        partner = by_text.get((name, other_leg(_read_line(line))))
        if partner and partner[0] > numbers[0] and len(partner) == len(numbers):
            twins += [[(a, False), (b, True)] for a, b in zip(numbers, partner)]
        elif not partner or partner == numbers:
            for k in numbers:
                alone.setdefault((name, _target(line), texts[k]), []).append(k)
    for (name, target, text), numbers in alone.items():
        others = alone.get((name, other_leg(target), other_leg(text)), [])
        same = len(others) == len(numbers) and others[0] > numbers[0]
        if same and (target, text) != (other_leg(target), other_leg(text)):
            twins += [[(a, False), (b, True)] for a, b in zip(numbers, others)]
    return twins


def _shown(numbers, node, copy):
    number = numbers.get(id(node))
    if number is None:
        return copy
    shown = ast.Call(ast.Name(WATCH, ast.Load()), [ast.Constant(number), copy], [])
    return ast.copy_location(shown, node)


def _with_old(old, node, copy):
    return old if getattr(node, "id", None) == OLD else copy
