"""The machine that measures: what a reader of the times must know, and what a method may miss."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Callable
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path

from ...models.machine_code import c_compiler

LIBRARIES = (
    "fivebar numpy scipy casadi matplotlib heyoka mujoco pin drake exudyn pylinkage numba jax torch"
    " mujoco-warp newton".split()
)


def lacks_c_compiler() -> str | None:
    """Return what is missing to compile C, or None."""
    return None if c_compiler() else "no C compiler (cc, gcc, clang)"


def lacks_module(module: str, package: str = "") -> Callable[[], str | None]:
    """Return a function that names the package to install where the module is missing."""

    def lacks():
        if find_spec(module):
            return None
        return f"{module} is not installed: pip install {package or module}"

    return lacks


def describe() -> dict:
    """Return processor, cores, system, compiler and versions of libraries."""
    versions = {found.name: found.version for found in distributions()}
    return {
        "cpu": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "compiler": _compiler(),
        **{name: versions.get(name, "not installed") for name in LIBRARIES},
    }


def _processor():
    info = Path("/proc/cpuinfo")  # Linux; platform.processor() is empty there
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.partition(": ")[2] for line in lines if line.startswith("model name")]
    return (names or [platform.processor() or platform.machine()])[0]


def _compiler():
    compiler = c_compiler()
    if compiler is None:
        return "none"
    result = subprocess.run([compiler, "--version"], capture_output=True, text=True)
    return result.stdout.partition("\n")[0] or compiler
