"""After a script's own traceback: what an error of today's NumPy means in an older file."""

import ast
import linecache
import re

import numpy as np

from ...base.old_numpy import CONVERSION, DROPPED, is_single

LENIENT = "(or run with --lenient, which takes what an older NumPy took)"


def explanation(error, frame, line):
    """Return lines that explain `error`, raised at this line of the user's frame, or none."""
    if isinstance(error, AttributeError):
        name = re.match(r"(?:module 'numpy' has no attribute '|`np\.)(\w+)", str(error))
        return _dropped(name[1]) if name and name[1] in DROPPED else []
    if not isinstance(error, (TypeError, ValueError)):
        return []
    texts = str(error), str(error.__cause__)
    if not any(CONVERSION in text or "inhomogeneous" in text for text in texts):
        return []
    what, mend = "what is computed here is an array", "an index or .item() after it"
    arrays = dict(_arrays(_statement(frame, line), frame))
    single = {text: array for text, array in arrays.items() if is_single(array)}
    if single:
        what = " and ".join(f"{text} is an array of shape {single[text].shape}" for text in single)
        mend = " and ".join(f"{text}.item()" for text in single)
    return [
        f"{what}, and NumPy {np.__version__} no longer takes one for a number.",
        f"mend: write {mend} {LENIENT}",
    ]


def _dropped(name):
    today = {"asscalar": "x.item()"}.get(name, DROPPED[name])
    return [
        f"NumPy {np.__version__} has no np.{name} any more; it was another name of {today}.",
        f"mend: write {today} {LENIENT}",
    ]


def _statement(frame, line):
    """Return the smallest statement of the frame's source that holds the line."""
    source = "".join(linecache.getlines(frame.f_code.co_filename))
    holding = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno:
            holding.append(node)
    return max(holding, key=lambda node: (node.lineno, -node.end_lineno))


def _arrays(statement, frame):
    """Yield (source text, value) of the arrays that the statement reads by a name and indices, but
    for those of which it takes the item.
    """
    mended: set = set()
    for node in ast.walk(statement):
        if isinstance(node, ast.Attribute) and node.attr == "item":
            mended |= {id(part) for part in ast.walk(node)}
        if id(node) not in mended and isinstance(getattr(node, "ctx", None), ast.Load):
            text = ast.unparse(node)
            if re.search(r"[(:]", text):  # nothing is called again, and no slice is an element
                continue
            try:
                value = eval(text, frame.f_globals, dict(frame.f_locals))
            except Exception:  # noqa: S112  a name of another scope: nothing to say of it
                continue
            if isinstance(value, np.ndarray) and value.ndim:
                yield text, value
