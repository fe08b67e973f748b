"""Takes from this process what a student's functions never need, for good; standard library
only.
"""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys

from filter import install
from landlock import restrict

_DEATH_SIGNAL = 1  # prctl


def confine(settings: dict) -> dict:
    """Set limits, an unprivileged user, no new processes, no files written, few read: {"filter",
    "landlock", "uid"}.

    settings: memory (bytes), cpu (s), paths (folders to import from), uid (to become, None to
    stay), readable and listable (files and folders), parent (pid to die with); the last three None
    if that is bubblewrap's work. Says which of the kernel's means were there. Raises OSError where
    the user cannot be left.
    """
    linux = sys.platform == "linux"
    sys.path[:] = [
        *(path for path in sys.path if path != os.path.dirname(__file__)),
        *settings["paths"],
    ]
    if linux:
        _limit(resource.RLIMIT_AS, settings["memory"], settings["memory"])
    for name, most in (
        ("CPU", settings["cpu"]),
        ("FSIZE", 1 << 20),
        ("CORE", 0),
        ("NOFILE", 64),
        ("NPROC", 0),
    ):
        _limit(getattr(resource, f"RLIMIT_{name}"), most, most + 1 if name == "CPU" else most)
    landlock = (
        linux
        and settings["readable"] is not None
        and restrict(settings["readable"], settings["listable"])
    )
    if settings["uid"] is not None:
        _become(settings["uid"], settings["moved"])
    if linux and settings["parent"] is not None:
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGKILL)
        if os.getppid() != settings["parent"]:
            os._exit(0)
    return {"filter": linux and install(), "landlock": landlock, "uid": os.getuid()}


def _limit(which, soft, hard):
    highest = resource.getrlimit(which)[1]
    if highest != resource.RLIM_INFINITY:
        soft, hard = min(soft, highest), min(hard, highest)
    resource.setrlimit(which, (soft, hard))


def _become(uid, moved):
    """Become another user, for ever. moved: folders that he may not reach stay open and are
    imported from by descriptor.
    """
    if moved:
        by_descriptor = {path: _descriptor(path) for path in sys.path if os.path.isdir(path)}
        sys.path[:] = [by_descriptor.get(path, path) for path in sys.path]
        for module in list(sys.modules.values()):
            if hasattr(module, "__path__"):
                module.__path__[:] = [_moved(path, by_descriptor) for path in module.__path__]
        sys.path_importer_cache.clear()
    try:
        os.setgroups([])
        os.setresgid(uid, uid, uid)
        os.setresuid(uid, uid, uid)
    except OSError as error:
        raise OSError(
            f"root cannot become the user {uid} ({error.strerror}): grade as a normal user"
        ) from None


def _descriptor(path):
    return f"/proc/self/fd/{os.open(path, os.O_PATH | os.O_DIRECTORY)}"


def _moved(path, by_descriptor):
    folder, name = os.path.split(path)
    return os.path.join(by_descriptor.get(folder, folder), name)
