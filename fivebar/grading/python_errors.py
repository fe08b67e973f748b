"""Python's and NumPy's messages in one sentence more: what such an error usually means in a file of
this kind.
"""

from __future__ import annotations

import ast
import difflib
import re
from collections.abc import Callable, Iterable

import numpy as np

from ..base.old_numpy import CONVERTING, DROPPED, refused

_NUMBERS = {function.__name__ for function in CONVERTING}


def explained(text: str, line: str = "", words: Iterable[str] = ()) -> str:
    """A sentence on an exception's "Type: message", raised at this line of a file with these words,
    or "".
    """
    if line.strip().startswith("raise ") and not text.startswith("NotImplementedError"):
        return (
            "Your own line refuses, though there is an answer here: compare its condition with the"
            " statement's."
        )
    for pattern, sentence in _SENTENCES:
        if found := re.match(pattern, text, re.DOTALL):
            notes = (
                sentence(found, line, words)
                if callable(sentence)
                else sentence.format(*found.groups())
            )
            if notes:
                return notes
    return ""


def mend(line: str) -> str:
    """How a line is written that took an array of one element for a number: "write v[1].item()"."""
    try:
        tree = ast.parse(line.strip().rstrip(":"))
    except SyntaxError:
        return "write .item() after what has one element"
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in _NUMBERS:
            for part in ast.walk(ast.Tuple(node.args)):
                if isinstance(part, ast.Subscript):
                    return f"write {ast.unparse(part)}.item()"
            if node.args and isinstance(node.args[0], ast.Name):
                return f"write {node.args[0].id}.item() where {node.args[0].id} is an array"
    return "write .item() after what has one element"


def _refused(found, line, words):
    """What only today's NumPy refuses."""
    if not refused(found[0]):
        return ""
    if name := next(
        (name for name in DROPPED if f"'{name}'" in found[0] or f"np.{name}`" in found[0]), ""
    ):
        today = {"asscalar": "x.item()"}.get(name, DROPPED[name])
        return f"NumPy {np.__version__} has no np.{name} any more: write {today}."
    return (
        f"NumPy {np.__version__} no longer takes an array of one element for a number:"
        f" {mend(line)}."
    )


def _unknown(found, line, words):
    name = found[1]
    alike = difflib.get_close_matches(name, sorted({word for word in words} - {name}), 1, 0.7)
    same = [word for word in words if word.lower() == name.lower() and word != name]
    words = list(words)
    imports = [
        k
        for k, word in enumerate(words)
        if word == name and words[max(k - 1, 0)] in ("import", "as")
    ]
    if imports or name in ("np", "numpy", "plt"):
        return f"The file uses {name} without an import that works."
    if same or alike:
        return f"Nothing has that name where it is used. Is {(same or alike)[0]} meant?"
    return (
        "Nothing has that name where it is used: is it misspelt, or made in another function only?"
    )


def _hidden(found, line, words):
    return (
        f"{found[1]} gets a value further down in the same function, so that it belongs to this"
        " function everywhere in it and has no value yet here: give what is assigned another name."
    )


def _called(found, line, words):
    if found[1] in (
        "float",
        "int",
        "numpy.float64",
        "numpy.ndarray",
        "ndarray",
        "tuple",
        "list",
        "complex",
    ):
        return (
            "Something with parentheses after it is a number or an array, not a function: is a *"
            " missing, or has a variable taken a function's name (or square brackets been meant)?"
        )
    return "Parentheses stand after something that is no function."


def _operands(found, line, words):
    types = found[1]
    if "function" in types or "method" in types or "ufunc" in types:
        return "A function stands where its value is meant: are its parentheses missing?"
    if "NoneType" in types:
        return (
            "One of the two is None: a function called here returns nothing. Is its return missing?"
        )
    if "list" in types or "tuple" in types:
        return "Lists and tuples do not calculate: make them arrays, np.array(...)."
    if "str" in types:
        return "One of the two is text, not a number."
    return ""


_SENTENCES: tuple[tuple[str, str | Callable], ...] = (
    (r".*", _refused),
    (r"NameError: name '(\w+)' is not defined", _unknown),
    (r"UnboundLocalError: cannot access local variable '(\w+)'", _hidden),
    (r"UnboundLocalError: local variable '(\w+)' referenced", _hidden),
    (r"TypeError: '([\w.]+)' object is not callable", _called),
    (
        r"TypeError: unsupported operand type\(s\) for \^|TypeError: ufunc 'bitwise_xor'",
        "A power is written ** in Python: ^ is something else.",
    ),
    (r"TypeError: unsupported operand type\(s\) for [^:]+: (.*)", _operands),
    (r"TypeError: bad operand type for", "A function or a list stands where a number is meant."),
    (
        r"TypeError: can't multiply sequence by non-int",
        "A list times a number repeats the list: make it an array, np.array(...).",
    ),
    (
        r"TypeError: can only concatenate",
        "+ joins lists and texts: make them arrays, np.array(...).",
    ),
    (
        r"TypeError: cannot unpack non-iterable NoneType",
        "What is called here returned None: in some case it comes to its end without a return.",
    ),
    (
        r"TypeError: cannot unpack non-iterable (\w+)",
        "What is called here returns one thing ({0}), and more names wait for values.",
    ),
    (
        r"ValueError: (too many values|not enough values) to unpack",
        "What is called here returns another number of values than names wait.",
    ),
    (
        r"TypeError: 'NoneType' object",
        "A function called here returns nothing: is its return missing?",
    ),
    (
        (
            r"TypeError: '(float|int|numpy\.float64|float64)' object (is not subscriptable|does not"
            r" support item)"
        ),
        "This is a number already: it has no [0].",
    ),
    (r"IndexError: invalid index to scalar variable", "This is a number already: it has no [0]."),
    (
        r"IndexError: too many indices for array",
        "The array has fewer dimensions than indices: print its .shape.",
    ),
    (
        r"IndexError: index (-?\d+) is out of bounds for axis \d+ with size (\d+)",
        (
            "The array has {1} here, counted from 0: print its .shape. Is it a row where a column"
            " was expected?"
        ),
    ),
    (
        r"TypeError: (list|tuple) indices must be integers or slices, not tuple",
        (
            "A {0} takes one index, [i][j] in place of [i, j]: or make it an array first,"
            " np.array(...)."
        ),
    ),
    (
        (
            r"RuntimeError: can't start new thread|(BlockingIOError|PermissionError):"
            r" .*(fork|Operation not permitted)"
        ),
        "No thread and no other program can be started here: call the function itself.",
    ),
    (
        r"FileNotFoundError|PermissionError",
        "No file can be read here: type in the numbers that the function needs.",
    ),
    (r"timeout", "Does a loop never end, or is far more computed than one call needs?"),
    (
        r"IndexError: (list|tuple) index out of range",
        "Counting begins at 0: the last of n has the index n - 1.",
    ),
    (
        r"TypeError: '([\w.]+)' object is not subscriptable",
        "Square brackets stand after a function or a number: are parentheses meant?",
    ),
    (
        r"TypeError: .*\(\) missing (\d+) required positional",
        "It is called with fewer arguments than its definition has.",
    ),
    (
        r"TypeError: .*\(\) takes (\d+) positional",
        "It is called with more arguments than its definition has.",
    ),
    (
        r"TypeError: array\(\) takes from",
        "The rows of np.array stand in one list more: np.array([[a, b], [c, d]]).",
    ),
    (
        r"TypeError: .*(must be real number|a float is required)",
        "math calculates with numbers only: with arrays take NumPy's function.",
    ),
    (
        r"TypeError: only (length-1|integer scalar) arrays",
        "An array stands where a number is wanted: math's functions take no arrays, NumPy's do.",
    ),
    (
        r"TypeError: loop of ufunc does not support",
        (
            "The array holds something that is no number (an array in an array, or a function):"
            " print it."
        ),
    ),
    (
        r"ValueError: matmul: .*|ValueError: shapes .* not aligned.*",
        (
            "The inner sizes of a matrix product must agree: print both .shape. Is one of the"
            " vectors a row where a column is meant?"
        ),
    ),
    (
        r"ValueError: operands could not be broadcast",
        "The shapes of the two do not go together: print both .shape.",
    ),
    (
        r"(numpy\.linalg\.)?LinAlgError: Singular matrix",
        (
            "The matrix that you invert is singular at these arguments, though the robot is not:"
            " look at its rows."
        ),
    ),
    (
        r"(numpy\.linalg\.)?LinAlgError: .*(square|dimensional)",
        "What you invert is no matrix of n x n numbers: print its .shape.",
    ),
    (
        r"ValueError: (math domain error|expected a nonnegative input)",
        (
            "A square root of a negative number, or acos of more than 1, where there is a pose:"
            " which length under the root is wrong?"
        ),
    ),
    (
        r"ZeroDivisionError",
        "A division by 0 at regular arguments: which length or sine is 0, and should it be?",
    ),
    (
        r"AttributeError: module 'math' has no attribute '(\w+)'",
        "math has no {0}: is NumPy's np.{0} meant?",
    ),
    (
        r"AttributeError: module 'numpy' has no attribute '(\w+)'",
        "NumPy has no {0}: is it misspelt?",
    ),
    (
        (
            r"AttributeError: '(float|int|list|tuple)' object has no attribute"
            r" '(T|dot|shape|I|ravel|item)'"
        ),
        "A {0} has no .{1}: make it an array, np.array(...).",
    ),
    (
        r"AttributeError: 'numpy.ndarray' object has no attribute 'I'",
        "Only np.matrix has .I: write np.linalg.inv(...).",
    ),
    (r"EOFError", "Nobody answers an input() here: what a function needs comes as its arguments."),
    (
        r"TabError",
        "This line begins with other blanks than its neighbours: tabs here and spaces there.",
    ),
    (r"RecursionError", "The function calls itself without end: is another one meant?"),
    (r"AssertionError", "An assert of your own file fails."),
)
