"""Type hints: what is public has them, and mypy finds the uses right that are right, and those wrong that are wrong."""

import ast
import inspect
import subprocess
import sys
from functools import cached_property

import pytest

import fivebar as fb
from tests.helpers.needs import need

from .helpers import ROOT


def public_functions():
    """(name, function) of all that `fb.` gives: functions, and its classes' public methods and how they are made."""
    for name in dir(fb):
        given = getattr(fb, name)
        if name.startswith("_") or not getattr(given, "__module__", "").startswith("fivebar"):
            continue
        if inspect.isfunction(given):
            yield name, given
        elif inspect.isclass(given):
            for key, value in vars(given).items():
                value = getattr(value, "__func__", None) or getattr(value, "fget", None) or value
                value = value.func if isinstance(value, cached_property) else value
                made = key in ("__init__", "__call__") and "__dataclass_fields__" not in vars(given)
                if inspect.isfunction(value) and (
                    made or key == "__call__" or not key.startswith("_")
                ):
                    yield f"{name}.{key}", value


def test_every_public_function_has_hints():
    functions = dict(public_functions())
    assert {
        "dgm",
        "simulate",
        "Run.from_csv",
        "Run.q_error",
        "Tracker.__init__",
        "Trajectory.__call__",
    } <= set(functions)
    missing = set()
    for name, function in functions.items():
        signature = inspect.signature(function)
        hints = [
            p.annotation
            for p in signature.parameters.values()
            if p.name not in ("self", "cls", "_")
        ]
        hints += [] if name.endswith("__init__") else [signature.return_annotation]
        if inspect.Parameter.empty in hints:
            missing.add(name)
    assert missing == set()


def test_a_type_checker_sees_every_public_name_where_it_is():
    tree = ast.parse((ROOT / "fivebar" / "__init__.py").read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    told = {alias.name: node.module for node in block.body for alias in node.names}
    parts = {name: told.pop(name) for name in fb._PARTS}
    assert told == fb._MODULES and set(parts.values()) <= {None, "visualization"}


@pytest.mark.deep
def test_mypy_finds_no_fault():
    """Configured in pyproject.toml; files without it there are named."""
    need("mypy")
    run = subprocess.run([sys.executable, "-m", "mypy"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
