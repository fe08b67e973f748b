"""The machine that measures: what a reader of the times must know of it, and what a method may miss
on it.
"""

from __future__ import annotations

import os
import platform
import subprocess
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ...models.machine_code import c_compiler
from .rivals.arm import lacks_arm
from .rivals.native import cxx_compiler, lacks_headers

if TYPE_CHECKING:
    from collections.abc import Iterable

LIBRARIES = (
    "fivebar",
    "numpy",
    "scipy",
    "casadi",
    "matplotlib",
    "heyoka",
    "mujoco",
    "pin",
    "drake",
    "exudyn",
    "pylinkage",
    "numba",
)

PEERS = (
    "heyoka",
    "mujoco",
    "pinocchio",
    "pydrake",
    "exudyn",
    "pylinkage",
    "numba",
)  # modules of other simulators
PACKAGES = {"pinocchio": "pin", "pydrake": "drake"}  # where they are called otherwise


def _installed(module):
    return (
        None
        if find_spec(module)
        else f"{module} is not installed: pip install {PACKAGES.get(module, module)}"
    )


# What a method may need -> () -> None, or what is missing.
NEEDED = {
    "C compiler": lambda: None if c_compiler() else "no C compiler (cc, gcc, clang)",
    "C++ compiler": lambda: (
        None if cxx_compiler() else "no C++ compiler (c++, g++, clang++) on Linux"
    ),
    "Pinocchio's headers": lacks_headers,
    "ARM compilers": lacks_arm,
    **{name: partial(_installed, name) for name in PEERS},
}


def missing(needs: Iterable[str]) -> str | None:
    """The first of these needs that this machine does not meet, in words; None if there is none."""
    return next((word for word in (NEEDED[need]() for need in needs) if word), None)


def describe() -> dict:
    """What a reader of the times must know of this machine: processor, cores, compiler, libraries'
    versions.
    """
    return {
        "cpu": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "compiler": _compiler(),
        **{name: _version(name) for name in LIBRARIES},
    }


def _processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [
                line.split(":", 1)[1].strip() for line in file if line.startswith("model name")
            ]
        return names[0] if names else platform.machine()
    except OSError:
        return platform.processor() or platform.machine()


def _compiler():
    compiler = c_compiler()
    if compiler is None:
        return "none"
    notes = subprocess.run(
        [compiler, "--version"], capture_output=True, text=True
    ).stdout.splitlines()
    return notes[0] if notes else compiler


def _version(name):
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
