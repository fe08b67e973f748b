"""The house's rules, late imports included; what only a type checker reads is not.

1. A room is a folder of the package; it imports only from rooms on floors below its own.
2. What starts with an underscore is not used outside its room.
3. No file imports itself by way of others.
4. `import fivebar` loads NumPy and nothing heavier.
"""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

import fivebar

FLOORS = [
    {"base", "guide"},
    {"models"},
    {"singularities", "linkages"},
    {"constraints"},
    {"control"},
    {"planning"},
    {"simulation"},
    {"paths"},
    {"exporters", "estimation"},
    {"optimal_design"},
    {"visualization"},
    {"study", "amoro", "grading"},
    {"cli"},
]
HEIGHT = {room: height for height, floor in enumerate(FLOORS) for room in floor}
DOORS = {"", "__main__"}  # give names on, hold nothing

PACKAGE = Path(fivebar.__file__).parent


def dotted(path):
    """A file's name in the package: "models.dyads", "models" for its __init__, "" for the package's own."""
    return (
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        .removesuffix("__init__")
        .removesuffix(".")
    )


READ = (
    ast.Import,
    ast.ImportFrom,
    ast.Name,
    ast.Attribute,
    ast.FunctionDef,
    ast.AsyncFunctionDef,
    ast.ClassDef,
)


@cache
def nodes(file):
    """Those of a file's syntax that are READ, but what only a type checker reads."""
    found, waiting = [], [ast.parse(FILES[file].read_text(encoding="utf-8"))]
    while waiting:
        node = waiting.pop()
        test = getattr(node, "test", None)  # of an if: TYPE_CHECKING or typing.TYPE_CHECKING
        if "TYPE_CHECKING" in (getattr(test, "id", ""), getattr(test, "attr", "")):
            node.body = []
        if isinstance(node, READ):
            found.append(node)
        waiting.extend(ast.iter_child_nodes(node))
    return found


FILES = {dotted(path): path for path in PACKAGE.rglob("*.py")}
FOLDERS = {dotted(path) for path in PACKAGE.rglob("__init__.py")}


def room(file):
    return file.split(".")[0]


@cache
def imports(file):
    """(file, name) of what a file imports from others of the package."""
    return list(_imports(file))


def _imports(file):
    here = file.split(".") if file else []
    for node in nodes(file):
        assert not isinstance(node, ast.Import) or all(
            room(alias.name) != "fivebar" for alias in node.names
        ), file
        if isinstance(node, ast.ImportFrom) and node.level:
            up = node.level - (file in FOLDERS)
            base = [*here[: len(here) - up], *(node.module or "").split(".")]
            for alias in node.names:
                whole = ".".join(filter(None, [*base, alias.name]))
                yield (whole if whole in FILES else whole.rpartition(".")[0]), alias.name


def defined(file):
    """Names that a file gives to a function, a class, a variable or an attribute."""
    for node in nodes(file):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.id if isinstance(node, ast.Name) else node.attr


def test_no_room_imports_from_a_floor_that_is_not_below():
    sideways = {
        (file, target)
        for file in FILES
        for target, _ in imports(file)
        if room(file) not in DOORS
        and room(file) != room(target)
        and HEIGHT[room(target)] >= HEIGHT[room(file)]
    }
    assert sideways == set()


def test_no_room_uses_what_is_private_to_another():
    """By import, and by the attributes that only other rooms define."""
    owners = {}
    for file in FILES:
        for name in defined(file):
            owners.setdefault(name, set()).add(room(file))
    foreign = []
    for file in FILES:
        used = [
            name
            for target, name in imports(file)
            if room(target) != room(file) and name not in FILES
        ]
        attributes = {node.attr for node in nodes(file) if isinstance(node, ast.Attribute)} & set(
            owners
        )
        used += [name for name in attributes if room(file) not in owners[name]]
        foreign += [
            f"{file}: {name}" for name in used if name.startswith("_") and not name.endswith("__")
        ]
    assert foreign == []


def test_no_file_imports_itself_by_way_of_others():
    names = sorted(FILES)
    arrows = {file: {target for target, _ in imports(file)} for file in names}
    matrix = np.array([[target in arrows[file] for target in names] for file in names])
    count, circle = connected_components(matrix, connection="strong")
    circles = [[name for name, k in zip(names, circle) if k == number] for number in range(count)]
    assert [names for names in circles if len(names) > 1] == []


def test_every_public_name_is_found():
    names = [
        name
        for name in dir(fivebar)
        if not name.startswith("_") and not isinstance(getattr(fivebar, name), type(ast))
    ]
    assert {"dgm", "simulate", "aspects", "compile", "singularity", "locus_distance"} <= set(names)
    assert not {path.stem for path in PACKAGE.iterdir()} & set(
        names
    )  # as a package's attribute it would hide the name
    with pytest.raises(AttributeError, match="no attribute 'dance'"):
        fivebar.dance  # noqa: B018


def test_the_program_begins_before_anything_slow_is_imported():
    """So that it answers Ctrl-C from its first moments on."""
    code = "import fivebar.cli, sys; print([name for name in sys.modules if name in ('numpy', 'fivebar.models')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_import_and_all_help_load_numpy_and_nothing_heavier():
    code = """import fivebar, fivebar.cli, sys
for words in ([], *([command] for command in fivebar.cli.COMMANDS)):
    try: fivebar.cli.main([*words, "--help"])
    except SystemExit as stop: assert stop.code == 0
    heavy = "scipy casadi matplotlib meshcat bokeh tqdm pytest html"
    print(words, [name for name in heavy.split() if name in sys.modules])"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = [line for line in done.stdout.splitlines() if re.match(r"\[.*\] \[.*\]$", line)]
    assert len(loaded) > 15 and all(line.endswith(" []") for line in loaded), loaded
