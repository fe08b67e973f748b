"""Programs that end, hang or crash, or want their rights back."""

ENDINGS = {
    "os._exit": ("import os\ndef evil(x): os._exit(0)", {"exit"}, 5),
    "sys.exit": ("import sys\ndef evil(x): sys.exit(0)", {"exit"}, 5),
    "KeyboardInterrupt": ("def evil(x): raise KeyboardInterrupt", {"exception"}, 5),
    "own exception group": (
        "class E(BaseException):\n    pass\ndef evil(x): raise BaseExceptionGroup('g', [E(), GeneratorExit()])",
        {"exception"},
        5,
    ),
    "infinite loop": ("def evil(x):\n    while True: pass", {"timeout"}, 0.3),
    "sleep": ("import time\ndef evil(x): time.sleep(1e6)", {"timeout"}, 0.3),
    "loop in C": ("def evil(x): return sum(iter(int, 1))", {"timeout"}, 0.3),
    "stopped": (
        "import os, signal\ndef evil(x): os.kill(os.getpid(), signal.SIGSTOP)",
        {"exception"},
        5,
    ),
    "own memory written": (
        'def evil(x): open("/proc/self/mem", "r+b").write(b"x")',
        {"exception"},
        5,
    ),
    "typed into the terminal": (
        """
import fcntl, os
def evil(x):
    for n in (0, 1, 2):
        try:
            fcntl.ioctl(n, 0x5412, b"r")
        except OSError:
            pass
    return fcntl.ioctl(os.open("/dev/tty", os.O_RDONLY), 0x5412, b"r")
""",
        {"exception"},
        5,
    ),
    "a backtracking pattern": (
        'import re\ndef evil(x): return re.match("(a+)+b", "a" * 60)',
        {"timeout"},
        0.3,
    ),
    "all exceptions caught": (
        "def evil(x):\n    while True:\n        try:\n            while True: pass\n        except BaseException: pass",
        {"timeout"},
        0.3,
    ),
    "signals ignored": (
        """
import signal
def evil(x):
    for number in range(1, 65):
        try:
            signal.signal(number, signal.SIG_IGN)
        except (OSError, ValueError):
            pass
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))
    while True: pass
""",
        {"timeout"},
        0.3,
    ),
    "infinite recursion": ("def evil(x): return evil(x) + 1", {"exception"}, 5),
    "recursion without limit": (
        """
import sys
sys.setrecursionlimit(10**9)
class A:
    def __repr__(self): return repr(self)
def evil(x): return repr(A()) + str(evil(x))
""",
        {"killed", "memory", "timeout", "exception"},
        5,
    ),
    "null pointer": ("import ctypes\ndef evil(x): return ctypes.string_at(0)", {"killed"}, 5),
    "abort": ("import os\ndef evil(x): os.abort()", {"killed"}, 5),
    "exit handler": (
        "import atexit, time, os\ndef evil(x):\n    atexit.register(time.sleep, 1e6)\n    raise SystemExit(0)",
        {"exit"},
        5,
    ),
    "closed pipes": (
        "import os\ndef evil(x):\n    os.closerange(0, 64)\n    return x",
        {"exit", "garbled", "killed"},
        5,
    ),
    "late alarm": (
        """
import signal, os
def wake(*_):
    for n in range(3, 64):
        try:
            os.write(n, b'{"k": "value", "v": 3.0}\\n')
        except OSError:
            pass
def evil(x):
    signal.signal(signal.SIGALRM, wake)
    signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
    return x
""",
        {"value", "garbled"},
        5,
    ),
    "limits raised": (
        """
import resource
def evil(x):
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    return x
""",
        {"exception"},
        5,
    ),
    "root again": ("import os\ndef evil(x):\n    os.setuid(0)\n    return x", {"exception"}, 5),
    "spaces of its own": (
        """
import ctypes
def evil(x):
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(0x10000000 | 0x20000) < 0:
        raise OSError(ctypes.get_errno(), "unshare")
    return x
""",
        {"exception"},
        5,
    ),
}
