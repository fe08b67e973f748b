"""What may stand in the place of an expression or a statement: the slips that people make, undone;
standard library only.

Each alternative is (rank, kind, new): likely ones have a low rank. Nothing here knows the right
answers.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial, reduce
from itertools import combinations, permutations

from scopes import LEG_NUMBER, Scope, names_in, other_leg

# An operator, what may be meant, and what is then wrong.
_OPERATORS = """
Add Sub a sign
Add Mult an operator
Sub Add a sign
Sub Mult an operator
Mult Div an operator
Mult Pow a square
Mult MatMult a matrix product
Mult Add an operator
Mult Sub an operator
Div Mult an operator
FloorDiv Div an operator
Pow Mult a square
MatMult Mult a matrix product
"""
# A comparison, or a function, and those that may be meant.
_TABLE = """
Lt Gt LtE
LtE GtE Lt
Gt Lt GtE
GtE LtE Gt
Eq NotEq Lt Gt
NotEq Eq
sin cos tan
cos sin
tan sin
asin acos
acos asin
arcsin arccos
arccos arcsin
real imag
imag real
min max
max min
outer dot cross
cross dot
dot cross outer
column_stack vstack
vstack column_stack
"""
_MODULES = "np numpy math cmath linalg mt".split()
_MEANT = {word: others for word, *others in map(str.split, _TABLE.strip().splitlines())}
_LIMITS = "round max min maximum minimum clip".split()  # that may be too much
_OF_MATRICES = ast.MatMult | ast.Assign | ast.Attribute  # what a matrix may stand in
_FACTOR = ast.Mult | ast.Div | ast.MatMult
_FACTORS = (1, 2, 0.5, 0.25)  # tried in the place of another number
_THRESHOLDS = [10.0**-power for power in range(3, 13)]  # tried in place of a small number
LARGEST_THRESHOLD = 0.05
MANY = 200  # steps, enough for what comes closer with each
MOST_WHOLE = 20  # of whole numbers that may be off by 1
MOST_FACTORS = 4  # of a product of matrices of which all orders are tried
MOST_ARGUMENTS = 4  # of a call of which all orders are tried
_BAR = re.compile(r"\d(?=\D*$)")  # the number of a bar in its leg
_GROUPS = ast.Mult | ast.Div | ast.MatMult | ast.Pow | ast.FloorDiv
Alternatives = Iterator[tuple[int, str, ast.expr]]


@dataclass(frozen=True)
class Place:
    """An expression, its parent, the statement and the scope that it is in; term: whether it is no
    factor of a product.
    """

    node: ast.expr
    parent: ast.AST
    line: ast.AST
    scope: Scope
    term: bool


def places(scope: Scope) -> Iterator[Place]:
    """Yield the expressions of a function that may be changed."""
    body = getattr(scope.function, "body", None)
    start: list[ast.AST] = [*reversed(body)] if isinstance(body, list) else [scope.function]
    waiting = [(node, node) for node in start]
    while waiting:
        parent, line = waiting.pop()
        line = parent if isinstance(parent, ast.stmt) else line
        if _is_text(parent) or isinstance(parent, ast.Raise | ast.arguments):
            continue
        product = isinstance(parent, ast.BinOp) and isinstance(parent.op, _GROUPS)
        sign = isinstance(parent, ast.UnaryOp)
        for node in ast.iter_child_nodes(parent):
            if isinstance(node, ast.expr) and _is_read(node) and not _is_called(node, parent):
                yield Place(node, parent, line, scope, not product and not sign)
            waiting.append((node, line))


def _is_text(node: ast.AST) -> bool:
    """Return whether a node is a text or another constant that is no number."""
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and not isinstance(node.value, int | float | complex)
    )


def _is_read(node):
    loaded = isinstance(getattr(node, "ctx", ast.Load()), ast.Load)
    return loaded and not isinstance(node, ast.Starred | ast.Slice)


def _is_called(node, parent):
    """Return whether a node only names what is called or taken a part of, or lists indices."""
    if isinstance(parent, ast.Call) and node is parent.func:
        return _callee(parent) not in _MEANT
    if isinstance(parent, ast.Subscript) and node is parent.slice:
        return isinstance(node, ast.Tuple)
    return isinstance(parent, ast.Attribute) and getattr(node, "id", None) in _MODULES


def alternatives(place: Place) -> Alternatives:
    """Yield what may stand there where a sign, mode, name, order or transpose is wrong."""
    node = place.node
    if type(node) in _OF:
        yield from _OF[type(node)](place)
    stored = isinstance(getattr(place.parent, "ctx", None), ast.Store)
    signed = ast.BinOp | ast.Call | ast.Name | ast.Subscript
    if place.term and not stored and isinstance(node, signed):
        yield 2, "a sign", ast.UnaryOp(ast.USub(), node)
        for by in (*map(name_of, place.scope.constants), ast.Constant(2)):
            yield 3, "a factor", ast.BinOp(node, ast.Mult(), by)
            yield 3, "a factor", ast.BinOp(node, ast.Div(), by)
        for other in map(name_of, place.scope.arguments):
            yield 3, "a term", ast.BinOp(node, ast.Add(), other)
            yield 3, "a term", ast.BinOp(node, ast.Sub(), other)
    if isinstance(node, ast.BinOp | ast.Call):
        # A turn by 90 degrees is a factor of complex numbers.
        yield 3, "a direction", ast.BinOp(ast.Constant(1j), ast.Mult(), node)
    # A fixed sign may be that of one mode alone.
    for name in place.scope.arguments if place.term or isinstance(node, ast.UnaryOp) else ():
        if re.match("assembly|gamma|branch", name):
            both = ast.BinOp(getattr(node, "operand", node), ast.Mult(), name_of(name))
            yield 2, "a mode", both
    around = getattr(place.parent, "op", place.parent)
    if isinstance(around, _OF_MATRICES) or _callee(around) in ("dot", "solve"):
        yield 1, "a transpose", transposed(node)
    whole = isinstance(place.parent, ast.stmt | ast.Lambda | ast.List | ast.Tuple)
    if whole or isinstance(node, ast.Call) or isinstance(around, ast.Div):
        yield from _exchanged(node, place.scope)


def _of_condition(place):
    node = place.node
    if isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield 1, "a comparison", ast.BoolOp(other, node.values)
    elif len(node.ops) == 1:
        for other in _MEANT.get(type(node.ops[0]).__name__, ()):
            op = getattr(ast, other)()
            yield 1, "a comparison", ast.Compare(node.left, [op], node.comparators)


def _exchanged(node, scope):
    """Yield a whole formula with sine and cosine, both legs, or two of the file's numbers in each
    other's place, or two arguments that it holds once.
    """
    text = ast.unparse(node)
    names = names_in([node])
    numbers = sorted({*scope.constants} & {*names})
    once = [name for name in scope.arguments if names.count(name) == 1]
    pairs = *combinations(numbers, 2), *combinations(once, 2)
    ways = [
        *(("a variable", _swapped(text, *pair)) for pair in pairs),
        ("a function", _swapped(text, "sin", "cos")),
        ("a variable", other_leg(text)),
        ("a variable", re.sub(r"\w+", partial(_of_other_leg, scope.constants), text)),
        ("a variable", _swapped(text, "A", "B")),
    ]
    for kind, changed in ways:
        if changed != text:
            yield 2, kind, ast.parse(changed, mode="eval").body


def _of_other_leg(names, found):
    return other_leg(found[0]) if found[0] in names else found[0]


def _swapped(text, a, b):
    """Return a formula with two names in each other's place."""
    return re.sub(rf"\b({a}|{b})\b", lambda found: b if found[0] == a else a, text)


def name_of(name: str) -> ast.expr:
    """Return the name as it is read."""
    return ast.Name(name, ast.Load())


def _of_name(place):
    name, scope = place.node.id, place.scope
    rank = int(_is_given_by_name(place))
    yield from ((rank, "a variable", name_of(other)) for other in scope.like(name))
    for other in _added_angles(place):
        yield 1, "a term", ast.BinOp(name_of(other), ast.Add(), place.node)
    yield from ((0, "a function", name_of(other)) for other in _MEANT.get(name, ()))
    if name in scope.constants:
        yield 1, "a factor", ast.BinOp(place.node, ast.Div(), ast.Constant(2))
    yield 2, "a square", ast.BinOp(place.node, ast.Pow(), ast.Constant(2))
    rank = 2 if name in scope.known else 0
    # A list that is put into itself takes all memory.
    if _callee(place.parent) != "append":
        yield from ((rank, "a variable", name_of(other)) for other in scope.stored)


def _added_angles(place):
    """Return names of what may be forgotten in an angle or a rate: the direction of a bar is the
    sum of its leg's angles.
    """
    name, scope = place.node.id, place.scope
    alike = [other for other in scope.like(name) if _BAR.sub("", other) == _BAR.sub("", name)]
    alone = isinstance(place.parent, ast.Call) and len(place.parent.args) == 1
    return alike or (scope.arguments if alone and len(scope.arguments) == 2 else [])


def _is_given_by_name(place):
    """Return whether a name is given to a function that has the same name for that argument."""
    arguments = place.scope.functions.get(_callee(place.parent))
    given = zip(place.parent.args, arguments) if arguments else ()
    return any(node is place.node and node.id == argument for node, argument in given)


def operators(op: ast.operator) -> Iterator[tuple[ast.operator, str]]:
    """Yield the operators that may be meant by one, and what is then wrong."""
    for line in _OPERATORS.strip().splitlines():
        one, other, kind = line.split(" ", 2)
        if one == type(op).__name__:
            yield getattr(ast, other)(), kind


def _of_operation(place):
    node = place.node
    left, op, right = node.left, node.op, node.right
    for other, kind in operators(op):
        yield 0, kind, ast.BinOp(left, other, right)
        if kind == "a sign" and _is_product(left) and _is_product(right):
            outer = ast.BinOp(left.left, ast.Mult(), right.right)
            inner = ast.BinOp(right.left, ast.Mult(), left.right)
            yield 1, "a product", ast.BinOp(outer, other, inner)
    kind = "a factor" if isinstance(op, _FACTOR) else "a term"
    kind = "a square" if isinstance(op, ast.Pow) else kind
    yield 2, kind, left
    if not isinstance(op, ast.Pow):
        yield 2, kind, right
    if isinstance(op, ast.Div):
        yield 1, "a factor", ast.BinOp(node, op, ast.Constant(2))
    if isinstance(op, ast.Sub):
        both = ast.BinOp(left, ast.Add(), right)
        yield 1, "a sign", ast.UnaryOp(ast.USub(), both)
    if not isinstance(op, ast.Add | ast.Mult | ast.MatMult):
        yield 1, "the order", ast.BinOp(right, op, left)
    yield from ((1, "a bracket", new) for new in _moved_ends(node))
    if isinstance(op, ast.MatMult):
        yield from _of_matrices(node)
    if getattr(place.parent, "left", None) is not node:
        yield from ((1, "a bracket", new) for new in _brackets(node))


def _is_product(node):
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def _of_matrices(node):
    """Yield a product of matrices in all orders, and with the inverse of the first one."""
    inverse = ast.parse("__import__('numpy').linalg.inv", mode="eval").body
    yield 2, "an inverse", ast.BinOp(ast.Call(inverse, [node.left], []), node.op, node.right)
    factors = [*_factors(node)]
    for order in permutations(factors) if len(factors) <= MOST_FACTORS else ():
        yield 2, "the order", reduce(lambda a, b: ast.BinOp(a, ast.MatMult(), b), order)


def _factors(node):
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        yield from _factors(node.left)
        yield from _factors(node.right)
    else:
        yield node


def _brackets(node: ast.BinOp) -> Iterator[ast.expr]:
    """Yield a formula with brackets around neighbours in its chain of operators: a / b * c as
    a / (b * c).
    """
    parts: list[ast.expr] = [node]
    operators: list[ast.operator] = []
    while isinstance(first := parts[0], ast.BinOp):
        parts[:1] = first.left, first.right
        operators.insert(0, first.op)
    for start, end in combinations(range(1, len(parts)), 2):
        inner = _chain(parts[start : end + 1], operators[start:end])
        around = [*parts[:start], inner, *parts[end + 1 :]]
        yield _chain(around, operators[:start] + operators[end:])


def _chain(parts, operators):
    made = parts[0]
    for op, part in zip(operators, parts[1:]):
        made = ast.BinOp(made, op, part)
    return made


def _moved_ends(node):
    """Yield a formula without the brackets around its last part, a * (b + c) as a * b + c; a sum
    with a function in it that ends later, f(a) + b as f(a + b); and a sum of squares as the square
    of the sum.
    """
    left, op, right = node.left, node.op, node.right
    powers = isinstance(left, ast.BinOp) and isinstance(right, ast.BinOp)
    if isinstance(right, ast.BinOp):
        yield ast.BinOp(ast.BinOp(left, op, right.left), right.op, right.right)
    if powers and isinstance(left.op, ast.Pow) and isinstance(right.op, ast.Pow):
        yield ast.BinOp(ast.BinOp(left.left, op, right.left), ast.Pow(), left.right)
    if isinstance(op, ast.Add | ast.Sub) and isinstance(left, ast.Call) and left.args:
        *others, last = left.args
        inner = ast.BinOp(last, op, right)
        yield ast.Call(left.func, [*others, inner], left.keywords)


def _of_number(place):
    value, around = place.node.value, place.parent
    if isinstance(around, ast.Subscript):
        yield from ((1, "an index", other) for other in _indices(place.node, place.scope))
        return
    if type(value) not in (int, float) or abs(value) > MOST_WHOLE:
        return
    listed = isinstance(around, ast.List | ast.Tuple)
    if listed:
        yield 1, "a sign", ast.UnaryOp(ast.USub(), place.node)
        if type(value) is int:
            yield 0, "a whole number", ast.Constant(float(value))
    if _callee(around) in ("range", "linspace"):
        yield 1, "steps", ast.Constant(MANY)
    yield from ((0, "a typed number", name) for name in typed(place))
    near = (value + 1, value - 1) if type(value) is int else ()
    thresholds = _THRESHOLDS if 0 < value < LARGEST_THRESHOLD else ()
    for other in dict.fromkeys((*near, *thresholds, *(() if listed else _FACTORS))):
        if other != value:
            yield 1, "a number", ast.Constant(other)


def typed(place: Place) -> list[ast.expr]:
    """Return what of the file a number may be typed for: its numbers, and halves of them, of the
    leg that the formula around speaks of.
    """
    number, found = getattr(place.node, "value", None), []
    legs = {*LEG_NUMBER.findall(ast.unparse(place.parent))}
    for name, value in place.scope.values.items():
        is_own = len(legs) != 1 or legs.issuperset(LEG_NUMBER.findall(name))
        if is_own and value == number:
            found.append(name_of(name))
        elif is_own and value / 2 == number:
            found.append(ast.BinOp(name_of(name), ast.Div(), ast.Constant(2)))
    return found


def transposed(node: ast.expr) -> ast.expr:
    """Return the transpose of a matrix."""
    return ast.Attribute(node, "T", ast.Load())


def _of_attribute(place):
    node = place.node
    if node.attr == "T":
        yield 0, "a transpose", node.value
    if (other := other_leg(node.attr)) != node.attr:
        yield 0, "a variable", ast.Attribute(node.value, other, ast.Load())
    for other in _MEANT.get(node.attr, ()):
        yield 0, "a function", ast.Attribute(node.value, other, ast.Load())
        if _is_product(node.value):
            left = ast.Call(ast.Attribute(node.value.left, "conjugate", ast.Load()), [], [])
            product = ast.BinOp(left, ast.Mult(), node.value.right)
            yield 2, "a conjugate", ast.Attribute(product, node.attr, ast.Load())


def _callee(node):
    """Return the name of the function that is called, "" where none is."""
    function = getattr(node, "func", None)
    return getattr(function, "attr", getattr(function, "id", ""))


def _of_call(place):
    node = place.node
    name = _callee(node)
    arguments, keywords = node.args, node.keywords
    if not arguments or any(isinstance(argument, ast.Starred) for argument in arguments):
        return
    if len(arguments) == 1 or name in _LIMITS:
        yield from ((1, "a function", argument) for argument in arguments)
        if name.endswith("inv"):
            yield 2, "an inverse", arguments[0]
            yield 2, "an inverse", transposed(arguments[0])
    named = {ast.unparse(argument): argument for argument in arguments}
    wanted = place.scope.functions.get(name, [])
    if wanted:
        yield from ((2, "a variable", name_of(other)) for other in place.scope.stored)
        for other, given in place.scope.functions.items():
            if other != name and len(given) == len(wanted):
                yield 1, "a function", ast.Call(name_of(other), arguments, keywords)
    if {*wanted} == {*named} and wanted != [*named]:
        yield 0, "the order", ast.Call(node.func, [named[one] for one in wanted], keywords)
    elif len(arguments) <= MOST_ARGUMENTS:
        for order in [*permutations(arguments)][1:]:
            yield 1, "the order", ast.Call(node.func, [*order], keywords)
    else:
        for order in exchanges(arguments):
            yield 2, "the order", ast.Call(node.func, order, keywords)
    quotient = arguments[0]
    if (
        name in ("atan", "arctan")
        and isinstance(quotient, ast.BinOp)
        and isinstance(quotient.op, ast.Div)
    ):
        both = [quotient.left, quotient.right]
        function = ast.parse("__import__('math').atan2", mode="eval").body
        yield 1, "a function", ast.Call(function, both, [])


def exchanges(parts: list) -> Iterator[list]:
    """Yield a list with any two of its parts in each other's place."""
    for k, m in combinations(range(len(parts)), 2):
        order = [*parts]
        order[k], order[m] = order[m], order[k]
        yield order


def _of_list(place):
    """Yield a list in other orders, and a vector turned by +-90 and by 180 degrees."""
    parts, kind = place.node.elts, type(place.node)
    for order in exchanges(parts):
        yield 1, "the order", kind(order, ast.Load())
    if len(parts) == 2 and not any(isinstance(part, ast.Tuple | ast.List) for part in parts):
        x, y = parts
        turns = [[_negative(x), _negative(y)], [_negative(y), x], [y, _negative(x)]]
        for turned in turns[isinstance(x, ast.Name) :]:  # a pair of matrices has no direction
            yield 2, "a direction", kind(turned, ast.Load())


def _negative(node):
    is_negative = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
    return node.operand if is_negative else ast.UnaryOp(ast.USub(), node)


def _of_subscript(place):
    node = place.node
    index = node.slice
    if isinstance(index, ast.Slice):
        yield 1, "the order", node.value
    elif isinstance(index, ast.Tuple) and len(index.elts) == 2:
        yield 1, "an index", _part(node, ast.Tuple(index.elts[::-1], ast.Load()))
        for k, one in enumerate(index.elts):
            for other in _indices(one, place.scope):
                both = [*index.elts]
                both[k] = other
                yield 1, "an index", _part(node, ast.Tuple(both, ast.Load()))
    else:
        yield from ((0, "an index", _part(node, other)) for other in _indices(index, place.scope))


def _part(node, index):
    return ast.Subscript(node.value, index, ast.Load())


def _indices(node, scope):
    """Yield other indices, by number or by a letter."""
    value = getattr(node, "value", None)
    if type(value) is int:
        yield from (ast.Constant(k) for k in range(3) if k != value)
        yield from (name_of(name) for name in sorted(scope.names) if len(name) == 1)


_OF = {
    ast.BinOp: _of_operation,
    ast.UnaryOp: lambda place: [(0, "a sign", place.node.operand)],
    ast.Compare: _of_condition,
    ast.BoolOp: _of_condition,
    ast.Name: _of_name,
    ast.Attribute: _of_attribute,
    ast.Constant: _of_number,
    ast.Call: _of_call,
    ast.Subscript: _of_subscript,
    ast.Tuple: _of_list,
    ast.List: _of_list,
}
