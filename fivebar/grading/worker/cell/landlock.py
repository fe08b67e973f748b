"""Landlock without any library: from now on this process reads the named files and folders, and no
others.
"""

from __future__ import annotations

import ctypes
import os
import struct

_CREATE, _ADD, _RESTRICT = 444, 445, 446  # system calls, the same on all machines
_READ_FILE, _READ_FOLDER = 1 << 2, 1 << 3
_BENEATH = 1
_NO_NEW_PRIVILEGES = 38  # prctl


def restrict(readable: list[str], listable: list[str]) -> bool:
    """Read only what is in or beneath `readable`, lists also `listable`; whether the kernel
    can.
    """
    library = ctypes.CDLL(None, use_errno=True)
    handled = struct.pack("=Q", _READ_FILE | _READ_FOLDER)
    rules = library.syscall(_CREATE, handled, ctypes.c_size_t(len(handled)), 0)
    if rules < 0:
        return False
    for paths, folder_access in ((readable, _READ_FILE | _READ_FOLDER), (listable, _READ_FOLDER)):
        for path in paths:
            descriptor = os.open(path, os.O_PATH)
            access = folder_access if os.path.isdir(path) else _READ_FILE
            rule = struct.pack("=Qi", access, descriptor)
            if library.syscall(_ADD, rules, _BENEATH, rule, 0) < 0:
                raise OSError(ctypes.get_errno(), "Landlock refuses a rule", path)
            os.close(descriptor)
    library.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    done = library.syscall(_RESTRICT, rules, 0) == 0
    os.close(rules)
    return done
