"""Programs that start others, or disturb them."""

SPREADING = {
    "fork bomb": ("import os\ndef evil(x):\n    while True:\n        os.fork()", {"exception"}, 5),
    "fork bomb that insists": (
        """
import os
def evil(x):
    while True:
        try:
            os.fork()
        except OSError:
            pass
""",
        {"timeout"},
        0.3,
    ),
    "daemon": (
        """
import os, time
def evil(x):
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(1e6)
    return x
""",
        {"exception"},
        5,
    ),
    "other program": (
        'import subprocess\ndef evil(x): return subprocess.run(["/bin/sh", "-c", "id"])',
        {"exception"},
        5,
    ),
    "this program replaced": (
        'import os, sys\ndef evil(x): os.execv(sys.executable, ["python", "-c", "while True: pass"])',
        {"exception"},
        5,
    ),
    "multiprocessing": (
        "import multiprocessing\ndef evil(x):\n    with multiprocessing.Pool(2) as p: return p.map(abs, [x])",
        {"exception"},
        5,
    ),
    "thread left behind": (
        """
import threading, time
def evil(x):
    threading.Thread(target=time.sleep, args=(1e6,)).start()
    return x
""",
        {"exception"},
        5,
    ),
    "raw system calls": (
        """
import ctypes
def evil(x):
    call = ctypes.CDLL(None, use_errno=True).syscall
    path = ctypes.c_char_p(b"FOLDER/MARK")
    how = (ctypes.c_uint64 * 3)(0o101, 0o644, 0)
    # fork, vfork, clone3, openat2, io_uring_setup, memfd_create, and a call of the 32-bit kind
    numbers = ((57,), (435, 0, 88), (437, -100, path, how, 24), (425, 8, how), (319, path, 0), (0x40000039,))
    if all(call(*n) == -1 for n in numbers):
        raise OSError(ctypes.get_errno(), "all refused")
    return x
""",
        {"exception"},
        5,
    ),
    "grader killed": (
        "import os, signal\ndef evil(x): os.kill(GRADER, signal.SIGKILL)",
        {"exception"},
        5,
    ),
    "parent killed": (
        "import os, signal\ndef evil(x): os.kill(os.getppid(), signal.SIGKILL)",
        {"exception"},
        5,
    ),
    "all killed": ("import os, signal\ndef evil(x): os.kill(-1, signal.SIGKILL)", {"exception"}, 5),
    "own group killed": ("import os\ndef evil(x): os.killpg(0, 9)", {"exception"}, 5),
    "grader killed by a descriptor": (
        """
import fcntl, os
def evil(x):
    r, w = os.pipe()
    fcntl.fcntl(r, fcntl.F_SETOWN, GRADER)
    fcntl.fcntl(r, 10, 9)
    fcntl.fcntl(r, fcntl.F_SETFL, os.O_ASYNC)
    os.write(w, b"x")
    return x
""",
        {"exception"},
        5,
    ),
    "grader's limits": (
        "import resource\ndef evil(x): return resource.prlimit(GRADER, resource.RLIMIT_CPU, (1, 1))",
        {"exception"},
        5,
    ),
    "grader slowed": (
        "import os\ndef evil(x): os.setpriority(os.PRIO_PROCESS, GRADER, 19)",
        {"exception"},
        5,
    ),
}
