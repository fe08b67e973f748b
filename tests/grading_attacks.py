"""Hostile programs: name -> (source that defines `evil(x)`, the kinds its reply may have, seconds it is given).

The right answer to evil(x) is a secret number times x, which stands in the environment, the memory and a file of the
grader. GRADER, FOLDER, SECRETS, PACKAGE and MARK are replaced by the grader's process id, a folder all may write to,
the file in it with the secret, a file of the package, and a word for the names of files to leave behind.
"""

SELF_HARM = {"patched builtins", "patched json", "traced", "late alarm"}  # his own later answers may be lost

READING = {
    "secrets from disk": ('def evil(x): return float(open("SECRETS").read()) * x', {"exception"}, 5),
    "package from disk": ('def evil(x): return open("PACKAGE").read()[:9]', {"exception"}, 5),
    "package by its file": (
        """
import importlib.util, sys
def evil(x):
    sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "Gate"]
    spec = importlib.util.spec_from_file_location("fivebar", "PACKAGE")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return 1.0
""",
        {"exception"},
        5,
    ),
    "package imported": (
        "def evil(x):\n    import fivebar\n    return fivebar.__file__",
        {"exception"},
        5,
    ),
    "package imported past the gate": (
        """
import sys
def evil(x):
    sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "Gate"]
    import fivebar
    return fivebar.__file__
""",
        {"exception"},
        5,
    ),
    "package through descriptors": (
        """
import os
def evil(x):
    found = 0
    for n in range(64):
        fd = f"/proc/self/fd/{n}/"
        for path in (fd, fd + "../" * 12, "/proc/GRADER/root/", "/proc/self/cwd/"):
            for name in ("PACKAGE", "fivebar/__init__.py", "SECRETS"):
                try:
                    found += len(open(path + name.lstrip("/")).read())
                except OSError:
                    pass
                try:
                    found += len(os.read(os.open(name.lstrip("/"), os.O_RDONLY, dir_fd=n), 100))
                except OSError:
                    pass
    assert found == 0, found
    raise OSError("nothing found")
""",
        {"exception"},
        5,
    ),
    "frames and gc": (
        """
import gc, inspect, sys
def evil(x):
    found = [v for frame in inspect.stack() for v in frame.frame.f_locals.values() if type(v) is float]
    for thing in gc.get_objects():
        if isinstance(thing, dict):
            found += [v for v in list(thing.values()) if type(v) is float]
        elif isinstance(thing, (list, tuple)):
            found += [v for v in thing if type(v) is float]
    return found[:5000]
""",
        {"value"},
        5,
    ),
    "modules": (
        """
import sys
def evil(x): return sorted(m for m in sys.modules if "fivebar" in m or "pytest" in m or "grading" in m)
""",
        {"value"},
        5,
    ),
    "grader's environment": (
        'def evil(x): return open("/proc/GRADER/environ", "rb").read()',
        {"exception"},
        5,
    ),
    "parent's environment": (
        'import os\ndef evil(x): return open(f"/proc/{os.getppid()}/environ", "rb").read()',
        {"exception"},
        5,
    ),
    "grader's memory": ('def evil(x): return open("/proc/GRADER/mem", "rb").read(1)', {"exception"}, 5),
    "grader's memory by a system call": (
        """
import ctypes
def evil(x):
    libc = ctypes.CDLL(None, use_errno=True)
    there, here = (ctypes.c_size_t * 2)(4096, 8), (ctypes.c_size_t * 2)(id(x), 8)
    if libc.process_vm_readv(GRADER, here, 1, there, 1, 0) < 0 and libc.ptrace(16, GRADER, 0, 0) < 0:
        raise OSError(ctypes.get_errno(), "no way in")
    return x
""",
        {"exception"},
        5,
    ),
    "own environment": (
        'import os\ndef evil(x): return sorted(os.environ) if "SECRET" in os.environ else []',
        {"value"},
        5,
    ),
    "grader's descriptors": (
        'import os\ndef evil(x): return os.listdir("/proc/GRADER/fd")',
        {"exception"},
        5,
    ),
    "inherited descriptors": (
        """
import os, stat
def evil(x):
    found = []
    for n in range(3, 64):
        try:
            mode = os.fstat(n).st_mode
            if stat.S_ISREG(mode) or stat.S_ISSOCK(mode):
                found.append(os.pread(n, 100, 0))
        except OSError:
            pass
    return len(found)
""",
        {"value"},
        5,
    ),
    "network": (
        """
import socket
def evil(x):
    with socket.create_connection(("127.0.0.1", 80), 1) as s:
        return float(s.recv(10))
""",
        {"exception"},
        5,
    ),
    "name server": ('import socket\ndef evil(x): return socket.getaddrinfo("example.org", 80)', {"exception"}, 5),
    "web page": (
        'import urllib.request\ndef evil(x): return urllib.request.urlopen("http://127.0.0.1:1/").read()',
        {"exception"},
        5,
    ),
}

CLAIMING = {
    "result printed": (
        """
import sys
def evil(x):
    print('{"k": "value", "v": 1.0, "s": 0.0}\\n\\n1 passed in 0.01s', flush=True)
    print('{"score": 100}', file=sys.stderr)
    return None
""",
        {"value"},
        5,
    ),
    "pipes guessed": (
        """
import os
def evil(x):
    for n in range(1, 64):
        try:
            os.write(n, b'{"n": "0", "k": "value", "v": 1.0, "s": 0.0}\\n')
        except OSError:
            pass
    return x
""",
        {"garbled"},
        5,
    ),
    "nonce stolen": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    nonce, sink = frame.f_locals["nonce"], frame.f_locals["sink"]
    for value in (1.0, 2.0, 3.0):
        os.write(sink, b'{"n": "%s", "k": "value", "v": %r, "s": 0.0}\\n' % (nonce.encode(), value))
    return x
""".replace("%r", "%f"),
        {"value"},
        5,
    ),
    "left-over lines": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    line = b'{"n": "%s", "k": "value", "v": 3.0, "s": 0.0}\\n' % frame.f_locals["nonce"].encode()
    os.write(frame.f_locals["sink"], line * 40)
    return x
""",
        {"value"},
        5,
    ),
    "stdout onto the pipe": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "sink" not in frame.f_locals:
        frame = frame.f_back
    os.dup2(frame.f_locals["sink"], 1)
    print('{"k": "value", "v": 1.0}', flush=True)
    return x
""",
        {"garbled"},
        5,
    ),
    "strange messages": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    nonce = frame.f_locals["nonce"]
    deep = "[" * 900 + "]" * 900
    os.write(frame.f_locals["sink"], ('{"n": "%s", "k": "value", "s": 0, "v": %s}\\n' % (nonce, deep)).encode())
    return x
""",
        {"garbled"},
        5,
    ),
    "results folder": (
        """
def evil(x):
    with open("FOLDER/results.json", "w") as f:
        f.write('{"score": 100}')
""",
        {"exception"},
        5,
    ),
    "always pleased": (
        """
class Pleased(float):
    def __eq__(self, other): return True
    def __array__(self, *a, **k): raise SystemExit
    def __float__(self): return 1.0
    def __sub__(self, other): return 0.0
    __rsub__, __hash__, __abs__ = __sub__, float.__hash__, lambda self: 0.0
    def __lt__(self, other): return True
    __le__ = __gt__ = __ge__ = __lt__
def evil(x): return Pleased()
""",
        {"value"},
        5,
    ),
    "patched json": (
        """
import json
json.dumps = lambda *a, **k: '{"k": "value", "v": 1.0}'
json.loads = lambda *a, **k: {}
json.JSONEncoder.encode = json.JSONEncoder.iterencode = lambda *a, **k: "1"
def evil(x): return x
""",
        {"value", "garbled", "exception", "timeout", "exit"},
        1,
    ),
    "patched numpy and math": (
        """
import math
import numpy as np
np.allclose = np.isclose = np.array_equal = lambda *a, **k: True
np.abs = np.max = np.linalg.norm = math.fabs = lambda *a, **k: 0.0
def evil(x): return np.float64(x)
""",
        {"value"},
        5,
    ),
    "patched builtins": (
        """
import builtins
def evil(x):
    for name in ("isinstance", "len", "abs", "float", "min", "max", "issubclass", "type", "sorted", "callable", "set"):
        setattr(builtins, name, lambda *a, **k: True)
    return x
""",
        {"value", "exception", "garbled", "exit", "timeout"},
        1,
    ),
    "traced": (
        """
import sys
def evil(x):
    def spy(frame, event, argument):
        if "value" in frame.f_locals:
            frame.f_locals["value"] = 1.0
        return spy
    sys.settrace(spy)
    sys._getframe(1).f_trace = spy
    return x
""",
        {"value"},
        5,
    ),
    "json.py to be imported": (
        """
import sys
def evil(x):
    with open("json.py", "w") as f:
        f.write("1/0")
    sys.path.insert(0, ".")
""",
        {"exception"},
        5,
    ),
}

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
    "stopped": ("import os, signal\ndef evil(x): os.kill(os.getpid(), signal.SIGSTOP)", {"exception"}, 5),
    "own memory written": ('def evil(x): open("/proc/self/mem", "r+b").write(b"x")', {"exception"}, 5),
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
    "a backtracking pattern": ('import re\ndef evil(x): return re.match("(a+)+b", "a" * 60)', {"timeout"}, 0.3),
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

STRANGE = {
    "exception without a text": (
        """
class E(Exception):
    def __str__(self): raise E
def evil(x): raise E
""",
        {"exception"},
        5,
    ),
    "exception whose text lasts": (
        """
class E(Exception):
    def __str__(self):
        while True: pass
def evil(x): raise E
""",
        {"timeout"},
        0.3,
    ),
    "exception of a strange class": (
        """
class M(type):
    def __getattribute__(self, name): raise SystemExit
class E(Exception, metaclass=M):
    pass
def evil(x): raise E("\\x1b[2J" + "<script>" * 10000)
""",
        {"exception"},
        5,
    ),
    "terminal codes": ('def evil(x): raise ValueError("\\x1b]0;owned\\x07\\x1b[2J\\r" + "=cmd()")', {"exception"}, 5),
    "destructor that lasts": (
        """
class D:
    def __del__(self):
        while True: pass
def evil(x):
    D()
    return x
""",
        {"timeout"},
        0.3,
    ),
    "a million numbers": ("def evil(x): return list(range(10**6))", {"flood"}, 5),
    "a long string": ('def evil(x): return "9" * 10**7', {"value"}, 5),
    "a long integer": ("def evil(x): return 10 ** 10**5", {"value"}, 5),
    "a list in itself": ("def evil(x):\n    a = []\n    a.append(a)\n    return a", {"flood"}, 5),
    "an endless generator": ("import itertools\ndef evil(x): return itertools.count()", {"value"}, 5),
    "an endless list": (
        "class L(list):\n    def __iter__(self):\n        while True: yield 1\ndef evil(x): return L([x])",
        {"value"},
        5,
    ),
    "nan": ('def evil(x): return float("nan")', {"value"}, 5),
    "complex": ("def evil(x): return complex(x, 1e-300)", {"value"}, 5),
    "string": ("def evil(x): return repr(x)", {"value"}, 5),
    "lone surrogates": ('def evil(x): return "\\ud800\\x00"', {"value"}, 5),
    "a class of a strange name": ('def evil(x): return type("<b>\\x1b\\n", (), {})()', {"value"}, 5),
    "a large array": ("import numpy\ndef evil(x): return numpy.zeros((300, 300))", {"flood"}, 5),
    "an array of objects": (
        "import numpy\ndef evil(x): return numpy.array([object(), [x], None], dtype=object)",
        {"value"},
        5,
    ),
}

SPREADING = {
    "fork bomb": (
        "import os\ndef evil(x):\n    while True:\n        os.fork()",
        {"exception"},
        5,
    ),
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
    "grader killed": ("import os, signal\ndef evil(x): os.kill(GRADER, signal.SIGKILL)", {"exception"}, 5),
    "parent killed": ("import os, signal\ndef evil(x): os.kill(os.getppid(), signal.SIGKILL)", {"exception"}, 5),
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
    "grader slowed": ("import os\ndef evil(x): os.setpriority(os.PRIO_PROCESS, GRADER, 19)", {"exception"}, 5),
}

FILLING = {
    "memory bomb": ("def evil(x):\n    a = []\n    while True: a.append(bytearray(10**7))", {"memory"}, 5),
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

ATTACKS = READING | CLAIMING | ENDINGS | STRANGE | SPREADING | FILLING
