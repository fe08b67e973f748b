"""What several tests share; no file here holds a test."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA, LABS = ROOT / "tests" / "data", ROOT / "labs"


def functions_with(does):
    """module:function of every function of the package of which a call `does` what is asked."""
    return {name for name, nodes in _functions() if any(map(does, nodes))}


@cache
def _functions():
    """(module:function, its calls) of every function of the package."""
    found = []
    for path in (ROOT / "fivebar").rglob("*.py"):
        if "_labs" in path.parts:
            continue
        module = ".".join(path.relative_to(ROOT / "fivebar").with_suffix("").parts)
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.FunctionDef):
                calls = [each for each in ast.walk(node) if isinstance(each, ast.Call)]
                found.append((f"{module}:{node.name}", calls))
    return found
