"""Single changes of a student's own formulas, to be tried one after the other; standard library
only.

A change is made in one place, or in all places that read alike but for the leg. Nothing here knows
the right answers: the grader compares.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

MOST_CHANGES = 2_000
MOST_TEXT = 60  # characters quoted
_OPERATORS: dict[type, tuple] = {
    ast.Add: ((ast.Sub, "a sign"), (ast.Mult, "an operator")),
    ast.Sub: ((ast.Add, "a sign"), (ast.Mult, "an operator")),
    ast.Mult: (
        (ast.Div, "an operator"),
        (ast.Pow, "a square"),
        (ast.MatMult, "a matrix product"),
        (ast.Add, "an operator"),
    ),
    ast.Div: ((ast.Mult, "an operator"),),
    ast.Pow: ((ast.Mult, "a square"),),
    ast.MatMult: ((ast.Mult, "a matrix product"),),
}
_DROPPED: dict[type, str] = {
    ast.Add: "a term",
    ast.Sub: "a term",
    ast.Mult: "a factor",
    ast.Div: "a factor",
    ast.MatMult: "a factor",
    ast.Pow: "a square",
}
_FUNCTIONS = {
    "sin": ("cos", "tan"),
    "cos": ("sin",),
    "tan": ("sin",),
    "asin": ("acos",),
    "acos": ("asin",),
    "arcsin": ("arccos",),
    "arccos": ("arcsin",),
    "real": ("imag",),
    "imag": ("real",),
    "min": ("max",),
    "max": ("min",),
}
_ATAN = {"atan": "atan2", "arctan": "arctan2"}
_FACTORS = (1, 2, 0.5, 0.25)  # tried in the place of another number
MOST_WHOLE = 20  # of whole numbers that may be off by 1
_INVERSE = "__import__('numpy').linalg.inv"
_VALUES = ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute | ast.Constant
_GROUPS = ast.Mult | ast.Div | ast.MatMult | ast.Pow


@dataclass(frozen=True)
class Change:
    """A change: the line, what it is about, the function that it is in, what stands there and what
    is tried; swaps: id of a node -> the node in its place.
    """

    line: int
    kind: str
    function: str
    old: str
    new: str
    swaps: dict
    functions: tuple[ast.FunctionDef, ...]

    def made(self, space: dict) -> dict:
        """Return the changed functions by name, made of the names of this module."""
        made: dict = {}
        for function in self.functions:
            tree = ast.Module([rebuilt(function, self.swaps)], [])
            own = dict(space)
            exec(compile(ast.fix_missing_locations(tree), "<changed>", "exec"), own)
            made[function.name] = _in_module(own[function.name], space)
        return made


def _in_module(function, space):
    """Return the function with the module's own names, so that what it calls is what stands there
    when it is called.
    """
    own = type(function)(
        function.__code__, space, function.__name__, function.__defaults__, function.__closure__
    )
    own.__kwdefaults__ = function.__kwdefaults__
    return own


def changes(source: str, function: str, apart: list[str]) -> list[Change]:
    """Return single changes in a function and in those of the file that it calls, likely ones
    first; apart: functions that are left as they are.
    """
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    defined = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
    constants = [
        target.id
        for node in body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    ]
    waiting: list[str] = [function]
    seen: list[str] = []
    found: dict = {}
    while waiting:
        name = waiting.pop(0)
        if name in seen or name not in defined or (name in apart and name != function):
            continue
        seen.append(name)
        node = defined[name]
        waiting += [part.id for part in ast.walk(node) if isinstance(part, ast.Name)]
        for place in _places(node, constants):
            for rank, kind, new in _alternatives(place, constants):
                change = _leg_free(f"{ast.unparse(place.node)}; {ast.unparse(new)}")
                key = kind, change, _LEG.sub("", ast.unparse(place.parent))
                found.setdefault(key, []).append((rank, kind, place, new))
    return _ordered(found.values())


def _ordered(groups):
    """Return the changes, of one place and of all places alike, by rank."""
    ranked = []
    for group in groups:
        group.sort(key=lambda one: (one[2].node.lineno, one[2].node.col_offset))
        sets = [[one] for one in group] + ([group] if len(group) > 1 else [])
        for members in sets:
            rank, kind, first, new = members[0]
            functions = {place.function.name: place.function for _, _, place, _ in members}
            change = Change(
                first.node.lineno,
                kind,
                first.function.name,
                _text(first.node),
                _text(new) + (f", in {len(members)} places" if len(members) > 1 else ""),
                {id(place.node): other for _, _, place, other in members},
                tuple(functions.values()),
            )
            ranked.append((rank, len(ranked), change))
    ranked.sort(key=lambda item: item[:2])
    return [change for _, _, change in ranked[:MOST_CHANGES]]


def _text(node):
    text = ast.unparse(node).replace(_INVERSE, "inv")
    return text if len(text) <= MOST_TEXT else f"{text[: MOST_TEXT - 4]} ..."


def rebuilt(node: ast.AST, swaps: dict) -> Any:
    """Return a copy of a tree with other nodes in some places."""
    if id(node) in swaps:
        return ast.copy_location(swaps[id(node)], node)
    fields = {name: _copied(value, swaps) for name, value in ast.iter_fields(node)}
    return ast.copy_location(type(node)(**fields), node)


def _copied(value, swaps):
    if isinstance(value, ast.AST):
        return rebuilt(value, swaps)
    if isinstance(value, list):
        return [_copied(part, swaps) for part in value]
    return value


_LEG = re.compile(r"(?<=[A-Za-z_])[12]|left|right")
_INDEX = re.compile(r"(?<=\[)[01](?=\])")  # is the leg where no name has its number
_LEGS = {"1": 1, "0": 1, "left": 1, "2": 2, "right": 2}


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


@dataclass(frozen=True)
class Place:
    """An expression, its parent, and the function that it is in; term: whether it is no factor of a
    product.
    """

    node: ast.expr
    parent: ast.AST
    function: ast.FunctionDef
    term: bool
    names: frozenset[str]

    @property
    def arguments(self) -> list[str]:
        return [argument.arg for argument in self.function.args.args]

    @property
    def stored(self) -> list[str]:
        """Names to which the function itself gives a value."""
        parts = [part for part in ast.walk(self.function) if isinstance(part, ast.Name)]
        return sorted({part.id for part in parts if isinstance(part.ctx, ast.Store)})

    def like(self, name: str) -> list[str]:
        """Return names that are taken for this one by mistake: other digits, u and v, x and y."""
        bare = _bare(name)
        return sorted(other for other in self.names if other != name and _bare(other) == bare)


def _bare(name):
    return re.sub(r"^v", "u", re.sub(r"^y", "x", re.sub(r"\d", "", name)))


def _places(function: ast.FunctionDef, constants: list[str]) -> Iterator[Place]:
    """Yield the expressions of a function that may be changed: not those that guard it, and no
    condition of a loop, which might then not end.
    """
    arguments = {part.arg for part in ast.walk(function) if isinstance(part, ast.arg)}
    used = {part.id for part in ast.walk(function) if isinstance(part, ast.Name)}
    names = frozenset(arguments | used | set(constants))
    waiting: list[tuple[ast.AST, bool]] = [(node, True) for node in reversed(function.body)]
    while waiting:
        parent, _ = waiting.pop()
        if isinstance(parent, ast.While) or _is_guard(parent) or _is_text(parent):
            continue
        product = isinstance(parent, ast.BinOp) and isinstance(parent.op, _GROUPS)
        sign = isinstance(parent, ast.UnaryOp)
        for node in ast.iter_child_nodes(parent):
            if isinstance(node, ast.expr) and _is_read(node) and not _is_called(node, parent):
                yield Place(node, parent, function, not product and not sign, names)
            waiting.append((node, True))


def _is_guard(node):
    return isinstance(node, ast.If) and isinstance(node.body[0], ast.Raise)


def _is_text(node):
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def _is_read(node):
    return isinstance(getattr(node, "ctx", ast.Load()), ast.Load)


def _is_called(node, parent):
    """Return whether a node only names what is called or taken a part of."""
    if isinstance(parent, ast.Call) and node is parent.func:
        name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
        return name not in _FUNCTIONS
    return isinstance(parent, ast.Attribute) and isinstance(node, ast.Name) and not _is_array(node)


def _is_array(node):
    return node.id not in ("np", "numpy", "math", "cmath", "linalg")


def _alternatives(place: Place, constants: list[str]) -> Iterator[tuple[int, str, ast.expr]]:
    """Yield (rank, kind, new node): first what replaces one sign or name, last what adds one."""
    node = place.node
    if isinstance(node, ast.BinOp):
        yield from _of_operation(node)
    elif isinstance(node, ast.UnaryOp):
        yield 0, "a sign", node.operand
    elif isinstance(node, ast.Name):
        yield from ((0, "a variable", _name(other)) for other in place.like(node.id))
        yield from ((0, "a function", _name(other)) for other in _FUNCTIONS.get(node.id, ()))
    elif isinstance(node, ast.Attribute):
        yield from _of_attribute(node)
    elif isinstance(node, ast.Constant):
        yield from _of_number(node.value)
    elif isinstance(node, ast.Call):
        yield from _of_call(node)
    elif isinstance(node, ast.Subscript):
        yield from _of_subscript(node)
    elif isinstance(node, ast.Tuple | ast.List) and len(node.elts) == 2:
        yield 1, "the order", type(node)(node.elts[::-1], node.ctx)
    if isinstance(place.parent, ast.stmt) or isinstance(node, ast.Call):
        yield from _exchanged(node)
    if isinstance(node, _VALUES) and not _is_called_name(place):
        given = isinstance(node, ast.Name) and node.id in place.arguments
        for rank, kind, new in _added(place, constants):
            yield rank + given, kind, new  # an argument itself is seldom what is wrong


def _exchanged(node):
    """Yield a whole formula with sine and cosine, or both legs, in each other's place."""
    text = ast.unparse(node)
    pairs = (
        ("a function", {"sin": "cos", "cos": "sin"}, r"\b(sin|cos)\b"),
        ("a variable", {"1": "2", "2": "1"}, r"(?<=[A-Za-z_])(?<!tan)[12](?=\d|D|\b)"),
    )
    for kind, others, pattern in pairs:
        changed = re.sub(pattern, lambda found, others=others: others[found[0]], text)
        if changed != text:
            yield 2, kind, ast.parse(changed, mode="eval").body


def _is_called_name(place):
    """Return whether a node is the name of a function in a call, or an index."""
    parent = place.parent
    return (
        isinstance(parent, ast.Call)
        and place.node is parent.func
        or isinstance(parent, ast.Subscript)
        and place.node is parent.slice
    )


def _name(name):
    return ast.Name(name, ast.Load())


def _of_operation(node):
    left, op, right = node.left, node.op, node.right
    for other, kind in _OPERATORS.get(type(op), ()):
        yield 0, kind, ast.BinOp(left, other(), right)
    kind = _DROPPED.get(type(op), "a term")
    yield 2, kind, left
    if not isinstance(op, ast.Pow):
        yield 2, kind, right
    if isinstance(op, ast.Sub):
        yield 1, "a sign", ast.UnaryOp(ast.USub(), ast.BinOp(left, ast.Add(), right))
    if isinstance(op, ast.Div) and isinstance(left, ast.Constant):
        yield 2, "an inverse", _inverse_of(right)
    if isinstance(op, ast.Pow) and isinstance(right, ast.UnaryOp):
        yield 2, "an inverse", _inverse_of(left)
    if not isinstance(op, ast.Add | ast.Mult):
        yield 1, "the order", ast.BinOp(right, op, left)
    yield from ((1, "a bracket", new) for new in _brackets(left, op, right))


def _brackets(left, op, right):
    """Yield the other ways to set brackets in an operation on operations."""
    if isinstance(left, ast.BinOp):
        yield ast.BinOp(left.left, left.op, ast.BinOp(left.right, op, right))
    if isinstance(right, ast.BinOp):
        yield ast.BinOp(ast.BinOp(left, op, right.left), right.op, right.right)
    powers = isinstance(left, ast.BinOp) and isinstance(right, ast.BinOp)
    if powers and isinstance(left.op, ast.Pow) and isinstance(right.op, ast.Pow):
        yield ast.BinOp(ast.BinOp(left.left, op, right.left), ast.Pow(), left.right)
    if isinstance(op, ast.Add | ast.Sub) and isinstance(left, ast.Call) and left.args:
        inner = ast.BinOp(left.args[-1], op, right)
        yield ast.Call(left.func, [*left.args[:-1], inner], left.keywords)


def _of_number(value):
    if type(value) not in (int, float) or abs(value) > MOST_WHOLE:
        return
    near = (value - 1, value + 1) if type(value) is int else ()
    for other in dict.fromkeys((*near, *_FACTORS)):
        if other != value:
            yield 1, "a number", ast.Constant(other)


def _inverse_of(node):
    return ast.Call(ast.parse(_INVERSE, mode="eval").body, [node], [])


def _of_attribute(node):
    if node.attr == "T":
        yield 0, "a transpose", node.value
        yield 2, "an inverse", _inverse_of(node.value)
    for other in _FUNCTIONS.get(node.attr, ()):
        yield 0, "a function", ast.Attribute(node.value, other, ast.Load())


def _of_call(node):
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    arguments = node.args
    if node.keywords or not arguments:
        return
    if len(arguments) == 2:
        yield 1, "the order", ast.Call(node.func, arguments[::-1], [])
    if len(arguments) == 1:
        kind = "an inverse" if name.endswith("inv") else "a root" if name == "sqrt" else "a call"
        yield 2, kind, arguments[0]
    if name == "solve" and len(arguments) == 2:
        yield 1, "an inverse", ast.BinOp(arguments[0], ast.MatMult(), arguments[1])
    quotient = arguments[0]
    if name in _ATAN and isinstance(quotient, ast.BinOp) and isinstance(quotient.op, ast.Div):
        both = [quotient.left, quotient.right]
        if isinstance(node.func, ast.Attribute):
            yield (
                1,
                "a function",
                ast.Call(ast.Attribute(node.func.value, _ATAN[name], ast.Load()), both, []),
            )
    last = arguments[-1]
    if isinstance(last, ast.BinOp) and isinstance(last.op, ast.Add | ast.Sub):
        inner = ast.Call(node.func, [*arguments[:-1], last.left], [])
        yield 1, "a bracket", ast.BinOp(inner, last.op, last.right)


def _of_subscript(node):
    index = node.slice
    if isinstance(index, ast.Slice):
        yield 1, "the order", node.value
    elif isinstance(index, ast.Tuple) and len(index.elts) == 2:
        yield 1, "an index", _part(node, ast.Tuple(index.elts[::-1], ast.Load()))
        for k, one in enumerate(index.elts):
            for other in _indices(one):
                both = [*index.elts]
                both[k] = other
                yield 1, "an index", _part(node, ast.Tuple(both, ast.Load()))
    else:
        yield from ((0, "an index", _part(node, other)) for other in _indices(index))


def _part(node, index):
    return ast.Subscript(node.value, index, ast.Load())


def _indices(node):
    if isinstance(node, ast.Constant) and type(node.value) is int:
        yield from (ast.Constant(k) for k in range(3) if k != node.value)


def _added(place, constants):
    """Yield what has been forgotten: a sign, a square, a root, a factor, a term."""
    node, parent = place.node, place.parent

    def with_(op, right):
        return ast.BinOp(node, op, right)

    if not isinstance(node, ast.Constant):
        yield 3, "a square", with_(ast.Pow(), ast.Constant(2))
        if place.term or isinstance(node, ast.Call):
            yield 3, "a root", with_(ast.Pow(), ast.Constant(0.5))
    matrices = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.MatMult)
    if matrices or (isinstance(parent, ast.Call) and not isinstance(node, ast.Constant)):
        yield 3, "a transpose", ast.Attribute(node, "T", ast.Load())
        yield 3, "an inverse", _inverse_of(node)
    if isinstance(node, ast.Name):
        for name in place.arguments:
            if _kind(name) == _kind(node.id) and name != node.id:
                yield 2, "a term", with_(ast.Add(), _name(name))
                yield 2, "a term", with_(ast.Sub(), _name(name))
        for name in place.stored:
            if name != node.id:
                yield 6, "a term", with_(ast.Add(), _name(name))
                yield 6, "a term", with_(ast.Sub(), _name(name))
    if not place.term:
        return
    yield 3, "a sign", ast.UnaryOp(ast.USub(), node)
    yield 4, "a factor", with_(ast.Div(), ast.Constant(2))
    yield 4, "a factor", with_(ast.Mult(), ast.Constant(2))
    yield 5, "a term", with_(ast.Add(), ast.Constant(1))
    yield 5, "a term", with_(ast.Sub(), ast.Constant(1))
    modes = [name for name in place.arguments if re.match("assembly|gamma|branch", name)]
    known = (*constants, *modes)
    for name in (*known, *(name for name in place.stored if name not in known)):
        rank = 4 if name in known else 5
        yield rank, "a factor", with_(ast.Mult(), _name(name))
        yield rank, "a factor", with_(ast.Div(), _name(name))
    if isinstance(parent, ast.Return | ast.Tuple | ast.List):
        yield 3, "a transpose", ast.Attribute(node, "T", ast.Load())
        for name in place.arguments:
            yield 5, "a term", with_(ast.Add(), _name(name))
            yield 5, "a term", with_(ast.Sub(), _name(name))


def _kind(name):
    """Return a name without its digits: q11 and q22 are angles, q11D and q22D are rates."""
    return re.sub(r"\d", "", name)
