"""Changes of a student's own formulas, to be tried one after the other; standard library only.

A change is made in one place, or in all places that read alike but for the leg. All changes are
compiled at once: each place asks which of its alternatives is switched on. Nothing here knows the
right answers: the grader compares.
"""

from __future__ import annotations

import ast
import contextlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice, product
from typing import Any

from alternatives import alternatives, operators, places, typed
from reading import deep
from scopes import Scope, compiled, exchanged, names_in, put_in, scopes, short
from watched import Watched

MOST_CHANGES = 4_000
MOST_KNOWN = 4  # programs that are remembered
MOST_TYPED = 256  # ways to name the numbers that a function has typed
MOST_TOLD = 8  # changes of one request that are told in words
WAVES = (0, 1), (2,), (0, 1, 2, 3)  # ranks tried together
MOST_STEPS = 10_000  # of a loop: more of them, and a change has made it endless
SWITCHES = "__on__"  # name of the switches in the student's module
_LEG = re.compile(r"(?<=[A-Za-z_])(?<!tan)[12]|left|right")
_INDEX = re.compile(r"(?<=\[)[01](?=\])")  # is the leg where no name has its number
_NAME = re.compile(r"(?<![(\w])[A-Za-z_]\w*")  # of a variable, in a short text of a node
_TURNED = re.compile(r"\b(sin|cos)\b")
_ADDED = re.compile(r"\((Add|Sub)\)")
MOST_ALIKE = 1  # rank of changes that are made together where they read alike but for the names
LATE = 2  # of the rank of changes in many places
_LEGS = {"1": 1, "0": 1, "left": 1, "2": 2, "right": 2}


class Switches(dict):
    """The alternatives that are switched on: number of a place -> that of its alternative."""

    def __init__(self):
        super().__init__()
        self.steps = 0

    def set_to(self, on: dict[int, int]) -> None:
        self.clear()
        self.update(on)
        self.steps = 0

    def step(self) -> None:
        """Count a step of a loop. Raises RuntimeError where a change lets it go on for ever."""
        self.steps += 1
        if self and self.steps > MOST_STEPS:
            raise RuntimeError(f"more than {MOST_STEPS} steps")


@dataclass(frozen=True)
class Change:
    """A change in one place or more; swaps: id of a node -> the node in its place, or lines."""

    members: list[_Single]
    swaps: dict

    @property
    def told(self) -> tuple[int, str, str, str, str]:
        """The line, what it is about, the function that it is in, what stands there and what is
        tried.
        """
        members = sorted(self.members, key=lambda one: one.place)
        first, count = members[0], len(members)
        both = dict.fromkeys((short(one.old), short(one.new)) for one in members)
        old, new = zip(*both)
        where = "places" if len(both) == 1 else "formulas"
        words = old[0], new[0] + (f", in {count} {where}" if count > 1 else "")
        if {*old} == {*new}:  # they are exchanged
            words = " and ".join(old), " and ".join(new)
        return first.place[0], first.kind, first.scope.name, *words


class Trials:
    """A program to be run with changes in it, or watched.

    A request has the function that is looked at, those that are left apart, what is made before,
    and the wave of changes, None for none. What is made are steps, each in what the ones before it
    left: (function, wave, numbers) of changes, or (function, None, what is written in some places),
    each (number, kind, formula).
    """

    def __init__(self, body: list[ast.stmt]):
        self._body = body
        self._known: dict = {}

    def of(self, request: dict) -> Variants | Watched:
        """Return the program of a request; the last few are remembered."""
        key = json.dumps(request | {"numbers": None})
        if key not in self._known:
            with deep():
                self._known[key] = self._made(request)
            if len(self._known) > MOST_KNOWN:
                del self._known[next(iter(self._known))]
        return self._known[key]

    def _made(self, request):
        body, words = self._body, []
        if request["made"]:
            *before, (function, wave, which) = request["made"]
            step = {"made": before, "function": function, "wave": wave, "watched": wave is None}
            body, words = self.of(request | step).changed(which)
        function, apart = request["function"], request["apart"]
        if request["watched"]:
            return Watched(body, function, apart)
        wave = request["wave"]
        return Variants(body, function, apart, words, () if wave is None else WAVES[wave])


class Variants:
    """A program's functions and the changes of them, likely ones first.

    body: the statements of the program; apart: functions that are left as they are; words: of the
    changes made before; ranks: of the changes, the likely ones have the lowest; () for none.
    """

    def __init__(
        self,
        body: list[ast.stmt],
        function: str,
        apart: list[str],
        words: list[list],
        ranks: tuple[int, ...],
    ):
        self.body, self.words = body, words
        self.scopes = [*scopes(body, function, apart)]
        groups: dict = {}
        signs = _Signs()
        for scope in self.scopes if ranks else ():
            for one in _single_changes(scope, signs):
                for key in one.alike if one.rank in ranks else ():
                    groups.setdefault(key, []).append(one)
        self.changes = _ordered(groups, function)

    def changed(self, numbers: list[int]) -> tuple[list[ast.stmt], list[list]]:
        """Return the program's statements after changes, and these in words."""
        changes = [self.changes[number] for number in numbers]
        swaps = dict(chain.from_iterable(change.swaps.items() for change in changes))
        return exchanged(self.body, swaps), [[*change.told] for change in changes]

    @cached_property
    def _with_switches(self):
        """The code of the functions with all alternatives, by name, and what is switched on for
        each change.
        """
        choices, on = _Choices(), []
        for change in self.changes:
            switched = {}
            for node, new in change.swaps.items():
                switched[node] = choices.number(node, new)
            on.append(switched)
        return compiled(self.body, self.scopes, choices.chosen), on

    @cached_property
    def _arrays(self):
        """The lines that make the file's arrays, in their order."""
        code, _ = self._with_switches
        names = [scope.name for scope in self.scopes if isinstance(scope.function, ast.Assign)]
        return [lines for name, lines in code.items() if name in names]

    def install(self, space: dict, apart: list[str]) -> bool:
        """Put the functions with all alternatives into a module, all switched off; return whether
        a class is among them.
        """
        with deep():
            code, _ = self._with_switches
        space[SWITCHES] = Switches()
        return put_in(space, code, apart)

    def told(self, numbers: list[list[int]]) -> dict:
        """Return how many changes there are; in words, those asked for, if they are few, or else
        those made last.
        """
        wanted = sorted({*chain.from_iterable(numbers)})
        few = wanted if len(wanted) <= MOST_TOLD else []
        words = [[*self.changes[number].told] for number in few]
        return {"count": len(self.changes), "changes": words or self.words}

    def seen(self, space: dict) -> dict:
        """Return nothing, as nothing is watched."""
        return {}

    def switch(self, space: dict, numbers: list[int]) -> None:
        """Switch these changes on in the module, all others off."""
        on: dict = {}
        for number in numbers:
            on |= self._with_switches[1][number]
        space[SWITCHES].set_to(on)
        for lines in self._arrays:
            with contextlib.suppress(Exception):  # the file's own array stays
                exec(lines, space)


@dataclass(frozen=True)
class _Single:
    """A change of one expression, or of whole lines: the nodes, and what comes in their place."""

    rank: int
    kind: str
    scope: Scope
    nodes: list[Any]
    swaps: dict
    key: tuple

    @property
    def place(self) -> tuple[int, int]:
        return self.nodes[0].lineno, self.nodes[0].col_offset

    @property
    def alike(self) -> list[tuple]:
        """Keys of the groups of changes that are made together: those of equal places, of a line,
        under sine and cosine, and of all places that read alike, also but for signs, as the bases
        at -d/2 and d/2 do. In one order: the number of a change is the same in every process.
        """
        kind, text, around = self.key
        line = self.place[0]
        bare = kind, _NAME.sub("", text) if self.rank <= MOST_ALIKE else text
        near = [(kind, text, line), (*bare, line)]
        if isinstance(self.nodes[0], ast.Constant):  # equal numbers mean different things
            keys = near if kind == "an index" else [self.key, *near]
        else:
            unsigned = kind, _ADDED.sub("±", text)
            far = [(kind, text, _TURNED.sub("", around)), (kind, text), bare, unsigned]
            far.append((kind, text, self.scope.name))
            keys = [self.key, *near, *far]
        return [*dict.fromkeys(keys)]

    @property
    def old(self) -> str:
        return ", ".join(dict.fromkeys(map(ast.unparse, self.nodes)))

    @property
    def new(self) -> str:
        told = [new if isinstance(new, list) else [new] for new in self.swaps.values()]
        lines = [ast.unparse(ast.fix_missing_locations(part)) for part in chain(*told)]
        return ", ".join(dict.fromkeys(lines))


def _single_changes(scope, signs) -> Iterator[_Single]:
    for place in places(scope):
        old, around = signs.of(place.node), _leg_free(signs.of(place.parent))
        for rank, kind, new in alternatives(place):
            key = kind, _leg_free(f"{old}; {signs.of(new)}"), around
            yield _Single(rank, kind, scope, [place.node], {id(place.node): new}, key)
    yield from _typed(scope)
    if isinstance(scope.function, ast.FunctionDef):
        for rank, kind, nodes, new in _of_statements(scope):
            swaps = dict(zip(map(id, nodes), new))
            key = kind, _leg_free("; ".join(map(signs.of, (*nodes, *chain(*new))))), ""
            yield _Single(rank, kind, scope, nodes, swaps, key)


def _typed(scope) -> Iterator[_Single]:
    """Yield all numbers that are typed in a function, with the file's in their places."""
    numbers = [place for place in places(scope) if isinstance(place.node, ast.Constant)]
    names = {place.node: new for place in numbers if (new := typed(place))}
    for chosen in islice(product(*names.values()), MOST_TYPED) if names else ():
        swaps = dict(zip(map(id, names), chosen))
        key = "typed numbers", "; ".join(map(ast.unparse, chosen)), scope.name
        yield _Single(1, "a typed number", scope, [*names], swaps, key)


class _Signs:
    """Short texts of nodes, each made once: two nodes that read alike have the same."""

    def __init__(self):
        self._known: dict[int, tuple[ast.AST, str]] = {}

    def of(self, node: ast.AST) -> str:
        known = self._known.get(id(node))
        if known is None or known[0] is not node:
            known = node, self._made(node)
            self._known[id(node)] = known
        return known[1]

    def _made(self, node):
        if isinstance(node, ast.Name):
            return node.id
        parts = [type(node).__name__]
        for _, value in ast.iter_fields(node):
            if isinstance(value, ast.AST):
                parts.append(self.of(value))
            elif isinstance(value, list):
                parts += [self.of(part) if isinstance(part, ast.AST) else part for part in value]
            elif value is not None:
                parts.append(repr(value))
        return f"({' '.join(map(str, parts))})"


def _of_statements(scope) -> Iterator[tuple[int, str, list, list]]:
    """Yield (rank, kind, lines, lines in their place)."""
    # What is given, or stands at the top of the file, may get another value.
    known = {*scope.arguments, *scope.constants}
    for node in ast.walk(scope.function):
        if isinstance(node, ast.AugAssign):
            for other, kind in operators(node.op):
                yield 0, kind, [node], [[ast.AugAssign(node.target, other, node.value)]]
        elif isinstance(node, ast.Assign) and known.issuperset(names_in(node.targets)):
            names = sorted({*names_in(node.targets)} - {*scope.arguments})
            kept = "\n".join(f"{name} = globals()['{name}']" for name in names)
            yield 0, "a line", [node], [ast.parse(kept or "pass").body]


def _ordered(groups, function):
    """Return the changes, of one place and of all places alike, by rank: those of more than two
    places, both legs or both coordinates, come late, and signs of long terms before those in them
    and those in other functions than the one that is looked at.
    """
    ranked, seen = [], set()
    for group in groups.values():
        sets = [[one] for one in group]
        if len(group) > 1:
            sets.append(group)
        for members in sets:
            swaps: dict = {}
            for one in members:
                swaps |= one.swaps
            # Of a place there may be several changes: one of them is made.
            members = [one for one in members if one.swaps.items() <= swaps.items()]
            key = frozenset(map(id, swaps.values()))
            if key not in seen:
                seen.add(key)
                late = LATE if len(members) > 2 else 0
                first = members[0]
                sign = first.kind == "a sign"
                length = sign * len(first.key[1])
                apart = sign and first.scope.name != function
                order = first.rank + late, apart, -length, len(ranked)
                ranked.append((order, members, swaps))
    ranked.sort(key=lambda item: item[0])
    return [Change(members, swaps) for _, members, swaps in ranked[:MOST_CHANGES]]


def _leg_free(text):
    """Return a text with the own leg and the other one for the legs' numbers, so that q12 + q11
    and q22 + q21 read alike; of u[0] and u[1], left and right as well.
    """
    pattern = _LEG if _LEG.search(text) else _INDEX
    first = pattern.search(text)
    own = first and _leg_of(first)
    return pattern.sub(lambda found: "own" if _leg_of(found) == own else "other", text)


def _leg_of(found):
    """Return the leg that a match means: in brackets the first one is number 0."""
    bracket = found.string[found.start() - 1] == "["
    return int(found[0]) + 1 if bracket else _LEGS[found[0]]


class _Choices:
    """The alternatives of each place, which has the id of its node."""

    def __init__(self):
        self._new: dict = {}

    def number(self, place: int, new: Any) -> int:
        known = self._new.setdefault(place, {})
        return known.setdefault(id(new), (len(known), new))[0]

    def chosen(self, node: ast.AST, copy: Any) -> Any:
        """Return a copy of a node that is one of its alternatives where that is switched on."""
        if isinstance(copy, ast.While):
            copy.body.insert(0, ast.parse(f"{SWITCHES}.step()").body[0])
        place = id(node)
        if place not in self._new:
            return copy
        test = ast.Compare(ast.Constant(place), [ast.In()], [_switches()])
        other = _one_of(place, [new for _, new in self._new[place].values()], 0)
        if isinstance(node, ast.stmt):
            return ast.copy_location(ast.If(test, other, [copy]), node)
        return ast.copy_location(ast.IfExp(test, other, copy), node)


def _one_of(place, new, first):
    """Return what chooses one of a place's alternatives by halves; first: number of new[0]."""
    if len(new) == 1:
        return new[0]
    half = len(new) // 2
    low, high = _one_of(place, new[:half], first), _one_of(place, new[half:], first + half)
    which = ast.Subscript(_switches(), ast.Constant(place), ast.Load())
    test = ast.Compare(which, [ast.Lt()], [ast.Constant(first + half)])
    if isinstance(low, list):
        return [ast.If(test, low, high)]
    return ast.IfExp(test, low, high)


def _switches():
    return ast.Name(SWITCHES, ast.Load())
