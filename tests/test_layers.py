"""Data flows one way: a room imports only from rooms below it, in functions too, and nothing heavy at import."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import fivebar

PACKAGE = Path(fivebar.__file__).parent
FLOORS = [
    {"_backend", "errors", "progress", "tables"},
    {"models"},
    {"singularities", "linkages", "control"},
    {"pictures"},
    {"planning"},
    {"simulation"},
    {"study", "amoro", "grading"},
    {"cli"},
]
HEIGHT = {room: height for height, floor in enumerate(FLOORS) for room in floor}
# A study and a map show themselves: where that is asked for, and only then, they look up.
UPWARD = {
    ("linkages.study", "pictures.pages"),
    ("linkages.study", "pictures.plot.linkages"),
    ("linkages.study", "pictures.view"),
    ("singularities.maps", "pictures.pages"),
}
DOORS = {"__init__", "__main__", "plot", "view", "pages"}  # give names on, hold nothing


def imports(path):
    """Modules of the package that a file imports anywhere, as paths from the package: ("models", "dyads")."""
    here = path.relative_to(PACKAGE).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = here[: len(here) - node.level + 1]
            inner = tuple(node.module.split(".")) if node.module else ()
            for alias in node.names:
                yield base + inner + (() if inner else (alias.name,))


def test_no_room_imports_from_above():
    upward = set()
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if room in DOORS:
            continue
        for target in imports(path):
            if HEIGHT[target[0]] > HEIGHT[room]:
                upward.add((".".join(path.relative_to(PACKAGE).with_suffix("").parts), ".".join(target)))
    assert upward == UPWARD


def test_every_public_name_is_found():
    names = [
        name for name in dir(fivebar) if not name.startswith("_") and not isinstance(getattr(fivebar, name), type(ast))
    ]
    assert {"dgm", "simulate", "aspects", "compile", "singularity", "locus_distance"} <= set(names)
    assert not {path.stem for path in PACKAGE.iterdir()} & set(names)  # as a package's attribute it would hide the name
    with pytest.raises(AttributeError, match="no attribute 'dance'"):
        fivebar.dance  # noqa: B018


@pytest.mark.parametrize("asked", ["pass", "fivebar.cli.main(['--help'])"])
def test_import_and_help_load_numpy_and_nothing_heavier(asked):
    heavy = "scipy casadi matplotlib meshcat bokeh tqdm pytest"
    code = f"""import fivebar, fivebar.cli, sys
try: {asked}
finally: print([m for m in '{heavy}'.split() if m in sys.modules])"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
