"""Starts the process of a worker, confined by itself or by bubblewrap."""

from __future__ import annotations

import json
import os
import secrets
import subprocess
from pathlib import Path

from .places import (
    CELL,
    bwrap_command,
    import_folders,
    interpreter,
    readable,
    unreachable,
    with_dependencies,
)

PACKAGES = ("numpy", "scipy")
USERS = 3_000  # unprivileged ids that nobody has, one per worker, so that none can reach another
_THREADS = "OPENBLAS OMP MKL VECLIB_MAXIMUM NUMEXPR".split()
ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "HOME": "/nonexistent",
    "MPLCONFIGDIR": "/tmp",
}
ENVIRONMENT |= {f"{name}_NUM_THREADS": "1" for name in _THREADS}


def launch(
    isolate: str, settings: dict, more: tuple[str, ...] = ()
) -> tuple[subprocess.Popen, int | None]:
    """Return (process, descriptor of the first process in bubblewrap's PID namespace or None).

    settings: read and write (descriptors to pass on), n (nonce), memory (bytes), cpu (s); more:
    packages that may be imported beside NumPy and SciPy.
    """
    packages = PACKAGES + (with_dependencies(more) if more else ())
    outside = isolate == "process"
    uid = _spare_user() if os.getuid() == 0 else None
    files, folders = readable(packages) if outside else (None, None)
    settings = settings | {
        "packages": packages,
        "paths": [str(place) for place in import_folders(packages)],
        "uid": uid,
        "moved": uid is not None and outside and unreachable(packages),
        "readable": files,
        "listable": folders,
        "parent": os.getpid() if outside else None,
    }
    cell = str(CELL) if outside else "/cell"
    # NumPy warns of each nan, which a function may return where no answer exists.
    warn = "-Wignore::RuntimeWarning"
    command = [str(interpreter()), "-I", "-S", "-B", "-u", warn, cell, json.dumps(settings)]
    passed = (settings["read"], settings["write"])
    if outside:
        return _popen(command, passed), None
    told, tell = os.pipe()
    with open(told) as information:
        try:
            command = [*bwrap_command(packages), "--info-fd", str(tell), *command]
            process = _popen(command, (*passed, tell))
        finally:
            os.close(tell)
        text = ""
        while "}" not in text and (line := information.readline()):
            text += line
    return process, os.pidfd_open(json.loads(text)["child-pid"]) if text else None


def _popen(command, passed):
    # It starts in a folder that is always there: one of its own would stay if the grader were
    # killed.
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        pass_fds=passed,
        start_new_session=True,
        cwd="/",
        env=ENVIRONMENT,
    )


def _spare_user():
    """Return a user id without an account, of those that this user namespace has."""
    mapped = Path("/proc/self/uid_map")
    many = not mapped.exists() or int(mapped.read_text().split()[2]) > 500_000
    return (400_000 if many else 61_200) + secrets.randbelow(USERS)
