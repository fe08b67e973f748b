"""What has been forgotten in a formula: a square, a factor, an inverse, a term of the same kind; or
any other name of the same derivative; standard library only.

What else is forgotten is found from the values that formulas need.
"""

from __future__ import annotations

import ast
import re

from alternatives import Alternatives, Place, inverse_of, name_of, transposed

_VALUES = ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute


def additions(place: Place) -> Alternatives:
    """Yield what may stand there where something has been forgotten, or where any other name should
    stand.
    """
    node = place.node
    if isinstance(node, ast.Name):
        yield from _other_names(place)
    index = isinstance(place.parent, ast.Subscript) and node is place.parent.slice
    called = isinstance(place.parent, ast.Call) and node is place.parent.func
    if isinstance(node, _VALUES) and not index and not called:
        given = isinstance(node, ast.Name) and node.id in place.scope.arguments
        for rank, kind, new in _added(place):
            yield rank + given, kind, new  # an argument itself is seldom what is wrong


def _other_names(place):
    known = {*place.scope.like(place.node.id), place.node.id}
    derivative = _order(place.node.id)
    for other in place.scope.values:
        if other not in known and derivative and _order(other) == derivative:
            yield 3, "a variable", name_of(other)


def _order(name):
    """Return which derivative a name is by its last letters: 0 of q11, 1 of q11D, 2 of q11DD."""
    return len(name) - len(name.rstrip("D"))


def _added(place):
    """Yield what has been forgotten."""
    node, parent, scope = place.node, place.parent, place.scope

    def with_(op, right):
        return ast.BinOp(node, op, right)

    yield 3, "a square", with_(ast.Pow(), ast.Constant(2))
    if place.term or isinstance(node, ast.Call):
        yield 3, "a root", with_(ast.Pow(), ast.Constant(0.5))
    if scope.complex_numbers:
        conjugate = ast.parse(f"__import__('numpy').conj({ast.unparse(node)})", mode="eval")
        yield 3, "a conjugate", conjugate.body
        yield 4, "a direction", with_(ast.Mult(), ast.Constant(1j))
        yield 4, "a direction", with_(ast.Mult(), ast.UnaryOp(ast.USub(), ast.Constant(1j)))
    matrices = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.MatMult)
    whole = isinstance(parent, ast.Return | ast.Assign | ast.Tuple | ast.List | ast.Lambda)
    if matrices or whole or isinstance(parent, ast.Call | ast.Attribute):
        yield 3, "a transpose", transposed(node)
        yield 3, "an inverse", inverse_of(node)
    for name in _matrices(scope) if matrices else ():
        yield 4, "a matrix product", ast.BinOp(name_of(name), ast.MatMult(), node)
        yield 4, "a matrix product", with_(ast.MatMult(), name_of(name))
    if not place.term:
        return
    yield 4, "a factor", with_(ast.Div(), ast.Constant(2))
    yield 4, "a factor", with_(ast.Mult(), ast.Constant(2))
    for name in scope.values:
        if name in scope.constants or re.match("assembly|gamma|branch", name):
            yield 4, "a factor", with_(ast.Mult(), name_of(name))
            yield 4, "a factor", with_(ast.Div(), name_of(name))
        elif isinstance(node, ast.Name) and name != node.id and _kind(name) == _kind(node.id):
            yield 3, "a term", with_(ast.Add(), name_of(name))
            yield 3, "a term", with_(ast.Sub(), name_of(name))


def _matrices(scope):
    """Return the names of the matrices of which a function makes products."""
    products = [
        part
        for part in ast.walk(scope.function)
        if isinstance(part, ast.BinOp) and isinstance(part.op, ast.MatMult)
    ]
    factors = [factor for part in products for factor in (part.left, part.right)]
    return sorted({factor.id for factor in factors if isinstance(factor, ast.Name)})


def _kind(name):
    """Return what names of one kind have alike: q11 and q22 are angles, qaD and qpD are rates."""
    return name[0], len(name), _order(name)
