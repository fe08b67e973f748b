"""What several tests share; no file here holds a test."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA, LABS = ROOT / "tests" / "data", ROOT / "labs"


def functions_with(does):
    """module:function of every function of the package of which a node of the syntax `does` what is asked."""
    found = set()
    for path in (ROOT / "fivebar").rglob("*.py"):
        if "_labs" in path.parts:
            continue
        module = ".".join(path.relative_to(ROOT / "fivebar").with_suffix("").parts)
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef) and any(map(does, ast.walk(node))):
                found.add(f"{module}:{node.name}")
    return found
