"""Times and what they were measured on."""

import gc
import math
import os
import platform
import subprocess
import time
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

import numpy as np

from ...models.machine_code import c_compiler

LIBRARIES = (
    "fivebar",
    "numpy",
    "scipy",
    "casadi",
    "matplotlib",
    "mujoco",
    "pin",
    "drake",
    "exudyn",
    "pylinkage",
    "numba",
)
SAMPLE = 1e-4  # s; shorter calls are timed together
MOST = 101  # samples
LONG = 5.0  # budgets; a call as long is not timed again


def times_of(call, first, budget):
    """Seconds of a call, (n,) samples in about `budget` s, without the garbage collector.

    first: s that it took before, which warmed it up; all there is where that is LONG budgets or more.
    """
    if first > LONG * budget:
        return np.array([first])
    before = time.perf_counter()
    call()
    once = time.perf_counter() - before
    together = max(1, math.ceil(SAMPLE / max(once, 1e-9)))
    count = int(np.clip(budget / (together * once), 3, MOST))
    samples, collecting = np.empty(count), gc.isenabled()
    gc.disable()
    try:
        for k in range(count):
            before = time.perf_counter()
            for _ in range(together):
                call()
            samples[k] = (time.perf_counter() - before) / together
    finally:
        if collecting:
            gc.enable()
    return samples


PEERS = "mujoco", "pinocchio", "pydrake", "exudyn", "pylinkage", "numba"  # modules of other simulators


def _installed(module):
    return None if find_spec(module) else f"{module} is not installed: pip install 'fivebar[peers]'"


# What a method may need -> () -> None, or what is missing.
NEEDED = {
    "C compiler": lambda: None if c_compiler() else "no C compiler (cc, gcc, clang)",
    **{name: partial(_installed, name) for name in PEERS},
}


def missing(needs):
    """The first of these needs that this machine does not meet, in words; None if there is none."""
    return next((word for word in (NEEDED[need]() for need in needs) if word), None)


def describe():
    """What a reader of the times must know of this machine: processor, cores, compiler, libraries' versions."""
    return {
        "cpu": _processor(), "cores": os.cpu_count(), "system": platform.platform(),
        "python": platform.python_version(),
        "compiler": _compiler(), **{name: _version(name) for name in LIBRARIES},
    }  # fmt: skip


def _processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
        return names[0] if names else platform.machine()
    except OSError:
        return platform.processor() or platform.machine()


def _compiler():
    compiler = c_compiler()
    if compiler is None:
        return "none"
    said = subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout.splitlines()
    return said[0] if said else compiler


def _version(name):
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
