"""What has been forgotten in a formula: a mode, an inverse, a transpose; standard library only.

What else is forgotten is found from the values that formulas need.
"""

from __future__ import annotations

import ast
import re

from alternatives import Alternatives, Place, name_of, transposed

_VALUES = ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute


def additions(place: Place) -> Alternatives:
    """Yield what may stand there where something has been forgotten."""
    node = place.node
    index = isinstance(place.parent, ast.Subscript) and node is place.parent.slice
    called = isinstance(place.parent, ast.Call) and node is place.parent.func
    if isinstance(node, _VALUES) and not index and not called:
        given = isinstance(node, ast.Name) and node.id in place.scope.arguments
        for rank, kind, new in _added(place):
            yield rank + given, kind, new  # an argument itself is seldom what is wrong


def _added(place):
    """Yield what has been forgotten."""
    node, parent, scope = place.node, place.parent, place.scope
    matrices = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.MatMult)
    whole = isinstance(parent, ast.Return | ast.Assign | ast.Tuple | ast.List | ast.Lambda)
    if matrices or whole or isinstance(parent, ast.Call | ast.Attribute):
        yield 3, "a transpose", transposed(node)
        # In code that needs no import.
        inverse = ast.parse("__import__('numpy').linalg.inv", mode="eval").body
        yield 3, "an inverse", ast.Call(inverse, [node], [])
    # Rows of one mode alone are wrong without it, and do not tell a mode from a sign.
    for name in scope.arguments if place.term else ():
        if re.match("assembly|gamma|branch", name):
            yield 4, "a factor", ast.BinOp(node, ast.Mult(), name_of(name))
