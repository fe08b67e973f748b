"""Count the syntax nodes of each room of the package: `python -m tests.helpers.density`."""

import ast
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from . import ROOT

COLUMNS = 100
COMPREHENSIONS = ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp
CONTEXTS = ast.Load, ast.Store, ast.Del
DOCUMENTED = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef
TEXTS = ast.Constant, ast.JoinedStr


@dataclass
class Density:
    """Counts of one room: files, lines of code, syntax nodes, and what a reader stumbles over."""

    files: int = 0
    lines: int = 0
    nodes: int = 0
    long_lines: int = 0
    nested: int = 0
    unformatted: int = 0

    @property
    def nodes_a_line(self) -> float:
        return self.nodes / max(self.lines, 1)

    def add(self, path: Path) -> None:
        """Count a file. Docstrings are neither lines nor nodes."""
        source = path.read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(source)))
        documented = [node for node in nodes if isinstance(node, DOCUMENTED)]
        docstrings = [
            node.body[0] for node in documented if ast.get_docstring(node, clean=False) is not None
        ]
        documentation = set()
        for docstring in docstrings:
            documentation.update(range(docstring.lineno, docstring.end_lineno + 1))
        lines = source.splitlines()
        code = set()
        for number, line in enumerate(lines, start=1):
            if line.strip() and not line.lstrip().startswith("#"):
                code.add(number)
        for node in nodes:  # empty lines of a text, and those that begin with # there, are code
            if isinstance(node, TEXTS) and '"""' in lines[node.lineno - 1]:
                code.update(range(node.lineno, node.end_lineno + 1))
        self.files += 1
        self.lines += len(code - documentation)
        self.nodes += sum(not isinstance(node, CONTEXTS) for node in nodes)
        self.nodes -= 2 * len(docstrings)  # the expression and its constant
        self.long_lines += sum(len(line) > COLUMNS for line in lines)
        self.nested += sum(has_comprehension_inside(node) for node in nodes)
        self.unformatted += sum("fmt: skip" in line for line in lines)


def has_comprehension_inside(node: ast.AST) -> bool:
    if not isinstance(node, COMPREHENSIONS):
        return False
    return any(isinstance(inner, COMPREHENSIONS) for inner in ast.walk(node) if inner is not node)


def densities() -> dict[str, Density]:
    """Return the counts of each room; the files of the package's own folder are the room ""."""
    rooms = defaultdict(Density)
    for path in sorted((ROOT / "fivebar").rglob("*.py")):
        parts = path.relative_to(ROOT / "fivebar").parts
        if "_labs" not in parts:
            rooms[parts[0] if len(parts) > 1 else ""].add(path)
    return dict(rooms)


if __name__ == "__main__":
    table = densities()
    print(f"{'room':16}{'files':>6}{'lines':>8}{'nodes':>8}{'a line':>8}{'long':>6}{'nested':>8}")
    for name, count in sorted(table.items(), key=lambda item: -item[1].nodes):
        print(
            f"{name:16}{count.files:6}{count.lines:8}{count.nodes:8}{count.nodes_a_line:8.2f}"
            f"{count.long_lines:6}{count.nested:8}"
        )
    print(f"{'sum':16}{'':14}{sum(count.nodes for count in table.values()):8}")
