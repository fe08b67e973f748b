"""After a script's own traceback: what an error of today's NumPy means in a file written for an
older one.
"""

import ast
import linecache
import re

import numpy as np

from ...base.old_numpy import CONVERSION, CONVERTING, DROPPED, is_single
from .tracebacks import is_users

CONVERSIONS = {"array", "asarray", "print", *(function.__name__ for function in CONVERTING)}


def explanation(error, frame, line):
    """Lines that explain `error`, raised at this line of the user's frame; none where there is
    nothing to add.
    """
    if isinstance(error, AttributeError):
        name = re.match(
            r"module 'numpy' has no attribute '(\w+)'|`np\.(\w+)` was removed", str(error)
        )
        return _dropped(name[1] or name[2]) if name and (name[1] or name[2]) in DROPPED else []
    if not isinstance(error, (TypeError, ValueError)):
        return []
    conversion = CONVERSION in str(error) or CONVERSION in str(error.__cause__)
    if conversion or (isinstance(error, ValueError) and "inhomogeneous" in str(error)):
        return _conversion(frame, line)
    return []


def _dropped(name):
    today = {"asscalar": "x.item()"}.get(name, DROPPED[name])
    return [
        f"NumPy {np.__version__} has no np.{name} any more; it was another name of {today}.",
        f"mend: write {today} (or run with --lenient, which knows the old names)",
    ]


def _conversion(frame, line):
    statement = _statement(frame, line)
    if returned := _returned(statement, frame):
        return returned
    arrays = dict(_arrays(statement, frame))
    for text, array in reversed(arrays.items()):
        if is_single(array):
            return _refused(f"{text} is an array of shape {array.shape}", f"{text}.item()")
        if _unpacks(statement) and array.size == len(array):
            return _refused(
                f"the rows of {text} are arrays of shape {array.shape[1:]}", f"{text}.ravel()"
            )
    if arrays and not _computes(statement):
        found = ", ".join(f"{text} of shape {array.shape}" for text, array in arrays.items())
        return [f"a number is wanted where there is an array: {found}."]
    return _refused("what is computed here is an array, often of one element", ".item() after it")


def _returned(statement, frame):
    """Where a function's results are put into numbers: the line in which it returns arrays of one
    element.
    """
    if not isinstance(statement, ast.Assign) or not isinstance(statement.value, ast.Call):
        return []
    function = frame.f_globals.get(ast.unparse(statement.value.func))
    code = getattr(function, "__code__", None)
    if code is None or not is_users(code.co_filename):
        return []
    for node in ast.walk(ast.parse("".join(linecache.getlines(code.co_filename)))):
        if (
            isinstance(node, ast.FunctionDef)
            and node.name == code.co_name
            and node.lineno == code.co_firstlineno
        ):
            given = [
                inner.value
                for inner in ast.walk(node)
                if isinstance(inner, ast.Return) and inner.value is not None
            ]
            parts = [
                part
                for value in given
                for part in (value.elts if isinstance(value, ast.Tuple) else [value])
            ]
            if parts:
                text = ast.unparse(parts[0])
                mend = (
                    f"{text}.item()"
                    if isinstance(parts[0], (ast.Name, ast.Subscript))
                    else f"({text}).item()"
                )
                where = f"what {node.name} returns in line {parts[0].lineno}, {text}, is an array"
                return _refused(where, f"{mend} there")
    return []


def _refused(what, mend):
    return [
        f"{what}, and NumPy {np.__version__} no longer takes one for a number.",
        f"mend: write {mend} (or run with --lenient, which lets arrays of one element through)",
    ]


def _unpacks(statement):
    return isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Tuple)


def _computes(statement):
    """Whether what is converted is not just named: other calls than the conversions themselves, or
    sums.
    """
    for node in ast.walk(statement):
        if isinstance(node, ast.BinOp) and not isinstance(node.op, ast.Mod):
            return True
        if (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).rpartition(".")[2] not in CONVERSIONS
        ):
            return True
    return False


def _statement(frame, line):
    """The smallest statement of the frame's source that holds the line, or None."""
    source = "".join(linecache.getlines(frame.f_code.co_filename, frame.f_globals))
    holding = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno
    ]
    return max(holding, key=lambda node: (node.lineno, -node.end_lineno), default=None)


def _arrays(statement, frame):
    """(source text, value) of every array that the statement reads by a name, with or without
    indices.
    """
    if statement is None or hasattr(statement, "body"):
        return
    for node in ast.walk(
        statement.value if isinstance(statement, (ast.Assign, ast.AugAssign)) else statement
    ):
        if isinstance(node, (ast.Name, ast.Subscript, ast.Attribute)) and isinstance(
            node.ctx, ast.Load
        ):
            text = ast.unparse(node)
            if re.search(r"[(:]", text):  # nothing is called again, and no slice is an element
                continue
            try:
                value = eval(text, frame.f_globals, dict(frame.f_locals))
            except Exception:  # noqa: S112  a name of another scope: nothing to say of it
                continue
            if isinstance(value, np.ndarray) and value.ndim:
                yield text, value
