"""Programs that fill or empty memory, disk and pipes."""

FILLING = {
    "memory bomb": (
        "def evil(x):\n    a = []\n    while True: a.append(bytearray(10**7))",
        {"memory"},
        5,
    ),
    "memory at once": ("def evil(x): return [0] * 10**11", {"memory"}, 5),
    "memory kept": (
        "kept = []\ndef evil(x):\n    while True: kept.append([0] * 1000)",
        {"memory", "exit", "killed", "timeout"},
        5,
    ),
    "disk filler": (
        """
def evil(x):
    with open("MARK", "wb") as f:
        while True: f.write(bytes(10**6))
""",
        {"exception"},
        5,
    ),
    "disk filled elsewhere": (
        """
import os
def evil(x):
    for folder in ("/tmp", "/var/tmp", "/dev/shm", "FOLDER", "."):
        for make in (os.mkdir, os.mkfifo, lambda p: open(p, "w"), lambda p: os.symlink("/etc", p)):
            try:
                make(folder + "/MARK")
                return x
            except OSError:
                pass
    raise OSError("nowhere")
""",
        {"exception"},
        5,
    ),
    "files removed": (
        """
import os, shutil
def evil(x):
    for act in (os.unlink, os.truncate, os.rename, os.chmod):
        try:
            act("SECRETS", *{os.truncate: (0,), os.rename: ("FOLDER/MARK",), os.chmod: (0,)}.get(act, ()))
            return x
        except OSError:
            pass
    shutil.rmtree("FOLDER")
""",
        {"exception"},
        5,
    ),
    "shared memory": (
        """
import ctypes
from multiprocessing import shared_memory
def evil(x):
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.shmget(77, 4096, 0o1666) >= 0 or libc.msgget(77, 0o1666) >= 0 or libc.semget(77, 1, 0o1666) >= 0:
        return x
    return shared_memory.SharedMemory("MARK", create=True, size=4096)
""",
        {"exception"},
        5,
    ),
    "output flood": ('def evil(x):\n    while True: print("x" * 10000)', {"timeout"}, 0.3),
    "flood of errors": (
        'import os\ndef evil(x):\n    while True: os.write(2, b"\\xff\\x1b" * 5000)',
        {"timeout"},
        0.3,
    ),
    "flood of the pipe": (
        """
import os
def evil(x):
    while True:
        for n in range(3, 64):
            try:
                os.write(n, b"x" * 4096)
            except OSError:
                pass
""",
        {"flood", "timeout"},
        5,
    ),
}
