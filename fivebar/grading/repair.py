"""Where a function is right but for one slip of the pen: the one place whose change makes all its
answers right.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass

MOST_CHANGES, MOST_SURE = 1_500, 12  # tried for one function; of those right once, asked all
MISSING = ("a missing sign", "a missing square", "a missing factor", "a missing transpose")
_OPERATORS = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div, ast.Pow, ast.MatMult, ast.Add),
    ast.Div: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.MatMult: (ast.Mult,),
}
_PAIRS = {"sin": "cos", "cos": "sin", "u": "v", "v": "u", "atan": "atan2", "arctan": "arctan2"}
_NUMBERS = {0: (1,), 1: (0, 2, 0.5), 2: (1, 4), 0.5: (1, 0.25), 0.25: (0.5,), 4: (2,), 3: (2,)}


@dataclass(frozen=True)
class Change:
    """One change: its line, what it is about in a word or two, the text that stands there; the
    changed definition.
    """

    line: int
    what: str
    text: str
    function: str
    source: str


def changes(source: str, function: str, others: Container[str] = ()) -> Iterator[Change]:
    """All single changes in the function and in those of the file that it calls, the others
    apart.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    defined = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    waiting, seen = [function], set()
    while waiting:
        name = waiting.pop(0)
        if name in seen or name not in defined or name in others:
            continue
        seen.add(name)
        node = defined[name]
        waiting += [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and n.id in defined]
        yield from _changed(node, ast.get_source_segment(source, node))


def _changed(definition, text):
    """Each change as text: only the changed expression is written anew."""
    names = {n.id for n in ast.walk(definition) if isinstance(n, ast.Name)} | {
        a.arg for a in definition.args.args
    }
    starts = [0]
    for line in text.split("\n"):
        starts.append(starts[-1] + len(line.encode()) + 1)
    data, first, guards = text.encode(), definition.lineno, _guards(definition)
    for node in ast.walk(definition):
        if node in guards:
            continue
        for what, change in _of(node, names):
            new = _moved(node)
            change(new)
            begin = starts[node.lineno - first] + node.col_offset
            end = starts[node.end_lineno - first] + node.end_col_offset
            changed = data[:begin] + f"({ast.unparse(new)})".encode() + data[end:]
            old = data[begin:end].decode()
            yield Change(
                node.lineno, what, " ".join(old.split()), definition.name, changed.decode()
            )


def _guards(definition):
    """What stands in the condition of an if that only refuses: any change that lets rows pass would
    seem right.
    """
    tests = [
        n.test
        for n in ast.walk(definition)
        if isinstance(n, ast.If) and isinstance(n.body[0], ast.Raise)
    ]
    return {node for test in tests for node in ast.walk(test)}


def _become(node: ast.AST, other: ast.AST) -> None:
    """The node turned into another one, in place."""
    node.__class__ = other.__class__
    node.__dict__.clear()
    node.__dict__.update(other.__dict__)


def _of(node: ast.AST, names: set[str]) -> Iterator[tuple[str, Callable]]:
    """(what is changed, how) of one node of the syntax tree."""
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        for other in _OPERATORS[type(node.op)]:
            yield "an operator", lambda n, other=other: setattr(n, "op", other())
        yield "a part too many", lambda n: _become(n, n.left)
        yield "a part too many", lambda n: _become(n, n.right)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "a sign", lambda n: _become(n, n.operand)
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        for other in sorted(_siblings(node.id, names)):
            yield "a name", lambda n, other=other: setattr(n, "id", other)
    if isinstance(node, ast.Attribute):
        if node.attr in _PAIRS:
            yield "a function", lambda n: setattr(n, "attr", _PAIRS[n.attr])
        if node.attr == "T":
            yield "a transpose", lambda n: _become(n, n.value)
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        for other in _NUMBERS.get(node.value, ()):
            yield "a number", lambda n, other=other: setattr(n, "value", other)
    if isinstance(node, ast.Call) and len(node.args) == 2 and not node.keywords:
        yield "the order of two arguments", lambda n: n.args.reverse()
    if (
        isinstance(node, ast.Call)
        and len(node.args) == 1
        and ast.unparse(node.func).endswith("inv")
    ):
        yield "an inverse", lambda n: _become(n, n.args[0])
    if isinstance(node, ast.expr) and isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
        if isinstance(node, ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute):
            yield from _forgotten(names)


def _forgotten(names):
    """A sign, a square, a factor that is missing."""

    def wrapped(make):
        return lambda n: _become(n, make(_moved(n)))

    yield "a missing sign", wrapped(lambda e: ast.UnaryOp(ast.USub(), e))
    yield "a missing square", wrapped(lambda e: ast.BinOp(e, ast.Pow(), ast.Constant(2)))
    yield "a missing factor", wrapped(lambda e: ast.BinOp(e, ast.Div(), ast.Constant(2)))
    yield "a missing transpose", wrapped(lambda e: ast.Attribute(e, "T", ast.Load()))
    for name in ("l", "mR", "mp", "m"):
        if name in names or name == "l":
            yield (
                "a missing factor",
                wrapped(lambda e, name=name: ast.BinOp(e, ast.Mult(), ast.Name(name, ast.Load()))),
            )
            yield (
                "a missing factor",
                wrapped(lambda e, name=name: ast.BinOp(e, ast.Div(), ast.Name(name, ast.Load()))),
            )


def _moved(node):
    """A node of the same content."""
    other = copy.copy(node)
    other.__dict__.update(node.__dict__)
    return other


def _siblings(name, names):
    """Names that are taken for this one by mistake: other digits, other derivatives, sine and
    cosine.
    """
    bare = re.sub(r"\d|D", "", name)
    alike = {other for other in names if other != name and re.sub(r"\d|D", "", other) == bare}
    pair = {_PAIRS[name]} if name in _PAIRS else set()
    legs = {
        other
        for other in names
        if {other[:1], name[:1]} <= {"u", "v"} and other[1:] == name[1:] and other != name
    }
    axes = {
        other
        for other in names
        if {other[:1], name[:1]} <= {"x", "y"} and other[1:] == name[1:] and other != name
    }
    return alike | pair | legs | axes


_CALLER = """
def changed__(k, *row):
    name, text = changes__[k]
    space = globals()
    kept = space[name]
    try:
        if k not in made__:
            exec(text, space)
            made__[k] = space[name]
        space[name] = made__[k]
        return space[{function!r}](*row)
    finally:
        space[name] = kept
"""


def with_changes(source: str, function: str, tried: list[Change]) -> str:
    """The source with a function changed__(k, *row) that calls it with the k-th change made."""
    table = [(change.function, change.source) for change in tried]
    return (
        f"{source.rstrip()}\n\nmade__ = {{}}\nchanges__ ="
        f" {table!r}\n{_CALLER.format(function=function)}"
    )


def repaired(
    source: str, function: str, open_again: Callable, right: Callable, others: Container[str] = ()
) -> Change | None:
    """The first change that makes the function right, None where none does.

    others: functions that are asked by themselves, and left as they are. open_again(source) gives a
    running Student; right(student, ks, few) says of each of these changes whether the answers are
    right, few: to one or two questions.
    """
    tried = _tried(source, function, others)
    if not tried:
        return None
    with open_again(with_changes(source, function, tried)) as student:
        first = right(student, range(len(tried)), True)
        for k in [k for k, good in enumerate(first) if good][:MOST_SURE]:
            if right(student, [k], False)[0]:
                return tried[k]
    return None


def _tried(source, function, others):
    """Changes of what is written before such of what is missing; none twice."""
    found = list(changes(source, function, others))
    found.sort(key=lambda change: change.what in MISSING)
    unique = {(change.function, change.source): change for change in reversed(found)}
    return list(reversed(unique.values()))[:MOST_CHANGES]
