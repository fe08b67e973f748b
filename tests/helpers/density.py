"""Count the syntax nodes of each room of the package: `python -m tests.helpers.density --base main`.

A figure that a change reports, not a test: each Python's `ast` counts another number.
"""

import argparse
import ast
import subprocess
from collections import Counter

from . import ROOT

CONTEXTS = ast.Load, ast.Store, ast.Del
DOCUMENTED = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef


def nodes(source: str) -> int:
    """Return the number of syntax nodes of a file; docstrings are none."""
    tree = list(ast.walk(ast.parse(source)))
    documented = [node for node in tree if isinstance(node, DOCUMENTED)]
    docstrings = sum(ast.get_docstring(node, clean=False) is not None for node in documented)
    # A docstring is an expression and its constant.
    return sum(not isinstance(node, CONTEXTS) for node in tree) - 2 * docstrings


def git(*words: str) -> str:
    return subprocess.check_output(["git", *words], cwd=ROOT, text=True, encoding="utf-8")


def rooms(revision: str | None = None) -> Counter:
    """Return the nodes of each room, of the working tree or of a revision of git; the files of the
    package's own folder are the room "(top)".
    """
    listed = git("ls-tree", "-r", "--name-only", revision) if revision else git("ls-files")
    counts = Counter()
    for name in listed.splitlines():
        top, *inner = name.split("/")
        if top != "fivebar" or not name.endswith(".py") or not (revision or (ROOT / name).exists()):
            continue
        source = git("show", f"{revision}:{name}") if revision else (ROOT / name).read_text("utf-8")
        counts[inner[0] if len(inner) > 1 else "(top)"] += nodes(source)
    return counts


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", metavar="REV", help="a revision to compare with")
    base = parser.parse_args().base
    now = rooms()
    before = rooms(base) if base else Counter()
    for name, count in [*now.most_common(), ("sum", now.total())]:
        compared = before.total() if name == "sum" else before[name]
        print(f"{name:16}{count:8}" + f"{compared:8}{count - compared:+8}" * bool(base))
