"""What has been forgotten in a formula: a sign, a factor, a term, an inverse; or any other name;
standard library only.
"""

from __future__ import annotations

import ast
import re

from alternatives import (
    LINEAR_ALGEBRA,
    Alternatives,
    Place,
    inverse_of,
    is_text,
    name_of,
    transposed,
)

_VALUES = ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute | ast.Constant
_TURNED = ("sin", "cos", "tan", "atan2", "arctan2")


def _length_of(node):
    return ast.Call(ast.parse(f"{LINEAR_ALGEBRA}norm", mode="eval").body, [node], [])


def additions(place: Place) -> Alternatives:
    """Yield what may stand there where something has been forgotten, or where any other name should
    stand.
    """
    node = place.node
    if isinstance(node, ast.Name):
        yield from _other_names(place)
    index = isinstance(place.parent, ast.Subscript) and node is place.parent.slice
    called = isinstance(place.parent, ast.Call) and node is place.parent.func
    if isinstance(node, _VALUES) and not index and not called and not is_text(node):
        given = isinstance(node, ast.Name) and node.id in place.scope.arguments
        for rank, kind, new in (*_added(place), *_added_terms(place)):
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
    """Yield what has been forgotten: a sign, a square, a root, a factor, an inverse."""
    node, parent, scope = place.node, place.parent, place.scope

    def with_(op, right):
        return ast.BinOp(node, op, right)

    whole = isinstance(parent, ast.Return | ast.Assign | ast.Tuple | ast.List | ast.Lambda)
    if not isinstance(node, ast.Constant):
        yield 3, "a square", with_(ast.Pow(), ast.Constant(2))
        if place.term or isinstance(node, ast.Call):
            yield 3, "a root", with_(ast.Pow(), ast.Constant(0.5))
        yield 5, "a factor", with_(ast.Div(), _length_of(node))
        if scope.complex_numbers:
            conjugate = ast.parse(f"__import__('numpy').conj({ast.unparse(node)})", mode="eval")
            yield 4, "a conjugate", conjugate.body
            yield 4, "a direction", with_(ast.Mult(), ast.Constant(1j))
            yield 4, "a direction", with_(ast.Mult(), ast.UnaryOp(ast.USub(), ast.Constant(1j)))
    matrices = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.MatMult)
    if not isinstance(node, ast.Constant) and (
        matrices or whole or isinstance(parent, ast.Call | ast.Attribute)
    ):
        yield 3, "a transpose", transposed(node)
        yield 3, "an inverse", inverse_of(node)
    if not place.term:
        return
    yield 4, "a factor", with_(ast.Div(), ast.Constant(2))
    yield 4, "a factor", with_(ast.Mult(), ast.Constant(2))
    called = getattr(parent, "func", None)
    if whole or getattr(called, "attr", getattr(called, "id", "")) in _TURNED:
        for op in (ast.Mult(), ast.Div()):
            yield 5, "degrees", with_(op, ast.Constant(57.29577951308232))
    for name in scope.values:
        rank = 4 if name in scope.constants or re.match("assembly|gamma|branch", name) else 5
        yield rank, "a factor", with_(ast.Mult(), name_of(name))
        yield rank, "a factor", with_(ast.Div(), name_of(name))


def _added_terms(place):
    """Yield a sum with one term more: a number, or a name."""
    node, parent, scope = place.node, place.parent, place.scope
    inside = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.Add | ast.Sub)
    last = not inside or node is parent.right
    more: list = []
    if place.term:
        more += [(5, ast.Constant(1))]
    if isinstance(node, ast.Name):
        alike = [name for name in scope.values if _kind(name) == _kind(node.id)]
        more += [(3, name_of(name)) for name in alike if name != node.id]
    elif place.term and last and not isinstance(node, ast.Constant):
        more += [(5, name_of(name)) for name in scope.constants]
    for rank, term in more:
        yield rank, "a term", ast.BinOp(node, ast.Add(), term)
        yield rank, "a term", ast.BinOp(node, ast.Sub(), term)


def _kind(name):
    """Return what names of one kind have alike: q11 and q22 are angles, qaD and qpD are rates."""
    return name[0], len(name), _order(name)
