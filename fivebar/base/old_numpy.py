"""What NumPy took of files written years ago, and takes no more: an array of one element for a
number, dropped names.

An array's own conversion cannot be replaced, so the source is rewritten where a conversion can take
place: in assignments to elements, in calls of float, int, np.array and the functions of math, and
    in "..." % x. Python's own
library only: a confined process gets this file as text.
"""

import ast
import builtins
import math
import sys
from functools import cache

HELPER, LOOSEN = "__fivebar_lenient__", "__fivebar_loosen__"
# Names that NumPy has dropped, and what to write today.
DROPPED = {
    "float": "float",
    "int": "int",
    "object": "object",
    "str": "str",
    "complex": "complex",
    "float_": "np.float64",
    "complex_": "np.complex128",
    "Inf": "np.inf",
    "Infinity": "np.inf",
    "infty": "np.inf",
    "NaN": "np.nan",
    "product": "np.prod",
    "cumproduct": "np.cumprod",
    "alltrue": "np.all",
    "sometrue": "np.any",
    "round_": "np.round",
    "asscalar": "np.ndarray.item",
    "mat": "np.asmatrix",
    "trapz": "np.trapezoid",
    "in1d": "np.isin",
}
CONVERTING = {float, int, complex, round, *(f for f in vars(math).values() if callable(f))}
CONVERSION = "only 0-dimensional arrays can be converted to Python scalars"


def refused(message):
    """Return whether an error's message is about what NumPy once took."""
    dropped = any(
        f"'numpy' has no attribute '{name}'" in message or f"np.{name}`" in message
        for name in DROPPED
    )
    return (
        CONVERSION in message
        or "inhomogeneous" in message
        or "setting an array element" in message
        or dropped
    )


def give_names_back(np):
    for name, today in DROPPED.items():
        if name not in vars(np):
            setattr(np, name, eval(today, {"np": np}))


def install():
    """The names that rewritten code calls."""
    setattr(builtins, HELPER, lenient)
    setattr(builtins, LOOSEN, loosen)


def is_single(value):
    """Return whether this is an array of one element, but not a number."""
    np = sys.modules.get("numpy")
    return np is not None and isinstance(value, np.ndarray) and value.size == 1 and value.ndim > 0


def loosen(value):
    """Return the number in an array of one element, also within lists, or the value itself."""
    if is_single(value):
        return value.item()
    return type(value)(map(loosen, value)) if type(value) in (list, tuple) else value


def lenient(thing):
    """Return what is called, or written into, or printed with %, in its lenient form."""
    np = sys.modules.get("numpy")
    if np is not None:
        if isinstance(thing, np.ndarray):
            return Elements(thing)
        if thing is np.array or thing is np.asarray:
            return _array(thing)
    try:
        converts = thing in CONVERTING
    except TypeError:  # not hashable
        return thing
    return _converting(thing) if converts else thing


@cache
def _converting(function):
    return lambda *args, **options: function(*map(loosen, args), **options)


@cache
def _array(function):
    def make(values, *args, **options):
        try:
            return function(values, *args, **options)
        except ValueError as error:
            if "inhomogeneous" not in str(error):
                raise
            return function(loosen(values), *args, **options)

    return make


class Elements:
    """An array as the target of an assignment."""

    def __init__(self, array):
        self.array = array

    def __getitem__(self, key):
        return self.array[key]

    def __setitem__(self, key, value):
        try:
            self.array[key] = value
        except (TypeError, ValueError):
            if not is_single(value):
                raise
            self.array[key] = value.item()


class Rewriter(ast.NodeTransformer):
    def visit_Subscript(self, node):
        self.generic_visit(node)
        if isinstance(node.ctx, ast.Store):
            node.value = self._helped(node.value)
        return node

    def visit_Call(self, node):
        self.generic_visit(node)
        if isinstance(node.func, (ast.Name, ast.Attribute)):
            node.func = self._helped(node.func)
        return node

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if (
            isinstance(node.op, ast.Mod)
            and isinstance(node.left, ast.Constant)
            and isinstance(node.left.value, str)
        ):
            node.right = self._helped(node.right, LOOSEN)
        return node

    def _helped(self, node, helper=HELPER):
        return ast.copy_location(ast.Call(ast.Name(helper, ast.Load()), [node], []), node)


def rewritten(tree):
    """Return the syntax tree of a source, rewritten."""
    return ast.fix_missing_locations(Rewriter().visit(tree))


def compiled(source, path):
    """Return the code of a module's source, rewritten."""
    return compile(rewritten(ast.parse(source, path)), path, "exec")
