"""Data flows one way: a module imports only from layers below its own, and nothing heavy at import."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import fivebar

PACKAGE = Path(fivebar.__file__).parent
LAYERS = [
    {"_backend", "errors", "units"},
    {"dyads"},
    {"robots"},
    {"geometry"},
    {"kinematics"},
    {"singularity", "dynamics", "four_bar_motion"},
    {"locus", "charts", "trajectory", "path_check"},
    {"line_loci"},
    {"loci"},
    {"nearest_locus", "maps", "regions"},
    {"singularity_free"},
    {"inscribed", "control"},
    {"rectangles"},
    {"machine_code"},
    {"run", "engine", "steps"},
    {"plant"},
    {"simulation"},
    {"closed_loop", "collocation", "tracker_model", "tracker_qp"},
    {"transcription", "plans"},
    {"plan_arguments", "first_guess"},
    {"planner", "tracker"},
    {"comparison", "cases"},
    {"plot", "view", "amoro", "study", "linkages", "pages", "grading"},
    {"__init__"},
    {"robot_options"},
    {"track_cli", "map_cli", "linkage_cli", "chart_cli", "run_cli", "grade_cli"},
    {"cli"},
    {"__main__"},
]
HEIGHT = {name: height for height, layer in enumerate(LAYERS) for name in layer}


def imports(path):
    """(imported module of the package, whether at import time)."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inside = {id(n) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f)}
    depth = len(path.relative_to(PACKAGE).parts)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            names = [node.module.split(".")[0]] if node.module else [alias.name for alias in node.names]
            if node.level == depth:
                for name in names:
                    yield (name if name in HEIGHT else "__init__"), id(node) not in inside


def test_no_module_imports_from_above():
    for path in PACKAGE.rglob("*.py"):
        module = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        for name, at_import in imports(path):
            if module == "__init__" or not at_import:
                continue
            assert HEIGHT[name] <= HEIGHT[module], f"{path.name} imports {name}, which is above it"


def test_every_public_name_is_found_and_none_is_hidden_by_a_module():
    names = [
        name for name in dir(fivebar) if not name.startswith("_") and not isinstance(getattr(fivebar, name), type(ast))
    ]
    assert {"dgm", "simulate", "aspects", "compile", "singularity", "locus_distance"} <= set(names)
    modules = {path.stem for path in PACKAGE.glob("*.py")}
    assert {name for name in names if name in modules} == {"singularity"}  # loaded with the package, so never after it
    with pytest.raises(AttributeError, match="no attribute 'dance'"):
        fivebar.dance  # noqa: B018


def test_import_loads_numpy_and_nothing_heavier():
    heavy = "scipy casadi matplotlib meshcat bokeh tqdm pytest"
    code = f"import fivebar, sys; print([m for m in '{heavy}'.split() if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
